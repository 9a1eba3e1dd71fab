// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A spiral around a part that is not round: on its path at every tick, however it is held, slowed down or left.

use super::bench::{Bench, PER_MM, SAFE_X, TURN, TestNoise, machine, segment, to};
use camwright::interpolator::{
    ExecutionState, InterpolatorAlarm, Motion, MotionOutcome, MotionRequest, PrepareError, Prepared,
};
use camwright::machine::description::{AXIS_COUNT, Axis, MachineDescription, MotionLimits};
use camwright::math::hermite::{HermiteSpline, Knot};
use camwright::math::units::TURN_RAD;
use camwright::motion::path_stop::path_stop_s;
use camwright::motion::plan::{Phase, Plan, SegmentKind, SpiralSegment};
use camwright::motion::point_to_point::rest_to_rest;
use camwright::motion::speed_plan::LimitedQuantity;
use camwright::planner::plan_check::{PlanFault, check_plan};
use std::sync::Arc;

const TURNS: u32 = 6;
const SPEED_RAD_S: f64 = 12.0;

/// Position of the axes before it.
pub(crate) fn start() -> [i64; AXIS_COUNT] {
    [0, SAFE_X, 10 * PER_MM]
}

/// X swings twice a turn about 30 mm and grows along the part, Z goes back by a millimetre a turn.
pub(crate) fn x_mm(c: f64) -> Knot {
    let (sin, cos) = (2.0 * c).sin_cos();
    Knot { at: c, value: 30.0 + 0.1 * c + 1.5 * cos, first: 0.1 - 3.0 * sin, second: -6.0 * cos }
}

pub(crate) fn z_mm(c: f64) -> f64 {
    50.0 - c / TURN_RAD
}

/// Moves to its start, the spiral, moves off.
pub(crate) fn plan(machine: &MachineDescription) -> Plan {
    let end_rad = f64::from(TURNS) * TURN_RAD;
    let path = (0..=360 * TURNS).map(|i| x_mm(f64::from(i) * TURN_RAD / 360.0)).collect();
    let z_per_rad = -1.0 / TURN_RAD;
    let z_knot = |at: f64| Knot { at, value: z_mm(at), first: z_per_rad, second: 0.0 };
    // A tenth is left to a stop that begins while C slows down by itself.
    let c_peaks = MotionLimits { velocity: SPEED_RAD_S, acceleration: 270.0, jerk: 27_000.0 };
    let law = rest_to_rest(end_rad, &c_peaks).expect("a law");
    let x_peaks = MotionLimits { velocity: 40.0, acceleration: 1_800.0, jerk: 150_000.0 };
    let stop_s = [(Axis::C, c_peaks), (Axis::X, x_peaks)]
        .map(|(axis, peaks)| path_stop_s(&peaks, &machine.axis(axis).limits).expect("room for a stop"));
    let stop_ticks = (stop_s[0].max(stop_s[1]) / machine.cycle_time_s()).ceil() as u64;
    let ticks = (law.end() / machine.cycle_time_s()).ceil() as u64;
    let spiral = SpiralSegment { path: 0, advance: 1, speed: 0, start_counts: 0 };
    let x_start = machine.axis(Axis::X).scale.counts(x_mm(0.0).value);
    Plan {
        time_laws: vec![law],
        angle_laws: vec![
            HermiteSpline::new(path).expect("knots"),
            HermiteSpline::new(vec![z_knot(0.0), z_knot(end_rad)]).expect("knots"),
        ],
        segments: vec![
            segment(SegmentKind::Move(vec![to(machine, Axis::Z, 50 * PER_MM)]), Phase::Index, 300, 1, 0.0),
            segment(SegmentKind::Move(vec![to(machine, Axis::X, x_start)]), Phase::Approach, 200, 1, 0.0),
            segment(SegmentKind::Spiral(spiral), Phase::Cut, ticks, stop_ticks, 0.0),
            segment(SegmentKind::Move(vec![to(machine, Axis::X, SAFE_X)]), Phase::Retract, 200, 1, 0.0),
        ],
        ..Plan::default()
    }
}

fn spiral_of(plan: &mut Plan) -> &mut SpiralSegment {
    match &mut plan.segments[2].kind {
        SegmentKind::Spiral(spiral) => spiral,
        _ => panic!("segment 2 is the spiral"),
    }
}

