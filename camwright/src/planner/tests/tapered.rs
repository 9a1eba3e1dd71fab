// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lobes with taper and crown: the same motion as for straight lobes, the rims that can grind them, and what is refused.

use super::*;
use crate::cam::outline::Outline;
use crate::job::grinding::JobError;
use crate::machine::description::{MagazineWheel, WheelChanger};

const AXIAL: AxialProfile = AxialProfile { taper_mm: 0.010, crown_mm: 0.003 };

/// The machine of the other tests with a rim that grinds [`AXIAL`] into the lobes of 14 mm.
fn tapering() -> MachineDescription {
    let mut machine = machine();
    machine.wheel.rim = -AXIAL.over(14.0, machine.wheel.width_mm);
    machine
}

fn tapered() -> JobSpec {
    let mut job = job();
    job.lobes.iter_mut().for_each(|lobe| lobe.axial = Some(AXIAL));
    job
}

fn refusal_on(machine: &MachineDescription, job: &JobSpec) -> PlanError {
    plan_job(job, machine, 60.0, None).map(|_| ()).expect_err("must be refused")
}

/// A rim with a profile moves X and C as a straight one, to the bit; the sections of a lobe have the shape.
#[test]
fn a_tapered_lobe_has_the_motion_of_a_straight_one() {
    let straight = plan_job(&job(), &machine(), 60.0, None).expect("straight lobes");
    let planned = plan_job(&tapered(), &tapering(), 60.0, None).expect("tapered lobes");
    assert_eq!(planned.plan, straight.plan);
    let sections = planned.lobes[0].design.sections();
    let above_um: Vec<f64> = sections.iter().map(|section| 1e3 * section.above_mm).collect();
    // A third of the taper and four ninths of the crown less.
    let wanted_um = [0.0, -10.0 / 3.0 - 4.0 / 3.0, 10.0 / 3.0 - 4.0 / 3.0];
    assert!(above_um.iter().zip(wanted_um).all(|(um, wanted)| (um - wanted).abs() < 1e-9), "{above_um:?}");
    assert_eq!(straight.lobes[0].design.sections().len(), 1);
    let near_mm = AxialProfile { taper_mm: AXIAL.taper_mm + 0.000_8, ..AXIAL };
    let mut near = tapered();
    near.lobes[2].axial = Some(near_mm);
    assert!(plan_job(&near, &tapering(), 60.0, None).is_ok(), "0.4 um off at the ends");
}

/// One thing wrong each: the refusal says what the wheel grinds and which rim would grind the lobe.
#[test]
fn rims_that_do_not_grind_the_lobe_are_refused() {
    let text = refusal_on(&machine(), &tapered()).to_string();
    let wanted = "lobe I1: taper_um is 10.000 and crown_um 3.000; wheel grinds 0.000 and 0.000 over the width of 14 mm, 8.000 um off where \
                  0.5 um are allowed; with wheel.rim.taper_um -17.857 and wheel.rim.crown_um -9.566 in the machine file it grinds the lobe";
    assert!(text.starts_with(wanted), "{text}");
    let text = refusal_on(&tapering(), &job()).to_string();
    assert!(text.contains("taper_um is 0.000 and crown_um 0.000; wheel grinds 10.000 and 3.000"), "{text}");
    assert!(text.contains("wheel.rim.taper_um 0.000 and wheel.rim.crown_um 0.000"), "{text}");
    let mut turned_round = tapered();
    turned_round.lobes[1].axial = Some(-AXIAL);
    assert!(refusal_on(&tapering(), &turned_round).to_string().starts_with("lobe E1: taper_um is -10.000"));
    let change = |change: fn(&mut JobSpec)| {
        let mut job = tapered();
        change(&mut job);
        refusal_on(&tapering(), &job).to_string()
    };
    let text = change(|job| job.lobes[0].axial = Some(AxialProfile { taper_mm: f64::NAN, crown_mm: 0.0 }));
    assert_eq!(text, "lobe I1: taper_mm is NaN; it must be -0.5 to 0.5");
    let text = change(|job| job.lobes[0].axial = Some(AxialProfile { taper_mm: 0.0, crown_mm: 0.6 }));
    assert_eq!(text, "lobe I1: crown_mm is 0.6; it must be -0.5 to 0.5");
    let text = change(|job| job.stock_mm = 0.002);
    assert!(text.starts_with("lobe I1: taper_um and crown_um put a section 2.083 um above the contour"), "{text}");
    let text = change(|job| job.lobes[3].name = "I1-tail".into());
    assert!(text.contains("section I1-tail has the name of lobe I1-tail"), "{text}");
    let text = change(|job| {
        let wide = LobeSpec { width_mm: 40.0, ..job.lobes[0].clone() };
        let plunges = wide.side_by_side(3.0, 25.0).expect("plunges");
        job.lobes.splice(0..1, plunges);
        job.lobes.truncate(2);
    });
    assert!(
        text.starts_with("lobe I1 is wider than the wheel of 25 mm: plunges side by side need a straight rim"),
        "{text}"
    );
    let text = change(|job| {
        let many = (0..11).map(|index| LobeSpec { station: format!("LS{}", index % 8 + 1), ..job.lobes[0].clone() });
        job.lobes = many.enumerate().map(|(i, lobe)| LobeSpec { name: format!("L{i}"), ..lobe }).collect();
        job.lobes.truncate(8);
        job.lobes.iter_mut().for_each(|lobe| lobe.axial = Some(AXIAL));
        job.lobes[7].axial = Some(-AXIAL);
    });
    assert!(text.starts_with("lobe L7: taper_um is -10.000"), "eight tapered lobes have 24 sections: {text}");
}

