// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Data items of the MTConnect device model, and their values from the messages of the cell.
//!
//! Names of types, sub-types, categories and units are those of the MTConnect model; a test compares them with a table of names that were
//! looked up.

use crate::cell_messages::{CellMessages, Equipment};
use camwright::math::units::{deg_from_rad, rpm_from_rad_s};
use camwright_files::convert::machine_description::WHEEL_JOINT;
use camwright_files::convert::mm_from_m;
use camwright_msgs::camwright_msgs::msg::{Alarm, CellState, WorkArea};
use std::collections::BTreeMap;

/// Category of a data item.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Category {
    Sample,
    Event,
    Condition,
}

impl Category {
    #[must_use]
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Sample => "SAMPLE",
            Self::Event => "EVENT",
            Self::Condition => "CONDITION",
        }
    }
}

/// Component of the device that has the data item.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Component {
    Device,
    Controller,
    Path,
    CAxis,
    XAxis,
    ZAxis,
    Wheel,
    Chuck,
    Door,
}

impl Component {
    /// Name of the XML element.
    #[must_use]
    pub(super) const fn element(self) -> &'static str {
        match self {
            Self::Device => "Device",
            Self::Controller => "Controller",
            Self::Path => "Path",
            Self::CAxis | Self::Wheel => "Rotary",
            Self::XAxis | Self::ZAxis => "Linear",
            Self::Chuck => "Chuck",
            Self::Door => "Door",
        }
    }

    /// Id without the prefix of the cell.
    #[must_use]
    pub(super) const fn id(self) -> &'static str {
        match self {
            Self::Device => "device",
            Self::Controller => "controller",
            Self::Path => "path",
            Self::CAxis => "c",
            Self::XAxis => "x",
            Self::ZAxis => "z",
            Self::Wheel => "s",
            Self::Chuck => "chuck",
            Self::Door => "door",
        }
    }

    /// Value of the attribute `name`; the device has that of the machine.
    #[must_use]
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::CAxis => "C",
            Self::XAxis => "X",
            Self::ZAxis => "Z",
            Self::Wheel => "S",
            other => other.id(),
        }
    }
}

/// An alarm as an active condition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct ActiveAlarm {
    pub(super) severity: u8,
    pub(super) text: String,
}

/// Present value of a data item.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Reading {
    Unavailable,
    Value(String),
    /// Active alarms of a condition by number; empty: normal.
    Alarms(BTreeMap<u16, ActiveAlarm>),
}

/// Value of a data item before it is text.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum ItemValue {
    Text(String),
    Count(u64),
    /// A finite number, and the decimals that are published.
    Real(f64, usize),
}

/// Source of the value of a data item.
#[derive(Clone, Copy)]
enum Source {
    Text(fn(&CellMessages) -> Option<String>),
    /// A number, and the decimals that are published.
    Real(fn(&CellMessages) -> Option<f64>, usize),
    /// Accumulated time (s).
    Timer(fn(&CellState) -> f64),
    /// Number of parts.
    Count(fn(&CellMessages) -> Option<u64>),
    /// Alarms that this component raised.
    Alarms(fn(&Alarm) -> bool),
}

/// A data item.
#[derive(Clone, Copy)]
pub(super) struct Item {
    /// Id without the prefix of the cell.
    pub(super) id: &'static str,
    pub(super) component: Component,
    pub(super) category: Category,
    /// Attribute `type`.
    pub(super) kind: &'static str,
    pub(super) sub_type: Option<&'static str>,
    pub(super) units: Option<&'static str>,
    /// Topic and field, for the reference.
    pub(super) topic: &'static str,
    /// Rule for the value, for the reference.
    pub(super) rule: &'static str,
    /// The machine has the item.
    pub(super) applies: fn(Equipment) -> bool,
    source: Source,
}

