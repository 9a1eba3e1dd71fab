// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Findings of a check.

use camwright_files::ConfigError;
use std::fmt;
use std::path::{Path, PathBuf};

/// Severity of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The job can be made, but needs a look.
    Warning,
    /// The job cannot be made.
    Error,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Severity::Warning => "warning",
            Severity::Error => "error",
        })
    }
}

/// A finding: what, how much, how much is allowed, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    pub severity: Severity,
    /// The sentence, with file and line.
    pub error: ConfigError,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.severity, self.error)
    }
}

/// Findings of one file.
#[derive(Debug, Clone)]
pub struct CheckReport {
    /// The file that was checked.
    pub file: PathBuf,
    /// Errors and warnings, errors first.
    pub findings: Vec<Finding>,
    /// One sentence about the job, if it can be made.
    pub summary: Option<String>,
    /// Readings of its lift tables with the cost of each, and expected finishing turns.
    pub notes: Vec<String>,
}

impl CheckReport {
    #[must_use]
    pub fn worst(&self) -> Option<Severity> {
        self.findings.iter().map(|finding| finding.severity).max()
    }

    #[must_use]
    pub fn first_error(&self) -> Option<&ConfigError> {
        self.findings.iter().find(|finding| finding.severity == Severity::Error).map(|finding| &finding.error)
    }

    pub(super) fn refused(file: &Path, errors: Vec<ConfigError>) -> Self {
        let findings = errors.into_iter().map(|error| Finding { severity: Severity::Error, error }).collect();
        Self { file: file.to_path_buf(), findings, summary: None, notes: Vec::new() }
    }
}

pub(super) fn warning(error: ConfigError) -> Finding {
    Finding { severity: Severity::Warning, error }
}
