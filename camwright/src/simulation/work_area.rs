// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Door, chuck, part sensor and work area of a machine that is loaded: what each shows, and what it may do.
//!
//! A simulation of the machine's side of it, not a safety function.

use crate::machine::alarm::AlarmKind;
use crate::machine::loading::LoadingDescription;
use thiserror::Error;

/// Position of a door or a chuck.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum ActuatorPosition {
    /// At its end: nothing goes through, or the part is held.
    #[default]
    Closed = 0,
    Opening = 1,
    /// At its other end.
    Open = 2,
    /// On its way back.
    Closing = 3,
}

crate::snapshot_cases!(ActuatorPosition { 0 Closed, 1 Opening, 2 Open, 3 Closing });

/// A door or a chuck: it goes from one end to the other in so many ticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Leaf {
    place: ActuatorPosition,
    /// Ticks that it still goes, and for which it has been on its way.
    left: u32,
    under_way: u32,
    ticks_to_open: u32,
    ticks_to_close: u32,
    stuck: bool,
}

crate::snapshot!(Leaf { place, left, under_way, stuck } on { ticks_to_open, ticks_to_close });

impl Leaf {
    #[allow(clippy::cast_possible_truncation, reason = "clamped to u32 before the cast")]
    fn new((opens_s, closes_s): (f64, f64), cycle_time_s: f64, place: ActuatorPosition) -> Self {
        let ticks = |time_s: f64| libm::ceil(time_s / cycle_time_s).clamp(1.0, f64::from(u32::MAX)) as u32;
        let (ticks_to_open, ticks_to_close) = (ticks(opens_s), ticks(closes_s));
        Self { place, left: 0, under_way: 0, ticks_to_open, ticks_to_close, stuck: false }
    }

    fn order(&mut self, open: bool) {
        let (there, way, ticks) = match open {
            true => (ActuatorPosition::Open, ActuatorPosition::Opening, self.ticks_to_open),
            false => (ActuatorPosition::Closed, ActuatorPosition::Closing, self.ticks_to_close),
        };
        if self.place != there && self.place != way {
            (self.place, self.left, self.under_way) = (way, ticks, 0);
        }
    }

    /// At once without a command: forced.
    pub(super) fn force_open(&mut self) {
        (self.place, self.left, self.under_way) = (ActuatorPosition::Open, 0, 0);
    }

    pub(super) fn set_stuck(&mut self, stuck: bool) {
        self.stuck = stuck;
    }

    /// One tick; true when it has been on its way for twice as long as it takes.
    fn step(&mut self) -> bool {
        let (end, whole) = match self.place {
            ActuatorPosition::Opening => (ActuatorPosition::Open, self.ticks_to_open),
            ActuatorPosition::Closing => (ActuatorPosition::Closed, self.ticks_to_close),
            ActuatorPosition::Open | ActuatorPosition::Closed => return false,
        };
        self.under_way = self.under_way.saturating_add(1);
        if !self.stuck {
            self.left = self.left.saturating_sub(1);
        }
        if self.left == 0 {
            self.place = end;
            return false;
        }
        let is_late = self.under_way > whole.saturating_mul(2);
        if is_late {
            // Reported once; a reset restarts its time limit.
            self.under_way = 0;
        }
        is_late
    }

    fn is_moving(&self) -> bool {
        matches!(self.place, ActuatorPosition::Opening | ActuatorPosition::Closing)
    }
}

/// Why door, chuck or part were left as they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum LoadingRefused {
    /// The machine has no door and no chuck of its own.
    #[error("the machine has no door and no chuck (loading)")]
    NothingThere,
    #[error("the axes are not at rest")]
    Moving,
    /// The wheel has not stopped.
    #[error("the wheel still turns")]
    WheelTurns,
    /// A person would be hit or locked in.
    #[error("a person is in the work area")]
    Entered,
    /// The chuck is out of reach.
    #[error("the door is not open")]
    DoorNotOpen,
    #[error("the chuck is not open")]
    ChuckNotOpen,
    #[error("the chuck is not closed")]
    ChuckNotClosed,
    /// There is one already.
    #[error("there is a part in the chuck")]
    PartThere,
    #[error("there is no part in the chuck")]
    NoPart,
}

/// Conditions that prevent axes and wheel from starting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AccessRefusal {
    /// A person is in the work area.
    Entered,
    /// The door is not closed.
    Door,
    /// The chuck is not closed.
    Chuck,
}

impl AccessRefusal {
    /// The alarm of who starts, or goes on, in spite of it.
    #[must_use]
    pub const fn alarm(self) -> AlarmKind {
        match self {
            AccessRefusal::Entered => AlarmKind::WorkAreaEntered,
            AccessRefusal::Door => AlarmKind::DoorOpened,
            AccessRefusal::Chuck => AlarmKind::ChuckOpened,
        }
    }

    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            AccessRefusal::Entered => "a person is in the work area",
            AccessRefusal::Door => "the door is not closed",
            AccessRefusal::Chuck => "the chuck is not closed",
        }
    }
}

/// State of door, chuck and sensors after a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WorkAreaState {
    pub door: ActuatorPosition,
    /// The chuck; closed: it holds.
    pub chuck: ActuatorPosition,
    /// The sensor sees a part in the chuck.
    pub part_present: bool,
    /// A person is inside, or has not been reported as gone.
    pub entered: bool,
    /// The axes stand still in their safe place, the wheel has stopped, the door is open.
    pub is_safe: bool,
    /// Condition that prevents axes and wheel from starting.
    pub hindrance: Option<AccessRefusal>,
}

