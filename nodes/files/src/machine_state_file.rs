// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Persistent state of the machine in one small file: wheels with their radii, growth of the wheelhead, dress count, part counters.

use crate::names::is_name;
use crate::{ConfigError, FileLocation};
use camwright::machine::description::{MAX_WHEELS, MachineDescription, WheelChanger, WheelDescription};
use camwright::machine::persistent_state::{PersistentState, TravelCount};
use camwright::machine::wheel_magazine::{StoredWheel, WheelMagazine};
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Newest version of the state file's schema that this program reads.
const SCHEMA: &str = "camwright/machine_state/1";

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StateFile {
    schema: String,
    /// Name of the mounted wheel of a changer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    wheel: Option<String>,
    wheel_radius_mm: f64,
    #[serde(default, skip_serializing_if = "is_none")]
    wheel_wear_mm: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    growth_mm: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    growth_at_dress_mm: Option<f64>,
    #[serde(default, skip_serializing_if = "is_zero")]
    lobes_since_dress: u32,
    #[serde(default, skip_serializing_if = "is_zero")]
    parts_since_dress: u32,
    dress_count: u32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    wheel_zero_error_mm: Option<f64>,
    /// The other wheels of a changer.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    wheels: Vec<StoredWheelFile>,
    part_count: u64,
    #[serde(default, skip_serializing_if = "is_no_part")]
    good_count: u64,
    #[serde(default, skip_serializing_if = "is_no_part")]
    bad_count: u64,
    #[serde(default, skip_serializing_if = "is_new_shift")]
    shift: ShiftFile,
}

/// A wheel in the magazine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredWheelFile {
    name: String,
    radius_mm: f64,
    wear_mm: f64,
    growth_at_dress_mm: f64,
    zero_error_mm: f64,
    lobes_since_dress: u32,
    parts_since_dress: u32,
    dress_count: u32,
}

impl StoredWheelFile {
    fn new(name: &str, wheel: &StoredWheel) -> Self {
        let StoredWheel { radius_mm, wear_mm, growth_at_dress_mm, zero_error_mm, .. } = *wheel;
        let StoredWheel { lobes_since_dress, parts_since_dress, dress_count, .. } = *wheel;
        let name = name.to_owned();
        Self {
            name,
            radius_mm,
            wear_mm,
            growth_at_dress_mm,
            zero_error_mm,
            lobes_since_dress,
            parts_since_dress,
            dress_count,
        }
    }

    /// Its state; an error is the end of a message.
    fn wheel(&self, described: &WheelDescription) -> Result<StoredWheel, String> {
        let Self { name, radius_mm, wear_mm, growth_at_dress_mm, zero_error_mm, .. } = self;
        check_size(described, ("radius_mm", *radius_mm), ("wear_mm", *wear_mm))
            .and_then(|()| check_within(("growth_at_dress_mm", *growth_at_dress_mm), MAX_GROWTH_MM))
            .and_then(|()| check_within(("zero_error_mm", *zero_error_mm), MAX_ZERO_ERROR_MM))
            .map_err(|error| format!("wheel {name}: {error}"))?;
        Ok(StoredWheel {
            radius_mm: *radius_mm,
            wear_mm: *wear_mm,
            growth_at_dress_mm: *growth_at_dress_mm,
            zero_error_mm: *zero_error_mm,
            lobes_since_dress: self.lobes_since_dress,
            parts_since_dress: self.parts_since_dress,
            dress_count: self.dress_count,
        })
    }
}

/// Parts of a shift.
#[derive(Debug, Default, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ShiftFile {
    part_count: u64,
    good_count: u64,
    bad_count: u64,
}

fn is_no_part(count: &u64) -> bool {
    *count == 0
}

fn is_new_shift(shift: &ShiftFile) -> bool {
    *shift == ShiftFile::default()
}

fn is_none(wear_mm: &f64) -> bool {
    *wear_mm <= 0.0
}

/// Most that a wheelhead can have grown by (mm).
const MAX_GROWTH_MM: f64 = 1.0;

/// Largest distance of the zero of X from the machine's own (mm).
const MAX_ZERO_ERROR_MM: f64 = 1e5;

