// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Spark-out that ends when the force is steady.

use super::bench::{Bench, TURN, TestNoise, machine, sparking_out};
use camwright::interpolator::{InterpolatorEvent, Motion, MotionOutcome, MotionRequest, PrepareError, Prepared};
use camwright::motion::plan::{CutSegment, Plan, SegmentKind};
use std::sync::Arc;

/// Turns with infeed of the cut.
const INFEED_TURNS: i64 = 2;

fn cut_of(plan: &Plan) -> CutSegment {
    match &plan.segments[1].kind {
        SegmentKind::Cut(cut) => cut.clone(),
        other => panic!("{other:?} is no cut"),
    }
}

fn left_out(bench: &Bench) -> i64 {
    let turns = |event: &InterpolatorEvent| match event {
        InterpolatorEvent::LeftOut { lobe: 0, turns } => i64::from(*turns),
        _ => 0,
    };
    bench.events.iter().map(|(_, event)| turns(event)).sum()
}

/// Runs to the end with the input closed from C there on (counts).
fn run(max_turns: u32, closes_at: i64) -> (Bench, Plan) {
    let machine = machine();
    let (plan, start) = sparking_out(&machine, max_turns);
    let mut bench = Bench::at(machine, start);
    bench.start_plan(plan.clone());
    let mut is_closed = false;
    while bench.outcome.is_none() {
        bench.step(&[]);
        if !is_closed && bench.counts()[0] >= closes_at {
            bench.force_is_steady(true);
            is_closed = true;
        }
    }
    (bench, plan)
}

/// The motion is that of all turns with whole turns cut out of it.
#[test]
fn turns_are_left_out_whole_and_the_motion_goes_on_without_a_step() {
    let (all, _) = run(8, i64::MAX);
    assert_eq!((left_out(&all), all.counts()[0]), (0, (INFEED_TURNS + 8) * TURN));
    for closes_at in [4 * TURN + TURN / 3, 5 * TURN - TURN / 2, 7 * TURN + 7] {
        let (bench, plan) = run(8, closes_at);
        assert_eq!(bench.outcome, Some(MotionOutcome::Completed));
        let left_out = left_out(&bench);
        assert_eq!(bench.counts()[0], (INFEED_TURNS + 8 - left_out) * TURN);
        // The turn in which it is known is finished.
        assert_eq!(left_out, INFEED_TURNS + 8 - 1 - closes_at.div_euclid(TURN), "{closes_at}");
        bench.assert_limits("spark-out cut short");
        bench.assert_at_rest("spark-out cut short");
        bench.assert_on_path(&plan, &cut_of(&plan), "spark-out cut short");
        assert_eq!(bench.counts()[1], all.counts()[1], "X ends where it would have");
    }
}

/// A force that is steady during the infeed is no reason to leave out a turn before the step of the infeed has been ground away.
#[test]
fn a_whole_turn_without_infeed_is_always_turned() {
    let (bench, _) = run(8, 0);
    assert_eq!(bench.counts()[0], (INFEED_TURNS + 2) * TURN, "one turn, and the one in which it is known");
    let (few, _) = run(1, 0);
    assert_eq!((few.counts()[0], left_out(&few)), ((INFEED_TURNS + 1) * TURN, 0));
}

#[test]
fn an_input_that_opens_again_in_time_leaves_out_nothing() {
    let machine = machine();
    let (plan, start) = sparking_out(&machine, 4);
    let mut bench = Bench::at(machine, start);
    bench.start_plan(plan);
    let mut seen = [false; 2];
    while bench.outcome.is_none() {
        bench.step(&[]);
        for (seen, (at, closes)) in seen.iter_mut().zip([(TURN, true), (2 * TURN, false)]) {
            if !*seen && bench.counts()[0] >= at {
                bench.force_is_steady(closes);
                *seen = true;
            }
        }
    }
    assert_eq!((left_out(&bench), bench.counts()[0]), (0, (INFEED_TURNS + 4) * TURN));
}

/// Whenever the input closes, whatever is held and however late edges arrive: limits, path and end are kept, and edges delivered early or
/// late give the same bits.
#[test]
fn holds_and_delivery_do_not_disturb_it() {
    let machine = machine();
    let (plan, start) = sparking_out(&machine, 6);
    let seed = 90_125;
    let mut random = TestNoise(seed);
    for case in 0..30 {
        let (closes, hold, length) = (random.below(9_000), random.below(9_000), 1 + random.below(2_500));
        let what = format!("seed {seed} case {case}: closed at {closes}, held at {hold} for {length}");
        let run = |delivery: Box<dyn FnMut() -> u64>| {
            let mut bench = Bench::at(machine.clone(), start);
            bench.delivery = delivery;
            bench.run_held(plan.clone(), (hold, length), (closes, |bench| bench.force_is_steady(true)));
            bench
        };
        let mut late = TestNoise(seed + case);
        let (bench, other) = (run(Box::new(|| 1)), run(Box::new(move || 1 + late.below(20))));
        assert_eq!(bench.outcome, Some(MotionOutcome::Completed), "{what}");
        bench.assert_limits(&what);
        bench.assert_on_path(&plan, &cut_of(&plan), &what);
        assert_eq!(bench.counts()[0].rem_euclid(TURN), 0, "{what}");
        assert!(bench.rows.iter().zip(&other.rows).all(|(a, b)| a.setpoint == b.setpoint), "{what}");
        assert_eq!(bench.rows.len(), other.rows.len(), "{what}");
    }
}

/// While a hold has the wheel off the part there is no force, which is as steady as can be: a whole turn must follow.
#[test]
fn a_hold_in_spark_out_makes_another_whole_turn_necessary() {
    let machine = machine();
    let (plan, start) = sparking_out(&machine, 12);
    let mut bench = Bench::at(machine, start);
    bench.start_plan(plan);
    bench.step(&[]);
    while bench.counts()[0] < INFEED_TURNS * TURN + TURN / 2 {
        bench.step(&[]);
    }
    bench.step(&[MotionRequest::Hold]);
    for _ in 0..4_000 {
        bench.step(&[]);
    }
    bench.force_is_steady(true);
    bench.step(&[MotionRequest::Unhold]);
    while bench.last().status.state != camwright::interpolator::ExecutionState::Executing {
        bench.step(&[]);
    }
    let returned = bench.counts()[0];
    assert_eq!(bench.finish(40_000), MotionOutcome::Completed);
    assert!(left_out(&bench) > 5);
    assert!(bench.counts()[0] - returned >= TURN, "{} counts after its return", bench.counts()[0] - returned);
}

#[test]
fn a_cut_that_waits_for_an_unmonitored_force_is_refused() {
    let machine = machine();
    let (mut plan, _) = sparking_out(&machine, 4);
    plan.segments.remove(0);
    let error = Prepared::new(Motion::Plan(Arc::new(plan)), &machine).expect_err("nobody watches");
    assert!(matches!(error, PrepareError::BadCut { segment: 0, .. }), "{error}");
}
