// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! From interface files to Rust, at build time.
//!
//! The stages stand in the order the data walks: [`parse`] reads one file (types by [`syntax`]), [`load`] reads a package and adds the
//! messages that ROS derives from services and actions, [`describe`] computes type descriptions and their RIHS01
//! hashes, [`schema`] writes the text a bag carries, [`rust`] writes the code. The rules of the file format are those
//! of `rosidl_adapter` (Jazzy): what it would refuse or silently misread is an error here, with file and line.

pub(crate) mod describe;
pub(crate) mod load;
pub(crate) mod model;
pub(crate) mod parse;
pub(crate) mod rust;
pub(crate) mod schema;
#[path = "../src/syntax.rs"]
#[allow(unreachable_pub, reason = "the crate exports it")]
pub(crate) mod syntax;
pub(crate) mod value;

use std::fmt;
use std::path::{Path, PathBuf};

/// The package whose files lie directly under the crate's directory.
pub(crate) const OWN_PACKAGE: &str = "camwright_msgs";

/// Error in an interface file, and its position.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Error {
    /// The file at fault.
    pub(crate) file: PathBuf,
    /// Line in it, from 1; 0 when the file as a whole is meant.
    pub(crate) line: usize,
    /// Reason.
    pub(crate) what: String,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            0 => write!(f, "{}: {}", self.file.display(), self.what),
            line => write!(f, "{}:{line}: {}", self.file.display(), self.what),
        }
    }
}

impl std::error::Error for Error {}

/// Reads the interfaces under `root` (own ones in `msg`, `srv`, `action`; others in `standard/<package>`) and returns
/// the text of the Rust module that holds them all.
///
/// # Errors
/// The first file that cannot be read or does not follow the format.
pub(crate) fn generate(root: &Path) -> Result<String, Error> {
    let mut library = load::Library::default();
    library.add_package(OWN_PACKAGE, root, load::Origin::Own)?;
    for (package, folder) in load::packages_in(&root.join("standard"))? {
        library.add_package(&package, &folder, load::Origin::Standard)?;
    }
    library.check_references()?;
    rust::emit(&library)
}
