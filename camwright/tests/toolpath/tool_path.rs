// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The wheel's path against closed forms, against the swept wheel, and the wheels that do not fit.

use crate::cams;

use cams::{SplitMix64, camshaft_segments, lobe, printed, program, random_segments};
use camwright::cam::contour::Contour;
use camwright::cam::follower::Follower;
use camwright::cam::lift::LiftLaw;
use camwright::cam::motion_law::MotionLaw;
use camwright::math::units::TURN_RAD;
use camwright::toolpath::wheel_path::{ToolPath, ToolPathError};

fn angles(count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| TURN_RAD * (f64::from(i) + 0.31) / f64::from(count))
}

const ROLLER: Follower = Follower::Roller { radius_mm: 8.5, offset_mm: 0.0 };

/// X(θ) = E cos θ + √((r + R)² − E² sin² θ) for a disc of radius r at eccentricity E and a wheel of radius R, to 1e-9 mm:
/// the eccentric of E 4.2, D 38 with a tool of radius 15 and others, from the disc itself and from its lift as a formula.
#[test]
fn eccentric_disc_has_its_closed_form() {
    for (e, r, wheel) in
        [(4.2, 19.0, 15.0), (4.2, 14.8, 15.0), (0.0, 20.0, 40.0), (10.0, 30.0, 200.0), (0.01, 12.0, 60.0)]
    {
        let flat = LiftLaw::eccentric_flat(e, 0.0).unwrap();
        let round = LiftLaw::eccentric_round(e, r + 8.5, 0.0).unwrap();
        let sampled = LiftLaw::from_fn(|angle| e * (1.0 + angle.cos())).unwrap();
        for contour in [
            Contour::eccentric(e, r).unwrap(),
            Contour::from_lift(&flat, &Follower::Flat, r - e).unwrap(),
            Contour::from_lift(&sampled, &Follower::Flat, r - e).unwrap(),
            Contour::from_lift(&round, &ROLLER, r - e).unwrap(),
        ] {
            let path = ToolPath::for_wheel(&contour, wheel).unwrap();
            for angle in angles(10_007) {
                let centre = e * angle.cos() + ((r + wheel).powi(2) - (e * angle.sin()).powi(2)).sqrt();
                let found = path.sample(angle).value + wheel;
                assert!((found - centre).abs() < 1e-9, "E {e}, r {r}, R {wheel}, {angle}: {found} {centre}");
                // The contact runs along a circle by its radius per radian of its own turning; β from the triangle.
                let beta = -(e * angle.sin() / (r + wheel)).asin();
                assert!((path.beta(angle) - beta).abs() < 1e-7, "{angle}: {} {beta}", path.beta(angle));
                let point = path.contact(angle);
                assert!((libm::hypot(point.x - e, point.y) - r).abs() < 1e-9, "{angle}");
            }
        }
    }
}

/// A printed table of the disc gives the closed form within the table's half digit.
#[test]
fn eccentric_disc_from_a_table_is_right_within_half_a_digit() {
    let (e, r, wheel) = (4.2, 19.0, 15.0);
    let law = LiftLaw::eccentric_flat(e, 0.0).unwrap();
    for resolution_mm in [1e-3, 1e-4] {
        let read = LiftLaw::from_table(&printed(&law, 3600, resolution_mm)).unwrap();
        let contour = Contour::from_lift(&read, &Follower::Flat, r - e).unwrap();
        let path = ToolPath::for_wheel(&contour, wheel).unwrap();
        for angle in angles(7201) {
            let centre = e * angle.cos() + ((r + wheel).powi(2) - (e * angle.sin()).powi(2)).sqrt();
            let error = path.sample(angle).value + wheel - centre;
            assert!(error.abs() <= 0.5 * resolution_mm, "{angle}: {error}");
        }
    }
}

