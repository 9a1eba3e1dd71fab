// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Types and topics: what a file says of them, and whether their messages are what it says.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use mcap::records::{Channel as ChannelRecord, MessageHeader, SchemaHeader, Statistics};

use super::report::{BagReport, FindingCount};
use crate::definition::TypeDefinition;
use crate::qos::{self, Durability};
use crate::sequence_check::{Numbers, SequenceCheck};
use crate::values::{self, FieldValue};
use crate::well_formed::well_formed;

/// Types whose messages are inputs with a number of their own, counted from 0.
const INPUTS: [&str; 2] = ["camwright_msgs/msg/MachineInput", "camwright_msgs/msg/AppliedInput"];

/// State of one topic.
#[derive(Default)]
pub(super) struct TopicCheck {
    pub(super) type_name: String,
    pub(super) hash: String,
    is_latched: bool,
    definition: Option<Rc<TypeDefinition>>,
    numbers: Numbers,
    /// The largest number before this file, and whether it came again in it.
    before: u32,
    is_headed: bool,
    /// In the current file: missing sequence numbers, and unexpected repetitions.
    missing: u64,
    doubled: u64,
    malformed: FindingCount,
    /// The number of the next input, where the topic has inputs, and where some are missing.
    next_input: u64,
    gaps: FindingCount,
    /// Files that do not begin with its last message, though it is latched.
    pub(super) headless: Vec<String>,
    /// The last message, where it is the recorder's own account.
    pub(super) account: Option<Account>,
}

/// Last counts reported by the recorder.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Account {
    /// Name of the bag that it counts.
    pub(super) bag: String,
    pub(super) written: u64,
    pub(super) dropped: u64,
}

impl TopicCheck {
    /// Takes a message; whether it had been in an earlier file.
    pub(super) fn message(&mut self, is_later_file: bool, header: &MessageHeader, data: &[u8]) -> bool {
        let checked = self.numbers.check(header.sequence);
        match checked {
            SequenceCheck::New(missing) => self.missing += u64::from(missing),
            SequenceCheck::Missed => self.missing = self.missing.saturating_sub(1),
            // The head of a later file repeats what is latched.
            SequenceCheck::Again if is_later_file => self.is_headed |= header.sequence == self.before,
            SequenceCheck::Again => self.doubled += 1,
        }
        if let Some(definition) = &self.definition
            && let Err(reason) = well_formed(definition, data)
        {
            self.malformed.note(|| format!("number {} at {} ns: {reason}", header.sequence, header.log_time));
        } else if matches!(checked, SequenceCheck::New(_)) {
            self.read_ours(data);
        }
        checked == SequenceCheck::Again && is_later_file
    }

    /// Reads messages of camwright's own types: the numbers of inputs, and the status of the recorder.
    fn read_ours(&mut self, data: &[u8]) {
        let is_input = INPUTS.contains(&self.type_name.as_str());
        let Some(definition) = self.definition.as_ref().filter(|_| is_input || self.is_account()) else { return };
        let (mut found, mut bag) = (BTreeMap::new(), String::new());
        // It was found to be well formed.
        let _ = values::read(definition, data, 0, &mut |path, value| match (path, value) {
            ("bag", FieldValue::Text(path)) => bag = path.rsplit('/').next().unwrap_or_default().to_owned(),
            (path, FieldValue::Unsigned(value, _)) if !path.contains('.') => drop(found.insert(path.to_owned(), value)),
            _ => {}
        });
        let value = |name: &str| found.get(name).copied();
        if is_input && let Some(number) = value("sequence") {
            if number > self.next_input {
                let (from, tick) = (self.next_input, value("tick").unwrap_or(0));
                self.gaps.note(|| format!("inputs {from} to {} before tick {tick} are missing", number - 1));
            }
            self.next_input = self.next_input.max(number.saturating_add(1));
        } else if let (Some(written), Some(dropped)) = (value("written"), value("dropped")) {
            self.account = Some(Account { bag, written, dropped });
        }
    }

    fn is_account(&self) -> bool {
        self.type_name == "camwright_msgs/msg/RecorderStatus"
    }

