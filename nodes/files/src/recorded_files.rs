// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Files that a job names, as a recording holds them.

use std::path::PathBuf;
use std::sync::Arc;

/// Kind of the machine files.
pub const MACHINES: &str = "machines";

/// A file that a job names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedFile {
    /// Kind, as [`super::locate::locate`] knows it: `lifts`, `surfaces`, `programs`, `machines`.
    pub kind: String,
    /// Name of the file in the job.
    pub name: String,
    pub bytes: Arc<[u8]>,
}

/// Files of a recorded job, which are found before any on the disk.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RecordedFiles(Arc<[NamedFile]>);

impl RecordedFiles {
    #[must_use]
    pub fn new(files: Vec<NamedFile>) -> Self {
        Self(files.into())
    }

    /// Names of the files of a kind.
    pub(super) fn names<'a>(&'a self, kind: &'a str) -> impl Iterator<Item = &'a str> {
        self.0.iter().filter(move |file| file.kind == kind).map(|file| file.name.as_str())
    }

    /// Path that errors show, and content of a file.
    pub(super) fn find(&self, kind: &str, name: &str) -> Option<(PathBuf, &[u8])> {
        // A job names one machine.
        let file = self.0.iter().find(|file| file.kind == kind && (file.name == name || kind == MACHINES))?;
        Some((PathBuf::from(format!("recorded:{kind}/{}", file.name)), &file.bytes))
    }
}
