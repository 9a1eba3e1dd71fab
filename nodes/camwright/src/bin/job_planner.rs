// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The node `job_planner` as a process of its own.

use camwright_job_planner::JobPlanner;
use camwright_ros::running::{self, COMING_TO_REST, ENDING};
use std::process::ExitCode;

fn main() -> ExitCode {
    running::main("job_planner", ENDING, JobPlanner::start, |planner| drop(planner.stop_within(COMING_TO_REST)))
}
