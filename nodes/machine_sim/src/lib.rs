// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The node `machine_sim`: the clock, axes, sensors, wheel, part, gauge, alarms and e-stop of a simulated machine.

use camwright::machine::persistent_state::PersistentState;
use camwright::simulation::Machine;
use camwright_files::machine_file::MachineConfig;
use camwright_machine_node::{MachineNode, OpenedPlant, PACE, Plant};
use camwright_ros::running::NodeError;
use camwright_ros::{Node, Parameter};
use camwright_threads::ring::Waker;

/// Drives, sensors and part of the simulation.
#[derive(Debug, Default)]
pub struct SimulatedPlant;

impl Plant for SimulatedPlant {
    fn node_name(&self) -> &'static str {
        "machine_sim"
    }

    fn parameters(&self) -> Vec<Parameter> {
        vec![
            Parameter::string(PACE, "realtime")
                .describe("real time, or as fast as possible")
                .choices(&["realtime", "fast"])
                .read_only(),
        ]
    }

    fn open(
        &self,
        _: &Node,
        file: &MachineConfig,
        lasting: PersistentState,
        _: &Waker,
    ) -> Result<OpenedPlant, NodeError> {
        let machine = Machine::new(file.description.clone(), lasting)
            .map_err(|error| NodeError::Parameter(format!("machine {}: {error}", file.path.display())))?;
        Ok(OpenedPlant { machine, bus: None })
    }
}

/// A running `machine_sim`.
pub type MachineSim = MachineNode<SimulatedPlant>;
