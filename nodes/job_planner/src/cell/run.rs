// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A run of parts, and how far it is.

use std::fmt;

/// Next need of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PartPhase {
    /// A raw part in the chuck.
    Part,
    Begin,
    Job,
    Empty,
    End,
}

/// A run of parts.
#[derive(Debug, Clone)]
pub(super) struct PartsRun {
    pub(super) job: String,
    pub(super) overrides: Vec<String>,
    /// Number of parts; 0: until it is stopped.
    pub(super) wanted: u32,
    pub(super) done: u32,
    /// A robot puts the parts in.
    pub(super) loads: bool,
    pub(super) phase: PartPhase,
}

impl fmt::Display for PartsRun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = if self.job.is_empty() { "the loaded job" } else { &self.job };
        match self.wanted {
            0 => write!(f, "{name}, {} parts done", self.done),
            wanted => write!(f, "{name}, {} of {wanted} parts done", self.done),
        }
    }
}
