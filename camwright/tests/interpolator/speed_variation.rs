// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A work speed that differs from turn to turn.

use super::bench::{Bench, TURN, TestNoise, cut_only, cut_only_under, machine, sparking_out};
use camwright::interpolator::{MotionOutcome, MotionRequest};
use camwright::job::grinding::SpeedLaw;
use camwright::job::speed_variation::SpeedVariation;
use camwright::motion::plan::{CutSegment, Plan, SegmentKind};

const WORK_SPEED_RAD_S: f64 = 6.0;
const VARIATION: SpeedVariation = SpeedVariation { slower: 0.4, period_turns: 1.5 };

/// The plan with a varying work speed in its cut, which is at this place, and with the time that it then takes.
fn varied(mut plan: Plan, segment: usize) -> (Plan, CutSegment) {
    let cycle_s = machine().cycle_time_s();
    let SegmentKind::Cut(cut) = plan.segments[segment].kind.clone() else { panic!("segment {segment} is a cut") };
    let cut = CutSegment { variation: Some(VARIATION), ..cut };
    let motion = plan.motion_of(&cut).expect("its splines");
    let change_s = plan.segments[segment].stop_ticks as f64 * cycle_s;
    let added_s = motion.time_added_by(&VARIATION, cut.plateau_s, change_s);
    plan.segments[segment].ticks += (added_s / cycle_s).round() as u64;
    plan.segments[segment].kind = SegmentKind::Cut(cut.clone());
    (plan, cut)
}

/// In the middle of each half C has the planned speed or 0.6 of it; the path, the limits and the end are those of the cut, and the time is the
/// predicted one.
#[test]
fn half_of_each_period_is_slower_on_the_same_path() {
    let machine = machine();
    let (plan, start) = cut_only(&machine, 4.2, WORK_SPEED_RAD_S);
    let (plan, cut) = varied(plan, 0);
    let mut bench = Bench::at(machine.clone(), start);
    bench.start_plan(plan.clone());
    assert_eq!(bench.finish(20_000), MotionOutcome::Completed);
    bench.assert_limits("varied");
    bench.assert_on_path(&plan, &cut, "varied");
    assert_eq!((bench.counts()[0], bench.counts()[1]), (4 * TURN, start[1] - 36_000));
    let predicted = plan.segments[0].ticks;
    assert!((bench.rows.len() as u64).abs_diff(predicted) <= 4, "{} ticks, predicted {predicted}", bench.rows.len());
    let speed_rad_s = |turns: f64| {
        let reached = bench.rows.windows(2).find(|pair| pair[1].setpoint.counts[0] as f64 >= turns * TURN as f64);
        let pair = reached.expect("C turns so far");
        let moved = pair[1].setpoint.counts[0] - pair[0].setpoint.counts[0];
        moved as f64 / TURN as f64 * std::f64::consts::TAU / machine.cycle_time_s()
    };
    // Halves of 0.75 turns: at the planned speed, slower, and so on. The last turn runs down.
    for (turns, share) in [(0.6, 1.0), (1.3, 0.6), (2.1, 1.0), (2.8, 0.6)] {
        let speed = speed_rad_s(turns);
        assert!((speed / (share * WORK_SPEED_RAD_S) - 1.0).abs() < 1e-3, "after {turns} turns: {speed} rad/s");
    }
    for pair in bench.rows.windows(2) {
        assert!(pair[1].status.percent >= pair[0].status.percent - 1e-9, "{pair:?}");
    }
}

/// Holds, releases and overrides in any order.
#[test]
fn disturbed_anywhere_it_keeps_the_limits_and_the_path() {
    let machine = machine();
    let removal = SpeedLaw::ConstantRemovalRate { removal_rate_mm2_s: 30.0, max_rad_s: 12.0 };
    let cuts = [cut_only(&machine, 4.2, WORK_SPEED_RAD_S), cut_only_under(&machine, 8.0, removal)];
    let seed = 407;
    let mut random = TestNoise(seed);
    for case in 0..40 {
        let (plan, start) = cuts[case % cuts.len()].clone();
        let (plan, cut) = varied(plan, 0);
        let what = format!("seed {seed} case {case}");
        let mut bench = Bench::at(machine.clone(), start);
        bench.start_plan(plan.clone());
        bench.disturb(&mut random, (20, 200), [MotionRequest::Hold, MotionRequest::Unhold]);
        assert_eq!(bench.finish(60_000), MotionOutcome::Completed, "{what}");
        bench.assert_limits(&what);
        bench.assert_on_path(&plan, &cut, &what);
        assert_eq!((bench.counts()[0].rem_euclid(TURN), bench.counts()[1]), (0, start[1] - 36_000), "{what}");
    }
}

/// Turns that are left out do not move the halves: what counts is the way that C has really turned.
#[test]
fn turns_that_are_left_out_leave_no_step_of_speed() {
    let machine = machine();
    let (plan, start) = sparking_out(&machine, 20);
    let (plan, cut) = varied(plan, 1);
    for at in [9_000, 9_300, 9_700] {
        let mut bench = Bench::at(machine.clone(), start);
        bench.start_plan(plan.clone());
        while bench.rows.len() < at {
            bench.step(&[]);
        }
        bench.force_is_steady(true);
        assert_eq!(bench.finish(60_000), MotionOutcome::Completed);
        bench.assert_limits(&format!("steady at {at}"));
        bench.assert_on_path(&plan, &cut, &format!("steady at {at}"));
        assert!(bench.counts()[0] < 22 * TURN, "{:?}", bench.counts());
    }
}
