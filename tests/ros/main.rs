// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The ROS layer beside real ROS 2 peers.

#[path = "../support/cell.rs"]
mod cell;
#[path = "../../nodes/ros/examples/homing_axis/axis.rs"]
mod example;
#[path = "../support/mod.rs"]
mod support;

mod cell_with_rclpy;
mod homing_axis;
mod interoperability;
mod lathe_with_rclpy;
mod loader_with_rclpy;
mod no_packet_leaves_the_host;
mod ros_actions;
mod ros_interface;
mod ros_layer;
mod tutorials;
