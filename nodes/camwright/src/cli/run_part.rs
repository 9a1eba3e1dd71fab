// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! State of the part when a job ends before its time.

use camwright_msgs::camwright_msgs::action::RunJobFeedback;
use serde_json::{Value, json};

/// Lobes that a job has begun, from its feedback.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct PartProgress {
    /// Lobes in the order of the job.
    begun: Vec<String>,
    /// Turns done on the last of them, and all turns.
    turns: (f64, f64),
    lobes: usize,
}

impl PartProgress {
    pub(super) fn receive(&mut self, feedback: &RunJobFeedback) {
        self.lobes = usize::try_from(feedback.lobe_count).unwrap_or(usize::MAX);
        // A lobe is begun by its first turn, not by the way to it.
        if feedback.lobe.is_empty() || feedback.turns <= 0.0 {
            return;
        }
        if self.begun.last() != Some(&feedback.lobe) {
            self.begun.push(feedback.lobe.clone());
        }
        self.turns = (feedback.turn, feedback.turns);
    }

    /// The finished lobes, and the one in work.
    fn split(&self) -> (&[String], Option<&str>) {
        match self.begun.split_last() {
            Some((last, before)) if self.turns.0 < self.turns.1 => (before, Some(last)),
            _ => (&self.begun, None),
        }
    }

    /// Lobe to begin with on the same part; none if the job has not begun one.
    pub(super) fn next_lobe(&self) -> Option<String> {
        let (finished, current) = self.split();
        let number = finished.len() + 1;
        current
            .map(str::to_owned)
            .or_else(|| (!finished.is_empty() && number <= self.lobes).then(|| number.to_string()))
    }

    /// State of the part in words.
    pub(super) fn text(&self) -> String {
        let (finished, current) = self.split();
        if self.begun.is_empty() {
            return "no lobe begun".to_owned();
        }
        let mut texts = Vec::new();
        if !finished.is_empty() {
            texts.push(format!("finished {}", finished.join(", ")));
        }
        if let Some(lobe) = current {
            texts.push(format!("{lobe} ended in turn {:.1} of {:.0}", self.turns.0, self.turns.1));
        }
        let rest = self.lobes.saturating_sub(self.begun.len());
        if rest > 0 {
            texts.push(format!("{rest} not begun"));
        }
        format!("unfinished: {}", texts.join("; "))
    }

    pub(super) fn json(&self) -> Value {
        let (finished, current) = self.split();
        json!({
            "finished": finished,
            "unfinished": current,
            "turn": current.map(|_| self.turns.0),
            "turns": current.map(|_| self.turns.1),
            "lobes": self.lobes,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(feedback: &[(&str, f64, f64)]) -> PartProgress {
        let mut part = PartProgress::default();
        for (lobe, turn, turns) in feedback {
            part.receive(&RunJobFeedback {
                lobe: (*lobe).to_owned(),
                lobe_count: 4,
                turn: *turn,
                turns: *turns,
                ..RunJobFeedback::default()
            });
        }
        part
    }

    #[test]
    fn the_part_is_described_by_its_lobes() {
        let none = after(&[("", 0.0, 0.0), ("I1", 0.0, 0.0)]);
        assert_eq!((none.text().as_str(), none.next_lobe()), ("no lobe begun", None));
        let second = after(&[("I1", 0.5, 12.0), ("I1", 11.9, 12.0), ("E1", 0.0, 0.0), ("E1", 3.25, 12.0)]);
        assert_eq!(second.text(), "unfinished: finished I1; E1 ended in turn 3.2 of 12; 2 not begun");
        assert_eq!(second.next_lobe().as_deref(), Some("E1"));
        let between = after(&[("I1", 0.5, 12.0), ("I1", 12.0, 12.0), ("E1", 0.0, 0.0)]);
        assert_eq!(between.text(), "unfinished: finished I1; 3 not begun");
        assert_eq!(between.next_lobe().as_deref(), Some("2"));
    }
}
