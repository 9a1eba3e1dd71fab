// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Random cams through everything that is planned of a cam: `cargo run --release -p camwright --example random_cams [COUNT [SEED]]`.
//!
//! Prints how many were planned, how many refused and where, and every seed that gave something wrong; exit code 1 then.
#![allow(clippy::print_stdout, reason = "a command")]

#[path = "../tests/cams/campaign.rs"]
mod campaign;
#[path = "../tests/cams/mod.rs"]
mod cams;

use campaign::{Verdict, judge};
use std::collections::BTreeMap;
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut numbers = std::env::args().skip(1).map(|word| word.parse::<u64>());
    let (Ok(count), Ok(first)) = (numbers.next().unwrap_or(Ok(100_000)), numbers.next().unwrap_or(Ok(1))) else {
        println!("usage: random_cams [COUNT [SEED]]: so many cams, seeds from SEED on (100000, 1)");
        return ExitCode::from(2);
    };
    let mut tally: BTreeMap<&str, u64> = BTreeMap::new();
    let mut wrong = 0_u64;
    for seed in first..first.saturating_add(count) {
        let what = match judge(seed) {
            Verdict::Planned => "planned",
            Verdict::Refused(place) => place,
            Verdict::Wrong(text) => {
                println!("seed {seed}: {text}");
                wrong += 1;
                "wrong"
            }
        };
        *tally.entry(what).or_default() += 1;
        let done = seed - first + 1;
        if done.is_multiple_of(1000) {
            println!("{done} of {count}: {tally:?}");
        }
    }
    println!("{count} cams, seeds {first} to {}: {tally:?}", first.saturating_add(count).saturating_sub(1));
    if wrong == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
