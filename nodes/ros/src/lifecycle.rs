// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Managed nodes: the life cycle of `lifecycle_msgs`, with its five services and its topic.
//!
//! Transitions run on a thread of their own, one after the other, so that a callback may wait for peers or files while the executor
//! goes on delivering messages.

use std::{
    fmt,
    sync::{
        Arc, Condvar, Mutex, PoisonError,
        mpsc::{self, Sender},
    },
    thread::ThreadId,
    time::{Duration, Instant},
};

use camwright_msgs::lifecycle_msgs::{
    msg::{State as StateMsg, Transition as TransitionMsg, TransitionDescription, TransitionEvent},
    srv::{
        ChangeState, ChangeStateResponse, GetAvailableStates, GetAvailableStatesResponse, GetAvailableTransitions,
        GetAvailableTransitionsResponse, GetState, GetStateResponse,
    },
};

use super::{
    error::RosError,
    logging::Logger,
    node::{Node, WeakNode, private},
    qos::Qos,
    services::ServiceHandle,
    topics::Publisher,
};

/// States of a managed node, with their numbers in `lifecycle_msgs/msg/State`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum LifecycleState {
    Unconfigured = 1,
    /// Set up, not working.
    Inactive = 2,
    Active = 3,
    Finalized = 4,
    Configuring = 10,
    CleaningUp = 11,
    ShuttingDown = 12,
    Activating = 13,
    Deactivating = 14,
    /// Dealing with an error.
    ErrorProcessing = 15,
}

use LifecycleState as S;

impl LifecycleState {
    const ALL: [LifecycleState; 10] = [
        S::Unconfigured,
        S::Inactive,
        S::Active,
        S::Finalized,
        S::Configuring,
        S::CleaningUp,
        S::ShuttingDown,
        S::Activating,
        S::Deactivating,
        S::ErrorProcessing,
    ];

    /// Label as `ros2 lifecycle` prints it.
    pub fn label(self) -> &'static str {
        match self {
            S::Unconfigured => "unconfigured",
            S::Inactive => "inactive",
            S::Active => "active",
            S::Finalized => "finalized",
            S::Configuring => "configuring",
            S::CleaningUp => "cleaningup",
            S::ShuttingDown => "shuttingdown",
            S::Activating => "activating",
            S::Deactivating => "deactivating",
            S::ErrorProcessing => "errorprocessing",
        }
    }

    fn to_msg(self) -> StateMsg {
        StateMsg { id: self as u8, label: self.label().to_string() }
    }
}

/// Transitions that may be asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transition {
    Configure,
    Activate,
    Deactivate,
    Cleanup,
    /// Any of the three to finalized.
    Shutdown,
}

/// One edge of the state machine (`rcl_lifecycle`'s default machine).
struct TransitionEdge {
    id: u8,
    label: &'static str,
    from: LifecycleState,
    to: LifecycleState,
}

const fn edge(id: u8, label: &'static str, from: LifecycleState, to: LifecycleState) -> TransitionEdge {
    TransitionEdge { id, label, from, to }
}

const SUCCESS: &str = "transition_success";
const FAILURE: &str = "transition_failure";
const ERROR: &str = "transition_error";

/// Number of the error that leads out of a state in which the node works: `rcl_lifecycle` has none from the state itself.
const DEACTIVATE_ERROR: u8 = 42;

const EDGES: [TransitionEdge; 25] = [
    edge(1, "configure", S::Unconfigured, S::Configuring),
    edge(10, SUCCESS, S::Configuring, S::Inactive),
    edge(11, FAILURE, S::Configuring, S::Unconfigured),
    edge(12, ERROR, S::Configuring, S::ErrorProcessing),
    edge(2, "cleanup", S::Inactive, S::CleaningUp),
    edge(20, SUCCESS, S::CleaningUp, S::Unconfigured),
    edge(21, FAILURE, S::CleaningUp, S::Inactive),
    edge(22, ERROR, S::CleaningUp, S::ErrorProcessing),
    edge(3, "activate", S::Inactive, S::Activating),
    edge(30, SUCCESS, S::Activating, S::Active),
    edge(31, FAILURE, S::Activating, S::Inactive),
    edge(32, ERROR, S::Activating, S::ErrorProcessing),
    edge(4, "deactivate", S::Active, S::Deactivating),
    edge(40, SUCCESS, S::Deactivating, S::Inactive),
    edge(41, FAILURE, S::Deactivating, S::Active),
    edge(42, ERROR, S::Deactivating, S::ErrorProcessing),
    edge(5, "shutdown", S::Unconfigured, S::ShuttingDown),
    edge(6, "shutdown", S::Inactive, S::ShuttingDown),
    edge(7, "shutdown", S::Active, S::ShuttingDown),
    edge(50, SUCCESS, S::ShuttingDown, S::Finalized),
    edge(51, FAILURE, S::ShuttingDown, S::Finalized),
    edge(52, ERROR, S::ShuttingDown, S::ErrorProcessing),
    edge(60, SUCCESS, S::ErrorProcessing, S::Unconfigured),
    edge(61, FAILURE, S::ErrorProcessing, S::Finalized),
    edge(62, ERROR, S::ErrorProcessing, S::Finalized),
];

