// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A printed lift table over one turn of the cam, in whole units of its last digit.

use super::declaration::mm_from_units;
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;

/// Lift over one turn in N equal blocks. Lifts are whole units of the last digit, so that increments and absolute lifts
/// give the same table exactly.
#[derive(Debug, Clone, PartialEq)]
pub struct LiftTable {
    pub(super) lifts: Vec<i64>,
    pub(super) digit_mm: f64,
    pub(super) resolution_mm: f64,
    /// Lowest lift that was declared (mm).
    pub(super) lowest_mm: f64,
}

impl LiftTable {
    /// Fewest blocks: what the lift law's solver needs, and coarser than any table in use.
    pub const MIN_BLOCKS: usize = 12;
    /// Most blocks: 0.01° each. With ten times more, rounding keeps the lift law from its smoothest curve.
    pub const MAX_BLOCKS: usize = 36_000;

    /// Number of blocks N over one turn.
    #[must_use]
    pub fn blocks(&self) -> usize {
        self.lifts.len()
    }

    /// Angle of one block (rad).
    #[must_use]
    pub fn block_rad(&self) -> f64 {
        let blocks = self.lifts.len() as f64;
        TURN_RAD / blocks
    }

    /// Lift at the beginning of a block, taken modulo one turn (units of the last digit).
    #[must_use]
    pub fn lift_units(&self, block: usize) -> i64 {
        self.lifts[block % self.lifts.len()]
    }

    /// Increment over a block, Xn of JPS6156064B2 (units of the last digit).
    #[must_use]
    pub fn increment_units(&self, block: usize) -> i64 {
        self.lift_units(block + 1) - self.lift_units(block)
    }

    /// Lift at the beginning of a block, taken modulo one turn (mm).
    #[must_use]
    pub fn lift_mm(&self, block: usize) -> f64 {
        mm_from_units(self.lift_units(block), self.digit_mm)
    }

    /// Lift at the beginning of every block (mm).
    #[must_use]
    pub fn lifts_mm(&self) -> Vec<f64> {
        (0..self.blocks()).map(|block| self.lift_mm(block)).collect()
    }

    /// Resolution (mm): the lift law lies within half of it.
    #[must_use]
    pub fn resolution_mm(&self) -> f64 {
        self.resolution_mm
    }

    /// The finest digit printed (mm); the resolution unless that was declared coarser.
    #[must_use]
    pub fn digit_mm(&self) -> f64 {
        self.digit_mm
    }

    /// Form that the table leaves open (mm): half its resolution, and what a cubic through its rows may be off between them, 5/384 of the
    /// largest fourth difference.
    #[must_use]
    pub fn unknown_mm(&self) -> f64 {
        let n = self.blocks();
        let fourth = |k: usize| {
            let [a, b, c, d, e] = [0, 1, 2, 3, 4].map(|step| self.lift_mm(k + step));
            (a - 4.0 * b + 6.0 * c - 4.0 * d + e).abs()
        };
        0.5 * self.resolution_mm + (0..n).map(fourth).fold(0.0, f64::max) * 5.0 / 384.0
    }

    /// Largest lift (mm).
    #[must_use]
    pub fn max_lift_mm(&self) -> f64 {
        (0..self.blocks()).map(|block| self.lift_mm(block)).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// h(1 − cos φ)/2 over n rows has a fourth difference of h/2 · (2 sin(π/n))⁴; rounding adds at most 16 half digits to it.
    #[test]
    fn few_rows_and_coarse_digits_leave_the_form_open() {
        for (rows, digit_mm) in [(36_u32, 1e-6), (72, 1e-6), (3600, 0.01)] {
            let lift = |k: u32| 5.0 * (1.0 - libm::cos(f64::from(k) * TURN_RAD / f64::from(rows)));
            #[allow(clippy::cast_possible_truncation, reason = "at most ten million")]
            let lifts = (0..rows).map(|k| libm::round(lift(k) / digit_mm) as i64).collect();
            let table = LiftTable { lifts, digit_mm, resolution_mm: digit_mm, lowest_mm: 0.0 };
            let chord = 2.0 * libm::sin(TURN_RAD / 2.0 / f64::from(rows));
            let (rows_mm, digits_mm) = (5.0 * chord * chord * chord * chord * 5.0 / 384.0, 0.5 * digit_mm);
            let rounding_mm = 16.0 * 0.5 * digit_mm * 5.0 / 384.0;
            let unknown_mm = table.unknown_mm();
            assert!((unknown_mm - rows_mm - digits_mm).abs() <= rounding_mm * 1.001, "{rows}: {unknown_mm}");
        }
    }
}
