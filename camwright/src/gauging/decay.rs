// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! λ from a dwell, without any force: what a turn at constant wheel position leaves of every depth of cut.
//!
//! `U_j`(φ) = `U_0`(φ) λ^j. Of all phases together the λ is looked for with which the depths are best explained, every phase with its own
//! `U_0`: with w = (1, λ, λ² …) and `S_jk` = `Σ_φ U_j U_k` that is where wᵀS w / wᵀw is largest. Noise of the readings adds its square to the
//! diagonal of S and so to all w alike, and gives λ no bias, as it does to a ratio `U_1`/`U_0`.
//!
//! km/kg = 1/λ − 1, to be compared with what forces say.

use super::record::GaugeRecord;
use super::runout::{FEWEST_PHASES, phase_rad};
use super::state::MAX_PHASES;
use super::stiffness::MeasuredValue;
use crate::math::units::{TURN_RAD, deg_from_rad, um_from_mm};
use alloc::vec::Vec;
use thiserror::Error;

/// Most turns that are looked at: after 32 nothing is left of a cut.
const MAX_TURNS: f64 = 32.0;

/// λ looked for: of km/kg from 4 down to 0.001.
const RANGE: (f64, f64) = (0.2, 0.999);

/// Reasons why a dwell gives no decay.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum DecayError {
    /// A decay needs two turns.
    #[error("depths of cut are known over {known_deg:.2} deg of the dwell, {needed_deg:.2} deg are needed")]
    TooShort {
        /// Available angle (deg).
        known_deg: f64,
        /// Two turns (deg).
        needed_deg: f64,
    },
    /// Phases that are too few or too many.
    #[error("{phases} phases: between {min} and {max} are needed")]
    Phases { phases: usize, min: usize, max: usize },
    /// The part was hardly cut.
    #[error(
        "depths of cut of {:.3} um rms in the first turn are not above their scatter of {:.3} um",
        um_from_mm(*.depth_mm), um_from_mm(*.scatter_mm)
    )]
    NothingCut {
        /// Root mean square of the first turn's depths (mm).
        depth_mm: f64,
        /// Scatter (mm).
        scatter_mm: f64,
    },
    /// The depths did not decay.
    #[error(
        "depths of cut decay by {decay} per turn, which must lie between {min} and {max}: the wheel did not stand still"
    )]
    NoDecay {
        /// λ found, at an end of the range.
        decay: f64,
        min: f64,
        max: f64,
    },
}

/// Result of a dwell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decay {
    /// λ, left per turn.
    pub per_turn: MeasuredValue,
    /// km/kg = 1/λ − 1.
    pub ratio: MeasuredValue,
    /// Turns that were looked at.
    pub turns: usize,
    /// Standard deviation of a depth about the decay (mm).
    pub scatter_mm: f64,
}

impl Decay {
    /// From a dwell that began when the headstock was at `from_rad` and lasts to the end of the record, at `phases` equal steps. The
    /// uncertainty takes the depths for independent, as they are but for readings that two of them share; it is too large rather than
    /// too small.
    ///
    /// # Errors
    /// Less than two turns, phases that do not fit, depths that are not above their scatter or do not decay.
    pub fn from_dwell(record: &GaugeRecord<'_>, from_rad: f64, phases: usize) -> Result<Self, DecayError> {
        if !(FEWEST_PHASES..=MAX_PHASES).contains(&phases) {
            return Err(DecayError::Phases { phases, min: FEWEST_PHASES, max: MAX_PHASES });
        }
        let first_rad = record.first_cut_rad().max(from_rad);
        let known_rad = record.last_cut_rad() - first_rad;
        #[allow(clippy::cast_possible_truncation, reason = "clamped to 0 … 32")]
        let turns = libm::floor(known_rad / TURN_RAD + 1e-9).clamp(0.0, MAX_TURNS) as usize;
        let too_short =
            DecayError::TooShort { known_deg: deg_from_rad(known_rad), needed_deg: deg_from_rad(2.0 * TURN_RAD) };
        if turns < 2 {
            return Err(too_short);
        }
        let mut products = Products { turns, sums: alloc::vec![0.0; turns * turns] };
        let mut depths: Vec<f64> = alloc::vec![0.0; turns];
        for index in 0..phases {
            let mut c_rad = first_rad + phase_rad(index, phases);
            for depth in &mut depths {
                *depth = record.depth_mm(c_rad).ok_or(too_short)?;
                c_rad += TURN_RAD;
            }
            products.add(&depths);
        }
        let decay = products.best(RANGE);
        if decay < RANGE.0 + 1e-6 || decay > RANGE.1 - 1e-6 {
            return Err(DecayError::NoDecay { decay, min: RANGE.0, max: RANGE.1 });
        }
        let explained = products.explained(decay);
        let (phases, spare) = (phases as f64, (phases * (turns - 1) - 1) as f64);
        let scatter = libm::sqrt((products.total() - explained).max(0.0) / spare);
        // Σ U_0² is the explained part minus the part that noise explains by itself; only the part of dw/dλ across w determines λ.
        let (w, slope) = powers(decay, turns);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (ww, wd, dd) = (dot(&w, &w), dot(&w, &slope), dot(&slope, &slope));
        let first = (explained - phases * scatter * scatter) / ww;
        if first <= phases * scatter * scatter {
            let depth_mm = libm::sqrt(first.max(0.0) / phases);
            return Err(DecayError::NothingCut { depth_mm, scatter_mm: scatter });
        }
        let uncertainty = scatter / libm::sqrt(first * (dd - wd * wd / ww));
        Ok(Self {
            per_turn: MeasuredValue { value: decay, uncertainty },
            ratio: MeasuredValue { value: 1.0 / decay - 1.0, uncertainty: uncertainty / (decay * decay) },
            turns,
            scatter_mm: scatter,
        })
    }
}

