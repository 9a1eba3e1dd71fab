// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Room 10. The interpolator: from a plan, tick by tick, to setpoints on encoder counts.
//!
//! [`Interpolator::step`] does not allocate, lock, log or fail; its result holds everything to report. All
//! time-consuming work is done before, in [`Prepared::new`]. The motion, the requests with their ticks, and the
//! feedback whose own tick lies at least D ticks back determine every setpoint: the same inputs give the same
//! setpoints, bit for bit.
//!
//! ```
//! use camwright::interpolator::{Interpolator, TickInputs};
//! use camwright::machine::reference::cam_grinder;
//!
//! let mut interpolator = Interpolator::new(&cam_grinder());
//! let out = interpolator.step(&TickInputs { tick: 1, requests: &[] });
//! assert!(interpolator.is_idle() && out.events.iter().next().is_none());
//! ```

mod cut;
mod exchange;
mod execution;
mod following;
mod free_rotation;
mod homing;
pub mod join;
mod line;
pub mod manual;
mod path_time;
mod pose;
mod prepare_error;
mod prepared;
mod progress;
pub mod quantity;
mod replay;
mod search;
pub mod setup;
mod spiral;
mod status;
mod tail;
pub mod tolerance;
pub mod trajectory;
mod trajectory_limits;
mod trajectory_replacement;
pub mod wheel_change;

pub use exchange::{
    AppliedInput, InfeedEnd, InterpolatorEvent, MAX_APPLIED, MotionOutcome, MotionRequest, Order, OrderKind,
    ProbeOutcome, StartError, StepOutput, TickInputs,
};
pub use prepare_error::PrepareError;
pub use prepared::{Motion, Prepared};
pub use replay::RestState;
pub use status::{ExecutionState, InterpolatorAlarm, InterpolatorStatus, SearchStep};
pub use trajectory_replacement::StateForecast;

use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use crate::machine::setpoint::{Input, Latch, Setpoint};
use crate::math::fixed_list::FixedList;
use alloc::boxed::Box;
use cut::CutExecution;
use following::{PathFollowing, SetpointHistory};
use free_rotation::FreeRotation;
use line::LineExecution;
use path_time::{ONE, PathClock};
use pose::AxisPose;
use spiral::Spiral;
use tolerance::ToleranceViolation;

/// Feedback waiting for its tick.
#[derive(Debug, Clone, Copy, PartialEq)]
enum PendingFeedback {
    Latch(Latch),
    Alarm(u64, u16),
    OutOfTolerance(u64, ToleranceViolation),
    Settled(u64),
}

impl PendingFeedback {
    fn tick(&self) -> u64 {
        match self {
            PendingFeedback::Latch(latch) => latch.tick,
            PendingFeedback::Alarm(tick, _)
            | PendingFeedback::OutOfTolerance(tick, _)
            | PendingFeedback::Settled(tick) => *tick,
        }
    }
}

impl Default for PendingFeedback {
    fn default() -> Self {
        PendingFeedback::Alarm(0, 0)
    }
}

/// Purpose of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Purpose {
    Move,
    Seek,
    Return,
    Retract,
}

/// Motion in execution.
#[allow(clippy::large_enum_variant, reason = "a box would allocate in the cyclic path")]
#[derive(Debug, Clone, Copy, PartialEq)]
enum ExecutionMode {
    Idle,
    Fault,
    /// Loaded; begins with the next tick.
    Starting,
    /// At rest between two segments.
    Ready,
    Dwell {
        left: u64,
    },
    Wait,
    Command {
        until: u64,
    },
    Line(LineExecution, Purpose),
    /// Waits for the state of the home switch, before a search that depends on it.
    Level {
        until: u64,
    },
    /// At the end of a search's travel, for an edge that is not in sight yet.
    LastLook {
        until: u64,
    },
    Cut(CutExecution),
    Spiral(Spiral),
    Trajectory(PathClock),
    /// At the end of a trajectory, until the axes are where it ends.
    Settle,
}

/// The interpolator of one machine.
#[derive(Debug, Clone)]
pub struct Interpolator {
    machine: MachineDescription,
    motion: Option<Box<Prepared>>,
    finished: Option<Box<Prepared>>,
    feedback: FixedList<PendingFeedback, 256>,
    mode: ExecutionMode,
    /// C turning on between two cuts, whatever the mode.
    spin: Option<FreeRotation>,
    tick: u64,
    setpoint: Setpoint,
    segment: usize,
    segment_began: u64,
    /// First tick of the motion in execution; earlier edges are ignored.
    motion_began: u64,
    /// The edge that ends the search in execution.
    caught: Option<Latch>,
    /// Position caught by the last search of an axis (counts).
    references: [i64; AXIS_COUNT],
    homed: [bool; AXIS_COUNT],
    feed_override: i64,
    hold: bool,
    cancel: bool,
    alarm: Option<u16>,
    decisions: u32,
    /// The force monitor's input, as far as it is in sight.
    is_steady: bool,
    /// The size monitor's input, as far as it is in sight, and the first tick of its present watch.
    is_size_reached: bool,
    size_watched_from: u64,
    history: SetpointHistory,
    following: PathFollowing,
}

