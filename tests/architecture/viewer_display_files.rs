// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The display files for `RViz` and Foxglove load, and show topics and fields that the cell publishes.

use crate::support::repository;
use crate::viewer_files::{Published, PublishedTopic, layout_faults, message_path, path_value, rviz_faults};
use serde_json::Value;
use std::collections::BTreeSet;

fn read(path: &str) -> String {
    std::fs::read_to_string(repository().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Topics in the reference of the nodes, which `interface_reference` of the test program `ros` compares with running nodes.
fn published() -> Published {
    let mut published = Published::new();
    for page in ["overview", "machine_sim", "axis_interpolator", "job_planner", "run_logger"] {
        let text = read(&format!("docs/reference/ros/{page}.md"));
        let table = text.split("# Published topics").nth(1).unwrap_or_else(|| panic!("{page} publishes nothing"));
        let table = table.split("\n##").next().unwrap_or_default();
        for row in table.lines().filter(|line| line.starts_with("| `")) {
            let cells: Vec<&str> = row.split('|').map(str::trim).collect();
            let name = cells[1].trim_matches('`').replace("~/", &format!("{page}/"));
            let type_name = cells[2].trim_start_matches('[').split(']').next().unwrap_or_default().to_owned();
            let is_latched = Some(cells[3].contains("transient local"));
            published.insert(format!("/{}", name.trim_start_matches('/')), PublishedTopic { type_name, is_latched });
        }
    }
    assert!(published.len() > 30, "{published:?}");
    published
}

/// Values of the constants of a message of camwright.
fn states(type_name: &str) -> BTreeSet<String> {
    let name = type_name.rsplit('/').next().unwrap_or_default();
    let text = read(&format!("msgs/msg/{name}.msg"));
    let constants = text.lines().filter(|line| line.starts_with("uint8 ")).filter_map(|line| line.split_once(" = "));
    constants.filter_map(|(_, value)| value.split_whitespace().next().map(str::to_owned)).collect()
}

/// Namespaces of markers, as the guide lists them.
fn namespaces() -> BTreeSet<String> {
    let guide = read("docs/guides/visualisation.md");
    let rows = guide.lines().filter(|line| line.contains("/markers`"));
    let named = rows.flat_map(|row| row.split('|').nth(3).unwrap_or_default().split('`').skip(1).step_by(2));
    let named: BTreeSet<String> = named.map(str::to_owned).collect();
    let sources = ["nodes/machine_node/src/scene_outlet.rs", "nodes/job_planner/src/lobe_forms.rs"].map(read);
    for name in &named {
        let literal = format!("\"{name}\"");
        assert!(
            sources.iter().any(|text| text.contains(&literal)),
            "no node publishes markers of the namespace {name}"
        );
    }
    named
}

fn layout() -> Value {
    serde_json::from_str(&read("nodes/foxglove/cell.json")).expect("JSON")
}

#[test]
fn rviz_accepts_every_property_and_every_topic_is_published() {
    let text = read("nodes/rviz/cell.rviz");
    assert_eq!(rviz_faults(&text, &published(), &namespaces()), [""; 0]);
}

#[test]
fn foxglove_accepts_every_property_and_every_path_leads_to_a_number() {
    assert_eq!(layout_faults(&layout(), &published(), states), [""; 0]);
}

/// X has a plot of its own: it moves by some millimetres while C turns on and on.
#[test]
fn foxglove_shows_x_in_a_plot_of_its_own() {
    let layout = layout();
    let panels = layout["configById"].as_object().expect("panels");
    let shows = |path: &str| {
        let only = |config: &&Value| {
            config["paths"].as_array().is_some_and(|paths| paths.len() == 1 && paths[0]["value"] == path)
        };
        panels.values().filter(only).count()
    };
    for path in ["/joint_states.position[0].@degrees", "/joint_states.position[1].@mul(1000)"] {
        assert_eq!(shows(path), 1, "{path}");
    }
}

/// A topic or field that the cell renames is found, and so is a name that the programs do not accept.
#[test]
fn a_renamed_topic_or_field_and_an_unknown_property_are_found() {
    let (published, rviz, layout) = (published(), read("nodes/rviz/cell.rviz"), read("nodes/foxglove/cell.json"));
    for (from, to, fault) in [
        ("machine/markers", "machine/marks", "not published"),
        ("rviz_default_plugins/TF\n      Name", "rviz_default_plugins/Tf\n      Name", "unknown"),
        ("Marker Scale", "Marker Size", "not a property"),
        ("Plane: XY", "Plane: ZX", "not accepted"),
        ("Durability Policy: Transient Local", "Durability Policy: Latched", "not accepted"),
        ("Durability Policy: Transient Local", "Durability Policy: Volatile", "latched"),
        ("stock: true", "bar: true", "namespace bar"),
        ("Value: robot_description", "Value: joint_states", "the display shows"),
        ("Color: 120; 120; 120", "Color: grey", "not accepted"),
        ("Panels:", "Panels: [", "not YAML"),
    ] {
        assert!(rviz.contains(from), "{from}");
        let faults = rviz_faults(&rviz.replacen(from, to, 1), &published, &namespaces());
        assert!(faults.iter().any(|found| found.contains(fault)), "{from} → {to}: {faults:?}");
    }
    for (from, to, fault) in [
        ("/machine/outline.radius[:]", "/machine/contour.radius[:]", "not published"),
        ("/machine/outline.radius[:]", "/machine/outline.radii[:]", "has no radii"),
        ("/machine/outline.radius[:]", "/machine/outline.name[:]", "no list"),
        ("/machine/outline.radius[:]", "/machine/outline.name", "no number"),
        ("/joint_states.position[1]", "/joint_states.position[:]", "does not fit"),
        (".@mul(1000)", ".@times(1000)", "unknown"),
        ("position[1].@mul(1000)", "position[1]", "not in mm"),
        ("\"X (mm)\"", "\"X (m)\"", "no unit"),
        ("\"first\": \"Plot!c\"", "\"first\": \"Plot!x\"", "2 times"),
        ("\"first\": \"Plot!c\"", "\"first\": \"Plot!d\"", "no configuration"),
        ("Indicator!job", "Lamp!job", "unknown"),
        ("\"rawValue\": \"6\"", "\"rawValue\": \"7\"", "the state has"),
        ("showLegend", "showLegends", "not a property"),
        ("\"/job_planner/markers\"", "\"/job_planner/lobe_forms\"", "the panel shows"),
        ("\"/diagnostics\"", "\"/diagnosis\"", "not published"),
    ] {
        assert!(layout.contains(from), "{from}");
        let changed: Value = serde_json::from_str(&layout.replace(from, to)).expect("JSON");
        let faults = layout_faults(&changed, &published, states);
        assert!(faults.iter().any(|found| found.contains(fault)), "{from} → {to}: {faults:?}");
    }
}

#[test]
fn message_paths_follow_the_syntax_of_foxglove() {
    for path in
        ["/a", "/a/b.c", "/a.b[0].c", "/a.b[-1]", "/a.b[:]", "/a.b[1:3].c", "/a.b.@abs", "/a.b.@mul(1000).@round(2)"]
    {
        assert!(message_path(path).is_ok(), "{path}: {:?}", message_path(path));
    }
    for path in
        ["a", "/", "/a.", "/a..b", "/a.b[", "/a.b[x]", "/a.b.@", "/a.b.@mul", "/a.b.@mul(x)", "/a.b.@abs(1)", "/a b"]
    {
        assert!(message_path(path).is_err(), "{path}");
    }
    let value = path_value("/dynamic_joint_states.interface_values[1].values[3]", &published()).expect("a value");
    assert!(value.is_number && !value.is_list);
}
