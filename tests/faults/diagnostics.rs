// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Health of a running cell: the status of every node on `/diagnostics`, with levels that go up and come down again, and the output of
//! `camwright status` in a second shell.

use crate::cell;
use crate::support;
use crate::watched;

use camwright_msgs::camwright_msgs::action::RunJobFeedback;
use camwright_msgs::camwright_msgs::srv::{ValidateJob, ValidateJobRequest};
use camwright_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus};
use camwright_msgs::lifecycle_msgs::msg::{Transition, TransitionEvent};
use camwright_msgs::lifecycle_msgs::srv::{ChangeState, ChangeStateRequest};
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, Trigger, TriggerRequest};
use camwright_ros::{GoalStatus, Node, NodeOptions, ParameterValue, Qos, RosArgs, Subscription};
use cell::{Cell, PATIENCE};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::time::Instant;
use support::{Domain, Guarded};
use watched::LogLines;

struct DiagnosticsListener {
    arrays: mpsc::Receiver<DiagnosticArray>,
    last: BTreeMap<String, DiagnosticStatus>,
    _subscription: Subscription,
}

fn value(status: &DiagnosticStatus, key: &str) -> Option<String> {
    status.values.iter().find(|value| value.key == key).map(|value| value.value.clone())
}

impl DiagnosticsListener {
    fn subscribe(cell: &Cell) -> Self {
        let (sender, arrays) = mpsc::channel();
        let on_message = move |array, _: &_| drop(sender.send(array));
        let subscription = cell.client.node.subscribe("/diagnostics", &Qos::default_topic().keep_last(100), on_message);
        DiagnosticsListener { arrays, last: BTreeMap::new(), _subscription: subscription.expect("a subscription") }
    }

    /// Listens until the status is as wanted.
    fn until(&mut self, what: &str, wanted: impl Fn(&BTreeMap<String, DiagnosticStatus>) -> bool) {
        while !wanted(&self.last) {
            let array = self.arrays.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("{what}: {:?}", self.last));
            self.last.extend(array.status.into_iter().map(|status| (status.name.clone(), status)));
        }
    }
}

