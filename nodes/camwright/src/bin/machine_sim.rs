// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The node `machine_sim` as a process of its own.

use camwright_machine_sim::MachineSim;
use camwright_ros::running;
use std::process::ExitCode;

fn main() -> ExitCode {
    running::main("machine_sim", running::ENDING, MachineSim::start, |machine| drop(machine.stop()))
}
