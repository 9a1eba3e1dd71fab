// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Cams of oscillating followers against closed forms, against the follower itself, and the geometries that are none.

use crate::cams;

use cams::{SplitMix64, contour_unless_undercut, lobe, program, random_segments};
use camwright::cam::contour::{Contour, ContourError};
use camwright::cam::follower::{ArmSide, Follower, FollowerError, Pivot, SwingLift};
use camwright::cam::lift::LiftLaw;
use camwright::cam::motion_law::MotionLaw;
use camwright::math::units::{TURN_RAD, deg_from_rad, rad_from_deg};
use camwright::toolpath::wheel_path::{ToolPath, ToolPathError};
use nalgebra::Vector2;
use std::f64::consts::PI;

const SIDES: [ArmSide; 2] = [ArmSide::Ahead, ArmSide::Behind];

fn angles(count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| TURN_RAD * (f64::from(i) + 0.31) / f64::from(count))
}

fn roller(radius_mm: f64, arm_mm: f64, distance_mm: f64, side: ArmSide, lift: SwingLift) -> Follower {
    Follower::OscillatingRoller { radius_mm, arm_mm, pivot: Pivot { distance_mm, side, lift } }
}

fn flat(face_offset_mm: f64, distance_mm: f64, side: ArmSide, lift: SwingLift) -> Follower {
    Follower::OscillatingFlat { face_offset_mm, pivot: Pivot { distance_mm, side, lift } }
}

fn turned(v: Vector2<f64>, angle: f64) -> Vector2<f64> {
    let (sin, cos) = angle.sin_cos();
    Vector2::new(v.x * cos - v.y * sin, v.x * sin + v.y * cos)
}

fn unit(angle: f64) -> Vector2<f64> {
    Vector2::new(angle.cos(), angle.sin())
}

/// The follower as a drawing has it: pivot, direction of the arm, and the arm's angle, at a cam angle. The arm is the
/// direction to the cam's axis, turned by ψ: clockwise if it reaches ahead.
fn drawn(follower: &Follower, base: f64, law: &LiftLaw, angle: f64) -> (Vector2<f64>, Vector2<f64>, f64) {
    let (pivot, rest) = match *follower {
        Follower::OscillatingRoller { radius_mm, arm_mm: a, pivot } => {
            let (c, p) = (pivot.distance_mm, base + radius_mm);
            (pivot, ((c * c + a * a - p * p) / (2.0 * a * c)).acos())
        }
        Follower::OscillatingFlat { face_offset_mm, pivot } => {
            (pivot, ((base - face_offset_mm) / pivot.distance_mm).asin())
        }
        other => panic!("{other:?} does not oscillate"),
    };
    let lift = law.sample(angle).value;
    let psi = rest
        + match pivot.lift {
            SwingLift::Degrees => rad_from_deg(lift),
            SwingLift::Arc { radius_mm } => lift / radius_mm,
        };
    let arm = match pivot.side {
        ArmSide::Ahead => turned(-unit(angle), -psi),
        ArmSide::Behind => turned(-unit(angle), psi),
    };
    (pivot.distance_mm * unit(angle), arm, psi)
}

/// Points of the contour at equal steps of the cam angle.
fn points(contour: &Contour) -> Vec<Vector2<f64>> {
    angles(POINTS).map(|angle| contour.point(angle)).collect()
}

const POINTS: u32 = 20_000;

/// Smallest value over the contour: over its points, then over points between the neighbours of the best.
fn min(contour: &Contour, points: &[Vector2<f64>], value: impl Fn(Vector2<f64>) -> f64) -> f64 {
    let best =
        (0..points.len()).min_by(|&a, &b| value(points[a]).total_cmp(&value(points[b]))).expect("a contour has points");
    let step = TURN_RAD / f64::from(POINTS);
    (-100..=100)
        .map(|i| value(contour.point(step * (best as f64 + 0.31 + 0.01 * f64::from(i)))))
        .fold(f64::INFINITY, f64::min)
}