/// Door, chuck, sensors and who is inside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct WorkArea {
    pub(super) door: Leaf,
    pub(super) chuck: Leaf,
    /// There is a part in the chuck, whatever the sensor shows.
    has_part: bool,
    /// Fixed reading of a stuck sensor.
    pub(super) sensor_stuck: Option<bool>,
    pub(super) person_inside: bool,
    loader_inside: bool,
    loader_lost: bool,
}

crate::snapshot!(WorkArea {
    door, chuck, has_part, sensor_stuck, person_inside, loader_inside, loader_lost,
} on {});

impl WorkArea {
    /// After power-up: door closed, chuck open, work area empty.
    pub(super) fn new(description: &LoadingDescription, cycle_time_s: f64) -> Self {
        let LoadingDescription { door_opens_s, door_closes_s, chuck_opens_s, chuck_closes_s, .. } = *description;
        Self {
            door: Leaf::new((door_opens_s, door_closes_s), cycle_time_s, ActuatorPosition::Closed),
            chuck: Leaf::new((chuck_opens_s, chuck_closes_s), cycle_time_s, ActuatorPosition::Open),
            has_part: false,
            sensor_stuck: None,
            person_inside: false,
            loader_inside: false,
            loader_lost: false,
        }
    }

    /// One tick: the alarms of what does not come to its end.
    pub(super) fn step(&mut self) -> [Option<AlarmKind>; 2] {
        if self.entered() && self.door.place == ActuatorPosition::Closing {
            // Its edge opens it again.
            self.door.order(true);
        }
        [(&mut self.door, AlarmKind::DoorStuck), (&mut self.chuck, AlarmKind::ChuckStuck)]
            .map(|(leaf, alarm)| leaf.step().then_some(alarm))
    }

    pub(super) fn is_moving(&self) -> bool {
        self.door.is_moving() || self.chuck.is_moving()
    }

    pub(super) fn part_present(&self) -> bool {
        self.sensor_stuck.unwrap_or(self.has_part)
    }

    pub(super) fn entered(&self) -> bool {
        self.loader_inside || self.person_inside
    }

    pub(super) fn hindrance(&self) -> Option<AccessRefusal> {
        let wanted = [
            (self.entered(), AccessRefusal::Entered),
            (self.door.place != ActuatorPosition::Closed, AccessRefusal::Door),
            (self.chuck.place != ActuatorPosition::Closed, AccessRefusal::Chuck),
        ];
        wanted.into_iter().find_map(|(is_so, hindrance)| is_so.then_some(hindrance))
    }

    /// State of the work area; `quiet`: the axes stand still at their safe position and the wheel has stopped.
    pub(super) fn state(&self, quiet: bool) -> WorkAreaState {
        WorkAreaState {
            door: self.door.place,
            chuck: self.chuck.place,
            part_present: self.part_present(),
            entered: self.entered(),
            is_safe: quiet && self.door.place == ActuatorPosition::Open,
            hindrance: self.hindrance(),
        }
    }

    /// Opens or closes the door of a machine in which nothing moves.
    pub(super) fn order_door(&mut self, open: bool) -> Result<(), LoadingRefused> {
        if !open && self.entered() {
            return Err(LoadingRefused::Entered);
        }
        self.door.order(open);
        Ok(())
    }

    /// Opens or closes the chuck of a machine in which nothing moves. With the door closed a part would fall.
    pub(super) fn order_chuck(&mut self, open: bool) -> Result<(), LoadingRefused> {
        if open && self.door.place != ActuatorPosition::Open {
            return Err(LoadingRefused::DoorNotOpen);
        }
        self.chuck.order(open);
        Ok(())
    }

    /// Puts a part into the open chuck, or takes it out.
    pub(super) fn change_part(&mut self, put_in: bool) -> Result<(), LoadingRefused> {
        if self.door.place != ActuatorPosition::Open {
            return Err(LoadingRefused::DoorNotOpen);
        }
        if self.chuck.place != ActuatorPosition::Open {
            return Err(LoadingRefused::ChuckNotOpen);
        }
        if put_in == self.has_part {
            return Err(if put_in { LoadingRefused::PartThere } else { LoadingRefused::NoPart });
        }
        self.has_part = put_in;
        Ok(())
    }

    /// Checks that a part is held that may get the outline of a raw part.
    pub(super) fn holds_part(&self) -> Result<(), LoadingRefused> {
        match (self.part_present(), self.chuck.place) {
            (false, _) => Err(LoadingRefused::NoPart),
            (true, ActuatorPosition::Closed) => Ok(()),
            (true, _) => Err(LoadingRefused::ChuckNotClosed),
        }
    }

    /// Updates the state of the loader; `lost`: it has fallen silent. Returns true if it fell silent inside.
    pub(super) fn see_loader(&mut self, inside: bool, lost: bool) -> bool {
        let was_lost = core::mem::replace(&mut self.loader_lost, lost);
        // One that says nothing any more is where it was.
        self.loader_inside = if lost { self.loader_inside } else { inside };
        lost && !was_lost && self.loader_inside
    }
}
