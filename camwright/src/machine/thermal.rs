// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Thermal growth of a machine.

use crate::machine::description_error::DescriptionError;

/// The wheelhead grows towards the part while its spindle runs: by G (1 − exp(−t/τ)) of a cold one, t being the time that the spindle
/// has run. The encoder of X does not see it. What passes while the spindle stands is not known to the machine, and it keeps what it
/// had: it does not cool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThermalDescription {
    /// G: growth of a warm machine (mm); negative where it grows away from the part.
    pub growth_mm: f64,
    /// τ (s).
    pub time_constant_s: f64,
    /// Share of G that a machine that has never run begins with, 0 cold … 1 warm; its wheel is dressed like that.
    pub start_share: f64,
}

impl ThermalDescription {
    /// Growth (mm) after `seconds` of a running spindle, from what it is now.
    #[must_use]
    pub fn after_mm(&self, now_mm: f64, seconds: f64) -> f64 {
        now_mm - (self.growth_mm - now_mm) * libm::expm1(-seconds / self.time_constant_s)
    }

    /// Growth of a machine that has never run (mm).
    #[must_use]
    pub fn start_mm(&self) -> f64 {
        self.start_share * self.growth_mm
    }

    pub(super) fn validate(&self) -> Result<(), DescriptionError> {
        let (what, value) = ("time constant of the growth (s)", self.time_constant_s);
        if !(value > 0.0 && value.is_finite()) {
            return Err(DescriptionError::NotPositive { what, value });
        }
        for (what, value) in
            [("growth of a warm machine (mm)", self.growth_mm.abs()), ("warmth of the start", self.start_share)]
        {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(DescriptionError::Negative { what, value });
            }
            if value > 1.0 {
                return Err(DescriptionError::AboveLimit { what, value, allowed: 1.0 });
            }
        }
        Ok(())
    }
}
