// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Predicted size of the bag of a job: messages of every topic, their rate, and the overhead of the storage.
//!
//! Message sizes come from sample messages written as CDR, not from measurements. Markers and outlines for viewers, whose rate depends
//! on the computer, and alarms and logs are small and omitted.

use std::path::Path;

use camwright::machine::description::{Axis, MachineDescription};
use camwright::machine::persistent_state::PersistentState;
use camwright::simulation::Machine;
use camwright_msgs::camwright_msgs::msg::{
    GaugeReading, InterpolatorState, JobFilePage, MachineInput, MachineKeyframe, MachineStream, PlanPage,
    RecorderStatus, TopicRecord, TurnedPage, WorkArea,
};
use camwright_msgs::control_msgs::msg::{DynamicJointState, InterfaceValue, JointTrajectoryControllerState};
use camwright_msgs::rosgraph_msgs::msg::Clock;
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_msgs::tf2_msgs::msg::TFMessage;
use camwright_msgs::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};
use camwright_msgs::{Message, by_type_name};

use camwright_bag::{CHUNK_BYTES, free_bytes};
use camwright_files::convert::bytes_from_mb;
use camwright_files::convert::job_files::pages_from_files;
use camwright_files::convert::machine_description::WHEEL_JOINT;
use camwright_files::convert::pages::{BYTES_PER_PAGE, page_count};
use camwright_files::convert::setpoints::joint_names;
use camwright_files::convert::setpoints::{CHUNK_TICKS, STOP_POINTS};
use camwright_machine_cycle::keyframes::{PERIOD_S as KEYFRAME_PERIOD_S, ticks_between};
use camwright_machine_cycle::pacing::Pace;
use camwright_machine_cycle::part::clamp_bar;
use camwright_machine_cycle::replay::MachineReplay;
use camwright_msgs::cdr::sample_from_message;
use camwright_planning::{AnyPrepared, bar, with_raw_part};
use camwright_run_logger::MIN_FREE_MB;
use camwright_scene::{Frames, Tree};

/// Bytes of a message in a file in addition to its own: head and fields of its record, and its entry in the index.
const FRAMING: u64 = (1 + 8) + (2 + 4 + 8 + 8) + (8 + 8);
/// Bytes of a chunk in addition to its records, and for each channel in it: its head and its entry in the index of the file, their share of both.
const CHUNK: u64 = (9 + 40) + (9 + 72);
const CHANNEL_IN_CHUNK: u64 = (9 + 2 + 4) + (2 + 8);
/// Size of a channel without its type: names, quality of service, type hash (B).
const CHANNEL: u64 = 800;

/// Topic of the files that a job names.
const JOB_FILES: &str = "job_planner/job_files";
/// Topics of plans, of states of the machine, and of the recorder.
const PLAN: &str = "job_planner/plan";
const KEYFRAMES: &str = "machine/keyframes";
const RECORDER_STATUS: &str = "run_logger/status";

/// Topics of a cell that say little, and that the recorder lists ten times a second like all others.
const QUIET: [(&str, &str); 31] = [
    ("axis_interpolator/alarms", "camwright_msgs/msg/MachineAlarms"),
    ("axis_interpolator/execute_plan/_action/status", "action_msgs/msg/GoalStatusArray"),
    ("axis_interpolator/follow_joint_trajectory/_action/status", "action_msgs/msg/GoalStatusArray"),
    ("axis_interpolator/home/_action/status", "action_msgs/msg/GoalStatusArray"),
    ("axis_interpolator/inputs", "camwright_msgs/msg/AppliedInput"),
    ("axis_interpolator/jog/_action/status", "action_msgs/msg/GoalStatusArray"),
    ("axis_interpolator/move_to/_action/status", "action_msgs/msg/GoalStatusArray"),
    ("axis_interpolator/probe/_action/status", "action_msgs/msg/GoalStatusArray"),
    ("axis_interpolator/transition_event", "lifecycle_msgs/msg/TransitionEvent"),
    ("diagnostics", "diagnostic_msgs/msg/DiagnosticArray"),
    ("events/rosbag2_messages_lost", "rosbag2_interfaces/msg/MessagesLostEvent"),
    ("events/write_split", "rosbag2_interfaces/msg/WriteSplitEvent"),
    ("job_planner/cell_state", "camwright_msgs/msg/CellState"),
    ("job_planner/form_map", "camwright_msgs/msg/FormMap"),
    ("job_planner/job_status", "camwright_msgs/msg/JobStatus"),
    ("job_planner/loading", "camwright_msgs/msg/LoadingState"),
    ("job_planner/lobe_forms", "camwright_msgs/msg/LobeForm"),
    ("job_planner/markers", "visualization_msgs/msg/MarkerArray"),
    ("job_planner/run_job/_action/status", "action_msgs/msg/GoalStatusArray"),
    ("machine/alarms", "camwright_msgs/msg/MachineAlarms"),
    ("machine/command_holder", "camwright_msgs/msg/CommandHolder"),
    ("machine/commands", "camwright_msgs/msg/MachineCommand"),
    ("machine/counters", "camwright_msgs/msg/MachineCounters"),
    ("machine/description", "camwright_msgs/msg/MachineDescription"),
    ("machine/io", "camwright_msgs/msg/MachineIo"),
    ("machine/markers", "visualization_msgs/msg/MarkerArray"),
    ("machine/outline", "camwright_msgs/msg/PartLobe"),
    ("machine/part", "camwright_msgs/msg/PartLobe"),
    ("parameter_events", "rcl_interfaces/msg/ParameterEvent"),
    ("rosout", "rcl_interfaces/msg/Log"),
    ("tf_static", "tf2_msgs/msg/TFMessage"),
];

