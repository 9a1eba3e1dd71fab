// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Gap detector and keyway switch in a machine file.

use camwright::machine::description::{GapDetector, KeyWayProbe};
use camwright::math::units::rad_from_deg;
use schemars::JsonSchema;
use serde::Deserialize;

/// The gap detector of a machine.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GapDetectorFile {
    /// Time for which the input stays closed after the contact ends.
    #[schemars(range(min = 1.0, max = 1e4))]
    holds_ms: f64,
}

impl GapDetectorFile {
    pub(super) fn detector(&self) -> GapDetector {
        GapDetector { holds_s: self.holds_ms / 1e3 }
    }
}

/// The switch at the keyway.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct KeyWayProbeFile {
    /// Azimuth of the switch from the wheel's line.
    #[schemars(range(min = -360.0, max = 360.0))]
    at_deg: f64,
    /// Angle of the keyway.
    #[schemars(range(min = 0.1, max = 180.0))]
    width_deg: f64,
}

impl KeyWayProbeFile {
    pub(super) fn probe(&self) -> KeyWayProbe {
        KeyWayProbe { at_rad: rad_from_deg(self.at_deg), width_rad: rad_from_deg(self.width_deg) }
    }
}
