//! Trajectories of ROS clients: from points to splines, and the tolerances of following them.
//!
//! ROS reads points with positions alone as straight pieces, with velocities as cubics, with accelerations as
//! quintics. A straight piece steps in velocity at every point and a cubic in acceleration; a machine with limits can
//! follow neither. So what a point does not say is filled in from its neighbours, every point is met at its time, and
//! what then exceeds a limit is refused by name instead of being smoothed away.

use super::join::{self, AxisLaw, StartTolerance};
use super::tolerance::FollowingTolerances;
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription, MotionLimits};
use crate::math::hermite::{HermiteSpline, Knot};
use alloc::vec::Vec;
use core::fmt;
use thiserror::Error;

/// One point of a trajectory, values in the order of its joints.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TrajectoryPoint {
    /// Time from the start (s).
    pub time_s: f64,
    /// Positions (mm or rad).
    pub positions: Vec<f64>,
    /// Velocities (mm/s or rad/s); empty: not given.
    pub velocities: Vec<f64>,
    /// Accelerations (mm/s² or rad/s²); empty: not given. They need velocities.
    pub accelerations: Vec<f64>,
}

/// What a limit or a tolerance is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    Position,
    /// mm/s or rad/s.
    Velocity,
    /// mm/s² or rad/s².
    Acceleration,
    /// mm/s³ or rad/s³.
    Jerk,
}

impl Quantity {
    /// Its unit for an axis.
    #[must_use]
    pub const fn unit(self, axis: Axis) -> &'static str {
        match (self, axis) {
            (Quantity::Position, Axis::C) => "rad",
            (Quantity::Velocity, Axis::C) => "rad/s",
            (Quantity::Acceleration, Axis::C) => "rad/s^2",
            (Quantity::Jerk, Axis::C) => "rad/s^3",
            (Quantity::Position, _) => "mm",
            (Quantity::Velocity, _) => "mm/s",
            (Quantity::Acceleration, _) => "mm/s^2",
            (Quantity::Jerk, _) => "mm/s^3",
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Quantity::Position => "position",
            Quantity::Velocity => "velocity",
            Quantity::Acceleration => "acceleration",
            Quantity::Jerk => "jerk",
        })
    }
}

/// Why points make no trajectory that this machine can follow.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TrajectoryError {
    /// No joints, or no points.
    #[error("a trajectory needs at least one joint and one point, not {joints} joints and {points} points")]
    Empty { joints: usize, points: usize },
    /// A joint is named twice.
    #[error("joint {} is named twice", axis.joint())]
    JointTwice { axis: Axis },
    /// A point has another number of values than there are joints.
    #[error("point {point}: {count} {quantity} values for {joints} joints")]
    Size {
        /// Index of the point.
        point: usize,
        quantity: Quantity,
        count: usize,
        joints: usize,
    },
    /// Some points give a quantity and others do not.
    #[error("point {point}: every point or none must give a {quantity}, and accelerations need velocities")]
    Mixed {
        /// First point that differs.
        point: usize,
        quantity: Quantity,
    },
    /// A number is not finite, or a time is negative.
    #[error("point {point}: not a finite number, or a negative time")]
    NotFinite {
        /// Index of the point.
        point: usize,
    },
    /// Times do not increase.
    #[error("point {point}: time {time_s} s does not increase (previous {previous_s} s)")]
    TimeNotIncreasing {
        /// Index of the point.
        point: usize,
        time_s: f64,
        previous_s: f64,
    },
    /// The trajectory does not end at rest.
    #[error("joint {}: the last point moves at {velocity} {}, it must be at rest", axis.joint(), Quantity::Velocity.unit(*axis))]
    EndNotAtRest { axis: Axis, velocity: f64 },
    /// A first point at time 0 that is farther from the axis than allowed.
    #[error(
        "joint {}: the point at time 0 is at {asked} {unit}, the setpoint of the axis at {actual} {unit}, allowed are {allowed} {unit} \
         between them; plan from the present position, or raise the start tolerance",
        axis.joint(), unit = Quantity::Position.unit(*axis)
    )]
    StartsElsewhere {
        axis: Axis,
        /// Position of the point.
        asked: f64,
        /// Setpoint of the axis.
        actual: f64,
        allowed: f64,
    },
    /// A joint that moves is not told where to go.
    #[error("joint {} still moves and the new trajectory does not name it", axis.joint())]
    StillMoves { axis: Axis },
    /// A limit of the machine would be exceeded.
    #[error(
        "joint {} at {time_s:.3} s: {quantity} {value:.4} {unit}, the machine allows {bound} {unit}",
        axis.joint(), unit = quantity.unit(*axis)
    )]
    Limit {
        axis: Axis,
        quantity: Quantity,
        /// When it is largest (s from the start).
        time_s: f64,
        value: f64,
        /// How much is allowed.
        bound: f64,
    },
}

