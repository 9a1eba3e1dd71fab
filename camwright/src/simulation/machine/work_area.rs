// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Guards: nothing moves with an open door, an open chuck or a person inside, and nothing opens while something moves.

use super::Machine;
use super::supervision::SetpointSource;
use crate::machine::alarm::AlarmKind;
use crate::machine::description::Axis;
use crate::machine::setpoint::Setpoint;
use crate::simulation::fault::LoadingFault;
use crate::simulation::work_area::{AccessRefusal, LoadingRefused, WorkAreaState};

impl Machine {
    /// State of door, chuck and sensors; `None`: the machine has none.
    #[must_use]
    pub fn work_area(&self) -> Option<WorkAreaState> {
        self.work_area.as_ref().map(|area| area.state(self.is_quiet()))
    }

    /// Door or chuck is on its way, or the wheel of a machine that is loaded runs down: ticks that a client waits for.
    #[must_use]
    pub fn is_being_loaded(&self) -> bool {
        let spindle = self.wheel.spindle();
        let runs_down = !spindle.is_ordered() && !spindle.is_still();
        self.work_area.as_ref().is_some_and(|area| area.is_moving() || runs_down)
    }

    /// Opens or closes the door.
    ///
    /// # Errors
    /// Something moves, or a person is inside; the door does not move.
    pub fn order_door(&mut self, open: bool) -> Result<(), LoadingRefused> {
        self.require_stillness()?;
        self.work_area.as_mut().map_or(Err(LoadingRefused::NothingThere), |area| area.order_door(open))
    }

    /// Opens or closes the chuck.
    ///
    /// # Errors
    /// Something moves, or the door is closed and a part would fall; the chuck stays as it is.
    pub fn order_chuck(&mut self, open: bool) -> Result<(), LoadingRefused> {
        self.require_stillness()?;
        self.work_area.as_mut().map_or(Err(LoadingRefused::NothingThere), |area| area.order_chuck(open))
    }

    /// Puts a part into the chuck, or takes it out: what a real part does to its sensor.
    ///
    /// # Errors
    /// Door or chuck is closed, there is a part already, or none.
    pub fn change_part(&mut self, put_in: bool) -> Result<(), LoadingRefused> {
        self.work_area.as_mut().map_or(Err(LoadingRefused::NothingThere), |area| area.change_part(put_in))?;
        self.clear_part();
        Ok(())
    }

    /// Checks that the chuck holds a part, which may be given the outline of a raw one. A machine without a sensor always agrees.
    ///
    /// # Errors
    /// There is no part, or the chuck does not hold it.
    pub fn holds_part(&self) -> Result<(), LoadingRefused> {
        self.work_area.as_ref().map_or(Ok(()), |area| area.holds_part())
    }

    /// Takes the loader's report of its position; `lost`: it reports nothing any more.
    pub fn see_loader(&mut self, inside: bool, lost: bool) {
        if self.work_area.as_mut().is_some_and(|area| area.see_loader(inside, lost)) {
            self.raise(AlarmKind::LoaderLost, 0.0, 0.0);
        }
    }

    fn require_stillness(&self) -> Result<(), LoadingRefused> {
        if !self.is_at_rest() || self.stream.moves() || self.is_mounting() {
            return Err(LoadingRefused::Moving);
        }
        if self.wheel.turns() {
            return Err(LoadingRefused::WheelTurns);
        }
        Ok(())
    }

    /// The axes stand still in their safe place, and the wheel has stopped.
    fn is_quiet(&self) -> bool {
        let safe_mm = self.description.loading.map_or(f64::INFINITY, |loading| loading.safe_x_mm);
        self.require_stillness().is_ok() && self.axes[Axis::X.index()].true_value() >= safe_mm
    }

    /// Hindrance that keeps axes and wheel from starting.
    pub(super) fn hindrance(&self) -> Option<AccessRefusal> {
        self.work_area.as_ref().and_then(|area| area.hindrance())
    }

    /// A motion that begins in spite of a hindrance is refused before anything has moved. One that is under way already ends on its
    /// path, beside which the wheel leaves the part.
    pub(super) fn hinders(&self, setpoint: &Setpoint) -> Option<AlarmKind> {
        let hindrance = self.hindrance().filter(|_| self.supervision.mode() == SetpointSource::Following)?;
        self.stream.moves_to(setpoint).then(|| hindrance.alarm())
    }

    /// Door, chuck and who is inside, while something moves.
    pub(super) fn watch_guards(&mut self) {
        let Some(area) = &mut self.work_area else { return };
        for late in area.step().into_iter().flatten() {
            self.raise(late, 0.0, 0.0);
        }
        let moves = !self.is_at_rest() || self.stream.moves() || self.is_mounting();
        if let Some(hindrance) = self.hindrance().filter(|_| moves || self.wheel.turns()) {
            self.raise(hindrance.alarm(), 0.0, 0.0);
            self.wheel.stop();
        }
    }

    pub(super) fn apply_loading_fault(&mut self, fault: LoadingFault) {
        let Some(area) = &mut self.work_area else { return };
        match fault {
            LoadingFault::DoorForced(true) => area.door.force_open(),
            LoadingFault::ChuckForced(true) => area.chuck.force_open(),
            // What was forced open is closed by who closes it.
            LoadingFault::DoorForced(false) | LoadingFault::ChuckForced(false) => {}
            LoadingFault::DoorStuck(stuck) => area.door.set_stuck(stuck),
            LoadingFault::ChuckStuck(stuck) => area.chuck.set_stuck(stuck),
            LoadingFault::PartSensor(level) => area.sensor_stuck = level,
            LoadingFault::Person(inside) => area.person_inside = inside,
        }
    }
}
