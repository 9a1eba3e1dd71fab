// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A folder of its own for a test, removed at the end.

use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// See above.
pub struct Folder(TempDir);

impl Folder {
    /// A new folder under `target/tmp`, whose name begins with `name`.
    pub fn new(name: &str) -> Self {
        let folder = tempfile::Builder::new().prefix(&format!("{name}-")).tempdir_in(env!("CARGO_TARGET_TMPDIR"));
        Self(folder.expect("a folder under target/tmp"))
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// A place in it.
    pub fn join(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    /// Writes a file into it.
    pub fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.join(name);
        std::fs::write(&path, text).expect("a file under target/tmp");
        path
    }
}
