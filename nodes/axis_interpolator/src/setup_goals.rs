// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Set-up work: the actions `~/home`, `~/move_to` and `~/probe`. Goals that can be judged without moving are rejected with a reason in
//! the log; a goal that fails at its start, for example because an axis is not homed, is aborted.

use super::goals::{RunningGoal, by};
use super::{Shared, lock};
use camwright::interpolator::MotionRequest;
use camwright::machine::description::{Axis, MachineDescription};
use camwright::machine::setpoint::Input;
use camwright_files::convert::machine_report::input_named;
use camwright_files::convert::motion_record::{MotionRecord, MoveRecord, ProbeRecord};
use camwright_files::convert::{core_from_si, mm_from_m};
use camwright_msgs::camwright_msgs::action::{Home, HomeGoal, MoveTo, MoveToGoal, Probe, ProbeGoal};
use camwright_ros::{ActionHandler, GoalDecision, GoalHandle, GoalId};
use std::sync::Arc;

/// Speed of a wheel that touches unless the goal says another (mm/s): with a feedback delay of 0.1 s it runs on by 5 µm.
pub(crate) const TOUCH_MM_S: f64 = 0.05;

/// Serves `~/home`.
#[derive(Debug)]
pub(super) struct HomeHandler(pub(super) Arc<Shared>);

impl ActionHandler<Home> for HomeHandler {
    fn goal(&mut self, _id: GoalId, goal: &HomeGoal) -> GoalDecision {
        if let Some(joint) = goal.joints.iter().find(|joint| Axis::from_joint(joint).is_none()) {
            return GoalDecision::Reject(format!("there is no joint {joint:?}"));
        }
        self.0.decide(|machine| Ok(homing(goal, machine)))
    }

    fn accepted(&mut self, handle: GoalHandle<Home>) {
        let motion = self.0.machine().ok_or_else(unknown).map(|machine| homing(handle.goal(), &machine));
        let name = by("homing", handle.client());
        lock(&self.0.served).begin(RunningGoal::Home(handle), name, String::new());
        self.0.begin_or_refuse(motion);
    }

    fn cancel(&mut self, _id: GoalId) -> bool {
        self.0.request(MotionRequest::Cancel)
    }
}

/// Serves `~/move_to`.
#[derive(Debug)]
pub(super) struct MoveHandler(pub(super) Arc<Shared>);

impl ActionHandler<MoveTo> for MoveHandler {
    fn goal(&mut self, _id: GoalId, goal: &MoveToGoal) -> GoalDecision {
        self.0.decide(|_| self.0.targets(goal))
    }

    fn accepted(&mut self, handle: GoalHandle<MoveTo>) {
        let motion = self.0.targets(handle.goal());
        let name = by(&format!("a move of {}", handle.goal().joints.join(", ")), handle.client());
        lock(&self.0.served).begin(RunningGoal::Move(handle), name, String::new());
        self.0.begin_or_refuse(motion);
    }

    fn cancel(&mut self, _id: GoalId) -> bool {
        self.0.request(MotionRequest::Cancel)
    }
}

/// Serves `~/probe`.
#[derive(Debug)]
pub(super) struct ProbeHandler(pub(super) Arc<Shared>);

impl ActionHandler<Probe> for ProbeHandler {
    fn goal(&mut self, _id: GoalId, goal: &ProbeGoal) -> GoalDecision {
        self.0.decide(|machine| self.0.probe(goal, machine))
    }

    fn accepted(&mut self, handle: GoalHandle<Probe>) {
        let motion = self.0.machine().ok_or_else(unknown).and_then(|machine| self.0.probe(handle.goal(), &machine));
        let name = by(&format!("a probe of {} for {}", handle.goal().joint, handle.goal().input), handle.client());
        lock(&self.0.served).begin(RunningGoal::Probe(handle), name, String::new());
        self.0.begin_or_refuse(motion);
    }

    fn cancel(&mut self, _id: GoalId) -> bool {
        self.0.request(MotionRequest::Cancel)
    }
}

/// Homing of the joints of a goal; of all axes that need it if the goal names none.
fn homing(goal: &HomeGoal, machine: &MachineDescription) -> MotionRecord {
    let mut axes: Vec<Axis> = goal.joints.iter().filter_map(|joint| Axis::from_joint(joint)).collect();
    if axes.is_empty() {
        axes = Axis::ALL.into_iter().filter(|axis| machine.axis(*axis).needs_homing).collect();
    }
    MotionRecord::Home(axes.iter().map(|axis| axis.joint().to_owned()).collect())
}

pub(super) fn unknown() -> String {
    "no message from the machine yet".to_owned()
}

pub(super) fn axis(joint: &str) -> Result<Axis, String> {
    Axis::from_joint(joint).ok_or_else(|| format!("there is no joint {joint:?}"))
}

impl Shared {
    pub(super) fn begin_or_refuse(&self, record: Result<MotionRecord, String>) {
        match self.hindrance().and(record) {
            Ok(record) => self.begin(record, None),
            Err(reason) => lock(&self.served).refuse(&reason),
        }
    }

    fn targets(&self, goal: &MoveToGoal) -> Result<MotionRecord, String> {
        let (joints, positions) = (goal.joints.len(), goal.positions.len());
        if joints != positions {
            return Err(format!("{joints} joints and {positions} positions; each joint needs one"));
        }
        let moves = goal.joints.iter().zip(&goal.positions).map(|(joint, position)| {
            let axis = axis(joint)?;
            let position = core_from_si(axis, *position);
            Ok(MoveRecord { joint: joint.clone(), position, relative: goal.relative })
        });
        let moves: Vec<MoveRecord> = moves.collect::<Result<_, String>>()?;
        let speed_factor = if goal.speed_factor == 0.0 { 1.0 } else { goal.speed_factor };
        Ok(MotionRecord::Move { moves, from: *lock(&self.rest_counts), speed_factor })
    }

    fn probe(&self, goal: &ProbeGoal, machine: &MachineDescription) -> Result<MotionRecord, String> {
        let axis = axis(&goal.joint)?;
        let speed = match (goal.speed == 0.0, input_named(&goal.input, machine)) {
            (true, Some(Input::WheelContact)) => TOUCH_MM_S,
            (true, _) => machine.axis(axis).search_velocity,
            (false, _) => core_from_si(axis, goal.speed),
        };
        Ok(MotionRecord::Probe(Box::new(ProbeRecord {
            joint: goal.joint.clone(),
            target: core_from_si(axis, goal.target),
            speed,
            input: goal.input.clone(),
            until_open: goal.until_open,
            stand_off: core_from_si(axis, goal.stand_off),
            most_force_n: goal.most_force,
            reads: goal.correct_zero.then(|| (mm_from_m(goal.true_position), mm_from_m(goal.most_correction))),
            from: *lock(&self.rest_counts),
        })))
    }
}
