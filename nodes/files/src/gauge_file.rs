// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! In-process gauge in a machine file.

use camwright::machine::description::{GaugeDescription, GaugeKind};
use camwright::math::units::{TURN_RAD, mm_from_um, rad_from_deg};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The gauge of a machine.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GaugeFile {
    /// Contacts of the gauge.
    kind: GaugeKindFile,
    /// Gamma: angle of its first contact behind the wheel, in the direction in which positive C turns the part.
    #[schemars(range(min = 0.0, max = 360.0))]
    behind_wheel_deg: f64,
    /// Gamma of a second gauge of the same kind. Default: one gauge.
    #[schemars(range(min = 0.0, max = 360.0))]
    second_behind_wheel_deg: Option<f64>,
    /// Resolution of a reading.
    #[schemars(range(min = 0.0, max = 1e3))]
    resolution_um: f64,
    /// Standard deviation of the noise.
    #[schemars(range(min = 0.0, max = 1e3))]
    noise_um: f64,
    /// Bandwidth of the amplifier (first-order lag). Default: no lag.
    #[schemars(range(min = 1e-3, max = 1e6))]
    bandwidth_hz: Option<f64>,
    /// Seed of the noise.
    #[serde(default)]
    seed: u64,
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum GaugeKindFile {
    /// Two opposed contacts.
    Diameter,
    /// One contact.
    Radius,
}

impl GaugeFile {
    pub(super) fn gauge(&self) -> GaugeDescription {
        GaugeDescription {
            kind: match self.kind {
                GaugeKindFile::Diameter => GaugeKind::Diameter,
                GaugeKindFile::Radius => GaugeKind::Radius,
            },
            behind_wheel_rad: rad_from_deg(self.behind_wheel_deg),
            second_behind_wheel_rad: self.second_behind_wheel_deg.map(rad_from_deg),
            resolution_mm: mm_from_um(self.resolution_um),
            noise_mm: mm_from_um(self.noise_um),
            bandwidth_rad_s: self.bandwidth_hz.map(|hz| hz * TURN_RAD),
            seed: self.seed,
        }
    }
}
