// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The machine of a running cell, from the description that it publishes.

use super::mm_from_m;
use crate::{ConfigError, FileLocation, machine_file};
use camwright::machine::description::{MAX_WHEELS, MachineDescription, WheelChanger, WheelsNow};
use camwright::machine::wheel_state::WheelNow;
use camwright_msgs::camwright_msgs::msg::{MachineDescription as DescriptionMessage, WheelState};
use std::path::Path;

/// The machine as it is now, as its description says.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineNow {
    pub description: MachineDescription,
    /// Its wheels.
    pub wheels: WheelsNow,
}

/// Source of a description in errors.
const TOPIC: &str = "machine/description";

/// Machine file of a description message, with `key=value` overrides and the wheel that is mounted; the caller checks the hash.
///
/// # Errors
/// It is no machine file, or the mounted wheel is none of its changer.
pub fn described_machine(
    message: &DescriptionMessage,
    overrides: &[String],
) -> Result<MachineDescription, ConfigError> {
    let mut machine = machine_file::parse(Path::new(TOPIC), &message.source, overrides)?.description;
    let refuse = |error: String| ConfigError::at(FileLocation::file(Path::new(TOPIC)), error);
    if let Some(changer) = &machine.wheel_changer {
        let mounted = changer.position(&message.wheel).ok_or_else(|| refuse(other_wheel(changer, &message.wheel)))?;
        machine.mount_wheel(mounted).map_err(|error| refuse(error.to_string()))?;
    }
    Ok(machine)
}

