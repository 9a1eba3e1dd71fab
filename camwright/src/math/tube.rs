// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The smoothest periodic quintic spline that passes within a given distance of every point.
//!
//! Among all periodic functions with |s(θᵢ) − yᵢ| ≤ δwᵢ, δ the largest distance, the one with the least ∫ s‴² dθ is a quintic spline with its knots
//! at the points, so nothing is lost by looking for it among those splines. In units of δ and of the knot spacing:
//!
//! ```text
//!   minimise ½ cᵀHc  subject to  −w ≤ Bc − y ≤ w,
//!   B = cyclic band (1, 26, 66, 26, 1)/120,   H = D₃ᵀ B D₃,   D₃ = third differences
//! ```
//!
//! (the Gram matrix of the quadratic B-splines is B again). A primal-dual interior point method solves it; each step is
//! one factorisation of `H + BᵀWB`, a cyclic band of half width 5, so the whole is linear in the number of points.

use super::banded::{CyclicBand, CyclicCholesky};
use super::periodic_spline::{PeriodicSpline, PeriodicSplineError};
use alloc::vec;
use alloc::vec::Vec;
use thiserror::Error;

/// Fewest points: the half bandwidth 5 needs eleven unknowns.
pub const MIN_POINTS: usize = 11;

/// Values of the quintic B-spline at its knots.
const BASIS: [f64; 5] = [1.0 / 120.0, 26.0 / 120.0, 66.0 / 120.0, 26.0 / 120.0, 1.0 / 120.0];

/// Upper half of a row of H: (−1, 6, −15, 20, −15, 6, −1) folded with [`BASIS`].
const ENERGY: [f64; 6] = [552.0 / 120.0, -330.0 / 120.0, 0.0, 75.0 / 120.0, -20.0 / 120.0, -1.0 / 120.0];

/// The energy is within this fraction of the least possible. 1e-6 leaves s″ the same in five digits (tried 1e-4 … 1e-9);
/// smaller costs iterations, and below 1e-9 the rounding of the points themselves shows.
const RELATIVE_GAP: f64 = 1e-6;

/// Excess of energy at which a result is refused: jerk then is up to √2 times the least. Met only by tables of more than
/// 36 000 points with a coarse digit, where H is singular to working precision; at 3600 the excess is [`RELATIVE_GAP`].
const WORST_GAP: f64 = 1.0;

/// Energy that counts as zero, as a fraction of that of a wave of one half digit once per turn: anything smoother cannot
/// be distinguished from a circle, and a table without lift must terminate.
const NEGLIGIBLE: f64 = 1e-3;

/// Iterations after which the method has failed; it takes 10 to 30.
const MAX_ITERATIONS: usize = 100;

/// Why there is no smoothest spline.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TubeError {
    #[error("{count} points, at least {MIN_POINTS} are needed")]
    TooFewPoints { count: usize },
    /// A half width is not a positive number.
    #[error("half width {half_width} of point {index} is not a positive number")]
    BadHalfWidth {
        /// Index of the point.
        index: usize,
        half_width: f64,
    },
    /// A point is not finite.
    #[error("point {index} is not a finite number")]
    NotFinite { index: usize },
    /// Rounding kept the method from coming near the smoothest curve.
    #[error("the curve found may have {relative_gap:.1} times the least energy in excess; allowed: {max}")]
    NotSmoothest {
        /// Excess of ∫ s‴² over the least possible, as a fraction of it.
        relative_gap: f64,
        max: f64,
    },
    /// Independent evaluation of the result leaves the tube.
    #[error("the spline is {deviation} from point {index}; allowed: {half_width}")]
    OutsideTube {
        /// Index of the point.
        index: usize,
        deviation: f64,
        half_width: f64,
    },
}

/// The smoothest spline and how it was reached.
#[derive(Debug, Clone, PartialEq)]
pub struct TubeSpline {
    /// The spline; its n coefficients belong to the n points.
    pub spline: PeriodicSpline,
    /// The energy ∫ s‴² is at most this fraction above the least possible.
    pub relative_gap: f64,
    /// Steps of the interior point method.
    pub iterations: usize,
}

