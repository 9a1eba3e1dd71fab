// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A bag that can be made wrong in one way: all that a recorder would write, open to be changed before it is written.

#![allow(missing_debug_implementations, reason = "as above")]
#![allow(unreachable_pub, reason = "a module of a test binary has no outside")]

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;
use std::rc::Rc;

use camwright_bag::metadata::{BagMetadata, FileEntry, NO_START_NS, RECORD_KEY, RECORD_NAME, TopicEntry, VERSION};
use camwright_bag::qos::{self, Durability, QosProfile, Reliability};
use camwright_msgs::camwright_msgs::msg::{MachineInput, RecorderStatus};
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_msgs::std_msgs::msg::String as Text;
use mcap::records::{MessageHeader, Metadata, op};

/// Log time of the first message (ns since 1970).
pub const START_NS: u64 = 1_760_000_000_000_000_000;
/// Topics of a draft, by their place.
pub const JOINTS: usize = 0;
pub const PAGES: usize = 1;
pub const INPUTS: usize = 2;
pub const STATUS: usize = 3;

#[derive(Clone)]
pub struct DraftTopic {
    pub name: String,
    pub type_name: String,
    pub encoding: String,
    pub text: Rc<str>,
    pub message_encoding: String,
    pub metadata: BTreeMap<String, String>,
    profile: QosProfile,
}

#[derive(Clone)]
pub struct DraftMessage {
    pub topic: usize,
    pub sequence: u32,
    pub log_time_ns: u64,
    pub data: Vec<u8>,
}

pub struct Draft {
    pub profile: String,
    pub topics: Vec<DraftTopic>,
    /// Messages of each file.
    pub files: Vec<Vec<DraftMessage>>,
    pub options: fn(mcap::WriteOptions) -> mcap::WriteOptions,
    /// Metadata records at the beginning and at the end.
    pub opening: bool,
    pub closing: bool,
    pub custom_data: BTreeMap<String, String>,
    /// Change of `metadata.yaml` before it is written, and of its text.
    pub account: fn(&mut BagMetadata),
    pub yaml: fn(String) -> String,
    /// Change of the last file's bytes.
    pub patch: fn(&mut Vec<u8>),
    /// Change of the bag's directory at the end.
    pub directory: fn(&Path),
}

fn topic<T: camwright_msgs::Message>(name: &str, durability: Durability) -> DraftTopic {
    let profile = QosProfile::discovered(Reliability::Reliable, durability);
    let metadata = [
        ("offered_qos_profiles", qos::to_yaml(std::slice::from_ref(&profile), 0)),
        ("topic_type_hash", T::TYPE_HASH.into()),
    ];
    DraftTopic {
        name: name.into(),
        type_name: T::TYPE_NAME.into(),
        encoding: "ros2msg".into(),
        text: T::SCHEMA.into(),
        message_encoding: "cdr".into(),
        metadata: metadata.map(|(key, value)| (key.to_owned(), value)).into(),
        profile,
    }
}

pub fn cdr<T: camwright_msgs::Message>(message: &T) -> Vec<u8> {
    let body = cdr_encoding::to_vec::<_, byteorder::LittleEndian>(message).expect("a message can be written");
    let mut data = [&[0, 1, 0, 0][..], &body].concat();
    data.resize(data.len().next_multiple_of(4), 0);
    data
}

impl DraftTopic {
    /// The same topic under another name.
    pub fn named(&self, name: &str) -> Self {
        Self { name: name.into(), ..self.clone() }
    }
}

