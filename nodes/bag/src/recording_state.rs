// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! State and commands that a recording and its writer's thread share.

use super::Topic;
use super::durations::{DurationSummary, Durations};
use super::writer::RecordingOutcome;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Counts of one topic, shared by the two threads.
#[derive(Debug, Default)]
pub(super) struct TopicState {
    pub(super) topic: String,
    pub(super) type_name: String,
    pub(super) received: AtomicU64,
    pub(super) written: AtomicU64,
    pub(super) dropped: AtomicU64,
    pub(super) passed: AtomicU64,
    /// Messages known to have been lost before they were handed over.
    pub(super) missed: AtomicU64,
    pub(super) queued_bytes: AtomicU64,
}

/// State of a recording, shared by the two threads.
#[derive(Debug, Default)]
pub(super) struct RecordingShared {
    pub(super) queued_bytes: AtomicU64,
    pub(super) bytes: AtomicU64,
    pub(super) free_bytes: AtomicU64,
    pub(super) files: AtomicU64,
    pub(super) repeated: AtomicU64,
    pub(super) fault: OnceLock<String>,
    /// Names of files that were closed and opened since that was asked last.
    pub(super) splits: Mutex<Vec<(String, String)>>,
    /// Messages for which the queue had no room.
    pub(super) queue_full: AtomicU64,
    /// Time to hand each message over.
    pub(super) enqueue: Durations,
    /// Guards the list only; it is locked to add a topic or to read the counts, never while writing.
    pub(super) topics: Mutex<Vec<Arc<TopicState>>>,
}

impl RecordingShared {
    pub(super) fn topics(&self) -> Vec<Arc<TopicState>> {
        self.topics.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Losses so far.
    pub(super) fn losses(&self) -> Losses {
        Losses {
            dropped: self.topics().iter().map(|t| t.dropped.load(Ordering::Acquire)).sum(),
            queue_full: self.queue_full.load(Ordering::Acquire),
            missed: self.missed(),
        }
    }

    /// Messages of all topics known to have been lost before they were handed over.
    pub(super) fn missed(&self) -> u64 {
        let topics = self.topics.lock().unwrap_or_else(PoisonError::into_inner);
        topics.iter().map(|topic| topic.missed.load(Ordering::Acquire)).sum()
    }

    /// Time to hand a message over.
    pub(super) fn enqueue(&self) -> DurationSummary {
        self.enqueue.summary()
    }
}

/// Messages that were published and are not in the bag.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Losses {
    /// Handed over and not written.
    pub(super) dropped: u64,
    /// Those of them for which the queue had no room.
    pub(super) queue_full: u64,
    pub(super) missed: u64,
}

/// Receives the outcome of a request to the writer.
type OnAnswer<T> = Box<dyn FnOnce(T) + Send>;

/// Commands to the writer's thread.
pub(super) enum WriterCommand {
    Topic(Topic),
    Message {
        topic: usize,
        log_time_ns: u64,
        publish_time_ns: u64,
        data: Vec<u8>,
    },
    /// Starts the next file; the answer is true if there is one.
    Split(OnAnswer<bool>),
    /// Writes a snapshot; the answer is the number of its messages.
    Snapshot(OnAnswer<u64>),
    Stop(RecordingOutcome),
}

impl WriterCommand {
    /// Answers that nothing was done: the recording has ended.
    pub(super) fn refuse(self) {
        match self {
            Self::Split(answer) => answer(false),
            Self::Snapshot(answer) => answer(0),
            Self::Topic(_) | Self::Message { .. } | Self::Stop(_) => {}
        }
    }
}
