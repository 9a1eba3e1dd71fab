// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! One trajectory takes the place of another while the axes move, without a step in position, velocity or acceleration.

use super::execution::trajectory_pose;
use super::path_time::{PathClock, to_ticks, whole};
use super::pose::AxisPose;
use super::trajectory::TrajectoryStart;
use super::{ExecutionMode, Interpolator, PathFollowing, Prepared, StartError};
use crate::machine::description::Axis;
use crate::machine::setpoint::Setpoint;
use alloc::boxed::Box;

/// Forecast for a future tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StateForecast {
    /// Position and motion of the axes by the trajectory's own time, if nothing disturbs it.
    At(TrajectoryStart),
    /// A trajectory is loaded whose first tick has not been computed yet.
    NotBegun,
    /// No trajectory is executed, or it is over or coming to its end by then.
    Over,
    Held,
}

impl Interpolator {
    /// Forecasts the state of the current trajectory at a future tick.
    #[must_use]
    pub fn foresee(&self, tick: u64) -> StateForecast {
        let Some(motion) = self.motion.as_deref() else { return StateForecast::Over };
        let (clock, trajectory) = match (&self.mode, &motion.trajectory) {
            (ExecutionMode::Trajectory(clock), Some(trajectory)) => (clock, trajectory),
            (ExecutionMode::Starting, Some(_)) => return StateForecast::NotBegun,
            _ => return StateForecast::Over,
        };
        let time = clock.at(tick);
        let ends = self.cancel || self.alarm.is_some() || self.following.broken.is_some();
        if ends || tick <= self.tick || time.tau >= whole(motion.ticks) {
            return StateForecast::Over;
        }
        if self.hold {
            return StateForecast::Held;
        }
        let waits = tick < clock.begins();
        let mut start = TrajectoryStart::default();
        for axis in Axis::ALL {
            let place = axis.index();
            match trajectory.law(axis) {
                Some(law) if !waits => {
                    let sample = law.sample(to_ticks(time.tau) * self.machine.cycle_time_s());
                    start.position[place] = sample.value;
                    start.velocity[place] = sample.first;
                    start.acceleration[place] = sample.second;
                }
                _ => start.position[place] = self.machine.axis(axis).scale.position(self.setpoint.counts[place]),
            }
        }
        StateForecast::At(start)
    }

    /// Setpoint of the trajectory in execution at a tick ahead, without a disturbance.
    #[must_use]
    pub fn planned_at(&self, tick: u64) -> Option<Setpoint> {
        let (ExecutionMode::Trajectory(clock), Some(motion)) = (&self.mode, self.motion.as_deref()) else {
            return None;
        };
        let rest = AxisPose::at_rest(self.setpoint.counts);
        (tick > self.tick).then(|| trajectory_pose(clock, tick, motion, &self.machine, &rest).setpoint())
    }

    /// Puts a trajectory in the place of the one in execution; it begins with the next tick, `tick`, at the rate at which time passes.
    /// The one before it is to be taken as finished.
    ///
    /// # Errors
    /// The start differs from the forecast of [`Interpolator::foresee`] for that tick; the motion is returned.
    pub fn splice(&mut self, tick: u64, motion: Box<Prepared>) -> Result<(), (StartError, Box<Prepared>)> {
        let begins = motion.trajectory.as_ref().map(|trajectory| StateForecast::At(*trajectory.start()));
        let (ExecutionMode::Trajectory(mut clock), true) = (self.mode, begins == Some(self.foresee(tick))) else {
            return Err((StartError::MovesOtherwise, motion));
        };
        if tick < clock.begins() {
            clock = PathClock::starting(tick, self.feed_override);
        } else {
            clock.rewind(clock.at(tick).tau);
        }
        self.mode = ExecutionMode::Trajectory(clock);
        self.motion_began = tick;
        self.following = PathFollowing::default();
        self.finished = self.motion.replace(motion);
        Ok(())
    }
}
