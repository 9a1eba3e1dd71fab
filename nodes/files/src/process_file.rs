// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Process data of grinding in a machine file.

use camwright::machine::description::{GrindingProcess, ReferenceCut};
use camwright::math::units::mm_from_um;
use schemars::JsonSchema;
use serde::Deserialize;

/// The process of a machine: its wheel on the material that it grinds.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ProcessFile {
    /// Energy per removed volume.
    #[schemars(range(min = 0.1, max = 1e4))]
    specific_energy_j_mm3: f64,
    /// Force of rubbing per contact area.
    #[schemars(range(min = 0.0, max = 1e3))]
    rubbing_n_mm2: f64,
    /// Speed of the contact in a cut that just does not burn (burn index 1).
    #[schemars(range(min = 1e-3, max = 1e5))]
    safe_footprint_speed_mm_s: f64,
    /// Depth of that cut along the normal.
    #[schemars(range(min = 1e-3, max = 1e4))]
    safe_depth_um: f64,
    /// Equivalent diameter of that cut.
    #[schemars(range(min = 1e-2, max = 1e4))]
    safe_equivalent_diameter_mm: f64,
}

impl ProcessFile {
    pub(super) fn process(&self) -> GrindingProcess {
        GrindingProcess {
            specific_energy_j_mm3: self.specific_energy_j_mm3,
            rubbing_n_mm2: self.rubbing_n_mm2,
            safe_cut: ReferenceCut {
                footprint_speed_mm_s: self.safe_footprint_speed_mm_s,
                depth_mm: mm_from_um(self.safe_depth_um),
                equivalent_diameter_mm: self.safe_equivalent_diameter_mm,
            },
        }
    }
}
