// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The handshake between the cell and the robot that loads it, as the cell sees it: what it asks for, when the robot may enter, what it
//! makes of what the sensors show afterwards.
//!
//! ```text
//!  step    OPEN_DOOR ───────────► ENTER ──────► INSIDE ─────────────────────────► CLOSE_DOOR ─────► done
//!  cell    orders the door,       clear to      clear to enter; the chuck obeys    orders the door
//!          waits for axes, wheel  enter         the robot
//!  robot   outside                outside       inside, or outside and busy        outside
//!  ends    door open, axes in     it is inside  outside and not busy, and the      door closed
//!          their safe place                     sensors show what was asked for
//! ```
//! A robot that is not heard of, not available or reports a fault is waited for; a step that takes too long, or sensors that show
//! something else, end the handshake with a reason, and it can be begun again. Nothing here orders an axis.

use crate::simulation::work_area::ActuatorPosition;
use core::fmt;

/// Wanted content of the chuck.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HandshakeGoal {
    /// A raw part, in the place of a machined one if there is one.
    RawPart,
    Empty,
}

/// Request to the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum HandshakeRequest {
    #[default]
    None = 0,
    /// Put a raw part in.
    Load = 1,
    /// Take the part out.
    Unload = 2,
    /// Take the part out and put a raw one in.
    Exchange = 3,
}

impl HandshakeRequest {
    /// Request that brings a chuck from its content to the goal.
    #[must_use]
    pub const fn for_goal(goal: HandshakeGoal, part_present: bool, is_machined: bool) -> Self {
        match (goal, part_present) {
            (HandshakeGoal::RawPart, false) => HandshakeRequest::Load,
            (HandshakeGoal::RawPart, true) if is_machined => HandshakeRequest::Exchange,
            (HandshakeGoal::Empty, true) => HandshakeRequest::Unload,
            (HandshakeGoal::RawPart, true) | (HandshakeGoal::Empty, false) => HandshakeRequest::None,
        }
    }

    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            HandshakeRequest::None => "nothing",
            HandshakeRequest::Load => "load",
            HandshakeRequest::Unload => "unload",
            HandshakeRequest::Exchange => "exchange",
        }
    }
}

/// Longest times of the steps (s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timeouts {
    /// For the door, the axes and the wheel.
    pub machine_s: f64,
    /// From the leave to enter until the robot is inside.
    pub enter_s: f64,
    /// For its work, until it has left.
    pub inside_s: f64,
}

/// Reported state of a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LoaderState {
    /// It can take a request.
    pub available: bool,
    /// It is in the work area.
    pub inside: bool,
    /// It works on a request.
    pub busy: bool,
    /// It reports a fault.
    pub has_fault: bool,
}

/// Signals of machine and robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadingInputs {
    /// Now (s, of a clock that does not go back).
    pub now_s: f64,
    pub door: ActuatorPosition,
    pub chuck: ActuatorPosition,
    /// The sensor of the part.
    pub part_present: bool,
    /// The machine reports a person inside.
    pub entered: bool,
    /// The axes stand still in their safe place, the wheel has stopped, the door is open.
    pub is_safe: bool,
    /// The robot while its signals arrive.
    pub loader: Option<LoaderState>,
}

/// A step of the handshake.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HandshakeStep {
    /// The wheel runs down, the door opens.
    OpenDoor,
    /// The robot may enter.
    Enter,
    /// It is inside, or fetches the next part.
    Inside,
    /// It has left, the door closes.
    CloseDoor,
}

impl HandshakeStep {
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            HandshakeStep::OpenDoor => "open door",
            HandshakeStep::Enter => "enter",
            HandshakeStep::Inside => "inside",
            HandshakeStep::CloseDoor => "close door",
        }
    }
}

/// Reason for waiting for the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wait {
    /// Its signals are missing.
    Silent,
    /// It is not available.
    Unavailable,
    /// It reports a fault.
    Fault,
}

/// Why a handshake ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HandshakeFailure {
    /// A step took longer than it may (s).
    TooLong(HandshakeStep, f64),
    /// No part after it was loaded.
    PartMissing,
    /// The part is still there after it was unloaded.
    PartStillThere,
    /// The part was not changed.
    NotExchanged,
    /// The chuck does not hold the part that was loaded.
    ChuckNotClosed,
}

