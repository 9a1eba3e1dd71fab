// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Gauge readings of contours: against closed forms, against gauges pushed onto points of the contour, and back.

use crate::cams;

use cams::{SplitMix64, camshaft_segments, lobe, printed, program, random_segments};
use camwright::cam::contour::Contour;
use camwright::cam::follower::{ArmSide, Follower, FollowerError, Pivot, SwingLift};
use camwright::cam::inspection::{Inspection, InspectionError};
use camwright::cam::lift::{LiftLaw, LiftLawError};
use camwright::cam::motion_law::MotionLaw;
use camwright::math::units::{TURN_RAD, deg_from_rad};
use camwright::toolpath::wheel_path::ToolPath;

fn angles(count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| TURN_RAD * (f64::from(i) + 0.31) / f64::from(count))
}

fn on_axis(radius_mm: f64) -> Follower {
    Follower::Roller { radius_mm, offset_mm: 0.0 }
}

/// One follower of each kind, with random measures that fit the base circle.
fn one_of_each(random: &mut SplitMix64, base: f64) -> [Follower; 8] {
    let mut pivot = || {
        let side = random.one_of(&[ArmSide::Ahead, ArmSide::Behind]);
        let distance_mm = base + random.within(40.0, 90.0);
        let arc = SwingLift::Arc { radius_mm: random.within(20.0, 60.0) };
        Pivot { distance_mm, side, lift: random.one_of(&[SwingLift::Degrees, arc]) }
    };
    let (for_roller, for_face) = (pivot(), pivot());
    let (radius_mm, lead) = (random.within(3.0, 15.0), random.within(0.8, 2.0));
    // Third side of the triangle axis, pivot, roller.
    let (p, c) = (base + radius_mm, for_roller.distance_mm);
    let arm_mm = (p * p + c * c - 2.0 * p * c * lead.cos()).sqrt();
    [
        Follower::KnifeEdge { offset_mm: 0.0 },
        Follower::KnifeEdge { offset_mm: random.within(-2.0, 2.0) },
        on_axis(random.within(3.0, 15.0)),
        Follower::Roller { radius_mm: random.within(3.0, 15.0), offset_mm: random.within(-5.0, 5.0) },
        Follower::Mushroom { radius_mm: random.within(20.0, 60.0) },
        Follower::Flat,
        Follower::OscillatingRoller { radius_mm, arm_mm, pivot: for_roller },
        Follower::OscillatingFlat { face_offset_mm: random.within(-8.0, 8.0), pivot: for_face },
    ]
}

#[test]
fn every_follower_reads_its_own_lift_back() {
    let mut made = [0; 8];
    for seed in 0..24 {
        let mut random = SplitMix64(seed);
        let law = program(random.within(0.0, TURN_RAD), &random_segments(&mut random));
        let base = random.within(14.0, 30.0);
        for (kind, follower) in one_of_each(&mut random, base).into_iter().enumerate() {
            let Ok(contour) = Contour::from_lift(&law, &follower, base) else { continue };
            made[kind] += 1;
            let inspection = Inspection::new(&contour, &follower).unwrap();
            assert_eq!(inspection.overlooked(), None, "seed {seed}, {follower:?}");
            for angle in angles(361) {
                let reading = inspection.read(angle).unwrap();
                let wanted = law.sample(angle).value;
                assert!(
                    (reading.lift - wanted).abs() < 1e-9,
                    "seed {seed}, {follower:?} {angle}: {reading:?} {wanted}"
                );
                let along = (contour.point(reading.contact_rad) - contour.point(angle)).norm();
                assert!(along < 1e-7, "seed {seed}, {follower:?} {angle}: {along}");
            }
        }
    }
    assert!(made.iter().all(|&count| count > 5), "{made:?}");
}

