//! A fixed slice of the campaign of `cargo run --release -p camwright --example random_cams`.

#[path = "cams/campaign.rs"]
mod campaign;
mod cams;

pub(crate) use cams::{Seeded, segment};

use campaign::{Verdict, judge};

/// No panic, no NaN, no limit broken; lifts come back, turned lifts turn the contour.
#[test]
fn random_cams_are_refused_or_planned_and_never_wrong() {
    let (mut planned, mut refused) = (0, 0);
    for seed in 1..=120 {
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
    assert!(planned >= 10 && refused >= 10, "both kinds are met: {planned} planned, {refused} refused");
}
