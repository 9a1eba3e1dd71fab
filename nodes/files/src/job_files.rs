// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The files that a job names: one hash over all of them, and the files themselves, so that a bag can hold what a job was made from.

use super::ConfigError;
use super::locate::{Located, LocatedBytes, locate, locate_bytes};
use super::recorded_files::NamedFile;
use super::yaml::Document;
use sha2::{Digest, Sha256};
use std::sync::Arc;

/// Files in the order in which a job names them, with SHA-256 over them one after the other, each with its length first, so that no two sets of
/// files give the same bytes.
#[derive(Debug, Clone, Default)]
pub(super) struct JobFiles {
    hash: Sha256,
    files: Vec<NamedFile>,
}

impl JobFiles {
    /// The job's own file.
    pub(super) fn from_document(document: &Document) -> Self {
        let mut files = Self::default();
        files.hash(document.text.as_bytes());
        files
    }

    fn hash(&mut self, file: &[u8]) {
        self.hash.update((file.len() as u64).to_le_bytes());
        self.hash.update(file);
    }

    /// A file that it names.
    pub(super) fn add(&mut self, kind: &str, name: &str, bytes: &[u8]) {
        self.hash(bytes);
        self.files.push(NamedFile { kind: kind.to_owned(), name: name.to_owned(), bytes: bytes.into() });
    }

    /// The hash, 64 hexadecimal digits, and the files that the job names.
    pub(super) fn finish(self) -> (String, Arc<[NamedFile]>) {
        (self.hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect(), self.files.into())
    }
}

impl Document {
    /// Finds a file of a kind that this one names, by name or path.
    ///
    /// # Errors
    /// As [`super::locate::locate`].
    pub(super) fn locate(&self, kind: &str, name: &str, extension: &str) -> Result<Located, ConfigError> {
        match self.recorded.find(kind, name) {
            Some((path, bytes)) => LocatedBytes { path, bytes: bytes.to_vec() }.into_text(),
            None => locate(kind, name, extension, Some(&self.path)),
        }
    }

    /// The same for a file that may be no text and is refused if it is larger than so many bytes.
    ///
    /// # Errors
    /// As [`super::locate::locate_bytes`].
    pub(super) fn locate_bytes(
        &self,
        kind: &str,
        name: &str,
        extension: &str,
        max: u64,
    ) -> Result<LocatedBytes, ConfigError> {
        match self.recorded.find(kind, name) {
            Some((path, bytes)) => Ok(LocatedBytes { path, bytes: bytes.to_vec() }),
            None => locate_bytes(kind, name, extension, Some(&self.path), max),
        }
    }
}
