// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A new bag of what is whole in one that was not closed, or is damaged; and what is lost.
//!
//! Only chunks with a correct check sum are recovered; messages outside of chunks (preset `fastwrite`) have none, which is reported. The
//! damaged bag is not changed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use mcap::records::Record;

use super::channels::{Channels, DefinitionMemory, files_in, storage_files, topic_of};
use super::json::quoted;
use super::metadata::{self, BagMetadata};
use super::records::read_summary;
use super::salvage::{Loss, Proof, Salvage, SalvagedPiece};
use super::sequence_check::{Numbers, SequenceCheck};
use super::writer::REPEATED;
use super::{BagError, BagMessage, BagWriter, Topic, TopicId, WriterOptions};

/// Result of a recovery.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Recovery {
    pub into: PathBuf,
    pub message_count: u64,
    pub topic_count: usize,
    /// Losses, in the order of the files.
    pub losses: Vec<Lost>,
    /// Messages that are missing by the numbers of their topics.
    pub missing: BTreeMap<String, u64>,
    /// Messages that no check sum proves.
    pub unproved: u64,
    /// A file has no end: it was never closed, so what had not reached it is lost too.
    pub was_open: bool,
}

/// Bytes of a file that are lost.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lost {
    /// Name of the file.
    pub file: String,
    /// Offset (B).
    pub offset: u64,
    /// Size (B).
    pub bytes: u64,
    /// Reason.
    pub reason: String,
    /// Lost messages by topic, as far as an index lists them.
    pub messages: BTreeMap<String, u64>,
}

impl Recovery {
    /// Returns whether the bag was intact.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.losses.is_empty() && self.missing.is_empty() && !self.was_open
    }

    #[must_use]
    pub fn to_text(&self) -> String {
        let verdict = if self.is_whole() { "NOTHING LOST" } else { "INCOMPLETE" };
        let (messages, topics) = (self.message_count, self.topic_count);
        let mut text = format!("{verdict}: {messages} messages on {topics} topics\n");
        for lost in &self.losses {
            let messages: Vec<String> = lost.messages.iter().map(|(topic, n)| format!("{n} of {topic}")).collect();
            let messages =
                if messages.is_empty() { String::new() } else { format!("; messages: {}", messages.join(", ")) };
            let Lost { file, offset, bytes, reason, .. } = lost;
            text.push_str(&format!("lost: {file}, {bytes} bytes after offset {offset}: {reason}{messages}\n"));
        }
        for (topic, count) in &self.missing {
            text.push_str(&format!("missing sequence numbers: {count} of {topic}\n"));
        }
        if self.unproved > 0 {
            text.push_str(&format!("{} messages are outside of chunks and have no check sum\n", self.unproved));
        }
        if self.was_open {
            text.push_str("the bag was never closed: messages that were not flushed are lost\n");
        }
        text.push_str(&format!("bag: {}\n", self.into.display()));
        text
    }

    /// For scripts: one JSON object.
    #[must_use]
    pub fn to_json(&self) -> String {
        let counts = |counts: &BTreeMap<String, u64>| {
            let counts: Vec<String> = counts.iter().map(|(topic, n)| format!("{}:{n}", quoted(topic))).collect();
            format!("{{{}}}", counts.join(","))
        };
        let losses: Vec<String> = self
            .losses
            .iter()
            .map(|lost| {
                format!(
                    "{{\"file\":{},\"offset\":{},\"bytes\":{},\"reason\":{},\"messages\":{}}}",
                    quoted(&lost.file),
                    lost.offset,
                    lost.bytes,
                    quoted(&lost.reason),
                    counts(&lost.messages)
                )
            })
            .collect();
        format!(
            "{{\"into\":{},\"message_count\":{},\"topic_count\":{},\"unproved\":{},\"was_open\":{},\"missing\":{},\"losses\":[{}]}}",
            quoted(&self.into.display().to_string()),
            self.message_count,
            self.topic_count,
            self.unproved,
            self.was_open,
            counts(&self.missing),
            losses.join(",")
        )
    }
}

/// Default path of the new bag: beside the damaged one.
#[must_use]
pub fn beside(path: &Path) -> PathBuf {
    super::named_beside(path, "recovered")
}

/// Makes a new bag of what is whole in the bag at `path`: a directory, or one MCAP file.
///
/// # Errors
/// There is no bag, the new one exists already or cannot be written; then no new bag is left.
pub fn recover(path: &Path, into: &Path) -> Result<Recovery, BagError> {
    let files = match storage_files(path) {
        // The storage is what counts.
        Err(BagError::Metadata { .. }) => files_in(path)?,
        other => other?,
    };
    let mut rescue = BagRebuild::new(into)?;
    let outcome = files.iter().try_for_each(|file| rescue.file(file));
    if let Err(error) = outcome {
        // Ours, made a moment ago, and nothing that anybody should take for a bag.
        drop(rescue);
        drop(std::fs::remove_dir_all(into));
        return Err(error);
    }
    rescue.close()
}

/// The topics of one file, by channel.
#[derive(Default)]
struct ChannelTopics {
    known: BTreeMap<u16, (String, TopicId)>,
    repeated: BTreeMap<u16, Topic>,
}

impl ChannelTopics {
    fn find(&mut self, channel: u16, writer: &mut BagWriter) -> Result<Option<(String, TopicId)>, BagError> {
        if let Some(topic) = self.repeated.get(&channel).filter(|_| !self.known.contains_key(&channel)) {
            let id = writer.add_topic(topic)?;
            self.known.insert(channel, (topic.name.clone(), id));
        }
        Ok(self.known.get(&channel).cloned())
    }

