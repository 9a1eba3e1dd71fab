// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Wheel and part deflect against each other: what a machine with a stiffness leaves of a part, turn after turn.

use super::turned::{self, Eccentric};
use super::{ideal, machine};
use camwright::machine::contact_law::ContactLaw;
use camwright::machine::description::{Axis, ContactDescription, MachineDescription, StiffnessAt};
use camwright::machine::setpoint::Setpoint;
use camwright::math::units::TURN_RAD;
use camwright::simulation::Machine;
use camwright::simulation::tick_report::TickReport;
use camwright::simulation::workpiece::{DEFAULT_AZIMUTHS, DEGREES};

const WIDTH_MM: f64 = 15.0;
const KG_N_MM: f64 = 5.0e4;
/// Table at the first station.
const Z_MM: f64 = 60.0;

/// The reference machine with ideal drives, and this stiffness of machine and part.
fn soft(machine_n_mm: f64, threshold_n: f64) -> (MachineDescription, ContactLaw) {
    let contact = ContactDescription {
        stiffness: vec![StiffnessAt { z_mm: Z_MM, n_mm: machine_n_mm }],
        grinding_n_mm2: KG_N_MM / WIDTH_MM,
        threshold_n_mm: threshold_n / WIDTH_MM,
        part_share: 0.5,
        modes: Vec::new(),
    };
    let law = contact.law(Z_MM, WIDTH_MM).expect("a law");
    (MachineDescription { contact: Some(contact), ..ideal() }, law)
}

/// C turns so many times from 0, at 400 ticks a turn in the mean; X over what it has turned, with two derivatives (mm over rad).
#[allow(clippy::cast_possible_truncation, reason = "some thousand ticks")]
fn turning(description: &MachineDescription, turns: f64, x: impl Fn(f64) -> (f64, f64, f64)) -> Vec<Setpoint> {
    turned::turning(description, Z_MM, turns, (400.0 * turns) as u32, x)
}

/// Azimuth of bin `i`.
fn azimuth(i: usize) -> f64 {
    TURN_RAD * i as f64 / DEFAULT_AZIMUTHS as f64
}

/// Radii of the lobe whenever a whole turn is over, the raw ones first; and every tick's report.
fn turn_by_turn(
    description: &MachineDescription,
    raw: Vec<f64>,
    setpoints: &[Setpoint],
) -> (Vec<Vec<f64>>, Vec<TickReport>, Machine) {
    let mut machine = machine(description);
    machine.load_lobe("I1", "LS1", WIDTH_MM, raw).expect("a raw part");
    machine.place(setpoints[0].counts);
    let per_turn = description.axis(Axis::C).scale.counts(TURN_RAD);
    let radii = |machine: &Machine| machine.part().lobe("I1").expect("it is there").radii_mm().to_vec();
    let (mut turns, mut reports) = (vec![radii(&machine)], Vec::new());
    for pair in setpoints.windows(2) {
        reports.push(machine.step(Some(&pair[1]), &[], &[]));
        if pair[1].counts[0] / per_turn > pair[0].counts[0] / per_turn {
            turns.push(radii(&machine));
        }
    }
    assert!(machine.alarms().is_empty(), "{:?}", machine.alarms());
    (turns, reports, machine)
}

/// Azimuths that the wheel does not touch when a turn is over: its leading edge has begun some degrees of the next.
const WHOLE: std::ops::Range<usize> = 200..3500;

/// A part that runs out by two harmonics, 50 µm in all, and a wheel that stands still: every phase follows the law within the cusps
/// of the sweep, and the runout goes by λ = kg/(kg + km) a turn.
#[test]
fn runout_goes_by_the_same_share_every_turn() {
    for machine_n_mm in [2.5e3, 5.0e3, 1.0e4, 2.5e4] {
        let (description, law) = soft(machine_n_mm, 15.0);
        let raw = (0..DEFAULT_AZIMUTHS).map(|i| 20.05 + 0.02 * azimuth(i).cos() + 0.005 * (3.0 * azimuth(i)).sin());
        let setpoints = turning(&description, 6.2, |_| (20.0, 0.0, 0.0));
        let (turns, _, _) = turn_by_turn(&description, raw.collect(), &setpoints);
        let mut worst = 0.0_f64;
        for pair in turns.windows(2) {
            for i in WHOLE {
                worst = worst.max((pair[1][i] - law.radius_after_mm(pair[0][i], 20.0)).abs());
            }
        }
        let spread = |radii: &[f64]| {
            let mean = radii[WHOLE].iter().sum::<f64>() / WHOLE.len() as f64;
            radii[WHOLE].iter().map(|r| (r - mean).powi(2)).sum::<f64>().sqrt()
        };
        let left = (spread(&turns[6]) / spread(&turns[1])).powf(0.2);
        eprintln!("km {machine_n_mm} N/mm: off the law by {worst:e} mm; {left} left by a turn, law {}", law.decay());
        assert!(worst < 1e-5, "{worst} mm");
        assert!((left - law.decay()).abs() < 1e-4, "{left}, law {}", law.decay());
    }
}

