// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Faults that can be put into the simulated machine, each by its name.

use crate::machine::description::{Axis, MachineDescription};
use crate::machine::setpoint::Input;
use crate::math::units::{TURN_RAD, rad_from_deg};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use thiserror::Error;

/// Failure of a gauge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GaugeFault {
    /// It gives its last reading for ever.
    #[default]
    Stuck,
    /// It gives no number.
    NotANumber,
}

crate::snapshot_cases!(GaugeFault { 0 Stuck, 1 NotANumber });

/// Failure of the loading equipment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadingFault {
    /// The door is forced open.
    DoorForced(bool),
    /// The door does not move any more, or does again.
    DoorStuck(bool),
    /// The chuck lets go.
    ChuckForced(bool),
    /// The chuck does not move any more, or does again.
    ChuckStuck(bool),
    /// The sensor of the part shows this level whatever there is; `None`: it is healthy again.
    PartSensor(Option<bool>),
    /// A person enters or leaves the work area.
    Person(bool),
}

impl Default for LoadingFault {
    /// None: the work area is free.
    fn default() -> Self {
        LoadingFault::Person(false)
    }
}

crate::snapshot_cases!(LoadingFault {
    0 DoorForced(on),
    1 DoorStuck(on),
    2 ChuckForced(on),
    3 ChuckStuck(on),
    4 PartSensor(level),
    5 Person(inside),
});

/// A fault that begins or ends at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// Emergency stop pressed or released.
    EStop(bool),
    /// The mains are lost or back.
    PowerLoss(bool),
    /// An input shows this level whatever happens; `None`: it is healthy again.
    StuckInput { input: Input, level: Option<bool> },
    /// The origin detector sees a second mark at this angle from its own (rad); `None`: it is healthy again.
    DoubleOrigin(Option<f64>),
    /// A station's switch bounces whenever it closes or opens, or no longer.
    BouncingSwitch {
        /// Index of the station.
        station: usize,
        active: bool,
    },
    /// Two inputs lie on one line: each shows the other's level and edges too; `None`: no longer.
    SharedInput(Option<[Input; 2]>),
    /// The encoder of an axis reads this much more than the axis has moved (mm or rad); 0: healthy.
    EncoderOffset { axis: Axis, offset: f64 },
    /// The gains of a drive are this fraction of their settings; 0: the axis stands as if blocked; 1: healthy.
    DriveGain { axis: Axis, factor: f64 },
    /// A drive reports a fault, or no longer.
    DriveFault { axis: Axis, active: bool },
    /// The next chunks of setpoints, so many, do not arrive. The machine's end of the stream loses them, see
    /// [`crate::simulation::buffer`]; the machine itself knows nothing of it.
    LostChunks(u32),
    /// The gauge fails, or works again.
    Gauge(Option<GaugeFault>),
    /// The wheel loses its speed, or may run again.
    WheelStall(bool),
    /// The wheel turns so many times as fast as it is ordered to; 1: healthy.
    WheelOverspeed(f64),
    /// Door, chuck, sensor or a person inside; nothing on a machine without.
    Loading(LoadingFault),
}

crate::snapshot_cases!(Fault {
    0 EStop(pressed),
    1 PowerLoss(lost),
    2 StuckInput { input, level },
    3 DoubleOrigin(counts),
    4 BouncingSwitch { station, active },
    5 SharedInput(inputs),
    6 EncoderOffset { axis, offset },
    7 DriveGain { axis, factor },
    8 DriveFault { axis, active },
    9 LostChunks(chunks),
    10 Gauge(fault),
    11 WheelStall(stalled),
    12 WheelOverspeed(factor),
    13 Loading(fault),
});

impl Default for Fault {
    /// None: an emergency stop that is not pressed.
    fn default() -> Self {
        Fault::EStop(false)
    }
}

/// Fault with its description for the operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaultEntry {
    pub name: &'static str,
    pub target: &'static str,
    /// Meaning of its value.
    pub value: &'static str,
}

const JOINT: &str = "c_axis, x_axis or z_axis";
const SWITCH: &str = "a station's switch";

