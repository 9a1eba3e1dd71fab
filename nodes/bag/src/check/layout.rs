// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Check of a file's index against its content: chunks, messages within chunks, metadata, the sections of the file.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use mcap::records::{ChunkHeader, ChunkIndex, Footer, MessageIndex, Record, op};

use super::report::{BagReport, FindingCount};
use crate::BagError;
use crate::records::open_file;
use crate::salvage::walk_chunk;

/// Operation code and length of a record (B).
const HEAD: u64 = 9;
/// Magic bytes at the beginning and at the end (B).
const MAGIC: u64 = 8;

/// A chunk as it stands in the file.
struct ChunkExtent {
    /// Length of its record with its head (B).
    length: u64,
    header: ChunkHeader,
    /// Its first and last log time, where it has messages (ns since 1970).
    range_ns: Option<(u64, u64)>,
    /// Offset of the message index of each channel, and their total length (B).
    indexes: BTreeMap<u16, u64>,
    index_bytes: u64,
    /// The message indexes do not lead to its messages.
    is_misled: bool,
}

/// Log times and places of messages, by channel.
type Entries = BTreeMap<u16, Vec<(u64, u64)>>;

/// The chunk under way: its messages, and what the indexes behind it say of them.
#[derive(Default)]
struct LastChunk {
    at: Option<u64>,
    messages: Entries,
    indexed: Entries,
}

/// Kinds and offsets of the records of a file.
#[derive(Default)]
struct Layout {
    chunks: BTreeMap<u64, ChunkExtent>,
    /// Length and name of metadata records.
    metadata: BTreeMap<u64, (u64, String)>,
    /// Messages that stand outside of chunks.
    bare: u64,
    chunk_indexes: Vec<ChunkIndex>,
    metadata_indexes: Vec<(u64, u64, String)>,
    /// Groups of records of the summary: operation code, where they begin, how long they are.
    groups: BTreeMap<u64, (u8, u64)>,
    offsets: Vec<(u8, u64, u64)>,
    data_end: Option<u64>,
    first_offset: Option<u64>,
    footer: Option<(u64, Footer)>,
}

/// Looks at a file whose records can be read; returns whether it has a summary.
pub(super) fn check(report: &mut BagReport, path: &Path, place: &str) -> bool {
    let layout = match Layout::from_file(path) {
        Ok(layout) => layout,
        Err(reason) => {
            report.error(place, format!("index: {reason}"));
            return false;
        }
    };
    if layout.footer.as_ref().is_some_and(|(_, footer)| footer.summary_start == 0) {
        report.warning(place, "it has no summary: every reader has to walk through the whole file");
        return false;
    }
    layout.sections(report, place);
    layout.chunks(report, place);
    layout.message_indexes(report, place);
    layout.metadata(report, place);
    true
}

impl Layout {
    fn from_file(path: &Path) -> Result<Self, String> {
        let text_of = |error: BagError| error.to_string();
        let mut file = open_file(path).map_err(text_of)?;
        let end = file.metadata().map_err(|e| text_of(BagError::io("read", path, e)))?.len();
        let mut layout = Self::default();
        let (mut at, mut last) = (MAGIC, LastChunk::default());
        while at + HEAD <= end.saturating_sub(MAGIC) {
            let head = read(&mut file, at, HEAD).map_err(|e| text_of(BagError::io("read", path, e)))?;
            let length = head.get(1..9).and_then(|eight| eight.try_into().ok()).map_or(u64::MAX, u64::from_le_bytes);
            if length > end - at - HEAD {
                return Err(format!("the record at {at} is longer than the file"));
            }
            let body = read(&mut file, at + HEAD, length).map_err(|e| text_of(BagError::io("read", path, e)))?;
            layout.note(at, head[0], &body, &mut last).map_err(|reason| format!("{reason} at {at}"))?;
            at += HEAD + length;
        }
        layout.settle(&mut last);
        Ok(layout)
    }

