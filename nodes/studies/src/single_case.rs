// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! One case of a written plan, for a scheduler that spreads the cases over many processes.

use super::StudyError;
use super::case_run::{CaseOutcome, run_case};
use super::cases::{StudyCase, cases};
use super::folder::StudyFolder;
use camwright_files::study_file::Study;
use rayon::ThreadPoolBuilder;
use std::path::PathBuf;
use thiserror::Error;

/// A case that ran alone.
#[derive(Debug, Clone, PartialEq)]
pub struct SingleCase {
    pub case: StudyCase,
    /// Number of cases in the plan.
    pub case_count: usize,
    pub outcome: CaseOutcome,
    /// The case had its files already and did not run again.
    pub ran_before: bool,
}

/// A case that cannot run.
#[derive(Debug, Error)]
pub enum SingleCaseError {
    #[error("{0}; write the plan of the cases first: `camwright study FILE --plan --out DIR`")]
    NoPlan(StudyError),
    #[error("case {hash} of {} cannot run: the plan has no such case", plan.display())]
    Unknown { hash: String, plan: PathBuf },
    #[error(
        "case {hash} of {} cannot run: study, job, machine or program have changed since the plan was written; write it again with --plan",
        plan.display()
    )]
    Outdated { hash: String, plan: PathBuf },
    #[error(transparent)]
    Failed(#[from] StudyError),
}

/// Runs a case of the plan in a folder on one thread and writes its files there. A case that has its files does not run again.
///
/// # Errors
/// No plan, a plan without the case or of another study; files that cannot be written.
pub fn run_single_case(study: &Study, folder: &StudyFolder, hash: &str) -> Result<SingleCase, SingleCaseError> {
    let all = cases(study);
    let is_planned = folder.planned_hashes().map_err(SingleCaseError::NoPlan)?.iter().any(|planned| planned == hash);
    let plan = folder.file("plan.json");
    if !is_planned {
        return Err(SingleCaseError::Unknown { hash: hash.to_owned(), plan });
    }
    let Some(case) = all.iter().find(|case| case.hash == hash) else {
        return Err(SingleCaseError::Outdated { hash: hash.to_owned(), plan });
    };
    let done = |outcome, ran_before| SingleCase { case: case.clone(), case_count: all.len(), outcome, ran_before };
    if let Some(outcome) = folder.single_case(hash) {
        return Ok(done(outcome, true));
    }
    let pool = ThreadPoolBuilder::new().num_threads(1).build().map_err(StudyError::Workers)?;
    let outcome = pool.install(|| run_case(study, &case.settings));
    folder.write_single_case(study, &all, hash, &outcome)?;
    Ok(done(outcome, false))
}
