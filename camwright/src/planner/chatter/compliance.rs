// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Dynamic compliance between wheel and part: spring, vibration modes, and the drive of the wheelhead.

use super::drive_compliance::DriveCompliance;
use crate::math::complex::Complex;
use alloc::vec::Vec;

/// Vibration mode of the structure between wheel and part, as a tap test finds it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VibrationMode {
    /// Natural frequency without damping (rad/s).
    pub frequency_rad_s: f64,
    /// Damping ratio, 0 to below 1.
    pub damping: f64,
    /// Modal stiffness (N/mm).
    pub stiffness_n_mm: f64,
}

impl VibrationMode {
    /// Compliance at a complex frequency (mm/N).
    #[must_use]
    pub fn at(&self, s: Complex<f64>) -> Complex<f64> {
        let square = self.frequency_rad_s * self.frequency_rad_s;
        let inertia = s * s + s * (2.0 * self.damping * self.frequency_rad_s) + square;
        Complex::new(square / self.stiffness_n_mm, 0.0) / inertia
    }
}

/// Compliance of wheel against part along the normal of their contact.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactCompliance {
    /// Compliance of the springs without mass (mm/N).
    pub spring_mm_n: f64,
    pub modes: Vec<VibrationMode>,
    /// Drive of the wheelhead; `None`: the contact force does not move it.
    pub drive: Option<DriveCompliance>,
}

impl ContactCompliance {
    /// One mode without anything beside it.
    #[must_use]
    pub fn single_mode(mode: VibrationMode) -> Self {
        Self { spring_mm_n: 0.0, modes: alloc::vec![mode], drive: None }
    }

    /// The same with a part of this compliance on its supports (mm/N): a spring without mass.
    #[must_use]
    pub fn with_part(self, part_mm_n: f64) -> Self {
        Self { spring_mm_n: self.spring_mm_n + part_mm_n, ..self }
    }

    /// Deflection per force at a complex frequency (mm/N).
    #[must_use]
    pub fn at(&self, s: Complex<f64>) -> Complex<f64> {
        let modes = self.modes.iter().map(|mode| mode.at(s)).sum::<Complex<f64>>();
        let drive = self.drive.map_or(Complex::ZERO, |drive| drive.at(s));
        modes + drive + self.spring_mm_n
    }

    /// Natural frequencies of everything that vibrates (rad/s).
    pub(super) fn natural_rad_s(&self) -> impl Iterator<Item = f64> + '_ {
        let drive = self.drive.iter().flat_map(DriveCompliance::natural_rad_s);
        self.modes.iter().map(|mode| mode.frequency_rad_s).chain(drive)
    }

    /// Highest frequency that can chatter (rad/s), as a factor above every natural frequency: beyond it the masses stand still.
    pub(super) fn highest_rad_s(&self) -> f64 {
        FREQUENCY_MARGIN * self.natural_rad_s().fold(0.0, f64::max)
    }

    /// Cutting stiffness up to which no wave grows at any work speed, −1/(2 min Re G) (N/mm); `None`: no cut chatters.
    #[must_use]
    pub fn unconditional_n_mm(&self) -> Option<f64> {
        let (lowest, _) = self.most_negative()?;
        (lowest < 0.0).then(|| -0.5 / lowest)
    }

    /// Most negative real part over all frequencies, and its frequency (mm/N, rad/s); `None` where nothing vibrates.
    #[must_use]
    pub fn most_negative(&self) -> Option<(f64, f64)> {
        let highest = self.highest_rad_s();
        if highest <= 0.0 {
            return None;
        }
        let real = |rad_s: f64| self.at(Complex::new(0.0, rad_s)).re;
        let start = (f64::INFINITY, highest);
        let coarse = |from: f64, to: f64, steps: u32| {
            let step = (to - from) / f64::from(steps);
            (0..=steps).map(move |i| from + step * f64::from(i))
        };
        let lowest = |at: (f64, f64), rad_s: f64| if real(rad_s) < at.0 { (real(rad_s), rad_s) } else { at };
        // Around every natural frequency densely: a mode is as narrow as its damping.
        let mut found = coarse(highest * 1e-4, highest, 2000).fold(start, lowest);
        for natural in self.natural_rad_s() {
            found = coarse(0.7 * natural, 1.5 * natural, 2000).fold(found, lowest);
        }
        let mut half = 1e-3 * found.1;
        for _ in 0..4 {
            found = coarse(found.1 - half, found.1 + half, 100).fold(found, lowest);
            half *= 0.03;
        }
        Some(found)
    }
}

/// Ratio of the highest frequency that is examined to the highest natural frequency.
const FREQUENCY_MARGIN: f64 = 3.0;
