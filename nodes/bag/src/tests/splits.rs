// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Bags of several files, and recordings of which only snapshots are written.

use super::*;
use crate::SnapshotOptions;
use crate::recover::recover;
use crate::writer::{DELETED, REPEATED, SplitLimits};

const SECOND: u64 = 1_000_000_000;
const START: u64 = 1_760_000_000 * SECOND;

fn latched(name: &str) -> Topic {
    Topic {
        offered_qos: vec![QosProfile::discovered(Reliability::Reliable, Durability::TransientLocal)],
        ..topic(name, "std_msgs/msg/String")
    }
}

fn split_by(bytes: Option<u64>, seconds: Option<u64>) -> WriterOptions {
    WriterOptions {
        split: SplitLimits { bytes, duration: seconds.map(Duration::from_secs), files: None },
        ..WriterOptions::default()
    }
}

/// A page every ten seconds on a latched topic, a sample ten times a second, for 60 s; with the files split by `options`.
fn write_files(path: &Path, options: &WriterOptions) -> BagMetadata {
    let mut writer = BagWriter::create(path, options).expect("the directory is free");
    let pages = writer.add_topic(&latched("/pages")).expect("it is open");
    let samples = writer.add_topic(&topic("/samples", "std_msgs/msg/String")).expect("it is open");
    for i in 0..600 {
        let t = START + i * SECOND / 10;
        if i % 100 == 0 {
            writer.write(pages, t, t, &string_cdr(&format!("page {}", i / 100))).expect("it is open");
        }
        writer.write(samples, t + 1, t, &string_cdr(&"x".repeat(500))).expect("it is open");
        writer.flush().expect("the disk has room");
    }
    assert_eq!((writer.written(pages), writer.written(samples)), (6, 600));
    writer.close(RecordingOutcome::Complete, 0).expect("the disk has room")
}

fn files_of(metadata: &BagMetadata) -> Vec<(&str, u64)> {
    metadata.files.iter().map(|file| (file.path.as_str(), file.message_count)).collect()
}

#[test]
fn a_bag_that_is_split_by_time_begins_every_file_with_what_is_latched() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    let metadata = write_files(&path, &split_by(None, Some(20)));
    // Pages of 0, 10 and 20 s with samples up to there; then pages of 30 and 40 s behind three that are repeated; then five of them.
    assert_eq!(files_of(&metadata), [("run_0.mcap", 203), ("run_1.mcap", 3 + 203), ("run_2.mcap", 5 + 200)]);
    assert_eq!((metadata.message_count, metadata.custom_data[REPEATED].as_str()), (614, "8"));
    let report = check(&path).expect("there is a bag");
    assert_eq!(report.findings, [], "{}", report.to_text());
    let bag = Bag::open(&path).expect("it was closed");
    let messages = read_all(&bag);
    assert_eq!(messages.len(), 606, "repetitions come once");
    assert!(messages.windows(2).all(|pair| pair[0].log_time_ns < pair[1].log_time_ns));
    // Each file alone has what a late listener needs.
    let last = Bag::open(&path.join("run_2.mcap")).expect("it was closed");
    let pages: Vec<Vec<u8>> = read_all(&last).into_iter().filter(|m| m.topic == 0).map(|m| m.data).collect();
    assert_eq!(pages, (0..6).map(|n| string_cdr(&format!("page {n}"))).collect::<Vec<_>>());
    // From the middle on, what comes there comes once.
    let mut middle = bag.messages_from(START + 30 * SECOND);
    let mut pages = Vec::new();
    while let Some(message) = middle.next_message().expect("it is readable") {
        if message.topic == 0 {
            pages.push(message.sequence);
        }
    }
    assert_eq!(pages, [4, 5, 6]);
}

