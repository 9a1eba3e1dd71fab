// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Numbers that carry their derivatives over two variables up to the second, so that formulas of surfaces are written once.

use core::ops::{Add, Mul, Neg, Sub};

/// A value with its derivatives over the azimuth a and over z.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Jet {
    pub(crate) value: f64,
    pub(crate) a: f64,
    pub(crate) z: f64,
    pub(crate) aa: f64,
    pub(crate) az: f64,
    pub(crate) zz: f64,
}

impl Jet {
    pub(crate) fn constant(value: f64) -> Self {
        Self { value, ..Self::default() }
    }

    pub(crate) fn azimuth(value: f64) -> Self {
        Self { value, a: 1.0, ..Self::default() }
    }

    pub(crate) fn along(value: f64) -> Self {
        Self { value, z: 1.0, ..Self::default() }
    }

    /// A function of this one, given by its value and first two derivatives here.
    pub(crate) fn through(self, value: f64, first: f64, second: f64) -> Self {
        Self {
            value,
            a: first * self.a,
            z: first * self.z,
            aa: first * self.aa + second * self.a * self.a,
            az: first * self.az + second * self.a * self.z,
            zz: first * self.zz + second * self.z * self.z,
        }
    }

    pub(crate) fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = libm::sincos(self.value);
        (self.through(sin, cos, -sin), self.through(cos, -sin, -cos))
    }

    pub(crate) fn sqrt(self) -> Self {
        let root = libm::sqrt(self.value);
        self.through(root, 0.5 / root, -0.25 / (root * self.value))
    }

    pub(crate) fn recip(self) -> Self {
        let recip = 1.0 / self.value;
        self.through(recip, -recip * recip, 2.0 * recip * recip * recip)
    }
}

impl Add for Jet {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            a: self.a + other.a,
            z: self.z + other.z,
            aa: self.aa + other.aa,
            az: self.az + other.az,
            zz: self.zz + other.zz,
        }
    }
}

impl Neg for Jet {
    type Output = Self;

    fn neg(self) -> Self {
        self * -1.0
    }
}

impl Sub for Jet {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul<f64> for Jet {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            a: self.a * factor,
            z: self.z * factor,
            aa: self.aa * factor,
            az: self.az * factor,
            zz: self.zz * factor,
        }
    }
}

impl Mul for Jet {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            a: self.a * other.value + self.value * other.a,
            z: self.z * other.value + self.value * other.z,
            aa: self.aa * other.value + 2.0 * self.a * other.a + self.value * other.aa,
            az: self.az * other.value + self.a * other.z + self.z * other.a + self.value * other.az,
            zz: self.zz * other.value + 2.0 * self.z * other.z + self.value * other.zz,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// √(2 + sin a · z)/(1 + z²) against differences.
    #[test]
    fn derivatives_are_those_of_differences() {
        let f = |a: f64, z: f64| {
            let (a, z) = (Jet::azimuth(a), Jet::along(z));
            (Jet::constant(2.0) + a.sin_cos().0 * z).sqrt() * (Jet::constant(1.0) + z * z).recip()
        };
        let (a, z, h) = (0.7, 0.4, 1e-4);
        let jet = f(a, z);
        let close = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-7, "{found} {wanted}");
        close(jet.a, (f(a + h, z).value - f(a - h, z).value) / (2.0 * h));
        close(jet.z, (f(a, z + h).value - f(a, z - h).value) / (2.0 * h));
        close(jet.aa, (f(a + h, z).a - f(a - h, z).a) / (2.0 * h));
        close(jet.az, (f(a, z + h).a - f(a, z - h).a) / (2.0 * h));
        close(jet.zz, (f(a, z + h).z - f(a, z - h).z) / (2.0 * h));
    }
}