fn other_wheel(changer: &WheelChanger, name: &str) -> String {
    let names: Vec<&str> = changer.wheels.iter().map(|wheel| wheel.name.as_str()).collect();
    format!("wheel is {name:?}; the machine's changer has {}", names.join(", "))
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

/// Wheels of a machine's description, for the machine that it describes with its wheel mounted ([`recorded_machine`]).
///
/// # Errors
/// Wheels that are not those of the machine, or values that no wheel has, as the end of a sentence.
pub fn wheels_now(message: &DescriptionMessage, machine: &MachineDescription) -> Result<WheelsNow, String> {
    let mounted = wheel_now(message);
    check_wheel("the mounted wheel", &mounted)?;
    let Some(changer) = &machine.wheel_changer else {
        return match message.wheels.is_empty() && message.wheel.is_empty() {
            true => Ok(mounted.into()),
            false => Err("the machine's description has several wheels, its file has no wheel_changer".to_owned()),
        };
    };
    let (said, known) = (message.wheels.len(), changer.wheels.len());
    if said != known {
        return Err(format!("the machine's description has {said} wheels, the changer of its file has {known}"));
    }
    let mut stored = [None; MAX_WHEELS];
    for (position, (state, wheel)) in message.wheels.iter().zip(&changer.wheels).enumerate() {
        if state.name != wheel.name {
            let (said, known) = (&state.name, &wheel.name);
            return Err(format!(
                "wheel {position} of the machine's description is {said:?}, that of its file {known:?}"
            ));
        }
        let now = wheel_of_changer(state);
        check_wheel(&format!("wheel {}", wheel.name), &now)?;
        let is_mounted = position == machine.mounted_wheel();
        if state.mounted != is_mounted || is_mounted && (message.wheel != wheel.name || now != mounted) {
            let name = &wheel.name;
            return Err(format!("the machine's description contradicts itself about the mounted wheel: wheel {name}"));
        }
        if let Some(place) = stored.get_mut(position).filter(|_| !is_mounted) {
            *place = Some(now);
        }
    }
    Ok(WheelsNow { mounted, stored })
}

fn wheel_of_changer(state: &WheelState) -> WheelNow {
    WheelNow {
        radius_mm: mm_from_m(state.radius),
        wear_mm: mm_from_m(state.wear),
        lobes_since_dress: state.lobes_since_dress,
        parts_since_dress: state.parts_since_dress,
    }
}

fn check_wheel(what: &str, wheel: &WheelNow) -> Result<(), String> {
    let (radius_mm, wear_mm) = (wheel.radius_mm, wheel.wear_mm);
    if !(radius_mm > 0.0 && radius_mm.is_finite()) {
        return Err(format!("the radius of {what} is {radius_mm} mm; it must be above 0"));
    }
    match (0.0..radius_mm).contains(&wear_mm) {
        true => Ok(()),
        false => Err(format!("the wear of {what} is {wear_mm} mm; its radius is {radius_mm} mm")),
    }
}

impl MachineNow {
    /// The machine as it says that it is.
    ///
    /// # Errors
    /// Why it is not known, as the end of a sentence.
    pub fn from_message(message: &DescriptionMessage) -> Result<Self, String> {
        let description = recorded_machine(message, &[])?;
        let wheels = wheels_now(message, &description)?;
        Ok(Self { description, wheels })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convert::machine_description::description_message;
    use crate::locate;
    use camwright::machine::persistent_state::PersistentState;

    fn two_wheels() -> machine_file::MachineConfig {
        let located = locate::locate("machines", "cam_grinder_two_wheels", "yaml", None).expect("a shipped machine");
        machine_file::parse(&located.path, &located.text, &[]).expect("valid")
    }

    #[test]
    fn the_wheels_of_a_description_are_those_of_the_machine() {
        let file = two_wheels();
        let mut mounted = file.description.clone();
        mounted.mount_wheel(1).expect("two wheels");
        let worn = WheelNow { wear_mm: 0.01, lobes_since_dress: 3, ..WheelNow::dressed(195.0) };
        let other = WheelNow { parts_since_dress: 2, ..WheelNow::dressed(39.0) };
        let mut wheels = WheelsNow::from(other);
        wheels.stored[0] = Some(worn);
        let lasting = PersistentState::new(&mounted).with_wheels(&wheels);
        let message = description_message(&file, &lasting);
        assert_eq!((message.wheel.as_str(), message.wheels.len()), ("finishing", 2));
        assert_eq!((message.wheel_width, message.wheel_surface_speed), (0.020, 60.0));
        let machine = recorded_machine(&message, &[]).expect("its own file");
        assert_eq!(machine, mounted);
        let now = wheels_now(&message, &machine).expect("its own wheels");
        for position in [0, 1] {
            let (found, wanted) = (now.wheel(&machine, position), wheels.wheel(&machine, position));
            assert!((found.radius_mm - wanted.radius_mm).abs() < 1e-9 && (found.wear_mm - wanted.wear_mm).abs() < 1e-9);
            assert_eq!(found.lobes_since_dress, wanted.lobes_since_dress);
        }
        let refused = |change: &dyn Fn(&mut DescriptionMessage)| {
            let mut message = message.clone();
            change(&mut message);
            wheels_now(&message, &machine).expect_err("not its wheels")
        };
        assert!(refused(&|message| _ = message.wheels.pop()).contains("has 1 wheels"));
        assert!(refused(&|message| message.wheels.swap(0, 1)).contains("is \"finishing\""));
        assert!(refused(&|message| message.wheels[0].mounted = true).contains("contradicts itself"));
        assert!(refused(&|message| message.wheels[1].mounted = false).contains("contradicts itself"));
        assert!(refused(&|message| message.wheel = "roughing".into()).contains("contradicts itself"));
        assert!(refused(&|message| message.wheel_radius = 0.030).contains("contradicts itself"));
        assert!(refused(&|message| message.wheels[0].radius = f64::NAN).contains("wheel roughing is NaN"));
        assert!(refused(&|message| message.wheels[0].wear = -1.0).contains("wear of wheel roughing"));
        let unknown = DescriptionMessage { wheel: "polishing".into(), ..message.clone() };
        let error = recorded_machine(&unknown, &[]).expect_err("no such wheel");
        assert!(error.contains("\"polishing\"") && error.contains("roughing, finishing"), "{error}");
    }

    #[test]
    fn a_machine_with_one_wheel_names_none() {
        let located = locate::locate("machines", "cam_grinder", "yaml", None).expect("a shipped machine");
        let file = machine_file::parse(&located.path, &located.text, &[]).expect("valid");
        let message = description_message(&file, &PersistentState::new(&file.description));
        assert!(message.wheel.is_empty() && message.wheels.is_empty());
        let now = wheels_now(&message, &file.description).expect("one wheel");
        assert_eq!((now.mounted.radius_mm, now.stored), (60.0, [None; MAX_WHEELS]));
        let two = DescriptionMessage { wheel: "roughing".into(), ..message };
        assert!(wheels_now(&two, &file.description).expect_err("no changer").contains("no wheel_changer"));
    }
}
