//! The fastest turn without limits of jerk and of X acceleration: every plan is slower, so its time is a lower bound, and
//! where it is slow a plan needs its knots.

use super::square_speed::{SpeedKnots, to_f64};
use crate::machine::description::MotionLimits;
use crate::math::units::{TURN_RAD, wrap_turn};
use alloc::vec::Vec;

/// Fewest and most knots of a plan.
const MIN_KNOTS: usize = 64;
const MAX_KNOTS: usize = 6000;

/// z = Ċ² on a uniform grid: below its bound, rising and falling by the acceleration of C at most.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Envelope {
    square: Vec<f64>,
    min_s: f64,
}

impl Envelope {
    /// From 1/bound² at equal angles from 0 on, all positive and finite.
    pub(super) fn new(per_bound: &[f64], c: &MotionLimits) -> Self {
        let count = per_bound.len();
        let d = spacing(count);
        let rise = 2.0 * c.acceleration * d;
        let mut square: Vec<f64> = per_bound.iter().map(|per| 1.0 / per).collect();
        // Twice round, so that what is slow at the end of the turn is felt at its beginning, and the other way about.
        for _ in 0..2 {
            let mut before = square[count - 1];
            for z in &mut square {
                before = z.min(before + rise);
                *z = before;
            }
        }
        for _ in 0..2 {
            let mut after = square[0];
            for z in square.iter_mut().rev() {
                after = z.min(after + rise);
                *z = after;
            }
        }
        // Between two points z is below both tents; a straight z takes 2d/(v0 + v1), which from a to the peak, on the rise, is
        // 2d (√peak − √a)/rise.
        let mut sum = 0.0;
        let mut a = square[count - 1];
        for &b in &square {
            sum += libm::sqrt(0.5 * (a + b + rise)) - libm::sqrt(b);
            a = b;
        }
        Self { square, min_s: 4.0 * d / rise * sum }
    }

    /// A time that no plan goes below (s).
    pub(super) fn minimum_s(&self) -> f64 {
        self.min_s
    }

    /// z at an angle.
    pub(super) fn square_at(&self, angle_rad: f64) -> f64 {
        let n = self.square.len();
        let x = wrap_turn(angle_rad) / spacing(n);
        #[allow(clippy::cast_possible_truncation, reason = "an angle within the turn")]
        let i = (x as usize).min(n - 1);
        let u = x - to_f64(i);
        self.square[i] * (1.0 - u) + self.square[(i + 1) % n] * u
    }

    /// Knots that take equal times at this speed, and are never farther apart than `widest_rad`.
    pub(super) fn knots(&self, step_s: f64, widest_rad: f64) -> SpeedKnots {
        let count = self.square.len();
        let d = spacing(count);
        let weight = |z: f64| 1.0 / (step_s * libm::sqrt(z)) + 1.0 / widest_rad;
        let mut sums = Vec::with_capacity(count + 1);
        let mut sum = 0.0;
        let mut left = weight(self.square[0]);
        for i in 0..count {
            sums.push(sum);
            let right = weight(self.square[if i + 1 < count { i + 1 } else { 0 }]);
            sum += 0.5 * d * (left + right);
            left = right;
        }
        sums.push(sum);
        #[allow(clippy::cast_possible_truncation, reason = "some hundred knots")]
        let n = (libm::ceil(sum) as usize).clamp(MIN_KNOTS, MAX_KNOTS);
        let mut at = Vec::with_capacity(n);
        let mut cell = 0;
        for k in 0..n {
            let wanted = sum * to_f64(k) / to_f64(n);
            while cell + 1 < count && sums[cell + 1] <= wanted {
                cell += 1;
            }
            let within = (wanted - sums[cell]) / (sums[cell + 1] - sums[cell]);
            at.push((to_f64(cell) + within) * d);
        }
        SpeedKnots::new(at)
    }
}

fn spacing(count: usize) -> f64 {
    TURN_RAD / to_f64(count)
}
