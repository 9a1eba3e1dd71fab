// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Sections of a lobe that is wider than the wheel: each is cut by the plunges that cover it, and one deflection carries them all.

use super::turned::{Eccentric, turning};
use super::{follow, ideal, machine};
use camwright::job::plunges::LobeSection;
use camwright::machine::contact_law::ContactLaw;
use camwright::machine::description::{ContactDescription, ContactMode, MachineDescription, StiffnessAt};
use camwright::math::range::minimum_and_maximum;
use camwright::simulation::Machine;
use camwright::simulation::workpiece::{DEFAULT_AZIMUTHS, LobeError};

const STATION_MM: f64 = 60.0;
const RAW_MM: f64 = 20.05;
/// Two plunges of a wheel of 25 mm, 20 mm apart: what only one cuts, and what both cut.
const SECTIONS: [(&str, f64, f64); 3] = [("W-1", -12.5, 20.0), ("W-1-2", 0.0, 5.0), ("W-2", 12.5, 20.0)];
const PLUNGES_MM: [f64; 2] = [-10.0, 10.0];

fn grinder(contact: Option<ContactDescription>) -> MachineDescription {
    let mut description = MachineDescription { contact, ..ideal() };
    description.wheel.width_mm = 25.0;
    description
}

fn soft(modes: Vec<ContactMode>) -> ContactDescription {
    ContactDescription {
        stiffness: vec![StiffnessAt { z_mm: STATION_MM, n_mm: 2e4 }],
        grinding_n_mm2: 1.5e3,
        threshold_n_mm: 0.8,
        part_share: 0.5,
        modes,
    }
}

pub(crate) fn loaded(description: &MachineDescription) -> Machine {
    let mut machine = machine(description);
    for (name, offset_mm, width_mm) in SECTIONS {
        let outline = (offset_mm, width_mm, vec![RAW_MM; DEFAULT_AZIMUTHS]);
        machine.load_section(name, "LS1", outline, None).expect("a raw section");
    }
    machine
}

/// Turns of C with X on the path of a disc and the table at a plunge.
fn plunge(machine: &mut Machine, disc: Eccentric, offset_mm: f64, turns: f64) {
    turn(machine, disc, (STATION_MM + offset_mm, turns, 4000));
}

/// Turns of C in a number of ticks, with X on the path of a disc and the table at a position (mm).
pub(crate) fn turn(machine: &mut Machine, disc: Eccentric, (z_mm, turns, ticks): (f64, f64, u32)) {
    let description = machine.description().clone();
    let setpoints = turning(&description, z_mm, turns, ticks, |c| disc.path_over_c(1.0, c));
    machine.place(setpoints[0].counts);
    let reports = follow(machine, &setpoints);
    assert!(reports.iter().all(|report| report.raised.is_empty()), "{:?}", machine.alarms());
}

pub(crate) fn radii<'a>(machine: &'a Machine, name: &str) -> &'a [f64] {
    machine.part().lobe(name).expect("it was loaded").radii_mm()
}

