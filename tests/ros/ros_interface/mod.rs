// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Reference of the ROS interface: the pages of `docs/reference/ros/` come from the running nodes, their declared parameters and the
//! interface files.
//!
//! `CAMWRIGHT_WRITE_REFERENCE=1 cargo test -p camwright_nodes --test ros ros_interface` writes them anew.

use crate::support;

mod collect;
mod interface_files;
mod page;
mod texts;

use camwright_msgs::std_msgs::msg::Empty;
use camwright_msgs::{camwright_msgs::msg::MachineCommand, control_msgs::msg::SpeedScalingFactor};
use camwright_msgs::{rcl_interfaces::msg::Log, trajectory_msgs::msg::JointTrajectory};
use camwright_ros::{Node, NodeOptions, Qos, RosArgs};
use collect::Interface;
use std::collections::BTreeMap;
use std::sync::mpsc;
use std::time::{Duration, Instant};
use support::{PATIENCE, repository};

/// Environment variable that makes the test write the pages.
const WRITE: &str = "CAMWRIGHT_WRITE_REFERENCE";

const FOLDER: &str = "docs/reference/ros";

/// Time between two messages to a topic whose subscriber may not know the publisher yet.
const REPETITION: Duration = Duration::from_millis(200);

#[test]
fn the_reference_of_the_ros_interface_is_what_the_nodes_offer() {
    let interfaces = collect::all();
    texts::assert_complete(&interfaces);
    let pages = page::all(&interfaces);
    let folder = repository().join(FOLDER);
    if std::env::var_os(WRITE).is_some() {
        std::fs::create_dir_all(&folder).expect("the repository is writable");
        for (name, text) in &pages {
            std::fs::write(folder.join(name), text).expect("the repository is writable");
        }
    }
    let entries = std::fs::read_dir(&folder).expect("the pages are in the repository").flatten();
    let read = |path: std::path::PathBuf| std::fs::read_to_string(path).expect("a page");
    let committed: BTreeMap<String, String> =
        entries.map(|entry| (entry.file_name().to_string_lossy().into_owned(), read(entry.path()))).collect();
    for (name, text) in &pages {
        let present = committed.get(name).map_or("", String::as_str);
        let differs = text.lines().zip(present.lines().chain(std::iter::repeat(""))).find(|(now, then)| now != then);
        assert!(
            present == text,
            "{FOLDER}/{name} is out of date; write it with {WRITE}=1 cargo test -p camwright_nodes --test ros ros_interface\n\
             first difference (now, in the page): {differs:?}"
        );
    }
    let names = |map: &BTreeMap<String, String>| map.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&committed), names(&pages), "pages of {FOLDER}");
}

/// A page differs as soon as the interface does.
#[test]
fn a_changed_interface_changes_its_page() {
    let mut interfaces = vec![Interface::example()];
    let page = |interfaces: &[Interface]| page::all(interfaces).remove("example.md").expect("a page");
    let before = page(&interfaces);
    interfaces[0].published[0].qos = Qos::latched(2);
    let after = page(&interfaces);
    assert!(before.contains("| reliable, transient local, 1 |") && after.contains("| reliable, transient local, 2 |"));
    interfaces[0].services.clear();
    assert!(after.contains("`~/stop`") && !page(&interfaces).contains("`~/stop`"));
    let with_default = |value: f64| {
        let parameter =
            camwright_ros::Parameter::double("rate", value).describe("rate of the example (Hz)").range(1.0, 9.0);
        page(&[Interface { parameters: vec![parameter], ..Interface::example() }])
    };
    assert!(with_default(2.0).contains("| `rate` | double | `2.0` | 1 to 9 | Hz |"), "{}", with_default(2.0));
    assert_ne!(with_default(2.0), with_default(3.0));
}

#[test]
fn the_page_of_types_has_every_field() {
    let page = interface_files::page();
    for row in [
        "| `form_error_max` | `float64` | ",
        "| `holder` | `string` | ",
        "| `EXECUTING` | 2 | ",
        "| `percent` | `float64` | ",
    ] {
        assert!(page.contains(row), "{row}");
    }
    assert!(page.lines().count() > 1000, "only {} lines", page.lines().count());
}

/// A client without command publishes on every topic that the pages call closed; the node refuses the message.
#[test]
fn topics_that_need_command_refuse_a_client_without_it() {
    let mut cell = crate::cell::Cell::start(&[]);
    cell.release();
    let node = Node::new(NodeOptions::new("stranger", &RosArgs::default().with_domain_id(cell.domain().id())));
    let node = node.expect("a node");
    let (sender, lines) = mpsc::channel();
    let _log = node.subscribe("/rosout", &Qos::latched(1000), move |log: Log, _| drop(sender.send(log.msg)));
    let _spin = node.spin_in_thread().expect("a thread");
    let trajectories =
        |topic: &str| node.publisher::<JointTrajectory>(topic, &Qos::default_topic()).expect("a publisher");
    let [setpoints, trajectory] = ["machine/setpoints", "axis_interpolator/joint_trajectory"].map(trajectories);
    let commands = node.publisher::<MachineCommand>("machine/commands", &Qos::default_topic()).expect("a publisher");
    let scaling = node.publisher::<SpeedScalingFactor>("axis_interpolator/speed_scaling_input", &Qos::latched(1));
    let scaling = scaling.expect("a publisher");
    let held = node.publisher::<Empty>("axis_interpolator/hold_to_run", &Qos::default_topic()).expect("a publisher");
    let mut expected: Vec<&str> = texts::topics_that_need_command().collect();
    assert_eq!(expected.len(), 5, "this test publishes on five topics, the pages name {expected:?}");
    let deadline = Instant::now() + PATIENCE;
    while !expected.is_empty() {
        assert!(Instant::now() < deadline, "{expected:?} are not refused");
        // A reader may meet its writer later than the writer the reader: what comes before is lost.
        for publisher in [&setpoints, &trajectory] {
            publisher.publish(&JointTrajectory::default()).expect("sent");
        }
        commands.publish(&MachineCommand::default()).expect("sent");
        scaling.publish(&SpeedScalingFactor { factor: 0.5 }).expect("sent");
        held.publish(&Empty::default()).expect("sent");
        while let Ok(line) = lines.recv_timeout(REPETITION) {
            expected.retain(|topic| !line.contains(&format!("{topic} of /stranger refused")));
        }
    }
    node.shutdown();
    cell.stop();
}
