// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The goal that has command of the axes: a plan, a homing, a trajectory.

use super::engine_messages::Ended;
use super::goal_end::{self, GoalEnd, close};
use camwright::interpolator::tolerance::MotionPhase;
use camwright::interpolator::{InterpolatorStatus, MotionOutcome, ProbeOutcome, SearchStep};
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::{Axis, MachineDescription};
use camwright_files::convert::{m_from_mm, si_from_counts};
use camwright_msgs::camwright_msgs::action::{
    ExecutePlan, ExecutePlanFeedback, ExecutePlanResult, Home, HomeFeedback, HomeResult, Jog, JogResult, MoveTo,
    MoveToFeedback, MoveToResult, Probe, ProbeFeedback, ProbeResult,
};
use camwright_msgs::camwright_msgs::msg::PlanSegment;
use camwright_msgs::control_msgs::action::{FollowJointTrajectory, FollowJointTrajectoryResult};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolResponse};
use camwright_ros::{GoalHandle, Responder};

/// A goal in execution.
#[derive(Debug)]
pub(super) enum RunningGoal {
    Plan(GoalHandle<ExecutePlan>),
    Home(GoalHandle<Home>),
    Trajectory(GoalHandle<FollowJointTrajectory>),
    Move(GoalHandle<MoveTo>),
    Probe(GoalHandle<Probe>),
    Jog(GoalHandle<Jog>),
    /// The wheel, to its speed (true) or to rest.
    Wheel(Responder<SetBool>, bool),
    /// A trajectory that has begun in the place of another; its handle is on its way.
    Arrived,
    /// A trajectory of the topic `~/joint_trajectory`.
    Topic,
}

/// Error code and text for the client of an aborted trajectory.
type Ending = (i32, String);

/// Goal being served; none between motions.
#[derive(Debug, Default)]
pub(super) struct ActiveGoal {
    goal: Option<RunningGoal>,
    /// Who has command, for those who ask meanwhile.
    name: String,
    plan_hash: String,
    /// Why a trajectory is brought to an end, if neither its client wants it nor an alarm.
    ending: Option<Ending>,
    /// Result of a trajectory that ended before its handle arrived.
    early: Option<(GoalEnd, FollowJointTrajectoryResult)>,
    /// A jog comes to rest because its button was released.
    was_let_go: bool,
    /// Turns of spark-out omitted, for each lobe of the plan.
    turns_left_out: Vec<u32>,
    /// The interpolator's own alarm, if it raised one.
    pub(super) alarm: Option<(u16, String)>,
    /// Result of a probe.
    pub(super) probed: Option<ProbeOutcome>,
}

impl ActiveGoal {
    /// Returns whether a goal is being served.
    pub(super) fn is_busy(&self) -> bool {
        self.goal.is_some()
    }

    /// Who has command, and of which plan.
    pub(super) fn names(&self) -> (String, String) {
        (self.name.clone(), self.plan_hash.clone())
    }

    /// A joint trajectory has command.
    pub(super) fn is_trajectory(&self) -> bool {
        matches!(self.goal, Some(RunningGoal::Trajectory(_) | RunningGoal::Arrived | RunningGoal::Topic))
    }

    /// Goal that has command.
    pub(super) fn goal(&self) -> Option<&RunningGoal> {
        self.goal.as_ref()
    }

    /// A trajectory of the topic has command: no client waits for an answer, so its end is logged.
    pub(super) fn is_of_topic(&self) -> bool {
        matches!(self.goal, Some(RunningGoal::Topic))
    }

    /// The goal of a joint trajectory that has command.
    pub(super) fn trajectory(&self) -> Option<&GoalHandle<FollowJointTrajectory>> {
        match &self.goal {
            Some(RunningGoal::Trajectory(goal)) => Some(goal),
            _ => None,
        }
    }

    /// The jog that has command.
    pub(super) fn jog(&self) -> Option<&GoalHandle<Jog>> {
        match &self.goal {
            Some(RunningGoal::Jog(goal)) => Some(goal),
            _ => None,
        }
    }

    /// The jog that has command comes to rest because its button was released.
    pub(super) fn let_go(&mut self) {
        self.was_let_go = true;
    }

    /// Sets the reason reported to the client when the current trajectory ends.
    pub(super) fn end_because(&mut self, reason: &str) {
        if self.is_trajectory() {
            self.ending.get_or_insert((FollowJointTrajectoryResult::INVALID_GOAL, reason.to_owned()));
        }
    }

    /// The trajectory in execution is replaced by another, of a goal or of the topic.
    pub(super) fn yield_to(&mut self, to_a_goal: bool, name: &str, tick: u64) {
        if let Some(RunningGoal::Trajectory(goal)) = self.goal.take() {
            let error_string = format!("{name} replaced it at tick {tick}");
            let error_code = FollowJointTrajectoryResult::INVALID_GOAL;
            goal.abort(FollowJointTrajectoryResult { error_code, error_string });
        }
        let goal = if to_a_goal { RunningGoal::Arrived } else { RunningGoal::Topic };
        self.begin(goal, name.to_owned(), String::new());
    }

