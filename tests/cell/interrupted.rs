// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Interruptions of a running cell: Ctrl-C, an interpolator that dies, a second machine with a clock.

use crate::support;

use byteorder::LittleEndian;
use camwright_bag::Bag;
use camwright_bag::check::check;
use camwright_msgs::camwright_msgs::action::{RunJob, RunJobGoal};
use camwright_msgs::camwright_msgs::msg::{InterpolatorState, MachineAlarms, PlanSegment};
use camwright_msgs::camwright_msgs::srv::{LoadJob, LoadJobRequest};
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_msgs::std_srvs::srv::{Trigger, TriggerRequest};
use camwright_ros::{GoalStatus, Node, NodeOptions, Qos, RosArgs, Subscription};
use std::path::Path;
use std::process::Command;
use std::sync::{Arc, Mutex, mpsc};
use std::time::{Duration, Instant};
use support::command::Shared;
use support::{Domain, Guarded, PATIENCE};

fn until(what: &str, mut condition: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !condition() {
        assert!(Instant::now() < deadline, "{what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// The phases that the interpolator goes through, as they are received.
fn phases_of(node: &Node) -> (mpsc::Receiver<u8>, Subscription) {
    let (sender, phases) = mpsc::channel();
    let on_state = move |state: InterpolatorState, _: &_| {
        let _test_is_over = sender.send(state.phase);
    };
    let states = node.subscribe("axis_interpolator/state", &Qos::latched(1), on_state).expect("a subscription");
    (phases, states)
}

/// At pace realtime, so that the cut is still going on when the signal comes.
#[test]
fn ctrl_c_in_the_cut_retracts_the_wheel_and_closes_the_bag() {
    let domain = Domain::reserve();
    let bag = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("interrupted-{}", std::process::id()));
    let _not_there = std::fs::remove_dir_all(&bag);
    let node = Node::new(NodeOptions::new("watcher", &RosArgs::default().with_domain_id(domain.id()))).expect("a node");
    let _spinning = node.spin_in_thread().expect("a thread");
    let (phases, _states) = phases_of(&node);
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.env("ROS_DOMAIN_ID", domain.id().to_string()).env("XDG_STATE_HOME", env!("CARGO_TARGET_TMPDIR"));
    command.args(["run", "eccentric", "--pace", "realtime", "--bag"]).arg(&bag);
    command.args(["--set", "wheel_radius_mm=60.0", "--set-machine", "wheel.spin_up_s=0.2"]);
    // Setpoints run far ahead, so that a busy computer is no underrun.
    command.args(["--set-machine", "feedback_delay_ticks=500"]);
    let mut run = Guarded::start("camwright run", &mut command);
    while phases.recv_timeout(PATIENCE).expect("it comes to the cut") != PlanSegment::PHASE_CUT {}
    run.interrupt();
    let status = run.wait(PATIENCE);
    assert_eq!(status.code(), Some(3), "a job that was cancelled{}", run.complaint());
    let lines = run.remaining_lines(PATIENCE);
    let text = lines.join("\n");
    assert_eq!(lines[0], "NOT COMPLETE: eccentric, cancelled");
    let flat = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(flat.contains("cancelled: the axes are at rest and the wheel is retracted"), "{text}");
    assert!(lines.contains(&format!("bag:    {}", bag.display())), "{text}");
    assert!(lines.contains(&format!("report: {}", bag.join("report.html").display())), "{text}");

    let report = check(&bag).expect("there is a bag");
    assert_eq!(report.findings, [], "{}", report.to_text());
    let read = Bag::open(&bag).expect("it is closed");
    let (mut last, mut messages) = (None, read.messages());
    while let Some(message) = messages.next_message().expect("a readable bag") {
        if read.topics()[message.topic].name == "/joint_states" {
            last = Some(message.data);
        }
    }
    let last: JointState =
        cdr_encoding::from_bytes::<_, LittleEndian>(&last.expect("joint states")[4..]).expect("CDR").0;
    let of = |values: &[f64], joint: &str| values[last.name.iter().position(|name| name == joint).expect("a joint")];
    for axis in ["c_axis", "x_axis", "z_axis"] {
        assert!(of(&last.velocity, axis).abs() < 1e-12, "{axis} moves still: {last:?}");
    }
    // The disc reaches out to 23.2 mm, its blank 0.3 mm farther.
    assert!(of(&last.position, "x_axis") > 23.5e-3, "{last:?}");
    std::fs::remove_dir_all(&bag).expect("the bag is ours");
}

/// Silence is a stop: the machine runs out the stop of the last chunk and says so, the planner gives up, and a new interpolator goes on
/// after a reset.
#[test]
fn an_interpolator_that_dies_in_the_cut_is_a_stop_and_a_new_one_goes_on() {
    let domain = Domain::reserve();
    let start = |binary: &str, parameters: &[&str]| {
        let mut command = Command::new(binary);
        command.env("ROS_DOMAIN_ID", domain.id().to_string()).arg("--ros-args");
        for parameter in parameters {
            command.args(["-p", parameter]);
        }
        Guarded::start(binary, &mut command)
    };
    let overrides = "machine_overrides:=[\"wheel.spin_up_s=0.2\", \"feedback_delay_ticks=500\"]";
    let machine = start(env!("CARGO_BIN_EXE_machine_sim"), &["pace:=realtime", "state_file:=none", overrides]);
    let planner = start(env!("CARGO_BIN_EXE_job_planner"), &[]);
    let mut interpolator = start(env!("CARGO_BIN_EXE_axis_interpolator"), &[]);

    let node = Node::new(NodeOptions::new("watcher", &RosArgs::default().with_domain_id(domain.id()))).expect("a node");
    let _spinning = node.spin_in_thread().expect("a thread");
    let (phases, _states) = phases_of(&node);
    let alarms: Arc<Mutex<Vec<u16>>> = Arc::default();
    let place = Arc::clone(&alarms);
    let _alarms = node
        .subscribe::<MachineAlarms>("machine/alarms", &Qos::latched(1), move |list, _| {
            *place.lock().expect("not poisoned") = list.alarms.iter().map(|alarm| alarm.number).collect();
        })
        .expect("a subscription");
    let moving: Arc<Mutex<bool>> = Arc::default();
    let place = Arc::clone(&moving);
    let _joints = node
        .subscribe::<JointState>("joint_states", &Qos::default_topic(), move |joints, _| {
            let axes = joints.name.iter().zip(&joints.velocity).filter(|(name, _)| name.ends_with("_axis"));
            *place.lock().expect("not poisoned") = axes.into_iter().any(|(_, velocity)| velocity.abs() > 1e-9);
        })
        .expect("a subscription");
    let jobs = node.action_client::<RunJob>("job_planner/run_job").expect("a client");
    jobs.wait_for_server(PATIENCE).expect("run_job");
    let load = node.client::<LoadJob>("job_planner/load_job").expect("a client");
    load.wait_for_service(PATIENCE).expect("load_job");
    let command = Shared::for_cell(&domain, "");
    let settings = ["wheel_radius_mm=60.0", "infeed.per_block_um=0.05", "infeed.spark_out_turns=1"].map(String::from);
    let request = LoadJobRequest { job: "eccentric".into(), overrides: settings.clone().into() };
    until("the planner has met the machine", || load.call(&request, PATIENCE).expect("an answer").success);
    let run = || {
        let goal = RunJobGoal { job: "eccentric".into(), overrides: settings.clone().into(), ..RunJobGoal::default() };
        jobs.send_goal(goal, drop, PATIENCE).expect("a decision")
    };

    let job = run();
    assert!(job.accepted(), "{}", planner.complaint());
    while phases.recv_timeout(PATIENCE).expect("it comes to the cut") != PlanSegment::PHASE_CUT {}
    assert!(*moving.lock().expect("not poisoned"));
    drop(interpolator);
    until("the machine says that setpoints are missing", || *alarms.lock().expect("not poisoned") == [80]);
    until("the axes are at rest", || !*moving.lock().expect("not poisoned"));
    let (status, result) = job.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Aborted, "{}", result.message);
    assert!(result.message.contains("the axis interpolator does not answer"), "{}", result.message);
    assert_eq!(result.alarm, 80, "{}", result.message);

    interpolator = start(env!("CARGO_BIN_EXE_axis_interpolator"), &[]);
    let reset = node.client::<Trigger>("machine/reset").expect("a client");
    reset.wait_for_service(PATIENCE).expect("reset");
    let answer = reset.call(&TriggerRequest::default(), PATIENCE).expect("an answer");
    assert!(answer.success, "{}", answer.message);
    until("a job is taken again", || {
        let job = run();
        job.accepted() && job.result(PATIENCE).expect("a result").0 == GoalStatus::Succeeded
    });
    drop(command);
    for mut node in [planner, interpolator, machine] {
        node.interrupt();
        assert!(node.wait(PATIENCE).success(), "{}", node.complaint());
    }
}

/// The second machine at pace fast says that it leaves the clock to the first, and takes it over when that is gone.
#[test]
fn only_one_of_two_machines_publishes_the_clock() {
    let domain = Domain::reserve();
    let node = Node::new(NodeOptions::new("watcher", &RosArgs::default().with_domain_id(domain.id()))).expect("a node");
    let _spinning = node.spin_in_thread().expect("a thread");
    let machine = |namespace: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_machine_sim"));
        command.env("ROS_DOMAIN_ID", domain.id().to_string());
        command.args(["--ros-args", "-r", &format!("__ns:={namespace}"), "-p", "pace:=fast", "-p", "state_file:=none"]);
        Guarded::start(namespace, &mut command)
    };
    let clocks = || node.publisher_count("/clock").expect("a good name");
    let mut first = machine("/left");
    until("the first machine publishes its clock", || clocks() == 1);
    let mut second = machine("/right");
    let expected = "/left/machine_sim publishes /clock, so this machine does not";
    until("the second leaves it to the first", || {
        assert!(second.is_running(), "{}", second.complaint());
        second.stderr().contains(expected)
    });
    assert_eq!(clocks(), 1);
    first.interrupt();
    assert!(first.wait(PATIENCE).success(), "{}", first.complaint());
    until("the second takes over", || second.stderr().contains("no other node publishes /clock"));
    until("it publishes its clock", || clocks() == 1);
    second.interrupt();
    assert!(second.wait(PATIENCE).success(), "{}", second.complaint());
}
