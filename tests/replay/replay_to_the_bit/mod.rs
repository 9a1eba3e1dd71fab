// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A run computed again from its inputs as they were applied: identical to the bit, and where one bit was changed its tick is named.
#![allow(clippy::print_stdout, reason = "a test shows its seed and what it measured")]

use crate::cell;
use crate::changed_bag;
mod keyframes;
use crate::support;

use camwright_analysis::rerun::{ReplayVerdict, rerun};
use camwright_msgs::Action;
use camwright_msgs::builtin_interfaces::msg::Duration as RosDuration;
use camwright_msgs::camwright_msgs::action::{
    Home, HomeGoal, Jog, JogGoal, MoveTo, MoveToGoal, Probe, ProbeGoal, RunJobFeedback,
};
use camwright_msgs::camwright_msgs::msg::{AppliedInput, MachineAlarms, MachineInput, RecorderStatus};
use camwright_msgs::camwright_msgs::srv::{InjectFault, InjectFaultRequest, SetOverride, SetOverrideRequest};
use camwright_msgs::cdr::sample_from_message;
use camwright_msgs::control_msgs::action::{FollowJointTrajectory, FollowJointTrajectoryGoal};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, Trigger, TriggerRequest};
use camwright_msgs::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};
use camwright_ros::{GoalStatus, ParameterValue, Qos, RosArgs};
use camwright_run_logger::RunLogger;
use cell::{Cell, PATIENCE};
use changed_bag::{Original, as_it_was};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::mpsc;
use std::time::Instant;
use support::Folder;

const MACHINE: [&str; 3] = [
    "gap_detector={holds_ms: 20}",
    "key_way_probe={at_deg: 140, width_deg: 16}",
    "gauge={kind: diameter, behind_wheel_deg: 90, resolution_um: 0.1, noise_um: 0.2}",
];
const ONE_LOBE: [&str; 3] = ["wheel_radius_mm=60.0", "infeed.per_block_um=0.05", "infeed.spark_out_turns=6"];

fn act<A: Action>(cell: &Cell, name: &str, goal: A::Goal) -> GoalStatus {
    let client = cell.client.node.action_client::<A>(&format!("axis_interpolator/{name}")).expect("a client");
    client.wait_for_server(PATIENCE).expect("the interpolator offers it");
    let sent = client.send_goal(goal, drop, PATIENCE).expect("a decision");
    assert!(sent.accepted(), "{name}");
    sent.result(PATIENCE).expect("a result").0
}

fn trajectory(joint: &str, position: f64, sec: i32) -> FollowJointTrajectoryGoal {
    let time_from_start = RosDuration { sec, nanosec: 0 };
    let point = JointTrajectoryPoint { positions: vec![position], time_from_start, ..JointTrajectoryPoint::default() };
    let trajectory =
        JointTrajectory { joint_names: vec![joint.into()], points: vec![point], ..JointTrajectory::default() };
    FollowJointTrajectoryGoal { trajectory, ..FollowJointTrajectoryGoal::default() }
}

