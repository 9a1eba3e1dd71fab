// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Random delays between the wire and the callbacks, for tests of determinism.

use std::time::Duration;

/// Random delays of subscription callbacks, for tests that results do not depend on delivery times. The order within a topic is
/// kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DelayInjection {
    /// Seed of the delays.
    pub seed: u64,
    /// Longest delay in ms.
    pub max_ms: u64,
}

impl DelayInjection {
    /// Name of the environment variable that sets it, as `seed:max_ms`.
    pub const ENVIRONMENT: &str = "CAMWRIGHT_DELAY_INJECTION";

    pub(super) fn from_env() -> Option<Self> {
        let text = std::env::var(Self::ENVIRONMENT).ok()?;
        let (seed, max_ms) = text.split_once(':')?;
        Some(DelayInjection { seed: seed.trim().parse().ok()?, max_ms: max_ms.trim().parse().ok()? })
    }

    /// The delays of the subscription with this number, which has a stream of its own (splitmix64 of seed and number).
    pub(super) fn source(self, number: u64) -> DelaySource {
        let mut state = self.seed.wrapping_add(number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        state = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state = (state ^ (state >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        DelaySource { state: (state ^ (state >> 31)) | 1, max_us: self.max_ms.saturating_mul(1000) }
    }
}

/// A stream of delays (xorshift64*; quality enough to shuffle deliveries).
pub(super) struct DelaySource {
    state: u64,
    max_us: u64,
}

impl DelaySource {
    pub(super) fn next(&mut self) -> Duration {
        self.state ^= self.state >> 12;
        self.state ^= self.state << 25;
        self.state ^= self.state >> 27;
        Duration::from_micros((self.state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 16) % (self.max_us + 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_stay_within_their_bound_and_differ() {
        let mut source = DelaySource { state: 42, max_us: 5000 };
        let delays: Vec<Duration> = (0..1000).map(|_| source.next()).collect();
        assert!(delays.iter().all(|delay| *delay <= Duration::from_millis(5)));
        assert!(delays.iter().any(|delay| *delay > Duration::from_millis(4)));
        assert!(delays.iter().any(|delay| *delay < Duration::from_millis(1)));
    }
}
