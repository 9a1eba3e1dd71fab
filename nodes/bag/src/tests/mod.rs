// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Bags written and read back.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

use super::check::{BagSeverity, check};
use super::metadata::BagMetadata;
use super::qos::{Durability, Reliability};
use super::recording::{Recording, RecordingOptions};
use super::*;
use tempfile::TempDir;

mod exports;
mod splits;

fn topic(name: &str, type_name: &str) -> Topic {
    let info = camwright_msgs::by_type_name(type_name).expect("the type is one of ours");
    Topic {
        name: name.into(),
        type_name: type_name.into(),
        type_hash: info.type_hash.into(),
        definition: info.schema.into(),
        offered_qos: vec![QosProfile::discovered(Reliability::Reliable, Durability::Volatile)],
    }
}

/// `std_msgs/msg/String` in little-endian CDR.
fn string_cdr(text: &str) -> Vec<u8> {
    let mut data = vec![0, 1, 0, 0];
    let length = u32::try_from(text.len() + 1).expect("a test's text is short");
    data.extend_from_slice(&length.to_le_bytes());
    data.extend_from_slice(text.as_bytes());
    data.push(0);
    data
}

/// Writes `count` strings, 1 ms apart, on two topics in turn.
fn write_bag(path: &Path, preset: Preset, count: u64) -> BagMetadata {
    let options = WriterOptions {
        preset,
        custom_data: BTreeMap::from([("camwright.run_id".into(), "r1".into())]),
        ..WriterOptions::default()
    };
    let mut writer = BagWriter::create(path, &options).expect("the directory is free");
    let ids = [
        writer.add_topic(&topic("/a", "std_msgs/msg/String")).expect("it is open"),
        writer.add_topic(&topic("/b", "std_msgs/msg/String")).expect("it is open"),
    ];
    for i in 0..count {
        let t = 1_760_000_000_000_000_000 + i * 1_000_000;
        let id = ids[usize::from(i % 2 == 1)];
        writer.write(id, t, t - 500, &string_cdr(&format!("message {i}"))).expect("it is open");
        if i % 100 == 99 {
            writer.flush().expect("the disk has room");
        }
    }
    writer.close(RecordingOutcome::Complete, 0).expect("the disk has room")
}

fn read_all(bag: &Bag) -> Vec<BagMessage> {
    let mut messages = bag.messages();
    let mut all = Vec::new();
    while let Some(message) = messages.next_message().expect("the bag is readable") {
        all.push(message);
    }
    all
}

#[test]
fn every_preset_gives_back_every_byte_and_checks_clean() {
    for (_, preset) in Preset::NAMES {
        let dir = TempDir::new().expect("a temporary directory");
        let path = dir.path().join("run");
        let metadata = write_bag(&path, preset, 1001);
        assert_eq!(metadata.message_count, 1001);
        assert_eq!((metadata.starting_time_ns, metadata.duration_ns), (1_760_000_000_000_000_000, 1_000_000_000));
        assert_eq!(BagMetadata::read_from(&path).expect("it was written"), metadata);

        let bag = Bag::open(&path).expect("it was closed");
        assert_eq!(bag.message_counts(), [501, 500]);
        assert_eq!(bag.topics()[0], topic("/a", "std_msgs/msg/String"));
        assert_eq!(bag.custom_data()["camwright.outcome"], "complete");
        let messages = read_all(&bag);
        assert_eq!(messages.len(), 1001);
        for (i, m) in messages.iter().enumerate() {
            let t = 1_760_000_000_000_000_000 + i as u64 * 1_000_000;
            assert_eq!((m.topic, m.log_time_ns, m.publish_time_ns), (i % 2, t, t - 500));
            assert_eq!(m.sequence as usize, i / 2 + 1);
            assert_eq!(m.data, string_cdr(&format!("message {i}")));
        }
        let report = check(&path).expect("there is a bag");
        // What has no chunks has no index either.
        let expected = (preset == Preset::FastWrite).then_some(BagSeverity::Warning);
        assert_eq!((report.worst(), report.findings.len()), (expected, usize::from(expected.is_some())), "{report:?}");
        assert_eq!((report.message_count, report.topic_count), (1001, 2));
    }
}

