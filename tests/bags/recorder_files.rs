// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Selection of topics and files of a recorder: splits, snapshots, regular expressions, foreign types.

use crate::bag_judges;
use crate::recorder;
use crate::support;

use std::path::Path;
use std::process::Command;
use std::sync::{Arc, Mutex};

use bag_judges::{foxglove_counts, rosbags_counts};
use camwright_bag::check::check;
use camwright_bag::{Bag, BagMetadata};
use camwright_msgs::camwright_msgs::msg::{Alarm, MachineAlarms};
use camwright_msgs::rosbag2_interfaces::msg::WriteSplitEvent;
use camwright_msgs::rosbag2_interfaces::srv::{
    IsDiscoveryRunning, IsDiscoveryRunningRequest, Record, RecordRequest, Snapshot, SnapshotRequest, SplitBagfile,
    SplitBagfileRequest, StartDiscovery, StartDiscoveryRequest, Stop, StopDiscovery, StopDiscoveryRequest, StopRequest,
};
use camwright_msgs::std_msgs::msg::String as Text;
use camwright_ros::{Node, NodeOptions, Qos};
use recorder::{ACTIVATE, CONFIGURE, DEACTIVATE, RecorderUnderTest, args, directory, messages, until};
use serde_json::json;
use support::{Domain, Guarded, PATIENCE, Peer};

fn text(text: impl Into<String>) -> Text {
    Text { data: text.into() }
}

/// The texts of a bag's topic, in order.
fn texts(bag: &Bag, topic: &str) -> Vec<String> {
    let body = |data: &[u8]| data[8..].split(|&byte| byte == 0).next().map(String::from_utf8_lossy).map(String::from);
    messages(bag, topic).iter().filter_map(|message| body(&message.data)).collect()
}

#[test]
fn a_recording_splits_on_request_and_publishes_the_event() {
    let domain = Domain::reserve();
    let directory = directory("split");
    let bag = directory.join("run");
    let mut cell = RecorderUnderTest::new(&domain, &["--ros-args", "-p", &format!("bag_dir:={}", bag.display())]);
    let events = Arc::<Mutex<Vec<WriteSplitEvent>>>::default();
    let into = events.clone();
    let _splits = cell
        .node
        .subscribe("events/write_split", &Qos::default_topic(), move |event, _| {
            into.lock().expect("nobody panics with it").push(event);
        })
        .expect("good name");
    let latched = cell.node.publisher::<Text>("latched", &Qos::latched(5)).expect("good name");
    let plain = cell.node.publisher::<Text>("plain", &Qos::default_topic()).expect("good name");
    assert!(cell.change_state(CONFIGURE) && cell.change_state(ACTIVATE));
    cell.wait_for_topics(&["/latched", "/plain"]);
    let split = cell.node.client::<SplitBagfile>("run_logger/split_bagfile").expect("good name");
    split.wait_for_service(PATIENCE).expect("it is offered");
    latched.publish(&text("kept")).expect("room");
    for file in 1..=3 {
        plain.publish(&text(format!("{file}"))).expect("room");
        until("it is written", || cell.written("/plain") == file && cell.written("/latched") == 1);
        split.call(&SplitBagfileRequest::default(), PATIENCE).expect("it answers");
    }
    until("the files are published", || {
        events.lock().expect("nobody panics with it").len() == 3 && cell.status().files == 4
    });
    assert!(cell.status().free_bytes > 0 && cell.status().repeated >= 3);
    assert!(cell.change_state(DEACTIVATE));
    cell.end();
    let path = |number: u32| bag.join(format!("run_{number}.mcap")).display().to_string();
    for (number, event) in (0..).zip(events.lock().expect("nobody panics with it").iter()) {
        assert_eq!((&event.closed_file, &event.opened_file), (&path(number), &path(number + 1)));
        assert_eq!(event.node_name, "/run_logger");
    }
    let report = check(&bag).expect("there is a bag");
    assert_eq!(report.findings, [], "{}", report.to_text());
    let read = Bag::open(&bag).expect("it is closed");
    assert_eq!(
        (texts(&read, "/plain"), texts(&read, "/latched")),
        (vec!["1".into(), "2".into(), "3".into()], vec!["kept".into()])
    );
    for number in 0..4 {
        let file = Bag::open(Path::new(&path(number))).expect("it is closed");
        assert_eq!(texts(&file, "/latched"), ["kept"], "file {number} alone");
    }
    if let Some(counts) = foxglove_counts(&bag) {
        assert_eq!((&counts["topics"]["/latched"], &counts["topics"]["/plain"]), (&json!(4), &json!(3)));
    }
    if let Some(counts) = rosbags_counts(&bag, &domain) {
        assert_eq!(
            (&counts["topics"]["/latched"]["count"], &counts["topics"]["/plain"]["count"]),
            (&json!(4), &json!(3))
        );
    }
    std::fs::remove_dir_all(directory).expect("it is ours");
}