    fn name(&self, channel: u16) -> String {
        let known = self.known.get(&channel).map(|(name, _)| name);
        let name = known.or_else(|| self.repeated.get(&channel).map(|topic| &topic.name));
        name.cloned().unwrap_or_else(|| format!("channel {channel}"))
    }
}

struct BagRebuild {
    writer: BagWriter,
    recovery: Recovery,
    numbers: BTreeMap<usize, Numbers>,
    custom_data: BTreeMap<String, String>,
}

impl BagRebuild {
    fn new(into: &Path) -> Result<Self, BagError> {
        let writer = BagWriter::create(into, &WriterOptions::default())?;
        let recovery = Recovery { into: into.to_owned(), ..Recovery::default() };
        Ok(Self { writer, recovery, numbers: BTreeMap::new(), custom_data: BTreeMap::new() })
    }

    fn file(&mut self, path: &Path) -> Result<(), BagError> {
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let mut salvage = Salvage::open(path)?;
        let mut channels = Channels::default();
        let mut topics = ChannelTopics::default();
        // Where a chunk is lost that defines a topic, the summary of a file that was closed still knows it.
        if let Ok(Some(summary)) = read_summary(path) {
            let mut room = DefinitionMemory::default();
            for channel in summary.channels.values() {
                let schema = channel.schema.as_ref();
                if room.reserve(path, schema.map_or(0, |s| s.data.len())).is_err() {
                    break;
                }
                let (name, text) =
                    schema.map_or_else(Default::default, |s| (s.name.clone(), String::from_utf8_lossy(&s.data).into()));
                // No check sum is looked at here; what cannot be read is not known.
                if let Ok(topic) = topic_of(path, &channel.topic, name, text, &channel.metadata) {
                    topics.repeated.insert(channel.id, topic);
                }
            }
        }
        while let Some(piece) = salvage.next()? {
            match piece {
                SalvagedPiece::Whole(records, proof) => {
                    let unproved =
                        records.iter().filter(|r| proof == Proof::None && matches!(r, Record::Message { .. }));
                    self.recovery.unproved += unproved.count() as u64;
                    for record in records {
                        self.record(path, record, &mut channels, &mut topics)?;
                    }
                }
                SalvagedPiece::Lost(Loss { offset, bytes, reason, messages }) => {
                    let messages = messages.into_iter().map(|(id, count)| (topics.name(id), count)).collect();
                    self.recovery.losses.push(Lost { file: name.clone(), offset, bytes, reason, messages });
                }
            }
        }
        self.recovery.was_open |= !salvage.is_closed();
        Ok(())
    }

    fn record(
        &mut self,
        path: &Path,
        record: Record<'static>,
        channels: &mut Channels,
        topics: &mut ChannelTopics,
    ) -> Result<(), BagError> {
        match record {
            Record::Message { header, data } => {
                // Its channel was in a chunk that is lost: the type of the message is unknown.
                let Some((name, id)) = topics.find(header.channel_id, &mut self.writer)? else {
                    *self.recovery.missing.entry(topics.name(header.channel_id)).or_insert(0) += 1;
                    return Ok(());
                };
                if !self.is_first(id, name, header.sequence) {
                    return Ok(());
                }
                let message = BagMessage {
                    topic: id.index(),
                    sequence: header.sequence,
                    log_time_ns: header.log_time,
                    publish_time_ns: header.publish_time,
                    data: data.into_owned(),
                };
                self.writer.copy(id, &message)?;
                self.recovery.message_count += 1;
            }
            Record::Metadata(mut m) if m.name == metadata::RECORD_NAME => {
                let text = m.metadata.remove(metadata::RECORD_KEY);
                if let Some(Ok(recorded)) = text.as_deref().map(BagMetadata::parse_record) {
                    self.custom_data = recorded.custom_data;
                }
            }
            other => match channels.note(path, other) {
                Ok(Some((id, topic))) => {
                    let made = self.writer.add_topic(&topic)?;
                    topics.known.insert(id, (topic.name, made));
                }
                Ok(None) => {}
                // A topic that stands outside of chunks, where nothing proves it; its messages are counted as missing.
                Err(error) => {
                    let file = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
                    let lost = Lost { file, offset: 0, bytes: 0, reason: error.to_string(), messages: BTreeMap::new() };
                    self.recovery.losses.push(lost);
                }
            },
        }
        Ok(())
    }

    /// Counts what is missing by its number. Not first is what an earlier file had already: the new bag is one file.
    fn is_first(&mut self, id: TopicId, topic: String, number: u32) -> bool {
        let missing = self.recovery.missing.entry(topic);
        match self.numbers.entry(id.index()).or_default().check(number) {
            SequenceCheck::New(0) => true,
            SequenceCheck::New(count) => {
                *missing.or_insert(0) += u64::from(count);
                true
            }
            // Lost where it stood first, and found where it is repeated.
            SequenceCheck::Missed => {
                *missing.or_insert(1) -= 1;
                true
            }
            SequenceCheck::Again => false,
        }
    }

    fn close(mut self) -> Result<Recovery, BagError> {
        self.custom_data.remove(REPEATED);
        self.recovery.missing.retain(|_, count| *count > 0);
        self.custom_data.insert("camwright.recovered".into(), self.recovery.to_json());
        let metadata = self.writer.close_as_recovered(self.custom_data)?;
        self.recovery.topic_count = metadata.topics.len();
        Ok(self.recovery)
    }
}
