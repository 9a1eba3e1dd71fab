// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The cell as it is delivered: machine at the wall clock's pace, interpolator and planner, each a process; and what it is asked.

use super::asker::{Asker, DISCOVERY, between_ns, now_ns, qos};
use super::figures::Row;
use super::support::{Domain, Guarded, command::Shared, processes::in_domain};
use camwright_files::convert::time::{TickClock, ns_from_time};
use camwright_msgs::Message;
use camwright_msgs::camwright_msgs::action::{RunJob, RunJobGoal};
use camwright_msgs::camwright_msgs::msg::{MachineIo, MachineStream};
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_msgs::std_srvs::srv::{Trigger, TriggerRequest};
use camwright_msgs::trajectory_msgs::msg::JointTrajectory;
use camwright_ros::{Qos, Subscription};
use std::os::unix::process::CommandExt;
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::time::{Duration, Instant};

/// Cycle time of the machine that is used.
const CYCLE_TIME_NS: u32 = 1_000_000;
/// Maximum time of the cell's actions.
pub const PATIENCE: Duration = Duration::from_secs(60);
/// Ticks between the last news of the machine and the first setpoint of a chunk: more than passes until it is there.
const LEAD_TICKS: u64 = 50;

/// Message of the machine, with its publication time by the system's clock (ns).
#[derive(Debug)]
pub enum MachineMessage {
    Joints { tick: u64, published_ns: i64, velocity: [f64; 3] },
    Io { tick: u64, published_ns: i64, io: Box<MachineIo> },
    Stream { published_ns: i64, here: Instant, stream: Box<MachineStream> },
}

/// The three processes; ended when this is dropped.
pub struct CellProcesses {
    _command: Shared,
    _processes: [Guarded; 3],
}

impl CellProcesses {
    pub fn start(domain: &Domain) -> Self {
        let machine: &[&str] = &["pace:=realtime", "state_file:=none"];
        let nodes: [(&str, &str, &[&str]); 3] = [
            ("machine_sim", env!("CARGO_BIN_EXE_machine_sim"), machine),
            ("axis_interpolator", env!("CARGO_BIN_EXE_axis_interpolator"), &[]),
            ("job_planner", env!("CARGO_BIN_EXE_job_planner"), &[]),
        ];
        let processes = nodes.map(|(name, binary, parameters)| {
            let mut command = in_domain(binary, domain);
            command.args(["--ros-args", "--log-level", "warn"]).process_group(0);
            for parameter in parameters {
                command.args(["-p", parameter]);
            }
            Guarded::start(name, &mut command)
        });
        Self { _command: Shared::for_cell(domain, ""), _processes: processes }
    }
}

/// Hears the machine.
pub struct Watch {
    messages: mpsc::Receiver<MachineMessage>,
    pub clock: TickClock,
    /// Lengths of the chunks on their way to the machine (octets).
    chunks: Arc<Mutex<Vec<usize>>>,
    _subscriptions: [Subscription; 4],
}

impl Watch {
    /// Waits for the machine's first word.
    pub fn new(asker: &Asker) -> Self {
        let (sender, messages) = mpsc::channel();
        let (to_io, to_stream) = (sender.clone(), sender.clone());
        let depth = Qos::default_topic().keep_last(2000);
        let joints = asker.node.subscribe("joint_states", &depth, move |state, info| {
            let state: JointState = state;
            let tick = u64::try_from(ns_from_time(&state.header.stamp)).unwrap_or(0);
            let velocity = std::array::from_fn(|i| state.velocity.get(i).copied().unwrap_or(0.0));
            let _over = sender.send(MachineMessage::Joints {
                tick,
                published_ns: info.source_timestamp_ns.unwrap_or(0),
                velocity,
            });
        });
        let io = asker.node.subscribe("machine/io", &qos(), move |io, info| {
            let io: Box<MachineIo> = Box::new(io);
            let _over = to_io.send(MachineMessage::Io {
                tick: io.tick,
                published_ns: info.source_timestamp_ns.unwrap_or(0),
                io,
            });
        });
        let stream = asker.node.subscribe("machine/stream", &qos(), move |stream, info| {
            let stream: Box<MachineStream> = Box::new(stream);
            let published_ns = info.source_timestamp_ns.unwrap_or(0);
            let _over = to_stream.send(MachineMessage::Stream { published_ns, here: Instant::now(), stream });
        });
        let chunks: Arc<Mutex<Vec<usize>>> = Arc::default();
        let lengths = Arc::clone(&chunks);
        let chunk = asker.node.subscribe_raw("machine/setpoints", JointTrajectory::TYPE_NAME, &qos(), move |cdr, _| {
            lengths.lock().unwrap_or_else(PoisonError::into_inner).push(cdr.len());
        });
        let subscriptions = [joints, io, stream, chunk].map(|made| made.expect("a subscription"));
        let mut watch = Self {
            messages,
            chunks,
            clock: TickClock { epoch_ns: 0, cycle_time_ns: CYCLE_TIME_NS },
            _subscriptions: subscriptions,
        };
        let stream = watch.stream(|_| true);
        watch.clock.epoch_ns = ns_from_time(&stream.2.epoch);
        watch
    }

