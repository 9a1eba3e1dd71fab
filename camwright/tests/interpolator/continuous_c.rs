// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! C turning on from one cut to the next: undisturbed, held, slowed down, cancelled and stopped at any tick.

use super::bench::{Bench, SAFE_X, TURN, TestNoise, machine, two_cuts};
use camwright::interpolator::{
    ExecutionState, Interpolator, Motion, MotionOutcome, MotionRequest, Prepared, TickInputs,
};
use camwright::job::grinding::SpeedLaw;
use camwright::machine::description::{AXIS_COUNT, Axis};
use camwright::machine::setpoint::StopPoint;
use camwright::math::hermite::HermiteSpline;
use camwright::motion::plan::{Plan, SegmentKind};
use std::sync::Arc;

fn speeds() -> [SpeedLaw; 2] {
    [
        SpeedLaw::ConstantWorkSpeed { work_speed_rad_s: 6.0 },
        SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 30.0, max_rad_s: 12.0 },
    ]
}

fn plans() -> [(Plan, [i64; AXIS_COUNT]); 2] {
    speeds().map(|speed| two_cuts(&machine(), speed))
}

fn started(plan: &Plan, start: [i64; AXIS_COUNT]) -> Bench {
    let mut bench = Bench::at(machine(), start);
    bench.start_plan(plan.clone());
    bench
}

/// Ends where the second cut closes: at its own phase after whole turns, X at size, then retracted.
fn assert_ended(bench: &Bench, what: &str) {
    assert_eq!(bench.counts()[0].rem_euclid(TURN), TURN / 3, "{what}");
    assert_eq!(bench.counts()[1], SAFE_X, "{what}");
    bench.assert_limits(what);
    bench.assert_at_rest(what);
}

#[test]
fn c_turns_from_the_first_cut_to_the_end_of_the_second() {
    for (plan, start) in plans() {
        let mut bench = started(&plan, start);
        assert_eq!(bench.finish(20_000), MotionOutcome::Completed);
        assert_ended(&bench, "undisturbed");
        let turning = |row: &&super::bench::Row| row.setpoint.velocity[0] > 0.0;
        let first = bench.rows.iter().position(|row| turning(&row)).unwrap();
        let last = bench.rows.iter().rposition(|row| turning(&row)).unwrap();
        assert!(bench.rows[first..=last].iter().all(|row| turning(&row)));
        // Between the cuts C comes to the speed of the second and keeps it.
        let indexing = bench.rows.iter().filter(|row| row.status.segment == 2);
        assert!(indexing.skip(50).all(|row| (row.setpoint.velocity[0] - 3.0).abs() < 1e-12));
    }
}

/// Whatever is held, whenever and for however long: limits hold and the end is the same.
#[test]
fn a_hold_anywhere_lets_the_phase_go_by_and_the_cut_begins_later() {
    let seed = 11;
    let mut random = TestNoise(seed);
    let plans = plans();
    for case in 0..60 {
        let (plan, start) = &plans[case % 2];
        let (hold, length) = (1 + random.below(7_000), 1 + random.below(2_500));
        let what = format!("seed {seed} case {case}: hold at {hold} for {length}");
        let mut bench = started(plan, *start);
        if !bench.hold_at(hold, length) {
            continue;
        }
        assert_eq!(bench.finish(30_000), MotionOutcome::Completed, "{what}");
        assert_ended(&bench, &what);
    }
}

/// A hold between the cuts stops the table; C turns on.
#[test]
fn a_hold_between_the_cuts_leaves_c_turning() {
    let (plan, start) = &plans()[0];
    let mut bench = started(plan, *start);
    while bench.rows.last().is_none_or(|row| row.status.segment < 1) {
        bench.step(&[]);
    }
    for _ in 0..100 {
        bench.step(&[]);
    }
    bench.step(&[MotionRequest::Hold]);
    for _ in 0..1000 {
        bench.step(&[]);
    }
    let row = *bench.last();
    assert_eq!((row.status.state, row.status.segment), (ExecutionState::Held, 1));
    assert_eq!(row.setpoint.velocity[1..], [0.0, 0.0]);
    assert!((row.setpoint.velocity[0] - 3.0).abs() < 1e-12);
    bench.step(&[MotionRequest::Unhold]);
    assert_eq!(bench.finish(20_000), MotionOutcome::Completed);
    assert_ended(&bench, "held between the cuts");
}

#[test]
fn holds_and_overrides_in_any_order_keep_the_limits() {
    let seed = 23;
    let mut random = TestNoise(seed);
    let plans = plans();
    for case in 0..40 {
        let (plan, start) = &plans[case % 2];
        let what = format!("seed {seed} case {case}");
        let mut bench = started(plan, *start);
        bench.disturb(&mut random, (30, 400), [MotionRequest::Hold, MotionRequest::Unhold]);
        assert_eq!(bench.finish(60_000), MotionOutcome::Completed, "{what}");
        assert_ended(&bench, &what);
    }
}

