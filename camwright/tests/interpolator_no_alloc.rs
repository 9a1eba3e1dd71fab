// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The cyclic path does not allocate: a whole job with a hold, an override and a cancel under an allocator that aborts.

#[path = "interpolator/bench.rs"]
#[allow(dead_code, clippy::cast_possible_truncation, clippy::float_cmp, reason = "shared with the other tests")]
mod bench;

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use bench::{ORIGIN, SWITCH, machine, two_cuts, whole_job};
use camwright::interpolator::tolerance::{FollowingTolerances, Tolerance};
use camwright::interpolator::trajectory::{Trajectory, TrajectoryPoint, TrajectoryStart};
use camwright::interpolator::{
    Interpolator, InterpolatorEvent, Motion, MotionOutcome, MotionRequest, Prepared, StateForecast, TickInputs,
};
use camwright::job::grinding::SpeedLaw;
use camwright::machine::description::Axis;
use camwright::machine::setpoint::{Input, Latch, Measured, StopPoint};
use std::sync::Arc;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

#[test]
fn neither_a_step_nor_a_stop_nor_feedback_allocates() {
    let machine = machine();
    let whole = (whole_job(&machine, 6.0), [0; 3], false);
    let (turning_on, start) = two_cuts(&machine, SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: 6.0 });
    for ((plan, start, homed), cancel_at) in
        [(whole.clone(), 0), (whole, 5_500), ((turning_on.clone(), start, true), 0), ((turning_on, start, true), 5_500)]
    {
        let prepared = Box::new(Prepared::new(Motion::Plan(Arc::new(plan)), &machine).expect("good plan"));
        let mut interpolator = Interpolator::new(&machine);
        interpolator.resync(start);
        interpolator.set_homed(Axis::C, homed);
        let mut tail = [StopPoint::default(); 32];
        let outcome = assert_no_alloc(|| {
            if interpolator.start(prepared).is_err() {
                return None;
            }
            let mut before = start;
            for tick in 0..40_000_u64 {
                let requests: &[MotionRequest] = match tick {
                    300 | 5_000 => &[MotionRequest::Hold],
                    600 | 6_200 => &[MotionRequest::Unhold],
                    5_100 => &[MotionRequest::SetOverride(0.5)],
                    _ if tick == cancel_at && tick > 0 => &[MotionRequest::Cancel],
                    _ => &[],
                };
                let out = interpolator.step(&TickInputs { tick, requests });
                interpolator.stop_tail(&mut tail);
                let now = out.setpoint.counts;
                let edge = |axis: Axis, at: i64| before[axis.index()] < at && now[axis.index()] >= at;
                if edge(Axis::C, ORIGIN) {
                    let (input, axis) = (Input::Origin, Axis::C);
                    interpolator.feedback(&Latch { tick, input, rising: true, axis, counts: ORIGIN });
                }
                if edge(Axis::Z, SWITCH) {
                    let (input, axis) = (Input::Station(0), Axis::Z);
                    interpolator.feedback(&Latch { tick, input, rising: true, axis, counts: SWITCH });
                }
                before = now;
                for event in out.events.iter() {
                    if let InterpolatorEvent::Finished(outcome) = event {
                        return Some(*outcome);
                    }
                }
            }
            None
        });
        let expected = if cancel_at > 0 { MotionOutcome::Cancelled } else { MotionOutcome::Completed };
        assert_eq!(outcome, Some(expected));
    }
}

#[test]
fn neither_following_a_trajectory_nor_putting_another_in_its_place_allocates() {
    let machine = machine();
    let kept = [Tolerance { position: Some(0.5), velocity: Some(1.0), acceleration: None }; 3];
    let tolerances = FollowingTolerances { path: kept, goal: kept, goal_time_ticks: Some(100) };
    let to = |x_mm: f64, start: &TrajectoryStart| {
        let points = [TrajectoryPoint { time_s: 1.0, positions: vec![x_mm], ..TrajectoryPoint::default() }];
        let trajectory = Trajectory::from_points(&[Axis::X], &points, start, &machine).expect("within limits");
        let motion = Motion::from(trajectory.with_tolerances(tolerances));
        Box::new(Prepared::new(motion, &machine).expect("good"))
    };
    // A rehearsal of the same ticks gives the position at tick 400.
    let mut rehearsed = Interpolator::new(&machine);
    rehearsed.start(to(20.0, &TrajectoryStart::default())).expect("idle");
    for tick in 0..300 {
        rehearsed.step(&TickInputs { tick, requests: &[] });
    }
    let first = to(20.0, &TrajectoryStart::default());
    let StateForecast::At(there) = rehearsed.foresee(400) else { panic!("it moves") };
    let second = to(5.0, &there);
    let mut interpolator = Interpolator::new(&machine);
    interpolator.start(first).expect("idle");
    let mut tail = [StopPoint::default(); 32];
    let (outcome, _first, _spliced) = assert_no_alloc(|| {
        let (mut second, mut first) = (Some(second), None);
        for tick in 0..5_000 {
            if tick == 400
                && let Some(second) = second.take()
            {
                let refused = interpolator.splice(tick, second).err();
                first = interpolator.take_finished();
                if refused.is_some() {
                    return (None, first, refused);
                }
            }
            let out = interpolator.step(&TickInputs { tick, requests: &[] });
            interpolator.stop_tail(&mut tail);
            let _desired = interpolator.desired_at(tick);
            let (counts, velocity) = (out.setpoint.counts, out.setpoint.velocity);
            interpolator.measured(&Measured { tick, counts, velocity });
            for event in out.events.iter() {
                if let InterpolatorEvent::Finished(outcome) = event {
                    return (Some(*outcome), first, None);
                }
            }
        }
        (None, first, None)
    });
    assert_eq!(outcome, Some(MotionOutcome::Completed));
}
