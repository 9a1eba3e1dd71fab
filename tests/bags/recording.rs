// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The recorder and the player in the graph: what nodes publish is in the bag, and comes back when the bag is played.

use crate::bag_judges;
use crate::recorder;
use crate::support;

use std::path::Path;
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use camwright_bag::check::check;
use camwright_bag::{Bag, BagMessage};
use camwright_machine_cycle::pacing::Pace;
use camwright_msgs::builtin_interfaces::msg::Time;
use camwright_msgs::camwright_msgs::msg::MachineStream;
use camwright_msgs::rosbag2_interfaces::srv::{IsPaused, IsPausedRequest, Pause, PauseRequest, Resume, ResumeRequest};
use camwright_msgs::rosgraph_msgs::msg::Clock;
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_msgs::std_msgs::msg::String as Text;
use camwright_nodes::bag_size::BagSize;
use camwright_nodes::player::{ReplayArgs, play};
use camwright_planning::prepare_any;
use camwright_ros::{Node, NodeOptions, Publisher, Qos, Shutdown};
use recorder::{ACTIVATE, CONFIGURE, DEACTIVATE, RecorderUnderTest, args, directory, messages, until};
use serde_json::json;
use support::{Domain, Guarded, PATIENCE, Peer};

/// Arguments of the command line without options.
fn played_as_it_is(bag: &Path) -> ReplayArgs {
    #[derive(clap::Parser)]
    struct Command {
        #[command(flatten)]
        replay: ReplayArgs,
    }
    <Command as clap::Parser>::try_parse_from([Path::new("replay"), bag]).expect("a bag is all it needs").replay
}

fn joint_state(tick: u32) -> JointState {
    let mut message = JointState {
        name: vec!["c_axis".into(), "x_axis".into()],
        position: vec![f64::from(tick) * 1e-3, f64::from(tick).sin()],
        ..JointState::default()
    };
    message.header.stamp = Time { sec: 100, nanosec: tick * 1_000_000 };
    message
}

