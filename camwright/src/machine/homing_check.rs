// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Check of a homing against its axis.

use crate::machine::description::{AxisDescription, AxisScale};
use crate::machine::description_error::DescriptionError;
use crate::machine::homing::{Homing, HomingKind};

impl Homing {
    /// Overshoot behind the edge until the axis stops to search the mark (mm).
    fn overshoot_mm(&self, axis: &AxisDescription, delay_s: f64) -> f64 {
        let v = self.latch_mm_s.abs();
        // A tenth of a second for the servo, and the stop with half the acceleration.
        v * (2.0 * delay_s + 0.1) + v * v / axis.limits.acceleration + v * axis.limits.acceleration / axis.limits.jerk
    }

    /// Checks that it fits its axis. `delay_s` is the feedback delay.
    pub(super) fn validate(
        &self,
        axis: &AxisDescription,
        hysteresis_mm: f64,
        delay_s: f64,
    ) -> Result<(), DescriptionError> {
        let joint = axis.axis.joint();
        let refuse = |what: &'static str| Err(DescriptionError::Homing { joint, what });
        let outside = |what: &'static str, value: f64, (low, high): (f64, f64)| {
            Err(DescriptionError::HomingOutside { joint, what, value, low, high })
        };
        if !matches!(axis.scale, AxisScale::Linear { .. }) {
            return refuse("only slides have a home switch; c_axis is homed on its origin detector");
        }
        let numbers = [self.search_mm_s, self.latch_mm_s, self.home_mm, self.switch_mm, self.offset_mm.unwrap_or(0.0)];
        if !numbers.iter().all(|number| number.is_finite()) {
            return refuse("its numbers must be finite");
        }
        let Some(kind) = self.kind() else {
            return refuse(
                "search and latch velocity and use_index must be 0, 0, no (immediate), 0, not 0, yes (index only), not 0, not 0, \
                 no (switch only) or not 0, not 0, yes (switch and index)",
            );
        };
        let fastest = axis.limits.velocity;
        for (what, value) in [("search velocity", self.search_mm_s), ("latch velocity", self.latch_mm_s)] {
            if value.abs() > fastest {
                return outside(what, value, (-fastest, fastest));
            }
        }
        if self.final_mm_s <= 0.0 {
            return refuse("its final velocity must be positive");
        }
        if self.final_mm_s > fastest {
            return outside("final velocity", self.final_mm_s, (0.0, fastest));
        }
        if let Some(range) = axis.soft_limits.filter(|(low, high)| !(*low..=*high).contains(&self.home_mm)) {
            return outside("home position", self.home_mm, range);
        }
        if self.use_index && !(self.index_pitch_mm > 0.0 && self.index_pitch_mm.is_finite()) {
            return refuse("an index needs a positive pitch of its marks");
        }
        if kind == HomingKind::IndexOnly && self.offset_mm.is_none() {
            return refuse("index only needs an offset: which mark comes first depends on where the axis stands");
        }
        if kind.has_switch()
            && !self.ignore_limits
            && axis.overtravel.is_some_and(|(low, high)| self.switch_mm <= low || self.switch_mm >= high)
        {
            return refuse("its switch lies beyond the hard limit switch; without ignore_limits it is never reached");
        }
        if kind == HomingKind::SwitchAndIndex {
            let ahead_mm = (self.switch_index_mm(hysteresis_mm) - self.edge_mm(hysteresis_mm)).abs();
            let overshoot_mm = self.overshoot_mm(axis, delay_s);
            if ahead_mm < overshoot_mm || self.index_pitch_mm - ahead_mm < overshoot_mm {
                return refuse("its index mark lies too near the edge of the switch: it could be the next one");
            }
        }
        Ok(())
    }

    fn switch_index_mm(&self, hysteresis_mm: f64) -> f64 {
        Self { offset_mm: None, ..*self }.offset_mm(hysteresis_mm)
    }
}
