// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright hal`: prints the HAL file of a machine, without ROS and without HAL.

use super::machine_text::print_machine_text;
use camwright_machine_hal::{connection_text, simulation_text};
use camwright_ros::running::NodeError;
use clap::Args;
use std::process::ExitCode;

/// Arguments of `camwright hal`.
#[derive(Debug, Clone, Args)]
#[command(after_help = super::help::HAL)]
pub(super) struct HalArgs {
    /// Name or path of a machine with the section `hal`.
    #[arg(default_value = "cam_grinder_hal")]
    machine: String,
    /// Simulate drives and switches by components of LinuxCNC.
    #[arg(long)]
    simulate: bool,
    /// Set a key of the machine; repeatable.
    #[arg(long = "set-machine", value_name = "KEY=VALUE")]
    set_machine: Vec<String>,
}

/// Entry point.
pub(super) fn main(args: &HalArgs) -> ExitCode {
    print_machine_text("camwright hal", (&args.machine, &args.set_machine), |file| {
        let Some(hal) = &file.hal else {
            let name = &file.description.name;
            return Err(NodeError::Parameter(format!(
                "machine {name} has no section `hal`; `camwright hal cam_grinder_hal` shows one, docs/guides/linuxcnc_machine.md explains it"
            )));
        };
        Ok(if args.simulate { simulation_text(file, hal) } else { connection_text(file, hal) })
    })
}
