// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Summaries of a bag in `metadata.yaml`, in its storage and by its recorder, compared with its content.

use super::report::BagReport;
use super::walk::BagWalk;
use crate::metadata::RECORDER_VERSION;
use crate::metadata::{self, BagMetadata, NO_START_NS};
use crate::writer::REPEATED;

const PLACE: &str = metadata::FILE_NAME;
const CUSTOM: &str = "custom_data";

/// Holds all accounts against each other. A bag that is one file has no `metadata.yaml`.
pub(super) fn agree(walk: &mut BagWalk, yaml: Option<&BagMetadata>) {
    let mut report = std::mem::take(&mut walk.report);
    walk.order.add_to(&mut report);
    // What a file has lost is no fault of the account.
    if let Some(yaml) = yaml.filter(|_| !walk.is_damaged) {
        let before = report.findings.len();
        in_all(walk, &mut report, yaml);
        by_topic(walk, &mut report, yaml);
        by_file(walk, &mut report, yaml);
        if let Some(record) = walk.record.as_ref().filter(|_| report.findings.len() == before) {
            differences(&mut report, yaml, record);
        }
    }
    check_recorded_summary(walk, &mut report, yaml);
    walk.report = report;
}

fn in_all(walk: &BagWalk, report: &mut BagReport, yaml: &BagMetadata) {
    let seen = report.message_count;
    if yaml.message_count != seen {
        report.error(PLACE, format!("message_count is {}, the files have {seen}", yaml.message_count));
    }
    let sum = |counts: &mut dyn Iterator<Item = u64>| counts.fold(0, u64::saturating_add);
    let by_topic = sum(&mut yaml.topics.iter().map(|t| t.message_count));
    let by_file = sum(&mut yaml.files.iter().map(|f| f.message_count));
    if by_topic != yaml.message_count || by_file != yaml.message_count {
        let declared = yaml.message_count;
        let text = format!("message_count is {declared}, its topics add up to {by_topic}, its files to {by_file}");
        report.error(PLACE, text);
    }
    let times_ns = walk.files.iter().filter_map(|(_, file)| file.log_times_ns);
    if let Some((first, last)) = times_ns.reduce(|all, of| (all.0.min(of.0), all.1.max(of.1)))
        && (yaml.starting_time_ns, yaml.duration_ns) != (first, last - first)
    {
        let (start, duration) = (yaml.starting_time_ns, yaml.duration_ns);
        let lasts = last - first;
        let text = format!("starts at {start} ns for {duration} ns, the messages at {first} ns for {lasts} ns");
        report.error(PLACE, text);
    }
}

fn by_topic(walk: &BagWalk, report: &mut BagReport, yaml: &BagMetadata) {
    for topic in &yaml.topics {
        let name = &topic.name;
        match walk.counts.get(name) {
            Some(count) if *count == topic.message_count => {}
            Some(n) => {
                report.error(PLACE, format!("topic {name} has {} messages, the files have {n}", topic.message_count));
            }
            None => report.error(PLACE, format!("topic {name} is not in the files")),
        }
        if let Some(seen) = walk.topics.get(name)
            && (&seen.type_name, &seen.hash) != (&topic.type_name, &topic.type_hash)
        {
            report.error(PLACE, format!("topic {name}: type or hash is not that of the file ({})", seen.type_name));
        }
    }
    let listed: std::collections::BTreeSet<&String> = yaml.topics.iter().map(|topic| &topic.name).collect();
    if listed.len() < yaml.topics.len() {
        report.error(PLACE, "it lists a topic more than once");
    }
    for name in walk.counts.keys().filter(|name| !listed.contains(name)) {
        report.error(PLACE, format!("topic {name} of the files is not listed"));
    }
}

/// The entry of each file against the file.
fn by_file(walk: &BagWalk, report: &mut BagReport, yaml: &BagMetadata) {
    for (declared, (name, seen)) in yaml.files.iter().zip(&walk.files) {
        let (first, last) = seen.log_times_ns.unwrap_or((NO_START_NS, NO_START_NS));
        let figures = [
            ("message_count", declared.message_count, seen.messages),
            ("starting_time", declared.starting_time_ns, first),
            ("duration", declared.duration_ns, last - first),
        ];
        for (key, declared, seen) in figures.iter().filter(|(_, declared, seen)| declared != seen) {
            report.error(PLACE, format!("{key} of file {name} is {declared}, the file has {seen}"));
        }
    }
}

