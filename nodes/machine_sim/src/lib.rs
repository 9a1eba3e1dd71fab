//! The node `machine_sim`: the clock, axes, sensors, wheel, part, gauge, alarms and e-stop of a simulated machine.

use camwright::machine::persistent_state::PersistentState;
use camwright::simulation::Machine;
use camwright_files::convert::machine_now::MachineNow;
use camwright_files::machine_file::MachineConfig;
use camwright_machine_node::{MachineNode, OpenedPlant, PACE, Plant};
use camwright_ros::running::NodeError;
use camwright_ros::{Farewell, Node, NodeOptions, Parameter, RosArgs};
use camwright_threads::ring::Waker;
use std::ops::Deref;

/// Drives, sensors and part of the simulation.
#[derive(Debug)]
struct SimulatedPlant;

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
#[derive(Debug)]
pub struct MachineSim(MachineNode);

impl MachineSim {
    /// Name and parameters of the node.
    #[must_use]
    pub fn options(args: &RosArgs) -> NodeOptions {
        MachineNode::options(args, &SimulatedPlant)
    }

    /// Machine and wheel with which a node with these arguments starts.
    ///
    /// # Errors
    /// A machine file or a machine state that is refused, parameters out of range.
    pub fn machine_from_args(args: &RosArgs) -> Result<MachineNow, NodeError> {
        MachineNode::machine_from_args(args, &SimulatedPlant)
    }

    /// Starts the node.
    ///
    /// # Errors
    /// A machine file that is refused, parameters out of range, DDS that cannot start.
    pub fn start(args: &RosArgs) -> Result<Self, NodeError> {
        MachineNode::start(args, &SimulatedPlant).map(Self)
    }

    /// Ends the cyclic thread, then the node.
    pub fn stop(self) -> Farewell {
        self.0.stop()
    }
}

impl Deref for MachineSim {
    type Target = MachineNode;

    fn deref(&self) -> &MachineNode {
        &self.0
    }
}
