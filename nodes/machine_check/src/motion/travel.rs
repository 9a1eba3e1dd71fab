// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Path of the tested axis: one polynomial from rest to rest. Every stop on it is the rest of the path itself, and the polynomial
//! alone gives the expected interpolation of its points.

use super::super::observed::DescriptionFacts;
use camwright_msgs::builtin_interfaces::msg::{Duration, Time};
use camwright_msgs::camwright_msgs::msg::AxisDescription;
use camwright_msgs::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};

/// Share of what the axis may do that is used.
const SHARE: f64 = 0.5;
/// A travel takes so many feedback delays at least: there must be time to do something on the way.
const DELAYS: u64 = 6;

/// A straight travel of one axis, from rest to rest; the others stand.
#[derive(Debug, Clone)]
pub(super) struct TestTravel {
    /// The axis that moves.
    pub(super) axis: usize,
    from: Vec<i64>,
    by: i64,
    /// Ticks that it takes.
    pub(super) ticks: u64,
    cycle_s: f64,
    per_unit: Vec<f64>,
}

/// A point: positions of all axes (counts), velocity and acceleration of the one that moves (m, rad, s).
#[derive(Debug, Clone)]
pub(super) struct TravelPoint {
    pub(super) counts: Vec<i64>,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
}

#[allow(clippy::cast_possible_truncation, reason = "as above")]
impl TestTravel {
    /// From where the axes rest, by so many counts, within the limits of the axis.
    pub(super) fn new(facts: &DescriptionFacts, axis: usize, limits: &AxisDescription, from: &[i64], by: i64) -> Self {
        let distance = by.unsigned_abs() as f64 / facts.per_unit[axis];
        // The extremes of s = 10 u^3 - 15 u^4 + 6 u^5 are 15/8, 10/sqrt 3 and 60.
        let by_velocity = 1.875 * distance / (SHARE * limits.max_velocity);
        let by_acceleration = (10.0 / 3.0_f64.sqrt() * distance / (SHARE * limits.max_acceleration)).sqrt();
        let by_jerk = (60.0 * distance / (SHARE * limits.max_jerk)).cbrt();
        let seconds = by_velocity.max(by_acceleration).max(by_jerk);
        let ticks = (seconds / facts.cycle_s()).ceil() as u64;
        let ticks = ticks.max(DELAYS * facts.delay);
        Self { axis, from: from.to_vec(), by, ticks, cycle_s: facts.cycle_s(), per_unit: facts.per_unit.clone() }
    }

    /// The point of the tick `k`; rest before the first and after the last.
    pub(super) fn point(&self, k: u64) -> TravelPoint {
        let u = k.min(self.ticks) as f64 / self.ticks as f64;
        let seconds = self.ticks as f64 * self.cycle_s;
        let distance = self.by as f64 / self.per_unit[self.axis];
        let along = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        let slope = 30.0 * u * u * (1.0 - u) * (1.0 - u);
        let bend = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u);
        let mut counts = self.from.clone();
        counts[self.axis] += (self.by as f64 * along).round() as i64;
        TravelPoint {
            counts,
            velocity: distance * slope / seconds,
            acceleration: distance * bend / (seconds * seconds),
        }
    }

    /// End position (counts).
    pub(super) fn end(&self) -> Vec<i64> {
        self.point(self.ticks).counts
    }

    /// A point as a message has it.
    fn message(&self, point: &TravelPoint, ticks: u64, facts: &DescriptionFacts) -> JointTrajectoryPoint {
        let only = |value: f64| (0..self.from.len()).map(|axis| if axis == self.axis { value } else { 0.0 }).collect();
        let positions = point.counts.iter().zip(&self.per_unit).map(|(counts, scale)| *counts as f64 / scale).collect();
        let ns = i64::try_from(ticks).unwrap_or(i64::MAX).saturating_mul(facts.cycle_ns);
        let Time { sec, nanosec } = stamp(ns);
        JointTrajectoryPoint {
            positions,
            velocities: only(point.velocity),
            accelerations: only(point.acceleration),
            effort: Vec::new(),
            time_from_start: Duration { sec, nanosec },
        }
    }

    /// A chunk that begins at a tick: points with their ticks after it.
    pub(super) fn chunk(
        &self,
        facts: &DescriptionFacts,
        epoch_ns: i64,
        first_tick: u64,
        points: &[(u64, TravelPoint)],
    ) -> JointTrajectory {
        let points = points.iter().map(|(after, point)| self.message(point, *after, facts)).collect();
        let mut chunk = JointTrajectory { joint_names: facts.joints.clone(), points, ..JointTrajectory::default() };
        let ticks = i64::try_from(first_tick).unwrap_or(i64::MAX);
        chunk.header.stamp = stamp(epoch_ns.saturating_add(ticks.saturating_mul(facts.cycle_ns)));
        chunk
    }
}

pub(super) fn stamp(ns: i64) -> Time {
    let (sec, nanosec) = (ns.div_euclid(1_000_000_000), ns.rem_euclid(1_000_000_000));
    Time { sec: i32::try_from(sec).unwrap_or(i32::MAX), nanosec: u32::try_from(nanosec).unwrap_or(0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// It keeps the limits that it was made for, begins and ends at rest, and its points lie on its own slope.
    #[test]
    fn a_travel_is_within_the_limits_of_its_axis() {
        let facts = DescriptionFacts {
            cycle_ns: 1_000_000,
            delay: 10,
            period: 1,
            rest_period: 5,
            joints: vec!["c_axis".into(), "z_axis".into()],
            per_unit: vec![1e6, 1e8],
        };
        let limits =
            AxisDescription { max_velocity: 0.2, max_acceleration: 2.0, max_jerk: 50.0, ..AxisDescription::default() };
        let travel = TestTravel::new(&facts, 1, &limits, &[7, -300], 5_000_000);
        let points: Vec<TravelPoint> = (0..=travel.ticks).map(|k| travel.point(k)).collect();
        assert_eq!(points[0].counts, [7, -300]);
        assert_eq!(travel.end(), [7, 4_999_700]);
        let largest = |of: fn(&TravelPoint) -> f64| points.iter().map(|point| of(point).abs()).fold(0.0, f64::max);
        assert!(largest(|point| point.velocity) <= 0.1 && largest(|point| point.acceleration) <= 1.0);
        for pair in points.windows(2) {
            let moved = (pair[1].counts[1] - pair[0].counts[1]) as f64 / 1e8;
            let meant = 0.5 * (pair[0].velocity + pair[1].velocity) * 1e-3;
            assert!((moved - meant).abs() < 2.0e-8, "{moved} m in a tick, the velocities say {meant}");
        }
        let last = points.last().unwrap();
        assert!(last.velocity == 0.0 && last.acceleration.abs() == 0.0);
    }
}
