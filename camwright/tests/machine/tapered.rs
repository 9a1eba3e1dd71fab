// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lobes ground by a rim with a profile: every section is a parallel curve of the design, and one deflection carries all of them.

use super::sections::{self, radii};
use super::turned::{Eccentric, WHEEL_MM};
use super::{ideal, machine};
use camwright::cam::contour::Contour;
use camwright::cam::follower::Follower;
use camwright::cam::form::Form;
use camwright::cam::lift::LiftLaw;
use camwright::job::axial_shape::profile_of_sections;
use camwright::machine::axial_profile::AxialProfile;
use camwright::machine::description::{Axis, AxisScale, ContactDescription, MachineDescription, StiffnessAt};
use camwright::math::units::TURN_RAD;
use camwright::simulation::Machine;
use camwright::simulation::workpiece::{DEFAULT_AZIMUTHS, Lobe, WheelCentre};
use camwright::toolpath::wheel_path::ToolPath;

const STATION_MM: f64 = 60.0;
/// Positions of the wheel in a turn: cusps between them are below 1 nm.
const POSITIONS: u32 = 40_000;
const RAW_MM: f64 = 20.05;
/// Width of lobe and wheel.
const LOBE_MM: f64 = 15.0;
const WIDTH_MM: f64 = 25.0;
/// 10 µm of taper and 4 µm of crown over the lobe.
const AXIAL: AxialProfile = AxialProfile { taper_mm: 0.010, crown_mm: 0.004 };
/// The lobe, its end at the headstock and that at the tailstock: name and middle.
const SECTIONS: [(&str, f64); 3] = [("T", 0.0), ("T-head", -5.0), ("T-tail", 5.0)];

fn grinder(contact: Option<ContactDescription>) -> MachineDescription {
    let mut description = MachineDescription { contact, ..ideal() };
    description.wheel.width_mm = WIDTH_MM;
    description.wheel.rim = -AXIAL.over(LOBE_MM, WIDTH_MM);
    description
}

pub(crate) fn loaded(description: &MachineDescription) -> Machine {
    let mut machine = machine(description);
    for (name, offset_mm) in SECTIONS {
        let outline = (offset_mm, LOBE_MM / 3.0, vec![RAW_MM; DEFAULT_AZIMUTHS]);
        machine.load_section(name, "LS1", outline, None).expect("a raw section");
    }
    machine
}

/// A machine as it stands in keyframes: any machine with the rim of these tests.
pub(crate) fn with_rim(mut description: MachineDescription) -> MachineDescription {
    (description.wheel.width_mm, description.wheel.rim) = (WIDTH_MM, -AXIAL.over(LOBE_MM, WIDTH_MM));
    description
}

/// Turns of C with X on the path of a disc and the table at a position (mm).
fn turn(machine: &mut Machine, disc: Eccentric, (z_mm, turns): (f64, f64)) {
    sections::turn(machine, disc, (z_mm, turns, 6000));
}

