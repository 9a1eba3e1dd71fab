// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Actual depths of cut and the part by phase, against what the reference really lost and has.

use super::part::{ANGLES_DEG, DWELLS_FROM_RAD, GaugeStation, GaugedPart, RATIOS, diameter, from, journal, law, rad};
use camwright::gauging::fit::Fit;
use camwright::gauging::record::GaugeRecord;
use camwright::gauging::runout::RadiusByPhase;
use camwright::gauging::state::{MeasureSettings, PartState};
use camwright::gauging::wheel_log::WheelLog;
use std::f64::consts::PI;

/// Radii of the reference at every step of C: what a phase had when it left the wheel.
fn left_the_wheel(phases: usize, ratio: f64, station: GaugeStation, dwell: f64) -> (GaugedPart, Vec<f64>, f64) {
    let (mut part, wheel_mm) = journal(phases, ratio, &[station], 0.0, 1);
    let mut radii = part.radii.clone();
    for step in 0..(dwell * phases as f64) as usize {
        part.pass(wheel_mm);
        radii.push(part.radii[step % phases]);
    }
    (part, radii, wheel_mm)
}

/// D0 − D1 is what the phase at the wheel lost, with odd harmonics and even, at every place of the gauge; and a reading of the gauge
/// belongs to the cut that its geometry says.
#[test]
fn the_difference_of_two_diameters_is_what_the_wheel_took() {
    for angle_deg in ANGLES_DEG {
        let angle_deg = f64::from(angle_deg);
        let (part, left, _) = left_the_wheel(720, 0.2, GaugeStation::diameter(angle_deg, 0.5), 2.0);
        let record = GaugeRecord::from_one(diameter(angle_deg), from(&part.readings[0], DWELLS_FROM_RAD)).unwrap();
        let depths = record.depths();
        assert!((depths.len() as f64 - 1.5 * 720.0).abs() < 2.0, "{}", depths.len());
        for depth in depths {
            let step = ((depth.c_rad - DWELLS_FROM_RAD) / rad(0.5)).round() as usize;
            let lost = left[step] - left[step + 720];
            assert!(
                (depth.depth_mm - lost).abs() < 1e-12,
                "gauge at {angle_deg}, step {step}: {} {lost}",
                depth.depth_mm
            );
            assert!(depth.known_at_rad > depth.c_rad && depth.known_at_rad < depth.c_rad + PI);
        }
    }
}

/// A three-lobed part has one diameter: a gauge that only turns with it sees nothing, and the depth of cut shows its lobes.
#[test]
fn a_diameter_is_blind_to_three_lobes_and_the_depth_of_cut_is_not() {
    let station = GaugeStation::diameter(270.0, 1.0);
    let mut part = GaugedPart::new(3600, law(0.2), &[(3.0, 0.01, 0.4)], &[station], 1);
    part.dwell(1.0, 25.0);
    let still = part.readings[0].clone();
    let spread = still.iter().map(|reading| (reading.value_mm - 40.0).abs()).fold(0.0, f64::max);
    assert!(spread < 1e-12, "{spread}");
    // In a spiral, as a wheel comes in: one that stood there at once would leave a step.
    let wheel_mm = part.feed(9.0, 20.012, 0.01);
    let dwells_rad = part.c_rad();
    part.dwell(2.0, wheel_mm);
    let log = part.log.clone();
    let ground = from(&part.readings[0], dwells_rad);
    let record = GaugeRecord::from_one(diameter(270.0), ground).unwrap();
    let state =
        PartState::measure(&record, WheelLog::new(&log).unwrap(), law(0.2), &MeasureSettings::default()).unwrap();
    let found = state.radii_at(part.c_rad() - rad(0.05)).unwrap();
    let true_mm = RadiusByPhase::new(part.radii.iter().copied().step_by(10).collect()).unwrap().harmonic_mm(3);
    eprintln!("third harmonic: {:.4} um of {:.4} um", found.harmonic_mm(3) * 1e3, true_mm * 1e3);
    assert!((found.harmonic_mm(3) / true_mm - 1.0).abs() < 1e-3);
    assert!(found.total_mm() > 5.0 * spread);
}

/// Size is found as well as runout, since the gauge's zero drops out and the force gives the position of the wheel's face.
#[test]
fn radii_are_found_as_they_are_at_every_moment() {
    let settings = MeasureSettings { fit: Fit::Depths { harmonics: None }, ..MeasureSettings::default() };
    for ratio in RATIOS {
        let (mut part, _, wheel_mm) = left_the_wheel(3600, ratio, GaugeStation::diameter(225.0, 1.0), 2.5);
        let readings = part.readings[0].clone();
        let log = part.log.clone();
        let record = GaugeRecord::from_one(diameter(225.0), from(&readings, DWELLS_FROM_RAD)).unwrap();
        let state = PartState::measure(&record, WheelLog::new(&log).unwrap(), law(ratio), &settings).unwrap();
        assert!(state.scatter_mm().unwrap() < 1e-9, "{:?}", state.scatter_mm());
        // Now, and after the wheel has stayed another 1.3 turns.
        for stays in [0.0, 1.3] {
            part.dwell(stays, wheel_mm);
            let found = state.radii_at(part.c_rad() - rad(0.05)).unwrap();
            for (radius, wanted) in found.radii_mm().iter().zip(part.radii.iter().step_by(10)) {
                assert!((radius - wanted).abs() < 2e-6, "km/kg {ratio}: {} um", (radius - wanted) * 1e3);
            }
        }
    }
}
