// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Measurements and corrections that are not possible are refused with a reason.

use super::part::{DWELLS_FROM_RAD, GaugeStation, GaugedPart, diameter, from, journal, law, rad};
use camwright::gauging::correction::{Correction, CorrectionError, CorrectionStart, CorrectionTarget};
use camwright::gauging::fit::Fit;
use camwright::gauging::published::{PublishedError, PublishedRunout};
use camwright::gauging::record::{GaugeRecord, RunoutReading};
use camwright::gauging::runout::{PhasesError, RadiusByPhase};
use camwright::gauging::spark_out::{self, SparkOutError};
use camwright::gauging::state::{MeasureSettings, PartState, StateError};
use camwright::gauging::stiffness::{
    ForcePoint, GrindingStiffness, StiffnessError, grinding_stiffness_of_one_feed, machine_stiffness,
};
use camwright::gauging::wheel_log::{WheelLog, WheelPosition};

const USUAL: MeasureSettings = MeasureSettings {
    fit: Fit::Readings { harmonics: 15 },
    phases: None,
    from_rad: None,
    min_depth_mm: 1e-4,
    max_scatter_mm: Some(2e-3),
};

#[test]
fn records_that_tell_no_state_are_refused() {
    let (part, _) = journal(720, 0.2, &[GaugeStation::diameter(270.0, 1.0)], 1.5, 1);
    let readings = from(&part.readings[0], DWELLS_FROM_RAD);
    let log = WheelLog::new(&part.log).unwrap();
    let measure = |count: usize, log: WheelLog<'_>, settings: MeasureSettings| {
        let record = GaugeRecord::from_one(diameter(270.0), &readings[..count]).unwrap();
        PartState::measure(&record, log, law(0.2), &settings).map(|_| ()).unwrap_err()
    };
    assert!(matches!(measure(500, log, USUAL), StateError::LessThanATurn { .. }));
    let all = readings.len();
    let short = WheelLog::new(&part.log[..10_000]).unwrap();
    assert!(matches!(measure(all, short, USUAL), StateError::LogTooShort { .. }));
    for phases in [30, 100_000] {
        let refused = measure(all, log, MeasureSettings { phases: Some(phases), ..USUAL });
        assert!(matches!(refused, StateError::Phases { min: 31, .. }), "{refused}");
    }
    for fit in [Fit::Readings { harmonics: 101 }, Fit::Depths { harmonics: Some(u32::MAX) }] {
        let refused = measure(all, log, MeasureSettings { fit, ..USUAL });
        assert!(matches!(refused, StateError::Harmonics { max: 100, .. }), "{refused}");
    }
    let late = MeasureSettings { from_rad: Some(DWELLS_FROM_RAD + 4.0), ..USUAL };
    assert!(matches!(measure(all, log, late), StateError::LessThanATurn { .. }));
}

/// An eccentric part that the wheel has met on one side only: of the other nothing is known.
#[test]
fn a_phase_that_was_not_cut_is_named() {
    let station = GaugeStation::diameter(270.0, 1.0);
    let mut part = GaugedPart::new(720, law(0.2), &[(1.0, 0.05, 0.0)], &[station], 1);
    part.dwell(2.0, 20.0);
    let record = GaugeRecord::from_one(diameter(270.0), &part.readings[0]).unwrap();
    let state = PartState::measure(&record, WheelLog::new(&part.log).unwrap(), law(0.2), &USUAL);
    let Err(StateError::NotCut { phase_deg, depth_mm, .. }) = state else { panic!("{state:?}") };
    assert!((80.0..280.0).contains(&phase_deg) && depth_mm < 1e-4, "{phase_deg} {depth_mm}");
}

