// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Elastic supports of the part: headstock, tailstock and steady rest.

use crate::machine::description_error::DescriptionError;

/// Steady rest of a machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SteadyRest {
    /// Radial stiffness of the jaws (N/mm).
    pub n_mm: f64,
    /// Width of the jaws along Z (mm).
    pub jaw_width_mm: f64,
}

/// Radial stiffness of the supports that hold a part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorkholdingDescription {
    /// Headstock at its centre or chuck (N/mm).
    pub headstock_n_mm: f64,
    /// Tilt of a part in the chuck: moment per angle (N mm/rad). `None`: no chuck.
    pub chuck_tilt_n_mm_rad: Option<f64>,
    /// Tailstock at its centre (N/mm). `None`: no tailstock.
    pub tailstock_n_mm: Option<f64>,
    /// `None`: no steady rest.
    pub steady_rest: Option<SteadyRest>,
}

impl WorkholdingDescription {
    pub(super) fn validate(&self) -> Result<(), DescriptionError> {
        let rest = self.steady_rest;
        let figures = [
            ("stiffness of the headstock (N/mm)", Some(self.headstock_n_mm)),
            ("tilting stiffness of the chuck (N mm/rad)", self.chuck_tilt_n_mm_rad),
            ("stiffness of the tailstock (N/mm)", self.tailstock_n_mm),
            ("stiffness of the steady rest (N/mm)", rest.map(|rest| rest.n_mm)),
            ("width of the jaws of the steady rest (mm)", rest.map(|rest| rest.jaw_width_mm)),
        ];
        for (what, value) in figures {
            if let Some(value) = value.filter(|value| !(*value > 0.0 && value.is_finite())) {
                return Err(DescriptionError::NotPositive { what, value });
            }
        }
        Ok(())
    }
}
