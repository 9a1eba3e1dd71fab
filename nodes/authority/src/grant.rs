// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The lease as interpolator and planner know it, and their reports to the machine that keeps it.

use super::lease::{Participant, Role, held_text, participant_of};
use super::{lock, rules};
use camwright_msgs::camwright_msgs::msg::CommandHolder;
use camwright_msgs::camwright_msgs::srv::{JoinCommand, JoinCommandRequest, JoinCommandResponse};
use camwright_ros::liveness;
use camwright_ros::{Authority, Client, Guid, Node, Qos, RosError, Subscription, TimerHandle};
use camwright_threads::silence::{HEARTBEAT, LOOK, Silence};
use std::any::Any;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};

/// Reports that wait for an answer.
const MAX_OPEN_REPORTS: usize = 8;

/// The lease as a member knows it.
#[derive(Debug)]
struct LeaseView {
    /// The machine whose word counts.
    machine: Option<(Participant, Silence)>,
    holder: CommandHolder,
}

/// Called with the participant of a machine that counts from now on.
type MachineHook = Box<dyn Fn(Participant) + Send>;

/// Called with a service and the reason for which a request to it was refused.
type RefusalHook = Box<dyn Fn(&str, &str) + Send + Sync>;

/// Decides for interpolator or planner.
pub struct Grant {
    own: Participant,
    view: Mutex<LeaseView>,
    hooks: Mutex<Vec<MachineHook>>,
    refusal_hook: OnceLock<RefusalHook>,
    refused: AtomicU32,
    has_joined: AtomicBool,
}

impl std::fmt::Debug for Grant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Grant").field("view", &self.view).finish_non_exhaustive()
    }
}

impl Grant {
    /// Lets the machine's lease decide on the node's requests, from now on.
    pub fn new(node: &Node) -> Result<Arc<Self>, RosError> {
        let view = LeaseView { machine: None, holder: CommandHolder::default() };
        let own = participant_of(node.participant_guid()?);
        let grant = Arc::new(Self {
            own,
            view: Mutex::new(view),
            hooks: Mutex::default(),
            refusal_hook: OnceLock::new(),
            refused: AtomicU32::new(0),
            has_joined: AtomicBool::new(false),
        });
        node.set_authority(Arc::<Self>::clone(&grant));
        Ok(grant)
    }

    /// Returns why the machine would refuse the node's setpoints and commands.
    pub fn obstacle(&self) -> Option<String> {
        let has_joined = self.has_joined.load(Ordering::Relaxed);
        (!has_joined)
            .then(|| "the machine has not accepted this node's role yet; ask again in a few seconds".to_owned())
    }

    /// Returns true where a message of a topic is taken; a refusal is logged once for each sender.
    pub fn accepts(&self, topic: &str, writer: &Guid, node: &Node) -> bool {
        let Some(reason) = self.refusal_of(writer) else { return true };
        let who = node.who(writer);
        node.warn_once(&format!("{topic} of {who} refused"), &format!("{topic} of {who} refused: {reason}"));
        false
    }

    /// Returns why a message of a writer is refused, and counts it; none where it may be executed.
    fn refusal_of(&self, writer: &Guid) -> Option<String> {
        let by = participant_of(*writer);
        let view = lock(&self.view);
        let CommandHolder { holder, participant, shared, interpolator, planner, .. } = &view.holder;
        let commands = !holder.is_empty() && (*shared || *participant == by);
        if by == self.own || commands || [interpolator, planner].contains(&&by) {
            return None;
        }
        self.refused.fetch_add(1, Ordering::Relaxed);
        Some(held_text(holder, None))
    }

    /// Takes the machine's word.
    fn update_holder(&self, message: CommandHolder, writer: &Guid) {
        if self.is_machine(participant_of(*writer)) {
            lock(&self.view).holder = message;
        }
    }

    /// Calls `hook` whenever another machine counts.
    pub(super) fn on_machine(&self, hook: impl Fn(Participant) + Send + 'static) {
        lock(&self.hooks).push(Box::new(hook));
    }

    /// Calls `hook` for every refused request. The first hook stays.
    pub fn on_refusal(&self, hook: impl Fn(&str, &str) + Send + Sync + 'static) {
        let _the_first_stays = self.refusal_hook.set(Box::new(hook));
    }

    /// Returns whether a participant is the current machine.
    pub(super) fn is_machine(&self, participant: Participant) -> bool {
        lock(&self.view).machine.as_ref().is_some_and(|(machine, _)| *machine == participant)
    }

    /// Returns whether a machine has answered.
    pub(super) fn has_machine(&self) -> bool {
        lock(&self.view).machine.is_some()
    }

