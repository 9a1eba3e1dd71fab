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

    /// Largest lift (mm).
    #[must_use]
    pub fn max_lift_mm(&self) -> f64 {
        (0..self.blocks()).map(|block| self.lift_mm(block)).fold(0.0, f64::max)
    }
}
