// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Form deviation against parts whose deviation is known.

use crate::cams;

use cams::{camshaft_segments, program};
use camwright::cam::contour::Contour;
use camwright::cam::follower::Follower;
use camwright::cam::follower::{ArmSide, Pivot, SwingLift};
use camwright::cam::form::{Form, FormError};
use camwright::cam::lift::MotionSegment;
use camwright::math::units::TURN_RAD;

fn radii(count: u32, radius: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..count).map(|i| radius(TURN_RAD * f64::from(i) / f64::from(count))).collect()
}

#[test]
fn perfect_part_has_no_deviation() {
    let follower = Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 };
    let contour = Contour::from_lift(&program(0.0, &camshaft_segments()), &follower, 17.0).unwrap();
    let phase = 0.7;
    let form = Form::measure(&radii(3600, |azimuth| contour.radius_at(azimuth - phase)), &contour, phase).unwrap();
    assert!(form.largest.deviation_mm.abs() < 1e-12 && form.rms_mm < 1e-12, "{:?}", form.largest);
}

/// A disc larger by d, measured against the disc: the deviation is d everywhere along the normal, less along the radius.
#[test]
fn larger_eccentric_deviates_by_the_difference_of_radii() {
    let (e, r, d) = (6.0, 20.0, 0.25);
    let contour = Contour::eccentric(e, r).unwrap();
    let larger = Contour::eccentric(e, r + d).unwrap();
    let form = Form::measure(&radii(720, |azimuth| larger.radius_at(azimuth)), &contour, 0.0).unwrap();
    assert!(form.deviations_mm.iter().all(|deviation| (deviation - d).abs() < 1e-10), "{:?}", form.largest);
    assert!((form.rms_mm - d).abs() < 1e-10);
}

#[test]
fn largest_deviation_is_found_with_its_sign_and_place() {
    let contour = Contour::eccentric(0.0, 20.0).unwrap();
    let mut measured = radii(360, |_| 20.002);
    measured[90] = 19.99;
    let form = Form::measure(&measured, &contour, 0.5).unwrap();
    assert!((form.largest.deviation_mm + 0.01).abs() < 1e-12);
    assert!((form.largest.azimuth_rad - TURN_RAD / 4.0).abs() < 1e-12);
    assert!((form.largest.cam_angle_rad - (TURN_RAD / 4.0 - 0.5)).abs() < 1e-9);
    let wanted = ((359.0 * 0.002_f64.powi(2) + 0.01_f64.powi(2)) / 360.0).sqrt();
    assert!((form.rms_mm - wanted).abs() < 1e-12);
}

#[test]
fn what_is_no_radius_is_refused() {
    let contour = Contour::eccentric(1.0, 20.0).unwrap();
    assert_eq!(Form::measure(&[], &contour, 0.0), Err(FormError::NoRadii));
    assert!(matches!(Form::measure(&[20.0, f64::NAN], &contour, 0.0), Err(FormError::BadRadius { .. })));
    assert!(matches!(Form::measure(&[20.0, -1.0], &contour, 0.0), Err(FormError::BadRadius { .. })));
}

/// A cam whose lift is larger by a ten thousandth is measured to have just that lift too much, under every kind of follower.
#[test]
fn the_error_of_the_lift_is_what_the_follower_feels() {
    let segments = camshaft_segments();
    let larger: Vec<_> = segments.iter().map(|s| MotionSegment { rise_mm: 1.0001 * s.rise_mm, ..*s }).collect();
    let pivot = Pivot { distance_mm: 70.0, side: ArmSide::Ahead, lift: SwingLift::Arc { radius_mm: 40.0 } };
    for follower in [
        Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 },
        Follower::Roller { radius_mm: 8.5, offset_mm: 3.0 },
        Follower::Flat,
        Follower::OscillatingRoller { radius_mm: 8.5, arm_mm: 60.0, pivot },
    ] {
        assert!(follower.lift_is_length());
        let design = Contour::from_lift(&program(0.0, &segments), &follower, 40.0).unwrap();
        let ground = Contour::from_lift(&program(0.0, &larger), &follower, 40.0).unwrap();
        let phase = 0.4;
        let form = Form::measure(&radii(3600, |azimuth| ground.radius_at(azimuth - phase)), &design, phase).unwrap();
        let (error, wanted) = (form.lift_error(&design, phase), 1e-4 * 8.5);
        assert!((error / wanted - 1.0).abs() < 2e-3, "{follower:?}: {error} mm, not {wanted}");
    }
    // A disc that is larger all round lifts a roller the same everywhere on its base circle: no error of the lift on an idle cam.
    let round = Contour::eccentric(0.0, 20.0).unwrap();
    let form = Form::measure(&radii(360, |_| 20.1), &round, 0.0).unwrap();
    assert!(form.lift_error(&round, 0.0) < 1e-12);
}
