// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Work by hand: a jog ends where it was to, at its limit or where it was let go of; the wheel comes to its speed and to rest.

use super::setup::{cell, description, finish, run};
use camwright::interpolator::manual::{Jog, JogRequest};
use camwright::interpolator::setup::SetupError;
use camwright::interpolator::{Motion, MotionOutcome, MotionRequest, Prepared, StartError};
use camwright::machine::description::Axis;
use camwright::simulation::closed_loop::ClosedLoop;

const C: usize = Axis::C as usize;
const X: usize = Axis::X as usize;
const Z: usize = Axis::Z as usize;
const PER_MM: i64 = 100_000;

fn jog(cell: &ClosedLoop, axis: Axis, velocity: f64, distance: Option<f64>) -> Result<Jog, SetupError> {
    let (machine, from) = (cell.machine().description(), cell.machine().setpoint().counts);
    let knows_zero = cell.interpolator().is_homed(axis);
    Jog::new(&JogRequest { axis, velocity, distance }, from, knows_zero, machine)
}

fn start(cell: &mut ClosedLoop, jog: Jog) {
    let motion = Prepared::new(Motion::Jog(jog), cell.machine().description()).expect("it can be executed");
    cell.start(Box::new(motion)).expect("it starts");
}

/// Steps, and the fastest that the setpoint of an axis went, per second.
fn fastest(cell: &mut ClosedLoop, ticks: usize, axis: usize) -> f64 {
    let mut before = cell.machine().setpoint().counts[axis];
    let mut max = 0;
    for _ in 0..ticks {
        cell.step(&[]);
        let now = cell.machine().setpoint().counts[axis];
        max = max.max((now - before).abs());
        before = now;
    }
    let scale = cell.machine().description().axes[axis].scale;
    scale.position(max) / cell.machine().description().cycle_time_s()
}

#[test]
fn a_jog_by_a_distance_ends_on_its_count_at_its_speed() {
    let mut cell = cell(&description());
    let by = jog(&cell, Axis::Z, 12.5, Some(-7.25)).expect("within travel");
    let from = cell.machine().setpoint().counts;
    start(&mut cell, by);
    let speed = fastest(&mut cell, 400, Z);
    assert!((speed - 12.5).abs() < 0.2, "{speed} mm/s");
    assert_eq!(finish(&mut cell), MotionOutcome::Completed);
    assert_eq!(cell.machine().setpoint().counts, [from[C], from[X], from[Z] - 72_500]);
}

#[test]
fn a_jog_that_is_held_goes_on_to_its_soft_limit_and_no_farther() {
    let mut cell = cell(&description());
    let (low, high) = description().axis(Axis::Z).soft_limits.expect("z_axis has limits");
    for (velocity, bound) in [(200.0, high), (-150.0, low)] {
        let along = jog(&cell, Axis::Z, velocity, None).expect("there is a way");
        assert_eq!(run(&mut cell, Motion::Jog(along)), Ok(MotionOutcome::Completed));
        assert_eq!(cell.machine().setpoint().counts[Z], description().axis(Axis::Z).scale.counts(bound));
        assert_eq!(jog(&cell, Axis::Z, velocity, None), Err(SetupError::NoWay(Axis::Z)));
    }
}

#[test]
fn a_jog_that_is_let_go_of_comes_to_rest_within_the_limits_of_its_axis() {
    let mut cell = cell(&description());
    let limits = description().axis(Axis::X).limits;
    let along = jog(&cell, Axis::X, 300.0, None).expect("there is a way");
    start(&mut cell, along);
    let ticks = 250;
    let mut positions = Vec::new();
    for tick in 0..2000 {
        if tick == ticks {
            cell.request(MotionRequest::Cancel);
        }
        cell.step(&[]);
        positions.push(cell.machine().setpoint().counts[X]);
    }
    assert_eq!(cell.outcome(), Some(MotionOutcome::Cancelled));
    assert!(cell.machine().is_at_rest() && cell.machine().alarms().is_empty());
    // Differences of whole counts: of velocity 1 count/ms is 0.01 mm/s per ms, of acceleration twice that.
    let velocity: Vec<i64> = positions.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let hardest = velocity.windows(2).map(|pair| (pair[1] - pair[0]).abs()).max().expect("many");
    let bound = limits.acceleration * 1e-6 * 1e5 + 2.0;
    assert!((hardest as f64) <= bound, "{hardest} counts/ms^2, {bound} are allowed");
    // From 300 mm/s: v²/2a and what the jerk adds, v a / 2j, at nine tenths of both limits.
    let (v, a, j) = (300.0, 0.9 * limits.acceleration, 0.9 * limits.jerk);
    let top = velocity.iter().max().expect("many");
    let begun = velocity.iter().rposition(|v| v == top).expect("it is there");
    let way_mm = (positions[positions.len() - 1] - positions[begun]) as f64 / PER_MM as f64;
    let min_mm = v * v / (2.0 * a) + v * a / (2.0 * j);
    assert!(way_mm > 0.8 * min_mm && way_mm < 1.5 * min_mm, "{way_mm} mm, the least is {min_mm} mm");
}

