//! What a machine file says about what grinding takes.

use camwright::machine::description::{GrindingProcess, ReferenceCut};
use camwright::math::units::mm_from_um;
use serde::Deserialize;

/// The process of a machine: its wheel on the material that it grinds.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ProcessFile {
    specific_energy_j_mm3: f64,
    rubbing_n_mm2: f64,
    safe_footprint_speed_mm_s: f64,
    safe_depth_um: f64,
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

    /// Its values with their ranges, by key.
    pub(super) fn ranges(&self) -> [(&'static str, f64, f64, f64); 5] {
        [
            ("process.specific_energy_j_mm3", self.specific_energy_j_mm3, 0.1, 1e4),
            ("process.rubbing_n_mm2", self.rubbing_n_mm2, 0.0, 1e3),
            ("process.safe_footprint_speed_mm_s", self.safe_footprint_speed_mm_s, 1e-3, 1e5),
            ("process.safe_depth_um", self.safe_depth_um, 1e-3, 1e4),
            ("process.safe_equivalent_diameter_mm", self.safe_equivalent_diameter_mm, 1e-2, 1e4),
        ]
    }
}
