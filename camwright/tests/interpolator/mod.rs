// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The interpolator on a bench: closed forms, holds, overrides, cancels and searches anywhere, bit for bit.
#![allow(clippy::cast_possible_truncation, clippy::float_cmp, reason = "test figures are small; rest is exactly zero")]

mod bench;
mod continuous_c;
mod disturbances;
mod feedback;
mod following;
mod homing;
mod joining;
mod manual;
mod on_the_machine;
mod setup;
mod size;
mod sparking_out;
mod speed_variation;
mod spirals;
mod tails;
mod trajectories;
mod varied;

use bench::{Bench, PER_MM, SAFE_X, TURN, cut_only, machine, whole_job};
use camwright::interpolator::{ExecutionState, InterpolatorAlarm, Motion, MotionOutcome, PrepareError, Prepared};
use camwright::machine::description::Axis;
use camwright::math::units::TURN_RAD;
use camwright::motion::plan::{Phase, Plan, PlanCommand, SegmentKind};
use std::sync::Arc;

/// The whole job arrives where it should: C homed on its mark and turned by whole turns, the table behind its switch.
#[test]
fn a_whole_job_runs_to_its_end_within_the_limits() {
    let machine = machine();
    let mut bench = Bench::new(machine.clone());
    bench.start_plan(whole_job(&machine, 6.0));
    assert_eq!(bench.finish(30_000), MotionOutcome::Completed);
    bench.assert_limits("whole job");
    bench.assert_at_rest("whole job");
    // Four turns after the zero; safe X; Z at 50 mm.
    assert_eq!(bench.counts(), [4 * TURN, SAFE_X, 50 * PER_MM]);
    assert!(bench.interpolator.is_homed(Axis::C) && bench.last().status.is_homed());
    assert_eq!(bench.last().status.state, ExecutionState::Idle);
    let plan = whole_job(&machine, 6.0);
    let SegmentKind::Cut(cut) = &plan.segments[8].kind else { panic!("segment 8 is the cut") };
    bench.assert_on_path(&plan, cut, "whole job");
    assert!(bench.interpolator.take_finished().is_some());
}

/// A concentric disc at constant speed: C is its law, rounded, tick by tick.
#[test]
fn undisturbed_positions_are_the_law_at_the_tick_rounded_to_counts() {
    let machine = machine();
    let (plan, start) = cut_only(&machine, 0.0, 6.0);
    let law = plan.time_laws[0].clone();
    let mut bench = Bench::at(machine.clone(), start);
    bench.start_plan(plan);
    assert_eq!(bench.finish(10_000), MotionOutcome::Completed);
    let first = bench.rows[0].tick;
    for row in &bench.rows {
        let exact = law.sample((row.tick - first) as f64 * machine.cycle_time_s()).value / TURN_RAD * TURN as f64;
        assert_eq!(row.setpoint.counts[0], exact.round() as i64, "tick {}", row.tick);
    }
}

/// Pulse distribution of JPS6156064B2: whatever the blocks, the remainder is carried along. No position is off by more
/// than half a count, increments of blocks are whole counts, and after n turns C and X have moved as commanded.
#[test]
fn increments_are_error_diffused_and_close_exactly_after_n_turns() {
    let machine = machine();
    let (plan, start) = cut_only(&machine, 4.2, 5.0);
    let mut bench = Bench::at(machine.clone(), start);
    let curves = plan.clone();
    bench.start_plan(plan);
    assert_eq!(bench.finish(10_000), MotionOutcome::Completed);
    let first = bench.rows[0].tick;
    let mut sum = 0;
    let mut worst: f64 = 0.0;
    for pair in bench.rows.windows(2) {
        sum += pair[1].setpoint.counts[1] - pair[0].setpoint.counts[1];
        let time = (pair[1].tick - first) as f64 * machine.cycle_time_s();
        let c = curves.time_laws[0].sample(time).value;
        let exact = curves.paths[0].sample(bench::START_RAD + c).value + curves.angle_laws[0].sample(c).value;
        worst = worst.max(((start[1] + sum) as f64 - exact * PER_MM as f64).abs());
    }
    // The path's own digits after some turns: 1e-9 of a count.
    assert!(worst <= 0.5 + 1e-6, "{worst}");
    assert_eq!(sum, -36_000, "0.36 mm of infeed at 100000 counts per mm");
    assert_eq!(bench.counts()[0], 4 * TURN);
}

