// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Bags with one fault each: `camwright bag check` names every one, and `bags/FAULTS.md` lists the results of the other
//! readers.

#![allow(clippy::print_stdout, reason = "the table is printed for whoever runs it")]

use crate::bag_judges;
mod draft;
mod hostile;
use crate::support;
mod table;

use std::path::{Path, PathBuf};
use std::process::Command;

use camwright_bag::check::{BagFinding, BagSeverity, check};
use draft::Draft;
use serde_json::Value;
use support::{Domain, repository};
use table::Fault;

/// Set where the table is to be written, not only printed.
const WRITE: &str = "CAMWRIGHT_WRITE_FAULTS";

fn directory(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("bag-faults-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&path).expect("the target directory is writable");
    path
}

fn exit_code(bag: &Path) -> Option<i32> {
    let output = Command::new(env!("CARGO_BIN_EXE_camwright")).args(["bag", "check"]).arg(bag).output();
    output.expect("it starts").status.code()
}

/// The finding that names a fault; what the check says instead fails the test.
fn found(fault: &Fault, bag: &Path) -> BagFinding {
    let report = check(bag).expect("there is a bag");
    let is_it = |finding: &&BagFinding| {
        finding.severity == fault.severity && finding.place == fault.place && finding.text.contains(fault.text)
    };
    let finding = report.findings.iter().find(is_it);
    finding.unwrap_or_else(|| panic!("{}: not {:?} but\n{}", fault.what, fault.text, report.to_text())).clone()
}

/// The first two columns of a line of the table.
fn judged_by_us(fault: &Fault, bag: &Path) -> String {
    let BagFinding { severity, place, text } = found(fault, bag);
    let word = if severity == BagSeverity::Error { "error" } else { "warning" };
    let text = text.replace(&format!("{}/", bag.display()), "").replace(&bag.display().to_string(), "run");
    let text = masked(&text.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', "\\|"));
    format!("| {} | {word}: {place}: {text} |", fault.what)
}

/// Without what changes with every message definition: check sums, places in the file, hashes; and without long times.
fn masked(text: &str) -> String {
    let is_sum = |word: &str| word.len() == 8 && word.bytes().all(|b| b.is_ascii_hexdigit() && !b.is_ascii_lowercase());
    let is_long = |word: &str| word.len() > 3 && word.bytes().all(|b| b.is_ascii_digit());
    let mask = |word: &str| match word {
        hash if hash.starts_with("RIHS01_") => "RIHS01_…".to_owned(),
        word if is_sum(word) || is_long(word) => "…".to_owned(),
        word => word.to_owned(),
    };
    let (mut masked, mut word) = (String::new(), String::new());
    for letter in text.chars().chain([' ']) {
        if letter.is_ascii_alphanumeric() || letter == '_' {
            word.push(letter);
        } else {
            masked.push_str(&mask(&std::mem::take(&mut word)));
            masked.push(letter);
        }
    }
    masked.trim_end().to_owned()
}

#[test]
fn every_fault_is_named_with_its_place_and_a_good_bag_is_clean() {
    let directory = directory("check");
    for (name, draft) in [("one", Draft::good()), ("two", Draft::in_two_files())] {
        draft.write(&directory.join(name));
        let bag = directory.join(name).join("run");
        assert_eq!(check(&bag).expect("there is a bag").findings, [], "{name}");
        assert_eq!(exit_code(&bag), Some(0), "{name}");
    }
    let document = std::fs::read_to_string(repository().join("bags/FAULTS.md")).expect("it is in the repository");
    let mut lines = document.lines().filter(|line| line.starts_with("| ")).skip(1);
    for (number, fault) in table::all().iter().enumerate() {
        let at = directory.join(number.to_string());
        (fault.make)().write(&at);
        let bag = at.join("run");
        let line = judged_by_us(fault, &bag);
        let documented = lines.next().unwrap_or_default();
        assert!(documented.starts_with(&line), "bags/FAULTS.md says\n{documented}\nand the check\n{line}");
        let expected = if fault.severity == BagSeverity::Error { 2 } else { 1 };
        assert_eq!(exit_code(&bag), Some(expected), "{}", fault.what);
    }
    assert_eq!(lines.next(), None, "bags/FAULTS.md has a line too many");
    std::fs::remove_dir_all(directory).expect("it is ours");
}

/// Commands that read bags.
const COMMANDS: [&[&str]; 7] = [
    &["bag", "info"],
    &["bag", "check"],
    &["bag", "recover", "--into", "recovered"],
    &["bag", "export", "--into", "csv"],
    &["bag", "export", "--to", "parquet", "--into", "parquet"],
    &["bag", "report", "--out", "report.html"],
    &["replay", "--against"],
];

#[test]
fn a_hostile_bag_is_read_or_refused_in_little_memory_and_every_command_ends() {
    let directory = directory("hostile");
    // Of addresses, of which a program takes more than of memory (KiB); and a minute, which none needs.
    let script = "ulimit -v 3000000; exec timeout 60 \"$@\"";
    for (number, (what, draft)) in hostile::all().iter().enumerate() {
        let at = directory.join(number.to_string());
        draft.write(&at);
        for command in COMMANDS {
            let mut shell = Command::new("sh");
            shell.args(["-c", script, "sh", env!("CARGO_BIN_EXE_camwright")]).args(command).arg("run").current_dir(&at);
            let output = shell.output().expect("there is a shell");
            let stderr = String::from_utf8_lossy(&output.stderr);
            // Ended by itself, with what it says of the bag: no panic (101), no signal, no time that ran out (124).
            assert!(matches!(output.status.code(), Some(0..=3)), "{what}: {command:?}: {}: {stderr}", output.status);
            assert!(!stderr.contains("panicked"), "{what}: {command:?}: {stderr}");
        }
    }
    std::fs::remove_dir_all(directory).expect("it is ours");
}

/// Set to how many changed bags are to be read; without it 200 are.
const MUTATIONS: &str = "CAMWRIGHT_MUTATIONS";

#[test]
fn a_bag_with_some_bytes_changed_is_read_or_refused_in_every_way() {
    let directory = directory("mutations");
    let wanted = std::env::var(MUTATIONS).map_or(200, |text| text.parse().expect("a number of bags"));
    for seed in 0..wanted {
        let at = directory.join(seed.to_string());
        let mut draft = if seed % 3 == 0 { Draft::in_two_files() } else { Draft::good() };
        // With check sums most changes go no further than them.
        if seed % 4 > 0 {
            draft.options = draft::without_crc;
        }
        draft.write(&at);
        let names = ["run_0.mcap", "run_0.mcap", "run_0.mcap", "run_0.mcap", "metadata.yaml"];
        let file = at.join("run").join(names[usize::try_from(seed % 5).expect("few")]);
        let mut bytes = std::fs::read(&file).expect("it was written");
        hostile::mutate(&mut bytes, &mut hostile::Seeded::new(seed));
        std::fs::write(&file, bytes).expect("the directory is ours");
        if let Err(panic) = std::panic::catch_unwind(|| hostile::read_in_every_way(&at)) {
            println!("bag number {seed} of {}, which is left there", at.display());
            std::panic::resume_unwind(panic);
        }
        std::fs::remove_dir_all(&at).expect("it is ours");
    }
    println!("{wanted} changed bags were read");
    std::fs::remove_dir_all(directory).expect("it is ours");
}

/// Short description of a reader's verdict on a bag.
fn description(verdict: &Value, messages: usize) -> String {
    let read = verdict["messages"].as_u64().unwrap_or(0);
    match verdict["refusal"].as_str() {
        Some(reason) if reason.starts_with("Unsupported compression") => "not tested: its node has no Zstandard".into(),
        Some(reason) => {
            let mut reason = masked(reason.lines().next().unwrap_or_default()).replace('|', "\\|");
            if let Some((cut, _)) = reason.char_indices().nth(60) {
                reason.truncate(cut);
                reason.push('…');
            }
            format!("yes: {reason}")
        }
        None if read < messages as u64 => format!("reads {read} of {messages} messages and says nothing"),
        None => "no".into(),
    }
}

#[test]
#[ignore = "asks every reader about every fault; prints the table of bags/FAULTS.md, and writes it with CAMWRIGHT_WRITE_FAULTS=1"]
fn the_table_of_faults_and_of_who_finds_them() {
    let directory = directory("table");
    let faults = table::all();
    let drafts: Vec<Draft> = faults.iter().map(|fault| (fault.make)()).collect();
    let mut bags = Vec::new();
    for (number, draft) in drafts.iter().enumerate() {
        let at = directory.join(number.to_string());
        draft.write(&at);
        bags.push(at.join("run"));
    }
    let python = bag_judges::python_verdicts(&bags, &Domain::reserve()).expect("the peers are not skipped");
    let foxglove = bag_judges::foxglove_verdicts(&bags).expect("node is installed");
    let mut text = String::from(HEAD);
    let mut seen = [0; 3];
    for (number, (fault, draft)) in faults.iter().zip(&drafts).enumerate() {
        let verdicts = [&python[number]["rosbags"], &python[number]["mcap"], &foxglove[number]];
        let columns: Vec<String> = verdicts.iter().map(|verdict| description(verdict, draft.count())).collect();
        columns.iter().zip(&mut seen).for_each(|(column, seen)| *seen += usize::from(column.starts_with("yes")));
        text.push_str(&format!("{} {} |\n", judged_by_us(fault, &bags[number]), columns.join(" | ")));
    }
    let [rosbags, mcap, foxglove] = seen;
    text.push_str(&format!(
        "\nOf {count} faults: `camwright bag check` {count}, rosbags {rosbags}, mcap {mcap}, Foxglove's reader {foxglove}.\n",
        count = faults.len()
    ));
    println!("{text}");
    if std::env::var_os(WRITE).is_some() {
        std::fs::write(repository().join("bags/FAULTS.md"), text).expect("the repository is writable");
    }
    std::fs::remove_dir_all(directory).expect("it is ours");
}

const HEAD: &str = "# Faults of bags, and the readers that find them

Each row is a bag with one fault. The second column is the finding of `camwright bag check`. An error ends it with exit code 2, a warning with 1:
after a warning every good reader still gets every message.

The other columns state whether a reader rejects the bag while it reads and decodes every message, with its text. `rosbags` reads the
directory. `mcap` reads by the index with every check sum and decodes with `mcap-ros2-support`. The last one is the reader of Foxglove. `no`
means that the reader returns wrong data without a report.

A file of `fastwrite` is a warning: all messages are there, but no index leads to them.

A test compares the second column with the check. This command prints the rest, and writes it with `CAMWRIGHT_WRITE_FAULTS=1`:

```sh
cargo test -p camwright_nodes --test bags bag_faults -- --ignored --nocapture
```

| fault | `camwright bag check` | rosbags | mcap | Foxglove |
|---|---|---|---|---|
";
