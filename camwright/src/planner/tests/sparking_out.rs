// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;
use crate::cam::form::Form;
use crate::interpolator::MotionOutcome;
use crate::job::grinding::JobError;
use crate::motion::plan::{PlanCommand, Segment};
use crate::planner::deflection::Deflections;

/// A job that sparks out until the force differs by so much over a turn at most (N), in so many turns at most.
fn until(max_n: Option<u32>, spark_out_turns: u32) -> (JobSpec, MachineDescription) {
    let soft = MachineDescription { contact: Some(contact()), ..machine() };
    let mut job = job();
    job.passes[0].total_infeed_mm = 0.108;
    job.passes[0].infeed_per_block_mm = 0.000_01;
    job.passes[0].spark_out_turns = spark_out_turns;
    job.passes[0].spark_out_until_n = max_n;
    job.stock_mm = 0.09;
    job.lobes.truncate(2);
    (job, soft)
}

/// Spark-out ends within a turn of what the law of the contact predicts: a force that gets steady just before the end of a turn may be
/// known in it or in the next. On round lobes, after as many turns, what is predicted is left. The second lobe is ground as if nothing had
/// happened.
#[test]
fn spark_out_ends_when_the_force_is_steady_after_the_predicted_turns() {
    for (max_n, round) in [(20, true), (60, true), (150, true), (60, false)] {
        let (mut job, soft) = until(Some(max_n), 20);
        if round {
            job.profiles.iter_mut().for_each(|profile| *profile = lobe_profile(&profile.name, 0.0, 75.0));
        }
        let planned = plan_job(&job, &soft, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
        let mut turned = [(f64::INFINITY, f64::NEG_INFINITY); 2];
        let (simulated, ground) = ground(&job, &planned, planned.plan.clone(), &soft, |setpoint, report| {
            if let Some(lobe) = report.lobe.filter(|_| setpoint.velocity[0] != 0.0) {
                let c = report.axes[Axis::C.index()].position / TURN_RAD;
                turned[lobe] = (turned[lobe].0.min(c), turned[lobe].1.max(c));
            }
        });
        assert_eq!(simulated.outcome, MotionOutcome::Completed);
        // A turn more or less for each lobe, and what the two searches of the table take longer.
        let took_s = (simulated.last_tick - simulated.first_tick) as f64 * soft.cycle_time_s();
        assert!((took_s - planned.plan.duration_s).abs() < 2.5, "{took_s} s, {} s", planned.plan.duration_s);
        for (index, lobe) in planned.lobes.iter().enumerate() {
            let design = &lobe.design;
            let station = soft.station(&design.station).expect("it was planned for it");
            let law = contact().law(station.position_mm, design.width_mm).expect("a width");
            let predicted = Deflections::from_lobe(&planned.plan, index, job.stock_mm, &law, &soft).expect("it is cut");
            let turns = libm::round(turned[index].1 - turned[index].0);
            let off = (turns - f64::from(predicted.turns)).abs();
            assert!(off < 1.5, "{max_n} N: {turns} turns, {predicted:?}");
            assert!(predicted.turns < 3 + 20, "{max_n} N: {predicted:?}");
            let radii = ground.part().lobe(&design.name).expect("it was loaded").radii_mm();
            let form = Form::measure(radii, &design.contour, design.phase_rad).expect("radii");
            let off_mm = form.largest.deviation_mm - predicted.left_mm;
            let exact = off_mm.abs() < 1e-4 + 0.02 * predicted.left_mm;
            assert!(exact || !round || off > 0.5, "{}: {:?}, {predicted:?}", design.name, form.largest);
            // Over a turn the force above F0 falls to kg/(kg + km) of itself, so where it fell by ΔF it was ΔF (1 + kg/km).
            let max_left_n = f64::from(max_n) * (1.0 + law.grinding_n_mm() / law.machine_n_mm()) + law.threshold_n();
            let max_left_mm = 1.05 * max_left_n / law.machine_n_mm() + 1e-4;
            assert!(form.largest.deviation_mm < max_left_mm, "{max_n} N: {:?}, {max_left_mm} mm", form.largest);
        }
    }
}

/// With a bound that is never met all turns are turned, and the plan that does not ask has no step for it.
#[test]
fn without_a_steady_force_every_turn_is_turned() {
    let (job, soft) = until(Some(1), 3);
    let planned = plan_job(&job, &soft, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
    let cut = planned.plan.cuts_of(0).next().expect("a cut");
    let law = contact().law(50.0, 14.0).expect("a width");
    let predicted = Deflections::from_lobe(&planned.plan, 0, job.stock_mm, &law, &soft).expect("it is cut");
    assert_eq!(predicted.turns, cut.turns);
    let watches = |plan: &Plan| {
        let is = |segment: &&Segment| matches!(segment.kind, SegmentKind::Command(PlanCommand::WatchForce { .. }));
        plan.segments.iter().filter(is).count()
    };
    assert_eq!(watches(&planned.plan), 1, "once for all lobes");
    let (plain, _) = until(None, 3);
    assert_eq!(watches(&plan_job(&plain, &soft, 60.0, None).unwrap_or_else(|error| panic!("{error}")).plan), 0);
}

#[test]
fn spark_out_by_force_is_refused_where_there_is_none_or_turns_are_counted_on() {
    let (job, soft) = until(Some(30), 6);
    let why = |job: &JobSpec, machine: &MachineDescription| match job.check(machine) {
        Err(error @ (JobError::SparkOutByForce { .. } | JobError::OutOfRange { .. })) => alloc::format!("{error}"),
        other => panic!("{other:?}"),
    };
    assert!(why(&job, &machine()).contains("no force to monitor"));
    assert!(why(&JobSpec { rotary_indexing: true, ..job.clone() }, &soft).contains("rotary indexing"));
    for max_n in [0, 10_001] {
        let (job, soft) = until(Some(max_n), 6);
        assert!(why(&job, &soft).contains("1 to 10000"));
    }
}
