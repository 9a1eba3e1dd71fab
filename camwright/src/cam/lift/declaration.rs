// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Rows of a lift table as a file gives them, and the units and form that it declares.

/// One row of a table as it was read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiftRow {
    /// Line of the file, for the user who corrects it; 0 for a row that was mirrored or filled in.
    pub line: usize,
    /// Angle (cam or crank degrees, as declared); `None` where the file has one value per block and no angles.
    pub angle_deg: Option<f64>,
    /// Lift, or its increment over the block that begins here (mm).
    pub value_mm: f64,
}

/// Meaning of the values of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LiftForm {
    /// Increment per block, as on the codec of JPS6156064B2: block k takes the lift from k·Δθ to (k + 1)·Δθ; block 0 begins at
    /// the base centre, where the lift is 0.
    Increments,
    /// Lift at each angle.
    Absolute,
}

/// Unit and reference of the angles of a table.
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

/// Unit of the printed lifts; the rows are in mm in any case.
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

/// Declarations of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiftDeclaration {
    /// Meaning of the values.
    pub form: LiftForm,
    /// Unit of the angles.
    pub angle_unit: AngleUnit,
    /// Resolution of the lift (mm): the last digit printed, or coarser where the file declares so. The lift law lies
    /// within half of it of every point.
    pub resolution_mm: f64,
    /// Unit of the printed lifts: its decimal parts are the digits expected in the values.
    pub unit: LengthUnit,
    /// Smoothing tolerance of a point (mm); 0 without smoothing.
    pub smooth_within_mm: f64,
    /// Lowest lift (mm): 0, the base circle, or below it.
    pub lowest_mm: f64,
    /// Blocks over one turn, where the file declares them.
    pub blocks: Option<usize>,
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
