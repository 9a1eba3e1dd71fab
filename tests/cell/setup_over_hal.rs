// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Homing over HAL.

use crate::hal::{Hal, NAMESPACE, integrator};
use crate::support;
use camwright_msgs::camwright_msgs::action::{Home, HomeGoal, MoveTo, MoveToGoal};
use camwright_ros::{ActionClient, GoalStatus};
use std::time::{Duration, Instant};
use support::command::Shared;
use support::processes::Processes;
use support::{Domain, PATIENCE};

/// An X axis whose encoder is zeroed by its index marks, 8 mm apart; its switch closes 14 mm from where it stands at power-up.
const INDEXED: [(&str, &str); 2] = [
    (
        "  power_up_position_mm: 150.0\n",
        "  power_up_position_mm: 150.0\n  home: {search_velocity_mm_s: 10, latch_velocity_mm_s: -3, switch_mm: 164, \
         home_mm: 150, use_index: true, index_pitch_mm: 8}\n",
    ),
    (
        "limit: x-limit.out}",
        "limit: x-limit.out, home: x-home.out, index_enable: x-index.index-enable, index_position: x-since-mark.out}",
    ),
];

/// The marks lie at multiples of 8 mm: whatever was before, the axis stands on the same count of its encoder at home.
#[test]
fn homing_at_an_index_mark_finds_the_same_zero_from_everywhere() {
    const COUNT_MM: f64 = 1e-5;
    let Some(hal) = Hal::start_with(&INDEXED, None) else { return };
    let domain = Domain::reserve();
    let machine = hal.node(&domain);
    let cell = Processes::start_some(&domain, NAMESPACE, &["axis_interpolator", "job_planner"]);
    let node = integrator(&domain);
    let home: ActionClient<Home> = node.action_client("axis_interpolator/home").expect("a client");
    let moves: ActionClient<MoveTo> = node.action_client("axis_interpolator/move_to").expect("a client");
    let spin = node.spin_in_thread().expect("a thread");
    home.wait_for_server(PATIENCE).unwrap_or_else(|error| panic!("{error}{}", machine.stderr()));
    moves.wait_for_server(PATIENCE).expect("the interpolator");
    let command = Shared::for_cell(&domain, NAMESPACE);
    // Where it stands at power-up, just before a mark, just behind one, on its switch.
    for start_m in [None, Some(0.159_99), Some(0.152_01), Some(0.171)] {
        if let Some(start) = start_m {
            let goal = MoveToGoal { joints: vec!["x_axis".into()], positions: vec![start], ..MoveToGoal::default() };
            let (status, moved) =
                moves.send_goal(goal, drop, PATIENCE).expect("an answer").result(PATIENCE).expect("it ends");
            assert_eq!(status, GoalStatus::Succeeded, "{}{}", moved.message, machine.stderr());
        }
        let deadline = Instant::now() + PATIENCE;
        let homing = loop {
            let goal = HomeGoal { joints: vec!["x_axis".into()] };
            let sent = home.send_goal(goal, drop, PATIENCE).expect("an answer");
            if sent.accepted() {
                break sent;
            }
            // Until the first message of the machine has come.
            assert!(Instant::now() < deadline, "no homing is accepted{}", machine.stderr());
            std::thread::sleep(Duration::from_millis(100));
        };
        let (status, homed) = homing.result(PATIENCE).expect("it ends");
        assert_eq!(status, GoalStatus::Succeeded, "from {start_m:?}: {}{}", homed.message, machine.stderr());
        // Its encoder began to count at power-up, at the home position.
        let stands = hal.halcmd(&["getp", "x-encoder.out"]).expect("the encoder");
        let stands: f64 = stands.trim().parse().expect("a number");
        assert!(stands.abs() <= COUNT_MM, "from {start_m:?} m it stands {stands} mm from home");
    }
    drop((command, spin, cell));
}