/// Differences between `metadata.yaml` and the last record within the storage that the content of the files does not decide.
fn differences(report: &mut BagReport, yaml: &BagMetadata, record: &BagMetadata) {
    let differs = [
        ("message_count", yaml.message_count != record.message_count),
        ("topics_with_message_count", yaml.topics != record.topics),
        ("files", yaml.files != record.files),
        ("custom_data", yaml.custom_data != record.custom_data),
        ("ros_distro", yaml.ros_distro != record.ros_distro),
    ];
    let keys: Vec<&str> = differs.iter().filter(|(_, differs)| *differs).map(|(key, _)| *key).collect();
    // Recorders that split leave in each file what they knew when it was closed.
    if !keys.is_empty() && (yaml.files.len() == 1 || yaml.custom_data.contains_key(RECORDER_VERSION)) {
        let keys = keys.join(", ");
        report.warning(PLACE, format!("it differs from the metadata record within the last file in {keys}"));
    }
}

/// Checks the recorder's own summary of the run.
fn check_recorded_summary(walk: &BagWalk, report: &mut BagReport, yaml: Option<&BagMetadata>) {
    let Some(declared) = walk.record.as_ref().or(yaml).map(|m| m.custom_data.clone()) else { return };
    let is_ours = declared.contains_key(RECORDER_VERSION);
    let lost: u64 = match declared.get("camwright.lost_total").map(|lost| lost.parse()) {
        Some(Ok(lost)) => lost,
        Some(Err(_)) => {
            report.error(CUSTOM, format!("camwright.lost_total '{}' is no number", declared["camwright.lost_total"]));
            0
        }
        None => 0,
    };
    if lost > 0 {
        report.warning(CUSTOM, format!("{lost} messages were received and are not in the bag"));
    }
    if is_ours && !walk.is_damaged {
        let (seen, repeated) = (walk.repeated, declared.get(REPEATED).map_or("0", String::as_str));
        if repeated != seen.to_string() {
            let text = format!("{repeated} messages are to stand at the head of a later file once more, {seen} do");
            report.error(CUSTOM, text);
        }
        latched(walk, report);
        account(walk, report, lost);
    }
    match declared.get("camwright.outcome").map(String::as_str) {
        Some("fault") => {
            let reason = declared.get("camwright.fault").map_or("", String::as_str);
            report.warning(CUSTOM, format!("the recording ended early: {reason}"));
        }
        Some("open") if !walk.is_damaged => report.warning(CUSTOM, "the recording is still marked as open"),
        _ => {}
    }
}

/// Every later file begins with the last message of each latched topic.
fn latched(walk: &BagWalk, report: &mut BagReport) {
    for (name, topic) in &walk.topics {
        for file in &topic.headless {
            report.error(
                file.as_str(),
                format!("topic {name} is latched, and its last message does not stand at the head"),
            );
        }
    }
}

/// Checks the last counts of the recorder: the bag cannot have fewer messages, and cannot have lost more.
fn account(walk: &BagWalk, report: &mut BagReport, lost: u64) {
    let accounts: Vec<_> =
        walk.topics.iter().filter_map(|(name, topic)| Some((name, topic.account.as_ref()?))).collect();
    // Two recorders in the graph receive each other's status, and one that continued in another bag first reported that one.
    let is_of_this = |bag: &str| walk.files.first().is_some_and(|(file, _)| file.starts_with(&format!("{bag}_")));
    let [(name, account)] = accounts[..] else { return };
    if account.bag.is_empty() || !is_of_this(&account.bag) {
        return;
    }
    let seen = report.message_count - walk.repeated;
    if account.written > seen {
        let declared = account.written;
        report.error(CUSTOM, format!("{name} reports {declared} messages written, the bag has {seen}"));
    }
    if account.dropped > lost {
        let declared = account.dropped;
        report.error(CUSTOM, format!("{name} reports {declared} lost messages, camwright.lost_total is {lost}"));
    }
}
