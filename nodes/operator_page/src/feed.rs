// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Feed of the viewers: waits for changes of the cell and writes them as JSON.

use super::cell_snapshot::CellSnapshot;
use super::status::{Shape, Status};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Shared by the subscriptions and by all viewers.
#[derive(Debug, Default)]
pub(super) struct Feed {
    snapshot: Mutex<CellSnapshot>,
    /// Number of updates.
    version: Mutex<u64>,
    changed: Condvar,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Feed {
    pub(super) fn set_cell(&self, namespace: &str) {
        self.update(|snapshot| {
            namespace.clone_into(&mut snapshot.namespace);
            snapshot.since = Some(Instant::now());
        });
    }

    /// Marks the cell as ended on purpose.
    pub(super) fn end_cell(&self) {
        self.update(|snapshot| snapshot.has_ended = true);
    }

    /// Updates the snapshot and wakes the viewers.
    pub(super) fn update(&self, change: impl FnOnce(&mut CellSnapshot)) {
        change(&mut lock(&self.snapshot));
        *lock(&self.version) += 1;
        self.changed.notify_all();
    }

    /// Waits up to `limit` for a version newer than `seen`; returns the newest.
    pub(super) fn wait_newer(&self, seen: u64, limit: Duration) -> u64 {
        let version = lock(&self.version);
        let waited = self.changed.wait_timeout_while(version, limit, |version| *version <= seen);
        *waited.unwrap_or_else(PoisonError::into_inner).0
    }

    /// Returns the status once `is_enough` is true, or after `limit`.
    pub(super) fn status_when(&self, limit: Duration, is_enough: impl Fn(&CellSnapshot) -> bool) -> Status {
        Status::from_snapshot(&self.wait_until(limit, is_enough), Instant::now())
    }

    /// Waits, up to `limit`, until `is_enough` is true; returns the snapshot.
    pub(super) fn wait_until(
        &self,
        limit: Duration,
        is_enough: impl Fn(&CellSnapshot) -> bool,
    ) -> MutexGuard<'_, CellSnapshot> {
        let deadline = Instant::now() + limit;
        let mut seen = 0;
        loop {
            let snapshot = lock(&self.snapshot);
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() || is_enough(&snapshot) {
                return snapshot;
            }
            drop(snapshot);
            seen = self.wait_newer(seen, left);
        }
    }

    /// Waits, up to `limit`, until no message of a latched topic has arrived for `silence`.
    pub(super) fn wait_for_quiet(&self, silence: Duration, limit: Duration) {
        let deadline = Instant::now() + limit;
        let mut seen = 0;
        loop {
            let quiet = lock(&self.snapshot).latched_at.map_or(silence, |at| at.elapsed());
            let left = silence.saturating_sub(quiet).min(deadline.saturating_duration_since(Instant::now()));
            if left.is_zero() {
                return;
            }
            seen = self.wait_newer(seen, left);
        }
    }

    /// Sleeps between two events.
    pub(super) fn pause(&self, time: Duration) {
        std::thread::sleep(time);
    }

    /// Returns the status as JSON, and the shape if it is newer than `seen`.
    pub(super) fn events(&self, seen: &mut Option<u64>) -> (String, Option<String>) {
        let snapshot = lock(&self.snapshot);
        let status = json(&Status::from_snapshot(&snapshot, Instant::now()));
        let newest = Some(snapshot.shape_version());
        let shape = (*seen != newest).then(|| json(&Shape::from_snapshot(&snapshot)));
        *seen = newest;
        (status, shape)
    }

    pub(super) fn snapshot(&self) -> String {
        let (status, shape) = self.events(&mut None);
        format!("{{\"status\":{status},\"shape\":{}}}\n", shape.unwrap_or_else(|| "null".to_owned()))
    }
}

fn json(value: &impl serde::Serialize) -> String {
    // Texts, numbers and lists always serialise.
    serde_json::to_string(value).unwrap_or_else(|_| "null".to_owned())
}
