// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A bag is played as rosbag2's player would, and does what its services ask.

use crate::recorder;
use crate::support;

use std::path::Path;
use std::sync::{Arc, Mutex, mpsc};

use camwright_bag::qos::{Durability, Reliability};
use camwright_bag::{BagWriter, QosProfile, RecordingOutcome, Topic, WriterOptions};
use camwright_msgs::Service;
use camwright_msgs::builtin_interfaces::msg::Time;
use camwright_msgs::camwright_msgs::msg::MachineStream;
use camwright_msgs::rosbag2_interfaces::msg::ReadSplitEvent;
use camwright_msgs::rosbag2_interfaces::srv::{
    Burst, BurstRequest, GetRate, GetRateRequest, IsPaused, IsPausedRequest, Pause, PauseRequest, Play, PlayNext,
    PlayNextRequest, PlayRequest, Resume, ResumeRequest, Seek, SeekRequest, SetRate, SetRateRequest, Stop, StopRequest,
    TogglePaused, TogglePausedRequest,
};
use camwright_msgs::rosgraph_msgs::msg::Clock;
use camwright_msgs::std_msgs::msg::String as Text;
use camwright_nodes::player::{PlaybackSummary, ReplayArgs, play};
use camwright_ros::{Node, NodeOptions, Qos, Shutdown, SpinThread, Subscription};
use recorder::{args, directory};
use support::{Domain, PATIENCE};

/// The first message of the bag (s since 1970); one a second follows.
const BEGIN: u64 = 1_760_000_000;

/// Ten texts, a second apart, and a latched one before each even; in two files.
fn write_bag(path: &Path) {
    let info = camwright_msgs::by_type_name("std_msgs/msg/String").expect("it is ours");
    let topic = |name: &str, durability| Topic {
        name: name.into(),
        type_name: info.type_name.into(),
        type_hash: info.type_hash.into(),
        definition: info.schema.into(),
        offered_qos: vec![QosProfile::discovered(Reliability::Reliable, durability)],
    };
    let mut writer = BagWriter::create(path, &WriterOptions::default()).expect("the directory is free");
    let texts = writer.add_topic(&topic("/texts", Durability::Volatile)).expect("it is open");
    let pages = writer.add_topic(&topic("/pages", Durability::TransientLocal)).expect("it is open");
    let data =
        |number: u64| [&[0, 1, 0, 0, 2, 0, 0, 0][..], &[b'0' + u8::try_from(number).expect("a digit"), 0]].concat();
    for number in 0..10 {
        let t = (BEGIN + number) * 1_000_000_000;
        if number % 2 == 0 {
            writer.write(pages, t, t, &data(number)).expect("it is open");
        }
        writer.write(texts, t + 1, t, &data(number)).expect("it is open");
        if number == 4 {
            writer.split().expect("the disk has room");
        }
    }
    writer.close(RecordingOutcome::Complete, 0).expect("the disk has room");
}

/// A player in a thread, and who listens to it.
struct PlayerUnderTest {
    node: Node,
    _spinning: SpinThread,
    _subscriptions: [Subscription; 4],
    texts: mpsc::Receiver<String>,
    pages: Arc<Mutex<Vec<String>>>,
    splits: mpsc::Receiver<ReadSplitEvent>,
    clock: mpsc::Receiver<Clock>,
    shutdown: Shutdown,
    playing: std::thread::JoinHandle<PlaybackSummary>,
}

impl PlayerUnderTest {
    fn start(domain: &Domain, bag: &Path, words: &[&str]) -> Self {
        #[derive(clap::Parser)]
        struct Line {
            #[command(flatten)]
            replay: ReplayArgs,
        }
        let node = Node::new(NodeOptions::new("listener", &args(domain, &[]))).expect("it joins");
        let spinning = node.spin_in_thread().expect("there are threads");
        let (of_texts, texts) = mpsc::channel();
        let (of_splits, splits) = mpsc::channel();
        let (of_clock, clock) = mpsc::channel();
        let pages = Arc::<Mutex<Vec<String>>>::default();
        let into = Arc::clone(&pages);
        let plain = Qos::default_topic().keep_last(100);
        let subscriptions = [
            node.subscribe("texts", &plain, move |text: Text, _| drop(of_texts.send(text.data))),
            node.subscribe("pages", &Qos::latched(100), move |text: Text, _| {
                into.lock().expect("nobody panics with it").push(text.data);
            }),
            node.subscribe("events/read_split", &plain, move |event, _| drop(of_splits.send(event))),
            node.subscribe("/clock", &plain, move |message, _| drop(of_clock.send(message))),
        ];
        let subscriptions = subscriptions.map(|made| made.expect("a subscription"));
        let bag = bag.display().to_string();
        let line = ["replay", &bag, "--wait", "30"].into_iter().chain(words.iter().copied());
        let replay = <Line as clap::Parser>::try_parse_from(line).expect("they are valid").replay;
        let (shutdown, ros) = (Shutdown::new(), args(domain, &[]));
        let stop = shutdown.clone();
        let playing = std::thread::spawn(move || play(&replay, &ros, &stop).expect("it can be played"));
        Self {
            node,
            _spinning: spinning,
            _subscriptions: subscriptions,
            texts,
            pages,
            splits,
            clock,
            shutdown,
            playing,
        }
    }

