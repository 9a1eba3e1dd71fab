//! The machine of a running cell, from the description that it publishes.

use super::mm_from_m;
use crate::{ConfigError, machine_file};
use camwright::machine::description::MachineDescription;
use camwright::machine::wheel_state::WheelNow;
use camwright_msgs::camwright_msgs::msg::MachineDescription as DescriptionMessage;
use std::path::Path;

/// The machine as it is now, as its description says.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineNow {
    pub description: MachineDescription,
    /// The wheel that is mounted.
    pub wheel: WheelNow,
}

/// Machine file of a description message, with `key=value` overrides; the caller checks the hash.
///
/// # Errors
/// It is no machine file.
pub fn described_machine(
    message: &DescriptionMessage,
    overrides: &[String],
) -> Result<MachineDescription, ConfigError> {
    machine_file::parse(Path::new("machine/description"), &message.source, overrides).map(|file| file.description)
}

/// Machine of a recorded description, with `key=value` overrides.
///
/// # Errors
/// Why it is not known, as the end of a sentence.
pub fn recorded_machine(message: &DescriptionMessage, overrides: &[String]) -> Result<MachineDescription, String> {
    let description = described_machine(message, overrides)
        .map_err(|error| format!("the machine's description is refused: {error}"))?;
    if overrides.is_empty() && description.hash != message.hash {
        let (hash, own) = (&message.hash, &description.hash);
        return Err(format!(
            "the machine's description does not have its hash: it says {hash:.12}, this version reads it as {own:.12}"
        ));
    }
    Ok(description)
}

/// Wheel of a machine's description.
pub fn wheel_now(message: &DescriptionMessage) -> WheelNow {
    WheelNow {
        radius_mm: mm_from_m(message.wheel_radius),
        wear_mm: mm_from_m(message.wheel_wear),
        lobes_since_dress: message.lobes_since_dress,
        parts_since_dress: message.parts_since_dress,
    }
}

impl MachineNow {
    /// The machine as it says that it is.
    ///
    /// # Errors
    /// Why it is not known, as the end of a sentence.
    pub fn from_message(message: &DescriptionMessage) -> Result<Self, String> {
        Ok(Self { description: recorded_machine(message, &[])?, wheel: wheel_now(message) })
    }
}
