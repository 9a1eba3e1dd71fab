// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Old runs make room for new ones, up to the configured number.

use std::fs;
use std::path::{Path, PathBuf};

use camwright_bag::BagMetadata;

/// Limits for the older runs beside the next one. Zero: no limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Retention {
    /// Runs, the next one among them.
    pub(super) runs: u64,
    /// Size of all runs before the next one together (B).
    pub(super) bytes: u64,
}

/// A run that was closed.
struct ClosedRun {
    path: PathBuf,
    started: String,
    bytes: u64,
}

impl Retention {
    /// Deletes the oldest runs beside the bag that is to be made, until what is left is within bounds. Only bags of this recorder count that
    /// were closed; what is still being recorded, was killed, or is anybody else's is not touched. Returns what was deleted.
    pub(super) fn make_room(self, next: &Path) -> std::io::Result<Vec<PathBuf>> {
        if self == Self::default() {
            return Ok(Vec::new());
        }
        let Some(folder) = next.parent().filter(|folder| folder.is_dir()) else { return Ok(Vec::new()) };
        let mut runs: Vec<ClosedRun> =
            fs::read_dir(folder)?.filter_map(|entry| closed_run(entry.ok()?.path())).collect();
        runs.sort_by(|a, b| (&a.started, &a.path).cmp(&(&b.started, &b.path)));
        let mut bytes: u64 = runs.iter().map(|run| run.bytes).sum();
        let mut left = runs.len() as u64 + 1;
        let mut deleted = Vec::new();
        for run in runs {
            let is_too_many = self.runs > 0 && left > self.runs;
            let is_too_large = self.bytes > 0 && bytes > self.bytes;
            if !is_too_many && !is_too_large {
                break;
            }
            fs::remove_dir_all(&run.path)?;
            (bytes, left) = (bytes - run.bytes, left - 1);
            deleted.push(run.path);
        }
        Ok(deleted)
    }
}

fn closed_run(path: PathBuf) -> Option<ClosedRun> {
    // The target of a link is outside the directory and stays.
    if !fs::symlink_metadata(&path).ok()?.is_dir() {
        return None;
    }
    let custom_data = BagMetadata::read_from(&path).ok()?.custom_data;
    let outcome = custom_data.get("camwright.outcome")?;
    let started = custom_data.get("camwright.wall_start_utc")?.clone();
    if !matches!(outcome.as_str(), "complete" | "fault") {
        return None;
    }
    let entries = fs::read_dir(&path).ok()?;
    let bytes = entries.filter_map(|entry| Some(entry.ok()?.metadata().ok()?.len())).sum();
    Some(ClosedRun { path, started, bytes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use camwright_bag::{BagWriter, RecordingOutcome, WriterOptions};
    use std::collections::BTreeMap;
    use tempfile::TempDir;

    fn run(path: &Path, started: &str) -> BagWriter {
        let custom_data = BTreeMap::from([("camwright.wall_start_utc".to_owned(), started.to_owned())]);
        BagWriter::create(path, &WriterOptions { custom_data, ..WriterOptions::default() }).expect("it is free")
    }

    #[test]
    fn the_oldest_closed_runs_of_ours_go_and_nothing_else() {
        let dir = TempDir::new().expect("a temporary directory");
        let at = |name: &str| dir.path().join(name);
        for (name, started) in [("b", "2026-01-02"), ("c", "2026-01-03"), ("a", "2026-01-04")] {
            run(&at(name), started).close(RecordingOutcome::Complete, 0).expect("there is room");
        }
        // Of a writer that is dropped nothing says that it was closed.
        drop(run(&at("killed"), "2026-01-01"));
        fs::create_dir(at("notes")).expect("ours");
        fs::write(at("notes").join("todo.txt"), "mine").expect("ours");
        let keep = |runs, bytes| Retention { runs, bytes }.make_room(&at("next")).expect("it is ours");
        assert!(keep(0, 0).is_empty() && keep(4, 0).is_empty() && keep(0, 1 << 40).is_empty());
        assert_eq!(keep(3, 0), [at("b")], "the next one counts");
        assert_eq!(keep(0, 1), [at("c"), at("a")]);
        assert!(at("killed").is_dir() && at("notes").join("todo.txt").is_file());
        assert!(
            Retention { runs: 1, bytes: 0 }.make_room(&at("no").join("where")).expect("nothing is there").is_empty()
        );
    }
}
