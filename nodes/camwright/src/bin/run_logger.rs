// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The node `run_logger` as a process of its own.

use camwright_ros::running;
use camwright_run_logger::RunLogger;
use std::process::ExitCode;

fn main() -> ExitCode {
    running::main("run_logger", running::CLOSING, RunLogger::start, RunLogger::stop)
}