/// One topic of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TopicSize {
    pub topic: &'static str,
    pub type_name: &'static str,
    pub messages: u64,
    pub bytes: u64,
}

/// Predicted content of the bag of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BagSize {
    /// Topics that contribute to the size.
    pub topics: Vec<TopicSize>,
}

impl BagSize {
    /// Estimates the bag of a planned job at a pace.
    #[must_use]
    pub fn estimate(prepared: &AnyPrepared, pace: Pace) -> Self {
        let shortest = shortest_chunk(prepared.machine());
        let chunk_ticks = match pace {
            Pace::Realtime => shortest,
            // A chunk has as many ticks as the machine has gone ahead meanwhile: from `shortest` to a full chunk. How many depends on the
            // computer; this is the geometric mean.
            Pace::Fast => (shortest * CHUNK_TICKS).isqrt(),
        };
        Self::with_chunk_ticks(prepared, pace, chunk_ticks)
    }

    /// Estimates the bag of a planned job at a pace, for a mean number of ticks in a message of set-points.
    #[must_use]
    pub fn with_chunk_ticks(prepared: &AnyPrepared, pace: Pace, chunk_ticks: usize) -> Self {
        let (machine, wheel_radius_mm) = match prepared {
            AnyPrepared::Ground(prepared) => (&prepared.machine, prepared.wheel_radius_mm),
            AnyPrepared::Turned(prepared) => (&prepared.machine, 0.0),
        };
        let mut topics = machine_topics(machine, wheel_radius_mm, prepared.duration_s(), pace, chunk_ticks);
        topics.push(page_topic(PLAN, prepared.first_pages()));
        topics.extend(keyframe_topic(prepared));
        let files = pages_from_files(prepared.job_hash(), prepared.files());
        topics.push(page_topic(JOB_FILES, &files));
        topics.extend(QUIET.map(|(topic, type_name)| TopicSize { topic, type_name, messages: 0, bytes: 0 }));
        // Ten times a second the recorder lists all topics.
        let records = topics.iter().map(|t| TopicRecord {
            topic: format!("/{}", t.topic),
            type_: t.type_name.into(),
            ..TopicRecord::default()
        });
        let status = RecorderStatus { bag: "bags/run".into(), topics: records.collect(), ..RecorderStatus::default() };
        topics.push(topic::<RecorderStatus>(RECORDER_STATUS, count(prepared.duration_s(), 10.0), bytes_of(&status)));
        Self { topics }
    }

    /// Size for a number of consecutive parts. Files of a job are published once. A job that learns publishes its tables again with every
    /// part; this is omitted.
    #[must_use]
    pub fn times(mut self, parts: u32) -> Self {
        let of_each_part = self.topics.iter_mut().filter(|topic| topic.topic != JOB_FILES);
        of_each_part.for_each(|topic| topic.messages = topic.messages.saturating_mul(parts.into()));
        self
    }

