//! Whether a bag is what a rosbag2 bag should be: structure, check sums, order, and whether its two accounts of itself agree.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use mcap::McapError;
use mcap::records::{MessageHeader, Record, Statistics};

use super::json::quoted;
use super::metadata::{self, BagMetadata};
use super::numbers::{Numbers, Told};
use super::records::{Records, strict};
use super::writer::{OURS, REPEATED};
use super::{Bag, BagError, qos};

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Worth knowing; every reader takes the bag.
    Warning,
    /// Damaged, incomplete, or not what rosbag2 writes.
    Error,
}

/// Something found in a bag.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// The file, relative to the bag where it is within.
    pub place: String,
    /// What was found, with the value and what it should be.
    pub text: String,
}

/// What a check found.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Report {
    /// In the order they were found.
    pub findings: Vec<Finding>,
    /// Messages seen.
    pub message_count: u64,
    /// Topics seen.
    pub topic_count: usize,
}

impl Report {
    /// The worst finding; none when the bag is clean.
    #[must_use]
    pub fn worst(&self) -> Option<Severity> {
        self.findings.iter().map(|f| f.severity).max()
    }

    /// For people.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for finding in &self.findings {
            let word = match finding.severity {
                Severity::Warning => "warning",
                Severity::Error => "error",
            };
            text.push_str(&format!("{word}: {}: {}\n", finding.place, finding.text));
        }
        let verdict = match self.worst() {
            None => "clean",
            Some(Severity::Warning) => "readable, with warnings",
            Some(Severity::Error) => "not in order",
        };
        text.push_str(&format!("{} messages on {} topics: {verdict}\n", self.message_count, self.topic_count));
        text
    }

    /// For scripts: one JSON object.
    #[must_use]
    pub fn to_json(&self) -> String {
        let findings: Vec<String> = self
            .findings
            .iter()
            .map(|f| {
                let severity = if f.severity == Severity::Error { "error" } else { "warning" };
                let (place, text) = (quoted(&f.place), quoted(&f.text));
                format!("{{\"severity\":\"{severity}\",\"place\":{place},\"text\":{text}}}")
            })
            .collect();
        format!(
            "{{\"message_count\":{},\"topic_count\":{},\"findings\":[{}]}}",
            self.message_count,
            self.topic_count,
            findings.join(",")
        )
    }
}

/// Checks the bag at `path`: a directory, or one MCAP file.
///
/// # Errors
/// Only when there is nothing to check; whatever is wrong with a bag is a finding.
pub fn check(path: &Path) -> Result<Report, BagError> {
    let is_file = std::fs::metadata(path).map_err(|e| BagError::io("open", path, e))?.is_file();
    let mut checker = Checker::default();
    let (files, yaml) = if is_file { (vec![path.to_owned()], None) } else { checker.directory(path) };
    for file in &files {
        checker.file(file);
    }
    checker.order();
    if let Some(yaml) = &yaml {
        checker.accounts_agree(yaml);
    }
    checker.run_as_told(yaml.as_ref());
    if !checker.is_damaged {
        checker.index(path);
    }
    checker.report.topic_count = checker.counts.len();
    Ok(checker.report)
}

#[derive(Default)]
struct Checker {
    report: Report,
    /// Messages of each topic, by name.
    counts: BTreeMap<String, u64>,
    /// Type and hash of each topic, by name.
    types: BTreeMap<String, (String, String)>,
    log_times_ns: Option<(u64, u64)>,
    /// The last metadata record of the last file.
    record: Option<BagMetadata>,
    /// A file could not be read to its end.
    is_damaged: bool,
    /// The numbers of each topic's messages so far, by name.
    numbers: BTreeMap<String, Numbers>,
    /// Files before the one under way, and messages in them that had been in an earlier one.
    files: usize,
    repeated: u64,
    at_zero: u64,
    not_increasing: u64,
    without_cdr: u64,
}

/// A channel of the file under way.
struct Channel {
    topic: String,
    messages: u64,
    /// How many numbers were left out, and how many came again where none should.
    missing: u64,
    doubled: u64,
}

impl Checker {
    fn error(&mut self, place: impl Into<String>, text: impl Into<String>) {
        self.report.findings.push(Finding { severity: Severity::Error, place: place.into(), text: text.into() });
    }

    fn warning(&mut self, place: impl Into<String>, text: impl Into<String>) {
        self.report.findings.push(Finding { severity: Severity::Warning, place: place.into(), text: text.into() });
    }

