// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Writing a bag: one directory, one MCAP file after the other, the metadata in all of them and beside them.

use std::collections::{BTreeMap, VecDeque};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::latched::{Latched, LatchedMessage};
use super::metadata::{BagMetadata, FileEntry, NO_START_NS, RECORDER_VERSION, TopicEntry, VERSION};
use super::preset::Preset;
use super::storage_file::StorageFile;
use super::{BagError, BagMessage, Topic};

/// Custom-data key with the number of repeated latched messages.
pub(super) const REPEATED: &str = "camwright.repeated_total";
/// Custom-data key with the number of oldest files that were deleted.
pub(super) const DELETED: &str = "camwright.deleted_files";
/// The smallest log time: a message at 0 makes viewers refuse the whole bag.
const FIRST_LOG_TIME_NS: u64 = 1;

/// When a bag goes on in its next file, and how many it retains. Nothing set: never by itself, because some viewers read one file only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SplitLimits {
    /// Size of a file that is exceeded by a chunk at most (B), its repeated latched messages apart.
    pub bytes: Option<u64>,
    /// Longest time between the first and the last message of a file, by log time.
    pub duration: Option<Duration>,
    /// Maximum number of files: a split deletes the oldest ones above it.
    pub files: Option<usize>,
}

/// Options of a new bag.
#[derive(Debug, Clone, Default)]
pub struct WriterOptions {
    /// Layout of the files.
    pub preset: Preset,
    /// When the next file begins.
    pub split: SplitLimits,
    /// Custom data of the run; keys `camwright.version`, `.target`, `.outcome` and `.lost_total` are added.
    pub custom_data: BTreeMap<String, String>,
}

/// End of a recording, as `camwright.outcome` states it. While it runs (and in a killed one) it is `open`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordingOutcome {
    /// Closed because it was asked to.
    Complete,
    /// Closed because it could not go on.
    Fault,
    /// The intact part of a bag that was not closed, or damaged.
    Recovered,
}

impl RecordingOutcome {
    fn word(self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::Fault => "fault",
            Self::Recovered => "recovered",
        }
    }
}

/// A topic of a bag that is being written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TopicId(usize);

impl TopicId {
    /// The number of topics added before this one.
    #[must_use]
    pub fn index(self) -> usize {
        self.0
    }
}

struct WrittenTopic {
    topic: Topic,
    written: u64,
}

/// A file that was closed.
struct FinishedFile {
    entry: FileEntry,
    bytes: u64,
    /// Number of messages repeated at its head.
    repeated: u64,
    /// Messages of each topic, by the topic's number in the bag.
    counts: Vec<u64>,
}

/// Writer of a bag. Log times are strictly increasing over all topics and each topic's messages are numbered from 1, so that a
/// reader can prove that none is missing. Every file after the first begins with the latched messages so far, under their original
/// numbers: a repeated number marks a repetition.
pub struct BagWriter {
    directory: PathBuf,
    preset: Preset,
    split: SplitLimits,
    current: StorageFile,
    /// Bytes of the current file when its own messages began, and how many messages it repeats.
    head: (u64, u64),
    /// The files before it.
    finished: VecDeque<FinishedFile>,
    /// Sums over these files, because every message asks for them: bytes, and messages that repeat one of an earlier file.
    finished_bytes: u64,
    finished_repeated: u64,
    deleted_files: usize,
    /// Names of the files that were closed and opened since that was asked last.
    splits: Vec<(String, String)>,
    topics: Vec<WrittenTopic>,
    ids: BTreeMap<String, TopicId>,
    latched: Latched,
    last_ns: u64,
    custom_data: BTreeMap<String, String>,
    /// Why it takes no more, beyond what the current file says.
    fault: Option<String>,
}

impl std::fmt::Debug for BagWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BagWriter")
            .field("directory", &self.directory)
            .field("fault", &self.fault())
            .finish_non_exhaustive()
    }
}

impl BagWriter {
    /// Makes the directory, the storage file, and a first `metadata.yaml`, so that a killed recording can be opened.
    ///
    /// # Errors
    /// When the directory exists, cannot be made, or its disk lacks the room a recording keeps back (`SPARE_BYTES`).
    pub fn create(directory: &Path, options: &WriterOptions) -> Result<Self, BagError> {
        file_name(directory, 0)?;
        if let Some(parent) = directory.parent() {
            fs::create_dir_all(parent).map_err(|e| BagError::io("create", parent, e))?;
        }
        match fs::create_dir(directory) {
            Ok(()) => {}
            Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => {
                return Err(BagError::Exists { path: directory.to_owned() });
            }
            Err(e) => return Err(BagError::io("create", directory, e)),
        }
        match Self::fill(directory, options) {
            Ok(writer) => Ok(writer),
            Err(error) => {
                // The directory is ours and holds nothing of worth; leaving it would refuse the next try.
                drop(fs::remove_dir_all(directory));
                Err(error)
            }
        }
    }