/// A plunge of 10 µm a turn: the depth of cut grows as f (1 − λⁿ), the force to kg f + F0; the wheel then stands, and sparks out to
/// F0/km. `x_axis` feels the force.
#[test]
fn a_plunge_and_its_spark_out_are_those_of_the_law() {
    let (description, law) = soft(1.0e4, 15.0);
    let (feed_mm, plunge, rest_mm) = (0.01, 30.0, 15.0 / 1.0e4);
    let depth = |turns: f64| feed_mm * turns.min(plunge);
    let setpoints = turning(&description, 70.2, |angle| {
        let slope = if angle < plunge * TURN_RAD { -feed_mm / TURN_RAD } else { 0.0 };
        // From where the force reaches F0 on.
        (20.0 - rest_mm - depth(angle / TURN_RAD), slope, 0.0)
    });
    let (turns, reports, _) = turn_by_turn(&description, vec![20.0; DEFAULT_AZIMUTHS], &setpoints);
    let mut radii = turns[0].clone();
    let mut worst = 0.0_f64;
    for (turn, ground) in turns.iter().enumerate().skip(1) {
        for i in WHOLE {
            let passed = turn as f64 - 1.0 + azimuth(i) / TURN_RAD;
            radii[i] = law.radius_after_mm(radii[i], 20.0 - rest_mm - depth(passed));
            worst = worst.max((ground[i] - radii[i]).abs());
        }
    }
    eprintln!("off the law by {worst:e} mm at most");
    assert!(worst < 2e-5, "{worst} mm");
    assert!((turns[70][1800] - (20.0 - depth(100.0))).abs() < 1e-5 + 0.3 * law.decay().powi(40), "{}", turns[70][1800]);
    let turned = |setpoint: &Setpoint| setpoint.counts[0] as f64 / 3.6e6;
    let at = |turns: f64| setpoints.iter().position(|setpoint| turned(setpoint) >= turns).expect("within the cut");
    let (cutting, sparked_out) = (&reports[at(29.5)], &reports[at(69.9)]);
    let wanted_n = 15.0 + 5.0e4 * feed_mm * (1.0 - law.decay().powf(29.5));
    assert!((cutting.normal_force_n - wanted_n).abs() < 0.005 * wanted_n, "{} N, {wanted_n} N", cutting.normal_force_n);
    assert!((sparked_out.normal_force_n - 15.0).abs() < 0.5, "{} N", sparked_out.normal_force_n);
    assert!((cutting.axes[1].effort + wanted_n).abs() < 0.02 * wanted_n, "{} N", cutting.axes[1].effort);
}

/// On what is not round wheel and part deflect along the normal: an eccentric disc keeps its form, and what is left of its stock is
/// the same all round.
#[test]
fn an_eccentric_gives_way_along_its_normal() {
    for sense in [1, -1] {
        let (mut description, law) = soft(1.0e4, 15.0);
        description.rotation_sense = sense;
        let (radius_mm, offset_mm, stock_mm) = (19.0, 4.2, 0.03);
        let disc = |radius_mm: f64| Eccentric { radius_mm, offset_mm };
        let raw = (0..DEFAULT_AZIMUTHS).map(|i| disc(radius_mm + stock_mm).radius(azimuth(i)));
        let sense = f64::from(sense);
        let setpoints = turning(&description, 4.2, |angle| disc(radius_mm).path_over_c(sense, angle));
        let (turns, _, _) = turn_by_turn(&description, raw.collect(), &setpoints);
        let beyond = |turn: usize, i: usize| {
            let r = turns[turn][i];
            (r * azimuth(i).cos() - offset_mm).hypot(r * azimuth(i).sin()) - radius_mm
        };
        let mut left_mm = radius_mm + stock_mm;
        for turn in 1..=4 {
            left_mm = law.radius_after_mm(left_mm, radius_mm);
            for i in WHOLE {
                let off = beyond(turn, i) - (left_mm - radius_mm);
                assert!(off.abs() < 3e-5, "sense {sense}, turn {turn}, {} rad: {off} mm", azimuth(i));
            }
        }
    }
}

/// A stiffer machine leaves less; one that does not deflect at all leaves what the rigid wheel leaves.
#[test]
fn a_machine_that_is_stiff_beyond_measure_grinds_like_a_rigid_one() {
    let ground = |description: &MachineDescription| {
        let setpoints = turning(description, 2.2, |angle| Eccentric { radius_mm: 19.0, offset_mm: 4.2 }.path(angle));
        turn_by_turn(description, vec![23.3; DEFAULT_AZIMUTHS], &setpoints).0.pop().expect("two turns")
    };
    let (rigid, stiff) = (ground(&ideal()), ground(&soft(1.0e12, 0.0).0));
    let worst = rigid.iter().zip(&stiff).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-6, "{worst} mm");
}

