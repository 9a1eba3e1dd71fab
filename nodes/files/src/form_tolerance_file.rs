// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Allowed form error of a lobe as a job writes it.

use camwright::cam::form_tolerance::FormTolerance;
use camwright::math::units::mm_from_um;
use schemars::JsonSchema;
use serde::Deserialize;

/// `form_tolerance` as written.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FormToleranceFile {
    /// Allowed deviation from the contour along its normal, in both directions, in every zone without a value of its own.
    #[schemars(range(min = 0.01, max = 1000.0))]
    #[serde(default = "default_all")]
    all_um: f64,
    /// Base circle: lift 0. Default: `all_um`.
    #[schemars(range(min = 0.01, max = 1000.0))]
    base_um: Option<f64>,
    /// Ramp and flank on which the follower rises. Default: `all_um`.
    #[schemars(range(min = 0.01, max = 1000.0))]
    opening_um: Option<f64>,
    /// Nose: from the largest velocity of the opening flank to that of the closing flank. Default: `all_um`.
    #[schemars(range(min = 0.01, max = 1000.0))]
    nose_um: Option<f64>,
    /// Flank and ramp on which the follower falls. Default: `all_um`.
    #[schemars(range(min = 0.01, max = 1000.0))]
    closing_um: Option<f64>,
}

fn default_all() -> f64 {
    5.0
}

impl Default for FormToleranceFile {
    fn default() -> Self {
        Self { all_um: default_all(), base_um: None, opening_um: None, nose_um: None, closing_um: None }
    }
}

impl FormToleranceFile {
    pub(super) fn tolerance(&self) -> FormTolerance {
        let mm = |zone_um: Option<f64>| mm_from_um(zone_um.unwrap_or(self.all_um));
        FormTolerance {
            base_mm: mm(self.base_um),
            opening_mm: mm(self.opening_um),
            nose_mm: mm(self.nose_um),
            closing_mm: mm(self.closing_um),
        }
    }
}
