// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A robot in rclpy, with the interfaces as ROS 2 builds them, tends ten parts: as a robot programmer would run the example.

use crate::cell;
use crate::support;

use camwright_msgs::camwright_msgs::msg::CellState;
use camwright_ros::{ParameterValue, Qos};
use cell::{Cell, PATIENCE};
use std::sync::mpsc;
use std::time::Instant;
use support::{Guarded, peer_env, repository};

const MACHINE: &str =
    "loading={door: {opens_ms: 500, closes_ms: 500}, chuck: {opens_ms: 200, closes_ms: 200}, safe_x_mm: 120}";

#[test]
fn the_robot_in_rclpy_tends_ten_parts() {
    let Some(env) = peer_env() else { return };
    let cell = Cell::start_with(&[MACHINE], |args| {
        args.with_parameter(None, "loader_timeout_s", ParameterValue::Double(10.0))
    });
    let (sender, states) = mpsc::channel();
    let qos = Qos::latched(1).keep_last(500);
    let _subscription = cell.client.node.subscribe("job_planner/cell_state", &qos, move |state: CellState, _| {
        drop(sender.send(state));
    });
    let script = repository().join("nodes/camwright/examples/loader_robot.py");
    let mut command = env.python(&script.display().to_string(), cell.domain());
    command.args(["--job", "eccentric", "--parts", "10"]);
    for pair in ["wheel_radius_mm=60.0", "infeed.per_block_um=0.05", "infeed.spark_out_turns=6"] {
        command.args(["--set", pair]);
    }
    let mut robot = Guarded::start("loader_robot.py", &mut command);
    // A part takes some seconds on a busy computer: what is awaited is the next good one, not the end of all.
    let (mut good, mut deadline) = (0, Instant::now() + PATIENCE);
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        let state = states.recv_timeout(left).unwrap_or_else(|_| panic!("{good} good parts{}", robot.complaint()));
        if state.life.good > good {
            (good, deadline) = (state.life.good, Instant::now() + PATIENCE);
        }
        if state.state == CellState::COMPLETE && good == 10 {
            assert_eq!((state.parts_done, state.life.bad, state.life.total), (10, 0, 10));
            break;
        }
    }
    let line = robot.line(PATIENCE).unwrap_or_else(|| panic!("it ended{}", robot.complaint()));
    assert_eq!(line, "10 of 10 parts tended in 11 visits", "{}", robot.complaint());
    let status = robot.wait(PATIENCE);
    assert!(status.success(), "it ends with {status}{}", robot.complaint());
    cell.stop();
}
