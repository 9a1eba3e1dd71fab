// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The stiffness of machine and cut: measured on the journals, kept, and taken from what is kept.

use super::*;
use camwright::gauging::identify::Identified;
use camwright::gauging::journal::JournalError;
use camwright::job::grinding::{IdentificationSpec, KnownContact};
use camwright::machine::contact_law::ContactLaw;
use camwright::machine::description::Structure;
use camwright::motion::plan::Half;
use camwright::planner::identify;

/// Coulomb's friction of the wheelhead (N).
const FRICTION_N: f64 = 20.0;

/// A job in two feeds that measures its stiffness: nothing of what the description says about the contact is used.
pub(super) fn identifying_job() -> JobSpec {
    let mut job = job(GaugingMode::Exact);
    let rough = PassSpec { name: "rough".into(), total_infeed_mm: 0.162, spark_out_turns: 1, ..job.passes[0].clone() };
    job.passes.insert(0, rough);
    (job.passes[1].total_infeed_mm, job.passes[1].infeed_per_block_mm) = (0.03, 0.006 / 3600.0);
    job.identification =
        Some(IdentificationSpec { push_mm: 0.04, push_speed_mm_s: 0.05, max_n: 1000, only: false, afresh: false });
    job
}

/// With ordinary drives, whose motors work against friction, and a gauge of 0.2 µm: km and kg within a few per cent of what the
/// machine is, at both stations; and corrected with what was measured the journals are as round as with what is known.
#[test]
fn what_is_measured_on_the_journals_is_what_the_machine_is() {
    let ideal = grinder(0.2, 270.0);
    let mut machine = MachineDescription { contact: ideal.contact, gauge: ideal.gauge, ..cam_grinder() };
    if let Some(gauge) = &mut machine.gauge {
        (gauge.noise_mm, gauge.resolution_mm) = (2e-4, 1e-4);
    }
    machine.axes[1].drive = DriveSettings {
        kv_1_s: 200.0,
        velocity_feed_forward: 0.99,
        acceleration_feed_forward: 0.97,
        velocity_loop_rad_s: Some(120.0 * TURN_RAD),
        velocity_integral_s: Some(0.01),
        max_force: Some(6000.0),
        coulomb_friction: FRICTION_N,
        viscous_friction: 0.2,
        structure: Some(Structure { frequency_rad_s: 150.0 * TURN_RAD, damping: 0.04, mass_share: 0.2 }),
        encoder_step_counts: 1.0,
        encoder_noise_counts: 0.3,
        ..DriveSettings::IDEAL
    };
    let job = identifying_job();
    let first = plan_job(&job, &machine, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
    let mut cell = MachineUnderTest::new(&machine, &job);
    let logs = cell.run(&first.plan);
    let measured: Vec<Option<Identified>> = identify(&job, &machine, &first, &logs)
        .into_iter()
        .map(|measured| Some(measured.unwrap_or_else(|error| panic!("{error}"))))
        .collect();
    for (lobe, measured) in job.lobes.iter().zip(measured.iter().flatten()) {
        let z_mm = machine.station(&lobe.station).expect("it is there").position_mm;
        let truth = machine.contact.as_ref().and_then(|contact| contact.law(z_mm, WIDTH_MM)).expect("a law");
        let (km, kg, f0) = (measured.machine_n_mm, measured.grinding.grinding_n_mm, measured.grinding.threshold_n);
        eprintln!(
            "{}: km {:.1} +- {:.1} N/mm ({:.1}), kg {:.0} +- {:.0} ({:.0}), F0 {:.1} +- {:.1} N ({:.1}), one feed {:.0} with {:.0} too much, km/kg {:.4} by force, {:.4} +- {:.4} by decay",
            lobe.name,
            km.value,
            km.uncertainty,
            truth.machine_n_mm(),
            kg.value,
            kg.uncertainty,
            truth.grinding_n_mm(),
            f0.value,
            f0.uncertainty,
            truth.threshold_n(),
            measured.one_feed.grinding_n_mm,
            measured.one_feed.bias_n_mm,
            measured.comparison.by_force.value,
            measured.comparison.by_decay.value,
            measured.comparison.by_decay.uncertainty
        );
        assert!((km.value / truth.machine_n_mm() - 1.0).abs() < 0.03);
        assert!((kg.value - truth.grinding_n_mm()).abs() < 2.0 * kg.uncertainty && kg.uncertainty < 0.2 * kg.value);
        assert!((f0.value - truth.threshold_n()).abs() < 2.0 * f0.uncertainty);
        assert!(measured.comparison.agrees(2.0), "{:?}", measured.comparison);
        let known = measured.known_to;
        assert!((known.ratio.value / truth.machine_n_mm() * truth.grinding_n_mm() - 1.0).abs() < 0.05, "{known:?}");
        assert!((measured.law.grinding_n_mm() - truth.grinding_n_mm()).abs() < 2.0 * known.grinding_n_mm, "{known:?}");
        assert!((measured.law.threshold_n() - truth.threshold_n()).abs() < 2.0 * known.threshold_n, "{known:?}");
        assert!((measured.law.decay() - truth.decay()).abs() < 0.01, "{} {}", measured.law.decay(), truth.decay());
    }
    let decided =
        decide_corrections(&job, &machine, &first, &logs, &measured).unwrap_or_else(|error| panic!("{error}"));
    let second = plan_corrections(&job, &machine, &first, &decided).unwrap_or_else(|error| panic!("{error}"));
    let before: Vec<f64> = job.lobes.iter().map(|lobe| cell.runout_mm(&lobe.name).0).collect();
    cell.run(&second.plan);
    for ((lobe, before_mm), decided) in job.lobes.iter().zip(before).zip(decided) {
        let (after_mm, off_mm) = cell.runout_mm(&lobe.name);
        eprintln!("{decided}, scatter {:?}", decided.scatter_mm);
        eprintln!(
            "{}: {:.3} um, {:.3} um left, size {:+.3} um off",
            lobe.name,
            1e3 * before_mm,
            1e3 * after_mm,
            1e3 * off_mm
        );
        assert!(after_mm < 1.5e-3 && off_mm.abs() < 2e-3, "{}: {after_mm} mm left, {off_mm} mm off", lobe.name);
    }
}

#[test]
fn one_feed_and_no_turn_in_the_air_tell_no_stiffness() {
    let machine = grinder(0.2, 270.0);
    let mut job = identifying_job();
    job.passes[1].infeed_per_block_mm = job.passes[0].infeed_per_block_mm;
    assert!(matches!(job.check(&machine), Err(JobError::OneFeed { .. })));
    let mut job = identifying_job();
    job.stock_mm = 0.16;
    assert!(matches!(job.check(&machine), Err(JobError::NoAir { .. })));
}

/// A machine whose description is wrong by half: with what was kept for it, which is right, its journals come out round all the same.
#[test]
fn what_is_kept_for_the_machine_beats_its_description() {
    let truth = grinder(0.2, 270.0);
    let mut changed = truth.clone();
    if let Some(contact) = &mut changed.contact {
        contact.stiffness.iter_mut().for_each(|at| at.n_mm *= 1.5);
    }
    let left = |stiffness: StiffnessSource| {
        let mut job = job(GaugingMode::Exact);
        let known = |lobe: &LobeSpec| {
            let z_mm = truth.station(&lobe.station).expect("it is there").position_mm;
            let law = truth.contact.as_ref().and_then(|contact| contact.law(z_mm, WIDTH_MM)).expect("a law");
            KnownContact { lobe: lobe.name.clone(), law }
        };
        let contacts = job.lobes.iter().map(known).collect();
        if let Some(spec) = &mut job.correction {
            (spec.stiffness, spec.contacts) = (stiffness, contacts);
        }
        let first = plan_job(&job, &changed, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
        let mut cell = MachineUnderTest::new(&truth, &job);
        let logs = cell.run(&first.plan);
        let decided = decide_corrections(&job, &changed, &first, &logs, &[]).unwrap_or_else(|error| panic!("{error}"));
        let before_mm = cell.runout_mm("J1").0;
        let second = plan_corrections(&job, &changed, &first, &decided).unwrap_or_else(|error| panic!("{error}"));
        cell.run(&second.plan);
        cell.runout_mm("J1").0 / before_mm
    };
    let (kept, nominal) = (left(StiffnessSource::Kept), left(StiffnessSource::Nominal));
    eprintln!("left: by what is kept {kept:.4}, by the description {nominal:.4}");
    assert!(kept < 0.011 && nominal > 0.1, "{kept} {nominal}");
}

#[test]
fn a_job_that_insists_on_what_is_kept_is_refused_where_nothing_is() {
    let machine = grinder(0.2, 270.0);
    let mut job = job(GaugingMode::Exact);
    if let Some(spec) = &mut job.correction {
        spec.stiffness = StiffnessSource::Kept;
    }
    assert_eq!(job.check(&machine), Err(JobError::NothingKept { lobe: "J1".into() }));
    let identifies = JobSpec { identification: identifying_job().identification, ..identifying_job() };
    assert_eq!(identifies.check(&machine), Ok(()));
    let law = ContactLaw::new(1e4, 3e4, 15.0).expect("good");
    if let Some(spec) = &mut job.correction {
        spec.contacts.push(KnownContact { lobe: "J9".into(), law });
    }
    assert_eq!(job.check(&machine), Err(JobError::KeptElsewhere { lobe: "J9".into() }));
}

/// The log does not contain turns that a hold adds to the first journal's cut, so that journal gives no stiffness; the second one,
/// with an undisturbed cut, gives the same result as without the hold.
#[test]
fn a_held_journal_yields_no_stiffness_and_later_ones_do() {
    let machine = grinder(0.2, 270.0);
    let mut job = identifying_job();
    if let Some(identification) = &mut job.identification {
        identification.only = true;
    }
    let first = plan_job(&job, &machine, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(first.plan.half, Half::Whole, "nothing follows what only measures");
    let mut cell = MachineUnderTest::new(&machine, &job);
    let mut logs = cell.run(&first.plan);
    let whole = identify(&job, &machine, &first, &logs);
    let middle = logs[0].gauged.len() / 2;
    let later = logs[0].gauged[middle..].iter_mut();
    later.for_each(|gauged| gauged.c_rad += 2.0 * TURN_RAD);
    logs[1].gauged.iter_mut().for_each(|gauged| gauged.c_rad += 2.0 * TURN_RAD);
    let held = identify(&job, &machine, &first, &logs);
    assert!(matches!(&held[0], Err(error) if error.source == JournalError::Held { turns: 2.0 }), "{:?}", held[0]);
    let [Ok(held), Ok(whole)] = [&held[1], &whole[1]] else { panic!("{:?}", held[1]) };
    assert!((held.law.decay() - whole.law.decay()).abs() < 1e-9, "{held:?} {whole:?}");
}