/// A disc, and a lobe with hollow flanks, ground by the rim at many places of its width, with the centre of the wheel on the path for the
/// contour: every section is the parallel curve at the distance −h within 0.01 µm, whatever the sign of h.
#[test]
fn every_section_is_the_parallel_curve_of_the_design() {
    let lift = LiftLaw::from_fn(|cam_angle| 2.5 * (1.0 - (4.0 * cam_angle).cos())).expect("a lift");
    let follower = Follower::Roller { radius_mm: 12.0, offset_mm: 0.0 };
    let hollow = Contour::from_lift(&lift, &follower, 20.0).expect("a lobe");
    assert!(hollow.largest_wheel_radius_mm().is_some_and(|largest_mm| largest_mm > WHEEL_MM), "its flanks are hollow");
    let disc = Contour::eccentric(3.0, 20.0).expect("a disc");
    for (name, contour) in [("disc", disc), ("lobe", hollow)] {
        let path = ToolPath::for_wheel(&contour, WHEEL_MM).expect("a path");
        for share in [-0.5, -1.0 / 3.0, 0.0, 0.2, 0.5] {
            let rim_mm = -AXIAL.height_mm(share * LOBE_MM, LOBE_MM);
            let mut lobe = Lobe::new("T".into(), 0, 5.0, vec![32.0; DEFAULT_AZIMUTHS]).expect("a blank");
            for position in 0..POSITIONS {
                let azimuth_rad = f64::from(position) * TURN_RAD / f64::from(POSITIONS);
                let centre_mm = path.sample(azimuth_rad).value + WHEEL_MM;
                lobe.pass(WheelCentre { azimuth_rad, centre_mm, radius_mm: WHEEL_MM + rim_mm }, true);
            }
            let form = Form::measure_parallel(lobe.radii_mm(), &contour, 0.0, -rim_mm).expect("radii");
            let off_um = 1e3 * form.largest.deviation_mm;
            eprintln!(
                "{name} at {share:+.3} of the width: {:+.2} um from the contour, {off_um:+.4} um off",
                -1e3 * rim_mm
            );
            assert!(off_um.abs() < 0.01, "{name} at {share}: {off_um} um");
            let contour_mm = Form::measure(lobe.radii_mm(), &contour, 0.0).expect("radii").mean_mm();
            assert!((contour_mm + rim_mm).abs() < 1e-5, "{name} at {share}: {contour_mm} mm, {rim_mm} mm");
        }
    }
}

/// The machine without deflection: form of every section within 0.05 µm of its own design, taper and crown within 0.01 µm, in front of the
/// middle of the wheel and beside it, where the parabola gives a taper of its own.
#[test]
fn taper_and_crown_are_ground_and_recovered() {
    let disc = Eccentric { radius_mm: 19.9, offset_mm: 0.1 };
    let contour = Contour::eccentric(0.1, 19.9).expect("a disc");
    for aside_mm in [0.0, 2.0] {
        let mut description = grinder(None);
        description.axes[Axis::X.index()].scale = AxisScale::Linear { counts_per_mm: 10_000_000 };
        let mut machine = loaded(&description);
        turn(&mut machine, disc, (STATION_MM + aside_mm, 2.0));
        // The section stands at −aside from the middle of the wheel.
        let wanted_mm = SECTIONS.map(|(_, offset_mm)| AXIAL.height_mm(offset_mm - aside_mm, LOBE_MM));
        let mut means_mm = [0.0; 3];
        for (index, (name, _)) in SECTIONS.into_iter().enumerate() {
            let form = Form::measure_parallel(radii(&machine, name), &contour, 0.0, wanted_mm[index]).expect("radii");
            let off_um = 1e3 * form.largest.deviation_mm;
            assert!(off_um.abs() < 0.05, "{name}: {off_um} um");
            means_mm[index] = wanted_mm[index] + form.mean_mm();
        }
        let found = profile_of_sections(means_mm);
        let wanted = profile_of_sections(wanted_mm);
        let [taper_um, crown_um] =
            [found.taper_mm - wanted.taper_mm, found.crown_mm - wanted.crown_mm].map(|mm| 1e3 * mm);
        eprintln!("{aside_mm} mm aside: taper {:.4} um, crown {:.4} um", 1e3 * found.taper_mm, 1e3 * found.crown_mm);
        assert!(taper_um.abs() < 0.01 && crown_um.abs() < 0.02, "{taper_um} um, {crown_um} um");
        assert!((wanted.crown_mm - AXIAL.crown_mm).abs() < 1e-12);
        let of_parabola_mm = 8.0 * AXIAL.crown_mm * aside_mm / LOBE_MM;
        assert!((wanted.taper_mm - AXIAL.taper_mm - of_parabola_mm).abs() < 1e-12);
    }
}