/// A gauge that stuck, and a wheel that was elsewhere.
#[test]
fn readings_that_do_not_follow_the_contact_law_are_refused() {
    let (part, _) = journal(720, 0.2, &[GaugeStation::diameter(270.0, 1.0)], 3.0, 1);
    let good = from(&part.readings[0], DWELLS_FROM_RAD);
    let measure = |readings: &[RunoutReading], log: &[WheelPosition], ratio: f64| {
        let record = GaugeRecord::from_one(diameter(270.0), readings).unwrap();
        PartState::measure(&record, WheelLog::new(log).unwrap(), law(ratio), &USUAL).map(|_| ())
    };
    assert!(measure(good, &part.log, 0.2).is_ok());
    let mut stuck = good.to_vec();
    let at = stuck[200].value_mm;
    stuck[200..].iter_mut().for_each(|reading| reading.value_mm = at);
    let mut all = good.to_vec();
    all.iter_mut().for_each(|reading| reading.value_mm = at);
    let elsewhere: Vec<WheelPosition> = part
        .log
        .iter()
        .map(|place| WheelPosition {
            x_mm: place.x_mm + if place.c_rad > DWELLS_FROM_RAD + 6.0 { 0.05 } else { 0.0 },
            ..*place
        })
        .collect();
    for (what, refused) in [
        ("stuck", measure(&stuck, &part.log, 0.2)),
        ("stuck from the first", measure(&all, &part.log, 0.2)),
        ("wheel elsewhere", measure(good, &elsewhere, 0.2)),
    ] {
        let refused = refused.unwrap_err();
        eprintln!("{what}: {refused}");
        assert!(matches!(refused, StateError::Scatter { .. } | StateError::NotCut { .. }), "{what}: {refused:?}");
    }
}

/// 0.3 um at half the km/kg: visible beside a gauge's noise, but no reason to refuse. The decay shows it.
#[test]
fn a_wrong_stiffness_shows_in_the_scatter_but_is_not_refused_for_it() {
    let (part, _) = journal(720, 0.2, &[GaugeStation::diameter(270.0, 1.0)], 3.0, 1);
    let record = GaugeRecord::from_one(diameter(270.0), from(&part.readings[0], DWELLS_FROM_RAD)).unwrap();
    let scatter = |ratio: f64| {
        let state = PartState::measure(&record, WheelLog::new(&part.log).unwrap(), law(ratio), &USUAL).unwrap();
        eprintln!("km/kg 0.2, thought {ratio}: readings scatter by {:.3} um", state.scatter_mm().unwrap() * 1e3);
        state.scatter_mm().unwrap()
    };
    assert!(scatter(0.2) < 2e-5 && (2e-4..4e-4).contains(&scatter(0.1)) && (2e-4..4e-4).contains(&scatter(0.3)));
}

#[test]
fn corrections_that_cannot_be_are_refused() {
    let (part, _) = journal(720, 0.2, &[GaugeStation::diameter(270.0, 1.0)], 1.5, 1);
    let record = GaugeRecord::from_one(diameter(270.0), from(&part.readings[0], DWELLS_FROM_RAD)).unwrap();
    let state = PartState::measure(&record, WheelLog::new(&part.log).unwrap(), law(0.2), &USUAL).unwrap();
    let at = CorrectionStart::At(part.c_rad());
    let refused =
        |start: CorrectionStart, target: CorrectionTarget| Correction::exact(&state, start, target).unwrap_err();
    let usual = CorrectionTarget::MinRadius { extra_depth_mm: 0.0 };
    assert!(matches!(refused(CorrectionStart::At(1.0), usual), CorrectionError::BeforeLogEnds { .. }));
    assert!(matches!(
        refused(CorrectionStart::AtMinRadius { from_rad: f64::NAN }, usual),
        CorrectionError::BeforeLogEnds { .. }
    ));
    for extra_depth_mm in [-1e-3, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            refused(at, CorrectionTarget::MinRadius { extra_depth_mm }),
            CorrectionError::ExtraDepth { .. }
        ));
    }
    let min_mm = state.radii_at(part.c_rad()).unwrap().minimum_mm();
    for target_mm in [min_mm + 0.002, f64::NAN] {
        assert!(matches!(refused(at, CorrectionTarget::Radius(target_mm)), CorrectionError::TargetAboveMin { .. }));
    }
    let runout = state.radii_at(part.c_rad()).unwrap();
    let no_wheel = Correction::published(&runout, &law(0.2), f64::NAN, 0.0).unwrap_err();
    assert!(matches!(no_wheel, CorrectionError::Wheel { .. }));
}