#[test]
fn what_is_published_is_in_the_bag_and_comes_back_when_it_is_played() {
    let domain = Domain::reserve();
    let directory = directory("round-trip");
    let bag = directory.join("run");
    let mut cell = RecorderUnderTest::new(
        &domain,
        &["--ros-args", "-p", &format!("bag_dir:={}", bag.display()), "-p", "run_id:=r7"],
    );
    let joints = cell.node.publisher::<JointState>("joint_states", &Qos::default_topic()).expect("good name");
    // The latched pages of a plan, published before anybody records.
    let pages = cell.node.publisher::<Text>("plan_pages", &Qos::latched(20)).expect("good name");
    for page in 0..20 {
        pages.publish(&Text { data: format!("page {page}") }).expect("room");
    }
    assert!(cell.change_state(CONFIGURE) && cell.change_state(ACTIVATE));
    cell.wait_for_topics(&["/joint_states", "/plan_pages"]);
    // The recorder may match the publisher before the publisher matches the recorder.
    assert!(joints.wait_matched(1, PATIENCE));
    // The recorder's cache grows with the first message, so that the others may come all at once.
    joints.publish(&joint_state(0)).expect("room");
    until("the first is written", || cell.written("/joint_states") == 1);
    for tick in 1..500 {
        joints.publish(&joint_state(tick)).expect("room");
    }
    until("all is written", || cell.written("/joint_states") == 500 && cell.written("/plan_pages") == 20);
    assert!(!cell.change_state(ACTIVATE), "it is active already");
    assert!(cell.change_state(DEACTIVATE));
    until("the end is published", || !cell.status().recording);
    // The bag is there and is not written over.
    assert!(!cell.change_state(ACTIVATE), "the bag exists");
    cell.end();

    let report = check(&bag).expect("there is a bag");
    assert_eq!(report.findings, [], "{}", report.to_text());
    let read = Bag::open(&bag).expect("it is closed");
    assert_eq!(read.custom_data()["camwright.run_id"], "r7");
    assert_eq!(read.custom_data()["camwright.outcome"], "complete");
    assert_eq!(read.custom_data()["camwright.lost_total"], "0");
    assert_eq!((messages(&read, "/joint_states").len(), messages(&read, "/plan_pages").len()), (500, 20));
    judge(&bag, &domain, 500);

    // Played to a graph in which nobody else publishes, to a listener that was there and to one that comes late.
    drop(cell);
    let other = Domain::reserve();
    let listener = Node::new(NodeOptions::new("listener", &args(&other, &[]))).expect("it joins");
    let _spinning = listener.spin_in_thread().expect("there are threads");
    let received = Arc::<Mutex<Vec<JointState>>>::default();
    let into = received.clone();
    let _subscription = listener
        .subscribe::<JointState>("joint_states", &Qos::default_topic().keep_last(1000), move |message, _| {
            into.lock().expect("nobody panics with it").push(message);
        })
        .expect("good name");
    let late = Arc::<Mutex<Vec<String>>>::default();
    let node = listener.clone();
    let into = late.clone();
    let late_joiner = std::thread::spawn(move || {
        until("the player publishes", || node.publisher_count("plan_pages").is_ok_and(|n| n > 0));
        std::thread::sleep(Duration::from_millis(1500));
        node.subscribe::<Text>("plan_pages", &Qos::latched(100), move |message, _| {
            into.lock().expect("nobody panics with it").push(message.data);
        })
        .expect("good name")
    });
    let replay = ReplayArgs { rate: 0.1, exclude: vec!["/rosout".into()], wait: 10.0, ..played_as_it_is(&bag) };
    let interrupt = Shutdown::new();
    let (stop, all) = (interrupt.clone(), late.clone());
    let playing = std::thread::spawn({
        let (ros, interrupt) = (args(&other, &[]), interrupt.clone());
        move || play(&replay, &ros, &interrupt).expect("the bag can be played")
    });
    let _late_subscription = late_joiner.join().expect("it subscribes");
    until("the late listener hears the latched pages", || all.lock().expect("nobody panics with it").len() == 20);
    until("the listener hears all", || received.lock().expect("nobody panics with it").len() == 500);
    stop.request();
    let played = playing.join().expect("it ends well");
    assert!(played.messages >= 520 && played.failed == 0 && played.matched_topics >= 1, "{played:?}");
    let received = received.lock().expect("nobody panics with it");
    for (tick, message) in (0..).zip(received.iter()) {
        assert_eq!(*message, joint_state(tick));
    }
    assert_eq!(*late.lock().expect("nobody panics with it"), (0..20).map(|n| format!("page {n}")).collect::<Vec<_>>());
    std::fs::remove_dir_all(directory).expect("it is ours");
}

/// The readers that other people use see so many joint states in the bag, and decode every message of it.
fn judge(bag: &Path, domain: &Domain, joint_states: usize) {
    if let Some(counts) = bag_judges::foxglove_counts(bag) {
        assert_eq!(counts["topics"]["/joint_states"], json!(joint_states));
    }
    let Some(counts) = bag_judges::rosbags_counts(bag, domain) else { return };
    let seen = &counts["topics"]["/joint_states"];
    assert_eq!((&seen["type"], &seen["count"]), (&json!("sensor_msgs/msg/JointState"), &json!(joint_states)));
}