/// A straight rim grinds three sections as it grinds one lobe of their width, to the bit.
#[test]
fn a_straight_rim_grinds_three_sections_as_one_lobe() {
    let disc = Eccentric { radius_mm: 19.9, offset_mm: 0.1 };
    let mut description = grinder(None);
    description.wheel.rim = AxialProfile::default();
    let mut divided = loaded(&description);
    let mut whole = machine(&description);
    whole.load_lobe("T", "LS1", LOBE_MM, vec![RAW_MM; DEFAULT_AZIMUTHS]).expect("a raw lobe");
    for machine in [&mut divided, &mut whole] {
        turn(machine, disc, (STATION_MM, 2.0));
    }
    for (name, _) in SECTIONS {
        assert_eq!(radii(&divided, name), radii(&whole, "T"), "{name}");
    }
}

fn soft() -> ContactDescription {
    ContactDescription {
        stiffness: vec![StiffnessAt { z_mm: STATION_MM, n_mm: 2e4 }],
        grinding_n_mm2: 1.5e3,
        threshold_n_mm: 0.8,
        part_share: 0.5,
        modes: Vec::new(),
    }
}

/// Radii of the sections after turns with a fixed wheel whose rim leaves each another radius: the balance of all forces in every turn, by
/// bisection.
fn after_turns(rim_mm: [f64; 3], turns: u32) -> [f64; 3] {
    let contact = soft();
    let (km, width_mm) = (contact.stiffness[0].n_mm, LOBE_MM / 3.0);
    let mut radii_mm = [RAW_MM; 3];
    for _ in 0..turns {
        let excess_n = |deflection_mm: f64| {
            let forces = radii_mm.iter().zip(rim_mm).map(|(radius_mm, rim_mm)| {
                let depth_mm = radius_mm - (20.0 - rim_mm) - deflection_mm;
                let force_n = (contact.threshold_n_mm + contact.grinding_n_mm2 * depth_mm) * width_mm;
                if depth_mm > 0.0 { force_n } else { 0.0 }
            });
            forces.sum::<f64>() - km * deflection_mm
        };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if excess_n(middle) > 0.0 { low = middle } else { high = middle }
        }
        for (radius_mm, rim_mm) in radii_mm.iter_mut().zip(rim_mm) {
            *radius_mm = radius_mm.min(20.0 - rim_mm + low);
        }
    }
    radii_mm
}

/// A round lobe with deflection: after whole turns every section has the radius that the balance of the forces leaves, one turn more or
/// less where the wheel was put in. All sections deflect the wheel alike, so their differences are those of the rim.
#[test]
fn one_deflection_carries_the_sections_of_a_tapered_lobe() {
    let round = Eccentric { radius_mm: 20.0, offset_mm: 0.0 };
    let mut machine = loaded(&grinder(Some(soft())));
    turn(&mut machine, round, (STATION_MM, 3.4));
    let rim_mm = SECTIONS.map(|(_, offset_mm)| -AXIAL.height_mm(offset_mm, LOBE_MM));
    let (three, four) = (after_turns(rim_mm, 3), after_turns(rim_mm, 4));
    assert!(three[0] > 20.0 + 1e-3 && three[0] - four[0] > 1e-4, "the wheel is deflected: {three:?}, {four:?}");
    let begin = DEFAULT_AZIMUTHS / 20;
    for (index, (name, _)) in SECTIONS.into_iter().enumerate() {
        for (i, radius) in radii(&machine, name).iter().enumerate().skip(begin).take(DEFAULT_AZIMUTHS - 2 * begin) {
            let range = four[index] - 2e-5..=three[index] + 2e-5;
            assert!(range.contains(radius), "{name}, azimuth {i}: {radius} mm, {range:?}");
        }
        let near = radii(&machine, name)[DEFAULT_AZIMUTHS / 10];
        assert!((near - four[index]).abs() < 2e-5, "{name}: {near} mm, {}", four[index]);
    }
    let heights = SECTIONS.map(|(name, _)| radii(&machine, name)[DEFAULT_AZIMUTHS / 10]);
    let found = profile_of_sections(heights);
    assert!((found.taper_mm - AXIAL.taper_mm).abs() < 1e-5, "{found:?}");
    assert!((found.crown_mm - AXIAL.crown_mm).abs() < 1e-5, "{found:?}");
}
