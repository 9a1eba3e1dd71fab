// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Intact parts of a damaged MCAP file, from its beginning to its end: chunks with a correct check sum; everything between them is lost.
//!
//! ```text
//! record · record · chunk ✓ · chunk ✗ (reported with its index entry) · ??? … search … · chunk ✓ · torn tail
//! ```
//! Where lengths lead nowhere any more the next chunk is searched for, byte by byte; that it is one its check sum proves.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use mcap::McapError;
use mcap::records::{ChunkHeader, Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader};

use super::BagError;
use super::records::{RECORD_LIMIT, open_file, parse_record, tolerant};

/// Operation code and length of a record (B).
const HEAD: u64 = 9;
/// Magic bytes at the beginning and at the end.
const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// Size of a window in the search for a chunk (B).
const WINDOW: usize = 1 << 20;
/// The shortest chunk record: times, size, check sum, an empty word for the compression, and a length (B).
const MIN_CHUNK: u64 = 8 + 8 + 8 + 4 + 4 + 8;
/// The same with its head.
const MIN_RECORD: usize = 49;
/// Maximum number of passes over the bytes of a file: a file that looks like chunks everywhere would be read without end.
const LOOKS: u64 = 32;

/// Something of the file, in its order.
#[derive(Debug)]
pub(super) enum SalvagedPiece {
    /// Records: the content of a chunk that is whole, or one that stands by itself.
    Whole(Vec<Record<'static>>, Proof),
    /// Bytes of which nothing can be had.
    Lost(Loss),
}

/// Proof that records are unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Proof {
    CheckSum,
    None,
}

/// Bytes that are lost.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Loss {
    /// Offset and size.
    pub(super) offset: u64,
    pub(super) bytes: u64,
    /// Reason.
    pub(super) reason: String,
    /// Messages in them by channel, if the index behind a chunk lists them.
    pub(super) messages: BTreeMap<u16, u64>,
}

/// The walk through one file.
pub(super) struct Salvage {
    path: PathBuf,
    file: File,
    at: u64,
    length: u64,
    /// Bytes of what looked like chunks while one was searched for.
    looked: u64,
    /// The end of the data was met: the file was closed, and a summary follows.
    closed: bool,
}

impl Salvage {
    pub(super) fn open(path: &Path) -> Result<Self, BagError> {
        let io = |error| BagError::io("read", path, error);
        let mut file = open_file(path)?;
        let length = file.metadata().map_err(io)?.len();
        let mut magic = [0; MAGIC.len()];
        // Without its first bytes it may still have chunks.
        let begins_well = length >= MAGIC.len() as u64 && file.read_exact(&mut magic).is_ok() && magic == *MAGIC;
        let at = if begins_well { MAGIC.len() as u64 } else { 0 };
        Ok(Self { path: path.to_owned(), file, at, length, looked: 0, closed: false })
    }

    /// The end of the data was met.
    pub(super) fn is_closed(&self) -> bool {
        self.closed
    }

    /// The next piece, or none at the end.
    pub(super) fn next(&mut self) -> Result<Option<SalvagedPiece>, BagError> {
        while !self.closed && self.at < self.length {
            let begin = self.at;
            let Some((opcode, length)) = self.head(begin)? else {
                return self.search(begin, "the file ends within a record").map(Some);
            };
            if opcode == op::DATA_END {
                self.closed = true;
                break;
            }
            if !is_of_the_data(opcode) {
                return self.search(begin, &format!("operation code {opcode:#04x} is no record's")).map(Some);
            }
            let end = begin + HEAD + length;
            let body = self.read(begin + HEAD, length)?;
            let piece = match opcode {
                op::CHUNK => match chunk(&body) {
                    Ok(records) => Ok(Some(records)),
                    Err(reason) => Err(reason),
                },
                // A message index only repeats what is in the chunk before it.
                op::MESSAGE_INDEX => Ok(None),
                _ => match parse_record(opcode, &body) {
                    Ok(record) => Ok(Some(vec![record.into_owned()])),
                    Err(error) => Err(error.to_string()),
                },
            };
            self.at = end;
            match piece {
                Ok(Some(records)) => {
                    let proof = if opcode == op::CHUNK { Proof::CheckSum } else { Proof::None };
                    return Ok(Some(SalvagedPiece::Whole(records, proof)));
                }
                Ok(None) => {}
                Err(reason) if opcode == op::CHUNK && self.is_at_a_record()? => {
                    let messages = self.messages_by_index()?;
                    return Ok(Some(SalvagedPiece::Lost(Loss { offset: begin, bytes: end - begin, reason, messages })));
                }
                // Its length may be what is damaged.
                Err(reason) => return self.search(begin, &reason).map(Some),
            }
        }
        Ok(None)
    }

    /// Operation code and length of the record at an offset; none where its length does not fit into the file.
    fn head(&mut self, at: u64) -> Result<Option<(u8, u64)>, BagError> {
        if self.length - at < HEAD {
            return Ok(None);
        }
        let head = self.read(at, HEAD)?;
        let (opcode, length) = (head[0], u64_at(&head, 1));
        Ok((length <= self.length - at - HEAD && length <= RECORD_LIMIT as u64).then_some((opcode, length)))
    }

    fn is_at_a_record(&mut self) -> Result<bool, BagError> {
        if self.at == self.length {
            return Ok(true);
        }
        let at = self.at;
        Ok(self.head(at)?.is_some_and(|(opcode, _)| opcode == op::DATA_END || is_of_the_data(opcode)))
    }