impl Item {
    /// Value of the item; `None` if the machine does not have it.
    #[must_use]
    pub(super) fn read(&self, cell: &CellMessages) -> Option<Reading> {
        if !(self.applies)(cell.equipment) {
            return None;
        }
        if let Source::Alarms(is_own) = self.source {
            let alarms = cell.alarms().map(|alarms| active(alarms.filter(|alarm| is_own(alarm))));
            return Some(alarms.map_or(Reading::Unavailable, Reading::Alarms));
        }
        let value = self.value(cell).map(|value| match value {
            ItemValue::Text(text) => text,
            ItemValue::Count(count) => count.to_string(),
            ItemValue::Real(value, decimals) => number(value, decimals),
        });
        Some(value.map_or(Reading::Unavailable, Reading::Value))
    }

    /// Typed value of the item; `None` if it is unavailable or a condition.
    #[must_use]
    pub(super) fn value(&self, cell: &CellMessages) -> Option<ItemValue> {
        let real = |value: f64, decimals| value.is_finite().then_some(ItemValue::Real(value, decimals));
        match self.source {
            Source::Text(text) => text(cell).map(ItemValue::Text),
            Source::Real(value, decimals) => value(cell).and_then(|value| real(value, decimals)),
            Source::Timer(seconds) => cell.cell().and_then(|cell| real(seconds(cell), 1)),
            Source::Count(count) => count(cell).map(ItemValue::Count),
            Source::Alarms(_) => None,
        }
    }

    const fn with_units(self, units: &'static str) -> Self {
        Self { units: Some(units), ..self }
    }

    const fn for_machines(self, applies: fn(Equipment) -> bool) -> Self {
        Self { applies, ..self }
    }

    const fn with_source(self, topic: &'static str, rule: &'static str) -> Self {
        Self { topic, rule, ..self }
    }
}

/// Present values of all items, in the order of [`ITEMS`].
#[must_use]
pub(super) fn read_all(cell: &CellMessages) -> Vec<Option<Reading>> {
    ITEMS.iter().map(|item| item.read(cell)).collect()
}

/// Maximum number of active alarms of a condition; there are fewer kinds.
const MAX_ALARMS: usize = 200;

/// Alarms by number; of two with one number the more severe.
fn active<'a>(alarms: impl Iterator<Item = &'a Alarm>) -> BTreeMap<u16, ActiveAlarm> {
    let mut active = BTreeMap::<u16, ActiveAlarm>::new();
    for alarm in alarms.take(MAX_ALARMS) {
        let new = ActiveAlarm { severity: alarm.severity, text: alarm.text.clone() };
        active
            .entry(alarm.number)
            .and_modify(|known| {
                if known.severity < new.severity {
                    known.clone_from(&new);
                }
            })
            .or_insert(new);
    }
    active
}

/// A sample with at most so many decimals.
const fn sample(
    id: &'static str,
    component: Component,
    (kind, sub_type): (&'static str, Option<&'static str>),
    (decimals, value): (usize, fn(&CellMessages) -> Option<f64>),
) -> Item {
    let source = Source::Real(value, decimals);
    let category = Category::Sample;
    Item { id, component, category, kind, sub_type, units: None, topic: "", rule: "", applies: always, source }
}

const fn event(
    id: &'static str,
    component: Component,
    (kind, sub_type): (&'static str, Option<&'static str>),
    text: fn(&CellMessages) -> Option<String>,
) -> Item {
    let source = Source::Text(text);
    Item { category: Category::Event, source, ..sample(id, component, (kind, sub_type), (0, |_| None)) }
}

const fn condition(id: &'static str, component: Component, is_own: fn(&Alarm) -> bool) -> Item {
    let source = Source::Alarms(is_own);
    Item { category: Category::Condition, source, ..sample(id, component, ("SYSTEM", None), (0, |_| None)) }
}

const ACTUAL: Option<&str> = Some("ACTUAL");
const AXES: &str = "`dynamic_joint_states`";
const CELL: &str = "`job_planner/cell_state`";

