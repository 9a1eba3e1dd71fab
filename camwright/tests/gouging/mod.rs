// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Nothing that is planned cuts deeper than the design, at any tick, however it is held, slowed or cancelled: seeded random jobs through the
//! real interpolator, and the edge beside the design by a sweep of its own.
//!
//! A slice of the seeds runs with all tests. A long campaign:
//!
//! ```text
//! GOUGE_KIND=grinding GOUGE_SEED=1000 GOUGE_COUNT=2000 cargo test -p camwright --test integration gouging::campaign -- --ignored --nocapture
//! ```
//! Kinds are grinding, correcting, turning and programs; without one all of them run.
#![allow(clippy::print_stdout, reason = "figures for the reader of --nocapture")]
#![allow(clippy::cast_possible_truncation, reason = "indices of tables")]

mod correcting;
mod drive;
mod grinding;
mod programs;
mod sweep;
mod turning;

use crate::cams;
use crate::program_motion::shop::Part;
use std::collections::BTreeMap;
use std::ops::Range;

/// Outcome of a job.
pub(crate) enum JobEnd {
    /// It was not planned.
    Refused(String),
    /// It ran, and its deepest place beside the design (mm).
    Clean { deepest_mm: f64 },
    /// It was too deep, or ended otherwise than it should.
    Gouge(String),
}

/// Judges seeds and prints what became of them; how many ran.
fn all(kind: &str, seeds: Range<u64>, judge: impl Fn(u64) -> JobEnd) -> usize {
    let (mut ran, mut deepest, mut refused, mut wrong) = (0, (f64::NEG_INFINITY, 0), BTreeMap::new(), Vec::new());
    for seed in seeds {
        match judge(seed) {
            JobEnd::Clean { deepest_mm } => {
                ran += 1;
                deepest = if deepest_mm > deepest.0 { (deepest_mm, seed) } else { deepest };
            }
            JobEnd::Refused(why) => {
                let why: String = why.chars().filter(|c| !c.is_ascii_digit()).take(70).collect();
                let (count, _) = refused.entry(why).or_insert((0, seed));
                *count += 1;
            }
            JobEnd::Gouge(fault) => {
                println!("{kind} seed {seed}: {fault}");
                wrong.push(seed);
            }
        }
    }
    println!("{kind}: {ran} ran, deepest {:+.4} um (seed {}), {} gouge", 1e3 * deepest.0, deepest.1, wrong.len());
    for (why, (count, seed)) in refused {
        println!("  {count} refused, first seed {seed}: {why}");
    }
    assert!(wrong.is_empty(), "{kind}: seeds {wrong:?}");
    ran
}

fn programs(seeds: Range<u64>) -> usize {
    let touch = sweep::Touch::new(&cams::reference_contour(), Part::lobe().wheel_mm(), 0.0);
    all("programs", seeds, |seed| programs::judge(seed, &touch))
}

#[test]
fn ground_lobes_are_nowhere_deeper_than_their_design() {
    assert!(all("grinding", 0..24, grinding::judge) > 12);
}

#[test]
fn corrected_journals_are_nowhere_deeper_than_their_design() {
    assert!(all("correcting", 0..8, correcting::judge) > 4);
}

/// Each of these seeds holds in the middle of a turn that corrects runout.
#[test]
fn a_hold_in_a_correction_waits_for_the_end_of_its_cut() {
    for seed in [3052, 3086, 3121] {
        assert_eq!(all("correcting", seed..seed + 1, correcting::judge), 1, "seed {seed} was refused");
    }
}

#[test]
fn turned_parts_are_nowhere_deeper_than_their_design() {
    assert!(all("turning", 0..4, turning::judge) > 0);
}

#[test]
fn programs_are_nowhere_deeper_than_the_design() {
    assert!(programs(0..3) > 0);
}

#[test]
#[ignore = "a campaign of minutes to hours: GOUGE_KIND, GOUGE_SEED, GOUGE_COUNT"]
fn campaign() {
    let number =
        |name: &str, default: u64| std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default);
    let from = number("GOUGE_SEED", 0);
    let seeds = from..from + number("GOUGE_COUNT", 200);
    let kind = std::env::var("GOUGE_KIND").unwrap_or_default();
    let wanted = |name: &str| kind.is_empty() || kind == name;
    if wanted("grinding") {
        all("grinding", seeds.clone(), grinding::judge);
    }
    if wanted("correcting") {
        all("correcting", seeds.clone(), correcting::judge);
    }
    if wanted("turning") {
        all("turning", seeds.clone(), turning::judge);
    }
    if wanted("programs") {
        programs(seeds);
    }
}
