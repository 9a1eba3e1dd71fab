// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Handle of an accepted goal, for the code that works on it.

use std::{
    fmt,
    sync::{
        Arc,
        atomic::{AtomicI8, Ordering},
    },
};

use camwright_msgs::Action;

use super::{
    action::{GoalId, GoalStatus},
    goal_table::GoalTableCore,
};

struct Token<A: Action> {
    core: Arc<GoalTableCore<A>>,
    id: GoalId,
    goal: A::Goal,
    client: String,
    status: Arc<AtomicI8>,
}

impl<A: Action> Drop for Token<A> {
    fn drop(&mut self) {
        // A goal whose worker has gone would keep its client waiting for ever.
        if self.core.finish(self.id, GoalStatus::Aborted, A::Result::default()) {
            self.core.logger.error(&format!("goal {} of {} was dropped and is aborted", self.id, self.core.name));
        }
    }
}

/// An accepted goal. Clones are the same goal. Dropping the last clone aborts a goal that has not ended.
pub struct GoalHandle<A: Action> {
    token: Arc<Token<A>>,
}

impl<A: Action> Clone for GoalHandle<A> {
    fn clone(&self) -> Self {
        GoalHandle { token: Arc::clone(&self.token) }
    }
}

impl<A: Action> fmt::Debug for GoalHandle<A> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("GoalHandle").field("id", &self.token.id.to_string()).field("status", &self.status()).finish()
    }
}

impl<A: Action> GoalHandle<A> {
    pub(super) fn new(
        core: &Arc<GoalTableCore<A>>,
        id: GoalId,
        goal: A::Goal,
        client: String,
        status: Arc<AtomicI8>,
    ) -> Self {
        GoalHandle { token: Arc::new(Token { core: Arc::clone(core), id, goal, client, status }) }
    }

    /// Identity of the goal.
    pub fn id(&self) -> GoalId {
        self.token.id
    }

    pub fn goal(&self) -> &A::Goal {
        &self.token.goal
    }

    /// Fully qualified name of the client's node; its GUID while the node is unknown.
    pub fn client(&self) -> &str {
        &self.token.client
    }

    /// State of the goal.
    pub fn status(&self) -> GoalStatus {
        GoalStatus::from_number(self.token.status.load(Ordering::Acquire))
    }

    /// Returns true after an accepted request to cancel; the goal has to be ended.
    pub fn is_canceling(&self) -> bool {
        self.status() == GoalStatus::Canceling
    }

    /// Returns true until the goal has ended.
    pub fn is_active(&self) -> bool {
        !self.status().is_terminal()
    }

    /// Publishes feedback.
    pub fn feedback(&self, feedback: &A::Feedback) {
        let message = A::feedback_message(self.token.id.to_msg(), feedback.clone());
        if let Err(error) = self.token.core.feedback.publish(&message) {
            self.token.core.logger.warn(&error.to_string());
        }
    }

    /// Ends the goal as succeeded. Returns false if it has ended already.
    pub fn succeed(&self, result: A::Result) -> bool {
        self.token.core.finish(self.token.id, GoalStatus::Succeeded, result)
    }

    /// Ends the goal as aborted. Returns false if it has ended already.
    pub fn abort(&self, result: A::Result) -> bool {
        self.token.core.finish(self.token.id, GoalStatus::Aborted, result)
    }

    /// Ends the goal as canceled. Returns false if it has ended already.
    pub fn canceled(&self, result: A::Result) -> bool {
        self.token.core.finish(self.token.id, GoalStatus::Canceled, result)
    }
}
