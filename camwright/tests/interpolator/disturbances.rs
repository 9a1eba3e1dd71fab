// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Hold, override, cancel and alarms at any tick.

use super::bench::{Bench, SAFE_X, TURN, TestNoise, cut_only, cut_only_under, machine, whole_job};
use camwright::interpolator::{ExecutionState, InterpolatorEvent, MotionOutcome, MotionRequest};
use camwright::job::grinding::SpeedLaw;
use camwright::motion::plan::{CutSegment, Plan, SegmentKind};

fn cut_of(plan: &Plan) -> CutSegment {
    plan.segments
        .iter()
        .find_map(|segment| match &segment.kind {
            SegmentKind::Cut(cut) => Some(cut.clone()),
            _ => None,
        })
        .expect("the plan has a cut")
}

/// The same plan of one cut, whose hold stops the infeed and leaves the wheel on the part.
fn holding_on_the_part(mut plan: Plan) -> Plan {
    plan.segments[0].kind = SegmentKind::Cut(CutSegment { hold_mm: 0.0, ..cut_of(&plan) });
    plan
}

/// Whatever is held, whenever and for however long: limits hold, the path is the same, the end is the same.
#[test]
fn a_hold_anywhere_stops_within_limits_and_resumes_on_the_path() {
    let machine = machine();
    let seed = 4711;
    let mut random = TestNoise(seed);
    let plan = whole_job(&machine, 6.0);
    for case in 0..40 {
        let (hold, length) = (1 + random.below(7_500), 1 + random.below(2_500));
        let what = format!("seed {seed} case {case}: hold at {hold} for {length}");
        let mut bench = Bench::new(machine.clone());
        bench.start_plan(plan.clone());
        if !bench.hold_at(hold, length) {
            continue;
        }
        assert_eq!(bench.finish(30_000), MotionOutcome::Completed, "{what}");
        bench.assert_limits(&what);
        bench.assert_on_path(&plan, &cut_of(&plan), &what);
        let end = bench.counts();
        assert_eq!((end[0].rem_euclid(TURN), end[1]), (0, SAFE_X), "{what}");
    }
}

/// In the cut the wheel leaves the part, C goes on turning, and whole turns are inserted.
#[test]
fn a_hold_in_the_cut_retracts_and_keeps_c_turning() {
    let machine = machine();
    let (plan, start) = cut_only(&machine, 4.2, 6.0);
    let mut bench = Bench::at(machine.clone(), start);
    bench.start_plan(plan.clone());
    for _ in 0..1500 {
        bench.step(&[]);
    }
    let stock = bench.last().status.stock_mm;
    bench.step(&[MotionRequest::Hold]);
    assert_eq!(bench.last().status.state, ExecutionState::Holding);
    for _ in 0..3000 {
        bench.step(&[]);
    }
    let row = *bench.last();
    assert_eq!(row.status.state, ExecutionState::Held);
    assert!((row.setpoint.velocity[0] - 6.0).abs() < 1e-9, "C turns: {row:?}");
    assert!((row.status.stock_mm - stock).abs() < 1e-3, "nothing is cut");
    let path = plan.paths[0]
        .sample(super::bench::START_RAD + row.setpoint.counts[0] as f64 / TURN as f64 * std::f64::consts::TAU);
    let off = row.setpoint.counts[1] as f64 / 1e5 - path.value;
    assert!(off > 2.0 + stock - 1e-3, "2 mm off the infeed that was reached: {off}");
    bench.step(&[MotionRequest::Unhold]);
    assert_eq!(bench.last().status.state, ExecutionState::Unholding);
    assert_eq!(bench.finish(10_000), MotionOutcome::Completed);
    let turns = bench.counts()[0] / TURN;
    assert!(turns > 4 && bench.counts()[0] % TURN == 0, "whole turns were inserted: {turns}");
    bench.assert_limits("hold in the cut");
    bench.assert_on_path(&plan, &cut_of(&plan), "hold in the cut");
}