/// `~/record`, `~/stop` and the services of discovery, as a script for rosbag2's recorder calls them.
#[test]
fn a_recorder_is_driven_by_the_services_of_rosbag2() {
    let domain = Domain::reserve();
    let directory = directory("services");
    let (first, second) = (directory.join("first"), directory.join("second"));
    let bag_dir = format!("bag_dir:={}", first.display());
    let mut cell = RecorderUnderTest::new(&domain, &["--ros-args", "-p", &bag_dir, "-p", "regex:=^/(early|late)$"]);
    let early = cell.node.publisher::<Text>("early", &Qos::latched(5)).expect("good name");
    early.publish(&text("1")).expect("room");
    assert!(cell.change_state(CONFIGURE));
    let record = cell.node.client::<Record>("run_logger/record").expect("good name");
    let stop = cell.node.client::<Stop>("run_logger/stop").expect("good name");
    let start_discovery = cell.node.client::<StartDiscovery>("run_logger/start_discovery").expect("good name");
    let stop_discovery = cell.node.client::<StopDiscovery>("run_logger/stop_discovery").expect("good name");
    let is_running = cell.node.client::<IsDiscoveryRunning>("run_logger/is_discovery_running").expect("good name");
    let into = |uri: &Path| {
        let request = RecordRequest { uri: uri.display().to_string() };
        let answer = record.call(&request, PATIENCE).expect("it answers");
        (answer.return_code, answer.error_string)
    };
    let start = || {
        let answer = start_discovery.call(&StartDiscoveryRequest::default(), PATIENCE).expect("it answers");
        (answer.return_code, answer.error_string)
    };
    let halt = || {
        let answer = stop_discovery.call(&StopDiscoveryRequest::default(), PATIENCE).expect("it answers");
        (answer.return_code, answer.error_string)
    };
    let running = || is_running.call(&IsDiscoveryRunningRequest::default(), PATIENCE).expect("it answers").running;

    assert!(!running());
    assert_eq!(start().0, 1, "nothing is recorded");
    assert_eq!(into(Path::new("")), (0, String::new()), "into bag_dir");
    assert_eq!((into(&second).0, running()), (1, true), "one bag at a time");
    assert!(!second.exists());
    cell.wait_for_topics(&["/early"]);
    assert_eq!(start(), (1, "discovery is running already".into()));
    assert_eq!(halt(), (0, String::new()));
    assert_eq!((halt().0, running()), (1, false));
    let late = cell.node.publisher::<Text>("late", &Qos::latched(5)).expect("good name");
    late.publish(&text("2")).expect("room");
    early.publish(&text("3")).expect("room");
    until("the known topic is recorded", || cell.written("/early") == 2);
    assert_eq!(late.matched(), 0);
    assert_eq!(start(), (0, String::new()));
    until("the new topic is recorded", || cell.written("/late") == 1);
    stop.call(&StopRequest::default(), PATIENCE).expect("it answers");
    until("the end is published", || !cell.status().recording);

    let refused = into(Path::new(""));
    assert!(refused.0 == 1 && refused.1.contains("first"), "the bag is there already: {refused:?}");
    assert_eq!(into(&second), (0, String::new()));
    until("latched messages are recorded again", || cell.written("/early") == 2 && cell.written("/late") == 1);
    cell.end();
    for bag in [&first, &second] {
        assert_eq!(check(bag).expect("there is a bag").findings, []);
        let read = Bag::open(bag).expect("it is closed");
        assert_eq!((texts(&read, "/early"), texts(&read, "/late")), (vec!["1".into(), "3".into()], vec!["2".into()]));
    }
    std::fs::remove_dir_all(directory).expect("it is ours");
}

