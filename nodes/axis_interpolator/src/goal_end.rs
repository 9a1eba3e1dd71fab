// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! End of a goal: its state and its result.

use camwright::interpolator::{MotionOutcome, ProbeOutcome};
use camwright::machine::description::{Axis, MachineDescription};
use camwright_files::convert::si_from_counts;
use camwright_msgs::camwright_msgs::action::{Jog, JogResult, Probe, ProbeResult};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolResponse};
use camwright_ros::{GoalHandle, Responder};

/// Final state of a goal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GoalEnd {
    Succeeded,
    Canceled,
    Aborted,
}

impl GoalEnd {
    pub(super) fn close<A: camwright_msgs::Action>(self, goal: &GoalHandle<A>, result: A::Result) {
        // False where the goal has ended already, which then is its end.
        let _first_end = match self {
            GoalEnd::Succeeded => goal.succeed(result),
            GoalEnd::Canceled => goal.canceled(result),
            GoalEnd::Aborted => goal.abort(result),
        };
    }
}

pub(super) fn close<A: camwright_msgs::Action>(goal: &GoalHandle<A>, outcome: MotionOutcome, result: A::Result) {
    let end = match outcome {
        MotionOutcome::Completed => GoalEnd::Succeeded,
        MotionOutcome::Cancelled => GoalEnd::Canceled,
        MotionOutcome::Failed(_) | MotionOutcome::OutOfTolerance(_) => GoalEnd::Aborted,
    };
    end.close(goal, result);
}

/// Ends a probe whose axes rest.
pub(super) fn end_probe(
    goal: &GoalHandle<Probe>,
    outcome: MotionOutcome,
    probed: Option<ProbeOutcome>,
    mut result: ProbeResult,
    machine: &MachineDescription,
) {
    let Some(axis) = Axis::from_joint(&goal.goal().joint) else { return close(goal, outcome, result) };
    let scale = machine.axis(axis).scale;
    let si = |counts: i64| si_from_counts(scale, counts);
    let input = &goal.goal().input;
    result.already_there = probed == Some(ProbeOutcome::AlreadyThere);
    let (latch, off, correction) = match probed {
        Some(ProbeOutcome::Found { latch, correction }) => (Some(latch), correction, correction),
        Some(ProbeOutcome::TooFarOff { latch, off }) => (Some(latch), off, 0),
        Some(ProbeOutcome::Missed | ProbeOutcome::AlreadyThere) | None => (None, 0, 0),
    };
    if let Some(latch) = latch {
        (result.found, result.tick) = (true, latch.tick);
        (result.position, result.off, result.correction) = (si(latch.counts), si(off), si(correction));
    }
    if outcome != MotionOutcome::Completed {
        return close(goal, outcome, result);
    }
    let verb = if goal.goal().until_open { "open" } else { "close" };
    let failed = match probed {
        Some(ProbeOutcome::Found { .. }) => None,
        Some(ProbeOutcome::TooFarOff { off, .. }) => Some(format!(
            "the edge is off by {:.6} m, more than the {:.6} m by which the zero may be corrected; it stays as it was",
            si(off),
            goal.goal().most_correction
        )),
        Some(ProbeOutcome::Missed) if goal.goal().may_miss => None,
        Some(ProbeOutcome::Missed) => Some(format!("{} went to its target and {input} did not {verb}", axis.joint())),
        Some(ProbeOutcome::AlreadyThere) => Some(format!("{input} does not {verb}: it is so already; nothing moved")),
        None => Some("the probe returned no result".to_owned()),
    };
    match failed {
        None => close(goal, outcome, result),
        Some(message) => {
            // False where the goal has ended already, which then is its end.
            let _first_end = goal.abort(ProbeResult { message, ..result });
        }
    }
}

/// Ends a jog with a message for its client.
pub(super) fn end_jog(goal: &GoalHandle<Jog>, outcome: MotionOutcome, was_let_go: bool, result: JogResult) {
    let text = match (outcome, was_let_go) {
        (MotionOutcome::Completed, _) if goal.goal().distance != 0.0 => Some("it has gone its distance"),
        (MotionOutcome::Completed, _) => Some("it is at its soft limit"),
        (MotionOutcome::Cancelled, true) => Some("it was let go of, and rests"),
        _ => None,
    };
    match text {
        Some(text) => GoalEnd::Succeeded.close(goal, JogResult { message: text.to_owned(), ..result }),
        None => close(goal, outcome, result),
    }
}

/// Answers the client of `~/wheel`.
pub(super) fn end_wheel(responder: Responder<SetBool>, turns: bool, outcome: MotionOutcome, text: String) {
    let success = outcome == MotionOutcome::Completed;
    let message = match (success, turns) {
        (true, true) => "the wheel has its speed".to_owned(),
        (true, false) => "the wheel rests".to_owned(),
        (false, _) => text,
    };
    responder.send(&SetBoolResponse { success, message });
}
