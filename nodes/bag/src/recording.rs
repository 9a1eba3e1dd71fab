// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A recording: a bag written by a thread of its own behind a bounded queue, with every loss counted.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::thread::{JoinHandle, Thread};
use std::time::Instant;

use super::durations::DurationSummary;
use super::metadata::BagMetadata;
pub use super::recording_options::RecordingOptions;
use super::recording_state::{RecordingShared, TopicState, WriterCommand};
use super::writer::{BagWriter, RecordingOutcome};
use super::writer_task::WriterTask;
use super::{BagError, Topic};

/// Guaranteed share of the queue for a topic (one part of this number), and reserve for topics below their share. 64 topics with
/// their full share fit into it; a cell has some forty, of which a handful is fast.
const RARE: u64 = 256;
const KEPT_FOR_RARE: u64 = 4;

/// Messages of one topic. Once nothing is in the queue, received = written + dropped, and + passed + what is held where only
/// snapshots are written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TopicCounts {
    pub topic: String,
    pub type_name: String,
    /// Messages handed to the recording.
    pub received: u64,
    /// Messages in the bag.
    pub written: u64,
    /// Messages lost between the two.
    pub dropped: u64,
    /// Messages that no snapshot asked for while they were held.
    pub passed: u64,
    /// Messages that are known to have been lost before they could be handed over; they are not among those received.
    pub missed: u64,
}

/// Messages over all topics.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Counts {
    /// Messages handed to the recording.
    pub received: u64,
    /// Messages in the bag.
    pub written: u64,
    /// Messages lost between the two.
    pub dropped: u64,
    /// Those of them for which the queue had no room; the others the bag did not take.
    pub queue_full: u64,
    /// Messages that are known to have been lost before they could be handed over; they are not among those received.
    pub missed: u64,
    /// Time to hand a message over.
    pub enqueue: DurationSummary,
    /// Messages that no snapshot asked for while they were held.
    pub passed: u64,
    /// Latched messages that stand at the head of a later file once more.
    pub repeated: u64,
    pub files: u64,
    /// Size of the storage files on the disk (B).
    pub bytes: u64,
    /// Free space on the disk (B), as of the last sync.
    pub free_bytes: u64,
    /// Bytes waiting in the queue.
    pub queued_bytes: u64,
    /// Each topic, in the order they were added.
    pub topics: Vec<TopicCounts>,
}

/// A topic of a recording.
#[derive(Debug, Clone)]
pub struct RecordedTopic {
    index: usize,
    state: Arc<TopicState>,
}

impl RecordedTopic {
    #[must_use]
    pub fn name(&self) -> &str {
        &self.state.topic
    }

    /// Takes back that a message was lost: it came late.
    pub fn withdraw_missed(&self) {
        self.state.missed.fetch_sub(1, Ordering::AcqRel);
    }

    /// Messages of this topic handed to the recording so far.
    #[must_use]
    pub fn received(&self) -> u64 {
        self.state.received.load(Ordering::Relaxed)
    }
}

/// Thread of a writer; `None` where it panicked.
type WriterThread = JoinHandle<Option<Result<BagMetadata, BagError>>>;

/// A bag that is being written. Dropping it closes the bag.
#[derive(Debug)]
pub struct Recording {
    directory: PathBuf,
    commands: mpsc::Sender<WriterCommand>,
    shared: Arc<RecordingShared>,
    queue_bytes: u64,
    /// The writer's thread, to wake it for what is asked of it.
    writer: Thread,
    /// Join handle until the end is awaited.
    thread: Mutex<Option<WriterThread>>,
}

impl Recording {
    /// Makes the bag in `directory` and begins to write what comes.
    ///
    /// # Errors
    /// As [`BagWriter::create`], when less is free on the disk than is to be left, or when the system gives no thread.
    pub fn start(directory: &Path, options: &RecordingOptions) -> Result<Self, BagError> {
        let writer = BagWriter::create(directory, &options.writer)?;
        let shared = Arc::new(RecordingShared::default());
        let (commands, queue) = mpsc::channel();
        let task = WriterTask::new(writer, shared.clone(), options)?;
        let thread = (options.supervisor)
            .spawn("bag writer", move || task.run(&queue))
            .map_err(|e| BagError::io("start the writer of", directory, e))?;
        Ok(Self {
            directory: directory.to_owned(),
            commands,
            shared,
            queue_bytes: options.queue_bytes,
            writer: thread.thread().clone(),
            thread: Mutex::new(Some(thread)),
        })
    }

    #[must_use]
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// Adds a topic. The same name twice gives the same topic.
    pub fn add_topic(&self, topic: Topic) -> RecordedTopic {
        let mut topics = self.shared.topics.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(index) = topics.iter().position(|t| t.topic == topic.name) {
            return RecordedTopic { index, state: topics[index].clone() };
        }
        let state = Arc::new(TopicState {
            topic: topic.name.clone(),
            type_name: topic.type_name.clone(),
            ..TopicState::default()
        });
        topics.push(state.clone());
        let index = topics.len() - 1;
        // Still under the lock, so that topics reach the writer in the order of their numbers. When the writer is gone, so is
        // the recording, and the first message will be counted as dropped.
        let _ = self.commands.send(WriterCommand::Topic(topic));
        RecordedTopic { index, state }
    }

    /// Hands over one message: the CDR bytes as they travelled, the log time and the publication time (ns since 1970).
    /// Never waits. Returns whether the message is in the writer's queue; otherwise it is counted as dropped.
    pub fn record(&self, topic: &RecordedTopic, log_time_ns: u64, publish_time_ns: u64, data: Vec<u8>) -> bool {
        let begun = Instant::now();
        let is_queued = self.enqueue(topic, log_time_ns, publish_time_ns, data);
        self.shared.enqueue.add(begun.elapsed());
        is_queued
    }

