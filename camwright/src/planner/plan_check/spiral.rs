// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A spiral of a plan, walked through forwards.

use super::{PlanCheck, PlanFault, larger, within};
use crate::machine::description::Axis;
use crate::math::differences::largest_exact_derivatives;
use crate::math::hermite::HermiteSpline;
use crate::math::twofold::Twofold;
use crate::math::units::TURN_RAD;
use crate::motion::plan::SpiralSegment;
use crate::motion::speed_plan::{LimitUse, LimitedQuantity};
use crate::motion::spiral_motion::{ExactSpiral, SpiralMotion};
use alloc::vec::Vec;
use core::cell::Cell;

/// Points between two knots at which a spiral is differenced: of its path X and Z, of its law C.
const PARTS: f64 = 8.0;
/// Shortest step (s).
const SHORTEST_STEP_S: f64 = 1e-5;
/// Fewest steps over the whole of a spiral.
const MIN_STEPS: f64 = 65_536.0;
/// Within a stretch the speed of C changes by this factor at most, or between two knots of its law.
const SPEEDS_APART: f64 = 2.0;

/// Part of a law in which a step of the same length passes similar angles.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SpiralRange {
    from_s: f64,
    to_s: f64,
    /// Slowest and fastest of the fastest speeds from knot to knot (rad/s).
    speeds_rad_s: (f64, f64),
    /// From one knot of the law to the next (s), where that is least.
    knots_s: f64,
}

impl SpiralRange {
    fn all(law: &HermiteSpline) -> Vec<Self> {
        let mut stretches: Vec<Self> = Vec::new();
        for pair in law.knots().windows(2) {
            let (from_s, to_s) = (pair[0].at, pair[1].at);
            let middle = law.sample(0.5 * (from_s + to_s)).first;
            let rad_s = pair[0].first.max(pair[1].first).max(middle);
            let knots_s = to_s - from_s;
            match stretches.last_mut() {
                Some(last) if rad_s.max(last.speeds_rad_s.1) <= SPEEDS_APART * rad_s.min(last.speeds_rad_s.0) => {
                    last.to_s = to_s;
                    last.speeds_rad_s = (rad_s.min(last.speeds_rad_s.0), rad_s.max(last.speeds_rad_s.1));
                    last.knots_s = knots_s.min(last.knots_s);
                }
                _ => stretches.push(Self { from_s, to_s, speeds_rad_s: (rad_s, rad_s), knots_s }),
            }
        }
        stretches
    }

    /// Step at which an axis is differenced here (s).
    fn step_s(&self, axis: Axis, motion: &SpiralMotion<'_>) -> f64 {
        if axis == Axis::C {
            return (motion.duration_s() / MIN_STEPS).min(self.knots_s / PARTS).max(SHORTEST_STEP_S);
        }
        let knots = motion.path.knots().len() as f64;
        (motion.angle_rad() / (PARTS * knots * self.speeds_rad_s.1)).max(SHORTEST_STEP_S)
    }
}

/// Maximum number of points at which a pass is checked, some ten seconds of work. The reference turned cam needs 2.3e5.
pub(super) const MAX_POINTS: f64 = 2e7;

impl PlanCheck<'_> {
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
        let stretches = SpiralRange::all(motion.law);
        let points: f64 = Axis::ALL
            .into_iter()
            .flat_map(|axis| stretches.iter().map(move |stretch| (axis, stretch)))
            .map(|(axis, stretch)| (stretch.to_s - stretch.from_s) / stretch.step_s(axis, &motion))
            .sum();
        if points > MAX_POINTS {
            return Err(PlanFault::TooLong { points, duration_s: end_s });
        }
        let mut worst: Option<LimitUse> = None;
        for axis in Axis::ALL {
            let description = self.machine.axis(axis);
            let range = Cell::new((f64::INFINITY, f64::NEG_INFINITY));
            let mut exact = ExactSpiral::new(&motion);
            for stretch in &stretches {
                let step = stretch.step_s(axis, &motion);
                let at = |t: Twofold| {
                    let value = exact.position(axis, t);
                    let (low, high) = range.get();
                    range.set((low.min(value.value()), high.max(value.value())));
                    [value]
                };
                // Differences that reach from one stretch into the next are in both.
                let (from, to) = (stretch.from_s - 3.0 * step, stretch.to_s + 3.0 * step);
                let [extremes] = largest_exact_derivatives(at, Twofold::from(from), Twofold::from(to), step);
                for (quantity, extreme) in LimitedQuantity::ALL.into_iter().zip(extremes) {
                    let allowed = quantity.limit(&description.limits);
                    let angle_rad = motion.law.sample(extreme.at).value;
                    let found =
                        LimitUse { axis, quantity, value: extreme.value, allowed, angle_rad, time_s: extreme.at };
                    worst = larger(worst, found);
                }
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