    /// Size of the whole bag (B), in the layout of the preset `default`.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let messages: u64 = self.topics.iter().map(|t| t.messages * (t.bytes + FRAMING)).sum();
        // Definitions and channels stand in the data and in the summary.
        let schema = |name: &str| by_type_name(name).map_or(0, |info| info.schema.len() as u64);
        let types: u64 = self.topics.iter().map(|t| 2 * (schema(t.type_name) + CHANNEL)).sum();
        let chunks = messages.div_ceil(CHUNK_BYTES);
        messages + types + chunks * (CHUNK + CHANNEL_IN_CHUNK * self.topics.len() as u64)
    }

    /// One line for people: how large, and what makes most of it.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut largest: Vec<&TopicSize> = self.topics.iter().collect();
        largest.sort_by_key(|t| std::cmp::Reverse(t.messages * (t.bytes + FRAMING)));
        let largest: Vec<String> = largest
            .iter()
            .take(3)
            .map(|t| format!("{} {:.1} MB", t.topic, megabytes(t.messages * (t.bytes + FRAMING))))
            .collect();
        format!("{:.1} MB of bag, uncompressed ({})", megabytes(self.bytes()), largest.join(", "))
    }

    /// Returns a message if the disk of a directory, existing or not, has too little space for the bag.
    #[must_use]
    pub fn lacks_room(&self, directory: &Path) -> Option<String> {
        let there = directory.ancestors().find(|path| path.is_dir() || path.as_os_str().is_empty())?;
        let there = if there.as_os_str().is_empty() { Path::new(".") } else { there };
        let free = free_bytes(there)?;
        let needed = self.bytes().saturating_add(bytes_from_mb(MIN_FREE_MB));
        (free < needed).then(|| {
            let (free, all) = (megabytes(free), megabytes(self.bytes()));
            format!(
                "{free:.0} MB are free on the disk of {}, the bag takes some {all:.0} MB, and the recording ends before less than {MIN_FREE_MB} MB are left",
                there.display()
            )
        })
    }
}

/// Names and types of the topics that a run records, sorted by name. Some are published by machines with a gauge, an insert or `loading` only.
#[must_use]
pub fn recorded_topics(machine: &MachineDescription) -> Vec<(&'static str, &'static str)> {
    let machine_topics = machine_topics(machine, machine.wheel.new_radius_mm, 0.0, Pace::Fast, CHUNK_TICKS);
    let mut topics: Vec<_> = machine_topics.iter().map(|topic| (topic.topic, topic.type_name)).collect();
    topics.extend(QUIET);
    topics.extend([
        (PLAN, PlanPage::TYPE_NAME),
        (JOB_FILES, JobFilePage::TYPE_NAME),
        (KEYFRAMES, MachineKeyframe::TYPE_NAME),
        (RECORDER_STATUS, RecorderStatus::TYPE_NAME),
        ("machine/gauge", GaugeReading::TYPE_NAME),
        ("machine/turned_part", TurnedPage::TYPE_NAME),
        ("machine/work_area", WorkArea::TYPE_NAME),
    ]);
    topics.sort_unstable();
    topics
}

/// Topics of machine and interpolator.
fn machine_topics(
    machine: &MachineDescription,
    wheel_radius_mm: f64,
    duration_s: f64,
    pace: Pace,
    chunk_ticks: usize,
) -> Vec<TopicSize> {
    let tick_s = machine.cycle_time_s();
    let per_tick = |ticks: u64| count(duration_s, 1.0 / (tick_s * (ticks as f64)));
    let stream_ticks = machine.stream_period_ticks();
    let frames = Frames::new("", machine);
    let base = frames.base.clone();
    let tree = Tree::new(machine, wheel_radius_mm, frames);
    let mut topics = Vec::new();
    let joints = Axis::ALL.len() + 1;
    let mut state = JointState { name: joint_names(), ..JointState::default() };
    state.name.push(WHEEL_JOINT.into());
    state.header.frame_id.clone_from(&base);
    (state.position, state.velocity, state.effort) = (vec![0.0; joints], vec![0.0; joints], vec![0.0; joints]);
    topics.push(topic::<JointState>("joint_states", per_tick(1), bytes_of(&state)));
    let axes = Axis::ALL.len();
    let stream = MachineStream {
        holder: "/axis_interpolator".into(),
        setpoint_counts: vec![0; axes],
        actual_counts: vec![0; axes],
        actual_velocities: vec![0.0; axes],
        ..MachineStream::default()
    };
    topics.push(topic::<MachineStream>("machine/stream", per_tick(stream_ticks), bytes_of(&stream)));
    let transforms = TFMessage { transforms: tree.moved(&state.header.stamp, |_| 0.0) };
    topics.push(topic::<TFMessage>("tf", count(duration_s, 50.0), bytes_of(&transforms)));
    let names = ["position", "velocity", "effort", "following_error"];
    let values = InterfaceValue { interface_names: names.map(str::to_owned).into(), values: vec![0.0; names.len()] };
    let mut dynamic =
        DynamicJointState { joint_names: joint_names(), interface_values: vec![values; axes], ..Default::default() };
    if machine.contact.is_some() {
        let process: &[&str] = if machine.process.is_some() { &["power", "burn_index"] } else { &[] };
        let names: Vec<String> = ["velocity", "normal_force"].iter().chain(process).map(ToString::to_string).collect();
        let values = vec![0.0; names.len()];
        dynamic.joint_names.push(WHEEL_JOINT.into());
        dynamic.interface_values.push(InterfaceValue { interface_names: names, values });
    }
    dynamic.header.frame_id = base;
    topics.push(topic::<DynamicJointState>("dynamic_joint_states", count(duration_s, 50.0), bytes_of(&dynamic)));
    topics.extend(interpolator_topics(duration_s, per_tick(1), chunk_ticks));
    if pace == Pace::Fast {
        topics.push(topic::<Clock>("clock", per_tick(10), bytes_of(&Clock::default())));
    }
    topics
}

