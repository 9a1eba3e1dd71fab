// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The shipped camshaft with two wheels, ground by the whole cell from the command line.

use crate::support;

use camwright_analysis::rerun::rerun;
use std::process::Command;
use support::{Domain, Folder};

/// Two parts in a row: every part is roughed by the large wheel and finished by the small one, so the machine changes back before the second.
/// Only finished lobes are judged. The finished lobes are smaller by the setting error of the small wheel, and the bag repeats to the bit.
#[test]
fn a_batch_is_ground_with_two_wheels_and_repeats() {
    let folder = Folder::new("two-wheels-run");
    let (domain, bag) = (Domain::reserve(), folder.join("bag"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
    command.env("XDG_STATE_HOME", folder.join("state"));
    let short =
        ["roughing.0.infeed.total_mm=0.036", "stock_mm=0.05", "infeed.total_mm=0.045", "wheel_approach_mm=0.02"]
            .map(|set| ["--set", set]);
    command.args(["run", "two_wheel_camshaft", "--json", "--parts", "2"]).args(short.as_flattened());
    let output = command.arg("--bag").arg(&bag).output().expect("camwright runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a report");
    let parts = report["batch"]["parts"].as_array().unwrap_or_else(|| panic!("no parts in {report}"));
    assert_eq!(parts.len(), 2);
    for part in parts {
        let lobes = part["lobes"].as_array().unwrap_or_else(|| panic!("no lobes in {part}"));
        let names: Vec<&str> = lobes.iter().filter_map(|lobe| lobe["name"].as_str()).collect();
        assert_eq!(names, ["I1", "E1", "I2", "E2"]);
        for lobe in lobes {
            let um = lobe["form_um"].as_f64().expect("a number");
            assert!(um.abs() < 5.0, "{lobe}");
            // The setting error is 2 um; deflection leaves less than 1 um.
            let size_um = lobe["size_um"].as_f64().expect("a number");
            assert!((-2.2..-0.8).contains(&size_um), "{lobe}");
        }
    }
    let verdict = rerun(&bag).expect("the bag holds what it takes");
    assert!(verdict.is_identical(), "{}", verdict.to_text());
}
