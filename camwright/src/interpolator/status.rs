//! What the interpolator is doing, and the alarms that it raises itself.

use super::path_time::to_ticks;
use super::spiral::Spiral;
use super::{Interpolator, Mode, Prepared, Purpose};
use crate::machine::description::{AXIS_COUNT, Axis};
use crate::machine::setpoint::Input;
use crate::math::units::TURN_RAD;
use crate::motion::plan::{HomeStep, Phase, SegmentKind};
use core::fmt;

/// State of the interpolator; the numbers are those of the message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum State {
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

/// What the interpolator is doing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Status {
    pub state: State,
    /// Index of the segment in execution.
    pub segment: usize,
    /// What it is for.
    pub phase: Option<Phase>,
    /// Index of the lobe it is for.
    pub lobe: Option<usize>,
    /// Turns done of a cut, those inserted by a hold not counted.
    pub turn: f64,
    /// Turns of the cut.
    pub turns: f64,
    /// Material above the contour (mm).
    pub stock_mm: f64,
    /// Of the predicted time (0..=100).
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

impl Status {
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
        /// Where it should be (counts; C modulo a turn).
        wanted: i64,
        /// Where it is (counts).
        actual: i64,
    },
    /// A segment that preparation should have refused.
    BadSegment { segment: usize },
}

impl InterpolatorAlarm {
    /// Number in the alarm table; in alarms of an axis the last digit is 1 for C, 2 for X, 3 for Z.
    #[must_use]
    pub const fn number(self) -> u16 {
        const fn digit(axis: Axis) -> u16 {
            match axis {
                Axis::C => 1,
                Axis::X => 2,
                Axis::Z => 3,
            }
        }
        match self {
            InterpolatorAlarm::SoftLimit { axis, .. } => 20 + digit(axis),
            InterpolatorAlarm::NoEdge { input: Input::Station(_), .. } => 91,
            InterpolatorAlarm::NoEdge { .. } => 90,
            InterpolatorAlarm::NotHomed { axis } => 110 + digit(axis),
            InterpolatorAlarm::NotAtStart { axis, .. } => 120 + digit(axis),
            InterpolatorAlarm::BadSegment { .. } => 130,
        }
    }

    /// What to do about it.
    #[must_use]
    pub const fn remedy(self) -> &'static str {
        match self {
            InterpolatorAlarm::SoftLimit { .. } => "reset; send only positions between the soft limits",
            InterpolatorAlarm::NoEdge { input: Input::Station(_), .. } => {
                "look at the station's limit switch and the dog, then reset"
            }
            InterpolatorAlarm::NoEdge { .. } => {
                "look at the origin detector, the home switch or their marks, then reset and home again"
            }
            InterpolatorAlarm::NotHomed { .. } => "reset and home the axis",
            InterpolatorAlarm::NotAtStart { .. } => "reset and start the job from its beginning",
            InterpolatorAlarm::BadSegment { .. } => "reset and plan the job again",
        }
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
                    Input::KeyWay => "key-way",
                    Input::SteadyForce => "steady force",
                    Input::Home(_) | Input::Origin | Input::Station(_) => "home switch",
                };
                write!(f, "{} searched its whole travel and its {what} was not found", axis.joint())
            }
            InterpolatorAlarm::SoftLimit { axis, counts, bound } => {
                write!(f, "{} at {counts} counts, the soft limit is {bound}", axis.joint())
            }
            InterpolatorAlarm::NotHomed { axis } => write!(f, "{} is not homed, its zero is not known", axis.joint()),
            InterpolatorAlarm::NotAtStart { axis, wanted, actual } => {
                write!(f, "the cut begins at {wanted} counts of {}, the axis is at {actual}", axis.joint())
            }
            InterpolatorAlarm::BadSegment { segment } => write!(f, "segment {segment} cannot be executed"),
        }
    }
}

impl Interpolator {
    fn state(&self) -> State {
        let tick = self.tick;
        match self.mode {
            Mode::Idle => return State::Idle,
            Mode::Fault => return State::Fault,
            _ if self.cancel || self.alarm.is_some() => return State::Stopping,
            _ => {}
        }
        let (rests, disturbed) = match &self.mode {
            Mode::Line(line, purpose) => {
                let found = *purpose == Purpose::Seek && self.caught.is_some();
                (line.is_stopped(tick), line.is_stopping() && !found)
            }
            Mode::Cut(cut) => (cut.is_off(tick), !cut.is_on_path()),
            Mode::Trajectory(clock) if tick < clock.begins() => (true, false),
            Mode::Trajectory(clock) | Mode::Spiral(Spiral { clock, .. }) => {
                (clock.is_stopped(tick), clock.is_stopped(tick) && self.feed_override > 0)
            }
            Mode::Command { .. } => (false, false),
            _ => (true, false),
        };
        match (self.hold, rests, disturbed) {
            (true, true, _) => State::Held,
            (true, false, _) => State::Holding,
            (false, _, true) => State::Unholding,
            (false, _, false) => State::Executing,
        }
    }