/// Ticks of the shortest message of set-points: the period of the stream, at most a full chunk.
fn shortest_chunk(machine: &MachineDescription) -> usize {
    usize::try_from(machine.stream_period_ticks()).unwrap_or(CHUNK_TICKS).clamp(1, CHUNK_TICKS)
}

fn interpolator_topics(duration_s: f64, ticks: u64, chunk_ticks: usize) -> Vec<TopicSize> {
    let axes = Axis::ALL.len();
    let point = JointTrajectoryPoint {
        positions: vec![0.0; axes],
        velocities: vec![0.0; axes],
        accelerations: vec![0.0; axes],
        ..JointTrajectoryPoint::default()
    };
    // Points of the path, then those of the stop that follows if nothing else comes.
    let points = chunk_ticks + STOP_POINTS;
    let chunk =
        JointTrajectory { joint_names: joint_names(), points: vec![point.clone(); points], ..Default::default() };
    let chunks = ticks / (chunk_ticks as u64).max(1);
    let measured = JointTrajectoryPoint { accelerations: Vec::new(), ..point.clone() };
    let controller = JointTrajectoryControllerState {
        joint_names: joint_names(),
        reference: point.clone(),
        output: point,
        feedback: measured.clone(),
        error: measured,
        ..JointTrajectoryControllerState::default()
    };
    let holder = "plan 00000000 of /job_planner, job of some name".to_owned();
    let state = InterpolatorState { holder, plan_hash: "0".repeat(64), ..InterpolatorState::default() };
    vec![
        topic::<JointTrajectory>("machine/setpoints", chunks, bytes_of(&chunk)),
        // Each chunk that was taken is an input, and a digest comes every second.
        topic::<MachineInput>("machine/inputs", chunks + count(duration_s, 1.0), bytes_of(&MachineInput::default())),
        topic::<JointTrajectoryControllerState>(
            "axis_interpolator/controller_state",
            count(duration_s, 50.0),
            bytes_of(&controller),
        ),
        topic::<InterpolatorState>("axis_interpolator/state", count(duration_s, 20.0), bytes_of(&state)),
    ]
}

/// The states of the machine with its raw part in it.
fn keyframe_topic(prepared: &AnyPrepared) -> Option<TopicSize> {
    let description = prepared.machine();
    let machine = match prepared {
        AnyPrepared::Ground(prepared) => with_raw_part(prepared, description).ok()?,
        AnyPrepared::Turned(prepared) => {
            let mut machine = Machine::new(description.clone(), PersistentState::new(description)).ok()?;
            clamp_bar(&mut machine, bar(prepared)).ok()?;
            machine
        }
    };
    let size = MachineReplay::from_machine(machine).state().ok()?.len();
    let ticks = ticks_between(size, KEYFRAME_PERIOD_S, description.cycle_time_s());
    let pages = page_count(size, BYTES_PER_PAGE);
    let page = MachineKeyframe { data: vec![0; size / pages as usize], ..MachineKeyframe::default() };
    let keyframes = prepared.duration_s() / (ticks as f64 * description.cycle_time_s());
    Some(topic::<MachineKeyframe>(KEYFRAMES, count(keyframes.floor(), f64::from(pages)), bytes_of(&page)))
}

fn topic<T: Message>(topic: &'static str, messages: u64, bytes: u64) -> TopicSize {
    TopicSize { topic, type_name: T::TYPE_NAME, messages, bytes }
}

/// Pages, with what each takes in the mean.
fn page_topic<T: Message>(name: &'static str, pages: &[T]) -> TopicSize {
    let count = pages.len() as u64;
    topic::<T>(name, count, pages.iter().map(bytes_of).sum::<u64>() / count.max(1))
}

/// Size of a message on the wire, padded to a multiple of four bytes.
fn bytes_of<T: Message>(message: &T) -> u64 {
    sample_from_message(message).map_or(0, |sample| sample.len().next_multiple_of(4) as u64)
}

/// Number of messages at a rate within a duration.
#[allow(clippy::cast_possible_truncation, reason = "a duration of a job and a rate are positive; a cast saturates")]
fn count(duration_s: f64, rate_hz: f64) -> u64 {
    (duration_s * rate_hz).round().max(0.0) as u64
}

fn megabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e6
}