/// A hold that stops the infeed: the wheel stays on the part, at the depth it had reached, while C goes on turning.
#[test]
fn a_hold_that_stops_the_infeed_leaves_the_wheel_where_it_is() {
    let machine = machine();
    let (plan, start) = cut_only(&machine, 4.2, 6.0);
    let plan = holding_on_the_part(plan);
    let cut = cut_of(&plan);
    let mut bench = Bench::at(machine.clone(), start);
    bench.start_plan(plan.clone());
    for _ in 0..1500 {
        bench.step(&[]);
    }
    let stock = bench.last().status.stock_mm;
    bench.step(&[MotionRequest::Hold]);
    let mut held = 0;
    for _ in 0..3000 {
        bench.step(&[]);
        let row = *bench.last();
        let angle = row.setpoint.counts[0] as f64 / TURN as f64 * std::f64::consts::TAU;
        let path = plan.paths[0].sample(super::bench::START_RAD + angle).value;
        let off = row.setpoint.counts[1] as f64 / 1e5 - path - stock;
        // One millisecond of infeed, half a count of X, and half a count of C on the slope.
        assert!(off.abs() < 2e-4, "tick {}: {off} mm off the depth that was reached", row.tick);
        held += u32::from(row.status.state == ExecutionState::Held);
    }
    assert!(held > 2900, "held {held} ticks");
    assert!((bench.last().setpoint.velocity[0] - 6.0).abs() < 1e-9, "C turns");
    bench.step(&[MotionRequest::Unhold]);
    assert_eq!(bench.finish(10_000), MotionOutcome::Completed);
    let turns = bench.counts()[0] / TURN;
    assert!(turns > 4 && bench.counts()[0] % TURN == 0, "whole turns were inserted: {turns}");
    bench.assert_limits("hold of the infeed");
    bench.assert_on_path(&plan, &cut, "hold of the infeed");
}

/// A cancel takes the wheel off the part, whatever a hold has done before.
#[test]
fn a_cancel_retracts_out_of_a_hold_that_left_the_wheel_on_the_part() {
    let machine = machine();
    let (plan, start) = cut_only(&machine, 4.2, 6.0);
    let plan = holding_on_the_part(plan);
    for wait in [1, 3, 400] {
        let mut bench = Bench::at(machine.clone(), start);
        bench.start_plan(plan.clone());
        for _ in 0..1500 {
            bench.step(&[]);
        }
        bench.step(&[MotionRequest::Hold]);
        for _ in 0..wait {
            bench.step(&[]);
        }
        bench.step(&[MotionRequest::Cancel]);
        assert_eq!(bench.finish(10_000), MotionOutcome::Cancelled);
        let angle = bench.counts()[0] as f64 / TURN as f64 * std::f64::consts::TAU;
        let off = bench.counts()[1] as f64 / 1e5 - plan.paths[0].sample(super::bench::START_RAD + angle).value;
        assert!(off > 2.0, "{off} mm off the part after {wait} ticks of hold");
        bench.assert_limits("cancel out of a hold");
        bench.assert_at_rest("cancel out of a hold");
    }
}

/// Hold, release and hold again while the wheel is on its way, faster than it can follow.
#[test]
fn holds_and_releases_in_any_order_keep_the_limits_and_the_path() {
    let machine = machine();
    let removal = SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 30.0, max_rad_s: 12.0 };
    let mut cuts = vec![cut_only(&machine, 4.2, 6.0), cut_only_under(&machine, 8.0, removal)];
    for case in 0..2 {
        let (plan, start) = cuts[case].clone();
        cuts.push((holding_on_the_part(plan), start));
    }
    let seed = 99;
    let mut random = TestNoise(seed);
    for case in 0..60 {
        let (plan, start) = cuts[case % cuts.len()].clone();
        let what = format!("seed {seed} case {case}");
        let mut bench = Bench::at(machine.clone(), start);
        bench.start_plan(plan.clone());
        bench.disturb(&mut random, (20, 160), [MotionRequest::Unhold, MotionRequest::Hold]);
        assert_eq!(bench.finish(60_000), MotionOutcome::Completed, "{what}");
        bench.assert_limits(&what);
        bench.assert_on_path(&plan, &cut_of(&plan), &what);
        assert_eq!((bench.counts()[0].rem_euclid(TURN), bench.counts()[1]), (0, start[1] - 36_000), "{what}");
    }
}

