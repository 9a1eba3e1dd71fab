//! The goal that has command of the axes: a plan, a homing, a trajectory.

use super::engine_messages::Ended;
use super::setup_goals;
use crate::convert::{m_from_mm, si_from_counts};
use crate::ros::GoalHandle;
use camwright::interpolator::{Outcome, Probed, SearchStep, Status};
use camwright::machine::description::{Axis, MachineDescription};
use camwright_msgs::camwright_msgs::action::{
    ExecutePlan, ExecutePlanFeedback, ExecutePlanResult, Home, HomeFeedback, HomeResult, MoveTo, MoveToFeedback,
    MoveToResult, Probe, ProbeFeedback, ProbeResult,
};
use camwright_msgs::control_msgs::action::{FollowJointTrajectory, FollowJointTrajectoryResult};

/// A goal in execution.
#[derive(Debug)]
pub(super) enum Goal {
    Plan(GoalHandle<ExecutePlan>),
    Home(GoalHandle<Home>),
    Trajectory(GoalHandle<FollowJointTrajectory>),
    Move(GoalHandle<MoveTo>),
    Probe(GoalHandle<Probe>),
    /// A trajectory of the topic `~/joint_trajectory`.
    Topic,
}

/// What is being served; nothing between motions.
#[derive(Debug, Default)]
pub(super) struct Served {
    goal: Option<Goal>,
    /// Who has command, for those who ask meanwhile.
    name: String,
    plan_hash: String,
    /// Turns of spark-out left out, for each lobe of the plan.
    turns_left_out: Vec<u32>,
    /// The interpolator's own alarm, if it raised one.
    pub(super) alarm: Option<(u16, String)>,
    /// What a probe found.
    pub(super) probed: Option<Probed>,
}

impl Served {
    /// Whether somebody has command.
    pub(super) fn is_busy(&self) -> bool {
        self.goal.is_some()
    }

    /// Who has command, and of which plan.
    pub(super) fn names(&self) -> (String, String) {
        (self.name.clone(), self.plan_hash.clone())
    }

    /// Gives command to a goal.
    pub(super) fn begin(&mut self, goal: Goal, name: String, plan_hash: String) {
        *self = Self { goal: Some(goal), name, plan_hash, ..Self::default() };
    }

    /// Spark-out of a lobe was over before its last turn.
    pub(super) fn leave_out(&mut self, lobe: usize, turns: u32) {
        if self.turns_left_out.len() <= lobe {
            self.turns_left_out.resize(lobe + 1, 0);
        }
        self.turns_left_out[lobe] += turns;
    }

    /// The motion did not start.
    pub(super) fn refuse(&mut self, reason: &str) {
        let message = format!("not started: {reason}; nothing moved");
        match self.goal.take() {
            Some(Goal::Plan(goal)) => {
                goal.abort(ExecutePlanResult { message, ..ExecutePlanResult::default() });
            }
            Some(Goal::Home(goal)) => {
                goal.abort(HomeResult { message, ..HomeResult::default() });
            }
            Some(Goal::Trajectory(goal)) => {
                let error_code = FollowJointTrajectoryResult::INVALID_GOAL;
                goal.abort(FollowJointTrajectoryResult { error_code, error_string: message });
            }
            Some(Goal::Move(goal)) => {
                goal.abort(MoveToResult { message, ..MoveToResult::default() });
            }
            Some(Goal::Probe(goal)) => {
                goal.abort(ProbeResult { message, ..ProbeResult::default() });
            }
            Some(Goal::Topic) | None => {}
        }
    }

    pub(super) fn feedback(&self, tick: u64, status: &Status) {
        match &self.goal {
            Some(Goal::Plan(goal)) => goal.feedback(&ExecutePlanFeedback {
                tick,
                segment: u32::try_from(status.segment).unwrap_or(u32::MAX),
                phase: status.phase.map_or(0, |phase| phase as u8),
                lobe: status.lobe.and_then(|lobe| i32::try_from(lobe).ok()).unwrap_or(-1),
                turn: status.turn,
                turns: status.turns,
                stock: m_from_mm(status.stock_mm),
                percent: status.percent,
                time_left: status.time_left_s,
            }),
            Some(Goal::Home(goal)) => {
                if let Some((axis, step)) = status.search {
                    goal.feedback(&HomeFeedback { joint: axis.joint().to_owned(), step: step_name(step).to_owned() });
                }
            }
            Some(Goal::Move(goal)) => {
                goal.feedback(&MoveToFeedback { percent: status.percent, time_left: status.time_left_s });
            }
            Some(Goal::Probe(goal)) => {
                let step = status.search.map_or("", |(_, step)| step_name(step)).to_owned();
                goal.feedback(&ProbeFeedback { step, percent: status.percent });
            }
            Some(Goal::Trajectory(_) | Goal::Topic) | None => {}
        }
    }

    /// The motion is over.
    pub(super) fn end(&mut self, ended: &Ended, text: &str, machine: &MachineDescription) {
        let alarm = match ended.outcome {
            Outcome::Failed(number) => number,
            Outcome::Completed | Outcome::Cancelled => 0,
        };
        let message = match &self.alarm {
            Some((_, reason)) if alarm != 0 => format!("{text}: {reason}"),
            _ => text.to_owned(),
        };
        let success = ended.outcome == Outcome::Completed;
        match self.goal.take() {
            Some(Goal::Plan(goal)) => {
                let (first_tick, last_tick) = (ended.first_tick, ended.last_tick);
                let turns_left_out = std::mem::take(&mut self.turns_left_out);
                let result = ExecutePlanResult { success, message, alarm, first_tick, last_tick, turns_left_out };
                close(&goal, ended.outcome, result);
            }
            Some(Goal::Home(goal)) => close(&goal, ended.outcome, HomeResult { success, message, alarm }),
            Some(Goal::Trajectory(goal)) => {
                let error_code = match ended.outcome {
                    Outcome::Completed | Outcome::Cancelled => FollowJointTrajectoryResult::SUCCESSFUL,
                    Outcome::Failed(_) => FollowJointTrajectoryResult::PATH_TOLERANCE_VIOLATED,
                };
                close(&goal, ended.outcome, FollowJointTrajectoryResult { error_code, error_string: message });
            }
            Some(Goal::Move(goal)) => {
                let joints = Axis::ALL.iter().map(|axis| axis.joint().to_owned()).collect();
                let at = |axis: &Axis| si_from_counts(machine.axis(*axis).scale, ended.counts[axis.index()]);
                let positions = Axis::ALL.iter().map(at).collect();
                close(&goal, ended.outcome, MoveToResult { success, message, alarm, joints, positions });
            }
            Some(Goal::Probe(goal)) => {
                let result = ProbeResult { success, message, alarm, ..ProbeResult::default() };
                setup_goals::end_probe(&goal, ended.outcome, self.probed, result, machine);
            }
            Some(Goal::Topic) | None => {}
        }
        *self = Self::default();
    }
}

pub(super) fn close<A: camwright_msgs::Action>(goal: &GoalHandle<A>, outcome: Outcome, result: A::Result) {
    // False where the goal has ended already, which then is its end.
    let _first_end = match outcome {
        Outcome::Completed => goal.succeed(result),
        Outcome::Cancelled => goal.canceled(result),
        Outcome::Failed(_) => goal.abort(result),
    };
}

fn step_name(step: SearchStep) -> &'static str {
    match step {
        SearchStep::Search => "search",
        SearchStep::Stop => "stop",
        SearchStep::Return => "return",
        SearchStep::Latch => "latch",
    }
}