/// Where a trajectory begins: position (mm or rad) and its derivatives by the time of the trajectory, one per axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Start {
    pub position: [f64; AXIS_COUNT],
    /// mm/s or rad/s.
    pub velocity: [f64; AXIS_COUNT],
    /// mm/s² or rad/s².
    pub acceleration: [f64; AXIS_COUNT],
}

impl Start {
    /// At rest at a place (mm or rad).
    #[must_use]
    pub fn at_rest(position: [f64; AXIS_COUNT]) -> Self {
        Self { position, ..Self::default() }
    }

    #[must_use]
    pub fn is_moving(&self, axis: Axis) -> bool {
        self.velocity[axis.index()] != 0.0 || self.acceleration[axis.index()] != 0.0
    }
}

/// A motion of some joints over time, inside the limits of the machine; the others stay where they are.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    laws: [Option<HermiteSpline>; AXIS_COUNT],
    peaks: [MotionLimits; AXIS_COUNT],
    duration_s: f64,
    start: Start,
    tolerances: FollowingTolerances,
}

impl Trajectory {
    /// The trajectory through points from exactly `start` on, which is at rest or where another trajectory is at that time.
    ///
    /// A quantity that the points do not give is taken from their neighbours: velocities by the parabola through three
    /// points, zero where the direction turns and at the ends; accelerations as the mean of the two cubics that meet.
    ///
    /// # Errors
    /// Points that are no trajectory, and limits of the machine that it would exceed, with joint, time and amount.
    pub fn from_points(
        joints: &[Axis],
        points: &[TrajectoryPoint],
        start: &Start,
        machine: &MachineDescription,
    ) -> Result<Self, TrajectoryError> {
        Self::joined(joints, points, start, &StartTolerance::default(), machine)
    }

    /// The same, where a first point at time 0 may lie beside `start`: the trajectory is joined within
    /// [`join::MAX_JOIN_S`], see [`join`].
    ///
    /// # Errors
    /// As [`Trajectory::from_points`], and a first point farther away than the tolerance.
    pub fn joined(
        joints: &[Axis],
        points: &[TrajectoryPoint],
        start: &Start,
        tolerance: &StartTolerance,
        machine: &MachineDescription,
    ) -> Result<Self, TrajectoryError> {
        validate(joints, points)?;
        if let Some(axis) = Axis::ALL.into_iter().find(|axis| start.is_moving(*axis) && !joints.contains(axis)) {
            return Err(TrajectoryError::StillMoves { axis });
        }
        let mut all: Vec<AxisLaw> = Vec::with_capacity(joints.len());
        for (joint, axis) in joints.iter().enumerate() {
            if joints[..joint].contains(axis) {
                return Err(TrajectoryError::JointTwice { axis: *axis });
            }
            all.push(law_of(joint, *axis, points, start, tolerance, machine)?);
        }
        let mut laws: [Option<HermiteSpline>; AXIS_COUNT] = [None, None, None];
        let mut peaks = [MotionLimits { velocity: 0.0, acceleration: 0.0, jerk: 0.0 }; AXIS_COUNT];
        let mut duration_s: f64 = 0.0;
        for (axis, law, reached) in join::all(&all, machine)? {
            peaks[axis.index()] = reached;
            duration_s = duration_s.max(law.end());
            laws[axis.index()] = Some(law);
        }
        Ok(Self { laws, peaks, duration_s, start: *start, tolerances: FollowingTolerances::default() })
    }

    /// With tolerances of following it.
    #[must_use]
    pub fn with_tolerances(self, tolerances: FollowingTolerances) -> Self {
        Self { tolerances, ..self }
    }