/// The smoothest periodic quintic spline within `half_widths` of `values`, which stand at the angles i·2π/n; one width for each value.
///
/// # Errors
/// Too few points, numbers that are not finite, half widths that are not positive, or a result that evaluation of the
/// spline itself does not confirm.
pub fn smoothest_within(values: &[f64], half_widths: &[f64]) -> Result<TubeSpline, TubeError> {
    let n = values.len();
    if n < MIN_POINTS {
        return Err(TubeError::TooFewPoints { count: n });
    }
    let is_width = |width: &f64| width.is_finite() && *width > 0.0;
    if let Some(index) = (0..n).find(|index| !half_widths.get(*index).is_some_and(is_width)) {
        return Err(TubeError::BadHalfWidth { index, half_width: half_widths.get(index).copied().unwrap_or(f64::NAN) });
    }
    if let Some(index) = values.iter().position(|value| !value.is_finite()) {
        return Err(TubeError::NotFinite { index });
    }
    // Around the first value, so that a dwell there keeps its digits.
    let level = values[0];
    let largest = half_widths.iter().copied().fold(0.0, f64::max);
    let y: Vec<f64> = values.iter().map(|value| (value - level) / largest).collect();
    let mut tube = Tube::start(y, half_widths.iter().map(|width| width / largest).collect())?;
    let points = n as f64;
    let cubed = libm::pow(crate::math::units::TURN_RAD / points, 3.0);
    let negligible = NEGLIGIBLE * points * cubed * cubed;
    // The least energy is not negative, so the excess is never more than the energy itself.
    let excess = |tube: &Tube| if tube.energy() <= negligible { 0.0 } else { tube.gap() / tube.energy() };
    let mut iterations = 0;
    while iterations < MAX_ITERATIONS && excess(&tube) > RELATIVE_GAP && tube.step() {
        iterations += 1;
    }
    let relative_gap = excess(&tube);
    if relative_gap.is_nan() || relative_gap > WORST_GAP {
        return Err(TubeError::NotSmoothest { relative_gap, max: WORST_GAP });
    }
    let coefficients = tube.c.iter().map(|c| level + largest * c).collect();
    let spline = PeriodicSpline::from_coefficients(coefficients).map_err(from_spline_error)?;
    verify(&spline, values, half_widths)?;
    Ok(TubeSpline { spline, relative_gap, iterations })
}

fn from_spline_error(error: PeriodicSplineError) -> TubeError {
    match error {
        PeriodicSplineError::TooFewCoefficients { count } => TubeError::TooFewPoints { count },
        PeriodicSplineError::NotFinite { index } => TubeError::NotFinite { index },
    }
}

/// Evaluates the spline itself at every point; the solver's own slacks are not asked.
fn verify(spline: &PeriodicSpline, values: &[f64], half_widths: &[f64]) -> Result<(), TubeError> {
    for (index, (value, &half_width)) in values.iter().zip(half_widths).enumerate() {
        let angle = index as f64 * crate::math::units::TURN_RAD / values.len() as f64;
        let deviation = (spline.sample(angle).value - value).abs();
        // The angle itself is rounded: on a steep flank that alone moves the value by some 1e-14 of its size.
        if deviation.is_nan() || deviation > half_width * (1.0 + 1e-9) + 1e-13 * value.abs() {
            return Err(TubeError::OutsideTube { index, deviation, half_width });
        }
    }
    Ok(())
}

/// State of the interior point method. `r` = Bc − y is the deviation; the slacks are w − r and w + r.
struct Tube {
    y: Vec<f64>,
    w: Vec<f64>,
    c: Vec<f64>,
    r: Vec<f64>,
    upper: Vec<f64>,
    lower: Vec<f64>,
}

struct NewtonStep {
    c: Vec<f64>,
    r: Vec<f64>,
    upper: Vec<f64>,
    lower: Vec<f64>,
}

