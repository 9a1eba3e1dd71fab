// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Runout that a correction leaves, with its uncertainty.
//!
//! The contact law alone leaves next to nothing. What is left comes from what is not known exactly. An error of the fitted radii is
//! carried on by the law, every cut reduces it by λ, and so does the correction; its covariance is that of the least squares. If km/kg is
//! another by its standard uncertainty, the part is another too: it is fitted again to the same readings, and ground by the same path.
//! Both are drawn at random, and the runout of each drawing is taken: the runout of an uncertain outline is larger than that of its mean.
//!
//! Errors of the drives and of the gauge's lag are not part of it.

use super::correction::Correction;
use super::runout::phase_rad;
use super::state::PartState;
use crate::math::noise::Noise;
use crate::math::range::minimum_and_maximum;
use crate::math::units::{um_from_mm, wrap_turn};
use alloc::vec::Vec;

/// Drawings. The 95th of 100 is uncertain by 2 in 100.
const DRAWINGS: usize = 400;
/// Places on the outline.
const PLACES: usize = 360;
const SEED: u64 = 0x5EED_CA11;
/// Error whose share in the result is computed (mm): as small as those that occur.
const ERROR_MM: f64 = 1e-4;

/// Expected runout after a correction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpectedRunout {
    /// Median (mm).
    pub median_mm: f64,
    /// Limit that 95 of 100 corrections keep (mm).
    pub limit_mm: f64,
    /// Median by the noise of the readings alone (mm); `None` if it is not known.
    pub by_noise_mm: Option<f64>,
    /// Runout by a standard uncertainty of km/kg alone (mm); `None` if it is not known.
    pub by_stiffness_mm: Option<f64>,
}

impl ExpectedRunout {
    /// Draws the errors of a correction of a part. `other` is the part as the readings show it if km/kg is larger by its standard uncertainty.
    #[must_use]
    pub fn from_correction(correction: &Correction, state: &PartState<'_>, other: Option<&PartState<'_>>) -> Self {
        let start_rad = correction.start_rad();
        let since = |place: usize| wrap_turn(phase_rad(place, PLACES) - start_rad);
        let after = |part: &PartState<'_>| -> Vec<f64> {
            let at = |place| correction.radii_mm(part, since(place))[2];
            (0..PLACES).map(at).collect()
        };
        let expected = after(state);
        let by_stiffness = other.map(|other| -> Vec<f64> {
            after(other).iter().zip(&expected).map(|(other, expected)| other - expected).collect()
        });
        let errors = state.errors();
        let with_error = after(&state.with_larger_deviation(ERROR_MM));
        let shares: Vec<f64> =
            with_error.iter().zip(&expected).map(|(with_error, expected)| (with_error - expected) / ERROR_MM).collect();
        let mut noise = Noise::new(SEED);
        let (mut all, mut by_noise) = (Vec::with_capacity(DRAWINGS), Vec::with_capacity(DRAWINGS));
        for _ in 0..DRAWINGS {
            let mut drawn = alloc::vec![0.0; PLACES];
            if let Some(errors) = errors {
                drawn =
                    errors.draw(&mut noise, PLACES).iter().zip(&shares).map(|(error, share)| error * share).collect();
            }
            by_noise.push(runout(drawn.iter().copied()));
            let times = noise.normal();
            let stiffness = |place: usize| by_stiffness.as_ref().map_or(0.0, |by| times * by[place]);
            all.push(runout((0..PLACES).map(|place| expected[place] + drawn[place] + stiffness(place))));
        }
        Self {
            median_mm: quantile(&mut all, 0.5),
            limit_mm: quantile(&mut all, 0.95),
            by_noise_mm: errors.map(|_| quantile(&mut by_noise, 0.5)),
            by_stiffness_mm: by_stiffness.map(|by| runout(by.into_iter())),
        }
    }
}

fn runout(radii_mm: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = minimum_and_maximum(radii_mm);
    high - low
}

/// Value that a share of the values does not exceed.
fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
    let index = libm::ceil(share * values.len() as f64) as usize;
    values[index.saturating_sub(1)]
}

impl core::fmt::Display for ExpectedRunout {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let um = |mm: Option<f64>| mm.map_or("not known".into(), |mm| alloc::format!("{:.3} um", um_from_mm(mm)));
        write!(
            f,
            "{:.3} um expected, below {:.3} um in 95 of 100 cases (gauge noise {}, uncertainty of the stiffness {}; drives not included)",
            um_from_mm(self.median_mm),
            um_from_mm(self.limit_mm),
            um(self.by_noise_mm),
            um(self.by_stiffness_mm)
        )
    }
}
