// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The shipped slender camshaft, ground by the whole cell from the command line.

use crate::support;

use camwright_analysis::rerun::rerun;
use std::process::Command;
use support::{Domain, Folder};

/// Largest form error of every lobe (µm) of a run whose bag repeats to the bit.
fn ground_um(set: &[&str]) -> Vec<f64> {
    let folder = Folder::new("steady-rest-run");
    let (domain, bag) = (Domain::reserve(), folder.join("bag"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
    command.env("XDG_STATE_HOME", folder.join("state"));
    let short = ["roughing=[]", "stock_mm=0.03", "infeed.spark_out_turns=3"];
    let set: Vec<&str> = short.iter().chain(set).flat_map(|set| ["--set", set]).collect();
    command.args(["run", "long_camshaft", "--json"]).args(set);
    let output = command.arg("--bag").arg(&bag).output().expect("camwright runs");
    let report: serde_json::Value = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&output.stderr)));
    let lobes = report["lobes"].as_array().expect("lobes").iter();
    let errors_um = lobes.map(|lobe| lobe["form_error_max_um"].as_f64().expect("a number")).collect();
    let verdict = rerun(&bag).expect("the bag holds what it takes");
    assert!(verdict.is_identical(), "{}", verdict.to_text());
    errors_um
}

/// The machine gets the compliance of the part over its topic: without the steady rest the lobes beside it are worse, and both runs repeat
/// to the bit.
#[test]
fn a_slender_part_is_ground_with_and_without_steady_rest_and_repeats() {
    let rested_um = ground_um(&[]);
    let alone_um = ground_um(&["part_support.steady_rest_z_mm=null"]);
    assert_eq!((rested_um.len(), alone_um.len()), (6, 6));
    for beside in [2, 3] {
        assert!(alone_um[beside] > 1.3 * rested_um[beside].abs() + 1.0, "{alone_um:?} um, {rested_um:?} um with rest");
    }
}
