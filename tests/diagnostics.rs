//! How a running cell is: what every node says of itself on `/diagnostics`, with levels that go up and come down again, and what
//! `camwright status` tells from a second shell.

#[path = "support/cell.rs"]
mod cell;
mod support;
#[path = "support/watched.rs"]
mod watched;

use camwright_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, Trigger, TriggerRequest};
use camwright_nodes::ros::{ParameterValue, Qos, Subscription};
use cell::{Cell, PATIENCE};
use std::collections::BTreeMap;
use std::process::Command;
use std::sync::mpsc;
use std::time::Instant;
use support::Domain;
use watched::LogLines;

struct Told {
    arrays: mpsc::Receiver<DiagnosticArray>,
    last: BTreeMap<String, DiagnosticStatus>,
    _subscription: Subscription,
}

fn value(status: &DiagnosticStatus, key: &str) -> Option<String> {
    status.values.iter().find(|value| value.key == key).map(|value| value.value.clone())
}

impl Told {
    fn of(cell: &Cell) -> Self {
        let (sender, arrays) = mpsc::channel();
        let heard = move |array, _: &_| drop(sender.send(array));
        let subscription = cell.client.node.subscribe("/diagnostics", &Qos::default_topic().keep_last(100), heard);
        Told { arrays, last: BTreeMap::new(), _subscription: subscription.expect("a subscription") }
    }

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
    let mut told = Told::of(&cell);
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

/// Scheduling of the threads of this process that have a name, as the kernel tells it: policy and real-time priority.
fn scheduled(name: &str) -> Vec<(u32, u32)> {
    let tasks = std::fs::read_dir("/proc/self/task").expect("Linux tells of threads");
    let stats = tasks.filter_map(|task| std::fs::read_to_string(task.expect("a thread").path().join("stat")).ok());
    let of_name = stats.filter(|stat| stat.contains(&format!("({name})")));
    of_name
        .map(|stat| {
            // Behind the name, which may hold blanks, comes the third field.
            let fields: Vec<&str> = stat.rsplit(')').next().expect("fields").split_whitespace().collect();
            let number = |field: usize| fields[field - 3].parse().expect("a number");
            (number(41), number(40))
        })
        .collect()
}

/// With the right to it the cycle has its priority; without it that is said, with what to do, and the cell works all the same.
#[test]
fn a_cycle_that_asks_for_a_real_time_priority_has_it_or_it_is_told_why_not() {
    const FIFO: u32 = 1;
    let cell = Cell::start_with(&[], |args| {
        args.with_parameter(Some("machine_sim"), "pace", ParameterValue::String("realtime".into())).with_parameter(
            Some("machine_sim"),
            "cyclic_priority",
            ParameterValue::Integer(5),
        )
    });
    let log = LogLines::of(&cell);
    let mut told = Told::of(&cell);
    told.until("the machine", |last| last.contains_key("machine_sim"));
    let told = value(&told.last["machine_sim"], "scheduling").expect("it is told");
    match scheduled("machine cycle").contains(&(FIFO, 5)) {
        true => assert_eq!(told, "SCHED_FIFO 5"),
        false => {
            assert_eq!(told, "ordinary");
            log.line(&["cyclic_priority 5 is refused", "`ulimit -r 5`"]);
        }
    }
    cell.stop();
}