/// X and Z against the design at the C of the same row, wherever a row belongs to the spiral.
fn assert_on_spiral(bench: &Bench, what: &str) {
    let mut checked = 0;
    for row in bench.rows.iter().filter(|row| row.status.segment == 2 && row.status.turns > 0.0) {
        let c = row.setpoint.counts[0] as f64 / TURN as f64 * TURN_RAD;
        let x = x_mm(c);
        let per_c = 0.51 * TURN_RAD / TURN as f64 * PER_MM as f64;
        let off = row.setpoint.counts[1] as f64 - x.value * PER_MM as f64;
        assert!(off.abs() <= 0.51 + per_c * x.first.abs(), "{what}: tick {} X off by {off} counts", row.tick);
        let off = row.setpoint.counts[2] as f64 - z_mm(c) * PER_MM as f64;
        assert!(off.abs() <= 0.51 + per_c, "{what}: tick {} Z off by {off} counts", row.tick);
        checked += 1;
    }
    assert!(checked > 1000, "{what}: {checked} rows");
}

#[test]
fn x_and_z_follow_c_along_the_spiral_and_c_closes_after_whole_turns() {
    let machine = machine();
    let plan = plan(&machine);
    let report = check_plan(&plan, &machine, start()).expect("within limits");
    let mut bench = Bench::at(machine, start());
    bench.start_plan(plan);
    assert_eq!(bench.finish(20_000), MotionOutcome::Completed);
    bench.assert_limits("spiral");
    bench.assert_at_rest("spiral");
    assert_on_spiral(&bench, "spiral");
    assert_eq!(bench.counts(), report.end_counts);
    assert_eq!(bench.counts(), [i64::from(TURNS) * TURN, SAFE_X, (50 - i64::from(TURNS)) * PER_MM]);
    let turning_rows = bench.rows.iter().filter(|row| row.status.turns > 0.0);
    assert!(turning_rows.clone().all(|row| row.status.turns == f64::from(TURNS)));
    assert!(turning_rows.clone().any(|row| (row.status.turn - 3.5).abs() < 0.01));
}

#[test]
fn held_anywhere_it_stops_on_the_spiral_and_goes_on_to_the_same_end() {
    let seed = 11;
    let mut random = TestNoise(seed);
    for _ in 0..12 {
        let (at, ticks) = (700 + random.below(2200), random.below(900));
        let what = format!("seed {seed}: held after {at} ticks for {ticks}");
        let machine = machine();
        let mut bench = Bench::at(machine.clone(), start());
        bench.start_plan(plan(&machine));
        assert!(bench.hold_at(at, ticks), "{what}: it was over");
        assert_eq!(bench.finish(30_000), MotionOutcome::Completed, "{what}");
        bench.assert_limits(&what);
        assert_on_spiral(&bench, &what);
        assert_eq!(bench.counts(), [i64::from(TURNS) * TURN, SAFE_X, (50 - i64::from(TURNS)) * PER_MM], "{what}");
        let held = bench.rows.iter().any(|row| row.status.state == ExecutionState::Held);
        assert!(held || ticks <= 400, "{what}: it never was at rest");
    }
}

#[test]
fn cancelled_anywhere_it_stops_on_the_spiral_and_then_x_leaves_the_part() {
    for at in [900, 1500, 2100, 2900] {
        let machine = machine();
        let mut bench = Bench::at(machine.clone(), start());
        bench.start_plan(plan(&machine));
        while bench.rows.len() < at {
            bench.step(&[]);
        }
        bench.step(&[MotionRequest::Cancel]);
        assert_eq!(bench.finish(10_000), MotionOutcome::Cancelled, "after {at} ticks");
        bench.assert_limits(&format!("cancelled after {at} ticks"));
        assert_eq!(bench.counts()[1], SAFE_X, "after {at} ticks");
        let [c, _, z] = bench.counts();
        let z_there = z_mm(c as f64 / TURN as f64 * TURN_RAD) * PER_MM as f64;
        assert!((z as f64 - z_there).abs() <= 1.0, "after {at} ticks: Z leaves only with X off the part");
    }
}

#[test]
fn an_override_slows_all_axes_down_together() {
    let machine = machine();
    let mut bench = Bench::at(machine.clone(), start());
    bench.start_plan(plan(&machine));
    while bench.rows.len() < 1000 {
        bench.step(&[]);
    }
    bench.step(&[MotionRequest::SetOverride(0.3)]);
    assert_eq!(bench.finish(40_000), MotionOutcome::Completed);
    bench.assert_limits("override");
    assert_on_spiral(&bench, "override");
    let fastest = bench.rows.iter().skip(2000).map(|row| row.setpoint.velocity[0]).fold(0.0, f64::max);
    assert!((fastest - 0.3 * SPEED_RAD_S).abs() < 1e-9, "{fastest}");
}