impl Interpolator {
    /// The interpolator of a machine whose axes rest at its power-up positions, which are zero counts.
    #[must_use]
    pub fn new(machine: &MachineDescription) -> Self {
        Self {
            machine: machine.clone(),
            motion: None,
            finished: None,
            feedback: FixedList::new(),
            mode: ExecutionMode::Idle,
            spin: None,
            tick: 0,
            setpoint: Setpoint::default(),
            segment: 0,
            segment_began: 0,
            motion_began: 0,
            caught: None,
            references: [0; AXIS_COUNT],
            homed: core::array::from_fn(|axis| !machine.axes[axis].needs_homing),
            feed_override: ONE,
            hold: false,
            cancel: false,
            alarm: None,
            decisions: 0,
            is_steady: false,
            is_size_reached: false,
            size_watched_from: 0,
            history: SetpointHistory::new(machine),
            following: PathFollowing::default(),
        }
    }

    /// Takes the machine's word for where the axes rest (counts): at the start, after an underrun, after a reset. A
    /// motion in execution is dropped.
    pub fn resync(&mut self, counts: [i64; AXIS_COUNT]) {
        self.setpoint = Setpoint { counts, ..Setpoint::default() };
        self.mode = ExecutionMode::Idle;
        self.spin = None;
        self.alarm = None;
        self.hold = false;
        self.cancel = false;
        self.feedback = FixedList::new();
        self.following = PathFollowing::default();
        self.drop_motion();
    }

    /// Takes the machine's word for whether the zero of an axis is known.
    pub fn set_homed(&mut self, axis: Axis, homed: bool) {
        self.homed[axis.index()] = homed;
    }

    /// The zero of an axis is known.
    #[must_use]
    pub fn is_homed(&self, axis: Axis) -> bool {
        self.homed[axis.index()]
    }

    #[must_use]
    pub fn setpoint(&self) -> &Setpoint {
        &self.setpoint
    }

