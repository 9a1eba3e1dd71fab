// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Two cells under two namespaces in one domain do not disturb each other.

use crate::support;

use camwright_bag::Bag;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use support::Domain;

fn cell(domain: &Domain, namespace: &str, bag: &Path) -> Child {
    let _not_there = std::fs::remove_dir_all(bag);
    Command::new(env!("CARGO_BIN_EXE_camwright"))
        .env("ROS_DOMAIN_ID", domain.id().to_string())
        .env("XDG_STATE_HOME", env!("CARGO_TARGET_TMPDIR"))
        .args(["run", "--json", "--bag"])
        .arg(bag)
        .args(["--set", "infeed.total_mm=0.036", "--set", "infeed.spark_out_turns=3", "--set", "stock_mm=0.03"])
        .args(["--set-machine", "wheel.spin_up_s=0.2", "--set-machine", "feedback_delay_ticks=500"])
        .args(["--ros-args", "-r", &format!("__ns:={namespace}")])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("camwright runs")
}

#[test]
fn two_namespaces_are_two_cells() {
    let domain = Domain::reserve();
    let bag = |name: &str| -> PathBuf {
        Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("two-cells-{name}-{}", std::process::id()))
    };
    let cells = [("/left", bag("left")), ("/right", bag("right"))].map(|(namespace, bag)| {
        let child = cell(&domain, namespace, &bag);
        (namespace, bag, child)
    });
    for (namespace, bag, child) in cells {
        let output = child.wait_with_output().expect("it ends");
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{namespace}: {text}\n{}", String::from_utf8_lossy(&output.stderr));
        let report: serde_json::Value = serde_json::from_str(text.trim()).expect("one line of JSON");
        assert_eq!(report["good"], true, "{namespace}: {report}");
        let recorded = Bag::open(&bag).expect("a bag");
        let shared = ["/clock", "/diagnostics", "/rosout", "/parameter_events", "/tf", "/tf_static"];
        for topic in recorded.topics() {
            let own = topic.name.starts_with(&format!("{namespace}/"));
            assert!(own || shared.contains(&topic.name.as_str()), "{namespace} recorded {}", topic.name);
        }
        std::fs::remove_dir_all(&bag).expect("the bag is ours");
    }
}
