// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `metadata.yaml`, version 9 as Jazzy writes it, and the older versions as far as they can be read.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Write as _;
use std::path::Path;

use serde::Deserialize;

use super::json::quoted;
use super::qos::{self, QosProfile, RawProfile};
use super::yaml::{YamlWriter, scalar};
use super::{BagError, Topic};

/// The metadata version of Jazzy.
pub const VERSION: u32 = 9;
/// The starting time rosbag2 writes while there is no message (ns).
pub const NO_START_NS: u64 = i64::MAX as u64;
/// Name of the file beside the storage files.
pub const FILE_NAME: &str = "metadata.yaml";
/// Name of the MCAP metadata record that repeats the file, and the key within it.
pub const RECORD_NAME: &str = "rosbag2";
/// Key of that record that holds the YAML text.
pub const RECORD_KEY: &str = "serialized_metadata";

/// Key of the custom data that every bag of this recorder has.
pub(super) const RECORDER_VERSION: &str = "camwright.version";

/// One topic and how many of its messages the bag holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TopicEntry {
    pub name: String,
    /// ROS type, for example `sensor_msgs/msg/JointState`.
    pub type_name: String,
    /// `RIHS01_…`, empty when unknown.
    pub type_hash: String,
    /// Offered quality of service of each publisher.
    pub offered_qos: Vec<QosProfile>,
    /// Messages in the bag.
    pub message_count: u64,
}

impl TopicEntry {
    /// The entry of `topic` with `message_count` messages.
    #[must_use]
    pub fn new(topic: &Topic, message_count: u64) -> Self {
        Self {
            name: topic.name.clone(),
            type_name: topic.type_name.clone(),
            type_hash: topic.type_hash.clone(),
            offered_qos: topic.offered_qos.clone(),
            message_count,
        }
    }
}

/// One storage file of a bag.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileEntry {
    /// Path relative to the bag's directory.
    pub path: String,
    /// Smallest log time (ns since 1970), [`NO_START_NS`] without messages.
    pub starting_time_ns: u64,
    /// Largest less smallest log time (ns).
    pub duration_ns: u64,
    /// Messages in the file.
    pub message_count: u64,
}

/// All that `metadata.yaml` says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BagMetadata {
    /// Version of the form.
    pub version: u32,
    /// `mcap`.
    pub storage_identifier: String,
    /// Largest less smallest log time over all files (ns).
    pub duration_ns: u64,
    /// Smallest log time (ns since 1970), [`NO_START_NS`] without messages.
    pub starting_time_ns: u64,
    /// Messages over all topics.
    pub message_count: u64,
    /// Every topic, also those without messages.
    pub topics: Vec<TopicEntry>,
    /// Compression done by rosbag2 itself; empty, since MCAP compresses its own chunks.
    pub compression_format: String,
    /// Compression by rosbag2 itself; empty.
    pub compression_mode: String,
    /// The storage files in order, relative to the directory.
    pub relative_file_paths: Vec<String>,
    /// The storage files with their times and counts.
    pub files: Vec<FileEntry>,
    /// Custom data of the writer.
    pub custom_data: BTreeMap<String, String>,
    /// ROS distribution whose forms are used.
    pub ros_distro: String,
}

impl BagMetadata {
    /// The mapping under `rosbag2_bagfile_information`, as it stands in the MCAP metadata record: rosbag2's field order,
    /// no line end after the last line.
    #[must_use]
    pub fn to_yaml(&self) -> String {
        let mut yaml = YamlWriter::new(0);
        yaml.value("version", self.version);
        yaml.text("storage_identifier", &self.storage_identifier);
        yaml.map("duration", |yaml| yaml.value("nanoseconds", self.duration_ns));
        yaml.map("starting_time", |yaml| yaml.value("nanoseconds_since_epoch", self.starting_time_ns));
        yaml.value("message_count", self.message_count);
        yaml.list("topics_with_message_count", &self.topics, |yaml, topic| {
            yaml.map("topic_metadata", |yaml| {
                yaml.text("name", &topic.name);
                yaml.text("type", &topic.type_name);
                yaml.value("serialization_format", "cdr");
                yaml.list("offered_qos_profiles", &topic.offered_qos, qos::write);
                yaml.text("type_description_hash", &topic.type_hash);
            });
            yaml.value("message_count", topic.message_count);
        });
        yaml.value("compression_format", quoted(&self.compression_format));
        yaml.value("compression_mode", quoted(&self.compression_mode));
        yaml.texts("relative_file_paths", &self.relative_file_paths);
        yaml.list("files", &self.files, |yaml, file| {
            yaml.text("path", &file.path);
            yaml.map("starting_time", |yaml| yaml.value("nanoseconds_since_epoch", file.starting_time_ns));
            yaml.map("duration", |yaml| yaml.value("nanoseconds", file.duration_ns));
            yaml.value("message_count", file.message_count);
        });
        if self.custom_data.is_empty() {
            yaml.value("custom_data", "~");
        } else {
            yaml.map("custom_data", |yaml| {
                for (key, value) in &self.custom_data {
                    yaml.value(&scalar(key), quoted(value));
                }
            });
        }
        yaml.text("ros_distro", &self.ros_distro);
        yaml.finish()
    }

