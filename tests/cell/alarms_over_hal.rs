// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A job over and the faults that HAL reports.

use crate::hal::{
    Hal, JOB, NAMESPACE, integrator, messages, planner_client, recorded_cell, reset, send, subscribe_to_alarms,
    wait_for_alarms, wait_for_recorder,
};
use crate::support;
use camwright_analysis::report;
use camwright_analysis::rerun::{self, Window};
use camwright_bag::Bag;
use camwright_msgs::camwright_msgs::action::{RunJob, RunJobGoal};
use camwright_msgs::camwright_msgs::msg::MachineStream;
use camwright_msgs::diagnostic_msgs::msg::DiagnosticArray;
use camwright_msgs::trajectory_msgs::msg::JointTrajectory;
use camwright_ros::{ActionClient, GoalStatus, Qos};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use support::command::Shared;
use support::processes::{Processes, fresh_bag};
use support::{Domain, PATIENCE};

/// Setpoints that were sent, tick by tick, to the bit: position, velocity and acceleration of C, X and Z.
fn setpoints(bag: &Path) -> Vec<[[u64; 3]; 3]> {
    let bag = Bag::open(bag).expect("a bag");
    let mut ticks = BTreeMap::new();
    for chunk in messages::<JointTrajectory>(&bag, &format!("{NAMESPACE}/machine/setpoints")) {
        let stamp_ns = i64::from(chunk.header.stamp.sec) * 1_000_000_000 + i64::from(chunk.header.stamp.nanosec);
        for (tick, point) in (0_i64..).zip(&chunk.points) {
            let since = &point.time_from_start;
            // Behind the setpoints of every tick follows the stop.
            if i64::from(since.sec) * 1_000_000_000 + i64::from(since.nanosec) != tick * 1_000_000 {
                break;
            }
            let axis = |axis: usize| {
                [&point.positions, &point.velocities, &point.accelerations].map(|values| values[axis].to_bits())
            };
            ticks.insert(stamp_ns + tick * 1_000_000, [axis(0), axis(1), axis(2)]);
        }
    }
    ticks.into_values().collect()
}

/// The same job on the simulated machine: its bag.
fn simulated() -> PathBuf {
    let (domain, bag) = (Domain::reserve(), fresh_bag("hal-simulated"));
    let cell = Processes::start(&domain, NAMESPACE, &["machine:=cam_grinder_hal"], &bag);
    let node = integrator(&domain);
    let jobs: ActionClient<RunJob> = node.action_client("job_planner/run_job").expect("a client");
    let spin = node.spin_in_thread().expect("a thread");
    jobs.wait_for_server(PATIENCE).expect("the planner");
    wait_for_recorder(&node);
    let overrides = JOB.map(String::from).into();
    let goal = RunJobGoal { job: "eccentric".into(), overrides, ..RunJobGoal::default() };
    let sent = jobs.send_goal(goal, drop, PATIENCE).expect("an answer");
    let (status, result) = sent.result(PATIENCE).expect("it ends");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    drop(spin);
    cell.end()
}

/// A bag of a real machine: its drives, their timing, a replay of the interpolator, a report that states what was measured.
fn judge_bag(bag: &Path) {
    let verdict = rerun::rerun(bag).expect("the bag holds the inputs");
    let text = verdict.to_text();
    assert!(verdict.is_identical() && verdict.drives.as_deref() == Some("hal"), "{text}");
    assert!(verdict.setpoints > 5_000 && verdict.ticks == 0, "{text}");
    assert!(text.contains("the machine is real (hal): only the interpolator is recomputed"), "{text}");
    let page = report::html(bag).expect("a report");
    for words in ["Real drives (hal)", "as if wheel and part were rigid", "of 150 setpoints waited in the queue"] {
        assert!(page.contains(words), "{words} is not in the report");
    }
    let diagnostics: Vec<DiagnosticArray> = messages(&Bag::open(bag).expect("a bag"), "/diagnostics");
    let mut timing = diagnostics.iter().flat_map(|array| &array.status);
    let timing =
        timing.rfind(|status| status.name == format!("{NAMESPACE}/machine_hal: drive_queue")).expect("a status");
    let keys: Vec<&str> = timing.values.iter().map(|pair| pair.key.as_str()).collect();
    assert_eq!(keys, ["queued", "min_queued", "queue_ticks", "max_jitter_us", "underruns"]);
}

/// Beside the part, where the axes have only their own zeros, real and simulated switches differ: HAL sees an edge within a servo period.
/// At the part, C and X go the same way to the bit.
fn same_setpoints(real: &Path, simulated: &Path) {
    const BESIDE_M: f64 = 0.03;
    let (real, simulated) = (setpoints(real), setpoints(simulated));
    let same = real.iter().zip(&simulated).take_while(|(one, other)| one == other).count();
    assert!(same > 2_000, "up to the origin detector everything is the same, not only {same} ticks");
    let at_the_part = |setpoints: &[[[u64; 3]; 3]]| -> Vec<[[u64; 3]; 2]> {
        let near = setpoints.iter().filter(|[_, x, _]| f64::from_bits(x[0]) < BESIDE_M);
        near.map(|[c, x, _]| [*c, *x]).collect()
    };
    let (real, simulated) = (at_the_part(&real), at_the_part(&simulated));
    assert!(real.len() > 3_000, "{} ticks", real.len());
    let first = real.iter().zip(&simulated).position(|(one, other)| one != other);
    assert_eq!((first, real.len()), (None, simulated.len()), "the first setpoint that differs, and the number of them");
}

