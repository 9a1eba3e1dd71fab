// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Counts of what a node refused or could not deliver, for its diagnostics.

use std::sync::atomic::{AtomicU64, Ordering};

use camwright_msgs::diagnostic_msgs::msg::KeyValue;

#[derive(Debug, Default)]
pub(super) struct Count(AtomicU64);

impl Count {
    pub(super) fn add_one(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    pub(super) fn get(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// Counts of a node since its start.
#[derive(Debug, Default)]
pub(super) struct Load {
    /// Goals that were rejected.
    pub(super) goals_rejected: Count,
    /// Service calls that were refused because too many waited.
    pub(super) calls_refused: Count,
    /// Requests that could not be read.
    pub(super) requests_unreadable: Count,
    /// Replies whose client was not found, or that could not be written.
    pub(super) replies_undelivered: Count,
    /// Events of service introspection that could not be published.
    pub(super) service_events_dropped: Count,
}

impl Load {
    /// The counts that are not zero.
    pub(super) fn values(&self) -> Vec<KeyValue> {
        let counts = [
            ("goals rejected", &self.goals_rejected),
            ("calls refused", &self.calls_refused),
            ("requests unreadable", &self.requests_unreadable),
            ("replies undelivered", &self.replies_undelivered),
            ("service events dropped", &self.service_events_dropped),
        ];
        let is_news = |(_, count): &(&str, &Count)| count.get() > 0;
        let value = |(key, count): (&str, &Count)| KeyValue { key: key.to_string(), value: count.get().to_string() };
        counts.into_iter().filter(is_news).map(value).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_counts_above_zero_are_reported() {
        let load = Load::default();
        assert_eq!(load.values(), []);
        load.goals_rejected.add_one();
        load.goals_rejected.add_one();
        assert_eq!(load.values(), [KeyValue { key: "goals rejected".into(), value: "2".into() }]);
    }
}
