// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Action clients: several goals at once, blocking from other threads or with callbacks from the executor's.

use std::{
    collections::BTreeMap,
    fmt,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use camwright_msgs::{
    Action,
    action_msgs::{
        msg::{GoalInfo, GoalStatusArray},
        srv::{CancelGoal, CancelGoalRequest, CancelGoalResponse},
    },
};

use super::{
    action::{ActionNames, GoalId, GoalStatus},
    error::RosError,
    introspection::CallGroup,
    node::Node,
    qos::Qos,
    services::Client,
    topics::Subscription,
};

/// Answer of a server to a request to cancel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CancelOutcome {
    /// The goal is canceling.
    Accepted,
    Rejected,
    /// The server does not know the goal.
    UnknownGoal,
    /// The goal has ended already.
    Terminated,
}

impl From<&CancelGoalResponse> for CancelOutcome {
    fn from(response: &CancelGoalResponse) -> Self {
        match response.return_code {
            CancelGoalResponse::ERROR_NONE => CancelOutcome::Accepted,
            CancelGoalResponse::ERROR_UNKNOWN_GOAL_ID => CancelOutcome::UnknownGoal,
            CancelGoalResponse::ERROR_GOAL_TERMINATED => CancelOutcome::Terminated,
            _ => CancelOutcome::Rejected,
        }
    }
}

type FeedbackCallback<A> = Arc<Mutex<Box<dyn FnMut(<A as Action>::Feedback) + Send>>>;

struct AcceptedGoal<A: Action> {
    feedback: FeedbackCallback<A>,
    status: GoalStatus,
}

type Goals<A> = Arc<Mutex<BTreeMap<GoalId, AcceptedGoal<A>>>>;

struct ActionClientCore<A: Action> {
    action: String,
    send_goal: Client<A::SendGoal>,
    cancel_goal: Client<CancelGoal>,
    get_result: Client<A::GetResult>,
    goals: Goals<A>,
    feedback: Subscription,
    _status: Subscription,
}

/// A client of an action. Clones are the same client.
pub struct ActionClient<A: Action> {
    core: Arc<ActionClientCore<A>>,
}

impl<A: Action> Clone for ActionClient<A> {
    fn clone(&self) -> Self {
        ActionClient { core: Arc::clone(&self.core) }
    }
}

impl<A: Action> fmt::Debug for ActionClient<A> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ActionClient").field("action", &self.core.action).finish_non_exhaustive()
    }
}

impl Node {
    /// Calls an action.
    ///
    /// # Errors
    /// The name breaks the rules, or the node is shut down.
    pub fn action_client<A: Action>(&self, name: &str) -> Result<ActionClient<A>, RosError> {
        let names = ActionNames::resolve(self, name)?;
        let goals: Goals<A> = Arc::default();
        let listening = Arc::clone(&goals);
        let feedback = self.subscribe::<A::FeedbackMessage>(
            &names.feedback,
            &Qos::default_topic().keep_last(100),
            move |m, _| {
                let (uuid, feedback) = A::split_feedback_message(m);
                let goals = listening.lock().unwrap_or_else(PoisonError::into_inner);
                let callback = goals.get(&GoalId::from_msg(&uuid)).map(|goal| Arc::clone(&goal.feedback));
                drop(goals);
                if let Some(callback) = callback {
                    (callback.lock().unwrap_or_else(PoisonError::into_inner))(feedback);
                }
            },
        )?;
        let following = Arc::clone(&goals);
        let status = self.subscribe::<GoalStatusArray>(&names.status, &Qos::action_status(), move |message, _| {
            let mut goals = following.lock().unwrap_or_else(PoisonError::into_inner);
            for status in message.status_list {
                if let Some(goal) = goals.get_mut(&GoalId::from_msg(&status.goal_info.goal_id)) {
                    goal.status = GoalStatus::from_number(status.status);
                }
            }
        })?;
        Ok(ActionClient {
            core: Arc::new(ActionClientCore {
                send_goal: self.client_with(&names.send_goal, CallGroup::ActionClients)?,
                cancel_goal: self.client_with(&names.cancel_goal, CallGroup::ActionClients)?,
                get_result: self.client_with(&names.get_result, CallGroup::ActionClients)?,
                action: names.action,
                goals,
                feedback,
                _status: status,
            }),
        })
    }
}

