// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A plan: everything the interpolator needs to machine a part, made and proven before anything moves.
//!
//! Splines are shared by index. Segments are executed one after the other; each begins and ends with all axes at rest, but
//! for C, which may turn on from the end of a cut to the beginning of the next.

use crate::job::speed_variation::SpeedVariation;
use crate::machine::description::{Axis, MotionLimits};
use crate::math::hermite::HermiteSpline;
use crate::math::periodic_spline::PeriodicSpline;
use alloc::string::String;
use alloc::vec::Vec;

/// Purpose of a segment in the grinding cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Phase {
    /// Homing the headstock on its origin detector.
    Home = 1,
    /// Table to the lobe's station.
    Index = 2,
    /// Wheel corrected by the lift at the starting phase.
    Position = 3,
    Approach = 4,
    Cut = 5,
    SparkOut = 6,
    Retract = 7,
    /// Back to the home position.
    Return = 8,
    /// The conventional way: C turned to the lobe's base centre before machining.
    RotaryIndex = 9,
    /// Wheel trued at the dresser.
    Dress = 10,
    /// Another wheel mounted.
    WheelChange = 11,
}

/// Target of one axis in a [`SegmentKind::Move`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisTarget {
    pub axis: Axis,
    /// Absolute target (counts).
    pub target_counts: i64,
    /// Limits to keep on the way.
    pub limits: MotionLimits,
}

/// C by a time law, X by a periodic path over C plus an infeed law, plus the way beside the path where C turns on.
///
/// With `c` the angle since the cut begins: `C = start + c`, `X = path(path_start + c) + infeed(c) + lead(t)`, the infeed
/// times `ratio(path_start + c)` where it is measured along the contour's normal. The cut itself is `c` from 0 to its turns.
/// Where C turns on, the law begins before time 0 at a speed, or ends at one after the last turn: X comes from rest onto the
/// moving path meanwhile, or goes from it to rest, and there is no lead in addition.
///
/// Paths run over `σ·θ`, with θ the wheel-line angle in the lobe's frame and σ the machine's rotation sense, so that they
/// are read forwards while C turns forwards on every machine.
#[derive(Debug, Clone, PartialEq)]
pub struct CutSegment {
    /// Index into [`Plan::paths`]: `x_axis` position over σ times the wheel-line angle in the lobe's frame (mm over rad).
    pub path: usize,
    /// Index into [`Plan::time_laws`]: angle since the cut begins over time (rad over s), without acceleration at both ends.
    pub speed: usize,
    /// Index into [`Plan::angle_laws`]: offset of X over the angle since the start (mm over rad); ends at what the lobe's
    /// later passes take.
    pub infeed: usize,
    /// Index into [`Plan::ratios`] where the infeed is measured along the contour's normal: the way of X per depth.
    pub ratio: Option<usize>,
    /// Index into [`Plan::time_laws`] where C turns on: distance of X from path and infeed (mm over s).
    pub lead: Option<usize>,
    /// C where the cut begins, modulo one turn (counts).
    pub start_counts: i64,
    /// σ times the wheel-line angle in the lobe's frame there (rad).
    pub path_start_rad: f64,
    /// Turns of C, spark-out included.
    pub turns: u32,
    /// Turns with infeed; the rest is spark-out.
    pub infeed_turns: u32,
    /// Time at which the constant-speed part begins and ends, and the time of one turn in it (s): between the two the
    /// law is periodic, and a hold may insert whole turns.
    pub plateau_s: (f64, f64),
    /// Time of one turn within the plateau (s).
    pub turn_s: f64,
    /// Distance by which a cancel takes the wheel off the part (mm).
    pub retract_mm: f64,
    /// Distance by which a hold does (mm); 0: it stops the infeed and leaves the wheel on the part.
    pub hold_mm: f64,
    /// Spark-out ends when the normal force changes over one turn by no more than this (N), set in the machine by
    /// [`PlanCommand::WatchForce`]; `None`: all turns are executed.
    pub until_steady_n: Option<u32>,
    /// Speed that differs from turn to turn within the constant-speed part; `None`: every turn takes the same time.
    pub variation: Option<SpeedVariation>,
}