/// Exit code and output of `camwright status`.
fn status(cell: &Cell, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.env("ROS_DOMAIN_ID", cell.domain().id().to_string()).arg("status").args(arguments);
    let output = command.output().expect("it runs");
    (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
}

/// In a cut the status names the lobe, all lobes of its job, and the running wheel; a reader may close the pipe before the status is printed.
#[test]
fn status_in_a_cut_names_lobe_and_wheel() {
    let cell = Cell::start(&[]);
    let (goal, feedback) = cell.client.send("four_lobe_camshaft", &[]);
    assert!(goal.accepted());
    let in_cut =
        |feedback: &RunJobFeedback| feedback.lobe_count == 4 && feedback.lobe_index == 0 && feedback.turn > 0.0;
    while !in_cut(&feedback.recv_timeout(PATIENCE).expect("the job goes on")) {}
    let request = SetBoolRequest { data: true };
    assert!(cell.client.call::<SetBool>("axis_interpolator/feed_hold", &request).success, "the job is held");
    let (code, text) = status(&cell, &[]);
    assert_eq!(code, Some(0), "{text}");
    for words in ["of 4)", ", runs\n", "command   the test", "motion    plan ", ", held"] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.env("ROS_DOMAIN_ID", cell.domain().id().to_string()).arg("status");
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it runs");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    goal.cancel(PATIENCE).expect("an answer");
    goal.result(PATIENCE).expect("a result");
}

/// One node as a process in which a thread panics at its next piece of work.
fn node_with_a_dying_thread(binary: &str, thread: &str, domain: &Domain, parameters: &[&str]) -> Guarded {
    let mut command = Command::new(binary);
    command.env("ROS_DOMAIN_ID", domain.id().to_string()).env("CAMWRIGHT_TEST_PANIC", thread).arg("--ros-args");
    // A backtrace takes longer than the planner lets a client wait.
    command.env("RUST_BACKTRACE", "0");
    for parameter in parameters {
        command.args(["-p", parameter]);
    }
    Guarded::start(thread, &mut command)
}

/// A client gets an error, everybody a diagnostic and the state of the node, and the process ends with an exit code: no node looks alive
/// without the thread that does its work.
#[test]
fn a_thread_that_dies_is_reported_and_ends_its_process() {
    let domain = Domain::reserve();
    let node = Node::new(NodeOptions::new("watcher", &RosArgs::default().with_domain_id(domain.id()))).expect("a node");
    // Announced before the diagnostics: a writer that knows their reader knows this one too.
    let (sender, states) = mpsc::channel();
    let on_message = move |event: TransitionEvent, _: &_| drop(sender.send(event.goal_state.label));
    let events = "job_planner/transition_event";
    let _events = node.subscribe(events, &Qos::default_topic().keep_last(100), on_message).expect("a subscription");
    let (sender, diagnostics) = mpsc::channel();
    let on_message =
        move |array: DiagnosticArray, _: &_| array.status.into_iter().for_each(|status| drop(sender.send(status)));
    let _diagnostics =
        node.subscribe("/diagnostics", &Qos::default_topic().keep_last(100), on_message).expect("a subscription");
    let validate = node.client::<ValidateJob>("job_planner/validate_job").expect("a client");
    let _spinning = node.spin_in_thread().expect("a thread");
    let mut planner = node_with_a_dying_thread(env!("CARGO_BIN_EXE_job_planner"), "planning", &domain, &[]);
    validate.wait_for_service(PATIENCE).expect("the planner offers it");
    // A planner that dies before it knows the readers reaches none of them.
    diagnostics.recv_timeout(PATIENCE).expect("a first diagnostic of the planner");
    let request = ValidateJobRequest { job: "eccentric".into(), ..ValidateJobRequest::default() };
    let answer = validate.call(&request, PATIENCE).expect("it is answered");
    assert!(!answer.success && answer.message.starts_with("no answer is possible"), "{}", answer.message);
    let status = planner.wait(PATIENCE);
    assert_eq!(status.code(), Some(101), "{}", planner.complaint());
    assert!(planner.stderr().contains("thread planning was ended by a defect"), "{}", planner.stderr());
    let error = loop {
        let status: DiagnosticStatus = diagnostics.recv_timeout(PATIENCE).expect("a diagnostic of the error");
        if status.level == DiagnosticStatus::ERROR {
            break status.message;
        }
    };
    assert!(error.starts_with("thread planning was ended by a defect"), "{error}");
    while states.recv_timeout(PATIENCE).expect("a transition") != "errorprocessing" {}

    let machine = env!("CARGO_BIN_EXE_machine_sim");
    for thread in ["machine cycle", "machine pump"] {
        let mut machine = node_with_a_dying_thread(machine, thread, &domain, &["pace:=fast", "state_file:=none"]);
        assert_eq!(machine.wait(PATIENCE).code(), Some(101), "{thread}{}", machine.complaint());
    }
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("dying-writer-{}", std::process::id()));
    let bag = format!("bag_dir:={}", directory.display());
    let mut logger = node_with_a_dying_thread(env!("CARGO_BIN_EXE_run_logger"), "bag writer", &domain, &[&bag]);
    assert_eq!(logger.wait(PATIENCE).code(), Some(101), "{}", logger.complaint());
}

#[test]
fn status_without_a_cell_reports_where_it_searched() {
    let domain = Domain::reserve();
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.env("ROS_DOMAIN_ID", domain.id().to_string()).args(["status", "--patience", "0.3"]);
    let output = command.output().expect("it runs");
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!((output.status.code(), output.stdout.len()), (Some(1), 0));
    assert!(stderr.contains("no machine found within 0.3 s") && stderr.contains("ROS_DOMAIN_ID"), "{stderr}");
}

