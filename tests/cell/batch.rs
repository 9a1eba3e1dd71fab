// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Parts one after the other from the command line: what they teach the next one, what outlives a run, what a batch is capable of.

use crate::support;

use serde_json::Value;
use std::process::{Command, Output};
use support::{Domain, Folder};

/// Runs a short four-lobe job; what is kept is kept in the folder.
fn run(domain: &Domain, folder: &Folder, bag: &str, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
    command.env("XDG_STATE_HOME", folder.path()).args(["run", "--json", "--bag"]).arg(folder.join(bag));
    for over in ["infeed.total_mm=0.072", "stock_mm=0.06"] {
        command.args(["--set", over]);
    }
    command.args(more).output().expect("camwright runs")
}

fn report(output: &Output) -> Value {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("a report in JSON")
}

/// The form errors of the lobes of a part (um).
fn forms_um(lobes: &Value, key: &str) -> Vec<f64> {
    let lobes = lobes.as_array().expect("lobes");
    lobes.iter().map(|lobe| lobe[key].as_f64().expect("a number").abs()).collect()
}

#[test]
fn parts_teach_the_next_one_over_a_restart_until_they_are_forgotten() {
    let (domain, folder) = (Domain::reserve(), Folder::new("batch-learns"));
    const LEARN: [&str; 2] = ["--set", "form_compensation={}"];
    let both = report(&run(&domain, &folder, "both", &[&LEARN[..], &["--parts", "2"]].concat()));
    let batch = &both["batch"];
    let parts = batch["parts"].as_array().expect("parts");
    assert_eq!(parts.len(), 2);
    let (first, second) = (forms_um(&parts[0]["lobes"], "form_um"), forms_um(&parts[1]["lobes"], "form_um"));
    assert!(first.iter().zip(&second).all(|(first, second)| *second < 0.7 * first), "{first:?} {second:?}");
    assert_ne!(parts[0]["plan_hash"], parts[1]["plan_hash"]);
    assert_eq!(forms_um(&both["lobes"], "form_error_max_um").len(), second.len());

    // Cp and Cpk of two parts by hand: s = |a - b|/sqrt 2.
    let size = |part: &Value| part["lobes"][0]["size_um"].as_f64().expect("a size");
    let (a, b) = (size(&parts[0]), size(&parts[1]));
    let (mean, deviation) = (0.5 * (a + b), (a - b).abs() / 2_f64.sqrt());
    let found = &batch["capability"][0]["size"];
    let near = |key: &str, wanted: f64| {
        let found = found[key].as_f64().expect("a number");
        assert!((found - wanted).abs() < 1e-6 * wanted.abs(), "{key}: {found} {wanted}");
    };
    near("cp", 10.0 / (6.0 * deviation));
    near("cpk", (5.0 - mean.abs()) / (3.0 * deviation));

    let third = report(&run(&domain, &folder, "third", &LEARN));
    assert!(third["batch"].is_null());
    let third = forms_um(&third["lobes"], "form_error_max_um");
    assert!(third.iter().zip(&second).all(|(third, second)| third < second), "{second:?} {third:?}");
    let kept = || {
        let path = folder.join("camwright/learned/cam_grinder/four_lobe_camshaft.yaml");
        std::fs::read_to_string(path).expect("what was learned")
    };
    assert!(kept().contains("parts: 3\n"), "{}", kept());

    let afresh = report(&run(&domain, &folder, "afresh", &[&LEARN[..], &["--forget-learned"]].concat()));
    let afresh = forms_um(&afresh["lobes"], "form_error_max_um");
    assert!(afresh.iter().zip(&first).all(|(afresh, first)| (afresh - first).abs() < 0.3), "{first:?} {afresh:?}");
    assert!(kept().contains("parts: 1\n"), "{}", kept());
}

#[test]
fn a_job_that_does_not_learn_has_nothing_to_forget_and_keeps_nothing() {
    let (domain, folder) = (Domain::reserve(), Folder::new("batch-plain"));
    let refused = run(&domain, &folder, "refused", &["--forget-learned"]);
    assert!(!refused.status.success());
    let stderr = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(stderr.contains("four_lobe_camshaft does not learn; add the key form_compensation"), "{stderr}");
    report(&run(&domain, &folder, "plain", &[]));
    assert!(!folder.join("camwright/learned").exists());
}
