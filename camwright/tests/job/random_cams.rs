// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Fixed slices of the campaigns of `cargo run --release -p camwright --example random_cams` and `… --example long_cuts`.

#[path = "../cams/campaign.rs"]
mod campaign;
#[path = "../cams/long_cuts.rs"]
mod long_cuts;
#[path = "../cams/odd_jobs.rs"]
mod odd_jobs;

use campaign::{Verdict, judge};
use odd_jobs::{OddVerdict, judge_odd_job};

/// Zero, next to nothing, beyond anything, infinite and not a number where a job has a number.
#[test]
fn jobs_with_odd_numbers_are_refused_or_planned() {
    let (mut planned, mut refused) = (0, 0);
    for seed in (1..=8).chain([28, 43]) {
        match judge_odd_job(seed).0 {
            OddVerdict::Planned => planned += 1,
            OddVerdict::Refused => refused += 1,
            OddVerdict::Wrong(text) => panic!("seed {seed}: {text}"),
        }
    }
    assert!(planned >= 1 && refused >= 4, "both are met: {planned} planned, {refused} refused");
}

use long_cuts::{CutVerdict, judge_cut, reference_cut};

/// After many turns a position has fewer digits behind its point: that is no reason to refuse a plan.
#[test]
fn no_cut_is_refused_because_its_positions_were_rounded() {
    assert_eq!(reference_cut(), CutVerdict::Planned(21));
    let (mut planned, mut max_turns) = (0, 0);
    for seed in 1..=20 {
        match judge_cut(seed) {
            CutVerdict::Planned(turns) => (planned, max_turns) = (planned + 1, max_turns.max(turns)),
            CutVerdict::Refused(_) => {}
            CutVerdict::Wrong(text) => panic!("seed {seed}: {text}"),
        }
    }
    assert!(planned >= 7 && max_turns > 500, "{planned} were planned, of up to {max_turns} turns");
}

/// No panic, no NaN, no limit broken; lifts come back, turned lifts turn the contour.
#[test]
fn random_cams_are_refused_or_planned_and_never_wrong() {
    let (mut planned, mut refused) = (0, 0);
    for seed in 1..=40 {
        match judge(seed) {
            Verdict::Planned => planned += 1,
            Verdict::Refused(_) => refused += 1,
            Verdict::Wrong(text) => panic!("seed {seed}: {text}"),
        }
    }
    // Notches in the bound narrower than the grid it was looked at on, or with their bottom between its points; and a speed that
    // all but vanished between two points.
    let notches = [321, 697, 2005, 5017, 5466, 5795, 50_637, 55_826, 79_148, 79_956, 93_573];
    for seed in notches.into_iter().chain([35_113]) {
        assert_eq!(judge(seed), Verdict::Planned, "seed {seed}");
    }
    assert!(planned >= 5 && refused >= 5, "both kinds are met: {planned} planned, {refused} refused");
}
