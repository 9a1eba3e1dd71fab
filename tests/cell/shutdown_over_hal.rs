// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The end of the node of HAL.

use crate::hal::{Hal, NAMESPACE, WatchedPeriod, integrator, moves, planner_client, send};
use crate::support;
use support::command::Shared;
use support::processes::Processes;
use support::{Domain, Guarded, PATIENCE};

/// Servo periods without setpoints after which HAL switches the drives off.
const SILENCE_PERIODS: usize = 500;

/// HAL while a node ends in the middle of a job: the periods from the motion to the end of power.
fn end_in_motion(hal: &Hal, signal: &str, axes: &[usize]) -> (Vec<WatchedPeriod>, Guarded) {
    let domain = Domain::reserve();
    let machine = hal.node(&domain);
    let cell = Processes::start_some(&domain, NAMESPACE, &["axis_interpolator", "job_planner"]);
    let node = integrator(&domain);
    let (jobs, spin) = planner_client(&node, &machine);
    let command = Shared::for_cell(&domain, NAMESPACE);
    let job = send(&jobs, &machine);
    let mut watch = hal.watch();
    watch.until(signal, &machine, |periods| axes.iter().all(|axis| moves(periods, *axis)));
    machine.signal(signal);
    // Power is off, and has been for a while.
    let is_off = |periods: &[WatchedPeriod]| {
        periods.len() > 300 && periods[periods.len() - 300..].iter().all(WatchedPeriod::is_off)
    };
    let periods = watch.until(signal, &machine, is_off);
    drop((job, command, spin, cell));
    (periods, machine)
}

/// A node that is asked to end stops the axes on the path. One that dies or stands still leaves them at its last setpoint. HAL switches the
/// drives off when nothing comes any more, and the next node starts at rest.
#[test]
fn drives_are_at_rest_and_off_after_the_node_has_ended_in_motion() {
    let Some(hal) = Hal::start(None) else { return };
    // C searches its origin, or turns while the wheel moves to the part.
    for (signal, axes) in [("KILL", &[0][..]), ("STOP", &[0]), ("TERM", &[0, 1])] {
        let (periods, mut machine) = end_in_motion(&hal, signal, axes);
        // Not one setpoint is lost or repeated while they come.
        let last_sequence = periods.last().expect("periods").sequence;
        let silent = periods.iter().position(|period| period.sequence == last_sequence).expect("it is there");
        for pair in periods[..=silent].windows(2) {
            assert_eq!(pair[1].sequence, pair[0].sequence + 1, "{signal}");
        }
        let end = &periods[silent];
        for period in &periods[silent..] {
            let [held, sent] = [period, end].map(|period| period.commands.map(f64::to_bits));
            assert_eq!(held, sent, "{signal}: the last setpoint holds");
        }
        let off = periods[silent..].iter().position(WatchedPeriod::is_off).expect("they go off");
        assert!((SILENCE_PERIODS - 5..SILENCE_PERIODS + 20).contains(&off), "{signal}: off after {off} periods");
        let rest = periods.last().expect("periods");
        for (encoder, command) in rest.encoders.iter().zip(rest.commands) {
            assert!((encoder - command).abs() < 1e-5, "{signal}: rests at {rest:?}");
        }
        if signal == "STOP" {
            machine.signal("CONT");
            // Threads of DDS do not survive a stop (nodes/ros/UPSTREAM.md).
            assert_eq!(machine.wait(PATIENCE).code(), Some(70), "{}", machine.stderr());
        } else {
            let status = machine.wait(PATIENCE);
            assert_eq!(status.success(), signal == "TERM", "{signal}: {status} {}", machine.stderr());
        }
        if signal == "TERM" {
            // No acceleration beyond that of a stop (degrees or mm for a period, twice), and two counts.
            for (axis, bound) in [(0, 0.0172), (1, 0.01), (2, 0.002)] {
                let positions = periods.iter().map(|period| period.commands[axis]).collect::<Vec<_>>();
                let largest = positions.windows(3).map(|at| (at[2] - 2.0 * at[1] + at[0]).abs()).fold(0.0, f64::max);
                assert!(largest < 1.2 * bound + 4e-4, "axis {axis} jumps by {largest}");
            }
        }
    }
}