    /// The handle of a trajectory that has begun already; one that has not is given back.
    pub(super) fn start_arrived(
        &mut self,
        handle: GoalHandle<FollowJointTrajectory>,
    ) -> Option<GoalHandle<FollowJointTrajectory>> {
        if let Some((end, result)) = self.early.take() {
            end.close(&handle, result);
            return None;
        }
        if matches!(self.goal, Some(RunningGoal::Arrived)) {
            self.name = by(&self.name, handle.client());
            self.goal = Some(RunningGoal::Trajectory(handle));
            return None;
        }
        Some(handle)
    }

    /// Gives command to a goal.
    pub(super) fn begin(&mut self, goal: RunningGoal, name: String, plan_hash: String) {
        *self = Self { goal: Some(goal), name, plan_hash, ..Self::default() };
    }

    /// Turns of a lobe are skipped: its spark-out is over, or its infeed.
    pub(super) fn leave_out(&mut self, lobe: usize, turns: u32) {
        if self.turns_left_out.len() <= lobe {
            self.turns_left_out.resize(lobe + 1, 0);
        }
        self.turns_left_out[lobe] += turns;
    }

    /// The motion cannot start.
    pub(super) fn refuse(&mut self, reason: &str) {
        self.finish(GoalEnd::Aborted, reason);
    }

    /// It was cancelled before it started.
    pub(super) fn withdraw(&mut self, reason: &str) {
        self.finish(GoalEnd::Canceled, reason);
    }

    fn finish(&mut self, end: GoalEnd, reason: &str) {
        let message = format!("not started: {reason}; nothing moved");
        match self.goal.take() {
            Some(RunningGoal::Plan(goal)) => {
                end.close(&goal, ExecutePlanResult { message, ..ExecutePlanResult::default() });
            }
            Some(RunningGoal::Home(goal)) => end.close(&goal, HomeResult { message, ..HomeResult::default() }),
            Some(RunningGoal::Trajectory(goal)) => {
                let error_code = match end {
                    GoalEnd::Canceled => FollowJointTrajectoryResult::SUCCESSFUL,
                    GoalEnd::Succeeded | GoalEnd::Aborted => FollowJointTrajectoryResult::INVALID_GOAL,
                };
                end.close(&goal, FollowJointTrajectoryResult { error_code, error_string: message });
            }
            Some(RunningGoal::Move(goal)) => end.close(&goal, MoveToResult { message, ..MoveToResult::default() }),
            Some(RunningGoal::Probe(goal)) => end.close(&goal, ProbeResult { message, ..ProbeResult::default() }),
            Some(RunningGoal::Jog(goal)) => end.close(&goal, JogResult { message, ..JogResult::default() }),
            Some(RunningGoal::Wheel(responder, _)) => responder.send(&SetBoolResponse { success: false, message }),
            Some(RunningGoal::Topic | RunningGoal::Arrived) | None => {}
        }
    }

    pub(super) fn feedback(&self, tick: u64, status: &InterpolatorStatus) {
        match &self.goal {
            Some(RunningGoal::Plan(goal)) => goal.feedback(&ExecutePlanFeedback {
                tick,
                segment: u32::try_from(status.segment).unwrap_or(u32::MAX),
                phase: status.phase.map_or(0, |phase| phase as u8),
                lobe: status.lobe.and_then(|lobe| i32::try_from(lobe).ok()).unwrap_or(PlanSegment::NO_LOBE),
                turn: status.turn,
                turns: status.turns,
                stock: m_from_mm(status.stock_mm),
                percent: status.percent,
                time_left: status.time_left_s,
            }),
            Some(RunningGoal::Home(goal)) => {
                if let Some((axis, step)) = status.search {
                    goal.feedback(&HomeFeedback { joint: axis.joint().to_owned(), step: step_name(step).to_owned() });
                }
            }
            Some(RunningGoal::Move(goal)) => {
                goal.feedback(&MoveToFeedback { percent: status.percent, time_left: status.time_left_s });
            }
            Some(RunningGoal::Probe(goal)) => {
                let step = status.search.map_or("", |(_, step)| step_name(step)).to_owned();
                goal.feedback(&ProbeFeedback { step, percent: status.percent });
            }
            // Jogs and trajectories report measured values as they arrive.
            Some(
                RunningGoal::Jog(_)
                | RunningGoal::Wheel(..)
                | RunningGoal::Trajectory(_)
                | RunningGoal::Arrived
                | RunningGoal::Topic,
            )
            | None => {}
        }
    }

