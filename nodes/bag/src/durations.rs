// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Histogram of durations in fixed memory, filled from any thread without a lock.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Counters for each doubling of the time: a reported time is at most a sixteenth too long.
const PARTS: u64 = 16;
/// One for each time below `PARTS` nanoseconds, then `PARTS` for each doubling up to 2^64 ns.
const COUNTERS: usize = 976;

pub(super) struct Durations {
    counters: Box<[AtomicU64]>,
    longest_ns: AtomicU64,
}

/// Summary in ns. Percentiles are at most a sixteenth too long; the maximum is exact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DurationSummary {
    pub count: u64,
    /// Half of them take no longer (ns).
    pub p50_ns: u64,
    /// 99 of a hundred take no longer (ns).
    pub p99_ns: u64,
    /// 999 of a thousand take no longer (ns).
    pub p99_9_ns: u64,
    /// The longest (ns).
    pub longest_ns: u64,
}

impl std::fmt::Debug for Durations {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.summary().fmt(f)
    }
}

impl Default for Durations {
    fn default() -> Self {
        Self {
            counters: std::iter::repeat_with(AtomicU64::default).take(COUNTERS).collect(),
            longest_ns: AtomicU64::default(),
        }
    }
}

/// Which counter a time belongs to.
fn counter_of(ns: u64) -> usize {
    let index = if ns < PARTS {
        ns
    } else {
        let doubling = u64::from(ns.ilog2()) - 4;
        (doubling + 1) * PARTS + ((ns >> doubling) - PARTS)
    };
    usize::try_from(index).unwrap_or(COUNTERS)
}

/// The longest time (ns) of a counter.
fn longest_of(counter: usize) -> u64 {
    let counter = counter as u64;
    if counter < PARTS {
        return counter;
    }
    let doubling = counter / PARTS - 1;
    let first = (PARTS + counter % PARTS) << doubling;
    first + ((1 << doubling) - 1)
}

impl Durations {
    pub(super) fn add(&self, time: Duration) {
        let ns = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        if let Some(counter) = self.counters.get(counter_of(ns)) {
            counter.fetch_add(1, Ordering::Relaxed);
        }
        self.longest_ns.fetch_max(ns, Ordering::Relaxed);
    }

    pub(super) fn summary(&self) -> DurationSummary {
        let counts: Vec<u64> = self.counters.iter().map(|counter| counter.load(Ordering::Relaxed)).collect();
        let count: u64 = counts.iter().sum();
        let longest_ns = self.longest_ns.load(Ordering::Relaxed);
        // So many of a thousand, rounded up.
        let percentile = |of_thousand: u64| {
            let wanted = (count * of_thousand).div_ceil(1000).max(1);
            let mut seen = 0;
            let counter = counts.iter().position(|n| {
                seen += n;
                seen >= wanted
            });
            counter.map_or(0, |counter| longest_of(counter).min(longest_ns))
        };
        DurationSummary {
            count,
            p50_ns: percentile(500),
            p99_ns: percentile(990),
            p99_9_ns: percentile(999),
            longest_ns,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_time_has_one_counter_and_its_longest_is_at_most_a_sixteenth_more() {
        assert_eq!((counter_of(0), counter_of(15), counter_of(16), counter_of(17)), (0, 15, 16, 17));
        assert_eq!((counter_of(u64::MAX), longest_of(COUNTERS - 1)), (COUNTERS - 1, u64::MAX));
        for counter in 0..COUNTERS - 1 {
            let longest = longest_of(counter);
            assert_eq!((counter_of(longest), counter_of(longest + 1)), (counter, counter + 1));
        }
        for ns in (0..64).map(|shift| u64::MAX >> shift).chain([1000, 49_999, 123_456_789]) {
            let reported = longest_of(counter_of(ns));
            assert!(reported >= ns && reported - ns <= ns / 16, "{ns} ns is reported as {reported} ns");
        }
    }

    #[test]
    fn percentiles_are_those_of_what_was_added() {
        let durations = Durations::default();
        assert_eq!(durations.summary(), DurationSummary::default());
        for us in 1..=10_000 {
            durations.add(Duration::from_micros(us));
        }
        let reported = durations.summary();
        assert_eq!((reported.count, reported.longest_ns), (10_000, 10_000_000));
        for (reported, exact) in
            [(reported.p50_ns, 5_000_000), (reported.p99_ns, 9_900_000), (reported.p99_9_ns, 9_990_000)]
        {
            assert!((exact..=exact + exact / 16).contains(&reported), "{reported} ns for {exact} ns");
        }
        let one = Durations::default();
        one.add(Duration::from_nanos(777));
        assert_eq!((one.summary().p50_ns, one.summary().p99_9_ns), (777, 777));
    }
}
