// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Paths of mills round a contour: by their periphery as a wheel's, by their face as the support function; and the contours that a face
//! cannot make.

use crate::cams;

use cams::{SplitMix64, contour_unless_undercut, lobe, random_law};
use camwright::cam::contour::Contour;
use camwright::cam::follower::Follower;
use camwright::cam::motion_law::MotionLaw;
use camwright::math::units::TURN_RAD;
use camwright::toolpath::cutter_path::face::{FaceError, FacePath};
use camwright::toolpath::cutter_path::{CarriageAxis, CutterPath};
use camwright::toolpath::wheel_path::ToolPath;

fn angles(count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| TURN_RAD * (f64::from(i) + 0.31) / f64::from(count))
}

fn x(path: &CutterPath, azimuth: f64) -> f64 {
    path.sample(CarriageAxis::X, azimuth).expect("it moves along X").value
}

/// A disc of radius r at eccentricity E: the centre of a mill of radius R is at E cos θ + √((r + R)² − E² sin² θ), its face at r + E cos θ.
#[test]
fn eccentric_disc_has_its_closed_forms() {
    let (e, r, radius) = (4.2, 19.0, 15.0);
    let contour = Contour::eccentric(e, r).unwrap();
    let round = CutterPath::from_periphery(&ToolPath::for_wheel(&contour, radius).unwrap());
    assert_eq!((round.infeed, round.travels.len()), (CarriageAxis::X, 1));
    let face = FacePath::new(&contour, 5.0, 0.25).unwrap();
    for angle in angles(3601) {
        let centre = e * angle.cos() + ((r + radius).powi(2) - (e * angle.sin()).powi(2)).sqrt();
        assert!((x(&round, angle) - centre).abs() < 1e-9, "{angle}");
        assert!((x(face.path(), angle) - (r + 0.25 + e * angle.cos())).abs() < 1e-9, "{angle}");
        assert_eq!(face.path().sample(CarriageAxis::Y, angle), None);
    }
    // It touches E beside its middle at most, a quarter turn from the nose.
    let reach = face.reach();
    assert!((reach.beside_mm - e).abs() < 1e-9 && (reach.azimuth_rad.sin().abs() - 1.0).abs() < 1e-6, "{reach:?}");
    assert!((reach.width_mm - 2.0 * (25.0 - e * e).sqrt()).abs() < 1e-9, "{reach:?}");
}

/// A flat follower's lift is the support function already.
#[test]
fn a_face_does_what_a_flat_follower_does() {
    let (law, base) = (lobe(MotionLaw::Cycloidal, 3.0, 75.0), 18.0);
    let face = FacePath::new(&Contour::from_lift(&law, &Follower::Flat, base).unwrap(), 10.0, 0.0).unwrap();
    for angle in angles(3600) {
        assert!((x(face.path(), angle) - base - law.sample(angle).value).abs() < 2e-9, "{angle}");
    }
}

/// The face pushed against the contour from outside stands where the path says, and touches it within its rim: X(θ) is the largest p·u over
/// the contour's points.
#[test]
fn a_swept_face_leaves_the_contour() {
    let (mut made, mut hollow, mut small) = (0, 0, 0);
    for seed in 0..80 {
        let mut random = SplitMix64(seed);
        let law = random_law(&mut random, 16.0);
        let follower = match random.next() % 3 {
            0 => Follower::Flat,
            1 => Follower::Roller { radius_mm: random.within(4.0, 25.0), offset_mm: random.within(-4.0, 4.0) },
            _ => Follower::Mushroom { radius_mm: random.within(100.0, 400.0) },
        };
        let Some(contour) = contour_unless_undercut(&law, &follower, random.within(20.0, 40.0), seed) else { continue };
        let (radius, leaves) = (random.within(3.0, 25.0), random.within(0.0, 0.5));
        let points: Vec<_> = angles(40_000).map(|angle| contour.point(angle)).collect();
        let pushed =
            |angle: f64| points.iter().map(|p| p.x * angle.cos() + p.y * angle.sin()).fold(f64::NEG_INFINITY, f64::max);
        match FacePath::new(&contour, radius, leaves) {
            Ok(face) => {
                made += 1;
                for angle in angles(101) {
                    let (found, wanted) = (x(face.path(), angle), pushed(angle) + leaves);
                    assert!((found - wanted).abs() < 2e-6, "seed {seed}, {follower:?}: {found} {wanted} at {angle}");
                    // The rate of the support is where it touches.
                    let touches = face.path().sample(CarriageAxis::X, angle).unwrap().first;
                    let on_it = (0..points.len()).filter(|i| {
                        let along = points[*i].x * angle.cos() + points[*i].y * angle.sin();
                        let across = points[*i].y * angle.cos() - points[*i].x * angle.sin();
                        (along + leaves - found).abs() < 1e-6 && (across - touches).abs() < 0.2
                    });
                    assert!(on_it.count() > 0 && touches.abs() <= radius, "seed {seed}: {touches} at {angle}");
                }
            }
            Err(FaceError::Hollow { angle_deg, curvature_1_mm, .. }) => {
                hollow += 1;
                assert!(curvature_1_mm < 1e-6, "seed {seed}: {curvature_1_mm} at {angle_deg}");
                assert!(contour.maximum_concavity().is_none_or(|place| place.value < 1e-6), "seed {seed}");
            }
            Err(FaceError::FaceTooSmall { offset_mm, azimuth_deg, .. }) => {
                small += 1;
                // By differences of the pushed face, which knows nothing of splines.
                let (at, step) = (azimuth_deg.to_radians(), 1e-3);
                let rate = (pushed(at + step) - pushed(at - step)) / (2.0 * step);
                assert!(
                    offset_mm >= radius && (rate.abs() - offset_mm).abs() < 0.02,
                    "seed {seed}: {offset_mm} {rate}"
                );
            }
            Err(other) => panic!("seed {seed}: {other}"),
        }
    }
    assert!(
        made > 10 && hollow > 3 && small > 5,
        "{made} made, {hollow} hollow, {small} with a face that is too small"
    );
}

#[test]
fn what_a_face_cannot_make_is_refused_with_figures_and_place() {
    let refusal = |contour: &Contour, radius, leaves| FacePath::new(contour, radius, leaves).unwrap_err().to_string();
    let disc = Contour::eccentric(4.2, 19.0).unwrap();
    assert_eq!(refusal(&disc, -1.0, 0.0), "the face of the mill has a radius of -1 mm; it must be a positive number");
    assert!(matches!(FacePath::new(&disc, f64::NAN, 0.0), Err(FaceError::BadRadius { .. })));
    assert_eq!(refusal(&disc, 5.0, -0.1), "-0.1 mm cannot be left on a contour; it must be 0 or more");
    assert!(matches!(FacePath::new(&disc, 5.0, f64::INFINITY), Err(FaceError::BadStock { .. })));
    let small = refusal(&disc, 4.0, 0.0);
    assert!(
        small.starts_with("a face of radius 4 mm touches the contour 4.200 mm beside its middle at azimuth "),
        "{small}"
    );
    let roller = Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 };
    let lobe = Contour::from_lift(&lobe(MotionLaw::Polynomial345, 6.0, 62.0), &roller, 16.0).unwrap();
    let hollow = refusal(&lobe, 20.0, 0.0);
    assert!(hollow.starts_with("the contour is hollow at cam angle "), "{hollow}");
}
