// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Noise that repeats: normally distributed numbers from a seed.

use crate::math::snapshot::{Snapshot, SnapshotCodec, SnapshotError};
use crate::math::units::TURN_RAD;

/// A source of normally distributed numbers with mean 0 and standard deviation 1: Box and Muller's transform of Steele, Lea and
/// Flood's `SplitMix64`. The same seed gives the same numbers on every machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Noise {
    state: u64,
}

impl Snapshot for Noise {
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        codec.bits(&mut self.state)
    }
}

impl Noise {
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// Above 0 and up to 1.
    pub fn uniform(&mut self) -> f64 {
        ((self.bits() >> 11) + 1) as f64 / (1_u64 << 53) as f64
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// Cheaper, for what needs one in every servo step: the sum of four equally distributed numbers of 16 bits, mean 0, standard
    /// deviation 1, never beyond ±2√3.
    pub(crate) fn quick(&mut self) -> f64 {
        // Of four numbers from 0 to 65,535: their mean, and √(4 (2³² − 1)/12).
        const MEAN: f64 = 131_070.0;
        const DEVIATION: f64 = 37_837.227_2;
        let bits = self.bits();
        let sum = (bits & 0xffff) + (bits >> 16 & 0xffff) + (bits >> 32 & 0xffff) + (bits >> 48);
        (sum as f64 - MEAN) / DEVIATION
    }

    /// Normally distributed, mean 0 and standard deviation 1.
    pub fn normal(&mut self) -> f64 {
        let (radius, turn) = (libm::sqrt(-2.0 * libm::log(self.uniform())), self.uniform());
        radius * libm::cos(TURN_RAD * turn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean, variance, third and fourth moment of the normal distribution within four standard errors of 100,000 numbers.
    #[test]
    fn its_moments_are_those_of_the_normal_distribution() {
        let seed = 20_261_121;
        let mut quick = Noise::new(seed);
        let mut noise = Noise::new(seed);
        let n = 100_000;
        let mut quick_moments = [0.0; 4];
        for _ in 0..n {
            let value = quick.quick();
            assert!(value.abs() < 3.465);
            for (power, moment) in (1..).zip(&mut quick_moments) {
                *moment += value.powi(power) / f64::from(n);
            }
        }
        // Fourth moment of four: 3 − 6/5/4.
        for (moment, (wanted, spread)) in
            quick_moments.into_iter().zip([(0.0, 1.0), (1.0, 1.3), (0.0, 3.3), (2.7, 7.0)])
        {
            assert!(
                (moment - wanted).abs() < 4.0 * spread / f64::from(n).sqrt(),
                "seed {seed}: {moment}, not {wanted}"
            );
        }
        let mut moments = [0.0; 4];
        for _ in 0..n {
            let value = noise.normal();
            assert!(value.is_finite());
            for (power, moment) in (1..).zip(&mut moments) {
                *moment += value.powi(power) / f64::from(n);
            }
        }
        let error = f64::from(n).sqrt().recip();
        for (moment, (wanted, spread)) in moments.into_iter().zip([(0.0, 1.0), (1.0, 1.42), (0.0, 3.88), (3.0, 9.8)]) {
            assert!((moment - wanted).abs() < 4.0 * spread * error, "seed {seed}: {moment}, not {wanted}");
        }
    }
}
