// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Warnings that come again and again: the first at once, the others as a count.

use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex, MutexGuard, PoisonError, Weak},
    time::{Duration, Instant},
};

use super::executor::Executor;
use super::logging::Logger;

/// Time for which repetitions are counted before they are reported.
const PERIOD: Duration = Duration::from_secs(5);

/// Kinds of warnings that are counted separately at a time. Further ones are counted as one.
const MAX_KINDS: usize = 64;

/// The kind that stands for all beyond [`MAX_KINDS`].
const OTHERS: &str = "further refusals";

/// Warnings of a node that repeat.
pub(super) struct RepeatedWarnings {
    counts: WarningCounts,
    executor: Weak<Executor>,
    logger: Logger,
}

impl RepeatedWarnings {
    pub(super) fn new(executor: &Arc<Executor>, logger: &Logger) -> Arc<Self> {
        let (executor, logger) = (Arc::downgrade(executor), logger.clone());
        Arc::new(RepeatedWarnings { counts: WarningCounts::default(), executor, logger })
    }

    /// Writes the first warning of a kind and counts the others.
    #[track_caller]
    pub(super) fn warn(self: &Arc<Self>, kind: &str, text: &str) {
        let Some(kind) = self.counts.add(kind) else { return };
        self.report_later(kind);
        self.logger.warn(text);
    }

    fn report_later(self: &Arc<Self>, kind: String) {
        let Some(executor) = self.executor.upgrade() else { return };
        let weak = Arc::downgrade(self);
        let report = move || {
            let Some(warnings) = weak.upgrade() else { return };
            let count = warnings.counts.end_period(&kind);
            if count > 0 {
                let seconds = PERIOD.as_secs();
                warnings.logger.warn(&format!("{kind}: {count} more times in the last {seconds} s"));
                warnings.report_later(kind);
            }
        };
        executor.at(Instant::now() + PERIOD, Box::new(report));
    }
}

/// Counts of repetitions in the current period, by kind.
#[derive(Debug, Default)]
struct WarningCounts {
    repeated: Mutex<BTreeMap<String, u64>>,
}

impl WarningCounts {
    fn repeated(&self) -> MutexGuard<'_, BTreeMap<String, u64>> {
        self.repeated.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The kind that begins a period, or `None` when the warning was counted.
    fn add(&self, kind: &str) -> Option<String> {
        let mut repeated = self.repeated();
        let kind = if repeated.contains_key(kind) || repeated.len() < MAX_KINDS { kind } else { OTHERS };
        if let Some(count) = repeated.get_mut(kind) {
            *count += 1;
            return None;
        }
        repeated.insert(kind.to_string(), 0);
        Some(kind.to_string())
    }

    /// Ends the period of a kind. Returns the repetitions, and begins the next period when there were any.
    fn end_period(&self, kind: &str) -> u64 {
        let mut repeated = self.repeated();
        match repeated.get_mut(kind).map(std::mem::take) {
            None => 0,
            Some(0) => {
                repeated.remove(kind);
                0
            }
            Some(count) => count,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repetitions_are_counted_until_a_period_without_any() {
        let counts = WarningCounts::default();
        assert_eq!(counts.add("empty trajectory"), Some("empty trajectory".to_string()));
        assert_eq!(counts.add("empty trajectory"), None);
        assert_eq!(counts.add("empty trajectory"), None);
        assert_eq!(counts.end_period("empty trajectory"), 2);
        assert_eq!(counts.add("empty trajectory"), None, "the next period has begun");
        assert_eq!(counts.end_period("empty trajectory"), 1);
        assert_eq!(counts.end_period("empty trajectory"), 0);
        assert_eq!(counts.add("empty trajectory"), Some("empty trajectory".to_string()));
    }

    #[test]
    fn kinds_beyond_the_bound_are_counted_as_one() {
        let counts = WarningCounts::default();
        let begun = (0..1000).filter_map(|index| counts.add(&format!("point {index}"))).collect::<Vec<_>>();
        assert_eq!(begun.len(), MAX_KINDS + 1);
        assert_eq!(begun.last().map(String::as_str), Some(OTHERS));
        assert_eq!(counts.end_period(OTHERS), 1000 - MAX_KINDS as u64 - 1);
    }
}
