// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Reading a bag: a directory, or one MCAP file; ours, and those of other ROS 2 recorders.

use std::collections::{BTreeMap, BTreeSet, HashMap, VecDeque};
use std::fs::{self, File};
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use mcap::records::{ChunkIndex, MessageHeader, Record, Statistics};
use mcap::sans_io::indexed_reader::{IndexedReadEvent, IndexedReader, IndexedReaderOptions};
use mcap::{McapError, Summary};

use super::channels::{Channels, DefinitionMemory, storage_files, topic_of};
use super::metadata::{self, BagMetadata, RECORDER_VERSION};
use super::records::{RECORD_LIMIT, Records, last_metadata_record, open_file, read_summary, tolerant};
use super::sequence_check::{Numbers, SequenceCheck};
use super::{BagError, Topic};

/// One message of a bag.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BagMessage {
    /// Which of [`Bag::topics`].
    pub topic: usize,
    /// Number within the topic, 0 where the recorder did not count.
    pub sequence: u32,
    /// When it was received (ns since 1970).
    pub log_time_ns: u64,
    /// When it was sent (ns since 1970).
    pub publish_time_ns: u64,
    /// CDR with its four leading bytes.
    pub data: Vec<u8>,
}

/// Content of one storage file.
#[derive(Debug, Clone)]
pub struct FileContent {
    pub path: PathBuf,
    /// Its size (B).
    pub bytes: u64,
    /// It was closed: summary and index are there.
    pub is_closed: bool,
    pub message_count: u64,
    /// Smallest and largest log time (ns since 1970).
    pub log_times_ns: Option<(u64, u64)>,
    summary: Option<Summary>,
}

/// A bag that can be read.
#[derive(Debug, Clone)]
pub struct Bag {
    path: PathBuf,
    files: Vec<FileContent>,
    topics: Vec<Topic>,
    /// Place of each topic in the list, by name.
    places: HashMap<String, usize>,
    counts: Vec<u64>,
    custom_data: BTreeMap<String, String>,
}

impl Bag {
    /// Opens a bag's directory or one MCAP file of it. A killed recording opens too: what is whole in it is there. A bag that is
    /// still recorded is read as it is now: what comes later is not in it, until it is opened again.
    ///
    /// # Errors
    /// When there is no bag, or its files cannot be understood.
    pub fn open(path: &Path) -> Result<Self, BagError> {
        let paths = storage_files(path)?;
        let mut bag = Self {
            path: path.to_owned(),
            files: Vec::new(),
            topics: Vec::new(),
            places: HashMap::new(),
            counts: Vec::new(),
            custom_data: BTreeMap::new(),
        };
        let mut record = None;
        for path in paths {
            record = bag.add_file(path)?.or(record);
        }
        // What the storage says of itself wins over the file beside it, which a kill leaves as it was at the beginning.
        if let Some(Ok(metadata)) = record.as_deref().map(BagMetadata::parse_record) {
            bag.custom_data = metadata.custom_data;
        }
        Ok(bag)
    }

    /// The path it was opened by.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its storage files, in order.
    #[must_use]
    pub fn files(&self) -> &[FileContent] {
        &self.files
    }

    /// Its topics, by first appearance.
    #[must_use]
    pub fn topics(&self) -> &[Topic] {
        &self.topics
    }

    /// Messages of each topic.
    #[must_use]
    pub fn message_counts(&self) -> &[u64] {
        &self.counts
    }

    /// Custom data of the recorder.
    #[must_use]
    pub fn custom_data(&self) -> &BTreeMap<String, String> {
        &self.custom_data
    }

    /// Smallest and largest log time (ns since 1970); none without messages.
    #[must_use]
    pub fn log_times_ns(&self) -> Option<(u64, u64)> {
        self.files.iter().filter_map(|f| f.log_times_ns).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// All messages, in order of log time within each file. Latched messages that stand at the head of a later file once more come
    /// once only.
    #[must_use]
    pub fn messages(&self) -> Messages<'_> {
        Messages { numbers: self.latched_numbers(), ..self.records() }
    }