    fn ask<S: Service>(&self, name: &str, request: &S::Request) -> S::Response {
        let client = self.node.client::<S>(&format!("bag_player/{name}")).expect("good name");
        client.wait_for_service(PATIENCE).expect("it is offered");
        client.call(request, PATIENCE).expect("it answers")
    }

    fn text(&self) -> String {
        self.texts.recv_timeout(PATIENCE).expect("a text is played")
    }

    fn end(self) -> PlaybackSummary {
        self.shutdown.request();
        self.playing.join().expect("it ends well")
    }
}

fn at(second: u64) -> SeekRequest {
    SeekRequest { time: Time { sec: i32::try_from(BEGIN + second).expect("it fits"), nanosec: 0 } }
}

#[test]
fn a_paused_player_steps_bursts_seeks_and_resumes() {
    let domain = Domain::reserve();
    let directory = directory("player-services");
    let bag = directory.join("run");
    write_bag(&bag);
    let show = PlayerUnderTest::start(&domain, &bag, &["--start-paused", "--rate", "0.001", "--clock", "100"]);
    assert!(show.ask::<IsPaused>("is_paused", &IsPausedRequest::default()).paused);
    assert!(show.ask::<PlayNext>("play_next", &PlayNextRequest::default()).success, "a page");
    assert!(show.ask::<PlayNext>("play_next", &PlayNextRequest::default()).success);
    assert_eq!(show.text(), "0");
    assert_eq!(show.ask::<Burst>("burst", &BurstRequest { num_messages: 3 }).actually_burst, 3);
    assert_eq!([show.text(), show.text()], ["1", "2"]);
    assert!(show.ask::<Seek>("seek", &at(6)).success);
    assert!(!show.ask::<Seek>("seek", &at(99)).success, "it is not in the bag");
    assert!(!show.ask::<SetRate>("set_rate", &SetRateRequest { rate: 0.0 }).success);
    assert!(!show.ask::<SetRate>("set_rate", &SetRateRequest { rate: f64::NAN }).success);
    assert!(show.ask::<SetRate>("set_rate", &SetRateRequest { rate: 20.0 }).success);
    assert_eq!(show.ask::<GetRate>("get_rate", &GetRateRequest::default()).rate.to_bits(), 20.0_f64.to_bits());
    // The clock of the bag stands still where it was led to, and goes on with it.
    let clock = || show.clock.recv_timeout(PATIENCE).expect("it is published").clock;
    while clock() != at(6).time {}
    show.ask::<TogglePaused>("toggle_paused", &TogglePausedRequest::default());
    assert_eq!([show.text(), show.text(), show.text(), show.text()], ["6", "7", "8", "9"]);
    let event = show.splits.recv_timeout(PATIENCE).expect("the second file was begun");
    assert!(event.closed_file.ends_with("run_0.mcap") && event.opened_file.ends_with("run_1.mcap"), "{event:?}");
    assert_eq!(event.node_name, "/bag_player");
    let pages = Arc::clone(&show.pages);
    let played = show.end();
    assert_eq!(played.failed, 0, "{played:?}");
    // Steps played 0 and 2; the jump to 6 s played what was latched before it: 0, 2, 4; then 6 and 8.
    assert_eq!(*pages.lock().expect("nobody panics with it"), ["0", "2", "0", "2", "4", "6", "8"]);
    std::fs::remove_dir_all(directory).expect("it is ours");
}

