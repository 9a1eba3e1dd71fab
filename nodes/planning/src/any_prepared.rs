// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A planned job of any kind: what is to be known of it without knowing what it makes.

use super::finding::Finding;
use super::lobe_tables::LobeTable;
use super::table::NumberTable;
use super::timings::{PlanningStage, Timings};
use super::turning::{self, PreparedTurning, tables};
use super::{PreparedJob, findings, plan_timed, summary};
use camwright::machine::description::MachineDescription;
use camwright::planner::PlannedLobe;
use camwright_files::any_job::{self, AnyJob};
use camwright_files::convert::machine_now::MachineNow;
use camwright_files::fault_file::JobFault;
use camwright_files::milling_file::MilledJob;
use camwright_files::recorded_files::NamedFile;
use camwright_files::{ConfigError, FileLocation};
use camwright_msgs::camwright_msgs::msg::PlanPage;
use std::path::Path;

/// A job, planned and ready to send.
#[derive(Debug, Clone)]
pub enum AnyPrepared {
    /// Lobes that are ground.
    Ground(Box<PreparedJob>),
    /// A part that is turned.
    Turned(Box<PreparedTurning>),
}

/// Finds, reads and plans a job of any kind; see [`super::prepare`].
///
/// # Errors
/// Everything that cannot be made, one sentence with the file and the line that causes it.
pub fn prepare_any(name: &str, overrides: &[String], machine: Option<&MachineNow>) -> Result<AnyPrepared, ConfigError> {
    prepare_any_timed(name, overrides, machine, &Timings::start())
}

/// [`prepare_any`] with a stopwatch.
///
/// # Errors
/// Those of [`prepare_any`].
pub fn prepare_any_timed(
    name: &str,
    overrides: &[String],
    machine: Option<&MachineNow>,
    timings: &Timings,
) -> Result<AnyPrepared, ConfigError> {
    plan_any_timed(any_job::load(name, overrides)?, machine, timings)
}

/// Plans a job of any kind that has been read.
///
/// # Errors
/// Everything that cannot be made.
pub fn plan_any(job: AnyJob, machine: Option<&MachineNow>) -> Result<AnyPrepared, ConfigError> {
    plan_any_timed(job, machine, &Timings::start())
}

fn plan_any_timed(job: AnyJob, machine: Option<&MachineNow>, timings: &Timings) -> Result<AnyPrepared, ConfigError> {
    Ok(match job {
        AnyJob::Ground(job) => AnyPrepared::Ground(Box::new(plan_timed(*job, machine, timings)?)),
        AnyJob::Turned(job) => {
            timings.enter(PlanningStage::Turning);
            AnyPrepared::Turned(Box::new(turning::plan_turned(*job, machine)?))
        }
        AnyJob::Milled(job) => return Err(is_milled(&job)),
    })
}

/// Why a milling job has no plan: its program is for another machine.
#[must_use]
pub fn is_milled(job: &MilledJob) -> ConfigError {
    let name = &job.spec.name;
    let message = format!(
        "{name} is milled on a machine with its own CNC control; `camwright post {name}` writes its NC program"
    );
    job.document.error("schema", message)
}

impl AnyPrepared {
    /// Warnings about the job, its files and its plan.
    #[must_use]
    pub fn warnings(&self) -> Vec<Finding> {
        match self {
            Self::Ground(prepared) => findings::all_warnings(prepared),
            Self::Turned(prepared) => turning::all_warnings(prepared),
        }
    }

    /// Returns true if this is the plan of a job, with the files that it names, for the machine as it is.
    #[must_use]
    pub fn is_plan_of(&self, job: &AnyJob, now: &MachineNow) -> bool {
        let is_same_machine = *self.machine() == now.description;
        is_same_machine
            && match (self, job) {
                (Self::Ground(prepared), AnyJob::Ground(job)) => {
                    prepared.job.hash == job.hash && prepared.wheels == now.wheels
                }
                (Self::Turned(prepared), AnyJob::Turned(job)) => prepared.job.hash == job.hash,
                _ => false,
            }
    }

