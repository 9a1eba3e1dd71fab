//! The files that a job names: one hash over all of them, and the files themselves, so that a bag can hold what a job was made from.

use super::ConfigError;
use super::locate::{Located, LocatedBytes, locate, locate_bytes};
use super::yaml::Document;
use sha2::{Digest, Sha256};
use std::path::PathBuf;
use std::sync::Arc;

/// What files of machines are.
pub const MACHINES: &str = "machines";

/// A file that a job names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedFile {
    /// What it is, as [`super::locate::locate`] knows it: `lifts`, `surfaces`, `programs`, `machines`.
    pub kind: String,
    /// As the job names it.
    pub name: String,
    pub bytes: Arc<[u8]>,
}

/// Files in the order in which a job names them, with SHA-256 over them one after the other, each with its length first, so that no two sets of
/// files give the same bytes.
#[derive(Debug, Clone, Default)]
pub(super) struct JobFiles {
    hash: Sha256,
    files: Vec<NamedFile>,
}

impl JobFiles {
    /// The job's own file.
    pub(super) fn of(document: &Document) -> Self {
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

/// Files that are at hand: those of a recorded job, which are found before any on the disk.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct AtHand(Arc<[NamedFile]>);

impl AtHand {
    #[must_use]
    pub fn new(files: Vec<NamedFile>) -> Self {
        Self(files.into())
    }

    /// Names of the files of a kind.
    pub(super) fn names<'a>(&'a self, kind: &'a str) -> impl Iterator<Item = &'a str> {
        self.0.iter().filter(move |file| file.kind == kind).map(|file| file.name.as_str())
    }

    fn find(&self, kind: &str, name: &str) -> Option<LocatedBytes> {
        // A job names one machine.
        let file = self.0.iter().find(|file| file.kind == kind && (file.name == name || kind == MACHINES))?;
        let path = PathBuf::from(format!("recorded:{kind}/{}", file.name));
        Some(LocatedBytes { path, bytes: file.bytes.to_vec() })
    }
}

impl Document {
    /// Finds a file of a kind that this one names, by name or path.
    ///
    /// # Errors
    /// As [`super::locate::locate`].
    pub(super) fn locate(&self, kind: &str, name: &str, extension: &str) -> Result<Located, ConfigError> {
        match self.at_hand.find(kind, name) {
            Some(found) => found.into_text(),
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
        most: u64,
    ) -> Result<LocatedBytes, ConfigError> {
        match self.at_hand.find(kind, name) {
            Some(found) => Ok(found),
            None => locate_bytes(kind, name, extension, Some(&self.path), most),
        }
    }
}