/// The removed volume of the part equals the reported removal, tick by tick.
#[test]
fn an_elastic_cut_reports_its_removal() {
    let (description, _) = soft(1.0e4, 15.0);
    let setpoints = turning(&description, 3.2, |_| (20.0, 0.0, 0.0));
    let (turns, reports, machine) = turn_by_turn(&description, vec![20.1; DEFAULT_AZIMUTHS], &setpoints);
    let area = |radii: &[f64]| radii.iter().map(|r| r * r * 0.5 * TURN_RAD / radii.len() as f64).sum::<f64>();
    let reported: f64 = reports.iter().map(|report| report.removal.area_mm2).sum();
    let left = area(machine.part().lobe("I1").expect("it is there").radii_mm());
    assert!((area(&turns[0]) - left - reported).abs() < 1e-9, "{reported} mm2");
}

/// Largest normal force on every degree (N), as the machine keeps it.
fn forces(machine: &Machine) -> Vec<f64> {
    let lobe = machine.part().lobe("I1").expect("it is there");
    lobe.cut_record().map_or_else(Vec::new, |record| record.forces_n().to_vec())
}

/// A wheel that stands still in a part whose raw radius grows from degree to degree: each degree was met as deep as it stood out in the
/// first turn, when it was pressed hardest, and the force there is the law's.
#[test]
fn the_force_on_every_degree_is_that_of_its_engagement() {
    let (description, law) = soft(1.0e4, 15.0);
    let out_mm = |azimuth: f64| 0.05 + 0.02 * azimuth.cos();
    let raw = (0..DEFAULT_AZIMUTHS).map(|i| 20.0 + out_mm(azimuth(i))).collect();
    let setpoints = turning(&description, 3.2, |_| (20.0, 0.0, 0.0));
    let (_, _, machine) = turn_by_turn(&description, raw, &setpoints);
    let forces = forces(&machine);
    assert_eq!(forces.len(), DEGREES);
    let mut worst = 0.0_f64;
    for (degree, force_n) in forces.iter().enumerate().take(350).skip(10) {
        // The hardest place of a degree is one of its ends; from one to the other the force changes by 3 N at most.
        let at = |i: usize| {
            let engagement_mm = out_mm(azimuth(i));
            law.force_n(law.deflection_mm(engagement_mm))
        };
        let wanted_n = (10 * degree..10 * degree + 10).map(at).fold(0.0, f64::max);
        worst = worst.max((force_n - wanted_n).abs());
    }
    eprintln!("{worst:e} N off the law at most, of {:.0} N", forces[10]);
    assert!(worst < 0.5, "{worst} N");
}

/// The record of every degree equals the reports during contact: for a steady plunge the largest force of a turn's ticks.
#[test]
fn the_force_per_degree_is_the_largest_reported_there() {
    let (description, law) = soft(1.0e4, 15.0);
    let (feed_mm, plunge) = (0.01, 60.0);
    let setpoints =
        turning(&description, plunge + 0.2, |angle| (20.0 - feed_mm * angle / TURN_RAD, -feed_mm / TURN_RAD, 0.0));
    let (_, reports, machine) = turn_by_turn(&description, vec![20.0; DEFAULT_AZIMUTHS], &setpoints);
    let mut reported = [0.0_f64; DEGREES];
    for report in &reports {
        // A round part touches a wheel on the line from its axis to the wheel's.
        let degrees = (report.axes[Axis::C.index()].position / TURN_RAD).rem_euclid(1.0) * DEGREES as f64;
        #[allow(clippy::cast_possible_truncation, reason = "a degree of a turn")]
        let degree = (degrees as usize).min(DEGREES - 1);
        reported[degree] = reported[degree].max(report.normal_force_n);
    }
    let steady_n = law.threshold_n() + law.grinding_n_mm() * feed_mm;
    let kept = forces(&machine);
    for (degree, (kept, reported)) in kept.iter().zip(&reported).enumerate() {
        assert!((kept - reported).abs() < 0.005 * steady_n, "{degree} deg: {kept} N, reported {reported} N");
        assert!((kept - steady_n).abs() < 0.005 * steady_n, "{degree} deg: {kept} N, {steady_n} N");
    }
    let largest = |forces: &[f64]| forces.iter().copied().fold(0.0, f64::max);
    assert!(largest(&kept) >= largest(&reported), "{} N, reported {} N", largest(&kept), largest(&reported));
}

/// Without a law there is no force to know, and nothing is kept, not zeros.
#[test]
fn a_rigid_machine_knows_no_force() {
    let setpoints = turning(&ideal(), 1.2, |_| (20.0, 0.0, 0.0));
    let (_, _, machine) = turn_by_turn(&ideal(), vec![20.05; DEFAULT_AZIMUTHS], &setpoints);
    assert!(machine.part().lobe("I1").expect("it is there").cut_record().is_none());
}
