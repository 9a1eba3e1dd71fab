// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Uniform periodic quintic B-splines over one turn: C⁴, the form in which every closed curve of a cam travels.

use super::banded::{CyclicBand, CyclicCholesky};
use super::twofold::Twofold;
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;
use thiserror::Error;

pub use super::hermite::Sample;

/// Why coefficients do not make a periodic spline.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PeriodicSplineError {
    /// Fewer coefficients than the order needs.
    #[error("a periodic quintic spline needs at least 6 coefficients, not {count}")]
    TooFewCoefficients {
        /// Number of coefficients given.
        count: usize,
    },
    /// A coefficient is not finite.
    #[error("coefficient {index} is not a finite number")]
    NotFinite { index: usize },
}

/// A uniform periodic quintic B-spline over one turn: f(φ) = Σ cᵢ B₅(φ/h − i), h = 2π/n, with B₅ the centred quintic
/// cardinal B-spline, so that coefficient i sits at φ = i·h.
#[derive(Debug, Clone, PartialEq)]
pub struct PeriodicSpline {
    coefficients: Vec<f64>,
}

impl PeriodicSpline {
    /// A spline of given coefficients.
    ///
    /// # Errors
    /// Fewer than six coefficients, or one that is not finite.
    pub fn from_coefficients(coefficients: Vec<f64>) -> Result<Self, PeriodicSplineError> {
        if coefficients.len() < 6 {
            return Err(PeriodicSplineError::TooFewCoefficients { count: coefficients.len() });
        }
        if let Some(index) = coefficients.iter().position(|c| !c.is_finite()) {
            return Err(PeriodicSplineError::NotFinite { index });
        }
        Ok(Self { coefficients })
    }

