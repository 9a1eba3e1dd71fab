// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Numbers of twice the digits, as unevaluated sums of two floats: for positions that are differenced after C has turned far, where one float keeps too few digits
//! behind its point. Sums and products are those of Dekker and Knuth, exact but for one rounding at 2⁻¹⁰⁴.

/// A number as the sum of a float and of what that float rounded off.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Twofold {
    high: f64,
    low: f64,
}

impl From<f64> for Twofold {
    fn from(value: f64) -> Self {
        Self { high: value, low: 0.0 }
    }
}

impl Twofold {
    /// Sum of two floats, exact.
    #[inline]
    #[must_use]
    pub fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let of_b = high - a;
        Self { high, low: (a - (high - of_b)) + (b - of_b) }
    }

    /// Product of two floats, exact.
    #[inline]
    #[must_use]
    pub fn product(a: f64, b: f64) -> Self {
        let high = a * b;
        let ((a1, a0), (b1, b0)) = (halves(a), halves(b));
        Self { high, low: ((a1 * b1 - high) + a1 * b0 + a0 * b1) + a0 * b0 }
    }

    /// Quotient of two floats.
    #[must_use]
    pub fn quotient(a: f64, b: f64) -> Self {
        let high = a / b;
        let rest = Self::from(a).minus(Self::product(high, b));
        Self::sum(high, rest / b)
    }

    #[inline]
    #[must_use]
    pub fn value(self) -> f64 {
        self.high + self.low
    }

    /// Sum with another number.
    #[inline]
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        let sum = Self::sum(self.high, other.high);
        Self::sum(sum.high, sum.low + (self.low + other.low))
    }

    /// Sum with a float.
    #[inline]
    #[must_use]
    pub fn plus_float(self, other: f64) -> Self {
        let sum = Self::sum(self.high, other);
        Self::sum(sum.high, sum.low + self.low)
    }

    /// Product with another number.
    #[inline]
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        let product = Self::product(self.high, other.high);
        Self::sum(product.high, product.low + (self.high * other.low + self.low * other.high))
    }

    /// Difference from another number, rounded once: of numbers that lie near each other it keeps the digits of both.
    #[inline]
    #[must_use]
    pub fn minus(self, other: Self) -> f64 {
        let difference = Self::sum(self.high, -other.high);
        difference.high + (difference.low + (self.low - other.low))
    }

    /// The largest whole number below it or equal to it, and what is left, in 0..1 but for rounding.
    #[inline]
    #[must_use]
    pub fn floor(self) -> (f64, f64) {
        let whole = libm::floor(self.high);
        let rest = (self.high - whole) + self.low;
        if rest < 0.0 {
            return (whole - 1.0, rest + 1.0);
        }
        (whole, rest)
    }
}

/// A float as the sum of two with half of its digits each.
#[inline]
fn halves(a: f64) -> (f64, f64) {
    /// 2²⁷ + 1.
    const SPLIT: f64 = 134_217_729.0;
    let far = SPLIT * a;
    let high = far - (far - a);
    (high, a - high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::noise::Noise;

    /// Whole numbers of up to 100 bits are computed exactly in `i128`, and here.
    #[allow(clippy::cast_possible_truncation, reason = "whole numbers below 2^53")]
    #[test]
    fn sums_and_products_lose_nothing() {
        let mut noise = Noise::new(3);
        for _ in 0..10_000 {
            let whole = |noise: &mut Noise| libm::round(noise.normal() * (1_u64 << 49) as f64);
            let (a, b, c) = (whole(&mut noise), whole(&mut noise), whole(&mut noise));
            let exact = a as i128 * b as i128 + c as i128;
            let found = Twofold::product(a, b).plus_float(c);
            assert_eq!(found.high as i128 + found.low as i128, exact, "seed 3: {a} · {b} + {c}");
        }
    }

    /// A third of a turn after 2,000 turns: a float keeps it to 2e-12, its difference from the turns to the last digit.
    #[test]
    fn digits_behind_many_turns_are_kept() {
        let turns = Twofold::product(2000.0, crate::math::units::TURN_RAD);
        let third = crate::math::units::TURN_RAD / 3.0;
        assert_eq!(turns.plus_float(third).minus(turns).to_bits(), third.to_bits());
        let share = Twofold::quotient(1.0, 3.0);
        let one = share.times(Twofold::from(3.0));
        assert!(one.minus(Twofold::from(1.0)).abs() < 1e-31, "{one:?}");
    }

    #[test]
    fn a_floor_is_below_even_where_the_high_part_is_whole() {
        assert_eq!(Twofold { high: 3.0, low: -1e-20 }.floor().0.to_bits(), 2.0_f64.to_bits());
        assert_eq!(Twofold::sum(-0.25, 1e-20).floor(), (-1.0, 0.75));
    }
}
