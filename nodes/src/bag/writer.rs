//! Writing a bag: one directory, one MCAP file, the metadata in both.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;

use super::metadata::{BagMetadata, FileEntry, NO_START_NS, RECORD_KEY, RECORD_NAME, TopicEntry, VERSION};
use super::spare::{Level, SPARE_BYTES, Spare, SpareWriter};
use super::{BagError, Message, Topic, qos};

/// rosbag2's `DefaultChunkSize` (B).
const CHUNK_BYTES: u64 = 786_432;
/// What is gathered before a write to the file (B); a flush empties it, so it adds nothing to what a kill can cost.
const BUFFER_BYTES: usize = 256 << 10;
/// The smallest log time: a message at 0 makes viewers refuse the whole bag.
const FIRST_LOG_TIME_NS: u64 = 1;

/// How the file is laid out, with rosbag2's names for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Preset {
    /// Chunks of 768 KiB without compression, with check sums.
    #[default]
    Default,
    /// The same chunks, compressed with Zstandard at its fast level 1.
    Zstd,
    /// No chunks, hence no index: least work while recording, no seeking afterwards.
    FastWrite,
}

impl Preset {
    /// The preset of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "default" => Some(Self::Default),
            "zstd" => Some(Self::Zstd),
            "fastwrite" => Some(Self::FastWrite),
            _ => None,
        }
    }

    fn write_options(self) -> mcap::WriteOptions {
        // Everything is said here: the library's own defaults compress on as many threads as the machine has.
        let options = mcap::WriteOptions::new()
            .profile("ros2")
            .library(concat!("camwright ", env!("CARGO_PKG_VERSION")))
            .compression(None)
            .compression_level(1)
            .compression_threads(0)
            .chunk_size(Some(CHUNK_BYTES))
            .use_chunks(true)
            // A chunk under way stays in memory, so that a kill leaves whole records and at most one torn one.
            .disable_seeking(true)
            .calculate_chunk_crcs(true)
            .calculate_data_section_crc(true)
            .calculate_summary_section_crc(true);
        match self {
            Self::Default => options,
            Self::Zstd => options.compression(Some(mcap::Compression::Zstd)),
            Self::FastWrite => {
                options.use_chunks(false).emit_message_indexes(false).calculate_summary_section_crc(false)
            }
        }
    }
}

/// What a new bag is to be.
#[derive(Debug, Clone, Default)]
pub struct WriterOptions {
    /// Layout of the file.
    pub preset: Preset,
    /// What is to be known about the run; keys `camwright.version`, `.target`, `.outcome` and `.lost_total` are added.
    pub custom_data: BTreeMap<String, String>,
}

/// How a recording ended, as `camwright.outcome` says it. While it runs (and in a killed one) it is `open`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Closed because it was asked to.
    Complete,
    /// Closed because it could not go on.
    Fault,
    /// What was whole in a bag that was not closed, or damaged.
    Recovered,
}

impl Outcome {
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

struct TopicState {
    topic: Topic,
    channel: u16,
    written: u64,
}

type Storage = mcap::Writer<NoSeek<BufWriter<SpareWriter<File, Spare>>>>;

/// A bag being written. Log times are strictly increasing over all topics and each topic's messages are numbered from 1, so
/// that a reader can prove that none is missing.
pub struct BagWriter {
    directory: PathBuf,
    file_name: String,
    path: PathBuf,
    storage: Option<Storage>,
    level: Arc<Level>,
    /// A second handle of the storage file, for `sync_data`.
    file: File,
    /// Length of the file at the last flush (B): everything before it is whole records.
    whole_bytes: u64,
    topics: Vec<TopicState>,
    ids: BTreeMap<String, TopicId>,
    first_ns: Option<u64>,
    last_ns: u64,
    custom_data: BTreeMap<String, String>,
    is_dirty: bool,
    fault: Option<String>,
}

impl std::fmt::Debug for BagWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BagWriter")
            .field("directory", &self.directory)
            .field("fault", &self.fault)
            .finish_non_exhaustive()
    }
}

impl BagWriter {
    /// Makes the directory, the storage file, and a first `metadata.yaml`, so that a killed recording can be opened.
    ///
    /// # Errors
    /// When the directory exists, cannot be made, or its disk lacks the room a recording keeps back ([`SPARE_BYTES`]).
    pub fn create(directory: &Path, options: &WriterOptions) -> Result<Self, BagError> {
        let name = directory
            .file_name()
            .and_then(|n| n.to_str())
            .ok_or_else(|| BagError::Name { path: directory.to_owned() })?;
        let file_name = format!("{name}_0.mcap");
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
        match Self::fill(directory, file_name, options) {
            Ok(writer) => Ok(writer),
            Err(error) => {
                // The directory is ours and holds nothing of worth; leaving it would refuse the next try.
                drop(fs::remove_dir_all(directory));
                Err(error)
            }
        }
    }