    /// The spline through values at the angles i·2π/n, n being their number, odd or even.
    ///
    /// Solves the cyclic band (1, 26, 66, 26, 1)/120, whose condition is 7.5: the values come back to a few ulp.
    ///
    /// # Errors
    /// Fewer than six values, or one that is not finite.
    pub fn interpolate(values: &[f64]) -> Result<Self, PeriodicSplineError> {
        if values.len() < 6 {
            return Err(PeriodicSplineError::TooFewCoefficients { count: values.len() });
        }
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            return Err(PeriodicSplineError::NotFinite { index });
        }
        // Around the first value, so that a constant stays exactly constant and a small lift keeps its digits.
        let level = values[0];
        let mut coefficients: Vec<f64> = values.iter().map(|value| value - level).collect();
        Self::interpolation(values.len())
            .expect("at least six rows, and the diagonal outweighs the rest of its row")
            .solve(&mut coefficients);
        for coefficient in &mut coefficients {
            *coefficient += level;
        }
        Self::from_coefficients(coefficients)
    }

    /// Matrix that turns this many values into coefficients; `None` for fewer than five.
    pub(crate) fn interpolation(count: usize) -> Option<CyclicCholesky<3>> {
        CyclicBand::<3>::circulant(count, [66.0 / 120.0, 26.0 / 120.0, 1.0 / 120.0]).factor().ok()
    }

    /// f(−φ): the basis is symmetric about its knots, so the coefficients only change places.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let mut coefficients = self.coefficients.clone();
        coefficients[1..].reverse();
        Self { coefficients }
    }

    /// Its coefficients, one per knot.
    #[must_use]
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// The same with a constant added.
    #[must_use]
    pub fn raised(&self, by: f64) -> Self {
        Self { coefficients: self.coefficients.iter().map(|coefficient| coefficient + by).collect() }
    }

    /// Value and derivatives with respect to the angle (rad).
    #[must_use]
    pub fn sample(&self, angle_rad: f64) -> Sample {
        let x = angle_rad * self.per_rad();
        // Within the turn, as nearly always: the same numbers without rounding and division.
        #[allow(clippy::cast_possible_truncation, reason = "an index within the turn")]
        let inside = if x >= 0.0 { x as usize } else { usize::MAX };
        if inside < self.coefficients.len() {
            let floor = inside as f64;
            return self.combine(inside, &Weights::at(x - floor));
        }
        let floor = libm::floor(x);
        #[allow(clippy::cast_possible_truncation, reason = "angles are far inside i64 knots")]
        let knot = (floor as i64).rem_euclid(i64::try_from(self.coefficients.len()).unwrap_or(i64::MAX));
        self.combine(usize::try_from(knot).unwrap_or(0), &Weights::at(x - floor))
    }

    /// The value at an angle, with the digits that a float loses behind many turns and behind a large value. It repeats exactly after
    /// [`TURN_RAD`].
    #[must_use]
    pub fn exact_value(&self, angle_rad: Twofold) -> Twofold {
        let per_rad = Twofold::quotient(self.coefficients.len() as f64, TURN_RAD);
        let (floor, u) = angle_rad.times(per_rad).floor();
        #[allow(clippy::cast_possible_truncation, reason = "angles are far inside i64 knots")]
        let knot = (floor as i64).rem_euclid(i64::try_from(self.coefficients.len()).unwrap_or(i64::MAX));
        let [a, b, m, p, q, r] = self.around(usize::try_from(knot).unwrap_or(0));
        let v = basis(u);
        Twofold::sum(m, v[0] * (a - m) + v[1] * (b - m) + v[3] * (p - m) + v[4] * (q - m) + v[5] * (r - m))
    }

    /// Same as [`PeriodicSpline::sample`], at `parts` equal steps from every knot to the next, from angle 0 on round the turn.
    #[must_use]
    pub fn samples(&self, parts: u32) -> Vec<Sample> {
        let weights = Weights::at_parts(parts);
        let mut samples = Vec::with_capacity(self.coefficients.len() * weights.len());
        for knot in 0..self.coefficients.len() {
            samples.extend(weights.iter().map(|w| self.combine(knot, w)));
        }
        samples
    }

    /// Largest magnitudes that the first, second and third derivative can have from knot `from` up to knot `to` (which may lie
    /// beyond the turn): a spline lies within the hull of its control points.
    pub(crate) fn largest_derivatives(&self, from: usize, to: usize) -> [f64; 3] {
        let n = self.coefficients.len();
        let mut index = (from + n - 2) % n;
        let mut next = || {
            let here = self.coefficients[index];
            index = if index + 1 < n { index + 1 } else { 0 };
            here
        };
        // Differences of the first three coefficients, then one more of each kind with every further coefficient.
        let (a, b, mut last) = (next(), next(), next());
        let (mut d1, mut largest) = (last - b, [(b - a).abs().max((last - b).abs()), 0.0_f64, 0.0_f64]);
        let mut d2 = d1 - (b - a);
        largest[1] = d2.abs();
        for _ in 0..to - from + 2 {
            let c = next();
            let new1 = c - last;
            let new2 = new1 - d1;
            largest[0] = largest[0].max(new1.abs());
            largest[1] = largest[1].max(new2.abs());
            largest[2] = largest[2].max((new2 - d2).abs());
            (last, d1, d2) = (c, new1, new2);
        }
        let per_rad = self.per_rad();
        [largest[0] * per_rad, largest[1] * per_rad * per_rad, largest[2] * per_rad * per_rad * per_rad]
    }

    /// Largest magnitude of the fourth derivative between a knot and the next, and that of the fifth, which is constant there.
    pub(crate) fn fourth_and_fifth(&self, knot: usize) -> (f64, f64) {
        let [a, b, m, p, q, r] = self.around(knot);
        let d2 = [(m - b) - (b - a), (p - m) - (m - b), (q - p) - (p - m), (r - q) - (q - p)];
        let d3 = [d2[1] - d2[0], d2[2] - d2[1], d2[3] - d2[2]];
        let d4 = [d3[1] - d3[0], d3[2] - d3[1]];
        let per_rad = self.per_rad();
        let fourth = per_rad * per_rad * per_rad * per_rad;
        (d4[0].abs().max(d4[1].abs()) * fourth, (d4[1] - d4[0]).abs() * fourth * per_rad)
    }

    /// Largest magnitudes of the fourth derivative from every `stride`th knot to the next of them; `stride` divides the number of knots.
    pub(crate) fn largest_fourth_derivatives(&self, stride: usize) -> Vec<f64> {
        let n = self.coefficients.len();
        let around = [&self.coefficients[n - 2..], &self.coefficients, &self.coefficients[..3]].concat();
        // It is a line from the control point of a knot to that of the next.
        let at_knots = around.windows(5).map(|c| (c[0] + c[4] - 4.0 * (c[1] + c[3]) + 6.0 * c[2]).abs());
        let at_knots: Vec<f64> = at_knots.collect();
        let per_rad = self.per_rad();
        let scale = per_rad * per_rad * per_rad * per_rad;
        (0..n / stride)
            .map(|k| scale * at_knots[k * stride..=(k + 1) * stride].iter().fold(0.0, |a, b| f64::max(a, *b)))
            .collect()
    }

    pub(crate) fn per_rad(&self) -> f64 {
        let count = self.coefficients.len() as f64;
        count / TURN_RAD
    }

    /// The six coefficients that are felt between a knot and the next.
    fn around(&self, knot: usize) -> [f64; 6] {
        let n = self.coefficients.len();
        let inside = knot.checked_sub(2).and_then(|from| self.coefficients.get(from..from + 6));
        match inside.and_then(|inside| inside.try_into().ok()) {
            Some(inside) => inside,
            None => core::array::from_fn(|i| self.coefficients[(knot + n - 2 + i) % n]),
        }
    }

    /// Value and derivatives at a place between a knot and the next.
    #[inline]
    pub(crate) fn combine(&self, knot: usize, w: &Weights) -> Sample {
        let per_rad = self.per_rad();
        // Differences first: a constant spline is then exactly constant, and derivatives lose no digits.
        let [a, b, m, p, q, r] = self.around(knot);
        let v = &w.value;
        let value = m + (v[0] * (a - m) + v[1] * (b - m) + v[3] * (p - m) + v[4] * (q - m) + v[5] * (r - m));
        let d1 = [b - a, m - b, p - m, q - p, r - q];
        let d2 = [d1[1] - d1[0], d1[2] - d1[1], d1[3] - d1[2], d1[4] - d1[3]];
        let d3 = [d2[1] - d2[0], d2[2] - d2[1], d2[3] - d2[2]];
        let first: f64 = w.first.iter().zip(d1).map(|(w, d)| w * d).sum();
        let second: f64 = w.second.iter().zip(d2).map(|(w, d)| w * d).sum();
        let third: f64 = w.third.iter().zip(d3).map(|(w, d)| w * d).sum();
        Sample {
            value,
            first: first * per_rad,
            second: second * per_rad * per_rad,
            third: third * per_rad * per_rad * per_rad,
        }
    }
}