/// Acceptance 4 of the main job: every tick is in its bag, and others read every message.
#[test]
fn the_main_job_leaves_a_bag_without_a_gap_that_every_reader_reads() {
    let domain = Domain::reserve();
    let directory = directory("main-job");
    let bag = directory.join("run");
    let output = Command::new(env!("CARGO_BIN_EXE_camwright"))
        .args(["run", "--bag", &bag.display().to_string()])
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."))
        .env("ROS_DOMAIN_ID", domain.id().to_string())
        .output()
        .expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report = check(&bag).expect("there is a bag");
    assert_eq!(report.findings, [], "{}", report.to_text());
    let read = Bag::open(&bag).expect("it is closed");
    assert_eq!(read.custom_data()["camwright.lost_total"], "0");
    let joints = messages(&read, "/joint_states");
    // The stamp stands behind the four bytes that say which CDR.
    let number =
        |m: &BagMessage, at: usize| u64::from(u32::from_le_bytes(m.data[at..at + 4].try_into().expect("four bytes")));
    let stamps: Vec<u64> = joints.iter().map(|m| number(m, 4) * 1_000_000_000 + number(m, 8)).collect();
    let cycle_ns = stamps[1] - stamps[0];
    for pair in stamps.windows(2) {
        assert_eq!(pair[1] - pair[0], cycle_ns, "a tick is missing before {} ns", pair[1]);
    }
    let prepared = prepare_any("four_lobe_camshaft", &[], None).expect("it can be planned");
    // Only the number of ticks in a message of set-points depends on the computer: with the real one, the prediction is close.
    let chunks = messages(&read, "/machine/setpoints").len();
    let size = BagSize::with_chunk_ticks(&prepared, Pace::Fast, joints.len() / chunks);
    let files = size.topics.iter().find(|topic| topic.topic == "job_planner/job_files").expect("it names files");
    assert_eq!(files.messages, messages(&read, "/job_planner/job_files").len() as u64, "pages of the files of the job");
    let (estimate, predicted) = (BagSize::estimate(&prepared, Pace::Fast).bytes(), size.bytes());
    let real = read.files()[0].bytes;
    println!("{estimate} bytes of bag were estimated, {predicted} with the real set-points, {real} there are");
    assert!(
        predicted.abs_diff(real) * 20 < real,
        "{predicted} bytes were predicted for {chunks} messages of set-points, {real} there are: more than 5 % off"
    );
    assert!(
        estimate.abs_diff(real) * 4 < real,
        "{estimate} bytes were estimated, {real} there are: more than 25 % off"
    );
    let (first, last) = read.log_times_ns().expect("there are messages");
    let (bag_s, machine_s) = ((last - first) / 1_000_000_000, (stamps[stamps.len() - 1] - stamps[0]) / 1_000_000_000);
    assert!(bag_s.abs_diff(machine_s) <= 1, "the bag lasts {bag_s} s, the machine took {machine_s} s");
    judge(&bag, &domain, joints.len());
    std::fs::remove_dir_all(directory).expect("it is ours");
}

#[test]
fn the_machine_hears_how_far_its_joint_states_are_in_the_bag() {
    let domain = Domain::reserve();
    let directory = directory("credit");
    let bag = directory.join("run");
    let recorder = ["--ros-args", "-p", &format!("bag_dir:={}", bag.display()), "-p", "credit_ticks:=50"];
    let mut cell = RecorderUnderTest::new(&domain, &recorder);
    let joints: Publisher<JointState> = cell.node.publisher("joint_states", &Qos::default_topic()).expect("good name");
    let stream: Publisher<MachineStream> =
        cell.node.publisher("machine/stream", &Qos::default_topic()).expect("good name");
    assert!(cell.change_state(CONFIGURE) && cell.change_state(ACTIVATE));
    cell.wait_for_topics(&["/joint_states", "/machine/stream"]);
    let (mut tick, mut begun) = (0, Instant::now());
    let epoch = Time { sec: 100, nanosec: 0 };
    // A machine at pace fast, 200 ticks ahead of the recorder at most: it comes as far as it wants.
    while tick < 900 {
        tick += 1;
        let stamp = Time { sec: 100, nanosec: tick * 1_000_000 };
        joints.publish(&joint_state(tick)).expect("room");
        if tick % 10 == 0 {
            let (epoch, pace) = (epoch.clone(), MachineStream::PACE_FAST);
            let message = MachineStream { stamp, epoch, tick: tick.into(), pace, ..MachineStream::default() };
            stream.publish(&message).expect("room");
        }
        until("the recorder follows", || cell.status().last_tick + 200 >= u64::from(tick));
        if tick == 100 {
            begun = Instant::now();
        }
    }
    until("the recorder is up to date", || cell.status().last_tick == 900);
    println!("800 ticks with credit in {:?}", begun.elapsed());
    cell.end();
    assert_eq!(check(&bag).expect("shutdown closes the bag").findings, []);
    assert_eq!(messages(&Bag::open(&bag).expect("it is closed"), "/joint_states").len(), 900);
    std::fs::remove_dir_all(directory).expect("it is ours");
}

