//! What a machine file says about the gap detector and the switch at the key-way.

use camwright::machine::description::{GapDetector, KeyWayProbe};
use camwright::math::units::rad_from_deg;
use serde::Deserialize;

/// The gap detector of a machine.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GapDetectorFile {
    holds_ms: f64,
}

impl GapDetectorFile {
    pub(super) fn detector(&self) -> GapDetector {
        GapDetector { holds_s: self.holds_ms / 1e3 }
    }

    /// Its values with their ranges, by key.
    pub(super) fn ranges(&self) -> [(&'static str, f64, f64, f64); 1] {
        [("gap_detector.holds_ms", self.holds_ms, 1.0, 1e4)]
    }
}

/// The switch at the key-way.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KeyWayProbeFile {
    at_deg: f64,
    width_deg: f64,
}

impl KeyWayProbeFile {
    pub(super) fn probe(&self) -> KeyWayProbe {
        KeyWayProbe { at_rad: rad_from_deg(self.at_deg), width_rad: rad_from_deg(self.width_deg) }
    }

    /// Its values with their ranges, by key.
    pub(super) fn ranges(&self) -> [(&'static str, f64, f64, f64); 2] {
        [("key_way_probe.at_deg", self.at_deg, -360.0, 360.0), ("key_way_probe.width_deg", self.width_deg, 0.1, 180.0)]
    }
}
