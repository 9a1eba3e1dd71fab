// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The machine's side: keeps the lease, answers those who want it, refuses all others.

use super::lease::{Lease, LeaseRequest, Participant, Role, participant_of};
use super::{lock, rules};
use camwright_msgs::camwright_msgs::msg::CommandHolder;
use camwright_msgs::camwright_msgs::srv::{
    JoinCommand, JoinCommandRequest, JoinCommandResponse, TakeCommand, TakeCommandRequest, TakeCommandResponse,
};
use camwright_ros::{Authority, Guid, Node, Publisher, Qos, Responder, RosError, ServiceHandle, TimerHandle};
use camwright_threads::silence::LOOK;
use camwright_threads::system_time::system_time_ns;
use std::any::Any;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Longest wait of an answer for the members to hear of a change; a member that has ended is lost earlier.
const HEARING: Duration = Duration::from_secs(4);
/// Answers that may wait.
const MAX_WAITING: usize = 32;
/// Time between two alarms about refusals.
const ALARM_PERIOD: Duration = Duration::from_secs(1);

/// The lease, and how often it was the reason for a refusal.
#[derive(Debug)]
struct LeaseGate {
    own: Participant,
    lease: Mutex<Lease>,
    refused: AtomicU32,
}

impl Authority for LeaseGate {
    fn refusal(&self, service: &str, request: &dyn Any, sender: &Guid) -> Option<String> {
        let by = participant_of(*sender);
        if by == self.own || rules::is_open(service, request) {
            return None;
        }
        let refused = lock(&self.lease).refusal(by, Instant::now());
        self.refused.fetch_add(u32::from(refused.is_some()), Ordering::Relaxed);
        refused
    }
}

/// An answer that waits until the members have acknowledged a change.
type DelayedAnswer = (Responder<TakeCommand>, TakeCommandResponse, u64, Instant);

/// Keeps the lease of a machine.
#[derive(Debug)]
pub struct CommandServer {
    node: Node,
    gate: Arc<LeaseGate>,
    publisher: Publisher<CommandHolder>,
    /// Number of the state that was published last.
    published: Mutex<u64>,
    waiting: Mutex<Vec<DelayedAnswer>>,
}

/// Services and timer of a desk.
#[derive(Debug)]
pub struct Open {
    pub services: Vec<ServiceHandle>,
    /// Looks after the lease.
    pub timer: TimerHandle,
}

impl CommandServer {
    /// Lets the lease decide on every request to the node; members are lost after `silence_limit`.
    ///
    /// # Errors
    /// The node is shut down.
    pub fn new(node: &Node, silence_limit: Duration) -> Result<Arc<Self>, RosError> {
        let first_number = u64::try_from(system_time_ns()).unwrap_or(1);
        let lease = Mutex::new(Lease::new(silence_limit, first_number));
        let own = participant_of(node.participant_guid()?);
        let gate = Arc::new(LeaseGate { own, lease, refused: AtomicU32::new(0) });
        node.set_authority(Arc::<LeaseGate>::clone(&gate));
        let publisher = node.publisher("machine/command_holder", &Qos::latched(1))?;
        let desk = Self { node: node.clone(), gate, publisher, published: Mutex::new(0), waiting: Mutex::default() };
        desk.publish_change();
        Ok(Arc::new(desk))
    }

    /// Offers the services; `in_motion` says whether setpoints are executed, `alarm` raises the alarm about refusals.
    ///
    /// # Errors
    /// The node is shut down.
    pub fn open(
        self: &Arc<Self>,
        in_motion: impl Fn() -> bool + Send + 'static,
        mut alarm: impl FnMut() + Send + 'static,
    ) -> Result<Open, RosError> {
        let this = Arc::clone(self);
        let take = self.node.service_deferred::<TakeCommand>("machine/take_command", move |request, responder| {
            this.grant(&request, responder);
        })?;
        let this = Arc::clone(self);
        let join = self.node.service_deferred::<JoinCommand>("machine/join_command", move |request, responder| {
            let answer = this.join(&request, &responder.sender());
            responder.send(&answer);
        })?;
        let this = Arc::clone(self);
        let mut alarmed: Option<Instant> = None;
        let timer = self.node.timer(LOOK, move || {
            {
                let mut lease = lock(&this.gate.lease);
                lease.note_motion(in_motion());
                lease.check_holder(|holder| this.node.knows_participant(holder), Instant::now());
                lease.expire(Instant::now());
            }
            this.publish_change();
            this.answer_waiting();
            if alarmed.is_none_or(|at| at.elapsed() >= ALARM_PERIOD) && this.gate.refused.swap(0, Ordering::Relaxed) > 0
            {
                alarmed = Some(Instant::now());
                alarm();
            }
        });
        Ok(Open { services: vec![take, join], timer })
    }