    /// What following it has to keep.
    #[must_use]
    pub fn tolerances(&self) -> &FollowingTolerances {
        &self.tolerances
    }

    #[must_use]
    pub fn start(&self) -> &Start {
        &self.start
    }

    /// Law of an axis (mm or rad over s); `None` where it stays.
    #[must_use]
    pub fn law(&self, axis: Axis) -> Option<&HermiteSpline> {
        self.laws[axis.index()].as_ref()
    }

    /// Largest speed, acceleration and jerk of an axis.
    #[must_use]
    pub fn peaks(&self, axis: Axis) -> &MotionLimits {
        &self.peaks[axis.index()]
    }

    /// Length (s).
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }
}

fn validate(joints: &[Axis], points: &[TrajectoryPoint]) -> Result<(), TrajectoryError> {
    if joints.is_empty() || points.is_empty() {
        return Err(TrajectoryError::Empty { joints: joints.len(), points: points.len() });
    }
    for (index, point) in points.iter().enumerate() {
        let size = |quantity, values: &[f64], may_lack: bool| {
            let fits = values.len() == joints.len() || (may_lack && values.is_empty());
            let error = TrajectoryError::Size { point: index, quantity, count: values.len(), joints: joints.len() };
            if fits { Ok(()) } else { Err(error) }
        };
        size(Quantity::Position, &point.positions, false)?;
        size(Quantity::Velocity, &point.velocities, true)?;
        size(Quantity::Acceleration, &point.accelerations, true)?;
        if point.velocities.is_empty() != points[0].velocities.is_empty() {
            return Err(TrajectoryError::Mixed { point: index, quantity: Quantity::Velocity });
        }
        if point.accelerations.is_empty() != points[0].accelerations.is_empty()
            || (point.velocities.is_empty() && !point.accelerations.is_empty())
        {
            return Err(TrajectoryError::Mixed { point: index, quantity: Quantity::Acceleration });
        }
        let mut numbers = point.positions.iter().chain(&point.velocities).chain(&point.accelerations);
        if !numbers.all(|x| x.is_finite()) || !point.time_s.is_finite() || point.time_s < 0.0 {
            return Err(TrajectoryError::NotFinite { point: index });
        }
        if index > 0 && point.time_s <= points[index - 1].time_s {
            let (time_s, previous_s) = (point.time_s, points[index - 1].time_s);
            return Err(TrajectoryError::TimeNotIncreasing { point: index, time_s, previous_s });
        }
    }
    Ok(())
}

fn law_of(
    joint: usize,
    axis: Axis,
    points: &[TrajectoryPoint],
    start: &Start,
    tolerance: &StartTolerance,
    machine: &MachineDescription,
) -> Result<AxisLaw, TrajectoryError> {
    let from = Knot {
        at: 0.0,
        value: start.position[axis.index()],
        first: start.velocity[axis.index()],
        second: start.acceleration[axis.index()],
    };
    let scale = machine.axis(axis).scale;
    let of = |values: &Vec<f64>| values.get(joint).copied().unwrap_or(0.0);
    let mut knots: Vec<Knot> = Vec::with_capacity(points.len() + 2);
    let mut difference = 0.0;
    if points[0].time_s > 0.0 {
        knots.push(from);
    } else if scale.counts(points[0].positions[joint]) != scale.counts(from.value) {
        let (asked, actual, allowed) = (points[0].positions[joint], from.value, tolerance.0[axis.index()]);
        difference = actual - asked;
        if libm::fabs(difference) > allowed {
            return Err(TrajectoryError::StartsElsewhere { axis, asked, actual, allowed });
        }
    }
    knots.extend(points.iter().map(|point| Knot {
        at: point.time_s,
        value: of(&point.positions),
        first: of(&point.velocities),
        second: of(&point.accelerations),
    }));
    // From where the axis is, as it moves there, not from where it was believed to be; a difference is added afterwards.
    knots[0] = Knot { value: from.value - difference, ..from };
    let last = knots.len() - 1;
    #[allow(clippy::float_cmp, reason = "rest is exactly zero")]
    if knots[last].first != 0.0 {
        return Err(TrajectoryError::EndNotAtRest { axis, velocity: knots[last].first });
    }
    if points[0].velocities.is_empty() {
        fill_velocities(&mut knots);
    }
    if points[0].accelerations.is_empty() {
        fill_accelerations(&mut knots);
    }
    if last == 0 {
        // A single point at time 0, where the axis is already, or will soon be.
        let time_s = join::move_s(difference, &machine.axis(axis).limits).unwrap_or(join::MAX_JOIN_S);
        knots.push(Knot { at: time_s.max(machine.cycle_time_s()), ..knots[0] });
    }
    let law = HermiteSpline::new(knots).expect("points were validated: finite, times increase");
    Ok(AxisLaw { axis, law, difference })
}

