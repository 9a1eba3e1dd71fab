// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Path following of the axes: setpoints of each tick, compared with the encoder readings.
//!
//! Like an edge, what is found at tick k comes into sight at tick k + D, so that it changes nothing but by its tick.

use super::path_time::to_ticks;
use super::tolerance::{FollowingState, MotionPhase, ToleranceViolation, violation};
use super::trajectory::Trajectory;
use super::{ExecutionMode, Interpolator, PendingFeedback, Prepared};
use crate::machine::description::MachineDescription;
use crate::machine::setpoint::{Measured, Setpoint};
use alloc::vec::Vec;

/// Setpoints of a tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Reported {
    tick: u64,
    setpoint: Setpoint,
    /// Path time of a trajectory.
    tau: i64,
}

/// The setpoints that may still be measured.
#[derive(Debug, Clone)]
pub(super) struct SetpointHistory {
    reported: Vec<Reported>,
}

impl SetpointHistory {
    /// Room for what can be between a setpoint and the news of how it was followed: setpoints run D ahead, and D for the way back.
    pub(super) fn new(machine: &MachineDescription) -> Self {
        let room = 2 * machine.feedback_delay_ticks as usize + 64;
        Self { reported: alloc::vec![Reported { tick: u64::MAX, ..Reported::default() }; room] }
    }

    fn place(&self, tick: u64) -> usize {
        // Less than the length, which is far below 2^32.
        usize::try_from(tick % self.reported.len() as u64).unwrap_or(0)
    }

    fn report(&mut self, reported: Reported) {
        let place = self.place(reported.tick);
        self.reported[place] = reported;
    }

    fn at(&self, tick: u64) -> Option<&Reported> {
        self.reported.get(self.place(tick)).filter(|reported| reported.tick == tick)
    }
}

/// State of the path following of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct PathFollowing {
    /// Its last tick, once it is over.
    ended: Option<u64>,
    /// Tolerances need no more looking at: they were broken, or kept at the end.
    is_judged: bool,
    /// The tolerance that was broken is in sight.
    pub(super) broken: Option<ToleranceViolation>,
    /// That all axes are inside their goal tolerances is in sight.
    pub(super) has_settled: bool,
}

impl Interpolator {
    /// The tick's setpoint, for when it will have been measured.
    pub(super) fn remember_setpoint(&mut self, tick: u64) {
        let tau = match &self.mode {
            ExecutionMode::Trajectory(clock) => clock.at(tick).tau,
            _ => 0,
        };
        self.history.report(Reported { tick, setpoint: self.setpoint, tau });
    }

    /// The trajectory is at its end with this tick.
    pub(super) fn end_trajectory(&mut self, tick: u64) {
        self.following.ended = Some(tick);
    }

    /// Setpoints of a recent tick.
    #[must_use]
    pub fn desired_at(&self, tick: u64) -> Option<&Setpoint> {
        self.history.at(tick).map(|reported| &reported.setpoint)
    }

    /// Takes what the encoders read, in the order of ticks. It comes into sight D ticks after its own; every measurement of tick
    /// k − D must have been given before the step of tick k.
    pub fn measured(&mut self, measured: &Measured) {
        let Some(trajectory) = self.motion.as_deref().and_then(|motion| motion.trajectory.as_ref()) else { return };
        if self.following.is_judged || measured.tick < self.motion_began {
            return;
        }
        let Some(reported) = self.history.at(measured.tick) else { return };
        let Some(verdict) = self.judge(trajectory, reported, measured) else { return };
        self.following.is_judged = self.remember(verdict);
    }

    fn judge(&self, trajectory: &Trajectory, reported: &Reported, measured: &Measured) -> Option<PendingFeedback> {
        let error = |axis: usize| {
            let scale = self.machine.axes[axis].scale;
            FollowingState {
                position: scale.position(reported.setpoint.counts[axis] - measured.counts[axis]),
                velocity: reported.setpoint.velocity[axis] - measured.velocity[axis],
                acceleration: 0.0,
            }
        };
        let (tick, tolerances) = (measured.tick, trajectory.tolerances());
        let (errors, cycle_s) = (core::array::from_fn(error), self.machine.cycle_time_s());
        match self.following.ended.filter(|ended| tick >= *ended) {
            None => {
                let time_s = to_ticks(reported.tau) * cycle_s;
                let broken = violation(&tolerances.path, &errors, MotionPhase::Path, time_s);
                broken.map(|broken| PendingFeedback::OutOfTolerance(tick, broken))
            }
            Some(ended) => {
                let late_s = (tick - ended) as f64 * cycle_s;
                match violation(&tolerances.goal, &errors, MotionPhase::Goal, late_s) {
                    None => Some(PendingFeedback::Settled(tick)),
                    Some(broken) => {
                        let is_over = tolerances.goal_time_ticks.is_some_and(|max| tick - ended > max);
                        is_over.then_some(PendingFeedback::OutOfTolerance(tick, broken))
                    }
                }
            }
        }
    }

    /// Every axis is known to be within the goal tolerances of a trajectory; where there are none they are kept.
    pub(super) fn is_at_goal(&self, motion: &Prepared) -> bool {
        let waits = motion.trajectory.as_ref().is_some_and(|trajectory| trajectory.tolerances().has_goal());
        !waits || self.following.has_settled
    }
}
