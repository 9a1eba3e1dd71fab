// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The harmonics of values at equal steps of a turn.

use crate::math::units::TURN_RAD;
use alloc::vec::Vec;

/// Mean and harmonics, the cosine's amplitude and the sine's.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FourierSeries {
    mean: f64,
    harmonics: Vec<(f64, f64)>,
}

/// Cosine and sine at equal steps of a turn.
fn circle(count: usize) -> Vec<(f64, f64)> {
    let angle = |k: usize| TURN_RAD * k as f64 / count as f64;
    (0..count).map(|k| (libm::cos(angle(k)), libm::sin(angle(k)))).collect()
}

impl FourierSeries {
    /// The harmonics of values up to `max`, or as many as they have.
    pub(super) fn from_values(values: &[f64], max: usize) -> Self {
        let count = values.len();
        let share = 1.0 / count as f64;
        // From the first value, so that a radius of 20 mm does not cost the digits of its runout.
        let level = values[0];
        let mean = level + share * values.iter().map(|value| value - level).sum::<f64>();
        let circle = circle(count);
        let harmonics = (1..=max.min(count / 2))
            .map(|h| {
                let (mut cos, mut sin, mut k) = (0.0, 0.0, 0);
                for value in values {
                    cos += (value - mean) * circle[k].0;
                    sin += (value - mean) * circle[k].1;
                    k = (k + h) % count;
                }
                // The highest harmonic of an even number of values is a cosine alone, and met once instead of twice.
                if 2 * h == count { (cos * share, 0.0) } else { (2.0 * cos * share, 2.0 * sin * share) }
            })
            .collect();
        Self { mean, harmonics }
    }

    /// From a mean, and cosine's and sine's amplitude of every harmonic from the first on.
    pub(super) const fn from_parts(mean: f64, harmonics: Vec<(f64, f64)>) -> Self {
        Self { mean, harmonics }
    }

    /// The values at `count` equal steps.
    pub(super) fn values(&self, count: usize) -> Vec<f64> {
        let circle = circle(count);
        (0..count)
            .map(|place| {
                let mut value = 0.0;
                let mut k = 0;
                for (cos, sin) in &self.harmonics {
                    k = (k + place) % count;
                    value += cos * circle[k].0 + sin * circle[k].1;
                }
                self.mean + value
            })
            .collect()
    }

    /// Amplitude of a harmonic; 0 of one that it does not hold.
    pub(super) fn amplitude(&self, harmonic: usize) -> f64 {
        let held = harmonic.checked_sub(1).and_then(|i| self.harmonics.get(i));
        held.map_or(0.0, |(cos, sin)| libm::hypot(*cos, *sin))
    }

    /// The series g of which this one is v, where g(φ) − μ g(φ − δ) = v(φ) and |μ| < 1.
    pub(super) fn without_echo(mut self, echo: f64, delay_rad: f64) -> Self {
        self.mean /= 1.0 - echo;
        for (i, (cos, sin)) in self.harmonics.iter_mut().enumerate() {
            // cos − i sin is the complex amplitude; that of the echo is turned by e^(−ihδ).
            let angle = (i + 1) as f64 * delay_rad;
            let (re, im) = (1.0 - echo * libm::cos(angle), echo * libm::sin(angle));
            let square = re * re + im * im;
            (*cos, *sin) = ((*cos * re - *sin * im) / square, (*sin * re + *cos * im) / square);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_of_all_harmonics_gives_its_values_back() {
        for count in [8_usize, 9, 72, 101] {
            let values: Vec<f64> = (0..count).map(|i| 20.0 + libm::sin((i * i) as f64)).collect();
            for (found, wanted) in FourierSeries::from_values(&values, count).values(count).iter().zip(&values) {
                assert!((found - wanted).abs() < 1e-12, "{count}: {found} {wanted}");
            }
        }
        let lobes: Vec<f64> = (0..72).map(|i| 20.0 + 3e-3 * libm::cos(3.0 * TURN_RAD * f64::from(i) / 72.0)).collect();
        let series = FourierSeries::from_values(&lobes, 5);
        assert!((series.amplitude(3) - 3e-3).abs() < 1e-15 && series.amplitude(2) < 1e-15);
        assert!(series.amplitude(0).abs() + series.amplitude(9) < 1e-300);
    }

    #[test]
    fn an_echo_is_taken_out() {
        let (echo, delay, count) = (-0.6, 0.9, 360);
        let g = |phi: f64| 1.0 + libm::sin(phi) - 0.3 * libm::cos(3.0 * phi + 0.4);
        let at = |k: usize| TURN_RAD * k as f64 / count as f64;
        let measured: Vec<f64> = (0..count).map(|k| g(at(k)) - echo * g(at(k) - delay)).collect();
        let found = FourierSeries::from_values(&measured, 15).without_echo(echo, delay).values(count);
        for (k, found) in found.iter().enumerate() {
            assert!((found - g(at(k))).abs() < 1e-12, "{k}: {found} {}", g(at(k)));
        }
    }
}
