// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Observed messages of a machine, in the order of arrival.

use camwright_files::convert::counts_per_si;
use camwright_msgs::Message;
use camwright_msgs::builtin_interfaces::msg::Time;
use camwright_msgs::camwright_msgs::msg::{MachineAlarms, MachineDescription, MachineIo, MachineStream};
use camwright_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus};
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_ros::{Node, Qos, RosError, Subscription};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// No machine runs for so many ticks: 285 000 years of milliseconds. With fewer of them no sum overflows.
pub(super) const MAX_TICK: u64 = 1 << 53;

/// Nanoseconds of a stamp; the checker's own, so that it does not believe what it judges.
pub(super) fn ns(stamp: &Time) -> i64 {
    i64::from(stamp.sec) * 1_000_000_000 + i64::from(stamp.nanosec)
}

/// A message of `joint_states`, without the names.
#[derive(Debug, Clone)]
pub(super) struct Joints {
    pub(super) stamp_ns: i64,
    pub(super) position: Vec<f64>,
    pub(super) velocity: Vec<f64>,
    pub(super) effort: Vec<f64>,
}

/// Everything that was received.
#[derive(Debug, Default)]
pub(super) struct Observed {
    pub(super) description: Option<MachineDescription>,
    /// Hashes of descriptions after the first one that differ from it.
    pub(super) other_hashes: Vec<String>,
    pub(super) streams: Vec<MachineStream>,
    /// Tick of a message of the stream that cannot be: it is not among the others.
    pub(super) beyond: Option<u64>,
    /// When the messages of the stream came.
    pub(super) came: Vec<Instant>,
    pub(super) joints: Vec<Joints>,
    pub(super) joint_names: Vec<String>,
    /// The names changed, and to what.
    pub(super) other_names: Option<Vec<String>>,
    pub(super) io: Vec<MachineIo>,
    pub(super) alarms: Vec<MachineAlarms>,
    /// Warnings in diagnostics.
    pub(super) warnings: Vec<String>,
}

impl Observed {
    /// Observations up to this number of stream messages; of the other topics everything.
    pub(super) fn until(&self, streams: usize) -> Self {
        let streams = streams.min(self.streams.len());
        let last = self.streams[..streams].last().map_or(i64::MAX, |message| ns(&message.stamp));
        Self {
            description: self.description.clone(),
            other_hashes: self.other_hashes.clone(),
            streams: self.streams[..streams].to_vec(),
            beyond: self.beyond,
            came: self.came[..streams].to_vec(),
            joints: self.joints.iter().filter(|message| message.stamp_ns <= last).cloned().collect(),
            joint_names: self.joint_names.clone(),
            other_names: self.other_names.clone(),
            io: self.io.clone(),
            alarms: self.alarms.clone(),
            warnings: self.warnings.clone(),
        }
    }

    /// The last news of the machine.
    pub(super) fn last(&self) -> Option<&MachineStream> {
        self.streams.last()
    }

    /// True if `machine/alarms` names the alarms of the last message of the stream.
    pub(super) fn alarms_agree(&self) -> bool {
        let (Some(stream), Some(alarms)) = (self.streams.last(), self.alarms.last()) else { return false };
        sorted(stream.alarms.clone()) == alarm_numbers(alarms)
    }
}

/// Numbers of the alarms of a message, in ascending order.
pub(super) fn alarm_numbers(message: &MachineAlarms) -> Vec<u16> {
    sorted(message.alarms.iter().map(|alarm| alarm.number).collect())
}

/// Numbers of alarms in ascending order.
pub(super) fn sorted(mut numbers: Vec<u16>) -> Vec<u16> {
    numbers.sort_unstable();
    numbers
}

/// Content of the description, in integers.
#[derive(Debug, Clone)]
pub(super) struct DescriptionFacts {
    pub(super) cycle_ns: i64,
    pub(super) delay: u64,
    /// Ticks between two messages of the stream.
    pub(super) period: u64,
    /// The same of a machine that stands still at pace realtime without setpoints.
    pub(super) rest_period: u64,
    pub(super) joints: Vec<String>,
    /// Counts of an axis for a metre or a radian.
    pub(super) per_unit: Vec<f64>,
}

