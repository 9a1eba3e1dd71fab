//! A printed lift table over one turn of the cam, in whole units of its last digit.

use super::check;
use super::error::LiftError;
use super::row_spacing::{ANGLE_TOLERANCE, block_of};
use super::warning::LiftDoubt;
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;

/// One row of a table as it was read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiftRow {
    /// Line of the file, for whoever has to correct it; 0 for a row that was mirrored or filled in.
    pub line: usize,
    /// Angle (cam or crank degrees, as declared); `None` where the file has one value per block and no angles.
    pub angle_deg: Option<f64>,
    /// Lift, or its increment over the block that begins here (mm).
    pub value_mm: f64,
}

/// What the values of a table are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LiftForm {
    /// Increment per block, as on the tape of JPS6156064B2: block k takes the lift from k·Δθ to (k + 1)·Δθ; block 0 begins at
    /// the base centre, where the lift is 0.
    Increments,
    /// Lift at each angle.
    Absolute,
}

/// What the angles of a table are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AngleUnit {
    /// One turn of the cam is 360 degrees.
    CamDegrees,
    /// One turn of the cam is 720 degrees.
    CrankDegrees,
}

impl AngleUnit {
    /// One turn of the cam in this unit (deg).
    #[must_use]
    pub const fn turn_deg(self) -> f64 {
        match self {
            AngleUnit::CamDegrees => 360.0,
            AngleUnit::CrankDegrees => 720.0,
        }
    }
}

/// What the lifts of a table were printed in; the rows hold mm in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LengthUnit {
    /// Millimetres or a decimal part of them.
    Millimetre,
    /// Inches: 25.4 mm.
    Inch,
}

impl LengthUnit {
    /// Its length (mm).
    #[must_use]
    pub const fn mm(self) -> f64 {
        match self {
            LengthUnit::Millimetre => 1.0,
            LengthUnit::Inch => 25.4,
        }
    }
}

/// What a table says about itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiftDeclaration {
    /// What the values are.
    pub form: LiftForm,
    /// What the angles are.
    pub angle_unit: AngleUnit,
    /// Resolution of the lift (mm): the last digit printed, or coarser where the file declares so. The lift law lies
    /// within half of it of every point.
    pub resolution_mm: f64,
    /// What the lifts were printed in: its decimal parts are the digits looked for in the values.
    pub unit: LengthUnit,
    /// How far the law may lie from a point where the job asks for smoothing (mm); 0 where it does not.
    pub smooth_within_mm: f64,
    /// Blocks over one turn, where the file declares them.
    pub blocks: Option<usize>,
}

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

    /// A table from the rows of a file. Rows stand in the order of the turn from any angle that is a multiple of the
    /// block; a last absolute row that repeats the first after a whole turn is accepted if its lift is the same.
    ///
    /// # Errors
    /// The first of [`Self::findings`].
    pub fn from_rows(rows: &[LiftRow], declaration: &LiftDeclaration) -> Result<Self, LiftError> {
        Self::read(rows, declaration).map(|(table, _)| table).map_err(|mut findings| findings.swap_remove(0))
    }

    /// Everything that is wrong with the rows of a file, row by row; empty when [`Self::from_rows`] succeeds. A bad row
    /// does not hide another: the checks go round it.
    #[must_use]
    pub fn findings(rows: &[LiftRow], declaration: &LiftDeclaration) -> Vec<LiftError> {
        Self::read(rows, declaration).err().unwrap_or_default()
    }

    /// A table as [`Self::from_rows`] makes it, with what is lawful about it and yet looks wrong.
    ///
    /// # Errors
    /// [`Self::findings`], at least one.
    pub fn read(rows: &[LiftRow], declaration: &LiftDeclaration) -> Result<(Self, Vec<LiftDoubt>), Vec<LiftError>> {
        check::inspect(rows, declaration)
    }

    /// The same table with its angle 0 at the cam angle `zero_deg` (deg).
    ///
    /// # Errors
    /// An angle that is no multiple of the block.
    pub fn turned_by(mut self, zero_deg: f64) -> Result<Self, LiftError> {
        let step_deg = 360.0 / self.blocks() as f64;
        let turned = block_of(zero_deg, step_deg);
        let off_deg = zero_deg - turned as f64 * step_deg;
        if off_deg.is_nan() || off_deg.abs() > ANGLE_TOLERANCE * step_deg {
            return Err(LiftError::ZeroOffStep { zero_deg, off_deg, step_deg });
        }
        let turned = turned.rem_euclid(i64::try_from(self.blocks()).unwrap_or(i64::MAX));
        self.lifts.rotate_right(usize::try_from(turned).unwrap_or(0));
        Ok(self)
    }

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

/// A length of whole digits (mm). A decimal digit is not a binary number, but its inverse is a whole one, in mm or in
/// inches: dividing rounds once and gives the number that the printed figure parses to.
pub(super) fn mm_from_units(units: i64, digit_mm: f64) -> f64 {
    let units = units as f64;
    for unit in [LengthUnit::Millimetre, LengthUnit::Inch] {
        let per_unit = libm::round(unit.mm() / digit_mm);
        if (per_unit * digit_mm / unit.mm() - 1.0).abs() < 1e-12 {
            return units / per_unit * unit.mm();
        }
    }
    units * digit_mm
}
