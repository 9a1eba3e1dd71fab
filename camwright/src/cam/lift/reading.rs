// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The ways to read a curve out of a table, and what each of them costs.

/// Method that turns a table into a curve.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum TableMethod {
    /// The smoothest periodic curve within half a digit of every point: a quintic spline, jerk continuous.
    #[default]
    Smoothest,
    /// The periodic cubic spline through the figures themselves, as cam grinders have long read them: jerk jumps at every point,
    /// and rounding shows in it in full.
    CubicSpline,
    /// The smoothest periodic curve within a wider distance, because the job asks for it.
    SmoothWithin {
        /// Largest distance from a point (mm); at least half a digit.
        tolerance_mm: f64,
    },
}

impl TableMethod {
    /// Name in job files and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            TableMethod::Smoothest => "smoothest",
            TableMethod::CubicSpline => "cubic_spline",
            TableMethod::SmoothWithin { .. } => "smooth_within",
        }
    }
}

/// Fidelity of a table's reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableReading {
    /// Method.
    pub reading: TableMethod,
    /// Half the table's resolution (mm).
    pub half_digit_mm: f64,
    /// Tolerance of a point (mm): half a digit, or the tolerance of the job; 0 for the cubic spline.
    pub allowed_mm: f64,
    /// Largest distance of the law from a point (mm).
    pub max_deviation_mm: f64,
    /// Cam angle of that point (rad).
    pub max_deviation_rad: f64,
    /// Root of the mean square of the distances (mm).
    pub rms_deviation_mm: f64,
    /// Largest third derivative of the law (mm/rad³).
    pub peak_jerk_mm_rad3: f64,
    /// ∫ s‴² is at most this fraction above the least possible within the allowed distance; 0 for the cubic spline.
    pub relative_gap: f64,
    /// Steps the solver took.
    pub iterations: usize,
}
