// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `camwright urdf`: prints the URDF of a machine, without ROS.

use super::machine_text::print_machine_text;
use camwright::machine::description::MachineDescription;
use camwright_ros::running::NodeError;
use camwright_scene::{self as scene, Frames, Tree, UrdfVersion};
use clap::Args;
use std::process::ExitCode;

/// Arguments of `camwright urdf`.
#[derive(Debug, Clone, Args)]
#[command(after_help = super::help::URDF)]
pub(super) struct UrdfArgs {
    /// Name or path of the machine.
    #[arg(default_value = "cam_grinder")]
    machine: String,
    /// Prefix of frame names, as `frame_prefix` of a node [default: namespace].
    #[arg(long, default_value = "")]
    prefix: String,
    /// Namespace of the cell.
    #[arg(long, default_value = "/")]
    namespace: String,
    /// Radius of the mounted wheel (mm) [default: new wheel].
    #[arg(long, value_name = "MM")]
    wheel_radius_mm: Option<f64>,
    /// Write URDF 1.2 with limits of acceleration and jerk [default: URDF 1.0].
    #[arg(long)]
    extended_limits: bool,
    /// Set a key of the machine; repeatable.
    #[arg(long = "set-machine", value_name = "KEY=VALUE")]
    set_machine: Vec<String>,
}

/// Entry point.
pub(super) fn main(args: &UrdfArgs) -> ExitCode {
    print_machine_text("camwright urdf", (&args.machine, &args.set_machine), |file| urdf(args, &file.description))
}

fn urdf(args: &UrdfArgs, machine: &MachineDescription) -> Result<String, NodeError> {
    let (min_mm, new_mm) = (machine.wheel.min_radius_mm, machine.wheel.new_radius_mm);
    let radius_mm = args.wheel_radius_mm.unwrap_or(new_mm);
    if !(min_mm..=new_mm).contains(&radius_mm) {
        let message = format!("--wheel-radius-mm {radius_mm} is outside {min_mm} to {new_mm} mm");
        return Err(NodeError::Parameter(message));
    }
    let prefix = scene::prefix(&args.prefix, &args.namespace).map_err(NodeError::Parameter)?;
    let frames = Frames::new(&prefix, machine);
    Ok(Tree::new(machine, radius_mm, frames).urdf(UrdfVersion::with_extended_limits(args.extended_limits)))
}
