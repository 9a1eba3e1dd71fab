// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Types of the companion models that the nodes of the server have: OPC 40501-1 (machine tools) 1.02, OPC 40001-1 (machinery) 1.04,
//! OPC 10000-100 (devices).
//!
//! Numbers and names are those of the published node sets. Types are present by number, name and supertype, not with their members.

/// Namespace of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum UaNamespace {
    /// The standard itself.
    Core,
    Di,
    Machinery,
    MachineTool,
    /// Nodes of this cell.
    Cell,
}

impl UaNamespace {
    /// All but the standard itself.
    pub(super) const ADDED: [Self; 4] = [Self::Di, Self::Machinery, Self::MachineTool, Self::Cell];

    /// Index in this module; a server has indices of its own.
    #[must_use]
    pub(super) const fn index(self) -> u16 {
        self as u16
    }

    /// Published URI; `None` for the namespace of the cell.
    #[must_use]
    pub(super) const fn uri(self) -> Option<&'static str> {
        match self {
            Self::Core => Some("http://opcfoundation.org/UA/"),
            Self::Di => Some("http://opcfoundation.org/UA/DI/"),
            Self::Machinery => Some("http://opcfoundation.org/UA/Machinery/"),
            Self::MachineTool => Some("http://opcfoundation.org/UA/MachineTool/"),
            Self::Cell => None,
        }
    }

    /// Name in the reference.
    #[must_use]
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Core => "UA",
            Self::Di => "DI",
            Self::Machinery => "Machinery",
            Self::MachineTool => "MachineTool",
            Self::Cell => "cell",
        }
    }
}

/// Number of a node in its namespace.
pub(super) type ModelId = (UaNamespace, u32);

const fn core(id: u32) -> ModelId {
    (UaNamespace::Core, id)
}

const fn di(id: u32) -> ModelId {
    (UaNamespace::Di, id)
}

const fn machinery(id: u32) -> ModelId {
    (UaNamespace::Machinery, id)
}

const fn tool(id: u32) -> ModelId {
    (UaNamespace::MachineTool, id)
}

/// Folder under Objects with all machines of a server.
pub(super) const MACHINES: ModelId = machinery(1001);

pub(super) const BASE_OBJECT: ModelId = core(58);
pub(super) const FOLDER: ModelId = core(61);
pub(super) const ORDERED_LIST: ModelId = core(23518);
pub(super) const BASE_DATA_VARIABLE: ModelId = core(63);
pub(super) const PROPERTY: ModelId = core(68);
pub(super) const STATE_VARIABLE: ModelId = core(2760);
pub(super) const STATE: ModelId = core(2307);
pub(super) const INITIAL_STATE: ModelId = core(2309);
/// A number with a unit.
pub(super) const ANALOG_UNIT: ModelId = core(17497);
/// A number with a unit and a range.
pub(super) const ANALOG_UNIT_RANGE: ModelId = core(17570);
const FINITE_STATE_MACHINE: ModelId = core(2771);
const ALARM_CONDITION: ModelId = core(2915);

const FUNCTIONAL_GROUP: ModelId = di(1005);

pub(super) const ITEM_STATE_TYPE: ModelId = machinery(1002);
const ITEM_IDENTIFICATION: ModelId = machinery(1004);
const MODE_TYPE: ModelId = machinery(1008);
pub(super) const OPERATION_COUNTERS: ModelId = machinery(1009);
const MACHINE_IDENTIFICATION: ModelId = machinery(1012);

