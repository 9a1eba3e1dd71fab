// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Who answers without being a machine: our ROS layer alone, rclpy on Fast DDS, Cyclone DDS. Each is a process of its own.

use super::asker::{Asker, Stamped, qos};
use super::figures::Row;
use super::support::{Domain, Guarded, LOOPBACK, PeerEnv};
use camwright_files::convert::setpoints::joint_names;
use camwright_files::convert::time::duration_from_ns;
use camwright_msgs::camwright_msgs::action::{RunJob, RunJobGoal, RunJobResult};
use camwright_msgs::camwright_msgs::msg::{MachineIo, MachineStream};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, SetBoolResponse};
use camwright_msgs::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};
use camwright_msgs::{Action, unique_identifier_msgs::msg::UUID};
use camwright_ros::{ActionHandler, GoalDecision, GoalHandle, GoalId, Node, NodeOptions, RosArgs, Subscription};
use serde::Serialize;
use std::io::Read;
use std::os::unix::process::CommandExt;
use std::process::Command;
use std::time::Duration;

/// The word that makes this program a responder.
pub const ANSWER: &str = "--answer";
/// Setpoints and points of the stop in a chunk as the interpolator sends it: ticks between two messages of the machine, and the
/// median of the points of the stop.
const DENSE: usize = 10;
const STOP_POINTS: usize = 11;
const PATIENCE: Duration = Duration::from_secs(60);

/// Which stack answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stack {
    Ours,
    Rclpy,
    Cyclone,
}

/// Question and answer, of the size that they have in the cell.
pub struct Messages {
    pub chunk: JointTrajectory,
    pub stream: MachineStream,
    pub edge: MachineIo,
    pub stop: JointTrajectory,
}

fn trajectory(points: usize) -> JointTrajectory {
    let point = |index: usize| JointTrajectoryPoint {
        positions: vec![0.1; 3],
        velocities: vec![0.0; 3],
        accelerations: vec![0.0; 3],
        effort: Vec::new(),
        time_from_start: duration_from_ns(i64::try_from(index).unwrap_or(0) * 1_000_000),
    };
    JointTrajectory {
        joint_names: joint_names(),
        points: (0..points).map(point).collect(),
        ..JointTrajectory::default()
    }
}

impl Messages {
    pub fn new() -> Self {
        let stream = MachineStream {
            holder: "/axis_interpolator".into(),
            setpoint_counts: vec![1_000_000; 3],
            actual_counts: vec![1_000_000; 3],
            actual_velocities: vec![0.0; 3],
            ..MachineStream::default()
        };
        let edge = MachineIo {
            station_switches: (1..=4).map(|number| format!("LS{number}")).collect(),
            station_states: vec![false; 4],
            overtravel_x_max: true,
            ..MachineIo::default()
        };
        Self { chunk: trajectory(DENSE + STOP_POINTS), stream, edge, stop: trajectory(STOP_POINTS) }
    }
}

/// CDR in hexadecimal, with the header that states its byte order.
fn hex(message: &impl Serialize) -> String {
    let body = cdr_encoding::to_vec::<_, byteorder::LittleEndian>(message).expect("a message of plain values");
    [0, 1, 0, 0].iter().chain(&body).map(|byte| format!("{byte:02x}")).collect()
}

/// Length of a message on the wire (octets).
pub fn size(message: &impl Serialize) -> usize {
    hex(message).len() / 2
}

/// A responder in its process; ended when this is dropped.
pub struct Twin {
    /// Reported name.
    pub name: String,
    stack: Stack,
    _process: Guarded,
}

fn script(stack: Stack, env: &PeerEnv, domain: &Domain) -> Command {
    let name = if stack == Stack::Rclpy { "rclpy_twin.py" } else { "cyclone_twin.py" };
    let mut command = env.python(&format!("../benchmarks/latency/{name}"), domain);
    command.env("CYCLONEDDS_URI", LOOPBACK);
    command
}

impl Twin {
    pub fn start(stack: Stack, env: Option<&PeerEnv>, domain: &Domain, messages: &Messages) -> Self {
        let mut command = match env {
            Some(env) if stack != Stack::Ours => {
                let mut command = script(stack, env, domain);
                command.args(["answer", &hex(&messages.stream), &hex(&messages.stop)]);
                command
            }
            _ => {
                let mut command = Command::new(std::env::current_exe().expect("this program"));
                command.arg(ANSWER).env("ROS_DOMAIN_ID", domain.id().to_string());
                command
            }
        };
        // Ctrl-C is for this program, which then ends the others.
        let mut process = Guarded::start("a twin", command.process_group(0));
        let name = process.line(PATIENCE).unwrap_or_else(|| panic!("a twin ended{}", process.complaint()));
        Self { name, stack, _process: process }
    }