#[test]
fn every_node_publishes_diagnostics_and_levels_follow_events() {
    let cell = Cell::start(&[]);
    let mut diagnostics = DiagnosticsListener::subscribe(&cell);
    let names = [
        "axis_interpolator",
        "axis_interpolator: machine",
        "job_planner",
        "machine_sim",
        "machine_sim: drives",
        "machine_sim: setpoints",
        "machine_sim: telemetry",
        "machine_sim: wheel",
    ];
    diagnostics.until("every status", |last| names.iter().all(|name| last.contains_key(*name)));
    let found: Vec<&str> = diagnostics.last.keys().map(String::as_str).collect();
    assert_eq!(found, names, "and no other, with names that do not change");
    diagnostics.until("all is well", |last| last.values().all(|status| status.level == DiagnosticStatus::OK));
    for status in diagnostics.last.values() {
        assert!(!status.message.is_empty() && !status.hardware_id.is_empty(), "{status:?}");
    }
    assert_eq!(value(&diagnostics.last["machine_sim: wheel"], "wear_since_dress_um").as_deref(), Some("0.00"));
    assert_eq!(value(&diagnostics.last["axis_interpolator: machine"], "lost").as_deref(), Some("0"));

    let (code, text) = status(&cell, &[]);
    assert_eq!(code, Some(0), "{text}");
    for words in [
        "cell      /  cam_grinder",
        "state     ",
        "x_axis",
        "command   the test (shared",
        "motion    none, not homed, override 100 %",
        "recorder  none",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }

    let estop = |data: bool| assert!(cell.client.call::<SetBool>("machine/estop", &SetBoolRequest { data }).success);
    estop(true);
    diagnostics.until("an alarm", |last| last["machine_sim"].level == DiagnosticStatus::ERROR);
    assert!(diagnostics.last["machine_sim"].message.contains("need a reset"), "{:?}", diagnostics.last["machine_sim"]);
    let (code, text) = status(&cell, &["--json"]);
    let json: serde_json::Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"));
    assert_eq!((code, &json["alarms"][0]["number"]), (Some(3), &serde_json::json!(1)), "{text}");
    estop(false);
    // Refused until the axes have come to rest.
    let deadline = Instant::now() + PATIENCE;
    while !cell.client.call::<Trigger>("machine/reset", &TriggerRequest::default()).success {
        assert!(Instant::now() < deadline, "the machine cannot be reset");
    }
    diagnostics.until("all is well again", |last| last["machine_sim"].level == DiagnosticStatus::OK);
    cell.stop();
}

/// A job without a fault raises no ERROR, although the table needs nearly the whole force of its drive to speed up.
#[test]
fn a_healthy_job_holds_no_error_in_its_diagnostics() {
    let cell = Cell::start(&[]);
    let mut diagnostics = DiagnosticsListener::subscribe(&cell);
    diagnostics.until("every node", |last| {
        ["machine_sim: drives", "axis_interpolator", "job_planner"].iter().all(|name| last.contains_key(*name))
    });
    let short = ["wheel_radius_mm=60.0", "infeed.per_block_um=0.05", "infeed.spark_out_turns=6"];
    let (job, _) = cell.client.send("eccentric", &short);
    assert!(job.accepted());
    let (sender, ended) = mpsc::channel();
    job.result_with(move |status, result| drop(sender.send((status, result)))).expect("a result will come");
    let (mut force_percent, mut outcome, mut after) = (0.0_f64, None, 0);
    // Two more reports of the machine cover the end of the job.
    while after < 2 {
        let array = diagnostics.arrays.recv_timeout(PATIENCE).expect("a report every second");
        after += u32::from(outcome.is_some() && array.status.iter().any(|status| status.name == "machine_sim: drives"));
        for status in array.status {
            assert!(status.level < DiagnosticStatus::ERROR, "{}: {}", status.name, status.message);
            let forces = status.values.iter().filter(|pair| pair.key.ends_with("_force_percent"));
            force_percent = forces.filter_map(|pair| pair.value.parse().ok()).fold(force_percent, f64::max);
        }
        outcome = outcome.or_else(|| ended.try_recv().ok());
    }
    let (status, result) = outcome.expect("the loop ends after it");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    println!("largest force in the job: {force_percent} % of its drive");
    assert!(force_percent >= 90.0, "the job has no motion that needs a whole drive: {force_percent} %");
    cell.stop();
}