/// Half the override: the same path in about twice the time.
#[test]
fn override_one_half_visits_the_same_points_in_twice_the_time() {
    let machine = machine();
    let (plan, start) = cut_only(&machine, 4.2, 6.0);
    let run = |factor: f64| {
        let mut bench = Bench::at(machine.clone(), start);
        bench.step(&[MotionRequest::SetOverride(factor)]);
        bench.start_plan(plan.clone());
        assert_eq!(bench.finish(20_000), MotionOutcome::Completed);
        bench.rows.remove(0);
        bench
    };
    let (full, half) = (run(1.0), run(0.5));
    half.assert_on_path(&plan, &cut_of(&plan), "half");
    // Every other tick of the slow run is a tick of the fast one.
    for (index, row) in full.rows.iter().enumerate().take(full.rows.len() - 1) {
        assert_eq!(half.rows[2 * index].setpoint.counts, row.setpoint.counts, "{index}");
    }
    assert!(half.rows.len().abs_diff(2 * full.rows.len()) <= 3);
}

/// Turning the knob at any time in any segment.
#[test]
fn a_changing_override_keeps_the_limits_and_the_path() {
    let machine = machine();
    let plan = whole_job(&machine, 6.0);
    let seed = 5;
    let mut random = TestNoise(seed);
    for case in 0..10 {
        let what = format!("seed {seed} case {case}");
        let mut bench = Bench::new(machine.clone());
        bench.start_plan(plan.clone());
        while bench.outcome.is_none() && bench.rows.len() < 60_000 {
            let factor = if random.next() < 0.2 { 1.0 } else { 0.2 + 0.8 * random.next() };
            bench.step(&[MotionRequest::SetOverride(factor)]);
            for _ in 0..random.below(900) {
                bench.step(&[]);
            }
        }
        assert_eq!(bench.outcome, Some(MotionOutcome::Completed), "{what}");
        bench.assert_limits(&what);
        bench.assert_on_path(&plan, &cut_of(&plan), &what);
    }
}

#[test]
fn override_zero_stands_still_and_any_other_goes_on() {
    let machine = machine();
    let (plan, start) = cut_only(&machine, 4.2, 6.0);
    let mut bench = Bench::at(machine.clone(), start);
    bench.start_plan(plan.clone());
    for _ in 0..800 {
        bench.step(&[]);
    }
    bench.step(&[MotionRequest::SetOverride(0.0), MotionRequest::SetOverride(f64::NAN)]);
    for _ in 0..1500 {
        bench.step(&[]);
    }
    bench.assert_at_rest("override 0");
    bench.step(&[MotionRequest::SetOverride(7.0)]);
    assert_eq!(bench.last().status.feed_override, 1.0);
    assert_eq!(bench.finish(20_000), MotionOutcome::Completed);
    assert_eq!(bench.counts()[0], 4 * TURN);
    bench.assert_limits("override 0");
}

/// Every so many ticks of the whole job, and from a hold: rest within limits, the wheel away from the part.
#[test]
fn a_cancel_anywhere_ends_at_rest_with_the_wheel_retracted() {
    let machine = machine();
    let plan = whole_job(&machine, 6.0);
    for cancel in (1..8_000).step_by(131) {
        for held in [0, 40, 700] {
            let what = format!("cancel at {cancel} after a hold of {held}");
            let mut bench = Bench::new(machine.clone());
            bench.start_plan(plan.clone());
            while (bench.rows.len() as u64) < cancel && bench.outcome.is_none() {
                bench.step(&[]);
            }
            if bench.outcome.is_some() {
                continue;
            }
            if held > 0 {
                bench.step(&[MotionRequest::Hold]);
                for _ in 0..held {
                    bench.step(&[]);
                }
            }
            // An order under way is not held back, and the last one ends the job.
            if bench.outcome.is_some() {
                continue;
            }
            bench.step(&[MotionRequest::Cancel]);
            assert!(matches!(bench.last().status.state, ExecutionState::Stopping | ExecutionState::Idle), "{what}");
            assert_eq!(bench.finish(5_000), MotionOutcome::Cancelled, "{what}");
            bench.assert_limits(&what);
            bench.assert_at_rest(&what);
            assert!(bench.counts()[1] >= SAFE_X, "{what}: {:?}", bench.counts());
        }
    }
}