    /// All messages of all files, repetitions too.
    pub(super) fn records(&self) -> Messages<'_> {
        let numbers = vec![None; self.topics.len()];
        Messages { bag: self, waiting: self.files.iter().collect(), source: None, from_ns: 0, numbers }
    }

    /// For each topic whose messages may come again: that none has come. Other recorders number in other ways, or not at all.
    fn latched_numbers(&self) -> Vec<Option<Numbers>> {
        let is_ours = self.custom_data.contains_key(RECORDER_VERSION);
        self.topics.iter().map(|topic| (is_ours && topic.is_latched()).then(Numbers::default)).collect()
    }

    /// The messages from a log time on (ns since 1970).
    #[must_use]
    pub fn messages_from(&self, log_time_ns: u64) -> Messages<'_> {
        Messages { from_ns: log_time_ns, ..self.messages() }
    }

    fn topic_index(&mut self, topic: Topic) -> usize {
        if let Some(&index) = self.places.get(&topic.name) {
            return index;
        }
        self.places.insert(topic.name.clone(), self.topics.len());
        self.topics.push(topic);
        self.counts.push(0);
        self.topics.len() - 1
    }

    /// Takes up one file; returns the text of its last metadata record.
    fn add_file(&mut self, path: PathBuf) -> Result<Option<String>, BagError> {
        let bytes = fs::metadata(&path).map_err(|e| BagError::io("read", &path, e))?.len();
        let summary = match read_summary(&path) {
            Ok(summary) => summary,
            // A file without its end has no summary either.
            Err(BagError::Mcap {
                source: McapError::BadMagic | McapError::BadFooter | McapError::UnexpectedEof,
                ..
            }) => None,
            Err(error) => return Err(error),
        };
        // A file has no more messages than bytes; what says otherwise is not believed in anything.
        let is_possible = |stats: &Statistics| {
            stats.message_count <= bytes && stats.channel_message_counts.values().all(|count| *count <= bytes)
        };
        if let Some(summary) = summary
            && let Some(stats) = summary.stats.clone().filter(is_possible)
        {
            let mut channels: Vec<_> = summary.channels.values().collect();
            channels.sort_by_key(|c| c.id);
            let mut room = DefinitionMemory::default();
            for channel in channels {
                room.reserve(&path, channel.schema.as_ref().map_or(0, |s| s.data.len()))?;
                let (type_name, definition) = channel.schema.as_ref().map_or((String::new(), String::new()), |s| {
                    (s.name.clone(), String::from_utf8_lossy(&s.data).into())
                });
                let index =
                    self.topic_index(topic_of(&path, &channel.topic, type_name, definition, &channel.metadata)?);
                let count = stats.channel_message_counts.get(&channel.id).copied().unwrap_or(0);
                self.counts[index] = self.counts[index].saturating_add(count);
            }
            let record = last_metadata_record(&path, &summary)?;
            let (first, last) = (stats.message_start_time, stats.message_end_time);
            self.files.push(FileContent {
                path,
                bytes,
                is_closed: true,
                message_count: stats.message_count,
                log_times_ns: (stats.message_count > 0).then_some((first.min(last), first.max(last))),
                summary: Some(summary),
            });
            return Ok(record);
        }
        self.scan_file(path, bytes)
    }

    /// Takes up a file without a summary by walking through it.
    fn scan_file(&mut self, path: PathBuf, bytes: u64) -> Result<Option<String>, BagError> {
        let mut records = Records::open_first(bytes, &path, tolerant())?;
        let mut channels = Channels::default();
        let mut file = FileContent {
            path: path.clone(),
            bytes,
            is_closed: false,
            message_count: 0,
            log_times_ns: None,
            summary: None,
        };
        let mut text = None;
        while let Some(record) = records.next()? {
            match record {
                Record::Message { header, .. } => {
                    let index = channels.index(&path, &header)?;
                    self.counts[index] += 1;
                    file.message_count += 1;
                    let t = header.log_time;
                    file.log_times_ns = Some(file.log_times_ns.map_or((t, t), |(a, b)| (a.min(t), b.max(t))));
                }
                Record::Metadata(mut m) if m.name == metadata::RECORD_NAME => {
                    text = m.metadata.remove(metadata::RECORD_KEY).or(text);
                }
                other => {
                    if let Some((id, topic)) = channels.note(&path, other)? {
                        let index = self.topic_index(topic);
                        channels.indexes.insert(id, index);
                    }
                }
            }
        }
        file.is_closed = !records.is_torn();
        self.files.push(file);
        Ok(text)
    }
}

/// The messages of a bag, one after the other.
pub struct Messages<'a> {
    bag: &'a Bag,
    waiting: VecDeque<&'a FileContent>,
    source: Option<MessageSource>,
    from_ns: u64,
    /// Sequence numbers of each topic whose messages may be repeated.
    numbers: Vec<Option<Numbers>>,
}

impl std::fmt::Debug for Messages<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Messages").field("bag", &self.bag.path).finish_non_exhaustive()
    }
}

enum MessageSource {
    Indexed { path: PathBuf, file: File, reader: Box<IndexedReader>, indexes: HashMap<u16, usize>, buffer: Vec<u8> },
    Linear { records: Box<Records>, channels: Channels },
}

