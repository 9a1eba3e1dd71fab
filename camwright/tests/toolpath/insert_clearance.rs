// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Clearance of the insert's flank against closed forms and against the flank drawn beside the part.

use crate::cams;
use crate::solids;

use cams::SplitMix64;
use camwright::cam::surface::Surface;
use camwright::math::units::rad_from_deg;
use camwright::toolpath::insert_clearance::{ClearanceMap, Flank, InsertClearanceError, flank_distance_mm};
use camwright::toolpath::insert_path::{InsertFeed, InsertPath, PathRequest};
use solids::{CYLINDER, ECCENTRIC, cam_along_z, random_lobed, solid};
use std::f64::consts::FRAC_PI_2;

fn map(surface: &Surface, flank: Flank) -> ClearanceMap {
    let (from, to) = surface.ends_mm();
    ClearanceMap::new(surface, from, to, flank).expect("a flank of a workshop")
}

/// relief + asin(H/r), at any height.
#[test]
fn on_a_cylinder_the_clearance_is_the_relief_and_the_offset_angle() {
    let map = map(&solid(CYLINDER), Flank::default());
    for height in [-19.0, -6.0, 0.0, 5.0, 14.142, 19.9] {
        let found = map.at(height).unwrap();
        let offset = (height / 20.0_f64).asin();
        assert!((found.clearance.angle_rad - rad_from_deg(7.0) - offset).abs() < 1e-12, "{height}");
        assert!((found.approach.angle_rad - FRAC_PI_2 + offset).abs() < 1e-12);
        assert!((found.offset_angle_rad - offset).abs() < 1e-12);
    }
    // 7° of relief leave 4° at 3° above centre; equal margins at (90° − 10° − 7° + 4°)/2 = 38.5°, moved to 40°.
    let heights = map.heights().unwrap();
    assert!((heights.lowest_mm + 20.0 * rad_from_deg(3.0).sin()).abs() < 1e-9, "{heights:?}");
    assert!((heights.highest_mm - 20.0 * rad_from_deg(80.0).sin()).abs() < 1e-9);
    assert!((heights.best_mm - 20.0 * rad_from_deg(40.0).sin()).abs() < 1e-9);
}

/// On a disc beside the axis the normal goes through its centre, so it leaves the radius by asin(e/R) at most.
#[test]
fn at_centre_an_eccentric_takes_its_steepest_slope_from_the_relief() {
    let found = map(&solid(ECCENTRIC), Flank::default()).at(0.0).unwrap();
    let steepest = (2.5_f64 / 21.0).asin();
    assert!((found.clearance.angle_rad - rad_from_deg(7.0) + steepest).abs() < 1e-4, "{found:?}");
    assert!((found.approach.angle_rad - FRAC_PI_2 + steepest).abs() < 1e-4, "{found:?}");
}

/// The least over all spots is that over those that were kept, above and below centre.
#[test]
fn spots_that_were_left_out_do_not_decide() {
    let mut random = SplitMix64(90);
    for round in 0..30 {
        let surface = solid(random_lobed(|low, high| random.within(low, high)));
        let map = map(&surface, Flank::default());
        for height in [-12.0, -3.0, 0.0, 4.0, 12.0] {
            let found = map.at(height).unwrap();
            for _ in 0..2000 {
                let point = surface.point(random.within(0.0, 7.0), random.within(0.0, 20.0));
                let lean = (height / point.radius_mm).asin() + (point.by_azimuth / point.radius_mm).atan();
                assert!(rad_from_deg(7.0) + lean > found.clearance.angle_rad - 3e-4, "seed 90, {round}, H {height}");
                assert!(FRAC_PI_2 - lean > found.approach.angle_rad - 3e-4, "seed 90, {round}, H {height}");
            }
        }
    }
}

fn path(surface: &Surface, height_mm: f64) -> InsertPath {
    let (from, to) = surface.ends_mm();
    let request = PathRequest {
        insert_radius_mm: 6.0,
        plane_y_mm: -height_mm,
        from_mm: from,
        to_mm: to,
        feed: InsertFeed::AlongZ(1.0),
        angles: 360,
        start_rad: 0.0,
        stock_mm: 0.0,
    };
    InsertPath::new(surface, &request).expect("a plane that cuts")
}

