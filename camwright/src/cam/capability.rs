// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Capability: how well a batch keeps within a tolerance, by the spread of its parts.
//!
//! With the mean m and the standard deviation s = √(Σ(xᵢ − m)²/(n − 1)) of n parts and the limits L and U of what is measured
//!
//! ```text
//! Cp  = (U − L)/(6 s)                      what the spread would allow if the mean stood in the middle
//! Cpk = min(U − m, m − L)/(3 s)            what it allows where the mean stands
//! ```
//!
//! Where nothing but one limit is a limit (form is never below 0) there is no Cp, and Cpk is that of this side. They are the indices of
//! ISO 22514-2 for a normal distribution, estimated from a batch in its order; of a few parts they are rough: of five the true Cpk may
//! with 95 % certainty be anything from 0.35 to 1.67 times what is found (chi-square of 4 degrees of freedom).

use crate::math::range::minimum_and_maximum;
use thiserror::Error;

/// Why there is no capability.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum CapabilityError {
    /// One part has no spread.
    #[error("a capability needs at least 2 parts, there are {count}")]
    TooFew {
        /// Number of values.
        count: usize,
    },
    /// A measured value or a limit that is none.
    #[error("{value} is not a number that can be judged")]
    NotFinite { value: f64 },
    /// Limits the wrong way round.
    #[error("the lower limit {lower} is not below the upper one, {upper}")]
    NoTolerance { lower: f64, upper: f64 },
}

/// Mean, spread and capability of a batch, in the unit of what was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capability {
    pub count: usize,
    pub mean: f64,
    /// Standard deviation of the parts, with n − 1.
    pub deviation: f64,
    pub span: (f64, f64),
    /// Cp; `None` with one limit, or where the parts do not differ.
    pub cp: Option<f64>,
    /// Cpk; `None` where the parts do not differ.
    pub cpk: Option<f64>,
}

impl Capability {
    /// Capability of a value measured on every part, against an upper limit and an optional lower limit.
    ///
    /// # Errors
    /// Fewer than 2 parts, values that are no numbers, limits the wrong way round.
    pub fn from_values(values: &[f64], lower: Option<f64>, upper: f64) -> Result<Self, CapabilityError> {
        let limits = lower.into_iter().chain([upper]);
        if let Some(value) = values.iter().copied().chain(limits).find(|value| !value.is_finite()) {
            return Err(CapabilityError::NotFinite { value });
        }
        if let Some(lower) = lower.filter(|lower| *lower >= upper) {
            return Err(CapabilityError::NoTolerance { lower, upper });
        }
        if values.len() < 2 {
            return Err(CapabilityError::TooFew { count: values.len() });
        }
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
        let deviation = libm::sqrt(squares / (count - 1.0));
        let span = minimum_and_maximum(values.iter().copied());
        // What rounding leaves of equal values is no spread.
        let spreads = deviation > 1e-12 * (mean.abs() + upper.abs());
        let nearest = lower.map_or(upper - mean, |lower| f64::min(upper - mean, mean - lower));
        Ok(Self {
            count: values.len(),
            mean,
            deviation,
            span,
            cp: lower.filter(|_| spreads).map(|lower| (upper - lower) / (6.0 * deviation)),
            cpk: spreads.then(|| nearest / (3.0 * deviation)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1, 2, 3, 4, 5: mean 3, s = √2.5. Between 0 and 10: Cp = 10/(6 √2.5), Cpk = 3/(3 √2.5).
    #[test]
    fn five_parts_have_the_capability_of_the_closed_form() {
        let found = Capability::from_values(&[1.0, 2.0, 3.0, 4.0, 5.0], Some(0.0), 10.0).unwrap();
        let s = libm::sqrt(2.5);
        assert!((found.mean - 3.0).abs() < 1e-15 && (found.deviation - s).abs() < 1e-15);
        assert!((found.cp.unwrap() - 10.0 / (6.0 * s)).abs() < 1e-14);
        assert!((found.cpk.unwrap() - 1.0 / s).abs() < 1e-14);
        assert_eq!((found.count, found.span), (5, (1.0, 5.0)));
    }

    /// ±d about the middle of ±t: s = d √(n/(n − 1)), and both indices are t/(3 s).
    #[test]
    fn a_centred_batch_has_the_same_cp_and_cpk() {
        let (d, t) = (0.4, 5.0);
        let found = Capability::from_values(&[d, -d, d, -d], Some(-t), t).unwrap();
        let wanted = t / (3.0 * d * libm::sqrt(4.0 / 3.0));
        assert!((found.cp.unwrap() - wanted).abs() < 1e-14 && (found.cpk.unwrap() - wanted).abs() < 1e-14);
        let off = Capability::from_values(&[d + 1.0, 1.0 - d, d + 1.0, 1.0 - d], Some(-t), t).unwrap();
        assert!((off.cp.unwrap() - wanted).abs() < 1e-14 && (off.cpk.unwrap() - wanted * 0.8).abs() < 1e-14);
    }

    #[test]
    fn one_limit_has_no_cp_and_a_mean_beyond_it_a_negative_cpk() {
        let found = Capability::from_values(&[5.5, 6.5], None, 5.0).unwrap();
        assert!(found.cp.is_none() && (found.cpk.unwrap() + 1.0 / (3.0 * libm::sqrt(0.5))).abs() < 1e-14);
    }

    #[test]
    fn equal_parts_have_no_index_and_one_part_no_spread() {
        let same = Capability::from_values(&[0.1 + 0.2, 0.3, 0.3], Some(-5.0), 5.0).unwrap();
        assert_eq!((same.cp, same.cpk), (None, None));
        assert_eq!(Capability::from_values(&[1.0], None, 5.0), Err(CapabilityError::TooFew { count: 1 }));
        assert_eq!(
            Capability::from_values(&[1.0, 2.0], Some(5.0), 5.0),
            Err(CapabilityError::NoTolerance { lower: 5.0, upper: 5.0 })
        );
        assert!(matches!(Capability::from_values(&[1.0, f64::NAN], None, 5.0), Err(CapabilityError::NotFinite { .. })));
    }
}