/// A random oscillating follower that can lie on the base circle.
fn random_follower(random: &mut SplitMix64, base: f64) -> Follower {
    let side = random.one_of(&SIDES);
    if random.next().is_multiple_of(2) {
        let radius = random.within(4.0, 15.0);
        let (prime, distance) = (base + radius, base + radius + random.within(15.0, 60.0));
        let arm = (prime * unit(random.within(0.7, 2.2)) - Vector2::new(distance, 0.0)).norm();
        let arc = SwingLift::Arc { radius_mm: random.within(0.2, 0.8) * arm };
        let lift = random.one_of(&[SwingLift::Degrees, arc]);
        roller(radius, arm, distance, side, lift)
    } else {
        let lift = random.one_of(&[SwingLift::Degrees, SwingLift::Arc { radius_mm: 50.0 }]);
        flat(random.within(-8.0, 8.0), base + random.within(25.0, 80.0), side, lift)
    }
}

#[test]
fn arm_at_rest_rides_on_the_base_circle() {
    let law = LiftLaw::eccentric_flat(0.0, 0.0).unwrap();
    for side in SIDES {
        for follower in [roller(8.5, 40.0, 50.0, side, SwingLift::Degrees), flat(3.0, 50.0, side, SwingLift::Degrees)] {
            let contour = Contour::from_lift(&law, &follower, 20.0).unwrap();
            for angle in angles(360) {
                assert!((contour.point(angle).norm() - 20.0).abs() < 1e-13, "{follower:?}");
                assert!((contour.curvature(angle) - 0.05).abs() < 1e-15, "{follower:?}");
                let off = contour.azimuth(angle) - angle;
                assert!(if side == ArmSide::Ahead { off > 0.0 && off < PI } else { off < 0.0 && off > -PI }, "{off}");
                assert!((contour.normal_angle(angle) - contour.azimuth(angle)).abs() < 1e-13);
            }
            let path = ToolPath::for_wheel(&contour, 60.0).unwrap();
            for angle in angles(360) {
                assert!((path.sample(angle).value - 20.0).abs() < 1e-12, "{follower:?}");
            }
        }
    }
}

/// The centre E of an eccentric disc, the pivot A and the roller P are a four-bar linkage: |P − E| = r + rr, |P − A| = a.
/// The swing it makes gives the disc back.
#[test]
fn four_bar_linkage_gives_back_the_eccentric_disc() {
    let (e, r, rr, a, c): (f64, f64, f64, f64, f64) = (4.2, 19.0, 8.5, 42.0, 55.0);
    for side in SIDES {
        let sign = if side == ArmSide::Ahead { 1.0 } else { -1.0 };
        let p = r - e + rr;
        let rest = ((c * c + a * a - p * p) / (2.0 * a * c)).acos();
        let swing = |angle: f64| {
            // Seen from the pivot, along the line to the axis and square to it on the arm's side.
            let to_disc = Vector2::new(c - e * angle.cos(), -sign * e * angle.sin());
            let q = to_disc.norm();
            let psi = to_disc.y.atan2(to_disc.x) + ((a * a + q * q - (r + rr).powi(2)) / (2.0 * a * q)).acos();
            psi - rest
        };
        let degrees = LiftLaw::from_fn(|angle| deg_from_rad(swing(angle))).unwrap();
        let arc = LiftLaw::from_fn(|angle| a * swing(angle)).unwrap();
        for (law, lift) in [(degrees, SwingLift::Degrees), (arc, SwingLift::Arc { radius_mm: a })] {
            let contour = Contour::from_lift(&law, &roller(rr, a, c, side, lift), r - e).unwrap();
            is_the_disc(&contour, e, r);
        }
    }
}

