// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! YAML in the layout of rosbag2: two spaces for each level, no line end after the last line.

use super::json::quoted;
use std::fmt::Display;

/// Writer of one document.
#[derive(Debug)]
pub(super) struct YamlWriter {
    text: String,
    indent: usize,
    /// The next line begins an item of a list.
    begins_item: bool,
}

impl YamlWriter {
    /// Writer whose lines all stand behind so many spaces.
    pub(super) fn new(indent: usize) -> Self {
        Self { text: String::new(), indent, begins_item: false }
    }

    pub(super) fn finish(self) -> String {
        self.text
    }

    fn line(&mut self, line: &str) {
        if !self.text.is_empty() {
            self.text.push('\n');
        }
        let dash = if std::mem::take(&mut self.begins_item) { "- " } else { "" };
        self.text.extend(std::iter::repeat_n(' ', self.indent - dash.len()));
        self.text.push_str(dash);
        self.text.push_str(line);
    }

    /// Writes a key with a value that stands as it is.
    pub(super) fn value(&mut self, key: &str, value: impl Display) {
        self.line(&format!("{key}: {value}"));
    }

    /// Writes a key with a text.
    pub(super) fn text(&mut self, key: &str, text: &str) {
        self.value(key, scalar(text));
    }

    /// Writes a key with a mapping.
    pub(super) fn map(&mut self, key: &str, write: impl FnOnce(&mut Self)) {
        self.line(&format!("{key}:"));
        self.indent += 2;
        write(self);
        self.indent -= 2;
    }

    /// Writes a key with a list of mappings.
    pub(super) fn list<T>(&mut self, key: &str, items: &[T], write: impl FnMut(&mut Self, &T)) {
        if items.is_empty() {
            return self.value(key, "[]");
        }
        self.map(key, |yaml| yaml.items(items, write));
    }

    /// Writes a list of mappings without a key.
    pub(super) fn items<T>(&mut self, items: &[T], mut write: impl FnMut(&mut Self, &T)) {
        self.indent += 2;
        for item in items {
            self.begins_item = true;
            write(self, item);
        }
        self.indent -= 2;
    }

    /// Writes a key with a list of texts.
    pub(super) fn texts(&mut self, key: &str, texts: &[String]) {
        self.list(key, texts, |yaml, text| yaml.line(&scalar(text)));
    }
}

/// A text as YAML reads it back: plain where no reader takes it for anything else.
pub(super) fn scalar(text: &str) -> String {
    let starts_plain = text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '/');
    let is_plain = text.chars().all(|c| c.is_ascii_alphanumeric() || "/_.-".contains(c));
    // Readers of YAML 1.1 take these for truth values and for no value.
    let is_word =
        matches!(text.to_ascii_lowercase().as_str(), "y" | "n" | "yes" | "no" | "on" | "off" | "true" | "false")
            || text.eq_ignore_ascii_case("null");
    if starts_plain && is_plain && !is_word { text.to_owned() } else { quoted(text) }
}
