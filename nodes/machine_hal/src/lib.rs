// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The node `machine_hal`: a machine whose drives LinuxCNC's HAL moves.
//!
//! ```text
//! setpoints → Machine (supervision) → halstreamer ─► streamer ─► drives
//!                  ▲                                               │
//!                  └──────── halsampler ◄── sampler ◄── encoders, switches
//! ```
//! HAL's servo thread is the clock: each sample is a tick, and sends one setpoint more, so that `fifo_ticks` setpoints always wait in the
//! queue of HAL. Programs of LinuxCNC run as processes of their own. Nothing here is a safety function.

mod connection;
mod hal_file_text;
mod halcmd;
mod sample;
mod servo_pipes;
mod simulated_journal;
mod simulated_references;

pub use hal_file_text::{connection_text, simulation_text};

use camwright::machine::persistent_state::PersistentState;
use camwright::simulation::Machine;
use camwright_files::machine_file::MachineConfig;
use camwright_machine_node::{MachineNode, OpenedPlant, Plant};
use camwright_ros::running::NodeError;
use camwright_ros::{Node, Parameter};
use camwright_threads::ring::Waker;
use servo_pipes::ServoPipes;

/// Drives, switches and spindle behind HAL.
#[derive(Debug, Default)]
pub struct HalPlant;

impl Plant for HalPlant {
    fn node_name(&self) -> &'static str {
        "machine_hal"
    }

    fn parameters(&self) -> Vec<Parameter> {
        Vec::new()
    }

    fn open(
        &self,
        node: &Node,
        file: &MachineConfig,
        lasting: PersistentState,
        waker: &Waker,
    ) -> Result<OpenedPlant, NodeError> {
        let path = file.path.display();
        let Some(hal) = &file.hal else {
            return Err(NodeError::Parameter(format!(
                "machine {path} has no section `hal`: it is simulated; start machine_sim, or see docs/guides/linuxcnc_machine.md"
            )));
        };
        if file.description.wheel_changer.is_some() {
            return Err(NodeError::Parameter(format!(
                "machine {path} has a `wheel_changer`, and HAL has no pins for one; remove it from the machine file, or start \
                 machine_sim"
            )));
        }
        let findings = halcmd::compare(hal, &file.description).map_err(NodeError::Parameter)?;
        if !findings.is_empty() {
            return Err(NodeError::Parameter(format!(
                "HAL does not fit machine {path}:\n  {}\n`camwright hal {}` prints the connection that it needs",
                findings.join("\n  "),
                file.description.name
            )));
        }
        let (pipes, at_rest) = ServoPipes::open(node, hal, &file.description, waker)?;
        let machine = Machine::real(&file.description, lasting, (hal.fifo_ticks, hal.rest_window_counts), &at_rest)
            .map_err(|error| NodeError::Parameter(format!("machine {path}: {error}")))?;
        Ok(OpenedPlant { machine, bus: Some((Box::new(pipes), at_rest)) })
    }
}

/// A running `machine_hal`.
pub type MachineHal = MachineNode<HalPlant>;