#[test]
fn a_job_runs_over_hal_and_every_fault_of_hal_is_an_alarm() {
    let Some(hal) = Hal::start(None) else { return };
    let domain = Domain::reserve();
    let mut machine = hal.node(&domain);
    let bag = fresh_bag("hal");
    let (mut recorder, cell) = recorded_cell(&domain, &bag);
    let node = integrator(&domain);
    let seen: Arc<Mutex<Vec<MachineStream>>> = Arc::default();
    let into = Arc::clone(&seen);
    let qos = Qos::default_topic().keep_last(1000);
    let _stream = node
        .subscribe("machine/stream", &qos, move |message: MachineStream, _| {
            into.lock().expect("no panic").push(message);
        })
        .expect("a subscription");
    let (_alarms, alarms) = subscribe_to_alarms(&node);
    let (jobs, _spin) = planner_client(&node, &machine);
    let _command = Shared::for_cell(&domain, NAMESPACE);
    wait_for_recorder(&node);

    // A whole job: the drives follow every setpoint to the count, and the form error is that of the encoders.
    let (status, result) = send(&jobs, &machine).result(PATIENCE).expect("it ends");
    assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
    assert!(result.lobes[0].form_error_max.abs() < 1e-7, "{} m", result.lobes[0].form_error_max);
    let messages = std::mem::take(&mut *seen.lock().expect("no panic"));
    let off = |message: &MachineStream| {
        let pairs = message.setpoint_counts.iter().zip(&message.actual_counts);
        pairs.map(|(setpoint, actual)| (setpoint - actual).abs()).max().unwrap_or(0)
    };
    let moving = messages.iter().filter(|message| message.actual_velocities.iter().any(|speed| *speed != 0.0)).count();
    let farthest = messages.iter().map(off).max();
    assert!(moving > 300 && farthest <= Some(1), "{moving} messages in motion, off by {farthest:?} counts");
    let ticks = messages.windows(2).all(|pair| pair[0].tick <= pair[1].tick);
    assert!(ticks, "ticks only increase");

    recorder.interrupt();
    assert!(recorder.wait(PATIENCE).success(), "{}", recorder.stderr());

    // The emergency stop chain of HAL opens in the cut.
    let job = send(&jobs, &machine);
    let goes_on = Instant::now() + PATIENCE;
    while !seen.lock().expect("no panic").iter().any(|message| message.actual_velocities.iter().any(|v| *v != 0.0)) {
        assert!(Instant::now() < goes_on, "nothing moves");
        std::thread::sleep(Duration::from_millis(20));
    }
    hal.set("chain.ok-in", "0");
    wait_for_alarms(&alarms, |numbers| numbers.contains(&1));
    assert_eq!(job.result(PATIENCE).expect("it ends").0, GoalStatus::Aborted);
    hal.set("chain.reset", "0");
    hal.set("chain.ok-in", "1");
    hal.set("chain.reset", "1");
    reset(&node);
    wait_for_alarms(&alarms, BTreeSet::is_empty);

    // A drive reports a fault, and a limit switch is pressed, at rest.
    hal.set("x-fault.in0", "1");
    wait_for_alarms(&alarms, |numbers| numbers.contains(&42));
    hal.set("x-fault.in0", "0");
    reset(&node);
    wait_for_alarms(&alarms, BTreeSet::is_empty);
    hal.set("z-limit.in0", "1");
    wait_for_alarms(&alarms, |numbers| numbers.contains(&13));
    hal.set("z-limit.in0", "0");
    reset(&node);
    wait_for_alarms(&alarms, BTreeSet::is_empty);

    // HAL stops: nobody knows where the axes are, and the node still answers.
    assert!(hal.halcmd(&["stop"]).is_some());
    wait_for_alarms(&alarms, |numbers| numbers.contains(&166));
    assert!(machine.is_running());
    machine.interrupt();
    assert!(machine.wait(PATIENCE).success(), "{}", machine.stderr());
    drop(cell);
    judge_bag(&bag);
    let simulated = simulated();
    same_setpoints(&bag, &simulated);
    let compared = rerun::against(&bag, Some(&simulated), Window::default()).expect("both hold their inputs");
    let text = compared.to_text();
    assert!(compared.is_same() && text.starts_with("the other run cuts the same: C and X of "), "{text}");
    for bag in [bag, simulated] {
        std::fs::remove_dir_all(bag).expect("our bag");
    }
}

/// A HAL that is not there, and one that does not fit the machine, are refused with the whole list.
#[test]
fn a_machine_without_its_hal_is_refused() {
    let output = Command::new(env!("CARGO_BIN_EXE_machine_hal"))
        .args(["--ros-args", "-p", "machine:=cam_grinder"])
        .env("ROS_DOMAIN_ID", Domain::reserve().id().to_string())
        .output();
    let output = output.expect("the node starts");
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("has no section `hal`") && text.contains("machine_sim"), "{text}");
}
