// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A machine with one fault: a node that passes on what a sound one says and hears, all but one thing.
#![allow(missing_debug_implementations, reason = "as above")]
#![allow(unreachable_pub, reason = "a module of test binaries has no outside")]

use crate::support::{Domain, PATIENCE, command::share_command};
use camwright_authority::HeldCommand;
use camwright_msgs::Message;
use camwright_msgs::camwright_msgs::msg::{
    Latch, MachineAlarms, MachineCommand, MachineDescription, MachineIo, MachineStream,
};
use camwright_msgs::camwright_msgs::srv::{TakeCommand, TakeCommandResponse};
use camwright_msgs::sensor_msgs::msg::JointState;
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolResponse, Trigger, TriggerResponse};
use camwright_msgs::trajectory_msgs::msg::JointTrajectory;
use camwright_ros::{
    Client, Guid, Node, NodeOptions, Publisher, Qos, RosArgs, ServiceHandle, SpinThread, Subscription,
};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    None,
    OtherHash,
    OtherLimit,
    TickLeftOut,
    CreditBeyond,
    StampOff,
    StreamTooRare,
    CreditTooLarge,
    AxesSwapped,
    JointsUneven,
    JointStampOff,
    MovesAtStandstill,
    NotAtItsSetpoint,
    JointsBestEffort,
    NoRemedy,
    UnknownPace,
    EdgeReportedTwice,
    EdgeElsewhere,
    OneCountOff,
    LossNotReported,
    RefusalNotReported,
    StrangerNotReported,
    GapNotReported,
    ResetWhileMoving,
    StopWithoutEffect,
    SilenceNotReported,
}

impl Fault {
    /// Alarm that is suppressed.
    fn hushed(self) -> Option<u16> {
        match self {
            Self::SilenceNotReported => Some(80),
            Self::GapNotReported => Some(82),
            Self::StrangerNotReported => Some(83),
            Self::RefusalNotReported => Some(84),
            Self::LossNotReported => Some(85),
            _ => None,
        }
    }

    /// Changed message of the stream; `None` if it is suppressed. `joints` counts those of `joint_states`.
    fn stream(self, mut message: MachineStream, count: u64, edges: &mut Vec<Latch>) -> Option<MachineStream> {
        match self {
            Self::StampOff if count % 6 == 4 => message.stamp.nanosec += 1,
            Self::StreamTooRare if count % 6 == 4 => return None,
            Self::CreditTooLarge if count % 6 == 4 => message.credit_tick += 1,
            Self::AxesSwapped => {
                [&mut message.setpoint_counts, &mut message.actual_counts].into_iter().for_each(|axes| axes.swap(0, 1));
            }
            Self::MovesAtStandstill if is_elsewhere(message.tick) => {
                message.setpoint_counts[2] += 1;
                message.actual_counts[2] += 1;
            }
            Self::NotAtItsSetpoint if count % 6 == 4 => message.setpoint_counts[2] += 1,
            // The largest number there is: an unchecked addition overflows.
            Self::CreditBeyond if count.is_multiple_of(8) => message.credit_tick = u64::MAX,
            Self::UnknownPace => message.pace = 7,
            Self::OneCountOff if message.alarms.is_empty() && message.actual_velocities[0].abs() > 0.1 => {
                message.setpoint_counts[0] += 1;
            }
            Self::EdgeReportedTwice => {
                let again = std::mem::replace(edges, message.latches.clone());
                message.latches.extend(again);
            }
            Self::EdgeElsewhere => message.latches.iter_mut().for_each(|latch| latch.counts += 1_000_000),
            _ => {}
        }
        message.alarms.retain(|number| Some(*number) != self.hushed());
        Some(message)
    }

    fn joints(self, mut message: JointState, count: u64, period_ns: u32) -> Option<JointState> {
        match self {
            Self::TickLeftOut if count % 200 == 103 => return None,
            // Every second one, and one in addition.
            Self::JointsUneven if count % 2 == 1 || count % 200 == 100 => return None,
            Self::JointStampOff if count % 200 == 100 => message.header.stamp.nanosec += period_ns / 2,
            _ => {}
        }
        Some(message)
    }