/// The faults by name.
pub const FAULTS: [FaultEntry; 20] = [
    FaultEntry { name: "estop", target: "", value: "none" },
    FaultEntry { name: "power_loss", target: "", value: "none" },
    FaultEntry {
        name: "stuck_input",
        target: "origin, a station's switch, x_axis home or z_axis home",
        value: "level: 0 open, 1 closed",
    },
    FaultEntry { name: "double_origin", target: "", value: "angle of the second mark from the first (deg)" },
    FaultEntry { name: "bouncing_input", target: SWITCH, value: "none" },
    FaultEntry { name: "shared_input", target: "two inputs with + between them", value: "none" },
    FaultEntry { name: "encoder_offset", target: JOINT, value: "offset of the reading (m; c_axis: rad)" },
    FaultEntry { name: "drive_gain", target: JOINT, value: "fraction of the gains left, 0 (blocked) to 1" },
    FaultEntry { name: "drive_fault", target: JOINT, value: "none" },
    FaultEntry { name: "lost_chunks", target: "", value: "how many" },
    FaultEntry { name: "gauge_stuck", target: "", value: "none" },
    FaultEntry { name: "gauge_nan", target: "", value: "none" },
    FaultEntry { name: "wheel_stall", target: "", value: "none" },
    FaultEntry { name: "wheel_overspeed", target: "", value: "how many times as fast as ordered" },
    FaultEntry { name: "door_forced", target: "", value: "none" },
    FaultEntry { name: "door_stuck", target: "", value: "none" },
    FaultEntry { name: "chuck_forced", target: "", value: "none" },
    FaultEntry { name: "chuck_stuck", target: "", value: "none" },
    FaultEntry { name: "part_sensor", target: "", value: "level: 0 no part, 1 a part" },
    FaultEntry { name: "person", target: "", value: "none" },
];

/// Why a fault cannot be set.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FaultError {
    /// There is no such fault.
    #[error("there is no fault {name:?}; faults: {}", FAULTS.map(|fault| fault.name).join(", "))]
    UnknownName { name: String },
    /// The fault does not affect this target.
    #[error("{name}: target {target:?} is not {allowed}{switches}")]
    UnknownTarget {
        name: &'static str,
        target: String,
        allowed: &'static str,
        /// Switches of the machine's stations, for faults of inputs.
        switches: String,
    },
    /// The machine has nothing that could fail so.
    #[error("{name}: the machine has no {what}")]
    NothingThere { name: &'static str, what: &'static str },
    /// The value is outside what the fault allows.
    #[error("{name}: value {value} is outside {low} to {high}")]
    Value { name: &'static str, value: f64, low: f64, high: f64 },
}

/// Most chunks that one fault may lose.
const MAX_CHUNKS: f64 = 1.0e6;

impl Fault {
    /// A fault from its name, what it strikes, and its size (mm or rad, an angle between marks in degrees); `active: false`
    /// makes healthy again.
    ///
    /// # Errors
    /// Unknown name or target, value out of range.
    #[allow(clippy::cast_possible_truncation, reason = "checked against its range before")]
    pub fn from_name(
        name: &str,
        target: &str,
        value: f64,
        active: bool,
        machine: &MachineDescription,
    ) -> Result<Self, FaultError> {
        let entry = FAULTS
            .iter()
            .find(|entry| entry.name == name)
            .ok_or_else(|| FaultError::UnknownName { name: name.to_string() })?;
        let name = entry.name;
        let switches = || {
            let names: Vec<&str> = machine.stations.iter().map(|station| station.switch.as_str()).collect();
            if entry.target == JOINT { String::new() } else { format!(" ({})", names.join(", ")) }
        };
        let unknown = || FaultError::UnknownTarget {
            name,
            target: target.to_string(),
            allowed: entry.target,
            switches: switches(),
        };
        let axis = || Axis::from_joint(target).ok_or_else(unknown);
        let station =
            |target: &str| machine.stations.iter().position(|station| station.switch == target).ok_or_else(unknown);
        let input = |target: &str| match target {
            "origin" => Ok(Input::Origin),
            "x_axis home" => Ok(Input::Home(Axis::X)),
            "z_axis home" => Ok(Input::Home(Axis::Z)),
            _ => station(target).map(Input::Station),
        };
        let between = |low: f64, high: f64| match value >= low && value <= high {
            true => Ok(value),
            false => Err(FaultError::Value { name, value, low, high }),
        };
        Ok(match name {
            "estop" => Fault::EStop(active),
            "power_loss" => Fault::PowerLoss(active),
            "stuck_input" => {
                let level = if active { Some(between(0.0, 1.0)? > 0.5) } else { None };
                Fault::StuckInput { input: input(target)?, level }
            }
            "double_origin" => {
                Fault::DoubleOrigin(if active { Some(rad_from_deg(between(-360.0, 360.0)?)) } else { None })
            }
            "bouncing_input" => Fault::BouncingSwitch { station: station(target)?, active },
            "shared_input" => {
                let (one, other) = target.split_once('+').ok_or_else(unknown)?;
                let inputs = [input(one.trim())?, input(other.trim())?];
                if inputs[0] == inputs[1] {
                    return Err(unknown());
                }
                Fault::SharedInput(active.then_some(inputs))
            }
            "encoder_offset" => {
                let axis = axis()?;
                // Ten times the trip level is as good as any more.
                let max = 10.0 * machine.axis(axis).max_following_error;
                // People give metres for a slide.
                let si = if axis == Axis::C { 1.0 } else { 1e-3 };
                if active && !(-max..=max).contains(&value) {
                    return Err(FaultError::Value { name, value: si * value, low: -si * max, high: si * max });
                }
                Fault::EncoderOffset { axis, offset: if active { value } else { 0.0 } }
            }
            "drive_gain" => Fault::DriveGain { axis: axis()?, factor: if active { between(0.0, 1.0)? } else { 1.0 } },
            "drive_fault" => Fault::DriveFault { axis: axis()?, active },
            "lost_chunks" => Fault::LostChunks(if active { between(1.0, MAX_CHUNKS)? as u32 } else { 0 }),
            "gauge_stuck" | "gauge_nan" if machine.gauge.is_none() => {
                return Err(FaultError::NothingThere { name, what: "gauge" });
            }
            "gauge_stuck" => Fault::Gauge(active.then_some(GaugeFault::Stuck)),
            "gauge_nan" => Fault::Gauge(active.then_some(GaugeFault::NotANumber)),
            "wheel_stall" => Fault::WheelStall(active),
            "wheel_overspeed" => Fault::WheelOverspeed(if active { between(1.0, 3.0)? } else { 1.0 }),
            _ if machine.loading.is_none() => {
                return Err(FaultError::NothingThere { name, what: "door and no chuck (loading)" });
            }
            "door_forced" => Fault::Loading(LoadingFault::DoorForced(active)),
            "door_stuck" => Fault::Loading(LoadingFault::DoorStuck(active)),
            "chuck_forced" => Fault::Loading(LoadingFault::ChuckForced(active)),
            "chuck_stuck" => Fault::Loading(LoadingFault::ChuckStuck(active)),
            "person" => Fault::Loading(LoadingFault::Person(active)),
            _ => {
                let level = if active { Some(between(0.0, 1.0)? > 0.5) } else { None };
                Fault::Loading(LoadingFault::PartSensor(level))
            }
        })
    }
}

