// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The alarm tables of `docs/reference/alarms.md` and of the alarm message are generated from the table of the core.
//!
//! `CAMWRIGHT_WRITE_REFERENCE=1 cargo test -p camwright_nodes --test architecture alarm_table` writes them anew.

use camwright::machine::alarm::{AlarmEntry, AlarmKind, AlarmSeverity};
use std::path::Path;

fn reaction(severity: AlarmSeverity) -> &'static str {
    match severity {
        AlarmSeverity::Warning => "warning",
        AlarmSeverity::Stop => "stop",
        AlarmSeverity::PowerOff => "power off",
    }
}

/// Compares the rows of a file, from a heading on, with the table; or writes them.
fn assert_generated(path: &str, heading: &str, is_row: impl Fn(&str) -> bool, table: &[String]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
    let text = std::fs::read_to_string(&path).expect("a file of the repository");
    let start = text.find(heading).expect("the heading of the table");
    let rows: Vec<&str> = text[start..].lines().filter(|line| is_row(line)).collect();
    if std::env::var_os("CAMWRIGHT_WRITE_REFERENCE").is_some() {
        let old = rows.join("\n");
        assert!(text.contains(&old), "the rows of the table are not in one piece");
        std::fs::write(&path, text.replace(&old, &table.join("\n"))).expect("a file that can be written");
        return;
    }
    assert_eq!(rows, table, "write it anew: see the head of this file");
}

#[test]
fn the_table_of_the_document_is_generated() {
    // A kind that each axis has is one row with a range of numbers.
    let kinds = AlarmKind::ALL.into_iter().filter(|kind| kind.axis().is_none_or(|axis| axis.index() == 0));
    let row = |kind: AlarmKind| {
        let AlarmEntry { number, name, severity, remedy, .. } = kind.entry();
        let numbers = kind.axis().map_or_else(|| number.to_string(), |_| format!("{number} … {}", number + 2));
        format!("| {numbers} | {name} | {} | {remedy} |", reaction(severity))
    };
    let is_row =
        |line: &str| line.strip_prefix("| ").is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
    assert_generated("docs/reference/alarms.md", "# Alarms", is_row, &kinds.map(row).collect::<Vec<_>>());
}

#[test]
fn the_table_of_the_message_is_generated() {
    let row = |kind: AlarmKind| {
        let AlarmEntry { number, name, severity, remedy, .. } = kind.entry();
        let axis = kind.axis().map_or_else(String::new, |axis| format!("_{}", axis.joint().trim_end_matches("_axis")));
        let constant = format!("{name}{axis}").to_uppercase().replace(|c: char| !c.is_ascii_alphanumeric(), "_");
        format!("uint16 {} = {number} # {}; {remedy}", constant.replace("__", "_"), reaction(severity))
    };
    let rows: Vec<String> =
        std::iter::once("uint16 NONE = 0".to_owned()).chain(AlarmKind::ALL.into_iter().map(row)).collect();
    let is_row = |line: &str| line.starts_with("uint16 ") && line.contains('=');
    assert_generated("msgs/msg/Alarm.msg", "# Numbers", is_row, &rows);
}