/// Weights of coefficients, and of their first, second and third differences, between two knots.
pub(crate) struct Weights {
    value: [f64; 6],
    first: [f64; 5],
    second: [f64; 4],
    third: [f64; 3],
}

impl Weights {
    /// At equal steps from the left knot on, the right one not included.
    pub(crate) fn at_parts(parts: u32) -> Vec<Self> {
        (0..parts).map(|part| Self::at(f64::from(part) / f64::from(parts))).collect()
    }

    /// Weights of the six coefficients in value, first and second derivative (over knots) at `u` in 0..1 from the left knot: for
    /// splines over a turn whose coefficients depend on something else.
    #[inline]
    pub(crate) fn from_coefficients(u: f64) -> [[f64; 6]; 3] {
        let (q, p) = (quartic_basis(u), cubic_basis(u));
        let first = [-q[0], q[0] - q[1], q[1] - q[2], q[2] - q[3], q[3] - q[4], q[4]];
        let second =
            [p[0], p[1] - 2.0 * p[0], p[2] - 2.0 * p[1] + p[0], p[3] - 2.0 * p[2] + p[1], p[2] - 2.0 * p[3], p[3]];
        [basis(u), first, second]
    }

    /// At `u` in 0..1 from the left knot.
    #[inline]
    fn at(u: f64) -> Self {
        Self { value: basis(u), first: quartic_basis(u), second: cubic_basis(u), third: quadratic_basis(u) }
    }
}