/// C by a time law, X and Z by laws over its angle: an insert along a spiral around a part that is not round.
///
/// With `c` the angle since the start: `C = start + c`, `X = path(c)`, `Z = advance(c)`. It begins and ends at rest; a hold stops it on
/// its path, and a cancel too, before X leaves the part.
#[derive(Debug, Clone, PartialEq)]
pub struct SpiralSegment {
    /// Index into [`Plan::angle_laws`]: `x_axis` position over the angle since the start (mm over rad).
    pub path: usize,
    /// Index into [`Plan::angle_laws`]: `z_axis` position over the angle since the start (mm over rad).
    pub advance: usize,
    /// Index into [`Plan::time_laws`]: angle since the start over time (rad over s), from rest at time 0 and angle 0 to rest.
    pub speed: usize,
    /// C where it begins, modulo one turn (counts).
    pub start_counts: i64,
}

/// The kinds of segment.
#[derive(Debug, Clone, PartialEq)]
pub enum SegmentKind {
    /// Point to point, from wherever the axes rest; all axes start and arrive together.
    Move(Vec<AxisTarget>),
    /// Move one axis until an input closes, stop, and return to the position caught at its edge plus an offset.
    Search {
        /// The axis that searches.
        axis: Axis,
        /// Input that ends the search: `origin`, or a station's switch.
        input: String,
        /// Farthest position relative to the start; reaching it without an edge is an alarm (counts).
        travel_counts: i64,
        /// Target position relative to the captured edge (counts).
        offset_counts: i64,
        /// Limits of the search; its velocity is that of the search.
        limits: MotionLimits,
    },
    Cut(CutSegment),
    /// Turn along a spiral.
    Spiral(SpiralSegment),
    Dwell,
    /// Stand still until a decision comes.
    Wait,
    /// Order the machine to do something.
    Command(PlanCommand),
    /// A step of the homing of an axis or of a probe, which are motions of their own: such steps stand in no plan of a job.
    Home(HomeStep),
}

/// The edge that ends a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SearchSignal {
    /// The input closes.
    Closing,
    Opening,
    /// The input opens, if it was closed when the zero was forgotten; otherwise there is no search.
    OpeningIfClosed,
}

/// A step of the homing of an axis, or of a probe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HomeStep {
    /// The zero of an axis is unknown from now on, so there are no soft limits; the machine reports whether its home switch is closed.
    Forget(Axis),
    /// Move until an edge is caught, and stop behind it.
    Seek {
        axis: Axis,
        input: crate::machine::setpoint::Input,
        sought: SearchSignal,
        /// Farthest position relative to the start; reaching it without the edge is an alarm (counts).
        travel_counts: i64,
        /// Reading of the axis at the edge, once it is the reference of the zero (counts).
        zero_counts: i64,
        /// Limits of the search; its velocity is that of the search.
        limits: MotionLimits,
    },
    /// Move until an input closes or opens, stop, and stand off from its edge; an edge that is not met is none, not an alarm.
    Probe {
        axis: Axis,
        input: crate::machine::setpoint::Input,
        sought: SearchSignal,
        /// Farthest position relative to the start (counts).
        travel_counts: i64,
        /// Limits of the probe; its velocity is that of the probe.
        limits: MotionLimits,
        /// Target position afterwards relative to the edge (counts), `None`: the stop position; and the limits of the move.
        stand_off: Option<(i64, MotionLimits)>,
        /// Expected reading at the edge, and its tolerance (counts): a following [`PlanCommand::SetHome`] then sets it.
        reads: Option<(i64, i64)>,
    },
    /// The current position of the axis gets this reading.
    Here { axis: Axis, counts: i64 },
}

