// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Which moment of the bag it is now, and when a later one will be.

use std::time::{Duration, Instant};

/// The bag's time as it is played: at a rate, or standing still. It is computed from the last change of either and never summed up, so that
/// a long playback does not drift.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlaybackPace {
    rate: f64,
    /// Bag time (ns since 1970) at the last change.
    from_ns: u64,
    /// When that was; none while it stands still.
    since: Option<Instant>,
}

impl PlaybackPace {
    /// Stands still at a moment of the bag.
    pub(super) fn new(from_ns: u64, rate: f64) -> Self {
        Self { rate, from_ns, since: None }
    }

    pub(super) fn rate(&self) -> f64 {
        self.rate
    }

    pub(super) fn is_paused(&self) -> bool {
        self.since.is_none()
    }

    /// The bag's time at a moment (ns since 1970).
    pub(super) fn at(&self, now: Instant) -> u64 {
        let passed = self.since.map_or(Duration::ZERO, |since| now.saturating_duration_since(since));
        self.from_ns.saturating_add(nanoseconds(passed.as_secs_f64() * 1e9 * self.rate))
    }

    /// When a moment of the bag is reached; none while it stands still.
    pub(super) fn due(&self, bag_ns: u64) -> Option<Instant> {
        let ahead = bag_ns.saturating_sub(self.from_ns) as f64 / self.rate;
        let since = self.since?;
        // Times beyond the range of the system's clock are never due.
        since.checked_add(Duration::from_nanos(nanoseconds(ahead))).or_else(|| since.checked_add(FAR))
    }

    pub(super) fn pause(&mut self, now: Instant) {
        (self.from_ns, self.since) = (self.at(now), None);
    }

    /// Goes on at a moment, which may lie ahead.
    pub(super) fn resume(&mut self, when: Instant) {
        if self.is_paused() {
            self.since = Some(when);
        }
    }

    pub(super) fn set_rate(&mut self, now: Instant, rate: f64) {
        self.jump(now, self.at(now));
        self.rate = rate;
    }

    /// It is another moment of the bag from now on.
    pub(super) fn jump(&mut self, now: Instant, bag_ns: u64) {
        self.from_ns = bag_ns;
        self.since = self.since.map(|since| since.max(now));
    }
}

const FAR: Duration = Duration::from_secs(100 * 365 * 86_400);

fn nanoseconds(ns: f64) -> u64 {
    #[allow(clippy::cast_possible_truncation, reason = "the conversion saturates")]
    let whole = ns as u64;
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEGIN: u64 = 1_760_000_000_000_000_000;
    const SECOND: u64 = 1_000_000_000;

    #[test]
    fn twice_the_rate_is_half_the_time_and_pauses_do_not_count() {
        let start = Instant::now();
        let after = |seconds| start + Duration::from_secs(seconds);
        let mut pace = PlaybackPace::new(BEGIN, 2.0);
        assert!(pace.is_paused() && pace.due(BEGIN).is_none());
        pace.resume(after(1));
        assert_eq!((pace.at(start), pace.at(after(3))), (BEGIN, BEGIN + 4 * SECOND));
        assert_eq!(pace.due(BEGIN + 4 * SECOND), Some(after(3)));
        assert_eq!(pace.due(BEGIN - SECOND), Some(after(1)), "what is past is due at once");
        pace.pause(after(3));
        assert_eq!(pace.at(after(100)), BEGIN + 4 * SECOND);
        pace.resume(after(100));
        pace.resume(after(200));
        assert_eq!(pace.at(after(101)), BEGIN + 6 * SECOND, "it goes on already");
        pace.set_rate(after(101), 0.5);
        assert_eq!((pace.at(after(103)), pace.rate()), (BEGIN + 7 * SECOND, 0.5));
        pace.jump(after(103), BEGIN);
        assert_eq!(pace.at(after(105)), BEGIN + SECOND);
    }

    #[test]
    fn no_rate_and_no_time_overflows() {
        let mut pace = PlaybackPace::new(0, 1e-300);
        pace.resume(Instant::now());
        assert!(pace.due(u64::MAX).is_some_and(|due| due > Instant::now()));
        let mut pace = PlaybackPace::new(u64::MAX - 1, 1e300);
        pace.resume(Instant::now());
        assert_eq!(pace.at(Instant::now() + Duration::from_secs(1)), u64::MAX);
    }
}
