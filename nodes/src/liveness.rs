//! Whether a partner is still heard.
//!
//! Silence is measured between looks, each of which counts a bounded time: a process that was stopped, or a thread that was starved, does
//! not take its own pause for the silence of another.

use crate::ros::{Logger, Node, Parameter};
use std::time::{Duration, Instant};

/// Parameter: how long a partner may be silent.
const LIMIT: &str = "silence_limit_s";
/// Longest time that one look counts.
const LONGEST_LOOK: Duration = Duration::from_millis(200);
/// How often a partner that has nothing new repeats what it said, so that it is heard.
pub(crate) const HEARTBEAT: Duration = Duration::from_millis(250);
/// How often a node looks after its partners.
pub(crate) const LOOK: Duration = Duration::from_millis(100);

/// The parameter of every node that waits for a partner.
pub(crate) fn parameter() -> Parameter {
    Parameter::double(LIMIT, 2.5)
        .describe("longest silence of a partner; a longer one ends the motion or the job with an alarm (s)")
        .range(0.5, 60.0)
        .read_only()
}

/// How long a partner may be silent.
pub(crate) fn limit(node: &Node) -> Duration {
    Duration::from_secs_f64(node.parameters().double(LIMIT))
}

/// The silence of one partner.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Silence {
    limit: Duration,
    silent: Duration,
    looked: Instant,
}

impl Silence {
    /// A partner that has just been heard.
    pub(crate) fn new(limit: Duration) -> Self {
        Self { limit, silent: Duration::ZERO, looked: Instant::now() }
    }

    /// The partner has said something.
    pub(crate) fn heard(&mut self) {
        self.silent = Duration::ZERO;
    }

    /// Looks now; true when the silence has just become too long.
    pub(crate) fn look(&mut self) -> bool {
        self.look_at(Instant::now())
    }

    /// The same at a time.
    pub(crate) fn look_at(&mut self, now: Instant) -> bool {
        let since = now.saturating_duration_since(std::mem::replace(&mut self.looked, now));
        let was_lost = self.is_lost();
        self.silent = self.silent.saturating_add(since.min(LONGEST_LOOK));
        self.is_lost() && !was_lost
    }

    /// Whether the partner has been silent for too long.
    pub(crate) fn is_lost(&self) -> bool {
        self.silent > self.limit
    }

    /// The limit (s).
    pub(crate) fn limit_s(&self) -> f64 {
        self.limit.as_secs_f64()
    }
}

/// A warning that is logged once a second at most: what fails for every message would fill the log.
#[derive(Debug, Default)]
pub(crate) struct Complaint {
    last: Option<Instant>,
    kept_back: u64,
}

impl Complaint {
    const PERIOD: Duration = Duration::from_secs(1);

    /// Logs a warning, or counts it.
    pub(crate) fn warn(&mut self, logger: &Logger, text: &str) {
        let now = Instant::now();
        if self.last.is_some_and(|last| now - last < Self::PERIOD) {
            self.kept_back += 1;
            return;
        }
        self.last = Some(now);
        match std::mem::take(&mut self.kept_back) {
            0 => logger.warn(text),
            more => logger.warn(&format!("{text} ({more} similar warnings before)")),
        }
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
        let lost: Vec<u32> = (1..=30).filter(|look| partner.look_at(begin + *look * 100 * MS)).collect();
        assert_eq!(lost, [11], "told once, by the first look after the limit");
        assert!(partner.is_lost());
        partner.heard();
        assert!(!partner.is_lost());
        assert!(!partner.look_at(begin + 3100 * MS));
    }

    #[test]
    fn a_pause_of_its_own_is_no_silence_of_the_partner() {
        let mut partner = Silence::new(1000 * MS);
        let begin = partner.looked;
        assert!(!partner.look_at(begin + 60_000 * MS), "this process was stopped for a minute");
        assert!(!partner.is_lost());
    }
}
