// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Repeatable numbers for tests.

/// Numbers from 0 to 1, by Marsaglia's xorshift of 32 bits.
pub(crate) fn unit_numbers(mut seed: u32) -> impl FnMut() -> f64 {
    move || {
        seed ^= seed << 13;
        seed ^= seed >> 17;
        seed ^= seed << 5;
        f64::from(seed) / f64::from(u32::MAX)
    }
}