    /// Returns true where a setpoint or command of a writer is taken; a refusal is logged and counted for the alarm.
    pub fn accepts_motion(&self, topic: &str, writer: &Guid) -> bool {
        let refused = lock(&self.gate.lease).refusal_of_motion(participant_of(*writer), Instant::now());
        match refused {
            None => true,
            Some(reason) => {
                self.refuse(topic, writer, &reason);
                false
            }
        }
    }

    /// Logs a message that is refused, once for each sender and topic, and counts it for the alarm.
    pub fn refuse(&self, topic: &str, writer: &Guid, reason: &str) {
        self.gate.refused.fetch_add(1, Ordering::Relaxed);
        self.log_refusal(topic, writer, reason);
    }

    fn log_refusal(&self, topic: &str, writer: &Guid, reason: &str) {
        let who = self.node.who(writer);
        self.node.warn_once(&format!("{topic} of {who} refused"), &format!("{topic} of {who} refused: {reason}"));
    }

    fn grant(&self, request: &TakeCommandRequest, responder: Responder<TakeCommand>) {
        let (by, now) = (participant_of(responder.sender()), Instant::now());
        let TakeCommandRequest { holder, lease_s, shared, release } = request;
        let (outcome, remaining_s, holder, number) = {
            let mut lease = lock(&self.gate.lease);
            let outcome = if *release {
                lease.release(by, holder, now)
            } else {
                lease.acquire(by, LeaseRequest { name: holder, lease_s: *lease_s, shared: *shared }, now)
            };
            let holder = lease.holder().map_or_else(String::new, |holder| holder.name.clone());
            (outcome, lease.remaining_s(now), holder, lease.number())
        };
        self.publish_change();
        let (success, message) = match outcome {
            Ok(()) if *release => (true, "command is released".to_owned()),
            Ok(()) => (true, format!("{holder} has command for {remaining_s:.0} s; renew it before")),
            Err(reason) => (false, reason),
        };
        let answer = TakeCommandResponse { success, message, holder, remaining_s };
        let mut waiting = lock(&self.waiting);
        if waiting.len() >= MAX_WAITING {
            return responder.send(&answer);
        }
        waiting.push((responder, answer, number, now + HEARING));
        drop(waiting);
        self.answer_waiting();
    }

    fn join(&self, request: &JoinCommandRequest, sender: &Guid) -> JoinCommandResponse {
        let (by, machine) = (participant_of(*sender), self.gate.own);
        let Some(role) = Role::named(&request.role) else {
            let shown: String = request.role.chars().take(64).collect();
            let message = format!("role is {shown:?}; it must be axis_interpolator or job_planner");
            return JoinCommandResponse { success: false, message, machine };
        };
        let (outcome, has_conflict) = {
            let mut lease = lock(&self.gate.lease);
            // A role whose owner has left the graph is free at once.
            lease.check_graph(role, |member| self.node.knows_participant(member));
            let outcome = lease.join(by, role, (request.known, request.busy), Instant::now());
            (outcome, lease.take_conflict())
        };
        self.gate.refused.fetch_add(u32::from(has_conflict), Ordering::Relaxed);
        if let Err(message) = outcome {
            self.log_refusal("machine/join_command", sender, &message);
            return JoinCommandResponse { success: false, message, machine };
        }
        self.gate.refused.fetch_add(request.refused.min(1), Ordering::Relaxed);
        if request.known != lock(&self.gate.lease).number() {
            *lock(&self.published) = 0;
        }
        self.publish_change();
        self.answer_waiting();
        JoinCommandResponse { success: true, message: String::new(), machine }
    }

    /// Publishes and logs what has changed.
    fn publish_change(&self) {
        let mut published = lock(&self.published);
        let lease = lock(&self.gate.lease);
        if *published == lease.number() {
            return;
        }
        let member = |role| lease.member(role).unwrap_or_default();
        let mut message = CommandHolder {
            stamp: self.node.now(),
            number: lease.number(),
            interpolator: member(Role::Interpolator),
            planner: member(Role::Planner),
            ..CommandHolder::default()
        };
        if let Some(holder) = lease.holder() {
            message.holder.clone_from(&holder.name);
            (message.participant, message.shared) = (holder.participant, holder.shared);
            message.lease_s = holder.lease.as_secs_f64();
        }
        *published = lease.number();
        drop(lease);
        if let Err(error) = self.publisher.publish(&message) {
            self.node.logger().error(&format!("the holder of command cannot be published: {error}"));
        }
    }

    /// Answers those whose change every member has received, and those who have waited for long enough.
    fn answer_waiting(&self) {
        let now = Instant::now();
        let due: Vec<DelayedAnswer> = {
            let lease = lock(&self.gate.lease);
            let is_due = |waiting: &mut DelayedAnswer| lease.is_known(waiting.2, now) || waiting.3 <= now;
            lock(&self.waiting).extract_if(.., is_due).collect()
        };
        for (responder, answer, ..) in due {
            responder.send(&answer);
        }
    }
}