pub(super) const NOTIFICATION: ModelId = tool(7);
pub(super) const IDENTIFICATION: ModelId = tool(11);
pub(super) const EQUIPMENT: ModelId = tool(12);
pub(super) const MACHINE_TOOL: ModelId = tool(13);
pub(super) const MONITORING: ModelId = tool(14);
const PROGRAM_STATES_TYPE: ModelId = tool(15);
pub(super) const CHANNEL: ModelId = tool(16);
pub(super) const PRODUCTION: ModelId = tool(21);
pub(super) const SPINDLE: ModelId = tool(22);
const ELEMENT: ModelId = tool(23);
const PRODUCTION_STATES_TYPE: ModelId = tool(24);
pub(super) const OPERATION: ModelId = tool(26);
const JOB_STATES_TYPE: ModelId = tool(28);
pub(super) const JOB: ModelId = tool(29);
pub(super) const JOB_LIST: ModelId = tool(30);
pub(super) const ACTIVE_PROGRAM: ModelId = tool(32);
pub(super) const MESSAGES: ModelId = tool(38);
pub(super) const ALERT: ModelId = tool(39);
const WORKING_UNIT: ModelId = tool(41);
pub(super) const TOOL_LIST: ModelId = tool(44);
const BASE_TOOL: ModelId = tool(49);
pub(super) const TOOL: ModelId = tool(50);
const PROGRAM: ModelId = tool(59);
pub(super) const TOOL_LIFE: ModelId = tool(61);
/// Property of an alert with the number of the alarm.
pub(super) const ALERT_ERROR_CODE: ModelId = tool(231);
const OPERATION_MODES_TYPE: ModelId = tool(1003);

/// A type of objects or variables.
#[derive(Debug, Clone, Copy)]
pub(super) struct UaType {
    pub(super) id: ModelId,
    pub(super) name: &'static str,
    pub(super) parent: ModelId,
    pub(super) is_abstract: bool,
    /// True for a type of variables.
    pub(super) is_variable: bool,
}

const fn concrete(id: ModelId, name: &'static str, parent: ModelId) -> UaType {
    UaType { id, name, parent, is_abstract: false, is_variable: false }
}

const fn is_abstract(id: ModelId, name: &'static str, parent: ModelId) -> UaType {
    UaType { is_abstract: true, ..concrete(id, name, parent) }
}

/// Types of the nodes, and their supertypes.
pub(super) const TYPES: &[UaType] = &[
    concrete(FUNCTIONAL_GROUP, "FunctionalGroupType", FOLDER),
    concrete(ITEM_STATE_TYPE, "MachineryItemState_StateMachineType", FINITE_STATE_MACHINE),
    is_abstract(ITEM_IDENTIFICATION, "MachineryItemIdentificationType", FUNCTIONAL_GROUP),
    concrete(MODE_TYPE, "MachineryOperationModeStateMachineType", FINITE_STATE_MACHINE),
    concrete(OPERATION_COUNTERS, "MachineryOperationCounterType", FUNCTIONAL_GROUP),
    concrete(MACHINE_IDENTIFICATION, "MachineIdentificationType", ITEM_IDENTIFICATION),
    concrete(NOTIFICATION, "NotificationType", BASE_OBJECT),
    concrete(IDENTIFICATION, "MachineToolIdentificationType", MACHINE_IDENTIFICATION),
    concrete(EQUIPMENT, "EquipmentType", BASE_OBJECT),
    concrete(MACHINE_TOOL, "MachineToolType", BASE_OBJECT),
    concrete(MONITORING, "MonitoringType", BASE_OBJECT),
    concrete(PROGRAM_STATES_TYPE, "ProductionProgramStateMachineType", PRODUCTION_STATES_TYPE),
    concrete(CHANNEL, "ChannelMonitoringType", ELEMENT),
    concrete(PRODUCTION, "ProductionType", BASE_OBJECT),
    concrete(SPINDLE, "SpindleMonitoringType", WORKING_UNIT),
    is_abstract(ELEMENT, "ElementMonitoringType", BASE_OBJECT),
    concrete(PRODUCTION_STATES_TYPE, "ProductionStateMachineType", FINITE_STATE_MACHINE),
    concrete(OPERATION, "MachineOperationMonitoringType", BASE_OBJECT),
    concrete(JOB_STATES_TYPE, "ProductionJobStateMachineType", PRODUCTION_STATES_TYPE),
    concrete(JOB, "ProductionJobType", BASE_OBJECT),
    concrete(JOB_LIST, "ProductionJobListType", ORDERED_LIST),
    concrete(ACTIVE_PROGRAM, "ProductionActiveProgramType", PROGRAM),
    concrete(MESSAGES, "MessagesType", BASE_OBJECT),
    concrete(ALERT, "AlertType", ALARM_CONDITION),
    is_abstract(WORKING_UNIT, "WorkingUnitMonitoringType", ELEMENT),
    concrete(TOOL_LIST, "ToolListType", BASE_OBJECT),
    is_abstract(BASE_TOOL, "BaseToolType", BASE_OBJECT),
    concrete(TOOL, "ToolType", BASE_TOOL),
    concrete(PROGRAM, "ProductionProgramType", BASE_OBJECT),
    UaType { is_variable: true, ..concrete(TOOL_LIFE, "ToolLifeType", BASE_DATA_VARIABLE) },
    concrete(OPERATION_MODES_TYPE, "MachineOperationModeStateMachineType", MODE_TYPE),
];

