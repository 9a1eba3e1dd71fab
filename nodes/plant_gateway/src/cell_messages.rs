// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Last messages of a cell, as far as the plant sees them.

use camwright::machine::description::MachineDescription as Machine;
use camwright_msgs::camwright_msgs::msg::{
    Alarm, CellState, InterpolatorState, MachineAlarms, MachineCounters, MachineDescription, MachineIo, WorkArea,
};
use camwright_msgs::control_msgs::msg::DynamicJointState;

/// Equipment that decides which data items a machine has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Equipment {
    /// A grinding wheel; false for a lathe.
    pub(super) wheel: bool,
    /// The machine reports the speed of its wheel: it has a contact law.
    pub(super) wheel_speed: bool,
    /// The machine reports the power of its wheel: it has process data too.
    pub(super) wheel_power: bool,
    /// Door and chuck.
    pub(super) loading: bool,
}

impl Equipment {
    #[must_use]
    pub(super) fn of_machine(machine: &Machine) -> Self {
        let wheel = !machine.is_lathe();
        let wheel_speed = wheel && machine.contact.is_some();
        let wheel_power = wheel_speed && machine.process.is_some();
        Self { wheel, wheel_speed, wheel_power, loading: machine.loading.is_some() }
    }
}

/// Nodes whose messages arrive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Presence {
    pub(super) machine: bool,
    pub(super) interpolator: bool,
    pub(super) planner: bool,
}

/// Last message of each topic; `None` before the first one, and after its publisher was lost.
#[derive(Debug, Clone, Default)]
pub(super) struct CellMessages {
    pub(super) presence: Presence,
    /// Equipment of the described machine; none before its description arrives.
    pub(super) equipment: Equipment,
    pub(super) description: Option<MachineDescription>,
    pub(super) io: Option<MachineIo>,
    pub(super) area: Option<WorkArea>,
    pub(super) counters: Option<MachineCounters>,
    pub(super) axes: Option<DynamicJointState>,
    pub(super) machine_alarms: Option<MachineAlarms>,
    pub(super) interpolator: Option<InterpolatorState>,
    pub(super) interpolator_alarms: Option<MachineAlarms>,
    pub(super) cell: Option<CellState>,
}

impl CellMessages {
    pub(super) fn description(&self) -> Option<&MachineDescription> {
        self.description.as_ref().filter(|_| self.presence.machine)
    }

    pub(super) fn io(&self) -> Option<&MachineIo> {
        self.io.as_ref().filter(|_| self.presence.machine)
    }

    pub(super) fn area(&self) -> Option<&WorkArea> {
        self.area.as_ref().filter(|_| self.presence.machine)
    }

    pub(super) fn counters(&self) -> Option<&MachineCounters> {
        self.counters.as_ref().filter(|_| self.presence.machine)
    }

    pub(super) fn interpolator(&self) -> Option<&InterpolatorState> {
        self.interpolator.as_ref().filter(|_| self.presence.interpolator)
    }

    pub(super) fn cell(&self) -> Option<&CellState> {
        self.cell.as_ref().filter(|_| self.presence.planner)
    }

    /// Value of an interface of a joint (SI); `None` if it is not reported or not a number.
    pub(super) fn joint(&self, joint: &str, interface: &str) -> Option<f64> {
        let axes = self.axes.as_ref().filter(|_| self.presence.machine)?;
        let values = axes.interface_values.get(axes.joint_names.iter().position(|name| name == joint)?)?;
        let at = values.interface_names.iter().position(|name| name == interface)?;
        values.values.get(at).copied().filter(|value| value.is_finite())
    }

    /// Active alarms of machine and interpolator; `None` without a list of the machine.
    pub(super) fn alarms(&self) -> Option<impl Iterator<Item = &Alarm>> {
        let machine = self.machine_alarms.as_ref().filter(|_| self.presence.machine)?;
        let interpolator = self.interpolator_alarms.as_ref().filter(|_| self.presence.interpolator);
        Some(machine.alarms.iter().chain(interpolator.into_iter().flat_map(|list| &list.alarms)))
    }
}
