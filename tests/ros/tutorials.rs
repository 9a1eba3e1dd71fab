// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Tutorials with rclpy.

use crate::support::{peer_env, tutorial};

fn follow(name: &str) {
    let Some(env) = peer_env() else { return };
    tutorial::follow(name, Some(env));
}

#[test]
fn the_cell_from_rclpy() {
    follow("the_cell_from_rclpy.md");
}

#[test]
fn moveit_and_ros2_control() {
    follow("moveit_and_ros2_control.md");
}