/// The rim stands out of the middle of the wheel towards the raw part, and the check of the plan knows it.
#[test]
fn the_highest_place_of_the_rim_stands_off_the_blank() {
    // The wheel stands 0.36 mm off the contour: a stock of 0.353 mm leaves 7 um, and the rim stands out by 8 um.
    let with_stock = |stock_mm: f64, machine: &MachineDescription, axial: Option<AxialProfile>| {
        let mut job = job();
        job.stock_mm = stock_mm;
        job.lobes.truncate(1);
        job.lobes[0].phase_rad = 0.0;
        job.lobes[0].axial = axial;
        plan_job(&job, machine, 60.0, None)
    };
    assert!(with_stock(0.353, &machine(), None).is_ok());
    let highest_mm = tapering().wheel.rim.over(25.0, 14.0).highest_mm();
    assert!((highest_mm - 0.008).abs() < 1e-12, "{highest_mm}");
    let error = with_stock(0.353, &tapering(), Some(AXIAL)).map(|_| ()).expect_err("the rim touches");
    assert!(matches!(error, PlanError::TouchesBlank { .. }), "{error}");
    assert!(with_stock(0.351, &tapering(), Some(AXIAL)).is_ok());
}

/// Corners that are sharper than a section lies inside the contour have no parallel curve there.
#[test]
fn sharp_corners_are_refused() {
    let of_corner = |radius_mm: f64, taper_mm: f64| {
        let outline = Outline::polygon(4, 30.0, radius_mm, 0.02 * radius_mm).expect("a square");
        let axial = AxialProfile { taper_mm, crown_mm: 0.0 };
        let mut job = job();
        job.profiles[0] = ProfileSpec {
            base_radius_mm: outline.smallest_mm(),
            lift: LiftLaw::from_outline(outline).expect("a law"),
            follower: Follower::KnifeEdge { offset_mm: 0.0 },
            ..job.profiles[0].clone()
        };
        job.lobes.truncate(1);
        job.lobes[0].axial = Some(axial);
        let mut machine = machine();
        machine.wheel.rim = -axial.over(14.0, machine.wheel.width_mm);
        plan_job(&job, &machine, 60.0, None)
    };
    let error = of_corner(0.1, 0.25).map(|_| ()).expect_err("0.125 mm inside");
    let PlanError::SharpForTaper { radius_mm, inside_mm, .. } = &error else { panic!("{error}") };
    assert!((inside_mm - 0.125).abs() < 1e-12 && (radius_mm - 0.1).abs() < 0.01, "{error}");
    let other = of_corner(0.5, 0.25).map(|_| ());
    assert!(!matches!(other, Err(PlanError::SharpForTaper { .. })), "{other:?}");
}

fn two_wheels(first: AxialProfile, second: AxialProfile) -> MachineDescription {
    let mut machine = machine();
    let wheel = |name: &str, rim| MagazineWheel {
        name: name.into(),
        wheel: WheelDescription { rim, ..machine.wheel },
        setting_error_mm: 0.0,
    };
    let wheels = vec![wheel("roughing", first), wheel("finishing", second)];
    machine.wheel = wheels[0].wheel;
    machine.wheel_changer = Some(WheelChanger { change_s: 5.0, min_x_mm: 100.0, wheels, mounted: 0 });
    machine
}

/// Roughing by a straight wheel and finishing by one with a profile: allowed where enough is left and the later wheel begins above it.
#[test]
fn another_wheel_may_rough_a_tapered_lobe() {
    let rim = tapering().wheel.rim;
    let job = |left_mm: f64, approach_mm: f64| {
        let mut job = tapered();
        job.lobes.truncate(2);
        let rough = PassSpec { name: "rough".into(), total_infeed_mm: 0.36, ..job.passes[0].clone() };
        let (total_infeed_mm, infeed_per_block_mm) = (left_mm + approach_mm, (left_mm + approach_mm) / 3600.0);
        let finish = PassSpec { total_infeed_mm, infeed_per_block_mm, ..job.passes[0].clone() };
        job.passes = vec![rough, finish];
        job.visit_by_wheels(&vec![vec![0, 1]; 2], approach_mm).expect("visits");
        job
    };
    let machine = two_wheels(AxialProfile::default(), rim);
    let planned = plan_job(&job(0.04, 0.02), &machine, 60.0, None).expect("roughed by a straight wheel");
    let sections: Vec<usize> = planned.lobes.iter().map(|lobe| lobe.design.sections().len()).collect();
    assert_eq!(sections, [0, 0, 3, 3]);
    let text = refusal_on(&machine, &job(0.002, 0.02)).to_string();
    assert!(text.starts_with("lobe I1-rough: the rim of its wheel cuts 2.083 um deeper than its middle"), "{text}");
    assert!(text.contains("leave 2.000 um"), "{text}");
    let text = refusal_on(&machine, &job(0.04, 0.007)).to_string();
    assert!(
        text.contains("8.000 um higher than its middle") && text.contains("wheel_approach_mm is 7.000 um"),
        "{text}"
    );
    // The other way round the second wheel leaves the lobe straight.
    let error = refusal_on(&two_wheels(rim, AxialProfile::default()), &job(0.04, 0.02));
    let PlanError::Job(JobError::OtherRim(other)) = &error else { panic!("{error}") };
    assert_eq!((other.rim_key.as_str(), other.wheel.as_str()), ("wheel_changer.wheels.0.rim", " finishing"));
}
