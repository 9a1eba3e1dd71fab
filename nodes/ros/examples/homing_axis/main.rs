// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A simulated axis as a managed node.
//!
//! `cargo run -p camwright_ros --example homing_axis -- --ros-args -p speed:=0.1`

mod axis;

use camwright_ros::running;
use std::process::ExitCode;
use std::time::Duration;

fn main() -> ExitCode {
    // Reads the arguments, starts the node, waits for Ctrl-C, and stops within two seconds.
    running::main("homing_axis", Duration::from_secs(2), axis::start, |(node, _spin)| node.shutdown())
}
