//! A spiral of a plan, walked through forwards.

use super::{PlanFault, Walk, larger, within};
use crate::machine::description::Axis;
use crate::numeric::differences::largest_derivatives;
use crate::plan::SpiralSegment;
use crate::speed_plan::{LimitUse, Quantity};
use crate::units::TURN_RAD;
use core::cell::Cell;

/// Points between two knots of a spiral's path at which X and Z are differenced.
const PARTS: f64 = 8.0;
/// Shortest step (s): the rounding of a metre in a third difference is 2e-12 mm over its cube.
const SHORTEST_STEP_S: f64 = 1e-5;
/// Share of the limit of C's jerk that the rounding of its angle may show in a third difference.
const ROUNDING_SHARE: f64 = 1e-7;

impl Walk<'_> {
    pub(super) fn spiral(&mut self, spiral: &SpiralSegment) -> Result<LimitUse, PlanFault> {
        let motion = self.plan.motion_of_spiral(spiral).ok_or(PlanFault::UnknownSpline)?;
        let counts = |axis: Axis, at: f64| self.machine.axis(axis).scale.counts(at);
        let turn_counts = counts(Axis::C, TURN_RAD);
        let c_at = self.at[Axis::C.index()];
        if (c_at - spiral.start_counts).rem_euclid(turn_counts) != 0 {
            let (begins, ended) = (spiral.start_counts, c_at.rem_euclid(turn_counts));
            return Err(PlanFault::Jump { axis: Axis::C, begins, ended });
        }
        let (start, end_s) = (motion.at(0.0), motion.duration_s());
        for axis in [Axis::X, Axis::Z] {
            let (begins, ended) = (counts(axis, start[axis.index()].value), self.at[axis.index()]);
            if begins != ended {
                return Err(PlanFault::Jump { axis, begins, ended });
            }
        }
        let knots = motion.law.knots();
        let (first, last) = (knots[0], knots[knots.len() - 1]);
        for end in [first, last] {
            if end.first != 0.0 || end.second != 0.0 {
                return Err(PlanFault::BadSpeed { speed_rad_s: end.first, time_s: end.at });
            }
        }
        let mut worst: Option<LimitUse> = None;
        for axis in Axis::ALL {
            let description = self.machine.axis(axis);
            #[allow(clippy::cast_precision_loss, reason = "counts of knots are far below 2^53")]
            let step = if axis == Axis::C {
                // 8 ε |c| / step³ in the third difference.
                let rounding = 8.0 * f64::EPSILON * last.value.abs() / (ROUNDING_SHARE * description.limits.jerk);
                libm::cbrt(rounding).max(end_s / 65_536.0)
            } else {
                (end_s / (PARTS * motion.path.knots().len() as f64)).max(SHORTEST_STEP_S)
            };
            let range = Cell::new((f64::INFINITY, f64::NEG_INFINITY));
            let at = |t: f64| {
                let value = motion.at(t.clamp(0.0, end_s))[axis.index()].value;
                let (low, high) = range.get();
                range.set((low.min(value), high.max(value)));
                value
            };
            let extremes = largest_derivatives(at, -3.0 * step, end_s + 3.0 * step, step);
            for (quantity, extreme) in Quantity::ALL.into_iter().zip(extremes) {
                let allowed = quantity.limit(&description.limits);
                let angle_rad = motion.law.sample(extreme.at).value;
                let found = LimitUse { axis, quantity, value: extreme.value, allowed, angle_rad, time_s: extreme.at };
                worst = larger(worst, found);
            }
            if axis != Axis::C {
                let (low, high) = range.get();
                self.soft_limit(axis, low)?;
                self.soft_limit(axis, high)?;
            }
        }
        let end = motion.at(end_s);
        self.at[Axis::C.index()] += counts(Axis::C, last.value);
        for axis in [Axis::X, Axis::Z] {
            self.at[axis.index()] = counts(axis, end[axis.index()].value);
        }
        within(worst)?.ok_or(PlanFault::UnknownSpline)
    }
}
