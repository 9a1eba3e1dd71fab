// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Quintic Hermite splines over equally spaced knots: as [`super::hermite`], but a place is found by one division, for paths of
//! hundreds of thousands of knots.

use super::hermite::{HermiteError, HermiteSpline, Knot, Sample, quintic};
use super::range::minimum_and_maximum;
use alloc::vec::Vec;

/// Value, first and second derivative at a knot.
pub type KnotValues = [f64; 3];

/// A C² spline of quintics between knots at `start + i·step`; constant beyond its ends.
#[derive(Debug, Clone, PartialEq)]
pub struct UniformHermite {
    start: f64,
    step: f64,
    knots: Vec<KnotValues>,
}

impl UniformHermite {
    /// A spline through knots (value, first and second derivative).
    ///
    /// # Errors
    /// Fewer than two knots, a step that is not positive, numbers that are not finite.
    pub fn new(start: f64, step: f64, knots: Vec<KnotValues>) -> Result<Self, HermiteError> {
        if knots.len() < 2 {
            return Err(HermiteError::TooFewKnots { count: knots.len() });
        }
        let finite = |knot: &KnotValues| knot.iter().all(|x| x.is_finite());
        if let Some(index) = knots.iter().position(|knot| !finite(knot)) {
            return Err(HermiteError::NotFinite { index });
        }
        if !start.is_finite() || !step.is_finite() {
            return Err(HermiteError::NotFinite { index: 0 });
        }
        if step <= 0.0 {
            return Err(HermiteError::NotIncreasing { index: 1, at: start + step, previous: start });
        }
        Ok(Self { start, step, knots })
    }

    /// Abscissa of the first knot.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.start
    }

    /// Distance of two knots.
    #[must_use]
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Abscissa of the last knot.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.at(self.knots.len() - 1)
    }

    #[must_use]
    pub fn knots(&self) -> &[KnotValues] {
        &self.knots
    }

    /// Abscissa of a knot.
    #[must_use]
    pub fn at(&self, index: usize) -> f64 {
        self.start + index as f64 * self.step
    }

    /// Value and derivatives; constant before the first and after the last knot.
    #[must_use]
    pub fn sample(&self, at: f64) -> Sample {
        let last = self.knots.len() - 1;
        if at < self.start {
            return Sample { value: self.knots[0][0], ..Sample::default() };
        }
        if at > self.end() {
            return Sample { value: self.knots[last][0], ..Sample::default() };
        }
        #[allow(clippy::cast_possible_truncation, reason = "it lies between the ends")]
        let left = (((at - self.start) / self.step) as usize).min(last - 1);
        quintic(&self.knot(left), &self.knot(left + 1), at)
    }

    /// The same curve in the form in which plans carry motion.
    ///
    /// # Errors
    /// A step so small that two abscissae are the same number.
    pub fn to_hermite(&self) -> Result<HermiteSpline, HermiteError> {
        HermiteSpline::new((0..self.knots.len()).map(|index| self.knot(index)).collect())
    }

    /// Magnitudes that the first three derivatives do not exceed between a knot and the next, see [`Self::hulls`].
    #[must_use]
    pub fn bounds(&self, left: usize) -> [f64; 3] {
        self.hulls(left).map(|(min, max)| min.abs().max(max.abs()))
    }

    /// Least and largest that the first three derivatives are at most between a knot and the next: a derivative lies within the hull of
    /// its Bézier points, which are differences of those of the quintic.
    #[must_use]
    pub fn hulls(&self, left: usize) -> [(f64, f64); 3] {
        let (Some(&[a, a1, a2]), Some(&[b, b1, b2])) = (self.knots.get(left), self.knots.get(left + 1)) else {
            return [(0.0, 0.0); 3];
        };
        let h = self.step;
        let rise = b - a;
        // Differences of neighbouring Bézier points.
        let d = [
            h * a1 / 5.0,
            h * a1 / 5.0 + h * h * a2 / 20.0,
            rise - 2.0 * h * (a1 + b1) / 5.0 + h * h * (b2 - a2) / 20.0,
            h * b1 / 5.0 - h * h * b2 / 20.0,
            h * b1 / 5.0,
        ];
        let d2 = [d[1] - d[0], d[2] - d[1], d[3] - d[2], d[4] - d[3]];
        let d3 = [d2[1] - d2[0], d2[2] - d2[1], d2[3] - d2[2]];
        let hull = |values: &[f64], times: f64, per: f64| {
            let (min, max) = minimum_and_maximum(values.iter().copied());
            (times * min / per, times * max / per)
        };
        [hull(&d, 5.0, h), hull(&d2, 20.0, h * h), hull(&d3, 60.0, h * h * h)]
    }

    fn knot(&self, index: usize) -> Knot {
        let [value, first, second] = self.knots[index];
        Knot { at: self.at(index), value, first, second }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(count: u32, step: f64) -> UniformHermite {
        let knots = (0..count).map(|i| f64::from(i) * step - 1.0);
        let knots = knots.map(|x| [libm::sin(x), libm::cos(x), -libm::sin(x)]).collect();
        UniformHermite::new(-1.0, step, knots).expect("finite knots")
    }

    /// The error of a quintic between its knots is h⁶f⁽⁶⁾/46080, here 3e-10 for h = 0.16.
    #[test]
    fn a_sine_comes_back_between_its_knots() {
        let spline = sine(100, 0.16);
        for i in 0..1500_u32 {
            let x = -0.99 + f64::from(i) * 0.01;
            let sample = spline.sample(x);
            assert!((sample.value - libm::sin(x)).abs() < 4e-10, "{x}");
            assert!((sample.first - libm::cos(x)).abs() < 4e-8, "{x}");
            let other = spline.to_hermite().expect("a positive step").sample(x);
            assert!((sample.value - other.value).abs() < 1e-15, "{x}");
        }
    }

    #[test]
    fn derivatives_stay_below_their_bounds_and_come_near_them() {
        let spline = sine(100, 0.05);
        for left in 0..99 {
            let bounds = spline.bounds(left);
            let mut largest = [0.0_f64; 3];
            for part in 0..=64_u32 {
                let sample = spline.sample(spline.at(left) + f64::from(part) / 64.0 * 0.05);
                for (largest, value) in largest.iter_mut().zip([sample.first, sample.second, sample.third]) {
                    *largest = largest.max(value.abs());
                }
            }
            for (bound, largest) in bounds.iter().zip(largest) {
                assert!(largest <= bound * (1.0 + 1e-9) + 1e-9 && *bound < largest + 2e-3, "{left}: {bound} {largest}");
            }
        }
    }

    #[test]
    fn what_makes_no_spline_is_refused() {
        assert_eq!(UniformHermite::new(0.0, 1.0, Vec::new()), Err(HermiteError::TooFewKnots { count: 0 }));
        let knots = alloc::vec![[0.0; 3], [f64::NAN, 0.0, 0.0]];
        assert_eq!(UniformHermite::new(0.0, 1.0, knots), Err(HermiteError::NotFinite { index: 1 }));
        assert!(UniformHermite::new(0.0, 0.0, alloc::vec![[0.0; 3]; 2]).is_err());
    }
}