    fn fill(directory: &Path, options: &WriterOptions) -> Result<Self, BagError> {
        let current = StorageFile::create(directory, file_name(directory, 0)?, options.preset)?;
        let mut custom_data = options.custom_data.clone();
        custom_data.insert(RECORDER_VERSION.into(), env!("CARGO_PKG_VERSION").into());
        custom_data.insert("camwright.target".into(), format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS));
        custom_data.insert("camwright.outcome".into(), "open".into());
        custom_data.insert("camwright.lost_total".into(), "0".into());
        let mut writer = Self {
            directory: directory.to_owned(),
            preset: options.preset,
            split: options.split,
            current,
            head: (0, 0),
            finished: VecDeque::new(),
            finished_bytes: 0,
            finished_repeated: 0,
            deleted_files: 0,
            splits: Vec::new(),
            topics: Vec::new(),
            ids: BTreeMap::new(),
            latched: Latched::default(),
            last_ns: 0,
            custom_data,
            fault: None,
        };
        writer.open_account()?;
        Ok(writer)
    }

    /// Writes the summary of the bag while the current file is open, within it and beside it.
    fn open_account(&mut self) -> Result<(), BagError> {
        // As rosbag2 opens a file: it is not listed before it has anything.
        let mut opening = self.metadata();
        opening.files.pop();
        self.current.write_metadata(&opening)?;
        self.current.sync()?;
        self.metadata().write_to(&self.directory)
    }

    #[must_use]
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// Size of the storage files on the disk so far (B).
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.finished_bytes + self.current.whole_bytes()
    }

    /// Storage files on the disk.
    #[must_use]
    pub fn files(&self) -> usize {
        self.finished.len() + 1
    }

    /// Messages that stand at the head of a file once more, over all files but the first.
    #[must_use]
    pub fn repeated(&self) -> u64 {
        if self.finished.is_empty() { 0 } else { self.finished_repeated + self.head.1 }
    }

    /// Why the bag takes no more messages, when it does not: the disk is full or failed.
    #[must_use]
    pub fn fault(&self) -> Option<&str> {
        self.fault.as_deref().or(self.current.fault())
    }

    /// Takes no more messages from now on, for this reason.
    pub fn give_up(&mut self, reason: String) {
        self.fault.get_or_insert(reason);
    }

    /// Adds a topic, or finds it when it is there with the same type.
    ///
    /// # Errors
    /// When the topic is there with another type, or the file cannot be written.
    pub fn add_topic(&mut self, topic: &Topic) -> Result<TopicId, BagError> {
        if let Some(&id) = self.ids.get(&topic.name) {
            let was = &self.topics[id.0].topic;
            if was.type_name == topic.type_name {
                return Ok(id);
            }
            let (was, now) = (was.type_name.clone(), topic.type_name.clone());
            return Err(BagError::TypeChanged { topic: topic.name.clone(), was, now });
        }
        let id = TopicId(self.topics.len());
        self.current.add_topic(id.0, topic)?;
        self.topics.push(WrittenTopic { topic: topic.clone(), written: 0 });
        self.ids.insert(topic.name.clone(), id);
        Ok(id)
    }

    /// Writes one message: `data` is the CDR bytes as they travelled, with the four bytes that say which CDR. A log time
    /// that is not after the previous message's is moved to one nanosecond after it, since players reorder equal ones.
    /// Returns the log time written (ns since 1970).
    ///
    /// # Errors
    /// When the bag takes no more messages; [`BagWriter::fault`] then says why, and the bag should be closed.
    pub fn write(&mut self, id: TopicId, log_time_ns: u64, publish_time_ns: u64, data: &[u8]) -> Result<u64, BagError> {
        if self.is_full(log_time_ns) {
            self.split()?;
        }
        let Some(state) = self.topics.get(id.0) else { return Err(no_topic(id)) };
        let sequence = u32::try_from((state.written + 1) & u64::from(u32::MAX)).unwrap_or(0);
        let is_latched = state.topic.is_latched();
        let log_time_ns = self.next_log_time(log_time_ns);
        self.write_message(id, sequence, (log_time_ns, publish_time_ns), data)?;
        if is_latched {
            self.latched.retain(LatchedMessage { topic: id.0, sequence, publish_time_ns, data: data.to_vec() });
        }
        Ok(log_time_ns)
    }

    /// Writes a message of another bag as it is, with its times and its number.
    ///
    /// # Errors
    /// As [`BagWriter::write`].
    pub(super) fn copy(&mut self, id: TopicId, message: &BagMessage) -> Result<(), BagError> {
        self.write_message(id, message.sequence, (message.log_time_ns, message.publish_time_ns), &message.data)
    }

    /// `times_ns`: log and publication time.
    fn write_message(&mut self, id: TopicId, sequence: u32, times_ns: (u64, u64), data: &[u8]) -> Result<(), BagError> {
        let Some(state) = self.topics.get_mut(id.0) else { return Err(no_topic(id)) };
        if let Some(reason) = self.fault.as_deref().or(self.current.fault()) {
            return Err(BagError::Closed { reason: reason.to_owned() });
        }
        self.current.write(id.0, sequence, times_ns.0, times_ns.1, data)?;
        state.written += 1;
        self.last_ns = self.last_ns.max(times_ns.0);
        Ok(())
    }

    fn next_log_time(&self, log_time_ns: u64) -> u64 {
        log_time_ns.max(self.last_ns.saturating_add(1)).max(FIRST_LOG_TIME_NS)
    }

    /// The current file has as much as the options allow, and something of its own.
    fn is_full(&self, log_time_ns: u64) -> bool {
        let (head_bytes, repeated) = self.head;
        if self.current.messages() <= repeated {
            return false;
        }
        let is_large = self.split.bytes.is_some_and(|max| self.current.bytes().saturating_sub(head_bytes) >= max);
        let is_long = self.split.duration.zip(self.current.log_times_ns()).is_some_and(|(max, (first, _))| {
            log_time_ns.saturating_sub(first) > u64::try_from(max.as_nanos()).unwrap_or(u64::MAX)
        });
        is_large || is_long
    }

    /// Goes on in the next file, which begins with the latched messages so far.
    ///
    /// # Errors
    /// When the next file cannot be made or the last one not be closed; the bag then takes no more messages.
    pub fn split(&mut self) -> Result<(), BagError> {
        let outcome = self.try_split();
        if let Err(error) = &outcome {
            self.give_up(error.to_string());
        }
        outcome
    }

    fn try_split(&mut self) -> Result<(), BagError> {
        if let Some(reason) = self.fault() {
            return Err(BagError::Closed { reason: reason.to_owned() });
        }
        // The next one is open before the last one is closed: if it cannot be made, that one is closed as the last of a whole bag.
        let name = file_name(&self.directory, self.deleted_files + self.files())?;
        let mut next = StorageFile::create(&self.directory, name, self.preset)?;
        for (index, state) in self.topics.iter().enumerate() {
            next.add_topic(index, &state.topic)?;
        }
        let closing = self.metadata();
        let mut last = std::mem::replace(&mut self.current, next);
        last.finish(&closing)?;
        self.finished.push_back(FinishedFile {
            entry: last.entry(),
            bytes: last.whole_bytes(),
            repeated: self.head.1,
            counts: (0..self.topics.len()).map(|topic| last.count(topic)).collect(),
        });
        self.head = (0, 0);
        let outdated = self.forget_outdated();
        self.open_account()?;
        for path in outdated.iter().map(|file| self.directory.join(&file.entry.path)) {
            match fs::remove_file(&path) {
                Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(BagError::io("delete", &path, e)),
                _ => {}
            }
        }
        self.repeat_latched()?;
        self.splits.push((last.name().to_owned(), self.current.name().to_owned()));
        Ok(())
    }

    /// Removes the oldest files above the maximum number from the list.
    fn forget_outdated(&mut self) -> Vec<FinishedFile> {
        let surplus = self.split.files.map_or(0, |max| self.files().saturating_sub(max.max(1)));
        let outdated: Vec<FinishedFile> = self.finished.drain(..surplus).collect();
        self.deleted_files += outdated.len();
        self.finished_bytes = self.finished.iter().map(|file| file.bytes).sum();
        self.finished_repeated = self.finished.iter().skip(1).map(|file| file.repeated).sum();
        if self.deleted_files > 0 {
            self.custom_data.insert(DELETED.into(), self.deleted_files.to_string());
        }
        outdated
    }

    fn repeat_latched(&mut self) -> Result<(), BagError> {
        for kept in self.latched.iter() {
            let log_time_ns = self.last_ns.saturating_add(1);
            self.current.write(kept.topic, kept.sequence, log_time_ns, kept.publish_time_ns, &kept.data)?;
            self.last_ns = log_time_ns;
        }
        self.current.flush()?;
        self.head = (self.current.bytes(), self.current.messages());
        Ok(())
    }

    /// Names of the files that were closed and opened since this was asked last.
    pub fn take_splits(&mut self) -> Vec<(String, String)> {
        std::mem::take(&mut self.splits)
    }

    /// Messages of a topic in the bag so far, repetitions apart.
    #[must_use]
    pub fn written(&self, id: TopicId) -> u64 {
        self.topics.get(id.0).map_or(0, |t| t.written)
    }

    /// Hands everything written so far to the system as whole records: what a kill of this process cannot take back.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn flush(&mut self) -> Result<(), BagError> {
        self.current.flush()
    }

    /// [`BagWriter::flush`], then waits until the bytes are on the disk: what a power failure cannot take back.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn sync(&mut self) -> Result<(), BagError> {
        self.current.sync()
    }

    /// Adds something to what is to be known about the run.
    pub fn add_metadata(&mut self, key: &str, value: String) {
        self.custom_data.insert(key.to_owned(), value);
    }

    /// Closes the bag: the index and both metadata. `lost` is the number of messages that were received and are not in it.
    /// After a fault everything that reached the file whole stays readable.
    ///
    /// # Errors
    /// When the summary cannot be written; the bag then reads like that of a killed recording.
    pub fn close(mut self, outcome: RecordingOutcome, lost: u64) -> Result<BagMetadata, BagError> {
        self.custom_data.insert("camwright.lost_total".into(), lost.to_string());
        let outcome = if self.fault().is_some() { RecordingOutcome::Fault } else { outcome };
        self.custom_data.insert("camwright.outcome".into(), outcome.word().into());
        if let Some(reason) = self.fault().map(str::to_owned) {
            self.custom_data.insert("camwright.fault".into(), reason);
        }
        self.finish()
    }

    /// Closes a bag that is a copy of all that another one holds, with what that said of itself.
    ///
    /// # Errors
    /// As [`BagWriter::close`].
    pub(super) fn close_as_it_was(mut self, custom_data: BTreeMap<String, String>) -> Result<BagMetadata, BagError> {
        self.custom_data = custom_data;
        self.finish()
    }

    /// Closes a bag that is a copy of what is whole in another one, with what that said of itself.
    ///
    /// # Errors
    /// As [`BagWriter::close`].
    pub(super) fn close_as_recovered(mut self, custom_data: BTreeMap<String, String>) -> Result<BagMetadata, BagError> {
        self.custom_data.extend(custom_data);
        self.custom_data.insert("camwright.outcome".into(), RecordingOutcome::Recovered.word().into());
        self.finish()
    }

    fn finish(mut self) -> Result<BagMetadata, BagError> {
        if self.repeated() > 0 {
            self.custom_data.insert(REPEATED.into(), self.repeated().to_string());
        }
        let closing = self.metadata();
        let finished = self.current.finish(&closing);
        if let Err(error) = &finished {
            self.custom_data.insert("camwright.outcome".into(), RecordingOutcome::Fault.word().into());
            self.custom_data.entry("camwright.fault".into()).or_insert_with(|| error.to_string());
        }
        let metadata = self.metadata();
        metadata.write_to(&self.directory)?;
        finished.map(|()| metadata)
    }

    fn metadata(&self) -> BagMetadata {
        let finished = self.finished.iter().map(|file| file.entry.clone());
        let files: Vec<FileEntry> = finished.chain([self.current.entry()]).collect();
        let count = |topic: usize| {
            self.finished.iter().filter_map(|file| file.counts.get(topic)).sum::<u64>() + self.current.count(topic)
        };
        let first_ns = files.iter().filter(|f| f.message_count > 0).map(|f| f.starting_time_ns).min();
        let last_ns = files.iter().filter(|f| f.message_count > 0).map(|f| f.starting_time_ns + f.duration_ns).max();
        BagMetadata {
            version: VERSION,
            storage_identifier: "mcap".into(),
            duration_ns: last_ns.zip(first_ns).map_or(0, |(last, first)| last - first),
            starting_time_ns: first_ns.unwrap_or(NO_START_NS),
            message_count: files.iter().map(|file| file.message_count).sum(),
            topics: self.topics.iter().enumerate().map(|(n, t)| TopicEntry::new(&t.topic, count(n))).collect(),
            compression_format: String::new(),
            compression_mode: String::new(),
            relative_file_paths: files.iter().map(|file| file.path.clone()).collect(),
            files,
            custom_data: self.custom_data.clone(),
            ros_distro: "jazzy".into(),
        }
    }
}

/// The name of a storage file, as rosbag2 makes it.
fn file_name(directory: &Path, number: usize) -> Result<String, BagError> {
    let name = directory.file_name().and_then(|n| n.to_str());
    let name = name.ok_or_else(|| BagError::Name { path: directory.to_owned() })?;
    Ok(format!("{name}_{number}.mcap"))
}

fn no_topic(id: TopicId) -> BagError {
    BagError::Closed { reason: format!("it has no topic number {}", id.0) }
}