#[test]
fn stock_turn_phase_and_percent_are_reported() {
    let machine = machine();
    let mut bench = Bench::new(machine.clone());
    bench.start_plan(whole_job(&machine, 6.0));
    bench.finish(30_000);
    let cutting: Vec<_> = bench.rows.iter().filter(|row| row.status.turns > 0.0).collect();
    assert!((cutting[0].status.stock_mm - 0.36).abs() < 1e-6);
    let middle = cutting.iter().find(|row| row.status.turn >= 1.0).expect("turn 1");
    assert!((middle.status.stock_mm - 0.18).abs() < 1e-3 && middle.status.phase == Some(Phase::Cut));
    let spark = cutting.iter().find(|row| row.status.turn >= 2.1).expect("turn 2.1");
    assert!(spark.status.stock_mm < 1e-9 && spark.status.phase == Some(Phase::SparkOut));
    for pair in bench.rows.windows(2) {
        assert!(pair[1].status.percent >= pair[0].status.percent - 1e-9, "{pair:?}");
    }
}

/// A cut may begin in any turn of C, but only at its phase, and only where X is.
#[test]
fn a_cut_that_begins_elsewhere_is_an_alarm_and_nothing_moves() {
    let machine = machine();
    let (plan, start) = cut_only(&machine, 4.2, 5.0);
    for (c, x, alarm) in [
        (-7 * TURN, 0, None),
        (5, 0, Some(InterpolatorAlarm::NotAtStart { axis: Axis::C, wanted: 0, actual: 5 })),
        (0, 2, Some(InterpolatorAlarm::NotAtStart { axis: Axis::X, wanted: start[1], actual: start[1] + 2 })),
    ] {
        let mut bench = Bench::at(machine.clone(), [c, start[1] + x, 0]);
        bench.start_plan(plan.clone());
        let outcome = bench.finish(10_000);
        match alarm {
            None => assert_eq!((outcome, bench.counts()[0]), (MotionOutcome::Completed, c + 4 * TURN)),
            Some(alarm) => {
                assert_eq!(outcome, MotionOutcome::Failed(alarm.number()));
                assert_eq!((bench.rows.len(), bench.counts()), (1, [c, start[1] + x, 0]));
                assert_eq!(bench.last().status.state, ExecutionState::Fault);
            }
        }
    }
}

#[test]
fn targets_beyond_soft_limits_and_axes_without_a_zero_are_alarms() {
    let machine = machine();
    let plan = |axis, counts| Plan {
        segments: vec![bench::segment(
            SegmentKind::Move(vec![bench::to(&machine, axis, counts)]),
            Phase::Approach,
            10,
            1,
            0.0,
        )],
        ..Plan::default()
    };
    for (axis, counts, number) in [(Axis::X, -6 * PER_MM, 22), (Axis::Z, 901 * PER_MM, 23), (Axis::C, 1, 111)] {
        let mut bench = Bench::new(machine.clone());
        bench.start_plan(plan(axis, counts));
        assert_eq!(bench.finish(10), MotionOutcome::Failed(number));
        assert_eq!(bench.counts(), [0; 3]);
    }
}

#[test]
fn what_cannot_be_executed_is_refused_when_it_is_prepared() {
    let machine = machine();
    let good = whole_job(&machine, 6.0);
    let refused = |change: &dyn Fn(&mut Plan)| {
        let mut plan = good.clone();
        change(&mut plan);
        Prepared::new(Motion::Plan(Arc::new(plan)), &machine).expect_err("refused")
    };
    let error = refused(&|plan| {
        if let SegmentKind::Search { input, .. } = &mut plan.segments[5].kind {
            *input = "LS9".into();
        }
    });
    assert_eq!(error, PrepareError::UnknownInput { segment: 5, input: "LS9".into() });
    let cut = |change: &dyn Fn(&mut camwright::motion::plan::CutSegment)| {
        refused(&|plan| {
            if let SegmentKind::Cut(cut) = &mut plan.segments[8].kind {
                change(cut);
            }
        })
    };
    assert_eq!(cut(&|cut| cut.speed = 3), PrepareError::MissingSpline { segment: 8 });
    assert!(matches!(cut(&|cut| cut.turn_s = f64::NAN), PrepareError::Plateau { segment: 8, .. }));
    assert!(matches!(cut(&|cut| cut.retract_mm = 180.0), PrepareError::SoftLimit { segment: 8, .. }));
    assert_eq!(refused(&|plan| plan.segments[8].stop_ticks = 0), PrepareError::NoStop { segment: 8 });
    let error = refused(&|plan| plan.segments[2].kind = SegmentKind::Command(PlanCommand::SetHome(Axis::X)));
    assert_eq!(error, PrepareError::NothingCaught { segment: 2, axis: Axis::X });
    assert!(matches!(
        refused(&|plan| {
            if let SegmentKind::Move(targets) = &mut plan.segments[0].kind {
                targets[0].limits.jerk = -1.0;
            }
        }),
        PrepareError::Move { segment: 0, .. }
    ));
}