/// A wheel of the roller's radius does what the roller does.
#[test]
fn wheel_like_the_roller_moves_like_the_roller() {
    let law = lobe(MotionLaw::Polynomial4567, 5.0, 62.0);
    let contour = Contour::from_lift(&law, &Follower::Roller { radius_mm: 30.0, offset_mm: 0.0 }, 20.0).unwrap();
    let path = ToolPath::for_wheel(&contour, 30.0).unwrap();
    for angle in angles(3600) {
        assert!((path.sample(angle).value - 20.0 - law.sample(angle).value).abs() < 2e-9, "{angle}");
    }
}

/// Support function: under a flat follower X = √((h + R)² + h′²) at θ = ω + atan(h′/(h + R)).
#[test]
fn flat_follower_has_the_support_function_form() {
    let (law, base, wheel) = (lobe(MotionLaw::Cycloidal, 3.0, 75.0), 18.0, 60.0);
    let path = ToolPath::for_wheel(&Contour::from_lift(&law, &Follower::Flat, base).unwrap(), wheel).unwrap();
    for omega in angles(3600) {
        let s = law.sample(omega);
        let centre = base + s.value + wheel;
        let theta = omega + (s.first / centre).atan();
        assert!((path.sample(theta).value + wheel - libm::hypot(centre, s.first)).abs() < 2e-9, "{omega}");
        assert!((path.beta(theta) - (s.first / centre).atan()).abs() < 1e-6, "{omega}");
    }
}

/// The wheel pushed against the contour from outside stands where the path says: X(θ) is the largest
/// p·u + √(R² − (p·n̂)²) over the contour's points. And the contact runs once round: ∫ vf/Ċ dθ is the perimeter.
#[test]
fn swept_wheel_leaves_the_contour() {
    let mut made = 0;
    for seed in 0..40 {
        let mut random = SplitMix64(seed);
        let law = program(random.within(0.0, TURN_RAD), &random_segments(&mut random));
        let follower = match random.next() % 3 {
            0 => Follower::Flat,
            1 => Follower::Roller { radius_mm: random.within(4.0, 15.0), offset_mm: random.within(-4.0, 4.0) },
            _ => Follower::KnifeEdge { offset_mm: 0.0 },
        };
        let wheel = random.within(10.0, 120.0);
        let Ok(contour) = Contour::from_lift(&law, &follower, random.within(14.0, 30.0)) else { continue };
        let path = match ToolPath::for_wheel(&contour, wheel) {
            Ok(path) => path,
            Err(ToolPathError::WheelTooLarge { largest_mm, .. }) => {
                assert!(largest_mm < wheel, "seed {seed}");
                continue;
            }
            Err(other) => panic!("seed {seed}: {other}"),
        };
        made += 1;
        let points: Vec<_> = angles(20_000).map(|angle| contour.point(angle)).collect();
        for angle in angles(41) {
            let (cos, sin) = (angle.cos(), angle.sin());
            let pushed = points
                .iter()
                .map(|p| (p.x * cos + p.y * sin, p.y * cos - p.x * sin))
                .filter(|(_, across)| across.abs() <= wheel)
                .map(|(along, across)| along + (wheel * wheel - across * across).sqrt())
                .fold(f64::NEG_INFINITY, f64::max);
            let found = path.sample(angle).value + wheel;
            assert!((found - pushed).abs() < 5e-6, "seed {seed}, {follower:?}, R {wheel}: {found} {pushed} at {angle}");
            let contact = path.contact(angle);
            assert!((contact.norm() - contour.radius_at(path.contact_azimuth(angle))).abs() < 2e-6, "seed {seed}");
        }
        let perimeter: f64 = points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>()
            + (points[0] - points[points.len() - 1]).norm();
        let run: f64 =
            angles(50_000).map(|angle| path.footprint_speed_ratio_mm(angle)).sum::<f64>() * TURN_RAD / 50_000.0;
        assert!((run / perimeter - 1.0).abs() < 1e-5, "seed {seed}: {run} {perimeter}");
        assert!(path.accuracy().interpolation_error_mm < 1e-6 && path.accuracy().contour_error_mm < 2e-6);
    }
    assert!(made > 12, "{made}");
}