    /// The storage files, and what `metadata.yaml` says.
    fn directory(&mut self, path: &Path) -> (Vec<PathBuf>, Option<BagMetadata>) {
        match BagMetadata::read_from(path) {
            Ok(yaml) => {
                if yaml.version != metadata::VERSION {
                    let text = format!("version {} is older than Jazzy's {}", yaml.version, metadata::VERSION);
                    self.warning(metadata::FILE_NAME, text);
                }
                if yaml.storage_identifier != "mcap" {
                    self.error(metadata::FILE_NAME, format!("storage '{}' is not mcap", yaml.storage_identifier));
                    self.is_damaged = true;
                    return (Vec::new(), Some(yaml));
                }
                let listed: Vec<&String> = yaml.files.iter().map(|f| &f.path).collect();
                if listed != yaml.relative_file_paths.iter().collect::<Vec<_>>() {
                    self.error(metadata::FILE_NAME, "files and relative_file_paths do not list the same files");
                }
                (yaml.relative_file_paths.iter().map(|p| path.join(p)).collect(), Some(yaml))
            }
            Err(error) => {
                self.error(metadata::FILE_NAME, error.to_string());
                let mut files: Vec<PathBuf> = std::fs::read_dir(path)
                    .map(|entries| entries.filter_map(|e| e.ok().map(|e| e.path())).collect())
                    .unwrap_or_default();
                files.retain(|p| p.extension().is_some_and(|e| e == "mcap"));
                files.sort();
                (files, None)
            }
        }
    }

