// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A machine made of a `joint_trajectory_controller` of `ros2_control`, through nothing but the public interfaces of the crate:
//! `cargo run --release -p camwright_nodes --example trajectory_controller_bridge -- MACHINE_FILE [CONTROLLER]`.
//!
//! It replaces `machine_sim`: it publishes the machine's description (`machine/description`), receives `machine/setpoints`, passes them to
//! `CONTROLLER/joint_trajectory` as a trajectory that replaces the one before, and publishes the axes of `CONTROLLER/controller_state`,
//! tick by tick. The controller's stamps are its clock: a tick is published once the controller has reported a time after it. The core's
//! own buffer holds the rules of chunks (M10 to M14), so this file contains only the bridge.
//!
//! What it does not do: inputs and their edges (M6, M21: caught in hardware or not at all), a new zero of an axis (M21), wheel, dresser and
//! force (M22). It refuses those with an alarm of its own. Its emergency stop is a stop on the path. `joint_state_broadcaster` publishes
//! `joint_states` too: give it another name, for these here have the stamps of ticks.
#![allow(dead_code, unreachable_pub, reason = "the tests include it as a module")]

use camwright::machine::alarm::{Alarm as Found, AlarmKind, AlarmSeverity, NO_TICK};
use camwright::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use camwright::machine::persistent_state::PersistentState;
use camwright::machine::setpoint::Setpoint;
use camwright::simulation::buffer::{ChunkError, SetpointBuffer};
use camwright_authority::{CommandServer, Open};
use camwright_files::convert::machine_description::description_message;
use camwright_files::convert::setpoints::{ChunkBuffer, chunk_from_trajectory, joint_names, trajectory_from_chunk};
use camwright_files::convert::time::{TickClock, ns_from_time};
use camwright_files::convert::{counts_from_si, si_from_counts};
use camwright_files::machine_file::{self, MachineConfig};
use camwright_msgs::camwright_msgs::msg::{
    Alarm, MachineAlarms, MachineCommand, MachineDescription as DescriptionMessage, MachineIo, MachineStream,
};
use camwright_msgs::control_msgs::msg::JointTrajectoryControllerState;
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolResponse, Trigger, TriggerResponse};
use camwright_msgs::trajectory_msgs::msg::JointTrajectory;
use camwright_ros::{
    Guid, Node, NodeOptions, Publisher, Qos, RosArgs, RosError, RosLayer, ServiceHandle, Shutdown, SpinThread,
    Subscription,
};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// An order that this bridge has nothing for.
const NOT_HERE: u16 = 1000;
/// Ticks for which an axis must stay at its setpoint to be at rest there, and within how many counts.
const SETTLED: (u32, u64) = (50, 20);

/// State of the axes in the controller at a time (m, rad, s).
#[derive(Debug, Clone, Copy, Default)]
struct Feedback {
    ns: i64,
    position: [f64; AXIS_COUNT],
    velocity: [f64; AXIS_COUNT],
}

#[derive(Debug)]
struct BridgeOutlets {
    description: Publisher<DescriptionMessage>,
    stream: Publisher<MachineStream>,
    joint_states: Publisher<JointState>,
    io: Publisher<MachineIo>,
    alarms: Publisher<MachineAlarms>,
    controller: Publisher<JointTrajectory>,
}

/// Longest silence of the axis interpolator.
const SILENCE: std::time::Duration = std::time::Duration::from_millis(2500);

/// The machine that the bridge makes of a controller.
#[derive(Debug)]
struct BridgedMachine {
    machine: MachineDescription,
    buffer: SetpointBuffer,
    clock: TickClock,
    before: Feedback,
    tick: u64,
    setpoint: Setpoint,
    settled: u32,
    holder: Option<Guid>,
    commands_received: u32,
    alarms: Vec<Alarm>,
    alarms_changed: bool,
    reported: (u8, usize, bool, u32),
    estop: bool,
}

/// A running bridge.
#[derive(Debug)]
pub struct Bridge {
    node: Node,
    _endpoints: (Vec<Subscription>, Vec<ServiceHandle>, Open),
    _spin: SpinThread,
}

/// State shared by callbacks: `None` before the controller's first message.
#[derive(Debug, Clone)]
struct Shared {
    node: Node,
    file: Arc<MachineConfig>,
    outlets: Arc<BridgeOutlets>,
    standing: Arc<Mutex<Option<BridgedMachine>>>,
}

