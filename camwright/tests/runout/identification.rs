// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! km, kg, F0 and λ from what a machine would show of them.

use super::part::{
    DWELLS_FROM_RAD, GRINDING_N_MM, GaugeStation, GaugedPart, NoiseSource, RATIOS, THRESHOLD_N, diameter, from,
    journal, law,
};
use camwright::gauging::decay::{Comparison, Decay, DecayError};
use camwright::gauging::record::GaugeRecord;
use camwright::gauging::stiffness::{
    ForcePoint, ForceReading, GrindingStiffness, MeasuredValue, StiffnessError, grinding_stiffness_of_one_feed,
    machine_stiffness, mean_of_turn, ratio,
};

/// Pushes of a stopped wheel in steps of 10 um, the force read with σ = 2 N.
fn push(machine_n_mm: f64, points: u32, noise: &mut NoiseSource) -> Vec<ForcePoint> {
    (0..points)
        .map(|i| {
            let way_mm = 0.01 * f64::from(i);
            ForcePoint { way_mm, force_n: 20.0 + machine_n_mm * way_mm + 2.0 * noise.gauss() }
        })
        .collect()
}

/// The reported uncertainty is correct: the errors of many pushes, each divided by its uncertainty, scatter as Student's distribution does,
/// √(ν/(ν−2)).
#[test]
fn pushing_a_stopped_wheel_gives_machine_stiffness_with_uncertainty() {
    let seed = 77;
    let mut noise = NoiseSource::new(seed);
    let mut squares = 0.0;
    for _ in 0..2000 {
        let found = machine_stiffness(&push(1.0e4, 12, &mut noise)).unwrap();
        squares += ((found.value - 1.0e4) / found.uncertainty).powi(2);
    }
    let spread = (squares / 2000.0_f64).sqrt();
    let wanted = (10.0_f64 / 8.0).sqrt();
    eprintln!("seed {seed}: errors are {spread:.3} uncertainties rms, {wanted:.3} wanted");
    // Of 2000 draws the spread is known to some 2 %.
    assert!((spread / wanted - 1.0).abs() < 0.08, "{spread}");
    let exact: Vec<ForcePoint> =
        (0..5).map(f64::from).map(|i| ForcePoint { way_mm: i * 0.01, force_n: i * 123.0 }).collect();
    let found = machine_stiffness(&exact).unwrap();
    assert!((found.value - 12300.0).abs() < 1e-7 && found.uncertainty < 1e-6, "{found:?}");
}

#[test]
fn a_push_that_begins_before_contact_is_refused() {
    let mut noise = NoiseSource::new(5);
    let mut points = push(1.0e4, 12, &mut noise);
    for point in &mut points {
        point.force_n = (point.force_n - 400.0).max(0.0);
    }
    assert!(matches!(machine_stiffness(&points), Err(StiffnessError::Bends { .. })));
}

/// Mean force and depth of cut over a turn at its steady depth, for feeds (mm per turn), by the gauge.
fn feeds(part_ratio: f64, feeds_mm: &[f64], sigma_mm: f64, seed: u64) -> Vec<ForcePoint> {
    let mut points = Vec::new();
    for &feed_mm in feeds_mm {
        let station = GaugeStation { sigma_mm, ..GaugeStation::diameter(270.0, 1.0) };
        let mut part = GaugedPart::new(720, law(part_ratio), &[], &[station], seed);
        let turns = 60.0;
        part.feed(turns, 20.0, feed_mm);
        let record = GaugeRecord::from_one(diameter(270.0), &part.readings[0]).unwrap();
        let forces = part.log.iter().zip(&part.forces);
        let forces: Vec<ForceReading> =
            forces.map(|(place, force_n)| ForceReading { c_rad: place.c_rad, force_n: *force_n }).collect();
        assert!(matches!(mean_of_turn(&record, &forces, 3.0), Err(StiffnessError::NotAllOfTheTurn { .. })));
        assert!(matches!(mean_of_turn(&record, &forces[30_000..], 100.0), Err(StiffnessError::NotAllOfTheTurn { .. })));
        // The last three turns that the gauge has seen.
        for turn in 0..3 {
            let until_rad = record.last_cut_rad() - 2.0 * std::f64::consts::PI * f64::from(turn);
            points.push(mean_of_turn(&record, &forces, until_rad).unwrap());
        }
    }
    points
}

/// The slope of two feeds is kg, what remains at no depth F0; the published formula of one feed is F0/U above kg.
#[test]
fn two_feeds_tell_grinding_stiffness_and_threshold_apart_and_one_does_not() {
    for km_kg in [0.1, 0.2, 0.5] {
        let points = feeds(km_kg, &[0.002, 0.010], 0.0, 1);
        let found = GrindingStiffness::from_feeds(&points).unwrap();
        assert!((found.grinding_n_mm.value / GRINDING_N_MM - 1.0).abs() < 1e-6, "{found:?}");
        assert!((found.threshold_n.value - THRESHOLD_N).abs() < 1e-3, "{found:?}");
        for point in &points {
            let one = grinding_stiffness_of_one_feed(*point, found.threshold_n.value).unwrap();
            assert!((one.grinding_n_mm - one.bias_n_mm - GRINDING_N_MM).abs() < 1.0, "{one:?}");
            eprintln!(
                "km/kg {km_kg}, U = {:.1} um: one feed says {:.2} N/um, {:+.1} % off",
                point.way_mm * 1e3,
                one.grinding_n_mm * 1e-3,
                100.0 * one.bias_n_mm / GRINDING_N_MM
            );
        }
    }
    let noisy = GrindingStiffness::from_feeds(&feeds(0.2, &[0.002, 0.010], 2e-4, 9)).unwrap();
    eprintln!("with 0.2 um of noise: {noisy:?}");
    assert!((noisy.grinding_n_mm.value - GRINDING_N_MM).abs() < 5.0 * noisy.grinding_n_mm.uncertainty, "{noisy:?}");
    let law = noisy.law(MeasuredValue { value: 1.0e4, uncertainty: 50.0 }).unwrap();
    assert!((law.grinding_n_mm() - noisy.grinding_n_mm.value).abs() < 1e-9);
}