impl TransitionEdge {
    /// Returns true for a transition that clients may request.
    fn is_public(&self) -> bool {
        self.id < 10
    }

    fn transition(&self) -> Option<Transition> {
        match self.id {
            1 => Some(Transition::Configure),
            2 => Some(Transition::Cleanup),
            3 => Some(Transition::Activate),
            4 => Some(Transition::Deactivate),
            5..=7 => Some(Transition::Shutdown),
            _ => None,
        }
    }

    fn to_msg(&self) -> TransitionMsg {
        TransitionMsg { id: self.id, label: self.label.to_string() }
    }

    fn describe(&self) -> TransitionDescription {
        TransitionDescription {
            transition: self.to_msg(),
            start_state: self.from.to_msg(),
            goal_state: self.to.to_msg(),
        }
    }
}

/// The public edge a request means: by its label if it has one, else by its number.
fn asked_for(request: &TransitionMsg, state: LifecycleState) -> Option<&'static TransitionEdge> {
    EDGES.iter().filter(|edge| edge.from == state && edge.is_public()).find(|edge| {
        if request.label.is_empty() {
            edge.id == request.id
        } else {
            // "unconfigured_shutdown" and the like are the names of the constants.
            edge.label == request.label || request.label == format!("{}_{}", edge.from.label(), edge.label)
        }
    })
}

/// Transitions of a managed node. Calls run on the thread of the life cycle. `Err` leaves the node in its state, with that reason in
/// the log.
pub trait LifecycleCallbacks: Send + 'static {
    /// Sets up parameters, files and topics.
    ///
    /// # Errors
    /// The transition fails, with the reason.
    fn configure(&mut self) -> Result<(), String> {
        Ok(())
    }

    /// Starts the work.
    ///
    /// # Errors
    /// The transition fails, with the reason.
    fn activate(&mut self) -> Result<(), String> {
        Ok(())
    }

    /// Stops the work; moving axes come to rest.
    ///
    /// # Errors
    /// The transition fails, with the reason.
    fn deactivate(&mut self) -> Result<(), String> {
        Ok(())
    }

    /// Undoes `configure`.
    ///
    /// # Errors
    /// The transition fails, with the reason.
    fn cleanup(&mut self) -> Result<(), String> {
        Ok(())
    }

    /// Ends from any state; the node is finalized even after an error.
    ///
    /// # Errors
    /// The reason why the end is incomplete.
    fn shutdown(&mut self) -> Result<(), String> {
        Ok(())
    }
}

struct TransitionRequest {
    edge: &'static TransitionEdge,
    done: Box<dyn FnOnce(Result<(), String>) + Send>,
}

struct LifecycleCore {
    state: Mutex<LifecycleState>,
    changed: Condvar,
    requests: Mutex<Option<Sender<TransitionRequest>>>,
    thread: Mutex<Option<ThreadId>>,
    events: Publisher<TransitionEvent>,
    node: WeakNode,
    logger: Logger,
}

