// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Trajectories of ROS clients.

use super::bench::{Bench, PER_MM, machine};
use camwright::interpolator::quantity::MotionQuantity;
use camwright::interpolator::trajectory::{Trajectory, TrajectoryError, TrajectoryPoint, TrajectoryStart};
use camwright::interpolator::{ExecutionState, Motion, MotionOutcome, MotionRequest, Prepared, StartError};
use camwright::machine::description::Axis;

fn point(time_s: f64, positions: &[f64], velocities: &[f64], accelerations: &[f64]) -> TrajectoryPoint {
    TrajectoryPoint {
        time_s,
        positions: positions.to_vec(),
        velocities: velocities.to_vec(),
        accelerations: accelerations.to_vec(),
    }
}

/// s(t) = 10 − 10 cos(πt/2) on X over 2 s, sampled ten times, in the three forms that ROS knows.
fn cosine(form: usize) -> Vec<TrajectoryPoint> {
    let w = std::f64::consts::FRAC_PI_2;
    (0..=20)
        .map(|i| {
            let t = 0.1 * f64::from(i);
            let (v, a) = (10.0 * w * (w * t).sin(), 10.0 * w * w * (w * t).cos());
            let v = if i % 20 == 0 { 0.0 } else { v };
            let (velocities, accelerations): (&[f64], &[f64]) = match form {
                0 => (&[], &[]),
                1 => (&[v], &[]),
                _ => (&[v], &[a]),
            };
            point(t, &[10.0 - 10.0 * (w * t).cos()], velocities, accelerations)
        })
        .collect()
}

#[test]
fn points_are_met_at_their_times_and_the_curve_between_is_that_of_the_motion() {
    let machine = machine();
    for (form, tolerance) in [(0, 0.05), (1, 0.01), (2, 0.05)] {
        let points = cosine(form);
        let trajectory =
            Trajectory::from_points(&[Axis::X], &points, &TrajectoryStart::default(), &machine).expect("within limits");
        let law = trajectory.law(Axis::X).expect("X moves");
        for point in &points {
            assert!((law.sample(point.time_s).value - point.positions[0]).abs() < 1e-12);
        }
        for i in 0..200 {
            let t = 0.01 * f64::from(i);
            let exact = 10.0 - 10.0 * (std::f64::consts::FRAC_PI_2 * t).cos();
            assert!((law.sample(t).value - exact).abs() < tolerance, "form {form} at {t}");
        }
    }
}

#[test]
fn a_trajectory_moves_its_joints_and_holds_the_others() {
    let machine = machine();
    let trajectory =
        Trajectory::from_points(&[Axis::X], &cosine(0), &TrajectoryStart::default(), &machine).expect("within limits");
    let mut bench = Bench::at(machine.clone(), [11, 0, 22]);
    bench.start(Motion::from(trajectory.clone()));
    assert_eq!(bench.finish(3000), MotionOutcome::Completed);
    assert_eq!(bench.counts(), [11, 20 * PER_MM, 22]);
    assert_eq!(bench.rows.len(), 2001);
    bench.assert_limits("trajectory");
    // Again: it begins elsewhere now.
    let again = Prepared::new(Motion::from(trajectory), &machine).expect("good");
    let (error, _) = bench.interpolator.start(Box::new(again)).expect_err("elsewhere");
    assert_eq!(error, StartError::StartsElsewhere { axis: Axis::X, wanted: 0, actual: 20 * PER_MM });
}

#[test]
fn a_held_trajectory_stops_on_its_path_and_ends_where_it_should() {
    let machine = machine();
    let trajectory =
        Trajectory::from_points(&[Axis::X], &cosine(2), &TrajectoryStart::default(), &machine).expect("within limits");
    for at in [1, 400, 1000, 1990] {
        let mut bench = Bench::new(machine.clone());
        bench.start(Motion::from(trajectory.clone()));
        for _ in 0..at {
            bench.step(&[]);
        }
        bench.step(&[MotionRequest::Hold]);
        for _ in 0..800 {
            bench.step(&[]);
        }
        assert!(at == 1990 || bench.last().status.state == ExecutionState::Held, "{:?}", bench.last());
        bench.assert_at_rest("held");
        if bench.outcome.is_none() {
            bench.step(&[MotionRequest::Unhold]);
            assert_eq!(bench.finish(5000), MotionOutcome::Completed);
        }
        assert_eq!(bench.counts()[1], 20 * PER_MM);
        bench.assert_limits("held trajectory");
        let mut bench = Bench::new(machine.clone());
        bench.start(Motion::from(trajectory.clone()));
        for _ in 0..at {
            bench.step(&[]);
        }
        bench.step(&[MotionRequest::Cancel]);
        bench.finish(3000);
        bench.assert_limits("cancelled trajectory");
        bench.assert_at_rest("cancelled trajectory");
    }
}

