// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A fixed slice of random turns, and a campaign of them:
//!
//! ```text
//! TURN_SEED=1000 TURN_COUNT=20000 cargo test -p camwright --test integration campaign_of_turns -- --ignored --nocapture
//! ```
#![allow(clippy::print_stdout, reason = "figures for the reader of --nocapture")]

#[path = "../cams/turn_campaign.rs"]
mod turn_campaign;

use std::ops::Range;
use turn_campaign::{TurnVerdict, USES, judge_turn, judge_turn_of_cut};

/// Largest use of a limit: what is left between the points that the planner looks at.
const MAX_USE: f64 = 1.00005;

/// Judges seeds and prints the largest uses; how many were planned.
fn all(kind: &str, seeds: Range<u64>, judge: impl Fn(u64) -> TurnVerdict) -> usize {
    let (mut planned, mut refused, mut wrong) = (0, 0, Vec::new());
    let mut worst = [(0.0_f64, 0_u64); USES];
    for seed in seeds {
        match judge(seed) {
            TurnVerdict::Planned { turn_s, uses, input } => {
                planned += 1;
                for (worst, used) in worst.iter_mut().zip(uses) {
                    *worst = if used > worst.0 { (used, seed) } else { *worst };
                }
                if uses.iter().any(|used| *used > MAX_USE) {
                    println!("{kind} seed {seed}, {turn_s} s, exceeds a limit: {uses:.6?}; {input}");
                    wrong.push(seed);
                }
            }
            TurnVerdict::Refused => refused += 1,
            TurnVerdict::Wrong(text) => {
                println!("{kind} seed {seed}: {text}");
                wrong.push(seed);
            }
        }
    }
    println!("{kind}: {planned} planned, {refused} refused; largest uses and their seeds {worst:.6?}");
    assert!(wrong.is_empty(), "{kind}: seeds {wrong:?}");
    planned
}

#[test]
fn random_turns_keep_every_limit() {
    assert!(all("turns", 0..40, judge_turn) > 30);
    assert!(all("cuts", 0..20, judge_turn_of_cut) > 5);
}

/// Peaks between the points at which a turn is planned: bottoms of notches that a flat bound hides but for their tip, a peak of the
/// speed below a flat bound, acceleration and jerk of X where a concave flank is followed by the largest wheel.
#[test]
fn peaks_between_the_points_are_found() {
    for seed in [127, 357, 617, 1061, 10_116, 551, 621, 927] {
        assert_eq!(all("turns", seed..seed + 1, judge_turn), 1, "seed {seed} is refused");
    }
}

/// Uses in time: notches of the bound (273, 416) and a peak of X's third derivative (309) that are much narrower than an interval of the
/// turn, where the quintic in time and the plan over the angle differ; the tip of a notch between two points of a flat bound
/// (250), and between two points of an interval that is shorter than their distance (401).
#[test]
fn narrow_peaks_are_kept_in_time() {
    for seed in [250, 273, 309, 401, 416] {
        assert_eq!(all("cuts", seed..seed + 1, judge_turn_of_cut), 1, "seed {seed} is refused");
    }
}

#[test]
#[ignore = "a campaign of minutes to hours: TURN_SEED, TURN_COUNT"]
fn campaign_of_turns() {
    let number =
        |name: &str, default: u64| std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default);
    let from = number("TURN_SEED", 0);
    let seeds = from..from + number("TURN_COUNT", 1000);
    all("turns", seeds.clone(), judge_turn);
    all("cuts", seeds, judge_turn_of_cut);
}
