// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The cell's own traffic at the wall clock's pace, and a proof from the bag that no message of it is missing.

use super::recorders::RunLoggerProcess;
use super::support::{Domain, Guarded, PATIENCE, command::Shared, processes::in_domain};
use camwright_analysis::rerun;
use camwright_bag::check::check;
use camwright_bag::{Bag, BagMessage};
use camwright_files::convert::time::ns_from_time;
use camwright_msgs::camwright_msgs::msg::{MachineInput, MachineStream, RecorderStatus};
use camwright_msgs::cdr::message_from_sample;
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_ros::Node;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::time::Duration;

/// The cycle of the machine that is used.
const CYCLE_NS: i64 = 1_000_000;
/// Topics that must be recorded before the first job, or its run could not be recomputed.
const RECORDED: [&str; 6] = [
    "/joint_states",
    "/machine/stream",
    "/machine/setpoints",
    "/machine/inputs",
    "/axis_interpolator/inputs",
    "/job_planner/plan",
];
/// The recorder gets the joint states of every tick, those of a machine at rest too. A pause of the computer is no alarm 80.
const MACHINE: &[&str] =
    &["pace:=realtime", "state_file:=none", "rest_publish_rate_hz:=1000.0", "setpoint_buffer_ms:=500.0"];

fn start_nodes(domain: &Domain) -> [Guarded; 3] {
    let nodes: [(&str, &str, &[&str]); 3] = [
        ("machine_sim", env!("CARGO_BIN_EXE_machine_sim"), MACHINE),
        ("axis_interpolator", env!("CARGO_BIN_EXE_axis_interpolator"), &[]),
        ("job_planner", env!("CARGO_BIN_EXE_job_planner"), &[]),
    ];
    nodes.map(|(name, binary, parameters)| {
        let mut command = in_domain(binary, domain);
        command.args(["--ros-args", "--log-level", "warn"]).process_group(0);
        for parameter in parameters {
            command.args(["-p", parameter]);
        }
        Guarded::start(name, &mut command)
    })
}

/// Ends the nodes from the top down, each well.
fn end(nodes: [Guarded; 3]) {
    for mut node in nodes.into_iter().rev() {
        node.interrupt();
        let status = node.wait(PATIENCE);
        assert!(status.success(), "a node ends with {status}{}", node.complaint());
    }
}

/// Records the cell while it works; prints what was recorded, and gives what is not as it should be, of the work too.
pub fn record(bag: &Path, work: impl FnOnce(&Node) -> Vec<String>) -> Vec<String> {
    let domain = Domain::reserve();
    let recorder = RunLoggerProcess::start(&domain, bag, &[]);
    assert!(recorder.wait_status(PATIENCE, |status| status.recording), "the recorder does not record");
    let nodes = start_nodes(&domain);
    let command = Shared::for_cell(&domain, "");
    recorder.wait_for_topics(&RECORDED);
    let mut wrong = work(&recorder.node);
    drop(command);
    end(nodes);
    // The last messages of the nodes are on their way; the status is published ten times a second.
    std::thread::sleep(Duration::from_secs(1));
    let status = recorder.status();
    let (bag, used) = recorder.end();
    println!("recorder: {:.1} s of CPU, {} kB at most", used.cpu_s, used.peak_kb);
    wrong.extend(judge(&bag, &status));
    wrong
}

/// A message that follows its like by an even step, or without one, by none or any.
struct Steps {
    what: &'static str,
    step: Option<i64>,
    last: Option<i64>,
    count: u64,
    breaks: Vec<String>,
}

impl Steps {
    fn new(what: &'static str, step: Option<i64>) -> Self {
        Self { what, step, last: None, count: 0, breaks: Vec::new() }
    }

    fn add(&mut self, value: i64) {
        let fits = self.last.is_none_or(|last| self.step.map_or(value >= last, |step| value == last + step));
        if !fits {
            self.breaks.push(format!("{}: {value} after {:?}", self.what, self.last));
        }
        self.last = Some(value);
        self.count += 1;
    }
}

