// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright study`: killed, resumed, interrupted and refused.

use crate::support;

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};
use support::{Folder, Guarded, PATIENCE};

/// Eight short cases.
const STUDY: &str = "schema: camwright/study/1
name: short
job: eccentric
fixed: {infeed.total_mm: 0.036, stock_mm: 0.03, infeed.spark_out_turns: 1}
factors:
  work_speed_rpm: {from: 40, to: 75, steps: 8}
design: {kind: grid}
seeds: [raw_part.seed]
limits: {form_error_max_um: 20.0, burn_index: 2.0}
";

fn study(folder: &Folder, out: &str, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(folder.path()).args(["study", "short.yaml", "--out", out]).args(more);
    command
}

fn output(command: &mut Command) -> (Option<i32>, String, String) {
    let Output { status, stdout, stderr } = command.output().expect("camwright runs");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (status.code(), text(stdout), text(stderr))
}

fn finished_lines(log: &Path) -> usize {
    std::fs::read_to_string(log).unwrap_or_default().matches('\n').count()
}

/// Waits until a log holds finished cases.
fn wait_for_cases(log: &Path, count: usize) {
    let deadline = Instant::now() + PATIENCE;
    while finished_lines(log) < count {
        assert!(Instant::now() < deadline, "{} has no {count} cases", log.display());
        // No event reaches this process from the file of another one.
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn a_killed_study_goes_on_and_gives_the_same_bytes() {
    let folder = Folder::new("study-killed");
    folder.write("short.yaml", STUDY);
    let (code, text, error) = output(&mut study(&folder, "whole", &["--workers", "2"]));
    assert_eq!(code, Some(0), "{text}{error}");
    assert!(text.starts_with("GOOD: case 8 of 8 is feasible with the smallest job_time_s: "), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 80 || !line.contains(' ')), "{text}");

    let log = folder.join("killed/cases.jsonl");
    let mut killed = Guarded::start("study", study(&folder, "killed", &["--workers", "1"]).stderr(Stdio::null()));
    wait_for_cases(&log, 2);
    killed.signal("KILL");
    killed.wait(PATIENCE);
    let before = finished_lines(&log);
    let (code, _, notes) = output(&mut study(&folder, "killed", &["--workers", "4"]));
    assert_eq!(code, Some(0), "{notes}");
    assert!(notes.contains(&format!("resumed: {before} of 8 cases were finished before")), "{notes}");
    assert_eq!(finished_lines(&log), 8, "no case ran twice");
    for name in ["plan.json", "results.parquet", "results.csv"] {
        let bytes = |out: &str| std::fs::read(folder.join(out).join(name)).expect("a result");
        assert!(bytes("whole") == bytes("killed"), "{name} differs");
    }
}

#[test]
fn ctrl_c_keeps_the_finished_cases() {
    let folder = Folder::new("study-interrupted");
    folder.write("short.yaml", &STUDY.replace("steps: 8", "steps: 200"));
    let log = folder.join("out/cases.jsonl");
    let mut running = Guarded::start("study", &mut study(&folder, "out", &["--workers", "2"]));
    wait_for_cases(&log, 1);
    running.interrupt();
    let line = running.line(PATIENCE).expect("a verdict");
    assert!(line.starts_with("INTERRUPTED: ") && line.contains(" of 200 cases are finished"), "{line}");
    assert_eq!(running.wait(PATIENCE).code(), Some(130));
    let rows = std::fs::read_to_string(folder.join("out/results.csv")).expect("results").lines().count() - 1;
    assert_eq!(rows, finished_lines(&log));
}

#[test]
fn a_bad_study_is_refused_with_its_line_before_anything_runs() {
    let folder = Folder::new("study-bad");
    for (from, to, words) in [
        ("steps: 8", "stesp: 8", "short.yaml:6: factors.work_speed_rpm.stesp is an unknown key; did you mean steps?"),
        ("from: 40, to: 75", "from: 75, to: 40", "short.yaml:6: factors.work_speed_rpm is an empty range"),
        (
            "work_speed_rpm:",
            "work_sped_rpm:",
            "short.yaml:6: work_sped_rpm is an unknown key; did you mean work_speed_rpm?",
        ),
        (
            "kind: grid",
            "kind: sobol, samples: 1000000000",
            "short.yaml:7: design.samples is 1000000000; it must be 1 to",
        ),
        ("seeds:", "replicates: 20000\nseeds:", "short.yaml:8: the study has 160000 cases; at most 100000 are allowed"),
    ] {
        folder.write("short.yaml", &STUDY.replacen(from, to, 1));
        let (code, text, error) = output(&mut study(&folder, "out", &[]));
        assert_eq!((code, text.as_str()), (Some(2), ""), "{error}");
        assert!(error.replace("\n", " ").contains(words), "{words}: {error}");
        assert!(!folder.join("out").exists(), "nothing was written");
        let checked = Command::new(env!("CARGO_BIN_EXE_camwright"))
            .current_dir(folder.path())
            .args(["check", "short.yaml"])
            .output();
        let checked = String::from_utf8(checked.expect("camwright runs").stderr).expect("UTF-8");
        assert!(checked.contains(words), "{words}: {checked}");
    }
}

#[test]
fn a_study_without_a_feasible_case_exits_with_4() {
    let folder = Folder::new("study-infeasible");
    folder.write("short.yaml", &STUDY.replace("steps: 8", "steps: 2").replace("max_um: 20.0", "max_um: 0.0"));
    let (code, text, error) = output(&mut study(&folder, "out", &["--json"]));
    assert_eq!(code, Some(4), "{text}{error}");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!((&json["verdict"], &json["done"], &json["feasible"]), (&"not good".into(), &2.into(), &0.into()));
}
