// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A trajectory that arrives while another is executed: it takes the other's place without a step, or begins when the other is over.
//!
//! ```text
//! goal ─► Foresee ─► engine ─► where the axes will be at tick S ─► the new trajectory from there ─► Splice ─► engine, at S
//! ```
//! Only then is the goal accepted and the one before it ended: a goal that cannot be followed has no effect.

use super::wanted::RequestedTrajectory;
use crate::engine_messages::{MotionForecast, PreparedMotion, ToEngine};
use camwright::machine::description::MachineDescription;
use camwright_files::convert::time::TickClock;
use camwright_ros::GoalDecider;

#[derive(Debug)]
pub(crate) struct TrajectoryArrival {
    pub(super) wanted: RequestedTrajectory,
    /// Who decides on the goal; `None` for a trajectory of the topic.
    pub(super) decider: Option<GoalDecider>,
    /// Name of the goal, for clients that ask for the holder of command.
    pub(super) name: String,
}

/// Next step of an arrival once the engine has looked ahead.
#[derive(Debug)]
pub(crate) enum ArrivalStep {
    /// Sends a message to the engine; the arrival continues to wait.
    Send(ToEngine),
    /// It waits until the trajectory before it is over.
    Wait,
    /// Refuses the trajectory with a reason; the engine drops the arrival.
    Refuse(String),
}

impl TrajectoryArrival {
    /// Next step, after the engine has forecast the position of the axes.
    pub(crate) fn next(
        &self,
        foresight: &MotionForecast,
        clock: TickClock,
        machine: &MachineDescription,
    ) -> ArrivalStep {
        match foresight {
            MotionForecast::Over => ArrivalStep::Wait,
            MotionForecast::Disturbed => {
                ArrivalStep::Refuse("the trajectory in execution is held; release the hold or cancel it first".into())
            }
            MotionForecast::At(tick, start) => {
                let record = self.wanted.record(*tick, clock, start, None);
                match record.and_then(|record| PreparedMotion::new(record, None, machine)) {
                    Ok(made) => ArrivalStep::Send(ToEngine::Splice(made)),
                    Err(reason) => ArrivalStep::Refuse(reason),
                }
            }
        }
    }

    /// First tick that it may take the other's place at, if it can at `soonest`.
    pub(super) fn begins(&self, soonest: u64, clock: TickClock) -> u64 {
        self.wanted.begins(soonest, clock)
    }

    /// Refuses it. Returns the reason for the log, when it has no client that could be answered.
    pub(crate) fn refuse(self, reason: &str) -> Option<String> {
        match self.decider {
            Some(decider) => {
                decider.reject(reason);
                None
            }
            None => Some(reason.to_owned()),
        }
    }
}
