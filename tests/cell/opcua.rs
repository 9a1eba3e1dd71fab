// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright gateway --opcua`: asyncua browses the machine, follows a whole run whose history is that of the bag, and changes nothing.

use crate::gateway::{
    MACHINE, NAMESPACE, SHORT, address_of, deduplicated, gateway_with, is_in_the_bag, run_camwright as camwright,
};
use crate::hal::messages;
use crate::support;

use camwright_bag::Bag;
use camwright_msgs::camwright_msgs::msg::{CellState, InterpolatorState, MachineAlarms};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::net::TcpListener;
use std::time::Instant;
use support::processes::{Processes, fresh_bag};
use support::{Domain, Guarded, PATIENCE, Peer, ua_client_env};

const ITEM_STATE: &str = "MachineryBuildingBlocks/MachineryItemState/CurrentState";
const PROGRAM_STATE: &str = "Production/ActiveProgram/State/CurrentState";
const PROGRAM_NAME: &str = "Production/ActiveProgram/Name";
const CHANNEL_STATE: &str = "Monitoring/Channel/ChannelState";
const RUNS_COMPLETED: &str = "Production/ProductionPlan/Job/RunsCompleted";
const CELL_STATE: &str = "Cell/State";
const ALARM_NUMBERS: &str = "Notification/ActiveAlarms/Numbers";
const X_POSITION: &str = "Axes/X/Position";
const PARTS: &str = "MachineryBuildingBlocks/OperationCounters/PartsProducedInLifetime";

/// `MachineryItemState` and `ActiveProgram.State` of the states 1 to 17, from the standards' meaning of the words.
const STATES: [(&str, &str); 17] = [
    ("OutOfService", "Aborted"),      // CLEARING
    ("NotExecuting", "Aborted"),      // STOPPED
    ("NotExecuting", "Initializing"), // STARTING
    ("NotExecuting", "Initializing"), // IDLE
    ("NotExecuting", "Interrupted"),  // SUSPENDED
    ("Executing", "Running"),         // EXECUTE
    ("NotExecuting", "Aborted"),      // STOPPING
    ("OutOfService", "Aborted"),      // ABORTING
    ("OutOfService", "Aborted"),      // ABORTED
    ("NotExecuting", "Interrupted"),  // HOLDING
    ("NotExecuting", "Interrupted"),  // HELD
    ("Executing", "Running"),         // UNHOLDING
    ("NotExecuting", "Interrupted"),  // SUSPENDING
    ("Executing", "Running"),         // UNSUSPENDING
    ("NotExecuting", "Initializing"), // RESETTING
    ("Executing", "Running"),         // COMPLETING
    ("NotExecuting", "Ended"),        // COMPLETE
];

/// A client with the histories of what it subscribed to.
struct Client {
    peer: Peer,
    /// Values and status of every variable, without repetitions.
    values: BTreeMap<String, Vec<(Value, String)>>,
    alerts: Vec<Value>,
}

impl Client {
    fn connect(peer: Peer) -> Self {
        Self { peer, values: BTreeMap::new(), alerts: Vec::new() }
    }

    fn subscribe(&mut self, paths: &[&str]) {
        let answer = self.peer.ask("subscribe", json!({ "paths": paths }));
        assert_eq!(answer["accepted"], paths.len(), "{answer}");
        self.peer.ask("alerts", json!({}));
    }

    /// Receives notifications until something is so.
    fn until(&mut self, what: &str, wanted: impl Fn(&Self) -> bool) {
        let deadline = Instant::now() + PATIENCE;
        loop {
            for event in self.peer.events_so_far("data") {
                let status = event["status"].as_str().expect("a status").to_owned();
                assert!(event["time"].as_f64().is_some_and(|time| time > 1.7e9), "a source time: {event}");
                let path = event["path"].as_str().expect("a path").to_owned();
                let history = self.values.entry(path).or_default();
                let new = (event["value"].clone(), status);
                if history.last() != Some(&new) {
                    history.push(new);
                }
            }
            self.alerts.extend(self.peer.events_so_far("alert"));
            if wanted(self) {
                return;
            }
            assert!(Instant::now() < deadline, "{what}: {:?} {:?}", self.values, self.alerts);
        }
    }

    fn last(&self, path: &str) -> Option<&(Value, String)> {
        self.values.get(path).and_then(|history| history.last())
    }

    fn is(&self, path: &str, value: impl Into<Value>) -> bool {
        let expected = value.into();
        self.last(path).is_some_and(|(value, status)| *value == expected && status == "Good")
    }

    fn is_lost(&self, path: &str) -> bool {
        self.last(path).is_some_and(|(value, status)| value.is_null() && status == "BadNoCommunication")
    }

    /// Good values, without repetitions.
    fn history(&self, path: &str) -> Vec<Value> {
        let good = self.values[path].iter().filter(|(_, status)| status == "Good").map(|(value, _)| value.clone());
        deduplicated(good)
    }
}

/// Waits for the address of the OPC UA server that the gateway prints.
fn url(gateway: &Guarded) -> String {
    address_of(gateway, "OPC UA server: ")
}

