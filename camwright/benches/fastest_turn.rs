// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Planning time of the fastest turn, for comparison with an earlier state of the planner:
//!
//! ```text
//! cargo bench -p camwright --bench fastest_turn -- --save-baseline before
//! cargo bench -p camwright --bench fastest_turn -- --baseline before
//! ```
//!
//! The second command reports a change above the noise threshold of 5 %.

#[path = "../tests/cams/mod.rs"]
mod cams;
#[path = "../tests/cams/turn_cases.rs"]
mod turn_cases;

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Duration;
use turn_cases::cases;

/// First seed of the random lobes: the second has X far from its limits, the third uses its jerk nearly everywhere.
const SEED: u64 = 20_261_121;

fn fastest_turn(criterion: &mut Criterion) {
    for case in cases(3, SEED).expect("regular lobes") {
        criterion.bench_function(&case.name, |bencher| {
            bencher.iter(|| black_box(case.plan()).expect("it can be made"));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().noise_threshold(0.05).measurement_time(Duration::from_secs(8));
    targets = fastest_turn
}
criterion_main!(benches);