/// The step that a lifted wheel leaves on the part, met in the middle of the turn, is no curve.
#[test]
fn a_step_within_the_turn_is_refused() {
    let (mut part, _) = journal(720, 0.2, &[GaugeStation::diameter(270.0, 1.0)], 1.5, 1);
    let lifted_rad = part.c_rad();
    part.dwell(0.1, 25.0);
    let readings: Vec<_> = part.readings[0].iter().copied().filter(|reading| reading.c_rad < lifted_rad).collect();
    let record = GaugeRecord::from_one(diameter(270.0), from(&readings, DWELLS_FROM_RAD)).unwrap();
    let state = PartState::measure(&record, WheelLog::new(&part.log).unwrap(), law(0.2), &USUAL).unwrap();
    let start = CorrectionStart::At(lifted_rad + rad(90.0));
    let refused = Correction::exact(&state, start, CorrectionTarget::MinRadius { extra_depth_mm: 0.0 }).unwrap_err();
    assert!(matches!(refused, CorrectionError::NotResolved { .. }), "{refused}");
}

#[test]
fn windows_radii_and_points_that_are_none_are_refused() {
    let (part, _) = journal(720, 0.2, &[GaugeStation::diameter(270.0, 5.0)], 1.4, 1);
    let record = GaugeRecord::from_one(diameter(270.0), from(&part.readings[0], DWELLS_FROM_RAD)).unwrap();
    let published = |phases: usize| PublishedRunout::measure(&record, &law(0.2), DWELLS_FROM_RAD, phases).unwrap_err();
    let PublishedError::WindowTooShort { turned_deg, needed_deg } = published(72) else { panic!() };
    assert!(turned_deg < 505.0 && (needed_deg - 540.0).abs() < 1e-9);
    assert!(matches!(published(4), PublishedError::Phases { phases: 4, .. }));
    assert!(matches!(RadiusByPhase::new(vec![1.0; 7]), Err(PhasesError::TooFew { count: 7, .. })));
    let mut radii = vec![1.0; 9];
    radii[4] = f64::NAN;
    assert!(matches!(RadiusByPhase::new(radii), Err(PhasesError::NotFinite { index: 4 })));
    for bad in [0.0, -1.0, f64::NAN] {
        assert!(matches!(spark_out::turns(&law(0.2), bad, 1.0), Err(SparkOutError::Runout { .. })));
        assert!(matches!(spark_out::turns(&law(0.2), 1.0, bad), Err(SparkOutError::Runout { .. })));
    }
    let point = |way_mm: f64, force_n: f64| ForcePoint { way_mm, force_n };
    let refused = |points: &[ForcePoint]| machine_stiffness(points).unwrap_err();
    assert!(matches!(refused(&[point(0.0, 1.0), point(1.0, 2.0)]), StiffnessError::TooFew { points: 2, .. }));
    assert!(matches!(refused(&[point(0.0, 1.0); 3]), StiffnessError::OnePlace { .. }));
    assert!(matches!(refused(&[point(0.0, 3.0), point(1.0, 2.0), point(2.0, 1.0)]), StiffnessError::NotRising { .. }));
    assert!(matches!(
        refused(&[point(0.0, 3.0), point(f64::NAN, 2.0), point(2.0, 1.0)]),
        StiffnessError::NotFinite { index: 1 }
    ));
    assert!(matches!(grinding_stiffness_of_one_feed(point(0.0, 1.0), 0.0), Err(StiffnessError::Depth { .. })));
    // A threshold far below nothing: the force has an offset.
    let offset = [point(0.001, 10.0), point(0.002, 60.0), point(0.003, 110.0), point(0.004, 160.1)];
    let found = GrindingStiffness::from_feeds(&offset).unwrap();
    assert!(matches!(found.law(machine_stiffness(&offset).unwrap()), Err(StiffnessError::Law(_))));
}
