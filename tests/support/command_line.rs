// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The command line, run from the repository.

use super::repository;
use std::process::{Command, Output};

/// Runs `camwright` with overrides of the job.
pub fn camwright(words: &[&str], set: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(repository()).args(words);
    for over in set {
        command.args(["--set", over]);
    }
    command.output().expect("camwright runs")
}

/// Text of `camwright check` of a job that is refused, on one line.
pub fn refusal_of_check(job: &str, set: &[&str]) -> String {
    let output = camwright(&["check", job, "--details"], set);
    assert_eq!(output.status.code(), Some(2), "{set:?}: {}", String::from_utf8_lossy(&output.stdout));
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