/// The six quintic B-splines that are not zero between two knots, at `u` in 0..1 from the left one.
fn basis(u: f64) -> [f64; 6] {
    let v = 1.0 - u;
    let end = |t: f64| t * t * t * t * t / 120.0;
    let next = |t: f64| (1.0 + t * (5.0 + t * (10.0 + t * (10.0 + t * (5.0 - 5.0 * t))))) / 120.0;
    let middle = |t: f64| (26.0 + t * (50.0 + t * (20.0 + t * (-20.0 + t * (-20.0 + 10.0 * t))))) / 120.0;
    [end(v), next(v), middle(v), middle(u), next(u), end(u)]
}

/// The five quartic B-splines between two knots.
fn quartic_basis(u: f64) -> [f64; 5] {
    let v = 1.0 - u;
    let end = |t: f64| t * t * t * t / 24.0;
    let next = |t: f64| (1.0 + t * (4.0 + t * (6.0 + t * (4.0 - 4.0 * t)))) / 24.0;
    let middle = (11.0 + u * (12.0 + u * (-6.0 + u * (-12.0 + 6.0 * u)))) / 24.0;
    [end(v), next(v), middle, next(u), end(u)]
}

/// The four cubic B-splines between two knots.
fn cubic_basis(u: f64) -> [f64; 4] {
    let v = 1.0 - u;
    let end = |t: f64| t * t * t / 6.0;
    let next = |t: f64| (1.0 + t * (3.0 + t * (3.0 - 3.0 * t))) / 6.0;
    [end(v), next(v), next(u), end(u)]
}

