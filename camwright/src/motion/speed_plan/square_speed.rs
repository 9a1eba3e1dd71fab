// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The square of C's speed over the path angle, z = Ċ², as a periodic quadratic B-spline on knots of any spacing.
//!
//! Over the angle, C̈ = z′/2 and C⃛ = √z·z″/2, and with the path X(φ) also Ẍ = X″z + X′z′/2 and
//! X⃛ = √z·(X‴z + 3/2·X″z′ + 1/2·X′z″). In z all of it is linear but the root, which is why plans are made in z.

use crate::math::units::TURN_RAD;
use alloc::vec::Vec;

/// z and its derivatives by the angle (rad²/s², rad).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct SquareSample {
    pub(super) z: f64,
    pub(super) first: f64,
    pub(super) second: f64,
}

/// Weights of the three coefficients that an interval sees.
pub(super) type SpeedWeights = [f64; 3];

/// A number of points or knots.
pub(super) fn to_f64(count: usize) -> f64 {
    count as f64
}

/// Knots over one turn: interval i goes from knot i to knot i + 1, the last one to the first again.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SpeedKnots {
    at: Vec<f64>,
}

impl SpeedKnots {
    /// Increasing angles from 0 on, below a turn; at least five.
    pub(super) fn new(at: Vec<f64>) -> Self {
        debug_assert!(at.len() >= 5 && at[0] >= 0.0 && at.windows(2).all(|pair| pair[0] < pair[1]));
        Self { at }
    }

    pub(super) fn count(&self) -> usize {
        self.at.len()
    }

    pub(super) fn at(&self, index: usize) -> f64 {
        self.at[index]
    }

    pub(super) fn length(&self, interval: usize) -> f64 {
        let next = if interval + 1 < self.at.len() { self.at[interval + 1] } else { self.at[0] + TURN_RAD };
        next - self.at[interval]
    }

    /// The interval of an angle within the turn, and the share of it that lies before.
    pub(super) fn find(&self, angle_rad: f64) -> (usize, f64) {
        let after = self.at.partition_point(|at| *at <= angle_rad);
        let (interval, angle_rad) =
            if after == 0 { (self.at.len() - 1, angle_rad + TURN_RAD) } else { (after - 1, angle_rad) };
        (interval, (angle_rad - self.at[interval]) / self.length(interval))
    }

    /// Index of the interval before and of that after one.
    pub(super) fn beside(&self, interval: usize) -> (usize, usize) {
        let last = self.at.len() - 1;
        (if interval == 0 { last } else { interval - 1 }, if interval == last { 0 } else { interval + 1 })
    }

    /// Weights of the coefficients before, of and after an interval at the share `u` of it: of z, z′ and z″.
    pub(super) fn weights(&self, interval: usize, u: f64) -> [SpeedWeights; 3] {
        let (before, after) = self.beside(interval);
        let (d0, d, d1) = (self.length(before), self.length(interval), self.length(after));
        // Bézier points of the interval: its first knot, its coefficient, its last knot.
        let (a, b) = (d / (d0 + d), d0 / (d0 + d));
        let (p, q) = (d1 / (d + d1), d / (d + d1));
        let v = 1.0 - u;
        [
            [a * v * v, b * v * v + 2.0 * u * v + p * u * u, q * u * u],
            [-2.0 / d * a * v, 2.0 / d * ((1.0 - b) * v + (p - 1.0) * u), 2.0 / d * q * u],
            [2.0 / (d * d) * a, 2.0 / (d * d) * (b - 2.0 + p), 2.0 / (d * d) * q],
        ]
    }
}

/// z over one turn.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SquareSpeed {
    knots: SpeedKnots,
    coefficients: Vec<f64>,
}

impl SquareSpeed {
    pub(super) fn new(knots: SpeedKnots, coefficients: Vec<f64>) -> Self {
        debug_assert_eq!(knots.count(), coefficients.len(), "a coefficient per interval");
        Self { knots, coefficients }
    }

    pub(super) fn knots(&self) -> &SpeedKnots {
        &self.knots
    }

    pub(super) fn scale(&mut self, factor: f64) {
        for coefficient in &mut self.coefficients {
            *coefficient *= factor;
        }
    }

    /// At the share `u` of an interval.
    pub(super) fn within(&self, interval: usize, u: f64) -> SquareSample {
        let (before, after) = self.knots.beside(interval);
        let c = [self.coefficients[before], self.coefficients[interval], self.coefficients[after]];
        let dot = |w: &SpeedWeights| w[0] * c[0] + w[1] * c[1] + w[2] * c[2];
        let [z, first, second] = self.knots.weights(interval, u);
        SquareSample { z: dot(&z), first: dot(&first), second: dot(&second) }
    }

    /// Time from one knot to the next (s): ∫dφ/√z of a quadratic, in closed form.
    ///
    /// With Bézier ends v₀, v₁ (speeds) and slope z′ it is the time of a motion whose z is a parabola; the form
    /// 2d/(v₀ + v₁) of a straight z is corrected by the curvature through a five-point Gauss rule, exact to rounding for
    /// intervals as short as these.
    pub(super) fn time_across(&self, interval: usize) -> f64 {
        const GAUSS: [(f64, f64); 5] = [
            (0.046_910_077_030_668, 0.118_463_442_528_094_54),
            (0.230_765_344_947_158_45, 0.239_314_335_249_683_24),
            (0.5, 0.284_444_444_444_444_45),
            (0.769_234_655_052_841_5, 0.239_314_335_249_683_24),
            (0.953_089_922_969_332, 0.118_463_442_528_094_54),
        ];
        let d = self.knots.length(interval);
        GAUSS.iter().map(|(u, weight)| weight * d / libm::sqrt(self.within(interval, *u).z)).sum()
    }
}
