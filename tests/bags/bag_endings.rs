// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! End of a recording without closing: a kill, a full disk, a file system that fails.
#![allow(clippy::print_stdout, reason = "a test shows its seed and what it measured")]

use crate::bag_judges;
use crate::support;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use camwright_bag::check::{BagSeverity, check};
use camwright_bag::qos::{Durability, Reliability};
use camwright_bag::recording::{Recording, RecordingOptions};
use camwright_bag::recover;
use camwright_bag::{Bag, QosProfile, RecordingOutcome, Topic, WriterOptions};
use support::Domain;

/// Number of messages that other readers count in a bag; they decode every message of it.
fn assert_judged(bag: &Path, messages: u64) {
    if let Some(counts) = bag_judges::foxglove_counts(bag) {
        assert_eq!(counts["messages"], messages, "Foxglove's reader");
    }
    if let Some(counts) = bag_judges::rosbags_counts(bag, &Domain::reserve()) {
        assert_eq!(counts["messages"], messages, "rosbags and mcap");
    }
}

/// Variable with the bag folder of a test's child process, and its message rate.
const CHILD: &str = "CAMWRIGHT_TEST_BAG_CHILD";

fn directory() -> PathBuf {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("bag-endings-{}-{number}", std::process::id()));
    std::fs::create_dir_all(&path).expect("the target directory is writable");
    path
}

fn now_ns() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).expect("the clock is after 1970");
    u64::try_from(since.as_nanos()).expect("the clock is before 2554")
}

fn text(text: &str) -> Vec<u8> {
    let length = u32::try_from(text.len() + 1).expect("a test's text is short");
    [&[0, 1, 0, 0][..], &length.to_le_bytes(), text.as_bytes(), &[0]].concat()
}

fn topic(name: &str) -> Topic {
    let info = camwright_msgs::by_type_name("std_msgs/msg/String").expect("it is a standard type");
    Topic {
        name: name.into(),
        type_name: info.type_name.into(),
        type_hash: info.type_hash.into(),
        definition: info.schema.into(),
        offered_qos: vec![QosProfile::discovered(Reliability::Reliable, Durability::Volatile)],
    }
}

