// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Learning from part to part against closed forms, on answers it can and cannot learn from, and the path that comes of it.

use crate::cams;

use cams::{SplitMix64, camshaft_segments, lobe, program};
use camwright::cam::compensation::{CompensationSpec, FormCurve, Learned, LobeLearning, SAME_MM};
use camwright::cam::contour::Contour;
use camwright::cam::follower::Follower;
use camwright::cam::form::Form;
use camwright::cam::motion_law::MotionLaw;
use camwright::math::units::TURN_RAD;
use camwright::toolpath::wheel_path::{ToolPath, ToolPathError};

const ROLLER: Follower = Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 };

fn spec() -> CompensationSpec {
    CompensationSpec::default()
}

fn curve(mean_mm: f64, waves_mm: &[[f64; 2]]) -> FormCurve {
    FormCurve::new(mean_mm, waves_mm.to_vec()).expect("finite")
}

/// Some micrometres in the first dozen harmonics.
fn random_curve(random: &mut SplitMix64) -> FormCurve {
    let waves: Vec<[f64; 2]> = (0..12).map(|_| [random.within(-0.001, 0.001), random.within(-0.001, 0.001)]).collect();
    curve(random.within(-0.002, 0.002), &waves)
}

/// Form error of a machine that applies this share of a correction, with this lag (rad) in every harmonic.
fn answer(own: &FormCurve, correction: &FormCurve, share: f64, lag_rad: f64) -> FormCurve {
    let (sin, cos) = lag_rad.sin_cos();
    let waves = correction.waves_mm().iter().map(|[a, b]| [a * cos - b * sin, a * sin + b * cos]).collect();
    own.plus(share, &FormCurve::new(correction.mean_mm(), waves).expect("finite"))
}

fn learned(own: &FormCurve, share: f64, lag_rad: f64, parts: usize) -> (Vec<f64>, LobeLearning) {
    let wide = CompensationSpec { max_mm: 0.1, max_slope_mm_rad: 1.0, ..spec() };
    let mut learning = LobeLearning::new(&wide);
    let mut errors = Vec::new();
    for _ in 0..parts {
        let error = answer(own, &learning.correction, share, lag_rad);
        errors.push(error.rms_mm());
        learning.learn(&wide, &error);
    }
    (errors, learning)
}

/// e(n + 1) = (1 − γ) e(n), in every harmonic and in the mean.
#[test]
fn an_error_that_comes_back_shrinks_by_the_gain_with_every_part() {
    let own = curve(0.0012, &[[0.001, -0.0005], [0.0, 0.002], [0.0003, 0.0]]);
    let mut learning = LobeLearning::new(&spec());
    for part in 0..8 {
        let error = own.plus(1.0, &learning.correction);
        let left = 0.3_f64.powi(part);
        assert!((error.mean_mm() - left * own.mean_mm()).abs() < 1e-15);
        for (found, own) in error.waves_mm().iter().zip(own.waves_mm()) {
            assert!((found[0] - left * own[0]).abs() < 1e-15 && (found[1] - left * own[1]).abs() < 1e-15, "{part}");
        }
        assert_eq!(learning.learn(&spec(), &error), Learned::Step);
    }
    assert_eq!((learning.parts, learning.gain), (8, 0.7));
}

/// |1 − γ g e^(−iλ)|² = 1 − 2 γ g cos λ + γ² g² a part, as long as that shrinks.
#[test]
fn an_answer_that_lags_shrinks_the_error_as_the_closed_form_says() {
    let own = curve(0.0, &[[0.0, 0.0], [0.004, 0.0]]);
    for (share, lag_deg) in [(1.0, 30.0_f64), (0.8, 45.0), (1.2, 20.0)] {
        let lag = lag_deg.to_radians();
        let times = (1.0 - 2.0 * 0.7 * share * lag.cos() + (0.7 * share).powi(2)).sqrt();
        let (errors, _) = learned(&own, share, lag, 4);
        for (before, after) in errors.iter().zip(&errors[1..]) {
            assert!((after / before - times).abs() < 1e-9, "{share}, {lag_deg} deg: {errors:?}, {times}");
        }
    }
}