fn reset(cell: &Cell) {
    let end = Instant::now() + PATIENCE;
    while !cell.client.call::<Trigger>("machine/reset", &TriggerRequest::default()).success {
        assert!(Instant::now() < end, "no reset");
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
}

/// A job that is held, goes on, and is slowed down on its way.
fn disturbed_job(cell: &Cell) {
    let (goal, feedback): (_, mpsc::Receiver<RunJobFeedback>) = cell.client.send("eccentric", &ONE_LOBE);
    assert!(goal.accepted());
    let hold =
        |hold| cell.client.call::<SetBool>("axis_interpolator/feed_hold", &SetBoolRequest { data: hold }).success;
    // Held as soon as it goes, wherever that is.
    feedback.recv_timeout(PATIENCE).expect("it goes on");
    while !hold(true) {
        std::thread::yield_now();
    }
    let slow = SetOverrideRequest { feed_override: 0.7 };
    assert!(cell.client.call::<SetOverride>("axis_interpolator/set_override", &slow).success);
    assert!(hold(false), "it was held");
    let (status, result) = goal.result(PATIENCE).expect("a result");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
}

/// The recorder hears the machine, and has subscribed to what will be sent to it.
fn wait_for_recorder(cell: &Cell) {
    let (sender, statuses) = mpsc::channel::<RecorderStatus>();
    let subscription = cell.client.node.subscribe("run_logger/status", &Qos::default_topic(), move |status, _| {
        drop(sender.send(status));
    });
    let _subscription = subscription.expect("a subscription");
    loop {
        let status = statuses.recv_timeout(PATIENCE).expect("the recorder says what it does");
        let topic = |name: &str| status.topics.iter().find(|topic| topic.topic == name);
        let hears = |name: &str| topic(name).is_some_and(|topic| topic.written > 0);
        let all = ["/machine/setpoints", "/machine/commands", "/axis_interpolator/inputs"];
        if all.iter().all(|name| topic(name).is_some()) && hears("/machine/stream") && hears("/machine/inputs") {
            return;
        }
    }
}

/// Everything that an operator does with a machine, in one bag.
fn eventful_run(folder: &Folder) -> PathBuf {
    let cell = Cell::start_with(&MACHINE, |args| {
        let period_s = ParameterValue::Double(1.5);
        args.with_parameter(Some("machine_sim"), "keyframe_period_s", period_s)
    });
    let bag = folder.join("eventful");
    let text = |text: &str| ParameterValue::String(text.into());
    let args = RosArgs::default().with_domain_id(cell.domain().id()).with_parameter(
        Some("run_logger"),
        "bag_dir",
        text(&bag.display().to_string()),
    );
    // It comes when the machine has begun: the first inputs are latched.
    let recorder = RunLogger::start(&args).expect("run_logger");
    wait_for_recorder(&cell);
    act::<Home>(&cell, "home", HomeGoal::default());
    let (joints, positions) = (vec!["z_axis".into()], vec![0.05]);
    act::<MoveTo>(&cell, "move_to", MoveToGoal { joints, positions, ..MoveToGoal::default() });
    let jog = JogGoal { joint: "x_axis".into(), velocity: 0.01, distance: -0.004, ..JogGoal::default() };
    act::<Jog>(&cell, "jog", jog);
    let probe = ProbeGoal { joint: "z_axis".into(), input: "LS1".into(), target: 0.1, ..ProbeGoal::default() };
    assert_eq!(act::<Probe>(&cell, "probe", probe), GoalStatus::Succeeded);
    for data in [true, false] {
        assert!(cell.client.call::<SetBool>("axis_interpolator/wheel", &SetBoolRequest { data }).success);
    }
    let follow = "follow_joint_trajectory";
    assert_eq!(act::<FollowJointTrajectory>(&cell, follow, trajectory("z_axis", 0.02, 2)), GoalStatus::Succeeded);
    disturbed_job(&cell);
    // A fault in the next job, whose alarm is reset; then one that comes to its end.
    let fault = InjectFaultRequest { fault: "estop".into(), active: true, job_tick: 6000, ..Default::default() };
    assert!(cell.client.call::<InjectFault>("machine/inject_fault", &fault).success);
    let (goal, _feedback) = cell.client.send("eccentric", &ONE_LOBE);
    assert_eq!(goal.result(PATIENCE).expect("a result").0, GoalStatus::Aborted);
    assert!(cell.client.call::<SetBool>("machine/estop", &SetBoolRequest { data: false }).success);
    reset(&cell);
    let (goal, _feedback) = cell.client.send("eccentric", &ONE_LOBE);
    assert_eq!(goal.result(PATIENCE).expect("a result").0, GoalStatus::Succeeded);
    cell.stop();
    recorder.stop();
    bag
}

fn replayed(bag: &Path) -> ReplayVerdict {
    let verdict = rerun(bag).unwrap_or_else(|error| panic!("{}: {error}", bag.display()));
    println!("{}: {}", bag.display(), verdict.to_text());
    verdict
}

/// The bag with one message changed.
fn with<M: Serialize + DeserializeOwned>(original: &Original, place: usize, change: impl FnOnce(&mut M)) -> &Path {
    let mut message: M = original.decoded(place);
    change(&mut message);
    let data = sample_from_message(&message).expect("it travels");
    original.rewritten(
        |index, message| {
            if index == place { Some(Cow::Owned(data.clone())) } else { as_it_was(message) }
        },
    )
}

#[test]
fn an_eventful_run_is_computed_again_to_the_bit_and_one_changed_bit_is_named_by_its_tick() {
    let folder = Folder::new("replay-to-the-bit");
    let path = eventful_run(&folder);
    let verdict_of_all = replayed(&path);
    let verdict = &verdict_of_all;
    assert!(verdict.is_identical(), "{}", verdict.to_text());
    assert!(verdict.motions >= 9 && verdict.digests.0 > 20, "{}", verdict.to_text());
    let original = Original::read(&path, folder.join("changed"));
    every_input_is_named(&original);
    what_comes_of_an_override_is_named(&original);
    // A changed setpoint and a changed sample are reported with field, values and µm.
    let chunks = original.places::<JointTrajectory>();
    let changed = with::<JointTrajectory>(&original, chunks[chunks.len() / 2], |chunk| {
        chunk.points[1].positions[1] = f64::from_bits(chunk.points[1].positions[1].to_bits() ^ 1 << 30);
    });
    let text = rerun(changed).expect("it can be computed").to_text();
    assert!(text.contains("setpoint: position of x_axis: recorded ") && text.contains(" um of difference"), "{text}");
    // So is an alarm.
    let has_alarms = |place: &usize| !original.decoded::<MachineAlarms>(*place).alarms.is_empty();
    let alarm = original.places::<MachineAlarms>().into_iter().find(has_alarms).expect("the emergency stop");
    let changed = with::<MachineAlarms>(&original, alarm, |message| message.alarms[0].text.push('!'));
    let text = rerun(changed).expect("it can be computed").to_text();
    assert!(
        text.contains("machine/alarms: recorded alarm 1 of tick ") && text.contains("emergency stop pressed!"),
        "{text}"
    );
    refusals(&original);
    keyframes::all(&path, &original, &verdict_of_all);
}

/// One bit of one input of either topic: named by its tick.
fn every_input_is_named(original: &Original) {
    let mut seed = 0x2026_1122_u64;
    let mut next = |below: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(seed >> 33).expect("31 bits") % below
    };
    let of_interpolator = original.places::<AppliedInput>();
    let of_machine = original.places::<MachineInput>();
    for _ in 0..3 {
        let (place, bit) = (of_interpolator[next(of_interpolator.len())], 1 << next(64));
        let input: AppliedInput = original.decoded(place);
        let changed = with::<AppliedInput>(original, place, |input| {
            input.value = f64::from_bits(input.value.to_bits() ^ bit);
        });
        let verdict = rerun(changed).expect("it can be computed");
        assert_eq!(verdict.changed.first().map(|(tick, _)| *tick), Some(input.tick), "{}", verdict.to_text());
        let (place, bit) = (of_machine[next(of_machine.len())], 1 << next(64));
        let input: MachineInput = original.decoded(place);
        let changed = with::<MachineInput>(original, place, |input| input.digest ^= bit);
        let verdict = rerun(changed).expect("it can be computed");
        assert_eq!(verdict.changed.first().map(|(tick, _)| *tick), Some(input.tick), "{}", verdict.to_text());
    }
}