    fn alarms(self, mut message: MachineAlarms) -> MachineAlarms {
        message.alarms.retain(|alarm| Some(alarm.number) != self.hushed());
        if self == Self::NoRemedy {
            message.alarms.iter_mut().for_each(|alarm| alarm.remedy.clear());
        }
        message
    }

    fn description(self, mut message: MachineDescription) -> MachineDescription {
        match self {
            Self::OtherHash => message.hash = message.hash.chars().rev().collect(),
            Self::OtherLimit => message.axes[2].max_velocity *= 1.5,
            _ => {}
        }
        message
    }
}

/// Returns whether a resting axis is reported elsewhere at this tick.
fn is_elsewhere(tick: u64) -> bool {
    (tick / 300) % 2 == 1
}

/// Senders that may speak at once.
const SENDERS: usize = 2;

/// Node that passes on a sender's messages: a node of its own, since the machine identifies senders by it.
struct Voice {
    setpoints: Publisher<JointTrajectory>,
    commands: Publisher<MachineCommand>,
    node: Node,
    _spin: SpinThread,
}

pub struct GoBetween {
    outside: Node,
    inside: Node,
    voices: Arc<Vec<Voice>>,
    _subscriptions: Vec<Subscription>,
    _services: Vec<ServiceHandle>,
    _spins: Vec<SpinThread>,
    command: HeldCommand,
}

fn many() -> Qos {
    Qos::default_topic().keep_last(2000)
}

/// Passes a topic on, changed.
fn pass<M: Message + Clone>(
    (inside, outside): (&Node, &Node),
    topic: &str,
    (listen, speak): (&Qos, &Qos),
    mut change: impl FnMut(M) -> Option<M> + Send + 'static,
) -> Subscription {
    let publisher = outside.publisher::<M>(topic, speak).expect("a publisher");
    let forward = move |message: M, _: &_| {
        if let Some(message) = change(message) {
            publisher.publish(&message).expect("it can be said");
        }
    };
    inside.subscribe(topic, listen, forward).expect("a subscription")
}

impl GoBetween {
    pub fn start(domain: &Domain, fault: Fault) -> Self {
        let args = |namespace| RosArgs::default().with_domain_id(domain.id()).with_namespace(namespace);
        let node = |name: &str, namespace| Node::new(NodeOptions::new(name, &args(namespace))).expect("a node");
        let (outside, inside) = (node("between", "/broken"), node("between", "/sound"));
        let voices = (0..SENDERS).map(|index| {
            let node = node(&format!("voice_{index}"), "/sound");
            let setpoints = node.publisher("machine/setpoints", &many()).expect("a publisher");
            let commands = node.publisher("machine/commands", &many()).expect("a publisher");
            let spin = node.spin_in_thread().expect("a thread");
            Voice { setpoints, commands, node, _spin: spin }
        });
        let voices = Arc::new(voices.collect::<Vec<_>>());
        let moving = Arc::new(AtomicBool::new(false));
        let mut subscriptions = pass_feedback(&inside, &outside, fault, &moving);
        subscriptions.extend(hears(&outside, &voices));
        let services = serves(&inside, &outside, fault, moving);
        let spins = vec![inside.spin_in_thread().expect("a thread"), outside.spin_in_thread().expect("a thread")];
        for voice in voices.iter() {
            assert!(voice.setpoints.wait_matched(1, PATIENCE) && voice.commands.wait_matched(1, PATIENCE));
        }
        let command = share_command(&inside);
        Self { command, outside, inside, voices, _subscriptions: subscriptions, _services: services, _spins: spins }
    }

    pub fn stop(self) {
        drop(self.command);
        self.outside.shutdown();
        self.inside.shutdown();
        self.voices.iter().for_each(|voice| voice.node.shutdown());
    }
}

