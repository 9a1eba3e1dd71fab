// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Infeed that ends at a size on the gauge.

use super::bench::{Bench, START_RAD, TURN, TestNoise, sizing};
use camwright::interpolator::{
    InfeedEnd, InterpolatorAlarm, InterpolatorEvent, Motion, MotionOutcome, PrepareError, Prepared,
};
use camwright::machine::description::{Axis, GaugeDescription, GaugeKind, MachineDescription};
use camwright::motion::plan::{Plan, SegmentKind};
use std::sync::Arc;

/// Turns with infeed and without of the cut, and its infeed in a turn (counts).
const INFEED_TURNS: i64 = 2;
const SPARK_OUT_TURNS: i64 = 3;
const PER_TURN: i64 = 18_000;

fn machine() -> MachineDescription {
    let gauge = GaugeDescription {
        kind: GaugeKind::Diameter,
        behind_wheel_rad: 4.7,
        second_behind_wheel_rad: None,
        resolution_mm: 0.0,
        noise_mm: 0.0,
        bandwidth_rad_s: None,
        seed: 1,
    };
    MachineDescription { gauge: Some(gauge), ..super::bench::machine() }
}

fn ends(bench: &Bench) -> Vec<(u64, InfeedEnd)> {
    let end = |(tick, event): &(u64, InterpolatorEvent)| match event {
        InterpolatorEvent::InfeedEnded(end) => Some((*tick, *end)),
        _ => None,
    };
    bench.events.iter().filter_map(end).collect()
}

fn alarms(bench: &Bench) -> Vec<InterpolatorAlarm> {
    let alarm = |(_, event): &(u64, InterpolatorEvent)| match event {
        InterpolatorEvent::Alarm(alarm) => Some(*alarm),
        _ => None,
    };
    bench.events.iter().filter_map(alarm).collect()
}

/// Runs to the end with the size read from C there on (counts).
fn run(reached_at: i64) -> Bench {
    let machine = machine();
    let (plan, start) = sizing(&machine, SPARK_OUT_TURNS as u32);
    let mut bench = Bench::at(machine, start);
    bench.start_plan(plan);
    let mut is_read = false;
    while bench.outcome.is_none() {
        bench.step(&[]);
        if !is_read && bench.counts()[0] >= reached_at {
            bench.size_is_reached();
            is_read = true;
        }
    }
    bench
}

/// X where the cut begins and where it would end with all of its infeed (counts).
fn x_ends() -> (i64, i64) {
    let machine = machine();
    let (plan, start) = sizing(&machine, SPARK_OUT_TURNS as u32);
    let path_mm = plan.paths[0].sample(START_RAD).value;
    (start[1], machine.axis(Axis::X).scale.counts(path_mm))
}

/// D ticks after the reading X stays above its path as far as it is then, the turn under way is finished, and every turn of spark-out is
/// turned.
#[test]
fn the_infeed_ends_where_it_is_and_every_spark_out_turn_follows() {
    let (begins, path) = x_ends();
    assert_eq!(begins - path, INFEED_TURNS * PER_TURN);
    for reached_at in [TURN / 3, TURN - TURN / 10, TURN + TURN / 2] {
        let bench = run(reached_at);
        assert_eq!(bench.outcome, Some(MotionOutcome::Completed));
        let ends = ends(&bench);
        let [(tick, end)] = ends[..] else { panic!("{ends:?}") };
        let read = bench.rows.iter().find(|row| row.absolute[0] >= reached_at).expect("it was there").tick;
        assert_eq!(tick, read + u64::from(bench.machine.feedback_delay_ticks));
        let before = bench.rows.iter().find(|row| row.tick == tick - 1).expect("it was there").absolute;
        assert!((end.turn - before[0] as f64 / TURN as f64).abs() < 1e-6, "{end:?}");
        let turns = before[0].div_euclid(TURN) + 1;
        assert_eq!(i64::from(end.left_out), INFEED_TURNS - turns);
        assert_eq!(bench.counts()[0], (turns + SPARK_OUT_TURNS) * TURN);
        // Infeed is linear in C but for the blend at its end.
        let infed = (before[0] as f64 / TURN as f64 * PER_TURN as f64).round() as i64;
        assert!((bench.counts()[1] - (begins - infed)).abs() <= 2, "{} counts, {infed} of infeed", bench.counts()[1]);
        assert!((end.infed_mm * 1e5 - infed as f64).abs() < 1.5, "{end:?}");
        bench.assert_limits("size");
        bench.assert_at_rest("size");
    }
}

