// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Tutorials that need no ROS installation; `tests/ros/tutorials.rs` and `tests/cell/tutorial_over_hal.rs` follow the others.

use crate::support::{repository, tutorial};

fn follow(name: &str) {
    tutorial::follow(name, None);
}

#[test]
fn every_tutorial_is_followed() {
    let sources = [
        include_str!("tutorials.rs"),
        include_str!("../ros/tutorials.rs"),
        include_str!("../cell/tutorial_over_hal.rs"),
    ];
    let folder = repository().join("docs/tutorials");
    for entry in std::fs::read_dir(&folder).expect("tutorials").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.ends_with(".ipynb") {
            let page = std::fs::read_to_string(folder.join("camwright_in_python.md")).expect("a page");
            assert!(
                page.contains(&format!("jupyter nbconvert --log-level ERROR --to html --execute {name}")),
                "{name}"
            );
            continue;
        }
        let calls = [format!("follow(\"{name}\")"), format!("follow_in(\"{name}\"")];
        let is_followed = calls.iter().any(|call| sources.iter().any(|source| source.contains(call)));
        assert!(is_followed, "no test follows {name}");
    }
}

#[test]
fn my_first_cam() {
    follow("my_first_cam.md");
}

#[test]
fn my_grinding_machine() {
    follow("my_grinding_machine.md");
}

#[test]
fn a_3d_cam_from_stl() {
    follow("a_3d_cam_from_stl.md");
}

#[test]
fn an_nc_program() {
    follow("an_nc_program.md");
}

#[test]
fn reading_a_report() {
    follow("reading_a_report.md");
}

#[test]
fn a_shaft_with_runout() {
    follow("a_shaft_with_runout.md");
}

#[test]
fn learning_from_part_to_part() {
    follow("learning_from_part_to_part.md");
}

#[test]
fn a_study() {
    follow("a_study.md");
}

/// Needs the Python package index: the page installs Dask and the build system of the module.
#[test]
fn a_study_on_many_computers() {
    follow("study_on_many_computers.md");
}

#[test]
fn recording_and_replaying() {
    follow("recording_and_replaying.md");
}

/// Needs the Python package index: the page installs the module, Jupyter and pytest.
#[test]
fn camwright_in_python() {
    follow("camwright_in_python.md");
}
