// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Planning time of the path of a lathe's insert, and its growth with the number of points:
//!
//! ```text
//! cargo run --release -p camwright --example turning_bench
//! ```
//!
//! For a formula, cams along z and a grid of radii: the surface, the path (hollows, contacts, the look at places between the knots), the
//! fastest spindle with its forward check on a grid eight times finer, and the law of a spindle whose speed varies, which knows that too.
//! The last lines are 360 angles of 2000 turns.
#![allow(clippy::print_stdout, reason = "a command: its output is the benchmark")]
#![allow(clippy::disallowed_methods, reason = "a benchmark measures time")]

#[path = "../tests/solids/mod.rs"]
mod solids;

use camwright::cam::surface::Surface;
use camwright::cam::surface::grid::SurfaceGrid;
use camwright::machine::description::MotionLimits;
use camwright::toolpath::insert_path::{AxisLimits, InsertFeed, InsertPath, PathRequest};
use std::error::Error;
use std::time::Instant;

const LIMITS: AxisLimits = AxisLimits {
    x: MotionLimits { velocity: 500.0, acceleration: 2e4, jerk: 2e6 },
    z: MotionLimits { velocity: 200.0, acceleration: 5e3, jerk: 5e5 },
    spindle_rad_s: 300.0,
};

const SPINDLE: MotionLimits = MotionLimits { velocity: 300.0, acceleration: 600.0, jerk: 6e4 };

const FEED_MM: f64 = 0.01;

fn plan(name: &str, make: impl Fn() -> Surface, turns: u32) -> Result<(), Box<dyn Error>> {
    let begin = Instant::now();
    let surface = make();
    let made = begin.elapsed();
    let request = PathRequest {
        insert_radius_mm: 6.0,
        plane_y_mm: -14.14,
        from_mm: 1.0,
        to_mm: 1.0 + FEED_MM * f64::from(turns),
        feed: InsertFeed::AlongZ(FEED_MM),
        angles: 360,
        start_rad: 0.0,
        stock_mm: 0.0,
    };
    let begin = Instant::now();
    let path = InsertPath::new(&surface, &request)?;
    let planned = begin.elapsed();
    let begin = Instant::now();
    let speed = path.fastest_spindle(&LIMITS)?;
    let checked = begin.elapsed();
    let constant = path.spindle_law(SPINDLE.velocity, &LIMITS, SPINDLE)?;
    let begin = Instant::now();
    let varied = path.varied_spindle_law(&LIMITS, SPINDLE)?;
    let laws = begin.elapsed();
    let points = path.x().knots().len();
    let whole = made + planned + checked;
    println!(
        "{name:<14} {turns:>5} turns {points:>7} points: surface {:>6.1} ms, path {:>6.1} ms, speed and its check {:>6.1} ms, \
         in all {:>6.1} ms, {:>5.0} ns a point; {:.1} rad/s by {:?}; varied law {:>6.1} ms, {:.2} times as fast",
        made.as_secs_f64() * 1e3,
        planned.as_secs_f64() * 1e3,
        checked.as_secs_f64() * 1e3,
        whole.as_secs_f64() * 1e3,
        whole.as_secs_f64() * 1e9 / points as f64,
        speed.rad_s,
        speed.bound,
        laws.as_secs_f64() * 1e3,
        constant.law.end() / varied.law.end(),
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let cams = solids::cam_along_z();
    for turns in [250, 500, 1000, 2000] {
        plan("elliptic cone", || solids::solid(solids::ELLIPTIC_CONE), turns)?;
        plan("cams along z", solids::cam_along_z, turns)?;
        let rows = (0..=turns).map(|k| 22.0 * f64::from(k) / f64::from(turns)).collect::<Vec<_>>();
        let grid = SurfaceGrid::sampled(360, rows, |azimuth, z| cams.radius(azimuth, z));
        plan("grid of radii", || Surface::grid(&grid).expect("the cam's radii"), turns)?;
    }
    Ok(())
}