impl Draft {
    /// A clean bag of one file: 60 joint states, three latched pages, six inputs, and what the recorder says at the end.
    pub fn good() -> Self {
        let mut messages = Vec::new();
        let mut numbers = [0_u32; 4];
        let mut add = |topic: usize, data: Vec<u8>| {
            numbers[topic] += 1;
            let log_time_ns = START_NS + 1_000_000 * (messages.len() as u64);
            messages.push(DraftMessage { topic, sequence: numbers[topic], log_time_ns, data });
        };
        for tick in 0..60_u32 {
            let joints = JointState {
                name: vec!["c_axis".into(), "x_axis".into()],
                position: vec![f64::from(tick), 0.125],
                ..JointState::default()
            };
            add(JOINTS, cdr(&joints));
            if tick % 20 == 0 {
                add(PAGES, cdr(&Text { data: format!("page {}", tick / 20) }));
            }
            if tick % 10 == 0 {
                let (tick, sequence) = (u64::from(tick), u64::from(tick / 10));
                add(
                    INPUTS,
                    cdr(&MachineInput { tick, sequence, kind: MachineInput::COMMAND, ..MachineInput::default() }),
                );
            }
        }
        let (bag, written) = ("bags/run".into(), 69);
        add(STATUS, cdr(&RecorderStatus { recording: true, bag, written, ..RecorderStatus::default() }));
        let custom_data =
            [("camwright.version", "0.1.0"), ("camwright.outcome", "complete"), ("camwright.lost_total", "0")];
        Self {
            profile: "ros2".into(),
            topics: vec![
                topic::<JointState>("/joint_states", Durability::Volatile),
                topic::<Text>("/plan_pages", Durability::TransientLocal),
                topic::<MachineInput>("/machine/inputs", Durability::Volatile),
                topic::<RecorderStatus>("/run_logger/status", Durability::Volatile),
            ],
            files: vec![messages],
            options: |options| options,
            opening: true,
            closing: true,
            custom_data: custom_data.map(|(key, value)| (key.to_owned(), value.to_owned())).into(),
            account: |_| {},
            yaml: |text| text,
            patch: |_| {},
            directory: |_| {},
        }
    }

    /// The same in two files, of which the second begins with the latched pages so far.
    pub fn in_two_files() -> Self {
        let mut draft = Self::good();
        let second = draft.files[0].split_off(35);
        let last_ns = draft.files[0].last().map_or(0, |last| last.log_time_ns);
        let latched = draft.files[0].iter().filter(|message| message.topic == PAGES).cloned();
        let head = (1..).zip(latched).map(|(place, page)| DraftMessage { log_time_ns: last_ns + place, ..page });
        let head: Vec<DraftMessage> = head.collect();
        draft.custom_data.insert("camwright.repeated_total".into(), head.len().to_string());
        draft.files.push(head.into_iter().chain(second).collect());
        draft
    }

    /// The messages of the only file.
    pub fn messages(&mut self) -> &mut Vec<DraftMessage> {
        &mut self.files[0]
    }

    /// The first message of a topic.
    pub fn first(&mut self, topic: usize) -> &mut DraftMessage {
        self.messages().iter_mut().find(|message| message.topic == topic).expect("every topic has some")
    }

    pub fn count(&self) -> usize {
        self.files.iter().map(Vec::len).sum()
    }

    /// Writes the bag `run` into a directory.
    pub fn write(&self, directory: &Path) {
        let bag = directory.join("run");
        std::fs::create_dir_all(&bag).expect("the directory is ours");
        let mut metadata = self.metadata();
        for (number, messages) in self.files.iter().enumerate() {
            let mut bytes = self.file(messages, &metadata);
            if number + 1 == self.files.len() {
                (self.patch)(&mut bytes);
            }
            std::fs::write(bag.join(format!("run_{number}.mcap")), bytes).expect("the directory is ours");
        }
        (self.account)(&mut metadata);
        let text = (self.yaml)(metadata.to_file_text());
        std::fs::write(bag.join("metadata.yaml"), text).expect("the directory is ours");
        (self.directory)(&bag);
    }

    fn metadata(&self) -> BagMetadata {
        let entry = |(number, messages): (usize, &Vec<DraftMessage>)| {
            let times = messages.iter().map(|message| message.log_time_ns);
            let first = times.clone().min().unwrap_or(NO_START_NS);
            FileEntry {
                path: format!("run_{number}.mcap"),
                starting_time_ns: first,
                duration_ns: times.max().map_or(0, |last| last - first),
                message_count: messages.len() as u64,
            }
        };
        let files: Vec<FileEntry> = self.files.iter().enumerate().map(entry).collect();
        let topics = self.topics.iter().enumerate().map(|(index, topic)| TopicEntry {
            name: topic.name.clone(),
            type_name: topic.type_name.clone(),
            type_hash: topic.metadata.get("topic_type_hash").cloned().unwrap_or_default(),
            offered_qos: vec![topic.profile.clone()],
            message_count: self.files.iter().flatten().filter(|message| message.topic == index).count() as u64,
        });
        // Two channels of a topic are one topic.
        let mut listed: Vec<TopicEntry> = Vec::new();
        for entry in topics {
            match listed.iter_mut().find(|other| other.name == entry.name) {
                Some(other) => other.message_count += entry.message_count,
                None => listed.push(entry),
            }
        }
        let first = files.iter().map(|file| file.starting_time_ns).min().unwrap_or(NO_START_NS);
        let last = files.iter().map(|file| file.starting_time_ns + file.duration_ns).max().unwrap_or(first);
        BagMetadata {
            version: VERSION,
            storage_identifier: "mcap".into(),
            duration_ns: last - first,
            starting_time_ns: first,
            message_count: self.count() as u64,
            topics: listed,
            compression_format: String::new(),
            compression_mode: String::new(),
            relative_file_paths: files.iter().map(|file| file.path.clone()).collect(),
            files,
            custom_data: self.custom_data.clone(),
            ros_distro: "jazzy".into(),
        }
    }

