// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Contours against closed forms, against the follower that made them, and the lifts that have none.

use crate::cams;

use cams::{SplitMix64, contour_unless_undercut, lobe, lobe_segments, printed, program, random_segments};
use camwright::cam::contour::{Contour, ContourError};
use camwright::cam::follower::{Follower, FollowerError};
use camwright::cam::lift::LiftLaw;
use camwright::cam::motion_law::MotionLaw;
use camwright::math::units::{TURN_RAD, deg_from_rad};
use std::f64::consts::PI;

fn angles(count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| TURN_RAD * (f64::from(i) + 0.31) / f64::from(count))
}

const CENTRED_ROLLER: Follower = Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 };

/// A flat follower on an eccentric disc lifts by e(1 + cos a); the contour is the disc again, for the lift of any
/// follower.
#[test]
fn eccentric_disc_gives_back_the_disc() {
    let (e, radius) = (4.2, 19.0);
    let contours = [
        Contour::eccentric(e, radius).unwrap(),
        Contour::from_lift(&LiftLaw::eccentric_flat(e, 0.0).unwrap(), &Follower::Flat, radius - e).unwrap(),
        Contour::from_lift(&LiftLaw::eccentric_round(e, radius + 8.5, 0.0).unwrap(), &CENTRED_ROLLER, radius - e)
            .unwrap(),
        Contour::from_lift(
            &LiftLaw::eccentric_round(e, radius, 0.0).unwrap(),
            &Follower::KnifeEdge { offset_mm: 0.0 },
            radius - e,
        )
        .unwrap(),
    ];
    for contour in contours {
        for angle in angles(720) {
            let point = contour.point(angle);
            assert!((libm::hypot(point.x - e, point.y) - radius).abs() < 1e-13 * radius, "{angle}");
            assert!((contour.curvature(angle) - 1.0 / radius).abs() < 1e-13, "{angle}");
            let normal = contour.normal(angle);
            assert!((normal.x * radius - (point.x - e)).abs() < 1e-12 && (normal.y * radius - point.y).abs() < 1e-12);
            // ρ(a) = e cos a + √(r² − e² sin² a)
            let wanted = e * angle.cos() + (radius * radius - (e * angle.sin()).powi(2)).sqrt();
            assert!((contour.radius_at(angle) - wanted).abs() < 1e-12, "{angle}");
        }
        assert_eq!(contour.largest_wheel_radius_mm(), None);
    }
}

/// Simple harmonic lift over the whole turn under a flat follower is an eccentric circle; built from two harmonic
/// segments it must be the same one.
#[test]
fn flat_follower_with_harmonic_lift_is_a_circle() {
    let (lift_mm, base) = (6.0, 14.0);
    let law = program(0.0, &lobe_segments(MotionLaw::Harmonic, lift_mm, 180.0)[1..3]);
    let contour = Contour::from_lift(&law, &Follower::Flat, base).unwrap();
    let (radius, e) = (base + lift_mm / 2.0, lift_mm / 2.0);
    for angle in angles(720) {
        let point = contour.point(angle);
        assert!((libm::hypot(point.x + e, point.y) - radius).abs() < 1e-13 * radius, "{angle}");
    }
}

/// Rb 15, lift 9 in 65° under a flat follower needs a radius of curvature of −17 mm.
#[test]
fn too_steep_lobe_is_undercut() {
    let law = lobe(MotionLaw::Polynomial345, 9.0, 65.0);
    let error = Contour::from_lift(&law, &Follower::Flat, 15.0).unwrap_err();
    let ContourError::Undercut { angle_deg, radius_of_curvature_mm, bound_mm } = error else { panic!("{error:?}") };
    // At u = (3 + √3)/6 the acceleration is least: −10/√3 h/β².
    assert!((radius_of_curvature_mm + 17.0).abs() < 0.2, "{radius_of_curvature_mm}");
    let u = (3.0 + 3.0_f64.sqrt()) / 6.0;
    let from_nose = (angle_deg - 180.0).abs();
    assert!((from_nose - 65.0 * (1.0 - u)).abs() < 2.0, "{angle_deg}");
    assert!(bound_mm.abs() < f64::MIN_POSITIVE);
    // The same from its printed table.
    let law = LiftLaw::from_table(&printed(&law, 3600, 1e-3)).unwrap();
    assert!(matches!(
        Contour::from_lift(&law, &Follower::Flat, 15.0),
        Err(ContourError::Undercut { radius_of_curvature_mm, .. }) if (radius_of_curvature_mm + 17.0).abs() < 0.5
    ));
}