/// Orders to the machine within a plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PlanCommand {
    /// The place where the last search on this axis stands, its caught edge plus its offset, is its zero from now on.
    /// On the origin detector that edge is the index mark at the centre of its window, the true zero.
    SetHome(Axis),
    /// Bring the wheel to its surface speed.
    WheelStart,
    /// Let the wheel come to rest.
    WheelStop,
    /// Mount a wheel of the changer, with the wheel at rest and X clear; nothing if it is mounted.
    ChangeWheel {
        /// Position of the wheel in the changer.
        wheel: u32,
    },
    /// The wheel mounted must have this radius, or the plan is for another one.
    ExpectWheel {
        /// Its radius (nm).
        radius_nm: i64,
    },
    /// The wheel, which does not turn, may press on the part from now on.
    Push {
        /// With so much at most (N); 0: not any more.
        max_n: i64,
    },
    /// The force monitor watches from now on.
    WatchForce {
        /// Most that the normal force may differ by over a turn of C (N); 0: it does not watch.
        max_n: i64,
    },
    /// The infeed of the next cut ends when the gauge reads a size.
    WatchSize(GaugeSize),
    /// Dress the wheel, at the dresser, to this radius; `x_axis` stays the distance of its cutting point.
    Dress {
        /// Radius after it (nm).
        radius_nm: i64,
    },
}

/// Size at which the gauge ends the infeed of a cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GaugeSize {
    /// Mean diameter over a turn, as the gauge reads it (nm).
    pub diameter_nm: i64,
    /// Infeed that the cut may drive below its path before it gives up (nm).
    pub beyond_nm: i64,
}

/// One step of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    pub kind: SegmentKind,
    /// Purpose.
    pub phase: Phase,
    /// Index of the lobe, `None` for the whole part.
    pub lobe: Option<usize>,
    pub label: String,
    /// Dwell: length. Others: predicted length (ticks).
    pub ticks: u64,
    /// Length of a stop on the path from full speed that keeps every limit (ticks).
    pub stop_ticks: u64,
    /// Material above the contour when the segment starts (mm).
    pub stock_mm: f64,
}

/// Part of a job that a plan covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Half {
    #[default]
    Whole = 0,
    /// Another follows, which is made from what this one finds out.
    First = 1,
    /// Plan that follows a first half; it finishes the part.
    Second = 2,
    /// No part is finished by it: a dry run, or set-up work.
    NoPart = 3,
    /// Plan between a first half and a second half.
    Middle = 4,
}

impl Half {
    /// The job begins with it.
    #[must_use]
    pub const fn begins(self) -> bool {
        !matches!(self, Half::Second | Half::Middle)
    }

    /// The job ends with it.
    #[must_use]
    pub const fn ends(self) -> bool {
        matches!(self, Half::Whole | Half::Second)
    }
}

/// A plan for one part.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plan {
    /// Name of the job.
    pub job: String,
    /// Part of the job that it covers.
    pub half: Half,
    /// Names of the lobes, in the order of machining.
    pub lobes: Vec<String>,
    /// Periodic paths: `x_axis` position (mm) over σ times the wheel-line angle (rad); one for each profile and radius of
    /// the wheel. A path is never used again after the wheel has been dressed.
    pub paths: Vec<PeriodicSpline>,
    /// Periodic ratios over σ times the wheel-line angle: way of X per depth along the contour's normal.
    pub ratios: Vec<PeriodicSpline>,
    /// Laws over time (rad over s).
    pub time_laws: Vec<HermiteSpline>,
    /// Laws over angle (mm over rad).
    pub angle_laws: Vec<HermiteSpline>,
    pub segments: Vec<Segment>,
    /// Predicted duration (s).
    pub duration_s: f64,
    /// Predicted duration of the same job with rotary indexing before each lobe (s).
    pub duration_with_indexing_s: f64,
}

impl Plan {
    /// Size that ends the infeed of the cut in this segment; `None`: it drives all of its infeed.
    #[must_use]
    pub fn size_of(&self, segment: usize) -> Option<GaugeSize> {
        let before = self.segments.get(..segment)?.iter().rev();
        let mut deciding = before.filter_map(|segment| match &segment.kind {
            SegmentKind::Command(PlanCommand::WatchSize(size)) => Some(Some(*size)),
            SegmentKind::Cut(_) => Some(None),
            _ => None,
        });
        deciding.next().flatten()
    }
}
