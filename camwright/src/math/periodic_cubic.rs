// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The periodic cubic spline through values over one turn: C², the curve of the textbooks.

use super::banded::CyclicBand;
use super::hermite::Sample;
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;

/// A cubic between every two of n values at the angles i·2π/n, with continuous second derivatives M:
/// M(i − 1) + 4M(i) + M(i + 1) = 6 δ²y(i)/h². Its third derivative is constant between two values and jumps at each.
#[derive(Debug, Clone, PartialEq)]
pub struct PeriodicCubic {
    values: Vec<f64>,
    seconds: Vec<f64>,
}

impl PeriodicCubic {
    pub const MIN_VALUES: usize = 3;

    /// The spline through values; `None` for fewer than [`Self::MIN_VALUES`] or one that is not finite.
    #[must_use]
    pub fn interpolate(values: Vec<f64>) -> Option<Self> {
        let n = values.len();
        if n < Self::MIN_VALUES || values.iter().any(|value| !value.is_finite()) {
            return None;
        }
        let step = TURN_RAD / n as f64;
        let mut seconds: Vec<f64> = (0..n)
            .map(|i| ((values[(i + 1) % n] - values[i]) - (values[i] - values[(i + n - 1) % n])) / (step * step))
            .collect();
        CyclicBand::<2>::circulant(n, [4.0 / 6.0, 1.0 / 6.0]).factor().ok()?.solve(&mut seconds);
        Some(Self { values, seconds })
    }

    #[must_use]
    pub fn knots(&self) -> usize {
        self.values.len()
    }

    /// Value and derivatives with respect to the angle (rad); at a knot the third is that of the arc behind it.
    #[must_use]
    pub fn sample(&self, angle_rad: f64) -> Sample {
        let n = self.values.len();
        let step = TURN_RAD / n as f64;
        let x = angle_rad / step;
        let floor = libm::floor(x);
        let u = x - floor;
        #[allow(clippy::cast_possible_truncation, reason = "angles are far inside i64 knots")]
        let base = (floor as i64).rem_euclid(i64::try_from(n).unwrap_or(i64::MAX));
        let left = usize::try_from(base).unwrap_or(0);
        let right = (left + 1) % n;
        let (a, b, v) = (self.seconds[left] * step * step, self.seconds[right] * step * step, 1.0 - u);
        let rise = self.values[right] - self.values[left];
        Sample {
            value: self.values[left] + u * rise + (v * (v * v - 1.0) * a + u * (u * u - 1.0) * b) / 6.0,
            first: (rise + ((1.0 - 3.0 * v * v) * a + (3.0 * u * u - 1.0) * b) / 6.0) / step,
            second: v * self.seconds[left] + u * self.seconds[right],
            third: (self.seconds[right] - self.seconds[left]) / step,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(n: u32) -> PeriodicCubic {
        let at = |i: u32| f64::from(i) * TURN_RAD / f64::from(n);
        PeriodicCubic::interpolate((0..n).map(|i| libm::sin(at(i))).collect()).expect("finite values")
    }

    #[test]
    fn it_goes_through_its_values_and_bends_as_they_do() {
        for n in [3, 4, 5, 72, 361] {
            let spline = sine(n);
            for i in 0..n {
                let angle = f64::from(i) * TURN_RAD / f64::from(n);
                assert!((spline.sample(angle).value - libm::sin(angle)).abs() < 1e-13, "{n} {i}");
            }
        }
        let spline = sine(360);
        for i in 0..1000 {
            let angle = f64::from(i) * 0.00721;
            let sample = spline.sample(angle);
            assert!((sample.value - libm::sin(angle)).abs() < 1e-9, "{angle}");
            assert!((sample.first - libm::cos(angle)).abs() < 1e-6, "{angle}");
            assert!((sample.second + libm::sin(angle)).abs() < 1e-4, "{angle}");
            assert!((sample.third + libm::cos(angle)).abs() < 2e-2, "{angle}");
        }
    }

    #[test]
    fn acceleration_is_continuous_at_every_value() {
        let spline =
            PeriodicCubic::interpolate((0..50).map(|i| libm::sin(f64::from(i * i))).collect()).expect("values");
        for i in 0..50 {
            let angle = f64::from(i) * TURN_RAD / 50.0;
            let (before, after) = (spline.sample(angle - 1e-10), spline.sample(angle + 1e-10));
            assert!((before.first - after.first).abs() < 1e-6 && (before.second - after.second).abs() < 1e-4, "{i}");
        }
    }

    #[test]
    fn what_is_no_curve_is_refused() {
        assert_eq!(PeriodicCubic::interpolate([1.0, 2.0].to_vec()), None);
        assert_eq!(PeriodicCubic::interpolate([1.0, f64::NAN, 2.0].to_vec()), None);
    }
}
