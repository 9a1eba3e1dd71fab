// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Door and chuck in a machine file.

use camwright::machine::description::LoadingDescription;
use schemars::JsonSchema;
use serde::Deserialize;

/// Loading equipment of a machine.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LoadingFile {
    /// Door.
    door: LeafFile,
    /// Chuck.
    chuck: LeafFile,
    /// X at which the wheel clears the loader; within the soft limits.
    #[schemars(range(min = -1e5, max = 1e5))]
    pub(super) safe_x_mm: f64,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct LeafFile {
    /// Time to open.
    #[schemars(range(min = 1.0, max = 6e4))]
    opens_ms: f64,
    /// Time to close.
    #[schemars(range(min = 1.0, max = 6e4))]
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
}