    fn file(&mut self, path: &Path) {
        let place = path.file_name().map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned());
        let mut records = match Records::open(path, strict()) {
            Ok(records) => records,
            Err(error) => {
                self.is_damaged = true;
                return self.error(place, error.to_string());
            }
        };
        let mut file = FileWalk::default();
        loop {
            match records.next() {
                Ok(Some(record)) => self.record(&place, &mut file, record),
                Ok(None) => break,
                Err(error) => {
                    self.is_damaged = true;
                    let reason = match &error {
                        BagError::Mcap { source: McapError::BytesAfterEndMagic, .. } => {
                            "there are bytes behind its end".into()
                        }
                        other => other.to_string(),
                    };
                    self.error(&place, format!("not readable beyond this: {reason}"));
                    break;
                }
            }
        }
        if records.is_torn() {
            self.is_damaged = true;
            self.error(
                &place,
                "the file ends before its end: the recording was killed; what is whole in it can be read",
            );
        } else if !self.is_damaged {
            if file.statistics.is_none() {
                self.warning(&place, "the summary has no statistics");
            }
            if file.chunks > 0 && file.chunk_indexes == 0 {
                self.warning(&place, "there is no index: players read it in file order");
            }
        }
        self.close(&place, file);
        self.files += 1;
    }

    fn record(&mut self, place: &str, file: &mut FileWalk, record: Record<'_>) {
        match record {
            Record::Header(header) if header.profile != "ros2" => {
                self.error(place, format!("profile '{}' is not ros2", header.profile));
            }
            Record::Schema { header, data } => self.schema(place, file, header.id, header.name, header.encoding, &data),
            Record::Channel(channel) => self.channel(place, file, channel),
            Record::Message { header, data } => self.message(place, file, &header, &data),
            Record::MessageIndex(_) => file.chunks += 1,
            Record::ChunkIndex(_) => file.chunk_indexes += 1,
            Record::Statistics(statistics) => file.statistics = Some(statistics),
            Record::Metadata(mut m) if m.name == metadata::RECORD_NAME => match m.metadata.remove(metadata::RECORD_KEY)
            {
                Some(text) => match BagMetadata::parse_record(&text) {
                    Ok(metadata) => file.metadata = Some(metadata),
                    Err(reason) => self.error(place, format!("metadata record: {reason}")),
                },
                None => self.error(place, format!("the metadata record has no {}", metadata::RECORD_KEY)),
            },
            _ => {}
        }
    }

    fn schema(&mut self, place: &str, file: &mut FileWalk, id: u16, name: String, encoding: String, data: &[u8]) {
        if file.schemas.contains_key(&id) {
            return; // The summary repeats it.
        }
        if encoding != "ros2msg" {
            self.error(place, format!("type {name}: definition encoding '{encoding}' is not ros2msg"));
        }
        if name.split('/').count() != 3 {
            self.error(place, format!("type '{name}' is not of the form package/msg/Type"));
        }
        if file.schemas.values().any(|n| *n == name) {
            self.warning(place, format!("type {name} is defined more than once"));
        }
        if let Some(info) = camwright_msgs::by_type_name(&name)
            && info.schema.as_bytes() != data
        {
            self.warning(place, format!("type {name}: the recorded definition text is not the one of this camwright"));
        }
        file.schemas.insert(id, name);
    }

    fn channel(&mut self, place: &str, file: &mut FileWalk, channel: mcap::records::Channel) {
        if file.channels.contains_key(&channel.id) {
            return; // The summary repeats it.
        }
        let topic = channel.topic;
        let type_name = file.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
        if type_name.is_empty() {
            self.error(place, format!("topic {topic} has no definition"));
        }
        if channel.message_encoding != "cdr" {
            self.error(place, format!("topic {topic}: message encoding '{}' is not cdr", channel.message_encoding));
        }
        let keys: Vec<&str> = channel.metadata.keys().map(String::as_str).collect();
        if keys != ["offered_qos_profiles", "topic_type_hash"] {
            let text = "metadata keys are not offered_qos_profiles and topic_type_hash";
            self.error(place, format!("topic {topic}: {text} but {}", keys.join(", ")));
        }
        if let Some(Err(reason)) = channel.metadata.get("offered_qos_profiles").map(|t| qos::from_yaml(t)) {
            self.error(place, format!("topic {topic}: {reason}"));
        }
        let hash = channel.metadata.get("topic_type_hash").cloned().unwrap_or_default();
        let digits = hash.strip_prefix("RIHS01_").unwrap_or_default();
        if digits.len() != 64 || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
            self.warning(place, format!("topic {topic}: type hash '{hash}' is not RIHS01_ and 64 hexadecimal digits"));
        } else if let Some(info) = camwright_msgs::by_type_name(&type_name)
            && info.type_hash != hash
        {
            self.warning(place, format!("topic {topic}: {type_name} was recorded from another definition of it"));
        }
        if file.channels.values().any(|c| c.topic == topic) {
            self.warning(place, format!("topic {topic} has more than one channel"));
        }
        match self.types.get(&topic) {
            Some((other, _)) if *other != type_name => {
                let text = format!("topic {topic} is {type_name} here and {other} in an earlier file");
                self.error(place, text);
            }
            _ => {
                self.types.insert(topic.clone(), (type_name, hash));
            }
        }
        self.counts.entry(topic.clone()).or_insert(0);
        file.channels.insert(channel.id, Channel { topic, messages: 0, missing: 0, doubled: 0 });
    }

    fn message(&mut self, place: &str, file: &mut FileWalk, header: &MessageHeader, data: &[u8]) {
        self.report.message_count += 1;
        let Some(channel) = file.channels.get_mut(&header.channel_id) else {
            return self.error(place, format!("a message belongs to the unknown channel {}", header.channel_id));
        };
        channel.messages += 1;
        match self.numbers.entry(channel.topic.clone()).or_default().take(header.sequence) {
            Told::New(missing) => channel.missing += u64::from(missing),
            Told::Missed => channel.missing = channel.missing.saturating_sub(1),
            // The head of a later file repeats what is latched.
            Told::Again if self.files > 0 => self.repeated += 1,
            Told::Again => channel.doubled += 1,
        }
        if let Some(count) = self.counts.get_mut(&channel.topic) {
            *count += 1;
        }
        // Representation identifiers 0x0000 to 0x000b: plain, parameter list, and the extensible ones, both byte orders.
        if data.len() < 4 || data[0] != 0 || data[1] > 0x0b {
            self.without_cdr += 1;
        }
        let t = header.log_time;
        self.at_zero += u64::from(t == 0);
        self.not_increasing += u64::from(self.log_times_ns.is_some_and(|(_, last)| t <= last));
        self.log_times_ns = Some(self.log_times_ns.map_or((t, t), |(a, b)| (a.min(t), b.max(t))));
    }

    fn close(&mut self, place: &str, file: FileWalk) {
        for channel in file.channels.values().filter(|c| c.missing > 0) {
            self.error(
                place,
                format!("topic {}: {} messages are missing by their numbers", channel.topic, channel.missing),
            );
        }
        for channel in file.channels.values().filter(|c| c.doubled > 0) {
            let Channel { topic, doubled, .. } = channel;
            self.warning(place, format!("topic {topic}: {doubled} messages have a number that was there before"));
        }
        if let Some(statistics) = &file.statistics {
            for (id, channel) in &file.channels {
                let told = statistics.channel_message_counts.get(id).copied().unwrap_or(0);
                if told != channel.messages {
                    let (topic, seen) = (&channel.topic, channel.messages);
                    self.error(place, format!("topic {topic}: statistics say {told} messages, the file has {seen}"));
                }
            }
        }
        if file.metadata.is_none() {
            self.warning(place, "there is no rosbag2 metadata record");
        }
        self.record = file.metadata.or(self.record.take());
    }

    fn order(&mut self) {
        let counted = [
            (self.at_zero, Severity::Error, "messages have the log time 0, which viewers refuse"),
            (
                self.not_increasing,
                Severity::Warning,
                "messages do not come after the one before, so players may reorder them",
            ),
            (self.without_cdr, Severity::Error, "messages do not begin with the four bytes of CDR"),
        ];
        for (count, severity, text) in counted {
            if count > 0 {
                let text = format!("{count} {text}");
                self.report.findings.push(Finding { severity, place: "messages".into(), text });
            }
        }
    }

    fn accounts_agree(&mut self, yaml: &BagMetadata) {
        const PLACE: &str = metadata::FILE_NAME;
        let seen = self.report.message_count;
        if yaml.message_count != seen {
            self.error(PLACE, format!("message_count is {}, the files have {seen}", yaml.message_count));
        }
        let by_topic: u64 = yaml.topics.iter().map(|t| t.message_count).sum();
        let by_file: u64 = yaml.files.iter().map(|f| f.message_count).sum();
        if by_topic != yaml.message_count || by_file != yaml.message_count {
            let text = format!(
                "message_count is {}, its topics add up to {by_topic}, its files to {by_file}",
                yaml.message_count
            );
            self.error(PLACE, text);
        }
        if let Some((first, last)) = self.log_times_ns
            && (yaml.starting_time_ns, yaml.duration_ns) != (first, last - first)
        {
            let (start, duration) = (yaml.starting_time_ns, yaml.duration_ns);
            let text =
                format!("starts at {start} ns for {duration} ns, the messages at {first} ns for {} ns", last - first);
            self.error(PLACE, text);
        }
        for topic in &yaml.topics {
            let count = self.counts.get(&topic.name).copied();
            if count != Some(topic.message_count) {
                let text = match count {
                    Some(n) => format!("topic {} has {} messages, the files have {n}", topic.name, topic.message_count),
                    None => format!("topic {} is not in the files", topic.name),
                };
                self.error(PLACE, text);
            }
            if let Some((type_name, hash)) = self.types.get(&topic.name).cloned()
                && (type_name != topic.type_name || hash != topic.type_hash)
            {
                self.error(PLACE, format!("topic {}: type or hash is not that of the file ({type_name})", topic.name));
            }
        }
        let unlisted: Vec<String> =
            self.counts.keys().filter(|name| !yaml.topics.iter().any(|t| t.name == **name)).cloned().collect();
        for name in unlisted {
            self.error(PLACE, format!("topic {name} of the files is not listed"));
        }
        if let Some(record) = &self.record
            && !self.is_damaged
            && yaml.files.len() == 1
            && record != yaml
        {
            self.warning(PLACE, "it differs from the metadata record within the file");
        }
    }

    /// What the recorder itself said about the run.
    fn run_as_told(&mut self, yaml: Option<&BagMetadata>) {
        let Some(told) = self.record.as_ref().or(yaml).map(|m| m.custom_data.clone()) else { return };
        if let Some(lost) = told.get("camwright.lost_total").filter(|l| *l != "0") {
            self.warning("custom_data", format!("{lost} messages were received and are not in the bag"));
        }
        let repeated = told.get(REPEATED).map_or("0", String::as_str);
        if !self.is_damaged && told.contains_key(OURS) && repeated != self.repeated.to_string() {
            let seen = self.repeated;
            let text = format!("{repeated} messages are to stand at the head of a later file once more, {seen} do");
            self.error("custom_data", text);
        }
        match told.get("camwright.outcome").map(String::as_str) {
            Some("fault") => {
                let reason = told.get("camwright.fault").map_or("", String::as_str);
                self.warning("custom_data", format!("the recording ended early: {reason}"));
            }
            Some("open") if !self.is_damaged => self.warning("custom_data", "the recording says that it is still open"),
            _ => {}
        }
    }

    /// Reads by the index and counts again.
    fn index(&mut self, path: &Path) {
        let by_index = Bag::open(path).and_then(|bag| {
            let mut messages = bag.records();
            let mut count = 0_u64;
            while messages.next_message()?.is_some() {
                count += 1;
            }
            Ok(count)
        });
        match by_index {
            Ok(count) if count != self.report.message_count => {
                let seen = self.report.message_count;
                self.error("index", format!("it leads to {count} messages of {seen}"));
            }
            Ok(_) => {}
            Err(error) => self.error("index", error.to_string()),
        }
    }
}

/// What has been seen of the file under way.
#[derive(Default)]
struct FileWalk {
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
    statistics: Option<Statistics>,
    metadata: Option<BagMetadata>,
    chunks: u64,
    chunk_indexes: u64,
}