impl fmt::Display for HandshakeFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            HandshakeFailure::TooLong(HandshakeStep::OpenDoor, s) => {
                write!(
                    f,
                    "the machine was not ready to be loaded within {s} s: open the door, stop the wheel and move x_axis to its safe position; after an alarm in a cut close the door and jog it there"
                )
            }
            HandshakeFailure::TooLong(HandshakeStep::Enter, s) => write!(f, "the loader did not enter within {s} s"),
            HandshakeFailure::TooLong(HandshakeStep::Inside, s) => {
                write!(f, "the loader did not leave the work area within {s} s")
            }
            HandshakeFailure::TooLong(HandshakeStep::CloseDoor, s) => write!(f, "the door did not close within {s} s"),
            HandshakeFailure::PartMissing => f.write_str("the part is missing after it was loaded"),
            HandshakeFailure::PartStillThere => f.write_str("the part is still in the chuck after it was unloaded"),
            HandshakeFailure::NotExchanged => f.write_str("the machined part is still in the chuck after the exchange"),
            HandshakeFailure::ChuckNotClosed => f.write_str("the chuck does not hold the part that was loaded"),
        }
    }
}

/// Command of the handshake to the cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadingCommand {
    OpenDoor,
    CloseDoor,
}

/// Progress of the handshake.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HandshakeProgress {
    /// Going on; what is to be done for it.
    Going(Option<LoadingCommand>),
    /// Waiting for the robot, for as long as it takes.
    Waiting(Wait),
    /// The chuck holds what was wanted, the work area is free, the door is closed.
    Done,
    /// It came to nothing.
    Failed(HandshakeFailure),
    /// The robot is inside without leave.
    Uncleared,
}

/// One exchange of parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Handshake {
    request: HandshakeRequest,
    timeouts: Timeouts,
    step: HandshakeStep,
    since_s: f64,
    /// The chuck was seen empty since the robot entered.
    was_empty: bool,
    waits: bool,
}

impl Handshake {
    #[must_use]
    pub fn begin(request: HandshakeRequest, timeouts: Timeouts, now_s: f64) -> Self {
        Self { request, timeouts, step: HandshakeStep::OpenDoor, since_s: now_s, was_empty: false, waits: false }
    }

    /// Request to the robot.
    #[must_use]
    pub fn request(&self) -> HandshakeRequest {
        match self.step {
            HandshakeStep::CloseDoor => HandshakeRequest::None,
            HandshakeStep::OpenDoor | HandshakeStep::Enter | HandshakeStep::Inside => self.request,
        }
    }

    /// The step it is in.
    #[must_use]
    pub fn step(&self) -> HandshakeStep {
        self.step
    }

    /// Returns whether the robot may enter.
    #[must_use]
    pub fn clear_to_enter(&self) -> bool {
        matches!(self.step, HandshakeStep::Enter | HandshakeStep::Inside)
    }

    /// Remaining time of this step (s); `None`: unlimited.
    #[must_use]
    pub fn timeout_left_s(&self, now_s: f64) -> Option<f64> {
        (!self.waits).then_some((self.longest_s() - (now_s - self.since_s)).max(0.0))
    }

    fn longest_s(&self) -> f64 {
        match self.step {
            HandshakeStep::OpenDoor | HandshakeStep::CloseDoor => self.timeouts.machine_s,
            HandshakeStep::Enter => self.timeouts.enter_s,
            HandshakeStep::Inside => self.timeouts.inside_s,
        }
    }

    fn enter(&mut self, step: HandshakeStep, now_s: f64) -> HandshakeProgress {
        (self.step, self.since_s, self.waits) = (step, now_s, false);
        HandshakeProgress::Going(None)
    }

