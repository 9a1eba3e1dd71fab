// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The job under way: its stage, and the events for its thread.

use camwright_msgs::camwright_msgs::action::ExecutePlanResult;
use camwright_planning::AnyPrepared;
use camwright_ros::GoalStatus;
use std::fmt;
use std::sync::mpsc;

/// Event for the thread of a running job.
#[derive(Debug)]
pub(super) enum JobEvent {
    Cancel,
    /// The interpolator has ended the plan.
    Ended(GoalStatus, ExecutePlanResult),
}

/// Stage of the one job that can be under way.
#[derive(Debug, Default)]
pub(super) enum JobSlot {
    #[default]
    Idle,
    /// A goal is being decided on.
    Deciding(String),
    /// A goal was accepted; its thread is about to start.
    Prepared(Box<AnyPrepared>),
    /// A job runs; its thread listens here.
    Running(String, mpsc::Sender<JobEvent>),
}

impl fmt::Display for JobSlot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            JobSlot::Idle => f.write_str("idle"),
            JobSlot::Deciding(job) => write!(f, "job {job} is being planned"),
            JobSlot::Prepared(prepared) => write!(f, "job {} is about to start", prepared.name()),
            JobSlot::Running(job, _) => write!(f, "job {job} is running"),
        }
    }
}
