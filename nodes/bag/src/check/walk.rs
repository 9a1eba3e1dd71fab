// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The walk through every record of every file, in their order.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use mcap::McapError;
use mcap::records::{MessageHeader, Record, Statistics};

use super::layout;
use super::order::OrderCheck;
use super::report::BagReport;
use super::report::place_of;
use super::topics::{FileTopics, TopicCheck};
use crate::BagError;
use crate::metadata::{self, BagMetadata};
use crate::records::{Records, strict};

/// State of the walk through a bag.
#[derive(Default)]
pub(super) struct BagWalk {
    pub(super) report: BagReport,
    /// Messages of each topic, by name.
    pub(super) counts: BTreeMap<String, u64>,
    pub(super) topics: BTreeMap<String, TopicCheck>,
    pub(super) order: OrderCheck,
    /// The last metadata record of the last file.
    pub(super) record: Option<BagMetadata>,
    /// A file could not be read to its end.
    pub(super) is_damaged: bool,
    /// Content of each file, by name, in their order.
    pub(super) files: Vec<(String, FileCount)>,
    /// Messages that had been in an earlier file.
    pub(super) repeated: u64,
}

/// Messages of a file, and their log times (ns since 1970).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct FileCount {
    pub(super) messages: u64,
    pub(super) log_times_ns: Option<(u64, u64)>,
}

/// State of the current file.
#[derive(Default)]
pub(super) struct FileWalk {
    pub(super) topics: FileTopics,
    pub(super) count: FileCount,
    statistics: Option<Statistics>,
    metadata: Option<BagMetadata>,
    /// Metadata records of rosbag2 before the first message, and all of them.
    opening: u64,
    records: u64,
    /// Channels of no definition that messages name, and how many such messages there are.
    unknown: (BTreeSet<u16>, u64),
    chunk_indexes: u64,
}

impl BagWalk {
    pub(super) fn file(&mut self, path: &Path) {
        let place = place_of(path);
        let damaged_before = std::mem::take(&mut self.is_damaged);
        let mut file = FileWalk::default();
        match Records::open(path, strict()) {
            Ok(mut records) => self.records(&place, &mut file, &mut records),
            Err(error) => {
                self.is_damaged = true;
                self.report.error(&place, error.to_string());
            }
        }
        if !self.is_damaged && layout::check(&mut self.report, path, &place) {
            self.summary(&place, &file);
        }
        self.close(place, file);
        self.is_damaged |= damaged_before;
    }

    fn records(&mut self, place: &str, file: &mut FileWalk, records: &mut Records) {
        loop {
            match records.next() {
                Ok(Some(record)) => self.record(place, file, record),
                Ok(None) => break,
                Err(error) => {
                    self.is_damaged = true;
                    let reason = match &error {
                        BagError::Mcap { source: McapError::BytesAfterEndMagic, .. } => {
                            "there are bytes behind its end".into()
                        }
                        BagError::Mcap { source, .. } => crate::mcap_reason(source),
                        other => other.to_string(),
                    };
                    self.report.error(place, format!("not readable beyond this: {reason}"));
                    break;
                }
            }
        }
        if records.is_torn() {
            self.is_damaged = true;
            let text = "the file ends before its end: the recording was killed; what is whole in it can be read";
            self.report.error(place, text);
        }
    }