#[test]
fn a_spiral_that_begins_elsewhere_is_an_alarm_and_nothing_moves() {
    let machine = machine();
    let mut only = plan(&machine);
    only.segments = vec![only.segments.remove(2)];
    let x = machine.axis(Axis::X).scale.counts(x_mm(0.0).value);
    for (counts, number) in [([5, x, 50 * PER_MM], 121), ([0, x + 2, 50 * PER_MM], 122), ([0, x, 49 * PER_MM], 123)] {
        let mut bench = Bench::at(machine.clone(), counts);
        bench.start_plan(only.clone());
        assert_eq!(bench.finish(10), MotionOutcome::Failed(number));
        assert_eq!(bench.counts(), counts);
    }
    let mut bench = Bench::new(machine.clone());
    bench.interpolator.resync([0, x, 50 * PER_MM]);
    bench.start_plan(only);
    assert_eq!(bench.finish(10), MotionOutcome::Failed(InterpolatorAlarm::NotHomed { axis: Axis::C }.number()));
}

#[test]
fn the_forward_check_refuses_what_joins_nothing_or_exceeds_a_limit() {
    let machine = machine();
    let fault = |change: &dyn Fn(&mut Plan)| {
        let mut plan = plan(&machine);
        change(&mut plan);
        check_plan(&plan, &machine, start()).expect_err("must be refused").fault
    };
    let jump = fault(&|plan| spiral_of(plan).start_counts = 7);
    assert!(matches!(jump, PlanFault::Jump { axis: Axis::C, .. }), "{jump}");
    let jump = fault(&|plan| drop(plan.segments.remove(0)));
    assert!(matches!(jump, PlanFault::Jump { axis: Axis::Z, .. }), "{jump}");
    let turning = fault(&|plan| {
        let mut knots = plan.time_laws[0].knots().to_vec();
        knots[0].first = 0.1;
        plan.time_laws[0] = HermiteSpline::new(knots).expect("knots");
    });
    assert!(matches!(turning, PlanFault::BadSpeed { .. }), "{turning}");
    let unknown = fault(&|plan| spiral_of(plan).advance = 9);
    assert_eq!(unknown, PlanFault::UnknownSpline);
    // Three times as fast X needs nine times the acceleration, 27 times the jerk.
    let limit = fault(&|plan| {
        let limits = MotionLimits { velocity: 3.0 * SPEED_RAD_S, acceleration: 1e4, jerk: 1e5 };
        plan.time_laws[0] = rest_to_rest(f64::from(TURNS) * TURN_RAD, &limits).expect("a law");
    });
    let PlanFault::Limit(used) = limit else { panic!("{limit}") };
    assert_eq!((used.axis, used.quantity), (Axis::C, LimitedQuantity::Acceleration));
    let beyond = fault(&|plan| {
        let knots = plan.angle_laws[1].knots().iter().map(|knot| Knot { first: 40.0 * knot.first, ..*knot });
        plan.angle_laws[1] = HermiteSpline::new(knots.collect()).expect("knots");
    });
    assert!(matches!(beyond, PlanFault::SoftLimit { axis: Axis::Z, .. } | PlanFault::Limit(_)), "{beyond}");
}

#[test]
fn a_spiral_that_cannot_be_is_refused_before_it_begins() {
    let machine = machine();
    let error = |change: &dyn Fn(&mut Plan)| {
        let mut plan = plan(&machine);
        change(&mut plan);
        Prepared::new(Motion::Plan(Arc::new(plan)), &machine).expect_err("must be refused")
    };
    assert_eq!(error(&|plan| spiral_of(plan).path = 5), PrepareError::MissingSpline { segment: 2 });
    assert_eq!(error(&|plan| plan.segments[2].stop_ticks = 0), PrepareError::NoStop { segment: 2 });
    for change in [
        (&|plan: &mut Plan| {
            let knots = plan.time_laws[0].knots().iter().map(|knot| Knot { value: -knot.value, ..*knot });
            plan.time_laws[0] = HermiteSpline::new(knots.collect()).expect("knots");
        }) as &dyn Fn(&mut Plan),
        &|plan| spiral_of(plan).start_counts = -1,
        &|plan| spiral_of(plan).start_counts = i64::MAX,
        &|plan| plan.segments[2].ticks = u64::MAX,
        &|plan| {
            let mut knots = plan.time_laws[0].knots().to_vec();
            knots[0].first = 1.0;
            plan.time_laws[0] = HermiteSpline::new(knots).expect("knots");
        },
        &|plan| {
            let mut knots = plan.time_laws[0].knots().to_vec();
            knots[1].value = 1e300;
            plan.time_laws[0] = HermiteSpline::new(knots).expect("knots");
        },
    ] {
        assert!(matches!(error(change), PrepareError::BadCut { segment: 2, .. }));
    }
    let beyond = error(&|plan| {
        let mut knots = plan.angle_laws[0].knots().to_vec();
        knots[100].value = 201.0;
        plan.angle_laws[0] = HermiteSpline::new(knots).expect("knots");
    });
    assert!(matches!(beyond, PrepareError::SoftLimit { segment: 2, bound_mm: 200.0, .. }), "{beyond}");
}
