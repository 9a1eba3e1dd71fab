// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Checks a bag against the form of rosbag2.
//!
//! ```text
//! directory ─► files ─► walk: records and check sums ─► types, topics, order, numbers, values by their definitions ─┐
//!     │          └────► layout: index against what stands where it points ──────────────────────────────────────────┼─► Report
//!     └─► metadata.yaml ─► accounts: what the bag says of itself against what was seen ─────────────────────────────┘
//! ```
//! `bags/FAULTS.md` lists what is found, and which of the readers that others use find it.

mod accounts;
mod layout;
mod order;
mod report;
mod topics;
mod walk;

use std::path::{Path, PathBuf};

pub use report::{BagFinding, BagReport, BagSeverity};

use super::BagError;
use super::channels::{files_in, is_of_bag};
use super::metadata::{self, BagMetadata};
use report::place_of;
use walk::BagWalk;

/// The only storage that is read here.
const STORAGE: &str = "mcap";

/// Checks the bag at `path`: a directory, or one MCAP file.
///
/// # Errors
/// Only when there is nothing to check; whatever is wrong with a bag is a finding.
pub fn check(path: &Path) -> Result<BagReport, BagError> {
    let is_file = std::fs::metadata(path).map_err(|e| BagError::io("open", path, e))?.is_file();
    let mut walk = BagWalk::default();
    let (files, yaml) = if is_file { (vec![path.to_owned()], None) } else { directory(&mut walk.report, path) };
    walk.is_damaged = yaml.as_ref().is_some_and(|yaml| yaml.storage_identifier != STORAGE);
    for file in &files {
        walk.file(file);
    }
    accounts::agree(&mut walk, yaml.as_ref());
    walk.report.topic_count = walk.counts.len();
    Ok(walk.report)
}

/// The storage files, and what `metadata.yaml` says.
fn directory(report: &mut BagReport, path: &Path) -> (Vec<PathBuf>, Option<BagMetadata>) {
    const PLACE: &str = metadata::FILE_NAME;
    let lying = files_in(path).unwrap_or_default();
    let yaml = match BagMetadata::read_from(path) {
        Ok(yaml) => yaml,
        Err(error) => {
            report.error(PLACE, error.to_string());
            return (lying, None);
        }
    };
    if yaml.version != metadata::VERSION {
        report.warning(PLACE, format!("version {} is older than Jazzy's {}", yaml.version, metadata::VERSION));
    }
    if yaml.storage_identifier != STORAGE {
        report.error(PLACE, format!("storage '{}' is not mcap", yaml.storage_identifier));
        return (Vec::new(), Some(yaml));
    }
    let listed: Vec<&String> = yaml.files.iter().map(|f| &f.path).collect();
    if listed != yaml.relative_file_paths.iter().collect::<Vec<_>>() {
        report.error(PLACE, "files and relative_file_paths do not list the same files");
    }
    for listed in &yaml.relative_file_paths {
        if !is_of_bag(listed) {
            report.error(PLACE, format!("file '{listed}' does not lie in the bag's directory"));
        }
    }
    let files: Vec<PathBuf> = yaml.relative_file_paths.iter().map(|p| path.join(p)).collect();
    for file in lying.iter().filter(|file| !files.contains(file)) {
        report.error(PLACE, format!("it does not list {}, which lies in the bag", place_of(file)));
    }
    (files, Some(yaml))
}