    fn record(&mut self, place: &str, file: &mut FileWalk, record: Record<'_>) {
        match record {
            Record::Header(header) if header.profile != "ros2" => {
                self.report.error(place, format!("profile '{}' is not ros2", header.profile));
            }
            Record::Schema { header, data } => file.topics.schema(&mut self.report, place, header, &data),
            Record::Channel(channel) => {
                if let Some(name) = file.topics.channel(&mut self.report, place, channel, &mut self.topics) {
                    self.counts.entry(name).or_insert(0);
                }
            }
            Record::Message { header, data } => self.message(place, file, &header, &data),
            Record::ChunkIndex(_) => file.chunk_indexes += 1,
            Record::Statistics(statistics) => file.statistics = Some(statistics),
            Record::Metadata(mut m) if m.name == metadata::RECORD_NAME => {
                file.records += 1;
                file.opening += u64::from(file.count.messages == 0);
                match m.metadata.remove(metadata::RECORD_KEY) {
                    Some(text) => match BagMetadata::parse_record(&text) {
                        Ok(metadata) => file.metadata = Some(metadata),
                        Err(reason) => self.report.error(place, format!("metadata record: {reason}")),
                    },
                    None => {
                        self.report.error(place, format!("the metadata record has no {}", metadata::RECORD_KEY));
                    }
                }
            }
            _ => {}
        }
    }

    fn message(&mut self, place: &str, file: &mut FileWalk, header: &MessageHeader, data: &[u8]) {
        self.report.message_count += 1;
        let t = header.log_time;
        file.count.messages += 1;
        file.count.log_times_ns = Some(file.count.log_times_ns.map_or((t, t), |(a, b)| (a.min(t), b.max(t))));
        let Some(topic) = file.topics.message(header.channel_id) else {
            file.unknown.0.insert(header.channel_id);
            file.unknown.1 += 1;
            return;
        };
        if let Some(count) = self.counts.get_mut(&topic) {
            *count += 1;
        }
        self.order.message(place, &topic, header);
        if let Some(check) = self.topics.get_mut(&topic) {
            self.repeated += u64::from(check.message(!self.files.is_empty(), header, data));
        }
    }

    /// Checks the end of a closed file.
    fn summary(&mut self, place: &str, file: &FileWalk) {
        let Some(declared) = &file.statistics else {
            return self.report.warning(place, "its summary has no statistics: viewers have to count first");
        };
        let count = file.count;
        let times = count.log_times_ns.unwrap_or((0, 0));
        let figures = [
            ("messages", declared.message_count, count.messages),
            ("channels", u64::from(declared.channel_count), file.topics.channels() as u64),
            ("types", u64::from(declared.schema_count), file.topics.schemas() as u64),
            ("ns as the first log time", declared.message_start_time, times.0),
            ("ns as the last log time", declared.message_end_time, times.1),
        ];
        // Writers that omit the chunk index still count their chunks; the layout check reports the missing index.
        let chunks = ("chunks in the index", u64::from(declared.chunk_count), file.chunk_indexes);
        let has_chunk_index = file.chunk_indexes > 0;
        for (what, declared, seen) in figures.into_iter().chain(has_chunk_index.then_some(chunks)) {
            if declared != seen {
                self.report.error(place, format!("statistics say {declared} {what}, the file has {seen}"));
            }
        }
        for (topic, declared, seen) in file.topics.counted_otherwise(declared) {
            self.report.error(place, format!("topic {topic}: statistics say {declared} messages, the file has {seen}"));
        }
    }

    fn close(&mut self, place: String, file: FileWalk) {
        let (channels, messages) = &file.unknown;
        if let Some(channel) = channels.first() {
            let text = format!("{messages} messages belong to {} unknown channels, first {channel}", channels.len());
            self.report.error(&place, text);
        }
        let is_whole_later_file = !self.files.is_empty() && !self.is_damaged;
        for (name, topic) in &mut self.topics {
            topic.close_file(&mut self.report, &place, name, is_whole_later_file);
        }
        if self.is_damaged {
            // A missing record is reported once.
        } else if file.metadata.is_none() {
            self.report.warning(&place, "there is no rosbag2 metadata record");
        } else if file.opening == 0 {
            let text =
                "no rosbag2 metadata record stands before the first message: of a killed recording none would be left";
            self.report.warning(&place, text);
        } else if file.records == 1 {
            self.report.warning(&place, "the rosbag2 metadata record of its end is missing");
        }
        self.record = file.metadata.or(self.record.take());
        self.files.push((place, file.count));
    }
}