#[test]
fn where_only_snapshots_are_written_an_alarm_asks_for_one_and_so_may_anybody() {
    let domain = Domain::reserve();
    let directory = directory("snapshot");
    let bag = directory.join("run");
    let bag_dir = format!("bag_dir:={}", bag.display());
    let words = ["-p", "snapshot_s:=1000.0", "-p", "snapshot_delay_s:=0.1", "-p", "regex:=^/texts$|alarms$"];
    let mut cell = RecorderUnderTest::new(&domain, &[&["--ros-args", "-p", &bag_dir][..], &words].concat());
    let publisher = cell.node.publisher::<Text>("texts", &Qos::default_topic()).expect("good name");
    let other = cell.node.publisher::<Text>("other", &Qos::default_topic()).expect("good name");
    let alarms = cell.node.publisher::<MachineAlarms>("machine/alarms", &Qos::latched(1)).expect("good name");
    assert!(cell.change_state(CONFIGURE) && cell.change_state(ACTIVATE));
    cell.wait_for_topics(&["/texts", "/machine/alarms"]);
    let received = |topic: &str| cell.status().topics.iter().find(|t| t.topic == topic).map_or(0, |t| t.received);
    other.publish(&text("nobody wants it")).expect("room");
    publisher.publish(&text("before")).expect("room");
    until("it is held", || received("/texts") == 1);
    assert_eq!(cell.written("/texts"), 0, "only snapshots are written");
    let alarm = |number, severity| Alarm { number, severity, ..Alarm::default() };
    let publish =
        |list: Vec<Alarm>| alarms.publish(&MachineAlarms { alarms: list, ..MachineAlarms::default() }).expect("room");
    publish(vec![alarm(102, Alarm::WARNING)]);
    until("the warning is held", || received("/machine/alarms") == 1);
    publish(vec![alarm(102, Alarm::WARNING), alarm(80, Alarm::STOP)]);
    until("the alarm's snapshot is written", || cell.written("/texts") == 1 && cell.written("/machine/alarms") == 2);
    let snapshot = cell.node.client::<Snapshot>("run_logger/snapshot").expect("good name");
    snapshot.wait_for_service(PATIENCE).expect("it is offered");
    publisher.publish(&text("after")).expect("room");
    until("it is held", || received("/texts") == 2);
    assert!(snapshot.call(&SnapshotRequest::default(), PATIENCE).expect("it answers").success);
    publisher.publish(&text("never wanted")).expect("room");
    until("it is held", || received("/texts") == 3);
    assert!(cell.change_state(DEACTIVATE));
    until("the end is published", || !cell.status().recording);
    let status = cell.status();
    assert_eq!((status.received, status.written, status.passed, status.dropped), (5, 4, 1, 0));
    cell.end();
    let report = check(&bag).expect("there is a bag");
    assert_eq!(report.findings, [], "{}", report.to_text());
    let read = Bag::open(&bag).expect("it is closed");
    assert_eq!(texts(&read, "/texts"), ["before", "after"]);
    assert!(!read.topics().iter().any(|topic| topic.name == "/other"), "no filter names it");
    let files: Vec<u64> =
        BagMetadata::read_from(&bag).expect("it is there").files.iter().map(|f| f.message_count).collect();
    assert_eq!(files, [3, 3, 2], "each snapshot is a file, with the alarms at its head");
    std::fs::remove_dir_all(directory).expect("it is ours");
}

#[test]
fn old_runs_make_room_and_a_recording_that_writes_all_takes_no_snapshot() {
    let domain = Domain::reserve();
    let directory = directory("retention");
    for number in 1..=3 {
        let bag = directory.join(format!("run{number}"));
        let bag_dir = format!("bag_dir:={}", bag.display());
        let mut cell = RecorderUnderTest::new(&domain, &["--ros-args", "-p", &bag_dir, "-p", "keep_runs:=2"]);
        assert!(cell.change_state(CONFIGURE) && cell.change_state(ACTIVATE));
        if number == 1 {
            let snapshot = cell.node.client::<Snapshot>("run_logger/snapshot").expect("good name");
            snapshot.wait_for_service(PATIENCE).expect("it is offered");
            assert!(!snapshot.call(&SnapshotRequest::default(), PATIENCE).expect("it answers").success);
        }
        cell.end();
        assert!(bag.join("metadata.yaml").is_file());
    }
    let left: Vec<bool> = (1..=3).map(|number| directory.join(format!("run{number}")).exists()).collect();
    assert_eq!(left, [false, true, true]);
    std::fs::remove_dir_all(directory).expect("it is ours");
}