/// Whatever the answer: lags up to half a turn, up to three times as much. What stays is never worse than the least error that was
/// seen, but for what counts as the same; with a lag well below a quarter turn and an answer that is not twice too much it converges.
#[test]
fn an_answer_that_is_wrong_converges_or_is_not_learned_from() {
    for seed in 1..=200 {
        let mut random = SplitMix64(seed);
        let own = random_curve(&mut random);
        let (share, lag) = (random.within(0.2, 3.0), random.within(0.0, std::f64::consts::PI));
        let (errors, learning) = learned(&own, share, lag, 80);
        let context = format!("seed {seed}, share {share}, lag {} deg", lag.to_degrees());
        // One step too far shows and is taken back: no part is worse than a single step of the full gain can make it.
        let max = (errors[0] + SAME_MM) * (1.0 + 0.7 * share);
        assert!(errors.iter().all(|error| *error <= max), "{context}: {errors:?}");
        let last = errors[errors.len() - 1];
        assert!(last <= errors[0] + SAME_MM, "{context}: {errors:?}");
        if lag.to_degrees() < 60.0 && share < 2.0 {
            assert!(last < 0.2 * errors[0] + SAME_MM, "{context}: {errors:?}");
        }
        if learning.gain <= 0.0 {
            let stays = answer(&own, &learning.correction, share, lag).rms_mm();
            assert!(stays <= errors[0] + SAME_MM, "{context}: {stays}");
        }
    }
}

#[test]
fn an_answer_the_wrong_way_round_stops_learning_on_the_part_as_designed() {
    let own = curve(0.002, &[[0.001, 0.001]]);
    let (errors, learning) = learned(&own, 1.0, 0.0, 1);
    assert!(learning.gain > 0.0 && errors.len() == 1);
    let mut learning = LobeLearning::new(&spec());
    let mut last = Learned::Step;
    for _ in 0..40 {
        last = learning.learn(&spec(), &own.plus(-1.0, &learning.correction));
    }
    assert_eq!((last, learning.gain), (Learned::Stopped, 0.0));
    assert!(learning.correction.rms_mm() < SAME_MM, "{:?}", learning.correction.rms_mm());
}

/// A machine that has changed (a dress, a warmer spindle) is not one that answers wrongly: learning goes on.
#[test]
fn a_machine_that_changes_is_learned_again() {
    let mut learning = LobeLearning::new(&spec());
    let mut error = FormCurve::default();
    for part in 0..14 {
        let own = if part < 5 { curve(0.0005, &[[0.001, 0.0]]) } else { curve(0.006, &[[0.001, 0.0]]) };
        error = own.plus(1.0, &learning.correction);
        learning.learn(&spec(), &error);
    }
    assert!(error.rms_mm() < SAME_MM, "{}", error.rms_mm());
    assert!(learning.gain > 0.3, "{}", learning.gain);
}

#[test]
fn a_correction_keeps_within_its_bounds_and_keeps_its_shape() {
    let own = curve(0.06, &[[0.0, 0.03], [0.02, 0.0]]);
    let mut learning = LobeLearning::new(&spec());
    for _ in 0..6 {
        assert_eq!(learning.learn(&spec(), &own), Learned::Bounded);
        let (size, slope) = learning.correction.largest();
        assert!(size <= spec().max_mm * (1.0 + 1e-12) && slope <= spec().max_slope_mm_rad * (1.0 + 1e-12));
    }
    let share = learning.correction.mean_mm() / own.mean_mm();
    assert!(share < 0.0 && (learning.correction.waves_mm()[1][0] / own.waves_mm()[1][0] - share).abs() < 1e-12);
}

/// Only the harmonics of the job are learned: one above them stays where it is.
#[test]
fn what_is_shorter_than_the_harmonics_is_left_alone() {
    let narrow = CompensationSpec { harmonics: 2, ..spec() };
    let own = curve(0.0, &[[0.001, 0.0], [0.0, 0.001], [0.002, 0.0]]);
    let mut learning = LobeLearning::new(&narrow);
    learning.learn(&narrow, &own);
    assert_eq!(learning.correction.waves_mm().len(), 2);
}

/// A curve ground onto a contour is read back from the radii: the paths and the measurement are each other's inverse.
#[test]
fn a_path_that_is_shifted_by_a_curve_grinds_that_curve() {
    let valve = Contour::from_lift(&program(0.0, &camshaft_segments()), &ROLLER, 17.0).unwrap();
    let disc = Contour::eccentric(4.2, 19.0).unwrap();
    let off = curve(0.002, &[[0.003, 0.0], [0.0, -0.002], [0.0, 0.0], [0.0, 0.0], [0.001, 0.001]]);
    for contour in [valve, disc] {
        for wheel in [40.0, 80.0] {
            let path = ToolPath::compensated(&contour, &off, wheel).unwrap();
            let mut worst = 0.0_f64;
            for i in 0..2000 {
                let point = path.contact(f64::from(i) * TURN_RAD / 2000.0);
                let (distance, angle) = contour.distance(libm::hypot(point.x, point.y), libm::atan2(point.y, point.x));
                worst = worst.max((distance - off.sample(angle).value).abs());
            }
            assert!(worst < 1e-7, "{worst} mm");
        }
    }
}