/// A face that swings on an eccentric disc: N·(A − E) = r − b.
#[test]
fn swinging_face_gives_back_the_eccentric_disc() {
    let (e, r, c): (f64, f64, f64) = (4.2, 19.0, 55.0);
    for (side, b) in SIDES.into_iter().flat_map(|side| [-6.0, 0.0, 6.0].map(|b| (side, b))) {
        let sign = if side == ArmSide::Ahead { 1.0 } else { -1.0 };
        let rest = ((r - e - b) / c).asin();
        let law = LiftLaw::from_fn(|angle| {
            let v = Vector2::new(c - e * angle.cos(), sign * e * angle.sin());
            let psi = ((r - b) / v.norm()).asin() - v.y.atan2(v.x);
            deg_from_rad(psi - rest)
        })
        .unwrap();
        let contour = Contour::from_lift(&law, &flat(b, c, side, SwingLift::Degrees), r - e).unwrap();
        is_the_disc(&contour, e, r);
        assert_eq!(contour.largest_wheel_radius_mm(), None);
    }
}

/// Contour and wheel path of a disc of radius r, its centre e from the axis at cam angle 0.
fn is_the_disc(contour: &Contour, e: f64, r: f64) {
    let what = contour.follower();
    for angle in angles(720) {
        let point = contour.point(angle);
        assert!((libm::hypot(point.x - e, point.y) - r).abs() < 1e-10, "{what:?} {angle}");
        assert!((contour.curvature(angle) * r - 1.0).abs() < 1e-5, "{what:?} {angle}: {}", contour.curvature(angle));
        assert!((contour.normal(angle) * r - (point - Vector2::new(e, 0.0))).norm() < 1e-8, "{what:?} {angle}");
    }
    for wheel in [8.0, 60.0, 200.0] {
        let path = ToolPath::for_wheel(contour, wheel).expect("every wheel grinds a disc");
        for angle in angles(2003) {
            let centre = e * angle.cos() + ((r + wheel).powi(2) - (e * angle.sin()).powi(2)).sqrt();
            assert!((path.sample(angle).value + wheel - centre).abs() < 2e-9, "{what:?} R {wheel} {angle}");
        }
    }
}

#[test]
fn mushroom_is_a_roller_on_the_axis() {
    let law = lobe(MotionLaw::Polynomial4567, 4.0, 70.0);
    let made = |follower| Contour::from_lift(&law, &follower, 20.0).unwrap();
    let (mushroom, roller) =
        (made(Follower::Mushroom { radius_mm: 45.0 }), made(Follower::Roller { radius_mm: 45.0, offset_mm: 0.0 }));
    for angle in angles(720) {
        assert_eq!(mushroom.point(angle), roller.point(angle));
        // The face touches r sin α beside the stem, α the pressure angle.
        let beside = 45.0 * mushroom.pressure_angle(angle).sin();
        assert!((mushroom.contact_on_face_mm(angle).unwrap() - beside).abs() < 1e-12);
    }
    assert_eq!(roller.contact_on_face_mm(1.0), None);
    assert_eq!(roller.face_in_use_mm(), None);
    // Too round a face is a roller too large for the nose.
    let error = Contour::from_lift(&law, &Follower::Mushroom { radius_mm: 2000.0 }, 8.0).unwrap_err();
    assert!(matches!(error, ContourError::Undercut { .. }), "{error}");
}

/// Half the face of a flat tappet must be at least max |s′| wide.
#[test]
fn flat_face_in_use_is_the_largest_velocity() {
    let law = lobe(MotionLaw::Cycloidal, 3.0, 75.0);
    let contour = Contour::from_lift(&law, &Follower::Flat, 18.0).unwrap();
    let fastest = 2.0 * 3.0 / rad_from_deg(75.0);
    let (min, max) = contour.face_in_use_mm().unwrap();
    assert!((min + fastest).abs() < 1e-9 && (max - fastest).abs() < 1e-9, "{min} {max}");
}

