// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Runs cases on several workers. Each worker plans on one thread, so that a worker is a core and cases do not wait for each other.

use super::StudyError;
use super::case_log::CaseLog;
use super::case_run::{CaseOutcome, run_case};
use super::cases::StudyCase;
use camwright_files::study_file::Study;
use rayon::ThreadPoolBuilder;
use std::collections::{HashMap, HashSet};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Results of cases by hash.
pub type CaseOutcomes = HashMap<String, CaseOutcome>;

/// Course of a run.
pub struct EngineSettings<'a> {
    /// Number of cases that run at a time.
    pub workers: usize,
    /// Returns true when no further case may begin.
    pub is_stopped: &'a (dyn Fn() -> bool + Sync),
    /// Receives the number of finished cases.
    pub on_done: &'a (dyn Fn(usize) + Sync),
}

impl std::fmt::Debug for EngineSettings<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("EngineSettings").field("workers", &self.workers).finish_non_exhaustive()
    }
}

/// Runs the cases that have no outcome yet and adds theirs, in the log too. A stop ends the run after the cases under way.
///
/// # Errors
/// The log cannot be written, or no worker starts.
pub fn run_cases(
    study: &Study,
    cases: &[StudyCase],
    (log, outcomes): (&CaseLog, &mut CaseOutcomes),
    settings: &EngineSettings<'_>,
) -> Result<(), StudyError> {
    let mut seen: HashSet<&str> = HashSet::new();
    let open = cases.iter().filter(|case| !outcomes.contains_key(&case.hash) && seen.insert(case.hash.as_str()));
    let open: Vec<&StudyCase> = open.collect();
    let done = AtomicUsize::new(0);
    let finished: Mutex<Vec<(String, CaseOutcome)>> = Mutex::new(Vec::new());
    let ran = on_workers(settings.workers, &open, |case| {
        if (settings.is_stopped)() {
            return Ok(());
        }
        let outcome = run_case(study, &case.settings);
        log.append(&case.hash, &outcome)?;
        finished.lock().unwrap_or_else(PoisonError::into_inner).push((case.hash.clone(), outcome));
        (settings.on_done)(done.fetch_add(1, Ordering::Relaxed) + 1);
        Ok(())
    });
    outcomes.extend(finished.into_inner().unwrap_or_else(PoisonError::into_inner));
    ran
}

/// Works on items in their order, each worker on one thread. The first error ends the work after the items under way.
pub(crate) fn on_workers<T: Sync>(
    workers: usize,
    items: &[T],
    work: impl Fn(&T) -> Result<(), StudyError> + Sync,
) -> Result<(), StudyError> {
    let pools = (0..workers.clamp(1, items.len().max(1)))
        .map(|_| ThreadPoolBuilder::new().num_threads(1).build())
        .collect::<Result<Vec<_>, _>>()?;
    let next = AtomicUsize::new(0);
    let failure: Mutex<Option<StudyError>> = Mutex::new(None);
    let has_failed = || failure.lock().unwrap_or_else(PoisonError::into_inner).is_some();
    let run = || {
        while !has_failed() {
            let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed)) else { return };
            if let Err(error) = work(item) {
                failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
            }
        }
    };
    std::thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| pool.install(run));
        }
    });
    failure.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
}
