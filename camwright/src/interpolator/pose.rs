// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Position of the axes between counts: computed by the motions and rounded to setpoints.

use super::path_time::PathTime;
use crate::machine::description::{AXIS_COUNT, Axis, AxisScale, MachineDescription};
use crate::machine::setpoint::{Setpoint, StopPoint};
use crate::math::hermite::Sample;
use crate::math::units::TURN_RAD;

/// Positions as whole counts plus an offset in counts, velocities and accelerations in mm or rad.
///
/// The whole counts keep a long journey of C exact, where a float alone would lose digits turn by turn.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct AxisPose {
    pub(crate) base: [i64; AXIS_COUNT],
    pub(crate) offset: [f64; AXIS_COUNT],
    pub(crate) velocity: [f64; AXIS_COUNT],
    pub(crate) acceleration: [f64; AXIS_COUNT],
}

impl AxisPose {
    /// At rest on counts.
    pub(crate) fn at_rest(counts: [i64; AXIS_COUNT]) -> Self {
        Self { base: counts, ..Self::default() }
    }

    /// Puts an axis `law` after a whole count: a law over path time (mm or rad over s), which passes as `time` says.
    pub(super) fn set_axis(
        &mut self,
        axis: Axis,
        base: i64,
        law: &Sample,
        time: &PathTime,
        machine: &MachineDescription,
    ) {
        let i = axis.index();
        self.base[i] = base;
        self.offset[i] = in_counts(machine.axis(axis).scale, law.value);
        (self.velocity[i], self.acceleration[i]) = time.scale(law, machine.cycle_time_s());
    }

    /// Rounded to counts. Each position is rounded by itself, from the absolute path: so the error never adds up, which
    /// is what a pulse distribution that carries its remainder along achieves.
    #[allow(clippy::cast_possible_truncation, reason = "travel in counts is below 2^53")]
    pub(crate) fn setpoint(&self) -> Setpoint {
        Setpoint {
            counts: core::array::from_fn(|axis| self.base[axis].saturating_add(libm::round(self.offset[axis]) as i64)),
            velocity: self.velocity,
            acceleration: self.acceleration,
        }
    }

    /// Converts the pose to a point of a stop, not rounded.
    pub(crate) fn stop_point(&self, ticks: u32, machine: &MachineDescription) -> StopPoint {
        let position = |axis: usize| {
            let scale = machine.axes[axis].scale;
            scale.position(self.base[axis]) + self.offset[axis] / scale.counts_per_unit()
        };
        StopPoint {
            ticks,
            position: core::array::from_fn(position),
            velocity: self.velocity,
            acceleration: self.acceleration,
        }
    }
}

/// A position (mm or rad) in counts, not rounded; whole turns are whole counts.
pub(crate) fn in_counts(scale: AxisScale, position: f64) -> f64 {
    match scale {
        AxisScale::Linear { counts_per_mm } => position * counts_per_mm as f64,
        AxisScale::Rotary { counts_per_turn } => position / TURN_RAD * counts_per_turn as f64,
    }
}
