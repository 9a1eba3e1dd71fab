//! Faults that can be put into the simulated machine, each by its name.

use crate::machine::description::{Axis, MachineDescription};
use crate::setpoint::Input;
use alloc::string::{String, ToString};
use thiserror::Error;

/// A fault that begins or ends at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// Emergency stop pressed or released.
    EStop(bool),
    /// An input shows this level whatever happens; `None`: it is healthy again.
    StuckInput {
        /// Which input.
        input: Input,
        /// Its level.
        level: Option<bool>,
    },
    /// The encoder of an axis reads this much more than the axis has moved (mm or rad); 0: healthy.
    EncoderOffset {
        /// Which axis.
        axis: Axis,
        /// By how much.
        offset: f64,
    },
    /// The gains of a drive are this fraction of their settings; 1: healthy.
    DriveGain {
        /// Which axis.
        axis: Axis,
        /// The fraction.
        factor: f64,
    },
    /// A drive reports a fault, or no longer.
    DriveFault {
        /// Which axis.
        axis: Axis,
        /// Reported or not.
        active: bool,
    },
    /// The wheel loses its speed, or may run again.
    WheelStall(bool),
}

/// What a fault may strike, for people.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaultEntry {
    /// Name.
    pub name: &'static str,
    /// What it strikes.
    pub target: &'static str,
    /// What its value means.
    pub value: &'static str,
}

/// The faults by name.
pub const FAULTS: [FaultEntry; 6] = [
    FaultEntry { name: "estop", target: "", value: "none" },
    FaultEntry { name: "stuck_input", target: "origin or a station's switch", value: "level: 0 open, 1 closed" },
    FaultEntry { name: "encoder_offset", target: "a joint", value: "offset of the reading (mm or rad)" },
    FaultEntry { name: "drive_gain", target: "a joint", value: "fraction of the gains left, 0 to 1" },
    FaultEntry { name: "drive_fault", target: "a joint", value: "none" },
    FaultEntry { name: "wheel_stall", target: "", value: "none" },
];

/// Why a fault cannot be set.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FaultError {
    /// There is no such fault.
    #[error("there is no fault {name:?}")]
    UnknownName {
        /// The name given.
        name: String,
    },
    /// It cannot strike this.
    #[error("{name} cannot strike {target:?}")]
    UnknownTarget {
        /// The fault.
        name: &'static str,
        /// The target given.
        target: String,
    },
    /// The value is outside what the fault allows.
    #[error("{name}: value {value} is outside {low} to {high}")]
    Value {
        /// The fault.
        name: &'static str,
        /// The value given.
        value: f64,
        /// Smallest allowed.
        low: f64,
        /// Largest allowed.
        high: f64,
    },
}

impl Fault {
    /// A fault from its name, what it strikes, and its size (mm or rad); `active: false` makes healthy again.
    ///
    /// # Errors
    /// Unknown name or target, value out of range.
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
        let unknown = || FaultError::UnknownTarget { name, target: target.to_string() };
        let axis = || Axis::from_joint(target).ok_or_else(unknown);
        let between = |low: f64, high: f64| match value >= low && value <= high {
            true => Ok(value),
            false => Err(FaultError::Value { name, value, low, high }),
        };
        Ok(match name {
            "estop" => Fault::EStop(active),
            "stuck_input" => {
                let input = match target {
                    "origin" => Input::Origin,
                    _ => {
                        let station = machine.stations.iter().position(|station| station.switch == target);
                        Input::Station(station.ok_or_else(unknown)?)
                    }
                };
                let level = if active { Some(between(0.0, 1.0)? > 0.5) } else { None };
                Fault::StuckInput { input, level }
            }
            "encoder_offset" => {
                let axis = axis()?;
                // Ten times the trip level is as good as any more.
                let most = 10.0 * machine.axis(axis).max_following_error;
                Fault::EncoderOffset { axis, offset: if active { between(-most, most)? } else { 0.0 } }
            }
            "drive_gain" => Fault::DriveGain { axis: axis()?, factor: if active { between(0.0, 1.0)? } else { 1.0 } },
            "drive_fault" => Fault::DriveFault { axis: axis()?, active },
            "wheel_stall" => Fault::WheelStall(active),
            _ => return Err(FaultError::UnknownName { name: name.to_string() }),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::reference::cam_grinder;

    #[test]
    fn every_listed_fault_can_be_set_and_others_are_refused() {
        let machine = cam_grinder();
        for entry in FAULTS {
            let target = match entry.target {
                "a joint" => "x_axis",
                "" => "",
                _ => "LS2",
            };
            assert!(Fault::from_name(entry.name, target, 0.5, true, &machine).is_ok(), "{}", entry.name);
        }
        assert_eq!(
            Fault::from_name("stuck_input", "LS2", 1.0, true, &machine),
            Ok(Fault::StuckInput { input: Input::Station(1), level: Some(true) })
        );
        assert!(matches!(Fault::from_name("gremlin", "", 0.0, true, &machine), Err(FaultError::UnknownName { .. })));
        assert!(matches!(
            Fault::from_name("drive_gain", "LS2", 0.5, true, &machine),
            Err(FaultError::UnknownTarget { .. })
        ));
        assert!(matches!(
            Fault::from_name("drive_gain", "x_axis", f64::NAN, true, &machine),
            Err(FaultError::Value { .. })
        ));
    }
}