impl Bridge {
    /// Stands in for a machine before a controller.
    ///
    /// # Errors
    /// DDS that cannot start.
    pub fn start(args: &RosArgs, file: MachineConfig, controller: &str) -> Result<Self, RosError> {
        let node = Node::new(NodeOptions::new("machine_bridge", args))?;
        let desk = CommandServer::new(&node, SILENCE)?;
        let many = Qos::default_topic().keep_last(2000);
        let outlets = BridgeOutlets {
            description: node.publisher("machine/description", &Qos::latched(1))?,
            stream: node.publisher("machine/stream", &many)?,
            joint_states: node.publisher("joint_states", &many)?,
            io: node.publisher("machine/io", &many)?,
            alarms: node.publisher("machine/alarms", &Qos::latched(1))?,
            controller: node.publisher(&format!("{controller}/joint_trajectory"), &Qos::default_topic())?,
        };
        outlets.description.publish(&description_message(&file, &PersistentState::new(&file.description)))?;
        let (file, outlets) = (Arc::new(file), Arc::new(outlets));
        let shared = Shared { node: node.clone(), file, outlets, standing: Arc::default() };
        let (state, chunks, orders) = (shared.clone(), shared.clone(), shared.clone());
        let (of_chunks, of_orders) = (Arc::clone(&desk), Arc::clone(&desk));
        let subscriptions = vec![
            node.subscribe(&format!("{controller}/controller_state"), &many, move |message, _| {
                state.receive(&message);
            })?,
            node.subscribe("machine/setpoints", &many, move |message, info| {
                if of_chunks.accepts_motion("machine/setpoints", &info.writer) {
                    chunks.follow(&message, participant(info.writer));
                }
            })?,
            node.subscribe("machine/commands", &many, move |message, info| {
                if of_orders.accepts_motion("machine/commands", &info.writer) {
                    orders.obey(&message, participant(info.writer));
                }
            })?,
        ];
        let (reset, stop, moving, alarms) = (shared.clone(), shared.clone(), shared.clone(), shared);
        let services = vec![
            node.service::<Trigger>("machine/reset", move |_| reset.reset())?,
            node.service::<SetBool>("machine/estop", move |request| stop.press(request.data))?,
        ];
        let in_motion = move || moving.standing().as_ref().is_some_and(|standing| standing.holder.is_some());
        let refused = move || {
            if let Some(standing) = alarms.standing().as_mut() {
                standing.raise(AlarmKind::NoAuthority, 0.0, 0.0);
            }
        };
        let command = desk.open(in_motion, refused)?;
        let spin = node.spin_in_thread()?;
        Ok(Self { node, _endpoints: (subscriptions, services, command), _spin: spin })
    }

    /// Ends; the controller runs out on the stop of what it has.
    pub fn stop(self) {
        self.node.shutdown();
    }
}

/// A sender is known by its participant.
fn participant(mut writer: Guid) -> Guid {
    writer[12..].fill(0);
    writer
}

impl Shared {
    fn standing(&self) -> MutexGuard<'_, Option<BridgedMachine>> {
        self.standing.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn warn(&self, outcome: Result<(), RosError>) {
        if let Err(error) = outcome {
            self.node.logger().warn(&error.to_string());
        }
    }

    /// Executes every tick up to the time of the controller's state.
    fn receive(&self, message: &JointTrajectoryControllerState) {
        let Some(feedback) = feedback(message) else {
            return self.node.logger().warn(&format!("the controller has joints {:?}", message.joint_names));
        };
        let mut standing = self.standing();
        let Some(standing) = standing.as_mut() else {
            *standing = Some(BridgedMachine::new(&self.file.description, feedback));
            return;
        };
        while standing.clock.ns(standing.tick + 1) <= feedback.ns {
            let now = between(&standing.before, &feedback, standing.clock.ns(standing.tick + 1));
            let stops_before = standing.is_stopped();
            let news = standing.execute(&now, &self.node);
            if standing.is_stopped() && !stops_before {
                standing.buffer.close();
            }
            self.warn(self.publish(standing, &now, news));
        }
        standing.before = feedback;
    }

