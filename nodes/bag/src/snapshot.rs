// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The last seconds of a recording, held in memory until a request writes them to the bag.

use std::collections::VecDeque;
use std::time::Duration;

/// Size of the buffered part of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SnapshotOptions {
    /// Age up to which messages are held, by log time.
    pub keep: Duration,
    /// Most bytes that are held; the oldest messages go first.
    pub bytes: u64,
}

/// A message that is held.
#[derive(Debug)]
pub(super) struct BufferedMessage {
    /// Which of the recording's topics.
    pub(super) topic: usize,
    pub(super) log_time_ns: u64,
    pub(super) publish_time_ns: u64,
    pub(super) data: Vec<u8>,
}

/// Messages in the order in which they came.
#[derive(Debug)]
pub(super) struct Ring {
    options: SnapshotOptions,
    held: VecDeque<BufferedMessage>,
    bytes: u64,
}

impl Ring {
    pub(super) fn new(options: SnapshotOptions) -> Self {
        Self { options, held: VecDeque::new(), bytes: 0 }
    }

    /// Holds one message more.
    pub(super) fn hold(&mut self, message: BufferedMessage) {
        self.bytes += message.data.len() as u64;
        self.held.push_back(message);
    }

    /// The oldest message, if it is older than the newest by more than is held, or if all are too many.
    pub(super) fn take_outdated(&mut self) -> Option<BufferedMessage> {
        let newest_ns = self.held.back()?.log_time_ns;
        let keep_ns = u64::try_from(self.options.keep.as_nanos()).unwrap_or(u64::MAX);
        let is_outdated = newest_ns.saturating_sub(self.held.front()?.log_time_ns) > keep_ns;
        if is_outdated || self.bytes > self.options.bytes { self.take() } else { None }
    }

    pub(super) fn take(&mut self) -> Option<BufferedMessage> {
        let oldest = self.held.pop_front()?;
        self.bytes -= oldest.data.len() as u64;
        Some(oldest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_old_or_too_much_is_let_go_of_from_its_old_end() {
        let mut ring = Ring::new(SnapshotOptions { keep: Duration::from_secs(2), bytes: 100 });
        let message = |topic: usize, log_time_ns: u64, bytes: usize| BufferedMessage {
            topic,
            log_time_ns,
            publish_time_ns: 0,
            data: vec![0; bytes],
        };
        for (topic, second) in (0..).zip([1, 2, 3, 4]) {
            ring.hold(message(topic, second * 1_000_000_000, 10));
        }
        assert_eq!(ring.take_outdated().map(|held| held.topic), Some(0));
        assert!(ring.take_outdated().is_none(), "two seconds old is not too old");
        ring.hold(message(9, 4_000_000_000, 80));
        assert_eq!(ring.take_outdated().map(|held| held.topic), Some(1), "110 bytes are too many");
        assert!(ring.take_outdated().is_none());
        assert_eq!(std::iter::from_fn(|| ring.take()).map(|held| held.topic).collect::<Vec<_>>(), [2, 3, 9]);
        assert_eq!(ring.bytes, 0);
    }
}