#[test]
fn reading_can_begin_in_the_middle() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    write_bag(&path, Preset::Default, 1001);
    let bag = Bag::open(&path).expect("it was closed");
    let mut messages = bag.messages_from(1_760_000_000_500_000_000);
    let first = messages.next_message().expect("readable").expect("there are messages from there on");
    assert_eq!(first.log_time_ns, 1_760_000_000_500_000_000);
}

#[test]
fn an_existing_bag_is_never_overwritten() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    write_bag(&path, Preset::Default, 3);
    let before = std::fs::read(path.join("run_0.mcap")).expect("it is there");
    let error = BagWriter::create(&path, &WriterOptions::default()).expect_err("it exists");
    assert!(matches!(error, BagError::Exists { .. }), "{error}");
    assert_eq!(std::fs::read(path.join("run_0.mcap")).expect("it is there"), before);
}

#[test]
fn equal_and_backward_log_times_are_moved_behind_the_message_before() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    let mut writer = BagWriter::create(&path, &WriterOptions::default()).expect("the directory is free");
    let id = writer.add_topic(&topic("/a", "std_msgs/msg/String")).expect("it is open");
    let times: Vec<u64> =
        [0, 0, 5, 5, 5, 3, 10].iter().map(|&t| writer.write(id, t, t, &string_cdr("x")).expect("it is open")).collect();
    assert_eq!(times, [1, 2, 5, 6, 7, 8, 10]);
    writer.close(RecordingOutcome::Complete, 0).expect("the disk has room");
    assert_eq!(check(&path).expect("there is a bag").findings, []);
}

#[test]
fn a_topic_keeps_its_type() {
    let dir = TempDir::new().expect("a temporary directory");
    let mut writer = BagWriter::create(&dir.path().join("run"), &WriterOptions::default()).expect("free");
    let id = writer.add_topic(&topic("/a", "std_msgs/msg/String")).expect("it is open");
    assert_eq!(writer.add_topic(&topic("/a", "std_msgs/msg/String")).expect("it is open"), id);
    let error = writer.add_topic(&topic("/a", "sensor_msgs/msg/JointState")).expect_err("another type");
    assert!(error.to_string().contains("std_msgs/msg/String"), "{error}");
}

#[test]
fn a_bag_without_messages_is_a_bag() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    let writer = BagWriter::create(&path, &WriterOptions::default()).expect("the directory is free");
    writer.close(RecordingOutcome::Complete, 0).expect("the disk has room");
    assert_eq!(check(&path).expect("there is a bag").findings, []);
    assert_eq!(info::BagInfo::read(&path).expect("there is a bag").message_count, 0);
}

/// A killed process leaves everything up to the last flush, a torn tail, and the metadata of the beginning.
#[test]
fn a_recording_that_was_cut_off_reads_up_to_its_last_flush() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    let mut writer = BagWriter::create(&path, &WriterOptions::default()).expect("the directory is free");
    let id = writer.add_topic(&topic("/a", "std_msgs/msg/String")).expect("it is open");
    for i in 0..300_u64 {
        writer.write(id, 1000 + i, 1000 + i, &string_cdr("x")).expect("it is open");
        if i == 199 {
            writer.flush().expect("the disk has room");
        }
    }
    let whole = writer.bytes();
    writer.flush().expect("the disk has room");
    let file = path.join("run_0.mcap");
    let bytes = std::fs::read(&file).expect("it is there");
    // The process ends here without closing; the second flush reached the disk by half.
    std::mem::forget(writer);
    let cut =
        usize::try_from(whole).expect("a small file") + (bytes.len() - usize::try_from(whole).expect("small")) / 2;
    std::fs::write(&file, &bytes[..cut]).expect("the directory is writable");

    let bag = Bag::open(&path).expect("it opens without an index");
    assert!(!bag.files()[0].is_closed);
    assert_eq!(bag.custom_data()["camwright.outcome"], "open");
    assert_eq!(read_all(&bag).len(), 200);
    let report = check(&path).expect("there is a bag");
    assert_eq!(report.worst(), Some(BagSeverity::Error));
    assert!(report.to_text().contains("the recording was killed"), "{}", report.to_text());
}

