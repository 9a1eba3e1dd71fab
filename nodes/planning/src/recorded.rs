// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A job planned again from what was said of it: its file, and the machine as it was.

use super::{AnyPrepared, plan_any};
use camwright::machine::description::MachineDescription;
use camwright_files::any_job;
use camwright_files::convert::machine_now::{MachineNow, wheels_now};
use camwright_files::locate::{Located, locate};
use camwright_files::recorded_files::{MACHINES, NamedFile, RecordedFiles};
use camwright_msgs::camwright_msgs::msg::{JobStatus, MachineDescription as DescriptionMessage};
use std::path::PathBuf;

/// Reason for not replanning a job without its file.
pub const NO_JOB_FILE: &str = "the bag does not hold the job's file";

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
    let located = Located { recorded: RecordedFiles::new(files), ..Located::new(path, status.job_source.clone()) };
    let job = any_job::parse(&located, overrides).map_err(|error| format!("the recorded job is refused: {error}"))?;
    let wheels = wheels_now(message, &description)?;
    let now = MachineNow { description, wheels };
    let prepared = plan_any(job, Some(&now)).map_err(|error| format!("the recorded job cannot be planned: {error}"))?;
    if overrides.is_empty() && prepared.job_hash() != status.job_hash {
        return Err("a file that the job names is not in the bag, and the one that was found is another".into());
    }
    Ok(prepared)
}
