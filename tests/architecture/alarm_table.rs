//! The alarm tables of `docs/reference/alarms.md` and of the alarm message are generated from the table of the core.
//!
//! `CAMWRIGHT_WRITE_REFERENCE=1 cargo test -p camwright_nodes --test architecture alarm_table` writes them anew.

use camwright::machine::alarm::{AlarmEntry, AlarmKind, AlarmSeverity};
use std::path::Path;

/// One line for each kind, in the order of the numbers; a kind that each axis has is one line with a range of numbers.
fn lines(dash: &str, line: impl Fn(&str, &AlarmEntry, &str) -> String) -> Vec<String> {
    let kinds = AlarmKind::ALL.into_iter().filter(|kind| kind.axis().is_none_or(|axis| axis.index() == 0));
    kinds
        .map(|kind| {
            let entry = kind.entry();
            let numbers = match kind.axis() {
                Some(_) => format!("{}{dash}{}", entry.number, entry.number + 2),
                None => entry.number.to_string(),
            };
            let reaction = match entry.severity {
                AlarmSeverity::Warning => "warning",
                AlarmSeverity::Stop => "stop",
                AlarmSeverity::PowerOff => "power off",
            };
            line(&numbers, &entry, reaction)
        })
        .collect()
}

/// Compares the numbered lines of a file, from a heading on, with the table; or writes them.
fn assert_generated(path: &str, heading: &str, prefix: &str, table: &[String]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
    let text = std::fs::read_to_string(&path).expect("a file of the repository");
    let start = text.find(heading).expect("the heading of the table");
    let is_row =
        |line: &str| line.strip_prefix(prefix).is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
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
    let rows = lines(" … ", |numbers, AlarmEntry { name, remedy, .. }, reaction| {
        format!("| {numbers} | {name} | {reaction} | {remedy} |")
    });
    assert_generated("docs/reference/alarms.md", "# Alarms", "| ", &rows);
}

#[test]
fn the_table_of_the_message_is_generated() {
    let rows = lines("-", |numbers, AlarmEntry { name, remedy, .. }, reaction| {
        format!("# {numbers} {name} ({reaction}): {remedy}")
    });
    assert_generated("msgs/msg/Alarm.msg", "# Numbers", "# ", &rows);
}
