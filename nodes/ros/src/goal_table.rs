// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Goals of an action server, their states, and the clients that wait for their results.

use camwright_msgs::Action;
use camwright_msgs::Service;
use camwright_msgs::action_msgs::msg::{GoalInfo, GoalStatus as GoalStatusMsg, GoalStatusArray};
use camwright_msgs::builtin_interfaces::msg::Time;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicI8, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, Instant};

use super::action::{GoalId, GoalStatus, RESULT_TIMEOUT};
use super::clock::from_time;
use super::logging::Logger;
use super::node::WeakNode;
use super::services::Responder;
use super::telemetry::Telemetry;
use super::topics::Publisher;

/// Goals with which every change of status is published at once.
const PUBLISHED_AT_ONCE: usize = 16;

/// Time from status to status with more goals.
const STATUS_PERIOD: Duration = Duration::from_millis(20);

/// Goals an action server keeps: those under way, and those that ended within the last seconds.
const MAX_GOALS: usize = 1024;

/// Clients that may wait for the result of one goal.
const MAX_WAITING_FOR_RESULT: usize = 64;

pub(super) struct GoalEntry<A: Action> {
    pub(super) stamp: Time,
    pub(super) status: Arc<AtomicI8>,
    pub(super) result: Option<A::Result>,
    pub(super) waiting: Vec<Responder<A::GetResult>>,
    pub(super) ended: Option<Instant>,
}

impl<A: Action> GoalEntry<A> {
    pub(super) fn status(&self) -> GoalStatus {
        GoalStatus::from_number(self.status.load(Ordering::Acquire))
    }
}

pub(super) struct GoalTableCore<A: Action> {
    pub(super) name: String,
    /// Guards the table and the order of what is published about it: the status is published with the lock held.
    pub(super) goals: Mutex<BTreeMap<GoalId, GoalEntry<A>>>,
    /// Dropped where a client leaves no room: an action goes on without it.
    pub(super) feedback: Telemetry<A::FeedbackMessage>,
    pub(super) status: Publisher<GoalStatusArray>,
    pub(super) logger: Logger,
    pub(super) node: WeakNode,
    pub(super) this: Weak<GoalTableCore<A>>,
    /// A status that stands for several changes is due.
    pub(super) is_status_due: AtomicBool,
}

impl<A: Action> GoalTableCore<A> {
    pub(super) fn goals(&self) -> MutexGuard<'_, BTreeMap<GoalId, GoalEntry<A>>> {
        self.goals.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn now(&self) -> Time {
        self.node.upgrade().map(|node| node.now()).unwrap_or_default()
    }

    /// Publishes the status, at once or, with many goals, soon: a message names them all, and each goal changes it three times.
    pub(super) fn publish_status(&self, goals: &BTreeMap<GoalId, GoalEntry<A>>) {
        if goals.len() <= PUBLISHED_AT_ONCE {
            return self.publish_status_now(goals);
        }
        if self.is_status_due.swap(true, Ordering::AcqRel) {
            return;
        }
        let Some(node) = self.node.upgrade() else { return };
        let core = self.this.clone();
        node.after(STATUS_PERIOD, move || {
            let Some(core) = core.upgrade() else { return };
            core.is_status_due.store(false, Ordering::Release);
            core.publish_status_now(&core.goals());
        });
    }

    fn publish_status_now(&self, goals: &BTreeMap<GoalId, GoalEntry<A>>) {
        let mut status_list: Vec<GoalStatusMsg> = goals
            .iter()
            .map(|(id, entry)| GoalStatusMsg {
                goal_info: GoalInfo { goal_id: id.to_msg(), stamp: entry.stamp.clone() },
                status: entry.status() as i8,
            })
            .collect();
        status_list.sort_by_key(|status| from_time(&status.goal_info.stamp));
        if let Err(error) = self.status.publish(&GoalStatusArray { status_list }) {
            self.logger.warn(&error.to_string());
        }
    }

    pub(super) fn set(&self, goals: &BTreeMap<GoalId, GoalEntry<A>>, id: GoalId, status: GoalStatus) {
        if let Some(entry) = goals.get(&id) {
            entry.status.store(status as i8, Ordering::Release);
            self.publish_status(goals);
        }
    }

    /// Handles a request for a result: answered now or at the end of the goal.
    pub(super) fn get_result(&self, request: <A::GetResult as Service>::Request, responder: Responder<A::GetResult>) {
        let id = GoalId::from_msg(&A::split_get_result_request(request));
        let mut goals = self.goals();
        let response = match goals.get_mut(&id) {
            None => A::get_result_response(GoalStatus::Unknown as i8, A::Result::default()),
            Some(entry) => match &entry.result {
                Some(result) => A::get_result_response(entry.status() as i8, result.clone()),
                None if entry.waiting.len() < MAX_WAITING_FOR_RESULT => {
                    entry.waiting.push(responder);
                    return;
                }
                // Its status says that this is not the end.
                None => A::get_result_response(entry.status() as i8, A::Result::default()),
            },
        };
        drop(goals);
        responder.send(&response);
    }

    /// Ends a goal; `false` if it has ended already.
    pub(super) fn finish(&self, id: GoalId, status: GoalStatus, result: A::Result) -> bool {
        let mut goals = self.goals();
        let Some(entry) = goals.get(&id) else { return false };
        if entry.status().is_terminal() {
            return false;
        }
        if status == GoalStatus::Canceled && entry.status() != GoalStatus::Canceling {
            // The goal ended before the answer to the cancel request.
            self.set(&goals, id, GoalStatus::Canceling);
        }
        let Some(entry) = goals.get_mut(&id) else { return false };
        let response = A::get_result_response(status as i8, result.clone());
        entry.result = Some(result);
        entry.ended = Some(Instant::now());
        let waiting = std::mem::take(&mut entry.waiting);
        self.set(&goals, id, status);
        drop(goals);
        for responder in waiting {
            responder.send(&response);
        }
        true
    }

    /// Makes room for a goal; the reason if there is none. Results that can no longer be requested go first.
    pub(super) fn make_room(&self, id: GoalId) -> Option<String> {
        let mut goals = self.goals();
        if goals.contains_key(&id) {
            return Some("its id is in use".into());
        }
        if goals.len() < MAX_GOALS {
            return None;
        }
        let ended = goals.iter().filter_map(|(id, entry)| entry.ended.map(|ended| (ended, *id)));
        match ended.min() {
            Some((_, oldest)) => {
                goals.remove(&oldest);
                None
            }
            None => Some(format!("{MAX_GOALS} goals of this action have not ended; wait for one to end")),
        }
    }

    pub(super) fn expire(&self) {
        let mut goals = self.goals();
        let before = goals.len();
        goals.retain(|_, entry| entry.ended.is_none_or(|ended| ended.elapsed() < RESULT_TIMEOUT));
        if goals.len() != before {
            self.publish_status(&goals);
        }
    }
}

pub(super) fn is_cancelable(status: GoalStatus) -> bool {
    matches!(status, GoalStatus::Accepted | GoalStatus::Executing)
}