#[test]
fn a_flipped_bit_anywhere_in_the_messages_is_found() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    write_bag(&path, Preset::Default, 500);
    let file = path.join("run_0.mcap");
    let good = std::fs::read(&file).expect("it is there");
    let needle = b"message 250";
    let at = good.windows(needle.len()).position(|w| w == needle).expect("the chunk is not compressed");
    let mut bad = good.clone();
    bad[at] ^= 0x10;
    std::fs::write(&file, &bad).expect("writable");
    let report = check(&path).expect("there is a bag");
    assert!(report.to_text().contains("CRC failed"), "{}", report.to_text());
}

#[test]
fn metadata_that_disagrees_with_the_file_is_found() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    let mut metadata = write_bag(&path, Preset::Default, 500);
    metadata.topics[1].message_count += 1;
    metadata.write_to(&path).expect("writable");
    let text = check(&path).expect("there is a bag").to_text();
    assert!(text.contains("topic /b has 251 messages, the files have 250"), "{text}");
    std::fs::remove_file(path.join("metadata.yaml")).expect("it is there");
    let text = check(&path).expect("there is a bag").to_text();
    assert!(text.contains("has no metadata.yaml"), "{text}");
    assert_eq!(read_all(&Bag::open(&path).expect("the storage is there")).len(), 500);
}

#[test]
fn a_file_that_is_no_bag_is_refused_without_panic() {
    let dir = TempDir::new().expect("a temporary directory");
    let file = dir.path().join("x.mcap");
    for content in [&b""[..], b"x", b"\x89MCAP0\r\n", b"\x89MCAP0\r\n\x06\xff\xff\xff\xff\xff\xff\xff\x7f"] {
        std::fs::write(&file, content).expect("writable");
        drop(Bag::open(&file));
        assert_eq!(check(&file).expect("there is a file").worst(), Some(BagSeverity::Error));
    }
    assert!(check(&dir.path().join("none")).is_err());
}

#[test]
fn a_recording_writes_all_that_it_was_given() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    let recording = Recording::start(&path, &RecordingOptions::default()).expect("the directory is free");
    let a = recording.add_topic(topic("/a", "std_msgs/msg/String"));
    for i in 0..20_000_u64 {
        assert!(recording.record(&a, 1_000_000 + i, i, string_cdr("x")));
    }
    let (metadata, counts) = recording.stop(RecordingOutcome::Complete).expect("the disk has room");
    assert_eq!(metadata.message_count, 20_000);
    assert_eq!((counts.received, counts.written, counts.dropped, counts.queued_bytes), (20_000, 20_000, 0, 0));
    assert_eq!(check(&path).expect("there is a bag").findings, []);
}

#[test]
fn what_the_queue_cannot_take_is_counted_and_a_fast_topic_leaves_room_for_a_rare_one() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    let options = RecordingOptions { queue_bytes: 40_000, ..RecordingOptions::default() };
    let recording = Recording::start(&path, &options).expect("the directory is free");
    let fast = recording.add_topic(topic("/fast", "std_msgs/msg/String"));
    let rare = recording.add_topic(topic("/rare", "std_msgs/msg/String"));
    let (big, small) = (string_cdr(&"x".repeat(500)), string_cdr("alarm"));
    for i in 0..20_000_u64 {
        recording.record(&fast, i + 1, i, big.clone());
        if i % 100 == 0 {
            assert!(recording.record(&rare, i + 1, i, small.clone()), "a rare message was pushed out");
        }
    }
    let (metadata, counts) = recording.stop(RecordingOutcome::Complete).expect("the disk has room");
    assert_eq!(counts.received, 20_200);
    assert_eq!(counts.received, counts.written + counts.dropped);
    assert_eq!(metadata.message_count, counts.written);
    assert_eq!(metadata.custom_data["camwright.lost_total"], counts.dropped.to_string());
    assert_eq!(counts.topics[1].written, 200);
}