/// Checks radius and wear of a wheel, each with its key (mm).
fn check_size(
    wheel: &WheelDescription,
    (radius_key, radius_mm): (&str, f64),
    (wear_key, wear_mm): (&str, f64),
) -> Result<(), String> {
    let (low, high) = (wheel.min_radius_mm, wheel.new_radius_mm);
    if !(low..=high).contains(&radius_mm) {
        return Err(format!("{radius_key} is {radius_mm}, the machine's wheel has {low} to {high}"));
    }
    let max = radius_mm - low;
    if !(0.0..=max.max(0.0)).contains(&wear_mm) {
        return Err(format!("{wear_key} is {wear_mm}, the wheel can lose 0 to {max}"));
    }
    Ok(())
}

fn check_within((key, value): (&str, f64), bound: f64) -> Result<(), String> {
    match (-bound..=bound).contains(&value) {
        true => Ok(()),
        false => Err(format!("{key} is {value}; allowed: -{bound} to {bound}")),
    }
}

/// A growth that is written.
fn grown(mm: f64) -> Option<f64> {
    (mm.abs() > 0.0).then_some(mm)
}

fn is_zero(count: &u32) -> bool {
    *count == 0
}

/// Default path of a machine's state: `$XDG_STATE_HOME/camwright/<machine>.yaml`, or `~/.local/state/…`; `None` without a
/// home folder.
#[must_use]
pub fn default_path(machine: &str) -> Option<PathBuf> {
    // Machine files are refused with other names; no name leads out of the folder, wherever it came from.
    if !is_name(machine) {
        return None;
    }
    let base = std::env::var_os("XDG_STATE_HOME")
        .map(PathBuf::from)
        .filter(|path| path.is_absolute())
        .or_else(|| std::env::var_os("HOME").map(|home| PathBuf::from(home).join(".local/state")))?;
    Some(base.join("camwright").join(format!("{machine}.yaml")))
}

/// Reads the state; a machine that has never run has a new wheel.
///
/// # Errors
/// A file that exists but cannot be read, is of another schema, or holds values the machine cannot have.
pub fn load(path: &Path, description: &MachineDescription) -> Result<PersistentState, ConfigError> {
    let refuse = |message: String| ConfigError::at(FileLocation::file(path), message);
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(PersistentState::new(description)),
        Err(error) => return Err(refuse(format!("cannot be read: {error}"))),
    };
    let file: StateFile = serde_saphyr::from_str(&text).map_err(|error| refuse(error.without_snippet().to_string()))?;
    if file.schema != SCHEMA {
        return Err(refuse(format!("schema is {:?}, this program reads {SCHEMA:?}", file.schema)));
    }
    let mut machine = description.clone();
    if let Some(name) = &file.wheel {
        let mounted = position(description.wheel_changer.as_ref(), "wheel", name).map_err(refuse)?;
        machine.mount_wheel(mounted).map_err(|error| refuse(error.to_string()))?;
    }
    let sizes = (("wheel_radius_mm", file.wheel_radius_mm), ("wheel_wear_mm", file.wheel_wear_mm));
    check_size(&machine.wheel, sizes.0, sizes.1).map_err(refuse)?;
    // What was written before the machine grew begins as a machine that has never run.
    let new = PersistentState::new(&machine);
    let (growth_mm, growth_at_dress_mm) =
        (file.growth_mm.unwrap_or(new.growth_mm), file.growth_at_dress_mm.unwrap_or(new.growth_at_dress_mm));
    let wheel_zero_error_mm = file.wheel_zero_error_mm.unwrap_or(new.wheel_zero_error_mm);
    for (key, value, bound) in [
        ("growth_mm", growth_mm, MAX_GROWTH_MM),
        ("growth_at_dress_mm", growth_at_dress_mm, MAX_GROWTH_MM),
        ("wheel_zero_error_mm", wheel_zero_error_mm, MAX_ZERO_ERROR_MM),
    ] {
        check_within((key, value), bound).map_err(refuse)?;
    }
    let magazine = magazine(&machine, &new, &file.wheels).map_err(refuse)?;
    Ok(PersistentState {
        wheel_radius_mm: file.wheel_radius_mm,
        wheel_wear_mm: file.wheel_wear_mm,
        growth_mm,
        growth_at_dress_mm,
        lobes_since_dress: file.lobes_since_dress,
        parts_since_dress: file.parts_since_dress,
        dress_count: file.dress_count,
        wheel_zero_error_mm,
        magazine,
        life: TravelCount { total: file.part_count, good: file.good_count, bad: file.bad_count },
        shift: TravelCount { total: file.shift.part_count, good: file.shift.good_count, bad: file.shift.bad_count },
    })
}

