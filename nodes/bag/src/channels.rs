// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The files of a bag, and the schemas and channels in them, as topics.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs;
use std::path::{Component, Path, PathBuf};

use mcap::McapError;
use mcap::records::{MessageHeader, Record};

use super::metadata::{self, BagMetadata};
use super::{BagError, Topic, qos};

/// The storage files of a bag in order.
pub(super) fn storage_files(path: &Path) -> Result<Vec<PathBuf>, BagError> {
    let kind = fs::metadata(path).map_err(|e| BagError::io("open", path, e))?;
    if kind.is_file() {
        return Ok(vec![path.to_owned()]);
    }
    match BagMetadata::read_from(path) {
        Ok(metadata) => {
            if metadata.storage_identifier != "mcap" {
                let reason = format!("storage '{}' is not supported, only mcap is", metadata.storage_identifier);
                return Err(BagError::Metadata { path: path.join(metadata::FILE_NAME), reason });
            }
            let mut seen = BTreeSet::new();
            if let Some(file) = metadata.relative_file_paths.iter().find(|file| !is_of_bag(file) || !seen.insert(*file))
            {
                let reason = format!("file '{file}' is listed twice, or does not lie in the bag's directory");
                return Err(BagError::Metadata { path: path.join(metadata::FILE_NAME), reason });
            }
            Ok(metadata.relative_file_paths.iter().map(|p| path.join(p)).collect())
        }
        Err(BagError::NoMetadata { .. }) => files_in(path),
        Err(error) => Err(error),
    }
}

/// A file that a bag lists lies in the bag's directory.
pub(super) fn is_of_bag(file: &str) -> bool {
    Path::new(file).components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
}

/// The storage files that lie in a directory, whatever its metadata say.
pub(super) fn files_in(path: &Path) -> Result<Vec<PathBuf>, BagError> {
    let entries = fs::read_dir(path).map_err(|e| BagError::io("read", path, e))?;
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| entry.ok().map(|e| e.path()))
        .filter(|p| p.extension().is_some_and(|e| e == "mcap"))
        .collect();
    // `run_10.mcap` comes after `run_9.mcap`.
    files.sort_by_key(|p| (p.as_os_str().len(), p.clone()));
    if files.is_empty() { Err(BagError::NoMetadata { path: path.to_owned() }) } else { Ok(files) }
}

/// Topic of a channel.
pub(super) fn topic_of(
    path: &Path,
    name: &str,
    type_name: String,
    definition: String,
    channel: &BTreeMap<String, String>,
) -> Result<Topic, BagError> {
    let text = channel.get("offered_qos_profiles").map_or("", String::as_str);
    let offered_qos = qos::from_yaml(text)
        .map_err(|reason| BagError::Metadata { path: path.to_owned(), reason: format!("topic {name}: {reason}") })?;
    let type_hash = channel.get("topic_type_hash").cloned().unwrap_or_default();
    Ok(Topic { name: name.to_owned(), type_name, type_hash, definition, offered_qos })
}

/// Every topic has the text of its type, and thousands of topics can name one text: so much of it is held (B).
const DEFINITION_BYTES: usize = 256 << 20;

/// Remaining memory for definitions.
#[derive(Debug, Default)]
pub(super) struct DefinitionMemory(usize);

impl DefinitionMemory {
    pub(super) fn reserve(&mut self, path: &Path, bytes: usize) -> Result<(), BagError> {
        self.0 = self.0.saturating_add(bytes);
        if self.0 <= DEFINITION_BYTES {
            return Ok(());
        }
        let reason = format!("the definitions of its topics take {} bytes, {DEFINITION_BYTES} are allowed", self.0);
        Err(BagError::Metadata { path: path.to_owned(), reason })
    }
}

/// Schemas and channels as they come by in a file.
#[derive(Debug, Default)]
pub(super) struct Channels {
    room: DefinitionMemory,
    seen: BTreeSet<u16>,
    schemas: HashMap<u16, (String, String)>,
    /// The topic of each channel, by its place in the bag.
    pub(super) indexes: HashMap<u16, usize>,
}

impl Channels {
    /// Takes a schema or channel record in; returns the topic of a channel.
    pub(super) fn note(&mut self, path: &Path, record: Record<'_>) -> Result<Option<(u16, Topic)>, BagError> {
        match record {
            Record::Schema { header, data } => {
                self.schemas.insert(header.id, (header.name, String::from_utf8_lossy(&data).into()));
                Ok(None)
            }
            Record::Channel(channel) => {
                // Summaries repeat it, and some writers do in every chunk.
                if self.seen.insert(channel.id) {
                    self.room.reserve(path, self.schemas.get(&channel.schema_id).map_or(0, |(_, text)| text.len()))?;
                }
                let (type_name, definition) = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                Ok(Some((channel.id, topic_of(path, &channel.topic, type_name, definition, &channel.metadata)?)))
            }
            _ => Ok(None),
        }
    }

    pub(super) fn index(&self, path: &Path, header: &MessageHeader) -> Result<usize, BagError> {
        self.indexes
            .get(&header.channel_id)
            .copied()
            .ok_or_else(|| BagError::mcap(path, McapError::UnknownChannel(header.sequence, header.channel_id)))
    }
}
