// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Options of a recording.

use super::snapshot::SnapshotOptions;
use super::writer::WriterOptions;
use camwright_threads::supervised::Supervisor;
use std::time::Duration;

/// Layout, limits and intervals of a recording.
#[derive(Debug, Clone)]
pub struct RecordingOptions {
    /// Layout and custom data.
    pub writer: WriterOptions,
    /// Maximum delay until a message is handed to the system: a kill of the process can lose as much. Shorter makes
    /// smaller chunks; 100 ms costs nothing measurable.
    pub flush_interval: Duration,
    /// Maximum delay until it is on the disk: a power failure can lose as much. A sync takes milliseconds.
    pub sync_interval: Duration,
    /// Disk space that stays free (B): with less, the recording does not begin, or ends.
    pub min_free_bytes: u64,
    /// Hold the last messages in memory, and write them on [`super::recording::Recording::snapshot`] only.
    pub snapshot: Option<SnapshotOptions>,
    /// Maximum number of bytes waiting in the queue. One topic may take half of them, all that are fast three quarters together: the last quarter is
    /// for topics of which little waits (each up to a 256th of the queue), so that commands and events have room whatever else comes.
    pub queue_bytes: u64,
    /// Reports the death of the writer's thread.
    pub supervisor: Supervisor,
}

impl Default for RecordingOptions {
    fn default() -> Self {
        Self {
            writer: WriterOptions::default(),
            flush_interval: Duration::from_millis(100),
            sync_interval: Duration::from_secs(1),
            min_free_bytes: 0,
            snapshot: None,
            queue_bytes: 256 << 20,
            supervisor: Supervisor::default(),
        }
    }
}