impl<A: Action> ActionClient<A> {
    /// Resolved name of the action.
    pub fn action(&self) -> &str {
        &self.core.action
    }

    /// Returns true while a server is matched.
    pub fn is_ready(&self) -> bool {
        self.core.send_goal.is_ready()
            && self.core.cancel_goal.is_ready()
            && self.core.get_result.is_ready()
            && self.core.feedback.matched() > 0
    }

    /// Waits until a server is matched. The node must spin on another thread.
    ///
    /// # Errors
    /// None appears in time, or the caller is a callback of the same node.
    pub fn wait_for_server(&self, timeout: Duration) -> Result<(), RosError> {
        let deadline = Instant::now() + timeout;
        let left = || deadline.saturating_duration_since(Instant::now());
        self.core.send_goal.wait_for_service(left())?;
        self.core.cancel_goal.wait_for_service(left())?;
        self.core.get_result.wait_for_service(left())?;
        if self.core.feedback.wait_matched(1, left()) {
            Ok(())
        } else {
            Err(RosError::timeout(format!("feedback of action {}", self.core.action), timeout))
        }
    }

    fn register(&self, feedback: impl FnMut(A::Feedback) + Send + 'static) -> ClientGoal<A> {
        let id = GoalId::random();
        let goal = AcceptedGoal { feedback: Arc::new(Mutex::new(Box::new(feedback))), status: GoalStatus::Unknown };
        self.core.goals.lock().unwrap_or_else(PoisonError::into_inner).insert(id, goal);
        ClientGoal { inner: Arc::new(ClientGoalInner { core: Arc::clone(&self.core), id, accepted: false.into() }) }
    }

    /// Sends a goal and waits until the server has decided on it; `feedback` is called on the executor thread.
    ///
    /// # Errors
    /// No answer comes in time. A rejection is not an error: see [`ClientGoal::accepted`].
    pub fn send_goal(
        &self,
        goal: A::Goal,
        feedback: impl FnMut(A::Feedback) + Send + 'static,
        timeout: Duration,
    ) -> Result<ClientGoal<A>, RosError> {
        let sent = self.register(feedback);
        let request = A::send_goal_request(sent.inner.id.to_msg(), goal);
        let (accepted, _stamp) = A::split_send_goal_response(self.core.send_goal.call(&request, timeout)?);
        sent.inner.accepted.store(accepted, std::sync::atomic::Ordering::Release);
        Ok(sent)
    }

    /// Sends a goal; `decided` is called on the executor thread when the server has decided on it. May be called from callbacks.
    ///
    /// # Errors
    /// The request cannot be sent.
    pub fn send_goal_with(
        &self,
        goal: A::Goal,
        feedback: impl FnMut(A::Feedback) + Send + 'static,
        decided: impl FnOnce(ClientGoal<A>) + Send + 'static,
    ) -> Result<(), RosError> {
        let sent = self.register(feedback);
        let request = A::send_goal_request(sent.inner.id.to_msg(), goal);
        self.core.send_goal.call_with(&request, move |response| {
            let (accepted, _stamp) = A::split_send_goal_response(response);
            sent.inner.accepted.store(accepted, std::sync::atomic::Ordering::Release);
            decided(sent);
        })?;
        Ok(())
    }

    /// Asks the server to cancel the goals of all clients; returns the number of goals that are canceling now.
    ///
    /// # Errors
    /// No answer comes in time.
    pub fn cancel_all(&self, timeout: Duration) -> Result<usize, RosError> {
        Ok(self.core.cancel_goal.call(&CancelGoalRequest::default(), timeout)?.goals_canceling.len())
    }
}

