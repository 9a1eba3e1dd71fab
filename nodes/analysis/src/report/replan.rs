// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The job planned again from what the bag holds of it: what a plan knows and no message says.

use super::job_timeline::JobTimeline;
use camwright::machine::description::MachineDescription;
use camwright_files::convert::machine_now::recorded_machine;
use camwright_planning::{AnyPrepared, NO_JOB_FILE, plan_recorded};

const NO_MACHINE: &str = "no machine description is recorded";

/// Machine of the recorded description.
///
/// # Errors
/// Why it is not known, as the end of a sentence.
pub(super) fn described(story: &JobTimeline<'_>) -> Result<MachineDescription, String> {
    recorded_machine(story.machine.ok_or(NO_MACHINE)?, &[])
}

/// Plans the recorded job for the recorded machine; what comes out counts only if it is the plan that was driven, by its hash.
///
/// # Errors
/// Why there is none, as the end of a sentence.
pub(super) fn plan(
    story: &JobTimeline<'_>,
    described: Result<MachineDescription, String>,
    known: Option<&AnyPrepared>,
) -> Result<AnyPrepared, String> {
    let status = story.status.ok_or("no job is recorded")?;
    let is_driven = |prepared: &&AnyPrepared| story.plans.iter().any(|(driven, _)| driven == prepared.plan_hash());
    if let Some(known) = known.filter(is_driven) {
        return Ok(known.clone());
    }
    if status.job_source.is_empty() {
        return Err(NO_JOB_FILE.into());
    }
    let prepared = plan_recorded(status, story.files.clone(), story.machine.ok_or(NO_MACHINE)?, described?, &[])?;
    let hash = prepared.plan_hash();
    if story.plans.iter().any(|(driven, _)| driven == hash) {
        Ok(prepared)
    } else {
        Err(format!("the recorded job plans to another plan here ({hash:.12})"))
    }
}
