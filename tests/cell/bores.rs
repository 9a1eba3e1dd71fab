// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The shipped ring of a vane pump, ground inside by the whole cell from the command line.

use crate::support;

use camwright_analysis::rerun::rerun;
use std::process::Command;
use support::{Domain, Folder};

/// The wall is within its tolerance, and the bag repeats to the bit.
#[test]
fn a_pump_ring_is_ground_inside_and_repeats() {
    let folder = Folder::new("bores");
    let (domain, bag) = (Domain::reserve(), folder.join("bag"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
    command.env("XDG_STATE_HOME", folder.join("state"));
    let output = command.args(["run", "pump_ring", "--json", "--bag"]).arg(&bag).output().expect("camwright runs");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a report");
    let lobe = &report["lobes"][0];
    assert!(lobe["form_error_max_um"].as_f64().expect("a number").abs() < 5.0, "{lobe}");
    let verdict = rerun(&bag).expect("the bag holds what it takes");
    assert!(verdict.is_identical(), "{}", verdict.to_text());
}