#[test]
fn a_paused_recorder_writes_nothing_until_resumed() {
    let domain = Domain::reserve();
    let directory = directory("pause");
    let bag = directory.join("run");
    let mut cell = RecorderUnderTest::new(
        &domain,
        &["--ros-args", "-p", &format!("bag_dir:={}", bag.display()), "-p", "preset:=zstd"],
    );
    let texts = cell.node.publisher::<Text>("texts", &Qos::default_topic()).expect("good name");
    assert!(cell.change_state(CONFIGURE) && cell.change_state(ACTIVATE));
    cell.wait_for_topics(&["/texts"]);
    let say = |text: &str| texts.publish(&Text { data: text.into() }).expect("room");
    let (pause, resume, is_paused) = (
        cell.node.client::<Pause>("/run_logger/pause").expect("good name"),
        cell.node.client::<Resume>("/run_logger/resume").expect("good name"),
        cell.node.client::<IsPaused>("/run_logger/is_paused").expect("good name"),
    );
    let asked = || is_paused.call(&IsPausedRequest::default(), PATIENCE).expect("it answers").paused;
    say("before");
    until("the first is written", || cell.written("/texts") == 1);
    pause.wait_for_service(PATIENCE).expect("it is offered");
    is_paused.wait_for_service(PATIENCE).expect("it is offered");
    pause.call(&PauseRequest::default(), PATIENCE).expect("it answers");
    assert!(asked());
    say("between");
    until("the status says so", || cell.status().paused);
    // Given time to be wrong: the message has long arrived.
    std::thread::sleep(Duration::from_millis(300));
    resume.wait_for_service(PATIENCE).expect("it is offered");
    resume.call(&ResumeRequest::default(), PATIENCE).expect("it answers");
    assert!(!asked());
    say("after");
    until("the last is written", || cell.written("/texts") == 2);
    cell.end();
    let bag = Bag::open(&bag).expect("it is closed");
    let texts = messages(&bag, "/texts").into_iter().map(|m| {
        // Behind the four bytes of CDR and the length; what follows the end of the text pads the sample on the wire.
        m.data[8..].split(|&b| b == 0).next().map(<[u8]>::to_vec).unwrap_or_default()
    });
    assert_eq!(texts.collect::<Vec<_>>(), [b"before".to_vec(), b"after".to_vec()]);
    std::fs::remove_dir_all(directory).expect("it is ours");
}

#[test]
fn a_recorder_by_itself_records_and_ctrl_c_closes_the_bag_and_ends_with_zero() {
    let domain = Domain::reserve();
    let directory = directory("ctrl-c");
    let bag = directory.join("run");
    let mut command = Command::new(env!("CARGO_BIN_EXE_run_logger"));
    command
        .args(["--ros-args", "-r", "__node:=logger", "-p", &format!("bag_dir:={}", bag.display())])
        .env("ROS_DOMAIN_ID", domain.id().to_string());
    let mut process = Guarded::start("run_logger", &mut command);
    let node = Node::new(NodeOptions::new("manager", &args(&domain, &[]))).expect("it joins");
    let _spinning = node.spin_in_thread().expect("there are threads");
    let texts = node.publisher::<Text>("texts", &Qos::latched(5)).expect("good name");
    texts.publish(&Text { data: "latched".into() }).expect("room");
    until("the message is on the disk", || {
        Bag::open(&bag)
            .is_ok_and(|b| b.topics().iter().zip(b.message_counts()).any(|(t, &n)| t.name == "/texts" && n == 1))
    });
    process.interrupt();
    let begun = Instant::now();
    let status = process.wait(PATIENCE);
    assert!(status.success(), "{status}: {}", process.stderr());
    println!("closed and ended in {:?}", begun.elapsed());
    assert_eq!(check(&bag).expect("there is a bag").findings, []);
    std::fs::remove_dir_all(directory).expect("it is ours");
}

