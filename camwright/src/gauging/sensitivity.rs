// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Remaining error of a correction with wrong assumptions: closed forms.
//!
//! Each is a share of the amplitude that a harmonic had, of a part whose radii were measured right before the turn. A thought radius
//! r̂ in place of r leaves λ (r − r̂): the correction turn itself takes the rest of any error away.

use crate::machine::contact_law::ContactLaw;

/// Left where the gauge stands at an angle other than thought, by `error_rad`: 2 λ sin(h·|error|/2) of harmonic h. At km/kg = 0.2 a
/// degree leaves 1.5 % of the first harmonic, five leave 7 %.
#[must_use]
pub fn left_by_phase_error(law: &ContactLaw, harmonic: u32, error_rad: f64) -> f64 {
    2.0 * law.decay() * libm::sin(0.5 * f64::from(harmonic) * error_rad).abs()
}

/// Left where kg/km is thought to be (1 + error) of what it is: λ (1 − (1 + error)²), less than nothing where too much is corrected. The
/// ratio enters twice, in the runout and in the correction: at km/kg = 0.2, 10 % too much leave −17.5 %, 10 % too little +15.8 %.
#[must_use]
pub fn left_by_ratio_error(law: &ContactLaw, error: f64) -> f64 {
    law.decay() * (1.0 - (1.0 + error) * (1.0 + error))
}

/// Left by the published correction of a runout that is known: −km/(kg + km).
#[must_use]
pub fn left_by_published(law: &ContactLaw) -> f64 {
    law.decay() - 1.0
}

/// Standard deviation of the radius of one phase that was read once (mm), with readings of standard deviation `reading_mm`:
/// √2 kg/km times as large, before dwell turns and the cut of harmonics make it less.
#[must_use]
pub fn noise_of_radius_mm(law: &ContactLaw, reading_mm: f64) -> f64 {
    core::f64::consts::SQRT_2 * reading_mm * law.grinding_n_mm() / law.machine_n_mm()
}

/// The same after `turns` of a dwell, by least squares, as the radius at the end of it: λ^(m−1)/√(Σ λ^2j) of the noise of one.
#[must_use]
pub fn noise_after_dwell(law: &ContactLaw, turns: u32) -> f64 {
    let square = law.decay() * law.decay();
    let (mut sum, mut last) = (0.0, 1.0);
    for turn in 0..turns {
        last = if turn == 0 { 1.0 } else { last * square };
        sum += last;
    }
    libm::sqrt(last / sum)
}
