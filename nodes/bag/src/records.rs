// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The records of one MCAP file: its summary, and the walk from its beginning.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Take};
use std::path::{Path, PathBuf};

use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::sans_io::summary_reader::{SummaryReadEvent, SummaryReader, SummaryReaderOptions};
use mcap::{McapError, Summary};

use super::{BagError, metadata};

/// No record or chunk of a bag is larger than this (B); a damaged length is, and must not take all memory.
pub(super) const RECORD_LIMIT: usize = 256 << 20;
/// Size of one read (B).
const READ_BYTES: usize = 1 << 20;

/// Opens a file to be read. What is no file, a pipe for example, would wait for ever.
pub(super) fn open_file(path: &Path) -> Result<File, BagError> {
    let kind = std::fs::metadata(path).map_err(|e| BagError::io("open", path, e))?;
    if !kind.is_file() {
        return Err(BagError::io("open", path, std::io::Error::other("it is no file")));
    }
    File::open(path).map_err(|e| BagError::io("open", path, e))
}

/// The summary of a file; none when it was never closed, or its writer left it out.
pub(super) fn read_summary(path: &Path) -> Result<Option<Summary>, BagError> {
    let mut file = open_file(path)?;
    let mut reader =
        SummaryReader::new_with_options(SummaryReaderOptions::default().with_record_length_limit(RECORD_LIMIT));
    while let Some(event) = reader.next_event() {
        match event.map_err(|e| BagError::mcap(path, e))? {
            SummaryReadEvent::ReadRequest(need) => {
                let read = file.read(reader.insert(need.min(READ_BYTES))).map_err(|e| BagError::io("read", path, e))?;
                reader.notify_read(read);
            }
            SummaryReadEvent::SeekRequest(to) => {
                // A file shorter than a footer cannot be sought backwards in: it has none.
                let Ok(position) = file.seek(to) else { return Ok(None) };
                reader.notify_seeked(position);
            }
        }
    }
    Ok(reader.finish())
}

/// The text of the last `rosbag2` record that the summary points at.
pub(super) fn last_metadata_record(path: &Path, summary: &Summary) -> Result<Option<String>, BagError> {
    let Some(index) = summary.metadata_indexes.iter().rev().find(|i| i.name == metadata::RECORD_NAME) else {
        return Ok(None);
    };
    let file = open_file(path)?;
    let length = index.length.min(RECORD_LIMIT as u64);
    let mut bytes = Vec::new();
    let mut at = &file;
    at.seek(SeekFrom::Start(index.offset)).map_err(|e| BagError::io("read", path, e))?;
    at.take(length).read_to_end(&mut bytes).map_err(|e| BagError::io("read", path, e))?;
    // Behind the operation code and the length.
    let body = bytes.get(9..).ok_or_else(|| BagError::mcap(path, McapError::BadIndex))?;
    match parse_record(op::METADATA, body).map_err(|e| BagError::mcap(path, e))? {
        Record::Metadata(mut m) => Ok(m.metadata.remove(metadata::RECORD_KEY)),
        _ => Ok(None),
    }
}

/// Part of a record up to its last text.
enum RecordField {
    /// Numbers of this many bytes in total.
    Numbers(usize),
    /// A text behind its length of 4 bytes.
    Text,
}

/// Checks that the texts of a record fit into it. The parser allocates the length that a text claims before it reads the text.
fn check_texts(opcode: u8, body: &[u8]) -> Result<(), McapError> {
    use RecordField::{Numbers, Text};
    let fields: &[RecordField] = match opcode {
        op::HEADER => &[Text, Text],
        op::SCHEMA => &[Numbers(2), Text, Text],
        op::CHANNEL => &[Numbers(4), Text, Text],
        op::CHUNK => &[Numbers(28), Text],
        op::ATTACHMENT => &[Numbers(16), Text, Text],
        op::ATTACHMENT_INDEX => &[Numbers(40), Text, Text],
        op::METADATA => &[Text],
        op::METADATA_INDEX => &[Numbers(16), Text],
        _ => &[],
    };
    let mut rest = body;
    for field in fields {
        let length = match field {
            Numbers(length) => *length,
            Text => {
                let (length, behind) = rest.split_first_chunk().ok_or(McapError::UnexpectedEof)?;
                rest = behind;
                usize::try_from(u32::from_le_bytes(*length)).map_err(|_| McapError::UnexpectedEof)?
            }
        };
        rest = rest.get(length..).ok_or(McapError::UnexpectedEof)?;
    }
    Ok(())
}

