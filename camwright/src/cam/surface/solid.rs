// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Solids by formula.

use super::{SurfaceError, SurfaceKey};
use crate::math::jet::Jet;
use alloc::vec::Vec;

/// A number that changes evenly along the axis: `at_zero + per_mm · z`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LinearInZ {
    /// At z = 0.
    pub at_zero: f64,
    pub per_mm: f64,
}

impl LinearInZ {
    /// The same all along.
    #[must_use]
    pub const fn constant(value: f64) -> Self {
        Self { at_zero: value, per_mm: 0.0 }
    }

    fn at(self, z: Jet) -> Jet {
        z * self.per_mm + Jet::constant(self.at_zero)
    }

    fn is_finite(self) -> bool {
        self.at_zero.is_finite() && self.per_mm.is_finite()
    }
}

/// One wave of a lobed solid: amplitude · cos(waves · φ − phase).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
    /// Waves per turn, at least 1.
    pub waves: u32,
    /// Amplitude (mm).
    pub amplitude_mm: LinearInZ,
    /// Phase (rad): of the wave, not of the part.
    pub phase_rad: LinearInZ,
}

/// A solid by formula.
#[derive(Debug, Clone, PartialEq)]
pub enum Solid {
    /// A cylinder about the spindle axis.
    Cylinder {
        /// Radius (mm).
        radius_mm: f64,
    },
    /// A cylinder about an axis beside that of the spindle: r = e cos(φ − α) + √(R² − e² sin²(φ − α)).
    Eccentric {
        /// Radius of the cylinder R (mm).
        radius_mm: f64,
        /// Eccentricity e (mm).
        eccentricity_mm: f64,
        /// Azimuth of its axis α (rad).
        azimuth_rad: f64,
    },
    /// An ellipse with half axes a and b that change along z: r = (cos²(φ − α)/a² + sin²(φ − α)/b²)^(−1/2).
    EllipticCone {
        /// Half axis a (mm).
        first_mm: LinearInZ,
        /// Half axis b (mm).
        second_mm: LinearInZ,
        /// Azimuth of a (rad).
        azimuth_rad: f64,
    },
    /// Waves on a mean radius: polygons, trochoids, and what else a few harmonics describe.
    Lobed {
        /// Mean radius (mm).
        mean_mm: LinearInZ,
        harmonics: Vec<Harmonic>,
    },
}

/// Most waves per turn: 0.5° each.
const MAX_WAVES: u32 = 720;

/// Most harmonics of a lobed solid.
const MAX_HARMONICS: usize = 256;

/// Largest radius (mm).
const LARGEST_MM: f64 = 1e5;

fn positive(what: SurfaceKey, value: f64) -> Result<(), SurfaceError> {
    if value.is_finite() && value > 0.0 && value <= LARGEST_MM {
        Ok(())
    } else {
        Err(SurfaceError::BadNumber { what, value, allowed: "above 0 and up to 1e5 mm" })
    }
}

fn finite(what: SurfaceKey, number: LinearInZ) -> Result<(), SurfaceError> {
    if number.is_finite() {
        return Ok(());
    }
    let value = if number.at_zero.is_finite() { number.per_mm } else { number.at_zero };
    Err(SurfaceError::BadNumber { what, value, allowed: "finite" })
}

impl Solid {
    /// Sees to it that its numbers make sense by themselves.
    pub(super) fn check(&self) -> Result<(), SurfaceError> {
        match self {
            Solid::Cylinder { radius_mm } => positive(SurfaceKey::CylinderRadius, *radius_mm),
            Solid::Eccentric { radius_mm, eccentricity_mm, azimuth_rad } => {
                positive(SurfaceKey::EccentricRadius, *radius_mm)?;
                if !(0.0..*radius_mm).contains(eccentricity_mm) {
                    let (what, value) = (SurfaceKey::Eccentricity, *eccentricity_mm);
                    return Err(SurfaceError::BadNumber { what, value, allowed: "at least 0 and below the radius" });
                }
                finite(SurfaceKey::EccentricAzimuth, LinearInZ::constant(*azimuth_rad))
            }
            Solid::EllipticCone { first_mm, second_mm, azimuth_rad } => {
                finite(SurfaceKey::FirstHalfAxis, *first_mm)?;
                finite(SurfaceKey::SecondHalfAxis, *second_mm)?;
                finite(SurfaceKey::HalfAxisAzimuth, LinearInZ::constant(*azimuth_rad))
            }
            Solid::Lobed { mean_mm, harmonics } => {
                finite(SurfaceKey::MeanRadius, *mean_mm)?;
                if harmonics.len() > MAX_HARMONICS {
                    let count = harmonics.len();
                    return Err(SurfaceError::Count { what: SurfaceKey::Harmonics, count, min: 0, max: MAX_HARMONICS });
                }
                for harmonic in harmonics {
                    if !(1..=MAX_WAVES).contains(&harmonic.waves) {
                        let (what, value) = (SurfaceKey::Waves, f64::from(harmonic.waves));
                        return Err(SurfaceError::BadNumber { what, value, allowed: "1 to 720" });
                    }
                    finite(SurfaceKey::WaveAmplitude, harmonic.amplitude_mm)?;
                    finite(SurfaceKey::WavePhase, harmonic.phase_rad)?;
                }
                Ok(())
            }
        }
    }

    /// Azimuths on which its waves are seen well.
    pub(super) fn grid(&self) -> u32 {
        match self {
            Solid::Lobed { harmonics, .. } => 12 * harmonics.iter().map(|harmonic| harmonic.waves).max().unwrap_or(1),
            _ => 0,
        }
    }

    /// The radius with its derivatives. An ellipse whose half axis has shrunk to nothing has a radius that is not a number.
    pub(super) fn jet(&self, azimuth_rad: f64, z_mm: f64) -> Jet {
        match self {
            Solid::Cylinder { radius_mm } => Jet::constant(*radius_mm),
            Solid::Eccentric { radius_mm, eccentricity_mm: e, azimuth_rad: towards } => {
                let (sin, cos) = Jet::azimuth(azimuth_rad - towards).sin_cos();
                let across = sin * *e;
                cos * *e + (Jet::constant(radius_mm * radius_mm) - across * across).sqrt()
            }
            Solid::EllipticCone { first_mm, second_mm, azimuth_rad: towards } => {
                let z = Jet::along(z_mm);
                let (sin, cos) = Jet::azimuth(azimuth_rad - towards).sin_cos();
                let (a, b) = (first_mm.at(z), second_mm.at(z));
                if a.value <= 0.0 || b.value <= 0.0 {
                    return Jet::constant(f64::NAN);
                }
                // ab/√((b cos)² + (a sin)²)
                let (along, across) = (b * cos, a * sin);
                a * b * (along * along + across * across).sqrt().recip()
            }
            Solid::Lobed { mean_mm, harmonics } => {
                let (azimuth, z) = (Jet::azimuth(azimuth_rad), Jet::along(z_mm));
                harmonics.iter().fold(mean_mm.at(z), |radius, harmonic| {
                    let angle = azimuth * f64::from(harmonic.waves) - harmonic.phase_rad.at(z);
                    radius + harmonic.amplitude_mm.at(z) * angle.sin_cos().1
                })
            }
        }
    }
}
