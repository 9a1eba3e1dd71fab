// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Searches, zeros, and feedback that arrives whenever it likes.

use super::bench::{Bench, ORIGIN, SWITCH, TURN, TestNoise, machine, whole_job};
use camwright::interpolator::{
    AppliedInput, InterpolatorAlarm, InterpolatorEvent, Motion, MotionOutcome, MotionRequest, OrderKind, SearchStep,
};
use camwright::machine::description::Axis;
use camwright::machine::setpoint::{Input, Latch};

/// C stands on its mark, which is then zero; setpoints are counted from it from the order's own tick on.
#[test]
fn homing_finds_the_mark_and_counts_from_it() {
    let machine = machine();
    let mut bench = Bench::new(machine.clone());
    bench.start(Motion::Home(vec![Axis::C, Axis::X]));
    assert_eq!(bench.finish(10_000), MotionOutcome::Completed);
    bench.assert_limits("homing");
    assert_eq!((bench.counts()[0], bench.last().absolute[0]), (0, ORIGIN));
    assert_eq!(bench.orders.len(), 2);
    assert_eq!(bench.orders[0].kind, OrderKind::LoseHome { axis: Axis::C });
    let order = bench.orders[1];
    assert_eq!(order.kind, OrderKind::SetHome { axis: Axis::C, counts: ORIGIN });
    let row = |tick: u64| bench.rows.iter().find(|row| row.tick == tick).expect("stepped");
    assert_eq!((row(order.tick - 1).setpoint.counts[0], row(order.tick).setpoint.counts[0]), (ORIGIN, 0));
    // Long enough for the order to overtake the setpoints that run D ahead.
    let emitted = bench.rows.iter().find(|row| row.status.search == Some((Axis::C, SearchStep::Latch)));
    assert_eq!(order.tick - emitted.expect("an order").tick, 2 * u64::from(machine.feedback_delay_ticks));
    for step in [SearchStep::Search, SearchStep::Stop, SearchStep::Return] {
        assert!(bench.rows.iter().any(|row| row.status.search == Some((Axis::C, step))), "{step:?}");
    }
}

/// Homed twice: the second zero is the first one.
#[test]
fn homing_again_finds_the_same_zero() {
    let machine = machine();
    let mut bench = Bench::new(machine.clone());
    for _ in 0..2 {
        bench.start(Motion::Home(vec![Axis::C]));
        assert_eq!(bench.finish(10_000), MotionOutcome::Completed);
    }
    assert_eq!((bench.counts()[0], bench.last().absolute[0]), (0, ORIGIN + TURN));
}

#[test]
fn an_axis_without_a_reference_is_refused() {
    let mut machine = machine();
    machine.axes[2].needs_homing = true;
    let error =
        camwright::interpolator::Prepared::new(Motion::Home(vec![Axis::Z]), &machine).expect_err("no reference");
    assert_eq!(error.to_string(), "z_axis has no reference to be homed on");
}

#[test]
fn a_search_without_its_edge_is_an_alarm_at_rest() {
    let machine = machine();
    let mut bench = Bench::new(machine.clone());
    bench.origin_works = false;
    bench.start(Motion::Home(vec![Axis::C]));
    let alarm = InterpolatorAlarm::NoEdge { axis: Axis::C, input: Input::Origin };
    assert_eq!(bench.finish(10_000), MotionOutcome::Failed(90));
    assert!(bench.events.iter().any(|(_, event)| *event == InterpolatorEvent::Alarm(alarm)));
    bench.assert_limits("no edge");
    bench.assert_at_rest("no edge");
    assert_eq!(bench.counts()[0], TURN + TURN / 4);
}

/// Falling edges, edges of other inputs and edges from before the search do not end it.
#[test]
fn only_the_wanted_edge_ends_a_search() {
    let machine = machine();
    let mut bench = Bench::new(machine.clone());
    bench.start(Motion::Home(vec![Axis::C]));
    let good = Latch { tick: bench.tick, input: Input::Origin, rising: true, axis: Axis::C, counts: 5 };
    for latch in [
        Latch { tick: good.tick - 1, ..good },
        Latch { rising: false, ..good },
        Latch { input: Input::Station(0), ..good },
        Latch { axis: Axis::Z, ..good },
    ] {
        assert!(bench.interpolator.feedback(&latch));
    }
    assert_eq!(bench.finish(10_000), MotionOutcome::Completed);
    assert_eq!(bench.last().absolute[0], ORIGIN);
}