/// The boundary of undercut is exact to a micrometre and depends on the base radius only.
#[test]
fn undercut_begins_where_the_radius_of_curvature_vanishes() {
    let law = lobe(MotionLaw::Cycloidal, 6.0, 62.0);
    let min = angles(200_000).map(|a| law.sample(a)).map(|s| s.value + s.second).fold(f64::INFINITY, f64::min);
    assert!(Contour::from_lift(&law, &Follower::Flat, -min - 1e-3).is_err());
    assert!(Contour::from_lift(&law, &Follower::Flat, -min + 1e-3).is_ok());
    // Roller: the pitch curve turns more tightly than the roller.
    let error = Contour::from_lift(&law, &Follower::Roller { radius_mm: 25.0, offset_mm: 0.0 }, 4.0).unwrap_err();
    assert!(
        matches!(error, ContourError::Undercut { radius_of_curvature_mm, .. } if radius_of_curvature_mm < 0.0),
        "{error}"
    );
}

/// Every contour is touched by its follower where the lift says, and nowhere entered: the follower's position is found
/// again from points of the contour alone.
#[test]
fn contour_gives_back_the_lift_to_its_follower() {
    let mut made = 0;
    for seed in 0..60 {
        let mut random = SplitMix64(seed);
        let law = program(random.within(0.0, TURN_RAD), &random_segments(&mut random));
        let base = random.within(12.0, 30.0);
        let follower = match random.next() % 4 {
            0 => Follower::Flat,
            1 => Follower::Roller { radius_mm: random.within(3.0, 15.0), offset_mm: 0.0 },
            2 => Follower::Roller { radius_mm: random.within(3.0, 15.0), offset_mm: random.within(-5.0, 5.0) },
            _ => Follower::KnifeEdge { offset_mm: random.within(-3.0, 3.0) },
        };
        let Some(contour) = contour_unless_undercut(&law, &follower, base, seed) else { continue };
        made += 1;
        let points: Vec<_> = angles(20_000).map(|angle| contour.point(angle)).collect();
        for angle in angles(37) {
            let (cos, sin) = (angle.cos(), angle.sin());
            let lift = law.sample(angle).value;
            let (found, wanted) = match follower {
                Follower::Flat => {
                    (points.iter().map(|p| p.x * cos + p.y * sin).fold(f64::NEG_INFINITY, f64::max), base + lift)
                }
                Follower::Roller { radius_mm, offset_mm } => (
                    points
                        .iter()
                        .map(|p| (p.x * cos + p.y * sin, p.y * cos - p.x * sin - offset_mm))
                        .filter(|(_, across)| across.abs() <= radius_mm)
                        .map(|(along, across)| along + (radius_mm * radius_mm - across * across).sqrt())
                        .fold(f64::NEG_INFINITY, f64::max),
                    libm::sqrt((base + radius_mm).powi(2) - offset_mm.powi(2)) + lift,
                ),
                Follower::KnifeEdge { offset_mm } => {
                    let point = contour.point(angle);
                    assert!((point.y * cos - point.x * sin - offset_mm).abs() < 1e-12);
                    (point.x * cos + point.y * sin, libm::sqrt(base * base - offset_mm * offset_mm) + lift)
                }
                other => panic!("{other:?} is not among them"),
            };
            assert!((found - wanted).abs() < 5e-6, "seed {seed}, {follower:?}: {found} {wanted} at {angle}");
        }
    }
    assert!(made > 25, "{made}");
}

