// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Error of a turned cam planned by a shortcut, and permitted heights of the insert:
//!
//! ```text
//! cargo run --release -p camwright --example turning_comparison
//! ```
//!
//! The part is a cam along z: base radius 20 mm, raised cosines of 4.5 mm and 3 mm lift, the second 25° on, 10 mm from one to the other.
#![allow(clippy::print_stdout, reason = "a command: its output is the comparison")]

#[path = "../tests/solids/mod.rs"]
mod solids;

use camwright::cam::surface::Surface;
use camwright::cam::surface::cams::CamAlong;
use camwright::machine::description::MotionLimits;
use camwright::math::units::{deg_from_rad, rpm_from_rad_s};
use camwright::toolpath::insert_clearance::{ClearanceMap, Flank, flank_distance_mm};
use camwright::toolpath::insert_path::{AxisLimits, InsertFeed, InsertPath, PathRequest};
use camwright::toolpath::rake_section::RakeSection;
use std::error::Error;

const LIMITS: AxisLimits = AxisLimits {
    x: MotionLimits { velocity: 500.0, acceleration: 2e4, jerk: 2e6 },
    z: MotionLimits { velocity: 200.0, acceleration: 5e3, jerk: 5e5 },
    spindle_rad_s: 300.0,
};

fn shortcuts() -> Result<(), Box<dyn Error>> {
    println!("error of X on the section, insert 14.14 mm below centre (offset angle 45 deg):");
    println!("  part                 radius taken at psi = 0   at one psi for all angles   solved at every angle");
    let single = |lift: f64| {
        let contour = solids::raised_cosine(lift);
        Surface::cams(&[CamAlong { contour: &contour, phase_rad: 0.0, from_mm: 0.0, to_mm: 10.0 }])
    };
    for (name, surface) in
        [("cam, lift 4.5 mm", single(4.5)?), ("cam, lift 3 mm", single(3.0)?), ("cam along z", solids::cam_along_z())]
    {
        let (from, to) = surface.ends_mm();
        let found = RakeSection::new(&surface, -14.14, from, to)?.shortcuts()?;
        let path = InsertPath::new(&surface, &request(14.14, from, to))?;
        println!(
            "  {name:<20} {:>20.3} mm {:>24.3} mm {:>18.1e} mm",
            found.ignored_mm,
            found.constant_mm,
            path.accuracy().interpolation_error_mm
        );
    }
    Ok(())
}

fn request(height_mm: f64, from_mm: f64, to_mm: f64) -> PathRequest {
    PathRequest {
        insert_radius_mm: 6.0,
        plane_y_mm: -height_mm,
        from_mm,
        to_mm,
        feed: InsertFeed::AlongZ(0.2),
        angles: 360,
        start_rad: 0.0,
        stock_mm: 0.0,
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    shortcuts()?;
    let surface = solids::cam_along_z();
    let (from, to) = surface.ends_mm();
    let flank = Flank::default();
    let map = ClearanceMap::new(&surface, from, to, flank)?;
    println!(
        "\ncam along z, relief {:.0} deg, clearance at least {:.0} deg:",
        deg_from_rad(flank.relief_rad),
        deg_from_rad(flank.min_clearance_rad)
    );
    let heights = map.heights()?;
    let offset = |height: f64| deg_from_rad(libm::asin(height / heights.min_radius_mm));
    println!(
        "  heights that work: {:.3} to {:.3} mm below centre (offset angle {:.1} to {:.1} deg), best {:.3} mm ({:.1} deg)",
        heights.lowest_mm,
        heights.highest_mm,
        offset(heights.lowest_mm),
        offset(heights.highest_mm),
        heights.best_mm,
        offset(heights.best_mm)
    );
    for (name, height) in [("at 45 deg", 14.142), ("the best", heights.best_mm), ("at centre", 0.0), ("above", -14.142)]
    {
        let found = map.at(height)?;
        let path = InsertPath::new(&surface, &request(height, from, to))?;
        println!(
            "  {name:<10} H {height:>7.3} mm: least clearance {:>6.2} deg, least angle to the rake face {:>6.2} deg, X stroke {:.3} mm",
            deg_from_rad(found.clearance.angle_rad),
            deg_from_rad(found.approach.angle_rad),
            path.stroke_mm()
        );
        match map.check(height) {
            Ok(_) => {
                flank_distance_mm(&surface, &path, &flank)?;
                let speed = path.fastest_spindle(&LIMITS)?;
                println!(
                    "             works, no point of the part enters the flank; at most {:.0} rpm \
                     ({:?}); cusps {:.2} um",
                    rpm_from_rad_s(speed.rad_s),
                    speed.bound,
                    camwright::math::units::um_from_mm(path.cusp_mm())
                );
            }
            Err(error) => println!("             refused: {error}"),
        }
    }
    Ok(())
}