#[test]
fn what_exceeds_a_limit_is_refused_with_joint_time_and_amount() {
    let machine = machine();
    let refuse = |points: &[TrajectoryPoint]| {
        Trajectory::from_points(&[Axis::X], points, &TrajectoryStart::default(), &machine).expect_err("beyond a limit")
    };
    // 100 mm in 0.1 s: quintic rest to rest peaks at 1.875 times the mean velocity and 5.77 d / T².
    let error = refuse(&[point(0.1, &[100.0], &[], &[])]);
    let TrajectoryError::Limit { axis: Axis::X, quantity, value, bound, .. } = error.clone() else { panic!("{error}") };
    assert_eq!(quantity, MotionQuantity::Jerk);
    assert!((value.abs() - 60.0 * 100.0 / 1e-3).abs() < 1.0 && bound == 1e6, "{value} {bound}");
    let error = refuse(&[point(1.0, &[300.0], &[], &[])]);
    assert_eq!(
        error.to_string(),
        "joint x_axis at 1.000 s: position 300.0000 mm, the machine allows 200 mm".replace("1.000", &when(&error))
    );
    let error = refuse(&[point(2.0, &[10.0], &[3.0], &[])]);
    assert_eq!(error, TrajectoryError::EndNotAtRest { axis: Axis::X, velocity: 3.0 });
}

fn when(error: &TrajectoryError) -> String {
    match error {
        TrajectoryError::Limit { time_s, .. } => format!("{time_s:.3}"),
        _ => String::new(),
    }
}

#[test]
fn points_that_are_no_trajectory_are_refused() {
    let machine = machine();
    let build = |joints: &[Axis], points: &[TrajectoryPoint]| {
        Trajectory::from_points(joints, points, &TrajectoryStart::default(), &machine)
    };
    assert!(matches!(build(&[], &[]), Err(TrajectoryError::Empty { .. })));
    assert!(matches!(build(&[Axis::X], &[]), Err(TrajectoryError::Empty { joints: 1, points: 0 })));
    let p = |t, x| point(t, &[x], &[], &[]);
    assert!(matches!(
        build(&[Axis::X], &[p(1.0, 1.0), p(1.0, 2.0)]),
        Err(TrajectoryError::TimeNotIncreasing { point: 1, .. })
    ));
    assert!(matches!(build(&[Axis::X, Axis::Z], &[p(1.0, 1.0)]), Err(TrajectoryError::Size { point: 0, .. })));
    assert!(matches!(build(&[Axis::X], &[p(f64::NAN, 1.0)]), Err(TrajectoryError::NotFinite { point: 0 })));
    assert!(matches!(
        build(&[Axis::X], &[p(1.0, 1.0), point(2.0, &[2.0], &[0.0], &[])]),
        Err(TrajectoryError::Mixed { point: 1, quantity: MotionQuantity::Velocity })
    ));
    assert!(matches!(
        build(&[Axis::X, Axis::X], &[point(1.0, &[1.0, 1.0], &[], &[])]),
        Err(TrajectoryError::JointTwice { axis: Axis::X })
    ));
    assert!(matches!(
        build(&[Axis::X], &[p(0.0, 1.0), p(1.0, 2.0)]),
        Err(TrajectoryError::StartsElsewhere { axis: Axis::X, .. })
    ));
    // A single point at time 0, where the axis is: nothing to do, and that is done.
    let trivial = build(&[Axis::X], &[p(0.0, 0.0)]).expect("nothing to do");
    let mut bench = Bench::new(machine.clone());
    bench.start(Motion::from(trivial));
    assert_eq!(bench.finish(10), MotionOutcome::Completed);
}
