//! Deflection of wheel and part in a machine file.

use super::ConfigError;
use super::yaml::Document;
use camwright::machine::description::{ContactDescription, StiffnessAt};
use schemars::JsonSchema;
use serde::Deserialize;

/// N/µm to N/mm.
pub(super) const PER_MM: f64 = 1e3;

/// Contact of wheel and part.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ContactFile {
    /// km: stiffness of machine and part at the wheel along the contour's normal, over the position of `z_axis`;
    /// linear between points, constant beyond.
    #[schemars(length(min = 1, max = 1000))]
    machine_stiffness: Vec<StiffnessPointFile>,
    /// kg: normal force per depth of cut and width.
    #[schemars(range(min = 1e-3, max = 1e3))]
    grinding_stiffness_n_um_mm: f64,
    /// F0: normal force per width at which the wheel begins to cut.
    #[schemars(range(min = 0.0, max = 1e3))]
    threshold_force_n_mm: f64,
    /// Share of the part in the deflection; a gauge with one contact reads it.
    #[schemars(range(min = 0.0, max = 1.0))]
    #[serde(default = "half")]
    part_share: f64,
}

/// Equal shares of part and wheelhead.
fn half() -> f64 {
    0.5
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct StiffnessPointFile {
    /// Position of `z_axis`; within the soft limits, rising.
    #[schemars(range(min = -1e5, max = 1e5))]
    z_mm: f64,
    /// Stiffness.
    #[schemars(range(min = 0.1, max = 1e4))]
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

    /// Positions of `z_axis` at which the stiffness is given (mm).
    pub(super) fn positions_mm(&self) -> impl Iterator<Item = f64> {
        self.machine_stiffness.iter().map(|point| point.z_mm)
    }

    /// Refuses positions that do not rise.
    pub(super) fn check(&self, document: &Document) -> Result<(), ConfigError> {
        let pairs = self.machine_stiffness.windows(2).enumerate();
        let mut falling = pairs.filter(|(_, pair)| pair[0].z_mm >= pair[1].z_mm);
        falling.next().map_or(Ok(()), |(index, pair)| {
            let key = format!("contact.machine_stiffness.{}.z_mm", index + 1);
            let message = format!("{key} is {}; it must be above {}, the position before", pair[1].z_mm, pair[0].z_mm);
            Err(document.error(&key, message))
        })
    }
}
