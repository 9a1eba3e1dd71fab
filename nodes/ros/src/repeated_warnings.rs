//! Warnings that come again and again: the first at once, the others as a count.

use std::{
    collections::BTreeMap,
    sync::{Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use super::node::Node;

/// Time for which repetitions are counted before they are reported.
const PERIOD: Duration = Duration::from_secs(5);

/// Kinds of warnings that are told apart at a time. Further ones are counted as one.
const MAX_KINDS: usize = 64;

/// The kind that stands for all beyond [`MAX_KINDS`].
const OTHERS: &str = "further refusals";

/// Counts of repetitions in the current period, by kind.
#[derive(Debug, Default)]
pub(super) struct RepeatedWarnings {
    repeated: Mutex<BTreeMap<String, u64>>,
}

impl RepeatedWarnings {
    fn repeated(&self) -> MutexGuard<'_, BTreeMap<String, u64>> {
        self.repeated.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether a warning of this kind has to be written now. If not, it is counted.
    pub(super) fn is_first(&self, node: &Node, kind: &str) -> bool {
        let Some(kind) = self.count(kind) else { return false };
        report_later(node, kind);
        true
    }

    /// The kind that begins a period, or `None` when the warning was counted.
    fn count(&self, kind: &str) -> Option<String> {
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

fn report_later(node: &Node, kind: String) {
    let weak = node.downgrade();
    node.after(PERIOD, move || {
        let Some(node) = weak.upgrade() else { return };
        let count = node.warnings().end_period(&kind);
        if count > 0 {
            let seconds = PERIOD.as_secs();
            node.logger().warn(&format!("{kind}: {count} more times in the last {seconds} s"));
            report_later(&node, kind);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repetitions_are_counted_until_a_period_without_any() {
        let warnings = RepeatedWarnings::default();
        assert_eq!(warnings.count("empty trajectory"), Some("empty trajectory".to_string()));
        assert_eq!(warnings.count("empty trajectory"), None);
        assert_eq!(warnings.count("empty trajectory"), None);
        assert_eq!(warnings.end_period("empty trajectory"), 2);
        assert_eq!(warnings.count("empty trajectory"), None, "the next period has begun");
        assert_eq!(warnings.end_period("empty trajectory"), 1);
        assert_eq!(warnings.end_period("empty trajectory"), 0);
        assert_eq!(warnings.count("empty trajectory"), Some("empty trajectory".to_string()));
    }

    #[test]
    fn kinds_beyond_the_bound_are_counted_as_one() {
        let warnings = RepeatedWarnings::default();
        let begun = (0..1000).filter_map(|index| warnings.count(&format!("point {index}"))).collect::<Vec<_>>();
        assert_eq!(begun.len(), MAX_KINDS + 1);
        assert_eq!(begun.last().map(String::as_str), Some(OTHERS));
        assert_eq!(warnings.end_period(OTHERS), 1000 - MAX_KINDS as u64 - 1);
    }
}