impl Tube {
    /// A smoothing spline of uniform weight p inside the tube: it satisfies Hc + pBᵀr = 0, so the multipliers
    /// p(w ± r)/2 are dual feasible, positive, and both products with their slacks are p(w² − r²)/2: centred, for free.
    fn start(y: Vec<f64>, w: Vec<f64>) -> Result<Self, TubeError> {
        let n = y.len();
        let through = PeriodicSpline::interpolate(&y).map_err(from_spline_error)?;
        let curvature = apply_energy(through.coefficients());
        let mut weight = 4.0 * curvature.iter().fold(0.0_f64, |a, h| a.max(h.abs()));
        let mut c = through.coefficients().to_vec();
        let mut used = weight.max(1e-12);
        let mut found = false;
        // Tenfold steps from a weight that surely follows the points to the last one that still lies inside; the
        // first guess may need raising where the table is rough compared with its digit.
        for _ in 0..40 {
            if weight < 1e-13 {
                break;
            }
            let mut right: Vec<f64> = apply_basis(&y);
            right.iter_mut().for_each(|x| *x *= weight);
            let weights = vec![weight; n];
            let Some(factor) = normal_matrix(&weights) else { break };
            factor.solve(&mut right);
            let inside = apply_basis(&right).iter().zip(&y).zip(&w).all(|((s, y), w)| (s - y).abs() < 0.9 * w);
            if inside {
                (c, used, found) = (right, weight, true);
                weight *= 0.1;
            } else if found {
                break;
            } else {
                weight *= 10.0;
            }
        }
        let r: Vec<f64> = apply_basis(&c).iter().zip(&y).map(|(s, y)| s - y).collect();
        let upper = r.iter().zip(&w).map(|(r, w)| 0.5 * used * (w + r)).collect();
        let lower = r.iter().zip(&w).map(|(r, w)| 0.5 * used * (w - r)).collect();
        Ok(Self { y, w, c, r, upper, lower })
    }

    fn energy(&self) -> f64 {
        let third = third_differences(&self.c);
        0.5 * third.iter().zip(apply_basis(&third)).map(|(a, b)| a * b).sum::<f64>()
    }

    /// Complementarity gap: how much the energy can still fall.
    fn gap(&self) -> f64 {
        (0..self.r.len())
            .map(|i| (self.w[i] - self.r[i]) * self.upper[i] + (self.w[i] + self.r[i]) * self.lower[i])
            .sum()
    }

    /// One predictor-corrector step (Mehrotra). `false`: no further progress in this arithmetic.
    fn step(&mut self) -> bool {
        let n = self.r.len();
        let pairs = 2.0 * n as f64;
        let mu = self.gap() / pairs;
        let weights: Vec<f64> =
            (0..n).map(|i| self.upper[i] / (self.w[i] - self.r[i]) + self.lower[i] / (self.w[i] + self.r[i])).collect();
        let Some(factor) = normal_matrix(&weights) else { return false };
        let stationarity = self.stationarity();
        let zero = vec![0.0; n];
        let affine = self.direction(&factor, &weights, &stationarity, 0.0, &zero, &zero);
        let reach = self.reach(&affine);
        let mu_affine = (0..n)
            .map(|i| {
                let r = self.r[i] + reach * affine.r[i];
                (self.w[i] - r) * (self.upper[i] + reach * affine.upper[i])
                    + (self.w[i] + r) * (self.lower[i] + reach * affine.lower[i])
            })
            .sum::<f64>()
            / pairs;
        let ratio = (mu_affine / mu).clamp(0.0, 1.0);
        let target = ratio * ratio * ratio * mu;
        let second_upper: Vec<f64> = (0..n).map(|i| affine.r[i] * affine.upper[i]).collect();
        let second_lower: Vec<f64> = (0..n).map(|i| -affine.r[i] * affine.lower[i]).collect();
        let full = self.direction(&factor, &weights, &stationarity, target, &second_upper, &second_lower);
        let reach = (0.995 * self.reach(&full)).min(1.0);
        if reach.is_nan() || reach < 1e-9 {
            return false;
        }
        for i in 0..n {
            self.c[i] += reach * full.c[i];
            self.upper[i] += reach * full.upper[i];
            self.lower[i] += reach * full.lower[i];
        }
        // From c, not by accumulation, so that the slacks are those of the spline that is returned.
        let r: Vec<f64> = apply_basis(&self.c).iter().zip(&self.y).map(|(s, y)| s - y).collect();
        if r.iter().zip(&self.w).any(|(r, w)| r.is_nan() || r.abs() >= *w) {
            for i in 0..n {
                self.c[i] -= reach * full.c[i];
            }
            return false;
        }
        self.r = r;
        true
    }