/// The roller touches the contour and enters it nowhere, the face lies on it: found from points of the contour alone.
#[test]
fn oscillating_follower_touches_its_contour_and_enters_it_nowhere() {
    let mut made = 0;
    for seed in 0..120 {
        let mut random = SplitMix64(seed);
        let law = program(random.within(0.0, TURN_RAD), &random_segments(&mut random));
        let base = random.within(12.0, 30.0);
        let follower = random_follower(&mut random, base);
        let Some(contour) = contour_unless_undercut(&law, &follower, base, seed) else { continue };
        made += 1;
        let points = points(&contour);
        for angle in angles(37) {
            let (pivot, arm, psi) = drawn(&follower, base, &law, angle);
            let (found, wanted) = match follower {
                Follower::OscillatingRoller { radius_mm, arm_mm, .. } => {
                    let centre = pivot + arm_mm * arm;
                    (min(&contour, &points, |p| (p - centre).norm()), radius_mm)
                }
                Follower::OscillatingFlat { face_offset_mm, pivot: Pivot { side, .. } } => {
                    let normal = turned(arm, if side == ArmSide::Ahead { -PI / 2.0 } else { PI / 2.0 });
                    let highest = -min(&contour, &points, |p| (pivot - p).dot(&normal));
                    // Where the common normal passes the instant centre of cam and arm.
                    let rate = match contour.follower() {
                        Follower::OscillatingFlat { pivot: Pivot { lift: SwingLift::Degrees, .. }, .. } => PI / 180.0,
                        _ => 1.0 / 50.0,
                    } * law.sample(angle).first
                        * if side == ArmSide::Ahead { 1.0 } else { -1.0 };
                    let along = contour.contact_on_face_mm(angle).unwrap();
                    assert!((along - pivot.norm() * psi.cos() / (1.0 - rate)).abs() < 1e-10, "seed {seed}");
                    assert!(((contour.point(angle) - pivot).dot(&arm) - along).abs() < 1e-10, "seed {seed}");
                    let (min, max) = contour.face_in_use_mm().unwrap();
                    assert!(min <= along + 1e-9 && along <= max + 1e-9, "seed {seed}");
                    (highest, face_offset_mm)
                }
                other => panic!("{other:?}"),
            };
            assert!((found - wanted).abs() < 1e-6, "seed {seed}, {follower:?}: {found} {wanted} at {angle}");
        }
    }
    assert!(made > 60, "{made}");
}

/// Normal, curvature and pressure angle against differences of the points and of the arm.
#[test]
fn rates_are_those_of_the_points() {
    let law = lobe(MotionLaw::Polynomial4567, 6.0, 70.0);
    for side in SIDES {
        for follower in [
            roller(8.5, 42.0, 50.0, side, SwingLift::Degrees),
            roller(5.0, 25.0, 45.0, side, SwingLift::Arc { radius_mm: 25.0 }),
            flat(-4.0, 80.0, side, SwingLift::Arc { radius_mm: 150.0 }),
            flat(5.0, 45.0, side, SwingLift::Arc { radius_mm: 120.0 }),
        ] {
            let contour = Contour::from_lift(&law, &follower, 26.0).unwrap();
            let step = 1e-4;
            for angle in angles(977) {
                let (a, m, b) = (contour.point(angle - step), contour.point(angle), contour.point(angle + step));
                let (first, second) = ((b - a) / (2.0 * step), (b - 2.0 * m + a) / (step * step));
                let length = first.norm();
                let normal = contour.normal(angle);
                assert!(normal.dot(&first).abs() < 1e-5 * length, "{follower:?} {angle}");
                assert!(normal.perp(&first) > 0.0 && (normal.norm() - 1.0).abs() < 1e-14);
                let curvature = (first.x * second.y - first.y * second.x) / length.powi(3);
                assert!((curvature - contour.curvature(angle)).abs() < 2e-4, "{follower:?} {angle}: {curvature}");
                let azimuth = contour.azimuth(angle);
                assert!((contour.radius_at(azimuth) - m.norm()).abs() < 1e-12);
                assert!((contour.cam_angle_at(azimuth) - angle).abs() < 1e-12, "{follower:?}");
                assert!((contour.cam_angle_at(azimuth + TURN_RAD) - angle - TURN_RAD).abs() < 1e-12);
                // What moves with the arm turns about the pivot, away from the cam.
                let (pivot, arm, _) = drawn(&follower, 26.0, &law, angle);
                let lever = match follower {
                    Follower::OscillatingRoller { arm_mm, .. } => arm_mm * arm,
                    _ => m - pivot,
                };
                let motion = turned(lever, if side == ArmSide::Ahead { -PI / 2.0 } else { PI / 2.0 });
                let between = normal.perp(&motion).atan2(normal.dot(&motion));
                assert!((contour.pressure_angle(angle) - between).abs() < 1e-12, "{follower:?} {angle}");
            }
        }
    }
}

