// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Trajectories that begin beside the axis: joined within limits and a stated time, or refused.

use super::bench::machine;
use camwright::interpolator::join::{MAX_JOIN_S, StartTolerance};
use camwright::interpolator::trajectory::{Trajectory, TrajectoryError, TrajectoryPoint, TrajectoryStart};
use camwright::machine::description::Axis;
use camwright::machine::description::MachineDescription;

const TOLERANCE: [f64; 3] = [0.01, 0.5, 0.5];

/// A small generator, the same in every run.
struct WordGenerator(u64);

impl WordGenerator {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// Between two numbers.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.next() >> 11) as f64 / (1_u64 << 53) as f64)
    }

    fn count_near(&mut self, position: f64, tolerance: f64, machine: &MachineDescription, axis: Axis) -> f64 {
        let scale = machine.axis(axis).scale;
        scale.position(scale.counts(position + self.between(-0.999, 0.999) * tolerance))
    }
}

/// From rest to rest along a quintic in so many points, at a share of the limits; forms as ROS knows them.
fn travel(
    words: &mut WordGenerator,
    from: f64,
    axis: Axis,
    share: f64,
    machine: &MachineDescription,
) -> Vec<TrajectoryPoint> {
    let limits = machine.axis(axis).limits;
    let far = words.between(0.01, 1.0).powi(3) * if axis == Axis::C { 30.0 } else { 40.0 };
    let (v, a, j) = (limits.velocity * share, limits.acceleration * share, limits.jerk * share);
    let time_s = (1.875 * far / v).max((5.7736 * far / a).sqrt()).max((60.0 * far / j).cbrt());
    let points = 2 + words.next() % 30;
    (0..=points)
        .map(|i| {
            let u = i as f64 / points as f64;
            let value = from + far * (u * u * u * (10.0 - 15.0 * u + 6.0 * u * u));
            let first = far * 30.0 * u * u * (1.0 - u) * (1.0 - u) / time_s;
            let second = far * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (time_s * time_s);
            TrajectoryPoint {
                time_s: u * time_s,
                positions: vec![value],
                velocities: vec![first],
                accelerations: vec![second],
            }
        })
        .collect()
}

#[test]
fn a_start_anywhere_within_tolerance_is_joined_within_limits_and_time() {
    let machine = machine();
    let mut words = WordGenerator(0x1122_3344_5566_7788);
    let (mut beside, mut delayed, mut longest_s): (u32, u32, f64) = (0, 0, 0.0);
    for round in 0..3000 {
        let axis = Axis::ALL[(words.next() % 3) as usize];
        let share = [0.3, 0.8, 0.95, 1.0][round % 4];
        let asked = words.between(20.0, 60.0);
        let tolerance = TOLERANCE[axis.index()];
        let at = words.count_near(asked, tolerance, &machine, axis);
        let mut start = TrajectoryStart::at_rest([0.0, 50.0, 50.0]);
        start.position[axis.index()] = at;
        let points = travel(&mut words, asked, axis, share, &machine);
        let joined = Trajectory::joined(&[axis], &points, &start, &StartTolerance(TOLERANCE), &machine)
            .unwrap_or_else(|error| panic!("round {round}: {error}"));
        let law = joined.law(axis).expect("it moves");
        let first = law.sample(0.0);
        assert!((first.value - at).abs() < 1e-12 && first.first == 0.0 && first.second == 0.0, "round {round}");

        // Limits, by what the joined law does at 1 kHz and between.
        let limits = machine.axis(axis).limits;
        for i in 0..4000 {
            let sample = law.sample(law.end() * (f64::from(i) + 0.5) / 4000.0);
            for (value, bound) in
                [(sample.first, limits.velocity), (sample.second, limits.acceleration), (sample.third, limits.jerk)]
            {
                assert!(value.abs() <= bound * (1.0 + 1e-5), "round {round}: {value} of {bound}");
            }
        }
        // From the stated time on it is the client's path, at the client's times or that much later.
        let end_s = points[points.len() - 1].time_s;
        let late_s = law.end() - end_s;
        assert!((-1e-9..=MAX_JOIN_S).contains(&late_s), "round {round}: {late_s} s late");
        start.position[axis.index()] = asked;
        let mut exact = points.clone();
        let scale = machine.axis(axis).scale;
        start.position[axis.index()] = scale.position(scale.counts(asked));
        exact[0].positions[0] = start.position[axis.index()];
        let plain = Trajectory::from_points(&[axis], &exact, &start, &machine);
        if let Ok(plain) = plain {
            let plain = plain.law(axis).expect("it moves").clone();
            for i in 0..50 {
                let t = MAX_JOIN_S + (end_s - MAX_JOIN_S).max(0.0) * f64::from(i) / 49.0;
                // The exact one begins up to half a count beside.
                let differs = (law.sample(t + late_s).value - plain.sample(t).value).abs();
                assert!(differs < 1e-4, "round {round}: {differs} at {t} s");
            }
        }
        assert!((law.sample(law.end()).value - points[points.len() - 1].positions[0]).abs() < 1e-12);
        beside += u32::from(late_s < 1e-9);
        delayed += u32::from(late_s >= 1e-9);
        longest_s = longest_s.max(late_s);
    }
    let counts =
        format!("joined beside the path: {beside}, by a move of their own: {delayed}, at most {longest_s:.3} s late");
    assert!(beside > 500 && delayed > 100, "{counts}");
}