fn fill_velocities(knots: &mut [Knot]) {
    for i in 1..knots.len().saturating_sub(1) {
        let (h0, h1) = (knots[i].at - knots[i - 1].at, knots[i + 1].at - knots[i].at);
        let d0 = (knots[i].value - knots[i - 1].value) / h0;
        let d1 = (knots[i + 1].value - knots[i].value) / h1;
        // Fritsch and Carlson: no more than three times the flatter neighbour, else the curve swings over.
        let most = 3.0 * libm::fabs(d0).min(libm::fabs(d1));
        knots[i].first = if d0 * d1 <= 0.0 { 0.0 } else { ((d0 * h1 + d1 * h0) / (h0 + h1)).clamp(-most, most) };
    }
}

fn fill_accelerations(knots: &mut [Knot]) {
    for i in 1..knots.len().saturating_sub(1) {
        let (left, mid, right) = (knots[i - 1], knots[i], knots[i + 1]);
        let (h0, h1) = (mid.at - left.at, right.at - mid.at);
        // Second derivatives of the cubics at the point they share.
        let before = (-6.0 * (mid.value - left.value) / h0 + 2.0 * left.first + 4.0 * mid.first) / h0;
        let after = (6.0 * (right.value - mid.value) / h1 - 4.0 * mid.first - 2.0 * right.first) / h1;
        knots[i].second = 0.5 * (before + after);
    }
}

/// Largest derivatives, or the limit that is exceeded most.
pub(super) fn check_limits(
    axis: Axis,
    law: &HermiteSpline,
    machine: &MachineDescription,
) -> Result<MotionLimits, TrajectoryError> {
    // Derivatives of a quintic have few extremes between knots; 32 points see them to a per mille.
    const POINTS: u32 = 32;
    let description = machine.axis(axis);
    let bounds = [description.limits.velocity, description.limits.acceleration, description.limits.jerk];
    let quantities = [Quantity::Velocity, Quantity::Acceleration, Quantity::Jerk];
    let mut peaks = [0.0_f64; 3];
    let mut worst: Option<(f64, TrajectoryError)> = None;
    let mut farthest: Option<(f64, TrajectoryError)> = None;
    for pair in law.knots().windows(2) {
        for i in 0..=POINTS {
            // Just inside: at a knot itself the third derivative has two values.
            let share = (f64::from(i) / f64::from(POINTS)).clamp(1e-9, 1.0 - 1e-9);
            let time_s = pair[0].at + (pair[1].at - pair[0].at) * share;
            let sample = law.sample(time_s);
            if let Some((low, high)) = description.soft_limits {
                let beyond = (low - sample.value).max(sample.value - high);
                if beyond > farthest.as_ref().map_or(0.0, |(most, _)| *most) {
                    let bound = if sample.value < low { low } else { high };
                    let (quantity, value) = (Quantity::Position, sample.value);
                    farthest = Some((beyond, TrajectoryError::Limit { axis, quantity, time_s, value, bound }));
                }
            }
            for (k, value) in [sample.first, sample.second, sample.third].into_iter().enumerate() {
                let (size, bound) = (libm::fabs(value), bounds[k]);
                peaks[k] = peaks[k].max(size);
                // A client computes with the same limits and other roundings: a millionth is not an excess.
                let excess = size / bound;
                if excess > 1.0 + 1e-6 && worst.as_ref().is_none_or(|(most, _)| excess > *most) {
                    let quantity = quantities[k];
                    worst = Some((excess, TrajectoryError::Limit { axis, quantity, time_s, value, bound }));
                }
            }
        }
    }
    match farthest.or(worst) {
        Some((_, error)) => Err(error),
        None => Ok(MotionLimits { velocity: peaks[0], acceleration: peaks[1], jerk: peaks[2] }),
    }
}
