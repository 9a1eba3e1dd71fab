// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A spiral in execution: all axes by one path time, which a hold, a cancel and an override slow down.

use super::path_time::{PathClock, to_ticks, whole};
use super::pose::AxisPose;
use super::prepared::Prepared;
use super::{ExecutionMode, Interpolator, InterpolatorAlarm, StepOutput};
use crate::machine::description::{Axis, MachineDescription};
use crate::math::units::TURN_RAD;
use crate::motion::plan::{Segment, SegmentKind, SpiralSegment};
use crate::motion::spiral_motion::SpiralMotion;

/// A spiral in execution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spiral {
    pub(super) clock: PathClock,
    /// C where it began (counts).
    start_counts: i64,
    /// Its length, and that of a stop on the path (ticks).
    ticks: u64,
    stop_ticks: u64,
}

impl Spiral {
    /// Axes at a tick.
    pub(super) fn pose(&self, tick: u64, motion: &SpiralMotion<'_>, machine: &MachineDescription) -> AxisPose {
        let (time, cycle_s) = (self.clock.at(tick), machine.cycle_time_s());
        // At the end exactly there, though the last tick lies up to a cycle after it.
        let over = time.tau >= whole(self.ticks);
        let at_s = if over { motion.duration_s() + cycle_s } else { to_ticks(time.tau) * cycle_s };
        let mut pose = AxisPose::default();
        for (axis, sample) in Axis::ALL.into_iter().zip(motion.at(at_s)) {
            pose.set_axis(axis, if axis == Axis::C { self.start_counts } else { 0 }, &sample, &time, machine);
        }
        pose
    }

    /// The spiral that stops on its path as soon as it can, and the tick of the stop.
    pub(super) fn stopping(&self, tick: u64) -> (Self, u64) {
        let (clock, end) = self.clock.stopping(tick, self.stop_ticks);
        (Self { clock, ..*self }, end)
    }

    /// Turns of C since it began.
    pub(super) fn turns_done(&self, tick: u64, motion: &SpiralMotion<'_>, cycle_s: f64) -> f64 {
        motion.law.sample(to_ticks(self.clock.at(tick).tau) * cycle_s).value / TURN_RAD
    }
}

impl Interpolator {
    /// The curves of the spiral in execution.
    pub(super) fn spiral_motion<'a>(&self, motion: &'a Prepared) -> Option<SpiralMotion<'a>> {
        match &motion.plan.segments.get(self.segment)?.kind {
            SegmentKind::Spiral(spiral) => motion.plan.motion_of_spiral(spiral),
            _ => None,
        }
    }

    pub(super) fn enter_spiral(
        &mut self,
        spiral: &SpiralSegment,
        segment: &Segment,
        tick: u64,
        motion: &Prepared,
    ) -> Result<(), InterpolatorAlarm> {
        let Some(curves) = motion.plan.motion_of_spiral(spiral) else {
            return Err(InterpolatorAlarm::BadSegment { segment: self.segment });
        };
        self.must_be_homed(&Axis::ALL)?;
        let begins = curves.at(0.0);
        for axis in [Axis::X, Axis::Z] {
            self.must_stand_at(axis, begins[axis.index()].value)?;
        }
        let spiral = Spiral {
            clock: PathClock::starting(tick, self.feed_override),
            start_counts: self.c_at_start(spiral.start_counts)?,
            ticks: segment.ticks,
            stop_ticks: segment.stop_ticks,
        };
        self.setpoint = spiral.pose(tick, &curves, &self.machine).setpoint();
        self.mode = ExecutionMode::Spiral(spiral);
        Ok(())
    }

    pub(super) fn advance_spiral(&mut self, mut spiral: Spiral, tick: u64, motion: &Prepared, out: &mut StepOutput) {
        let Some(curves) = self.spiral_motion(motion) else {
            self.fail(InterpolatorAlarm::BadSegment { segment: self.segment }, out);
            return;
        };
        let stopping = self.hold || self.cancel || self.alarm.is_some();
        let rate = if stopping { 0 } else { self.feed_override };
        spiral.clock.retarget(tick.saturating_sub(1), rate, spiral.stop_ticks);
        self.setpoint = spiral.pose(tick, &curves, &self.machine).setpoint();
        self.mode = ExecutionMode::Spiral(spiral);
        if spiral.clock.at(tick).tau >= whole(spiral.ticks) {
            self.begin(self.segment + 1, tick, motion, out);
        } else if spiral.clock.is_stopped(tick) {
            self.rest();
            self.leaves_at_rest(tick, motion, out);
        }
    }
}