    fn generation(&self) -> u64 {
        lock(&self.view).holder.number
    }

    /// Takes the answer to a report. The first machine counts until it is silent or has left.
    fn answered(&self, answer: &JoinCommandResponse, node: &Node, limit: Duration) -> Result<(), String> {
        let mut view = lock(&self.view);
        match &mut view.machine {
            Some((machine, silence)) if *machine == answer.machine => silence.reset(),
            Some((machine, silence)) if !silence.is_lost() && node.knows_participant(machine) => {
                return Err(format!(
                    "{} also offers machine/join_command; end one of the two",
                    node.who(&answer.machine)
                ));
            }
            _ => {
                view.machine = Some((answer.machine, Silence::new(limit)));
                view.holder = CommandHolder::default();
                drop(view);
                lock(&self.hooks).iter().for_each(|hook| hook(answer.machine));
            }
        }
        if answer.success { Ok(()) } else { Err(answer.message.clone()) }
    }

    fn poll_silence(&self) {
        if let Some((_, silence)) = &mut lock(&self.view).machine {
            silence.poll();
        }
    }
}

impl Authority for Grant {
    fn refusal(&self, service: &str, request: &dyn Any, sender: &Guid) -> Option<String> {
        if rules::is_open(service, request) {
            return None;
        }
        let reason = self.refusal_of(sender)?;
        if let Some(hook) = self.refusal_hook.get() {
            hook(service, &reason);
        }
        Some(reason)
    }
}

/// Keeps a member in its role.
#[derive(Debug)]
pub struct Membership {
    _holder: Subscription,
    _reports: TimerHandle,
}

/// Reports the role of a node to the machine; `busy` says whether work is under way.
pub fn join(
    node: &Node,
    grant: &Arc<Grant>,
    role: Role,
    busy: impl Fn() -> bool + Send + 'static,
) -> Result<Membership, RosError> {
    let client = node.client("machine/join_command")?;
    let reporter = Arc::new(Mutex::new(Reporter {
        grant: Arc::clone(grant),
        node: node.clone(),
        limit: liveness::limit(node),
        client,
        role,
        busy: Box::new(busy),
        sent: None,
        open: VecDeque::new(),
    }));
    let (into, news) = (Arc::clone(grant), Arc::clone(&reporter));
    let holder =
        node.subscribe::<CommandHolder>("machine/command_holder", &Qos::latched(1), move |message, info| {
            into.update_holder(message, &info.writer);
            lock(&news).report();
        })?;
    let reports = node.timer(LOOK, move || {
        let mut reporter = lock(&reporter);
        reporter.grant.poll_silence();
        reporter.report();
    });
    Ok(Membership { _holder: holder, _reports: reports })
}

struct Reporter {
    grant: Arc<Grant>,
    node: Node,
    limit: Duration,
    client: Client<JoinCommand>,
    role: Role,
    busy: Box<dyn Fn() -> bool + Send>,
    /// Last report: number of the state, work under way, time.
    sent: Option<(u64, bool, Instant)>,
    open: VecDeque<i64>,
}

impl Reporter {
    /// Reports news at once, and else as a heartbeat.
    fn report(&mut self) {
        let (known, busy) = (self.grant.generation(), (self.busy)());
        let is_old = |(old_known, old_busy, at): (u64, bool, Instant)| {
            (old_known, old_busy) != (known, busy) || at.elapsed() >= HEARTBEAT
        };
        if !self.sent.is_none_or(is_old) || !self.client.is_ready() {
            return;
        }
        self.sent = Some((known, busy, Instant::now()));
        let refused = self.grant.refused.swap(0, Ordering::Relaxed);
        let request = JoinCommandRequest { role: self.role.name().to_owned(), known, busy, refused };
        let (grant, node, limit) = (Arc::clone(&self.grant), self.node.clone(), self.limit);
        let answer = move |answer: JoinCommandResponse| {
            let outcome = grant.answered(&answer, &node, limit);
            grant.has_joined.store(outcome.is_ok(), Ordering::Relaxed);
            if let Err(reason) = outcome {
                node.warn_once(
                    "the role in the cell is refused",
                    &format!("the role in the cell is refused: {reason}"),
                );
            }
        };
        match self.client.call_with(&request, answer) {
            Ok(number) => self.open.push_back(number),
            Err(error) => self.node.logger().debug(&error.to_string()),
        }
        if self.open.len() > MAX_OPEN_REPORTS {
            self.open.pop_front().into_iter().for_each(|number| self.client.forget(number));
        }
    }
}