/// Scheduling of the threads of this process with this name, as the kernel reports it: policy and real-time priority.
fn scheduled(name: &str) -> Vec<(u32, u32)> {
    let tasks = std::fs::read_dir("/proc/self/task").expect("Linux lists threads");
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
fn a_requested_real_time_priority_is_set_or_the_reason_is_reported() {
    const FIFO: u32 = 1;
    let cell = Cell::start_with(&[], |args| {
        args.with_parameter(Some("machine_sim"), "pace", ParameterValue::String("realtime".into())).with_parameter(
            Some("machine_sim"),
            "cyclic_priority",
            ParameterValue::Integer(5),
        )
    });
    let log = LogLines::subscribe(&cell);
    let mut diagnostics = DiagnosticsListener::subscribe(&cell);
    diagnostics.until("the machine", |last| last.contains_key("machine_sim"));
    let others = value(&diagnostics.last["machine_sim"], "scheduling_of_other_threads").expect("it is reported");
    let scheduling = value(&diagnostics.last["machine_sim"], "scheduling").expect("it is reported");
    match scheduled("machine cycle").contains(&(FIFO, 5)) {
        true => {
            assert_eq!((scheduling.as_str(), others.as_str()), ("SCHED_FIFO 5", "SCHED_FIFO 4"));
            // The pump and what DDS receives with, but nothing of other nodes.
            assert!(scheduled("machine pump").contains(&(FIFO, 4)));
            let tasks = std::fs::read_dir("/proc/self/task").expect("Linux lists threads");
            let names =
                tasks.filter_map(|task| std::fs::read_to_string(task.expect("a thread").path().join("comm")).ok());
            let of_dds: Vec<String> = names.filter(|name| name.starts_with("RustDDS")).collect();
            assert!(of_dds.iter().any(|name| scheduled(name.trim()).contains(&(FIFO, 4))), "{of_dds:?}");
            assert!(scheduled("interpolator pu").iter().all(|thread| *thread == (0, 0)));
        }
        false => {
            assert_eq!(scheduling, "ordinary");
            log.line(&["cyclic_priority 5 is refused", "`ulimit -r 5`"]);
        }
    }
    cell.stop();
}

fn realtime_cell() -> Cell {
    Cell::start_with(&[], |args| {
        args.with_parameter(Some("machine_sim"), "pace", ParameterValue::String("realtime".into()))
    })
}

/// Minimum delay of joint-state stamps against the system clock (ms): a late message does not prove a late stamp.
fn behind_ms(joints: &mpsc::Receiver<(i64, i64)>) -> f64 {
    let on_message = (0..5).map(|_| joints.recv_timeout(PATIENCE).expect("joint states"));
    on_message.map(|(stamp_ns, now_ns)| (now_ns - stamp_ns) as f64 * 1e-6).fold(f64::INFINITY, f64::min)
}

/// From the start on, and after an inactive time, which is reported with its length.
#[test]
fn stamps_of_a_realtime_machine_follow_the_system_clock() {
    let cell = realtime_cell();
    let (log, mut diagnostics) = (LogLines::subscribe(&cell), DiagnosticsListener::subscribe(&cell));
    let (sender, joints) = mpsc::channel();
    let on_message = move |joints: JointState, _: &_| {
        let (stamp, now) = (joints.header.stamp, std::time::SystemTime::now());
        let now_ns = now.duration_since(std::time::UNIX_EPOCH).expect("after 1970").as_nanos();
        let stamp_ns = i64::from(stamp.sec) * 1_000_000_000 + i64::from(stamp.nanosec);
        let _gone = sender.send((stamp_ns, i64::try_from(now_ns).expect("before 2262")));
    };
    let qos = Qos::default_topic().keep_last(2000);
    let _subscription = cell.client.node.subscribe("joint_states", &qos, on_message).expect("a subscription");
    // Until a busy computer lets it: how late it is then is measured.
    let until_on_time = |joints: &mpsc::Receiver<(i64, i64)>| {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let behind = behind_ms(joints);
            if behind.abs() < 10.0 {
                return behind;
            }
            assert!(Instant::now() < deadline, "stamps are {behind} ms behind the system clock");
        }
    };
    let at_start = until_on_time(&joints);

    let change = |id: u8| {
        let transition = Transition { id, label: String::new() };
        cell.client.call::<ChangeState>("machine_sim/change_state", &ChangeStateRequest { transition }).success
    };
    assert!(change(4), "deactivated");
    std::thread::sleep(std::time::Duration::from_secs(3));
    assert!(change(3), "activated");
    let line = log.line(&["the machine was inactive for "]);
    let length = line.rsplit_once("for ").and_then(|(_, text)| text.split_once(' ')?.0.parse().ok());
    assert!(length.is_some_and(|s: f64| (2.9..60.0).contains(&s)), "{line}");
    log.line(&["the machine's time follows the system clock again"]);
    let after = until_on_time(&joints);
    println!("stamps behind the system clock: {at_start:.3} ms after the start, {after:.3} ms after an inactive time");
    diagnostics.until("the slip", |last| {
        let clock = last.get("machine_sim: clock");
        clock.and_then(|clock| value(clock, "slips")).is_some_and(|slips| slips != "0")
    });
    let buffer = &diagnostics.last["machine_sim: buffer"];
    assert_eq!(value(buffer, "buffer_ms").as_deref(), Some("100"), "{buffer:?}");
    assert!(value(buffer, "recommended_buffer_ms").is_some(), "{buffer:?}");

    // At rest every two-hundredth tick: what comes in a second of the machine's time.
    while joints.try_recv().is_ok() {}
    let (first, _) = joints.recv_timeout(PATIENCE).expect("joint states");
    let mut count = 0;
    while joints.recv_timeout(PATIENCE).expect("joint states").0 < first + 1_000_000_000 {
        count += 1;
    }
    assert!((4..=7).contains(&count), "{count} joint states in a second of rest");
    cell.stop();
}
