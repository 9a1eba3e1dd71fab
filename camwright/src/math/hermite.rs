// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Quintic Hermite splines: value, first and second derivative given at knots, C² throughout.
//!
//! One form serves every motion law of the project: constant-jerk phases of point-to-point moves and ramps are cubics
//! and hence exact, speed plans over time, infeed over angle, and trajectories of ROS clients with accelerations.

use alloc::vec::Vec;
use thiserror::Error;

/// A knot of a [`HermiteSpline`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knot {
    /// Abscissa (s or rad).
    pub at: f64,
    pub value: f64,
    pub first: f64,
    pub second: f64,
}

/// Value and derivatives of a spline at one abscissa.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sample {
    pub value: f64,
    pub first: f64,
    pub second: f64,
    pub third: f64,
}

crate::snapshot!(Sample { value, first, second, third } on {});

impl Sample {
    /// The sample of a function that is stretched along its abscissa by a factor: f(x / by).
    #[must_use]
    pub fn stretched(self, by: f64) -> Self {
        Self {
            value: self.value,
            first: self.first / by,
            second: self.second / (by * by),
            third: self.third / (by * by * by),
        }
    }
}

/// Why knots do not make a spline.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum HermiteError {
    /// Fewer than two knots.
    #[error("a spline needs at least 2 knots, not {count}")]
    TooFewKnots {
        /// Number of knots given.
        count: usize,
    },
    /// An abscissa does not increase.
    #[error("knot {index}: abscissa {at} does not increase (previous {previous})")]
    NotIncreasing {
        /// Index of the knot.
        index: usize,
        at: f64,
        previous: f64,
    },
    /// A number is not finite.
    #[error("knot {index}: not a finite number")]
    NotFinite {
        /// Index of the knot.
        index: usize,
    },
}

/// A quintic Hermite spline over increasing knots; constant beyond its ends.
#[derive(Debug, Clone, PartialEq)]
pub struct HermiteSpline {
    knots: Vec<Knot>,
}

impl HermiteSpline {
    /// A spline through knots.
    ///
    /// # Errors
    /// Fewer than two knots, abscissae that do not increase, numbers that are not finite.
    pub fn new(knots: Vec<Knot>) -> Result<Self, HermiteError> {
        if knots.len() < 2 {
            return Err(HermiteError::TooFewKnots { count: knots.len() });
        }
        for (index, knot) in knots.iter().enumerate() {
            if ![knot.at, knot.value, knot.first, knot.second].iter().all(|x| x.is_finite()) {
                return Err(HermiteError::NotFinite { index });
            }
            if index > 0 && knot.at <= knots[index - 1].at {
                return Err(HermiteError::NotIncreasing { index, at: knot.at, previous: knots[index - 1].at });
            }
        }
        Ok(Self { knots })
    }

    #[must_use]
    pub fn knots(&self) -> &[Knot] {
        &self.knots
    }

    #[must_use]
    pub fn start(&self) -> f64 {
        self.knots[0].at
    }

    #[must_use]
    pub fn end(&self) -> f64 {
        self.knots[self.knots.len() - 1].at
    }

    /// Value and derivatives; before the first and after the last knot the value is constant.
    #[must_use]
    pub fn sample(&self, at: f64) -> Sample {
        let last = self.knots[self.knots.len() - 1];
        if at <= self.knots[0].at {
            let first = self.knots[0];
            let inside = at >= first.at;
            return Sample {
                value: first.value,
                first: if inside { first.first } else { 0.0 },
                second: if inside { first.second } else { 0.0 },
                third: 0.0,
            };
        }
        if at >= last.at {
            let inside = at <= last.at;
            return Sample {
                value: last.value,
                first: if inside { last.first } else { 0.0 },
                second: if inside { last.second } else { 0.0 },
                third: 0.0,
            };
        }
        // An abscissa that is not a number lies nowhere, and gives what is not a number.
        let right = self.knots.partition_point(|knot| knot.at <= at).max(1);
        quintic(&self.knots[right - 1], &self.knots[right], at)
    }

    /// The same with a constant added.
    #[must_use]
    pub fn raised(&self, by: f64) -> Self {
        Self { knots: self.knots.iter().map(|knot| Knot { value: knot.value + by, ..*knot }).collect() }
    }

    /// Control points of all its pieces, as quintics of Bernstein: it lies within their hull.
    pub fn control_points(&self) -> impl Iterator<Item = f64> + '_ {
        self.knots.windows(2).flat_map(|pair| {
            let (left, right) = (pair[0], pair[1]);
            let h = right.at - left.at;
            [
                left.value,
                left.value + 0.2 * h * left.first,
                left.value + 0.4 * h * left.first + 0.05 * h * h * left.second,
                right.value - 0.4 * h * right.first + 0.05 * h * h * right.second,
                right.value - 0.2 * h * right.first,
                right.value,
            ]
        })
    }

    /// Abscissa at which a non-decreasing spline has a value, by bisection.
    #[must_use]
    pub fn place_of(&self, value: f64) -> f64 {
        let (mut low, mut high) = (self.start(), self.end());
        // The knot right of an abscissa between `low` and `high` is one of these, or the next.
        let (mut from, mut to) = (0, self.knots.len());
        while high - low > 1e-12 * (1.0 + high) {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            let right = from + self.knots[from..to].partition_point(|knot| knot.at <= middle);
            if quintic(&self.knots[right - 1], &self.knots[right], middle).value < value {
                (low, from) = (middle, right);
            } else {
                (high, to) = (middle, right);
            }
        }
        0.5 * (low + high)
    }
}