#[test]
fn c_axis_turns_until_it_is_let_go_of() {
    let mut cell = cell(&description());
    let turning = jog(&cell, Axis::C, -6.0, None).expect("there is no limit");
    start(&mut cell, turning);
    let speed = fastest(&mut cell, 60_000, C);
    assert!((speed - 6.0).abs() < 0.01, "{speed} rad/s");
    assert!(cell.is_running());
    cell.request(MotionRequest::Cancel);
    assert_eq!(finish(&mut cell), MotionOutcome::Cancelled);
    let turned = description().axis(Axis::C).scale.position(cell.machine().setpoint().counts[C]);
    assert!((turned + 360.0).abs() < 5.0, "a minute at 6 rad/s: {turned} rad");
}

#[test]
fn an_axis_without_a_zero_goes_slowly_and_beyond_what_would_be_its_limit() {
    let mut cell = cell(&description());
    let machine = description();
    let slow = machine.axis(Axis::Z).search_velocity;
    cell.parts_mut().0.set_homed(Axis::Z, false);
    match jog(&cell, Axis::Z, 1.01 * slow, Some(1.0)) {
        Err(SetupError::Lost { max, .. }) => assert_eq!(max.to_bits(), slow.to_bits()),
        other => panic!("{other:?}"),
    }
    let by = jog(&cell, Axis::Z, slow, Some(3.0)).expect("slow enough");
    let from = cell.machine().setpoint().counts[Z];
    assert_eq!(run(&mut cell, Motion::Jog(by)), Ok(MotionOutcome::Completed), "{:?}", cell.machine().alarms());
    assert_eq!(cell.machine().setpoint().counts[Z], from + 30_000);
    // Judged with a zero, it does not start without.
    cell.parts_mut().0.set_homed(Axis::Z, true);
    let by = jog(&cell, Axis::Z, 50.0, Some(1.0)).expect("it knows its zero");
    cell.parts_mut().0.set_homed(Axis::Z, false);
    assert_eq!(run(&mut cell, Motion::Jog(by)), Err(StartError::NotHomed(Axis::Z)));
}

#[test]
fn jogs_that_cannot_be_are_refused_with_what_is_allowed() {
    let cell = cell(&description());
    for (velocity, distance, words) in [
        (600.0, None, "x_axis cannot move at 600.000 mm/s; the speed must be above 0 and at most 500.000 mm/s"),
        (0.0, Some(1.0), "x_axis cannot move at 0.000 mm/s"),
        (f64::NAN, Some(1.0), "x_axis cannot move at NaN mm/s"),
        (10.0, Some(f64::INFINITY), "the distance of x_axis is not a number"),
        (10.0, Some(0.0), "x_axis is already at or beyond the target"),
        (10.0, Some(-60.0), "the target of x_axis is -20.0000 mm, the soft limit is "),
    ] {
        let refused = jog(&cell, Axis::X, velocity, distance).expect_err("it cannot be");
        assert!(refused.to_string().starts_with(words), "{refused}");
    }
}

#[test]
fn the_wheel_comes_to_its_speed_and_to_rest_while_the_axes_stand() {
    let mut cell = cell(&description());
    let at = cell.machine().setpoint().counts;
    for turns in [true, false] {
        assert_eq!(run(&mut cell, Motion::Wheel(turns)), Ok(MotionOutcome::Completed), "{:?}", cell.machine().alarms());
        assert_eq!(cell.step(&[]).io.wheel_running, turns);
        assert_eq!(cell.machine().setpoint().counts, at);
    }
}
