// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Sensors that locate the part: contact of the wheel, and position of the keyway.

use crate::machine::description_error::DescriptionError;
use crate::math::units::TURN_RAD;

/// A gap detector of the wheelhead, as acoustic emission sensors are: it closes when the wheel touches the part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GapDetector {
    /// Hold time of the closed input after the wheel has left the part (s).
    pub holds_s: f64,
}

impl GapDetector {
    pub(super) fn validate(&self) -> Result<(), DescriptionError> {
        match self.holds_s >= 0.0 && self.holds_s.is_finite() {
            true => Ok(()),
            false => Err(DescriptionError::Negative { what: "hold of the gap detector (s)", value: self.holds_s }),
        }
    }
}

/// A proximity switch that looks at the part where its keyway is, and is closed while the keyway stands under it.
///
/// ```text
/// azimuth under the switch  σ·C + at          closed while it is within half a width of the keyway's centre
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeyWayProbe {
    /// Angle of the probe: azimuth from the wheel's line (rad), in the direction in which azimuths of the part are counted.
    pub at_rad: f64,
    /// Angle that the keyway takes under it (rad).
    pub width_rad: f64,
}

impl KeyWayProbe {
    /// C where the keyway's centre stands under it (rad), of a part whose keyway lies at an azimuth (rad), with this rotation sense.
    #[must_use]
    pub fn centre_rad(&self, key_way_rad: f64, rotation_sense: i8) -> f64 {
        f64::from(rotation_sense) * (key_way_rad - self.at_rad)
    }

    /// Azimuth of the keyway (rad) of a part whose keyway's centre stood under it at this C (rad).
    #[must_use]
    pub fn key_way_rad(&self, centre_rad: f64, rotation_sense: i8) -> f64 {
        f64::from(rotation_sense) * centre_rad + self.at_rad
    }

    pub(super) fn validate(&self) -> Result<(), DescriptionError> {
        if !self.at_rad.is_finite() {
            return Err(DescriptionError::Negative { what: "angle of the keyway's switch (rad)", value: self.at_rad });
        }
        match self.width_rad > 0.0 && self.width_rad <= 0.5 * TURN_RAD {
            true => Ok(()),
            false => Err(DescriptionError::NotPositive {
                what: "angle of the keyway, at most half a turn (rad)",
                value: self.width_rad,
            }),
        }
    }
}