    /// Nothing is executed and nothing stands in the way of a start.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.mode == ExecutionMode::Idle
    }

    /// Loads a motion; it begins with the next tick, whose setpoint is still the present position.
    ///
    /// # Errors
    /// A motion in execution, an alarm, a trajectory that begins elsewhere; the motion is given back.
    pub fn start(&mut self, motion: Box<Prepared>) -> Result<(), (StartError, Box<Prepared>)> {
        match self.mode {
            ExecutionMode::Idle => {}
            ExecutionMode::Fault => return Err((StartError::Fault, motion)),
            _ => return Err((StartError::Busy, motion)),
        }
        if let Some(trajectory) = &motion.trajectory {
            for axis in Axis::ALL {
                let Some(law) = trajectory.law(axis) else { continue };
                let wanted = self.machine.axis(axis).scale.counts(law.sample(0.0).value);
                let actual = self.setpoint.counts[axis.index()];
                if wanted != actual {
                    return Err((StartError::StartsElsewhere { axis, wanted, actual }, motion));
                }
            }
        }
        let lost = motion.setup_axes.iter().copied().find(|axis| !self.homed[axis.index()]);
        if let Some(axis) = lost {
            return Err((StartError::NotHomed(axis), motion));
        }
        self.motion = Some(motion);
        self.mode = ExecutionMode::Starting;
        self.segment = 0;
        self.hold = false;
        self.cancel = false;
        self.alarm = None;
        self.decisions = 0;
        self.is_steady = false;
        self.is_size_reached = false;
        self.following = PathFollowing::default();
        Ok(())
    }

    /// The motion that ended, so that it can be freed outside the cyclic path. To be taken before the next start.
    pub fn take_finished(&mut self) -> Option<Box<Prepared>> {
        self.finished.take()
    }

    /// Takes an edge caught by the machine. It comes into sight D ticks after its own; `false` if there is no room.
    /// Every edge of tick k − D must have been given before the step of tick k. Without a motion it is of no interest.
    pub fn feedback(&mut self, latch: &Latch) -> bool {
        self.motion.is_none() || self.remember(PendingFeedback::Latch(*latch))
    }

    /// Takes an alarm of the machine that stops the axes, by its number and the tick at which it was raised. It comes
    /// into sight D ticks after its own; `false` if there is no room.
    pub fn alarm(&mut self, tick: u64, number: u16) -> bool {
        self.remember(PendingFeedback::Alarm(tick, number))
    }

    fn remember(&mut self, feedback: PendingFeedback) -> bool {
        let index = self.feedback.partition_point(|other| other.tick() <= feedback.tick());
        self.feedback.insert(index, feedback)
    }

    pub fn step(&mut self, inputs: &TickInputs<'_>) -> StepOutput {
        let mut out = StepOutput {
            tick: inputs.tick,
            setpoint: self.setpoint,
            requests_taken: 0,
            applied: FixedList::new(),
            orders: FixedList::new(),
            events: FixedList::new(),
            status: InterpolatorStatus::default(),
        };
        if self.mode == ExecutionMode::Starting {
            self.motion_began = inputs.tick;
        }
        self.apply_feedback(inputs.tick, &mut out);
        for request in inputs.requests {
            if out.applied.is_full() {
                break;
            }
            self.apply(*request);
            out.applied.push(AppliedInput::Request(*request));
            out.requests_taken += 1;
        }
        // Out of its place, so that the motion can be read while everything else changes.
        let motion = self.motion.take();
        if let Some(motion) = &motion {
            self.advance(inputs.tick, motion, &mut out);
            self.remember_setpoint(inputs.tick);
        }
        self.tick = inputs.tick;
        out.status = self.status(motion.as_deref());
        out.setpoint = self.setpoint;
        self.motion = motion;
        if matches!(self.mode, ExecutionMode::Idle | ExecutionMode::Fault) {
            self.drop_motion();
        }
        out
    }

    fn drop_motion(&mut self) {
        if self.motion.is_some() {
            self.finished = self.motion.take();
        }
    }

    /// Feedback that comes into sight.
    fn apply_feedback(&mut self, tick: u64, out: &mut StepOutput) {
        let Some(horizon) = tick.checked_sub(u64::from(self.machine.feedback_delay_ticks)) else { return };
        let mut seen = 0;
        while let Some(feedback) = self.feedback.get(seen).copied()
            && feedback.tick() <= horizon
            && !out.applied.is_full()
        {
            seen += 1;
            match feedback {
                // Whether it was given before or after the start must not show, not even in the record.
                PendingFeedback::Latch(latch) if latch.tick < self.motion_began => {}
                // It was reset before the motion began: with an alarm none begins.
                PendingFeedback::Alarm(raised, _) if self.motion.is_some() && raised < self.motion_began => {}
                PendingFeedback::Latch(latch) => {
                    out.applied.push(AppliedInput::Feedback(latch));
                    if latch.input == Input::SteadyForce {
                        self.is_steady = latch.rising;
                    }
                    if latch.input == Input::SizeReached && latch.tick >= self.size_watched_from {
                        self.is_size_reached = latch.rising;
                    }
                    self.catch(latch);
                }
                PendingFeedback::OutOfTolerance(tick, _) | PendingFeedback::Settled(tick)
                    if tick < self.motion_began => {}
                PendingFeedback::OutOfTolerance(_, broken) => {
                    out.applied.push(AppliedInput::OutOfTolerance(broken));
                    self.following.broken = Some(broken);
                }
                PendingFeedback::Settled(_) => {
                    out.applied.push(AppliedInput::Settled);
                    self.following.has_settled = true;
                }
                PendingFeedback::Alarm(_, number) => {
                    out.applied.push(AppliedInput::Alarm(number));
                    if self.mode == ExecutionMode::Idle {
                        self.mode = ExecutionMode::Fault;
                    }
                    self.alarm = self.alarm.or(Some(number));
                }
            }
        }
        self.feedback.remove_first(seen);
    }

    fn apply(&mut self, request: MotionRequest) {
        let busy = self.motion.is_some();
        match request {
            MotionRequest::Hold => self.hold = busy && !self.cancel,
            MotionRequest::Unhold => self.hold = false,
            MotionRequest::Cancel => {
                self.cancel = busy;
                self.hold = false;
            }
            MotionRequest::SetOverride(factor) if factor.is_finite() => {
                self.feed_override = path_time::from_ticks(factor.clamp(0.0, 1.0));
            }
            MotionRequest::SetOverride(_) => {}
            MotionRequest::Decision => self.decisions = self.decisions.saturating_add(u32::from(busy)),
        }
    }

    fn rest(&mut self) {
        self.setpoint = AxisPose::at_rest(self.setpoint.counts).setpoint();
    }
}
