//! What a machine file says about door and chuck.

use camwright::machine::description::LoadingDescription;
use serde::Deserialize;

/// What a machine is loaded through.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LoadingFile {
    door: LeafFile,
    chuck: LeafFile,
    safe_x_mm: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LeafFile {
    opens_ms: f64,
    closes_ms: f64,
}

impl LoadingFile {
    pub(super) fn loading(&self) -> LoadingDescription {
        LoadingDescription {
            door_opens_s: self.door.opens_ms / 1e3,
            door_closes_s: self.door.closes_ms / 1e3,
            chuck_opens_s: self.chuck.opens_ms / 1e3,
            chuck_closes_s: self.chuck.closes_ms / 1e3,
            safe_x_mm: self.safe_x_mm,
        }
    }

    /// Its values with their ranges, by key; X reaches so far (mm).
    pub(super) fn ranges(&self, x_mm: (f64, f64)) -> [(&'static str, f64, f64, f64); 5] {
        [
            ("loading.door.opens_ms", self.door.opens_ms, 1.0, 6e4),
            ("loading.door.closes_ms", self.door.closes_ms, 1.0, 6e4),
            ("loading.chuck.opens_ms", self.chuck.opens_ms, 1.0, 6e4),
            ("loading.chuck.closes_ms", self.chuck.closes_ms, 1.0, 6e4),
            ("loading.safe_x_mm", self.safe_x_mm, x_mm.0, x_mm.1),
        ]
    }
}