/// Tolerance around the mark within which the origin detector may signal (rad): the commutation of the headstock's motor
/// gives the angle of its rotor at any time, homed or not.
pub(super) const ORIGIN_TOLERANCE_RAD: f64 = TURN_RAD / 180.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::gauge::{GaugeDescription, GaugeKind};
    use crate::machine::loading::LoadingDescription;
    use crate::machine::reference::cam_grinder;

    const LOADING: LoadingDescription = LoadingDescription {
        door_opens_s: 0.01,
        door_closes_s: 0.01,
        chuck_opens_s: 0.01,
        chuck_closes_s: 0.01,
        safe_x_mm: 100.0,
    };
    const GAUGE: GaugeDescription = GaugeDescription {
        kind: GaugeKind::Diameter,
        behind_wheel_rad: 1.5,
        second_behind_wheel_rad: None,
        resolution_mm: 1e-4,
        noise_mm: 0.0,
        bandwidth_rad_s: None,
        seed: 1,
    };

    #[test]
    fn every_listed_fault_can_be_set_and_others_are_refused() {
        let plain = cam_grinder();
        let machine = MachineDescription { loading: Some(LOADING), gauge: Some(GAUGE), ..plain.clone() };
        for entry in FAULTS {
            let target = match entry.target {
                JOINT => "x_axis",
                "" => "",
                "two inputs with + between them" => "origin+LS3",
                _ => "LS2",
            };
            for active in [true, false] {
                let fault = Fault::from_name(entry.name, target, 1.0, active, &machine);
                assert!(fault.is_ok(), "{}: {fault:?}", entry.name);
            }
        }
        let refused = Fault::from_name("door_forced", "", 0.0, true, &plain);
        assert_eq!(refused, Err(FaultError::NothingThere { name: "door_forced", what: "door and no chuck (loading)" }));
        let refused = Fault::from_name("gauge_stuck", "", 0.0, true, &plain);
        assert_eq!(refused, Err(FaultError::NothingThere { name: "gauge_stuck", what: "gauge" }));
        assert_eq!(
            Fault::from_name("stuck_input", "LS2", 1.0, true, &machine),
            Ok(Fault::StuckInput { input: Input::Station(1), level: Some(true) })
        );
        assert!(matches!(Fault::from_name("gremlin", "", 0.0, true, &machine), Err(FaultError::UnknownName { .. })));
        for (name, target) in [("drive_gain", "LS2"), ("shared_input", "LS2"), ("shared_input", "LS2+LS2")] {
            let refused = Fault::from_name(name, target, 0.5, true, &machine);
            assert!(matches!(refused, Err(FaultError::UnknownTarget { .. })), "{name} {target}: {refused:?}");
        }
        for (name, target, value) in
            [("drive_gain", "x_axis", f64::NAN), ("lost_chunks", "", 0.0), ("wheel_overspeed", "", 0.5)]
        {
            let refused = Fault::from_name(name, target, value, true, &machine);
            assert!(matches!(refused, Err(FaultError::Value { .. })), "{name}: {refused:?}");
        }
    }
}