struct ClientGoalInner<A: Action> {
    core: Arc<ActionClientCore<A>>,
    id: GoalId,
    accepted: std::sync::atomic::AtomicBool,
}

impl<A: Action> Drop for ClientGoalInner<A> {
    fn drop(&mut self) {
        let removed = self.core.goals.lock().unwrap_or_else(PoisonError::into_inner).remove(&self.id);
        drop(removed);
    }
}

/// A goal that was sent. Clones are the same goal; feedback ends with the last of them (the goal itself goes on).
pub struct ClientGoal<A: Action> {
    inner: Arc<ClientGoalInner<A>>,
}

impl<A: Action> Clone for ClientGoal<A> {
    fn clone(&self) -> Self {
        ClientGoal { inner: Arc::clone(&self.inner) }
    }
}

impl<A: Action> fmt::Debug for ClientGoal<A> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ClientGoal").field("id", &self.inner.id.to_string()).finish_non_exhaustive()
    }
}

impl<A: Action> ClientGoal<A> {
    /// Identity of the goal.
    pub fn id(&self) -> GoalId {
        self.inner.id
    }

    /// Returns true if the server accepted the goal. The protocol carries no reason for a rejection; the server's log does.
    pub fn accepted(&self) -> bool {
        self.inner.accepted.load(std::sync::atomic::Ordering::Acquire)
    }

    /// State of the goal as the server last published it.
    pub fn status(&self) -> GoalStatus {
        let goals = self.inner.core.goals.lock().unwrap_or_else(PoisonError::into_inner);
        goals.get(&self.inner.id).map_or(GoalStatus::Unknown, |goal| goal.status)
    }

    fn cancel_request(&self) -> CancelGoalRequest {
        CancelGoalRequest { goal_info: GoalInfo { goal_id: self.inner.id.to_msg(), ..Default::default() } }
    }

    /// Asks the server to cancel the goal and waits for its answer (not for the end of the goal).
    ///
    /// # Errors
    /// No answer comes in time.
    pub fn cancel(&self, timeout: Duration) -> Result<CancelOutcome, RosError> {
        let response = self.inner.core.cancel_goal.call(&self.cancel_request(), timeout)?;
        Ok(CancelOutcome::from(&response))
    }

    /// Asks the server to cancel the goal; `answer` is called on the executor thread.
    ///
    /// # Errors
    /// The request cannot be sent.
    pub fn cancel_with(&self, answer: impl FnOnce(CancelOutcome) + Send + 'static) -> Result<(), RosError> {
        let request = self.cancel_request();
        self.inner.core.cancel_goal.call_with(&request, move |response| answer(CancelOutcome::from(&response)))?;
        Ok(())
    }

    /// Waits for the end of the goal. May be asked again for as long as the server keeps results.
    ///
    /// # Errors
    /// The goal does not end in time.
    pub fn result(&self, timeout: Duration) -> Result<(GoalStatus, A::Result), RosError> {
        let request = A::get_result_request(self.inner.id.to_msg());
        let (status, result) = A::split_get_result_response(self.inner.core.get_result.call(&request, timeout)?);
        Ok((GoalStatus::from_number(status), result))
    }

    /// Calls `ended` on the executor thread at the end of the goal.
    ///
    /// # Errors
    /// The request cannot be sent.
    pub fn result_with(&self, ended: impl FnOnce(GoalStatus, A::Result) + Send + 'static) -> Result<(), RosError> {
        let request = A::get_result_request(self.inner.id.to_msg());
        self.inner.core.get_result.call_with(&request, move |response| {
            let (status, result) = A::split_get_result_response(response);
            ended(GoalStatus::from_number(status), result);
        })?;
        Ok(())
    }
}
