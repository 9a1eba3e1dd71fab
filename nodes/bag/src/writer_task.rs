// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The thread that owns a bag while it is recorded: it writes, flushes, splits, and closes.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{self, TryRecvError};
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use super::metadata::BagMetadata;
use super::recording_options::RecordingOptions;
use super::recording_state::{RecordingShared, TopicState, WriterCommand};
use super::snapshot::{BufferedMessage, Ring};
use super::writer::{BagWriter, RecordingOutcome};
use super::{BagError, Topic, TopicId};
use camwright_threads::supervised::injected;

/// Polling interval of an idle writer. Messages do not wake it: waking it costs the caller a system call and, with few processors, its own
/// turn; 5000 messages a second took 14 µs (p50) and 45 µs (p99) each into the queue, and take 0.2 and 1.3 µs without
/// (`tests/recorder_load.rs` on two loaded processors). Requests to the writer wake it.
const LOOK: Duration = Duration::from_millis(20);

/// State of the thread.
pub(super) struct WriterTask {
    writer: Option<BagWriter>,
    /// Result of closing, once a fault made it necessary.
    closed: Option<Result<BagMetadata, BagError>>,
    shared: Arc<RecordingShared>,
    topics: Vec<(Option<TopicId>, bool, Arc<TopicState>)>,
    /// Content of a snapshot, if only snapshots are written.
    ring: Option<Ring>,
    flush_interval: Duration,
    sync_interval: Duration,
    min_free_bytes: u64,
}

impl WriterTask {
    /// # Errors
    /// When less is free on the disk than is to be left; the bag is not there then.
    pub(super) fn new(
        writer: BagWriter,
        shared: Arc<RecordingShared>,
        options: &RecordingOptions,
    ) -> Result<Self, BagError> {
        let directory = writer.directory().to_owned();
        let free = free_bytes(&directory);
        if free.is_some_and(|free| free < options.min_free_bytes) {
            drop(writer);
            // Ours, made a moment ago, and empty.
            drop(std::fs::remove_dir_all(&directory));
            return Err(BagError::NoRoom { path: directory, needed: options.min_free_bytes });
        }
        shared.free_bytes.store(free.unwrap_or(u64::MAX), Ordering::Relaxed);
        shared.bytes.store(writer.bytes(), Ordering::Relaxed);
        shared.files.store(1, Ordering::Relaxed);
        Ok(Self {
            writer: Some(writer),
            closed: None,
            shared,
            topics: Vec::new(),
            ring: options.snapshot.map(Ring::new),
            flush_interval: options.flush_interval,
            sync_interval: options.sync_interval,
            min_free_bytes: options.min_free_bytes,
        })
    }

    /// Runs until it is ordered to stop, or until no sender is left.
    pub(super) fn run(mut self, queue: &mpsc::Receiver<WriterCommand>) -> Result<BagMetadata, BagError> {
        let mut next_flush = Instant::now() + self.flush_interval;
        let mut next_sync = Instant::now() + self.sync_interval;
        let outcome = loop {
            injected::point("bag writer");
            match queue.try_recv() {
                Ok(WriterCommand::Topic(topic)) => self.add(&topic),
                Ok(WriterCommand::Message { topic, log_time_ns, publish_time_ns, data }) => {
                    self.receive(BufferedMessage { topic, log_time_ns, publish_time_ns, data });
                }
                Ok(WriterCommand::Split(answer)) => answer(self.step(BagWriter::split).is_some()),
                Ok(WriterCommand::Snapshot(answer)) => answer(self.snapshot()),
                Ok(WriterCommand::Stop(outcome)) => break outcome,
                Err(TryRecvError::Empty) => {
                    std::thread::park_timeout(LOOK.min(next_flush.saturating_duration_since(Instant::now())));
                }
                Err(TryRecvError::Disconnected) => break RecordingOutcome::Complete,
            }
            let now = Instant::now();
            if now >= next_flush {
                let is_sync_due = now >= next_sync;
                self.step(|writer| if is_sync_due { writer.sync() } else { writer.flush() });
                next_flush = now + self.flush_interval;
                if is_sync_due {
                    next_sync = now + self.sync_interval;
                    self.check_disk();
                }
            }
        };
        self.let_go();
        self.close(outcome);
        queue.try_iter().for_each(WriterCommand::refuse);
        self.closed.unwrap_or_else(|| Err(BagError::Closed { reason: "it was never open".into() }))
    }

    fn add(&mut self, topic: &Topic) {
        let state = self.shared.topics().get(self.topics.len()).cloned();
        let id = self.step(|writer| writer.add_topic(topic));
        // The list is longer than ours: the topic was put there before it was sent.
        if let Some(state) = state {
            self.topics.push((id, topic.is_latched(), state));
        }
    }