    fn fill(directory: &Path, file_name: String, options: &WriterOptions) -> Result<Self, BagError> {
        let spare = Spare::keep(directory).map_err(|e| match e.kind() {
            std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded => {
                BagError::NoRoom { path: directory.to_owned(), needed: SPARE_BYTES }
            }
            _ => BagError::io("write into", directory, e),
        })?;
        let path = directory.join(&file_name);
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&path)
            .map_err(|e| BagError::io("create", &path, e))?;
        let second_handle = file.try_clone().map_err(|e| BagError::io("open", &path, e))?;
        let sink = SpareWriter::new(file, spare);
        let level = sink.level();
        let sink = NoSeek::new(BufWriter::with_capacity(BUFFER_BYTES, sink));
        let storage = options.preset.write_options().create(sink).map_err(|e| BagError::mcap(&path, e))?;

        let mut custom_data = options.custom_data.clone();
        custom_data.insert("camwright.version".into(), env!("CARGO_PKG_VERSION").into());
        custom_data.insert("camwright.target".into(), format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS));
        custom_data.insert("camwright.outcome".into(), "open".into());
        custom_data.insert("camwright.lost_total".into(), "0".into());
        let mut writer = Self {
            directory: directory.to_owned(),
            file_name,
            path,
            storage: Some(storage),
            level,
            file: second_handle,
            whole_bytes: 0,
            topics: Vec::new(),
            ids: BTreeMap::new(),
            first_ns: None,
            last_ns: 0,
            custom_data,
            is_dirty: true,
            fault: None,
        };
        // As rosbag2 opens a file: none is listed before it has anything.
        let opening = BagMetadata { files: Vec::new(), ..writer.metadata() };
        writer.write_metadata_record(&opening)?;
        writer.sync()?;
        writer.metadata().write_to(directory)?;
        Ok(writer)
    }

    /// The bag's directory.
    #[must_use]
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// Size of the storage file on the disk so far (B).
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.whole_bytes
    }

    /// Why the bag takes no more messages, when it does not: the disk is full or failed.
    #[must_use]
    pub fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
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
        let channel = self.with_storage(|storage| {
            let schema = storage.add_schema(&topic.type_name, "ros2msg", topic.definition.as_bytes())?;
            let channel_metadata = BTreeMap::from([
                ("offered_qos_profiles".to_owned(), qos::to_yaml(&topic.offered_qos, 0)),
                ("topic_type_hash".to_owned(), topic.type_hash.clone()),
            ]);
            storage.add_channel(schema, &topic.name, "cdr", &channel_metadata)
        })?;
        let id = TopicId(self.topics.len());
        self.topics.push(TopicState { topic: topic.clone(), channel, written: 0 });
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
        let Some(state) = self.topics.get(id.0) else {
            return Err(BagError::Closed { reason: format!("it has no topic number {}", id.0) });
        };
        if let Some(reason) = &self.fault {
            return Err(BagError::Closed { reason: reason.clone() });
        }
        let log_time = log_time_ns.max(self.last_ns.saturating_add(1)).max(FIRST_LOG_TIME_NS);
        let sequence = u32::try_from((state.written + 1) & u64::from(u32::MAX)).unwrap_or(0);
        let header = MessageHeader { channel_id: state.channel, sequence, log_time, publish_time: publish_time_ns };
        self.with_storage(|storage| storage.write_to_known_channel(&header, data))?;
        self.topics[id.0].written += 1;
        self.first_ns.get_or_insert(log_time);
        self.last_ns = log_time;
        Ok(log_time)
    }

    /// Writes a message of another bag as it is, with its times and its number.
    ///
    /// # Errors
    /// As [`BagWriter::write`].
    pub(super) fn copy(&mut self, id: TopicId, message: &Message) -> Result<(), BagError> {
        let Some(channel) = self.topics.get(id.0).map(|state| state.channel) else {
            return Err(BagError::Closed { reason: format!("it has no topic number {}", id.0) });
        };
        let (log_time, publish_time) = (message.log_time_ns, message.publish_time_ns);
        let header = MessageHeader { channel_id: channel, sequence: message.sequence, log_time, publish_time };
        self.with_storage(|storage| storage.write_to_known_channel(&header, &message.data))?;
        if let Some(reason) = &self.fault {
            return Err(BagError::Closed { reason: reason.clone() });
        }
        self.topics[id.0].written += 1;
        self.first_ns = Some(self.first_ns.map_or(log_time, |first| first.min(log_time)));
        self.last_ns = self.last_ns.max(log_time);
        Ok(())
    }

    /// Messages of a topic in the bag so far.
    #[must_use]
    pub fn written(&self, id: TopicId) -> u64 {
        self.topics.get(id.0).map_or(0, |t| t.written)
    }

    /// Hands everything written so far to the system as whole records: what a kill of this process cannot take back.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn flush(&mut self) -> Result<(), BagError> {
        if !self.is_dirty {
            return Ok(());
        }
        self.with_storage(mcap::Writer::flush)?;
        self.whole_bytes = self.level.written();
        self.is_dirty = false;
        Ok(())
    }

    /// [`BagWriter::flush`], then waits until the bytes are on the disk: what a power failure cannot take back.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn sync(&mut self) -> Result<(), BagError> {
        self.flush()?;
        self.file.sync_data().map_err(|e| BagError::io("sync", &self.path, e))
    }

    /// Closes the bag: the index and both metadata. `lost` is the number of messages that were received and are not in it.
    /// After a fault everything that reached the file whole stays readable.
    ///
    /// # Errors
    /// When the summary cannot be written; the bag then reads like that of a killed recording.
    pub fn close(mut self, outcome: Outcome, lost: u64) -> Result<BagMetadata, BagError> {
        self.custom_data.insert("camwright.lost_total".into(), lost.to_string());
        let outcome = if self.fault.is_some() { Outcome::Fault } else { outcome };
        self.custom_data.insert("camwright.outcome".into(), outcome.word().into());
        if let Some(reason) = &self.fault {
            self.custom_data.insert("camwright.fault".into(), reason.clone());
        }
        self.finish()
    }

    /// Closes a bag that is a copy of what another one holds, with what that said of itself.
    ///
    /// # Errors
    /// As [`BagWriter::close`].
    pub(super) fn close_as_copy(mut self, told: BTreeMap<String, String>) -> Result<BagMetadata, BagError> {
        self.custom_data.extend(told);
        self.custom_data.insert("camwright.outcome".into(), Outcome::Recovered.word().into());
        self.finish()
    }

    fn finish(mut self) -> Result<BagMetadata, BagError> {
        let finished = self.finish_storage();
        if let Err(error) = &finished {
            self.custom_data.insert("camwright.outcome".into(), Outcome::Fault.word().into());
            self.custom_data.entry("camwright.fault".into()).or_insert_with(|| error.to_string());
        }
        let metadata = self.metadata();
        metadata.write_to(&self.directory)?;
        finished.map(|()| metadata)
    }

    fn finish_storage(&mut self) -> Result<(), BagError> {
        let closing = self.metadata();
        self.write_metadata_record(&closing)?;
        let Some(mut storage) = self.storage.take() else {
            return Err(BagError::Closed { reason: "its file was given up".into() });
        };
        let finished = storage.finish();
        let buffer = storage.into_inner().into_inner();
        match finished {
            Ok(_) => {
                buffer.into_inner().map_err(|e| BagError::io("write", &self.path, e.into_error()))?;
                self.file.sync_all().map_err(|e| BagError::io("sync", &self.path, e))
            }
            Err(error) => {
                self.cut_torn_tail(buffer);
                Err(BagError::mcap(&self.path, error))
            }
        }
    }

    /// Drops what is half written after the last flush.
    fn cut_torn_tail(&mut self, buffer: BufWriter<SpareWriter<File, Spare>>) {
        // Without this, dropping the buffer would write its bytes after all.
        let (_, _) = buffer.into_parts();
        // A torn tail is only untidy: readers stop at it.
        drop(self.file.set_len(self.whole_bytes));
    }

    fn write_metadata_record(&mut self, metadata: &BagMetadata) -> Result<(), BagError> {
        let record = Metadata {
            name: RECORD_NAME.into(),
            metadata: BTreeMap::from([(RECORD_KEY.to_owned(), metadata.to_yaml())]),
        };
        self.with_storage(|storage| storage.write_metadata(&record))
    }

    fn metadata(&self) -> BagMetadata {
        let message_count = self.topics.iter().map(|t| t.written).sum();
        let starting_time_ns = self.first_ns.unwrap_or(NO_START_NS);
        let duration_ns = self.first_ns.map_or(0, |first| self.last_ns - first);
        BagMetadata {
            version: VERSION,
            storage_identifier: "mcap".into(),
            duration_ns,
            starting_time_ns,
            message_count,
            topics: self.topics.iter().map(|t| TopicEntry::new(&t.topic, t.written)).collect(),
            compression_format: String::new(),
            compression_mode: String::new(),
            relative_file_paths: vec![self.file_name.clone()],
            files: vec![FileEntry { path: self.file_name.clone(), starting_time_ns, duration_ns, message_count }],
            custom_data: self.custom_data.clone(),
            ros_distro: "jazzy".into(),
        }
    }

    fn with_storage<T>(&mut self, step: impl FnOnce(&mut Storage) -> mcap::McapResult<T>) -> Result<T, BagError> {
        let Some(storage) = &mut self.storage else {
            return Err(BagError::Closed { reason: self.fault.clone().unwrap_or_else(|| "it was closed".into()) });
        };
        self.is_dirty = true;
        match step(storage) {
            Ok(value) => {
                if self.fault.is_none()
                    && let Some(reason) = self.level.full()
                {
                    self.fault = Some(format!("no room for more in {}: {reason}", self.directory.display()));
                }
                Ok(value)
            }
            Err(error) => {
                let error = BagError::mcap(&self.path, error);
                self.fault.get_or_insert_with(|| error.to_string());
                if let Some(storage) = self.storage.take() {
                    let buffer = storage.into_inner().into_inner();
                    self.cut_torn_tail(buffer);
                }
                Err(error)
            }
        }
    }
}