/// An enumeration whose values are 0, 1, 2 …
#[derive(Debug, PartialEq, Eq)]
pub(super) struct UaEnumeration {
    pub(super) id: ModelId,
    pub(super) name: &'static str,
    /// Number of its property `EnumValues`.
    pub(super) values_id: u32,
    pub(super) values: &'static [&'static str],
}

pub(super) const CHANNEL_STATE: UaEnumeration =
    UaEnumeration { id: tool(64), name: "ChannelState", values_id: 266, values: &["Active", "Interrupted", "Reset"] };
pub(super) const OPERATION_MODE: UaEnumeration = UaEnumeration {
    id: tool(65),
    name: "MachineOperationMode",
    values_id: 320,
    values: &["Manual", "Automatic", "Setup", "AutoWithManualIntervention", "Service", "Other"],
};
pub(super) const TOOL_LOCKED: UaEnumeration = UaEnumeration {
    id: tool(66),
    name: "ToolLocked",
    values_id: 309,
    values: &["CapabilityUnavailable", "ByOperator", "ToolBreak", "ToolLife", "MeasurementError", "Other"],
};
pub(super) const CHANNEL_MODE: UaEnumeration = UaEnumeration {
    id: tool(67),
    name: "ChannelMode",
    values_id: 288,
    values: &["Automatic", "MdaMdi", "JogManual", "JogIncrement", "TeachingHandle", "Remote", "Reference", "Other"],
};
pub(super) const TOOL_LIFE_INDICATION: UaEnumeration = UaEnumeration {
    id: tool(68),
    name: "ToolLifeIndication",
    values_id: 295,
    values: &[
        "Time",
        "NumberOfParts",
        "NumberOfUsages",
        "Feed_Distance",
        "Cutting_Distance",
        "Length",
        "Diameter",
        "Other",
    ],
};
pub(super) const TOOL_MANAGEMENT: UaEnumeration = UaEnumeration {
    id: tool(69),
    name: "ToolManagement",
    values_id: 268,
    values: &["NumberBased", "GroupBased", "Other"],
};

/// All enumerations of the nodes.
pub(super) const ENUMERATIONS: [&UaEnumeration; 6] =
    [&CHANNEL_STATE, &OPERATION_MODE, &TOOL_LOCKED, &CHANNEL_MODE, &TOOL_LIFE_INDICATION, &TOOL_MANAGEMENT];

/// A state of a state machine; its number is its index.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct UaState {
    pub(super) name: &'static str,
    pub(super) id: u32,
    /// Number of its property `StateNumber`.
    pub(super) number_id: u32,
}

const fn state(name: &'static str, id: u32, number_id: u32) -> UaState {
    UaState { name, id, number_id }
}

/// A finite state machine with the states of its type, which are in the type's namespace.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct UaStateMachine {
    pub(super) type_id: ModelId,
    pub(super) states: &'static [UaState],
    /// The first state is an initial state.
    pub(super) has_initial: bool,
}

