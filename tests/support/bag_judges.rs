// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The readers that other people use, as judges of bags: rosbags and mcap, and the JavaScript reader that Foxglove uses.
#![allow(dead_code, reason = "each test target uses its part")]
#![allow(unreachable_pub, reason = "a module of test binaries has no outside")]

use super::support::{Domain, in_ci, peer_env, repository, target_directory};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Content of a bag as rosbags and mcap decode it, every message decoded; `None` without peers. A rejected bag fails the test.
pub fn rosbags_counts(bag: &Path, domain: &Domain) -> Option<serde_json::Value> {
    rosbags_counts_without(&[], bag, domain)
}

/// The same, but without decoding messages of the types whose names end so.
pub fn rosbags_counts_without(suffixes: &[&str], bag: &Path, domain: &Domain) -> Option<serde_json::Value> {
    let mut judge = peer_env()?.python("judge_bag.py", domain);
    judge.arg(bag);
    if !suffixes.is_empty() {
        judge.arg("--undecoded").args(suffixes);
    }
    let output = judge.output().expect("the interpreter is there");
    assert!(output.status.success(), "a judge refuses the bag: {}", String::from_utf8_lossy(&output.stderr));
    Some(serde_json::from_slice(&output.stdout).expect("one JSON object"))
}

/// Verdicts of rosbags and mcap on bags that may be wrong, in order; `None` without peers.
pub fn python_verdicts(bags: &[PathBuf], domain: &Domain) -> Option<Vec<serde_json::Value>> {
    let output = peer_env()?.python("judge_faults.py", domain).args(bags).output().expect("the interpreter is there");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(lines(&output.stdout))
}

/// Verdicts of Foxglove's reader on bags that may be wrong, in order; `None` without Node.js.
pub fn foxglove_verdicts(bags: &[PathBuf]) -> Option<Vec<serde_json::Value>> {
    let home = foxglove_home()?;
    let output = Command::new("node").arg(home.join("judge_faults.mjs")).args(bags).output();
    let output = output.expect("node can be started");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(lines(&output.stdout))
}

fn lines(stdout: &[u8]) -> Vec<serde_json::Value> {
    let text = String::from_utf8_lossy(stdout);
    text.lines().map(|line| serde_json::from_str(line).expect("a JSON object a line")).collect()
}

/// Message counts of the judge by topic; `None` without Node.js (CI requires it). A rejected bag fails the test.
pub fn foxglove_counts(bag: &Path) -> Option<serde_json::Value> {
    let home = foxglove_home()?;
    let output = Command::new("node").arg(home.join("judge_bag.mjs")).arg(bag).output().expect("node can be started");
    assert!(output.status.success(), "Foxglove's reader refuses the bag: {}", String::from_utf8_lossy(&output.stderr));
    Some(serde_json::from_slice(&output.stdout).expect("one JSON object"))
}

/// Folder of the judge and its modules, made once under `target/`.
fn foxglove_home() -> Option<PathBuf> {
    let home = target_directory().join("foxglove-judge");
    let has =
        |program: &str| Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success());
    if !has("node") || !has("npm") {
        assert!(!in_ci(), "node and npm are not installed, and this judge is not optional under CI=true");
        eprintln!("SKIPPED, NOT PASSED: node and npm are not installed, Foxglove's reader was not asked");
        return None;
    }
    fs::create_dir_all(&home).expect("the target directory can be written");
    let lock = File::create(home.join("lock")).expect("a lock file can be made");
    lock.lock().expect("it can be locked");
    let source = repository().join("tests/support/foxglove");
    let stamp = home.join("stamp");
    let wanted = fs::read_to_string(source.join("package-lock.json")).expect("it is in the repository");
    if fs::read_to_string(&stamp).ok().as_ref() != Some(&wanted) {
        for name in ["package.json", "package-lock.json"] {
            fs::copy(source.join(name), home.join(name)).expect("the target directory can be written");
        }
        let output = Command::new("npm").args(["ci", "--no-audit", "--no-fund"]).current_dir(&home).output();
        let output = output.expect("npm can be started");
        assert!(output.status.success(), "npm ci: {}", String::from_utf8_lossy(&output.stderr));
        fs::write(&stamp, wanted).expect("the target directory can be written");
    }
    // Modules are looked for beside the script.
    for script in ["reader.mjs", "judge_bag.mjs", "judge_faults.mjs"] {
        fs::copy(source.join(script), home.join(script)).expect("the target directory can be written");
    }
    Some(home)
}
