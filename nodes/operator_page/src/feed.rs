//! Feed of the viewers: waits for news of the cell and writes it as JSON.

use super::cell_snapshot::CellSnapshot;
use super::status::{Shape, Status};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Shared by the subscriptions and by all viewers.
#[derive(Debug, Default)]
pub(super) struct Feed {
    known: Mutex<CellSnapshot>,
    /// Grows with everything that was heard.
    version: Mutex<u64>,
    changed: Condvar,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Feed {
    pub(super) fn set_cell(&self, namespace: &str) {
        self.update(|known| {
            namespace.clone_into(&mut known.cell);
            known.since = Some(Instant::now());
        });
    }

    /// Marks the cell as ended on purpose.
    pub(super) fn end_cell(&self) {
        self.update(|known| known.has_ended = true);
    }

    /// Takes something that was heard.
    pub(super) fn update(&self, take: impl FnOnce(&mut CellSnapshot)) {
        take(&mut lock(&self.known));
        *lock(&self.version) += 1;
        self.changed.notify_all();
    }

    /// Waits for something newer than `seen`, at most this long; the newest version.
    pub(super) fn wait_news(&self, seen: u64, most: Duration) -> u64 {
        let version = lock(&self.version);
        let waited = self.changed.wait_timeout_while(version, most, |version| *version <= seen);
        *waited.unwrap_or_else(PoisonError::into_inner).0
    }

    /// The cell once `is_enough` was heard of it, or after so long as far as it was heard then.
    pub(super) fn look(&self, most: Duration, is_enough: impl Fn(&CellSnapshot) -> bool) -> Status {
        let deadline = Instant::now() + most;
        let mut seen = 0;
        loop {
            let known = lock(&self.known);
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() || is_enough(&known) {
                return Status::from_snapshot(&known, Instant::now());
            }
            drop(known);
            seen = self.wait_news(seen, left);
        }
    }

    /// Lets some time pass.
    pub(super) fn pause(&self, time: Duration) {
        std::thread::sleep(time);
    }

    /// The status as JSON, and the shape where it is newer than what was seen of it.
    pub(super) fn events(&self, seen: &mut Option<u64>) -> (String, Option<String>) {
        let known = lock(&self.known);
        let status = json(&Status::from_snapshot(&known, Instant::now()));
        let newest = Some(known.shape_version());
        let shape = (*seen != newest).then(|| json(&Shape::from_snapshot(&known)));
        *seen = newest;
        (status, shape)
    }

    pub(super) fn snapshot(&self) -> String {
        let (status, shape) = self.events(&mut None);
        format!("{{\"status\":{status},\"shape\":{}}}\n", shape.unwrap_or_else(|| "null".to_owned()))
    }
}

fn json(value: &impl serde::Serialize) -> String {
    // Texts, numbers and lists of them can always be written.
    serde_json::to_string(value).unwrap_or_else(|_| "null".to_owned())
}