/// A disk that does nothing for a while: the writer's thread waits in the answer to what it was asked.
#[test]
fn while_the_disk_stands_still_rare_topics_have_room_and_every_drop_is_counted_with_its_reason() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    let options = RecordingOptions { queue_bytes: 1 << 20, ..RecordingOptions::default() };
    let recording = Recording::start(&path, &options).expect("the directory is free");
    let [a, b, c, commands] =
        ["/a", "/b", "/c", "/commands"].map(|name| recording.add_topic(topic(name, "std_msgs/msg/String")));
    let (disk, goes_on) = std::sync::mpsc::channel::<()>();
    recording.split(move |_| {
        let _disk = goes_on.recv();
    });
    // 1 KiB each: half of the queue is 512 of them, three quarters are 768, and a 256th, which every topic may have, is four.
    let kilobyte = string_cdr(&"x".repeat(1024 - 9));
    assert_eq!(kilobyte.len(), 1024);
    let give = |topic, count: u64| (1..=count).filter(|&n| recording.record(topic, n, n, kilobyte.clone())).count();
    assert_eq!([give(&a, 2000), give(&b, 2000), give(&c, 2000)], [512, 256, 4], "what of the fast topics has room");
    assert_eq!(give(&commands, 4), 4, "commands have room whatever else waits");
    assert!(recording.report_missed(&a, 2) && !recording.report_missed(&b, 1));
    a.withdraw_missed();
    drop(disk);
    let (metadata, counts) = recording.stop(RecordingOutcome::Complete).expect("the disk has room");
    let reported: Vec<(u64, u64, u64)> = counts.topics.iter().map(|t| (t.received, t.written, t.dropped)).collect();
    assert_eq!(reported, [(2000, 512, 1488), (2000, 256, 1744), (2000, 4, 1996), (4, 4, 0)]);
    assert_eq!((counts.dropped, counts.queue_full, counts.missed), (5228, 5228, 2));
    let custom = |key: &str| metadata.custom_data[&format!("camwright.{key}")].parse::<u64>().expect("a number");
    let lost = ["lost_total", "lost_queue_full", "lost_not_taken", "lost_on_the_way"].map(custom);
    assert_eq!(lost, [5230, 5228, 0, 2]);
    let enqueue =
        ["enqueue_count", "enqueue_p50_ns", "enqueue_p99_ns", "enqueue_p99_9_ns", "enqueue_max_ns"].map(custom);
    assert!(enqueue[0] == 6004 && enqueue[1..].is_sorted() && enqueue[1] > 0, "{enqueue:?}");
    assert_eq!(metadata.message_count, 776);
}