/// The file of an installed package defines its types; an unknown type is reported once, and the rest is recorded.
#[test]
fn a_type_is_known_from_the_package_that_is_installed() {
    let domain = Domain::reserve();
    let directory = directory("installed");
    let package = directory.join("prefix/share/shop_msgs/msg");
    std::fs::create_dir_all(&package).expect("it is ours");
    std::fs::write(package.join("Part.msg"), "# A part\nstd_msgs/String name\nSize size\n").expect("it is ours");
    std::fs::write(package.join("Size.msg"), "float64 length # (m)\n").expect("it is ours");
    let std_msgs = directory.join("prefix/share/std_msgs/msg");
    std::fs::create_dir_all(&std_msgs).expect("it is ours");
    std::fs::write(std_msgs.join("String.msg"), "string data\n").expect("it is ours");
    let hash = format!("RIHS01_{}", "5".repeat(64));
    let description = json!({"type_hashes": [{"type_name": "shop_msgs/msg/Part", "hash_string": hash}]});
    std::fs::write(package.join("Part.json"), description.to_string()).expect("it is ours");
    let bag = directory.join("run");
    let mut command = Command::new(env!("CARGO_BIN_EXE_run_logger"));
    command
        .args(["--ros-args", "-p", &format!("bag_dir:={}", bag.display())])
        .env("ROS_DOMAIN_ID", domain.id().to_string())
        .env("AMENT_PREFIX_PATH", directory.join("prefix"));
    let mut process = Guarded::start("run_logger", &mut command);
    let node = Node::new(NodeOptions::new("shop", &args(&domain, &[]))).expect("it joins");
    let _spinning = node.spin_in_thread().expect("there are threads");
    let parts = node.raw_publisher("part", "shop_msgs/msg/Part", &Qos::latched(1)).expect("good name");
    let _unknown = node.raw_publisher("riddle", "shop_msgs/msg/Riddle", &Qos::latched(1)).expect("good name");
    parts.publish(&[0, 1, 0, 0, 2, 0, 0, 0, b'a', 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]).expect("room");
    until("the part is on the disk", || {
        Bag::open(&bag)
            .is_ok_and(|b| b.topics().iter().zip(b.message_counts()).any(|(t, &n)| t.name == "/part" && n == 1))
    });
    process.interrupt();
    assert!(process.wait(PATIENCE).success(), "{}", process.stderr());
    let stderr = process.stderr();
    let sentence = "/riddle is not recorded: the definition of shop_msgs/msg/Riddle is not known here";
    assert_eq!(stderr.matches(sentence).count(), 1, "{stderr}");
    let read = Bag::open(&bag).expect("it is closed");
    let topic = read.topics().iter().find(|topic| topic.name == "/part").expect("it is recorded");
    let line = "=".repeat(80);
    let definition = format!(
        "# A part\nstd_msgs/String name\nSize size\n\n{line}\nMSG: shop_msgs/Size\nfloat64 length # (m)\n\n{line}\nMSG: std_msgs/String\nstring data\n"
    );
    assert_eq!((&topic.definition, &topic.type_hash), (&definition, &hash));
    assert_eq!(check(&bag).expect("there is a bag").findings, []);
    std::fs::remove_dir_all(directory).expect("it is ours");
}

/// The publisher's own node supplies the definition of a type that is not installed here, and other readers decode the recording.
#[test]
fn a_type_is_known_from_the_node_that_publishes_it() {
    let Some(peers) = support::peer_env() else { return };
    let domain = Domain::reserve();
    let directory = directory("asked");
    let bag = directory.join("run");
    let bag_dir = format!("bag_dir:={}", bag.display());
    let words = ["--ros-args", "-p", &bag_dir, "-p", "types:=['geometry_msgs/*']"];
    let mut cell = RecorderUnderTest::new(&domain, &words);
    let mut peer = Peer::start(peers, &domain, "surveyor");
    let kind = "geometry_msgs/msg/PolygonStamped";
    assert!(camwright_msgs::by_type_name(kind).is_none(), "it is not one of ours");
    peer.ask("advertise", json!({"topic": "/outline", "type": kind, "qos": "latched"}));
    peer.ask("publish", json!({"topic": "/outline", "data": {"polygon": {"points": [{"x": 1.0}, {"y": 2.0}]}}}));
    assert!(cell.change_state(CONFIGURE) && cell.change_state(ACTIVATE));
    until("the outline is written", || cell.written("/outline") == 1);
    assert!(cell.change_state(DEACTIVATE));
    cell.end();
    let read = Bag::open(&bag).expect("it is closed");
    assert_eq!(read.topics().iter().map(|topic| topic.type_name.as_str()).collect::<Vec<_>>(), [kind]);
    assert_eq!(check(&bag).expect("there is a bag").findings, []);
    let counts = rosbags_counts(&bag, &domain).expect("the peers are there");
    assert_eq!(counts["topics"]["/outline"]["count"], json!(1));
    assert_eq!(counts["topics"]["/outline"]["type"], json!(kind));
    std::fs::remove_dir_all(directory).expect("it is ours");
}