    fn enqueue(&self, topic: &RecordedTopic, log_time_ns: u64, publish_time_ns: u64, data: Vec<u8>) -> bool {
        let state = &topic.state;
        let size = data.len() as u64;
        state.received.fetch_add(1, Ordering::Relaxed);
        let mine = state.queued_bytes.fetch_add(size, Ordering::AcqRel) + size;
        let all = self.shared.queued_bytes.fetch_add(size, Ordering::AcqRel) + size;
        let is_open = self.shared.fault.get().is_none();
        let has_room = self.has_room(mine, all);
        let message = WriterCommand::Message { topic: topic.index, log_time_ns, publish_time_ns, data };
        if is_open && has_room && self.commands.send(message).is_ok() {
            return true;
        }
        self.shared.queued_bytes.fetch_sub(size, Ordering::AcqRel);
        state.queued_bytes.fetch_sub(size, Ordering::AcqRel);
        if is_open && !has_room {
            self.shared.queue_full.fetch_add(1, Ordering::AcqRel);
        }
        state.dropped.fetch_add(1, Ordering::AcqRel);
        false
    }

    /// Returns whether a message may be queued beside `mine` bytes of its topic and `all` bytes of all topics.
    fn has_room(&self, mine: u64, all: u64) -> bool {
        let max = self.queue_bytes;
        let is_rare = mine <= max / RARE;
        all <= max && (is_rare || (mine <= max / 2 && all <= max - max / KEPT_FOR_RARE))
    }

    /// Notes that `count` messages of a topic were lost before they could be handed over; they enter `camwright.lost_total`. Returns
    /// whether that is worth saying: the first time, and at every doubling of the sum over all topics.
    pub fn report_missed(&self, topic: &RecordedTopic, count: u64) -> bool {
        let before = self.shared.missed();
        topic.state.missed.fetch_add(count, Ordering::AcqRel);
        before == 0 || (before + count).ilog2() > before.ilog2()
    }

    /// Continues in the next file once the queue is written. The writer's thread then calls `answer` with whether there is one.
    pub fn split(&self, answer: impl FnOnce(bool) + Send + 'static) {
        self.ask(WriterCommand::Split(Box::new(answer)));
    }

    /// Writes the messages held in memory to a file of their own. The writer's thread then calls `answer` with their number.
    pub fn snapshot(&self, answer: impl FnOnce(u64) + Send + 'static) {
        self.ask(WriterCommand::Snapshot(Box::new(answer)));
    }

    fn ask(&self, command: WriterCommand) {
        match self.commands.send(command) {
            Ok(()) => self.writer.unpark(),
            Err(mpsc::SendError(command)) => command.refuse(),
        }
    }

    /// Names of the files that were closed and opened since this was asked last.
    #[must_use]
    pub fn take_splits(&self) -> Vec<(String, String)> {
        std::mem::take(&mut self.shared.splits.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Why the recording cannot go on, when it cannot: its bag is closed then, and everything since is counted as dropped.
    #[must_use]
    pub fn fault(&self) -> Option<&str> {
        self.shared.fault.get().map(String::as_str)
    }

    /// Received, written and lost messages.
    #[must_use]
    pub fn counts(&self) -> Counts {
        let mut counts = Counts {
            queue_full: self.shared.queue_full.load(Ordering::Acquire),
            enqueue: self.shared.enqueue(),
            bytes: self.shared.bytes.load(Ordering::Relaxed),
            queued_bytes: self.shared.queued_bytes.load(Ordering::Relaxed),
            free_bytes: self.shared.free_bytes.load(Ordering::Relaxed),
            files: self.shared.files.load(Ordering::Relaxed),
            repeated: self.shared.repeated.load(Ordering::Relaxed),
            ..Counts::default()
        };
        for state in self.shared.topics() {
            // The two ends first, so that the sum never exceeds what was received.
            let written = state.written.load(Ordering::Acquire);
            let dropped = state.dropped.load(Ordering::Acquire);
            let passed = state.passed.load(Ordering::Acquire);
            let received = state.received.load(Ordering::Acquire);
            let missed = state.missed.load(Ordering::Acquire);
            counts.received += received;
            counts.written += written;
            counts.dropped += dropped;
            counts.passed += passed;
            counts.missed += missed;
            let (topic, type_name) = (state.topic.clone(), state.type_name.clone());
            counts.topics.push(TopicCounts { topic, type_name, received, written, dropped, passed, missed });
        }
        counts
    }

    /// Writes what is queued and closes the bag; whatever is handed over afterwards is dropped and counted.
    ///
    /// # Errors
    /// When the bag could not be closed properly. A full disk is no such error: the bag is whole, and
    /// `camwright.outcome` in it says `fault`.
    pub fn stop(&self, outcome: RecordingOutcome) -> Result<(BagMetadata, Counts), BagError> {
        let result = self.join(outcome);
        result.map(|metadata| (metadata, self.counts()))
    }

    fn join(&self, outcome: RecordingOutcome) -> Result<BagMetadata, BagError> {
        let lost = || BagError::Closed { reason: "its writer ended".into() };
        let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(thread) = thread else { return Err(lost()) };
        // When the writer is gone already, joining says why.
        self.ask(WriterCommand::Stop(outcome));
        thread.join().ok().flatten().ok_or_else(lost)?
    }
}

impl Drop for Recording {
    fn drop(&mut self) {
        // No caller is left to receive an error; the metadata of the bag has it. After `stop` there is nothing to join.
        drop(self.join(RecordingOutcome::Complete));
    }
}
