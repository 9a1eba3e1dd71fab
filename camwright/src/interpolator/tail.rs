// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The stop that ends a chunk of setpoints: what the axes do if nothing more comes.

use super::execution::trajectory_pose;
use super::free_rotation::FreeRotation;
use super::pose::AxisPose;
use super::{ExecutionMode, Interpolator, Purpose};
use crate::machine::setpoint::StopPoint;

impl Interpolator {
    /// Writes the stop within limits that continues the last setpoint, on the path, as sparse points for quintic
    /// interpolation; the last one is at rest. Returns how many points it wrote: 0 if the axes rest already. Points
    /// are at least 2 ticks apart and after the last setpoint; more room in `out` sets them closer, 24 are plenty.
    pub fn stop_tail(&self, out: &mut [StopPoint]) -> usize {
        let now = self.tick;
        let rest = AxisPose::at_rest(self.setpoint.counts);
        // C that turns on between two cuts stops as well.
        let stopping = self.spin.map(|spin| spin.stopping(now));
        let (spin, spin_ticks) = (stopping.map(|(spin, _)| spin), stopping.map(|(_, end)| end.saturating_sub(now)));
        match &self.mode {
            ExecutionMode::Line(line, purpose) => {
                let mut line = *line;
                // The end of a retract is a rest too, and soon; so is that of a move that is nearly there.
                debug_assert!(matches!(purpose, Purpose::Move | Purpose::Seek | Purpose::Return | Purpose::Retract));
                line.stop_from(now);
                let length = line.stop_ticks_left(now).max(spin_ticks.unwrap_or(0));
                self.write(out, length, spin, |tick| line.pose(tick, &self.machine))
            }
            ExecutionMode::Cut(cut) => {
                let Some(curves) = self.motion.as_deref().and_then(|motion| self.curves(motion)) else { return 0 };
                let (cut, end) = cut.stopping(now);
                self.write(out, end - now, None, |tick| cut.pose(tick, &curves, &self.machine, &rest))
            }
            ExecutionMode::Spiral(spiral) => {
                let Some(motion) = self.motion.as_deref() else { return 0 };
                let Some(curves) = self.spiral_motion(motion) else { return 0 };
                let (spiral, end) = spiral.stopping(now);
                self.write(out, end - now, None, |tick| spiral.pose(tick, &curves, &self.machine))
            }
            ExecutionMode::Trajectory(clock) => {
                let Some(motion) = self.motion.as_deref() else { return 0 };
                let (clock, end) = clock.stopping(now, motion.stop_ticks);
                self.write(out, end - now, None, |tick| trajectory_pose(&clock, tick, motion, &self.machine, &rest))
            }
            _ => spin_ticks.map_or(0, |length| self.write(out, length, spin, |_| rest)),
        }
    }

    fn write(
        &self,
        out: &mut [StopPoint],
        length: u64,
        spin: Option<FreeRotation>,
        pose: impl Fn(u64) -> AxisPose,
    ) -> usize {
        let (Ok(room), Ok(length)) = (u32::try_from(out.len()), u32::try_from(length)) else { return 0 };
        if room == 0 || length == 0 {
            return 0;
        }
        // The first point after the last dense one must not look like another dense one.
        let length = length.max(2);
        let stride = length.div_ceil(room).max(2);
        let mut written = 0;
        for (point, index) in out.iter_mut().zip(1_u32..) {
            let ticks = (index * stride).min(length);
            let tick = self.tick + u64::from(ticks);
            *point = pose(tick).stop_point(ticks, &self.machine);
            if let Some(spin) = &spin {
                spin.put_point(tick, &self.machine, point);
            }
            written += 1;
            if ticks == length {
                point.velocity = Default::default();
                point.acceleration = Default::default();
                break;
            }
        }
        written
    }
}