/// All data items, in the order of the device model.
pub(super) const ITEMS: &[Item] = &[
    event("availability", Component::Device, ("AVAILABILITY", None), availability)
        .with_source("`machine/stream`", "AVAILABLE while messages arrive, else UNAVAILABLE"),
    timer("equipment_timer_powered", "POWERED", |cell| cell.accumulated[0])
        .with_source("`job_planner/cell_state` `accumulated`", "index 0"),
    timer("equipment_timer_operating", "OPERATING", operating_s).with_source(
        "`job_planner/cell_state` `accumulated`",
        "index 0 without STOPPED (2) and ABORTED (9): work and idle time",
    ),
    timer("equipment_timer_working", "WORKING", |cell| cell.accumulated[usize::from(CellState::EXECUTE)])
        .with_source("`job_planner/cell_state` `accumulated`", "index 6 (EXECUTE)"),
    condition("system", Component::Controller, |alarm| axis_of(alarm).is_none())
        .with_source("`machine/alarms`, `axis_interpolator/alarms`", "alarms without an axis, see below"),
    event("emergency_stop", Component::Controller, ("EMERGENCY_STOP", None), |cell| {
        cell.io().map(|io| choice(io.estop, "TRIGGERED", "ARMED"))
    })
    .with_source("`machine/io` `estop`", "TRIGGERED if true, else ARMED"),
    event("controller_mode", Component::Path, ("CONTROLLER_MODE", None), |cell| {
        cell.cell().and_then(|cell| controller_mode(cell.mode)).map(str::to_owned)
    })
    .with_source("`job_planner/cell_state` `mode`", "AUTOMATIC for 1, SEMI_AUTOMATIC for 4, MANUAL for 2 and 3"),
    event("execution", Component::Path, ("EXECUTION", None), |cell| {
        cell.cell().and_then(|cell| execution(cell.state)).map(str::to_owned)
    })
    .with_source("`job_planner/cell_state` `state`", "see below"),
    event("program", Component::Path, ("PROGRAM", None), |cell| {
        cell.cell().map(|cell| cell.job.clone()).filter(|job| !job.is_empty())
    })
    .with_source("`job_planner/cell_state` `job`", "name of the job; UNAVAILABLE before the first one"),
    Item {
        source: Source::Real(|cell| cell.interpolator().map(|state| 100.0 * state.feed_override), 1),
        ..event("path_feedrate_override", Component::Path, ("PATH_FEEDRATE_OVERRIDE", Some("PROGRAMMED")), |_| None)
    }
    .with_source("`axis_interpolator/state` `feed_override`", "per cent"),
    part_count("part_count_all", "ALL", |cell| cell.counters().map(|counters| counters.shift.total))
        .with_source("`machine/counters` `shift`", "`total`"),
    part_count("part_count_good", "GOOD", |cell| cell.counters().map(|counters| counters.shift.good))
        .with_source("`machine/counters` `shift`", "`good`"),
    part_count("part_count_bad", "BAD", |cell| cell.counters().map(|counters| counters.shift.bad))
        .with_source("`machine/counters` `shift`", "`bad`"),
    part_count("part_count_target", "TARGET", |cell| wanted(cell).map(|(wanted, _)| u64::from(wanted)))
        .with_source(CELL, "`parts_wanted`; UNAVAILABLE if it is 0"),
    part_count("part_count_remaining", "REMAINING", |cell| {
        wanted(cell).map(|(wanted, done)| u64::from(wanted.saturating_sub(done)))
    })
    .with_source(CELL, "`parts_wanted` − `parts_done`; UNAVAILABLE if `parts_wanted` is 0"),
    count("tool_number", ("TOOL_NUMBER", None), tool_number).with_source(
        "`machine/description` `wheels`",
        "position of the mounted wheel in the changer from 1; 1 without a changer",
    ),
    event("part_detect", Component::Path, ("PART_DETECT", None), |cell| {
        cell.io().map(|io| choice(io.part_present, "PRESENT", "NOT_PRESENT"))
    })
    .with_source("`machine/io` `part_present`", "PRESENT if true, else NOT_PRESENT"),
    sample(
        "c_angle",
        Component::CAxis,
        ("ANGLE", ACTUAL),
        (5, |cell| cell.joint("c_axis", "position").map(deg_from_rad)),
    )
    .with_units("DEGREE")
    .with_source(AXES, "`position` of `c_axis`; counts on over 360°"),
    sample("c_velocity", Component::CAxis, ("ROTARY_VELOCITY", ACTUAL), (3, |cell| speed_rpm(cell, "c_axis")))
        .with_units("REVOLUTION/MINUTE")
        .with_source(AXES, "`velocity` of `c_axis`"),
    sample("c_torque", Component::CAxis, ("TORQUE", None), (3, |cell| cell.joint("c_axis", "effort")))
        .with_units("NEWTON_METER")
        .with_source(AXES, "`effort` of `c_axis`"),
    event("c_rotary_mode", Component::CAxis, ("ROTARY_MODE", None), |cell| {
        cell.description().map(|_| "CONTOUR".to_owned())
    })
    .with_source("`machine/description`", "CONTOUR: C moves with the path"),
    condition("c_system", Component::CAxis, |alarm| axis_of(alarm) == Some("c_axis"))
        .with_source("`machine/alarms`, `axis_interpolator/alarms`", "alarms whose `source` is `c_axis`"),
    sample("x_position", Component::XAxis, ("POSITION", ACTUAL), (5, |cell| position_mm(cell, "x_axis")))
        .with_units("MILLIMETER")
        .with_source(AXES, "`position` of `x_axis`"),
    sample("x_feedrate", Component::XAxis, ("AXIS_FEEDRATE", ACTUAL), (3, |cell| speed_mm_s(cell, "x_axis")))
        .with_units("MILLIMETER/SECOND")
        .with_source(AXES, "`velocity` of `x_axis`"),
    sample("x_force", Component::XAxis, ("LINEAR_FORCE", None), (1, |cell| cell.joint("x_axis", "effort")))
        .with_units("NEWTON")
        .with_source(AXES, "`effort` of `x_axis`"),
    condition("x_system", Component::XAxis, |alarm| axis_of(alarm) == Some("x_axis"))
        .with_source("`machine/alarms`, `axis_interpolator/alarms`", "alarms whose `source` is `x_axis`"),
    sample("z_position", Component::ZAxis, ("POSITION", ACTUAL), (5, |cell| position_mm(cell, "z_axis")))
        .with_units("MILLIMETER")
        .with_source(AXES, "`position` of `z_axis`"),
    sample("z_feedrate", Component::ZAxis, ("AXIS_FEEDRATE", ACTUAL), (3, |cell| speed_mm_s(cell, "z_axis")))
        .with_units("MILLIMETER/SECOND")
        .with_source(AXES, "`velocity` of `z_axis`"),
    sample("z_force", Component::ZAxis, ("LINEAR_FORCE", None), (1, |cell| cell.joint("z_axis", "effort")))
        .with_units("NEWTON")
        .with_source(AXES, "`effort` of `z_axis`"),
    condition("z_system", Component::ZAxis, |alarm| axis_of(alarm) == Some("z_axis"))
        .with_source("`machine/alarms`, `axis_interpolator/alarms`", "alarms whose `source` is `z_axis`"),
    event("s_rotary_mode", Component::Wheel, ("ROTARY_MODE", None), |cell| {
        cell.description().map(|_| "SPINDLE".to_owned())
    })
    .for_machines(|equipment| equipment.wheel)
    .with_source("`machine/description`", "SPINDLE"),
    sample("s_velocity", Component::Wheel, ("ROTARY_VELOCITY", ACTUAL), (3, |cell| speed_rpm(cell, WHEEL_JOINT)))
        .with_units("REVOLUTION/MINUTE")
        .for_machines(|equipment| equipment.wheel_speed)
        .with_source(AXES, "`velocity` of `wheel_spindle`"),
    sample("s_power", Component::Wheel, ("WATTAGE", ACTUAL), (1, |cell| cell.joint(WHEEL_JOINT, "power")))
        .with_units("WATT")
        .for_machines(|equipment| equipment.wheel_power)
        .with_source(AXES, "`power` of `wheel_spindle`: power of the cut"),
    sample(
        "s_diameter",
        Component::Wheel,
        ("DIAMETER", None),
        (5, |cell| cell.description().map(|machine| mm_from_m(2.0 * (machine.wheel_radius - machine.wheel_wear)))),
    )
    .with_units("MILLIMETER")
    .for_machines(|equipment| equipment.wheel)
    .with_source("`machine/description`", "2 · (`wheel_radius` − `wheel_wear`)"),
    event("chuck_state", Component::Chuck, ("CHUCK_STATE", None), |cell| {
        cell.area().map(|area| opening(area.chuck).to_owned())
    })
    .for_machines(|equipment| equipment.loading)
    .with_source("`machine/work_area` `chuck`", "CLOSED for 0, OPEN for 2, else UNLATCHED"),
    event("door_state", Component::Door, ("DOOR_STATE", None), |cell| {
        cell.area().map(|area| opening(area.door).to_owned())
    })
    .for_machines(|equipment| equipment.loading)
    .with_source("`machine/work_area` `door`", "CLOSED for 0, OPEN for 2, else UNLATCHED"),
];