    /// What there is to say while nothing is executed: the override that the next motion begins with, and whether the axes are homed.
    #[must_use]
    pub fn idle_status(&self) -> Status {
        let Status { feed_override, homed, .. } = self.status(None);
        Status { feed_override, homed, ..Status::default() }
    }

    pub(super) fn status(&self, motion: Option<&Prepared>) -> Status {
        let mut status = Status {
            state: self.state(),
            segment: self.segment,
            feed_override: to_ticks(self.feed_override),
            homed: self.homed,
            ..Status::default()
        };
        let Some(motion) = motion else { return status };
        if matches!(self.mode, Mode::Idle) {
            status.percent = 100.0;
            return status;
        }
        let done = self.ticks_done(motion);
        let all = motion.ticks as f64;
        status.percent = if all > 0.0 { (100.0 * done / all).clamp(0.0, 100.0) } else { 0.0 };
        status.time_left_s = (all - done).max(0.0) * self.machine.cycle_time_s();
        let Some(segment) = motion.plan.segments.get(self.segment) else { return status };
        status.phase = Some(segment.phase);
        status.lobe = segment.lobe;
        status.stock_mm = segment.stock_mm;
        if let (Mode::Cut(cut), Some(curves)) = (&self.mode, self.curves(motion)) {
            let (turn, angle) = cut.progress(self.tick, &curves);
            status.turn = turn;
            status.turns = f64::from(curves.cut.turns);
            status.stock_mm = (segment.stock_mm - curves.infed_mm(angle.max(0.0))).max(0.0);
            if angle < 0.0 {
                status.phase = Some(Phase::Approach);
            } else if angle > f64::from(curves.cut.turns) * TURN_RAD {
                status.phase = Some(Phase::Retract);
            } else if segment.phase == Phase::Cut && angle >= f64::from(curves.cut.infeed_turns) * TURN_RAD {
                status.phase = Some(Phase::SparkOut);
            }
        }
        if let (Mode::Spiral(spiral), Some(curves)) = (&self.mode, self.spiral_motion(motion)) {
            status.turn = spiral.turns_done(self.tick, &curves, self.machine.cycle_time_s());
            status.turns = curves.angle_rad() / TURN_RAD;
        }
        status.search = self.search_step(&segment.kind);
        status
    }

    fn search_step(&self, kind: &SegmentKind) -> Option<(Axis, SearchStep)> {
        match kind {
            SegmentKind::Search { axis, .. } => match self.mode {
                Mode::Line(_, Purpose::Seek) if self.caught.is_some() => Some((*axis, SearchStep::Stop)),
                Mode::Line(_, Purpose::Seek) | Mode::LastLook { .. } => Some((*axis, SearchStep::Search)),
                Mode::Line(_, Purpose::Return) => Some((*axis, SearchStep::Return)),
                _ => None,
            },
            SegmentKind::Home(HomeStep::Seek { axis, .. } | HomeStep::Probe { axis, .. }) => {
                if matches!(self.mode, Mode::Line(_, Purpose::Return)) {
                    return Some((*axis, SearchStep::Return));
                }
                let is_found = self.caught.is_some() && !matches!(self.mode, Mode::Level { .. });
                Some((*axis, if is_found { SearchStep::Stop } else { SearchStep::Search }))
            }
            SegmentKind::Command(crate::motion::plan::Command::SetHome(axis)) => Some((*axis, SearchStep::Latch)),
            _ => None,
        }
    }

    /// Of the predicted ticks.
    fn ticks_done(&self, motion: &Prepared) -> f64 {
        if let Mode::Trajectory(clock) = &self.mode {
            return to_ticks(clock.at(self.tick).tau);
        }
        let (Some(facts), Some(segment)) = (motion.facts.get(self.segment), motion.plan.segments.get(self.segment))
        else {
            return motion.ticks as f64;
        };
        let length = segment.ticks as f64;
        let within = match &self.mode {
            Mode::Line(line, Purpose::Move) => line.share(self.tick) * length,
            Mode::Cut(cut) => cut.ticks_done(self.tick),
            Mode::Spiral(spiral) => to_ticks(spiral.clock.at(self.tick).tau),
            Mode::Dwell { left } => length - *left as f64,
            Mode::Starting | Mode::Ready | Mode::Wait => 0.0,
            _ => self.tick.saturating_sub(self.segment_began) as f64,
        };
        facts.ticks_before as f64 + within.min(length)
    }
}