#[test]
fn a_player_that_stays_plays_the_span_it_is_asked_for_and_pauses_and_stops() {
    let domain = Domain::reserve();
    let directory = directory("player-stays");
    let bag = directory.join("run");
    write_bag(&bag);
    let words = [
        "--stay",
        "--start-offset",
        "1",
        "--playback-duration",
        "2.5",
        "--rate",
        "100",
        "-e",
        "^/tex",
        "--exclude",
        "/rosout",
    ];
    let show = PlayerUnderTest::start(&domain, &bag, &words);
    assert_eq!([show.text(), show.text(), show.text()], ["1", "2", "3"]);
    let play = |start: i32, seconds: i32| {
        let mut request = PlayRequest::default();
        request.start_offset.sec = start;
        request.playback_duration.sec = seconds;
        show.ask::<Play>("play", &request).success
    };
    while !play(7, 1) {}
    assert_eq!(show.text(), "7", "that of 8 s comes a nanosecond too late");
    while !play(0, 0) {}
    show.ask::<SetRate>("set_rate", &SetRateRequest { rate: 1e-6 });
    assert!(!play(0, 0), "it is playing");
    show.ask::<Pause>("pause", &PauseRequest::default());
    assert!(show.ask::<IsPaused>("is_paused", &IsPausedRequest::default()).paused);
    show.ask::<Resume>("resume", &ResumeRequest::default());
    show.ask::<Stop>("stop", &StopRequest::default());
    assert!(play(9, 0), "it was stopped");
    show.ask::<SetRate>("set_rate", &SetRateRequest { rate: 100.0 });
    while show.text() != "9" {}
    assert!(show.pages.lock().expect("nobody panics with it").is_empty(), "the pages were not chosen");
    assert!(show.end().messages >= 6);
    std::fs::remove_dir_all(directory).expect("it is ours");
}

/// A bag of a cell is not played onto a live cell: nothing is published, and the error names the node, the topics and what to do. In another
/// namespace, or when it is asked for, it is played.
#[test]
fn a_bag_is_not_played_onto_a_live_cell() {
    let domain = Domain::reserve();
    let directory = directory("player-live-cell");
    let bag = directory.join("run");
    let info = camwright_msgs::by_type_name("std_msgs/msg/String").expect("it is ours");
    let mut writer = BagWriter::create(&bag, &WriterOptions::default()).expect("the directory is free");
    for name in ["/machine/setpoints", "/machine/commands", "/texts"] {
        let topic = writer.add_topic(&Topic {
            name: name.into(),
            type_name: info.type_name.into(),
            type_hash: info.type_hash.into(),
            definition: info.schema.into(),
            offered_qos: vec![QosProfile::discovered(Reliability::Reliable, Durability::Volatile)],
        });
        let (topic, t) = (topic.expect("it is open"), BEGIN * 1_000_000_000);
        writer.write(topic, t, t, &[0, 1, 0, 0, 2, 0, 0, 0, b'1', 0]).expect("it is open");
    }
    writer.close(RecordingOutcome::Complete, 0).expect("the disk has room");

    let node = Node::new(NodeOptions::new("machine_sim", &args(&domain, &[]))).expect("it joins");
    let _spinning = node.spin_in_thread().expect("there are threads");
    let _stream = node.publisher::<MachineStream>("machine/stream", &Qos::default_topic()).expect("a publisher");
    let (sender, received) = mpsc::channel();
    let subscriptions = ["machine/setpoints", "texts"].map(|topic| {
        let sender = sender.clone();
        let on_message = move |_: Text, _: &_| {
            let _is_over = sender.send(topic);
        };
        node.subscribe(topic, &Qos::default_topic(), on_message).expect("a subscription")
    });
    let output = |words: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_camwright"));
        command.env("ROS_DOMAIN_ID", domain.id().to_string()).arg("replay").arg(&bag).args(words);
        let output = command.output().expect("it runs");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).replace('\n', " "))
    };
    let (code, errors) = output(&["--wait", "30"]);
    assert_eq!(code, Some(2), "{errors}");
    for words in [
        "/machine_sim belongs to a live cell",
        "(/machine/setpoints, /machine/commands)",
        "ROS_DOMAIN_ID",
        "--onto-live-cell",
    ] {
        assert!(errors.contains(words), "{words}: {errors}");
    }
    assert!(received.try_recv().is_err(), "nothing is played");
    let (code, errors) = output(&["--wait", "30", "--exclude", "/machine/*"]);
    assert_eq!((code, received.recv_timeout(PATIENCE)), (Some(0), Ok("texts")), "{errors}");
    let rename = |topic: &str| format!("/machine/{topic}:=/old/machine/{topic}");
    let (setpoints, commands) = (rename("setpoints"), rename("commands"));
    let (code, errors) = output(&["--wait", "30", "--ros-args", "-r", &setpoints, "-r", &commands]);
    assert_eq!((code, received.recv_timeout(PATIENCE)), (Some(0), Ok("texts")), "{errors}");
    assert!(received.try_recv().is_err(), "the setpoints have another name");
    let (code, errors) = output(&["--wait", "30", "--onto-live-cell"]);
    let mut both = [0; 2].map(|_| received.recv_timeout(PATIENCE).expect("both are played"));
    both.sort_unstable();
    assert_eq!((code, both), (Some(0), ["machine/setpoints", "texts"]), "{errors}");
    drop(subscriptions);
    std::fs::remove_dir_all(directory).expect("it is ours");
}
