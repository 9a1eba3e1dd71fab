// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Deflection of wheel and part in a machine file.

use super::ConfigError;
use super::yaml::Document;
use camwright::machine::description::{ContactDescription, ContactMode, StiffnessAt};
use camwright::math::units::TURN_RAD;
use schemars::JsonSchema;
use serde::Deserialize;

/// N/µm to N/mm.
pub(super) const PER_MM: f64 = 1e3;

/// Contact of wheel and part.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ContactFile {
    /// km: stiffness of machine and part at the wheel along the contour's normal, over the position of `z_axis`;
    /// linear between points, constant beyond. For a job with `part_support` it is that of the machine alone.
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
    /// Modes that vibrate between wheel and part, from a tap test. Default: none, the deflection follows the force at once.
    #[schemars(length(max = 8))]
    #[serde(default)]
    modes: Vec<ContactModeFile>,
}

/// Vibration mode between wheel and part.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ContactModeFile {
    /// Natural frequency.
    #[schemars(range(min = 5.0, max = 5000.0))]
    frequency_hz: f64,
    /// Damping ratio.
    #[schemars(range(min = 1e-3, max = 0.9))]
    #[serde(default = "bolted")]
    damping: f64,
    /// Share of the static compliance 1/km that is the mode's; all modes together at most 0.95.
    #[schemars(range(min = 1e-3, max = 0.95))]
    compliance_share: f64,
}

/// Damping of a bolted machine of steel and iron.
fn bolted() -> f64 {
    0.04
}

impl ContactModeFile {
    fn mode(&self) -> ContactMode {
        let Self { frequency_hz, damping, compliance_share } = *self;
        ContactMode { frequency_rad_s: frequency_hz * TURN_RAD, damping, compliance_share }
    }
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
            modes: self.modes.iter().map(ContactModeFile::mode).collect(),
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