/// A 3-D cam of 4.5 mm lift on 20 mm: below centre the flank clears, at centre and above it touches; the refusal says where.
#[test]
fn a_cam_is_cut_below_centre_and_refused_at_centre_and_above() {
    let surface = cam_along_z();
    let flank = Flank { relief_rad: rad_from_deg(5.0), ..Flank::default() };
    let map = map(&surface, flank);
    let below = map.check(14.142).unwrap();
    assert!((below.offset_angle_rad.to_degrees() - 45.0).abs() < 0.01, "{below:?}");
    assert!(below.clearance.angle_rad.to_degrees() > 30.0, "{below:?}");
    assert!(flank_distance_mm(&surface, &path(&surface, 14.142), &flank).unwrap() > 0.0);
    for height in [0.0, -14.142] {
        let error = map.check(height).unwrap_err();
        let InsertClearanceError::FlankTouches { clearance_deg, bound_deg, z_mm, .. } = error else {
            panic!("{error}")
        };
        assert!(clearance_deg < 0.0 && (bound_deg - 4.0).abs() < 1e-9, "{error}");
        assert!((0.0..=22.0).contains(&z_mm));
        // What the angle says at the edge is seen farther down too.
        let error = flank_distance_mm(&surface, &path(&surface, height), &flank).unwrap_err();
        assert!(matches!(error, InsertClearanceError::MeetsFlank { inside_mm, .. } if inside_mm > 1e-3), "{error}");
    }
    let heights = map.heights().unwrap();
    assert!(heights.lowest_mm > 0.0 && heights.highest_mm < 20.0 && (heights.min_radius_mm - 20.0).abs() < 1e-6);
    let offset = (heights.best_mm / 20.0).asin().to_degrees();
    assert!((40.0..=60.0).contains(&offset), "{offset}");
    assert!(map.check(heights.best_mm).is_ok());
    assert!(map.check(heights.lowest_mm + 1e-6).is_ok() && map.check(heights.lowest_mm - 1e-3).is_err());
    assert!(map.check(heights.highest_mm - 1e-6).is_ok());
    assert!(matches!(map.check(heights.highest_mm + 1e-3), Err(InsertClearanceError::Scrapes { .. })));
}

/// The angle at the refused place, drawn: beside the contact the surface lies on the flank's side of the flank line.
#[test]
fn the_refused_place_is_where_the_surface_crosses_the_flank_line() {
    let surface = cam_along_z();
    let flank = Flank { relief_rad: rad_from_deg(5.0), ..Flank::default() };
    let error = map(&surface, flank).check(0.0).unwrap_err();
    let InsertClearanceError::FlankTouches { turned_deg, z_mm, clearance_deg, .. } = error else { panic!("{error}") };
    let turned = turned_deg.to_radians();
    let contact = surface.radius(turned, z_mm);
    let lead = -1e-4;
    let radius = surface.radius(lead + turned, z_mm);
    let (below, ahead) = (-radius * f64::sin(lead), radius * f64::cos(lead) - contact);
    // The flank line is at below · tan(relief) ahead of the edge, the surface nearer to the tool by the clearance.
    let seen = rad_from_deg(5.0) - (ahead / below).atan();
    assert!((seen.to_degrees() - clearance_deg).abs() < 0.05, "{} {clearance_deg}", seen.to_degrees());
}

#[test]
fn numbers_that_are_none_are_refused() {
    let surface = solid(CYLINDER);
    let new = |flank| ClearanceMap::new(&surface, 0.0, 20.0, flank).map(|_| ());
    let good = Flank::default();
    for flank in [
        Flank { relief_rad: -0.1, ..good },
        Flank { relief_rad: f64::NAN, ..good },
        Flank { min_clearance_rad: 2.0, ..good },
        Flank { min_approach_rad: f64::INFINITY, ..good },
        Flank { depth_mm: -1.0, ..good },
    ] {
        assert!(matches!(new(flank), Err(InsertClearanceError::BadNumber { .. })), "{flank:?}");
    }
    assert!(ClearanceMap::new(&surface, 1.0, f64::NAN, good).is_err());
    let map = map(&surface, good);
    for height in [20.0, -25.0, f64::NAN] {
        assert!(matches!(map.check(height), Err(InsertClearanceError::Misses { .. })), "{height}");
    }
    let greedy = Flank { min_clearance_rad: rad_from_deg(80.0), min_approach_rad: rad_from_deg(80.0), ..good };
    assert!(matches!(self::map(&surface, greedy).heights(), Err(InsertClearanceError::NoHeight { .. })));
}