fn as_values(words: impl Iterator<Item = &'static str>) -> Vec<Value> {
    deduplicated(words.map(Value::from))
}

#[test]
fn the_history_of_a_run_is_that_of_the_bag() {
    let Some(env) = ua_client_env() else { return };
    let (domain, bag) = (Domain::reserve(), fresh_bag("opcua"));
    let nameplate = ["--opcua", "0", "--manufacturer", "Example works", "--serial-number", "7"];
    let mut gateway = gateway_with(&domain, 0, &nameplate);
    let mut client = Client::connect(env.connect(&url(&gateway)));
    let browsed = client.peer.ask("browse", json!({}));
    assert_eq!(browsed["machine"], "plant");
    let tree = &browsed["tree"];
    let tool = "http://opcfoundation.org/UA/MachineTool/";
    assert_eq!(tree["Monitoring/Channel"]["type"], json!([tool, 16]), "{tree}");
    assert_eq!(tree["Production/ActiveProgram/State"]["type"], json!([tool, 15]));
    assert_eq!(tree["Identification"]["namespace"], "http://opcfoundation.org/UA/DI/");
    assert_eq!(tree["Monitoring/MachineTool/MachineryItemState/CurrentState"]["class"], "Variable");
    assert_eq!(tree["Cell/State"]["namespace"], "urn:camwright:cell:plant");
    let mut read = |path: &str| client.peer.ask("read", json!({ "path": path }));
    assert_eq!(read("Identification/SerialNumber")["value"], "7");
    assert_eq!(read("Identification/Manufacturer")["value"], "Example works");
    assert_eq!(read("Identification/ProductInstanceUri")["value"], "urn:camwright:cell:plant");
    assert_eq!(read("Axes/X/Position/EngineeringUnits")["value"], json!({ "unit": "mm", "id": 5_066_068 }));
    assert_eq!(read("Monitoring/Channel/FeedOverride/EURange")["value"], json!({ "low": 0.0, "high": 100.0 }));
    assert_eq!(read(X_POSITION)["status"], "BadNoCommunication");
    let kind = client.peer.ask("enumeration", json!({ "path": CHANNEL_STATE }));
    assert_eq!(kind["name"], "ChannelState");
    let names = [(0, "Active"), (1, "Interrupted"), (2, "Reset")];
    assert_eq!(kind["values"], json!(names.map(|(value, name)| json!({ "value": value, "name": name }))));
    let paths = [
        ITEM_STATE,
        PROGRAM_STATE,
        PROGRAM_NAME,
        CHANNEL_STATE,
        RUNS_COMPLETED,
        CELL_STATE,
        ALARM_NUMBERS,
        X_POSITION,
        PARTS,
        "Monitoring/Spindle/IsRotating",
        "Axes/C/Position",
        "Cell/EmergencyStop",
    ];
    client.subscribe(&paths);
    client.until("everything is lost", |client| paths.iter().all(|path| client.is_lost(path)));

    let mut cell = Processes::start_without_command(&domain, NAMESPACE, &MACHINE, &bag);
    client.until("the cell is there", |client| {
        let is_known = |path: &&str| client.last(path).is_some_and(|(_, status)| status == "Good");
        [CELL_STATE, CHANNEL_STATE, X_POSITION, ALARM_NUMBERS, PARTS].iter().all(is_known)
    });
    let set: Vec<&str> = SHORT.iter().flat_map(|over| ["--set", over]).collect();
    let start = ["fleet", "start", "eccentric", "--patience", "90", "--cell", NAMESPACE];
    camwright(&domain, &[&start[..], &set].concat());
    client.until("the run is complete", |client| {
        client.is(PROGRAM_STATE, "Ended") && client.is(RUNS_COMPLETED, 1) && client.is(PARTS, 1)
    });
    assert!(client.is(PROGRAM_NAME, "eccentric"));
    assert!(client.history("Monitoring/Spindle/IsRotating").contains(&Value::from(true)));
    let angles = client.history("Axes/C/Position").into_iter().filter_map(|value| value.as_f64()).map(f64::abs);
    assert!(angles.fold(0.0, f64::max) > 360.0, "C went round");

    // A read-only server.
    let mut write = |order: Value| client.peer.ask("write", order)["refused"].take();
    for (path, kind, value) in [
        (PROGRAM_NAME, "String", json!("another")),
        (RUNS_COMPLETED, "UInt32", json!(7)),
        ("Identification/SerialNumber", "String", json!("8")),
        ("Monitoring/MachineTool/FeedOverride", "Double", json!(100.0)),
    ] {
        let refused = write(json!({ "path": path, "type": kind, "value": value }));
        assert!(["BadNotWritable", "BadUserAccessDenied"].contains(&refused.as_str().unwrap_or_default()), "{refused}");
    }
    let name = json!({ "path": PROGRAM_NAME, "attribute": "AccessLevel", "type": "Byte", "value": 3 });
    assert_eq!(write(name), "BadNotWritable");

    // An alarm and its reset.
    camwright(&domain, &["estop"]);
    client.until("the alarm is active", |client| {
        client.is(ALARM_NUMBERS, json!([1])) && client.is(ITEM_STATE, "OutOfService") && !client.alerts.is_empty()
    });
    camwright(&domain, &["estop", "--release"]);
    camwright(&domain, &["reset"]);
    client.until("the alarm is reset", |client| client.is(ALARM_NUMBERS, json!([])) && client.alerts.len() > 1);
    let alert = |alert: &Value| {
        (alert["ErrorCode"].clone(), alert["Severity"].clone(), alert["Retain"].clone(), alert["SourceName"].clone())
    };
    let of_estop: Vec<_> = client.alerts.iter().filter(|alert| alert["ErrorCode"] == "1").map(alert).collect();
    let expected = |retain: bool| (json!("1"), json!(900), json!(retain), of_estop[0].3.clone());
    assert_eq!(of_estop, [expected(true), expected(false)], "{:?}", client.alerts);
    let seen = [ITEM_STATE, PROGRAM_STATE, CELL_STATE, CHANNEL_STATE, RUNS_COMPLETED, ALARM_NUMBERS]
        .map(|path| (path, client.history(path)));

    // A machine that dies without leaving the graph is lost, the planner is not.
    cell.kill("machine_sim");
    client.until("a dead machine is lost", |client| {
        [X_POSITION, PARTS, ALARM_NUMBERS].iter().all(|path| client.is_lost(path))
    });
    assert_eq!(client.last(CELL_STATE).map(|(_, status)| status.as_str()), Some("Good"));
    assert_eq!(client.peer.ask("read", json!({ "path": X_POSITION }))["status"], "BadNoCommunication");
    cell.restart("machine_sim", &domain, NAMESPACE);
    client.until("the new machine has made no part", |client| client.is(PARTS, 0));
    let bag = cell.end();
    client.until("everything is lost at the end", |client| paths.iter().all(|path| client.is_lost(path)));
    // The client is connected.
    gateway.interrupt();
    assert_eq!(gateway.wait(PATIENCE).code(), Some(0), "{}", gateway.complaint());

    let read = Bag::open(&bag).expect("a bag");
    let topic = |name: &str| format!("{NAMESPACE}/{name}");
    let states: Vec<CellState> = messages(&read, &topic("job_planner/cell_state"));
    let word = |state: &CellState| STATES[usize::from(state.state) - 1];
    let interpolator: Vec<InterpolatorState> = messages(&read, &topic("axis_interpolator/state"));
    let channel = |state: &InterpolatorState| [2, 0, 1, 1, 0, 0, 2][usize::from(state.state)];
    let lists: Vec<MachineAlarms> = messages(&read, &topic("machine/alarms"));
    let numbers = |list: &MachineAlarms| json!(list.alarms.iter().map(|alarm| alarm.number).collect::<Vec<u16>>());
    let recorded = [
        as_values(states.iter().map(|state| word(state).0)),
        as_values(states.iter().map(|state| word(state).1)),
        deduplicated(states.iter().map(|state| Value::from(state.state_name.clone()))),
        deduplicated(interpolator.iter().map(|state| Value::from(channel(state)))),
        deduplicated(states.iter().map(|state| Value::from(state.parts_done))),
        deduplicated(lists.iter().map(numbers)),
    ];
    for ((path, seen), bag) in seen.iter().zip(&recorded) {
        is_in_the_bag(path, seen, bag);
    }
    assert!(seen[4].1.ends_with(&[Value::from(0), Value::from(1)]), "one part is done: {:?}", seen[4].1);
    let program = &seen[1].1;
    assert!(program.len() >= 4 && program.contains(&Value::from("Running")), "{program:?}");
    assert!(seen[3].1.contains(&Value::from(0)), "the channel was active: {:?}", seen[3].1);
    std::fs::remove_dir_all(bag).expect("the bag is ours");
}

#[test]
fn a_port_in_use_is_one_error_and_off_is_the_default() {
    let (domain, taken) = (Domain::reserve(), TcpListener::bind("127.0.0.1:0").expect("a port"));
    let port = taken.local_addr().expect("an address").port();
    let mut refused = gateway_with(&domain, 0, &["--opcua", &port.to_string()]);
    assert_eq!(refused.wait(PATIENCE).code(), Some(1));
    let text = refused.stderr();
    let expected = format!("the OPC UA server cannot be served at 127.0.0.1:{port}: ");
    assert!(text.contains(&expected) && text.contains("choose another port"), "{text}");
    assert_eq!(text.trim_end().lines().count(), 1, "{text}");

    let mut plain = gateway_with(&domain, 0, &[]);
    let _adapter = address_of(&plain, "MTConnect adapter: ");
    plain.interrupt();
    assert_eq!(plain.wait(PATIENCE).code(), Some(0), "{}", plain.complaint());
    assert!(!plain.stderr().contains("OPC UA"), "{}", plain.stderr());
    let mut refused = gateway_with(&domain, 0, &["--serial-number", "7"]);
    assert_eq!(refused.wait(PATIENCE).code(), Some(2), "{}", refused.stderr());
}
