// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Cases for the judges of the fastest turn (tests/benchmarks): the reference lobe and seeded random ones.
//!
//! ```text
//! turn_cases DIRECTORY RANDOM SEED      then, on standard input, lines "CASE RUNS"
//! ```
//!
//! Writes for every case the data that another planner needs to solve the same task, and the turn found here: `case_NN.txt`
//! words and numbers; `case_NN.grid.f64` rows of X, X′, X″, X‴ (mm over rad), the bound on C's speed, speed and acceleration
//! of the turn (rad/s, rad/s²), at equal angles from 0 on; `case_NN.time.f64` rows of C (rad) and X (mm) at equal times.
//! Both are little-endian doubles. It then plans cases on request and prints the time of each run in nanoseconds, for a
//! side-by-side comparison with another planner.
#![allow(clippy::print_stdout, reason = "a command: its output is what the benchmark reads")]

#[path = "../tests/cams/mod.rs"]
mod cams;

#[path = "../tests/cams/turn_cases.rs"]
mod turn_cases;

use camwright::math::units::TURN_RAD;
use camwright::motion::speed_plan::TurnSpeed;
use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::io::{self, BufRead, Write as _};
use std::path::Path;
use std::time::Instant;
use turn_cases::{C, Case, cases};

/// Points of the grid that the judges get: 32 times the 3600 of the comparison, so that these are among them.
const GRID: u32 = 115_200;

/// Samples of the trajectory in time (1/s): the 1 kHz of the interpolator, eight times finer.
const SAMPLES_PER_S: f64 = 8000.0;

/// Steps of the integration from one sample to the next. C's jerk jumps at the knots, where a step is of third order only;
/// with 64 its error is some 1e-5 of the jerk limit once it has been differenced three times.
const STEPS_PER_SAMPLE: u32 = 64;

/// Writes the files of a case.
fn write(case: &Case, directory: &Path, index: usize) -> Result<(), Box<dyn Error>> {
    let turn = case.plan()?;
    let mut grid = Vec::new();
    for i in 0..GRID {
        let angle = f64::from(i) * (TURN_RAD / f64::from(GRID));
        let (x, c) = (case.path.sample(angle), turn.at(angle));
        for number in [x.value, x.first, x.second, x.third, case.bound(x), c.speed, c.acceleration] {
            grid.extend(number.to_le_bytes());
        }
    }
    fs::write(directory.join(format!("case_{index:02}.grid.f64")), grid)?;

    let mut times = Vec::new();
    for (c, x) in in_time(case, &turn) {
        times.extend(c.to_le_bytes());
        times.extend(x.to_le_bytes());
    }
    fs::write(directory.join(format!("case_{index:02}.time.f64")), times)?;

    let mut words = String::new();
    writeln!(words, "name {}", case.name)?;
    writeln!(words, "input {:?}", case.lobe)?;
    for (axis, limits) in [("c", C), ("x", case.lobe.x)] {
        writeln!(words, "{axis}_velocity {:e}", limits.velocity)?;
        writeln!(words, "{axis}_acceleration {:e}", limits.acceleration)?;
        writeln!(words, "{axis}_jerk {:e}", limits.jerk)?;
    }
    writeln!(words, "sample_s {:e}", 1.0 / SAMPLES_PER_S)?;
    writeln!(words, "turn_s {:e}", turn.turn_s())?;
    writeln!(words, "least_s {:e}", turn.minimum_s())?;
    fs::write(directory.join(format!("case_{index:02}.txt")), words)?;
    Ok(())
}

/// C and X over a turn and a tenth of one, at equal times, by integrating the speed over the angle.
fn in_time(case: &Case, turn: &TurnSpeed) -> Vec<(f64, f64)> {
    let step = 1.0 / (SAMPLES_PER_S * f64::from(STEPS_PER_SAMPLE));
    let speed = |angle: f64| turn.at(angle).speed;
    let mut angle = 0.0;
    let mut samples = Vec::new();
    while angle < 1.1 * TURN_RAD {
        samples.push((angle, case.path.sample(angle).value));
        for _ in 0..STEPS_PER_SAMPLE {
            let k1 = speed(angle);
            let k2 = speed(angle + 0.5 * step * k1);
            let k3 = speed(angle + 0.5 * step * k2);
            let k4 = speed(angle + step * k3);
            angle += step / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
        }
    }
    samples
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [directory, random, seed] = arguments.as_slice() else {
        return Err("turn_cases DIRECTORY RANDOM SEED".into());
    };
    let directory = Path::new(directory);
    fs::create_dir_all(directory)?;
    let cases = cases(random.parse()?, seed.parse()?)?;
    for (index, case) in cases.iter().enumerate() {
        write(case, directory, index)?;
    }
    println!("{}", cases.len());
    io::stdout().flush()?;
    for line in io::stdin().lock().lines() {
        let line = line?;
        let (index, runs) = line.split_once(' ').ok_or("a line is CASE RUNS")?;
        let case = cases.get(index.parse::<usize>()?).ok_or("no such case")?;
        let mut nanoseconds = Vec::new();
        for _ in 0..runs.parse::<u32>()? {
            #[allow(clippy::disallowed_methods, reason = "measures the planner, which itself sees no clock")]
            let start = Instant::now();
            let turn = case.plan()?;
            nanoseconds.push(start.elapsed().as_nanos().to_string());
            std::hint::black_box(turn);
        }
        println!("{}", nanoseconds.join(" "));
        io::stdout().flush()?;
    }
    Ok(())
}