    /// Hc + Bᵀ(z⁺ − z⁻), zero at the optimum.
    fn stationarity(&self) -> Vec<f64> {
        let difference: Vec<f64> = self.upper.iter().zip(&self.lower).map(|(u, l)| u - l).collect();
        apply_energy(&self.c).iter().zip(apply_basis(&difference)).map(|(h, b)| h + b).collect()
    }

    fn direction(
        &self,
        factor: &CyclicCholesky<6>,
        weights: &[f64],
        stationarity: &[f64],
        target: f64,
        second_upper: &[f64],
        second_lower: &[f64],
    ) -> NewtonStep {
        let n = self.r.len();
        let push_upper: Vec<f64> =
            (0..n).map(|i| (target + second_upper[i]) / (self.w[i] - self.r[i]) - self.upper[i]).collect();
        let push_lower: Vec<f64> =
            (0..n).map(|i| (target + second_lower[i]) / (self.w[i] + self.r[i]) - self.lower[i]).collect();
        let push: Vec<f64> = push_upper.iter().zip(&push_lower).map(|(u, l)| u - l).collect();
        let wanted: Vec<f64> = apply_basis(&push).iter().zip(stationarity).map(|(p, s)| -s - p).collect();
        let mut c = wanted.clone();
        factor.solve(&mut c);
        // Once more for the remainder: long dwells make the matrix nearly singular.
        let weighted: Vec<f64> = apply_basis(&c).iter().zip(weights).map(|(b, w)| b * w).collect();
        let mut rest: Vec<f64> =
            (apply_energy(&c).iter().zip(apply_basis(&weighted)).zip(&wanted)).map(|((h, b), w)| w - h - b).collect();
        factor.solve(&mut rest);
        c.iter_mut().zip(&rest).for_each(|(c, r)| *c += r);
        let r = apply_basis(&c);
        let upper = (0..n).map(|i| push_upper[i] + self.upper[i] / (self.w[i] - self.r[i]) * r[i]).collect();
        let lower = (0..n).map(|i| push_lower[i] - self.lower[i] / (self.w[i] + self.r[i]) * r[i]).collect();
        NewtonStep { c, r, upper, lower }
    }

    /// Distance along a direction before a slack or a multiplier becomes zero, at most 1/0.995 of the whole.
    fn reach(&self, direction: &NewtonStep) -> f64 {
        let mut reach = 1.0 / 0.995_f64;
        let mut shorten = |value: f64, change: f64| {
            if change < 0.0 {
                reach = reach.min(-value / change);
            }
        };
        for i in 0..self.r.len() {
            shorten(self.w[i] - self.r[i], -direction.r[i]);
            shorten(self.w[i] + self.r[i], direction.r[i]);
            shorten(self.upper[i], direction.upper[i]);
            shorten(self.lower[i], direction.lower[i]);
        }
        reach
    }
}

/// Factor of `H + BᵀWB`.
fn normal_matrix(weights: &[f64]) -> Option<CyclicCholesky<6>> {
    let n = weights.len();
    let mut matrix = CyclicBand::<6>::circulant(n, ENERGY);
    let rows = matrix.rows_mut();
    for (k, weight) in weights.iter().enumerate() {
        for a in 0..5 {
            for b in a..5 {
                rows[(k + n + a - 2) % n][b - a] += weight * BASIS[a] * BASIS[b];
            }
        }
    }
    matrix.factor().ok()
}

fn apply_basis(x: &[f64]) -> Vec<f64> {
    let n = x.len();
    (0..n)
        .map(|i| {
            let (a, b, m) = (x[(i + n - 2) % n], x[(i + n - 1) % n], x[i]);
            let (p, q) = (x[(i + 1) % n], x[(i + 2) % n]);
            m + (26.0 * ((b - m) + (p - m)) + ((a - m) + (q - m))) / 120.0
        })
        .collect()
}

