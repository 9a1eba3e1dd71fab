// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The shipped wide lobe, ground by the whole cell from the command line.

use crate::support;

use camwright_analysis::rerun::rerun;
use std::process::Command;
use support::{Domain, Folder};

/// Every plunge is within its tolerance, the message states every section and the largest step, and the bag repeats to the bit.
#[test]
fn a_wide_lobe_is_ground_side_by_side_and_repeats() {
    let folder = Folder::new("wide-lobes-run");
    let (domain, bag) = (Domain::reserve(), folder.join("bag"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
    command.env("XDG_STATE_HOME", folder.join("state"));
    let short = ["roughing.0.infeed.total_mm=0.036", "stock_mm=0.06"].map(|set| ["--set", set]);
    command.args(["run", "wide_lobes", "--json"]).args(short.as_flattened());
    let output = command.arg("--bag").arg(&bag).output().expect("camwright runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a report");
    let lobes = report["lobes"].as_array().expect("lobes");
    let um = |name: &str| {
        let lobe = lobes.iter().find(|lobe| lobe["name"] == name).unwrap_or_else(|| panic!("no {name} in {lobes:?}"));
        lobe["form_error_max_um"].as_f64().expect("a number")
    };
    assert_eq!(lobes.len(), 4);
    let message = report["message"].as_str().expect("a message");
    let section = |name: &str| -> f64 {
        let text = message.split(&format!("{name} ")).nth(1).unwrap_or_else(|| panic!("no {name} in {message}"));
        let number = text.split([' ', ',']).next().expect("a word");
        number.parse().unwrap_or_else(|_| panic!("no form error of {name} in {message}"))
    };
    for (plunge, sections) in [("W-1", vec!["W-1"]), ("W-2", vec!["W-2", "W-1-2"]), ("W-3", vec!["W-3", "W-2-3"])] {
        let errors_um: Vec<f64> = sections.iter().map(|name| section(name)).collect();
        let worst_um = errors_um.iter().fold(0.0_f64, |worst, um| if um.abs() > worst.abs() { *um } else { worst });
        assert!((um(plunge) - worst_um).abs() < 2e-3, "{plunge}: {} um, {errors_um:?} um, {message}", um(plunge));
        assert!(worst_um.abs() < 5.0, "{plunge}: {worst_um} um");
    }
    assert!(um("N").abs() < 5.0 && message.contains("largest step "), "{message}");
    let verdict = rerun(&bag).expect("the bag holds what it takes");
    assert!(verdict.is_identical(), "{}", verdict.to_text());
}