/// Not a test: the process that a test starts, which records until it is killed or its disk is full. Prints at its end
/// what it counted.
#[test]
#[ignore = "it is started by the other tests"]
fn child_that_records() {
    let Ok(arguments) = std::env::var(CHILD) else { return };
    let (path, per_second) = arguments.rsplit_once('@').expect("directory@rate");
    let per_second: u128 = per_second.parse().expect("a rate");
    let options = RecordingOptions { writer: WriterOptions::default(), ..RecordingOptions::default() };
    let recording = Recording::start(Path::new(path), &options).expect("the directory is free");
    let joints = recording.add_topic(topic("/joints"));
    let begin = Instant::now();
    let mut sent = 0_u128;
    while recording.fault().is_none() {
        while sent < begin.elapsed().as_micros() * per_second / 1_000_000 {
            recording.record(&joints, now_ns(), now_ns(), text(&format!("{sent:>200}")));
            sent += 1;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    let fault = recording.fault().expect("the loop ended by it").to_owned();
    let (_, counts) = match recording.stop(RecordingOutcome::Complete) {
        Ok(all) => all,
        Err(error) => {
            eprintln!("not closed: {error}");
            return;
        }
    };
    eprintln!("fault {fault}");
    eprintln!("counts {} {} {}", counts.received, counts.written, counts.dropped);
}

/// This test program, and what makes it the child.
fn as_child() -> (String, [&'static str; 4]) {
    let program = std::env::current_exe().expect("a running program has a path").display().to_string();
    (program, ["--exact", "bag_endings::child_that_records", "--ignored", "--nocapture"])
}

/// Numbers from a seed (splitmix64).
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// A message waits 100 ms at most before the system has it. The rest of the bound is for a test machine on which every core
/// has other work: the writer may get its turn late.
const LARGEST_LOSS: Duration = Duration::from_millis(600);

#[test]
fn a_kill_at_any_time_costs_no_more_than_the_flush_interval() {
    let mut seed = now_ns();
    println!("seed {seed}");
    let mut losses = Vec::new();
    for _ in 0..20 {
        let bag = directory().join("run");
        let (program, arguments) = as_child();
        let mut child = Command::new(program)
            .args(arguments)
            .env(CHILD, format!("{}@20000", bag.display()))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the test can start itself");
        let storage = bag.join("run_0.mcap");
        let deadline = Instant::now() + Duration::from_secs(60);
        while std::fs::metadata(&storage).map_or(0, |m| m.len()) < 10_000 {
            assert!(Instant::now() < deadline, "the child records nothing");
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_micros(random(&mut seed) % 400_000));
        // SIGKILL.
        child.kill().expect("the child runs");
        let killed_ns = now_ns();
        child.wait().expect("it was started here");

        let read = Bag::open(&bag).expect("a killed recording opens without repair");
        let (_, last_ns) = read.log_times_ns().expect("something was recorded");
        assert_eq!(read.custom_data()["camwright.outcome"], "open");
        assert_eq!(read.topics().len(), 1);
        let mut messages = read.messages();
        let mut count = 0_u32;
        while let Some(message) = messages.next_message().expect("what is whole is readable") {
            count += 1;
            assert_eq!(message.sequence, count, "a message is missing in the middle");
        }
        losses.push(Duration::from_nanos(killed_ns.saturating_sub(last_ns)));
        let into = recover::beside(&bag);
        let recovery = recover::recover(&bag, &into).expect("there is room beside it");
        assert_eq!((recovery.message_count, recovery.missing.len()), (u64::from(count), 0), "{}", recovery.to_text());
        assert!(recovery.was_open && recovery.losses.len() <= 1, "a torn tail at most: {}", recovery.to_text());
        let report = check(&into).expect("there is a bag");
        assert_eq!(report.worst(), None, "{}", report.to_text());
        assert_judged(&into, u64::from(count));
        std::fs::remove_dir_all(bag.parent().expect("it was made within one")).expect("it is ours");
    }
    println!("lost: {losses:?}");
    let worst = losses.iter().max().expect("there were twenty");
    assert!(*worst < LARGEST_LOSS, "{worst:?} of messages were lost");
}

/// Last output of the child.
fn counts(stderr: &str) -> [u64; 3] {
    let line =
        stderr.lines().find_map(|l| l.strip_prefix("counts ")).unwrap_or_else(|| panic!("no counts in:\n{stderr}"));
    let numbers: Vec<u64> = line.split(' ').map(|n| n.parse().expect("a count")).collect();
    numbers.try_into().expect("three counts")
}

#[test]
fn a_full_disk_ends_the_recording_with_a_whole_bag_and_a_clear_sentence() {
    let directory = directory();
    let disk = directory.join("disk");
    std::fs::create_dir_all(&disk).expect("the directory is ours");
    let (program, arguments) = as_child();
    // A file system of 12 MB of our own, in a namespace that ends with the shell.
    let script = "mount -t tmpfs -o size=12m tmpfs \"$DISK\" || exit 77; \"$@\"; cp -r \"$DISK/run\" \"$DISK/../copy\"";
    let output = Command::new("unshare")
        .args(["--user", "--map-root-user", "--mount", "sh", "-c", script, "sh", &program])
        .args(arguments)
        .env("DISK", &disk)
        .env(CHILD, format!("{}/run@20000", disk.display()))
        .output();
    let stderr = match &output {
        Ok(output) if output.status.code() != Some(77) => String::from_utf8_lossy(&output.stderr).into_owned(),
        other => {
            println!("SKIPPED: this machine lets no test mount a small disk ({other:?})");
            return;
        }
    };
    assert!(stderr.contains("fault no room for more in"), "{stderr}");
    let [received, written, dropped] = counts(&stderr);
    assert_eq!(received, written + dropped);

    let bag = directory.join("copy");
    // The copy has another name than its storage file, which does not matter.
    let report = check(&bag).expect("the bag was copied");
    assert_eq!(report.worst(), Some(BagSeverity::Warning), "{}", report.to_text());
    assert!(report.to_text().contains("the recording ended early: no room"), "{}", report.to_text());
    assert_eq!(report.message_count, written);
    let read = Bag::open(&bag).expect("it is closed");
    assert!(read.files()[0].is_closed);
    assert_eq!(read.custom_data()["camwright.outcome"], "fault");
    std::fs::remove_dir_all(&directory).expect("it is ours");
}

#[test]
fn a_file_that_may_grow_no_further_keeps_what_is_whole() {
    let directory = directory();
    let bag = directory.join("run");
    let (program, arguments) = as_child();
    // No spare room helps against a limit on the file's own size: 6 MB, of which the spare takes 4 in its own file.
    let script = "trap '' XFSZ; ulimit -f 12000; exec \"$@\"";
    let output = Command::new("sh")
        .args(["-c", script, "sh", &program])
        .args(arguments)
        .env(CHILD, format!("{}@20000", bag.display()))
        .output()
        .expect("there is a shell");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(stderr.contains("not closed: "), "{stderr}");

    let read = Bag::open(&bag).expect("it opens like that of a killed recording");
    let mut messages = read.messages();
    let mut count = 0_u32;
    while let Some(message) = messages.next_message().expect("what is whole is readable") {
        count += 1;
        assert_eq!(message.sequence, count);
    }
    assert!(count > 10_000, "only {count} messages are left");
    std::fs::remove_dir_all(&directory).expect("it is ours");
}