    fn receive(&mut self, message: BufferedMessage) {
        self.shared.queued_bytes.fetch_sub(message.data.len() as u64, Ordering::AcqRel);
        if let Some((_, _, state)) = self.topics.get(message.topic) {
            state.queued_bytes.fetch_sub(message.data.len() as u64, Ordering::AcqRel);
        }
        let Some(ring) = &mut self.ring else { return self.write(&message) };
        ring.hold(message);
        while let Some(oldest) = self.ring.as_mut().and_then(Ring::take_outdated) {
            self.pass(&oldest);
        }
    }

    /// A message that has been held long enough. What is latched is written all the same: every snapshot begins with it.
    fn pass(&mut self, message: &BufferedMessage) {
        match self.topics.get(message.topic) {
            Some((_, false, state)) => {
                state.passed.fetch_add(1, Ordering::AcqRel);
            }
            _ => self.write(message),
        }
    }

    fn write(&mut self, message: &BufferedMessage) {
        let Some((id, _, state)) = self.topics.get(message.topic).cloned() else { return };
        let BufferedMessage { log_time_ns, publish_time_ns, data, .. } = message;
        let is_written =
            id.and_then(|id| self.step(|writer| writer.write(id, *log_time_ns, *publish_time_ns, data))).is_some();
        let counter = if is_written { &state.written } else { &state.dropped };
        counter.fetch_add(1, Ordering::AcqRel);
    }

    /// Writes what is held; returns how many messages that were.
    fn snapshot(&mut self) -> u64 {
        let mut count = 0;
        while let Some(message) = self.ring.as_mut().and_then(Ring::take) {
            self.write(&message);
            count += 1;
        }
        // The next snapshot has a file of its own.
        if count > 0 {
            self.step(BagWriter::split);
        }
        count
    }

    /// At the end of a recording of snapshots, only latched messages of the buffer are written.
    fn let_go(&mut self) {
        while let Some(message) = self.ring.as_mut().and_then(Ring::take) {
            self.pass(&message);
        }
    }

    /// Ends the recording before the disk is full.
    fn check_disk(&mut self) {
        let min = self.min_free_bytes;
        let Some(free) = self.writer.as_ref().and_then(|writer| free_bytes(writer.directory())) else { return };
        self.shared.free_bytes.store(free, Ordering::Relaxed);
        if free < min {
            self.step(|writer| {
                let directory = writer.directory().display();
                writer.give_up(format!("{free} bytes are free on the disk of {directory}, {min} are to be left"));
                Ok(())
            });
        }
    }

    /// Does one thing with the bag; closes it when that shows that it takes no more.
    fn step<T>(&mut self, action: impl FnOnce(&mut BagWriter) -> Result<T, BagError>) -> Option<T> {
        let writer = self.writer.as_mut()?;
        let result = action(writer);
        self.shared.bytes.store(writer.bytes(), Ordering::Relaxed);
        self.shared.repeated.store(writer.repeated(), Ordering::Relaxed);
        let splits = writer.take_splits();
        if !splits.is_empty() {
            self.shared.files.store(writer.files() as u64, Ordering::Relaxed);
            self.shared.splits.lock().unwrap_or_else(PoisonError::into_inner).extend(splits);
        }
        let fault = writer.fault().map(str::to_owned);
        let fault = match (&result, fault) {
            (_, Some(reason)) => Some(reason),
            // A topic that changed its type spoils that topic, not the bag.
            (Err(BagError::TypeChanged { .. }) | Ok(_), None) => None,
            (Err(error), None) => Some(error.to_string()),
        };
        if let Some(reason) = fault {
            let _ = self.shared.fault.set(reason);
            self.close(RecordingOutcome::Fault);
        }
        result.ok()
    }

    fn close(&mut self, outcome: RecordingOutcome) {
        let Some(mut writer) = self.writer.take() else { return };
        let (losses, enqueue) = (self.shared.losses(), self.shared.enqueue());
        let counters = [
            ("camwright.lost_on_the_way", losses.missed),
            ("camwright.lost_queue_full", losses.queue_full),
            ("camwright.lost_not_taken", losses.dropped.saturating_sub(losses.queue_full)),
            ("camwright.enqueue_count", enqueue.count),
            ("camwright.enqueue_p50_ns", enqueue.p50_ns),
            ("camwright.enqueue_p99_ns", enqueue.p99_ns),
            ("camwright.enqueue_p99_9_ns", enqueue.p99_9_ns),
            ("camwright.enqueue_max_ns", enqueue.longest_ns),
        ];
        for (key, value) in counters {
            writer.add_metadata(key, value.to_string());
        }
        self.closed = Some(writer.close(outcome, losses.dropped + losses.missed));
    }
}

/// Free space on the disk of a directory for ordinary users (B).
pub fn free_bytes(directory: &Path) -> Option<u64> {
    let stats = rustix::fs::statvfs(directory).ok()?;
    Some(stats.f_bavail.saturating_mul(stats.f_frsize))
}
