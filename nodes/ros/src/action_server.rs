// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Action servers: any number of goals at once, with a table of their states.
//!
//! The crate's own server loses cancel requests and results as soon as two goals run, publishes the end of a goal only when a client
//! asks for its result, and keeps no results. This one has one table behind one lock; requests are handled on the executor thread,
//! goals are worked on wherever their handles go.

use std::{
    fmt,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, AtomicI8},
    },
    time::Duration,
};

use camwright_msgs::{
    Action, Service,
    action_msgs::{
        msg::GoalInfo,
        srv::{CancelGoal, CancelGoalRequest, CancelGoalResponse},
    },
    builtin_interfaces::msg::Time,
};

use super::action::{ActionNames, GoalId, GoalStatus};
use super::clock::from_time;
use super::error::RosError;
use super::executor::TimerHandle;
use super::goal_handle::GoalHandle;
use super::goal_table::{GoalEntry, GoalTableCore, is_cancelable};
use super::introspection::CallGroup;
use super::node::Node;
use super::qos::Qos;
use super::services::{Responder, ServiceHandle};
use camwright_threads::drops::DropCounter;

/// Decision on a request for a goal.
#[derive(Debug)]
pub enum GoalDecision {
    /// Accepts the goal at once.
    Accept,
    /// Rejects the goal. The reason goes to the log, since the protocol has no field for it.
    Reject(String),
    /// Defers the decision: see [`GoalDecision::later`].
    Later(DeferredDecision),
}

impl GoalDecision {
    /// Creates a deferred decision, for one that takes longer than a callback may.
    ///
    /// Return the decision to the server, and decide with the [`GoalDecider`].
    pub fn later() -> (GoalDecider, GoalDecision) {
        let decision: Arc<Mutex<PendingDecision>> = Arc::default();
        (GoalDecider(Arc::clone(&decision)), GoalDecision::Later(DeferredDecision(decision)))
    }
}

type GoalVerdict = Result<(), String>;

/// A verdict and its continuation, whichever comes first.
#[derive(Default)]
struct PendingDecision {
    verdict: Option<GoalVerdict>,
    then: Option<Box<dyn FnOnce(GoalVerdict) + Send>>,
}

/// Deferred decision.
pub struct DeferredDecision(Arc<Mutex<PendingDecision>>);

impl fmt::Debug for DeferredDecision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DeferredDecision").finish_non_exhaustive()
    }
}

impl DeferredDecision {
    fn then(self, then: impl FnOnce(GoalVerdict) + Send + 'static) {
        let mut undecided = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match undecided.verdict.take() {
            Some(verdict) => {
                drop(undecided);
                then(verdict);
            }
            None => undecided.then = Some(Box::new(then)),
        }
    }
}

/// The right to decide on one goal, once, from any thread. If it is dropped, the goal is rejected.
#[must_use = "dropping it rejects the goal"]
pub struct GoalDecider(Arc<Mutex<PendingDecision>>);

impl fmt::Debug for GoalDecider {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("GoalDecider").finish_non_exhaustive()
    }
}

impl GoalDecider {
    /// Accepts the goal: [`ActionHandler::accepted`] is called on the executor thread.
    pub fn accept(self) {
        self.decide(Ok(()));
    }

    /// Rejects the goal; the reason goes to the log.
    pub fn reject(self, reason: &str) {
        self.decide(Err(reason.to_string()));
    }

    fn decide(&self, verdict: GoalVerdict) {
        let mut undecided = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match undecided.then.take() {
            Some(then) => {
                drop(undecided);
                then(verdict);
            }
            // The first verdict stands: a drop after it changes nothing.
            None if undecided.verdict.is_none() => undecided.verdict = Some(verdict),
            None => {}
        }
    }
}

impl Drop for GoalDecider {
    fn drop(&mut self) {
        self.decide(Err("no decision was made".into()));
    }
}

/// Decisions of an action server. All calls run on the executor thread and must not block.
///
/// A closure that receives the handle of every goal is a handler too: it accepts every goal and every request to cancel.
pub trait ActionHandler<A: Action>: Send + 'static {
    /// Decides on a request for a goal. Default: accepts.
    fn goal(&mut self, _id: GoalId, _goal: &A::Goal) -> GoalDecision {
        GoalDecision::Accept
    }

    /// Receives an accepted goal, which is executing from now on. Pass the handle to the code that works on it.
    fn accepted(&mut self, goal: GoalHandle<A>);

    /// Decides on a request to cancel a goal. Default: accepts.
    ///
    /// After `true`, the handle of the goal is [`GoalHandle::is_canceling`]. The code that works on the goal ends it with
    /// [`GoalHandle::canceled`], or with another outcome that came first.
    fn cancel(&mut self, _id: GoalId) -> bool {
        true
    }
}

