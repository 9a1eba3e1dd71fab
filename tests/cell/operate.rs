// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright hold`, `resume`, `override` and others on a running cell: what is done, what is refused and by whom.

use crate::cell;
use crate::support;

use camwright_axis_interpolator::AxisInterpolator;
use camwright_machine_sim::MachineSim;
use camwright_msgs::camwright_msgs::msg::InterpolatorState;
use camwright_ros::{GoalStatus, Node, NodeOptions, ParameterValue, Qos, RosArgs};
use cell::{Cell, PATIENCE};
use std::path::Path;
use std::process::{Command, Output};
use std::sync::mpsc;
use std::time::Instant;
use support::{Domain, Folder, Guarded};

/// Runs a command of camwright; the folder holds the sockets of its user.
fn camwright(domain: &Domain, runtime: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command.args(words).env("ROS_DOMAIN_ID", domain.id().to_string()).env("XDG_RUNTIME_DIR", runtime);
    command.output().expect("camwright runs")
}

/// Checks exit code and text of a command.
fn answers(output: &Output, code: i32, words: &str) {
    let text = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    // Without the line breaks of an 80-column terminal.
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(output.status.code(), Some(code), "{words}: {text}");
    assert!(text.contains(words), "{words}: {text}");
}

#[test]
fn a_cell_is_operated_from_the_command_line() {
    let (cell, runtime) = (Cell::start(&[]), Folder::new("operate"));
    let call = |words: &[&str]| camwright(cell.domain(), runtime.path(), words);
    answers(&call(&["hold"]), 3, "axis_interpolator refuses: nothing is being executed");
    answers(&call(&["cancel"]), 3, "nothing to cancel");
    answers(&call(&["home", "x_axis", "z_axis"]), 0, "homed x_axis, z_axis");
    answers(&call(&["wheel", "on"]), 0, "wheel at speed");
    answers(&call(&["wheel", "off"]), 0, "wheel stopped");
    answers(&call(&["jog", "z_axis=0.5", "--speed", "10"]), 0, "z_axis at ");
    answers(&call(&["jog", "z_axis=5000", "--speed", "10"]), 3, "axis_interpolator refuses: the target of z_axis is ");
    // The node logs the same reason again only after a time.
    answers(&call(&["jog", "z_axis=5000", "--speed", "10"]), 3, "axis_interpolator refuses: the target of z_axis is ");
    answers(&call(&["load"]), 3, "the machine has no door and no chuck");

    let (goal, feedback) = cell.client.send("four_lobe_camshaft", &[]);
    assert!(goal.accepted());
    while feedback.recv_timeout(PATIENCE).expect("feedback").phase_name != "cut" {}
    answers(&call(&["hold"]), 0, "motion held on its path");
    answers(&call(&["override", "50%"]), 0, "override 50 %");
    answers(&call(&["override", "150"]), 2, "150 is outside 0 % to 100 %");
    answers(&call(&["resume"]), 0, "motion continues");
    answers(&call(&["cancel"]), 0, "job cancelled, the axes come to rest");
    let (status, _) = goal.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Canceled);

    answers(&call(&["fault", "drive_falt", "x_axis"]), 2, "tip: a similar value exists: 'drive_fault'");
    answers(&call(&["fault", "drive_fault"]), 3, "target \"\" is not c_axis, x_axis or z_axis");
    answers(&call(&["fault", "stuck_input", "LS9"]), 3, "(LS1, LS2, LS3, LS4");
    answers(&call(&["fault", "drive_fault", "x_axis"]), 0, "fault drive_fault injected");
    answers(&call(&["status"]), 3, "clear the fault at the drive, then reset");
    answers(&call(&["reset"]), 3, "clear it (`camwright fault drive_fault x_axis --clear`)");
    answers(&call(&["fault", "drive_fault", "x_axis", "--clear"]), 0, "fault drive_fault removed");
    answers(&call(&["reset"]), 0, "alarms reset");
    answers(&call(&["estop"]), 0, "emergency stop pressed");
    answers(&call(&["reset"]), 3, "machine refuses: ");
    answers(&call(&["estop", "--release"]), 0, "emergency stop released");
    answers(&call(&["reset"]), 0, "alarms reset");
    answers(&call(&["status"]), 0, "override 50 %");
    cell.stop();
    let empty = Domain::reserve();
    answers(&camwright(&empty, runtime.path(), &["hold"]), 3, "no answer within");
    answers(&camwright(&empty, runtime.path(), &["cancel"]), 3, "no answer within");
}