    /// Reports the content of the topic in a file.
    pub(super) fn close_file(&mut self, report: &mut BagReport, place: &str, name: &str, is_whole_later_file: bool) {
        let (missing, doubled) = (std::mem::take(&mut self.missing), std::mem::take(&mut self.doubled));
        if missing > 0 {
            report.error(place, format!("topic {name}: {missing} messages are missing by their numbers"));
        }
        if doubled > 0 {
            report.warning(place, format!("topic {name}: {doubled} messages have a number that was there before"));
        }
        if let Some(text) = std::mem::take(&mut self.malformed).sentence("that their definition does not decode") {
            report.error(place, format!("topic {name}: {text}"));
        }
        if let Some(text) =
            std::mem::take(&mut self.gaps).sentence("behind a gap of inputs, so that the run cannot be computed again")
        {
            report.error(place, format!("topic {name}: {text}"));
        }
        let headed = std::mem::take(&mut self.is_headed);
        if self.is_latched && is_whole_later_file && self.before > 0 && !headed {
            self.headless.push(place.to_owned());
        }
        self.before = self.numbers.largest();
    }
}

/// Types and channels of the current file.
#[derive(Default)]
pub(super) struct FileTopics {
    schemas: BTreeMap<u16, Rc<Schema>>,
    channels: BTreeMap<u16, Channel>,
    /// Topics and types that have been reported.
    named: BTreeSet<String>,
    types: BTreeSet<String>,
}

struct Channel {
    record: ChannelRecord,
    messages: u64,
}

/// A type as a file defines it, read once however many topics have it.
#[derive(Default)]
struct Schema {
    name: String,
    text: String,
    definition: Option<Rc<TypeDefinition>>,
    /// True if the text has the fields of the known type with this name, and that type's hash.
    known: Option<(bool, &'static str)>,
}

impl Schema {
    fn read(name: String, text: String) -> (Self, Option<String>) {
        let parse = |text: &str| TypeDefinition::parse(&name, text);
        let (definition, reason) = match parse(&text) {
            Ok(definition) => (Some(Rc::new(definition)), None),
            Err(reason) => (None, Some(reason)),
        };
        let ours = camwright_msgs::by_type_name(&name).filter(|info| !info.schema.is_empty());
        let known = ours.map(|info| {
            // Comments and constants do not enter the hash.
            let same = text == info.schema || definition.as_deref() == parse(info.schema).ok().as_ref();
            (same, info.type_hash)
        });
        (Self { name, text, definition, known }, reason)
    }
}

impl FileTopics {
    pub(super) fn channels(&self) -> usize {
        self.channels.len()
    }

    pub(super) fn schemas(&self) -> usize {
        self.schemas.len()
    }

    pub(super) fn schema(&mut self, report: &mut BagReport, place: &str, header: SchemaHeader, data: &[u8]) {
        let SchemaHeader { id, name, encoding } = header;
        let text = String::from_utf8_lossy(data).into_owned();
        if let Some(Schema { name: other, text: other_text, .. }) = self.schemas.get(&id).map(Rc::as_ref) {
            // The summary repeats it.
            if (other, other_text) != (&name, &text) {
                report.error(place, format!("type {name}: it has the number {id}, which {other} has too"));
            }
            return;
        }
        if encoding != "ros2msg" {
            report.error(place, format!("type {name}: definition encoding '{encoding}' is not ros2msg"));
        }
        if !matches!(name.split('/').collect::<Vec<_>>()[..], [_, "msg" | "srv" | "action", _]) {
            report.error(place, format!("type '{name}' is not of the form package/msg/Type"));
        }
        if !self.types.insert(name.clone()) {
            report.warning(place, format!("type {name} is defined more than once"));
        }
        let (schema, reason) = Schema::read(name, text);
        if let Some(reason) = reason {
            report.error(place, format!("the definition of {} cannot be read: {reason}", schema.name));
        }
        self.schemas.insert(id, Rc::new(schema));
    }

