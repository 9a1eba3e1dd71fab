// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Complex exponential and logarithm on `libm`, with the same bits on every computer.

pub use nalgebra::Complex;

/// e to the power of z.
#[must_use]
pub fn exponential(z: Complex<f64>) -> Complex<f64> {
    let (sin, cos) = libm::sincos(z.im);
    Complex::new(cos, sin) * libm::exp(z.re)
}

/// Principal logarithm, imaginary part from −π to π.
#[must_use]
pub fn logarithm(z: Complex<f64>) -> Complex<f64> {
    Complex::new(libm::log(magnitude(z)), libm::atan2(z.im, z.re))
}

/// Absolute value.
#[must_use]
pub fn magnitude(z: Complex<f64>) -> f64 {
    libm::hypot(z.re, z.im)
}
