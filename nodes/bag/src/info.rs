// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Content of a bag, for the operator and for scripts.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Duration;

use super::json::quoted;
use super::{Bag, BagError};
pub use camwright_threads::system_time::utc;

/// The figures of one topic.
#[derive(Debug, Clone, PartialEq)]
pub struct BagTopic {
    pub name: String,
    pub type_name: String,
    pub message_count: u64,
}

/// The figures of a bag.
#[derive(Debug, Clone, PartialEq)]
pub struct BagInfo {
    pub path: String,
    /// Size of its storage files (B).
    pub bytes: u64,
    /// Every storage file was closed properly.
    pub is_closed: bool,
    pub files: Vec<String>,
    /// Smallest and largest log time (ns since 1970).
    pub log_times_ns: Option<(u64, u64)>,
    /// Messages over all topics.
    pub message_count: u64,
    /// Each topic, by name.
    pub topics: Vec<BagTopic>,
    /// Custom data of the recorder.
    pub custom_data: Vec<(String, String)>,
}

impl BagInfo {
    /// Reads the figures of the bag at `path`.
    ///
    /// # Errors
    /// As [`Bag::open`].
    pub fn read(path: &Path) -> Result<Self, BagError> {
        let bag = Bag::open(path)?;
        let mut topics: Vec<BagTopic> = bag
            .topics()
            .iter()
            .zip(bag.message_counts())
            .map(|(t, &message_count)| BagTopic { name: t.name.clone(), type_name: t.type_name.clone(), message_count })
            .collect();
        topics.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(Self {
            path: path.display().to_string(),
            bytes: bag.files().iter().map(|f| f.bytes).sum(),
            is_closed: bag.files().iter().all(|f| f.is_closed),
            files: bag.files().iter().map(|f| f.path.display().to_string()).collect(),
            log_times_ns: bag.log_times_ns(),
            message_count: bag.files().iter().fold(0, |sum: u64, f| sum.saturating_add(f.message_count)),
            topics,
            custom_data: bag.custom_data().iter().map(|(k, v)| (k.clone(), v.clone())).collect(),
        })
    }

    /// Time between the first and the last message.
    #[must_use]
    pub fn duration(&self) -> Duration {
        self.log_times_ns.map_or(Duration::ZERO, |(first, last)| Duration::from_nanos(last - first))
    }

    /// Outcome, times and topics in lines of 80 columns; with `details` also types, files and everything the recorder wrote.
    #[must_use]
    pub fn to_text(&self, details: bool) -> String {
        let mut t = String::new();
        let duration_s = self.duration().as_secs_f64();
        let custom = |key: &str| self.custom_data.iter().find(|(k, _)| k == key).map(|(_, value)| readable(value));
        let outcome = match (self.is_closed, custom("camwright.outcome")) {
            (false, _) => "NOT CLOSED".to_owned(),
            (true, Some(outcome)) => outcome.to_uppercase(),
            (true, None) => "CLOSED".to_owned(),
        };
        let lost = custom("camwright.lost_total").map_or_else(String::new, |lost| format!(", {lost} lost"));
        let megabytes = self.bytes as f64 / 1e6;
        // Writing to a String cannot fail.
        let _ = writeln!(t, "{outcome}: {} messages{lost}, {duration_s:.3} s, {megabytes:.1} MB", self.message_count);
        if !self.is_closed {
            let _ = writeln!(t, "the recording was killed; the list holds the intact part");
        }
        if let Some((first, last)) = self.log_times_ns {
            let _ = writeln!(t, "time      {} to {}", utc(first), utc(last));
        }
        let _ = writeln!(t, "bag       {}", self.path);
        if details {
            let _ = writeln!(t, "files     {}", self.files.join(", "));
            for (key, value) in &self.custom_data {
                let _ = writeln!(t, "{}  {}", readable(key), readable(value));
            }
        }
        let _ = writeln!(t, " messages      per s  topic");
        for topic in &self.topics {
            let rate = if duration_s > 0.0 { topic.message_count as f64 / duration_s } else { 0.0 };
            let kind = if details { format!("  {}", readable(&topic.type_name)) } else { String::new() };
            let _ = writeln!(t, "{:>9}  {rate:>9.1}  {}{kind}", topic.message_count, readable(&topic.name));
        }
        t
    }

    /// For scripts: one JSON object.
    #[must_use]
    pub fn to_json(&self) -> String {
        let list = |items: Vec<String>| items.join(",");
        let (first, last) =
            self.log_times_ns.map_or(("null".into(), "null".into()), |(a, b)| (a.to_string(), b.to_string()));
        format!(
            "{{\"path\":{},\"files\":[{}],\"bytes\":{},\"closed\":{},\"starting_time_ns\":{first},\"end_time_ns\":{last},\
             \"duration_ns\":{},\"message_count\":{},\"custom_data\":{{{}}},\"topics\":[{}]}}",
            quoted(&self.path),
            list(self.files.iter().map(|f| quoted(f)).collect()),
            self.bytes,
            self.is_closed,
            self.duration().as_nanos(),
            self.message_count,
            list(self.custom_data.iter().map(|(k, v)| format!("{}:{}", quoted(k), quoted(v))).collect()),
            list(
                self.topics
                    .iter()
                    .map(|t| format!(
                        "{{\"name\":{},\"type\":{},\"message_count\":{}}}",
                        quoted(&t.name),
                        quoted(&t.type_name),
                        t.message_count
                    ))
                    .collect()
            ),
        )
    }
}

/// Longest name or value that is printed whole (characters): names of ROS 2 end at 255.
const MAX_SHOWN: usize = 255;

/// A text of the bag for a terminal: without control characters, and cut off where it is longer than any name.
fn readable(text: &str) -> String {
    let printed = |c: char| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c };
    let shown: String = text.chars().take(MAX_SHOWN).map(printed).collect();
    match text.chars().count() {
        0..=MAX_SHOWN => shown,
        count => format!("{shown}… ({count} characters)"),
    }
}

#[cfg(test)]
mod tests {
    use super::{BagInfo, BagTopic};

    #[test]
    fn names_of_any_length_and_with_any_character_are_printed() {
        let name = format!("/{}\u{1b}[2J", "x".repeat(70_000));
        let topics = vec![BagTopic { name, type_name: "y".repeat(70_000), message_count: 1 }];
        let info = BagInfo {
            path: "bag".into(),
            bytes: 1,
            is_closed: true,
            files: Vec::new(),
            log_times_ns: None,
            message_count: 1,
            topics,
            custom_data: vec![("k".into(), "v\u{7}".into())],
        };
        let text = info.to_text(true);
        assert!(
            text.len() < 2000 && text.contains("(70005 characters)") && text.contains("(70000 characters)"),
            "{text}"
        );
        assert!(!text.contains(['\u{1b}', '\u{7}']), "{text:?}");
        // A script gets all of it.
        assert!(info.to_json().len() > 140_000);
    }
}