    /// Looks at what machine and robot show now.
    pub fn advance(&mut self, seen: &LoadingInputs) -> HandshakeProgress {
        let inside = seen.entered || seen.loader.is_some_and(|loader| loader.inside);
        if inside && !self.clear_to_enter() {
            return HandshakeProgress::Uncleared;
        }
        let progress = match self.step {
            HandshakeStep::OpenDoor => self.open_door(seen),
            // Both say so, so that both let it work the chuck.
            HandshakeStep::Enter if seen.entered && seen.loader.is_some_and(|loader| loader.inside) => {
                self.was_empty = !seen.part_present;
                self.enter(HandshakeStep::Inside, seen.now_s)
            }
            HandshakeStep::Enter => {
                Self::waiting(seen).map_or(HandshakeProgress::Going(None), HandshakeProgress::Waiting)
            }
            HandshakeStep::Inside => self.inside(seen, inside),
            HandshakeStep::CloseDoor => match seen.door {
                ActuatorPosition::Closed => HandshakeProgress::Done,
                ActuatorPosition::Closing => HandshakeProgress::Going(None),
                ActuatorPosition::Open | ActuatorPosition::Opening => {
                    HandshakeProgress::Going(Some(LoadingCommand::CloseDoor))
                }
            },
        };
        self.in_time(progress, seen.now_s)
    }

    fn in_time(&mut self, progress: HandshakeProgress, now_s: f64) -> HandshakeProgress {
        let waits = matches!(progress, HandshakeProgress::Waiting(_));
        if waits || self.waits {
            // Who has come back has its time from then on.
            self.since_s = now_s;
        }
        self.waits = waits;
        let longest_s = self.longest_s();
        match progress {
            HandshakeProgress::Going(_) if now_s - self.since_s > longest_s => {
                HandshakeProgress::Failed(HandshakeFailure::TooLong(self.step, longest_s))
            }
            other => other,
        }
    }

    fn open_door(&mut self, seen: &LoadingInputs) -> HandshakeProgress {
        match seen.door {
            ActuatorPosition::Open if seen.is_safe => self.enter(HandshakeStep::Enter, seen.now_s),
            ActuatorPosition::Open | ActuatorPosition::Opening => HandshakeProgress::Going(None),
            ActuatorPosition::Closed | ActuatorPosition::Closing => {
                HandshakeProgress::Going(Some(LoadingCommand::OpenDoor))
            }
        }
    }

    /// Why a robot outside cannot be counted on.
    fn waiting(seen: &LoadingInputs) -> Option<Wait> {
        match seen.loader {
            None => Some(Wait::Silent),
            Some(loader) if loader.has_fault => Some(Wait::Fault),
            Some(loader) if !loader.available && !loader.busy => Some(Wait::Unavailable),
            Some(_) => None,
        }
    }

    fn inside(&mut self, seen: &LoadingInputs, inside: bool) -> HandshakeProgress {
        self.was_empty |= !seen.part_present;
        if let Some(wait) = Self::waiting(seen).filter(|wait| *wait != Wait::Unavailable) {
            return HandshakeProgress::Waiting(wait);
        }
        if inside || seen.loader.is_some_and(|loader| loader.busy) {
            return HandshakeProgress::Going(None);
        }
        match self.fault_of_result(seen) {
            Some(failure) => HandshakeProgress::Failed(failure),
            None => self.enter(HandshakeStep::CloseDoor, seen.now_s),
        }
    }

    /// Fault of the chuck after the robot has left.
    fn fault_of_result(&self, seen: &LoadingInputs) -> Option<HandshakeFailure> {
        match (self.request, seen.part_present) {
            (HandshakeRequest::Load | HandshakeRequest::Exchange, false) => Some(HandshakeFailure::PartMissing),
            (HandshakeRequest::Unload, true) => Some(HandshakeFailure::PartStillThere),
            (HandshakeRequest::Exchange, true) if !self.was_empty => Some(HandshakeFailure::NotExchanged),
            (HandshakeRequest::Load | HandshakeRequest::Exchange, true) if seen.chuck != ActuatorPosition::Closed => {
                Some(HandshakeFailure::ChuckNotClosed)
            }
            _ => None,
        }
    }

    /// Why the chuck may not be worked now; `None`: it may.
    #[must_use]
    pub fn chuck_refused(handshake: Option<&Self>, seen: &LoadingInputs) -> Option<&'static str> {
        let inside = seen.loader.is_some_and(|loader| loader.inside) && seen.entered;
        match handshake {
            None => Some("loading is not requested"),
            Some(handshake) if handshake.step != HandshakeStep::Inside => Some("the loader is not cleared and inside"),
            Some(_) if !inside => Some("the loader is not in the work area"),
            Some(_) => None,
        }
    }
}

#[cfg(test)]
mod tests;