/// A bag of two files at most: the oldest is deleted at a split, and what is left is a bag of its own.
#[test]
fn a_bag_retains_its_newest_files() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    let mut options = split_by(None, Some(10));
    options.split.files = Some(2);
    let metadata = write_files(&path, &options);
    // Six files of 10 s, of which the last two remain. Four pages are repeated at the head of the first, and those of 40 and 50 s follow.
    assert_eq!(files_of(&metadata), [("run_4.mcap", 4 + 2 + 100), ("run_5.mcap", 6 + 99)]);
    let counts: Vec<u64> = metadata.topics.iter().map(|topic| topic.message_count).collect();
    assert_eq!((metadata.message_count, counts), (211, vec![4 + 2 + 6, 100 + 99]));
    assert_eq!((metadata.custom_data[DELETED].as_str(), metadata.custom_data[REPEATED].as_str()), ("4", "6"));
    let mut names: Vec<_> = std::fs::read_dir(&path).expect("it is there").flatten().map(|f| f.file_name()).collect();
    names.sort();
    assert_eq!(names, ["metadata.yaml", "run_4.mcap", "run_5.mcap"]);
    let report = check(&path).expect("there is a bag");
    assert_eq!(report.findings, [], "{}", report.to_text());
    let pages = read_all(&Bag::open(&path).expect("it was closed")).into_iter().filter(|m| m.topic == 0);
    assert_eq!(pages.map(|page| page.sequence).collect::<Vec<_>>(), [1, 2, 3, 4, 5, 6], "latched messages stay");
}

#[test]
fn a_bag_is_split_by_size_and_by_request_and_never_into_files_of_repetitions_alone() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("by_size");
    let metadata = write_files(&path, &split_by(Some(100_000), None));
    assert!(metadata.files.len() > 3, "{:?}", files_of(&metadata));
    for file in &metadata.files[..metadata.files.len() - 1] {
        let bytes = std::fs::metadata(path.join(&file.path)).expect("it is there").len();
        assert!((100_000..130_000).contains(&bytes), "{}: {bytes}", file.path);
    }
    assert_eq!(check(&path).expect("there is a bag").findings, []);

    let path = dir.path().join("tiny");
    let options = split_by(Some(1), None);
    let mut writer = BagWriter::create(&path, &options).expect("the directory is free");
    let pages = writer.add_topic(&latched("/pages")).expect("it is open");
    for i in 0..5 {
        writer.write(pages, START + i, START, &string_cdr("page")).expect("it is open");
        writer.flush().expect("the disk has room");
    }
    writer.split().expect("the disk has room");
    assert_eq!(writer.take_splits().last(), Some(&("tiny_4.mcap".to_owned(), "tiny_5.mcap".to_owned())));
    let metadata = writer.close(RecordingOutcome::Complete, 0).expect("the disk has room");
    assert_eq!(files_of(&metadata).iter().map(|file| file.1).collect::<Vec<_>>(), [1, 2, 3, 4, 5, 5]);
    assert_eq!(check(&path).expect("there is a bag").findings, []);
}

#[test]
fn a_killed_bag_of_several_files_is_recovered_as_one_with_every_message_once() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    write_files(&path, &split_by(None, Some(20)));
    // The second file is torn, and of the first the part is flipped in which the second page stands.
    let torn = path.join("run_2.mcap");
    let bytes = std::fs::read(&torn).expect("it is there");
    std::fs::write(&torn, &bytes[..bytes.len() / 2]).expect("the directory is ours");
    let first = path.join("run_0.mcap");
    let mut bytes = std::fs::read(&first).expect("it is there");
    let at = bytes.windows(6).position(|text| text == b"page 1").expect("it is in there");
    bytes[at] ^= 1;
    std::fs::write(&first, bytes).expect("the directory is ours");
    let into = dir.path().join("new");
    let recovery = recover(&path, &into).expect("there is something to recover");
    assert!(recovery.was_open && !recovery.missing.contains_key("/pages"), "{}", recovery.to_text());
    let report = check(&into).expect("there is a bag");
    assert_eq!(report.worst(), recovery.missing.values().any(|n| *n > 0).then_some(BagSeverity::Error), "{report:?}");
    let bag = Bag::open(&into).expect("it was closed");
    let mut pages: Vec<u32> = read_all(&bag).iter().filter(|m| m.topic == 0).map(|m| m.sequence).collect();
    pages.sort_unstable();
    assert_eq!(pages, [1, 2, 3, 4, 5, 6]);
}

