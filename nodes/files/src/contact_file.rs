//! What a machine file says about how wheel and part give way to each other.

use super::ConfigError;
use super::machine_file::RangeCheck;
use super::yaml::Document;
use camwright::machine::description::{ContactDescription, StiffnessAt};
use serde::Deserialize;

/// N/µm to N/mm.
pub(super) const PER_MM: f64 = 1e3;

/// Contact of wheel and part.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ContactFile {
    machine_stiffness: Vec<StiffnessFile>,
    grinding_stiffness_n_um_mm: f64,
    threshold_force_n_mm: f64,
    #[serde(default = "half")]
    part_share: f64,
}

/// As much the part as the wheelhead.
fn half() -> f64 {
    0.5
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct StiffnessFile {
    z_mm: f64,
    n_um: f64,
}

impl ContactFile {
    pub(super) fn contact(&self) -> ContactDescription {
        ContactDescription {
            stiffness: self
                .machine_stiffness
                .iter()
                .map(|point| StiffnessAt { z_mm: point.z_mm, n_mm: PER_MM * point.n_um })
                .collect(),
            grinding_n_mm2: PER_MM * self.grinding_stiffness_n_um_mm,
            threshold_n_mm: self.threshold_force_n_mm,
            part_share: self.part_share,
        }
    }

    pub(super) fn check(&self, document: &Document, within: &RangeCheck<'_>, z: (f64, f64)) -> Result<(), ConfigError> {
        let key = "contact.machine_stiffness";
        if self.machine_stiffness.is_empty() {
            return Err(document.error(key, format!("{key} is empty, at least one is needed")));
        }
        for (index, point) in self.machine_stiffness.iter().enumerate() {
            within(&format!("{key}.{index}.z_mm"), point.z_mm, z.0, z.1)?;
            within(&format!("{key}.{index}.n_um"), point.n_um, 0.1, 1e4)?;
            let before = index.checked_sub(1).map(|before| self.machine_stiffness[before].z_mm);
            if let Some(before) = before.filter(|before| *before >= point.z_mm) {
                let message = format!("z_mm is {}, and that of the one before is {before}; they must rise", point.z_mm);
                return Err(document.error(&format!("{key}.{index}.z_mm"), message));
            }
        }
        within("contact.grinding_stiffness_n_um_mm", self.grinding_stiffness_n_um_mm, 1e-3, 1e3)?;
        within("contact.threshold_force_n_mm", self.threshold_force_n_mm, 0.0, 1e3)?;
        within("contact.part_share", self.part_share, 0.0, 1.0)
    }
}