/// Also without its check a changed input shows: the setpoints are others from its tick on.
fn what_comes_of_an_override_is_named(original: &Original) {
    let inputs = original.places::<AppliedInput>();
    let is_override = |place: &&usize| original.decoded::<AppliedInput>(**place).kind == AppliedInput::OVERRIDE;
    let place = *inputs.iter().find(is_override).expect("the override was changed");
    let input: AppliedInput = original.decoded(place);
    let changed = with::<AppliedInput>(original, place, |input| {
        // 0.7 with the highest bit of its mantissa: 0.95.
        input.value = f64::from_bits(input.value.to_bits() ^ 1 << 51);
    });
    let verdict = rerun(changed).expect("it can be computed");
    let first = verdict.differences.first().expect("the setpoints are others");
    assert!(first.field.starts_with("setpoint") || first.field.starts_with("stop"), "{first}");
    // It came while the axes were held: it shows in a setpoint when they go on.
    assert!(first.tick >= input.tick, "input of tick {}: {first}", input.tick);
    assert!(verdict.to_text().starts_with(&format!("differs: tick {}: OVERRIDE", input.tick)), "{}", verdict.to_text());
    println!("{}", verdict.to_text());
}

/// Requests that a bag does not support are refused with the reason.
fn refusals(original: &Original) {
    let without =
        |left_out: usize| rerun(original.rewritten(|index, message| as_it_was(message).filter(|_| index != left_out)));
    let text = without(original.places::<MachineInput>()[5]).expect_err("an input is missing").to_string();
    assert!(text.contains("machine/inputs is not whole: input 5 is missing, between ticks "), "{text}");
    let text = without(original.places::<AppliedInput>()[0]).expect_err("an input is missing").to_string();
    assert!(text.contains("axis_interpolator/inputs is not whole: the first input, of before"), "{text}");
    // A missing chunk is reported by its tick.
    let verdict = without(original.places::<JointTrajectory>()[3]).expect("the inputs are whole");
    assert!(!verdict.is_identical());
    assert!(verdict.to_text().contains("is not on machine/setpoints"), "{}", verdict.to_text());
}