/// Position of a wheel that the file names under a key; an error is a message.
fn position(changer: Option<&WheelChanger>, key: &str, name: &str) -> Result<usize, String> {
    let Some(changer) = changer else {
        return Err(format!(
            "{key} names the wheel {name:?}, but the machine has no wheel_changer; remove this file to begin with a new wheel"
        ));
    };
    changer.position(name).ok_or_else(|| {
        let names: Vec<&str> = changer.wheels.iter().map(|wheel| wheel.name.as_str()).collect();
        format!("{key} names the wheel {name:?}; the machine's changer has {}", names.join(", "))
    })
}

/// Wheels that are not mounted; those that the file does not hold are new. An error is a message.
fn magazine(
    machine: &MachineDescription,
    new: &PersistentState,
    files: &[StoredWheelFile],
) -> Result<Option<WheelMagazine>, String> {
    let mut stored: [Option<StoredWheel>; MAX_WHEELS] = [None; MAX_WHEELS];
    for file in files {
        let position = position(machine.wheel_changer.as_ref(), "wheels", &file.name)?;
        let described = machine.wheel_changer.as_ref().and_then(|changer| changer.wheels.get(position));
        let (Some(place), Some(described)) = (stored.get_mut(position), described) else { continue };
        if position == machine.mounted_wheel() || place.is_some() {
            return Err(format!("wheels names the wheel {:?}, which the file has already", file.name));
        }
        *place = Some(file.wheel(&described.wheel)?);
    }
    Ok(new.magazine.map(|new| {
        let state = |position: usize| stored[position].or_else(|| new.stored(position));
        WheelMagazine::from_states(new.mounted(), std::array::from_fn(state))
    }))
}