/// The whole infeed without the size: an alarm that says which, and a stop within the limits.
#[test]
fn a_size_that_is_not_read_is_an_alarm_when_the_infeed_is_over() {
    let bench = run(i64::MAX);
    assert_eq!(bench.outcome, Some(MotionOutcome::Failed(142)));
    let alarms = alarms(&bench);
    let [alarm @ InterpolatorAlarm::SizeNotReached { turns: 2, .. }] = alarms[..] else { panic!("{alarms:?}") };
    assert!(alarm.to_string().contains("2 turns of infeed are over") && alarm.to_string().contains("60.0120 mm"));
    assert!(alarm.remedy().contains("infeed.gauge_size.beyond_um"), "{}", alarm.remedy());
    assert!((INFEED_TURNS * TURN..(INFEED_TURNS + 1) * TURN).contains(&bench.counts()[0]), "{}", bench.counts()[0]);
    bench.assert_limits("no size");
    bench.assert_at_rest("no size");
}

/// Whenever the size is read, whatever is held and however late the edge arrives: limits and whole turns are kept, and an edge that is
/// delivered early or late gives the same bits.
#[test]
fn holds_and_delivery_do_not_disturb_it() {
    let machine = machine();
    let (plan, start) = sizing(&machine, SPARK_OUT_TURNS as u32);
    let (begins, path) = x_ends();
    let seed = 70_411;
    let mut random = TestNoise(seed);
    for case in 0..30 {
        let (read, hold, length) = (60 + random.below(1_900), 45 + random.below(4_500), 1 + random.below(2_500));
        let what = format!("seed {seed} case {case}: read at {read}, held at {hold} for {length}");
        let run = |delivery: Box<dyn FnMut() -> u64>| {
            let mut bench = Bench::at(machine.clone(), start);
            bench.delivery = delivery;
            // After the command to watch has taken effect.
            bench.run_held(plan.clone(), (hold, length), (read, |bench| bench.size_is_reached()));
            bench
        };
        let mut late = TestNoise(seed + case);
        let (bench, other) = (run(Box::new(|| 1)), run(Box::new(move || 1 + late.below(20))));
        assert_eq!(bench.outcome, Some(MotionOutcome::Completed), "{what}");
        bench.assert_limits(&what);
        assert_eq!(bench.counts()[0].rem_euclid(TURN), 0, "{what}");
        let ends = ends(&bench);
        let [(_, end)] = ends[..] else { panic!("{what}: {ends:?}") };
        let left = begins - path - (end.infed_mm * 1e5).round() as i64;
        assert!((bench.counts()[1] - path - left).abs() <= 2, "{what}: {end:?}, {} counts", bench.counts()[1]);
        assert!(bench.rows.iter().zip(&other.rows).all(|(a, b)| a.setpoint == b.setpoint), "{what}");
        assert_eq!(bench.rows.len(), other.rows.len(), "{what}");
    }
}

/// A size read before the watch of this cut belongs to another.
#[test]
fn an_edge_from_before_the_watch_is_ignored() {
    let machine = machine();
    let (plan, start) = sizing(&machine, SPARK_OUT_TURNS as u32);
    let mut bench = Bench::at(machine, start);
    bench.start_plan(plan);
    bench.step(&[]);
    bench.size_is_reached();
    assert_eq!(bench.finish(40_000), MotionOutcome::Failed(142));
}

#[test]
fn a_size_without_a_gauge_or_a_spark_out_turn_is_refused() {
    let refusal = |plan: Plan, machine: &MachineDescription| {
        let error = Prepared::new(Motion::Plan(Arc::new(plan)), machine).expect_err("must be refused");
        assert!(matches!(error, PrepareError::BadCut { segment: 1, .. }), "{error}");
        error.to_string()
    };
    let machine = machine();
    let (plan, _) = sizing(&machine, 2);
    let blind = MachineDescription { gauge: None, ..machine.clone() };
    assert!(refusal(plan.clone(), &blind).contains("no gauge"));
    let mut endless = plan;
    let SegmentKind::Cut(cut) = &mut endless.segments[1].kind else { panic!("a cut") };
    cut.infeed_turns = cut.turns;
    assert!(refusal(endless, &machine).contains("no turn without infeed"));
}