/// The command says the same, with its exit code, and compares two runs of one job.
#[test]
fn the_command_compares_a_run_with_itself_and_with_another() {
    let folder = Folder::new("replay-command");
    let run = |name: &str, more: &[&str]| {
        let domain = support::Domain::reserve();
        let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
        command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
        command.env("XDG_STATE_HOME", folder.join("state")).args(["run", "eccentric", "--bag"]).arg(folder.join(name));
        for set in ONE_LOBE.iter().chain(more) {
            command.args(["--set", set]);
        }
        let output = command.output().expect("camwright runs");
        // The part is complete; this infeed burns it.
        assert_eq!(output.status.code(), Some(4), "{}", String::from_utf8_lossy(&output.stderr));
    };
    run("one", &[]);
    run("two", &[]);
    run("other", &["work_speed_rpm=58"]);
    let replay = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
        let output = command.current_dir(folder.path()).arg("replay").args(arguments).output().expect("it runs");
        // An error is on the other stream, and nothing else is there.
        (output.status.code(), String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
    };
    let (code, text) = replay(&["one", "--against"]);
    println!("{text}");
    assert!(code == Some(0) && text.starts_with("identical: "), "{text}");
    let (code, text) = replay(&["one", "--against", "two"]);
    assert!(code == Some(0) && text.contains("the other run is the same: "), "{text}");
    let (code, text) = replay(&["one", "--against", "other"]);
    assert!(code == Some(3) && text.contains("the other run differs: job 1: the same up to tick "), "{text}");
    let (code, text) = replay(&["nowhere", "--against"]);
    assert!(code == Some(1) && text.starts_with("camwright replay: cannot replay nowhere: "), "{text}");
}

/// A list of infeeds is run on the whole cell: the part is within its tolerance, the run is computed again to the bit, and another list of the
/// same sum is another run.
#[test]
fn a_list_of_infeeds_is_ground_within_tolerance_and_replayed_to_the_bit() {
    let folder = Folder::new("replay-list");
    let run = |name: &str, list: &str| {
        let domain = support::Domain::reserve();
        let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
        command.current_dir(support::repository()).env("ROS_DOMAIN_ID", domain.id().to_string());
        command
            .env("XDG_STATE_HOME", folder.join("state"))
            .args(["run", "eccentric", "--json", "--bag"])
            .arg(folder.join(name));
        command.args([
            "--set",
            ONE_LOBE[0],
            "--set",
            "infeed.per_block_um=null",
            "--set",
            &format!("infeed.per_turn_um={list}"),
        ]);
        let output = command.output().expect("camwright runs");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(output.status.code(), Some(0), "{text} {}", String::from_utf8_lossy(&output.stderr));
        text
    };
    println!("{}", run("one", "[50, 50, 45, 45, 40, 40, 30, 30, 20, 10]"));
    run("other", "[50, 50, 45, 45, 40, 40, 30, 30, 18, 12]");
    let replay = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
        let output = command.current_dir(folder.path()).arg("replay").args(arguments).output().expect("it runs");
        (output.status.code(), String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
    };
    let (code, text) = replay(&["one", "--against"]);
    assert!(code == Some(0) && text.starts_with("identical: "), "{text}");
    let (code, text) = replay(&["one", "--against", "other"]);
    assert!(code == Some(3) && text.contains("the other run differs: job 1: the same up to tick "), "{text}");
}
