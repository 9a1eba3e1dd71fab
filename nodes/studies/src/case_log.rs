// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Log of finished cases: one line of JSON for each, appended as soon as it ends. A line that was cut off by the end of the process is
//! dropped when the log is opened again.

use super::StudyError;
use super::case_run::CaseOutcome;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// A finished case by its hash.
#[derive(Debug, Serialize, Deserialize)]
struct LogLine {
    case: String,
    #[serde(flatten)]
    outcome: CaseOutcome,
}

/// Log of finished cases, open for one process.
#[derive(Debug)]
pub struct CaseLog {
    path: PathBuf,
    file: Mutex<File>,
}

impl CaseLog {
    /// Opens or creates a log; returns it with the cases that it holds.
    ///
    /// # Errors
    /// Another process has it open, or it cannot be read or written.
    pub fn open(path: &Path) -> Result<(Self, HashMap<String, CaseOutcome>), StudyError> {
        let failed = |action| move |source| StudyError::io(action, path, source);
        let options = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
        let mut file = options.map_err(failed("opened"))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(StudyError::InUse { path: path.to_path_buf() }),
            Err(TryLockError::Error(source)) => return Err(StudyError::io("locked", path, source)),
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(failed("read"))?;
        let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
        let lines = bytes[..whole].split(|byte| *byte == b'\n').filter(|line| !line.is_empty());
        // A damaged line is a case that runs again.
        let known = lines.filter_map(|line| serde_json::from_slice::<LogLine>(line).ok());
        let known = known.map(|line| (line.case, line.outcome)).collect();
        file.set_len(whole as u64).map_err(failed("written"))?;
        file.seek(SeekFrom::End(0)).map_err(failed("written"))?;
        Ok((Self { path: path.to_path_buf(), file: Mutex::new(file) }, known))
    }

    /// Adds cases that ran alone: the files of a folder, in the order of their names. Returns those that the log did not hold.
    ///
    /// # Errors
    /// A file cannot be read, or the log cannot be written.
    pub(crate) fn add_single_cases(
        &self,
        folder: &Path,
        known: &HashMap<String, CaseOutcome>,
    ) -> Result<HashMap<String, CaseOutcome>, StudyError> {
        let failed = |source| StudyError::io("read", folder, source);
        let mut paths: Vec<PathBuf> = match std::fs::read_dir(folder) {
            Ok(entries) => {
                entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>().map_err(failed)?
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Vec::new(),
            Err(error) => return Err(failed(error)),
        };
        paths.retain(|path| path.extension().is_some_and(|extension| extension == "json"));
        paths.sort();
        let mut added = HashMap::new();
        for path in paths {
            let bytes = std::fs::read(&path).map_err(|source| StudyError::io("read", &path, source))?;
            // A damaged file is a case that runs again.
            let Ok(line) = serde_json::from_slice::<LogLine>(&bytes) else { continue };
            if !known.contains_key(&line.case) && !added.contains_key(&line.case) {
                self.append(&line.case, &line.outcome)?;
                added.insert(line.case, line.outcome);
            }
        }
        Ok(added)
    }

    /// Appends a finished case.
    ///
    /// # Errors
    /// The log cannot be written.
    pub fn append(&self, case: &str, outcome: &CaseOutcome) -> Result<(), StudyError> {
        let failed = |source| StudyError::io("written", &self.path, source);
        let text = line_of(case, outcome).map_err(failed)?;
        self.file.lock().unwrap_or_else(PoisonError::into_inner).write_all(&text).map_err(failed)
    }
}

/// Line of a finished case.
pub(crate) fn line_of(case: &str, outcome: &CaseOutcome) -> std::io::Result<Vec<u8>> {
    let mut text = serde_json::to_vec(&LogLine { case: case.to_owned(), outcome: outcome.clone() })?;
    text.push(b'\n');
    Ok(text)
}

/// Outcome in the line of a case; none if the line is damaged or of another case.
pub(crate) fn outcome_in(line: &[u8], case: &str) -> Option<CaseOutcome> {
    serde_json::from_slice::<LogLine>(line).ok().filter(|line| line.case == case).map(|line| line.outcome)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case_run::CaseStatus;

    fn outcome(time_s: f64) -> CaseOutcome {
        CaseOutcome {
            status: CaseStatus::Done,
            reason: "a \"reason\"\n of two lines".into(),
            alarm: Some(41),
            worst_lobe: None,
            responses: [Some(time_s), None, Some(0.1 + 0.2), None, None, Some(-0.0), Some(1e-300)],
        }
    }

    #[test]
    fn a_log_survives_a_cut_line_and_keeps_every_bit() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("cases.jsonl");
        let (log, known) = CaseLog::open(&path).expect("a new log");
        assert!(known.is_empty());
        assert!(matches!(CaseLog::open(&path), Err(StudyError::InUse { .. })), "one process at a time");
        for (case, time_s) in [("a", 1.0 / 3.0), ("b", f64::MIN_POSITIVE)] {
            log.append(case, &outcome(time_s)).expect("it is written");
        }
        drop(log);
        let mut text = std::fs::read(&path).expect("a log");
        text.extend_from_slice(b"no json\n{\"case\":\"c\",\"sta");
        std::fs::write(&path, &text).expect("it can be written");
        let (log, known) = CaseLog::open(&path).expect("the log again");
        assert_eq!(known.len(), 2);
        assert_eq!(known["a"], outcome(1.0 / 3.0));
        log.append("c", &outcome(2.0)).expect("it is written");
        drop(log);
        let (_, known) = CaseLog::open(&path).expect("the log again");
        assert_eq!(known.len(), 3);
        assert_eq!(known["c"], outcome(2.0));
    }
}
