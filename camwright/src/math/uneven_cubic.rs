// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The periodic cubic spline through values at any angles of a turn.

use super::banded::CyclicBand;
use crate::math::units::{TURN_RAD, wrap_turn};
use alloc::vec::Vec;

/// A cubic between every two of n values at rising angles of one turn, with continuous second derivatives M:
/// hᵢ₋₁M(i − 1) + 2(hᵢ₋₁ + hᵢ)M(i) + hᵢM(i + 1) = 6(dᵢ − dᵢ₋₁), d the slopes of the chords.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct UnevenCubic {
    angles: Vec<f64>,
    values: Vec<f64>,
    seconds: Vec<f64>,
}

impl UnevenCubic {
    /// The spline through points (rad, value), their angles rising and less than a turn from first to last; `None` where they do not, or
    /// are not finite, or fewer than three.
    pub(crate) fn interpolate(points: &[(f64, f64)]) -> Option<Self> {
        let n = points.len();
        let (angles, values): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
        if n < 3 || values.iter().any(|value| !value.is_finite()) {
            return None;
        }
        let width = |i: usize| if i + 1 < n { angles[i + 1] - angles[i] } else { angles[0] + TURN_RAD - angles[i] };
        let widths: Vec<f64> = (0..n).map(width).collect();
        if widths.iter().any(|width| width.is_nan() || *width <= 0.0) {
            return None;
        }
        let slope = |i: usize| (values[(i + 1) % n] - values[i]) / widths[i];
        let mut band = CyclicBand::<2>::circulant(n, [0.0; 2]);
        for (i, row) in band.rows_mut().iter_mut().enumerate() {
            *row = [(widths[(i + n - 1) % n] + widths[i]) / 3.0, widths[i] / 6.0];
        }
        let mut seconds: Vec<f64> = (0..n).map(|i| slope(i) - slope((i + n - 1) % n)).collect();
        band.factor().ok()?.solve(&mut seconds);
        Some(Self { angles, values, seconds })
    }

    /// Value at an angle (rad).
    pub(crate) fn value(&self, angle_rad: f64) -> f64 {
        let n = self.angles.len();
        let angle = self.angles[0] + wrap_turn(angle_rad - self.angles[0]);
        let left = self.angles.partition_point(|known| *known <= angle).max(1) - 1;
        let (right, end) =
            if left + 1 < n { (left + 1, self.angles[left + 1]) } else { (0, self.angles[0] + TURN_RAD) };
        let width = end - self.angles[left];
        let (u, v) = ((angle - self.angles[left]) / width, (end - angle) / width);
        let (a, b) = (self.seconds[left] * width * width, self.seconds[right] * width * width);
        v * self.values[left] + u * self.values[right] + (v * (v * v - 1.0) * a + u * (u * u - 1.0) * b) / 6.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uneven(n: u32) -> Vec<(f64, f64)> {
        let at = |i: u32| (f64::from(i) + 0.3 * libm::sin(f64::from(i) * 1.7)) * TURN_RAD / f64::from(n) - 1.0;
        (0..n).map(|i| (at(i), libm::sin(2.0 * at(i)))).collect()
    }

    /// Through its points, and between them with an error of the fourth order.
    #[test]
    fn a_sine_at_uneven_angles_comes_back() {
        let error = |n: u32| {
            let spline = UnevenCubic::interpolate(&uneven(n)).unwrap();
            for (angle, value) in uneven(n) {
                assert!((spline.value(angle) - value).abs() < 1e-13, "{angle}");
                assert!((spline.value(angle + TURN_RAD) - value).abs() < 1e-12, "{angle}");
            }
            (0..1000)
                .map(|i| 0.006_3 * f64::from(i))
                .map(|a| (spline.value(a) - libm::sin(2.0 * a)).abs())
                .fold(0.0, f64::max)
        };
        assert!(error(80) < 1e-4 && error(160) < error(80) / 8.0, "{} {}", error(80), error(160));
    }

    #[test]
    fn what_makes_no_spline_is_refused() {
        assert_eq!(UnevenCubic::interpolate(&[(0.0, 1.0), (1.0, 2.0)]), None);
        assert_eq!(UnevenCubic::interpolate(&[(0.0, 1.0), (1.0, 2.0), (1.0, 2.0)]), None);
        assert_eq!(UnevenCubic::interpolate(&[(0.0, 1.0), (1.0, f64::NAN), (2.0, 2.0)]), None);
        assert_eq!(UnevenCubic::interpolate(&[(0.0, 1.0), (1.0, 1.0), (7.0, 2.0)]), None);
    }
}
