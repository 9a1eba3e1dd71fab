// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The jobs of a bag: what was asked for, on which machine, and the plan that was driven.

use camwright::machine::description::MachineDescription;
use camwright::motion::plan::Plan;
use camwright_bag::schema_evolution::SchemaChange;
use camwright_bag::{Bag, BagError};
use camwright_files::convert::job_files::files_from_pages;
use camwright_files::convert::plan::plan_from_pages;
use camwright_files::recorded_files::NamedFile;
use camwright_msgs::Message as _;
use camwright_msgs::camwright_msgs::msg::{JobFilePage, JobStatus, MachineDescription as DescriptionMessage, PlanPage};
use camwright_msgs::cdr::message_from_sample;
use std::path::{Path, PathBuf};

/// A job as it was planned once.
#[derive(Debug, Clone)]
pub struct ArchivedJob {
    /// Status of the job after planning.
    pub status: JobStatus,
    /// The machine as it was then; none where it was not recorded.
    pub machine: Option<DescriptionMessage>,
    /// The files that it names, as far as they were recorded.
    pub files: Vec<NamedFile>,
    /// The pages of its first plan, including repetitions.
    pub pages: Vec<PlanPage>,
}

impl ArchivedJob {
    /// The plan as it was.
    ///
    /// # Errors
    /// Why it is not known, as the end of a sentence.
    pub fn plan(&self, machine: &MachineDescription) -> Result<Plan, String> {
        if self.pages.is_empty() {
            return Err(format!("its plan {:.12} was not recorded", self.status.plan_hash));
        }
        plan_from_pages(&self.pages, machine).map(|(plan, _)| plan).map_err(|error| error.to_string())
    }
}

/// The bag at a path, or the bags in the folder there, by their names.
///
/// # Errors
/// Nothing is there, or no bag.
pub fn bags_in(path: &Path) -> Result<Vec<PathBuf>, BagError> {
    let is_bag = |path: &Path| path.is_file() || path.join("metadata.yaml").is_file();
    if is_bag(path) {
        return Ok(vec![path.to_owned()]);
    }
    let failed = |source| BagError::Io { action: "read", path: path.to_owned(), source };
    let mut bags: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(path).map_err(failed)? {
        let inside = entry.map_err(failed)?.path();
        if inside.is_dir() && is_bag(&inside) {
            bags.push(inside);
        }
    }
    if bags.is_empty() {
        return Err(BagError::NoMetadata { path: path.to_owned() });
    }
    bags.sort();
    Ok(bags)
}

/// Every job that was planned while a bag was recorded, one of each kind: the same file on the same machine with the same plan is one.
///
/// # Errors
/// A bag that cannot be read; a message that is none of its type is passed over, and the job then lacks it.
pub fn archived_jobs(path: &Path) -> Result<Vec<ArchivedJob>, BagError> {
    let bag = Bag::open(path)?;
    let mut jobs: Vec<ArchivedJob> = Vec::new();
    // By the cell they are of: what their names begin with.
    let mut machines: Vec<(String, DescriptionMessage)> = Vec::new();
    let mut pages: Vec<PlanPage> = Vec::new();
    let mut files: Vec<JobFilePage> = Vec::new();
    let cell = |topic: usize, name: &str| bag.topics()[topic].name.strip_suffix(name).unwrap_or_default().to_owned();
    let mut messages = bag.messages();
    while let Some(mut message) = messages.next_message()? {
        let topic = &bag.topics()[message.topic];
        let of_type = topic.type_name.as_str();
        if of_type == DescriptionMessage::TYPE_NAME {
            SchemaChange::since(topic, DescriptionMessage::SCHEMA).apply(&mut message.data);
            if let Ok(recorded) = message_from_sample(&message.data) {
                machines.push((cell(message.topic, "machine/description"), recorded));
            }
        } else if of_type == PlanPage::TYPE_NAME {
            pages.extend(message_from_sample::<PlanPage>(&message.data));
        } else if of_type == JobFilePage::TYPE_NAME {
            files.extend(message_from_sample::<JobFilePage>(&message.data));
        } else if of_type == JobStatus::TYPE_NAME {
            SchemaChange::since(topic, JobStatus::SCHEMA).apply(&mut message.data);
            let Ok(status) = message_from_sample::<JobStatus>(&message.data) else { continue };
            if status.plan_hash.is_empty() {
                continue;
            }
            let of = cell(message.topic, "job_planner/job_status");
            let machine = machines.iter().rev().find(|(cell, _)| *cell == of).map(|(_, machine)| machine.clone());
            let is_known = |job: &ArchivedJob| {
                job.status.job_hash == status.job_hash
                    && job.status.plan_hash == status.plan_hash
                    && job.machine.as_ref().map(|known| &known.hash) == machine.as_ref().map(|recorded| &recorded.hash)
            };
            if !jobs.iter().any(is_known) {
                jobs.push(ArchivedJob { status, machine, files: Vec::new(), pages: Vec::new() });
            }
        }
    }
    for job in &mut jobs {
        job.files = files_from_pages(&job.status.job_hash, &files);
        job.pages = pages.iter().filter(|page| page.plan_hash == job.status.plan_hash).cloned().collect();
    }
    Ok(jobs)
}