pub(super) const ITEM_STATES: UaStateMachine = UaStateMachine {
    type_id: ITEM_STATE_TYPE,
    states: &[
        state("NotAvailable", 5005, 6039),
        state("OutOfService", 5004, 6038),
        state("NotExecuting", 5007, 6041),
        state("Executing", 5006, 6040),
    ],
    has_initial: false,
};
pub(super) const MODES: UaStateMachine = UaStateMachine {
    type_id: OPERATION_MODES_TYPE,
    states: &[
        state("None", 5059, 6081),
        state("Maintenance", 5058, 6080),
        state("Setup", 5061, 6083),
        state("Processing", 5060, 6082),
    ],
    has_initial: false,
};
pub(super) const PROGRAM_STATES: UaStateMachine = UaStateMachine {
    type_id: PROGRAM_STATES_TYPE,
    states: &[
        state("Initializing", 5039, 6060),
        state("Running", 5041, 6062),
        state("Ended", 5038, 6059),
        state("Interrupted", 5040, 6061),
        state("Aborted", 5037, 6058),
    ],
    has_initial: true,
};
pub(super) const JOB_STATES: UaStateMachine = UaStateMachine {
    type_id: JOB_STATES_TYPE,
    states: &[
        state("Initializing", 5015, 6050),
        state("Running", 5017, 6052),
        state("Ended", 5014, 6049),
        state("Interrupted", 5016, 6051),
        state("Aborted", 5013, 6048),
    ],
    has_initial: true,
};

/// All state machines of the nodes.
pub(super) const STATE_MACHINES: [&UaStateMachine; 4] = [&ITEM_STATES, &MODES, &PROGRAM_STATES, &JOB_STATES];

/// A unit of UNECE recommendation 20.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct UaUnit {
    /// Common code, up to three letters and digits.
    pub(super) code: &'static str,
    pub(super) symbol: &'static str,
    pub(super) name: &'static str,
}

impl UaUnit {
    /// Namespace of the units.
    pub(super) const NAMESPACE: &str = "http://www.opcfoundation.org/UA/units/un/cefact";

    /// Identifier of the unit: the code as a number with a letter in each byte.
    #[must_use]
    pub(super) fn id(&self) -> i32 {
        self.code.bytes().fold(0, |id, letter| (id << 8) | i32::from(letter))
    }
}

pub(super) const DEGREE: UaUnit = UaUnit { code: "DD", symbol: "°", name: "degree [unit of angle]" };
pub(super) const MILLIMETRE: UaUnit = UaUnit { code: "MMT", symbol: "mm", name: "millimetre" };
pub(super) const MILLIMETRE_PER_SECOND: UaUnit = UaUnit { code: "C16", symbol: "mm/s", name: "millimetre per second" };
pub(super) const NEWTON: UaUnit = UaUnit { code: "NEW", symbol: "N", name: "newton" };
pub(super) const NEWTON_METRE: UaUnit = UaUnit { code: "NU", symbol: "N·m", name: "newton metre" };
pub(super) const PERCENT: UaUnit = UaUnit { code: "P1", symbol: "%", name: "percent" };
pub(super) const REVOLUTION_PER_MINUTE: UaUnit =
    UaUnit { code: "RPM", symbol: "r/min", name: "revolutions per minute" };
pub(super) const WATT: UaUnit = UaUnit { code: "WTT", symbol: "W", name: "watt" };

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn units_have_the_published_identifiers() {
        // `UNECE_to_OPCUA.csv` of the OPC Foundation.
        let published = [(DEGREE, 17476), (MILLIMETRE, 5_066_068), (PERCENT, 20529), (NEWTON_METRE, 20053)];
        for (unit, id) in published {
            assert_eq!(unit.id(), id, "{}", unit.name);
        }
    }

    #[test]
    fn every_number_is_one_node_and_every_supertype_is_there() {
        let machines = STATE_MACHINES.iter().flat_map(|machine| {
            let numbers = machine.states.iter().flat_map(|state| [state.id, state.number_id]);
            numbers.map(|number| (machine.type_id.0, number))
        });
        let enumerations = ENUMERATIONS.iter().flat_map(|kind| [kind.id, (kind.id.0, kind.values_id)]);
        let ids: Vec<ModelId> = TYPES.iter().map(|kind| kind.id).chain(machines).chain(enumerations).collect();
        let unique: BTreeSet<(u16, u32)> = ids.iter().map(|(namespace, id)| (namespace.index(), *id)).collect();
        assert_eq!(ids.len(), unique.len());
        for kind in TYPES {
            let (namespace, _) = kind.parent;
            assert!(
                namespace == UaNamespace::Core || TYPES.iter().any(|other| other.id == kind.parent),
                "{}",
                kind.name
            );
        }
        for machine in STATE_MACHINES {
            assert!(TYPES.iter().any(|kind| kind.id == machine.type_id), "{machine:?}");
        }
    }
}