/// The table stands at the caught edge plus its offset, to the count, wherever the search stopped.
#[test]
fn the_table_stands_at_the_edge_plus_the_offset() {
    let machine = machine();
    let mut bench = Bench::new(machine.clone());
    bench.start_plan(whole_job(&machine, 6.0));
    while bench.last_segment() != Some(6) {
        bench.step(&[]);
    }
    assert_eq!(bench.counts()[2], SWITCH + 25 * super::bench::PER_MM);
}

impl Bench {
    fn last_segment(&self) -> Option<usize> {
        self.rows.last().map(|row| row.status.segment)
    }
}

/// Edges delivered at any moment between their own tick and D ticks later: not a bit differs.
#[test]
fn the_moment_at_which_feedback_arrives_changes_nothing() {
    let machine = machine();
    let plan = whole_job(&machine, 6.0);
    let run = |delivery: Box<dyn FnMut() -> u64>| {
        let mut bench = Bench::new(machine.clone());
        bench.delivery = delivery;
        bench.start_plan(plan.clone());
        bench.step(&[]);
        for _ in 0..5_000 {
            bench.step(&[]);
        }
        bench.step(&[MotionRequest::Hold]);
        for _ in 0..300 {
            bench.step(&[]);
        }
        bench.step(&[MotionRequest::Unhold, MotionRequest::SetOverride(0.8)]);
        bench.finish(30_000);
        let bits: Vec<_> = bench
            .rows
            .iter()
            .map(|row| {
                let s = row.setpoint;
                (row.tick, s.counts, s.velocity.map(f64::to_bits), s.acceleration.map(f64::to_bits))
            })
            .collect();
        (bits, bench.orders)
    };
    let at_once = run(Box::new(|| 1));
    let late = run(Box::new(|| 20));
    assert!(at_once == late);
    let mut random = TestNoise(3);
    assert!(at_once == run(Box::new(move || 1 + random.below(20))));
}

/// Applied inputs, replayed at the same ticks to another interpolator, give the same setpoints.
#[test]
fn applied_inputs_replay_the_run() {
    let machine = machine();
    let plan = std::sync::Arc::new(whole_job(&machine, 6.0));
    let mut bench = Bench::new(machine.clone());
    bench.start(Motion::Plan(plan.clone()));
    let mut applied: Vec<(u64, AppliedInput)> = Vec::new();
    let mut random = TestNoise(8);
    while bench.outcome.is_none() {
        let requests: &[MotionRequest] = match random.below(400) {
            0 => &[MotionRequest::Hold],
            1 => &[MotionRequest::Unhold, MotionRequest::SetOverride(0.7)],
            2 => &[MotionRequest::Unhold],
            _ => &[],
        };
        let out = bench.step(requests);
        applied.extend(out.applied.iter().map(|input| (out.tick, *input)));
        if bench.rows.len() > 20_000 {
            let out = bench.step(&[MotionRequest::Unhold]);
            applied.extend(out.applied.iter().map(|input| (out.tick, *input)));
            while bench.outcome.is_none() {
                bench.step(&[]);
            }
        }
    }
    let mut replay = Bench::new(machine.clone());
    replay.origin_works = false;
    replay.start(Motion::Plan(plan));
    for row in &bench.rows {
        let mut requests = Vec::new();
        for (_, input) in applied.iter().filter(|(tick, _)| *tick == row.tick) {
            match input {
                AppliedInput::Request(request) => requests.push(*request),
                AppliedInput::Feedback(latch) => assert!(replay.interpolator.feedback(latch)),
                AppliedInput::Alarm(_) => panic!("no alarm in this run"),
                AppliedInput::OutOfTolerance(_) | AppliedInput::Settled => panic!("no trajectory in this run"),
            }
        }
        let out =
            replay.interpolator.step(&camwright::interpolator::TickInputs { tick: row.tick, requests: &requests });
        assert_eq!(out.setpoint, row.setpoint, "tick {}", row.tick);
    }
}

/// Edges between motions do not affect the next search, and the record omits them.
#[test]
fn edges_between_motions_leave_no_trace() {
    let machine = machine();
    let mut bench = Bench::new(machine.clone());
    let old = |tick| Latch { tick, input: Input::Origin, rising: true, axis: Axis::C, counts: 5 };
    for tick in 0..500 {
        assert!(bench.interpolator.feedback(&old(tick)));
    }
    bench.start(Motion::Home(vec![Axis::C]));
    assert!(bench.interpolator.feedback(&old(999)));
    let mut seen = 0;
    while bench.outcome.is_none() {
        seen += bench.step(&[]).applied.len();
    }
    assert_eq!((bench.outcome, seen, bench.last().absolute[0]), (Some(MotionOutcome::Completed), 1, ORIGIN));
}
