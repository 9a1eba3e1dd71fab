// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Form compensation on simulated machines: what drives, structure and grinding leave is learned from part to part.

extern crate std;

use super::*;
use crate::cam::compensation::{Compensation, CompensationSpec, FormCurve, LearnedError, LobeLearning};
use crate::machine::description::Structure;

/// Four lobes with less stock: the same turns of spark-out decide the form.
fn short_job() -> JobSpec {
    let mut job = job();
    job.passes[0].total_infeed_mm = 0.072;
    job.passes[0].infeed_per_block_mm = 0.000_01;
    job.passes[0].spark_out_turns = 4;
    job.stock_mm = 0.06;
    job
}

fn drives() -> DriveSettings {
    DriveSettings {
        gain_error: 0.002,
        velocity_feed_forward: 0.995,
        friction_feed_forward: 0.8,
        velocity_loop_rad_s: Some(1200.0),
        velocity_integral_s: Some(0.01),
        max_force: Some(6000.0),
        coulomb_friction: 1.0,
        viscous_friction: 0.05,
        structure: Some(Structure { frequency_rad_s: 800.0, damping: 0.04, mass_share: 0.2 }),
        encoder_step_counts: 1.0,
        ..DriveSettings::IDEAL
    }
}

/// Parts one after the other, each ground with what was learned from those before it: the error of every lobe of each.
fn batch(job: &JobSpec, description: &MachineDescription, parts: usize) -> Vec<Vec<FormCurve>> {
    let spec = CompensationSpec::default();
    let mut learning: Vec<LobeLearning> = job.lobes.iter().map(|_| LobeLearning::new(&spec)).collect();
    let mut errors = Vec::new();
    for _ in 0..parts {
        let learned = job
            .lobes
            .iter()
            .zip(&learning)
            .map(|(lobe, learning)| LearnedError { lobe: lobe.name.clone(), correction: learning.correction.clone() });
        let job = JobSpec {
            compensation: Some(Compensation { spec, learned: learned.collect(), afresh: false }),
            ..job.clone()
        };
        let planned = plan_job(&job, description, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
        let (_, machine) = ground(&job, &planned, planned.plan.clone(), description, |_, _| {});
        let measured = planned.lobes.iter().map(|lobe| {
            let radii = machine.part().lobe(&lobe.design.name).expect("it was ground").radii_mm();
            FormCurve::measure(radii, &lobe.design.contour, lobe.design.phase_rad, 120).expect("radii")
        });
        let measured: Vec<FormCurve> = measured.collect();
        for (learning, error) in learning.iter_mut().zip(&measured) {
            learning.learn(&spec, error);
        }
        errors.push(measured);
    }
    errors
}

/// Drives with friction, a structure that swings and a mismatch of gains, and a wheel that deflects: after three parts every lobe is
/// within 2 µm from its highest to its lowest place, and nearer to size and form than the first.
#[test]
fn three_parts_teach_every_lobe_to_be_within_two_micrometres() {
    let description = MachineDescription { contact: Some(contact()), ..machine().with_drives(drives()) };
    let errors = batch(&short_job(), &description, 4);
    for (lobe, first) in errors[0].iter().enumerate() {
        let um: Vec<[f64; 2]> =
            errors.iter().map(|part| [part[lobe].peak_to_valley_mm() * 1e3, part[lobe].rms_mm() * 1e3]).collect();
        std::eprintln!("lobe {lobe}: peak to valley and rms (um) {um:?}");
        let last = &errors[3][lobe];
        assert!(last.peak_to_valley_mm() < 0.002, "lobe {lobe}: {um:?}");
        assert!(last.rms_mm() < 0.5 * first.rms_mm(), "lobe {lobe}: {um:?}");
    }
}

/// Drives with less feed-forward lag: no part is worse than the first.
#[test]
fn drives_that_lag_are_learned_without_ever_diverging() {
    let description = machine().with_drives(DriveSettings { velocity_feed_forward: 0.9, ..drives() });
    let errors = batch(&short_job(), &description, 6);
    let worst = |part: &[FormCurve]| part.iter().map(FormCurve::rms_mm).fold(0.0, f64::max);
    let um: Vec<f64> = errors.iter().map(|part| worst(part) * 1e3).collect();
    std::eprintln!("worst rms (um) {um:?}");
    assert!(um.iter().all(|part| *part <= um[0] + 0.1), "{um:?}");
    assert!(um[5] < 0.8 * um[0], "{um:?}");
}

#[test]
fn what_was_learned_of_nothing_has_the_plan_of_the_design() {
    let plain = planned(&short_job()).plan;
    let learned = vec![LearnedError { lobe: String::from("E1"), correction: FormCurve::default() }];
    let compensation = Some(Compensation { spec: CompensationSpec::default(), learned, afresh: false });
    assert_eq!(planned(&JobSpec { compensation, ..short_job() }).plan, plain);
}

/// Only the lobe that was learned has another path; its design is what it was.
#[test]
fn a_learned_lobe_has_a_path_of_its_own_and_the_same_design() {
    let plain = planned(&short_job());
    let correction = FormCurve::new(0.0, vec![[0.002, 0.0]]).expect("finite");
    let learned = vec![LearnedError { lobe: String::from("I2"), correction: correction.clone() }];
    let compensation = Some(Compensation { spec: CompensationSpec::default(), learned, afresh: false });
    let shifted = planned(&JobSpec { compensation, ..short_job() });
    for (lobe, (a, b)) in plain.lobes.iter().zip(&shifted.lobes).enumerate() {
        assert_eq!(a.design, b.design);
        assert_eq!(a.tool_path == b.tool_path, lobe != 2, "lobe {lobe}");
    }
    assert_ne!(plain.plan, shifted.plan);
}

#[test]
fn what_cannot_have_been_learned_is_refused() {
    let with = |lobe: &str, mm: f64| {
        let correction = FormCurve::new(mm, Vec::new()).expect("finite");
        let learned = vec![LearnedError { lobe: String::from(lobe), correction }];
        Some(Compensation { spec: CompensationSpec::default(), learned, afresh: false })
    };
    let error = refusal(|job| job.compensation = with("I9", 0.001)).to_string();
    assert!(error.contains("has learned of lobe I9, which is not in the job"), "{error}");
    let error = refusal(|job| job.compensation = with("I1", 0.03)).to_string();
    assert!(error.contains("lobe I1: the learned correction goes to 30.000 um"), "{error}");
    let error = refusal(|job| {
        job.compensation = with("I1", 0.001);
        job.compensation.as_mut().expect("it was set").spec.gain = 1.5;
    });
    assert!(error.to_string().contains("form_compensation.gain is 1.5"), "{error}");
    // Ten micrometres in waves of two degrees: the wheel cannot follow, and nothing is dropped.
    let error = refusal(|job| {
        let mut waves = vec![[0.0; 2]; 180];
        waves[179] = [0.006, 0.0];
        job.compensation = with("I1", 0.0);
        let compensation = job.compensation.as_mut().expect("it was set");
        compensation.spec = CompensationSpec { harmonics: 180, max_slope_mm_rad: 1.14, ..compensation.spec };
        compensation.learned[0].correction = FormCurve::new(0.0, waves).expect("finite");
    });
    assert!(matches!(error, PlanError::Compensated { .. }), "{error}");
    assert!(error.to_string().starts_with("lobe I1: corrected by what was learned, up to 6.000 um"), "{error}");
}
