// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Files people write: machines, jobs, lift tables. What was written is kept apart from what it means; below this module
//! there is only meaning.

pub mod convert;
pub mod digest;
pub mod machine_state_file;
pub mod record_text;

pub mod access;
pub mod any_job;
pub mod compensation_file;
mod contact_file;
mod contour_table;
mod drive_file;
pub mod fault_file;
pub mod file_kind;
mod follower_file;
mod form_tolerance_file;
mod gauge_file;
pub mod gauge_report_file;
pub mod grid_text;
mod groove_file;
pub mod hal_file;
mod homing_file;
mod insert_file;
pub mod job_file;
pub mod job_files;
pub mod journal_file;
mod lift_context;
pub mod lift_file;
mod lift_formula;
pub mod lift_preset;
pub mod lift_text;
pub mod limits;
mod loading_file;
pub mod locate;
pub mod machine_file;
pub mod milling_file;
pub(crate) mod names;
pub mod nc_file;
mod outline_file;
mod pass_file;
mod probe_file;
mod process_file;
pub mod profile_file;
pub mod program_file;
pub mod pulse_file;
pub mod recorded_files;
mod retract_file;
pub mod schema;
mod start_file;
pub mod starter;
pub mod stiffness_file;
mod stl;
pub mod study_file;
mod study_values;
mod surface_file;
mod table_files;
pub mod turning_file;
mod wheel_changer_file;
mod wheel_file;
mod workholding_file;
pub mod yaml;

use std::fmt;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Position in a file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FileLocation {
    pub file: PathBuf,
    /// Line from 1, if it is about a line.
    pub line: Option<u64>,
}

impl FileLocation {
    #[must_use]
    pub fn file(file: &Path) -> Self {
        Self { file: file.to_path_buf(), line: None }
    }

    /// A line of a file.
    #[must_use]
    pub fn line(file: &Path, line: u64) -> Self {
        Self { file: file.to_path_buf(), line: (line > 0).then_some(line) }
    }
}

impl fmt::Display for FileLocation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        match self.line {
            Some(line) => write!(f, ":{line}"),
            None => Ok(()),
        }
    }
}

/// Why a file was refused: one sentence with what, how much, how much is allowed, and where.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{place}: {message}")]
pub struct ConfigError {
    pub place: FileLocation,
    pub message: String,
}

impl ConfigError {
    /// An error at a place.
    #[must_use]
    pub fn at(place: FileLocation, message: impl Into<String>) -> Self {
        Self { place, message: message.into() }
    }
}