    /// The motion is over.
    pub(super) fn end(&mut self, ended: &Ended, text: &str, machine: &MachineDescription) {
        let alarm = match ended.outcome {
            MotionOutcome::Failed(number) => number,
            MotionOutcome::Cancelled => self.alarm.as_ref().map_or(0, |(number, _)| *number),
            MotionOutcome::Completed | MotionOutcome::OutOfTolerance(_) => 0,
        };
        let message = match &self.alarm {
            Some((_, reason)) if alarm != 0 => format!("{text}: {reason}"),
            _ => text.to_owned(),
        };
        match self.goal.take() {
            Some(RunningGoal::Plan(goal)) => {
                let (first_tick, last_tick) = (ended.first_tick, ended.last_tick);
                let turns_left_out = std::mem::take(&mut self.turns_left_out);
                let result = ExecutePlanResult { message, alarm, first_tick, last_tick, turns_left_out };
                close(&goal, ended.outcome, result);
            }
            Some(RunningGoal::Home(goal)) => close(&goal, ended.outcome, HomeResult { message, alarm }),
            Some(RunningGoal::Trajectory(goal)) => {
                let (end, result) = self.end_of_trajectory(ended.outcome, message);
                end.close(&goal, result);
            }
            Some(RunningGoal::Arrived) => {
                let early = self.end_of_trajectory(ended.outcome, message);
                *self = Self { early: Some(early), ..Self::default() };
                return;
            }
            Some(RunningGoal::Move(goal)) => {
                let joints = Axis::ALL.iter().map(|axis| axis.joint().to_owned()).collect();
                let at = |axis: &Axis| si_from_counts(machine.axis(*axis).scale, ended.counts[axis.index()]);
                let positions = Axis::ALL.iter().map(at).collect();
                close(&goal, ended.outcome, MoveToResult { message, alarm, joints, positions });
            }
            Some(RunningGoal::Probe(goal)) => {
                let result = ProbeResult { message, alarm, ..ProbeResult::default() };
                goal_end::end_probe(&goal, ended.outcome, self.probed, result, machine);
            }
            Some(RunningGoal::Jog(goal)) => {
                let axis = Axis::from_joint(&goal.goal().joint);
                let at = |axis: Axis| si_from_counts(machine.axis(axis).scale, ended.counts[axis.index()]);
                let result = JogResult { message, alarm, position: axis.map_or(0.0, at) };
                goal_end::end_jog(&goal, ended.outcome, self.was_let_go, result);
            }
            Some(RunningGoal::Wheel(responder, turns)) => goal_end::end_wheel(responder, turns, ended.outcome, message),
            Some(RunningGoal::Topic) | None => {}
        }
        *self = Self::default();
    }

    /// State and result of a joint trajectory that ended, with the codes of `FollowJointTrajectory`.
    fn end_of_trajectory(&self, outcome: MotionOutcome, message: String) -> (GoalEnd, FollowJointTrajectoryResult) {
        type Codes = FollowJointTrajectoryResult;
        let (end, error_code, error_string) = match (&self.ending, outcome) {
            (_, MotionOutcome::Completed) => (GoalEnd::Succeeded, Codes::SUCCESSFUL, message),
            (Some((code, reason)), MotionOutcome::Cancelled) => (GoalEnd::Aborted, *code, reason.clone()),
            (None, MotionOutcome::Cancelled) => (GoalEnd::Canceled, Codes::SUCCESSFUL, message),
            (_, MotionOutcome::OutOfTolerance(broken)) => {
                let code = match broken.stretch {
                    MotionPhase::Path => Codes::PATH_TOLERANCE_VIOLATED,
                    MotionPhase::Goal => Codes::GOAL_TOLERANCE_VIOLATED,
                };
                (GoalEnd::Aborted, code, broken.to_string())
            }
            // The machine's own tolerance of following.
            (_, MotionOutcome::Failed(number)) => match AlarmKind::from_number(number) {
                Some(AlarmKind::FollowingError(_)) => (GoalEnd::Aborted, Codes::PATH_TOLERANCE_VIOLATED, message),
                _ => (GoalEnd::Aborted, Codes::INVALID_GOAL, message),
            },
        };
        (end, FollowJointTrajectoryResult { error_code, error_string })
    }
}

/// Name of the goal with command, and of its node.
pub(super) fn by(what: &str, client: &str) -> String {
    format!("{what} by {client}")
}

/// A trajectory that was accepted and cannot begin.
pub(super) fn refuse_trajectory(goal: &GoalHandle<FollowJointTrajectory>, reason: &str) {
    let (error_code, error_string) = (FollowJointTrajectoryResult::INVALID_GOAL, reason.to_owned());
    goal.abort(FollowJointTrajectoryResult { error_code, error_string });
}

fn step_name(step: SearchStep) -> &'static str {
    match step {
        SearchStep::Search => "search",
        SearchStep::Stop => "stop",
        SearchStep::Return => "return",
        SearchStep::Latch => "latch",
    }
}
