//! Persistent state of the machine in one small file: wheel radius, growth of the wheelhead, dress count, part counters.

use crate::names::is_name;
use crate::{ConfigError, FileLocation};
use camwright::machine::description::MachineDescription;
use camwright::machine::persistent_state::{PersistentState, TravelCount};
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Newest version of the state file's schema that this program reads.
const SCHEMA: &str = "camwright/machine_state/1";

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StateFile {
    schema: String,
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
    part_count: u64,
    #[serde(default, skip_serializing_if = "is_no_part")]
    good_count: u64,
    #[serde(default, skip_serializing_if = "is_no_part")]
    bad_count: u64,
    #[serde(default, skip_serializing_if = "is_new_shift")]
    shift: ShiftFile,
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
    let (low, high) = (description.wheel.min_radius_mm, description.wheel.new_radius_mm);
    if !(low..=high).contains(&file.wheel_radius_mm) {
        return Err(refuse(format!(
            "wheel_radius_mm is {}, the machine's wheel has {low} to {high}",
            file.wheel_radius_mm
        )));
    }
    let max = file.wheel_radius_mm - low;
    if !(0.0..=max.max(0.0)).contains(&file.wheel_wear_mm) {
        return Err(refuse(format!("wheel_wear_mm is {}, the wheel can lose 0 to {max}", file.wheel_wear_mm)));
    }
    // What was written before the machine grew begins as a machine that has never run.
    let new = PersistentState::new(description);
    let (growth_mm, growth_at_dress_mm) =
        (file.growth_mm.unwrap_or(new.growth_mm), file.growth_at_dress_mm.unwrap_or(new.growth_at_dress_mm));
    for (key, value) in [("growth_mm", growth_mm), ("growth_at_dress_mm", growth_at_dress_mm)] {
        if !(-MAX_GROWTH_MM..=MAX_GROWTH_MM).contains(&value) {
            return Err(refuse(format!("{key} is {value}; allowed: -{MAX_GROWTH_MM} to {MAX_GROWTH_MM}")));
        }
    }
    Ok(PersistentState {
        wheel_radius_mm: file.wheel_radius_mm,
        wheel_wear_mm: file.wheel_wear_mm,
        growth_mm,
        growth_at_dress_mm,
        lobes_since_dress: file.lobes_since_dress,
        parts_since_dress: file.parts_since_dress,
        dress_count: file.dress_count,
        life: TravelCount { total: file.part_count, good: file.good_count, bad: file.bad_count },
        shift: TravelCount { total: file.shift.part_count, good: file.shift.good_count, bad: file.shift.bad_count },
    })
}

/// Writes the state whole or not at all.
///
/// # Errors
/// A directory or file that cannot be written.
pub fn store(path: &Path, state: &PersistentState) -> Result<(), ConfigError> {
    let refuse =
        |error: std::io::Error| ConfigError::at(FileLocation::file(path), format!("cannot be written: {error}"));
    let file = StateFile {
        schema: SCHEMA.to_owned(),
        wheel_radius_mm: state.wheel_radius_mm,
        wheel_wear_mm: state.wheel_wear_mm,
        growth_mm: grown(state.growth_mm),
        growth_at_dress_mm: grown(state.growth_at_dress_mm),
        lobes_since_dress: state.lobes_since_dress,
        parts_since_dress: state.parts_since_dress,
        dress_count: state.dress_count,
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
            life: TravelCount { total: 11, good: 8, bad: 2 },
            shift: TravelCount { total: 3, good: 3, bad: 0 },
        };
        store(&file, &state).unwrap();
        assert_eq!(load(&file, &machine).unwrap(), state);
        // A wheel that is as it was dressed is written as it always was.
        store(&file, &PersistentState::new(&machine)).unwrap();
        assert!(!std::fs::read_to_string(&file).unwrap().contains("wear"));
        assert!(!std::fs::read_to_string(&file).unwrap().contains("shift"), "as it always was");
        let worn = PersistentState { wheel_radius_mm: 45.01, wheel_wear_mm: 0.02, ..state };
        store(&file, &worn).unwrap();
        let error = load(&file, &machine).unwrap_err().to_string();
        assert!(error.contains("wheel_wear_mm is 0.02, the wheel can lose 0 to 0.0"), "{error}");
    }
}
