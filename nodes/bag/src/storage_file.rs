// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! One MCAP file of a bag while it is written.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;

use super::disk_reserve::{DiskLevel, DiskReserve, ReservedWriter, SPARE_BYTES};
use super::metadata::{BagMetadata, FileEntry, NO_START_NS, RECORD_KEY, RECORD_NAME};
use super::{BagError, Preset, Topic, qos};

/// Size of the write buffer (B); a flush empties it, so it adds nothing to the loss by a kill.
const BUFFER_BYTES: usize = 256 << 10;

type Storage = mcap::Writer<NoSeek<BufWriter<ReservedWriter<File, DiskReserve>>>>;

/// A topic within the file.
struct Channel {
    id: u16,
    messages: u64,
}

/// A file that takes messages until it is finished, or until the disk is full.
pub(super) struct StorageFile {
    path: PathBuf,
    name: String,
    storage: Option<Storage>,
    level: Arc<DiskLevel>,
    /// A second handle of the file, for `sync_data`.
    file: File,
    /// Length of the file at the last flush (B): everything before it is whole records.
    whole_bytes: u64,
    /// Channel of each topic, by the topic's number in the bag.
    channels: BTreeMap<usize, Channel>,
    messages: u64,
    log_times_ns: Option<(u64, u64)>,
    is_dirty: bool,
    fault: Option<String>,
}