#[test]
fn what_is_recorded_reaches_the_file_within_the_flush_interval() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    let recording = Recording::start(&path, &RecordingOptions::default()).expect("the directory is free");
    let a = recording.add_topic(topic("/a", "std_msgs/msg/String"));
    recording.record(&a, 1000, 1000, string_cdr("x"));
    // A tenth of a second is the interval; the rest is for a busy test machine.
    let deadline = Instant::now() + Duration::from_secs(5);
    loop {
        let bag = Bag::open(&path).expect("it opens while it is written");
        if read_all(&bag).len() == 1 {
            break;
        }
        assert!(Instant::now() < deadline, "nothing reached the file");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_bag_that_is_recorded_on_is_read_as_it_was_when_it_was_opened() {
    let dir = TempDir::new().expect("a temporary directory");
    let path = dir.path().join("run");
    let mut writer = BagWriter::create(&path, &WriterOptions::default()).expect("the directory is free");
    let mut opened = vec![Bag::open(&path).expect("it opens while it is written")];
    for (count, name) in (1..).zip(["/a", "/b", "/c"]) {
        let id = writer.add_topic(&topic(name, "std_msgs/msg/String")).expect("it is open");
        writer.write(id, count, count, &string_cdr("x")).expect("it is open");
        writer.flush().expect("the disk has room");
        opened.push(Bag::open(&path).expect("it opens while it is written"));
    }
    writer.close(RecordingOutcome::Complete, 0).expect("the disk has room");
    for (count, bag) in opened.iter().enumerate() {
        assert_eq!((bag.topics().len(), read_all(bag).len()), (count, count));
    }
}

/// Every message of a recovered bag is one of the original's, and missing ones are reported.
fn judge_recovery(original: &[BagMessage], damaged: &Path, into: &Path, what: &str) -> usize {
    let recovery = recover::recover(damaged, into).unwrap_or_else(|error| panic!("{what}: {error}"));
    let found = read_all(&Bag::open(into).expect("it was closed"));
    assert_eq!(found.len() as u64, recovery.message_count, "{what}");
    let mut from = original.iter();
    for message in &found {
        assert!(from.any(|m| m == message), "{what}: {message:?} was never written, or stood before another");
    }
    let missing = original.len() - found.len();
    assert!(missing == 0 || !recovery.is_whole(), "{what}: {missing} are missing and nothing is reported");
    assert!(missing > 0 || recovery.missing.is_empty(), "{what}: {recovery:?}");
    missing
}

#[test]
fn a_whole_bag_is_recovered_whole_and_never_over_another() {
    let dir = TempDir::new().expect("a temporary directory");
    let (path, into) = (dir.path().join("run"), recover::beside(&dir.path().join("run")));
    write_bag(&path, Preset::Zstd, 1001);
    let original = read_all(&Bag::open(&path).expect("it was closed"));
    assert_eq!(judge_recovery(&original, &path, &into, "whole"), 0);
    let report = check(&into).expect("there is a bag");
    assert_eq!(report.worst(), None, "{}", report.to_text());
    assert_eq!(Bag::open(&into).expect("a bag").custom_data()["camwright.run_id"], "r1");
    assert!(into.ends_with("run_recovered"));
    assert!(matches!(recover::recover(&path, &into), Err(BagError::Exists { .. })));
    assert!(recover::recover(&dir.path().join("nothing"), &dir.path().join("new")).is_err());
    assert!(!dir.path().join("new").exists(), "what fails leaves nothing behind");
}

#[test]
fn a_file_cut_anywhere_gives_back_all_that_is_whole_before_the_cut() {
    for preset in [Preset::Default, Preset::Zstd, Preset::FastWrite] {
        let dir = TempDir::new().expect("a temporary directory");
        let path = dir.path().join("run");
        write_bag(&path, preset, 1001);
        let original = read_all(&Bag::open(&path).expect("it was closed"));
        let storage = path.join("run_0.mcap");
        let bytes = std::fs::read(&storage).expect("it was written");
        // Seeded by the place in the list: 40 cuts over the whole file.
        let mut last = usize::MAX;
        for cut in (1..=40_usize).map(|n| bytes.len() * n / 41 + n % 7) {
            std::fs::write(&storage, &bytes[..cut]).expect("it can be cut");
            let into = dir.path().join(format!("cut_{cut}"));
            let missing = judge_recovery(&original, &path, &into, &format!("{preset:?} cut at {cut}"));
            assert!(missing <= last, "a later cut leaves no less");
            last = missing;
            let report = check(&into).expect("there is a bag");
            let worst = report.worst();
            assert!(
                worst.is_none() || (preset == Preset::FastWrite && worst == Some(BagSeverity::Warning)),
                "{}",
                report.to_text()
            );
        }
        assert!(last < 110, "of the last cut at most a chunk is missing: {last}");
    }
}

#[test]
fn one_flipped_bit_costs_at_most_one_chunk_and_is_reported() {
    for preset in [Preset::Default, Preset::Zstd] {
        let dir = TempDir::new().expect("a temporary directory");
        let path = dir.path().join("run");
        write_bag(&path, preset, 1001);
        let original = read_all(&Bag::open(&path).expect("it was closed"));
        let storage = path.join("run_0.mcap");
        let bytes = std::fs::read(&storage).expect("it was written");
        let mut reported = 0;
        for n in 0..120_usize {
            // All parts of the file, and all bits: 7919 and 5 have no factor in common with what they walk through.
            let (at, bit) = (n * 7919 % bytes.len(), n * 5 % 8);
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << bit;
            std::fs::write(&storage, &flipped).expect("it can be flipped");
            let into = dir.path().join(format!("flip_{n}"));
            let missing = judge_recovery(&original, &path, &into, &format!("{preset:?}, bit {bit} of byte {at}"));
            assert!(missing <= 200, "{preset:?}, bit {bit} of byte {at}: {missing} messages are missing");
            reported += usize::from(missing > 0);
        }
        assert!(reported > 20, "most of a file is chunks: {reported} of 120 flips cost something");
    }
}