impl LifecycleCore {
    fn state(&self) -> LifecycleState {
        *self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn follow(&self, edge: &TransitionEdge) {
        *self.state.lock().unwrap_or_else(PoisonError::into_inner) = edge.to;
        self.changed.notify_all();
        let now_ns = self.node.upgrade().map_or(0, |node| node.now_ns());
        let event = TransitionEvent {
            timestamp: u64::try_from(now_ns).unwrap_or(0),
            transition: edge.to_msg(),
            start_state: edge.from.to_msg(),
            goal_state: edge.to.to_msg(),
        };
        if let Err(error) = self.events.publish(&event) {
            self.logger.warn(&error.to_string());
        }
    }

    /// Runs one transition on the thread of the life cycle.
    fn run(&self, edge: &TransitionEdge, callbacks: &mut dyn LifecycleCallbacks) -> Result<(), String> {
        if self.state() != edge.from {
            return Err(format!("cannot {} a node that is {}", edge.label, self.state().label()));
        }
        self.follow(edge);
        let outcome = match edge.transition() {
            Some(Transition::Configure) => callbacks.configure(),
            Some(Transition::Activate) => callbacks.activate(),
            Some(Transition::Deactivate) => callbacks.deactivate(),
            Some(Transition::Cleanup) => callbacks.cleanup(),
            Some(Transition::Shutdown) => callbacks.shutdown(),
            None => Ok(()),
        };
        let label = if outcome.is_ok() { SUCCESS } else { FAILURE };
        if self.state() != edge.to {
            return Err("a thread of the node died meanwhile".into());
        }
        if let Some(end) = EDGES.iter().find(|end| end.from == edge.to && end.label == label) {
            self.follow(end);
        }
        if let Err(reason) = &outcome {
            self.logger.error(&format!("cannot {}: {reason}", edge.label));
        }
        outcome
    }

    /// A thread of the node died: nothing leads out of this state but the end of the process.
    fn fail(&self) {
        let from = self.state();
        let id =
            EDGES.iter().find(|edge| edge.from == from && edge.label == ERROR).map_or(DEACTIVATE_ERROR, |edge| edge.id);
        self.follow(&edge(id, ERROR, from, S::ErrorProcessing));
    }

    fn ask(&self, edge: &'static TransitionEdge, done: impl FnOnce(Result<(), String>) + Send + 'static) {
        let requests = self.requests.lock().unwrap_or_else(PoisonError::into_inner);
        let request = TransitionRequest { edge, done: Box::new(done) };
        match requests.as_ref().map(|requests| requests.send(request)) {
            Some(Ok(())) => {}
            Some(Err(mpsc::SendError(request))) => (request.done)(Err("the node is leaving".into())),
            // The last handle has gone; a waiting caller learns it from the dropped answer.
            None => {}
        }
    }
}

struct Owner {
    core: Arc<LifecycleCore>,
    _services: Vec<ServiceHandle>,
}

impl Drop for Owner {
    fn drop(&mut self) {
        // Ends the thread, which owns the callbacks.
        self.core.requests.lock().unwrap_or_else(PoisonError::into_inner).take();
    }
}

/// A node's life cycle. Clones are the same; it ends with the last of them.
#[derive(Clone)]
#[must_use = "dropping it ends the life cycle"]
pub struct Lifecycle {
    owner: Arc<Owner>,
}

impl fmt::Debug for Lifecycle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Lifecycle").field("state", &self.state()).finish()
    }
}

impl Lifecycle {
    /// State of the node.
    pub fn state(&self) -> LifecycleState {
        self.owner.core.state()
    }

    /// Returns true in the state active.
    pub fn is_active(&self) -> bool {
        self.state() == LifecycleState::Active
    }

