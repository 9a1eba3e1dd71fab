// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Runout: radii of a part by phase.

use super::harmonics::FourierSeries;
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;
use thiserror::Error;

/// Minimum number of phases of a runout.
pub const FEWEST_PHASES: usize = 8;

/// Why radii are no runout.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum PhasesError {
    #[error("radii at {count} phases, at least {min} are needed")]
    TooFew { count: usize, min: usize },
    /// A radius that is no number.
    #[error("radius {index} is not a finite number")]
    NotFinite { index: usize },
}

/// Radii from the axis of rotation at equal steps of the phase, beginning with phase 0.
#[derive(Debug, Clone, PartialEq)]
pub struct RadiusByPhase {
    radii_mm: Vec<f64>,
}

impl RadiusByPhase {
    /// From radii (mm), or radii but for a constant.
    ///
    /// # Errors
    /// Too few, or one that is no number.
    pub fn new(radii_mm: Vec<f64>) -> Result<Self, PhasesError> {
        if radii_mm.len() < FEWEST_PHASES {
            return Err(PhasesError::TooFew { count: radii_mm.len(), min: FEWEST_PHASES });
        }
        match radii_mm.iter().position(|radius| !radius.is_finite()) {
            Some(index) => Err(PhasesError::NotFinite { index }),
            None => Ok(Self { radii_mm }),
        }
    }

    /// Radii by phase (mm).
    #[must_use]
    pub fn radii_mm(&self) -> &[f64] {
        &self.radii_mm
    }

    /// Phase of a radius (rad).
    #[must_use]
    pub fn phase_rad(&self, index: usize) -> f64 {
        let (index, count) = (index as f64, self.radii_mm.len() as f64);
        TURN_RAD * index / count
    }

    /// Index of the least radius.
    #[must_use]
    pub fn minimum_index(&self) -> usize {
        let mut min = 0;
        for (index, radius) in self.radii_mm.iter().enumerate() {
            if *radius < self.radii_mm[min] {
                min = index;
            }
        }
        min
    }

    /// Least radius (mm).
    #[must_use]
    pub fn minimum_mm(&self) -> f64 {
        self.radii_mm[self.minimum_index()]
    }

    /// IR of every phase: by how much its radius exceeds the least (mm).
    #[must_use]
    pub fn runout_mm(&self) -> Vec<f64> {
        let min = self.minimum_mm();
        self.radii_mm.iter().map(|radius| radius - min).collect()
    }

    /// TIR, the total indicated runout: largest less least radius (mm).
    #[must_use]
    pub fn total_mm(&self) -> f64 {
        self.radii_mm.iter().fold(f64::NEG_INFINITY, |max, radius| max.max(*radius)) - self.minimum_mm()
    }

    /// Amplitude of a harmonic (mm): of the first the eccentricity, of the third that of a three-lobed part.
    #[must_use]
    pub fn harmonic_mm(&self, harmonic: u32) -> f64 {
        FourierSeries::from_values(&self.radii_mm, harmonic as usize).amplitude(harmonic as usize)
    }
}

/// Phase of an index (rad).
pub(super) fn phase_rad(index: usize, phases: usize) -> f64 {
    let (index, phases) = (index as f64, phases as f64);
    TURN_RAD * index / phases
}
