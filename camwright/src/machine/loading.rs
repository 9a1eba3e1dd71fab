// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Loading equipment: door and chuck, and the safe position of the wheel for loading.

use crate::machine::description_error::DescriptionError;

/// Door, chuck and safe place of a machine that is loaded by a robot or by hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadingDescription {
    /// Opening time of the door (s).
    pub door_opens_s: f64,
    /// Closing time of the door (s).
    pub door_closes_s: f64,
    /// Opening time of the chuck (s).
    pub chuck_opens_s: f64,
    /// Closing time of the chuck (s).
    pub chuck_closes_s: f64,
    /// X from which on the wheel leaves room for who loads (mm).
    pub safe_x_mm: f64,
}

impl LoadingDescription {
    pub(super) fn validate(&self) -> Result<(), DescriptionError> {
        for (what, value) in [
            ("time of the door to open (s)", self.door_opens_s),
            ("time of the door to close (s)", self.door_closes_s),
            ("time of the chuck to open (s)", self.chuck_opens_s),
            ("time of the chuck to close (s)", self.chuck_closes_s),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(DescriptionError::Negative { what, value });
            }
        }
        match self.safe_x_mm.is_finite() {
            true => Ok(()),
            false => Err(DescriptionError::Negative { what: "safe position of x_axis (mm)", value: self.safe_x_mm }),
        }
    }
}
