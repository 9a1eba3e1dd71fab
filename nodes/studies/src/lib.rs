// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Studies: one job in many cases, planned and simulated without ROS on all cores.
//!
//! ```text
//! study file ─► cases (plan.json) ─► workers ─► case log (cases.jsonl) ─► results.parquet, results.csv, report.html
//!                      ▲                              │
//!                      └───────── searches ◄──────────┘   with `--minimise`
//! ```

mod analysis;
mod case_log;
mod case_run;
mod cases;
mod csv_file;
mod engine;
mod folder;
mod optimise;
mod page;
mod results;
mod simulated_part;
mod single_case;
mod sobol;
mod summary;
mod table;

pub use analysis::{BestPoint, EffectLevel, FactorEffect, FailureReason};
pub use case_log::CaseLog;
pub use case_run::{CaseOutcome, CaseStatus, run_case};
pub use cases::{StudyCase, cases};
pub use engine::{CaseOutcomes, EngineSettings, run_cases};
pub use folder::StudyFolder;
pub use optimise::optimise;
pub use results::{StudyResults, StudyRow};
pub use simulated_part::{SimulatedForm, SimulatedLobe, SimulatedPart, simulate_part};
pub use single_case::{SingleCase, SingleCaseError, run_single_case};

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use thiserror::Error;

/// Files of a study that cannot be read or written.
#[derive(Debug, Error)]
pub enum StudyError {
    #[error("{} cannot be {action}: {source}", path.display())]
    Io { action: &'static str, path: PathBuf, source: std::io::Error },
    #[error("{} cannot be written: {source}", path.display())]
    Table { path: PathBuf, source: parquet::errors::ParquetError },
    #[error("{} is in use by another study; wait for its end or choose another folder with --out", path.display())]
    InUse { path: PathBuf },
    #[error("no worker can be started: {0}")]
    Workers(#[from] rayon::ThreadPoolBuildError),
}

impl StudyError {
    fn io(action: &'static str, path: &Path, source: std::io::Error) -> Self {
        Self::Io { action, path: path.to_path_buf(), source }
    }
}
