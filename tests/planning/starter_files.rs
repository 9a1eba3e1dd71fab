// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright init` and `camwright list`: files to start from pass the check and run as they are.

use crate::support;

use std::process::{Command, Output};
use support::{Domain, Folder};

fn camwright(folder: &Folder, domain: &Domain, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(folder.path()).env("ROS_DOMAIN_ID", domain.id().to_string());
    command.env("XDG_STATE_HOME", folder.join("state")).args(words).output().expect("camwright runs")
}

/// Standard output of a command that ends with 0.
fn succeeds(folder: &Folder, domain: &Domain, words: &[&str]) -> String {
    let output = camwright(folder, domain, words);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{words:?}: {text}{}", String::from_utf8_lossy(&output.stderr));
    text
}

#[test]
fn starter_files_are_written_and_pass_the_check() {
    let (folder, domain) = (Folder::new("starter-check"), Domain::reserve());
    for (kind, next) in [
        ("job", "camwright run my_job.yaml"),
        ("turning", "camwright run my_turning.yaml"),
        ("milling", "camwright post my_milling.yaml --out nc"),
        ("study", "camwright study my_study.yaml"),
        ("machine", "camwright run four_lobe_camshaft --set machine=my_machine.yaml"),
    ] {
        let file = format!("my_{kind}.yaml");
        let text = succeeds(&folder, &domain, &["init", kind]);
        assert_eq!(text, format!("written: {file}\nnext:    camwright check {file}\n         {next}\n"));
        let written = std::fs::read_to_string(folder.join(&file)).expect("it was written");
        assert!(written.contains(&format!("\nname: my_{kind}\n")), "{written}");
        let checked = succeeds(&folder, &domain, &["check", &file]);
        assert!(checked.starts_with(&format!("CLEAN: my_{kind}: ")), "{checked}");
        let printed = succeeds(&folder, &domain, &["init", kind, "--print"]);
        assert_eq!(printed, written, "and the file is left alone");
        assert_eq!(succeeds(&folder, &domain, &["init", kind, "-"]), written);
    }
}

#[test]
fn the_starter_job_runs_on_the_starter_machine() {
    let (folder, domain) = (Folder::new("starter-run"), Domain::reserve());
    succeeds(&folder, &domain, &["init", "job", "first.yaml"]);
    succeeds(&folder, &domain, &["init", "machine", "own.yaml"]);
    let run = ["run", "first.yaml", "--set", "machine=own.yaml", "--bag", "bag"];
    let text = succeeds(&folder, &domain, &run);
    assert!(text.starts_with("GOOD: worst form error ") && text.contains("\nfirst.yaml: 1 lobe in "), "{text}");
    assert!(folder.join("state/camwright/own.yaml").is_file(), "the state of the machine has its name");
}

#[test]
fn lists_name_what_commands_accept() {
    let (folder, domain) = (Folder::new("starter-list"), Domain::reserve());
    for (subject, words) in [
        ("jobs", "four_lobe_camshaft  "),
        ("machines", "lathe "),
        ("lifts", "intake "),
        ("studies", "speed_and_infeed  "),
        ("faults", "stuck_input "),
        ("topics", "joint_states "),
        ("alarms", "  stop  "),
    ] {
        let text = succeeds(&folder, &domain, &["list", subject]);
        assert!(text.contains(words), "{subject}: {text}");
        let json = succeeds(&folder, &domain, &["list", subject, "--json"]);
        let rows: serde_json::Value = serde_json::from_str(&json).expect("JSON");
        assert!(rows.as_array().is_some_and(|rows| rows.len() > 1), "{subject}: {json}");
    }
}
