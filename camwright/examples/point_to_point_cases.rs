// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Point-to-point moves for a judge (`tests/benchmarks/point_to_point.py`).
//!
//! ```text
//! point_to_point_cases COUNT SEED FILE
//! ```
//!
//! Draws moves of one axis to rest: from rest, and from a velocity. Writes for each a row of little-endian doubles: distance,
//! velocity at the start, the limits of velocity, acceleration and jerk, the duration found here, the largest velocity,
//! acceleration and jerk by differencing positions on a grid, and how far from its target it ends (mm, s). Then it plans all of
//! them again and prints the time of that in nanoseconds.
#![allow(clippy::print_stdout, reason = "a command: its output is what the benchmark reads")]

#[path = "../tests/cams/mod.rs"]
mod cams;

use cams::SplitMix64;
use camwright::machine::description::MotionLimits;
use camwright::math::differences::largest_derivatives;
use camwright::motion::point_to_point::{JerkLaw, solve};
use std::error::Error;
use std::fs;
use std::time::Instant;

/// Points of the grid on which a move is differenced.
const GRID: f64 = 4000.0;

struct Move {
    distance: f64,
    velocity: f64,
    limits: MotionLimits,
}

impl Move {
    /// Distances from 1 nm to 1 m, limits over two orders of magnitude, every other start from rest.
    fn random(random: &mut SplitMix64, index: u64) -> Self {
        let mut decades = |low: f64, high: f64| 10_f64.powf(random.within(low, high));
        let limits =
            MotionLimits { velocity: decades(1.0, 3.0), acceleration: decades(2.0, 4.0), jerk: decades(4.0, 6.0) };
        let distance = decades(-6.0, 3.0);
        let velocity = if index.is_multiple_of(2) { 0.0 } else { limits.velocity * random.within(-1.0, 1.0) };
        Self { distance, velocity, limits }
    }

    fn plan(&self) -> JerkLaw {
        solve(self.distance, self.velocity, 0.0, 0.0, &self.limits)
    }

    fn row(&self) -> [f64; 10] {
        let law = self.plan();
        let found = largest_derivatives(|t| law.sample(t).value, 0.0, law.duration(), law.duration() / GRID);
        let MotionLimits { velocity, acceleration, jerk } = self.limits;
        let missed = (law.sample(law.duration()).value - self.distance).abs();
        [
            self.distance,
            self.velocity,
            velocity,
            acceleration,
            jerk,
            law.duration(),
            found[0].value,
            found[1].value,
            found[2].value,
            missed,
        ]
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [count, seed, file] = arguments.as_slice() else {
        return Err("point_to_point_cases COUNT SEED FILE".into());
    };
    let mut random = SplitMix64(seed.parse()?);
    let moves: Vec<Move> = (0..count.parse::<u64>()?).map(|index| Move::random(&mut random, index)).collect();
    fs::write(file, moves.iter().flat_map(Move::row).flat_map(f64::to_le_bytes).collect::<Vec<u8>>())?;
    #[allow(clippy::disallowed_methods, reason = "measures the planner, which itself sees no clock")]
    let start = Instant::now();
    let seconds: f64 = moves.iter().map(|each| each.plan().duration()).sum();
    let took = start.elapsed().as_nanos();
    std::hint::black_box(seconds);
    println!("{took}");
    Ok(())
}