impl Messages<'_> {
    /// The next message, or none after the last.
    ///
    /// # Errors
    /// When the file cannot be read or is damaged there.
    pub fn next_message(&mut self) -> Result<Option<BagMessage>, BagError> {
        loop {
            if self.source.is_none() {
                let Some(file) = self.waiting.pop_front() else { return Ok(None) };
                self.source = Some(self.open(file)?);
            }
            let message = match &mut self.source {
                Some(source) => source.next(&self.bag.places)?,
                None => None,
            };
            match message {
                Some(message) if message.log_time_ns >= self.from_ns && !self.is_repeated(&message) => {
                    return Ok(Some(message));
                }
                Some(_) => {}
                None => self.source = None,
            }
        }
    }

    /// Which of the bag's files the last message came from.
    pub fn file(&self) -> usize {
        let left = self.waiting.len() + usize::from(self.source.is_some());
        (self.bag.files.len() - left).min(self.bag.files.len().saturating_sub(1))
    }

    /// Returns whether the message was delivered before.
    fn is_repeated(&mut self, message: &BagMessage) -> bool {
        let Some(Some(numbers)) = self.numbers.get_mut(message.topic) else { return false };
        numbers.check(message.sequence) == SequenceCheck::Again
    }

    fn open(&self, content: &FileContent) -> Result<MessageSource, BagError> {
        let path = &content.path;
        // An index that leaves out messages (rosbag2's fastwrite, a salvaged file) is worse than none.
        let indexed = content.summary.as_ref().filter(|s| is_worth_reading_by(s));
        let Some(summary) = indexed else {
            return Ok(MessageSource::Linear {
                records: Box::new(Records::open_first(content.bytes, path, tolerant())?),
                channels: Channels::default(),
            });
        };
        let options = IndexedReaderOptions::new().starting_at(self.from_ns).with_record_length_limit(RECORD_LIMIT);
        let reader = IndexedReader::new_with_options(summary, options).map_err(|e| BagError::mcap(path, e))?;
        let indexes =
            summary.channels.values().filter_map(|c| self.bag.places.get(&c.topic).map(|i| (c.id, *i))).collect();
        let file = open_file(path)?;
        Ok(MessageSource::Indexed { path: path.clone(), file, reader: Box::new(reader), indexes, buffer: Vec::new() })
    }
}

/// Returns whether an index is complete (rosbag2's fastwrite and salvaged files omit messages), lists each chunk once, and needs no more memory than
/// a walk: chunks with overlapping times are held together.
fn is_worth_reading_by(summary: &Summary) -> bool {
    let chunks = &summary.chunk_indexes;
    let limit = RECORD_LIMIT as u64;
    let mut starts = BTreeSet::new();
    let is_sound = chunks.iter().all(|chunk| {
        (chunk.message_index_length > 0 || chunk.message_end_time == 0)
            && chunk.uncompressed_size <= limit
            && starts.insert(chunk.chunk_start_offset)
    });
    let all: u64 = chunks.iter().fold(0, |sum, chunk| sum.saturating_add(chunk.uncompressed_size));
    let follows = |pair: &[ChunkIndex]| pair[1].message_start_time >= pair[0].message_end_time;
    !chunks.is_empty() && is_sound && (all <= 4 * limit || chunks.windows(2).all(follows))
}

impl MessageSource {
    fn next(&mut self, places: &HashMap<String, usize>) -> Result<Option<BagMessage>, BagError> {
        match self {
            Self::Indexed { path, file, reader, indexes, buffer } => {
                while let Some(event) = reader.next_event() {
                    match event.map_err(|e| BagError::mcap(path, e))? {
                        IndexedReadEvent::ReadChunkRequest { offset, length } => {
                            let size = file.metadata().map_err(|e| BagError::io("read", path, e))?.len();
                            if offset.checked_add(length as u64).is_none_or(|end| end > size) {
                                return Err(BagError::mcap(path, McapError::BadIndex));
                            }
                            buffer.resize(length, 0);
                            file.seek(SeekFrom::Start(offset))
                                .and_then(|_| file.read_exact(buffer))
                                .map_err(|e| BagError::io("read", path, e))?;
                            reader.insert_chunk_record_data(offset, buffer).map_err(|e| BagError::mcap(path, e))?;
                        }
                        IndexedReadEvent::Message { header, data } => {
                            let topic = *indexes.get(&header.channel_id).ok_or_else(|| {
                                BagError::mcap(path, McapError::UnknownChannel(header.sequence, header.channel_id))
                            })?;
                            return Ok(Some(message(topic, &header, data.to_vec())));
                        }
                    }
                }
                Ok(None)
            }
            Self::Linear { records, channels } => {
                while let Some(record) = records.next()? {
                    match record {
                        Record::Message { header, data } => {
                            let topic = channels.index(&records.path, &header)?;
                            return Ok(Some(message(topic, &header, data.into_owned())));
                        }
                        other => {
                            let path = records.path.clone();
                            if let Some((id, topic)) = channels.note(&path, other)?
                                && let Some(&index) = places.get(&topic.name)
                            {
                                channels.indexes.insert(id, index);
                            }
                        }
                    }
                }
                Ok(None)
            }
        }
    }
}

fn message(topic: usize, header: &MessageHeader, data: Vec<u8>) -> BagMessage {
    BagMessage {
        topic,
        sequence: header.sequence,
        log_time_ns: header.log_time,
        publish_time_ns: header.publish_time,
        data,
    }
}
