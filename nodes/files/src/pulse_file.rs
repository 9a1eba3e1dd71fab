// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Pulses of C and X that `camwright plan` counts, for a control that moves its axes by number and frequency of pulses.

use super::ConfigError;
use super::yaml::Document;
use camwright::math::units::mm_from_um;
use schemars::JsonSchema;
use serde::Deserialize;

/// Maximum number of steps of the cuts of a lobe that are counted.
const MAX_STEPS: f64 = 2e6;

/// Weight of a pulse of each axis, and the step of C over which pulses are counted.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PulsesFile {
    /// Angle of C per pulse.
    #[schemars(range(min = 1e-6, max = 1.0))]
    c_deg: f64,
    /// Travel of X per pulse.
    #[schemars(range(min = 1e-3, max = 1000.0))]
    x_um: f64,
    /// Step of C over which the pulses are counted: a whole part of 360 deg. Default: a block.
    #[schemars(range(min = 0.01, max = 45.0))]
    step_deg: Option<f64>,
    /// Maximum pulse frequency of the control; a higher one is a warning. Default: no limit.
    #[schemars(range(min = 1.0, max = 1e9))]
    max_frequency_hz: Option<f64>,
}

/// Pulses to be counted for a job.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PulseSettings {
    /// Angle of C per pulse (deg).
    pub c_deg: f64,
    /// Travel of X per pulse (mm).
    pub x_mm: f64,
    /// Steps of a turn.
    pub steps_per_turn: u32,
    /// Maximum pulse frequency of the control (Hz).
    pub max_frequency_hz: Option<f64>,
}

impl PulsesFile {
    /// Settings for a job of so many blocks in a turn, and so many turns on a lobe.
    pub(super) fn settings(&self, document: &Document, blocks: u32, turns: f64) -> Result<PulseSettings, ConfigError> {
        let refuse = |message: String| Err(document.error("pulses.step_deg", message));
        let steps = self.step_deg.map_or(f64::from(blocks), |step_deg| (360.0 / step_deg).round());
        if let Some(step_deg) = self.step_deg.filter(|step_deg| (360.0 / steps - step_deg).abs() > 1e-9 * step_deg) {
            let nearest_deg = 360.0 / steps;
            return refuse(format!(
                "pulses.step_deg is {step_deg}; it must be a whole part of 360 deg, the nearest is {nearest_deg}"
            ));
        }
        if steps * turns > MAX_STEPS {
            let smallest_deg = 360.0 * turns / MAX_STEPS;
            return refuse(format!(
                "pulses: {turns:.0} turns of {steps} steps are {:.0} steps on a lobe, at most {MAX_STEPS} are counted; set pulses.step_deg to \
                 {smallest_deg:.3} or more",
                steps * turns
            ));
        }
        #[allow(clippy::cast_possible_truncation, reason = "at most 36000")]
        let steps_per_turn = steps as u32;
        Ok(PulseSettings {
            c_deg: self.c_deg,
            x_mm: mm_from_um(self.x_um),
            steps_per_turn,
            max_frequency_hz: self.max_frequency_hz,
        })
    }
}