/// An arm that reaches behind, on a cam turned backwards, is an arm that reaches ahead seen from the other side.
#[test]
fn mirrored_lift_and_arm_give_the_mirrored_contour() {
    for seed in 200..230 {
        let mut random = SplitMix64(seed);
        let segments = random_segments(&mut random);
        let backwards: Vec<_> =
            segments.iter().rev().map(|s| camwright::cam::lift::MotionSegment { rise_mm: -s.rise_mm, ..*s }).collect();
        let base = random.within(14.0, 30.0);
        let follower = random_follower(&mut random, base);
        let other = |pivot: Pivot| Pivot {
            side: if pivot.side == ArmSide::Ahead { ArmSide::Behind } else { ArmSide::Ahead },
            ..pivot
        };
        let mirror = match follower {
            Follower::OscillatingRoller { radius_mm, arm_mm, pivot } => {
                Follower::OscillatingRoller { radius_mm, arm_mm, pivot: other(pivot) }
            }
            Follower::OscillatingFlat { face_offset_mm, pivot } => {
                Follower::OscillatingFlat { face_offset_mm, pivot: other(pivot) }
            }
            other => panic!("{other:?}"),
        };
        let plain = Contour::from_lift(&program(0.0, &segments), &follower, base);
        let mirrored = Contour::from_lift(&program(0.0, &backwards), &mirror, base);
        assert_eq!(plain.is_ok(), mirrored.is_ok(), "seed {seed}");
        let (Ok(plain), Ok(mirrored)) = (plain, mirrored) else { continue };
        for angle in angles(90) {
            let (a, b) = (plain.point(angle), mirrored.point(-angle));
            assert!((a.x - b.x).abs() < 1e-11 && (a.y + b.y).abs() < 1e-11, "seed {seed}");
        }
    }
}

/// The wheel pushed against the contour from outside stands where the path says.
#[test]
fn swept_wheel_leaves_the_contour_of_an_oscillating_follower() {
    let (mut made, mut too_large) = (0, 0);
    for seed in 300..360 {
        let mut random = SplitMix64(seed);
        let law = program(random.within(0.0, TURN_RAD), &random_segments(&mut random));
        let base = random.within(14.0, 30.0);
        let follower = random_follower(&mut random, base);
        let wheel = random.within(10.0, 400.0);
        let Ok(contour) = Contour::from_lift(&law, &follower, base) else { continue };
        let path = match ToolPath::for_wheel(&contour, wheel) {
            Ok(path) => path,
            Err(ToolPathError::WheelTooLarge { largest_mm, .. }) => {
                assert!(largest_mm < wheel, "seed {seed}");
                let fits = ToolPath::for_wheel(&contour, 0.8 * largest_mm).unwrap();
                assert!(fits.accuracy().contour_error_mm < 2e-6, "seed {seed}");
                too_large += 1;
                continue;
            }
            Err(other) => panic!("seed {seed}: {other}"),
        };
        made += 1;
        let points = points(&contour);
        for angle in angles(41) {
            let (sin, cos) = angle.sin_cos();
            let pushed = -min(&contour, &points, |p| {
                let across = p.y * cos - p.x * sin;
                if across.abs() > wheel {
                    return f64::INFINITY;
                }
                -(p.x * cos + p.y * sin) - (wheel * wheel - across * across).sqrt()
            });
            let found = path.sample(angle).value + wheel;
            assert!((found - pushed).abs() < 1e-6, "seed {seed}, {follower:?}, R {wheel}: {found} {pushed} at {angle}");
        }
    }
    assert!(made > 20 && too_large > 1, "{made} {too_large}");
}

