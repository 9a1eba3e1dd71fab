// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Plans that are to be executed: the action `~/execute_plan`.

use super::goals::{RunningGoal, by};
use super::{Shared, lock};
use camwright::interpolator::MotionRequest;
use camwright_msgs::camwright_msgs::action::{ExecutePlan, ExecutePlanGoal};
use camwright_ros::{ActionHandler, GoalDecision, GoalHandle, GoalId};
use std::sync::Arc;

/// Serves `~/execute_plan`.
#[derive(Debug)]
pub(super) struct PlanHandler(pub(super) Arc<Shared>);

impl ActionHandler<ExecutePlan> for PlanHandler {
    fn goal(&mut self, _id: GoalId, goal: &ExecutePlanGoal) -> GoalDecision {
        let named = || match goal.plan_hash.is_empty() {
            true => Err("the goal names no plan".to_owned()),
            false => self.0.hindrance(),
        };
        match self.0.obstacle().map_or_else(named, Err) {
            Ok(()) => GoalDecision::Accept,
            Err(reason) => GoalDecision::Reject(reason),
        }
    }

    fn accepted(&mut self, handle: GoalHandle<ExecutePlan>) {
        let hash = handle.goal().plan_hash.clone();
        let name = match handle.goal().client.as_str() {
            "" => by(&format!("plan {}", short(&hash)), handle.client()),
            client => format!("plan {} of {client}", short(&hash)),
        };
        lock(&self.0.served).begin(RunningGoal::Plan(handle), name, hash.clone());
        lock(&self.0.plans).wait_for(hash);
        self.0.begin_plan();
    }

    fn cancel(&mut self, _id: GoalId) -> bool {
        if lock(&self.0.plans).waiting().is_some() {
            lock(&self.0.plans).forget_waiting();
            lock(&self.0.served).withdraw("cancelled before its plan was complete");
            return true;
        }
        self.0.request(MotionRequest::Cancel)
    }
}

fn short(hash: &str) -> &str {
    hash.get(..8).unwrap_or(hash)
}