impl<A: Action, F: FnMut(GoalHandle<A>) + Send + 'static> ActionHandler<A> for F {
    fn accepted(&mut self, goal: GoalHandle<A>) {
        self(goal);
    }
}

impl<A: Action> GoalTableCore<A> {
    /// Handles a request for a goal.
    fn send_goal<H: ActionHandler<A>>(
        self: &Arc<Self>,
        handler: &Arc<Mutex<H>>,
        request: <A::SendGoal as Service>::Request,
        responder: Responder<A::SendGoal>,
    ) {
        let (uuid, goal) = A::split_send_goal_request(request);
        let id = GoalId::from_msg(&uuid);
        let decision = if self.goals().contains_key(&id) {
            GoalDecision::Reject("its id is in use".into())
        } else {
            handler.lock().unwrap_or_else(PoisonError::into_inner).goal(id, &goal)
        };
        match decision {
            GoalDecision::Accept => self.decided(handler, id, goal, responder, Ok(())),
            GoalDecision::Reject(reason) => self.decided(handler, id, goal, responder, Err(reason)),
            GoalDecision::Later(decision) => {
                let (core, handler) = (Arc::clone(self), Arc::clone(handler));
                decision.then(move |verdict| {
                    // On the executor thread in every case, as handlers expect.
                    if let Some(node) = core.node.upgrade() {
                        node.post(move || core.decided(&handler, id, goal, responder, verdict));
                    }
                });
            }
        }
    }

    /// Answers a request for a goal and, if it is accepted, starts the work.
    fn decided<H: ActionHandler<A>>(
        self: &Arc<Self>,
        handler: &Mutex<H>,
        id: GoalId,
        goal: A::Goal,
        responder: Responder<A::SendGoal>,
        verdict: GoalVerdict,
    ) {
        let stamp = self.now();
        let verdict = verdict.and_then(|()| match self.make_room(id) {
            None => Ok(()),
            Some(reason) => Err(reason),
        });
        if let Err(reason) = verdict {
            self.warn_of_rejection(id, &reason);
            responder.send(&A::send_goal_response(false, stamp));
            return;
        }
        let status = Arc::new(AtomicI8::new(GoalStatus::Accepted as i8));
        let client = self.node.upgrade().map(|node| node.who(&responder.client())).unwrap_or_default();
        let handle = GoalHandle::new(self, id, goal, client, Arc::clone(&status));
        {
            let mut goals = self.goals();
            let entry = GoalEntry { stamp: stamp.clone(), status, result: None, waiting: Vec::new(), ended: None };
            goals.insert(id, entry);
            responder.send(&A::send_goal_response(true, stamp));
            self.publish_status(&goals);
            self.set(&goals, id, GoalStatus::Executing);
        }
        handler.lock().unwrap_or_else(PoisonError::into_inner).accepted(handle);
    }

    fn warn_of_rejection(&self, id: GoalId, reason: &str) {
        let Some(node) = self.node.upgrade() else { return };
        node.load().goals_rejected.add_one();
        let kind = format!("goals of {} rejected: {reason}", self.name);
        node.warn_once(&kind, &format!("goal {id} of {} rejected: {reason}", self.name));
    }

    /// Handles a request to cancel, by the rules of `action_msgs/srv/CancelGoal`.
    fn cancel_goal<H: ActionHandler<A>>(&self, handler: &Mutex<H>, request: &CancelGoalRequest) -> CancelGoalResponse {
        let wanted = GoalId::from_msg(&request.goal_info.goal_id);
        let until_ns = from_time(&request.goal_info.stamp);
        let refuse = |return_code| CancelGoalResponse { return_code, goals_canceling: Vec::new() };
        let candidates: Vec<(GoalId, Time)> = {
            let goals = self.goals();
            let one = wanted != GoalId::default();
            if one && until_ns == 0 {
                match goals.get(&wanted) {
                    None => return refuse(CancelGoalResponse::ERROR_UNKNOWN_GOAL_ID),
                    Some(entry) if !is_cancelable(entry.status()) => {
                        return refuse(CancelGoalResponse::ERROR_GOAL_TERMINATED);
                    }
                    Some(_) => {}
                }
            }
            goals
                .iter()
                .filter(|(id, entry)| {
                    let by_time = if until_ns == 0 { !one } else { from_time(&entry.stamp) <= until_ns };
                    is_cancelable(entry.status()) && ((one && **id == wanted) || by_time)
                })
                .map(|(id, entry)| (*id, entry.stamp.clone()))
                .collect()
        };
        let asked = !candidates.is_empty();
        let mut goals_canceling = Vec::new();
        for (id, stamp) in candidates {
            if !handler.lock().unwrap_or_else(PoisonError::into_inner).cancel(id) {
                continue;
            }
            let goals = self.goals();
            // It may have ended while the handler was asked.
            if goals.get(&id).is_some_and(|entry| is_cancelable(entry.status())) {
                self.set(&goals, id, GoalStatus::Canceling);
            }
            goals_canceling.push(GoalInfo { goal_id: id.to_msg(), stamp });
        }
        let rejected = asked && goals_canceling.is_empty();
        let return_code = if rejected { CancelGoalResponse::ERROR_REJECTED } else { CancelGoalResponse::ERROR_NONE };
        CancelGoalResponse { return_code, goals_canceling }
    }
}