#[test]
fn a_part_is_loaded_and_unloaded_by_hand() {
    let door =
        "loading={door: {opens_ms: 500, closes_ms: 500}, chuck: {opens_ms: 200, closes_ms: 200}, safe_x_mm: 120}";
    // At pace realtime a step begins before the motion of the step before has ended, unless someone waits for it.
    let (cell, runtime) = (Cell::start_realtime(&[door]), Folder::new("operate-load"));
    let call = |words: &[&str]| camwright(cell.domain(), runtime.path(), words);
    answers(&call(&["home"]), 3, "axis_interpolator refuses: nothing may start: the chuck is not closed");
    answers(&call(&["load"]), 0, "part loaded");
    answers(&call(&["home", "z_axis"]), 0, "homed z_axis");
    answers(&call(&["load"]), 3, "there is a part in the chuck already");
    answers(&call(&["unload"]), 0, "part removed");
    answers(&call(&["fault", "door_stuck"]), 0, "fault door_stuck injected");
    answers(&call(&["load"]), 3, "machine/open_door: alarm 153, door stuck: find what blocks the door, then reset");
    cell.stop();
}

/// `camwright run` has command; another process of the same user operates its cell, one of another user does not.
#[test]
fn processes_of_the_user_that_runs_a_job_operate_its_cell() {
    let (domain, folder, runtime) = (Domain::reserve(), Folder::new("operate-run"), Folder::new("operate-user"));
    let mut run = Command::new(env!("CARGO_BIN_EXE_camwright"));
    run.current_dir(folder.path()).args(["run", "four_lobe_camshaft", "--pace", "realtime"]);
    run.args(["--set-machine", "feedback_delay_ticks=500"]);
    run.env("ROS_DOMAIN_ID", domain.id().to_string()).env("XDG_RUNTIME_DIR", runtime.path());
    let mut run = Guarded::start("camwright run", run.env("XDG_STATE_HOME", folder.path()));
    let args = RosArgs::default().with_domain_id(domain.id());
    let node = Node::new(NodeOptions::new("_watch", &args)).expect("a node");
    let (sender, states) = mpsc::channel();
    let seen = node.subscribe("axis_interpolator/state", &Qos::latched(1), move |state: InterpolatorState, _| {
        let _test_is_over = sender.send(state.state);
    });
    let (_seen, _spin) = (seen.expect("a subscription"), node.spin_in_thread().expect("a thread"));
    let wait_for = |wanted: u8| while states.recv_timeout(PATIENCE).expect("a state") != wanted {};
    wait_for(InterpolatorState::EXECUTING);
    let call = |words: &[&str]| camwright(&domain, runtime.path(), words);
    answers(&call(&["hold"]), 0, "motion held on its path");
    wait_for(InterpolatorState::HELD);
    let stranger = Folder::new("operate-stranger");
    answers(&camwright(&domain, stranger.path(), &["resume"]), 3, "the machine refuses: camwright run has command");
    answers(&call(&["override", "80"]), 0, "override 80 %");
    answers(&call(&["resume"]), 0, "motion continues");
    wait_for(InterpolatorState::EXECUTING);
    answers(&camwright(&domain, stranger.path(), &["cancel"]), 0, "job cancelled");
    assert_eq!(run.wait(PATIENCE).code(), Some(3), "a cancelled job");
    node.shutdown();
}

/// Ctrl-C ends the job and not the cell, whose nodes are other processes; command is free again.
#[test]
fn ctrl_c_cancels_an_attached_job_and_leaves_the_cell() {
    let (cell, folder) = (Cell::start(&[]), Folder::new("operate-attach"));
    let mut run = Command::new(env!("CARGO_BIN_EXE_camwright"));
    run.current_dir(folder.path()).args(["run", "four_lobe_camshaft", "--attach", "--json"]);
    run.env("ROS_DOMAIN_ID", cell.domain().id().to_string()).env("XDG_RUNTIME_DIR", folder.path());
    let (sender, states) = mpsc::channel();
    let node = &cell.client.node;
    let seen = node.subscribe("axis_interpolator/state", &Qos::latched(1), move |state: InterpolatorState, _| {
        let _test_is_over = sender.send(state.state);
    });
    let _seen = seen.expect("a subscription");
    let mut run = Guarded::start("camwright run --attach", &mut run);
    while states.recv_timeout(PATIENCE).expect("a state") != InterpolatorState::EXECUTING {}
    run.interrupt();
    assert_eq!(run.wait(PATIENCE).code(), Some(3), "a cancelled job: {}", run.complaint());
    let call = |words: &[&str]| camwright(cell.domain(), folder.path(), words);
    answers(&call(&["status"]), 0, "command the test (shared)");
    answers(&call(&["home", "z_axis"]), 0, "homed z_axis");
    cell.stop();
}