#[test]
fn a_start_beyond_tolerance_is_refused_with_joint_value_and_allowance() {
    let machine = machine();
    let points = |at: f64| {
        [(0.0, at), (2.0, 60.0)].map(|(time_s, x)| TrajectoryPoint {
            time_s,
            positions: vec![x],
            ..TrajectoryPoint::default()
        })
    };
    let start = TrajectoryStart::at_rest([0.0, 50.0, 50.0]);
    let tolerance = StartTolerance(TOLERANCE);
    let build =
        |at: f64, tolerance: &StartTolerance| Trajectory::joined(&[Axis::X], &points(at), &start, tolerance, &machine);
    let refused = build(50.75, &tolerance).expect_err("too far away");
    assert_eq!(refused, TrajectoryError::StartsElsewhere { axis: Axis::X, asked: 50.75, actual: 50.0, allowed: 0.5 });
    let text = refused.to_string();
    for part in ["x_axis", "50.75 mm", "50 mm", "0.5 mm", "start tolerance"] {
        assert!(text.contains(part), "{text}");
    }
    assert!(build(50.25, &tolerance).is_ok());
    assert!(build(50.25, &StartTolerance::default()).is_err(), "without a tolerance the count must be the same");
}

#[test]
fn two_axes_of_which_one_has_no_room_are_moved_to_their_first_points_together() {
    let machine = machine();
    let mut words = WordGenerator(7);
    let x = travel(&mut words, 50.0, Axis::X, 1.0, &machine);
    let points: Vec<TrajectoryPoint> = x
        .iter()
        .map(|point| TrajectoryPoint {
            time_s: point.time_s,
            positions: vec![point.positions[0], 50.0],
            velocities: vec![point.velocities[0], 0.0],
            accelerations: vec![point.accelerations[0], 0.0],
        })
        .collect();
    let start = TrajectoryStart::at_rest([0.0, 50.5, 50.0]);
    let joined = Trajectory::joined(&[Axis::X, Axis::Z], &points, &start, &StartTolerance(TOLERANCE), &machine)
        .expect("it is joined");
    let (x, z) = (joined.law(Axis::X).expect("X"), joined.law(Axis::Z).expect("Z"));
    assert!((x.end() - z.end()).abs() < 1e-12, "they end together");
    assert!((z.sample(0.1).value - 50.0).abs() < 1e-12);
}