    fn file(&self, messages: &[DraftMessage], metadata: &BagMetadata) -> Vec<u8> {
        let options = mcap::WriteOptions::new()
            .profile(self.profile.clone())
            .library("draft")
            .compression(None)
            .compression_threads(0)
            .chunk_size(Some(1 << 20))
            .calculate_chunk_crcs(true)
            .calculate_data_section_crc(true)
            .calculate_summary_section_crc(true);
        let mut writer = (self.options)(options).create(Cursor::new(Vec::new())).expect("memory takes it");
        let record = |text: String| Metadata {
            name: RECORD_NAME.into(),
            metadata: BTreeMap::from([(RECORD_KEY.to_owned(), text)]),
        };
        if self.opening {
            writer.write_metadata(&record(metadata.to_yaml())).expect("memory takes it");
        }
        let channels: Vec<u16> = self
            .topics
            .iter()
            .map(|topic| {
                let schema =
                    writer.add_schema(&topic.type_name, &topic.encoding, topic.text.as_bytes()).expect("there is room");
                writer
                    .add_channel(schema, &topic.name, &topic.message_encoding, &topic.metadata)
                    .expect("there is room")
            })
            .collect();
        for (index, message) in messages.iter().enumerate() {
            let header = MessageHeader {
                channel_id: channels[message.topic],
                sequence: message.sequence,
                log_time: message.log_time_ns,
                publish_time: message.log_time_ns,
            };
            writer.write_to_known_channel(&header, &message.data).expect("memory takes it");
            if index % 20 == 19 {
                writer.flush().expect("memory takes it");
            }
        }
        if self.closing {
            writer.write_metadata(&record(metadata.to_yaml())).expect("memory takes it");
        }
        writer.finish().expect("memory takes it");
        writer.into_inner().into_inner()
    }
}

/// Without any check sum, so that what is patched is wrong in nothing else.
pub fn without_crc(options: mcap::WriteOptions) -> mcap::WriteOptions {
    options.calculate_chunk_crcs(false).calculate_data_section_crc(false).calculate_summary_section_crc(false)
}

/// Offsets and lengths of the contents of all records with an operation code outside of chunks.
pub fn records(bytes: &[u8], opcode: u8) -> Vec<(usize, usize)> {
    let (mut at, mut found) = (8, Vec::new());
    while at + 9 <= bytes.len() - 8 {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().expect("eight bytes"));
        let length = usize::try_from(length).expect("it is in memory");
        if bytes[at] == opcode {
            found.push((at + 9, length));
        }
        at += 9 + length;
    }
    found
}

/// Changes the byte at an offset behind the beginning of the last record with an operation code.
pub fn patch_last(bytes: &mut [u8], opcode: u8, offset: usize) {
    let (at, _) = *records(bytes, opcode).last().expect("there is one");
    bytes[at + offset] ^= 1;
}

/// Offset of the first occurrence of some bytes.
pub fn find(bytes: &[u8], needle: &[u8]) -> usize {
    bytes.windows(needle.len()).position(|window| window == needle).expect("they are in there")
}

/// Offset of the content of the first chunk's message that holds a text.
pub fn message_with(bytes: &[u8], text: &str) -> usize {
    // Behind the four bytes of CDR and the length of the text.
    find(bytes, text.as_bytes()) - 8
}

/// The footer's record, from its head to the end of the file.
pub fn footer_at(bytes: &[u8]) -> usize {
    records(bytes, op::FOOTER).first().expect("there is one").0 - 9
}
