// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Set-up work: moving axes to places, and probing with one of them.
//!
//! ```text
//! move    all axes begin and arrive together, jerk limited
//! probe  (wheel up to speed, or still and allowed to press) · is the input free? · slowly, until it closes · stop · stand off
//!        (the edge is given the reading it should have)     · (wheel to rest)
//! ```
//! Both are checked against travel before anything moves and need axes whose zero is known; a cancel leaves them where they come to
//! rest.

use crate::machine::description::{AXIS_COUNT, Axis, AxisScale, MachineDescription, MotionLimits};
use crate::machine::setpoint::Input;
use crate::math::units::deg_from_rad;
use crate::motion::plan::{AxisTarget, HomeStep, Phase, Plan, PlanCommand, SearchSignal, Segment, SegmentKind};
use crate::motion::point_to_point::{MoveLaw, whole_ticks};
use alloc::string::String;
use alloc::vec::Vec;
use thiserror::Error;

/// Farthest that a wheel may run on after it has touched (mm): until the touch is known, and until it stands. A running wheel takes
/// that off the part, a stopped one is pressed by it.
pub const MAX_RUN_ON_MM: f64 = 0.05;

/// Target of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MoveTo {
    pub axis: Axis,
    /// To where, or by how much (mm or rad).
    pub position: f64,
    /// True for a distance from the rest position.
    pub is_relative: bool,
}

/// Why a move or a probe is refused.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SetupError {
    /// No axis is named.
    #[error("no joint is named")]
    NoAxis,
    /// An axis is named twice.
    #[error("{} is named twice", .0.joint())]
    Twice(Axis),
    /// A figure is none.
    #[error("{what} of {} is not a number", axis.joint())]
    NotFinite { axis: Axis, what: &'static str },
    /// A position beyond a soft limit (mm).
    #[error("{what} of {} is {position_mm:.4} mm, the soft limit is {bound_mm} mm", axis.joint())]
    SoftLimit { axis: Axis, what: &'static str, position_mm: f64, bound_mm: f64 },
    /// A share of the speed that is none.
    #[error("the speed factor is {0}; it must be above 0 and at most 1")]
    SpeedFactor(f64),
    /// A speed that an axis lacks (mm/s or rad/s).
    #[error("{} cannot move at {}; the speed must be above 0 and at most {}", axis.joint(), speed_text(*axis, *speed), speed_text(*axis, *max))]
    Speed { axis: Axis, speed: f64, max: f64 },
    /// A speed at which an axis is not moved whose zero is not known (mm/s or rad/s).
    #[error(
        "the zero of {} is unknown, so its maximum speed is its search speed {}, not {}; home it first",
        axis.joint(), speed_text(*axis, *max), speed_text(*axis, *speed)
    )]
    Lost { axis: Axis, speed: f64, max: f64 },
    /// The input is not caught by this axis.
    #[error("{input} catches the position of {}, not of {}", catches.joint(), axis.joint())]
    OtherAxis {
        /// Name of the input.
        input: String,
        /// The axis that it catches.
        catches: Axis,
        /// The axis that was to probe.
        axis: Axis,
    },
    /// The machine lacks it.
    #[error("the machine has no {0}")]
    NoInput(&'static str),
    /// A target where the axis stands already.
    #[error("{} is already at or beyond the target", .0.joint())]
    NoWay(Axis),
    /// A stand-off that is none.
    #[error("the stand-off is {0}; it must be {1}")]
    StandOff(f64, &'static str),
    /// A wheel that touches must be stopped in time (mm).
    #[error(
        "at {speed_mm_s} mm/s the wheel would run on by {run_on_mm:.4} mm after it has touched; at most {MAX_RUN_ON_MM} mm is \
         allowed, which is {max_mm_s:.3} mm/s"
    )]
    RunsOn {
        speed_mm_s: f64,
        /// Stopping distance (mm).
        run_on_mm: f64,
        /// The speed that would do.
        max_mm_s: f64,
    },
    /// A reading is to be set of an axis that finds its zero by itself.
    #[error("only the zero of x_axis can be corrected by a probe, not that of {}", .0.joint())]
    Zero(Axis),
    /// A bound that is none.
    #[error("{what} is {value}; it must be {allowed}")]
    Bound {
        what: &'static str,
        value: f64,
        /// Allowed values.
        allowed: &'static str,
    },
    /// Limits that no move can keep.
    #[error("{} cannot be moved so: {error}", axis.joint())]
    Move { axis: Axis, error: crate::motion::point_to_point::PointToPointError },
}