/// Writes the state whole or not at all.
///
/// # Errors
/// A directory or file that cannot be written.
pub fn store(path: &Path, state: &PersistentState, description: &MachineDescription) -> Result<(), ConfigError> {
    let changer = description.wheel_changer.as_ref();
    let named = |position: usize| changer.and_then(|changer| changer.wheels.get(position));
    let stored = (0..MAX_WHEELS)
        .filter(|position| *position != state.mounted_wheel())
        .filter_map(|position| Some(StoredWheelFile::new(&named(position)?.name, &state.wheel_at(position)?)));
    let refuse =
        |error: std::io::Error| ConfigError::at(FileLocation::file(path), format!("cannot be written: {error}"));
    let file = StateFile {
        schema: SCHEMA.to_owned(),
        wheel: named(state.mounted_wheel()).map(|wheel| wheel.name.clone()),
        wheel_radius_mm: state.wheel_radius_mm,
        wheel_wear_mm: state.wheel_wear_mm,
        growth_mm: grown(state.growth_mm),
        growth_at_dress_mm: grown(state.growth_at_dress_mm),
        lobes_since_dress: state.lobes_since_dress,
        parts_since_dress: state.parts_since_dress,
        dress_count: state.dress_count,
        // A wheel of a changer has a setting error until it is dressed.
        wheel_zero_error_mm: changer.map(|_| state.wheel_zero_error_mm).or(grown(state.wheel_zero_error_mm)),
        wheels: stored.collect(),
        part_count: state.life.total,
        good_count: state.life.good,
        bad_count: state.life.bad,
        shift: ShiftFile { part_count: state.shift.total, good_count: state.shift.good, bad_count: state.shift.bad },
    };
    let text = serde_saphyr::to_string(&file)
        .map_err(|error| ConfigError::at(FileLocation::file(path), format!("cannot be written: {error}")))?;
    if let Some(directory) = path.parent() {
        std::fs::create_dir_all(directory).map_err(refuse)?;
    }
    let temporary = path.with_extension("yaml.tmp");
    let mut out = std::fs::File::create(&temporary).map_err(refuse)?;
    out.write_all(text.as_bytes()).and_then(|()| out.sync_all()).map_err(refuse)?;
    std::fs::rename(&temporary, path).map_err(refuse)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_leads_out_of_the_folder() {
        for name in ["../../x", "/etc/x", "a/b", "..", ""] {
            assert_eq!(default_path(name), None, "{name}");
        }
    }

    #[test]
    fn what_is_known_of_the_wheel_survives_and_a_worn_out_one_is_refused() {
        let machine = camwright::machine::reference::cam_grinder();
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("wheel.yaml");
        let state = PersistentState {
            wheel_radius_mm: 58.25,
            wheel_wear_mm: 0.0125,
            growth_mm: 0.004,
            growth_at_dress_mm: 0.001,
            lobes_since_dress: 3,
            parts_since_dress: 1,
            dress_count: 7,
            wheel_zero_error_mm: 0.0,
            magazine: None,
            life: TravelCount { total: 11, good: 8, bad: 2 },
            shift: TravelCount { total: 3, good: 3, bad: 0 },
        };
        store(&file, &state, &machine).unwrap();
        assert_eq!(load(&file, &machine).unwrap(), state);
        // A wheel that is as it was dressed is written as it always was.
        store(&file, &PersistentState::new(&machine), &machine).unwrap();
        assert!(!std::fs::read_to_string(&file).unwrap().contains("wear"));
        assert!(!std::fs::read_to_string(&file).unwrap().contains("shift"), "as it always was");
        let worn = PersistentState { wheel_radius_mm: 45.01, wheel_wear_mm: 0.02, ..state };
        store(&file, &worn, &machine).unwrap();
        let error = load(&file, &machine).unwrap_err().to_string();
        assert!(error.contains("wheel_wear_mm is 0.02, the wheel can lose 0 to 0.0"), "{error}");
    }
    #[test]
    fn every_wheel_of_a_changer_keeps_its_state_by_its_name() {
        let located =
            crate::locate::locate("machines", "cam_grinder_two_wheels", "yaml", None).expect("a shipped machine");
        let machine = crate::machine_file::parse(&located.path, &located.text, &[]).expect("valid").description;
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("wheels.yaml");
        // A file of the time before the changer: the first wheel is mounted, the other is new.
        let old = "schema: camwright/machine_state/1\nwheel_radius_mm: 195.5\ndress_count: 2\npart_count: 9\n";
        std::fs::write(&file, old).unwrap();
        let state = load(&file, &machine).unwrap();
        assert_eq!((state.mounted_wheel(), state.wheel_radius_mm), (0, 195.5));
        let second = state.wheel_at(1).unwrap();
        assert_eq!((second.radius_mm, second.zero_error_mm), (40.0, 0.002));
        // What is written is read, also with the other wheel mounted.
        let mounted = StoredWheel { radius_mm: 38.5, wear_mm: 0.01, dress_count: 4, ..second };
        let first = state.wheel_at(0).unwrap();
        let mut stored = [None; MAX_WHEELS];
        stored[0] = Some(StoredWheel { lobes_since_dress: 5, ..first });
        let changed = PersistentState {
            wheel_radius_mm: mounted.radius_mm,
            wheel_wear_mm: mounted.wear_mm,
            wheel_zero_error_mm: 0.0,
            dress_count: 4,
            magazine: Some(WheelMagazine::from_states(1, stored)),
            ..state
        };
        store(&file, &changed, &machine).unwrap();
        assert_eq!(load(&file, &machine).unwrap(), changed);
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.contains("wheel: finishing"), "{text}");
        for (from, to, wanted) in [
            ("wheel: finishing", "wheel: polishing", "the machine's changer has roughing, finishing"),
            ("name: roughing", "name: finishing", "has already"),
            ("wheel_radius_mm: 38.5", "wheel_radius_mm: 195.5", "the machine's wheel has 32 to 40"),
            ("radius_mm: 195.5", "radius_mm: 20", "wheel roughing: radius_mm is 20"),
        ] {
            std::fs::write(&file, text.replace(from, to)).unwrap();
            let error = load(&file, &machine).unwrap_err().to_string();
            assert!(error.contains(wanted), "{to}: {error}");
        }
        std::fs::write(&file, &text).unwrap();
        let error = load(&file, &camwright::machine::reference::cam_grinder()).unwrap_err().to_string();
        assert!(error.contains("no wheel_changer; remove this file"), "{error}");
    }
}
