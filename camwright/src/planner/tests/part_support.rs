// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
use super::*;
use crate::cam::form::Form;
use crate::job::part_support::{HeadstockGrip, PartSupport};
use crate::machine::description::{ContactMode, SteadyRest, WorkholdingDescription};
use crate::planner::deflection::Deflections;

/// A slender part between centres on a grinder with a steady rest.
fn supported() -> (JobSpec, MachineDescription) {
    let machine = MachineDescription {
        contact: Some(contact()),
        workholding: Some(WorkholdingDescription {
            headstock_n_mm: 1.5e5,
            chuck_tilt_n_mm_rad: Some(5e9),
            tailstock_n_mm: Some(1e5),
            steady_rest: Some(SteadyRest { n_mm: 6e4, jaw_width_mm: 10.0 }),
        }),
        ..machine()
    };
    let mut job = job();
    job.passes[0].total_infeed_mm = 0.108;
    job.passes[0].infeed_per_block_mm = 0.000_01;
    job.passes[0].spark_out_turns = 6;
    job.stock_mm = 0.09;
    job.lobes.truncate(2);
    job.part_support = Some(PartSupport {
        diameter_mm: 28.0,
        modulus_n_mm2: 2.1e5,
        headstock_z_mm: -110.0,
        length_mm: 400.0,
        grip: HeadstockGrip::Centre,
        tailstock: true,
        steady_rest_z_mm: None,
    });
    (job, machine)
}

fn with_rest(job: &JobSpec, z_mm: f64) -> JobSpec {
    let support = job.part_support.map(|support| PartSupport { steady_rest_z_mm: Some(z_mm), ..support });
    JobSpec { part_support: support, ..job.clone() }
}

/// Form errors of the ground lobes and their forecasts (mm), with the stiffness that each was ground with (N/mm).
fn errors_mm(job: &JobSpec, machine: &MachineDescription) -> Vec<(f64, f64, f64)> {
    let planned = plan_job(job, machine, 60.0, None).unwrap_or_else(|error| panic!("{error}"));
    let mut loaded = loaded(job, &planned, machine);
    for lobe in &planned.lobes {
        let part_mm_n = lobe.design.part_compliance_mm_n(machine, 0.0);
        loaded.set_part_compliance(&lobe.design.name, part_mm_n).expect("it is loaded");
    }
    let motion = Prepared::new(Motion::Plan(Arc::new(planned.plan.clone())), machine).expect("a plan");
    let mut closed_loop = ClosedLoop::direct(loaded);
    closed_loop.simulate(Box::new(motion), |_, _| {}).unwrap_or_else(|error| panic!("{error}"));
    let ground = closed_loop.into_machine();
    let error = |(index, lobe): (usize, &PlannedLobe)| {
        let design = &lobe.design;
        let law = design.contact_law(machine).expect("a contact");
        let predicted = Deflections::from_lobe(&planned.plan, index, job.stock_mm, &law, machine).expect("it is cut");
        let radii = ground.part().lobe(&design.name).expect("it was loaded").radii_mm();
        let form = Form::measure(radii, &design.contour, design.phase_rad).expect("radii");
        (form.largest.deviation_mm, predicted.left_mm, law.machine_n_mm())
    };
    planned.lobes.iter().enumerate().map(error).collect()
}

/// The error that a slender part leaves on its lobes is predicted, with and without steady rest; the rest makes it smaller. Vibration
/// modes of the machine, which settle in the spark-out, change neither.
#[test]
fn the_forecast_holds_on_a_slender_part_with_and_without_steady_rest() {
    let (job, machine) = supported();
    let mut vibrating = machine.clone();
    vibrating.contact.as_mut().expect("a contact").modes =
        vec![ContactMode { frequency_rad_s: 3000.0, damping: 0.5, compliance_share: 0.6 }];
    let rest_mm = 115.0;
    let (alone, rested) = (errors_mm(&job, &machine), errors_mm(&with_rest(&job, rest_mm), &machine));
    let moving = errors_mm(&job, &vibrating);
    for found in alone.iter().chain(&rested).chain(&moving) {
        let (error_mm, predicted_mm, n_mm) = *found;
        let off_mm = error_mm - predicted_mm;
        assert!(off_mm.abs() < 1e-4 + 0.02 * predicted_mm, "{error_mm} mm, reported {predicted_mm} mm at {n_mm} N/mm");
    }
    for ((alone_mm, _, alone_n_mm), (rested_mm, _, rested_n_mm)) in alone.iter().zip(&rested) {
        assert!(*rested_n_mm > 1.5 * alone_n_mm, "{alone_n_mm} N/mm, {rested_n_mm} N/mm with rest");
        assert!(*rested_mm < 0.7 * alone_mm, "{alone_mm} mm, {rested_mm} mm with rest");
    }
}

/// The stiffness of each lobe is the series of machine, supports and bar; without the keys it is the machine's, to the bit.
#[test]
fn the_part_stands_in_series_with_the_machine() {
    let (job, machine) = supported();
    let planned = plan_job(&job, &machine, 60.0, None).expect("it can be planned");
    let shaft = job.part_support.expect("a support").shaft(&machine).expect("the machine has it");
    for lobe in &planned.lobes {
        let z_mm = lobe.design.z_mm(&machine).expect("a station");
        let rigid = machine.contact_law_at(z_mm, lobe.design.width_mm).expect("a contact");
        let wanted = 1.0 / (1.0 / rigid.machine_n_mm() + shaft.compliance_mm_n(z_mm));
        let law = lobe.design.contact_law(&machine).expect("a contact");
        assert!((law.machine_n_mm() / wanted - 1.0).abs() < 1e-14);
        assert!(law.machine_n_mm() < 0.5 * rigid.machine_n_mm(), "{} N/mm", law.machine_n_mm());
        let without = LobeDesign { part_support: None, ..lobe.design.clone() };
        assert_eq!(without.contact_law(&machine), Some(rigid));
        let (nominal, _) = lobe.contact(&job, &machine, None).expect("a contact");
        assert_eq!(nominal, law, "a journal is corrected with the same stiffness");
    }
    let chatter = |part_mm_n: f64| {
        chatter::ContactCompliance::from_machine(&machine, 85.0).expect("a contact").with_part(part_mm_n)
    };
    assert!((chatter(1e-5).spring_mm_n - chatter(0.0).spring_mm_n - 1e-5).abs() < 1e-18);
    assert_eq!(chatter(0.0), chatter::ContactCompliance::from_machine(&machine, 85.0).expect("a contact"));
}

