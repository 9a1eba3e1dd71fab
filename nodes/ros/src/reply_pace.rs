// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The pace of replies to one client.
//!
//! A client of `rclpy` or `rclcpp` keeps ten unread replies (the ROS default) and loses the older ones. A client that sends hundreds of
//! requests in a loop reads no reply until the loop ends. Replies to such a client therefore wait until its requests pause, and then go
//! out in small batches. The first replies are never delayed.

use std::{
    collections::{BTreeMap, VecDeque},
    time::{Duration, Instant},
};

/// Replies within a step that go out at once: what fits into the reader of a client in addition to two that it has not read.
const AT_ONCE: usize = 8;

/// Replies of a step after a burst. With [`STEP`], 600 a second: `rclpy` read about 1000 a second on two busy cores.
const BATCH: usize = 3;

/// Time from step to step.
pub(super) const STEP: Duration = Duration::from_millis(5);

/// Requests have paused when none came for so long.
const QUIET: Duration = Duration::from_millis(15);

/// Longest time for which replies wait for a pause.
const MAX_HOLD: Duration = Duration::from_millis(250);

/// Replies that may wait for one client; more are written at once.
const MAX_WAITING: usize = 8192;

/// State of one client.
#[derive(Debug)]
struct ReplyQueue<T> {
    last_request: Instant,
    /// Replies written since the beginning of the current step.
    written: usize,
    step: Instant,
    /// When the first of those that wait began to wait.
    waits_since: Instant,
    waiting: VecDeque<T>,
}

/// Replies that wait, by client.
#[derive(Debug)]
pub(super) struct ReplyPace<K: Ord, T> {
    clients: BTreeMap<K, ReplyQueue<T>>,
}

impl<K: Ord, T> Default for ReplyPace<K, T> {
    fn default() -> Self {
        ReplyPace { clients: BTreeMap::new() }
    }
}

impl<K: Ord + Copy, T> ReplyPace<K, T> {
    /// Registers a request.
    pub(super) fn request(&mut self, client: K, now: Instant) {
        let fresh =
            || ReplyQueue { last_request: now, written: 0, step: now, waits_since: now, waiting: VecDeque::new() };
        self.clients.entry(client).or_insert_with(fresh).last_request = now;
    }

    /// Takes a reply. Returns it when it is to be written at once; else it waits for [`ReplyPace::due`].
    pub(super) fn reply(&mut self, client: K, reply: T, now: Instant) -> Option<T> {
        let Some(known) = self.clients.get_mut(&client) else { return Some(reply) };
        if now.saturating_duration_since(known.step) >= STEP {
            (known.step, known.written) = (now, 0);
        }
        let must_wait = !known.waiting.is_empty() || known.written >= AT_ONCE;
        if !must_wait || known.waiting.len() >= MAX_WAITING {
            known.written += 1;
            return Some(reply);
        }
        if known.waiting.is_empty() {
            known.waits_since = now;
        }
        known.waiting.push_back(reply);
        None
    }

    /// Replies whose time has come. Forgets clients that are idle.
    pub(super) fn due(&mut self, now: Instant) -> Vec<T> {
        let mut due = Vec::new();
        self.clients.retain(|_, client| {
            let is_quiet = now.saturating_duration_since(client.last_request) >= QUIET;
            if is_quiet || now.saturating_duration_since(client.waits_since) >= MAX_HOLD {
                let batch = client.waiting.len().min(BATCH);
                due.extend(client.waiting.drain(..batch));
                (client.step, client.written) = (now, batch);
            }
            !client.waiting.is_empty() || now.saturating_duration_since(client.last_request) < MAX_HOLD
        });
        due
    }

    pub(super) fn has_waiting(&self) -> bool {
        self.clients.values().any(|client| !client.waiting.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times at which the replies to a burst are written (ms): requests come every `gap_us`, answers at once.
    fn burst(requests: u64, gap_us: u64) -> Vec<u64> {
        let start = Instant::now();
        let mut pace = ReplyPace::default();
        let mut written = Vec::new();
        let end = requests * gap_us;
        for us in (0..end + 8_000_000).step_by(100) {
            let now = start + Duration::from_micros(us);
            if us < end && us % gap_us == 0 {
                pace.request(1, now);
                written.extend(pace.reply(1, us / gap_us, now).map(|_| us / 1000));
            }
            if us % 5000 == 0 {
                written.extend(pace.due(now).iter().map(|_| us / 1000));
            }
        }
        assert!(!pace.has_waiting());
        written
    }

    #[test]
    fn a_single_call_and_a_steady_caller_are_answered_at_once() {
        assert_eq!(burst(1, 100), [0]);
        let steady = burst(100, 1000);
        assert!(steady.iter().enumerate().all(|(index, ms)| *ms == index as u64), "{steady:?}");
    }

    #[test]
    fn a_thousand_at_once_are_all_answered_in_small_batches() {
        let written = burst(1000, 200);
        assert_eq!(written.len(), 1000);
        assert!(written.iter().all(|ms| *ms < 2000), "{:?}", written.last());
        let during = written.iter().filter(|ms| **ms < 200).count();
        assert!(during <= AT_ONCE, "{during} replies while the client still sends");
        for start in 200..2000 {
            let in_step = written.iter().filter(|ms| (start..start + 5).contains(*ms)).count();
            assert!(in_step <= BATCH, "{in_step} in the 5 ms from {start}");
        }
        let of_300 = burst(300, 100);
        assert!(of_300.len() == 300 && of_300.iter().all(|ms| *ms < 600), "{:?}", of_300.last());
    }

    #[test]
    fn a_client_that_never_pauses_is_answered_after_the_longest_hold() {
        let written = burst(1000, 2000);
        assert_eq!(written.len(), 1000);
        assert!(written[999] <= 2100, "{}", written[999]);
        let many = burst(4000, 200);
        assert!(many[AT_ONCE] <= 255, "{}", many[AT_ONCE]);
    }
}
