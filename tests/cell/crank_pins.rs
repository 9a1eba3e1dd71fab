// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The shipped crank pins, ground by the whole cell from the command line, with the report of the bag.

use crate::support;

use camwright_analysis::rerun::rerun;
use std::process::Command;
use support::{Domain, Folder};

/// Both pins are within their tolerance; verdict and report state roundness, throw and angle; the bag repeats to the bit.
#[test]
fn crank_pins_are_ground_round_and_reported() {
    let folder = Folder::new("crank-pins");
    let (domain, bag) = (Domain::reserve(), folder.join("bag"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
    command.env("XDG_STATE_HOME", folder.join("state"));
    let output = command.args(["run", "crank_pins", "--json", "--bag"]).arg(&bag).output().expect("camwright runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a report");
    let lobes = report["lobes"].as_array().expect("lobes");
    assert_eq!(lobes.len(), 2);
    for lobe in lobes {
        let um = |key: &str| lobe[key].as_f64().expect("a number");
        assert!(um("form_error_max_um").abs() < 5.0, "{lobe}");
        assert!(um("runout_um").abs() < 1e-9, "the runout of a journal is none of a pin: {lobe}");
    }
    let message = report["message"].as_str().expect("a message");
    let value = |pin: &str, key: &str| -> f64 {
        let text = message.split(&format!("pin {pin}: ")).nth(1).unwrap_or_else(|| panic!("no {pin} in {message}"));
        let number = text.split(&format!("{key} ")).nth(1).and_then(|rest| rest.split(' ').next());
        number.and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("no {key} of {pin} in {message}"))
    };
    for pin in ["P1", "P2"] {
        let [roundness, throw, angle] = ["roundness", "throw", "angle"].map(|key| value(pin, key));
        assert!(roundness > 0.0 && roundness < 3.0, "{pin}: {roundness} um");
        assert!(throw.abs() < 3.0 && angle.abs() < 0.01, "{pin}: throw {throw} um, angle {angle} deg");
    }
    let verdict = rerun(&bag).expect("the bag holds what it takes");
    assert!(verdict.is_identical(), "{}", verdict.to_text());
    let html = std::fs::read_to_string(bag.join("report.html")).expect("a report beside the bag");
    let pins = html.split("<section id=\"pins\">").nth(1).expect("a table of pins").split("</section>").next();
    let pins = pins.expect("its end");
    assert!(pins.contains("P1") && pins.contains("P2") && pins.contains("40.000"), "{pins}");
    for pin in ["P1", "P2"] {
        let roundness = format!("{:.2}", value(pin, "roundness"));
        assert!(pins.contains(&roundness), "{pin}: roundness {roundness} of the message is not in {pins}");
    }
}
