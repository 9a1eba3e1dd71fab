// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Errors of a report.

use camwright_bag::BagError;
use std::io;
use std::path::PathBuf;

/// Reason why a report cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The bag cannot be read.
    #[error(transparent)]
    Bag(#[from] BagError),
    /// The file system refused.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// The attempted action, as a verb.
        action: &'static str,
        path: PathBuf,
        source: io::Error,
    },
    /// The bag holds no job.
    #[error("{} holds no job: nothing was recorded on job_planner/job_status", path.display())]
    NoJob { path: PathBuf },
}