fn decode<M: serde::de::DeserializeOwned>(message: &BagMessage) -> M {
    message_from_sample(&message.data).expect("the bag's messages are of their types")
}

/// Errors of a bag of the cell; prints its content.
fn judge(path: &Path, status: &RecorderStatus) -> Vec<String> {
    let bag = Bag::open(path).expect("it is closed");
    let mut wrong = Vec::new();
    let mut joints = Steps::new("stamp of joint_states (ns)", Some(CYCLE_NS));
    let mut stream = Steps::new("tick of machine/stream", None);
    let mut inputs = Steps::new("sequence of machine/inputs", Some(1));
    let mut numbers: Vec<Steps> = bag.topics().iter().map(|_| Steps::new("number in its topic", Some(1))).collect();
    let mut messages = bag.messages();
    let (mut joints_ns, mut last_tick) = (0, 0);
    while let Some(message) = messages.next_message().expect("the bag is readable") {
        numbers[message.topic].add(i64::from(message.sequence));
        match bag.topics()[message.topic].name.as_str() {
            "/joint_states" => {
                joints_ns = ns_from_time(&decode::<JointState>(&message).header.stamp);
                joints.add(joints_ns);
            }
            "/machine/stream" => {
                let feedback: MachineStream = decode(&message);
                last_tick = feedback.tick;
                stream.add(i64::try_from(feedback.tick).unwrap_or(i64::MAX));
                let epoch_ns = ns_from_time(&feedback.epoch);
                let of_joints = u64::try_from((joints_ns - epoch_ns) / CYCLE_NS).unwrap_or(0);
                if of_joints > feedback.tick + 1000 {
                    wrong.push(format!("machine/stream says {} while joint_states are at {of_joints}", feedback.tick));
                }
            }
            "/machine/inputs" => {
                let sequence = decode::<MachineInput>(&message).sequence;
                inputs.add(i64::try_from(sequence).unwrap_or(i64::MAX));
            }
            _ => {}
        }
    }
    println!(
        "{} joint states, {} words of machine/stream up to tick {last_tick}, {} inputs",
        joints.count, stream.count, inputs.count
    );
    println!("| topic | received | written | dropped | in the bag |\n|---|---:|---:|---:|---:|");
    for (topic, &count) in bag.topics().iter().zip(bag.message_counts()) {
        let Some(record) = status.topics.iter().find(|record| record.topic == topic.name) else { continue };
        println!("| {} | {} | {} | {} | {count} |", topic.name, record.received, record.written, record.dropped);
        // What came after that status, or waited for the writer then, is in the bag too.
        if record.dropped != 0 || record.received > count {
            wrong.push(format!("{}: {record:?}, {count} in the bag", topic.name));
        }
    }
    for steps in [joints, stream, inputs].into_iter().chain(numbers) {
        wrong.extend(steps.breaks.into_iter().take(3));
    }
    let lost = super::account::lost(&bag);
    let [p50, p99, p99_9, max] = super::account::enqueue(&bag);
    println!("{lost:?}; enqueue {p50} ns (p50), {p99} ns (p99), {p99_9} ns (p99.9), {max} ns (max)");
    if lost.total != 0 {
        wrong.push(format!("the recorder says: {lost:?}"));
    }
    let report = check(path).expect("there is a bag");
    print!("bag check: {}", report.to_text());
    if !report.findings.is_empty() {
        wrong.push(report.to_text());
    }
    match rerun::rerun(path) {
        Ok(verdict) => {
            println!("replay: {}", verdict.to_text());
            if !verdict.is_identical() || verdict.lost != 0 {
                wrong.push("the run computed again is another one".into());
            }
        }
        Err(error) => wrong.push(format!("it cannot be computed again: {error}")),
    }
    wrong
}
