// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The shipped lobes with taper and crown, ground by the whole cell from the command line.

use crate::support;

use camwright_analysis::rerun::rerun;
use std::process::Command;
use support::{Domain, Folder};

/// Measured taper and crown are those of the design within 0.5 µm, every section is within its tolerance, the report of the bag has them,
/// and the bag repeats to the bit.
#[test]
fn taper_and_crown_are_ground_and_repeat() {
    let folder = Folder::new("tapered-lobes-run");
    let (domain, bag) = (Domain::reserve(), folder.join("bag"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
    command.env("XDG_STATE_HOME", folder.join("state"));
    let short = ["roughing.0.infeed.total_mm=0.036", "stock_mm=0.06"].map(|set| ["--set", set]);
    command.args(["run", "tapered_lobes", "--json"]).args(short.as_flattened());
    let output = command.arg("--bag").arg(&bag).output().expect("camwright runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a report");
    let lobes = report["lobes"].as_array().expect("lobes");
    assert_eq!(lobes.len(), 2);
    let message = report["message"].as_str().expect("a message");
    for (lobe, (taper_um, crown_um)) in lobes.iter().zip([(10.0, 2.5), (12.0, 3.6)]) {
        let value = |key: &str| lobe["shape"][key].as_f64().expect("a number");
        assert!(
            (value("taper_design_um") - taper_um).abs() < 1e-9 && (value("crown_design_um") - crown_um).abs() < 1e-9
        );
        assert!((value("taper_um") - taper_um).abs() < 0.5, "{lobe}");
        assert!((value("crown_um") - crown_um).abs() < 0.5, "{lobe}");
        let sections = lobe["shape"]["form_error_of_sections_um"].as_array().expect("sections");
        let worst_um = sections.iter().map(|um| um.as_f64().expect("a number").abs()).fold(0.0, f64::max);
        assert!(sections.len() == 3 && worst_um < 5.0, "{lobe}");
        let of_lobe = lobe["form_error_max_um"].as_f64().expect("a number");
        assert!((of_lobe.abs() - worst_um).abs() < 1e-6, "the worst section is that of the lobe: {lobe}");
        let said = format!("taper {:+.3} um (design {taper_um:+.3})", value("taper_um"));
        assert!(message.contains(&said), "{said:?} is not in {message}");
    }
    let verdict = rerun(&bag).expect("the bag holds what it takes");
    assert!(verdict.is_identical(), "{}", verdict.to_text());
    let page = report["report"].as_str().expect("a run writes the report of its bag");
    let text = std::fs::read_to_string(page).expect("a report");
    assert!(text.contains("taper µm") && text.contains("+12.00"), "the report has no table of shapes");
}