#[test]
fn a_number_that_comes_again_in_a_first_file_and_a_gap_between_files_are_found() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    write_files(&path, &split_by(None, Some(20)));
    // Without its second file the bag has a gap of numbers, and its account is wrong.
    let mut metadata = BagMetadata::read_from(&path).expect("it was written");
    metadata.files.remove(1);
    metadata.relative_file_paths.remove(1);
    metadata.write_to(&path).expect("the directory is ours");
    let text = check(&path).expect("there is a bag").to_text();
    assert!(text.contains("run_2.mcap: topic /samples: 201 messages are missing by their numbers"), "{text}");
    assert!(text.contains("8 messages are to stand at the head of a later file once more, 3 do"), "{text}");

    let path = dir.path().join("doubled");
    let mut writer = BagWriter::create(&path, &WriterOptions::default()).expect("the directory is free");
    let id = writer.add_topic(&topic("/a", "std_msgs/msg/String")).expect("it is open");
    for (sequence, time) in [(1, 1), (2, 2), (2, 3)] {
        let (log_time_ns, publish_time_ns) = (START + time, START);
        let message = BagMessage { topic: 0, sequence, log_time_ns, publish_time_ns, data: string_cdr("x") };
        writer.copy(id, &message).expect("it is open");
    }
    writer.close(RecordingOutcome::Complete, 0).expect("the disk has room");
    let text = check(&path).expect("there is a bag").to_text();
    assert!(text.contains("topic /a: 1 messages have a number that was there before"), "{text}");
}

#[test]
fn snapshots_write_the_last_seconds_and_latched_messages() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    let options = RecordingOptions {
        snapshot: Some(SnapshotOptions { keep: Duration::from_secs(2), bytes: 1 << 20 }),
        ..RecordingOptions::default()
    };
    let recording = Recording::start(&path, &options).expect("the directory is free");
    let pages = recording.add_topic(latched("/pages"));
    let samples = recording.add_topic(topic("/samples", "std_msgs/msg/String"));
    assert!(recording.record(&pages, START, START, string_cdr("page 0")));
    let send = |from: u64, to: u64| {
        for i in from..to {
            let t = START + 1 + i * SECOND / 10;
            assert!(recording.record(&samples, t, t, string_cdr(&format!("{i}"))));
        }
    };
    send(0, 100);
    let snapshot = || {
        let (answer, answered) = std::sync::mpsc::channel();
        recording.snapshot(move |count| answer.send(count).expect("it is waited for"));
        answered.recv()
    };
    assert_eq!(snapshot(), Ok(21), "two seconds and their first sample");
    send(100, 105);
    assert_eq!(snapshot(), Ok(5), "what was written is not written again");
    send(105, 110);
    let (metadata, counts) = recording.stop(RecordingOutcome::Complete).expect("the disk has room");
    assert_eq!((counts.received, counts.written, counts.passed, counts.dropped), (111, 27, 84, 0));
    assert_eq!((counts.files, counts.repeated), (3, 2));
    assert_eq!(files_of(&metadata), [("run_0.mcap", 22), ("run_1.mcap", 1 + 5), ("run_2.mcap", 1)]);
    let report = check(&path).expect("there is a bag");
    assert_eq!(report.findings, [], "{}", report.to_text());
}

#[test]
fn a_recording_does_not_begin_with_less_room_than_it_is_to_leave_and_ends_before_there_is_less() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    let options = |min_free_bytes| RecordingOptions {
        min_free_bytes,
        sync_interval: Duration::from_millis(1),
        flush_interval: Duration::from_millis(1),
        ..RecordingOptions::default()
    };
    let error = Recording::start(&path, &options(u64::MAX)).expect_err("no disk is as large");
    assert!(matches!(error, BagError::NoRoom { needed: u64::MAX, .. }), "{error}");
    assert!(!path.exists(), "nothing is left behind");
    let recording = Recording::start(&path, &options(1)).expect("a byte is free");
    assert!(recording.counts().free_bytes > 0);
    recording.stop(RecordingOutcome::Complete).expect("the disk has room");
}
