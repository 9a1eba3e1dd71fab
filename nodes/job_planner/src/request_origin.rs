// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The client that asked for a job.

use super::lock;
use camwright_msgs::camwright_msgs::action::RunJob;
use camwright_msgs::camwright_msgs::srv::{IdentifyStiffness, IdentifyStiffnessResponse};
use camwright_ros::{GoalHandle, Responder};
use std::sync::{Arc, Mutex};

/// Client of `~/identify_stiffness`, until it has its answer.
pub(super) type PendingAnswer = Arc<Mutex<Option<Responder<IdentifyStiffness>>>>;

/// Client that asked for the job and gets its outcome.
#[derive(Debug, Clone)]
pub(super) enum RequestOrigin {
    /// A client of `~/run_job`.
    Goal(GoalHandle<RunJob>),
    /// One of `~/identify_stiffness`.
    Stiffness(PendingAnswer),
    /// The cell, for a part of its run; it follows the board.
    Cell,
}

/// Answers the client, once.
pub(super) fn answer(waiting: &PendingAnswer, response: &IdentifyStiffnessResponse) {
    if let Some(responder) = lock(waiting).take() {
        responder.send(response);
    }
}
