// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The node `machine_hal` as a process of its own.

use camwright_machine_hal::MachineHal;
use camwright_ros::running;
use std::process::ExitCode;

fn main() -> ExitCode {
    running::main("machine_hal", running::ENDING, MachineHal::start, |machine| drop(machine.stop()))
}
