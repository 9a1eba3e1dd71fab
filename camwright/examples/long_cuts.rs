// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Random cuts of 1 to 2,000 turns through the speed plan and its forward check:
//! `cargo run --release -p camwright --example long_cuts [COUNT [SEED]]`.
//!
//! Prints how many were planned, how many refused and why, and every seed whose plan failed its own check; exit code 1 then.
#![allow(clippy::print_stdout, reason = "a command")]

#[path = "../tests/cams/mod.rs"]
mod cams;
#[path = "../tests/cams/long_cuts.rs"]
mod long_cuts;

use long_cuts::{CutVerdict, judge_cut, reference_cut};
use std::collections::BTreeMap;
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut numbers = std::env::args().skip(1).map(|word| word.parse::<u64>());
    let (Ok(count), Ok(first)) = (numbers.next().unwrap_or(Ok(10_000)), numbers.next().unwrap_or(Ok(1))) else {
        println!("usage: long_cuts [COUNT [SEED]]: COUNT cuts, seeds from SEED on (10000, 1)");
        return ExitCode::from(2);
    };
    println!("reference cut: {:?}", reference_cut());
    let mut tally: BTreeMap<&str, u64> = BTreeMap::new();
    let (mut wrong, mut max_turns) = (0_u64, 0);
    for seed in first..first.saturating_add(count) {
        let what = match judge_cut(seed) {
            CutVerdict::Planned(turns) => {
                max_turns = max_turns.max(turns);
                "planned"
            }
            CutVerdict::Refused(why) => why,
            CutVerdict::Wrong(text) => {
                println!("seed {seed}: {text}");
                wrong += 1;
                "wrong"
            }
        };
        *tally.entry(what).or_default() += 1;
        let done = seed - first + 1;
        if done.is_multiple_of(500) {
            println!("{done} of {count}: {tally:?}");
        }
    }
    let last = first.saturating_add(count).saturating_sub(1);
    println!("{count} cuts, seeds {first} to {last}, up to {max_turns} turns: {tally:?}");
    if wrong == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
