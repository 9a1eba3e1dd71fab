// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Numbers that are computed side by side: written so that the compiler uses vector instructions, with the bits of one after another.

use core::array;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};
use wide::f64x2;

/// Numbers side by side.
pub(crate) const LANES: usize = 4;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lanes(pub(crate) [f64; LANES]);

impl Lanes {
    pub(crate) const ZERO: Lanes = Lanes([0.0; LANES]);

    #[inline(always)]
    pub(crate) const fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    /// The numbers from a place on; the caller has that many.
    #[inline(always)]
    pub(crate) fn load(values: &[f64], from: usize) -> Self {
        let values = &values[from..from + LANES];
        Self(array::from_fn(|lane| values[lane]))
    }

    /// The larger of each; neither is NaN.
    #[inline(always)]
    pub(crate) fn larger(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    /// The smaller of each; neither is NaN.
    #[inline(always)]
    pub(crate) fn smaller(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        Self(square_roots(self.0))
    }

    #[inline(always)]
    pub(crate) fn sum(self) -> f64 {
        let [a, b, c, d] = self.0;
        (a + b) + (c + d)
    }

    #[inline(always)]
    pub(crate) fn largest(self) -> f64 {
        self.0.into_iter().fold(f64::NEG_INFINITY, |a, b| if b > a { b } else { a })
    }

    #[inline(always)]
    fn zip(self, other: Self, with: impl Fn(f64, f64) -> f64) -> Self {
        Self(array::from_fn(|lane| with(self.0[lane], other.0[lane])))
    }
}

/// Square roots side by side, with the bits of `libm`, whose instruction for one of them the compiler cannot join with others.
#[inline(always)]
pub(crate) fn square_roots<const N: usize>(mut values: [f64; N]) -> [f64; N] {
    let (pairs, rest) = values.as_chunks_mut::<2>();
    for pair in pairs {
        *pair = f64x2::new(*pair).sqrt().to_array();
    }
    rest.iter_mut().for_each(|value| *value = libm::sqrt(*value));
    values
}

impl Add for Lanes {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Lanes {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Lanes {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Mul<Lanes> for f64 {
    type Output = Lanes;

    #[inline(always)]
    fn mul(self, lanes: Lanes) -> Lanes {
        Lanes::splat(self) * lanes
    }
}

impl Div for Lanes {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
}

impl Neg for Lanes {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|a| -a))
    }
}

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Lanes {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every lane is what a single number would be.
    #[test]
    fn lanes_have_the_bits_of_single_numbers() {
        let (a, b) = ([0.1, -2.0, 3e300, 7.0], [0.3, 1e-9, -5.0, 7.0]);
        let (x, y) = (Lanes(a), Lanes(b));
        for lane in 0..LANES {
            let (p, q) = (a[lane], b[lane]);
            let same = |lanes: Lanes, single: f64| assert_eq!(lanes.0[lane].to_bits(), single.to_bits());
            same(x + y, p + q);
            same(x - y, p - q);
            same(x * y, p * q);
            same(x / y, p / q);
            same(-x, -p);
            same(x.larger(y), p.max(q));
            same(x.smaller(y), p.min(q));
            same((x * x).sqrt(), libm::sqrt(p * p));
        }
        let odd = square_roots([0.0, 2.0, 5e-324, 1e-310, 3.0]);
        for (root, square) in odd.into_iter().zip([0.0, 2.0, 5e-324, 1e-310, 3.0]) {
            assert_eq!(root.to_bits(), libm::sqrt(square).to_bits());
        }
        let mut bits = 1_u64;
        for _ in 0..10_000 {
            let squares: [f64; 4] = array::from_fn(|_| {
                // xorshift64 by Marsaglia; the sign stays positive.
                bits ^= bits << 13;
                bits ^= bits >> 7;
                bits ^= bits << 17;
                f64::from_bits(bits >> 1)
            });
            for (root, square) in square_roots(squares).into_iter().zip(squares).filter(|(_, square)| !square.is_nan())
            {
                assert_eq!(root.to_bits(), libm::sqrt(square).to_bits(), "{square}");
            }
        }
        assert_eq!(y.largest().to_bits(), 7.0_f64.to_bits());
        assert_eq!(Lanes::load(&[0.0, 1.0, 2.0, 3.0, 4.0], 1).sum().to_bits(), 10.0_f64.to_bits());
    }
}
