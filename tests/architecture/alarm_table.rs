//! The alarm tables of the README and of the alarm message are the machine's.

use camwright::machine::alarm::{AlarmKind, Severity};
use std::path::Path;

/// Numbers, name, reaction and remedy of every kind, in the order of the numbers.
fn rows() -> Vec<(String, String, &'static str, &'static str, &'static str)> {
    let mut rows = Vec::new();
    for kind in AlarmKind::ALL {
        let entry = kind.entry();
        if kind.axis().is_some_and(|axis| axis.index() > 0) {
            continue;
        }
        let last = entry.number + 2;
        let (dots, dash) = match kind.axis() {
            Some(_) => (format!("{} … {last}", entry.number), format!("{}-{last}", entry.number)),
            None => (entry.number.to_string(), entry.number.to_string()),
        };
        let reaction = match entry.severity {
            Severity::Warning => "warning",
            Severity::Stop => "stop",
            Severity::PowerOff => "power off",
        };
        rows.push((dots, dash, entry.name, reaction, entry.remedy));
    }
    rows
}

fn text(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path))
        .expect("a file of the repository")
}

#[test]
fn the_table_of_the_readme_is_the_machines() {
    let numbered =
        |line: &&str| line.strip_prefix("| ").is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
    let readme = text("README.md");
    let alarms = readme.split("## Alarms").nth(1).expect("a chapter of alarms");
    let told: Vec<&str> = alarms.lines().filter(numbered).collect();
    let rows: Vec<String> = rows()
        .into_iter()
        .map(|(number, _, name, reaction, remedy)| format!("| {number} | {name} | {reaction} | {remedy} |"))
        .collect();
    assert_eq!(told, rows);
}

#[test]
fn the_table_of_the_message_is_the_machines() {
    let message = text("msgs/msg/Alarm.msg");
    let numbered =
        |line: &&str| line.strip_prefix("# ").is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
    let told: Vec<&str> = message.lines().filter(numbered).collect();
    let rows: Vec<String> = rows()
        .into_iter()
        .map(|(_, number, name, reaction, remedy)| format!("# {number} {name} ({reaction}): {remedy}"))
        .collect();
    assert_eq!(told, rows);
}