    /// Messages of a chunk according to the indexes behind it.
    fn messages_by_index(&mut self) -> Result<BTreeMap<u16, u64>, BagError> {
        let mut messages = BTreeMap::new();
        while self.at < self.length {
            let at = self.at;
            let Some((op::MESSAGE_INDEX, length)) = self.head(at)? else { break };
            let body = self.read(at + HEAD, length)?;
            if let Ok(Record::MessageIndex(index)) = parse_record(op::MESSAGE_INDEX, &body) {
                *messages.entry(index.channel_id).or_insert(0) += index.records.len() as u64;
            }
            self.at = at + HEAD + length;
        }
        Ok(messages)
    }

    /// Goes on at the next chunk that is whole; what lies before it is lost.
    fn search(&mut self, begin: u64, reason: &str) -> Result<SalvagedPiece, BagError> {
        let mut from = begin + 1;
        self.at = self.length;
        'windows: while from + MIN_RECORD as u64 <= self.length {
            let window = self.read(from, (self.length - from).min((WINDOW + 64) as u64))?;
            for (index, bytes) in window.windows(MIN_RECORD).enumerate().take(WINDOW) {
                let length = u64_at(bytes, 1);
                let at = from + index as u64;
                if bytes[0] != op::CHUNK || length < MIN_CHUNK || length > self.length - at - HEAD {
                    continue;
                }
                if length > RECORD_LIMIT as u64 || self.looked > self.length.saturating_mul(LOOKS) {
                    continue;
                }
                self.looked += length;
                let body = self.read(at + HEAD, length)?;
                if chunk(&body).is_ok() {
                    self.at = at;
                    break 'windows;
                }
            }
            from += WINDOW as u64;
        }
        let (bytes, messages) = (self.at - begin, BTreeMap::new());
        Ok(SalvagedPiece::Lost(Loss { offset: begin, bytes, reason: reason.to_owned(), messages }))
    }

    fn read(&mut self, at: u64, length: u64) -> Result<Vec<u8>, BagError> {
        let mut bytes = vec![0; usize::try_from(length).unwrap_or(RECORD_LIMIT)];
        self.file
            .seek(SeekFrom::Start(at))
            .and_then(|_| self.file.read_exact(&mut bytes))
            .map_err(|e| BagError::io("read", &self.path, e))?;
        Ok(bytes)
    }
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    bytes.get(at..at + 8).and_then(|eight| eight.try_into().ok()).map_or(u64::MAX, u64::from_le_bytes)
}

/// Records that may stand before the end of the data.
fn is_of_the_data(opcode: u8) -> bool {
    matches!(
        opcode,
        op::HEADER
            | op::SCHEMA
            | op::CHANNEL
            | op::MESSAGE
            | op::CHUNK
            | op::MESSAGE_INDEX
            | op::ATTACHMENT
            | op::METADATA
    )
}

/// The records of a chunk, all of them or the reason why none can be trusted.
fn chunk(body: &[u8]) -> Result<Vec<Record<'static>>, String> {
    let Ok(Record::Chunk { header, data }) = parse_record(op::CHUNK, body) else {
        return Err("its head cannot be read".to_owned());
    };
    if header.compressed_size != data.len() as u64 || header.uncompressed_size > RECORD_LIMIT as u64 {
        return Err("its sizes do not fit".to_owned());
    }
    let ChunkHeader { message_start_time, message_end_time, uncompressed_crc, .. } = header;
    let records = records_of(body).map_err(|error| error.to_string())?;
    // A check sum of 0 is none: then the times of the messages have to be those of the head.
    let times = records.iter().filter_map(|record| match record {
        Record::Message { header, .. } => Some(header.log_time),
        _ => None,
    });
    let around = |range: Option<(u64, u64)>, t| Some(range.map_or((t, t), |(a, b): (u64, u64)| (a.min(t), b.max(t))));
    let range = times.fold(None, around);
    if uncompressed_crc == 0 && range.is_some_and(|range| range != (message_start_time, message_end_time)) {
        return Err("it has no check sum, and its times do not fit".to_owned());
    }
    Ok(records)
}

/// Unpacks a chunk, its check sum first: what it does not prove may have lengths that no memory holds.
fn records_of(body: &[u8]) -> Result<Vec<Record<'static>>, McapError> {
    let mut records = Vec::new();
    walk_chunk(body, |opcode, data| {
        records.push(parse_record(opcode, data)?.into_owned());
        Ok(())
    })?;
    Ok(records)
}

/// Unpacks a chunk after checking its check sum, and passes on operation code and content of each record.
pub(super) fn walk_chunk(
    body: &[u8],
    mut on_record: impl FnMut(u8, &[u8]) -> Result<(), McapError>,
) -> Result<(), McapError> {
    let mut record = vec![op::CHUNK];
    record.extend_from_slice(&(body.len() as u64).to_le_bytes());
    record.extend_from_slice(body);
    let mut left = record.as_slice();
    let mut reader = LinearReader::new_with_options(tolerant().with_skip_start_magic(true).with_skip_end_magic(true));
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(need) => {
                let (now, later) = left.split_at(need.min(left.len()));
                reader.insert(now.len()).copy_from_slice(now);
                reader.notify_read(now.len());
                left = later;
            }
            LinearReadEvent::Record { data, opcode } => on_record(opcode, data)?,
        }
    }
    Ok(())
}