    /// The whole text of `metadata.yaml`.
    #[must_use]
    pub fn to_file_text(&self) -> String {
        let mut text = String::from("rosbag2_bagfile_information:\n");
        for line in self.to_yaml().lines() {
            text.push_str("  ");
            text.push_str(line);
            text.push('\n');
        }
        text
    }

    /// Writes `metadata.yaml` into `directory` so that at every instant the whole old or the whole new one is there.
    ///
    /// # Errors
    /// When the directory cannot be written.
    pub fn write_to(&self, directory: &Path) -> Result<(), BagError> {
        let path = directory.join(FILE_NAME);
        let beside = directory.join(".metadata.yaml.tmp");
        let mut file = File::create(&beside).map_err(|e| BagError::io("create", &beside, e))?;
        let written = file.write_all(self.to_file_text().as_bytes()).and_then(|()| file.sync_all());
        if let Err(error) = written {
            drop(file);
            // The half-written file is useless; the old one stays.
            drop(fs::remove_file(&beside));
            return Err(BagError::io("write", &path, error));
        }
        fs::rename(&beside, &path).map_err(|e| BagError::io("replace", &path, e))?;
        // The new name is on the disk only when the directory is.
        File::open(directory).and_then(|d| d.sync_all()).map_err(|e| BagError::io("sync", directory, e))
    }

    /// Reads `metadata.yaml` of a bag's directory.
    ///
    /// # Errors
    /// When there is none, or it cannot be understood.
    pub fn read_from(directory: &Path) -> Result<Self, BagError> {
        let path = directory.join(FILE_NAME);
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
                return Err(BagError::NoMetadata { path: directory.to_owned() });
            }
            Err(e) => return Err(BagError::io("read", &path, e)),
        };
        Self::parse_file(&text).map_err(|reason| BagError::Metadata { path, reason })
    }

    /// Parses the whole text of a `metadata.yaml`.
    ///
    /// # Errors
    /// One sentence saying what is missing or wrong.
    pub fn parse_file(text: &str) -> Result<Self, String> {
        let file: RawFile = serde_saphyr::from_str(text).map_err(|e| e.to_string())?;
        file.rosbag2_bagfile_information.parsed()
    }

    /// Parses the text of the MCAP metadata record.
    ///
    /// # Errors
    /// One sentence saying what is missing or wrong.
    pub fn parse_record(text: &str) -> Result<Self, String> {
        let raw: RawInformation = serde_saphyr::from_str(text).map_err(|e| e.to_string())?;
        raw.parsed()
    }
}

#[derive(Deserialize)]
struct RawFile {
    rosbag2_bagfile_information: RawInformation,
}

#[derive(Deserialize)]
struct RawInformation {
    version: u32,
    storage_identifier: String,
    duration: RawDuration,
    starting_time: RawStart,
    message_count: u64,
    topics_with_message_count: Vec<RawTopicCount>,
    compression_format: Option<String>,
    compression_mode: Option<String>,
    relative_file_paths: Option<Vec<String>>,
    files: Option<Vec<RawFileEntry>>,
    /// Twice, since nothing may stand behind the key, but the key has to.
    #[serde(default, deserialize_with = "present")]
    custom_data: Option<Option<BTreeMap<String, String>>>,
    ros_distro: Option<String>,
}