/// Turning the lift turns the path.
#[test]
fn rotating_the_lift_rotates_the_path() {
    let turn = 1.234_567;
    let path = |start| {
        let law = program(start, &camshaft_segments());
        ToolPath::for_wheel(&Contour::from_lift(&law, &ROLLER, 17.0).unwrap(), 60.0).unwrap()
    };
    let (plain, turned) = (path(0.0), path(turn));
    for angle in angles(2000) {
        assert!((plain.sample(angle).value - turned.sample(angle + turn).value).abs() < 2e-8, "{angle}");
    }
}

/// The reference lobe (roller 8.5, base 16, lift 6, 3-4-5 over 62°): a wheel of 60 mm sees its footprint speed change by
/// 13 to 1, one of 150 mm by 85 to 1, and one of 203 mm does not fit.
#[test]
fn concave_flank_limits_the_wheel() {
    let contour = Contour::from_lift(&lobe(MotionLaw::Polynomial345, 6.0, 62.0), &ROLLER, 16.0).unwrap();
    for (wheel, ratio) in [(60.0, 13.0), (150.0, 85.0)] {
        let path = ToolPath::for_wheel(&contour, wheel).unwrap();
        let speeds = || angles(36_000).map(|angle| path.footprint_speed_ratio_mm(angle));
        let found = speeds().fold(0.0, f64::max) / speeds().fold(f64::INFINITY, f64::min);
        assert!((found / ratio - 1.0).abs() < 0.05, "R {wheel}: {found}");
    }
    let largest = contour.largest_wheel_radius_mm().unwrap();
    let recommended = contour.recommended_wheel_radius_mm().unwrap();
    assert!((recommended - 0.9 * largest).abs() < 1e-9);
    ToolPath::for_wheel(&contour, recommended).unwrap();
    // Hard at the limit the path has a corner in all but name: made exactly, or refused.
    for fraction in [0.95, 0.99, 0.999_9] {
        match ToolPath::for_wheel(&contour, fraction * largest) {
            Ok(path) => assert!(path.accuracy().contour_error_mm < 2e-6),
            Err(error) => assert!(matches!(error, ToolPathError::Unresolved { .. }), "{error}"),
        }
    }
    let error = ToolPath::for_wheel(&contour, 1.1 * largest).unwrap_err();
    let ToolPathError::WheelTooLarge { wheel_radius_mm, largest_mm, clearance, .. } = error else { panic!("{error}") };
    assert!((wheel_radius_mm - 1.1 * largest).abs() < 1e-9 && (largest_mm - largest).abs() < 1e-9);
    assert!((clearance + 0.1).abs() < 1e-9, "{clearance}");
}

#[test]
fn what_is_no_wheel_is_refused() {
    let contour = Contour::eccentric(2.0, 20.0).unwrap();
    for wheel in [0.0, -5.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(ToolPath::for_wheel(&contour, wheel), Err(ToolPathError::BadWheelRadius { .. })));
    }
}

/// From the printed table to the wheel: the path of a camshaft lobe printed to 1 µm every 0.1° lies within half a digit,
/// widened by the flank's slope, of the path of the law that was printed.
#[test]
fn path_from_a_table_is_the_path_of_its_law() {
    for (follower, base) in [(ROLLER, 17.0), (Follower::Flat, 36.0)] {
        let law = program(0.0, &camshaft_segments());
        let path =
            |law: &LiftLaw| ToolPath::for_wheel(&Contour::from_lift(law, &follower, base).unwrap(), 50.0).unwrap();
        let read = LiftLaw::from_table(&printed(&law, 3600, 1e-3)).unwrap();
        let (exact, table) = (path(&law), path(&read));
        for angle in angles(9001) {
            let error = exact.sample(angle).value - table.sample(angle).value;
            assert!(error.abs() < 6e-4, "{follower:?} {angle}: {error}");
        }
    }
}
