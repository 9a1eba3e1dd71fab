// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Latched messages kept while a bag is written, so that every file of it begins with what a late listener would get.

use std::collections::{BTreeMap, VecDeque};

/// Messages kept of one topic at most: as many pages as a plan has.
const PER_TOPIC: usize = 1000;
/// Bytes kept of all topics together at most; the oldest go first.
const ALL_BYTES: usize = 64 << 20;

/// One message that is written again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct LatchedMessage {
    /// Number of its topic in the bag.
    pub(super) topic: usize,
    pub(super) sequence: u32,
    pub(super) publish_time_ns: u64,
    pub(super) data: Vec<u8>,
}

/// The last messages of each latched topic, by order of arrival.
#[derive(Debug, Default)]
pub(super) struct Latched {
    kept: VecDeque<LatchedMessage>,
    per_topic: BTreeMap<usize, usize>,
    bytes: usize,
}

impl Latched {
    pub(super) fn retain(&mut self, message: LatchedMessage) {
        let (topic, count) = (message.topic, self.per_topic.entry(message.topic).or_insert(0));
        *count += 1;
        let is_too_many = *count > PER_TOPIC;
        self.bytes += message.data.len();
        self.kept.push_back(message);
        if is_too_many && let Some(oldest) = self.kept.iter().position(|kept| kept.topic == topic) {
            self.forget(oldest);
        }
        while self.bytes > ALL_BYTES && self.kept.len() > 1 {
            self.forget(0);
        }
    }

    fn forget(&mut self, index: usize) {
        if let Some(old) = self.kept.remove(index) {
            self.bytes -= old.data.len();
            if let Some(count) = self.per_topic.get_mut(&old.topic) {
                *count -= 1;
            }
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &LatchedMessage> {
        self.kept.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(topic: usize, sequence: u32, bytes: usize) -> LatchedMessage {
        LatchedMessage { topic, sequence, publish_time_ns: 1, data: vec![0; bytes] }
    }

    #[test]
    fn the_newest_of_each_topic_are_kept_in_order_and_within_bounds() {
        let mut latched = Latched::default();
        latched.retain(message(1, 1, 10));
        for sequence in 1..=u32::try_from(PER_TOPIC).expect("it fits") + 7 {
            latched.retain(message(0, sequence, 1));
        }
        let of = |topic: usize| latched.iter().filter(move |kept| kept.topic == topic).map(|kept| kept.sequence);
        assert_eq!(of(1).collect::<Vec<_>>(), [1], "a frequent topic does not push out a rare one");
        assert_eq!((of(0).count(), of(0).min(), of(0).max()), (PER_TOPIC, Some(8), Some(1007)));
        latched.retain(message(2, 1, ALL_BYTES - 5));
        assert!(latched.bytes <= ALL_BYTES && latched.iter().any(|kept| kept.topic == 2));
        latched.retain(message(3, 1, ALL_BYTES + 1));
        assert_eq!(latched.iter().count(), 1, "what alone is too much is kept alone");
    }
}