fn decay_of(km_kg: f64, sigma_mm: f64, dwell: f64, seed: u64) -> Decay {
    let station = GaugeStation { sigma_mm, ..GaugeStation::diameter(270.0, 1.0) };
    let (part, _) = journal(720, km_kg, &[station], dwell, seed);
    let record = GaugeRecord::from_one(diameter(270.0), from(&part.readings[0], DWELLS_FROM_RAD - 1.6)).unwrap();
    Decay::from_dwell(&record, DWELLS_FROM_RAD, 360).unwrap()
}

#[test]
fn a_dwell_gives_its_decay_to_rounding() {
    for km_kg in RATIOS {
        for dwell in [2.5, 4.5] {
            let found = decay_of(km_kg, 0.0, dwell, 1);
            eprintln!("km/kg {km_kg}: {:.9} per turn, km/kg {:.9}", found.per_turn.value, found.ratio.value);
            assert!((found.per_turn.value - 1.0 / (1.0 + km_kg)).abs() < 1e-9, "{found:?}");
            assert!((found.ratio.value - km_kg).abs() < 1e-8);
            assert!(found.turns == dwell as usize && found.scatter_mm < 1e-9, "{found:?}");
        }
    }
}

/// No bias, and errors no larger than the uncertainty says: it takes depths that share a reading for independent, and is a little too large.
#[test]
fn the_decay_of_noisy_depths_is_unbiased_with_a_correct_uncertainty() {
    let seeds = 200_u32;
    for km_kg in [0.1, 0.2, 0.5] {
        let (mut sum, mut squares, mut uncertainty) = (0.0, 0.0, 0.0);
        for seed in 0..u64::from(seeds) {
            let found = decay_of(km_kg, 2e-4, 2.5, seed);
            let error = (found.ratio.value - km_kg) / found.ratio.uncertainty;
            sum += error;
            squares += error * error;
            uncertainty += found.ratio.uncertainty / f64::from(seeds);
        }
        let (mean, spread) = (sum / f64::from(seeds), (squares / f64::from(seeds)).sqrt());
        eprintln!("km/kg {km_kg} known to {uncertainty:.5}: errors {mean:+.2} in the mean, {spread:.2} rms of it");
        assert!(mean.abs() < 0.25 && spread < 1.2 && spread > 0.2, "{mean} {spread}");
    }
}

#[test]
fn force_and_decay_agree_where_the_sensor_is_right_and_not_where_it_is_not() {
    let mut noise = NoiseSource::new(11);
    let by_decay = decay_of(0.2, 2e-4, 3.5, 3).ratio;
    let machine = machine_stiffness(&push(1.0e4, 12, &mut noise)).unwrap();
    let grinding = GrindingStiffness::from_feeds(&feeds(0.2, &[0.002, 0.010], 2e-4, 9)).unwrap().grinding_n_mm;
    let comparison = Comparison::from_measurements(ratio(machine, grinding), by_decay);
    eprintln!("{comparison:?}");
    assert!(comparison.agrees(3.0));
    // A travel that reads 10 % too much.
    let wrong = MeasuredValue { value: machine.value * 1.1, ..machine };
    assert!(!Comparison::from_measurements(ratio(wrong, grinding), by_decay).agrees(3.0));
}

#[test]
fn dwells_that_tell_nothing_are_refused() {
    let (part, wheel_mm) =
        journal(720, 0.5, &[GaugeStation { sigma_mm: 2e-4, ..GaugeStation::diameter(270.0, 1.0) }], 1.5, 1);
    let dwell = |part: &GaugedPart, from_rad: f64, phases: usize| {
        let record = GaugeRecord::from_one(diameter(270.0), &part.readings[0]).unwrap();
        Decay::from_dwell(&record, from_rad, phases)
    };
    assert!(matches!(dwell(&part, DWELLS_FROM_RAD, 360), Err(DecayError::TooShort { .. })));
    assert!(matches!(dwell(&part, 0.0, 4), Err(DecayError::Phases { phases: 4, .. })));
    // Depths that grow: a feed, not a dwell.
    assert!(matches!(dwell(&part, 4.0, 360), Err(DecayError::NoDecay { .. })));
    let mut spent = part.clone();
    spent.dwell(60.0, wheel_mm);
    let from_rad = spent.c_rad();
    spent.dwell(3.0, wheel_mm);
    assert!(matches!(dwell(&spent, from_rad, 360), Err(DecayError::NothingCut { .. } | DecayError::NoDecay { .. })));
}
