//! The README's alarm table is the machine's.

use camwright::machine::alarm::AlarmKind;
use std::path::Path;

#[test]
fn every_alarm_is_in_the_readme() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md");
    let readme = std::fs::read_to_string(path).expect("the README");
    for kind in AlarmKind::ALL {
        let entry = kind.entry();
        let base = match kind.axis() {
            Some(axis) => entry.number - u16::try_from(axis.index()).expect("three axes"),
            None => entry.number,
        };
        let number = if kind.axis().is_some() { format!("| {base} … {} |", base + 2) } else { format!("| {base} |") };
        let row = readme.lines().find(|line| line.starts_with(&number));
        let row = row.unwrap_or_else(|| panic!("{number} {} is not in the README", entry.name));
        assert!(row.contains(entry.name) && row.contains(entry.remedy), "{row}: {} {}", entry.name, entry.remedy);
    }
}
