//! A job planned again from what was said of it: its file, and the machine as it was.

use super::{AnyPrepared, MachineNow, plan_any};
use crate::config::ConfigError;
use crate::config::any_job;
use crate::config::job_files::{AtHand, MACHINES, NamedFile};
use crate::config::locate::{Located, locate};
use crate::config::machine_file;
use crate::convert::mm_from_m;
use camwright::machine::description::MachineDescription;
use camwright::machine::wheel_state::WheelNow;
use camwright_msgs::camwright_msgs::msg::{JobStatus, MachineDescription as DescriptionMessage};
use std::path::{Path, PathBuf};

/// Why a job cannot be planned again whose file was not told.
pub const NO_JOB_FILE: &str = "the bag does not hold the job's file";

/// What the file says that a machine's description carries, with `key=value` overrides; whether it has its hash the caller judges.
///
/// # Errors
/// It is no machine file.
pub(crate) fn described_machine(
    message: &DescriptionMessage,
    overrides: &[String],
) -> Result<MachineDescription, ConfigError> {
    machine_file::parse(Path::new("machine/description"), &message.source, overrides).map(|file| file.description)
}

/// What a machine was by its recorded description, with `key=value` overrides.
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

/// The wheel that a machine's description tells of.
fn wheel_now(message: &DescriptionMessage) -> WheelNow {
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
    pub fn of(message: &DescriptionMessage) -> Result<Self, String> {
        Ok(Self { description: recorded_machine(message, &[])?, wheel: wheel_now(message) })
    }
}

/// Plans a recorded job, with the files that it names, for a machine on which the recorded wheel is mounted, with `key=value` overrides.
///
/// # Errors
/// Why there is no plan, as the end of a sentence.
pub fn plan_recorded(
    status: &JobStatus,
    mut files: Vec<NamedFile>,
    message: &DescriptionMessage,
    description: MachineDescription,
    overrides: &[String],
) -> Result<AnyPrepared, String> {
    if status.job_source.is_empty() {
        return Err(NO_JOB_FILE.into());
    }
    let (kind, name) = (MACHINES.to_owned(), message.name.clone());
    files.push(NamedFile { kind, name, bytes: message.source.as_bytes().into() });
    // What the bag does not hold is found beside the job's file, where it still is, and is the same file or none.
    let path =
        locate("jobs", &status.job, "yaml", None).map_or_else(|_| PathBuf::from(&status.job), |found| found.path);
    let located = Located { at_hand: AtHand::new(files), ..Located::new(path, status.job_source.clone()) };
    let job = any_job::parse(&located, overrides).map_err(|error| format!("the recorded job is refused: {error}"))?;
    let now = MachineNow { description, wheel: wheel_now(message) };
    let prepared = plan_any(job, Some(&now)).map_err(|error| format!("the recorded job cannot be planned: {error}"))?;
    if overrides.is_empty() && prepared.job_hash() != status.job_hash {
        return Err("a file that the job names is not in the bag, and the one that was found is another".into());
    }
    Ok(prepared)
}