    /// Takes a channel; the topic's name where it is new in the file.
    pub(super) fn channel(
        &mut self,
        report: &mut BagReport,
        place: &str,
        channel: ChannelRecord,
        topics: &mut BTreeMap<String, TopicCheck>,
    ) -> Option<String> {
        if let Some(known) = self.channels.get(&channel.id) {
            // The summary repeats it.
            let (id, topic, other) = (channel.id, &channel.topic, &known.record.topic);
            if topic != other {
                report.error(place, format!("topic {topic}: it has the channel {id}, which {other} has too"));
            } else if channel != known.record {
                report.error(place, format!("topic {topic}: the summary repeats its channel {id} otherwise"));
            }
            return None;
        }
        let topic = channel.topic.clone();
        let schema = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
        let type_name = schema.name.clone();
        if type_name.is_empty() {
            report.error(place, format!("topic {topic} has no definition"));
        }
        let hash = self.metadata_of(report, place, &channel);
        judge_hash(report, place, &topic, (&schema, &hash));
        if !self.named.insert(topic.clone()) {
            report.error(place, format!("topic {topic} has more than one channel, of which rosbags reads one"));
        }
        let check = topics.entry(topic.clone()).or_default();
        if check.type_name.is_empty() {
            check.type_name.clone_from(&type_name);
            check.hash = hash;
        } else if check.type_name != type_name {
            let other = &check.type_name;
            report.error(place, format!("topic {topic} is {type_name} here and {other} in an earlier file"));
        }
        let offered = channel.metadata.get("offered_qos_profiles").and_then(|text| qos::from_yaml(text).ok());
        check.is_latched |=
            offered.is_some_and(|offers| offers.iter().any(|offer| offer.durability == Durability::TransientLocal));
        check.definition.clone_from(&schema.definition);
        self.channels.insert(channel.id, Channel { record: channel, messages: 0 });
        Some(topic)
    }

    /// Looks at what stands beside a channel; returns its type's hash.
    fn metadata_of(&self, report: &mut BagReport, place: &str, channel: &ChannelRecord) -> String {
        let topic = &channel.topic;
        if channel.message_encoding != "cdr" {
            let encoding = &channel.message_encoding;
            report.error(place, format!("topic {topic}: message encoding '{encoding}' is not cdr"));
        }
        let keys: Vec<&str> = channel.metadata.keys().map(String::as_str).collect();
        if keys != ["offered_qos_profiles", "topic_type_hash"] {
            let text = "metadata keys are not offered_qos_profiles and topic_type_hash";
            report.error(place, format!("topic {topic}: {text} but {}", keys.join(", ")));
        }
        if let Some(text) = channel.metadata.get("offered_qos_profiles") {
            match qos::from_yaml(text) {
                Err(reason) => report.error(place, format!("topic {topic}: {reason}")),
                Ok(_) if qos::is_of_old_form(text) => {
                    let text =
                        "its QoS profiles are numbers, as before metadata version 9: Jazzy's player refuses them";
                    report.error(place, format!("topic {topic}: {text}"));
                }
                Ok(_) => {}
            }
        }
        channel.metadata.get("topic_type_hash").cloned().unwrap_or_default()
    }

    /// The topic of a message's channel, whose messages it counts.
    pub(super) fn message(&mut self, channel: u16) -> Option<String> {
        let channel = self.channels.get_mut(&channel)?;
        channel.messages += 1;
        Some(channel.record.topic.clone())
    }

    /// Topics with a wrong message count in the statistics: stated and actual number.
    pub(super) fn counted_otherwise(&self, statistics: &Statistics) -> Vec<(String, u64, u64)> {
        let declared = |id: &u16| statistics.channel_message_counts.get(id).copied().unwrap_or(0);
        let all =
            self.channels.iter().map(|(id, channel)| (channel.record.topic.clone(), declared(id), channel.messages));
        all.filter(|(_, declared, seen)| declared != seen).collect()
    }
}

/// Checks that a type's hash has the right form, and matches its definition if the type is known.
fn judge_hash(report: &mut BagReport, place: &str, topic: &str, declared: (&Schema, &str)) {
    let (schema, hash) = declared;
    let type_name = &schema.name;
    // Recorders omit the hash of the parts of services and actions, which rosbags cannot compute.
    if hash.is_empty() && !type_name.contains("/msg/") {
        return;
    }
    let digits = hash.strip_prefix("RIHS01_").unwrap_or_default();
    if digits.len() != 64 || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        report.warning(place, format!("topic {topic}: type hash '{hash}' is not RIHS01_ and 64 hexadecimal digits"));
        return;
    }
    let Some((is_same_text, known)) = schema.known else { return };
    match (is_same_text, hash == known) {
        (true, true) => {}
        (false, true) => {
            let text = "the recorded definition text is not the one that its type hash stands for";
            report.error(place, format!("topic {topic}: type {type_name}: {text}"));
        }
        (true, false) => {
            let text = format!("its type hash {hash} is not that of the recorded definition text, {known}");
            report.error(place, format!("topic {topic}: type {type_name}: {text}"));
        }
        (false, false) => {
            report.warning(place, format!("topic {topic}: {type_name} was recorded from another definition of it"));
        }
    }
}
