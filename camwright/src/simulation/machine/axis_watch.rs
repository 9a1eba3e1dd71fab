// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Watches the axes: encoder jumps, following error, overtravel.

use super::supervision::Supervision;
use crate::machine::alarm::AlarmKind;
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use crate::simulation::axis::AxisState;
use crate::simulation::sensors::OvertravelSwitches;

/// Jump of an encoder beyond what acceleration explains (counts): rounding of three readings, and noise.
const JUMP_COUNTS: f64 = 20.0;

/// Overtravel switches and the readings of the last ticks.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct AxisWatch {
    overtravel: [OvertravelSwitches; AXIS_COUNT],
    beyond: [bool; AXIS_COUNT],
    /// Wired limit switches that are closed.
    limits: [bool; AXIS_COUNT],
    /// Readings of each axis in the last two ticks (counts, true).
    readings: [[i64; 2]; AXIS_COUNT],
}

snapshot_groups!(AxisWatch { keep_beyond(fields: beyond), keep_readings(fields: readings) } on { overtravel, limits });

impl AxisWatch {
    pub(super) fn new(description: &MachineDescription, axes: &[AxisState; AXIS_COUNT]) -> Self {
        Self {
            overtravel: core::array::from_fn(|i| {
                let (min, max) = description.axes[i].overtravel.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
                OvertravelSwitches::new(min * axes[i].counts_per_unit, max * axes[i].counts_per_unit)
            }),
            beyond: [false; AXIS_COUNT],
            limits: [false; AXIS_COUNT],
            readings: resting_readings(axes),
        }
    }

    /// Takes the axes as resting where they stand.
    pub(super) fn restart(&mut self, axes: &[AxisState; AXIS_COUNT]) {
        self.readings = resting_readings(axes);
    }

    /// Closed overtravel switches of an axis: (min, max).
    pub(super) fn closed(&self, axis: Axis, axes: &[AxisState; AXIS_COUNT]) -> (bool, bool) {
        self.overtravel[axis.index()].closed(axes[axis.index()].true_position())
    }

    /// A wired limit switch of an axis is closed, or not.
    pub(super) fn see_limit(&mut self, axis: Axis, is_closed: bool) {
        self.limits[axis.index()] = is_closed;
    }

    /// Raises the alarms of the axes at the end of a tick.
    pub(super) fn watch(
        &mut self,
        axes: &mut [AxisState; AXIS_COUNT],
        description: &MachineDescription,
        tick: u64,
        supervision: &mut Supervision,
    ) {
        self.watch_encoders(axes, description, tick, supervision);
        watch_following_error(axes, description, tick, supervision);
        self.watch_overtravel(axes, description, tick, supervision);
    }

    /// Compares the acceleration that three readings in a row show with the most that the drive can do.
    fn watch_encoders(
        &mut self,
        axes: &mut [AxisState; AXIS_COUNT],
        description: &MachineDescription,
        tick: u64,
        supervision: &mut Supervision,
    ) {
        let cycle_time_s = description.cycle_time_s();
        for axis in Axis::ALL {
            let i = axis.index();
            let state = &mut axes[i];
            let now = state.reading();
            let [before, last] = self.readings[i];
            self.readings[i] = [last, now];
            let description = &description.axes[i];
            let max = 2.0 * description.maximum_acceleration() * state.counts_per_unit * cycle_time_s * cycle_time_s
                + JUMP_COUNTS
                + 4.0 * (description.drive.encoder_step_counts + description.drive.encoder_noise_counts);
            let jump = (now.saturating_sub(last)).saturating_sub(last.saturating_sub(before)).unsigned_abs() as f64;
            if jump > max {
                let per_unit = state.counts_per_unit;
                // The reading after it is as far off the other way.
                self.readings[i] = [now, now];
                if description.needs_homing {
                    state.lose_home();
                }
                supervision.raise(tick, AlarmKind::EncoderJump(axis), jump / per_unit, max / per_unit);
            }
        }
    }

    /// Raises the alarm when a switch closes. After a reset the axis may move back although it is still on its switch.
    fn watch_overtravel(
        &mut self,
        axes: &[AxisState; AXIS_COUNT],
        description: &MachineDescription,
        tick: u64,
        supervision: &mut Supervision,
    ) {
        for axis in Axis::ALL {
            let i = axis.index();
            let position = axes[i].true_position();
            let homes_on_it = description.axes[i].homing.is_some_and(|homing| homing.ignore_limits);
            let ignored = homes_on_it && !axes[i].homed;
            let wired = self.limits[i].then_some(position);
            // The zero of a real axis that is not homed is where it stood.
            let is_known = axes[i].homed || !axes[i].is_real();
            let passed = self.overtravel[i].beyond(position).filter(|_| is_known);
            let beyond = wired.or(passed).filter(|_| !ignored);
            if let Some(limit) = beyond.filter(|_| !self.beyond[i]) {
                let per_unit = axes[i].counts_per_unit;
                supervision.raise(tick, AlarmKind::Overtravel(axis), position / per_unit, limit / per_unit);
            }
            self.beyond[i] = beyond.is_some();
        }
    }
}

fn resting_readings(axes: &[AxisState; AXIS_COUNT]) -> [[i64; 2]; AXIS_COUNT] {
    core::array::from_fn(|i| [axes[i].reading(); 2])
}

/// `LinuxCNC`'s rule: the limit grows with the speed asked for, but is never below its floor.
fn watch_following_error(
    axes: &[AxisState; AXIS_COUNT],
    description: &MachineDescription,
    tick: u64,
    supervision: &mut Supervision,
) {
    for axis in Axis::ALL {
        let (state, description) = (&axes[axis.index()], &description.axes[axis.index()]);
        let share = state.shown_setpoint_velocity().abs() / description.limits.velocity;
        let limit = (description.max_following_error * share).max(description.min_following_error);
        let error = state.following_error().abs();
        if error > limit {
            supervision.raise(tick, AlarmKind::FollowingError(axis), error, limit);
        }
    }
}
