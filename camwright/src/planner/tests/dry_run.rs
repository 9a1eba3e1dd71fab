// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A dry run goes the whole way of its job, farther out, and leaves the part as it is.

use super::*;

fn dry(stand_off_mm: f64) -> JobSpec {
    JobSpec { dry_run_mm: Some(stand_off_mm), ..job() }
}

#[test]
fn a_dry_run_takes_as_long_and_leaves_the_part_untouched() {
    let machine = machine();
    let (wet_job, dry_job) = (job(), dry(5.0));
    let (wet, dry) = (planned(&wet_job), planned(&dry_job));
    assert_eq!(dry.plan.segments.len(), wet.plan.segments.len());
    assert!((dry.plan.duration_s - wet.plan.duration_s).abs() < 0.1, "{} {}", dry.plan.duration_s, wet.plan.duration_s);
    assert_eq!((wet.plan.half, dry.plan.half), (crate::motion::plan::Half::Whole, crate::motion::plan::Half::NoPart));
    let lowest = |planned: &PlannedJob, job: &JobSpec| {
        let mut lowest = f64::INFINITY;
        let plan = planned.plan.clone();
        let (before, after) = untouched(job, planned, plan, &machine, |setpoint, report| {
            // At its work speed, which homing has not.
            if report.axes[Axis::C.index()].velocity > 4.0 {
                lowest = lowest.min(machine.axis(Axis::X).scale.position(setpoint.counts[Axis::X.index()]));
            }
        });
        (lowest, before == after)
    };
    let ((wet_mm, wet_same), (dry_mm, dry_same)) = (lowest(&wet, &wet_job), lowest(&dry, &dry_job));
    assert!((dry_mm - wet_mm - 5.0).abs() < 2e-5, "{dry_mm} {wet_mm}");
    assert!(dry_same && !wet_same, "the dry run leaves every bit of the outlines, the job does not");
}

/// Outlines of every lobe before and after a plan (mm).
fn untouched(
    job: &JobSpec,
    planned: &PlannedJob,
    plan: Plan,
    on: &MachineDescription,
    report: impl FnMut(&Setpoint, &TickReport),
) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let (_, fresh) = ground(job, planned, Plan { segments: Vec::new(), ..plan.clone() }, on, |_, _| {});
    let (_, machine) = ground(job, planned, plan, on, report);
    let radii = |machine: &Machine| machine.part().lobes().iter().map(|lobe| lobe.radii_mm().to_vec()).collect();
    (radii(&fresh), radii(&machine))
}

/// With C turning on from lobe to lobe, and from pass to pass, the leads go outwards with the path.
#[test]
fn a_dry_run_with_c_turning_on_leaves_the_part_untouched_too() {
    let machine = machine();
    let job = JobSpec { c_between_lobes: BetweenLobes::TurnsOn { margin_s: 0.02 }, ..dry(8.0) };
    let planned = planned(&job);
    let (before, after) = untouched(&job, &planned, planned.plan.clone(), &machine, |_, _| {});
    assert_eq!(before, after);
}

/// The wheel leaves a flank askew of its normal, so more is needed than stock and clearance: what the refusal says is enough.
#[test]
fn a_stand_off_that_leaves_too_little_room_is_refused_with_the_one_that_does() {
    for wrong in [0.0, -5.0, f64::NAN] {
        let error = plan_job(&dry(wrong), &machine(), 60.0, None).expect_err("refused");
        assert!(error.to_string().contains("dry_run.stand_off_mm"), "{wrong}: {error}");
    }
    let error = plan_job(&dry(1.0), &machine(), 60.0, None).expect_err("refused");
    let PlanError::DryRun { needed_mm, min_mm, .. } = error else { panic!("{error}") };
    assert!((needed_mm - 1.3).abs() < 1e-12 && min_mm > needed_mm && min_mm < 5.0, "{needed_mm} {min_mm}");
    assert!(plan_job(&dry(1.01 * min_mm), &machine(), 60.0, None).is_ok());
    let error = plan_job(&dry(60.0), &machine(), 60.0, None).expect_err("refused");
    assert!(matches!(error, PlanError::SoftLimit { axis: Axis::X, .. }), "{error}");
}
