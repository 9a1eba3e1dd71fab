// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The grinding wheel at one moment of its life; dressing makes a new one.

/// Nanometres per millimetre: radii of dressed wheels are whole nanometres, so that a plan names them exactly.
const NM_PER_MM: f64 = 1e6;

/// A radius in whole nanometres (from mm).
#[must_use]
#[allow(clippy::cast_possible_truncation, reason = "wheels are metres at most")]
pub fn nm_from_mm(mm: f64) -> i64 {
    libm::round(mm * NM_PER_MM) as i64
}

/// A radius of whole nanometres (mm).
#[must_use]
pub fn mm_from_nm(nm: i64) -> f64 {
    nm as f64 / NM_PER_MM
}

/// The wheel as it is mounted, with what it has done since its last dress.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelNow {
    /// Radius at the last dress (mm): what `x_axis` is counted with.
    pub radius_mm: f64,
    /// Lost since then (mm).
    pub wear_mm: f64,
    /// Lobes ground since then.
    pub lobes_since_dress: u32,
    /// Parts finished since then.
    pub parts_since_dress: u32,
}

impl WheelNow {
    /// A wheel that has just been dressed to a radius (mm).
    #[must_use]
    pub const fn dressed(radius_mm: f64) -> Self {
        Self { radius_mm, wear_mm: 0.0, lobes_since_dress: 0, parts_since_dress: 0 }
    }
}

impl From<f64> for WheelNow {
    fn from(radius_mm: f64) -> Self {
        Self::dressed(radius_mm)
    }
}