#[test]
fn a_cancel_anywhere_ends_at_rest_with_the_wheel_retracted() {
    for (plan, start) in plans() {
        for cancel in (1..8_000).step_by(97) {
            let what = format!("cancel at {cancel}");
            let mut bench = started(&plan, start);
            while (bench.rows.len() as u64) < cancel && bench.outcome.is_none() {
                bench.step(&[]);
            }
            if bench.outcome.is_some() {
                continue;
            }
            bench.step(&[MotionRequest::Cancel]);
            assert_eq!(bench.finish(5_000), MotionOutcome::Cancelled, "{what}");
            bench.assert_limits(&what);
            bench.assert_at_rest(&what);
            assert!(bench.counts()[1] >= SAFE_X, "{what}: {:?}", bench.counts());
        }
    }
}

#[test]
fn an_alarm_anywhere_brings_c_to_rest_too() {
    for (plan, start) in plans() {
        for alarm in (50..8_000).step_by(173) {
            let mut bench = started(&plan, start);
            while (bench.rows.len() as u64) < alarm && bench.outcome.is_none() {
                bench.step(&[]);
            }
            if bench.outcome.is_some() {
                continue;
            }
            assert!(bench.interpolator.alarm(bench.tick, 42));
            for _ in 0..bench.machine.feedback_delay_ticks {
                bench.step(&[]);
            }
            if bench.outcome.is_some() {
                continue;
            }
            assert_eq!(bench.finish(3_000), MotionOutcome::Failed(42), "alarm at {alarm}");
            bench.assert_limits(&format!("alarm at {alarm}"));
            bench.assert_at_rest("alarm");
        }
    }
}

/// A switch that never closes: the interpolator's own alarm, and C comes to rest before the motion ends.
#[test]
fn a_station_that_is_not_found_brings_c_to_rest_before_the_motion_ends() {
    let (mut plan, start) = two_cuts(&machine(), speeds()[0]);
    // The table searches from behind its switch.
    let far = super::bench::to(&machine(), Axis::Z, 200 * super::bench::PER_MM);
    plan.segments[1].kind = SegmentKind::Move(vec![far]);
    let mut bench = started(&plan, start);
    assert_eq!(bench.finish(20_000), MotionOutcome::Failed(91));
    bench.assert_limits("no station");
    bench.assert_at_rest("no station");
    assert_eq!(bench.last().status.state, ExecutionState::Fault);
}

/// Numbers that no planner writes are refused before anything moves, or followed without a panic, whatever they stand for.
#[test]
fn a_plan_with_numbers_that_cannot_be_is_refused() {
    let (plan, start) = two_cuts(&machine(), speeds()[0]);
    let mut refused = 0;
    let mut follow = |plan: Plan| {
        let Ok(prepared) = Prepared::new(Motion::Plan(Arc::new(plan)), &machine()) else {
            refused += 1;
            return;
        };
        let mut interpolator = Interpolator::new(&machine());
        interpolator.resync(start);
        interpolator.set_homed(Axis::C, true);
        interpolator.start(Box::new(prepared)).unwrap();
        let mut tail = [StopPoint::default(); 32];
        for tick in 0..9_000 {
            let requests: &[MotionRequest] = match tick {
                2000 | 4800 => &[MotionRequest::Hold],
                2200 | 5000 => &[MotionRequest::Unhold],
                _ => &[],
            };
            interpolator.step(&TickInputs { tick, requests });
            interpolator.stop_tail(&mut tail);
        }
    };
    for huge in [1e-300, -1e300] {
        for law in 0..plan.time_laws.len() + plan.angle_laws.len() {
            let laws = |plan: &mut Plan| match law.checked_sub(plan.time_laws.len()) {
                None => std::mem::take(&mut plan.time_laws),
                Some(_) => std::mem::take(&mut plan.angle_laws),
            };
            let index = law.checked_sub(plan.time_laws.len()).unwrap_or(law);
            let count = laws(&mut plan.clone())[index].knots().len();
            for (knot, field) in (0..count).flat_map(|knot| (0..3).map(move |field| (knot, field))) {
                let mut changed = plan.clone();
                let mut all = laws(&mut changed);
                let mut knots = all[index].knots().to_vec();
                match field {
                    0 => knots[knot].value = huge,
                    1 => knots[knot].first = huge,
                    _ => knots[knot].at = huge,
                }
                let Ok(law_of_it) = HermiteSpline::new(knots) else { continue };
                all[index] = law_of_it;
                if law < plan.time_laws.len() {
                    changed.time_laws = all;
                } else {
                    changed.angle_laws = all;
                }
                follow(changed);
            }
        }
        for field in 0..7 {
            let mut changed = plan.clone();
            let SegmentKind::Cut(cut) = &mut changed.segments[4].kind else { panic!("segment 4 is the second cut") };
            match field {
                0 => cut.start_counts = if huge < 0.0 { i64::MIN } else { i64::MAX },
                1 => cut.path_start_rad = huge,
                2 => cut.turn_s = huge,
                3 => cut.plateau_s.1 = huge,
                4 => cut.hold_mm = huge,
                5 => cut.retract_mm = huge,
                _ => cut.turns = u32::MAX,
            }
            follow(changed);
        }
    }
    assert!(refused > 100, "{refused}");
}
