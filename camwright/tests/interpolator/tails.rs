// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The stop at the end of every chunk.

use super::bench::{Bench, PER_MM, START_RAD, TURN, machine, two_cuts, whole_job};
use camwright::interpolator::MotionRequest;
use camwright::job::grinding::SpeedLaw;
use camwright::machine::description::{AXIS_COUNT, Axis};
use camwright::machine::setpoint::StopPoint;
use camwright::math::hermite::{HermiteSpline, Knot};
use camwright::math::units::TURN_RAD;

/// The tail as a machine executes it: quintics through its points, beginning at the last setpoint.
fn splines(bench: &Bench, tail: &[StopPoint]) -> [HermiteSpline; AXIS_COUNT] {
    let dt = bench.machine.cycle_time_s();
    let last = bench.last().setpoint;
    std::array::from_fn(|i| {
        let mut knots = vec![Knot {
            at: 0.0,
            value: bench.machine.axes[i].scale.position(last.counts[i]),
            first: last.velocity[i],
            second: last.acceleration[i],
        }];
        knots.extend(tail.iter().map(|point| Knot {
            at: f64::from(point.ticks) * dt,
            value: point.position[i],
            first: point.velocity[i],
            second: point.acceleration[i],
        }));
        HermiteSpline::new(knots).expect("ticks increase")
    })
}

fn assert_tail(bench: &Bench, what: &str) -> Vec<StopPoint> {
    let mut room = [StopPoint::default(); 32];
    let count = bench.interpolator.stop_tail(&mut room);
    let tail = &room[..count];
    let last = bench.last().setpoint;
    if count == 0 {
        assert!(last.velocity.iter().all(|v| *v == 0.0), "{what}: no tail although it moves");
        return Vec::new();
    }
    assert!(tail[0].ticks >= 2, "{what}");
    assert!(tail.windows(2).all(|pair| pair[1].ticks > pair[0].ticks), "{what}");
    let end = tail[count - 1];
    assert!(end.velocity.iter().chain(&end.acceleration).all(|x| *x == 0.0), "{what}: {end:?}");
    let dt = bench.machine.cycle_time_s();
    for (axis, spline) in Axis::ALL.into_iter().zip(splines(bench, tail)) {
        let limits = bench.machine.axis(axis).limits;
        let count = 1.0 / bench.machine.axis(axis).scale.counts_per_unit();
        let first = f64::from(tail[0].ticks) * dt;
        let length = spline.end();
        for i in 0..=2000 {
            let at = length * f64::from(i) / 2000.0;
            let sample = spline.sample(at);
            // Half a count between the rounded last setpoint and the tail costs 5.8 / h² of acceleration, 60 / h³ of
            // jerk, over the first points.
            let (da, dv) =
                if at <= first { (0.5 * count * 5.8 / (first * first), 0.5 * count * 2.0 / first) } else { (0.0, 0.0) };
            assert!(sample.first.abs() <= limits.velocity * 1.001 + dv, "{what} {axis:?} {at}: v {}", sample.first);
            // Corners of jerk between sparse points make a quintic swing by a few per cent.
            assert!(
                sample.second.abs() <= limits.acceleration * 1.03 + da,
                "{what} {axis:?} {at} of {length}: a {} ({tail:?})",
                sample.second
            );
        }
    }
    tail.to_vec()
}

/// All axes stop together along a spiral.
#[test]
fn the_stop_after_any_tick_of_a_spiral_stays_on_it() {
    let machine = machine();
    let mut bench = Bench::at(machine.clone(), super::spirals::start());
    bench.start_plan(super::spirals::plan(&machine));
    while bench.outcome.is_none() {
        let at = bench.rows.len();
        bench.step(&[]);
        if at.is_multiple_of(37) {
            let tail = assert_tail(&bench, &format!("after {at} ticks, {:?}", bench.last().status));
            for point in tail.iter().filter(|_| bench.last().status.turns > 0.0) {
                let [c, x, z] = point.position;
                assert!((x - super::spirals::x_mm(c).value).abs() < 1e-6, "{at}: {point:?}");
                assert!((z - super::spirals::z_mm(c)).abs() < 1e-9, "{at}: {point:?}");
            }
        }
    }
}

/// C that turns on between two cuts stops with whatever else moves.
#[test]
fn the_stop_after_any_tick_stops_c_that_turns_on_too() {
    let (plan, start) = two_cuts(&machine(), SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: 6.0 });
    let mut bench = Bench::at(machine(), start);
    bench.start_plan(plan);
    while bench.outcome.is_none() {
        let at = bench.rows.len();
        bench.step(&[]);
        if at.is_multiple_of(17) {
            assert_tail(&bench, &format!("after {at} ticks, {:?}", bench.last().status));
        }
    }
}

#[test]
fn the_stop_after_any_tick_continues_the_setpoint_within_limits_and_ends_at_rest() {
    let machine = machine();
    let plan = whole_job(&machine, 6.0);
    let mut bench = Bench::new(machine.clone());
    bench.start_plan(plan);
    while bench.outcome.is_none() {
        let at = bench.rows.len();
        let requests: &[MotionRequest] = match at {
            5200 => &[MotionRequest::Hold],
            6900 => &[MotionRequest::Unhold],
            7900 => &[MotionRequest::SetOverride(0.3)],
            8400 => &[MotionRequest::SetOverride(1.0)],
            _ => &[],
        };
        bench.step(requests);
        if at.is_multiple_of(17) {
            assert_tail(&bench, &format!("after {at} ticks, {:?}", bench.last().status));
        }
    }
}

/// Silence is a stop on the path: in the cut every point of the tail lies on it.
#[test]
fn the_stop_in_the_cut_stays_on_the_path() {
    let machine = machine();
    let (plan, start) = super::bench::cut_only(&machine, 4.2, 6.0);
    let mut bench = Bench::at(machine.clone(), start);
    bench.start_plan(plan.clone());
    while bench.outcome.is_none() {
        bench.step(&[]);
        for point in assert_tail(&bench, "cut") {
            let c = point.position[0];
            let x = plan.paths[0].sample(START_RAD + c).value + plan.angle_laws[0].sample(c).value;
            assert!((point.position[1] - x).abs() < 1e-9, "{point:?} {x}");
        }
    }
}

/// A machine that ran out a tail rests where the tail said; after a resync the interpolator starts from there.
#[test]
fn after_an_underrun_the_machine_is_believed() {
    let machine = machine();
    let (plan, start) = super::bench::cut_only(&machine, 4.2, 6.0);
    let mut bench = Bench::at(machine.clone(), start);
    bench.start_plan(plan);
    for _ in 0..900 {
        bench.step(&[]);
    }
    let tail = assert_tail(&bench, "underrun");
    let end = tail.last().expect("it moves");
    let counts = std::array::from_fn(|i| machine.axes[i].scale.counts(end.position[i]));
    bench.interpolator.resync(counts);
    assert!(bench.interpolator.is_idle() && bench.interpolator.take_finished().is_some());
    bench.step(&[]);
    assert_eq!(bench.counts(), counts);
    assert!(counts[0] > 0 && counts[0] < 4 * TURN && counts[1] > 20 * PER_MM);
    assert!((end.position[0] - counts[0] as f64 / TURN as f64 * TURN_RAD).abs() < 1e-6);
}
