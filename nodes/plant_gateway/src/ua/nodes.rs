// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Nodes of the machine in the address space, and their values from the messages of the cell.
//!
//! A value that the MTConnect adapter also has comes from the table of its data items. Names, types and places are those of the published
//! node sets; a test compares them with members that were looked up.

use super::model::{self, ModelId, UaEnumeration, UaNamespace, UaStateMachine, UaUnit};
use crate::cell_messages::{CellMessages, Equipment};
use crate::items::{Category, ITEMS, Item, ItemValue};
use UaNamespace::{Cell, Core, Di, MachineTool, Machinery};
use camwright_files::convert::machine_description::WHEEL_JOINT;
use camwright_msgs::camwright_msgs::msg::{Alarm, CellState, InterpolatorState};
use opcua::types::{LocalizedText, Variant};

/// Reference from a node to its child.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum UaReference {
    Component,
    Property,
    AddIn,
    OrderedComponent,
}

/// Data type of a variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum UaData {
    Boolean,
    UInt16,
    UInt32,
    UInt64,
    /// Milliseconds.
    Duration,
    Text,
    Localized,
    /// A number without unit.
    Number,
    /// A number with a unit, and its range if it has one.
    Analog(&'static UaUnit, Option<(f64, f64)>),
    Enumeration(&'static UaEnumeration),
    /// Constant description of a unit.
    Unit(&'static UaUnit),
    UInt16List,
    TextList,
}

/// Property of the machine that no message has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NameplateField {
    Manufacturer,
    SerialNumber,
    ProductInstanceUri,
}

/// Source of the value of a variable.
#[derive(Clone, Copy)]
pub(super) enum NodeSource {
    /// Data item of the MTConnect adapter.
    Item(&'static str),
    /// Data item with a time in seconds.
    SecondsOfItem(&'static str),
    Value(fn(&CellMessages) -> Option<Variant>),
    Nameplate(NameplateField),
    /// Constant of the model; the reading is that of a [`UaData::Unit`] or of `fn`.
    Fixed(fn() -> Variant),
}

#[derive(Clone, Copy)]
pub(super) enum NodeKind {
    /// An object with its type.
    Object(ModelId),
    /// A variable; without a type of its own it is a property or a plain variable.
    Variable { data: UaData, source: NodeSource, type_id: Option<ModelId>, is_sample: bool },
    /// A state machine, and the index of its present state.
    States(&'static UaStateMachine, fn(&CellMessages) -> Option<usize>),
    /// The node of another path as a child of this parent too.
    Link(&'static str),
}

/// A node below the machine.
#[derive(Clone, Copy)]
pub(super) struct UaNode {
    /// Browse names from the machine, separated by `/`.
    pub(super) path: &'static str,
    /// Namespace of the last browse name.
    pub(super) namespace: UaNamespace,
    pub(super) reference: UaReference,
    pub(super) kind: NodeKind,
    /// The machine has the equipment.
    applies: fn(Equipment) -> bool,
    /// Topic and field, for the reference.
    topic: &'static str,
    /// Rule for the value, for the reference.
    rule: &'static str,
}

/// Present value of a node.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum NodeReading {
    /// No message has it.
    Unavailable,
    /// The machine does not have the equipment.
    Unsupported,
    Value(Variant),
    /// Index of a state.
    State(usize),
    /// Constant, or no variable.
    Constant,
}

impl UaNode {
    /// Last browse name.
    #[must_use]
    pub(super) fn name(&self) -> &'static str {
        self.path.rsplit_once('/').map_or(self.path, |(_, name)| name)
    }

    /// Path of the parent; empty for the machine.
    #[must_use]
    pub(super) fn parent(&self) -> &'static str {
        self.path.rsplit_once('/').map_or("", |(parent, _)| parent)
    }

    /// Returns true if the value changes with time and not with events, so that it is published at an interval.
    #[must_use]
    pub(super) fn is_sample(&self) -> bool {
        match self.kind {
            NodeKind::Variable { source: NodeSource::Item(id) | NodeSource::SecondsOfItem(id), .. } => {
                item(id).is_some_and(|item| item.category == Category::Sample)
            }
            NodeKind::Variable { is_sample, .. } => is_sample,
            _ => false,
        }
    }

    /// Present value.
    #[must_use]
    pub(super) fn read(&self, cell: &CellMessages) -> NodeReading {
        let is_missing = |applies: fn(Equipment) -> bool| cell.description().is_some() && !applies(cell.equipment);
        let value = match self.kind {
            NodeKind::Object(_) | NodeKind::Link(_) => return NodeReading::Constant,
            NodeKind::States(_, state) => return state(cell).map_or(NodeReading::Unavailable, NodeReading::State),
            NodeKind::Variable { source: NodeSource::Nameplate(_) | NodeSource::Fixed(_), .. } => {
                return NodeReading::Constant;
            }
            NodeKind::Variable { source: NodeSource::Value(value), .. } => {
                if is_missing(self.applies) {
                    return NodeReading::Unsupported;
                }
                value(cell)
            }
            NodeKind::Variable { source: NodeSource::Item(id) | NodeSource::SecondsOfItem(id), data, .. } => {
                let Some(item) = item(id) else { return NodeReading::Unavailable };
                if is_missing(item.applies) {
                    return NodeReading::Unsupported;
                }
                item.value(cell).map(|value| as_data(value, data))
            }
        };
        value.map_or(NodeReading::Unavailable, NodeReading::Value)
    }

    /// Type of a node in the reference.
    #[must_use]
    pub(super) fn type_name(&self) -> String {
        match self.kind {
            NodeKind::Object(id) => model::TYPES.iter().find(|kind| kind.id == id).map_or_else(
                || if id == model::FOLDER { "folder" } else { "object" }.to_owned(),
                |kind| format!("`{}`", kind.name),
            ),
            NodeKind::States(machine, _) => {
                let name = model::TYPES.iter().find(|kind| kind.id == machine.type_id).map_or("", |kind| kind.name);
                format!("`{name}`")
            }
            NodeKind::Link(path) => format!("the node `{path}`"),
            NodeKind::Variable { data, .. } => match data {
                UaData::Boolean => "Boolean".into(),
                UaData::UInt16 => "UInt16".into(),
                UaData::UInt32 => "UInt32".into(),
                UaData::UInt64 => "UInt64".into(),
                UaData::Duration => "Duration (ms)".into(),
                UaData::Text => "String".into(),
                UaData::Localized => "LocalizedText".into(),
                UaData::Number => "Double".into(),
                UaData::Analog(unit, None) => format!("Double ({})", unit.symbol),
                UaData::Analog(unit, Some((low, high))) => format!("Double ({low} to {high} {})", unit.symbol),
                UaData::Enumeration(kind) => format!("`{}`", kind.name),
                UaData::Unit(_) => "`EUInformation`".into(),
                UaData::UInt16List => "UInt16[]".into(),
                UaData::TextList => "String[]".into(),
            },
        }
    }

    /// Source and rule in the reference. A node that shows a data item has those of the item.
    #[must_use]
    pub(super) fn origin(&self) -> (String, String) {
        match self.kind {
            NodeKind::Variable { source: NodeSource::Item(id) | NodeSource::SecondsOfItem(id), .. } => {
                let topic = item(id).map_or("", |item| item.topic);
                let rule = if self.rule.is_empty() { "as in MTConnect".to_owned() } else { self.rule.to_owned() };
                (topic.to_owned(), format!("`{id}`: {rule}"))
            }
            _ => (self.topic.to_owned(), self.rule.to_owned()),
        }
    }

    const fn with_source(self, topic: &'static str, rule: &'static str) -> Self {
        Self { topic, rule, ..self }
    }

    const fn with_rule(self, rule: &'static str) -> Self {
        Self { rule, ..self }
    }

    const fn for_machines(self, applies: fn(Equipment) -> bool) -> Self {
        Self { applies, ..self }
    }

    const fn under(self, reference: UaReference) -> Self {
        Self { reference, ..self }
    }

    /// A value that changes with time.
    const fn as_sample(self) -> Self {
        match self.kind {
            NodeKind::Variable { data, source, type_id, .. } => {
                Self { kind: NodeKind::Variable { data, source, type_id, is_sample: true }, ..self }
            }
            _ => self,
        }
    }

    const fn with_type(self, id: ModelId) -> Self {
        match self.kind {
            NodeKind::Variable { data, source, is_sample, .. } => {
                Self { kind: NodeKind::Variable { data, source, is_sample, type_id: Some(id) }, ..self }
            }
            _ => self,
        }
    }
}

/// Milliseconds in a second.
const MS_PER_S: f64 = 1e3;

/// Data item of the MTConnect adapter.
fn item(id: &str) -> Option<&'static Item> {
    ITEMS.iter().find(|item| item.id == id)
}

/// Value of a data item in the data type of a node.
fn as_data(value: ItemValue, data: UaData) -> Variant {
    match (value, data) {
        (ItemValue::Text(text), UaData::Localized) => LocalizedText::new("en", &text).into(),
        (ItemValue::Text(text), _) => text.into(),
        (ItemValue::Count(count), UaData::UInt64) => count.into(),
        (ItemValue::Count(count), _) => saturated(count).into(),
        // The clock of a cell is a double itself.
        (ItemValue::Real(seconds, decimals), UaData::Duration) => {
            rounded(MS_PER_S * rounded(seconds, decimals), 0).into()
        }
        (ItemValue::Real(value, decimals), _) => rounded(value, decimals).into(),
    }
}

/// A number rounded to decimals, so that a client does not get changes that MTConnect does not show.
fn rounded(value: f64, decimals: usize) -> f64 {
    // No power of ten here has more than six zeros.
    let scale = (0..decimals).fold(1.0, |scale, _| scale * 10.0);
    // Without the sign of a negative zero.
    (value * scale).round() / scale + 0.0
}

fn saturated(count: u64) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

fn always(_: Equipment) -> bool {
    true
}

const fn node(path: &'static str, namespace: UaNamespace, reference: UaReference, kind: NodeKind) -> UaNode {
    UaNode { path, namespace, reference, kind, applies: always, topic: "", rule: "" }
}

const fn object(path: &'static str, namespace: UaNamespace, type_id: ModelId) -> UaNode {
    node(path, namespace, UaReference::Component, NodeKind::Object(type_id))
}

const fn add_in(path: &'static str, namespace: UaNamespace, type_id: ModelId) -> UaNode {
    object(path, namespace, type_id).under(UaReference::AddIn)
}

const fn link(path: &'static str, namespace: UaNamespace, target: &'static str) -> UaNode {
    node(path, namespace, UaReference::AddIn, NodeKind::Link(target))
}

const fn states(
    path: &'static str,
    namespace: UaNamespace,
    machine: &'static UaStateMachine,
    state: fn(&CellMessages) -> Option<usize>,
) -> UaNode {
    node(path, namespace, UaReference::Component, NodeKind::States(machine, state))
}

const fn variable(path: &'static str, namespace: UaNamespace, data: UaData, source: NodeSource) -> UaNode {
    let kind = NodeKind::Variable { data, source, type_id: None, is_sample: false };
    node(path, namespace, UaReference::Component, kind)
}

const fn shown(path: &'static str, namespace: UaNamespace, data: UaData, id: &'static str) -> UaNode {
    variable(path, namespace, data, NodeSource::Item(id))
}

const fn value(
    path: &'static str,
    namespace: UaNamespace,
    data: UaData,
    value: fn(&CellMessages) -> Option<Variant>,
) -> UaNode {
    variable(path, namespace, data, NodeSource::Value(value))
}

const fn property(node: UaNode) -> UaNode {
    node.under(UaReference::Property)
}

const fn fixed(path: &'static str, namespace: UaNamespace, data: UaData, value: fn() -> Variant) -> UaNode {
    variable(path, namespace, data, NodeSource::Fixed(value))
}

const fn nameplate(path: &'static str, data: UaData, field: NameplateField) -> UaNode {
    property(variable(path, Di, data, NodeSource::Nameplate(field)))
}

const CELL_STATE: &str = "`job_planner/cell_state`";
const OVERRIDE: UaData = UaData::Analog(&model::PERCENT, Some((0.0, 100.0)));
const ANGLE: UaData = UaData::Analog(&model::DEGREE, None);
const LENGTH: UaData = UaData::Analog(&model::MILLIMETRE, None);
const SPEED: UaData = UaData::Analog(&model::MILLIMETRE_PER_SECOND, None);
const ROTATION: UaData = UaData::Analog(&model::REVOLUTION_PER_MINUTE, None);
const FORCE: UaData = UaData::Analog(&model::NEWTON, None);
const TORQUE: UaData = UaData::Analog(&model::NEWTON_METRE, None);
const POWER: UaData = UaData::Analog(&model::WATT, None);
const STATE_RULE: &str = "Initializing in 3, 4, 15; Running in 6, 12, 14, 16; Ended in 17; Interrupted in 5, 10, 11, 13; Aborted in 1, 2, 7, 8, 9";

/// All nodes below the machine; a parent comes before its children.
pub(super) const NODES: &[UaNode] = &[
    add_in("Identification", Di, model::IDENTIFICATION),
    nameplate("Identification/Manufacturer", UaData::Localized, NameplateField::Manufacturer)
        .with_source("`--manufacturer`", "unknown without the option"),
    nameplate("Identification/SerialNumber", UaData::Text, NameplateField::SerialNumber)
        .with_source("`--serial-number`", "unknown without the option"),
    nameplate("Identification/ProductInstanceUri", UaData::Text, NameplateField::ProductInstanceUri)
        .with_source("`--product-instance-uri`", "without the option the namespace URI of the cell"),
    property(value("Identification/Model", Di, UaData::Localized, |cell| {
        cell.description().map(|machine| LocalizedText::new("en", &machine.name).into())
    }))
    .with_source("`machine/description` `name`", "name of the machine"),
    object("MachineryBuildingBlocks", Machinery, model::FOLDER),
    link("MachineryBuildingBlocks/Identification", Di, "Identification"),
    states("MachineryBuildingBlocks/MachineryItemState", Machinery, &model::ITEM_STATES, |cell| {
        cell.cell().and_then(|cell| item_state(cell.state))
    })
    .under(UaReference::AddIn)
    .with_source(
        "`job_planner/cell_state` `state`",
        "OutOfService in 1, 8, 9; Executing in 6, 12, 14, 16; else NotExecuting",
    ),
    states("MachineryBuildingBlocks/MachineryOperationMode", Machinery, &model::MODES, |cell| {
        cell.cell().and_then(|cell| operation_mode(cell.mode))
    })
    .under(UaReference::AddIn)
    .with_source("`job_planner/cell_state` `mode`", "Processing for 1 and 4, Setup for 2 and 3"),
    add_in("MachineryBuildingBlocks/OperationCounters", Di, model::OPERATION_COUNTERS),
    property(variable(
        "MachineryBuildingBlocks/OperationCounters/PowerOnDuration",
        Di,
        UaData::Duration,
        NodeSource::SecondsOfItem("equipment_timer_powered"),
    ))
    .with_rule("time since the node started"),
    property(variable(
        "MachineryBuildingBlocks/OperationCounters/OperationDuration",
        Di,
        UaData::Duration,
        NodeSource::SecondsOfItem("equipment_timer_working"),
    ))
    .with_rule("time in EXECUTE since the node started"),
    value("MachineryBuildingBlocks/OperationCounters/PartsProducedInLifetime", MachineTool, UaData::UInt64, |cell| {
        cell.counters().map(|counters| counters.life.total.into())
    })
    .with_source("`machine/counters` `life`", "`total`"),
    object("Monitoring", MachineTool, model::MONITORING),
    object("Monitoring/MachineTool", MachineTool, model::OPERATION),
    value("Monitoring/MachineTool/OperationMode", MachineTool, UaData::Enumeration(&model::OPERATION_MODE), |cell| {
        cell.cell().and_then(|cell| machine_mode(cell.mode)).map(Variant::from)
    })
    .with_source(
        "`job_planner/cell_state` `mode`",
        "Automatic (1) for 1, Setup (2) for 2, Manual (0) for 3, AutoWithManualIntervention (3) for 4",
    ),
    shown("Monitoring/MachineTool/FeedOverride", MachineTool, OVERRIDE, "path_feedrate_override"),
    link("Monitoring/MachineTool/MachineryItemState", Machinery, "MachineryBuildingBlocks/MachineryItemState"),
    link("Monitoring/MachineTool/MachineryOperationMode", Machinery, "MachineryBuildingBlocks/MachineryOperationMode"),
    link("Monitoring/MachineTool/OperationCounters", Di, "MachineryBuildingBlocks/OperationCounters"),
    object("Monitoring/Channel", Cell, model::CHANNEL),
    property(fixed("Monitoring/Channel/Name", MachineTool, UaData::Text, || "Channel".into())).with_rule("constant"),
    value("Monitoring/Channel/ChannelState", MachineTool, UaData::Enumeration(&model::CHANNEL_STATE), |cell| {
        cell.interpolator().and_then(|state| channel_state(state.state)).map(Variant::from)
    })
    .with_source(
        "`axis_interpolator/state` `state`",
        "Active (0) in EXECUTING, UNHOLDING, STOPPING; Interrupted (1) in HOLDING, HELD; Reset (2) in IDLE, FAULT",
    ),
    value("Monitoring/Channel/ChannelMode", MachineTool, UaData::Enumeration(&model::CHANNEL_MODE), |cell| {
        cell.cell().and_then(|cell| channel_mode(cell.mode)).map(Variant::from)
    })
    .with_source("`job_planner/cell_state` `mode`", "Automatic (0) for 1 and 4, JogManual (2) for 3, Other (7) for 2"),
    shown("Monitoring/Channel/FeedOverride", MachineTool, OVERRIDE, "path_feedrate_override"),
    object("Monitoring/Spindle", Cell, model::SPINDLE),
    property(fixed("Monitoring/Spindle/Name", MachineTool, UaData::Text, || "Wheel spindle".into()))
        .with_rule("constant"),
    value("Monitoring/Spindle/IsRotating", MachineTool, UaData::Boolean, |cell| is_rotating(cell).map(Variant::from))
        .for_machines(|equipment| equipment.wheel)
        .as_sample()
        .with_source(
            "`dynamic_joint_states`, `machine/io`",
            "`s_velocity` is not 0; without a contact law `wheel_running`",
        ),
    shown("Monitoring/Spindle/Speed", Cell, ROTATION, "s_velocity"),
    shown("Monitoring/Spindle/Power", Cell, POWER, "s_power"),
    object("Axes", Cell, model::FOLDER),
    object("Axes/C", Cell, model::BASE_OBJECT),
    shown("Axes/C/Position", Cell, ANGLE, "c_angle"),
    shown("Axes/C/Speed", Cell, ROTATION, "c_velocity"),
    shown("Axes/C/Torque", Cell, TORQUE, "c_torque"),
    object("Axes/X", Cell, model::BASE_OBJECT),
    shown("Axes/X/Position", Cell, LENGTH, "x_position"),
    shown("Axes/X/Speed", Cell, SPEED, "x_feedrate"),
    shown("Axes/X/Force", Cell, FORCE, "x_force"),
    object("Axes/Z", Cell, model::BASE_OBJECT),
    shown("Axes/Z/Position", Cell, LENGTH, "z_position"),
    shown("Axes/Z/Speed", Cell, SPEED, "z_feedrate"),
    shown("Axes/Z/Force", Cell, FORCE, "z_force"),
    object("Production", MachineTool, model::PRODUCTION),
    object("Production/ActiveProgram", MachineTool, model::ACTIVE_PROGRAM),
    property(value("Production/ActiveProgram/Name", MachineTool, UaData::Text, job_name))
        .with_source("`job_planner/cell_state` `job`", "name of the job; empty before the first one"),
    property(fixed("Production/ActiveProgram/NumberInList", Core, UaData::UInt16, || 0_u16.into()))
        .with_rule("constant: one program"),
    states("Production/ActiveProgram/State", MachineTool, &model::PROGRAM_STATES, |cell| {
        cell.cell().and_then(|cell| program_state(cell.state))
    })
    .with_source("`job_planner/cell_state` `state`", STATE_RULE),
    object("Production/ProductionPlan", MachineTool, model::JOB_LIST),
    object("Production/ProductionPlan/Job", Cell, model::JOB).under(UaReference::OrderedComponent),
    property(value("Production/ProductionPlan/Job/Identifier", MachineTool, UaData::Text, job_name))
        .with_source("`job_planner/cell_state` `job`", "name of the job"),
    property(fixed("Production/ProductionPlan/Job/NumberInList", Core, UaData::UInt16, || 0_u16.into()))
        .with_rule("constant: one job"),
    value("Production/ProductionPlan/Job/RunsPlanned", MachineTool, UaData::UInt32, |cell| {
        cell.cell().map(|cell| cell.parts_wanted.into())
    })
    .with_source(CELL_STATE, "`parts_wanted`"),
    property(value("Production/ProductionPlan/Job/RunsPlanned/IsValid", MachineTool, UaData::Boolean, |cell| {
        cell.cell().map(|cell| (cell.parts_wanted > 0).into())
    }))
    .with_source(CELL_STATE, "false if `parts_wanted` is 0: the run goes on until it is stopped"),
    value("Production/ProductionPlan/Job/RunsCompleted", MachineTool, UaData::UInt32, |cell| {
        cell.cell().map(|cell| cell.parts_done.into())
    })
    .with_source(CELL_STATE, "`parts_done`"),
    shown("Production/ProductionPlan/Job/PartsCompleted", MachineTool, UaData::UInt32, "part_count_all")
        .with_rule("parts of the shift, not of the job"),
    shown("Production/ProductionPlan/Job/PartsGood", MachineTool, UaData::UInt32, "part_count_good")
        .with_rule("parts of the shift, not of the job"),
    object("Production/ProductionPlan/Job/ProductionPrograms", MachineTool, model::ORDERED_LIST),
    link("Production/ProductionPlan/Job/ProductionPrograms/ActiveProgram", MachineTool, "Production/ActiveProgram")
        .under(UaReference::OrderedComponent),
    states("Production/ProductionPlan/Job/State", MachineTool, &model::JOB_STATES, |cell| {
        cell.cell().and_then(|cell| program_state(cell.state))
    })
    .with_source("`job_planner/cell_state` `state`", "as `Production/ActiveProgram/State`"),
    object("Notification", MachineTool, model::NOTIFICATION),
    object("Notification/Messages", MachineTool, model::MESSAGES)
        .with_source("`machine/alarms`, `axis_interpolator/alarms`", "source of the alerts, see below"),
    object("Notification/ActiveAlarms", Cell, model::BASE_OBJECT),
    value("Notification/ActiveAlarms/Numbers", Cell, UaData::UInt16List, |cell| {
        alarms(cell).map(|alarms| alarms.iter().map(|alarm| alarm.number).collect::<Vec<u16>>().into())
    })
    .with_source(ALARMS, "`number` of each active alarm, oldest first"),
    value("Notification/ActiveAlarms/Severities", Cell, UaData::UInt16List, |cell| {
        alarms(cell).map(|alarms| alarms.iter().map(|alarm| severity(alarm.severity)).collect::<Vec<u16>>().into())
    })
    .with_source(ALARMS, "500 for warning, 700 for stop, 900 for power off"),
    value("Notification/ActiveAlarms/Texts", Cell, UaData::TextList, |cell| {
        alarms(cell).map(|alarms| alarms.iter().map(|alarm| alarm.text.clone()).collect::<Vec<String>>().into())
    })
    .with_source(ALARMS, "`text`"),
    value("Notification/ActiveAlarms/Sources", Cell, UaData::TextList, |cell| {
        alarms(cell).map(|alarms| alarms.iter().map(|alarm| alarm.source.clone()).collect::<Vec<String>>().into())
    })
    .with_source(ALARMS, "`source`: node or axis"),
    object("Equipment", MachineTool, model::EQUIPMENT),
    object("Equipment/Tools", MachineTool, model::TOOL_LIST),
    object("Equipment/Tools/Wheel", Cell, model::TOOL),
    property(value("Equipment/Tools/Wheel/Name", MachineTool, UaData::Text, |cell| {
        cell.description().map(|machine| machine.wheel.clone().into())
    }))
    .for_machines(|equipment| equipment.wheel)
    .with_source("`machine/description` `wheel`", "name of the mounted wheel; empty without a changer"),
    shown("Equipment/Tools/Wheel/ControlIdentifier1", MachineTool, UaData::UInt32, "tool_number"),
    fixed(
        "Equipment/Tools/Wheel/ControlIdentifierInterpretation",
        MachineTool,
        UaData::Enumeration(&model::TOOL_MANAGEMENT),
        || 0_i32.into(),
    )
    .with_rule("constant: NumberBased (0)"),
    fixed("Equipment/Tools/Wheel/Locked", MachineTool, UaData::Boolean, || false.into())
        .with_rule("constant false: the cell locks no wheel"),
    property(fixed(
        "Equipment/Tools/Wheel/Locked/ReasonForLocking",
        MachineTool,
        UaData::Enumeration(&model::TOOL_LOCKED),
        || 0_i32.into(),
    ))
    .with_rule("constant: CapabilityUnavailable (0)"),
    object("Equipment/Tools/Wheel/ToolLife", MachineTool, model::BASE_OBJECT),
    shown("Equipment/Tools/Wheel/ToolLife/Diameter", Cell, UaData::Number, "s_diameter").with_type(model::TOOL_LIFE),
    property(fixed(
        "Equipment/Tools/Wheel/ToolLife/Diameter/EngineeringUnits",
        MachineTool,
        UaData::Unit(&model::MILLIMETRE),
        || Variant::Empty,
    ))
    .with_rule("constant: mm"),
    property(fixed(
        "Equipment/Tools/Wheel/ToolLife/Diameter/Indication",
        MachineTool,
        UaData::Enumeration(&model::TOOL_LIFE_INDICATION),
        || 6_i32.into(),
    ))
    .with_rule("constant: Diameter (6)"),
    property(fixed("Equipment/Tools/Wheel/ToolLife/Diameter/IsCountingUp", MachineTool, UaData::Boolean, || {
        false.into()
    }))
    .with_rule("constant false"),
    object("Cell", Cell, model::BASE_OBJECT),
    value("Cell/State", Cell, UaData::Text, |cell| cell.cell().map(|cell| cell.state_name.clone().into()))
        .with_source(CELL_STATE, "`state_name`: state of PackML"),
    value("Cell/StopReason", Cell, UaData::Text, |cell| cell.cell().map(|cell| cell.stop_reason.clone().into()))
        .with_source(CELL_STATE, "`stop_reason`"),
    value("Cell/EmergencyStop", Cell, UaData::Boolean, |cell| cell.io().map(|io| io.estop.into()))
        .with_source("`machine/io` `estop`", "true: pressed"),
    value("Cell/PartPresent", Cell, UaData::Boolean, |cell| cell.io().map(|io| io.part_present.into()))
        .with_source("`machine/io` `part_present`", "true: a part is clamped"),
    shown("Cell/Door", Cell, UaData::Text, "door_state"),
    shown("Cell/Chuck", Cell, UaData::Text, "chuck_state"),
];

const ALARMS: &str = "`machine/alarms`, `axis_interpolator/alarms`";
/// Maximum number of alarms in a list.
const MAX_ALARMS: usize = 200;

/// Active alarms of machine and interpolator; `None` without a list of the machine.
pub(super) fn alarms(cell: &CellMessages) -> Option<Vec<&Alarm>> {
    cell.alarms().map(|alarms| alarms.take(MAX_ALARMS).collect())
}

/// Severity of an alert: 334 to 666 for warnings, 667 to 1000 for errors.
#[must_use]
pub(super) fn severity(severity: u8) -> u16 {
    match severity {
        Alarm::WARNING => 500,
        Alarm::STOP => 700,
        _ => 900,
    }
}

fn job_name(cell: &CellMessages) -> Option<Variant> {
    cell.cell().map(|cell| cell.job.clone().into())
}

fn is_rotating(cell: &CellMessages) -> Option<bool> {
    match cell.joint(WHEEL_JOINT, "velocity") {
        Some(rad_s) => Some(rounded(rad_s, 3).abs() > 0.0),
        None => cell.io().filter(|_| !cell.equipment.wheel_speed).map(|io| io.wheel_running),
    }
}

/// Index of the state of the machine for a state of the cell.
fn item_state(state: u8) -> Option<usize> {
    Some(match state {
        CellState::CLEARING | CellState::ABORTING | CellState::ABORTED => 1,
        CellState::EXECUTE | CellState::UNHOLDING | CellState::UNSUSPENDING | CellState::COMPLETING => 3,
        CellState::CLEARING..=CellState::COMPLETE => 2,
        _ => return None,
    })
}

/// Index of the state of the program for a state of the cell.
fn program_state(state: u8) -> Option<usize> {
    Some(match state {
        CellState::STARTING | CellState::IDLE | CellState::RESETTING => 0,
        CellState::EXECUTE | CellState::UNHOLDING | CellState::UNSUSPENDING | CellState::COMPLETING => 1,
        CellState::COMPLETE => 2,
        CellState::HOLDING | CellState::HELD | CellState::SUSPENDING | CellState::SUSPENDED => 3,
        CellState::CLEARING | CellState::STOPPED | CellState::STOPPING | CellState::ABORTING | CellState::ABORTED => 4,
        _ => return None,
    })
}

/// Index of the mode of the machine for a mode of the cell.
fn operation_mode(mode: u8) -> Option<usize> {
    Some(match mode {
        CellState::AUTOMATIC | CellState::SEMI_AUTOMATIC => 3,
        CellState::SETUP | CellState::MANUAL => 2,
        _ => return None,
    })
}

/// Value of `MachineOperationMode` for a mode of the cell.
fn machine_mode(mode: u8) -> Option<i32> {
    Some(match mode {
        CellState::AUTOMATIC => 1,
        CellState::SETUP => 2,
        CellState::MANUAL => 0,
        CellState::SEMI_AUTOMATIC => 3,
        _ => return None,
    })
}

/// Value of `ChannelMode` for a mode of the cell.
fn channel_mode(mode: u8) -> Option<i32> {
    Some(match mode {
        CellState::AUTOMATIC | CellState::SEMI_AUTOMATIC => 0,
        CellState::MANUAL => 2,
        CellState::SETUP => 7,
        _ => return None,
    })
}

/// Value of `ChannelState` for a state of the interpolator.
fn channel_state(state: u8) -> Option<i32> {
    Some(match state {
        InterpolatorState::EXECUTING | InterpolatorState::UNHOLDING | InterpolatorState::STOPPING => 0,
        InterpolatorState::HOLDING | InterpolatorState::HELD => 1,
        InterpolatorState::IDLE | InterpolatorState::FAULT => 2,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell_messages::Presence;
    use UaReference::{AddIn, Component, OrderedComponent, Property};
    use camwright_msgs::camwright_msgs::msg::{
        MachineAlarms, MachineCounters, MachineDescription, MachineIo, PartCounters,
    };
    use camwright_msgs::control_msgs::msg::{DynamicJointState, InterfaceValue};
    use std::collections::BTreeSet;

    type Member = (UaNamespace, &'static str, UaReference, &'static str);

    /// Members of the published types: namespace, browse name, reference, type or data type. Read in the node sets of OPC 40501-1 1.02.0
    /// (2024-11-01) and OPC 40001-1 1.04.1 (2026-01-01), as the package node-opcua-nodesets 2.182.0 has them. A parent without a type of its own
    /// is there by its name.
    const PUBLISHED: &[(&str, &[Member])] = &[
        (
            "MachineToolType",
            &[
                (Di, "Identification", AddIn, "MachineToolIdentificationType"),
                (Machinery, "MachineryBuildingBlocks", Component, "folder"),
                (MachineTool, "Monitoring", Component, "MonitoringType"),
                (MachineTool, "Production", Component, "ProductionType"),
                (MachineTool, "Notification", Component, "NotificationType"),
                (MachineTool, "Equipment", Component, "EquipmentType"),
            ],
        ),
        (
            "MachineToolIdentificationType",
            &[
                (Di, "Manufacturer", Property, "LocalizedText"),
                (Di, "SerialNumber", Property, "String"),
                (Di, "ProductInstanceUri", Property, "String"),
                (Di, "Model", Property, "LocalizedText"),
            ],
        ),
        (
            "MachineryBuildingBlocks",
            &[
                (Di, "Identification", AddIn, "link"),
                (Machinery, "MachineryItemState", AddIn, "MachineryItemState_StateMachineType"),
                (Machinery, "MachineryOperationMode", AddIn, "MachineOperationModeStateMachineType"),
                (Di, "OperationCounters", AddIn, "MachineryOperationCounterType"),
            ],
        ),
        (
            "MachineryOperationCounterType",
            &[
                (Di, "PowerOnDuration", Property, "Duration (ms)"),
                (Di, "OperationDuration", Property, "Duration (ms)"),
                (MachineTool, "PartsProducedInLifetime", Component, "UInt64"),
            ],
        ),
        ("MonitoringType", &[(MachineTool, "MachineTool", Component, "MachineOperationMonitoringType")]),
        (
            "MachineOperationMonitoringType",
            &[
                (MachineTool, "OperationMode", Component, "MachineOperationMode"),
                (MachineTool, "FeedOverride", Component, "Double (0 to 100 %)"),
                (Machinery, "MachineryItemState", AddIn, "link"),
                (Machinery, "MachineryOperationMode", AddIn, "link"),
                (Di, "OperationCounters", AddIn, "link"),
            ],
        ),
        (
            "ChannelMonitoringType",
            &[
                (MachineTool, "Name", Property, "String"),
                (MachineTool, "ChannelState", Component, "ChannelState"),
                (MachineTool, "ChannelMode", Component, "ChannelMode"),
                (MachineTool, "FeedOverride", Component, "Double (0 to 100 %)"),
            ],
        ),
        (
            "SpindleMonitoringType",
            &[(MachineTool, "Name", Property, "String"), (MachineTool, "IsRotating", Component, "Boolean")],
        ),
        (
            "ProductionType",
            &[
                (MachineTool, "ActiveProgram", Component, "ProductionActiveProgramType"),
                (MachineTool, "ProductionPlan", Component, "ProductionJobListType"),
            ],
        ),
        (
            "ProductionActiveProgramType",
            &[
                (MachineTool, "Name", Property, "String"),
                (Core, "NumberInList", Property, "UInt16"),
                (MachineTool, "State", Component, "ProductionProgramStateMachineType"),
            ],
        ),
        (
            "ProductionJobType",
            &[
                (MachineTool, "Identifier", Property, "String"),
                (Core, "NumberInList", Property, "UInt16"),
                (MachineTool, "RunsPlanned", Component, "UInt32"),
                (MachineTool, "RunsCompleted", Component, "UInt32"),
                (MachineTool, "PartsCompleted", Component, "UInt32"),
                (MachineTool, "PartsGood", Component, "UInt32"),
                (MachineTool, "ProductionPrograms", Component, "object"),
                (MachineTool, "State", Component, "ProductionJobStateMachineType"),
            ],
        ),
        ("RunsPlanned", &[(MachineTool, "IsValid", Property, "Boolean")]),
        ("ProductionPrograms", &[(MachineTool, "ActiveProgram", OrderedComponent, "link")]),
        ("NotificationType", &[(MachineTool, "Messages", Component, "MessagesType")]),
        ("EquipmentType", &[(MachineTool, "Tools", Component, "ToolListType")]),
        (
            "ToolType",
            &[
                (MachineTool, "Name", Property, "String"),
                (MachineTool, "ControlIdentifier1", Component, "UInt32"),
                (MachineTool, "ControlIdentifierInterpretation", Component, "ToolManagement"),
                (MachineTool, "Locked", Component, "Boolean"),
                (MachineTool, "ToolLife", Component, "object"),
            ],
        ),
        ("Locked", &[(MachineTool, "ReasonForLocking", Property, "ToolLocked")]),
        (
            "ToolLifeType",
            &[
                (MachineTool, "EngineeringUnits", Property, "EUInformation"),
                (MachineTool, "Indication", Property, "ToolLifeIndication"),
                (MachineTool, "IsCountingUp", Property, "Boolean"),
            ],
        ),
    ];

    fn type_of(node: &UaNode) -> String {
        match node.kind {
            NodeKind::Link(_) => "link".to_owned(),
            NodeKind::Variable { type_id: Some(id), .. } => {
                model::TYPES.iter().find(|kind| kind.id == id).expect("a type").name.to_owned()
            }
            _ => node.type_name().trim_matches('`').to_owned(),
        }
    }

    /// Members of the parent's type in the published model.
    fn published(parent: &str) -> &'static [Member] {
        let node = NODES.iter().find(|node| node.path == parent);
        let keys =
            node.map_or(["MachineToolType".to_owned(), String::new()], |node| [type_of(node), node.name().to_owned()]);
        PUBLISHED.iter().find(|(key, _)| keys.iter().any(|other| other == key)).map_or(&[], |(_, members)| members)
    }

    #[test]
    fn nodes_are_those_of_the_published_models() {
        let mut found = 0;
        for node in NODES.iter().filter(|node| node.namespace != Cell) {
            let member = (node.namespace, node.name(), node.reference, type_of(node));
            let is_published = published(node.parent()).iter().any(|(namespace, name, reference, kind)| {
                (*namespace, *name, *reference, (*kind).to_owned()) == member
            });
            assert!(is_published, "{} is no member: {member:?}", node.path);
            found += 1;
        }
        let members: usize = PUBLISHED.iter().map(|(_, members)| members.len()).sum();
        assert_eq!(found, members, "the list has a member that no node is");
    }

    #[test]
    fn a_parent_comes_before_its_children_and_a_source_is_an_item() {
        let mut paths = BTreeSet::new();
        for node in NODES {
            assert!(node.parent().is_empty() || paths.contains(node.parent()), "{}", node.path);
            assert!(paths.insert(node.path), "{} is there twice", node.path);
            match node.kind {
                NodeKind::Link(target) => assert!(paths.contains(target), "{} shows nothing", node.path),
                NodeKind::Variable { source: NodeSource::Item(id) | NodeSource::SecondsOfItem(id), data, .. } => {
                    let item = item(id).unwrap_or_else(|| panic!("{} has no item {id}", node.path));
                    assert_ne!(item.category, Category::Condition);
                    // Both protocols have the same unit.
                    let unit = match data {
                        UaData::Analog(unit, _) => Some(unit.symbol),
                        _ => None,
                    };
                    let published = [
                        ("DEGREE", "°"),
                        ("REVOLUTION/MINUTE", "r/min"),
                        ("NEWTON_METER", "N·m"),
                        ("MILLIMETER", "mm"),
                        ("MILLIMETER/SECOND", "mm/s"),
                        ("NEWTON", "N"),
                        ("WATT", "W"),
                    ];
                    let expected = item.units.and_then(|units| published.iter().find(|(name, _)| *name == units));
                    if let (Some((_, symbol)), Some(unit)) = (expected, unit) {
                        assert_eq!(unit, *symbol, "{}", node.path);
                    }
                }
                _ => {}
            }
            let has_origin = !node.origin().0.is_empty() || !node.origin().1.is_empty();
            let needs_origin = matches!(node.kind, NodeKind::Variable { .. } | NodeKind::States(..));
            assert!(has_origin || !needs_origin, "{} needs a line in the reference", node.path);
        }
    }

    const ALL: Presence = Presence { machine: true, interpolator: true, planner: true };

    fn reading(cell: &CellMessages, path: &str) -> NodeReading {
        NODES.iter().find(|node| node.path == path).expect("a node").read(cell)
    }

    fn value(cell: &CellMessages, path: &str) -> Variant {
        match reading(cell, path) {
            NodeReading::Value(value) => value,
            other => panic!("{path} is {other:?}"),
        }
    }

    fn state<'a>(cell: &CellMessages, path: &str, machine: &'a UaStateMachine) -> &'a str {
        match reading(cell, path) {
            NodeReading::State(state) => machine.states[state].name,
            other => panic!("{path} is {other:?}"),
        }
    }

    fn planned(state: u8, mode: u8) -> CellMessages {
        let mut accumulated = [2.5; 18];
        accumulated[0] = 42.5;
        let cell = CellState {
            state,
            mode,
            accumulated,
            job: "disc".into(),
            parts_wanted: 2,
            parts_done: 1,
            ..CellState::default()
        };
        CellMessages { presence: ALL, cell: Some(cell), ..CellMessages::default() }
    }

    #[test]
    fn every_state_of_the_cell_is_a_state_of_the_model() {
        // Number of PackML, state of the machine, state of the program.
        let states = [
            (1, "OutOfService", "Aborted"),
            (2, "NotExecuting", "Aborted"),
            (3, "NotExecuting", "Initializing"),
            (4, "NotExecuting", "Initializing"),
            (5, "NotExecuting", "Interrupted"),
            (6, "Executing", "Running"),
            (7, "NotExecuting", "Aborted"),
            (8, "OutOfService", "Aborted"),
            (9, "OutOfService", "Aborted"),
            (10, "NotExecuting", "Interrupted"),
            (11, "NotExecuting", "Interrupted"),
            (12, "Executing", "Running"),
            (13, "NotExecuting", "Interrupted"),
            (14, "Executing", "Running"),
            (15, "NotExecuting", "Initializing"),
            (16, "Executing", "Running"),
            (17, "NotExecuting", "Ended"),
        ];
        for (number, machine, program) in states {
            let cell = planned(number, 1);
            assert_eq!(state(&cell, "MachineryBuildingBlocks/MachineryItemState", &model::ITEM_STATES), machine);
            assert_eq!(state(&cell, "Production/ActiveProgram/State", &model::PROGRAM_STATES), program);
            assert_eq!(state(&cell, "Production/ProductionPlan/Job/State", &model::JOB_STATES), program);
        }
        // Mode, mode of the machine, operation mode, channel mode.
        let modes = [
            (1, "Processing", "Automatic", "Automatic"),
            (2, "Setup", "Setup", "Other"),
            (3, "Setup", "Manual", "JogManual"),
            (4, "Processing", "AutoWithManualIntervention", "Automatic"),
        ];
        for (number, mode, operation, channel) in modes {
            let cell = planned(4, number);
            assert_eq!(state(&cell, "MachineryBuildingBlocks/MachineryOperationMode", &model::MODES), mode);
            let number_of = |kind: &UaEnumeration, name: &str| {
                let at = kind.values.iter().position(|value| *value == name).expect("a value");
                Variant::from(i32::try_from(at).expect("a small number"))
            };
            let operation = number_of(&model::OPERATION_MODE, operation);
            assert_eq!(value(&cell, "Monitoring/MachineTool/OperationMode"), operation);
            assert_eq!(value(&cell, "Monitoring/Channel/ChannelMode"), number_of(&model::CHANNEL_MODE, channel));
        }
        let unknown = planned(18, 5);
        for path in ["MachineryBuildingBlocks/MachineryItemState", "Production/ActiveProgram/State"] {
            assert_eq!(reading(&unknown, path), NodeReading::Unavailable, "{path}");
        }
        for (number, channel) in (0..).zip([2, 0, 1, 1, 0, 0, 2]) {
            let interpolator = InterpolatorState { state: number, ..InterpolatorState::default() };
            let cell = CellMessages { presence: ALL, interpolator: Some(interpolator), ..CellMessages::default() };
            assert_eq!(value(&cell, "Monitoring/Channel/ChannelState"), channel.into(), "state {number}");
        }
    }

    #[test]
    fn values_have_their_data_types_and_units() {
        let mut cell = planned(6, 1);
        assert_eq!(value(&cell, "Production/ActiveProgram/Name"), "disc".into());
        assert_eq!(value(&cell, "Production/ProductionPlan/Job/RunsPlanned"), 2_u32.into());
        assert_eq!(value(&cell, "Production/ProductionPlan/Job/RunsPlanned/IsValid"), true.into());
        assert_eq!(value(&cell, "Production/ProductionPlan/Job/RunsCompleted"), 1_u32.into());
        let counters = "MachineryBuildingBlocks/OperationCounters";
        assert_eq!(value(&cell, &format!("{counters}/PowerOnDuration")), 42_500.0.into());
        assert_eq!(value(&cell, &format!("{counters}/OperationDuration")), 2500.0.into());
        let parts = |total, good| PartCounters { total, good, bad: total - good };
        let counted = MachineCounters { life: parts(1 << 40, 1), shift: parts(12, 10), ..MachineCounters::default() };
        cell.counters = Some(counted);
        assert_eq!(value(&cell, &format!("{counters}/PartsProducedInLifetime")), (1_u64 << 40).into());
        assert_eq!(value(&cell, "Production/ProductionPlan/Job/PartsGood"), 10_u32.into());
        cell.interpolator = Some(InterpolatorState { feed_override: 0.75, ..InterpolatorState::default() });
        assert_eq!(value(&cell, "Monitoring/Channel/FeedOverride"), 75.0.into());
        let interface = |names: &[&str], values: &[f64]| InterfaceValue {
            interface_names: names.iter().map(ToString::to_string).collect(),
            values: values.to_vec(),
        };
        let turn = core::f64::consts::TAU;
        let mut axes = DynamicJointState {
            joint_names: ["c_axis", "x_axis", WHEEL_JOINT].map(str::to_owned).into(),
            interface_values: vec![
                interface(&["position"], &[1.25 * turn]),
                interface(&["position", "velocity"], &[0.123_456_789, -0.0]),
                interface(&["velocity"], &[25.0 * turn]),
            ],
            ..DynamicJointState::default()
        };
        cell.axes = Some(axes.clone());
        assert_eq!(value(&cell, "Axes/C/Position"), 450.0.into());
        assert_eq!(value(&cell, "Axes/X/Position"), 123.456_79.into());
        assert_eq!(value(&cell, "Axes/X/Speed"), 0.0.into());
        assert_eq!(value(&cell, "Monitoring/Spindle/IsRotating"), true.into());
        axes.interface_values[2].values[0] = 0.0;
        cell.axes = Some(axes);
        assert_eq!(value(&cell, "Monitoring/Spindle/IsRotating"), false.into());
        // Without a speed of the wheel, the input `wheel_running` decides.
        cell.axes = None;
        assert_eq!(reading(&cell, "Monitoring/Spindle/IsRotating"), NodeReading::Unavailable);
        cell.io = Some(MachineIo { wheel_running: true, ..MachineIo::default() });
        assert_eq!(value(&cell, "Monitoring/Spindle/IsRotating"), true.into());
        let alarm = Alarm { number: 42, severity: Alarm::POWER_OFF, source: "x_axis".into(), ..Alarm::default() };
        cell.machine_alarms = Some(MachineAlarms { alarms: vec![alarm], ..MachineAlarms::default() });
        assert_eq!(value(&cell, "Notification/ActiveAlarms/Numbers"), vec![42_u16].into());
        assert_eq!(value(&cell, "Notification/ActiveAlarms/Severities"), vec![900_u16].into());
        assert_eq!(value(&cell, "Notification/ActiveAlarms/Sources"), vec!["x_axis".to_owned()].into());
    }

    #[test]
    fn equipment_that_the_machine_does_not_have_is_not_supported() {
        let mut cell = CellMessages { presence: ALL, ..CellMessages::default() };
        let paths = ["Cell/Door", "Monitoring/Spindle/Speed", "Equipment/Tools/Wheel/Name"];
        for path in paths {
            assert_eq!(reading(&cell, path), NodeReading::Unavailable, "{path}: nothing is known of the machine");
        }
        cell.description = Some(MachineDescription { wheel: "rough".into(), ..MachineDescription::default() });
        for path in paths {
            assert_eq!(reading(&cell, path), NodeReading::Unsupported, "{path}");
        }
        cell.equipment = Equipment { wheel: true, ..Equipment::default() };
        assert_eq!(value(&cell, "Equipment/Tools/Wheel/Name"), "rough".into());
        cell.presence = Presence::default();
        for node in NODES {
            let reading = node.read(&cell);
            assert!(matches!(reading, NodeReading::Unavailable | NodeReading::Constant), "{}: {reading:?}", node.path);
        }
    }
}
