// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Silence of a partner.
//!
//! Silence is measured between looks, each of which counts a bounded time: a process that was stopped, or a thread that was starved, does
//! not take its own pause for the silence of another.

use std::time::{Duration, Instant};

/// Longest time that one look counts.
const LONGEST_LOOK: Duration = Duration::from_millis(200);
/// Period in which a partner without news repeats its message, so that it counts as present.
pub const HEARTBEAT: Duration = Duration::from_millis(250);
/// Period of a node's check of its partners.
pub const LOOK: Duration = Duration::from_millis(100);

/// The silence of one partner.
#[derive(Debug, Clone, Copy)]
pub struct Silence {
    limit: Duration,
    silent: Duration,
    looked: Instant,
}

impl Silence {
    /// A partner that has just sent a message.
    pub fn new(limit: Duration) -> Self {
        Self { limit, silent: Duration::ZERO, looked: Instant::now() }
    }

    /// The partner has said something.
    pub fn reset(&mut self) {
        self.silent = Duration::ZERO;
    }

    /// Looks now; true when the silence has just become too long.
    pub fn poll(&mut self) -> bool {
        self.check(Instant::now())
    }

    /// The same at a time.
    pub fn check(&mut self, now: Instant) -> bool {
        let since = now.saturating_duration_since(std::mem::replace(&mut self.looked, now));
        let was_lost = self.is_lost();
        self.silent = self.silent.saturating_add(since.min(LONGEST_LOOK));
        self.is_lost() && !was_lost
    }

    /// Returns whether the partner has been silent for too long.
    pub fn is_lost(&self) -> bool {
        self.silent > self.limit
    }

    /// The limit (s).
    pub fn limit_s(&self) -> f64 {
        self.limit.as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn silence_is_lost_once_and_found_again() {
        let mut partner = Silence::new(1000 * MS);
        let begin = partner.looked;
        let lost: Vec<u32> = (1..=30).filter(|poll| partner.check(begin + *poll * 100 * MS)).collect();
        assert_eq!(lost, [11], "reported once, by the first look after the limit");
        assert!(partner.is_lost());
        partner.reset();
        assert!(!partner.is_lost());
        assert!(!partner.check(begin + 3100 * MS));
    }

    #[test]
    fn a_pause_of_its_own_is_no_silence_of_the_partner() {
        let mut partner = Silence::new(1000 * MS);
        let begin = partner.looked;
        assert!(!partner.check(begin + 60_000 * MS), "this process was stopped for a minute");
        assert!(!partner.is_lost());
    }
}