    /// Has the twin's own stack ask it too; times of the topics and of the service.
    pub fn asked_by_its_like(&self, env: &PeerEnv, domain: &Domain, messages: &Messages, rows: &mut [&mut Row; 3]) {
        let count = rows[0].wanted.to_string();
        let mut command = script(self.stack, env, domain);
        command.args(["ask", &hex(&messages.chunk), &hex(&messages.edge), &count]);
        let mut process = Guarded::start("an asker", command.process_group(0));
        let line = process.line(3 * PATIENCE).unwrap_or_else(|| panic!("an asker ended{}", process.complaint()));
        let report: serde_json::Value = serde_json::from_str(&line).expect("what it says is JSON");
        for (row, name) in rows.iter_mut().zip(["setpoints", "edge", "estop"]) {
            let times = report[name].as_array().into_iter().flatten().filter_map(serde_json::Value::as_u64);
            row.times.extend(times.map(Duration::from_nanos));
            row.lost = row.wanted.saturating_sub(row.times.len());
        }
    }
}

/// Accepts every goal and ends it.
struct Accepting;

impl ActionHandler<RunJob> for Accepting {
    fn goal(&mut self, _id: GoalId, _goal: &RunJobGoal) -> GoalDecision {
        GoalDecision::Accept
    }

    fn accepted(&mut self, goal: GoalHandle<RunJob>) {
        let _first_end = goal.succeed(RunJobResult::default());
    }

    fn cancel(&mut self, _id: GoalId) -> bool {
        false
    }
}

fn answer_topic<Q: Stamped, A: Stamped>(node: &Node, [to, from]: [&str; 2], answer: A) -> Subscription {
    let publisher = node.publisher::<A>(from, &qos()).expect("a publisher");
    let subscription = node.subscribe::<Q>(to, &qos(), move |question, _| {
        let mut answer = answer.clone();
        answer.set_stamp(question.stamp().clone());
        publisher.publish(&answer).expect("it can be published");
    });
    subscription.expect("a subscription")
}

pub const CHUNK: [&str; 2] = ["twin/setpoints", "twin/stream"];
pub const EDGE: [&str; 2] = ["twin/io", "twin/stop"];
const ESTOP: &str = "twin/estop";
const RUN_JOB: &str = "twin/run_job";

/// Our ROS layer as a bare responder; returns when its standard input ends.
pub fn answer() {
    let (args, _rest) = RosArgs::parse(&[]).expect("the environment is ours");
    let node = Node::new(NodeOptions::new("twin", &args)).expect("a node");
    let messages = Messages::new();
    let _topics = [
        answer_topic::<JointTrajectory, MachineStream>(&node, CHUNK, messages.stream),
        answer_topic::<MachineIo, JointTrajectory>(&node, EDGE, messages.stop),
    ];
    let pressed = |_| SetBoolResponse { success: true, message: String::new() };
    let _estop = node.service::<SetBool>(ESTOP, pressed).expect("a service");
    let _run_job = node.action_server::<RunJob>(RUN_JOB, Accepting).expect("an action");
    let _spin = node.spin_in_thread().expect("a thread");
    println!("our ROS layer alone (RustDDS)");
    let _end_of_input = std::io::stdin().read_to_end(&mut Vec::new());
}

/// Asks a twin for everything: chunk, edge, e-stop, goal.
pub fn ask(asker: &mut Asker, twin: &Twin, messages: &Messages, [many, goals]: [usize; 2]) -> Vec<Row> {
    let row = |path: &'static str, wanted: usize| Row::new(path, &twin.name, wanted);
    let mut rows = super::TWIN_PATHS.map(|path| row(path, many));
    rows[5].wanted = goals;
    let [chunk, chunk_back, edge, edge_back, estop, goal] = &mut rows;
    asker.exchange::<JointTrajectory, MachineStream>(CHUNK, &messages.chunk, [chunk, chunk_back]);
    asker.exchange::<MachineIo, JointTrajectory>(EDGE, &messages.edge, [edge, edge_back]);
    asker.call::<SetBool>(ESTOP, || SetBoolRequest { data: true }, estop);
    let mut number = 0_u128;
    let send = || {
        number += 1;
        let id = UUID { uuid: number.to_le_bytes() };
        RunJob::send_goal_request(id, RunJobGoal { job: "eccentric_disc".into(), ..RunJobGoal::default() })
    };
    // A goal is asked for by a service, which is all of an action that a twin on Cyclone offers.
    asker.call::<<RunJob as Action>::SendGoal>(&format!("{RUN_JOB}/_action/send_goal"), send, goal);
    rows.into()
}