impl DescriptionFacts {
    pub(super) fn from_description(description: &MachineDescription) -> Self {
        let delay = u64::from(description.feedback_delay_ticks);
        Self {
            cycle_ns: i64::from(description.cycle_time_ns),
            delay,
            period: (delay / 10).max(1),
            rest_period: 5 * (delay / 10).max(1),
            joints: description.axes.iter().map(|axis| axis.joint.clone()).collect(),
            per_unit: description.axes.iter().map(counts_per_si).collect(),
        }
    }

    /// Length of a tick (s).
    pub(super) fn cycle_s(&self) -> f64 {
        self.cycle_ns as f64 * 1e-9
    }
}

/// Observations so far, shared with the callbacks, and a condition variable for new ones.
#[derive(Debug, Clone, Default)]
pub(super) struct Observer(Arc<(Mutex<Observed>, Condvar)>);

impl Observer {
    /// Looks at what was received.
    pub(super) fn read<R>(&self, read: impl FnOnce(&Observed) -> R) -> R {
        read(&self.0.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Waits until it is as wanted; `None` after the time.
    pub(super) fn wait<R>(&self, patience: Duration, mut wanted: impl FnMut(&Observed) -> Option<R>) -> Option<R> {
        let end = Instant::now() + patience;
        let mut observed = self.0.0.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if let Some(found) = wanted(&observed) {
                return Some(found);
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return None;
            }
            observed = self.0.1.wait_timeout(observed, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn update(&self, change: impl FnOnce(&mut Observed)) {
        change(&mut self.0.0.lock().unwrap_or_else(PoisonError::into_inner));
        self.0.1.notify_all();
    }

    fn topic<M: Message>(
        &self,
        node: &Node,
        topic: &str,
        qos: &Qos,
        take: impl Fn(&mut Observed, M) + Send + 'static,
    ) -> Result<Subscription, RosError> {
        let ears = self.clone();
        node.subscribe::<M>(topic, qos, move |message, _| ears.update(|observed| take(observed, message)))
    }

    /// Subscribes to what a machine says.
    pub(super) fn open(&self, node: &Node) -> Result<Vec<Subscription>, RosError> {
        let many = Qos::default_topic().keep_last(2000);
        Ok(vec![
            self.topic(node, "machine/description", &Qos::latched(1), describe)?,
            self.topic(node, "machine/stream", &many, update_stream)?,
            self.topic(node, "joint_states", &many, join)?,
            self.topic(node, "machine/io", &many, |observed, message| observed.io.push(message))?,
            self.topic(node, "machine/alarms", &Qos::latched(1), |observed, message| observed.alarms.push(message))?,
            self.topic(node, "/diagnostics", &many, |observed, message: DiagnosticArray| {
                let amiss = message.status.into_iter().filter(|status| status.level != DiagnosticStatus::OK);
                observed.warnings.extend(amiss.map(|status| format!("{}: {}", status.name, status.message)));
            })?,
        ])
    }
}

fn update_stream(observed: &mut Observed, mut message: MachineStream) {
    if message.tick > MAX_TICK {
        observed.beyond = Some(message.tick);
        return;
    }
    message.credit_tick = message.credit_tick.min(MAX_TICK);
    observed.streams.push(message);
    observed.came.push(Instant::now());
}

fn describe(observed: &mut Observed, message: MachineDescription) {
    match &observed.description {
        Some(first) if first.hash != message.hash => observed.other_hashes.push(message.hash),
        Some(_) => {}
        None => observed.description = Some(message),
    }
}

fn join(observed: &mut Observed, message: JointState) {
    if observed.joint_names.is_empty() {
        observed.joint_names.clone_from(&message.name);
    } else if observed.joint_names != message.name {
        observed.other_names = Some(message.name);
        return;
    }
    let (stamp_ns, position) = (ns(&message.header.stamp), message.position);
    observed.joints.push(Joints { stamp_ns, position, velocity: message.velocity, effort: message.effort });
}