/// Both plunges on one path without deflection: every section is the disc, and each plunge leaves alone what it does not cover.
#[test]
fn a_plunge_cuts_the_sections_that_it_covers() {
    let disc = Eccentric { radius_mm: 19.9, offset_mm: 0.1 };
    let mut machine = loaded(&grinder(None));
    plunge(&mut machine, disc, PLUNGES_MM[0], 2.0);
    assert_eq!(radii(&machine, "W-2"), vec![RAW_MM; DEFAULT_AZIMUTHS], "the first plunge does not reach it");
    assert_eq!(radii(&machine, "W-1"), radii(&machine, "W-1-2"), "one wheel cuts both");
    let first = radii(&machine, "W-1").to_vec();
    // The second wheel is 2 µm farther out: it cuts nothing of what the first has left.
    plunge(&mut machine, Eccentric { radius_mm: 19.902, ..disc }, PLUNGES_MM[1], 2.0);
    assert_eq!(radii(&machine, "W-1"), first, "the second plunge does not reach it");
    assert_eq!(radii(&machine, "W-1-2"), first, "the overlap keeps the smaller radius");
    for (name, radius_mm) in [("W-1", 19.9), ("W-2", 19.902)] {
        let wanted = Eccentric { radius_mm, ..disc };
        let azimuth = |i: usize| i as f64 / DEFAULT_AZIMUTHS as f64 * std::f64::consts::TAU;
        let off = radii(&machine, name).iter().enumerate().map(|(i, radius)| radius - wanted.radius(azimuth(i)));
        let (low, high) = minimum_and_maximum(off);
        assert!(low > -1e-4 && high < 1e-4, "{name}: {low} to {high} mm");
    }
    // A third, 3 µm farther in, cuts the overlap again.
    plunge(&mut machine, Eccentric { radius_mm: 19.897, ..disc }, PLUNGES_MM[1], 2.0);
    assert_eq!(radii(&machine, "W-1-2"), radii(&machine, "W-2"));
    assert_eq!(radii(&machine, "W-1"), first);
}