    /// Name of the job.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Ground(prepared) => &prepared.job.spec.name,
            Self::Turned(prepared) => &prepared.job.spec.name,
        }
    }

    /// Text of its file, with overrides applied.
    #[must_use]
    pub fn source(&self) -> &str {
        match self {
            Self::Ground(prepared) => &prepared.job.source,
            Self::Turned(prepared) => &prepared.job.source,
        }
    }

    /// SHA-256 of the job with everything it names, 64 hexadecimal digits.
    #[must_use]
    pub fn job_hash(&self) -> &str {
        match self {
            Self::Ground(prepared) => &prepared.job.hash,
            Self::Turned(prepared) => &prepared.job.hash,
        }
    }

    /// The files that it names.
    #[must_use]
    pub fn files(&self) -> &[NamedFile] {
        match self {
            Self::Ground(prepared) => &prepared.job.files,
            Self::Turned(prepared) => &prepared.job.files,
        }
    }

    /// Hash of its first plan, 64 hexadecimal digits.
    #[must_use]
    pub fn plan_hash(&self) -> &str {
        match self {
            Self::Ground(prepared) => prepared.plan_hash(),
            Self::Turned(prepared) => prepared.plan_hash(),
        }
    }

    /// Its first plan as messages, the header first.
    #[must_use]
    pub fn first_pages(&self) -> &[PlanPage] {
        match self {
            Self::Ground(prepared) => prepared.measuring.as_ref().map_or(&prepared.pages, |measuring| &measuring.pages),
            Self::Turned(prepared) => &prepared.pages,
        }
    }

    /// Predicted duration of all of it (s).
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        match self {
            Self::Ground(prepared) => prepared.duration_s(),
            Self::Turned(prepared) => prepared.duration_s(),
        }
    }

    /// One sentence about it.
    #[must_use]
    pub fn summary(&self) -> String {
        match self {
            Self::Ground(prepared) => prepared.summary(),
            Self::Turned(prepared) => prepared.summary(),
        }
    }

    /// The machine it was planned for.
    #[must_use]
    pub fn machine(&self) -> &MachineDescription {
        match self {
            Self::Ground(prepared) => &prepared.machine,
            Self::Turned(prepared) => &prepared.machine,
        }
    }

    /// Names of what it makes one after the other: its lobes, or the part that it turns.
    #[must_use]
    pub fn lobes(&self) -> &[String] {
        match self {
            Self::Ground(prepared) => &prepared.planned.plan.lobes,
            Self::Turned(prepared) => &prepared.planned.plan.lobes,
        }
    }

    /// Names of its tables: `<lobe>/contour` or `pass_1/insert_path`, as `camwright plan` names their CSV files.
    #[must_use]
    pub fn table_names(&self) -> Vec<String> {
        match self {
            Self::Ground(prepared) => {
                let lobes = prepared.planned.lobes.iter().enumerate();
                let tables = |(index, lobe): (usize, &PlannedLobe)| {
                    let kinds = LobeTable::ALL.into_iter().filter(move |kind| kind.exists(prepared, index));
                    let name = lobe.design.name.clone();
                    kinds.map(move |kind| format!("{name}/{}", kind.name()))
                };
                lobes.flat_map(tables).collect()
            }
            Self::Turned(prepared) => {
                let paths = (0..prepared.planned.passes.len()).map(tables::insert_path_name);
                paths.chain([tables::CLEARANCE.to_owned()]).collect()
            }
        }
    }

    /// Computes one of its tables; none if it has no table of that name.
    ///
    /// # Errors
    /// A turned surface that has no section in the rake plane.
    pub fn table(&self, name: &str) -> Result<Option<NumberTable>, ConfigError> {
        match self {
            Self::Ground(prepared) => {
                let Some((lobe, table)) = name.rsplit_once('/') else { return Ok(None) };
                let index = prepared.planned.lobes.iter().position(|planned| planned.design.name == lobe);
                let kind = LobeTable::ALL.into_iter().find(|kind| kind.name() == table);
                Ok(index.zip(kind).and_then(|(index, kind)| kind.compute(prepared, index)))
            }
            Self::Turned(prepared) if name == tables::CLEARANCE => {
                tables::planned_clearance(prepared).map(|rows| Some(tables::clearance_table(&rows)))
            }
            Self::Turned(prepared) => {
                let mut passes = prepared.planned.passes.iter().enumerate();
                let pass = passes.find(|(index, _)| tables::insert_path_name(*index) == name);
                Ok(pass.map(|(_, pass)| tables::insert_path_table(pass, prepared.job.spec.part_zero_mm)))
            }
        }
    }

    /// Content of `summary.json`.
    ///
    /// # Errors
    /// A number that JSON cannot hold.
    pub fn summary_json(&self) -> Result<String, ConfigError> {
        let text = match self {
            Self::Ground(prepared) => serde_json::to_string(&summary(prepared)),
            Self::Turned(prepared) => serde_json::to_string(&turning::turning_summary(prepared)),
        };
        let place = FileLocation::file(Path::new(self.name()));
        text.map_err(|error| ConfigError::at(place, format!("its summary is not written: {error}")))
    }

    /// Faults that strike in it.
    #[must_use]
    pub fn faults(&self) -> &[JobFault] {
        match self {
            Self::Ground(prepared) => &prepared.job.faults,
            Self::Turned(prepared) => &prepared.job.faults,
        }
    }
}