/// Of a deflection that part and machine share, the part has its own spring and the share that the machine file gives it.
#[test]
fn a_single_contact_feels_the_share_of_the_slender_part() {
    let contact = contact();
    let z_mm = 85.0;
    let machine_mm_n = 1.0 / contact.machine_n_mm(z_mm);
    assert_eq!(contact.part_share_with(z_mm, 0.0).to_bits(), contact.part_share.to_bits());
    let share = contact.part_share_with(z_mm, 3.0 * machine_mm_n);
    assert!((share - (contact.part_share + 3.0) / 4.0).abs() < 1e-14, "{share}");
}

/// A machine without the section takes a part without compliance only, and a compliance must be a number.
#[test]
fn a_machine_without_supports_takes_no_compliance() {
    let (job, machine) = supported();
    let planned = plan_job(&job, &machine, 60.0, None).expect("it can be planned");
    let name = &planned.lobes[0].design.name;
    let mut held = loaded(&job, &planned, &machine);
    for (part_mm_n, is_taken) in [(0.0, true), (1e-4, true), (-1e-4, false), (f64::NAN, false), (f64::INFINITY, false)]
    {
        assert_eq!(held.set_part_compliance(name, part_mm_n).is_ok(), is_taken, "{part_mm_n}");
    }
    assert!(held.set_part_compliance("X9", 1e-4).is_err());
    let mut rigid = loaded(&job, &planned, &MachineDescription { workholding: None, ..machine });
    assert!(rigid.set_part_compliance(name, 0.0).is_ok() && rigid.set_part_compliance(name, 1e-4).is_err());
}

#[test]
fn supports_that_do_not_fit_are_refused() {
    let (job, machine) = supported();
    let refused = |change: &dyn Fn(&mut PartSupport), on: &MachineDescription| {
        let mut job = job.clone();
        change(job.part_support.as_mut().expect("a support"));
        plan_job(&job, on, 60.0, None).expect_err("it is refused").to_string()
    };
    let bare = MachineDescription { workholding: None, ..machine.clone() };
    let rigid = MachineDescription { contact: None, ..machine.clone() };
    let without = |change: fn(&mut WorkholdingDescription)| {
        let mut machine = machine.clone();
        change(machine.workholding.as_mut().expect("supports"));
        machine
    };
    let no_chuck = without(|workholding| workholding.chuck_tilt_n_mm_rad = None);
    let no_tailstock = without(|workholding| workholding.tailstock_n_mm = None);
    let no_rest = without(|workholding| workholding.steady_rest = None);
    let chucked = |support: &mut PartSupport| (support.grip, support.tailstock) = (HeadstockGrip::Chuck, false);
    for (change, on, says) in [
        (
            &(|_: &mut PartSupport| {}) as &dyn Fn(&mut PartSupport),
            &bare,
            "states no stiffness of its supports; add workholding",
        ),
        (&|_: &mut PartSupport| {}, &rigid, "states no contact"),
        (&chucked, &no_chuck, "add workholding.chuck_tilt_n_m_rad"),
        (&|_: &mut PartSupport| {}, &no_tailstock, "add workholding.tailstock_stiffness_n_um"),
        (&|support: &mut PartSupport| support.steady_rest_z_mm = Some(130.0), &no_rest, "add workholding.steady_rest"),
        (&|support: &mut PartSupport| support.tailstock = false, &machine, "needs the tailstock"),
        (&|support: &mut PartSupport| support.steady_rest_z_mm = Some(399.0), &machine, "it must be -105 to 285"),
        (&|support: &mut PartSupport| support.steady_rest_z_mm = Some(f64::NAN), &machine, "it must be -105 to 285"),
        (
            &|support: &mut PartSupport| support.steady_rest_z_mm = Some(80.0),
            &machine,
            "under the jaws of the steady rest",
        ),
        (&|support: &mut PartSupport| support.headstock_z_mm = 38.0, &machine, "a lobe must stand between"),
        (
            &|support: &mut PartSupport| support.diameter_mm = 0.0,
            &machine,
            "part_support.diameter_mm is 0; it must be 1 to 1000",
        ),
        (&|support: &mut PartSupport| support.length_mm = f64::INFINITY, &machine, "part_support.length_mm is inf"),
        (&|support: &mut PartSupport| support.modulus_n_mm2 = 210.0, &machine, "1 to 1000 GPa"),
        (
            &|support: &mut PartSupport| support.headstock_z_mm = f64::NAN,
            &machine,
            "part_support.headstock_z_mm is NaN",
        ),
    ] {
        let message = refused(change, on);
        assert!(message.contains(says), "{message}: {says}");
    }
    let mut chuck = job.clone();
    chucked(chuck.part_support.as_mut().expect("a support"));
    assert!(plan_job(&chuck, &machine, 60.0, None).is_ok(), "a chuck alone holds a part");
}