    /// Publishes a tick.
    fn publish(&self, standing: &mut BridgedMachine, now: &Feedback, mut news: MachineStream) -> Result<(), RosError> {
        let (tick, stamp) = (standing.tick, standing.clock.stamp(standing.tick));
        let mut joints = JointState { name: joint_names(), ..JointState::default() };
        joints.header.stamp = stamp.clone();
        for axis in Axis::ALL {
            let counts = news.actual_counts[axis.index()];
            joints.position.push(si_from_counts(standing.machine.axis(axis).scale, counts));
        }
        joints.velocity.extend(now.velocity);
        self.outlets.joint_states.publish(&joints)?;
        let reported = (news.motion, standing.alarms.len(), standing.holder.is_some(), standing.commands_received);
        let changed = std::mem::replace(&mut standing.reported, reported) != reported || standing.alarms_changed;
        if std::mem::take(&mut standing.alarms_changed) || tick == 1 {
            self.outlets.alarms.publish(&MachineAlarms {
                stamp: stamp.clone(),
                tick,
                alarms: standing.alarms.clone(),
            })?;
        }
        if changed || tick.is_multiple_of(1000) {
            let estop = standing.estop;
            self.outlets.io.publish(&MachineIo {
                stamp: stamp.clone(),
                tick,
                estop,
                drives_on: true,
                ..MachineIo::default()
            })?;
        }
        if changed || tick.is_multiple_of(standing.machine.stream_period_ticks()) {
            news.stamp = stamp;
            self.outlets.stream.publish(&news)?;
        }
        Ok(())
    }

    /// A chunk: judged by the core's buffer, then all that is there from now on goes to the controller.
    fn follow(&self, message: &JointTrajectory, sender: Guid) {
        let mut standing = self.standing();
        let Some(standing) = standing.as_mut() else { return };
        if standing.holder.is_some_and(|holder| holder != sender) {
            return standing.raise(AlarmKind::SecondWriter, 0.0, 0.0);
        }
        let refused = |first_tick| (AlarmKind::ChunkRefused, first_tick, 0.0);
        let Ok(chunk) = chunk_from_trajectory(message, &standing.machine, standing.clock) else {
            return standing.refuse(refused(NO_TICK));
        };
        let first_tick = chunk.first_tick as f64;
        if let Some(beyond) = standing.beyond(&chunk) {
            return standing.refuse(beyond);
        }
        // The controller is ahead of its last message.
        let now = standing.clock.nearest_tick(self.node.now_ns()).unwrap_or(0).max(standing.tick);
        match standing.buffer.accept(&chunk.as_chunk(), now) {
            Ok(()) => {
                standing.holder = Some(sender);
                let trajectory = standing.window(&chunk);
                self.warn(self.outlets.controller.publish(&trajectory));
            }
            Err(ChunkError::Closed) => {}
            Err(ChunkError::Lost { expected, .. }) => {
                standing.refuse((AlarmKind::SetpointsLost, first_tick, expected as f64));
            }
            Err(error) => {
                self.node.logger().warn(&format!("setpoints of {} refused: {error}", self.node.who(&sender)));
                standing.refuse(refused(first_tick));
            }
        }
    }

    fn obey(&self, message: &MachineCommand, sender: Guid) {
        let mut standing = self.standing();
        let Some(standing) = standing.as_mut() else { return };
        if standing.holder.is_some_and(|holder| holder != sender) {
            return standing.raise(AlarmKind::SecondWriter, 0.0, 0.0);
        }
        if message.sequence == 1 {
            standing.commands_received = 0;
        }
        let expected = standing.commands_received + 1;
        if message.sequence != expected {
            return standing.raise(AlarmKind::CommandGap, f64::from(message.sequence), f64::from(expected));
        }
        if message.tick <= standing.tick {
            return standing.raise(AlarmKind::LateCommand, (standing.tick + 1 - message.tick) as f64, 0.0);
        }
        standing.commands_received = message.sequence;
        match message.kind {
            // Of jobs it keeps no book, and an input that it lacks is not closed.
            MachineCommand::JOB_BEGIN | MachineCommand::JOB_END | MachineCommand::ASK => {}
            MachineCommand::ALARM => match u16::try_from(message.counts).ok().and_then(AlarmKind::from_number) {
                Some(kind) => standing.raise(kind, f64::NAN, 0.0),
                None => standing.own("the sender's alarm has a number that is not in the table"),
            },
            kind => standing.own(&format!("command {kind} for {:?}: a bridge has nothing for it", message.target)),
        }
    }

    fn reset(&self) -> TriggerResponse {
        let mut standing = self.standing();
        let refuse = |message: &str| TriggerResponse { success: false, message: message.into() };
        let Some(standing) = standing.as_mut() else { return refuse("the controller has not been heard") };
        if standing.estop {
            return refuse("the emergency stop is pressed");
        }
        if !standing.is_at_rest() {
            return refuse("the axes are not at rest yet");
        }
        standing.alarms_changed = !std::mem::take(&mut standing.alarms).is_empty();
        standing.buffer.open(standing.setpoint);
        standing.holder = None;
        TriggerResponse { success: true, message: "alarms are cleared; nothing moves before a new goal".to_owned() }
    }

