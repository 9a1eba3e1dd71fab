// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! In-process gauge.

use crate::machine::description_error::DescriptionError;

/// Measured quantity of a gauge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GaugeKind {
    /// The distance of two opposed contacts, one at γ, one at γ + 180°. A part that deflects along their line changes nothing.
    Diameter,
    /// The distance of a single contact from the spindle axis.
    Radius,
}

/// A gauge, or two of a kind at different angles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaugeDescription {
    pub kind: GaugeKind,
    /// γ of its contact, or of its first one (rad), in 0..2π.
    pub behind_wheel_rad: f64,
    /// γ of a second gauge (rad); `None`: there is one.
    pub second_behind_wheel_rad: Option<f64>,
    /// Step of its reading (mm); 0: none.
    pub resolution_mm: f64,
    /// Standard deviation of its noise (mm).
    pub noise_mm: f64,
    /// Bandwidth of its amplifier, a lag of first order (rad/s); `None`: it does not lag.
    pub bandwidth_rad_s: Option<f64>,
    /// Seed of its noise.
    pub seed: u64,
}

impl GaugeDescription {
    pub(super) fn validate(&self) -> Result<(), DescriptionError> {
        for (what, value) in [
            ("resolution of the gauge (mm)", self.resolution_mm),
            ("noise of the gauge (mm)", self.noise_mm),
            ("angle of the gauge (rad)", self.behind_wheel_rad),
            ("angle of the second gauge (rad)", self.second_behind_wheel_rad.unwrap_or(0.0)),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(DescriptionError::Negative { what, value });
            }
        }
        match self.bandwidth_rad_s {
            Some(value) if !(value > 0.0 && value.is_finite()) => {
                Err(DescriptionError::NotPositive { what: "bandwidth of the gauge (rad/s)", value })
            }
            _ => Ok(()),
        }
    }
}
