// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A spiral whose spindle varies its speed: held, slowed down and left anywhere, within all limits.

use super::bench::{Bench, TestNoise};
use crate::solids::low_and_high_cam;
use camwright::interpolator::{ExecutionState, MotionOutcome, MotionRequest};
use camwright::job::turning::{TurningJob, TurningSpeed};
use camwright::machine::description::{AXIS_COUNT, Axis, DriveSettings, MachineDescription};
use camwright::machine::reference::lathe;
use camwright::math::hermite::{HermiteSpline, Knot};
use camwright::motion::plan::SegmentKind;
use camwright::motion::speed_plan::LimitedQuantity;
use camwright::planner::plan_check::{PlanFault, check_plan};
use camwright::planner::{PlanStart, PlannedTurning, plan_turning};
use camwright::toolpath::insert_path::{InsertFeed, Passes};

fn machine() -> MachineDescription {
    lathe().with_drives(DriveSettings::IDEAL)
}

fn start(machine: &MachineDescription) -> [i64; AXIS_COUNT] {
    [0, machine.axis(Axis::X).scale.counts(40.0), machine.axis(Axis::Z).scale.counts(20.0)]
}

/// From the high cam over the crest to the low one, in one pass.
fn planned(machine: &MachineDescription) -> PlannedTurning {
    let job = TurningJob {
        name: "two cams".into(),
        surface: low_and_high_cam(),
        turned_mm: (9.5, 3.5),
        bar_radius_mm: 24.7,
        part_zero_mm: 2.0,
        passes: Passes { stock_mm: 4.9, finish_mm: 4.9, deepest_mm: 4.9, rough_feed: InsertFeed::AlongZ(0.5) },
        feed: InsertFeed::AlongZ(0.5),
        angles: 360,
        speed: TurningSpeed::Varied,
        clearance_mm: 1.0,
        rapid_speed_mm_s: 200.0,
    };
    let start = PlanStart { counts: start(machine), c_homed: true };
    plan_turning(&job, machine, Some(start)).unwrap_or_else(|error| panic!("{error}"))
}

fn bench(machine: &MachineDescription, planned: &PlannedTurning) -> Bench {
    let mut bench = Bench::at(machine.clone(), start(machine));
    bench.start_plan(planned.plan.clone());
    bench
}

/// Rows of the spiral: the first and the one after the last.
fn spiral(bench: &Bench) -> (u64, u64) {
    let is_cut = |row: &&super::bench::Row| row.status.turns > 0.0;
    let first = bench.rows.iter().position(|row| is_cut(&row)).expect("it was cut");
    (first as u64, (first + bench.rows.iter().filter(is_cut).count()) as u64)
}

#[test]
fn held_slowed_down_or_left_anywhere_it_keeps_the_limits() {
    let seed = 29;
    let (mut random, machine) = (TestNoise(seed), machine());
    let planned = planned(&machine);
    let (low, high) = planned.passes[0].speed_range_rad_s();
    assert!(high > 10.0 * low, "{low} {high}");
    let mut undisturbed = bench(&machine, &planned);
    assert_eq!(undisturbed.finish(100_000), MotionOutcome::Completed);
    undisturbed.assert_limits("undisturbed");
    assert_eq!(undisturbed.counts(), planned.report.end_counts);
    let (first, end) = spiral(&undisturbed);
    for _ in 0..8 {
        let (at, ticks) = (first + random.below(end - first), random.below(900));
        let what = format!("seed {seed}: after {at} ticks of {first} to {end}, for {ticks}");
        let mut held = bench(&machine, &planned);
        assert!(held.hold_at(at, ticks), "{what}");
        assert_eq!(held.finish(100_000), MotionOutcome::Completed, "{what}");
        held.assert_limits(&format!("held {what}"));
        assert_eq!(held.counts(), planned.report.end_counts, "held {what}");
        assert!(ticks <= 600 || held.rows.iter().any(|row| row.status.state == ExecutionState::Held), "{what}");
        let mut slowed = bench(&machine, &planned);
        while (slowed.rows.len() as u64) < at {
            slowed.step(&[]);
        }
        slowed.step(&[MotionRequest::SetOverride(0.2 + 0.7 * random.next())]);
        assert_eq!(slowed.finish(200_000), MotionOutcome::Completed, "{what}");
        slowed.assert_limits(&format!("slowed {what}"));
        let mut left = bench(&machine, &planned);
        while (left.rows.len() as u64) < at {
            left.step(&[]);
        }
        left.step(&[MotionRequest::Cancel]);
        assert_eq!(left.finish(10_000), MotionOutcome::Cancelled, "{what}");
        left.assert_limits(&format!("left {what}"));
    }
}

/// A knot of the law whose acceleration is off, where C is fast and knots are 1.5 ms apart: between the points of a grid over the whole
/// law it would not be seen.
#[test]
fn the_forward_check_sees_a_single_knot_that_is_off() {
    let machine = machine();
    let planned = planned(&machine);
    let law = planned.plan.segments.iter().find_map(|segment| match &segment.kind {
        SegmentKind::Spiral(spiral) => Some(spiral.speed),
        _ => None,
    });
    let law = law.expect("it has a spiral");
    let limits = machine.axis(Axis::C).limits;
    let knots = planned.plan.time_laws[law].knots().to_vec();
    // Knots from which and to which the speed changes, fast ones.
    let shortest = |index: usize| (knots[index + 1].at - knots[index].at).min(knots[index].at - knots[index - 1].at);
    let fast = |index: &usize| knots[*index].first > 40.0 && shortest(*index) < 3e-3;
    let places: Vec<usize> = (2..knots.len() - 2).filter(fast).collect();
    assert!(places.len() > 10, "{}", places.len());
    for index in places.into_iter().step_by(7) {
        let mut plan = planned.plan.clone();
        let mut knots = knots.clone();
        // It goes up by this over one interval and down over the next: a third more than C's jerk.
        let second = knots[index].second + 2.0 * limits.jerk * shortest(index);
        knots[index] = Knot { second, ..knots[index] };
        plan.time_laws[law] = HermiteSpline::new(knots).expect("knots");
        let error = check_plan(&plan, &machine, start(&machine)).expect_err("it must be seen");
        let PlanFault::Limit(used) = error.fault else { panic!("{error}") };
        assert!(used.quantity == LimitedQuantity::Jerk || used.quantity == LimitedQuantity::Acceleration, "{used}");
    }
}
