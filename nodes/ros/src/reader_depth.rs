// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Depth of a reader's cache, chosen by the size and the rate of the messages.
//!
//! `RustDDS` frees a sample when newer samples push it out of the topic's cache, not when it is taken. A cache for 20,000 joint states
//! costs 6 MB, one for 20,000 plan pages 640 MB. The limit of a cache can be raised while it is in use, and never lowered. A cache
//! therefore begins small. It grows when the rate of arrival needs it, as long as messages of the largest size seen fit the budget.

use super::{
    node::{Node, WeakNode},
    qos::Qos,
};

/// Samples a growing cache holds before its first message is seen.
const INITIAL: u32 = 256;

/// Samples a cache holds at any rate, as soon as one message has shown that so many are cheap.
const QUICK: u32 = 512;

/// Maximum number of samples before the first message where a late joiner gets a history at once.
const MAX_HISTORY: u32 = 2048;

/// Memory a sample takes in addition to its payload (B): two entries of ordered maps, and the header.
const OVERHEAD_BYTES: usize = 256;

/// Time for which a cache holds all messages that arrive at the highest rate seen (ns).
const HORIZON_NS: i64 = 1_000_000_000;

/// Bounds of a growing cache.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct DepthBounds {
    /// Samples before the first message.
    pub(super) initial: u32,
    /// Maximum number of samples.
    pub(super) max: u32,
    /// Memory that growth may use (B).
    pub(super) budget_bytes: usize,
}

impl DepthBounds {
    /// For a subscription that must not lose messages while its process does not get its turn.
    ///
    /// `history` messages may come at once at the beginning.
    pub(super) fn for_topic(qos: &Qos, history: u32, budget_bytes: usize) -> Self {
        let max = qos.depth().max(1);
        DepthBounds { initial: history.clamp(INITIAL, MAX_HISTORY).min(max), max, budget_bytes }
    }

    /// For requests and replies: a burst of thousands waits in the cache until each is answered. It may be there before the reader
    /// has looked at its first message.
    pub(super) const fn for_service() -> Self {
        DepthBounds { initial: MAX_HISTORY, max: 8192, budget_bytes: 16 << 20 }
    }
}

/// Decides when a cache grows.
#[derive(Debug)]
struct Growth {
    bounds: DepthBounds,
    granted: u32,
    largest_bytes: usize,
    /// Reception time of the first message of the current count (ns), and the count.
    since_ns: i64,
    count: u32,
}

impl Growth {
    fn new(bounds: DepthBounds) -> Self {
        Growth { bounds, granted: bounds.initial, largest_bytes: 0, since_ns: i64::MIN, count: 0 }
    }

    /// Takes note of a message; returns the new depth when the cache must grow.
    fn observe(&mut self, bytes: usize, received_ns: i64) -> Option<u32> {
        self.largest_bytes = self.largest_bytes.max(bytes);
        if received_ns.saturating_sub(self.since_ns) >= HORIZON_NS || received_ns < self.since_ns {
            (self.since_ns, self.count) = (received_ns, 0);
        }
        self.count = self.count.saturating_add(1);
        let affordable = self.bounds.budget_bytes / (self.largest_bytes + OVERHEAD_BYTES);
        let affordable = u32::try_from(affordable).unwrap_or(u32::MAX).min(self.bounds.max);
        // Twice as many as arrived so far: at any rate the cache grows before it is full.
        let needed = if self.count > self.granted / 2 { self.granted.saturating_mul(2) } else { QUICK };
        let wanted = needed.min(affordable);
        (wanted > self.granted).then(|| {
            self.granted = wanted;
            wanted
        })
    }
}

/// A reader's cache that grows.
pub(super) struct ReaderDepth {
    growth: Growth,
    node: WeakNode,
    dds_name: String,
    dds_type: String,
    qos: Qos,
}

impl ReaderDepth {
    pub(super) fn new(node: &Node, dds_name: &str, dds_type: &str, qos: &Qos, bounds: DepthBounds) -> Self {
        ReaderDepth {
            growth: Growth::new(bounds),
            node: node.downgrade(),
            dds_name: dds_name.to_string(),
            dds_type: dds_type.to_string(),
            qos: *qos,
        }
    }

    /// Takes note of a message, and raises the limit of the cache when it has to grow.
    pub(super) fn observe(&mut self, bytes: usize, received_ns: i64) {
        let Some(depth) = self.growth.observe(bytes, received_ns) else { return };
        let Some(node) = self.node.upgrade() else { return };
        // Creating a topic that exists raises the limit of its cache; a node that is leaving needs none.
        let _ = node.dds_topic(self.dds_name.clone(), &self.dds_type, &self.qos.reader_policies_of_depth(depth));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: DepthBounds = DepthBounds { initial: 256, max: 20_000, budget_bytes: 16 << 20 };

    /// Depth after so many messages of a size at a rate.
    fn depth_after(messages: i64, bytes: usize, per_second: i64) -> u32 {
        let mut growth = Growth::new(BOUNDS);
        for index in 0..messages {
            growth.observe(bytes, index * 1_000_000_000 / per_second);
        }
        growth.granted
    }

    #[test]
    fn small_messages_at_a_high_rate_get_the_full_depth() {
        assert_eq!(depth_after(1, 300, 1000), QUICK);
        assert_eq!(depth_after(60_000, 300, 10), QUICK);
        assert_eq!(depth_after(60_000, 300, 1000), 2048);
        assert_eq!(depth_after(50_000, 300, 50_000), 20_000);
    }

    #[test]
    fn a_cache_grows_before_a_fast_stream_could_fill_it() {
        let mut growth = Growth::new(BOUNDS);
        for index in 0..10_000_u32 {
            growth.observe(300, i64::from(index));
            assert!(growth.granted > index.min(19_999), "{} at {index}", growth.granted);
        }
    }

    #[test]
    fn large_messages_never_get_more_than_the_budget() {
        assert_eq!(depth_after(100_000, 32_000, 5000), 520);
        assert_eq!(depth_after(1000, 4 << 20, 1000), 256);
        let mut growth = Growth::new(BOUNDS);
        for index in 0..100_000 {
            growth.observe(if index < 50 { 300 } else { 32_000 }, index * 1_000_000);
        }
        assert_eq!(growth.granted, 520);
    }

    #[test]
    fn a_clock_that_jumps_back_begins_a_new_count() {
        let mut growth = Growth::new(BOUNDS);
        for time in [0, 5_000_000_000, 1_000_000_000, i64::MIN, i64::MAX] {
            growth.observe(300, time);
        }
        assert_eq!(growth.granted, QUICK);
    }
}