    /// Waits until the node is in a state; `false` after the timeout.
    pub fn wait_for(&self, state: LifecycleState, timeout: Duration) -> bool {
        let deadline = Instant::now() + timeout;
        let mut now = self.owner.core.state.lock().unwrap_or_else(PoisonError::into_inner);
        while *now != state {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            now = self.owner.core.changed.wait_timeout(now, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        true
    }

    /// Makes a transition and waits for its end.
    ///
    /// # Errors
    /// The state does not allow it, the callback refuses, or the caller is a callback of the life cycle or of the executor.
    pub fn trigger(&self, transition: Transition) -> Result<(), RosError> {
        let core = &self.owner.core;
        let what = || format!("transition {transition:?}");
        let own = *core.thread.lock().unwrap_or_else(PoisonError::into_inner) == Some(std::thread::current().id());
        if own || core.node.upgrade().is_some_and(|node| node.on_executor_thread()) {
            return Err(RosError::WouldDeadlock { what: what() });
        }
        let (sender, receiver) = mpsc::sync_channel(1);
        self.trigger_with(transition, move |outcome| {
            let _ = sender.send(outcome);
        });
        match receiver.recv() {
            Ok(Ok(())) => Ok(()),
            Ok(Err(reason)) => Err(RosError::Refused { what: what(), reason }),
            Err(_) => Err(RosError::Refused { what: what(), reason: "the node is leaving".into() }),
        }
    }

    /// Makes a transition; `done` is called on the thread of the life cycle (at once if the state does not allow it).
    pub fn trigger_with(&self, transition: Transition, done: impl FnOnce(Result<(), String>) + Send + 'static) {
        let state = self.state();
        match EDGES.iter().find(|edge| edge.from == state && edge.transition() == Some(transition)) {
            Some(edge) => self.owner.core.ask(edge, done),
            None => done(Err(format!("a node that is {} has no such transition", state.label()))),
        }
    }
}

impl Node {
    /// Makes this a managed node, unconfigured at first.
    ///
    /// # Errors
    /// The node is shut down, or the operating system refuses a thread.
    pub fn lifecycle(&self, mut callbacks: impl LifecycleCallbacks) -> Result<Lifecycle, RosError> {
        let (sender, requests) = mpsc::channel::<TransitionRequest>();
        let core = Arc::new(LifecycleCore {
            state: Mutex::new(LifecycleState::Unconfigured),
            changed: Condvar::new(),
            requests: Mutex::new(Some(sender)),
            thread: Mutex::new(None),
            events: self.publisher(&private("transition_event"), &Qos::default_topic())?,
            node: self.downgrade(),
            logger: self.logger().clone(),
        });
        let services = offer(self, &core)?;
        let running = Arc::clone(&core);
        let failing = Arc::downgrade(&core);
        self.supervisor().on_fault(move |_| {
            if let Some(core) = failing.upgrade() {
                core.fail();
            }
        });
        let thread = self
            .supervisor()
            .spawn(&format!("lifecycle {}", self.name()), move || {
                let _current = running.logger.enter();
                for TransitionRequest { edge, done } in requests {
                    done(running.run(edge, &mut callbacks));
                }
            })
            .map_err(|source| RosError::Io { what: "thread of the life cycle".into(), source })?;
        *core.thread.lock().unwrap_or_else(PoisonError::into_inner) = Some(thread.thread().id());
        Ok(Lifecycle { owner: Arc::new(Owner { core, _services: services }) })
    }
}

fn offer(node: &Node, core: &Arc<LifecycleCore>) -> Result<Vec<ServiceHandle>, RosError> {
    let shared = || Arc::clone(core);
    let changing = shared();
    let change_state = node.service_deferred::<ChangeState>(&private("change_state"), move |request, responder| {
        let Some(edge) = asked_for(&request.transition, changing.state()) else {
            let asked = if request.transition.label.is_empty() {
                request.transition.id.to_string()
            } else {
                request.transition.label
            };
            changing.logger.warn(&format!("a node that is {} has no transition {asked}", changing.state().label()));
            responder.send(&ChangeStateResponse { success: false });
            return;
        };
        changing.ask(edge, move |outcome| responder.send(&ChangeStateResponse { success: outcome.is_ok() }));
    })?;
    let reading = shared();
    let get_state = node.service::<GetState>(&private("get_state"), move |_| GetStateResponse {
        current_state: reading.state().to_msg(),
    })?;
    let states = node.service::<GetAvailableStates>(&private("get_available_states"), |_| {
        let unknown = StateMsg { id: 0, label: "unknown".into() };
        let available_states =
            std::iter::once(unknown).chain(LifecycleState::ALL.into_iter().map(LifecycleState::to_msg)).collect();
        GetAvailableStatesResponse { available_states }
    })?;
    let reading = shared();
    let name = private("get_available_transitions");
    let transitions = node.service::<GetAvailableTransitions>(&name, move |_| {
        let state = reading.state();
        let available_transitions =
            EDGES.iter().filter(|edge| edge.from == state).map(TransitionEdge::describe).collect();
        GetAvailableTransitionsResponse { available_transitions }
    })?;
    let graph = node.service::<GetAvailableTransitions>(&private("get_transition_graph"), |_| {
        GetAvailableTransitionsResponse { available_transitions: EDGES.iter().map(TransitionEdge::describe).collect() }
    })?;
    Ok(vec![change_state, get_state, states, transitions, graph])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(id: u8, label: &str) -> TransitionMsg {
        TransitionMsg { id, label: label.into() }
    }

    #[test]
    fn a_request_is_read_by_label_first_and_by_number_else() {
        let found = |id, label, state| asked_for(&request(id, label), state).map(|edge| edge.id);
        assert_eq!(found(0, "configure", S::Unconfigured), Some(1));
        assert_eq!(found(1, "", S::Unconfigured), Some(1));
        assert_eq!(found(99, "shutdown", S::Inactive), Some(6));
        assert_eq!(found(0, "active_shutdown", S::Active), Some(7));
        assert_eq!(found(7, "", S::Active), Some(7));
        assert_eq!(found(5, "", S::Active), None, "the number of another state's shutdown");
        assert_eq!(found(3, "", S::Unconfigured), None);
        assert_eq!(found(10, "", S::Configuring), None, "not for outsiders");
        assert_eq!(found(1, "no such label", S::Unconfigured), None);
    }

    #[test]
    fn every_way_in_has_a_way_out() {
        for edge in EDGES.iter().filter(|edge| edge.is_public()) {
            for label in [SUCCESS, FAILURE, ERROR] {
                assert_eq!(EDGES.iter().filter(|end| end.from == edge.to && end.label == label).count(), 1);
            }
        }
    }
}