    /// Takes the record at an offset. Index records belong to the chunk before them.
    fn note(&mut self, at: u64, opcode: u8, body: &[u8], last: &mut LastChunk) -> Result<(), String> {
        let length = HEAD + body.len() as u64;
        if opcode == op::CHUNK {
            self.settle(last);
            last.at = Some(at);
            self.chunks.insert(at, ChunkExtent::from_body(body, &mut last.messages)?);
            return Ok(());
        }
        if opcode == op::MESSAGE {
            self.bare += 1;
            return Ok(());
        }
        if self.data_end.is_some() && !matches!(opcode, op::FOOTER | op::SUMMARY_OFFSET) {
            let last = self.groups.last_entry().filter(|group| group.get().0 == opcode);
            match last {
                Some(mut group) => group.get_mut().1 += length,
                None => drop(self.groups.insert(at, (opcode, length))),
            }
        }
        match mcap::parse_record(opcode, body).map_err(|error| error.to_string())? {
            Record::MessageIndex(MessageIndex { channel_id, records }) => {
                let chunk = last.at.and_then(|at| self.chunks.get_mut(&at)).ok_or("an index of no chunk")?;
                chunk.index_bytes += length;
                chunk.indexes.insert(channel_id, at);
                last.indexed.entry(channel_id).or_default().extend(records.iter().map(|e| (e.log_time, e.offset)));
            }
            Record::Metadata(metadata) => drop(self.metadata.insert(at, (length, metadata.name))),
            Record::ChunkIndex(index) => self.chunk_indexes.push(index),
            Record::MetadataIndex(index) => self.metadata_indexes.push((index.offset, index.length, index.name)),
            Record::SummaryOffset(offset) => {
                self.first_offset.get_or_insert(at);
                self.offsets.push((offset.group_opcode, offset.group_start, offset.group_length));
            }
            Record::DataEnd(_) => self.data_end = Some(at + length),
            Record::Footer(footer) => self.footer = Some((at, footer)),
            _ => {}
        }
        Ok(())
    }

    /// Holds the messages of the last chunk against its indexes.
    fn settle(&mut self, last: &mut LastChunk) {
        let LastChunk { at, mut messages, mut indexed } = std::mem::take(last);
        let Some(chunk) = at.and_then(|at| self.chunks.get_mut(&at)) else { return };
        indexed.retain(|_, entries| !entries.is_empty());
        messages.values_mut().chain(indexed.values_mut()).for_each(|entries| entries.sort_unstable());
        chunk.is_misled = messages != indexed;
    }

    /// Checks the offsets of the summary in the footer, and the summary of its sections.
    fn sections(&self, report: &mut BagReport, place: &str) {
        let Some((footer_at, footer)) = &self.footer else { return report.error(place, "it has no footer") };
        if Some(footer.summary_start) != self.data_end {
            let (declared, seen) = (footer.summary_start, self.data_end.unwrap_or(0));
            report.error(place, format!("summary start in the footer is {declared}, the summary begins at {seen}"));
        }
        let seen = self.first_offset.unwrap_or(0);
        if footer.summary_offset_start != seen && footer.summary_offset_start != *footer_at {
            let declared = footer.summary_offset_start;
            report
                .error(place, format!("summary offset start in the footer is {declared}, the offsets begin at {seen}"));
        }
        let mut wrong = FindingCount::default();
        for (opcode, start, length) in &self.offsets {
            if self.groups.get(start) != Some(&(*opcode, *length)) {
                wrong.note(|| format!("{length} bytes of records {opcode:#04x} from {start} on"));
            }
        }
        if let Some(text) =
            wrong.sentence_for("offset of the summary leads nowhere", "offsets of the summary lead nowhere")
        {
            report.error(place, text);
        }
    }

    /// The index of chunks against the chunks.
    fn chunks(&self, report: &mut BagReport, place: &str) {
        if self.bare > 0 {
            let text = "messages stand outside of chunks (fastwrite): no index leads to them, players cannot seek or choose topics, \
                        Foxglove loads the whole file";
            report.warning(place, format!("{} {text}", self.bare));
        }
        let with_messages = self.chunks.values().filter(|chunk| chunk.range_ns.is_some()).count();
        if self.chunk_indexes.is_empty() && with_messages > 0 {
            return report.warning(place, "there is no index of chunks: players read it in file order and cannot seek");
        }
        let mut wrong = FindingCount::default();
        let mut starts = BTreeSet::new();
        for index in &self.chunk_indexes {
            let at = index.chunk_start_offset;
            let reason = match self.chunks.get(&at) {
                None => Some("no chunk begins there"),
                Some(_) if !starts.insert(at) => Some("it is in the index twice"),
                Some(chunk) => chunk.differs_from(index),
            };
            if let Some(reason) = reason {
                wrong.note(|| format!("that of offset {at}: {reason}"));
            }
        }
        if let Some(text) = wrong.sentence_for("index entry of a chunk is wrong", "index entries of chunks are wrong") {
            report.error(place, text);
        }
        let unindexed =
            self.chunks.iter().filter(|(at, chunk)| chunk.range_ns.is_some() && !starts.contains(at)).count();
        if unindexed > 0 {
            report
                .error(place, format!("{unindexed} of {with_messages} chunks are not in the index: readers skip them"));
        }
    }

