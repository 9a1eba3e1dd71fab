// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Processes beside the node of HAL that die or stand still.

use crate::hal::{
    Hal, NAMESPACE, WatchedPeriod, integrator, moves, planner_client, reset, rests, send, subscribe_to_alarms,
    wait_for_alarms,
};
use crate::support;
use camwright_ros::GoalStatus;
use std::collections::BTreeSet;
use std::process::Command;
use support::command::Shared;
use support::processes::{Processes, in_domain};
use support::{Domain, Guarded, PATIENCE};

/// Id of a program that the node has started.
fn program_of(machine: &Guarded, name: &str) -> String {
    let folders = std::fs::read_dir("/proc").expect("Linux").flatten();
    let ids = folders.filter_map(|folder| folder.file_name().into_string().ok());
    let is_it = |id: &String| {
        let text = |file: &str| std::fs::read_to_string(format!("/proc/{id}/{file}")).unwrap_or_default();
        let parent = format!("PPid:\t{}\n", machine.id());
        text("comm").trim_end() == name && text("status").contains(&parent)
    };
    ids.filter(|id| id.bytes().all(|octet| octet.is_ascii_digit())).find(is_it).expect("the program")
}

fn signal(id: &str, signal: &str) {
    let sent = Command::new("kill").args([&format!("-{signal}"), id]).status().expect("kill is installed");
    assert!(sent.success(), "cannot signal {id}");
}

/// A process beside the node that dies, or stands still for 2 s: the axes rest, with the alarm for it.
#[test]
fn what_dies_or_stands_still_beside_the_node_ends_at_rest_with_its_alarm() {
    let Some(hal) = Hal::start(None) else { return };
    let domain = Domain::reserve();
    let machine = hal.node(&domain);
    let mut sender = in_domain(env!("CARGO_BIN_EXE_axis_interpolator"), &domain);
    let sender = Guarded::start("axis_interpolator", sender.args(["--ros-args", "-r", &format!("__ns:={NAMESPACE}")]));
    let cell = Processes::start_some(&domain, NAMESPACE, &["job_planner"]);
    let node = integrator(&domain);
    let (_alarms, alarms) = subscribe_to_alarms(&node);
    let (jobs, spin) = planner_client(&node, &machine);
    let command = Shared::for_cell(&domain, NAMESPACE);
    let mut watch = hal.watch();
    let at_rest = |what: &str, periods: &[WatchedPeriod]| {
        let rest = periods.last().expect("periods");
        for (encoder, command) in rest.encoders.iter().zip(rest.commands) {
            assert!((encoder - command).abs() < 1e-4, "{what}: rests at {rest:?}");
        }
    };
    let is_off = |periods: &[WatchedPeriod]| periods.last().is_some_and(WatchedPeriod::is_off);

    // The queue of HAL runs empty. What was sent before reaches the drives when the program goes on: the path has no gap.
    let job = send(&jobs, &machine);
    watch.until("motion", &machine, |periods| moves(periods, 0));
    let streamer = program_of(&machine, "halstreamer");
    signal(&streamer, "STOP");
    let periods = watch.until("an empty queue", &machine, |periods| periods.len() >= 2000);
    assert!(rests(&periods) && is_off(&periods), "{:?}", periods.last());
    at_rest("an empty queue", &periods);
    wait_for_alarms(&alarms, |numbers| numbers.contains(&80));
    signal(&streamer, "CONT");
    let stood_at = periods.last().expect("periods").sequence;
    let follows = |periods: &[WatchedPeriod]| periods.last().is_some_and(|period| period.sequence > stood_at + 300);
    at_rest("what was sent", &watch.until("what was sent", &machine, |periods| follows(periods) && rests(periods)));
    assert_eq!(job.result(PATIENCE).expect("it ends").0, GoalStatus::Aborted);
    reset(&node);
    wait_for_alarms(&alarms, BTreeSet::is_empty);
    at_rest("after a reset", &watch.until("a reset", &machine, rests));

    // The sender is silent: the machine follows the stop of its last chunk.
    let job = send(&jobs, &machine);
    watch.until("motion", &machine, |periods| moves(periods, 0));
    sender.signal("KILL");
    let periods = watch.until("a silent sender", &machine, rests);
    at_rest("a silent sender", &periods);
    // No acceleration beyond that of a stop (degrees or mm for a period, twice), and two counts.
    for (axis, bound) in [(0, 0.0172), (1, 0.01), (2, 0.002)] {
        let positions = periods.iter().map(|period| period.commands[axis]).collect::<Vec<_>>();
        let largest = positions.windows(3).map(|at| (at[2] - 2.0 * at[1] + at[0]).abs()).fold(0.0, f64::max);
        assert!(largest < 1.2 * bound + 4e-4, "axis {axis} jumps by {largest}");
    }
    wait_for_alarms(&alarms, |numbers| numbers.contains(&80));
    assert_eq!(job.result(PATIENCE).expect("it ends").0, GoalStatus::Aborted);
    reset(&node);
    wait_for_alarms(&alarms, BTreeSet::is_empty);

    // Nobody reads the samples any more: where the axes are is unknown, and they lose their power.
    signal(&program_of(&machine, "halsampler"), "KILL");
    wait_for_alarms(&alarms, |numbers| numbers.contains(&166));
    at_rest("no samples", &watch.until("no samples", &machine, |periods| rests(periods) && is_off(periods)));
    drop((sender, command, spin, cell));
}