    /// The next word of the machine.
    pub fn next(&self) -> MachineMessage {
        match self.messages.recv_timeout(DISCOVERY) {
            // Joint states have a time; the machine's clock converts it to a tick.
            Ok(MachineMessage::Joints { tick: stamp_ns, published_ns, velocity }) => {
                let stamp_ns = i64::try_from(stamp_ns).unwrap_or(0);
                MachineMessage::Joints { tick: self.clock.nearest_tick(stamp_ns).unwrap_or(0), published_ns, velocity }
            }
            Ok(messages) => messages,
            Err(error) => panic!("the machine says nothing any more: {error}"),
        }
    }

    /// The next stream message that fits: when it left, when it was here, what it says.
    pub fn stream(&self, fits: impl Fn(&MachineStream) -> bool) -> (i64, Instant, Box<MachineStream>) {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let MachineMessage::Stream { published_ns, here, stream } = self.next() else { continue };
            if fits(&stream) {
                return (published_ns, here, stream);
            }
            assert!(Instant::now() < deadline, "the machine does not say what was awaited, but {stream:?}");
        }
    }

    /// Median length of the chunks so far, and their number.
    pub fn usual_chunk(&self) -> (usize, usize) {
        let mut lengths = self.chunks.lock().unwrap_or_else(PoisonError::into_inner).clone();
        lengths.sort_unstable();
        (lengths.get(lengths.len() / 2).copied().unwrap_or(0), lengths.len())
    }

    /// Forgets what was said so far.
    pub fn catch_up(&self) {
        while self.messages.try_recv().is_ok() {}
    }
}

/// Chunks of setpoints at rest, each the whole of a motion: who sends one has command from the tick in which the machine has it, and
/// the machine says so at once.
pub fn send_chunks(asker: &mut Asker, watch: &Watch, chunk: &JointTrajectory, [one_way, round_trip]: [&mut Row; 2]) {
    let publisher = asker.node.publisher::<JointTrajectory>("machine/setpoints", &qos()).expect("a publisher");
    assert!(publisher.wait_matched(1, DISCOVERY), "the machine does not listen to setpoints");
    let mut chunk = chunk.clone();
    let reset = asker.node.client::<Trigger>("machine/reset").expect("a client");
    reset.wait_for_service(DISCOVERY).expect("the machine");
    for _ in 0..one_way.wanted {
        if !asker.goes_on() {
            return;
        }
        watch.catch_up();
        let (_, _, stream) = watch.stream(|stream| stream.holder.is_empty());
        // At any moment between two of the machine's regular words.
        std::thread::sleep(asker.dice.below(Duration::from_millis(10)));
        chunk.header.stamp = watch.clock.stamp(stream.tick + LEAD_TICKS);
        for point in &mut chunk.points {
            point.positions = rest_positions(&stream);
        }
        let (asked_ns, asked) = (now_ns(), Instant::now());
        publisher.publish(&chunk).expect("it can be published");
        let (published_ns, here, stream) =
            watch.stream(|stream| !stream.holder.is_empty() || !stream.alarms.is_empty());
        if stream.alarms.is_empty() {
            one_way.times.push(between_ns(asked_ns, published_ns));
            round_trip.times.push(here - asked);
        } else {
            // It came after its first tick, or not at all.
            one_way.lost += 1;
            round_trip.lost += 1;
            watch.stream(|stream| stream.motion == MachineStream::MOTION_FAULT);
            reset.call(&TriggerRequest::default(), PATIENCE).expect("the machine answers");
        }
        watch.stream(|stream| stream.holder.is_empty() && stream.alarms.is_empty());
    }
}

/// Rest positions of the axes (rad, m): by the encoder scales of the machine.
fn rest_positions(stream: &MachineStream) -> Vec<f64> {
    const PER_UNIT: [f64; 3] = [3_600_000.0 / std::f64::consts::TAU, 1e8, 1e7];
    stream.setpoint_counts.iter().zip(PER_UNIT).map(|(counts, per_unit)| *counts as f64 / per_unit).collect()
}

/// Goals for jobs that are planned, accepted, and cancelled before anything moves.
pub fn run_jobs(asker: &mut Asker, job: &str, row: &mut Row) {
    let client = asker.node.action_client::<RunJob>("job_planner/run_job").expect("a client");
    client.wait_for_server(DISCOVERY).expect("the planner");
    while row.times.len() < row.wanted && asker.goes_on() {
        let goal = RunJobGoal { job: job.to_owned(), ..RunJobGoal::default() };
        let asked = Instant::now();
        let sent = client.send_goal(goal, |_| {}, PATIENCE).expect("a decision");
        let taken = asked.elapsed();
        if !sent.accepted() {
            // The machine has not been heard of yet, or the job before ends.
            row.lost += 1;
            assert!(row.lost < 100, "the planner accepts no goal");
            std::thread::sleep(Duration::from_millis(50));
            continue;
        }
        row.times.push(taken);
        let _may_have_ended = sent.cancel(PATIENCE);
        sent.result(PATIENCE).expect("the goal ends");
    }
    row.lost = 0;
}