    fn press(&self, pressed: bool) -> SetBoolResponse {
        let mut standing = self.standing();
        let Some(standing) = standing.as_mut() else { return SetBoolResponse::default() };
        standing.estop = pressed;
        if pressed {
            standing.raise(AlarmKind::EStop, 0.0, 0.0);
        }
        SetBoolResponse { success: true, message: "a stop on the path, and no safety function".to_owned() }
    }
}

impl BridgedMachine {
    fn new(machine: &MachineDescription, feedback: Feedback) -> Self {
        let clock = TickClock {
            epoch_ns: feedback.ns.div_euclid(1_000_000_000) * 1_000_000_000,
            cycle_time_ns: machine.cycle_time_ns,
        };
        let rest = Setpoint { counts: counts(machine, &feedback), ..Setpoint::default() };
        Self {
            buffer: SetpointBuffer::new(machine, rest),
            tick: clock.nearest_tick(feedback.ns).unwrap_or(0),
            machine: machine.clone(),
            clock,
            before: feedback,
            setpoint: rest,
            settled: 0,
            holder: None,
            commands_received: 0,
            alarms: Vec::new(),
            alarms_changed: true,
            reported: Default::default(),
            estop: false,
        }
    }

    fn is_stopped(&self) -> bool {
        self.alarms.iter().any(|alarm| alarm.severity > Alarm::WARNING)
    }

    fn is_at_rest(&self) -> bool {
        self.settled >= SETTLED.0
    }

    /// Executes one tick: its setpoint, and the controller's state at that time.
    fn execute(&mut self, now: &Feedback, node: &Node) -> MachineStream {
        let next = self.tick + 1;
        if self.buffer.is_underrun(next) && !self.is_stopped() {
            self.raise(AlarmKind::Underrun, 0.0, 0.0);
            self.buffer.close();
        }
        let given = self.buffer.at(next);
        self.setpoint = given.unwrap_or(Setpoint { velocity: [0.0; 3], acceleration: [0.0; 3], ..self.setpoint });
        self.buffer.executed(next);
        self.tick = next;
        if self.buffer.is_spent() || (self.is_stopped() && given.is_none()) {
            self.holder = None;
        }
        let mut actual = counts(&self.machine, now);
        let off = |axis: usize| actual[axis].abs_diff(self.setpoint.counts[axis]);
        let is_near = (0..AXIS_COUNT).all(|axis| off(axis) <= SETTLED.1);
        let is_given = given.is_some() || self.buffer.has_setpoints();
        self.settled = if is_given || !is_near { 0 } else { self.settled.saturating_add(1) };
        self.watch(&actual);
        let motion = match (self.is_stopped(), self.is_at_rest()) {
            (true, true) => MachineStream::MOTION_FAULT,
            (true, false) => MachineStream::MOTION_STOPPING,
            (false, true) => MachineStream::MOTION_STANDSTILL,
            (false, false) => MachineStream::MOTION_RUNNING,
        };
        if self.is_at_rest() {
            // At rest an axis is reported at its setpoint (M8), within the tolerance of its drive.
            actual = self.setpoint.counts;
        }
        MachineStream {
            epoch: self.clock.stamp(0),
            tick: next,
            credit_tick: self.buffer.credit(next),
            pace: MachineStream::PACE_REALTIME,
            motion,
            commands_received: self.commands_received,
            holder: self.holder.map_or_else(String::new, |holder| node.who(&holder)),
            alarms: self.alarms.iter().map(|alarm| alarm.number).collect(),
            setpoint_counts: self.setpoint.counts.to_vec(),
            actual_counts: actual.to_vec(),
            actual_velocities: now.velocity.to_vec(),
            ..MachineStream::default()
        }
    }

    /// Following errors (M32); soft limits are looked at before a chunk is taken.
    fn watch(&mut self, actual: &[i64; AXIS_COUNT]) {
        for axis in Axis::ALL {
            let own = self.machine.axis(axis);
            let at = axis.index();
            let off = own.scale.position(actual[at].saturating_sub(self.setpoint.counts[at])).abs();
            let speed = (self.setpoint.velocity[at] / own.limits.velocity).abs();
            let bound = (own.max_following_error * speed).max(own.min_following_error);
            if off > bound {
                self.raise(AlarmKind::FollowingError(axis), off, bound);
            }
        }
    }

