// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Retract of the wheel after an alarm, in a machine file.

use camwright::machine::description::AlarmRetract;
use schemars::JsonSchema;
use serde::Deserialize;

/// Retract of the wheel after an alarm; see [`AlarmRetract`] for the defaults.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct AlarmRetractFile {
    /// Distance by which an alarm retracts the wheel from the farthest point of the lobe in front of it.
    /// Default: 2.
    #[schemars(range(min = 0.1, max = 100.0))]
    clearance_mm: Option<f64>,
    /// Energy of the drives after a mains failure. Default: 400.
    #[schemars(range(min = 0.0, max = 1e6))]
    buffered_energy_j: Option<f64>,
    /// Power of drives and control in addition to the motion. Default: 500.
    #[schemars(range(min = 0.0, max = 1e6))]
    standby_power_w: Option<f64>,
    /// Acceleration of an unpowered wheelhead by its weight or spring; 0: its brake holds it. Default: 2000.
    #[schemars(range(min = 0.0, max = 1e5))]
    drawback_mm_s2: Option<f64>,
}

impl AlarmRetractFile {
    pub(super) fn retract(&self) -> AlarmRetract {
        let ordinary = AlarmRetract::default();
        AlarmRetract {
            clearance_mm: self.clearance_mm.unwrap_or(ordinary.clearance_mm),
            buffered_energy_j: self.buffered_energy_j.unwrap_or(ordinary.buffered_energy_j),
            standby_w: self.standby_power_w.unwrap_or(ordinary.standby_w),
            drawback_mm_s2: self.drawback_mm_s2.unwrap_or(ordinary.drawback_mm_s2),
        }
    }
}
