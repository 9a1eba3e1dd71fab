//! The job planned again from what the bag holds of it: what a plan knows and no message says.

use super::story::Story;
use crate::config::any_job;
use crate::config::locate::{Located, locate};
use crate::config::machine_file;
use crate::planning::{AnyPrepared, MachineNow, plan_any};
use camwright::machine::description::MachineDescription;
use std::path::{Path, PathBuf};

const NO_MACHINE: &str = "no machine description is recorded";

/// What the machine is, by its recorded description.
///
/// # Errors
/// Why it is not known, as the end of a sentence.
pub(super) fn described(story: &Story<'_>) -> Result<MachineDescription, String> {
    let message = story.machine.ok_or(NO_MACHINE)?;
    let machine = machine_file::parse(Path::new("machine/description"), &message.source, &[]);
    let description = machine.map_err(|error| format!("the machine's description is refused: {error}"))?.description;
    if description.hash == message.hash {
        Ok(description)
    } else {
        Err("this version reads the machine's description as another one".into())
    }
}

/// Plans the recorded job for the recorded machine; what comes out counts only if it is the plan that was driven, by its hash.
///
/// # Errors
/// Why there is none, as the end of a sentence.
pub(super) fn plan(story: &Story<'_>, described: Result<MachineDescription, String>) -> Result<AnyPrepared, String> {
    let status = story.status.ok_or("no job is recorded")?;
    if status.job_source.is_empty() {
        return Err("the bag does not hold the job's file".into());
    }
    let message = story.machine.ok_or(NO_MACHINE)?;
    let description = described?;
    // Tables are found beside the job's file, where it still is.
    let path =
        locate("jobs", &status.job, "yaml", None).map_or_else(|_| PathBuf::from(&status.job), |found| found.path);
    let located = Located { path, text: status.job_source.clone() };
    let job = any_job::parse(&located, &[]).map_err(|error| format!("the recorded job is refused: {error}"))?;
    let now = MachineNow { description, wheel: crate::planning::wheel_now(message) };
    let prepared = plan_any(job, Some(&now)).map_err(|error| format!("the recorded job cannot be planned: {error}"))?;
    let hash = prepared.plan_hash();
    if story.plans.iter().any(|(driven, _)| driven == hash) {
        Ok(prepared)
    } else {
        Err(format!("the recorded job plans to another plan here ({hash:.12})"))
    }
}
