// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Permitted dependencies between crates, as declared in Cargo.toml. `cargo test -p camwright --test integration rooms` holds the rooms of the
//! core.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The four nodes: none of them depends on another.
const NODES: [&str; 4] =
    ["camwright_machine_sim", "camwright_axis_interpolator", "camwright_job_planner", "camwright_run_logger"];

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Direct dependencies of every crate of the workspace, those of its tests omitted.
fn dependencies() -> BTreeMap<String, BTreeSet<String>> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--format-version", "1"])
        .current_dir(repository())
        .output()
        .expect("cargo runs");
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("cargo prints JSON");
    let text = |value: &Value| value.as_str().expect("a name").to_owned();
    let packages = metadata["packages"].as_array().expect("packages");
    packages
        .iter()
        .map(|package| {
            let all = package["dependencies"].as_array().expect("dependencies");
            let shipped =
                all.iter().filter(|dependency| dependency["kind"].is_null() && dependency["optional"] == false);
            (text(&package["name"]), shipped.map(|dependency| text(&dependency["name"])).collect())
        })
        .collect()
}

/// Crates of the workspace that a crate depends on, directly or through others.
fn reached(from: &str, dependencies: &BTreeMap<String, BTreeSet<String>>) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut open = vec![from.to_owned()];
    while let Some(name) = open.pop() {
        for next in dependencies.get(&name).into_iter().flatten() {
            if found.insert(next.clone()) {
                open.push(next.clone());
            }
        }
    }
    found
}

#[test]
fn only_the_ros_layer_depends_on_the_dds_client() {
    let dependencies = dependencies();
    let names_dds = |of: &BTreeSet<String>| of.contains("ros2-client") || of.contains("rustdds");
    let with_dds: Vec<&String> = dependencies.iter().filter(|(_, of)| names_dds(of)).map(|(name, _)| name).collect();
    assert_eq!(with_dds, ["camwright_ros"]);
    for name in ["camwright", "camwright_msgs", "camwright_threads", "camwright_files", "camwright_bag"] {
        assert!(!reached(name, &dependencies).contains("camwright_ros"), "{name} knows no ROS");
    }
    for name in
        ["camwright_planning", "camwright_machine_cycle", "camwright_analysis", "camwright_studies", "camwright_python"]
    {
        assert!(!reached(name, &dependencies).contains("camwright_ros"), "{name} knows no ROS");
    }
}

#[test]
fn crates_know_only_what_stands_before_them() {
    let dependencies = dependencies();
    let own = |name: &str| -> BTreeSet<String> {
        dependencies[name].iter().filter(|name| name.starts_with("camwright")).cloned().collect()
    };
    let set = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<BTreeSet<_>>();
    assert_eq!(own("camwright"), set(&[]));
    assert_eq!(own("camwright_msgs"), set(&[]));
    assert_eq!(own("camwright_ros"), set(&["camwright_msgs", "camwright_threads"]));
    assert_eq!(own("camwright_authority"), set(&["camwright_msgs", "camwright_ros", "camwright_threads"]));
    assert_eq!(
        own("camwright_bag"),
        set(&["camwright_msgs", "camwright_threads"]),
        "bags know neither ROS nor the core"
    );
    for node in NODES {
        let others = own(node);
        assert!(NODES.iter().all(|other| !others.contains(*other)), "{node} imports another node: {others:?}");
    }
    assert_eq!(
        dependencies["camwright"],
        set(&["libm", "nalgebra", "thiserror", "wide"]),
        "the core is no_std: the compiler proves that it knows no file, clock or thread"
    );
}

/// Lengths of messages are in m and those of the core in mm: `nodes/files` converts, no other crate multiplies by a thousand.
#[test]
fn only_the_files_crate_turns_mm_into_m() {
    fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).expect("a folder of the repository").flatten() {
            let path = entry.path();
            if path.is_dir() {
                sources(&path, into);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                into.push(path);
            }
        }
    }
    let mut files = Vec::new();
    for entry in std::fs::read_dir(repository().join("nodes")).expect("nodes/").flatten() {
        let source = entry.path().join("src");
        if source.is_dir() && !entry.path().ends_with("files") {
            sources(&source, &mut files);
        }
    }
    assert!(files.len() > 100, "only {} files were found", files.len());
    // A PNG states how many of its pixels make a metre.
    let is_exempt = |path: &Path| {
        let text = path.display().to_string();
        text.contains("test") || text.ends_with("drawing/png_file.rs")
    };
    let thousands = ["1e3", "1000.0", "1_000.0", "1e-3", "0.001"];
    let is_factor = |line: &str| {
        thousands.iter().any(|number| {
            line.contains(&format!("{number} *"))
                || ["*", "/"].iter().any(|op| line.contains(&format!("{op} {number}")))
        })
    };
    let mut wrong = Vec::new();
    for path in files.iter().filter(|path| !is_exempt(path)) {
        let text = std::fs::read_to_string(path).expect("a source file");
        let shipped = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        let code = shipped.lines().map(|line| line.split("//").next().unwrap_or_default());
        for (number, line) in code.enumerate().filter(|(_, line)| is_factor(line)) {
            wrong.push(format!("{}:{}: {}", path.display(), number + 1, line.trim()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