/// km/kg by force and by decay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    pub by_force: MeasuredValue,
    pub by_decay: MeasuredValue,
    /// Value by decay minus value by force, and the uncertainty of the difference.
    pub difference: MeasuredValue,
}

impl Comparison {
    /// Compares the two measurements.
    #[must_use]
    pub fn from_measurements(by_force: MeasuredValue, by_decay: MeasuredValue) -> Self {
        let uncertainty = libm::hypot(by_force.uncertainty, by_decay.uncertainty);
        Self { by_force, by_decay, difference: MeasuredValue { value: by_decay.value - by_force.value, uncertainty } }
    }

    /// Returns whether they differ by no more than this number of standard uncertainties; 2 is usual.
    #[must_use]
    pub fn agrees(&self, coverage: f64) -> bool {
        self.difference.value.abs() <= coverage * self.difference.uncertainty
    }
}

/// w = (1, λ, λ² …) and dw/dλ.
fn powers(decay: f64, turns: usize) -> (Vec<f64>, Vec<f64>) {
    let (mut w, mut slope) = (Vec::with_capacity(turns), Vec::with_capacity(turns));
    let (mut power, mut below, mut turn) = (1.0, 0.0, 0.0);
    for _ in 0..turns {
        w.push(power);
        slope.push(turn * below);
        turn += 1.0;
        below = power;
        power *= decay;
    }
    (w, slope)
}

/// S: products of the depths of every two turns, summed over phases.
struct Products {
    turns: usize,
    sums: Vec<f64>,
}

impl Products {
    fn add(&mut self, depths: &[f64]) {
        for (row, a) in self.sums.chunks_mut(self.turns).zip(depths) {
            for (sum, b) in row.iter_mut().zip(depths) {
                *sum += a * b;
            }
        }
    }

    fn between(&self, a: &[f64], b: &[f64]) -> f64 {
        let rows = self.sums.chunks(self.turns).zip(a);
        rows.map(|(row, a)| a * row.iter().zip(b).map(|(sum, b)| sum * b).sum::<f64>()).sum()
    }

    /// Sum of the squares of all depths.
    fn total(&self) -> f64 {
        (0..self.turns).map(|turn| self.sums[turn * self.turns + turn]).sum()
    }

    /// Share explained by a decay: wᵀS w / wᵀw.
    fn explained(&self, decay: f64) -> f64 {
        let (w, _) = powers(decay, self.turns);
        self.between(&w, &w) / w.iter().map(|w| w * w).sum::<f64>()
    }

    /// Half the derivative of that, times (wᵀw)².
    fn slope(&self, decay: f64) -> f64 {
        let (w, slope) = powers(decay, self.turns);
        let ww = w.iter().map(|w| w * w).sum::<f64>();
        let wd = w.iter().zip(&slope).map(|(w, d)| w * d).sum::<f64>();
        self.between(&slope, &w) * ww - self.between(&w, &w) * wd
    }

    /// The λ that explains most: golden section, then bisection of the slope, since the top of a hill is flat to rounding within 1e-8.
    fn best(&self, (mut low, mut high): (f64, f64)) -> f64 {
        const RATIO: f64 = 0.618_033_988_749_894_9;
        for _ in 0..24 {
            let (left, right) = (high - RATIO * (high - low), low + RATIO * (high - low));
            if self.explained(left) >= self.explained(right) {
                high = right;
            } else {
                low = left;
            }
        }
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if self.slope(middle) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }
}