fn pass_feedback(inside: &Node, outside: &Node, fault: Fault, moving: &Arc<AtomicBool>) -> Vec<Subscription> {
    let (latched, many) = (Qos::latched(1), many());
    let ends = (inside, outside);
    let moving = Arc::clone(moving);
    let (mut streams, mut joints, mut edges) = (0, 0, Vec::new());
    let joint_states = if fault == Fault::JointsBestEffort { many.best_effort() } else { many };
    let place = Arc::new(Mutex::new(0_i64));
    let epoch = Arc::clone(&place);
    vec![
        pass(ends, "machine/description", (&latched, &latched), move |message| Some(fault.description(message))),
        pass(ends, "machine/stream", (&many, &many), move |message: MachineStream| {
            moving.store(message.motion == MachineStream::MOTION_RUNNING, Ordering::Release);
            *place.lock().expect("not poisoned") =
                i64::from(message.epoch.sec) * 1_000_000_000 + i64::from(message.epoch.nanosec);
            // Only those are counted that must come.
            streams += u64::from(message.tick.is_multiple_of(6));
            fault.stream(message, streams, &mut edges)
        }),
        pass(ends, "joint_states", (&many, &joint_states), move |mut message: JointState| {
            joints += 1;
            let epoch = *epoch.lock().expect("not poisoned");
            let ns =
                i64::from(message.header.stamp.sec) * 1_000_000_000 + i64::from(message.header.stamp.nanosec) - epoch;
            let tick = u64::try_from(ns / 4_000_000).unwrap_or(0);
            if fault == Fault::MovesAtStandstill && epoch > 0 && is_elsewhere(tick) {
                // A count of the table is 0.1 µm.
                message.position[2] += 1e-7;
            }
            fault.joints(message, joints, 4_000_000)
        }),
        pass(ends, "machine/io", (&many, &many), Some::<MachineIo>),
        pass(ends, "machine/alarms", (&latched, &latched), move |message| Some(fault.alarms(message))),
    ]
}

/// Passes on what senders say, each by a voice of its own.
fn hears(outside: &Node, voices: &Arc<Vec<Voice>>) -> Vec<Subscription> {
    let known: Arc<Mutex<Vec<Guid>>> = Arc::default();
    let voice_of = move |writer: &Guid| {
        let mut participant = *writer;
        participant[12..].fill(0);
        let mut known = known.lock().expect("not poisoned");
        known.iter().position(|other| *other == participant).unwrap_or_else(|| {
            known.push(participant);
            known.len() - 1
        })
    };
    let voice_of = Arc::new(voice_of);
    let (first, second) = (Arc::clone(voices), Arc::clone(voices));
    let of_commands = Arc::clone(&voice_of);
    let setpoints = outside.subscribe("machine/setpoints", &many(), move |message: JointTrajectory, info| {
        first[voice_of(&info.writer)].setpoints.publish(&message).expect("it can be said");
    });
    let commands = outside.subscribe("machine/commands", &many(), move |message: MachineCommand, info| {
        second[of_commands(&info.writer)].commands.publish(&message).expect("it can be said");
    });
    vec![setpoints.expect("a subscription"), commands.expect("a subscription")]
}

fn serves(inside: &Node, outside: &Node, fault: Fault, moving: Arc<AtomicBool>) -> Vec<ServiceHandle> {
    let reset: Arc<Client<Trigger>> = Arc::new(inside.client("machine/reset").expect("a client"));
    let estop: Arc<Client<SetBool>> = Arc::new(inside.client("machine/estop").expect("a client"));
    let reset = outside.service_deferred::<Trigger>("machine/reset", move |request, responder| {
        if fault == Fault::ResetWhileMoving && moving.load(Ordering::Acquire) {
            return responder.send(&TriggerResponse { success: true, message: String::new() });
        }
        reset.call_with(&request, move |answer| responder.send(&answer)).expect("it can be asked");
    });
    let estop = outside.service_deferred::<SetBool>("machine/estop", move |request, responder| {
        if fault == Fault::StopWithoutEffect {
            return responder.send(&SetBoolResponse { success: true, message: String::new() });
        }
        estop.call_with(&request, move |answer| responder.send(&answer)).expect("it can be asked");
    });
    // The machine behind it is shared already.
    let take = outside.service::<TakeCommand>("machine/take_command", |_| TakeCommandResponse {
        success: true,
        ..TakeCommandResponse::default()
    });
    vec![reset.expect("a service"), estop.expect("a service"), take.expect("a service")]
}