/// Machine and interpolator without a planner.
struct BareCell {
    domain: Domain,
    machine: MachineSim,
    interpolator: AxisInterpolator,
}

impl BareCell {
    fn start() -> Self {
        let domain = Domain::reserve();
        let text = |text: &str| ParameterValue::String(text.into());
        let args = RosArgs::default()
            .with_domain_id(domain.id())
            .with_parameter(Some("machine_sim"), "pace", text("fast"))
            .with_parameter(Some("machine_sim"), "state_file", text("none"));
        let machine = MachineSim::start(&args).expect("machine_sim");
        let interpolator = AxisInterpolator::start(&args).expect("axis_interpolator");
        Self { domain, machine, interpolator }
    }

    fn stop(self) {
        self.interpolator.stop();
        self.machine.stop();
    }
}

#[test]
fn motions_are_cancelled_without_a_planner() {
    let (cell, runtime) = (BareCell::start(), Folder::new("operate-bare"));
    let call = |words: &[&str]| camwright(&cell.domain, runtime.path(), words);
    answers(&call(&["home"]), 0, "homed all axes");
    answers(&call(&["cancel"]), 3, "nothing to cancel");
    let mut jog = Command::new(env!("CARGO_BIN_EXE_camwright"));
    jog.args(["jog", "c_axis=360000", "--speed", "10"]).env("ROS_DOMAIN_ID", cell.domain.id().to_string());
    let mut jog = Guarded::start("camwright jog", jog.env("XDG_RUNTIME_DIR", runtime.path()));
    let (args, (sender, states)) = (RosArgs::default().with_domain_id(cell.domain.id()), mpsc::channel());
    let node = Node::new(NodeOptions::new("_watch", &args)).expect("a node");
    let subscription =
        node.subscribe("axis_interpolator/state", &Qos::latched(1), move |state: InterpolatorState, _| {
            let _test_is_over = sender.send(state.state);
        });
    let (_subscription, _spin) = (subscription.expect("a subscription"), node.spin_in_thread().expect("a thread"));
    while states.recv_timeout(PATIENCE).expect("a state") != InterpolatorState::EXECUTING {}
    answers(&call(&["override", "50%"]), 0, "override 50 %");
    answers(&call(&["cancel"]), 0, "motion cancelled, the axes come to rest");
    assert_eq!(jog.wait(PATIENCE).code(), Some(3), "it did not go the distance");
    node.shutdown();
    cell.stop();
}

/// Prints the time of every operation, from the start of its process to its end, in a cell with a planner and in one without.
#[test]
#[ignore = "a measurement"]
#[allow(clippy::print_stdout, reason = "prints a table")]
fn times_of_operations() {
    const RUNS: usize = 5;
    let (cell, runtime) = (Cell::start(&[]), Folder::new("operate-times"));
    let measure = |domain: &Domain, words: &str| {
        let words: Vec<&str> = words.split(' ').collect();
        let mut times = [0.0; RUNS];
        let mut code = None;
        for time in &mut times {
            let start = Instant::now();
            code = camwright(domain, runtime.path(), &words).status.code();
            *time = start.elapsed().as_secs_f64();
        }
        times.sort_by(f64::total_cmp);
        println!(
            "| {} | {:.2} | {:.2} | {} |",
            words.join(" "),
            times[RUNS / 2],
            times[RUNS - 1],
            code.unwrap_or_default()
        );
    };
    println!("\n| operation | median (s) | maximum (s) | exit code |\n|---|---|---|---|");
    for words in [
        "status",
        "reset",
        "hold",
        "resume",
        "override 100",
        "cancel",
        "estop",
        "estop --release",
        "reset",
        "home",
        "wheel on",
        "wheel off",
        "jog z_axis=0.01 --speed 10",
        "load",
        "unload",
    ] {
        measure(cell.domain(), words);
    }
    cell.stop();
    let bare = BareCell::start();
    println!("without job_planner:");
    measure(&bare.domain, "cancel");
    bare.stop();
}