/// The three quadratic B-splines between two knots.
fn quadratic_basis(u: f64) -> [f64; 3] {
    let v = 1.0 - u;
    [v * v / 2.0, (1.0 + 2.0 * u * v) / 2.0, u * u / 2.0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    /// The basis functions of every degree sum to one everywhere.
    #[test]
    fn bases_are_partitions_of_unity() {
        for i in 0..=100 {
            let u = f64::from(i) / 100.0;
            assert!((basis(u).iter().sum::<f64>() - 1.0).abs() < 1e-15);
            assert!((quartic_basis(u).iter().sum::<f64>() - 1.0).abs() < 1e-15);
            assert!((cubic_basis(u).iter().sum::<f64>() - 1.0).abs() < 1e-15);
            assert!((quadratic_basis(u).iter().sum::<f64>() - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn a_constant_is_exactly_constant() {
        let spline = PeriodicSpline::from_coefficients(vec![7.3; 36]).expect("36 coefficients");
        for i in 0..1000 {
            let sample = spline.sample(f64::from(i) * 0.0123 - 3.0);
            assert_eq!(sample, Sample { value: 7.3, first: 0.0, second: 0.0, third: 0.0 });
        }
    }

    #[test]
    fn interpolation_returns_its_values_for_any_count() {
        for n in [6_usize, 7, 8, 36, 101, 3600, 3601] {
            let value = |i: usize| 40.0 + libm::sin(i as f64 * 0.71) + if i.is_multiple_of(7) { 3.0 } else { 0.0 };
            let values: Vec<f64> = (0..n).map(value).collect();
            let spline = PeriodicSpline::interpolate(&values).unwrap();
            for (i, wanted) in values.iter().enumerate() {
                let found = spline.sample(i as f64 * TURN_RAD / n as f64).value;
                assert!((found - wanted).abs() < 1e-13 * 43.0 * 4.0, "n = {n}, {i}: {found} {wanted}");
            }
        }
    }

    /// The error of interpolating an analytic curve falls with the sixth power of the spacing.
    #[test]
    fn interpolation_of_a_sine_is_of_sixth_order() {
        let error = |n: u32| {
            let at = |i: f64| i * TURN_RAD / f64::from(n);
            let values: Vec<f64> = (0..n).map(|i| libm::sin(3.0 * at(f64::from(i)))).collect();
            let spline = PeriodicSpline::interpolate(&values).unwrap();
            (0..n)
                .map(|i| at(f64::from(i) + 0.5))
                .map(|phi| (spline.sample(phi).value - libm::sin(3.0 * phi)).abs())
                .fold(0.0, f64::max)
        };
        let ratio = error(60) / error(120);
        assert!((50.0..80.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn samples_at_equal_steps_are_those_at_their_angles() {
        let spline = PeriodicSpline::from_coefficients((0..50).map(|i| libm::sin(f64::from(i * i))).collect()).unwrap();
        for (i, sample) in (0..).zip(spline.samples(4)) {
            let wanted = spline.sample((f64::from(i) + 1e-9) * TURN_RAD / 200.0);
            assert!((sample.value - wanted.value).abs() < 1e-7 && (sample.third - wanted.third).abs() < 1e-4, "{i}");
        }
        assert_eq!(spline.samples(4).len(), 200);
    }

    /// No sample of a derivative is beyond the hull, nor that of the third derivative's differences beyond fourth and fifth.
    #[test]
    fn derivatives_stay_within_their_hulls() {
        let spline = PeriodicSpline::from_coefficients((0..50).map(|i| libm::sin(f64::from(i * i))).collect()).unwrap();
        let step = TURN_RAD / 50.0;
        for (from, to) in [(0, 1), (7, 9), (45, 53), (49, 50), (0, 50)] {
            let hull = spline.largest_derivatives(from, to);
            let mut found = [0.0_f64; 3];
            for i in 0..=200 {
                let x = spline.sample((from as f64 + (to - from) as f64 * f64::from(i) / 200.0) * step);
                for (max, x) in found.iter_mut().zip([x.first, x.second, x.third]) {
                    *max = max.max(x.abs());
                }
            }
            for (hull, found) in hull.into_iter().zip(found) {
                assert!(found <= hull * (1.0 + 1e-12) && hull < 8.0 * found, "{from} to {to}: {found} {hull}");
            }
        }
        for (i, fourth) in spline.largest_fourth_derivatives(5).into_iter().enumerate() {
            let each = (5 * i..5 * i + 5).map(|knot| spline.fourth_and_fifth(knot).0).fold(0.0, f64::max);
            assert!((fourth / each - 1.0).abs() < 1e-12, "{i}: {fourth} {each}");
        }
        for knot in 0..50 {
            let third = |u: f64| spline.sample((knot as f64 + u) * step).third;
            let (fourth, fifth) = spline.fourth_and_fifth(knot);
            let slopes = [(third(0.01) - third(0.0)) / (0.01 * step), (third(0.99) - third(0.98)) / (0.01 * step)];
            assert!(slopes.iter().all(|slope| slope.abs() <= fourth * 1.001), "{knot}: {slopes:?} {fourth}");
            let curvature = (slopes[1] - slopes[0]).abs() / (0.98 * step);
            assert!((curvature - fifth).abs() <= 1e-6 * (fifth + fourth), "{knot}: {curvature} {fifth}");
        }
    }

    /// Derivatives agree with finite differences of the value.
    #[test]
    fn derivatives_agree_with_differences() {
        let coefficients = (0..72).map(|i| libm::sin(f64::from(i) * 0.3) + libm::cos(f64::from(i * i))).collect();
        let spline = PeriodicSpline::from_coefficients(coefficients).expect("72 coefficients");
        let step = 1e-5;
        for i in 0..500 {
            let at = f64::from(i) * 0.0177;
            let (left, mid, right) = (spline.sample(at - step), spline.sample(at), spline.sample(at + step));
            assert!(((right.value - left.value) / (2.0 * step) - mid.first).abs() < 1e-5 * (1.0 + mid.first.abs()));
            assert!(((right.first - left.first) / (2.0 * step) - mid.second).abs() < 1e-4 * (1.0 + mid.second.abs()));
            assert!(((right.second - left.second) / (2.0 * step) - mid.third).abs() < 1e-2 * (1.0 + mid.third.abs()));
        }
    }
}