/// Radii of sections after turns with a fixed wheel: the balance of all forces in every turn, found by bisection.
fn after_turns(radii_mm: &mut [f64], widths_mm: &[f64], wheel_mm: f64, turns: u32) {
    let contact = soft(Vec::new());
    let km = contact.stiffness[0].n_mm;
    for _ in 0..turns {
        let excess_n = |deflection_mm: f64| {
            let forces = radii_mm.iter().zip(widths_mm).map(|(radius_mm, width_mm)| {
                let depth_mm = radius_mm - wheel_mm - deflection_mm;
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
        radii_mm.iter_mut().for_each(|radius_mm| *radius_mm = radius_mm.min(wheel_mm + low));
    }
}

/// A round lobe under a wheel that stands still, in two plunges with deflection: after whole turns every section has the radius that the
/// balance of the forces leaves, one turn more or less where the plunge began.
#[test]
fn one_deflection_carries_all_sections() {
    let round = Eccentric { radius_mm: 20.0, offset_mm: 0.0 };
    for modes in [Vec::new(), vec![ContactMode { frequency_rad_s: 3000.0, damping: 0.5, compliance_share: 0.4 }]] {
        let tolerance_mm = if modes.is_empty() { 2e-5 } else { 2e-4 };
        let mut machine = loaded(&grinder(Some(soft(modes))));
        plunge(&mut machine, round, PLUNGES_MM[0], 3.4);
        let check = |machine: &Machine, name: &str, wanted_mm: [f64; 2]| {
            // The wheel is put in where C begins to turn.
            let begin = DEFAULT_AZIMUTHS / 20;
            for (i, radius) in radii(machine, name).iter().enumerate().skip(begin).take(DEFAULT_AZIMUTHS - 2 * begin) {
                let [low, high] = wanted_mm;
                assert!(
                    (low - tolerance_mm..=high + tolerance_mm).contains(radius),
                    "{name}, azimuth {i}: {radius} mm, {wanted_mm:?}"
                );
            }
            let middle = radii(machine, name).len() / 10;
            let near = radii(machine, name)[middle];
            assert!((near - wanted_mm[0]).abs() < tolerance_mm, "{name}: {near} mm, {wanted_mm:?}");
        };
        let first = |turns: u32| {
            let mut left = [RAW_MM; 2];
            after_turns(&mut left, &[20.0, 5.0], 20.0, turns);
            left
        };
        let (three, four) = (first(3), first(4));
        // Both sections are as one of the wheel's width.
        let whole = ContactLaw::new(2e4, 1.5e3 * 25.0, 0.8 * 25.0).expect("a law");
        let alone = (0..3).fold(RAW_MM, |radius, _| whole.radius_after_mm(radius, 20.0));
        assert!((three[0] - alone).abs() < 1e-12 && (three[1] - alone).abs() < 1e-12);
        check(&machine, "W-1", [four[0], three[0]]);
        check(&machine, "W-1-2", [four[1], three[1]]);
        let overlap_mm = radii(&machine, "W-1-2").to_vec();
        plunge(&mut machine, Eccentric { radius_mm: 19.998, ..round }, PLUNGES_MM[1], 3.4);
        let second = |turns: u32, overlap_mm: f64| {
            let mut left = [overlap_mm, RAW_MM];
            after_turns(&mut left, &[5.0, 20.0], 19.998, turns);
            left
        };
        let at = overlap_mm.len() / 10;
        let (four_again, three_again) = (second(4, overlap_mm[at]), second(3, three[1]));
        check(&machine, "W-2", [four_again[1], three_again[1].max(four_again[1])]);
        check(&machine, "W-1-2", [four_again[0], three_again[0].max(four_again[0])]);
        assert!(four_again[0] < overlap_mm[at] - 1e-4, "the overlap is cut again: {four_again:?}");
        // The own section alone would deflect the wheel less.
        let narrow = ContactLaw::new(2e4, 1.5e3 * 20.0, 0.8 * 20.0).expect("a law");
        let unshared = (0..4).fold(RAW_MM, |radius, _| narrow.radius_after_mm(radius, 19.998));
        assert!(four_again[1] > unshared + 1e-5, "{} mm, {unshared} mm", four_again[1]);
    }
}

/// Sections that overlap, stand about other centres, or are too many for the wheel are refused.
#[test]
fn impossible_sections_are_refused() {
    let description = grinder(None);
    let section = |machine: &mut Machine, name: &str, offset_mm: f64, width_mm: f64| {
        machine.load_section(name, "LS1", (offset_mm, width_mm, vec![20.0; 720]), None)
    };
    let mut machine = loaded(&description);
    let refused = section(&mut machine, "W-3", 21.0, 2.0);
    assert!(matches!(refused, Err(LobeError::StationTaken { other, .. }) if other == "W-2"));
    let refused = section(&mut machine, "W-3", f64::NAN, 2.0);
    assert!(matches!(refused, Err(LobeError::Offset { .. })), "{refused:?}");
    assert_eq!(section(&mut machine, "W-3", 24.0, 3.0), Ok(()), "flush with its neighbour");
    let mut narrow = super::machine(&description);
    for number in 0..5 {
        section(&mut narrow, &format!("N-{number}"), 4.0 * f64::from(number), 4.0)
            .expect("at most five under the wheel");
    }
    let refused = section(&mut narrow, "N-5", 20.0, 4.0);
    assert!(matches!(refused, Err(LobeError::TooManySections { max: 5, .. })), "{refused:?}");
}

/// The sections of a plan are those that the machine takes.
#[test]
fn planned_sections_are_taken() {
    let spec = camwright::job::grinding::LobeSpec {
        name: "W".into(),
        station: "LS1".into(),
        phase_rad: 0.0,
        profile: 0,
        width_mm: 0.0,
        tolerance: camwright::cam::form_tolerance::FormTolerance::default(),
        plunge: None,
        visit: None,
        axial: None,
    };
    let description = grinder(None);
    for width_mm in [25.5, 26.0, 40.0, 48.5, 60.0, 71.3, 150.0] {
        for overlap_mm in [0.5, 3.0, 8.3] {
            let wide = camwright::job::grinding::LobeSpec { width_mm, ..spec.clone() };
            let plunges = wide.side_by_side(overlap_mm, 25.0).expect("plunges");
            let mut machine = machine(&description);
            for plunge in plunges.iter().filter_map(|plunge| plunge.plunge.as_ref()) {
                for LobeSection { name, offset_mm, width_mm, .. } in plunge.finished_sections(25.0) {
                    let outline = (offset_mm, width_mm, vec![20.0; 720]);
                    machine.load_section(&name, "LS1", outline, None).expect("sections of a plan");
                }
            }
        }
    }
}
