// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Jobs with implausible numbers through all of planning: `cargo run --release -p camwright --example odd_jobs [COUNT [SEED]]`.
//!
//! Prints how many were planned and refused, the slowest, and every seed that panicked or failed its own check; exit code 1 then.
#![allow(clippy::print_stdout, reason = "a command")]

#[path = "../tests/cams/mod.rs"]
mod cams;
#[path = "../tests/cams/odd_jobs.rs"]
mod odd_jobs;

use odd_jobs::{OddVerdict, judge_odd_job};
use std::process::ExitCode;
use std::time::Duration;

fn main() -> ExitCode {
    let mut numbers = std::env::args().skip(1).map(|word| word.parse::<u64>());
    let (Ok(count), Ok(first)) = (numbers.next().unwrap_or(Ok(10_000)), numbers.next().unwrap_or(Ok(1))) else {
        println!("usage: odd_jobs [COUNT [SEED]]: COUNT jobs, seeds from SEED on (10000, 1)");
        return ExitCode::from(2);
    };
    let (mut planned, mut refused, mut wrong) = (0_u64, 0_u64, 0_u64);
    let mut slowest = (Duration::ZERO, 0);
    for seed in first..first.saturating_add(count) {
        let (verdict, took) = judge_odd_job(seed);
        slowest = slowest.max((took, seed));
        match verdict {
            OddVerdict::Planned => planned += 1,
            OddVerdict::Refused => refused += 1,
            OddVerdict::Wrong(text) => {
                println!("seed {seed}: {text}");
                wrong += 1;
            }
        }
    }
    println!(
        "{count} jobs from seed {first} on: {planned} planned, {refused} refused, {wrong} wrong; seed {} took {:?}",
        slowest.1, slowest.0
    );
    if wrong == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