/// With `/clock` the bag has the times of the recording, and messages before its first one wait for it.
#[test]
fn with_simulated_time_the_bag_has_the_times_of_the_clock() {
    let domain = Domain::reserve();
    let directory = directory("clock");
    let bag = directory.join("run");
    let recorder = ["--ros-args", "-p", &format!("bag_dir:={}", bag.display()), "-p", "use_sim_time:=true"];
    let mut cell = RecorderUnderTest::new(&domain, &recorder);
    let texts = cell.node.publisher::<Text>("texts", &Qos::latched(5)).expect("good name");
    texts.publish(&Text { data: "early".into() }).expect("room");
    assert!(cell.change_state(CONFIGURE) && cell.change_state(ACTIVATE));
    cell.wait_for_topics(&["/texts"]);
    assert_eq!(cell.written("/texts"), 0, "there is no time yet");
    let clock = cell.node.publisher::<Clock>("/clock", &Qos::default_topic()).expect("good name");
    clock.wait_matched(1, PATIENCE);
    let at = |sec: i32| clock.publish(&Clock { clock: Time { sec, nanosec: 500 } }).expect("room");
    let mut sec = 1000;
    until("the early message is written", || {
        // The recorder may hear the first of them before it has subscribed to the clock as a topic.
        at(sec);
        sec += 1;
        cell.written("/texts") == 1
    });
    texts.publish(&Text { data: "late".into() }).expect("room");
    until("the late message is written", || cell.written("/texts") == 2);
    cell.end();
    assert_eq!(check(&bag).expect("there is a bag").findings, []);
    let read = Bag::open(&bag).expect("it is closed");
    for message in messages(&read, "/texts") {
        let seconds = message.log_time_ns / 1_000_000_000;
        assert!((1000..u64::try_from(sec).expect("it counts up")).contains(&seconds), "log time {seconds} s");
    }
    std::fs::remove_dir_all(directory).expect("it is ours");
}

/// Acceptance 4 of the main job: a real ROS 2 subscriber hears what `camwright replay --rate` plays.
#[test]
fn an_rclpy_subscriber_hears_a_bag_that_is_played() {
    let Some(peers) = support::peer_env() else { return };
    let domain = Domain::reserve();
    let directory = directory("rclpy");
    let bag = directory.join("run");
    let mut cell = RecorderUnderTest::new(&domain, &["--ros-args", "-p", &format!("bag_dir:={}", bag.display())]);
    let joints = cell.node.publisher::<JointState>("joint_states", &Qos::default_topic()).expect("good name");
    assert!(cell.change_state(CONFIGURE) && cell.change_state(ACTIVATE));
    cell.wait_for_topics(&["/joint_states"]);
    for tick in 0..200 {
        joints.publish(&joint_state(tick)).expect("room");
        std::thread::sleep(Duration::from_millis(2));
    }
    until("all is written", || cell.written("/joint_states") == 200);
    cell.end();
    drop(cell);

    let other = Domain::reserve();
    let mut peer = Peer::start(peers, &other, "listener");
    peer.ask(
        "subscribe",
        json!({"topic": "/joint_states", "type": "sensor_msgs/msg/JointState", "qos": "reliable:1000"}),
    );
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    command
        .args(["replay", &bag.display().to_string(), "--rate", "2", "--wait", "30", "--topics", "/joint_states"])
        .env("ROS_DOMAIN_ID", other.id().to_string());
    let mut player = Guarded::start("camwright replay", &mut command);
    for tick in 0..200 {
        let received = peer.message("/joint_states");
        let expected = joint_state(tick);
        assert_eq!(received["position"], json!(expected.position), "message {tick}");
        assert_eq!(received["header"]["stamp"]["nanosec"], json!(expected.header.stamp.nanosec));
    }
    let status = player.wait(PATIENCE);
    assert!(status.success(), "{status}: {}", player.stderr());
    assert!(player.stderr().contains("played 200 messages on 1 topics, 1 with subscribers"), "{}", player.stderr());
    std::fs::remove_dir_all(directory).expect("it is ours");
}