fn speed_text(axis: Axis, speed: f64) -> String {
    match axis {
        Axis::C => alloc::format!("{:.3} deg/s", deg_from_rad(speed)),
        Axis::X | Axis::Z => alloc::format!("{speed:.3} mm/s"),
    }
}

/// Counts of a position far enough from where numbers end.
pub(super) fn counts(axis: Axis, scale: AxisScale, position: f64, what: &'static str) -> Result<i64, SetupError> {
    // A kilometre, or a million turns: beyond that a figure has slipped.
    let is_sound = position.is_finite() && position.abs() < 1e7;
    if is_sound { Ok(scale.counts(position)) } else { Err(SetupError::NotFinite { axis, what }) }
}

pub(super) fn within(machine: &MachineDescription, axis: Axis, at: i64, what: &'static str) -> Result<(), SetupError> {
    let description = machine.axis(axis);
    let Some((low, high)) = description.soft_limits else { return Ok(()) };
    let (min, max) = (description.scale.counts(low), description.scale.counts(high));
    if (min..=max).contains(&at) {
        return Ok(());
    }
    let bound_mm = if at < min { low } else { high };
    Err(SetupError::SoftLimit { axis, what, position_mm: description.scale.position(at), bound_mm })
}

/// Targets of a move, on counts, from where the axes rest; at this share of their speed.
///
/// # Errors
/// No axis or one twice, figures that are none, a place beyond a soft limit, a share that is none.
pub fn targets(
    moves: &[MoveTo],
    from: [i64; AXIS_COUNT],
    speed_factor: f64,
    machine: &MachineDescription,
) -> Result<Vec<AxisTarget>, SetupError> {
    if moves.is_empty() {
        return Err(SetupError::NoAxis);
    }
    if !(speed_factor > 0.0 && speed_factor <= 1.0) {
        return Err(SetupError::SpeedFactor(speed_factor));
    }
    let mut targets = Vec::with_capacity(moves.len());
    for (index, wanted) in moves.iter().enumerate() {
        let axis = wanted.axis;
        if moves[..index].iter().any(|other| other.axis == axis) {
            return Err(SetupError::Twice(axis));
        }
        let description = machine.axis(axis);
        let start = if wanted.is_relative { from[axis.index()] } else { 0 };
        let target_counts = start + counts(axis, description.scale, wanted.position, "the target")?;
        within(machine, axis, target_counts, "the target")?;
        let limits = description.limits.at_most(speed_factor * description.limits.velocity);
        targets.push(AxisTarget { axis, target_counts, limits });
    }
    Ok(targets)
}

/// Request of a probe.
#[derive(Debug, Clone, PartialEq)]
pub struct ProbeRequest {
    /// The axis that moves.
    pub axis: Axis,
    /// Farthest position (mm or rad).
    pub target: f64,
    /// Speed (mm/s or rad/s).
    pub speed: f64,
    pub input: Input,
    /// Its name, for people.
    pub input_name: String,
    /// True if the probe ends at the opening instead of the closing edge.
    pub until_open: bool,
    /// Final distance of the axis from the edge (mm or rad); 0: the stop position.
    pub stand_off: f64,
    /// With the gap detector: the stopped wheel touches and may press so hard (N); 0: the running wheel touches.
    pub most_force_n: f64,
    /// New reading of the edge, and its permitted difference from the old reading (mm).
    pub reads: Option<(f64, f64)>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    step: HomeStep,
    axis: Axis,
    wheel: Option<i64>,
    corrects: bool,
    expected_s: f64,
}