#[test]
fn what_cannot_oscillate_on_the_cam_is_refused() {
    let law = lobe(MotionLaw::Cycloidal, 5.0, 70.0);
    let refused = |follower| Contour::from_lift(&law, &follower, 20.0).unwrap_err();
    let follower = |follower| match refused(follower) {
        ContourError::Follower(error) => error,
        other => panic!("{other}"),
    };
    let degrees = SwingLift::Degrees;
    for bad in [0.0, -3.0, f64::NAN, f64::INFINITY] {
        let ahead = ArmSide::Ahead;
        assert!(matches!(follower(roller(bad, 40.0, 50.0, ahead, degrees)), FollowerError::BadRadius { .. }));
        for other in [
            roller(8.5, bad, 50.0, ahead, degrees),
            roller(8.5, 40.0, bad, ahead, degrees),
            roller(8.5, 40.0, 50.0, ahead, SwingLift::Arc { radius_mm: bad }),
            flat(0.0, bad, ahead, degrees),
            Follower::Mushroom { radius_mm: bad },
        ] {
            assert!(matches!(follower(other), FollowerError::BadNumber { .. }), "{other:?}");
        }
    }
    for side in SIDES {
        // The prime circle of 28.5 mm is out of the arm's reach from either side.
        for (arm, pivot) in [(20.0, 49.0), (80.0, 51.0), (10.0, 18.0)] {
            let error = follower(roller(8.5, arm, pivot, side, degrees));
            assert!(matches!(error, FollowerError::ArmOutOfReach { .. }), "{error}");
        }
        for face in [-31.0, 71.0, f64::NAN] {
            let error = follower(flat(face, 50.0, side, degrees));
            assert!(matches!(error, FollowerError::FaceOutOfReach { .. }), "{error}");
        }
    }
    let far = LiftLaw::from_fn(|angle| 70.0 * (1.0 - angle.cos())).unwrap();
    for follower in [roller(8.5, 30.0, 50.0, ArmSide::Ahead, degrees), flat(0.0, 50.0, ArmSide::Ahead, degrees)] {
        let error = Contour::from_lift(&far, &follower, 40.0).unwrap_err();
        assert!(matches!(error, ContourError::Follower(FollowerError::SwingTooFar { .. })), "{error}");
    }
    // A pivot inside the cam.
    let error = refused(roller(8.5, 30.0, 15.0, ArmSide::Ahead, degrees));
    assert!(matches!(error, ContourError::ReachesPivot { bound_mm, .. } if (bound_mm - 15.0).abs() < 1e-12), "{error}");
}

/// A face that swings faster than the cam turns would touch only a hollow; one that swings too abruptly doubles back.
#[test]
fn too_steep_a_swing_of_a_face_is_refused() {
    for side in SIDES {
        let steep = lobe(MotionLaw::Cycloidal, 40.0, 20.0);
        let error = Contour::from_lift(&steep, &flat(0.0, 60.0, side, SwingLift::Degrees), 20.0).unwrap_err();
        // Cycloidal: the largest velocity is 2 h/β.
        assert!(matches!(error, ContourError::FaceTurnsBack { rate, .. } if (rate - 4.0).abs() < 1e-6), "{error}");
        let abrupt = lobe(MotionLaw::Polynomial345, 12.0, 50.0);
        let error = Contour::from_lift(&abrupt, &flat(0.0, 60.0, side, SwingLift::Degrees), 15.0).unwrap_err();
        assert!(
            matches!(error, ContourError::Undercut { radius_of_curvature_mm, .. } if radius_of_curvature_mm < 0.0),
            "{error}"
        );
    }
    // The roller too large for its pitch curve.
    let law = lobe(MotionLaw::Cycloidal, 12.0, 40.0);
    let error =
        Contour::from_lift(&law, &roller(25.0, 45.0, 60.0, ArmSide::Ahead, SwingLift::Degrees), 6.0).unwrap_err();
    assert!(matches!(error, ContourError::Undercut { .. }), "{error}");
}