/// D₃x: third difference i spans x[i − 1] … x[i + 2].
fn third_differences(x: &[f64]) -> Vec<f64> {
    let n = x.len();
    (0..n).map(|i| (x[(i + 2) % n] - x[(i + n - 1) % n]) - 3.0 * (x[(i + 1) % n] - x[i])).collect()
}

/// Hx = `D₃ᵀBD₃x`.
fn apply_energy(x: &[f64]) -> Vec<f64> {
    let n = x.len();
    let third = apply_basis(&third_differences(x));
    (0..n).map(|i| (third[(i + n - 2) % n] - third[(i + 1) % n]) - 3.0 * (third[(i + n - 1) % n] - third[i])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rounded_bump(n: usize, digit: f64) -> Vec<f64> {
        (0..n)
            .map(|i| libm::sin(core::f64::consts::PI * i as f64 / n as f64))
            .map(|s| libm::round(4.0 * s * s * s * s / digit) * digit)
            .collect()
    }

    /// The certificate of an optimum, from the result alone: the multipliers λ with Hc + Bλ = 0 push only at points that
    /// the curve touches, from the side on which it touches; what they do elsewhere bounds the energy still to be won.
    #[test]
    fn result_satisfies_the_conditions_of_an_optimum() {
        for (n, digit) in [(360, 1e-3), (361, 1e-2), (3600, 1e-3), (40, 1e-4), (11, 1e-2)] {
            let values = rounded_bump(n, digit);
            let half = 0.5 * digit;
            // One width, and widths of a quarter to the whole of it.
            let same = vec![half; n];
            let several: Vec<f64> = (0..n).map(|i| half * [1.0, 0.5, 0.25, 0.75][i / 3 % 4]).collect();
            for widths in [same, several] {
                let tube = smoothest_within(&values, &widths).unwrap();
                let c: Vec<f64> = tube.spline.coefficients().iter().map(|c| c / half).collect();
                let push: Vec<f64> = apply_energy(&c).iter().map(|h| -h).collect();
                let multipliers = PeriodicSpline::interpolate(&push).unwrap().coefficients().to_vec();
                let third = third_differences(&c);
                let energy = 0.5 * third.iter().zip(apply_basis(&third)).map(|(a, b)| a * b).sum::<f64>();
                let slack: f64 = (apply_basis(&c).iter().zip(&values).zip(&multipliers).zip(&widths))
                    .map(|(((s, y), m), width)| m.abs() * width / half - m * (s - y / half))
                    .sum();
                // Sixth differences of coefficients of some 1e4 leave this much noise in the multipliers.
                let noise = n as f64 * 1e-15 * c.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
                assert!(slack.abs() < 1e-4 * energy + noise, "n = {n}: {slack} of {energy}");
            }
        }
    }

    /// Wide enough a tube and the smoothest curve is a circle's constant.
    #[test]
    fn wide_tube_holds_a_constant() {
        let values: Vec<f64> = (0..72).map(|i| libm::sin(f64::from(i) * 0.7)).collect();
        let tube = smoothest_within(&values, &[1.5; 72]).unwrap();
        for i in 0..100 {
            let sample = tube.spline.sample(f64::from(i) * 0.1);
            assert!(sample.third.abs() < 1e-6, "{sample:?}");
        }
    }

    #[test]
    fn what_has_no_tube_is_refused() {
        assert_eq!(smoothest_within(&[0.0; 10], &[1.0; 10]), Err(TubeError::TooFewPoints { count: 10 }));
        let mut widths = [1.0; 20];
        widths[3] = 0.0;
        assert_eq!(smoothest_within(&[0.0; 20], &widths), Err(TubeError::BadHalfWidth { index: 3, half_width: 0.0 }));
        assert!(matches!(smoothest_within(&[0.0; 20], &[1.0; 19]), Err(TubeError::BadHalfWidth { index: 19, .. })));
        let mut values = [0.0; 20];
        values[7] = f64::NAN;
        assert_eq!(smoothest_within(&values, &[1.0; 20]), Err(TubeError::NotFinite { index: 7 }));
    }
}
