// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The node `axis_interpolator` as a process of its own.

use camwright_axis_interpolator::AxisInterpolator;
use camwright_ros::running::{self, COMING_TO_REST, ENDING};
use std::process::ExitCode;

fn main() -> ExitCode {
    running::main("axis_interpolator", ENDING, AxisInterpolator::start, |node| drop(node.stop_within(COMING_TO_REST)))
}