/// The disc of radius r + m has the closed form of a larger disc.
#[test]
fn a_correction_that_is_the_same_all_round_is_a_larger_disc() {
    let (e, r, m, wheel) = (4.2, 19.0, 0.004, 60.0);
    let path = ToolPath::compensated(&Contour::eccentric(e, r).unwrap(), &curve(m, &[]), wheel).unwrap();
    for i in 0..997 {
        let angle = f64::from(i) * TURN_RAD / 997.0;
        let centre = e * angle.cos() + ((r + m + wheel).powi(2) - (e * angle.sin()).powi(2)).sqrt();
        assert!((path.sample(angle).value + wheel - centre).abs() < 1e-9);
    }
}

#[test]
fn no_correction_has_the_bits_of_the_design() {
    let contour = Contour::from_lift(&program(0.0, &camshaft_segments()), &ROLLER, 17.0).unwrap();
    let designed = ToolPath::for_wheel(&contour, 60.0).unwrap();
    assert_eq!(ToolPath::compensated(&contour, &curve(0.0, &[[0.0; 2]; 40]), 60.0).unwrap(), designed);
}

/// Measured on the azimuths of a part, turned by its phase, and read over the cam angle.
#[test]
fn a_curve_on_a_part_is_measured_as_it_is() {
    let contour = Contour::from_lift(&program(0.0, &camshaft_segments()), &ROLLER, 17.0).unwrap();
    let off = curve(-0.001, &[[0.002, 0.0], [0.0, 0.0], [0.0, 0.0005]]);
    let phase = 0.7;
    let radii: Vec<f64> = (0..3600)
        .map(|i| {
            let azimuth = f64::from(i) * TURN_RAD / 3600.0 - phase;
            // The radius whose distance along the normal is the curve's there.
            let mut radius = contour.radius_at(azimuth);
            for _ in 0..30 {
                let (distance, angle) = contour.distance(radius, azimuth);
                radius += off.sample(angle).value - distance;
            }
            radius
        })
        .collect();
    let found = FormCurve::measure(&radii, &contour, phase, 6).unwrap();
    assert!(found.plus(-1.0, &off).largest().0 < 5e-7, "{:?}", found.plus(-1.0, &off).largest());
    // The base circle of the valve lobe is where its lift is nothing; its mean there is its size.
    let size = Form::measure(&radii, &contour, phase).unwrap().size_mm(&contour, phase);
    let rests = (0..36_000)
        .map(|i| f64::from(i) * TURN_RAD / 36_000.0)
        .filter(|at| contour.lift().sample(*at).value.abs() < 0.0005);
    let values: Vec<f64> = rests.map(|at| off.sample(at).value).collect();
    let wanted = values.iter().sum::<f64>() / values.len() as f64;
    assert!((size - wanted).abs() < 2e-6, "{size} {wanted}");
}

#[test]
fn a_journal_is_as_large_as_it_is_all_round() {
    let contour = Contour::eccentric(0.0, 20.0).unwrap();
    let radii: Vec<f64> = (0..360).map(|i| 20.001 + 0.002 * (f64::from(i) * TURN_RAD / 360.0).cos()).collect();
    let size = Form::measure(&radii, &contour, 0.3).unwrap().size_mm(&contour, 0.3);
    assert!((size - 0.001).abs() < 1e-12, "{size}");
}

/// A wheel that hardly fits a hollow does not fit a hollow that a correction makes deeper: refused, never cut.
#[test]
fn a_correction_that_no_wheel_can_follow_is_refused() {
    let contour = Contour::from_lift(&lobe(MotionLaw::Polynomial4567, 6.0, 75.0), &ROLLER, 16.0).unwrap();
    let mut waves = vec![[0.0; 2]; 180];
    waves[179] = [0.01, 0.0];
    let error = ToolPath::compensated(&contour, &curve(0.0, &waves), 60.0).unwrap_err();
    assert!(matches!(error, ToolPathError::LeavesContour { .. } | ToolPathError::Unresolved { .. }), "{error}");
}
