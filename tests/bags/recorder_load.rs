// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The recorder's process under a load that any computer carries, on a full disk, and during shutdown: every message is accounted
//! for, once. The benchmark `recorder_load` has the same with more.
#![allow(clippy::print_stdout, reason = "a test shows what it measured")]
#![allow(unreachable_pub, reason = "a test binary has no outside")]

#[path = "../benchmarks/recorder_load/account.rs"]
mod account;
#[path = "../benchmarks/recorder_load/cell.rs"]
mod cell;
#[path = "../benchmarks/recorder_load/load.rs"]
mod load;
#[path = "../benchmarks/recorder_load/recorders.rs"]
mod recorders;
use crate::support;
#[path = "../benchmarks/recorder_load/usage.rs"]
mod usage;

use account::{ReportedLosses, disagreements, enqueue, lost};
use camwright_bag::Bag;
use camwright_bag::check::{BagSeverity, check};
use camwright_msgs::camwright_msgs::action::{MoveTo, MoveToGoal};
use camwright_msgs::rosbag2_interfaces::msg::MessagesLostEvent;
use camwright_msgs::std_msgs::msg::String as Text;
use camwright_ros::{GoalStatus, Node, Qos};
use load::{LAST, Load, Publisher, Stack, TOPIC};
use recorders::RunLoggerProcess;
use std::process::Command;
use std::sync::mpsc;
use std::time::{Duration, Instant};
use support::{Domain, Folder, PATIENCE, peer_env, repository};

/// Records a load of Cyclone DDS; what was lost, when all else adds up. None where the peers are to be skipped.
fn record(name: &str, is_reliable: bool, per_second: u64, seconds: u64) -> Option<ReportedLosses> {
    let env = peer_env()?;
    let (domain, folder) = (Domain::reserve(), Folder::new(name));
    let load = Load { stack: Stack::Cyclone, is_reliable, octets: 200, per_second, seconds };
    let recorder = RunLoggerProcess::start(&domain, &folder.join("run"), &[TOPIC]);
    let mut publisher = Publisher::start(load, Some(env), &domain);
    publisher.wait_matched();
    recorder.wait_for_topics(&[TOPIC]);
    let sent = publisher.publish(|| {});
    assert_eq!(sent.sent, per_second * seconds + LAST);
    let reported = recorder.wait_settled(sent.sent);
    let (bag, used) = recorder.end();
    assert_eq!(disagreements(&bag, &sent, reported), Vec::<String>::new());
    let read = Bag::open(&bag).expect("it is closed");
    println!(
        "{}: {} sent in {:.1} s with {:.1} s of CPU, {} times without room; {reported:?}, enqueue {:?} ns, {} datagrams thrown away, {} kB at most",
        publisher.name,
        sent.sent,
        sent.took_s,
        sent.cpu_s,
        sent.refused,
        enqueue(&read),
        used.datagrams_dropped,
        used.peak_kb
    );
    assert!(enqueue(&read).is_sorted() && enqueue(&read)[0] > 0);
    Some(lost(&read))
}

#[test]
fn every_message_of_another_dds_is_written_or_counted_with_the_reason() {
    let Some(lost) = record("load", false, 5000, 4) else { return };
    println!("{lost:?}");
}

#[test]
fn nothing_of_a_reliable_publisher_is_lost() {
    let Some(lost) = record("reliable-load", true, 2000, 4) else { return };
    assert_eq!(lost, ReportedLosses::default());
}

/// Memory of a process now (MB).
fn memory_mb(process: u32) -> f64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).expect("the process lives");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("a line of memory");
    let kb: f64 = line.split_whitespace().next().and_then(|kb| kb.parse().ok()).expect("a number");
    kb / 1024.0
}

/// Large and small messages as a job publishes them: plan pages and chunks of setpoints, and joint states. Sends what is due.
struct Traffic {
    topics: [(camwright_ros::Publisher<Text>, Text, u64); 2],
    begun: Instant,
    refused: u64,
}

