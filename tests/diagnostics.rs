//! How a running cell is: what every node says of itself on `/diagnostics`, with levels that go up and come down again, and what
//! `camwright status` tells from a second shell.

#[path = "support/cell.rs"]
mod cell;
mod support;

use camwright_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, Trigger, TriggerRequest};
use camwright_nodes::ros::Qos;
use cell::{Cell, PATIENCE};
use std::collections::BTreeMap;
use std::process::Command;
use std::sync::mpsc;
use std::time::Instant;
use support::Domain;

struct Told {
    arrays: mpsc::Receiver<DiagnosticArray>,
    last: BTreeMap<String, DiagnosticStatus>,
}

impl Told {
    /// Listens until what was told is as wanted.
    fn until(&mut self, what: &str, wanted: impl Fn(&BTreeMap<String, DiagnosticStatus>) -> bool) {
        while !wanted(&self.last) {
            let array = self.arrays.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("{what}: {:?}", self.last));
            self.last.extend(array.status.into_iter().map(|status| (status.name.clone(), status)));
        }
    }
}

/// What `camwright status` says of the cell: exit code and output.
fn status(cell: &Cell, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.env("ROS_DOMAIN_ID", cell.domain().id().to_string()).arg("status").args(arguments);
    let output = command.output().expect("it runs");
    (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
}

#[test]
fn of_a_cell_that_is_not_there_status_says_where_it_looked() {
    let domain = Domain::take();
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.env("ROS_DOMAIN_ID", domain.id().to_string()).args(["status", "--patience", "0.3"]);
    let output = command.output().expect("it runs");
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!((output.status.code(), output.stdout.len()), (Some(1), 0));
    assert!(told.contains("no machine was heard within 0.3 s") && told.contains("ROS_DOMAIN_ID"), "{told}");
}

#[test]
fn every_node_tells_of_itself_and_levels_follow_what_happens() {
    let cell = Cell::start(&[]);
    let (sender, arrays) = mpsc::channel();
    let heard = move |array, _: &_| drop(sender.send(array));
    let _subscription = cell.client.node.subscribe("/diagnostics", &Qos::default_topic().keep_last(100), heard);
    let mut told = Told { arrays, last: BTreeMap::new() };
    let names = [
        "axis_interpolator",
        "axis_interpolator: machine",
        "job_planner",
        "machine_sim",
        "machine_sim: drives",
        "machine_sim: setpoints",
        "machine_sim: wheel",
    ];
    told.until("every status", |last| names.iter().all(|name| last.contains_key(*name)));
    let found: Vec<&str> = told.last.keys().map(String::as_str).collect();
    assert_eq!(found, names, "and no other, with names that do not change");
    told.until("all is well", |last| last.values().all(|status| status.level == DiagnosticStatus::OK));
    for status in told.last.values() {
        assert!(!status.message.is_empty() && !status.hardware_id.is_empty(), "{status:?}");
    }
    let value = |status: &DiagnosticStatus, key: &str| {
        status.values.iter().find(|value| value.key == key).map(|value| value.value.clone())
    };
    assert_eq!(value(&told.last["machine_sim: wheel"], "wear_since_dress_um").as_deref(), Some("0.00"));
    assert_eq!(value(&told.last["axis_interpolator: machine"], "lost").as_deref(), Some("0"));

    let (code, text) = status(&cell, &[]);
    assert_eq!(code, Some(0), "{text}");
    for words in [
        "cell      /  cam_grinder",
        "state     ",
        "x_axis",
        "nobody has command",
        "override 100 %",
        "recorder  not there",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }

    let estop = |data: bool| assert!(cell.client.call::<SetBool>("machine/estop", &SetBoolRequest { data }).success);
    estop(true);
    told.until("an alarm", |last| last["machine_sim"].level == DiagnosticStatus::ERROR);
    assert!(told.last["machine_sim"].message.contains("need a reset"), "{:?}", told.last["machine_sim"]);
    let (code, text) = status(&cell, &["--json"]);
    let json: serde_json::Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"));
    assert_eq!((code, &json["alarms"][0]["number"]), (Some(3), &serde_json::json!(1)), "{text}");
    estop(false);
    // Refused until the axes have come to rest.
    let deadline = Instant::now() + PATIENCE;
    while !cell.client.call::<Trigger>("machine/reset", &TriggerRequest::default()).success {
        assert!(Instant::now() < deadline, "the machine cannot be reset");
    }
    told.until("all is well again", |last| last["machine_sim"].level == DiagnosticStatus::OK);
    cell.stop();
}