impl Probe {
    /// A probe from where the axes rest (counts).
    ///
    /// # Errors
    /// An input that the machine lacks or that catches another axis, a place beyond a soft limit, a speed at which a wheel
    /// that touches would run on too far, a stand-off that leaves it on the part.
    pub fn new(
        request: &ProbeRequest,
        from: [i64; AXIS_COUNT],
        machine: &MachineDescription,
    ) -> Result<Self, SetupError> {
        let (axis, scale) = (request.axis, machine.axis(request.axis).scale);
        let description = machine.axis(axis);
        match request.input {
            Input::WheelContact if machine.gap_detector.is_none() => return Err(SetupError::NoInput("gap detector")),
            Input::KeyWay if machine.key_way_probe.is_none() => {
                return Err(SetupError::NoInput("switch at the keyway"));
            }
            _ => {}
        }
        if request.input.axis() != axis {
            let input = request.input_name.clone();
            return Err(SetupError::OtherAxis { input, catches: request.input.axis(), axis });
        }
        let at = from[axis.index()];
        let target = counts(axis, scale, request.target, "the target")?;
        within(machine, axis, target, "the target")?;
        let travel_counts = target - at;
        if travel_counts == 0 {
            return Err(SetupError::NoWay(axis));
        }
        let max = description.limits.velocity;
        if !(request.speed > 0.0 && request.speed <= max) {
            return Err(SetupError::Speed { axis, speed: request.speed, max });
        }
        let limits = description.limits.at_most(request.speed);
        let checked = AxisTarget { axis, target_counts: target, limits };
        MoveLaw::new(from, &[checked], machine).map_err(|error| SetupError::Move { axis, error })?;
        let touches = request.input == Input::WheelContact;
        if touches {
            let run_on_mm = run_on(request.speed, &limits, machine);
            if run_on_mm > MAX_RUN_ON_MM {
                let max_mm_s = request.speed * MAX_RUN_ON_MM / run_on_mm;
                return Err(SetupError::RunsOn { speed_mm_s: request.speed, run_on_mm, max_mm_s });
            }
        }
        let stand_off = stand_off(request, at, target, touches, machine)?;
        let wheel = match request.most_force_n {
            _ if !touches => None,
            0.0 => Some(0),
            #[allow(clippy::cast_possible_truncation, reason = "checked: at most a million")]
            force_n if force_n > 0.0 && force_n <= 1e6 => Some(libm::ceil(force_n) as i64),
            value => {
                return Err(SetupError::Bound { what: "the maximum force (N)", value, allowed: "0 to 1000000" });
            }
        };
        let reads = match request.reads {
            None => None,
            Some(_) if axis != Axis::X => return Err(SetupError::Zero(axis)),
            Some((position, max)) if max > 0.0 && max < 10.0 => {
                Some((counts(axis, scale, position, "the true position")?, scale.counts(max)))
            }
            Some((_, value)) => {
                let what = "the largest correction (mm)";
                return Err(SetupError::Bound { what, value, allowed: "above 0 and below 10" });
            }
        };
        let sought = if request.until_open { SearchSignal::Opening } else { SearchSignal::Closing };
        let input = request.input;
        Ok(Self {
            step: HomeStep::Probe { axis, input, sought, travel_counts, limits, stand_off, reads },
            axis,
            wheel,
            corrects: reads.is_some(),
            // The position of the edge is unknown: half the distance.
            expected_s: 0.5 * scale.position(travel_counts.abs()) / request.speed,
        })
    }

    /// The axis that moves.
    #[must_use]
    pub fn axis(&self) -> Axis {
        self.axis
    }

