//! `/diagnostics` of a running cell: what every node says of itself, and that a level goes up and comes down again.

#[path = "support/cell.rs"]
mod cell;
mod support;

use camwright_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, Trigger, TriggerRequest};
use camwright_nodes::ros::Qos;
use cell::{Cell, PATIENCE};
use std::collections::BTreeMap;
use std::sync::mpsc;
use std::time::Instant;

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

    let estop = |data: bool| assert!(cell.client.call::<SetBool>("machine/estop", &SetBoolRequest { data }).success);
    estop(true);
    told.until("an alarm", |last| last["machine_sim"].level == DiagnosticStatus::ERROR);
    assert!(told.last["machine_sim"].message.contains("need a reset"), "{:?}", told.last["machine_sim"]);
    estop(false);
    // Refused until the axes have come to rest.
    let deadline = Instant::now() + PATIENCE;
    while !cell.client.call::<Trigger>("machine/reset", &TriggerRequest::default()).success {
        assert!(Instant::now() < deadline, "the machine cannot be reset");
    }
    told.until("all is well again", |last| last["machine_sim"].level == DiagnosticStatus::OK);
    cell.stop();
}