/// An action that is offered; dropping it withdraws it.
#[must_use = "dropping it withdraws the action"]
pub struct ActionServer<A: Action> {
    core: Arc<GoalTableCore<A>>,
    _services: [ServiceHandle; 3],
    _expiry: TimerHandle,
}

impl<A: Action> fmt::Debug for ActionServer<A> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ActionServer").field("action", &self.core.name).finish_non_exhaustive()
    }
}

impl<A: Action> ActionServer<A> {
    /// Resolved name of the action.
    pub fn action(&self) -> &str {
        &self.core.name
    }

    /// Goals that have not ended.
    pub fn active_goals(&self) -> Vec<GoalId> {
        self.core.goals().iter().filter(|(_, entry)| !entry.status().is_terminal()).map(|(id, _)| *id).collect()
    }
}

impl Node {
    /// Offers an action.
    ///
    /// # Errors
    /// The name breaks the rules, or the node is shut down.
    pub fn action_server<A: Action>(
        &self,
        name: &str,
        handler: impl ActionHandler<A>,
    ) -> Result<ActionServer<A>, RosError> {
        self.action_server_with_trailing_zeros(name, 0, handler)
    }

    /// Offers an action whose feedback ends with zero octets: clients with a later definition of the action read its additional fields
    /// as zero, others ignore the octets.
    ///
    /// # Errors
    /// See [`Node::action_server`].
    pub fn action_server_with_trailing_zeros<A: Action>(
        &self,
        name: &str,
        octets: usize,
        handler: impl ActionHandler<A>,
    ) -> Result<ActionServer<A>, RosError> {
        let names = ActionNames::resolve(self, name)?;
        let feedback = self.telemetry(&names.feedback, &Qos::default_topic(), &DropCounter::default())?;
        let feedback = feedback.with_trailing_zeros(octets);
        let status = self.publisher(&names.status, &Qos::action_status())?;
        let core = Arc::new_cyclic(|this| GoalTableCore::<A> {
            name: names.action,
            goals: Mutex::default(),
            feedback,
            status,
            logger: self.logger().clone(),
            node: self.downgrade(),
            this: this.clone(),
            is_status_due: AtomicBool::new(false),
        });
        let handler = Arc::new(Mutex::new(handler));
        let (accepting, accepting_handler) = (Arc::clone(&core), Arc::clone(&handler));
        let send_goal = self.service_deferred_with::<A::SendGoal>(
            &names.send_goal,
            &Qos::services(),
            CallGroup::ActionServers,
            move |request, responder| accepting.send_goal(&accepting_handler, request, responder),
        )?;
        let canceling = Arc::clone(&core);
        let cancel_goal = self.service_with::<CancelGoal>(
            &names.cancel_goal,
            &Qos::services(),
            CallGroup::ActionServers,
            move |request| canceling.cancel_goal(&handler, &request),
        )?;
        let answering = Arc::clone(&core);
        let get_result = self.service_deferred_with::<A::GetResult>(
            &names.get_result,
            &Qos::services(),
            CallGroup::ActionServers,
            move |request, responder| answering.get_result(request, responder),
        )?;
        let expiring = Arc::downgrade(&core);
        let expiry = self.timer(Duration::from_secs(1), move || {
            if let Some(core) = expiring.upgrade() {
                core.expire();
            }
        });
        // The latched topic says from the beginning that there are no goals.
        core.publish_status(&core.goals());
        Ok(ActionServer { core, _services: [send_goal, cancel_goal, get_result], _expiry: expiry })
    }
}
