// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A straight move in execution: its law, its feed hold and its resumption.
//!
//! A hold is not a scaling of time here but the shortest stop along the line, from whatever velocity and acceleration
//! it has: a move uses its limits, and time scaling would exceed them.

use super::path_time::{ONE, PathClock, to_ticks};
use super::pose::AxisPose;
use crate::machine::description::{AXIS_COUNT, MachineDescription, MotionLimits};
use crate::motion::point_to_point::{JerkLaw, MOVE_SHARE, MoveLaw, solve, stop, whole_ticks};

/// Position on a line, along its coordinate s (0 at the start, 1 at the target), per second.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LinePosition {
    s: f64,
    first: f64,
    second: f64,
}

/// A straight move of the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LineExecution {
    /// Start, distance and limits.
    geometry: MoveLaw,
    /// From `from` to 1, over path time.
    law: JerkLaw,
    from: f64,
    end_ticks: u64,
    clock: PathClock,
    ramp_ticks: u64,
    /// A stop under way or done: law of s from a tick on, and its length.
    stop: Option<(JerkLaw, u64, u64)>,
    cycle_s: f64,
}

impl LineExecution {
    /// A move that begins at rest at a tick.
    pub(crate) fn new(geometry: MoveLaw, tick: u64, rate: i64, cycle_s: f64) -> Self {
        let mut line = Self {
            geometry,
            law: *geometry.law(),
            from: 0.0,
            end_ticks: 0,
            clock: PathClock::starting(tick, rate),
            ramp_ticks: 1,
            stop: None,
            cycle_s,
        };
        line.prepare();
        line
    }

    fn prepare(&mut self) {
        self.end_ticks = whole_ticks(self.law.duration(), self.cycle_s);
        self.ramp_ticks = whole_ticks(override_ramp_s(&self.law, self.geometry.limits()), self.cycle_s).max(1);
    }

    fn along(&self, tick: u64) -> LinePosition {
        if let Some((law, begin, length)) = &self.stop {
            let ticks = tick.saturating_sub(*begin);
            let sample = law.sample(if ticks >= *length { law.duration() } else { ticks as f64 * self.cycle_s });
            return LinePosition { s: sample.value, first: sample.first, second: sample.second };
        }
        if self.is_done(tick) {
            return LinePosition { s: 1.0, first: 0.0, second: 0.0 };
        }
        let time = self.clock.at(tick);
        let sample = self.law.sample(to_ticks(time.tau) * self.cycle_s);
        let (first, second) = time.scale(&sample, self.cycle_s);
        LinePosition { s: self.from + sample.value, first, second }
    }

    /// Axes at a tick.
    pub(crate) fn pose(&self, tick: u64, machine: &MachineDescription) -> AxisPose {
        let along = self.along(tick);
        let mut pose = AxisPose { base: self.geometry.start_counts(), ..AxisPose::default() };
        for axis in 0..AXIS_COUNT {
            let per_unit = machine.axes[axis].scale.counts_per_unit();
            pose.offset[axis] = self.geometry.along(axis, along.s);
            pose.velocity[axis] = self.geometry.along(axis, along.first) / per_unit;
            pose.acceleration[axis] = self.geometry.along(axis, along.second) / per_unit;
        }
        pose
    }

    /// At its target at a tick.
    pub(crate) fn is_done(&self, tick: u64) -> bool {
        self.stop.is_none() && self.clock.at(tick).tau >= super::path_time::whole(self.end_ticks)
    }

    /// Stopped on the way at a tick.
    pub(crate) fn is_stopped(&self, tick: u64) -> bool {
        self.stop.is_some_and(|(_, begin, length)| tick >= begin + length)
    }

    /// A stop is under way or done.
    pub(crate) fn is_stopping(&self) -> bool {
        self.stop.is_some()
    }

    /// Share of the way covered (0..=1).
    pub(crate) fn share(&self, tick: u64) -> f64 {
        self.along(tick).s.clamp(0.0, 1.0)
    }

    /// Begins the shortest stop on the line, continuing the state of a tick.
    pub(crate) fn stop_from(&mut self, tick: u64) {
        if self.stop.is_none() && !self.is_done(tick) {
            let along = self.along(tick);
            let law = stop(along.s, along.first, along.second, self.geometry.limits());
            self.stop = Some((law, tick, whole_ticks(law.duration(), self.cycle_s)));
        }
    }

    /// Goes on from a stop at a tick.
    pub(crate) fn resume(&mut self, tick: u64, rate: i64) {
        let along = self.along(tick);
        self.law = solve(1.0 - along.s, 0.0, 0.0, 0.0, self.geometry.limits());
        self.from = along.s;
        self.stop = None;
        self.clock = PathClock::starting(tick, rate);
        self.prepare();
    }

    /// Turns towards an override.
    pub(crate) fn set_rate(&mut self, tick: u64, rate: i64) {
        if self.stop.is_none() {
            self.clock.retarget(tick, rate, self.ramp_ticks);
        }
    }

    /// Ticks until the stop of this line ends.
    pub(crate) fn stop_ticks_left(&self, tick: u64) -> u64 {
        self.stop.map_or(0, |(_, begin, length)| (begin + length).saturating_sub(tick))
    }
}

/// Time over which the override may change by 1 during a law, so that law and change together keep the limits of the
/// axes, of which the law uses [`MOVE_SHARE`]: with a rate r(t) the acceleration gains ṙ·v and the jerk 3·ṙ·a + r̈·v.
fn override_ramp_s(law: &JerkLaw, limits: &MotionLimits) -> f64 {
    // Largest first and second derivative of the smoothstep.
    const SLOPE: f64 = 1.875;
    const BEND: f64 = 5.7735;
    let spare = (1.0 - MOVE_SHARE) / MOVE_SHARE;
    let (v, a) = law.peaks();
    let by_acceleration = SLOPE * v / (spare * limits.acceleration);
    let (b, c) = (3.0 * SLOPE * a, BEND * v);
    let room = spare * limits.jerk;
    let by_jerk = (b + libm::sqrt(b * b + 4.0 * room * c)) / (2.0 * room);
    by_acceleration.max(by_jerk)
}

/// Rate of a move that takes the wheel to safety, whatever the override.
pub(crate) const FULL: i64 = ONE;
