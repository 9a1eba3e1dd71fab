// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Types of the status of the interpolator, and the alarms that it raises itself.

use crate::machine::alarm::AlarmKind;
use crate::machine::description::{AXIS_COUNT, Axis};
use crate::machine::setpoint::Input;
use crate::machine::wheel_state::mm_from_nm;
use crate::motion::plan::Phase;
use core::fmt;

/// State of the interpolator; the numbers are those of the message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum ExecutionState {
    #[default]
    Idle = 0,
    Executing = 1,
    /// Coming to a hold.
    Holding = 2,
    /// At rest on the path, or off the part with C turning.
    Held = 3,
    /// Returning to the path.
    Unholding = 4,
    /// Cancelled or stopped by an alarm: coming to rest, and retracting after a cancel.
    Stopping = 5,
    /// Stopped by an alarm.
    Fault = 6,
}

/// Step of a reference search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SearchStep {
    /// Looking for the edge.
    Search,
    /// Coming to rest behind it.
    Stop,
    /// Going back to it.
    Return,
    /// Making it the zero.
    Latch,
}

/// Present status of the interpolator.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct InterpolatorStatus {
    pub state: ExecutionState,
    /// Index of the segment in execution.
    pub segment: usize,
    /// Purpose.
    pub phase: Option<Phase>,
    /// Index of the lobe it is for.
    pub lobe: Option<usize>,
    /// Turns done of a cut, those inserted by a hold not counted.
    pub turn: f64,
    /// Turns of the cut.
    pub turns: f64,
    /// Material above the contour (mm).
    pub stock_mm: f64,
    /// Share of the predicted time (0..=100).
    pub percent: f64,
    /// Predicted at full override (s).
    pub time_left_s: f64,
    /// Override asked for (0..=1).
    pub feed_override: f64,
    /// Which axes know their zero, by [`Axis::index`].
    pub homed: [bool; AXIS_COUNT],
    /// Step of the search in execution, with its axis.
    pub search: Option<(Axis, SearchStep)>,
}

impl InterpolatorStatus {
    /// Every axis that needs homing is homed.
    #[must_use]
    pub fn is_homed(&self) -> bool {
        self.homed.iter().all(|homed| *homed)
    }
}

/// An alarm that the interpolator raises itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InterpolatorAlarm {
    /// A search came to the end of its travel without its edge.
    NoEdge {
        /// The axis that searched.
        axis: Axis,
        /// The input it searched for.
        input: Input,
    },
    /// A position beyond a soft limit.
    SoftLimit {
        axis: Axis,
        /// The position (counts).
        counts: i64,
        /// The bound (counts).
        bound: i64,
    },
    /// A position of an axis whose zero is not known.
    NotHomed { axis: Axis },
    /// A cut begins where the axis is not.
    NotAtStart {
        axis: Axis,
        /// Expected position (counts; C modulo a turn).
        wanted: i64,
        /// Actual position (counts).
        actual: i64,
    },
    /// A segment that preparation should have refused.
    BadSegment { segment: usize },
    /// All of the infeed was driven, and the gauge has not read the size.
    SizeNotReached {
        /// Size at which the infeed should have ended (nm).
        diameter_nm: i64,
        /// Turns with infeed that were driven.
        turns: u32,
    },
}

impl InterpolatorAlarm {
    /// Row in the alarm table.
    #[must_use]
    pub const fn kind(self) -> AlarmKind {
        match self {
            InterpolatorAlarm::SoftLimit { axis, .. } => AlarmKind::SoftLimit(axis),
            InterpolatorAlarm::NoEdge { input: Input::Station(_), .. } => AlarmKind::StationNotFound,
            InterpolatorAlarm::NoEdge { .. } => AlarmKind::HomingFailed,
            InterpolatorAlarm::NotHomed { axis } => AlarmKind::NotHomed(axis),
            InterpolatorAlarm::NotAtStart { axis, .. } => AlarmKind::NotAtStart(axis),
            InterpolatorAlarm::BadSegment { .. } => AlarmKind::BadSegment,
            InterpolatorAlarm::SizeNotReached { .. } => AlarmKind::SizeNotReached,
        }
    }

    #[must_use]
    pub const fn number(self) -> u16 {
        self.kind().entry().number
    }

    #[must_use]
    pub const fn remedy(self) -> &'static str {
        self.kind().entry().remedy
    }
}

impl fmt::Display for InterpolatorAlarm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            InterpolatorAlarm::NoEdge { axis, input: Input::Origin } => {
                write!(f, "{} searched its whole travel and the origin detector did not close", axis.joint())
            }
            InterpolatorAlarm::NoEdge { axis, input: Input::Station(index) } => {
                write!(f, "{} searched its whole travel and switch {index} did not close", axis.joint())
            }
            InterpolatorAlarm::NoEdge { axis, input } => {
                let what = match input {
                    Input::Index(_) => "index mark",
                    Input::WheelContact => "gap detector",
                    Input::KeyWay => "keyway",
                    Input::SteadyForce => "steady force",
                    Input::SizeReached => "size",
                    Input::Home(_) | Input::Origin | Input::Station(_) => "home switch",
                };
                write!(f, "{} searched its whole travel and did not find its {what}", axis.joint())
            }
            InterpolatorAlarm::SoftLimit { axis, counts, bound } => {
                write!(f, "{} at {counts} counts, the soft limit is {bound}", axis.joint())
            }
            InterpolatorAlarm::NotHomed { axis } => write!(f, "{} is not homed, its zero is not known", axis.joint()),
            InterpolatorAlarm::NotAtStart { axis, wanted, actual } => {
                write!(f, "the cut begins at {wanted} counts of {}, the axis is at {actual}", axis.joint())
            }
            InterpolatorAlarm::BadSegment { segment } => write!(f, "segment {segment} cannot be executed"),
            InterpolatorAlarm::SizeNotReached { diameter_nm, turns } => {
                let diameter_mm = mm_from_nm(*diameter_nm);
                write!(
                    f,
                    "{turns} turns of infeed are over, and the gauge has not read the size of {diameter_mm:.4} mm"
                )
            }
        }
    }
}