    /// The first setpoint of a chunk that is beyond the soft limits.
    fn beyond(&self, chunk: &ChunkBuffer) -> Option<(AlarmKind, f64, f64)> {
        let points = chunk.dense.iter().chain(chunk.tail.iter().map(|point| &point.setpoint));
        points.flat_map(|point| Axis::ALL.map(|axis| (axis, point))).find_map(|(axis, point)| {
            let (low, high) = self.machine.axis(axis).soft_limits?;
            let place = self.machine.axis(axis).scale.position(point.counts[axis.index()]);
            let bound = if place < low { low } else { high };
            (place < low || place > high).then_some((AlarmKind::SoftLimit(axis), place, bound))
        })
    }

    /// Trajectory for the controller from here: the present setpoint, all pending ones, and the stop. Its spline through position, velocity
    /// and acceleration is the same quintic that the contract requires (M10).
    fn window(&self, newest: &ChunkBuffer) -> JointTrajectory {
        let last = newest.first_tick + newest.dense.len() as u64 - 1;
        let mut rest = self.setpoint;
        let dense = (self.tick + 1..=last).map(|tick| {
            rest = self.buffer.at(tick).unwrap_or(rest);
            rest
        });
        let all = ChunkBuffer {
            first_tick: self.tick + 1,
            dense: dense.collect(),
            tail: newest.tail.clone(),
            is_final: newest.is_final,
        };
        trajectory_from_chunk(&all, &self.machine, self.clock)
    }

    fn refuse(&mut self, (kind, value, bound): (AlarmKind, f64, f64)) {
        if !self.is_stopped() {
            self.raise(kind, value, bound);
            self.buffer.close();
        }
    }

    fn raise(&mut self, kind: AlarmKind, value: f64, bound: f64) {
        let entry = kind.entry();
        let text = Found { kind, tick: self.tick, value, bound }.to_string();
        self.add(entry.number, entry.severity, text, entry.remedy);
    }

    fn own(&mut self, text: &str) {
        self.add(NOT_HERE, AlarmSeverity::Stop, text.to_owned(), "reset; do this by hand, or extend the bridge");
    }

    /// An alarm, of the tick that is executed next.
    fn add(&mut self, number: u16, severity: AlarmSeverity, text: String, remedy: &str) {
        if self.alarms.iter().any(|alarm| alarm.number == number) {
            return;
        }
        let tick = self.tick;
        let (stamp, remedy) = (self.clock.stamp(tick), remedy.to_owned());
        let source = "machine_bridge".to_owned();
        self.alarms.push(Alarm { stamp, tick, number, severity: severity as u8, source, text, remedy, active: true });
        self.alarms_changed = true;
        if severity > AlarmSeverity::Warning {
            self.buffer.close();
        }
    }
}

/// Place and velocity of each axis, by its joint.
fn feedback(message: &JointTrajectoryControllerState) -> Option<Feedback> {
    let mut feedback = Feedback { ns: ns_from_time(&message.header.stamp), ..Feedback::default() };
    for axis in Axis::ALL {
        let place = message.joint_names.iter().position(|name| name == axis.joint())?;
        feedback.position[axis.index()] = *message.feedback.positions.get(place)?;
        feedback.velocity[axis.index()] = message.feedback.velocities.get(place).copied().unwrap_or(0.0);
    }
    Some(feedback)
}

/// Interpolates between two states of the controller.
fn between(before: &Feedback, after: &Feedback, ns: i64) -> Feedback {
    let share = if after.ns > before.ns { (ns - before.ns) as f64 / (after.ns - before.ns) as f64 } else { 1.0 };
    let share = share.clamp(0.0, 1.0);
    let of = |one: f64, other: f64| one + share * (other - one);
    Feedback {
        ns,
        position: core::array::from_fn(|axis| of(before.position[axis], after.position[axis])),
        velocity: core::array::from_fn(|axis| of(before.velocity[axis], after.velocity[axis])),
    }
}

fn counts(machine: &MachineDescription, feedback: &Feedback) -> [i64; AXIS_COUNT] {
    core::array::from_fn(|axis| counts_from_si(machine.axes[axis].scale, feedback.position[axis]))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (args, words) = RosArgs::from_env()?;
    RosLayer::install();
    let mut words = words.into_iter();
    let path = words.next().ok_or("usage: trajectory_controller_bridge MACHINE_FILE [CONTROLLER] [--ros-args ...]")?;
    let controller = words.next().unwrap_or_else(|| "joint_trajectory_controller".to_owned());
    let file = machine_file::parse(Path::new(&path), &std::fs::read_to_string(&path)?, &[])?;
    let shutdown = Shutdown::on_signals()?;
    let bridge = Bridge::start(&args, file, &controller)?;
    shutdown.wait();
    bridge.stop();
    Ok(())
}
