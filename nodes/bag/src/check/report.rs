// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Report of a check, for the operator and for scripts.

use crate::json::quoted;
use std::path::Path;

/// Severity of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum BagSeverity {
    /// Worth knowing: no reader loses a message by it that knows how to go on, and some can do less with the bag.
    Warning,
    /// Damaged, incomplete, or not what rosbag2 writes.
    Error,
}

/// Something found in a bag.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BagFinding {
    /// Severity.
    pub severity: BagSeverity,
    /// The file, relative to the bag where it is within.
    pub place: String,
    /// Text of the finding, with the actual and the expected value.
    pub text: String,
}

/// Name of a file, as a place in a finding.
pub(super) fn place_of(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}

/// Maximum number of findings in a report; a file may have a fault in each of millions of records.
const MAX_FINDINGS: usize = 1000;

/// Report of a check.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct BagReport {
    /// In the order they were found.
    pub findings: Vec<BagFinding>,
    /// Number of further findings, and the worst of them.
    pub more: (u64, Option<BagSeverity>),
    pub message_count: u64,
    pub topic_count: usize,
}

impl BagReport {
    /// The worst finding; none when the bag is clean.
    #[must_use]
    pub fn worst(&self) -> Option<BagSeverity> {
        self.findings.iter().map(|f| f.severity).max().max(self.more.1)
    }

    #[must_use]
    pub fn to_text(&self) -> String {
        let verdict = match self.worst() {
            None => "CLEAN",
            Some(BagSeverity::Warning) => "READABLE, WITH WARNINGS",
            Some(BagSeverity::Error) => "DAMAGED",
        };
        let mut text = format!("{verdict}: {} messages on {} topics\n", self.message_count, self.topic_count);
        for finding in &self.findings {
            let word = match finding.severity {
                BagSeverity::Warning => "warning",
                BagSeverity::Error => "error",
            };
            text.push_str(&format!("{word}: {}: {}\n", finding.place, finding.text));
        }
        if self.more.0 > 0 {
            text.push_str(&format!("and {} more\n", self.more.0));
        }
        text
    }

    /// For scripts: one JSON object.
    #[must_use]
    pub fn to_json(&self) -> String {
        let findings: Vec<String> = self
            .findings
            .iter()
            .map(|f| {
                let severity = if f.severity == BagSeverity::Error { "error" } else { "warning" };
                let (place, text) = (quoted(&f.place), quoted(&f.text));
                format!("{{\"severity\":\"{severity}\",\"place\":{place},\"text\":{text}}}")
            })
            .collect();
        format!(
            "{{\"message_count\":{},\"topic_count\":{},\"more_findings\":{},\"findings\":[{}]}}",
            self.message_count,
            self.topic_count,
            self.more.0,
            findings.join(",")
        )
    }

    pub(super) fn error(&mut self, place: impl Into<String>, text: impl Into<String>) {
        self.find(BagSeverity::Error, place.into(), text.into());
    }

    pub(super) fn warning(&mut self, place: impl Into<String>, text: impl Into<String>) {
        self.find(BagSeverity::Warning, place.into(), text.into());
    }

    fn find(&mut self, severity: BagSeverity, place: String, text: String) {
        if self.findings.len() < MAX_FINDINGS {
            self.findings.push(BagFinding { severity, place, text });
        } else {
            self.more = (self.more.0 + 1, self.more.1.max(Some(severity)));
        }
    }
}

/// The same thing found again and again: how often, and where first. A damaged bag may have it in every message.
#[derive(Debug, Default)]
pub(super) struct FindingCount {
    count: u64,
    first: String,
}

impl FindingCount {
    pub(super) fn note(&mut self, first: impl FnOnce() -> String) {
        if self.count == 0 {
            self.first = first();
        }
        self.count += 1;
    }

    /// `1 message what: which`, or `7 messages what, first which`; none where nothing was noted.
    pub(super) fn sentence(&self, what: &str) -> Option<String> {
        match self.count {
            0 => None,
            1 => Some(format!("1 message {what}: {}", self.first)),
            count => Some(format!("{count} messages {what}, first {}", self.first)),
        }
    }

    /// The same of something else than messages, with the words for one and for many.
    pub(super) fn sentence_for(&self, one: &str, many: &str) -> Option<String> {
        match self.count {
            0 => None,
            1 => Some(format!("1 {one}, {}", self.first)),
            count => Some(format!("{count} {many}, first {}", self.first)),
        }
    }
}