    pub(super) fn plan(&self, machine: &MachineDescription) -> Plan {
        let mut plan = Plan { job: String::from("probe"), ..Plan::default() };
        let turns = self.wheel == Some(0);
        if self.wheel.is_some() {
            push_wheel(&mut plan, turns, machine);
        }
        let order_s = 2.0 * f64::from(machine.feedback_delay_ticks) * machine.cycle_time_s();
        let mut push = |kind: SegmentKind, seconds: f64, label: &str| {
            plan.segments.push(step(kind, Phase::Position, whole_ticks(seconds, machine.cycle_time_s()), label));
        };
        if let Some(max_n) = self.wheel.filter(|_| !turns) {
            push(SegmentKind::Command(PlanCommand::Push { max_n }), order_s, "the stopped wheel may press");
        }
        push(SegmentKind::Home(self.step), self.expected_s, "probe");
        if self.corrects {
            push(SegmentKind::Command(PlanCommand::SetHome(self.axis)), order_s, "correct the zero");
        }
        match self.wheel {
            Some(_) if turns => push(SegmentKind::Command(PlanCommand::WheelStop), order_s, "wheel stop"),
            Some(_) => push(SegmentKind::Command(PlanCommand::Push { max_n: 0 }), order_s, "no more pressing"),
            None => {}
        }
        plan
    }
}

/// Stopping distance of an axis after an edge (mm or rad): until the edge is known, and until the axis stands. A stop from v takes
/// at most v/a + a/j, at half the speed on average; moves use only part of acceleration and jerk, the rest is reserved for the stop.
fn run_on(speed: f64, limits: &MotionLimits, machine: &MachineDescription) -> f64 {
    let known_s = f64::from(machine.feedback_delay_ticks + 2) * machine.cycle_time_s();
    // From a slow speed the stop is all jerk: 2 √(v/j).
    let stop_s =
        (speed / limits.acceleration + limits.acceleration / limits.jerk).min(2.0 * libm::sqrt(speed / limits.jerk));
    speed * (known_s + stop_s)
}

/// Final position of the axis relative to the edge, and the move to it.
fn stand_off(
    request: &ProbeRequest,
    at: i64,
    target: i64,
    touches: bool,
    machine: &MachineDescription,
) -> Result<Option<(i64, MotionLimits)>, SetupError> {
    let description = machine.axis(request.axis);
    let distance = request.stand_off;
    if !(distance >= 0.0 && distance.is_finite()) {
        return Err(SetupError::StandOff(distance, "a number from 0 on"));
    }
    if distance == 0.0 {
        return if touches {
            Err(SetupError::StandOff(0.0, "above 0: the wheel must leave the part"))
        } else {
            Ok(None)
        };
    }
    let away = counts(request.axis, description.scale, distance, "the stand-off")? * if target > at { -1 } else { 1 };
    // The edge may lie anywhere on the way.
    within(machine, request.axis, at + away, "the stand-off from the start")?;
    within(machine, request.axis, target + away, "the stand-off from the target")?;
    Ok(Some((away, description.limits)))
}

/// A move as a plan.
pub(super) fn move_plan(targets: Vec<AxisTarget>) -> Plan {
    let moves = step(SegmentKind::Move(targets), Phase::Position, 0, "move");
    Plan { job: String::from("move"), segments: alloc::vec![moves], ..Plan::default() }
}

/// Appends the order to the wheel and the time that it takes.
pub(super) fn push_wheel(plan: &mut Plan, turns: bool, machine: &MachineDescription) {
    let cycle_s = machine.cycle_time_s();
    let order_s = 2.0 * f64::from(machine.feedback_delay_ticks) * cycle_s;
    let (command, label) =
        if turns { (PlanCommand::WheelStart, "wheel start") } else { (PlanCommand::WheelStop, "wheel stop") };
    let kinds = [
        (SegmentKind::Command(command), order_s, label),
        (SegmentKind::Dwell, machine.longest_spin_up_s() + cycle_s, "wheel to its speed, or to rest"),
    ];
    for (kind, seconds, label) in kinds {
        plan.segments.push(step(kind, Phase::Position, whole_ticks(seconds, cycle_s), label));
    }
}

/// Appends a step that takes this time (s).
pub(super) fn push_step(
    plan: &mut Plan,
    kind: SegmentKind,
    phase: Phase,
    seconds: f64,
    label: &str,
    machine: &MachineDescription,
) {
    plan.segments.push(step(kind, phase, whole_ticks(seconds, machine.cycle_time_s()), label));
}

fn step(kind: SegmentKind, phase: Phase, ticks: u64, label: &str) -> Segment {
    Segment { kind, phase, lobe: None, label: String::from(label), ticks, stop_ticks: 1, stock_mm: 0.0 }
}