/// With the override at 0 a cancel must not wait for it.
#[test]
fn a_cancel_does_not_wait_for_the_override() {
    let machine = machine();
    let (plan, start) = cut_only(&machine, 4.2, 6.0);
    for wait in [10, 100, 2000] {
        let mut bench = Bench::at(machine.clone(), start);
        bench.start_plan(plan.clone());
        for _ in 0..1000 {
            bench.step(&[]);
        }
        bench.step(&[MotionRequest::SetOverride(0.0)]);
        for _ in 0..wait {
            bench.step(&[]);
        }
        bench.step(&[MotionRequest::Cancel]);
        assert_eq!(bench.finish(5_000), MotionOutcome::Cancelled);
        bench.assert_limits("cancel at override 0");
    }
}

/// An alarm of the machine is seen D ticks after its own, ends the motion at rest, and a start needs a reset.
#[test]
fn an_alarm_anywhere_stops_within_limits_and_needs_a_reset() {
    let machine = machine();
    let plan = whole_job(&machine, 6.0);
    let delay = u64::from(machine.feedback_delay_ticks);
    for alarm in (50..8_000).step_by(389) {
        let mut bench = Bench::new(machine.clone());
        bench.start_plan(plan.clone());
        while (bench.rows.len() as u64) < alarm && bench.outcome.is_none() {
            bench.step(&[]);
        }
        if bench.outcome.is_some() {
            continue;
        }
        let raised = bench.tick;
        assert!(bench.interpolator.alarm(raised, 42));
        for _ in 0..delay {
            let out = bench.step(&[]);
            assert!(!out.applied.iter().any(|input| matches!(input, camwright::interpolator::AppliedInput::Alarm(_))));
        }
        if bench.outcome.is_some() {
            continue;
        }
        assert_eq!(bench.finish(3_000), MotionOutcome::Failed(42), "alarm at {alarm}");
        bench.assert_limits(&format!("alarm at {alarm}"));
        bench.assert_at_rest("alarm");
        assert_eq!(bench.last().status.state, ExecutionState::Fault);
        let counts = bench.counts();
        bench.interpolator.resync(counts);
        assert!(bench.interpolator.is_idle());
    }
}

/// It came and was reset while nothing moved: the next motion has nothing to do with it.
#[test]
fn an_alarm_from_before_a_motion_does_not_end_it() {
    let machine = machine();
    let mut plan = whole_job(&machine, 6.0);
    plan.segments.truncate(1);
    let mut bench = Bench::new(machine);
    assert!(bench.interpolator.alarm(bench.tick - 1, 1));
    bench.start_plan(plan.clone());
    assert_eq!(bench.finish(5_000), MotionOutcome::Completed);
    // One of its first tick does.
    let mut bench = Bench::new(bench.machine);
    assert!(bench.interpolator.alarm(bench.tick, 1));
    bench.start_plan(plan);
    assert_eq!(bench.finish(5_000), MotionOutcome::Failed(1));
}

#[test]
fn a_wait_waits_for_its_decision() {
    let machine = machine();
    let mut plan = whole_job(&machine, 6.0);
    plan.segments.truncate(1);
    plan.segments.push(super::bench::segment(SegmentKind::Wait, camwright::motion::plan::Phase::Return, 0, 1, 0.0));
    let mut bench = Bench::new(machine.clone());
    bench.start_plan(plan);
    for _ in 0..2_000 {
        bench.step(&[]);
    }
    assert_eq!((bench.outcome, bench.last().status.segment), (None, 1));
    bench.step(&[MotionRequest::Decision]);
    assert_eq!(bench.outcome, Some(MotionOutcome::Completed));
    assert!(bench.events.iter().any(|(_, event)| *event == InterpolatorEvent::Segment(1)));
}