fn present<'de, T: Deserialize<'de>, D: serde::Deserializer<'de>>(value: D) -> Result<Option<T>, D::Error> {
    T::deserialize(value).map(Some)
}

#[derive(Deserialize)]
struct RawDuration {
    nanoseconds: u64,
}

#[derive(Deserialize)]
struct RawStart {
    nanoseconds_since_epoch: u64,
}

#[derive(Deserialize)]
struct RawTopicCount {
    topic_metadata: RawTopic,
    message_count: u64,
}

#[derive(Deserialize)]
struct RawTopic {
    name: String,
    #[serde(rename = "type")]
    type_name: String,
    serialization_format: String,
    offered_qos_profiles: Option<RawProfiles>,
    type_description_hash: Option<String>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum RawProfiles {
    List(Vec<RawProfile>),
    Text(String),
}

#[derive(Deserialize)]
struct RawFileEntry {
    path: String,
    starting_time: RawStart,
    duration: RawDuration,
    message_count: u64,
}

impl RawInformation {
    fn parsed(self) -> Result<BagMetadata, String> {
        if self.version > VERSION {
            return Err(format!("metadata version {} is newer than {VERSION}, the newest known here", self.version));
        }
        if self.version == VERSION {
            let topics = || self.topics_with_message_count.iter().map(|entry| &entry.topic_metadata);
            let missing = [
                (self.compression_format.is_none(), "compression_format"),
                (self.compression_mode.is_none(), "compression_mode"),
                (self.relative_file_paths.is_none(), "relative_file_paths"),
                (self.files.is_none(), "files"),
                (self.custom_data.is_none(), "custom_data"),
                (self.ros_distro.is_none(), "ros_distro"),
                (topics().any(|t| t.offered_qos_profiles.is_none()), "offered_qos_profiles of every topic"),
                (topics().any(|t| t.type_description_hash.is_none()), "type_description_hash of every topic"),
            ];
            if let Some((_, key)) = missing.iter().find(|(is_missing, _)| *is_missing) {
                return Err(format!("version {VERSION} requires the key {key}"));
            }
        }
        let mut topics = Vec::with_capacity(self.topics_with_message_count.len());
        for entry in self.topics_with_message_count {
            let raw = entry.topic_metadata;
            if raw.serialization_format != "cdr" {
                return Err(format!(
                    "topic {}: serialization format '{}' is not cdr",
                    raw.name, raw.serialization_format
                ));
            }
            let offered_qos = match raw.offered_qos_profiles {
                Some(RawProfiles::List(list)) => list.into_iter().map(RawProfile::parsed).collect::<Result<_, _>>(),
                Some(RawProfiles::Text(text)) => qos::from_yaml(&text),
                None => Ok(Vec::new()),
            }
            .map_err(|reason| format!("topic {}: {reason}", raw.name))?;
            topics.push(TopicEntry {
                name: raw.name,
                type_name: raw.type_name,
                type_hash: raw.type_description_hash.unwrap_or_default(),
                offered_qos,
                message_count: entry.message_count,
            });
        }
        Ok(BagMetadata {
            version: self.version,
            storage_identifier: self.storage_identifier,
            duration_ns: self.duration.nanoseconds,
            starting_time_ns: self.starting_time.nanoseconds_since_epoch,
            message_count: self.message_count,
            topics,
            compression_format: self.compression_format.unwrap_or_default(),
            compression_mode: self.compression_mode.unwrap_or_default(),
            relative_file_paths: self.relative_file_paths.unwrap_or_default(),
            files: self
                .files
                .unwrap_or_default()
                .into_iter()
                .map(|f| FileEntry {
                    path: f.path,
                    starting_time_ns: f.starting_time.nanoseconds_since_epoch,
                    duration_ns: f.duration.nanoseconds,
                    message_count: f.message_count,
                })
                .collect(),
            custom_data: self.custom_data.flatten().unwrap_or_default(),
            ros_distro: self.ros_distro.unwrap_or_default(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::qos::{Durability, Reliability};
    use super::*;

    fn example() -> BagMetadata {
        let profile = QosProfile::discovered(Reliability::Reliable, Durability::Volatile);
        BagMetadata {
            version: VERSION,
            storage_identifier: "mcap".into(),
            duration_ns: 999_000_000,
            starting_time_ns: 1_760_000_000_000_000_000,
            message_count: 1000,
            topics: vec![TopicEntry {
                name: "/joint_states".into(),
                type_name: "sensor_msgs/msg/JointState".into(),
                type_hash: "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e".into(),
                offered_qos: vec![profile],
                message_count: 1000,
            }],
            compression_format: String::new(),
            compression_mode: String::new(),
            relative_file_paths: vec!["pybag_0.mcap".into()],
            files: vec![FileEntry {
                path: "pybag_0.mcap".into(),
                starting_time_ns: 1_760_000_000_000_000_000,
                duration_ns: 999_000_000,
                message_count: 1000,
            }],
            custom_data: BTreeMap::from([("camwright.run_id".into(), "r1".into())]),
            ros_distro: "jazzy".into(),
        }
    }

    /// The text of RECORDING section 1.5 for one topic.
    const REFERENCE: &str = r#"rosbag2_bagfile_information:
  version: 9
  storage_identifier: mcap
  duration:
    nanoseconds: 999000000
  starting_time:
    nanoseconds_since_epoch: 1760000000000000000
  message_count: 1000
  topics_with_message_count:
    - topic_metadata:
        name: /joint_states
        type: sensor_msgs/msg/JointState
        serialization_format: cdr
        offered_qos_profiles:
          - history: unknown
            depth: 0
            reliability: reliable
            durability: volatile
            deadline:
              sec: 9223372036
              nsec: 854775807
            lifespan:
              sec: 9223372036
              nsec: 854775807
            liveliness: automatic
            liveliness_lease_duration:
              sec: 9223372036
              nsec: 854775807
            avoid_ros_namespace_conventions: false
        type_description_hash: RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e
      message_count: 1000
  compression_format: ""
  compression_mode: ""
  relative_file_paths:
    - pybag_0.mcap
  files:
    - path: pybag_0.mcap
      starting_time:
        nanoseconds_since_epoch: 1760000000000000000
      duration:
        nanoseconds: 999000000
      message_count: 1000
  custom_data:
    camwright.run_id: "r1"
  ros_distro: jazzy
"#;

    #[test]
    fn the_text_is_that_of_rosbag2() {
        assert_eq!(example().to_file_text(), REFERENCE);
    }

    #[test]
    fn what_is_written_is_read_back_with_any_name_and_text() {
        let mut metadata = example();
        metadata.topics[0].offered_qos.clear();
        metadata.topics[0].type_hash.clear();
        metadata.relative_file_paths = vec!["2026_11_21".into(), "a b: #c".into(), "off".into(), "ü\"\\".into()];
        metadata.custom_data.insert("key with: colon".into(), "two\nlines \"quoted\" \u{85} # no comment".into());
        assert_eq!(BagMetadata::parse_record(&metadata.to_yaml()), Ok(metadata.clone()));
        assert_eq!(BagMetadata::parse_file(&metadata.to_file_text()), Ok(metadata.clone()));
        metadata.topics.clear();
        metadata.files.clear();
        metadata.relative_file_paths.clear();
        metadata.custom_data.clear();
        assert_eq!(BagMetadata::parse_file(&metadata.to_file_text()), Ok(metadata));
    }

    #[test]
    fn older_forms_are_read_and_newer_ones_refused() {
        let quoted_list = REFERENCE
            .replace("version: 9", "version: 5")
            .lines()
            .filter(|l| !l.contains("ros_distro") && !l.contains("camwright") && !l.contains("custom_data"))
            .map(|l| format!("{l}\n"))
            .collect::<String>();
        let start = quoted_list.find("          - history").expect("the list is in the text");
        let end = quoted_list.find("        type_description_hash").expect("the hash follows the list");
        let older = format!("{} \"\"\n{}", &quoted_list[..start - 1], &quoted_list[end..]);
        let metadata = BagMetadata::parse_file(&older).expect("version 5 needs no distribution");
        assert_eq!((metadata.version, metadata.topics[0].offered_qos.len()), (5, 0));

        let newer = BagMetadata::parse_file(&REFERENCE.replace("version: 9", "version: 10")).expect_err("not known");
        assert!(newer.contains("version 10 is newer"), "{newer}");
        let lacking = BagMetadata::parse_file(&REFERENCE.replace("  compression_mode: \"\"\n", ""));
        assert_eq!(lacking, Err("version 9 requires the key compression_mode".into()));
    }
}
