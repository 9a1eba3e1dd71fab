//! A job planned again from what was said of it: its file, and the machine as it was.

use super::{AnyPrepared, MachineNow, plan_any, wheel_now};
use crate::config::any_job;
use crate::config::locate::{Located, locate};
use crate::config::machine_file;
use camwright::machine::description::MachineDescription;
use camwright_msgs::camwright_msgs::msg::{JobStatus, MachineDescription as DescriptionMessage};
use std::path::{Path, PathBuf};

/// What a machine was by its recorded description, with `key=value` overrides.
///
/// # Errors
/// Why it is not known, as the end of a sentence.
pub fn recorded_machine(message: &DescriptionMessage, overrides: &[String]) -> Result<MachineDescription, String> {
    let machine = machine_file::parse(Path::new("machine/description"), &message.source, overrides);
    let description = machine.map_err(|error| format!("the machine's description is refused: {error}"))?.description;
    if overrides.is_empty() && description.hash != message.hash {
        return Err("this version reads the machine's description as another one".into());
    }
    Ok(description)
}

/// Plans a recorded job for a machine on which the recorded wheel is mounted, with `key=value` overrides.
///
/// # Errors
/// Why there is no plan, as the end of a sentence.
pub fn plan_recorded(
    status: &JobStatus,
    message: &DescriptionMessage,
    description: MachineDescription,
    overrides: &[String],
) -> Result<AnyPrepared, String> {
    if status.job_source.is_empty() {
        return Err("the bag does not hold the job's file".into());
    }
    // Tables are found beside the job's file, where it still is.
    let path =
        locate("jobs", &status.job, "yaml", None).map_or_else(|_| PathBuf::from(&status.job), |found| found.path);
    let located = Located { path, text: status.job_source.clone() };
    let job = any_job::parse(&located, overrides).map_err(|error| format!("the recorded job is refused: {error}"))?;
    let now = MachineNow { description, wheel: wheel_now(message) };
    plan_any(job, Some(&now)).map_err(|error| format!("the recorded job cannot be planned: {error}"))
}