impl Traffic {
    const TOPICS: [(&'static str, usize, u64); 2] = [("/large", 30_000, 100), ("/small", 300, 1000)];

    fn new(node: &Node) -> Self {
        let topics = Self::TOPICS.map(|(name, bytes, per_second)| {
            let publisher = node.publisher(name, &Qos::default_topic().keep_last(1000)).expect("a publisher");
            (publisher, Text { data: "x".repeat(bytes) }, per_second)
        });
        Self { topics, begun: Instant::now(), refused: 0 }
    }

    /// Publishes for a second.
    fn go_on(&mut self) {
        const PERIOD: Duration = Duration::from_millis(10);
        for _ in 0..100 {
            for (publisher, message, per_second) in &self.topics {
                for _ in 0..per_second / 100 {
                    self.refused += u64::from(publisher.publish(message).is_err());
                }
            }
            std::thread::sleep(PERIOD);
        }
    }
}

/// The bag grows, the memory of the recorder does not. `CAMWRIGHT_SOAK_S` is the time that this is watched (s).
#[test]
fn memory_stays_flat_while_the_bag_grows() {
    let seconds: u32 = std::env::var("CAMWRIGHT_SOAK_S").ok().and_then(|text| text.parse().ok()).unwrap_or(24);
    let (domain, folder) = (Domain::reserve(), Folder::new("memory"));
    let names = Traffic::TOPICS.map(|(name, ..)| name);
    let recorder =
        RunLoggerProcess::start(&domain, &folder.join("run"), &[names[0], names[1], "/run_logger/status", "/rosout"]);
    let mut traffic = Traffic::new(&recorder.node);
    recorder.wait_for_topics(&names);
    let process = recorder.process.id();
    let mut memory = Vec::new();
    for second in 0..seconds {
        traffic.go_on();
        memory.push(memory_mb(process));
        if second % (seconds / 12).max(1) == 0 {
            let written: u64 = recorder.status().topics.iter().map(|topic| topic.written).sum();
            println!(
                "{:.0} s: {written} messages, {:.1} MB",
                traffic.begun.elapsed().as_secs_f64(),
                memory[second as usize]
            );
        }
    }
    let (bag, _) = recorder.end();
    let lost = lost(&Bag::open(&bag).expect("it is closed"));
    let third = memory.len() / 3;
    let max = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
    let (before, after) = (max(&memory[third..2 * third]), max(&memory[2 * third..]));
    println!("{before:.1} MB in the second third, {after:.1} MB in the last; {lost:?}, refused {}", traffic.refused);
    assert_eq!(lost, ReportedLosses::default());
    // A tenth of what the messages of the last third take.
    let grown = after - before;
    assert!(grown < 0.1 * 3.3 * f64::from(seconds / 3), "{grown:.1} MB more: {memory:?}");
}

/// Maximum time of a move.
const LONGEST: Duration = Duration::from_secs(1200);

/// Moves X and Z to and fro until the time is over: a motion like that of a job, and shorter.
fn move_to_and_fro(node: &Node, time: Duration) -> Vec<String> {
    let client = node.action_client::<MoveTo>("axis_interpolator/move_to").expect("a client");
    client.wait_for_server(PATIENCE).expect("the interpolator offers it");
    let (begun, mut moves) = (Instant::now(), 0);
    while begun.elapsed() < time {
        let positions = if moves % 2 == 0 { [0.12, 0.08] } else { [0.15, 0.0] };
        let joints = ["x_axis", "z_axis"].map(str::to_owned).into();
        let goal = MoveToGoal { joints, positions: positions.into(), speed_factor: 0.5, ..MoveToGoal::default() };
        let sent = client.send_goal(goal, drop, PATIENCE).expect("a decision");
        if sent.accepted() {
            let (status, result) = sent.result(LONGEST).expect("a result");
            assert_eq!(status, GoalStatus::Succeeded, "{}", result.message);
            moves += 1;
        } else {
            // It has not heard yet that the machine is ready.
            assert!(begun.elapsed() < PATIENCE, "the interpolator accepts no move");
            std::thread::sleep(Duration::from_millis(50));
        }
    }
    println!("{moves} moves in {:.0} s", begun.elapsed().as_secs_f64());
    Vec::new()
}

/// The messages of a cell at pace realtime are in the bag to the last tick, and equal their recomputation.
#[test]
fn the_cells_own_traffic_is_recorded_without_a_gap() {
    let folder = Folder::new("cell-traffic");
    let wrong = cell::record(&folder.join("run"), |node| move_to_and_fro(node, Duration::from_secs(6)));
    assert_eq!(wrong, Vec::<String>::new());
}

/// Publishes until the condition holds.
fn publish_until(recorder: &RunLoggerProcess, text: &str, condition: impl Fn(&RunLoggerProcess) -> bool) {
    let publisher = recorder.node.publisher::<Text>(TOPIC, &Qos::default_topic()).expect("a publisher");
    recorder.wait_for_topics(&[TOPIC]);
    let deadline = Instant::now() + PATIENCE;
    while !condition(recorder) {
        assert!(Instant::now() < deadline, "waited in vain: {:?}", recorder.status());
        for _ in 0..20 {
            publisher.publish(&Text { data: text.to_owned() }).expect("room");
        }
        // At the rate of the recorder's status.
        let _status = recorder.wait_status(Duration::from_millis(100), |_| false);
    }
}

#[test]
fn sigterm_leaves_a_whole_bag_and_exit_code_0() {
    let (domain, folder) = (Domain::reserve(), Folder::new("sigterm"));
    let recorder = RunLoggerProcess::start(&domain, &folder.join("run"), &[TOPIC]);
    publish_until(&recorder, "as ever", |recorder| recorder.counts().written > 100);
    let RunLoggerProcess { bag, mut process, .. } = recorder;
    process.terminate();
    let status = process.wait(PATIENCE);
    assert!(status.success(), "{status}: {}", process.stderr());
    let report = check(&bag).expect("there is a bag");
    assert_eq!(report.findings, [], "{}", report.to_text());
    assert_eq!(Bag::open(&bag).expect("it is closed").custom_data()["camwright.outcome"], "complete");
}

/// A disk of 12 MB of its own, in a namespace that ends with the shell, which takes the bag out of it before.
const ON_A_SMALL_DISK: &str = "mount -t tmpfs -o size=12m tmpfs \"$DISK\" || exit 77; \"$@\" & pid=$!; trap 'kill -TERM $pid' TERM; \
    wait $pid; wait $pid; code=$?; cp -r \"$DISK/run\" \"$BAG\"; exit $code";

#[test]
fn a_full_disk_ends_the_recording_with_a_whole_bag_a_clear_sentence_and_exit_code_1() {
    let (domain, folder) = (Domain::reserve(), Folder::new("full-disk"));
    let (disk, bag) = (folder.join("disk"), folder.join("copy"));
    std::fs::create_dir_all(&disk).expect("the folder is ours");
    let can_mount = ["--user", "--map-root-user", "--mount", "sh", "-c", "mount -t tmpfs tmpfs \"$0\""];
    if !Command::new("unshare").args(can_mount).arg(&disk).status().is_ok_and(|status| status.success()) {
        println!("SKIPPED: this computer lets no test mount a small disk");
        return;
    }
    let mut command = Command::new("unshare");
    command.args(["--user", "--map-root-user", "--mount", "sh", "-c", ON_A_SMALL_DISK, "sh"]);
    command.arg(env!("CARGO_BIN_EXE_run_logger")).env("DISK", &disk).env("BAG", &bag);
    command.current_dir(repository()).env("ROS_DOMAIN_ID", domain.id().to_string()).env_remove("ROS_NAMESPACE");
    // What fills a disk is not the floor that is left free of it.
    command.args(["--ros-args", "-p", "min_free_mb:=0"]);
    let recorder = RunLoggerProcess::start_with(&domain, &disk.join("run"), &[TOPIC], command);
    let (sender, events) = mpsc::channel();
    let on_event = move |event: MessagesLostEvent, _: &_| drop(sender.send(event));
    let losses = recorder.node.subscribe("events/rosbag2_messages_lost", &Qos::default_topic(), on_event);
    assert!(losses.as_ref().expect("a subscription").wait_matched(1, PATIENCE));
    publish_until(&recorder, &"x".repeat(30_000), |recorder| recorder.counts().dropped > 100);
    let reported = recorder.wait_settled(u64::MAX);
    assert_eq!(reported.received, reported.written + reported.dropped);
    let mut published = 0;
    while published < reported.dropped {
        let event = events.recv_timeout(PATIENCE).expect("every loss is published");
        let [loss] = &event.messages_lost_statistics[..] else { panic!("one topic is recorded: {event:?}") };
        assert_eq!((event.node_name.as_str(), loss.topic_name.as_str()), ("/run_logger", TOPIC));
        assert_eq!(loss.messages_lost_in_transport, 0);
        published += loss.messages_lost_in_recorder;
    }
    assert_eq!(published, reported.dropped);
    assert!(!recorder.status().recording, "it says that it has ended");
    let RunLoggerProcess { mut process, .. } = recorder;
    process.terminate();
    let status = process.wait(PATIENCE);
    let stderr = process.stderr();
    assert_eq!(status.code(), Some(1), "{stderr}");
    assert_eq!(stderr.matches("the recording has ended: no room for more in").count(), 1, "{stderr}");

    // The copy has another name than its storage file, which does not matter.
    let report = check(&bag).expect("the bag was copied");
    assert_eq!(report.worst(), Some(BagSeverity::Warning), "{}", report.to_text());
    assert!(report.to_text().contains("the recording ended early: no room"), "{}", report.to_text());
    assert_eq!(report.message_count, reported.written);
    let read = Bag::open(&bag).expect("it is closed");
    assert_eq!(read.custom_data()["camwright.outcome"], "fault");
    assert!(read.files()[0].is_closed);
}
