// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Free oscillation of an axis structure after power loss.

use crate::machine::description::Structure;
use crate::math::units::TURN_RAD;

/// The structure of an axis without power, by small steps of q̈ = −ω² q − 2 ζ ω q̇ − v̇ (see `mechanics.rs`).
#[derive(Debug, Clone, Copy)]
pub(super) struct FreeOscillation {
    structure: Option<Structure>,
    start: f64,
    ahead: f64,
    growth: f64,
}

impl FreeOscillation {
    /// Parts of a servo step: with 32 of them one of 250 Hz loses 1e-5 of its height in a period.
    const PARTS: u32 = 32;

    pub(super) fn new(structure: Option<Structure>, (ahead, growth): (f64, f64)) -> Self {
        Self { structure, start: ahead, ahead, growth }
    }

    pub(super) fn period_s(&self) -> f64 {
        self.structure.map_or(0.0, |structure| TURN_RAD / structure.frequency_rad_s)
    }

    /// Deflection relative to the beginning, one servo step later, in which the slide changes its speed by `change` per second. 0
    /// for a rigid axis.
    pub(super) fn after(&mut self, change: f64, step_s: f64) -> f64 {
        let Some(Structure { frequency_rad_s: w, damping, .. }) = self.structure else { return 0.0 };
        let part_s = step_s / f64::from(Self::PARTS);
        for _ in 0..Self::PARTS {
            // Half a part of way to either side of the change of speed.
            self.ahead += 0.5 * part_s * self.growth;
            self.growth -= part_s * (w * w * self.ahead + 2.0 * damping * w * self.growth + change);
            self.ahead += 0.5 * part_s * self.growth;
        }
        self.ahead - self.start
    }
}