const fn timer(id: &'static str, sub_type: &'static str, seconds: fn(&CellState) -> f64) -> Item {
    let item = sample(id, Component::Device, ("EQUIPMENT_TIMER", Some(sub_type)), (1, |_| None));
    Item { source: Source::Timer(seconds), ..item }.with_units("SECOND")
}

const fn part_count(id: &'static str, sub_type: &'static str, parts: fn(&CellMessages) -> Option<u64>) -> Item {
    count(id, ("PART_COUNT", Some(sub_type)), parts)
}

const fn count(
    id: &'static str,
    kind: (&'static str, Option<&'static str>),
    count: fn(&CellMessages) -> Option<u64>,
) -> Item {
    Item { source: Source::Count(count), ..event(id, Component::Path, kind, |_| None) }
}

fn always(_: Equipment) -> bool {
    true
}

fn choice(is_first: bool, first: &str, second: &str) -> String {
    if is_first { first } else { second }.to_owned()
}

/// A finite number with at most so many decimals.
fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = if decimals == 0 { &text } else { text.trim_end_matches('0').trim_end_matches('.') };
    if text == "-0" { "0" } else { text }.to_owned()
}

fn availability(cell: &CellMessages) -> Option<String> {
    cell.presence.machine.then(|| "AVAILABLE".to_owned())
}