/// Normal and curvature against differences of the points, which share no formula with them.
#[test]
fn normal_and_curvature_are_those_of_the_points() {
    for follower in [
        Follower::Flat,
        CENTRED_ROLLER,
        Follower::Roller { radius_mm: 8.5, offset_mm: 3.0 },
        Follower::KnifeEdge { offset_mm: -2.0 },
    ] {
        let law = lobe(MotionLaw::Polynomial4567, 4.0, 70.0);
        let contour = Contour::from_lift(&law, &follower, 20.0).unwrap();
        let step = 1e-4;
        for angle in angles(977) {
            let (a, m, b) = (contour.point(angle - step), contour.point(angle), contour.point(angle + step));
            let (first, second) = ((b - a) / (2.0 * step), (b - 2.0 * m + a) / (step * step));
            let length = first.norm();
            assert!(contour.normal(angle).dot(&first).abs() < 1e-5 * length, "{follower:?} {angle}");
            assert!((contour.normal(angle).norm() - 1.0).abs() < 1e-14);
            let curvature = (first.x * second.y - first.y * second.x) / length.powi(3);
            assert!((curvature - contour.curvature(angle)).abs() < 2e-4, "{follower:?} {angle}: {curvature}");
            assert!((contour.normal_angle(angle) - angle).abs() < PI / 2.0);
            let azimuth = contour.azimuth(angle);
            assert!((contour.radius_at(azimuth) - m.norm()).abs() < 1e-12);
            assert!((contour.cam_angle_at(azimuth) - angle).abs() < 1e-12);
            assert!((contour.cam_angle_at(azimuth + TURN_RAD) - angle - TURN_RAD).abs() < 1e-12);
        }
    }
}

/// The reference lobe: roller 8.5, base 16, lift 6, 3-4-5 over 62°. Pressure angle 20.8°, concave 203 mm.
#[test]
fn reference_lobe_has_its_known_figures() {
    let contour = Contour::from_lift(&lobe(MotionLaw::Polynomial345, 6.0, 62.0), &CENTRED_ROLLER, 16.0).unwrap();
    let steepest = contour.max_pressure_angle();
    assert!((deg_from_rad(steepest.value.abs()) - 20.8).abs() < 0.1, "{}", deg_from_rad(steepest.value));
    let largest = contour.largest_wheel_radius_mm().unwrap();
    assert!((largest - 203.0).abs() < 1.0, "{largest}");
}

/// Turning the law turns the contour.
#[test]
fn rotating_the_lift_rotates_the_contour() {
    for seed in 100..110 {
        let mut random = SplitMix64(seed);
        let segments = random_segments(&mut random);
        let turn = random.within(0.0, TURN_RAD);
        let make = |start| Contour::from_lift(&program(start, &segments), &CENTRED_ROLLER, 25.0);
        let (Ok(plain), Ok(turned)) = (make(0.0), make(turn)) else { continue };
        for angle in angles(90) {
            assert!((plain.radius_at(angle) - turned.radius_at(angle + turn)).abs() < 1e-11, "seed {seed}");
        }
    }
}

#[test]
fn what_is_no_cam_is_refused() {
    let law = lobe(MotionLaw::Cycloidal, 5.0, 70.0);
    for base in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Contour::from_lift(&law, &Follower::Flat, base), Err(ContourError::BadBaseRadius { .. })));
    }
    let with = |follower| Contour::from_lift(&law, &follower, 20.0).unwrap_err();
    assert!(matches!(
        with(Follower::Roller { radius_mm: 0.0, offset_mm: 0.0 }),
        ContourError::Follower(FollowerError::BadRadius { .. })
    ));
    assert!(matches!(
        with(Follower::KnifeEdge { offset_mm: 20.0 }),
        ContourError::Follower(FollowerError::OffsetTooLarge { .. })
    ));
    assert!(matches!(Contour::eccentric(19.0, 19.0), Err(ContourError::AxisOutside { .. })));
    assert!(matches!(Contour::eccentric(f64::NAN, 19.0), Err(ContourError::Lift(_))));
    assert!(Contour::eccentric(0.0, 19.0).is_ok());
}

/// A waist narrower than the roller: every place is regular by itself, but the contour passes the axis.
#[test]
fn contour_that_passes_the_axis_is_refused() {
    let law = LiftLaw::from_fn(|angle| 20.0 * (1.0 - (2.0 * angle).cos())).unwrap();
    let error = Contour::from_lift(&law, &Follower::KnifeEdge { offset_mm: 0.49 }, 0.5).unwrap_err();
    assert!(matches!(error, ContourError::PassesAxis { .. }), "{error}");
}