/// Decodes one record.
///
/// # Errors
/// The record is damaged, or one of its texts is longer than the record.
pub(super) fn parse_record(opcode: u8, body: &[u8]) -> Result<Record<'_>, McapError> {
    check_texts(opcode, body)?;
    mcap::parse_record(opcode, body)
}

/// Reads on through a torn tail's end, checking each chunk before anything of it is used.
pub(super) fn tolerant() -> LinearReaderOptions {
    LinearReaderOptions::default().with_prevalidate_chunk_crcs(true).with_record_length_limit(RECORD_LIMIT)
}

/// Every check sum that the file has, and nothing behind its end.
pub(super) fn strict() -> LinearReaderOptions {
    tolerant()
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true)
        .with_check_finishes_after_end_magic(true)
}

/// The records of one file in file order, those in chunks too.
pub(super) struct Records {
    pub(super) path: PathBuf,
    file: Take<File>,
    reader: LinearReader,
    is_torn: bool,
}

impl Records {
    pub(super) fn open(path: &Path, options: LinearReaderOptions) -> Result<Self, BagError> {
        Self::open_first(u64::MAX, path, options)
    }

    /// The records in the first `bytes` of a file, which may be recorded on meanwhile.
    pub(super) fn open_first(bytes: u64, path: &Path, options: LinearReaderOptions) -> Result<Self, BagError> {
        let file = open_file(path)?.take(bytes);
        Ok(Self { path: path.to_owned(), file, reader: LinearReader::new_with_options(options), is_torn: false })
    }

    /// The file ended before its end: it was never closed.
    pub(super) fn is_torn(&self) -> bool {
        self.is_torn
    }

    pub(super) fn next(&mut self) -> Result<Option<Record<'static>>, BagError> {
        if self.is_torn {
            return Ok(None);
        }
        loop {
            let Some(event) = self.reader.next_event() else { return Ok(None) };
            match event {
                Ok(LinearReadEvent::ReadRequest(need)) => {
                    let space = self.reader.insert(need.clamp(1, READ_BYTES));
                    let read = self.file.read(space).map_err(|e| BagError::io("read", &self.path, e))?;
                    self.reader.notify_read(read);
                }
                Ok(LinearReadEvent::Record { data, opcode }) => {
                    let record = parse_record(opcode, data).map_err(|e| BagError::mcap(&self.path, e))?;
                    return Ok(Some(record.into_owned()));
                }
                Err(McapError::UnexpectedEof) => {
                    self.is_torn = true;
                    return Ok(None);
                }
                Err(error) => return Err(BagError::mcap(&self.path, error)),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Head of a chunk whose compression claims this many bytes.
    fn chunk_head(claimed: u32) -> Vec<u8> {
        let mut body = vec![0; 28];
        body.extend(claimed.to_le_bytes());
        body.extend(b"zstd");
        body.extend(0_u64.to_le_bytes());
        body
    }

    #[test]
    fn a_text_that_claims_more_than_its_record_is_refused_before_memory_is_taken() {
        assert!(matches!(check_texts(op::CHUNK, &chunk_head(1_612_245_650)), Err(McapError::UnexpectedEof)));
        assert!(matches!(parse_record(op::CHUNK, &chunk_head(1_612_245_650)), Err(McapError::UnexpectedEof)));
        assert!(matches!(parse_record(op::CHUNK, &chunk_head(4)), Ok(Record::Chunk { .. })));
    }
}
