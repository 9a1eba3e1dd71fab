// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Trajectories of ROS clients: from points to splines, and the tolerances of following them.
//!
//! ROS reads points with positions alone as straight pieces, with velocities as cubics, with accelerations as
//! quintics. A straight piece steps in velocity at every point and a cubic in acceleration; a machine with limits can
//! follow neither. So what a point does not say is filled in from its neighbours, every point is met at its time, and
//! what then exceeds a limit is refused by name instead of being smoothed away.

use super::join::{self, AxisLaw, StartTolerance};
use super::quantity::MotionQuantity;
use super::tolerance::FollowingTolerances;
pub use super::trajectory_limits::TrajectoryError;
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription, MotionLimits};
use crate::math::hermite::{HermiteSpline, Knot};
use alloc::vec::Vec;

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

/// Start of a trajectory: position (mm or rad) and its derivatives by the time of the trajectory, one per axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TrajectoryStart {
    pub position: [f64; AXIS_COUNT],
    /// mm/s or rad/s.
    pub velocity: [f64; AXIS_COUNT],
    /// mm/s² or rad/s².
    pub acceleration: [f64; AXIS_COUNT],
}

impl TrajectoryStart {
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
    start: TrajectoryStart,
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
        start: &TrajectoryStart,
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
        start: &TrajectoryStart,
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

    /// Tolerances for following it.
    #[must_use]
    pub fn tolerances(&self) -> &FollowingTolerances {
        &self.tolerances
    }

    #[must_use]
    pub fn start(&self) -> &TrajectoryStart {
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
        size(MotionQuantity::Position, &point.positions, false)?;
        size(MotionQuantity::Velocity, &point.velocities, true)?;
        size(MotionQuantity::Acceleration, &point.accelerations, true)?;
        if point.velocities.is_empty() != points[0].velocities.is_empty() {
            return Err(TrajectoryError::Mixed { point: index, quantity: MotionQuantity::Velocity });
        }
        if point.accelerations.is_empty() != points[0].accelerations.is_empty()
            || (point.velocities.is_empty() && !point.accelerations.is_empty())
        {
            return Err(TrajectoryError::Mixed { point: index, quantity: MotionQuantity::Acceleration });
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
    start: &TrajectoryStart,
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
        let max = 3.0 * libm::fabs(d0).min(libm::fabs(d1));
        knots[i].first = if d0 * d1 <= 0.0 { 0.0 } else { ((d0 * h1 + d1 * h0) / (h0 + h1)).clamp(-max, max) };
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