/// Axis that raised an alarm; `None`: a node.
fn axis_of(alarm: &Alarm) -> Option<&'static str> {
    ["c_axis", "x_axis", "z_axis"].into_iter().find(|axis| *axis == alarm.source)
}

/// Value of EXECUTION for a state of the cell.
fn execution(state: u8) -> Option<&'static str> {
    Some(match state {
        CellState::IDLE | CellState::STARTING | CellState::RESETTING => "READY",
        CellState::EXECUTE | CellState::UNHOLDING | CellState::UNSUSPENDING | CellState::COMPLETING => "ACTIVE",
        CellState::HOLDING | CellState::HELD => "FEED_HOLD",
        CellState::SUSPENDING | CellState::SUSPENDED => "WAIT",
        CellState::COMPLETE => "PROGRAM_COMPLETED",
        CellState::STOPPED | CellState::STOPPING | CellState::ABORTING | CellState::ABORTED | CellState::CLEARING => {
            "STOPPED"
        }
        _ => return None,
    })
}

/// Value of `CONTROLLER_MODE` for a mode of the cell.
fn controller_mode(mode: u8) -> Option<&'static str> {
    Some(match mode {
        CellState::AUTOMATIC => "AUTOMATIC",
        CellState::SEMI_AUTOMATIC => "SEMI_AUTOMATIC",
        CellState::SETUP | CellState::MANUAL => "MANUAL",
        _ => return None,
    })
}

/// Value for a state of a door or chuck.
fn opening(state: u8) -> &'static str {
    match state {
        WorkArea::CLOSED => "CLOSED",
        WorkArea::OPEN => "OPEN",
        _ => "UNLATCHED",
    }
}

/// Parts of the run: wanted, done; `None` if their number is not limited.
fn wanted(cell: &CellMessages) -> Option<(u32, u32)> {
    cell.cell().map(|cell| (cell.parts_wanted, cell.parts_done)).filter(|(wanted, _)| *wanted > 0)
}