/// The quintic between two knots, written around the left one so that a constant stays exactly constant.
pub(crate) fn quintic(left: &Knot, right: &Knot, at: f64) -> Sample {
    let h = right.at - left.at;
    let u = at - left.at;
    // What the right knot asks beyond the left knot's own Taylor parabola; p = c3 u³ + c4 u⁴ + c5 u⁵ must supply it.
    let value = right.value - (left.value + h * (left.first + 0.5 * h * left.second));
    let first = right.first - (left.first + h * left.second);
    let second = right.second - left.second;
    let c3 = (10.0 * value - 4.0 * h * first + 0.5 * h * h * second) / (h * h * h);
    let c4 = (-15.0 * value + 7.0 * h * first - h * h * second) / (h * h * h * h);
    let c5 = (6.0 * value - 3.0 * h * first + 0.5 * h * h * second) / (h * h * h * h * h);
    Sample {
        value: left.value + u * (left.first + u * (0.5 * left.second + u * (c3 + u * (c4 + u * c5)))),
        first: left.first + u * (left.second + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5))),
        second: left.second + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5)),
        third: 6.0 * c3 + u * (24.0 * c4 + u * 60.0 * c5),
    }
}

/// Way done at share `s` of a step: the cubic from 0 to `way` with these slopes by the share at its ends; exactly `way` at 1.
#[must_use]
pub fn cubic_path(s: f64, way: f64, slope_from: f64, slope_to: f64) -> f64 {
    let s2 = s * s;
    let s3 = s2 * s;
    slope_from * (s - 2.0 * s2 + s3) + way * (3.0 * s2 - 2.0 * s3) + slope_to * (s3 - s2)
}

/// The derivative of [`cubic_path`] by the share.
#[must_use]
pub fn cubic_slope(s: f64, way: f64, slope_from: f64, slope_to: f64) -> f64 {
    slope_from * (1.0 - 4.0 * s + 3.0 * s * s) + way * (6.0 * s - 6.0 * s * s) + slope_to * (3.0 * s * s - 2.0 * s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    /// A quintic polynomial is reproduced exactly between its own knots.
    #[test]
    fn quintic_polynomial_is_reproduced() {
        let p = |x: f64| 1.0 + x * (2.0 + x * (-3.0 + x * (0.5 + x * (0.25 - x * 0.125))));
        let p1 = |x: f64| 2.0 + x * (-6.0 + x * (1.5 + x * (1.0 - x * 0.625)));
        let p2 = |x: f64| -6.0 + x * (3.0 + x * (3.0 - x * 2.5));
        let knot = |x: f64| Knot { at: x, value: p(x), first: p1(x), second: p2(x) };
        let spline = HermiteSpline::new(vec![knot(0.0), knot(0.7), knot(2.0)]).expect("knots increase");
        for i in 0..=200 {
            let x = 2.0 * f64::from(i) / 200.0;
            let sample = spline.sample(x);
            assert!((sample.value - p(x)).abs() < 1e-12, "{x}");
            assert!((sample.first - p1(x)).abs() < 1e-11, "{x}");
            assert!((sample.second - p2(x)).abs() < 1e-10, "{x}");
        }
    }

    /// The place of a value is that of a bisection which looks for the knots anew at every step, to the bit.
    #[test]
    fn a_place_is_that_of_plain_bisection() {
        let cubic = |x: f64| Knot { at: x, value: x * x * x + x, first: 3.0 * x * x + 1.0, second: 6.0 * x };
        let knots = (0..40).map(|i| cubic(f64::from(i * i) * 0.003 - 1.0)).collect();
        let spline = HermiteSpline::new(knots).expect("knots increase");
        let plain = |value: f64| {
            let (mut low, mut high) = (spline.start(), spline.end());
            while high - low > 1e-12 * (1.0 + high) {
                let middle = 0.5 * (low + high);
                if spline.sample(middle).value < value { low = middle } else { high = middle }
            }
            0.5 * (low + high)
        };
        for i in -10..500 {
            let value = cubic(f64::from(i) * 0.01 - 1.0).value;
            assert_eq!(spline.place_of(value).to_bits(), plain(value).to_bits(), "{value}");
        }
    }

    /// s³ − 2s has way −1 and slopes −2 and 1 over a step.
    #[test]
    fn a_cubic_is_reproduced_with_its_slope_and_ends_exactly() {
        for i in 0..=20 {
            let s = f64::from(i) / 20.0;
            assert!((cubic_path(s, -1.0, -2.0, 1.0) - s * (s * s - 2.0)).abs() < 1e-15, "{s}");
            assert!((cubic_slope(s, -1.0, -2.0, 1.0) - (3.0 * s * s - 2.0)).abs() < 1e-15, "{s}");
        }
        assert_eq!(cubic_path(1.0, 0.1, 0.7, -0.3).to_bits(), 0.1_f64.to_bits());
    }

    #[test]
    fn an_abscissa_that_does_not_increase_is_refused() {
        let knot = |at: f64| Knot { at, value: 0.0, first: 0.0, second: 0.0 };
        assert_eq!(
            HermiteSpline::new(vec![knot(0.0), knot(1.0), knot(1.0)]),
            Err(HermiteError::NotIncreasing { index: 2, at: 1.0, previous: 1.0 })
        );
    }
}