    /// The indexes of messages behind chunks against the messages in them.
    fn message_indexes(&self, report: &mut BagReport, place: &str) {
        let filled = self.chunks.iter().filter(|(_, chunk)| chunk.range_ns.is_some());
        let (with, without): (Vec<_>, Vec<_>) = filled.partition(|(_, chunk)| !chunk.indexes.is_empty());
        if !without.is_empty() && with.is_empty() {
            let text =
                "its chunks have no message index: players read it in file order, and rosbags reads nothing of it";
            return report.error(place, text);
        }
        let mut wrong = FindingCount::default();
        for (at, _) in with.iter().chain(&without).filter(|(_, chunk)| chunk.is_misled) {
            wrong.note(|| format!("that of the chunk at {at}"));
        }
        let (one, many) = ("message index leads to other messages", "message indexes lead to other messages");
        if let Some(text) = wrong.sentence_for(one, many) {
            report.error(place, text);
        }
    }

    fn metadata(&self, report: &mut BagReport, place: &str) {
        let declared: BTreeMap<u64, (u64, String)> =
            self.metadata_indexes.iter().map(|(at, length, name)| (*at, (*length, name.clone()))).collect();
        if declared != self.metadata {
            let (declared, seen) = (declared.len(), self.metadata.len());
            let text =
                format!("the index of metadata ({declared} entries) does not lead to the {seen} metadata records");
            report.error(place, text);
        }
    }
}

impl ChunkExtent {
    /// Reads a chunk, and its messages into `messages`.
    fn from_body(body: &[u8], messages: &mut Entries) -> Result<Self, String> {
        let Ok(Record::Chunk { header, .. }) = mcap::parse_record(op::CHUNK, body) else {
            return Err("a chunk whose head cannot be read".into());
        };
        let mut at = 0;
        walk_chunk(body, |opcode, data| {
            if opcode == op::MESSAGE
                && let Ok(Record::Message { header, .. }) = mcap::parse_record(opcode, data)
            {
                messages.entry(header.channel_id).or_default().push((header.log_time, at));
            }
            at += HEAD + data.len() as u64;
            Ok(())
        })
        .map_err(|error| error.to_string())?;
        let times = messages.values().flatten().map(|(log_time, _)| *log_time);
        let range_ns = times.clone().min().zip(times.max());
        let length = HEAD + body.len() as u64;
        Ok(Self { length, header, range_ns, indexes: BTreeMap::new(), index_bytes: 0, is_misled: false })
    }

    /// Returns the field in which the index differs.
    fn differs_from(&self, index: &ChunkIndex) -> Option<&'static str> {
        let header = &self.header;
        let range = self.range_ns.unwrap_or((0, 0));
        if index.chunk_length != self.length {
            return Some("its length is another");
        }
        if (index.message_start_time, index.message_end_time) != range {
            return Some("its log times are others");
        }
        if index.compression != header.compression
            || (index.compressed_size, index.uncompressed_size) != (header.compressed_size, header.uncompressed_size)
        {
            return Some("its compression is another");
        }
        if index.message_index_length != self.index_bytes || index.message_index_offsets != self.indexes {
            return Some("its message indexes stand elsewhere");
        }
        if (header.message_start_time, header.message_end_time) != range {
            return Some("the head of the chunk has other log times than its messages");
        }
        None
    }
}

fn read(file: &mut File, at: u64, length: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = vec![0; usize::try_from(length).unwrap_or(usize::MAX)];
    file.seek(SeekFrom::Start(at))?;
    file.read_exact(&mut bytes)?;
    Ok(bytes)
}