fn operating_s(cell: &CellState) -> f64 {
    let idle = [CellState::STOPPED, CellState::ABORTED].map(|state| cell.accumulated[usize::from(state)]);
    cell.accumulated[0] - idle.iter().sum::<f64>()
}

fn tool_number(cell: &CellMessages) -> Option<u64> {
    let wheels = &cell.description()?.wheels;
    let position = match wheels.iter().position(|wheel| wheel.mounted) {
        Some(position) => position,
        None if wheels.is_empty() => 0,
        None => return None,
    };
    u64::try_from(position + 1).ok()
}

fn position_mm(cell: &CellMessages, joint: &str) -> Option<f64> {
    cell.joint(joint, "position").map(mm_from_m)
}

fn speed_mm_s(cell: &CellMessages, joint: &str) -> Option<f64> {
    cell.joint(joint, "velocity").map(mm_from_m)
}

fn speed_rpm(cell: &CellMessages, joint: &str) -> Option<f64> {
    cell.joint(joint, "velocity").map(rpm_from_rad_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell_messages::Presence;
    use camwright_msgs::camwright_msgs::msg::{
        InterpolatorState, MachineCounters, MachineDescription, MachineIo, PartCounters, WheelState,
    };
    use camwright_msgs::control_msgs::msg::{DynamicJointState, InterfaceValue};

    const ALL: Presence = Presence { machine: true, interpolator: true, planner: true };

    /// Value of an item; `None`: unavailable.
    fn value(cell: &CellMessages, id: &str) -> Option<String> {
        let item = ITEMS.iter().find(|item| item.id == id).expect("an item");
        match item.read(cell).expect("the machine has it") {
            Reading::Value(value) => Some(value),
            Reading::Unavailable => None,
            Reading::Alarms(_) => panic!("{id} is a condition"),
        }
    }

    fn with_state(state: u8, mode: u8) -> CellMessages {
        let mut accumulated = [1.0; 18];
        accumulated[0] = 17.0;
        let cell = CellState { state, mode, accumulated, parts_wanted: 10, parts_done: 3, ..CellState::default() };
        CellMessages { presence: ALL, cell: Some(cell), ..CellMessages::default() }
    }

    #[test]
    fn every_state_and_mode_of_the_cell_has_its_word() {
        let states = [
            "STOPPED",
            "STOPPED",
            "READY",
            "READY",
            "WAIT",
            "ACTIVE",
            "STOPPED",
            "STOPPED",
            "STOPPED",
            "FEED_HOLD",
            "FEED_HOLD",
            "ACTIVE",
            "WAIT",
            "ACTIVE",
            "READY",
            "ACTIVE",
            "PROGRAM_COMPLETED",
        ];
        for (state, word) in (1..).zip(states) {
            assert_eq!(value(&with_state(state, 1), "execution").as_deref(), Some(word), "state {state}");
        }
        for (mode, word) in (1..).zip(["AUTOMATIC", "MANUAL", "MANUAL", "SEMI_AUTOMATIC"]) {
            assert_eq!(value(&with_state(4, mode), "controller_mode").as_deref(), Some(word), "mode {mode}");
        }
        let unknown = with_state(18, 5);
        assert_eq!((value(&unknown, "execution"), value(&unknown, "controller_mode")), (None, None));
        let cell = with_state(6, 1);
        let timer = |id: &str| value(&cell, &format!("equipment_timer_{id}"));
        let timers = ["powered", "operating", "working"].map(|id| timer(id).expect("a time"));
        assert_eq!(timers, ["17", "15", "1"], "all; without STOPPED and ABORTED; EXECUTE");
        assert_eq!(value(&cell, "part_count_target").as_deref(), Some("10"));
        assert_eq!(value(&cell, "part_count_remaining").as_deref(), Some("7"));
        assert_eq!(value(&cell, "program"), None, "no job yet");
    }

    #[test]
    fn axes_and_wheel_are_in_the_units_of_the_model() {
        let turn = core::f64::consts::TAU;
        let interface = |names: &[&str], values: &[f64]| InterfaceValue {
            interface_names: names.iter().map(ToString::to_string).collect(),
            values: values.to_vec(),
        };
        let axis = |position: f64, velocity: f64| {
            let names = ["position", "velocity", "effort", "following_error"];
            interface(&names, &[position, velocity, -12.345_67, 0.0])
        };
        let axes = DynamicJointState {
            joint_names: ["c_axis", "x_axis", "z_axis", "wheel_spindle"].map(str::to_owned).into(),
            interface_values: vec![
                axis(1.25 * turn, turn),
                axis(0.123_456_789, -0.001),
                axis(-0.0, f64::NAN),
                interface(&["velocity", "normal_force", "power"], &[25.0 * turn, 1.0, 987.654]),
            ],
            ..DynamicJointState::default()
        };
        let equipment = Equipment { wheel: true, wheel_speed: true, wheel_power: true, loading: true };
        let mut cell = CellMessages { presence: ALL, equipment, axes: Some(axes), ..CellMessages::default() };
        for (id, expected) in [
            ("c_angle", "450"),
            ("c_velocity", "60"),
            ("c_torque", "-12.346"),
            ("x_position", "123.45679"),
            ("x_feedrate", "-1"),
            ("x_force", "-12.3"),
            ("z_position", "0"),
            ("s_velocity", "1500"),
            ("s_power", "987.7"),
        ] {
            assert_eq!(value(&cell, id).as_deref(), Some(expected), "{id}");
        }
        assert_eq!(value(&cell, "z_feedrate"), None, "not a number");
        let mounted = |mounted| WheelState { mounted, ..WheelState::default() };
        let described =
            |wheels| Some(MachineDescription { wheels, wheel_radius: 0.3, ..MachineDescription::default() });
        cell.description = described(Vec::new());
        assert_eq!(value(&cell, "tool_number").as_deref(), Some("1"), "the only wheel");
        cell.description = described(vec![mounted(false), mounted(true)]);
        assert_eq!(value(&cell, "tool_number").as_deref(), Some("2"));
        cell.description = described(vec![mounted(false), mounted(false)]);
        assert_eq!(value(&cell, "tool_number"), None, "a wheel is being changed");
        assert_eq!(value(&cell, "s_diameter").as_deref(), Some("600"));
        assert_eq!(
            ["c_rotary_mode", "s_rotary_mode"].map(|id| value(&cell, id).expect("known")),
            ["CONTOUR", "SPINDLE"]
        );
        cell.presence.machine = false;
        for id in ["c_angle", "s_velocity", "tool_number", "availability"] {
            assert_eq!(value(&cell, id), None, "{id} without a machine");
        }
    }

    #[test]
    fn inputs_counters_and_override_are_mapped() {
        let shift = PartCounters { total: 12, good: 10, bad: 1 };
        let cell = CellMessages {
            presence: ALL,
            equipment: Equipment { loading: true, ..Equipment::default() },
            io: Some(MachineIo { estop: true, part_present: true, ..MachineIo::default() }),
            counters: Some(MachineCounters { shift, ..MachineCounters::default() }),
            area: Some(WorkArea { door: WorkArea::CLOSING, chuck: WorkArea::CLOSED, ..WorkArea::default() }),
            interpolator: Some(InterpolatorState { feed_override: 0.555, ..InterpolatorState::default() }),
            ..CellMessages::default()
        };
        for (id, expected) in [
            ("availability", "AVAILABLE"),
            ("emergency_stop", "TRIGGERED"),
            ("part_detect", "PRESENT"),
            ("part_count_all", "12"),
            ("part_count_good", "10"),
            ("part_count_bad", "1"),
            ("door_state", "UNLATCHED"),
            ("chuck_state", "CLOSED"),
            ("path_feedrate_override", "55.5"),
        ] {
            assert_eq!(value(&cell, id).as_deref(), Some(expected), "{id}");
        }
        for id in ["execution", "part_count_target"] {
            assert_eq!(value(&cell, id), None, "{id} without a planner");
        }
        assert_eq!(opening(WorkArea::OPEN), "OPEN");
        assert_eq!([1.0, 0.25, -0.0001, 1e15].map(|v| number(v, 2)), ["1", "0.25", "0", "1000000000000000"]);
        assert_eq!(number(120.0, 0), "120");
    }
}
