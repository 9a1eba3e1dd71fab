// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Tables of a bag as Parquet: pandas and pyarrow read every value as it stands in the CSV, and as rosbags reads it from the bag.

use crate::support;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use camwright_bag::qos::{Durability, QosProfile, Reliability};
use camwright_bag::{BagWriter, RecordingOutcome, Topic, TopicId, WriterOptions};
use camwright_msgs::Message;
use camwright_msgs::camwright_msgs::msg::{MachineInput, RecorderStatus, TopicRecord};
use camwright_msgs::geometry_msgs::msg::PointStamped;
use camwright_msgs::sensor_msgs::msg::JointState;
use serde_json::{Value, json};
use support::{Domain, peer_env, repository};

const START_NS: u64 = 1_760_000_000_000_000_000;

fn directory(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("bag-tables-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&path).expect("the target directory is writable");
    path
}

/// A bag under construction, a message every millisecond.
struct BagBuilder {
    writer: BagWriter,
    time_ns: u64,
}

impl BagBuilder {
    fn topic<T: Message>(&mut self, name: &str) -> TopicId {
        let offered_qos = vec![QosProfile::discovered(Reliability::Reliable, Durability::Volatile)];
        let (type_name, type_hash) = (T::TYPE_NAME.into(), T::TYPE_HASH.into());
        let topic = Topic { name: name.into(), type_name, type_hash, definition: T::SCHEMA.into(), offered_qos };
        self.writer.add_topic(&topic).expect("the disk has room")
    }

    fn write<T: Message>(&mut self, topic: TopicId, message: &T) {
        let body = cdr_encoding::to_vec::<_, byteorder::LittleEndian>(message).expect("a message can be written");
        let data = [&[0, 1, 0, 0][..], &body].concat();
        self.time_ns += 1_000_000;
        self.writer.write(topic, self.time_ns, self.time_ns - 7, &data).expect("the disk has room");
    }
}

/// Arrays that grow and shrink, one that is too long for columns, types within types, texts with everything in them, numbers at their ends.
fn make(bag: &Path) {
    let writer = BagWriter::create(bag, &WriterOptions::default()).expect("the directory is free");
    let mut making = BagBuilder { writer, time_ns: START_NS };
    let joints = making.topic::<JointState>("/joint_states");
    let points = making.topic::<PointStamped>("/cell/point");
    let inputs = making.topic::<MachineInput>("/machine/inputs");
    let statuses = making.topic::<RecorderStatus>("/run_logger/status");
    for tick in 0..300_u32 {
        let axes = usize::try_from(tick % 4).expect("few");
        let mut message = JointState { name: vec!["x_axis".into(); axes], ..JointState::default() };
        message.position =
            (0..axes).map(|axis| f64::from(tick).sqrt() * 10_f64.powi(i32::try_from(axis).expect("few"))).collect();
        message.velocity.clone_from(&message.position);
        message.header.frame_id = ["", "a, \"b\"", "zwei\nZeilen", "µm"][axes].into();
        making.write(joints, &message);
        if tick % 10 == 0 {
            let ends = [f64::MAX, f64::MIN_POSITIVE, -0.0, f64::INFINITY, f64::NAN, 0.1];
            let mut point = PointStamped::default();
            let end = |place: u32| ends[usize::try_from((tick / 10 + place) % 6).expect("few")];
            (point.point.x, point.point.y, point.point.z) = (end(0), end(1), end(2));
            point.header.stamp.sec = if tick == 0 { i32::MIN } else { i32::MAX };
            point.header.stamp.nanosec = u32::MAX;
            making.write(points, &point);
        }
        if tick % 50 == 0 {
            let values = (0..tick).map(f64::from).collect();
            let input =
                MachineInput { tick: u64::MAX - u64::from(tick), values, check: u64::MAX, ..MachineInput::default() };
            making.write(inputs, &input);
            let record =
                |n: u32| TopicRecord { topic: format!("/t{n}"), written: u64::from(n), ..TopicRecord::default() };
            let (recording, topics) = (tick % 100 == 0, (0..tick / 50).map(record).collect());
            making.write(statuses, &RecorderStatus { recording, topics, ..RecorderStatus::default() });
        }
    }
    making.writer.close(RecordingOutcome::Complete, 0).expect("the disk has room");
}

fn export(at: &Path, to: &str) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_camwright"));
    let output = command.args(["bag", "export", "RUN", "--to", to]).current_dir(at).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn stdout_of(output: &Output) -> &[u8] {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    &output.stdout
}

#[test]
fn every_value_of_the_tables_is_that_of_the_bag_and_has_its_type() {
    let Some(env) = peer_env() else { return };
    let (domain, at) = (Domain::reserve(), directory("values"));
    make(&at.join("RUN"));
    export(&at, "csv");
    export(&at, "parquet");
    let mut judge = env.python("judge_tables.py", &domain);
    let output = judge.args(["RUN", "RUN_csv", "RUN_parquet"]).current_dir(&at).output().expect("there is Python");
    let report: Value = serde_json::from_slice(stdout_of(&output)).expect("one JSON object");
    assert_eq!(report["rows"], json!(300 + 30 + 6 + 6));
    assert!(report["values"].as_u64().is_some_and(|values| values > 3000), "{}", report["values"]);
    let types = &report["types"];
    for (table, column, expected) in [
        ("joint_states", "log_time", "timestamp[ns, tz=UTC]"),
        ("joint_states", "header.stamp.sec", "int32"),
        ("joint_states", "header.stamp.nanosec", "uint32"),
        ("joint_states", "header.frame_id", "string"),
        ("joint_states", "position[2]", "double"),
        ("machine.inputs", "tick", "uint64"),
        ("machine.inputs", "kind", "uint8"),
        ("machine.inputs", "writer[15]", "uint8"),
        ("machine.inputs", "values", "list<element: double not null>"),
        ("run_logger.status", "recording", "bool"),
        ("run_logger.status", "topics[4].topic", "string"),
        ("cell.point", "point.z", "double"),
    ] {
        assert_eq!(types[table][column], json!(expected), "{table}, {column}");
    }
    std::fs::remove_dir_all(at).expect("it is ours");
}

/// The pandas lines of `docs/reference/bags.md` work.
#[test]
fn the_documented_lines_of_python_run() {
    let Some(env) = peer_env() else { return };
    let (domain, at) = (Domain::reserve(), directory("documented"));
    make(&at.join("RUN"));
    export(&at, "csv");
    export(&at, "parquet");
    let document =
        std::fs::read_to_string(repository().join("docs/reference/bags.md")).expect("it is in the repository");
    let blocks: Vec<&str> = document.split("```python\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    let mut ran = 0;
    for (number, block) in blocks.iter().enumerate().filter(|(_, block)| block.contains("pandas")) {
        let script = at.join(format!("documented_{number}.py"));
        std::fs::write(&script, block).expect("the directory is ours");
        let mut python = env.python(&script.display().to_string(), &domain);
        let output = python.current_dir(&at).output().expect("there is Python");
        assert!(
            String::from_utf8_lossy(stdout_of(&output)).contains("position[0]"),
            "{}",
            String::from_utf8_lossy(&output.stdout)
        );
        ran += 1;
    }
    assert!(ran >= 1, "docs/reference/bags.md has nothing for pandas");
    std::fs::remove_dir_all(at).expect("it is ours");
}
