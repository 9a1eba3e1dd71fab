// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The fastest turn without limits of jerk and of X acceleration: every plan is slower, so its time is a lower bound, and
//! where it is slow a plan needs its knots.

use super::square_speed::{SpeedKnots, to_f64};
use super::turn_request::TurnRequest;
use crate::machine::description::MotionLimits;
use crate::math::lanes::LANES;
use crate::math::units::{TURN_RAD, wrap_turn};
use alloc::vec::Vec;

/// Fewest and most knots of a plan.
const MIN_KNOTS: usize = 64;
const MAX_KNOTS: usize = 6000;

/// Points at which the density of knots is looked at, at most.
const DENSITY_POINTS: usize = 1800;

/// Blocks of a turn that are quiet or not.
const BLOCKS: usize = 240;

/// Largest relative change of z around a quiet block.
const QUIET_CHANGE: f64 = 2e-3;

/// Largest use of the limits of X in one.
const QUIET_USE: f64 = 0.5;

/// Spacing of knots in quiet blocks, in steps.
const QUIET_STEPS: f64 = 4.0;

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
        for is_again in [false, true] {
            let before = square[count - 1];
            limit_rise(square.iter_mut(), before, rise, is_again);
        }
        for is_again in [false, true] {
            let after = square[0];
            limit_rise(square.iter_mut().rev(), after, rise, is_again);
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

    /// Blocks around which z is constant and the limits of X are far, as on a base circle.
    fn quiet_blocks(&self, request: &TurnRequest<'_>) -> Vec<bool> {
        let (count, c) = (self.square.len(), &request.c);
        let block_rad = spacing(BLOCKS);
        let ends = |block: usize| (block * count / BLOCKS, (block + 1) * count / BLOCKS);
        let ranges: Vec<(f64, f64)> = (0..BLOCKS)
            .map(|block| {
                let (from, to) = ends(block);
                let z = self.square[from..to].iter();
                z.fold((f64::INFINITY, 0.0), |(low, high), z| (f64::min(low, *z), f64::max(high, *z)))
            })
            .collect();
        let per_rad = request.path.per_rad();
        (0..BLOCKS)
            .map(|block| {
                let speed = libm::sqrt(ranges[block].1);
                let reach_rad = 2.0 * speed * c.acceleration / c.jerk;
                #[allow(clippy::cast_possible_truncation, reason = "some blocks")]
                let reach = (libm::ceil(reach_rad / block_rad).min(to_f64(BLOCKS / 2))) as usize;
                let around = (0..=2 * reach).map(|k| ranges[(block + BLOCKS + k - reach) % BLOCKS]);
                let (low, high) =
                    around.fold((f64::INFINITY, 0.0), |(low, high), (a, b)| (f64::min(low, a), f64::max(high, b)));
                if high > low * (1.0 + QUIET_CHANGE) {
                    return false;
                }
                #[allow(clippy::cast_possible_truncation, reason = "some ten thousand knots")]
                let knot = |block: usize| (to_f64(block) * block_rad * per_rad) as usize;
                let mut x = request.path.largest_derivatives(knot(block), knot(block + 1) + 1);
                x[0] += request.infeed_slope_mm_rad.abs();
                request.largest_x_use(x, high) <= QUIET_USE
            })
            .collect()
    }

    /// Knots that take equal times at this speed and are never farther apart than `widest_rad`; where nothing acts, `QUIET_STEPS` times
    /// as much.
    pub(super) fn knots(&self, request: &TurnRequest<'_>, step_s: f64, widest_rad: f64) -> SpeedKnots {
        let count = self.square.len().min(DENSITY_POINTS);
        let d = spacing(count);
        let quiet = self.quiet_blocks(request);
        let weight = |i: usize| {
            let square = self.square[i * self.square.len() / count];
            let density = 1.0 / (step_s * libm::sqrt(square)) + 1.0 / widest_rad;
            if quiet[i * BLOCKS / count] { density / QUIET_STEPS } else { density }
        };
        let mut sums = Vec::with_capacity(count + 1);
        let mut sum = 0.0;
        let mut left = weight(0);
        for i in 0..count {
            sums.push(sum);
            let right = weight(if i + 1 < count { i + 1 } else { 0 });
            sum += 0.5 * d * (left + right);
            left = right;
        }
        sums.push(sum);
        #[allow(clippy::cast_possible_truncation, reason = "some hundred knots")]
        let n = (libm::ceil(sum) as usize).clamp(MIN_KNOTS, MAX_KNOTS).next_multiple_of(LANES);
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

/// Keeps each value within a rise of the one before. The second time round the rest is known to be as soon as one is.
fn limit_rise<'a>(values: impl Iterator<Item = &'a mut f64>, mut before: f64, rise: f64, is_again: bool) {
    for z in values {
        let allowed = before + rise;
        if *z > allowed {
            *z = allowed;
        } else if is_again {
            return;
        }
        before = *z;
    }
}

fn spacing(count: usize) -> f64 {
    TURN_RAD / to_f64(count)
}