/// A contour, its lift under another follower, and the contour of that lift: the same.
#[test]
fn contour_to_lift_to_contour_returns_between_all_followers() {
    let (mut made, mut overlooked) = (0, 0);
    for seed in 51..53 {
        let mut random = SplitMix64(seed);
        // The last is the reference lobe, concave for a roller.
        let (law, base) = match seed {
            52 => (lobe(MotionLaw::Polynomial345, 6.0, 62.0), 16.0),
            _ => (program(random.within(0.0, TURN_RAD), &random_segments(&mut random)), random.within(20.0, 30.0)),
        };
        let followers = one_of_each(&mut random, base);
        for (i, follower) in followers.into_iter().enumerate() {
            let Ok(contour) = Contour::from_lift(&law, &follower, base) else { continue };
            // Every pair on the reference lobe, every third on the other.
            for (_, gauge) in followers.into_iter().enumerate().filter(|(j, _)| seed == 52 || (i + j) % 3 == 0) {
                let inspection = Inspection::new(&contour, &gauge).unwrap();
                let read = match inspection.law() {
                    Ok(read) => read,
                    Err(error) => {
                        // Overlooked, or so nearly that the reading all but has a corner.
                        let room = 1.0
                            + contour.maximum_concavity().map_or(0.0, |place| place.value)
                                * gauge.tip_radius_mm().unwrap_or(f64::INFINITY);
                        assert!(room < 0.3, "seed {seed}, {follower:?}, {gauge:?}, {room}: {error}");
                        overlooked += 1;
                        continue;
                    }
                };
                made += 1;
                let again = Contour::from_lift(&read, &gauge, base).unwrap();
                for angle in angles(181) {
                    let point = again.point(angle);
                    let (off, _) = contour.distance(point.norm(), point.y.atan2(point.x));
                    assert!(off.abs() < 1e-8, "seed {seed}, {follower:?}, {gauge:?}, {angle}: {off}");
                }
            }
        }
    }
    assert!(made > 45 && overlooked > 0, "{made} {overlooked}");
}

/// On a disc of radius r, its centre e from the axis: a flat face reads e(1 + cos φ), a roller with offset o
/// e cos φ + √((r + rr)² − (o + e sin φ)²) − d₀.
#[test]
fn gauges_on_an_eccentric_disc_read_closed_forms() {
    let (e, r) = (4.2_f64, 19.0_f64);
    let contour = Contour::eccentric(e, r).unwrap();
    let flat = Inspection::new(&contour, &Follower::Flat).unwrap();
    for angle in angles(720) {
        assert!((flat.read(angle).unwrap().lift - e * (1.0 + angle.cos())).abs() < 1e-12);
    }
    for (radius_mm, offset_mm) in [(0.0, 0.0), (0.0, 3.0), (8.5, 0.0), (8.5, -6.0), (60.0, 12.0), (1e4, 0.0)] {
        let gauge =
            if radius_mm > 0.0 { Follower::Roller { radius_mm, offset_mm } } else { Follower::KnifeEdge { offset_mm } };
        let gauged = Inspection::new(&contour, &gauge).unwrap();
        let rest = ((r - e + radius_mm).powi(2) - offset_mm * offset_mm).sqrt();
        for angle in angles(720) {
            let beside = offset_mm + e * angle.sin();
            let wanted = e * angle.cos() + ((r + radius_mm).powi(2) - beside * beside).sqrt() - rest;
            let found = gauged.read(angle).unwrap().lift;
            assert!(
                (found - wanted).abs() < 1e-9_f64.min(1e-12 * (r + radius_mm)),
                "{gauge:?} {angle}: {found} {wanted}"
            );
        }
    }
}

/// A roller gauge of the wheel's radius stands where the wheel stands: X = base + lift.
#[test]
fn roller_gauge_reads_the_path_of_a_wheel_of_its_radius() {
    let contour = Contour::from_lift(&program(0.0, &camshaft_segments()), &on_axis(8.5), 17.0).unwrap();
    for radius in [5.0, 25.0, 60.0] {
        let path = ToolPath::for_wheel(&contour, radius).unwrap();
        let gauged = Inspection::new(&contour, &on_axis(radius)).unwrap();
        for angle in angles(1801) {
            let difference = path.sample(angle).value - 17.0 - gauged.read(angle).unwrap().lift;
            assert!(difference.abs() < 2e-9, "R {radius} {angle}: {difference}");
        }
    }
}