impl StorageFile {
    /// Makes the file `name` in `directory`, and keeps back the room that closing it will take.
    pub(super) fn create(directory: &Path, name: String, preset: Preset) -> Result<Self, BagError> {
        let spare = DiskReserve::create(directory).map_err(|e| match e.kind() {
            std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded => {
                BagError::NoRoom { path: directory.to_owned(), needed: SPARE_BYTES as u64 }
            }
            _ => BagError::io("write into", directory, e),
        })?;
        let path = directory.join(&name);
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&path)
            .map_err(|e| BagError::io("create", &path, e))?;
        let second_handle = file.try_clone().map_err(|e| BagError::io("open", &path, e))?;
        let sink = ReservedWriter::new(file, spare);
        let level = sink.level();
        let sink = NoSeek::new(BufWriter::with_capacity(BUFFER_BYTES, sink));
        let storage = preset.write_options().create(sink).map_err(|e| BagError::mcap(&path, e))?;
        Ok(Self {
            path,
            name,
            storage: Some(storage),
            level,
            file: second_handle,
            whole_bytes: 0,
            channels: BTreeMap::new(),
            messages: 0,
            log_times_ns: None,
            is_dirty: true,
            fault: None,
        })
    }

    /// Its name within the bag's directory.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Its size on the disk at the last flush (B).
    pub(super) fn whole_bytes(&self) -> u64 {
        self.whole_bytes
    }

    /// Bytes that the system has taken so far; what is gathered for the next chunk is not among them.
    pub(super) fn bytes(&self) -> u64 {
        self.level.written()
    }

    pub(super) fn messages(&self) -> u64 {
        self.messages
    }

    /// Messages of the topic with this number in the bag.
    pub(super) fn count(&self, topic: usize) -> u64 {
        self.channels.get(&topic).map_or(0, |channel| channel.messages)
    }

    /// First and last log time in it (ns since 1970).
    pub(super) fn log_times_ns(&self) -> Option<(u64, u64)> {
        self.log_times_ns
    }

    /// Why it takes no more, when it does not.
    pub(super) fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }

    /// Entry of the file in `metadata.yaml`.
    pub(super) fn entry(&self) -> FileEntry {
        let (first, last) = self.log_times_ns.unwrap_or((NO_START_NS, NO_START_NS));
        FileEntry {
            path: self.name.clone(),
            starting_time_ns: first,
            duration_ns: last - first,
            message_count: self.messages,
        }
    }

    /// Defines the topic with this number in the bag.
    pub(super) fn add_topic(&mut self, index: usize, topic: &Topic) -> Result<(), BagError> {
        let id = self.with_storage(|storage| {
            let schema = storage.add_schema(&topic.type_name, "ros2msg", topic.definition.as_bytes())?;
            let channel_metadata = BTreeMap::from([
                ("offered_qos_profiles".to_owned(), qos::to_yaml(&topic.offered_qos, 0)),
                ("topic_type_hash".to_owned(), topic.type_hash.clone()),
            ]);
            storage.add_channel(schema, &topic.name, "cdr", &channel_metadata)
        })?;
        self.channels.insert(index, Channel { id, messages: 0 });
        Ok(())
    }

    /// Writes one message of a topic that was defined before.
    pub(super) fn write(
        &mut self,
        topic: usize,
        sequence: u32,
        log_time: u64,
        publish_time: u64,
        data: &[u8],
    ) -> Result<(), BagError> {
        let Some(&Channel { id: channel_id, .. }) = self.channels.get(&topic) else {
            return Err(BagError::Closed { reason: format!("it has no topic number {topic}") });
        };
        let header = MessageHeader { channel_id, sequence, log_time, publish_time };
        self.with_storage(|storage| storage.write_to_known_channel(&header, data))?;
        self.messages += 1;
        if let Some(channel) = self.channels.get_mut(&topic) {
            channel.messages += 1;
        }
        let times = self.log_times_ns.get_or_insert((log_time, log_time));
        *times = (times.0.min(log_time), times.1.max(log_time));
        Ok(())
    }

    /// Writes what is known of the bag.
    pub(super) fn write_metadata(&mut self, metadata: &BagMetadata) -> Result<(), BagError> {
        let record = Metadata {
            name: RECORD_NAME.into(),
            metadata: BTreeMap::from([(RECORD_KEY.to_owned(), metadata.to_yaml())]),
        };
        self.with_storage(|storage| storage.write_metadata(&record))
    }

    /// Hands everything written so far to the system as whole records.
    pub(super) fn flush(&mut self) -> Result<(), BagError> {
        if !self.is_dirty {
            return Ok(());
        }
        self.with_storage(mcap::Writer::flush)?;
        self.whole_bytes = self.level.written();
        self.is_dirty = false;
        Ok(())
    }

    /// Flushes, then waits until the bytes are on the disk.
    pub(super) fn sync(&mut self) -> Result<(), BagError> {
        self.flush()?;
        self.file.sync_data().map_err(|e| BagError::io("sync", &self.path, e))
    }

    /// Ends the file: what is known of the bag, the index, and all of it on the disk.
    pub(super) fn finish(&mut self, closing: &BagMetadata) -> Result<(), BagError> {
        self.write_metadata(closing)?;
        let Some(mut storage) = self.storage.take() else {
            return Err(BagError::Closed { reason: "its file was given up".into() });
        };
        let finished = storage.finish();
        let buffer = storage.into_inner().into_inner();
        match finished {
            Ok(_) => {
                buffer.into_inner().map_err(|e| BagError::io("write", &self.path, e.into_error()))?;
                self.file.sync_all().map_err(|e| BagError::io("sync", &self.path, e))?;
                self.whole_bytes = self.level.written();
                Ok(())
            }
            Err(error) => {
                self.cut_torn_tail(buffer);
                Err(BagError::mcap(&self.path, error))
            }
        }
    }

    /// Drops what is half written after the last flush.
    fn cut_torn_tail(&mut self, buffer: BufWriter<ReservedWriter<File, DiskReserve>>) {
        // Without this, dropping the buffer would write its bytes after all.
        let (_, _) = buffer.into_parts();
        // A torn tail is only untidy: readers stop at it.
        drop(self.file.set_len(self.whole_bytes));
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
                    let directory = self.path.parent().unwrap_or(&self.path).display();
                    self.fault = Some(format!("no room for more in {directory}: {reason}"));
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
