// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Inputs and outputs of a tick of the interpolator.

use super::tolerance::ToleranceViolation;
use super::{InterpolatorAlarm, InterpolatorStatus};
use crate::machine::description::Axis;
use crate::machine::setpoint::{Input, Latch, Setpoint};
use crate::math::fixed_list::FixedList;
use thiserror::Error;

/// Request of an operator or a client during a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MotionRequest {
    /// Hold on the path; in a cut, take the wheel off the part and keep C turning, as between cuts where it turns on.
    Hold,
    Unhold,
    /// Come to rest, retract, and drop the motion.
    Cancel,
    /// Factor on path time, 0..=1; what lies outside is taken to the nearer bound, what is not a number is ignored.
    SetOverride(f64),
    /// A decision of the client.
    Decision,
}

/// Requests of one tick.
#[derive(Debug, Clone, Copy)]
pub struct TickInputs<'a> {
    /// The tick to compute. Consecutive while a motion is executed.
    pub tick: u64,
    /// In the order in which they were made.
    pub requests: &'a [MotionRequest],
}

/// An input that took effect: what must be recorded, in addition to the motion, to compute the same setpoints again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AppliedInput {
    Request(MotionRequest),
    /// An edge caught by the machine came into sight.
    Feedback(Latch),
    /// An alarm of the machine came into sight, by its number.
    Alarm(u16),
    /// That a trajectory's tolerance was broken came into sight.
    OutOfTolerance(ToleranceViolation),
    /// That the axes are where a trajectory ends, within its goal tolerances, came into sight.
    Settled,
}

impl Default for AppliedInput {
    fn default() -> Self {
        AppliedInput::Alarm(0)
    }
}

/// An order to the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OrderKind {
    /// The position `counts` of the axis is zero from the order's tick on: setpoints from that tick on, and latches of
    /// ticks from that tick on, are counted from there.
    SetHome {
        axis: Axis,
        /// The position that becomes zero (counts).
        counts: i64,
    },
    /// In the order's tick the machine reports, like an edge, whether an input is closed.
    Ask { input: Input },
    /// The zero of the axis is unknown from the order's tick on; the machine reports whether its home switch is closed.
    LoseHome { axis: Axis },
    /// Bring the wheel to its surface speed.
    #[default]
    WheelStart,
    /// Let the wheel come to rest.
    WheelStop,
    /// Mount a wheel of the changer.
    ChangeWheel { wheel: u32 },
    /// The wheel mounted must have this radius (nm).
    ExpectWheel { radius_nm: i64 },
    /// Dress the wheel to this radius (nm).
    Dress { radius_nm: i64 },
    /// The stopped wheel may press on the part.
    Push {
        /// The most (N); 0: not any more.
        max_n: i64,
    },
    /// The force monitor watches.
    WatchForce {
        /// Most that the force may differ by over a turn (N); 0: not any more.
        max_n: i64,
    },
    /// The size monitor of the gauge watches.
    WatchSize {
        /// Mean diameter over a turn (nm); 0: no longer.
        diameter_nm: i64,
    },
}

/// An order to the machine, and the tick at which it takes effect. No setpoint of that tick or later may be sent before
/// the machine has acknowledged it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Order {
    /// First tick at which it is in force.
    pub tick: u64,
    pub kind: OrderKind,
}

/// Outcome of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MotionOutcome {
    Completed,
    /// Ended by a cancel; the axes rest, the wheel is retracted.
    Cancelled,
    /// Ended by an alarm, with its number.
    Failed(u16),
    /// Ended by a violated tolerance of a trajectory; the axes rest on their path.
    OutOfTolerance(ToleranceViolation),
}

/// Result of a probe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProbeOutcome {
    /// The edge, as it read; and by how much the reading of the axis was corrected (counts), 0 where it was not to be.
    Found {
        latch: Latch,
        /// New reading of the edge minus the old one.
        correction: i64,
    },
    /// The edge; it read so much else than it should (counts) that the zero was left as it is.
    TooFarOff {
        latch: Latch,
        /// Expected reading of the edge minus the measured one.
        off: i64,
    },
    /// No edge up to the target, where the axis stands.
    Missed,
    /// The input was closed before anything moved, or open where it was to open: nothing moved.
    AlreadyThere,
}

/// Something that happened in a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum InterpolatorEvent {
    /// A segment begins, by its index.
    Segment(usize),
    /// Spark-out is over before its last turn: the force was steady.
    LeftOut {
        /// Index of the lobe.
        lobe: usize,
        turns: u32,
    },
    /// The infeed of a cut ended because the gauge read the size.
    InfeedEnded(InfeedEnd),
    /// The interpolator raises an alarm.
    Alarm(InterpolatorAlarm),
    /// A probe came to its end.
    Probed(ProbeOutcome),
    /// The motion ended with this tick, and the axes rest.
    Finished(MotionOutcome),
}

impl Default for InterpolatorEvent {
    fn default() -> Self {
        InterpolatorEvent::Segment(0)
    }
}

/// End of the infeed of a cut at a gauge-controlled size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InfeedEnd {
    /// Index of the lobe.
    pub lobe: usize,
    /// Turns since the cut began.
    pub turn: f64,
    /// Infeed since the cut began (mm).
    pub infed_mm: f64,
    /// Turns with infeed that are left out.
    pub left_out: u32,
}

/// Most inputs that one tick applies; the rest waits for the next.
pub const MAX_APPLIED: usize = 32;

/// Result of one tick.
#[derive(Debug, Clone, Copy)]
pub struct StepOutput {
    pub tick: u64,
    pub setpoint: Setpoint,
    /// Number of requests applied; the caller offers the others again with the next tick.
    pub requests_taken: usize,
    /// Inputs that took effect with this tick, in order.
    pub applied: FixedList<AppliedInput, MAX_APPLIED>,
    /// Orders to send to the machine.
    pub orders: FixedList<Order, 4>,
    pub events: FixedList<InterpolatorEvent, 16>,
    /// Present status of the interpolator.
    pub status: InterpolatorStatus,
}

/// Why a motion does not start.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum StartError {
    /// Another motion is executed.
    #[error("another motion is being executed")]
    Busy,
    /// Stopped by an alarm.
    #[error("stopped by an alarm; reset it first")]
    Fault,
    /// It was cancelled before it could begin.
    #[error("it was cancelled before the axes stood still")]
    Cancelled,
    /// The machine is silent, or was started again.
    #[error("the machine is silent, or was started again")]
    MachineLost,
    /// An axis of a move or a probe whose zero is not known.
    #[error("{} is not homed, its zero is not known", .0.joint())]
    NotHomed(Axis),
    /// A trajectory that was to take the place of another does not begin as the axes move.
    #[error("the trajectory does not begin as the axes move; hold, cancel or an alarm came between")]
    MovesOtherwise,
    /// A trajectory begins elsewhere.
    #[error("the trajectory begins at {wanted} counts of {}, the axis rests at {actual}", axis.joint())]
    StartsElsewhere {
        axis: Axis,
        /// Start of the trajectory (counts).
        wanted: i64,
        /// Rest position of the axis (counts).
        actual: i64,
    },
}