/// The gauge pushed against points of the contour: largest p·u for a face, largest p·u + √(r² − (p·n̂)²) for a roller.
/// Concave flanks included: there face and large roller lie across.
#[test]
fn gauges_rest_on_what_holds_them_farthest_out() {
    // The reference lobe, concave to 203 mm.
    let contour = Contour::from_lift(&lobe(MotionLaw::Polynomial345, 6.0, 62.0), &on_axis(8.5), 16.0).unwrap();
    let points: Vec<_> = angles(100_000).map(|angle| contour.point(angle)).collect();
    for (gauge, overlooks) in [
        (Follower::Flat, true),
        (on_axis(3.0), false),
        (on_axis(190.0), false),
        (on_axis(400.0), true),
        (Follower::Roller { radius_mm: 400.0, offset_mm: 5.0 }, true),
    ] {
        let gauged = Inspection::new(&contour, &gauge).unwrap();
        assert_eq!(gauged.overlooked().is_some(), overlooks, "{gauge:?}");
        let (radius, offset) = match gauge {
            Follower::Roller { radius_mm, offset_mm } => (Some(radius_mm), offset_mm),
            _ => (None, 0.0),
        };
        let rest = radius.map_or(16.0, |radius| ((16.0 + radius).powi(2) - offset * offset).sqrt());
        for angle in angles(173) {
            let (sin, cos) = angle.sin_cos();
            let pushed = points
                .iter()
                .map(|p| (p.x * cos + p.y * sin, p.y * cos - p.x * sin - offset))
                .filter_map(|(along, across)| match radius {
                    Some(radius) if across.abs() > radius => None,
                    Some(radius) => Some(along + (radius * radius - across * across).sqrt()),
                    None => Some(along),
                })
                .fold(f64::NEG_INFINITY, f64::max);
            let found = gauged.read(angle).unwrap().lift;
            assert!((found - (pushed - rest)).abs() < 1e-6, "{gauge:?} {angle}: {found} {}", pushed - rest);
        }
        if overlooks {
            // The reading has a corner where the gauge goes over from one side of the hollow to the other.
            let error = gauged.law().unwrap_err();
            assert!(matches!(error, InspectionError::NoLaw(LiftLawError::Unresolved { .. })), "{error}");
        }
    }
    // A face on a hollow touches either side of it and never its floor.
    let floor = contour.maximum_concavity().unwrap().angle_rad;
    let gauged = Inspection::new(&contour, &Follower::Flat).unwrap();
    for angle in angles(3600) {
        let contact = gauged.read(angle).unwrap().contact_rad;
        assert!((contact - floor).abs() > 0.05, "{}", deg_from_rad(angle));
    }
}

/// A cam ground from a printed roller table and gauged with a small roller: the lift law of the gauge makes the cam again,
/// though the table's base circle is only flat within half a digit.
#[test]
fn printed_table_is_gauged_like_its_law() {
    let law = program(0.0, &camshaft_segments());
    let read = LiftLaw::from_table(&printed(&law, 3600, 1e-3)).unwrap();
    let (exact, table) = (
        Contour::from_lift(&law, &on_axis(8.5), 17.0).unwrap(),
        Contour::from_lift(&read, &on_axis(8.5), 17.0).unwrap(),
    );
    for gauge in [on_axis(3.0), Follower::KnifeEdge { offset_mm: 0.0 }] {
        let (exact, table) = (Inspection::new(&exact, &gauge).unwrap(), Inspection::new(&table, &gauge).unwrap());
        for angle in angles(3601) {
            let difference = exact.read(angle).unwrap().lift - table.read(angle).unwrap().lift;
            assert!(difference.abs() < 7e-4, "{gauge:?} {angle}: {difference}");
        }
        let again = Contour::from_lift(&table.law().unwrap(), &gauge, 17.0).unwrap();
        for angle in angles(997) {
            let point = again.point(angle);
            let (off, _) = table.contour().distance(point.norm(), point.y.atan2(point.x));
            assert!(off.abs() < 1e-8, "{gauge:?} {angle}: {off}");
        }
    }
}

#[test]
fn gauges_that_do_not_fit_are_refused() {
    let contour = Contour::from_lift(&lobe(MotionLaw::Cycloidal, 8.0, 70.0), &on_axis(8.5), 20.0).unwrap();
    let error = Inspection::new(&contour, &on_axis(-1.0)).unwrap_err();
    assert!(matches!(error, InspectionError::Gauge(FollowerError::BadRadius { .. })), "{error}");
    let error = Inspection::new(&contour, &Follower::KnifeEdge { offset_mm: 20.0 }).unwrap_err();
    assert!(matches!(error, InspectionError::Gauge(FollowerError::OffsetTooLarge { .. })), "{error}");
    // The arm holds its roller on the base circle but not over the nose.
    let pivot = Pivot { distance_mm: 20.0, side: ArmSide::Ahead, lift: SwingLift::Degrees };
    let short = Follower::OscillatingRoller { radius_mm: 2.0, arm_mm: 6.0, pivot };
    let gauged = Inspection::new(&contour, &short).unwrap();
    assert!(gauged.read(0.0).is_some());
    let error = gauged.law().unwrap_err();
    assert!(matches!(error, InspectionError::OutOfReach { .. }), "{error}");
}
