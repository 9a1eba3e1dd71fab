// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Plausibility of consecutive setpoints, as a drive checks it.

use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use crate::machine::setpoint::Setpoint;

pub use crate::machine::description::DRIVE_HEADROOM;

/// Faults between two setpoints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlausibilityFault {
    /// Faster than the axis (mm/s or rad/s).
    Velocity,
    /// Changes speed faster than the axis (mm/s² or rad/s²).
    Acceleration,
    /// The distance does not fit the speeds (mm or rad).
    Jump,
}

/// A setpoint that cannot follow the one before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImplausibleSetpoint {
    pub axis: Axis,
    pub what: PlausibilityFault,
    /// Value; see [`PlausibilityFault`] for the unit.
    pub value: f64,
    /// Allowed value.
    pub bound: f64,
}

/// Checks setpoints one tick apart against what the drives can do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plausibility {
    counts_per_unit: [f64; AXIS_COUNT],
    velocity: [f64; AXIS_COUNT],
    acceleration: [f64; AXIS_COUNT],
    cycle_time_s: f64,
}

impl Plausibility {
    /// The check for a machine.
    #[must_use]
    pub fn new(description: &MachineDescription) -> Self {
        Self {
            counts_per_unit: core::array::from_fn(|i| description.axes[i].scale.counts_per_unit()),
            velocity: core::array::from_fn(|i| description.axes[i].limits.velocity * DRIVE_HEADROOM),
            acceleration: core::array::from_fn(|i| description.axes[i].limits.acceleration * DRIVE_HEADROOM),
            cycle_time_s: description.cycle_time_s(),
        }
    }

    /// The first misfit between two setpoints one tick apart, in the same coordinates.
    ///
    /// The distance may differ from that of the mean of the two speeds by half the acceleration limit times the tick
    /// squared (a law of bounded acceleration needs a quarter) and two counts (each position is rounded, and its
    /// rounding error diffused into the next).
    #[must_use]
    pub fn misfit(&self, from: &Setpoint, to: &Setpoint) -> Option<ImplausibleSetpoint> {
        let t = self.cycle_time_s;
        for axis in Axis::ALL {
            let i = axis.index();
            let (v0, v1) = (from.velocity[i], to.velocity[i]);
            let distance = to.counts[i].saturating_sub(from.counts[i]) as f64 / self.counts_per_unit[i];
            let change = (v1 - v0).abs() / t;
            let jump = (distance - 0.5 * (v0 + v1) * t).abs();
            let jump_bound = 0.5 * self.acceleration[i] * t * t + 2.0 / self.counts_per_unit[i];
            for (what, value, bound) in [
                (PlausibilityFault::Velocity, v1.abs(), self.velocity[i]),
                (PlausibilityFault::Acceleration, change.max(to.acceleration[i].abs()), self.acceleration[i]),
                (PlausibilityFault::Jump, jump, jump_bound),
            ] {
                // Written so that a number that is not one is a misfit too.
                if !(value <= bound && to.acceleration[i].is_finite()) {
                    return Some(ImplausibleSetpoint { axis, what, value, bound });
                }
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::reference::cam_grinder;

    #[test]
    fn violations_are_distinguished() {
        let check = Plausibility::new(&cam_grinder());
        let rest = Setpoint::default();
        assert_eq!(check.misfit(&rest, &rest), None);
        let mut next = rest;
        next.counts[1] = 10_000;
        assert!(matches!(
            check.misfit(&rest, &next),
            Some(ImplausibleSetpoint { axis: Axis::X, what: PlausibilityFault::Jump, .. })
        ));
        let mut next = rest;
        next.velocity[0] = 1.0;
        assert!(matches!(
            check.misfit(&rest, &next),
            Some(ImplausibleSetpoint { axis: Axis::C, what: PlausibilityFault::Acceleration, .. })
        ));
        next.velocity[0] = f64::NAN;
        assert!(check.misfit(&rest, &next).is_some());
        let mut next = rest;
        next.velocity[2] = -1000.0;
        assert!(matches!(
            check.misfit(&rest, &next),
            Some(ImplausibleSetpoint { axis: Axis::Z, what: PlausibilityFault::Velocity, .. })
        ));
    }
}
