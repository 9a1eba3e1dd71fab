// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The stock of journals: measured before anything is cut, and the turns that are omitted for it.

use super::stiffness::identifying_job;
use super::*;
use camwright::job::grinding::StockSpec;
use camwright::motion::plan::Half;
use camwright::planner::{MeasuredJob, PlanError, measured_stocks, plan_measured_job, plan_measuring};

/// A job of two passes that measures its stock first: 6 turns of 18 µm, 15 of 6 µm, and 20 µm are left, so the infeed begins 218 µm above
/// the journal.
fn measuring_job(unknown_mm: f64) -> JobSpec {
    let mut job = identifying_job();
    job.identification = None;
    (job.raw_part.unknown_mm, job.raw_part.eccentric.mm, job.raw_part.lobes[0].1.mm) = (unknown_mm, 0.01, 0.002);
    (job.passes[0].total_infeed_mm, job.passes[1].total_infeed_mm) = (0.108, 0.09);
    job.measure_stock = Some(StockSpec { margin_mm: 0.041, speed_rad_s: TURN_RAD });
    job
}

/// Runout of every journal, and how far its size is off (mm).
type RemainingErrors = Vec<(f64, f64)>;

/// Measures, plans anew, grinds and corrects; what was planned anew, and of every journal what is left of runout and size (mm).
fn measured_and_ground(
    machine: &MachineDescription,
    job: &JobSpec,
) -> Result<(MeasuredJob, RemainingErrors), Box<PlanError>> {
    let whole = plan_job(job, machine, 60.0, None)?;
    let measuring = plan_measuring(job, machine, 60.0, &whole.lobes, None)?;
    let mut cell = MachineUnderTest::new(machine, job);
    let logs = cell.run(&measuring.plan);
    let stocks = measured_stocks(machine, &measuring, &whole.lobes, &logs).unwrap_or_else(|error| panic!("{error}"));
    let measured = plan_measured_job(job, machine, 60.0, &whole, &measuring, &stocks)?;
    assert_eq!([measuring.plan.half, measured.planned.plan.half], [Half::First, Half::Middle]);
    let logs = cell.run(&measured.planned.plan);
    let first = &measured.planned;
    let decided = decide_corrections(job, machine, first, &logs, &[]).unwrap_or_else(|error| panic!("{error}"));
    let second = plan_corrections(job, machine, first, &decided)?;
    cell.run(&second.plan);
    let left = job.lobes.iter().map(|lobe| cell.runout_mm(&lobe.name)).collect();
    Ok((measured, left))
}

/// s of stock and 41 µm of margin under 218 µm: ⌊(218 − s − 41)/18⌋ turns of the first pass are omitted; where s + 41 is below the 110 µm
/// that the second pass begins at, the first with its spark-out turn, and ⌊(110 − s − 41)/6⌋ more. The finished journals are as good.
#[test]
fn turns_in_the_air_are_left_out_by_the_closed_form_and_the_part_is_as_good() {
    let machine = grinder(0.2, 270.0);
    for (unknown_mm, infeed_turns, spark_out_turns) in [(0.0, 4, 0), (-0.05, 9, 1), (-0.03, 5, 0), (0.06, 0, 0)] {
        let job = measuring_job(unknown_mm);
        let (measured, left) = measured_and_ground(&machine, &job).unwrap_or_else(|error| panic!("{error}"));
        for (skipped, (runout_mm, off_mm)) in measured.skipped.iter().zip(&left) {
            eprintln!("{skipped}; {:.3} s saved, {runout_mm} mm left, {off_mm} mm off", measured.saved_s);
            // A wave of three crests is on no diameter, and eccentricity neither, but to second order.
            assert!((skipped.stock_mm - 0.1 - unknown_mm).abs() < 1e-4, "{skipped:?}");
            assert_eq!((skipped.infeed_turns, skipped.spark_out_turns), (infeed_turns, spark_out_turns), "{skipped:?}");
            assert!(*runout_mm < 1e-3 && off_mm.abs() < 3e-4, "{runout_mm} mm left, {off_mm} mm off");
        }
        let turns = f64::from(2 * (infeed_turns + spark_out_turns));
        assert!((measured.saved_s - turns).abs() < 0.6, "{} s of {turns} turns at one a second", measured.saved_s);
    }
}

/// With an infeed of its own in every turn the first pass begins its turns 218, 188, 162, 140, 126 and 116 µm above the journal: turns are
/// omitted up to the last that begins s + 41 µm above it, and the list loses as many values.
#[test]
fn turns_of_a_list_in_the_air_are_left_out_by_their_own_infeed() {
    let machine = grinder(0.2, 270.0);
    for (unknown_mm, infeed_turns, spark_out_turns) in [(0.0, 2, 0), (-0.03, 5, 0), (-0.05, 9, 1), (0.06, 0, 0)] {
        let mut job = measuring_job(unknown_mm);
        job.passes[0].infeed_of_turns_mm = vec![0.03, 0.026, 0.022, 0.014, 0.01, 0.006];
        let (measured, left) = measured_and_ground(&machine, &job).unwrap_or_else(|error| panic!("{error}"));
        for (skipped, (runout_mm, off_mm)) in measured.skipped.iter().zip(&left) {
            assert_eq!((skipped.infeed_turns, skipped.spark_out_turns), (infeed_turns, spark_out_turns), "{skipped:?}");
            assert!(*runout_mm < 1e-3 && off_mm.abs() < 3e-4, "{runout_mm} mm left, {off_mm} mm off");
        }
    }
}

/// A part with more stock than the start of the infeed is not touched: the wheel stays at its home position.
#[test]
fn a_part_with_too_much_stock_is_refused_before_the_wheel_comes_near_it() {
    let machine = grinder(0.2, 270.0);
    let error = measured_and_ground(&machine, &measuring_job(0.08)).unwrap_err();
    assert!(matches!(&*error, PlanError::TooMuchStock { lobe, .. } if lobe == "J1"), "{error:?}");
    let text = error.to_string();
    assert!(text.contains("0.18") && text.contains("0.1770 mm are the most"), "{text}");
    let error = measured_and_ground(&machine, &measuring_job(-0.09)).unwrap_err();
    assert!(error.to_string().contains("nothing to grind"), "{error}");
}

#[test]
fn a_margin_below_what_a_diameter_does_not_show_and_jobs_that_cannot_be_measured_are_refused() {
    let machine = grinder(0.2, 270.0);
    let mut job = measuring_job(0.0);
    assert_eq!(job.check(&machine), Ok(()));
    let blind = MachineDescription { gauge: None, ..machine.clone() };
    assert!(
        JobSpec { correction: None, ..job.clone() }
            .check(&blind)
            .unwrap_err()
            .to_string()
            .contains("no in-process gauge")
    );
    job.rotary_indexing = true;
    assert!(matches!(job.check(&machine), Err(JobError::MeasuresNoStock { .. })));
    job.rotary_indexing = false;
    job.measure_stock = Some(StockSpec { margin_mm: 0.01, speed_rad_s: TURN_RAD });
    let error = job.check(&machine).unwrap_err();
    assert!(error.to_string().contains("is 10.0, and the raw part may be off by 12.0 um"), "{error}");
}
