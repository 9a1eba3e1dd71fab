// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Work by hand: the action `~/jog` with its `~/hold_to_run`, and the service `~/wheel`.
//!
//! A jog that has no distance continues while messages come on `~/hold_to_run`. They are waited for in ticks of the
//! machine, so that a jog ends if any of these has stopped: its client, the network, this node's other threads.

use super::goals::{RunningGoal, by};
use super::{Shared, lock};
use camwright::interpolator::MotionRequest;
use camwright::machine::description::Axis;
use camwright_files::convert::motion_record::MotionRecord;
use camwright_files::convert::{core_from_si, si_from_counts};
use camwright_msgs::camwright_msgs::action::{Jog, JogFeedback, JogGoal};
use camwright_msgs::camwright_msgs::msg::MachineStream;
use camwright_msgs::std_msgs::msg::Empty;
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolResponse};
use camwright_ros::{
    ActionHandler, GoalDecision, GoalHandle, GoalId, Qos, Responder, RosError, ServiceHandle, Subscription,
};
use std::sync::Arc;

/// Longest time between two messages on `~/hold_to_run`, unless the goal says another, and the longest that it may say (s).
const HOLD_TO_RUN_S: f64 = 0.5;
const LONGEST_HOLD_S: f64 = 2.0;
/// Period of a jog's feedback (s).
const FEEDBACK_S: f64 = 0.05;

/// A jog that has to be held, in ticks of the machine.
#[derive(Debug, Clone, Copy)]
pub(super) struct HeldJog {
    ticks: u64,
    until: u64,
}

/// Serves `~/jog`.
#[derive(Debug)]
pub(super) struct JogHandler(pub(super) Arc<Shared>);

impl ActionHandler<Jog> for JogHandler {
    fn goal(&mut self, _id: GoalId, goal: &JogGoal) -> GoalDecision {
        self.0.decide(|machine| {
            hold_ticks(goal, machine.cycle_time_s())?;
            self.0.jog(goal)
        })
    }

    fn accepted(&mut self, handle: GoalHandle<Jog>) {
        let goal = handle.goal().clone();
        let jog = self.0.machine().ok_or_else(super::setup_goals::unknown).and_then(|machine| {
            let held = hold_ticks(&goal, machine.cycle_time_s())?;
            Ok((self.0.jog(&goal)?, held))
        });
        let name = by(&format!("a jog of {}", goal.joint), handle.client());
        lock(&self.0.served).begin(RunningGoal::Jog(handle), name, String::new());
        let until = |ticks| HeldJog { ticks, until: self.0.machine_tick() + ticks };
        *lock(&self.0.held) = jog.as_ref().ok().and_then(|(_, held)| *held).map(until);
        self.0.begin_or_refuse(jog.map(|(jog, _)| jog));
    }

    fn cancel(&mut self, _id: GoalId) -> bool {
        self.0.request(MotionRequest::Cancel)
    }
}

/// Duration of a jog after its last hold message (ticks); `None` if it needs none.
fn hold_ticks(goal: &JogGoal, cycle_s: f64) -> Result<Option<u64>, String> {
    let seconds = match goal.hold_to_run {
        _ if goal.distance != 0.0 => return Ok(None),
        JogGoal::UNTIL_CANCEL if goal.joint == Axis::C.joint() => return Ok(None),
        JogGoal::UNTIL_CANCEL => {
            return Err(format!("{} does not move without being held; only c_axis turns so", goal.joint));
        }
        0.0 => HOLD_TO_RUN_S,
        seconds => seconds,
    };
    if !(seconds > 0.0 && seconds <= LONGEST_HOLD_S) {
        return Err(format!("hold_to_run is {seconds} s; it must be above 0 and at most {LONGEST_HOLD_S} s"));
    }
    #[allow(clippy::cast_possible_truncation, reason = "a few thousand at most")]
    Ok(Some((seconds / cycle_s).ceil() as u64))
}

impl Shared {
    fn jog(&self, goal: &JogGoal) -> Result<MotionRecord, String> {
        let axis = super::setup_goals::axis(&goal.joint)?;
        Ok(MotionRecord::Jog {
            joint: goal.joint.clone(),
            velocity: core_from_si(axis, goal.velocity),
            distance: (goal.distance != 0.0).then(|| core_from_si(axis, goal.distance)),
            from: *lock(&self.rest_counts),
            knows_zero: lock(&self.homed)[axis.index()],
        })
    }

    /// Ends a jog without a recent hold message, and publishes its position.
    pub(super) fn watch_jog(&self, message: &MachineStream) {
        let mut served = lock(&self.served);
        let Some(goal) = served.jog() else { return };
        let Some(axis) = Axis::from_joint(&goal.goal().joint) else { return };
        if let Some(cell) = lock(&self.cell).as_ref() {
            let machine = &cell.machine;
            #[allow(clippy::cast_possible_truncation, reason = "a cycle is 1 us at least")]
            let every = (FEEDBACK_S / machine.cycle_time_s()) as u64;
            let at = (message.actual_counts.get(axis.index()), message.actual_velocities.get(axis.index()));
            if let ((Some(counts), Some(velocity)), true) =
                (at, message.tick % every.max(1) < machine.stream_period_ticks())
            {
                let position = si_from_counts(machine.axis(axis).scale, *counts);
                goal.feedback(&JogFeedback { position, velocity: *velocity });
            }
        }
        let mut held = lock(&self.held);
        if held.is_some_and(|held| message.tick > held.until) {
            *held = None;
            served.let_go();
            drop((held, served));
            self.request(MotionRequest::Cancel);
        }
    }

    fn wheel(&self, turns: bool, responder: Responder<SetBool>) {
        if let Some(reason) = self.obstacle() {
            responder.send(&SetBoolResponse { success: false, message: reason });
            return;
        }
        let what = if turns { "starting the wheel" } else { "stopping the wheel" };
        let name = by(what, &self.node.who(&responder.client()));
        lock(&self.served).begin(RunningGoal::Wheel(responder, turns), name, String::new());
        self.begin_or_refuse(Ok(MotionRecord::Wheel(turns)));
    }
}

/// The service `~/wheel`.
pub(super) fn offer(shared: &Arc<Shared>) -> Result<ServiceHandle, RosError> {
    let this = Arc::clone(shared);
    shared.node.service_deferred::<SetBool>("~/wheel", move |request, responder| {
        let failed = |message| SetBoolResponse { success: false, message };
        this.wheel(request.data, responder.or_fail(failed));
    })
}

/// The topic `~/hold_to_run`.
pub(super) fn subscribe(shared: &Arc<Shared>) -> Result<Subscription, RosError> {
    let this = Arc::clone(shared);
    shared.node.subscribe::<Empty>("~/hold_to_run", &Qos::default_topic(), move |_, info| {
        if !this.grant.accepts("~/hold_to_run", &info.writer, &this.node) {
            return;
        }
        let tick = this.machine_tick();
        if let Some(held) = lock(&this.held).as_mut() {
            held.until = tick + held.ticks;
        }
    })
}
