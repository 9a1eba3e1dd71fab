// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Stability lobes: largest cutting stiffness without chatter over the work speed.

use super::compliance::ContactCompliance;
use crate::math::complex::{Complex, magnitude};
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;

/// Frequencies at which the boundary is followed, in every interval with a negative real part.
const FREQUENCIES: u32 = 4000;

/// Boundary at one work speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LobePoint {
    /// Work speed (rad/s).
    pub speed_rad_s: f64,
    /// Cutting stiffness at the boundary (N/mm); infinite where nothing chatters.
    pub grinding_n_mm: f64,
    /// Frequency of the chatter there (Hz).
    pub frequency_hz: f64,
    /// Whole waves in a turn; the part of a wave beyond them is the phase.
    pub waves: u32,
}

/// Boundary over the work speed, without waves on the wheel.
///
/// At the frequency ω the boundary is kg = −1/(2 Re G), and the phase between two turns is ωT = 2πm − 2 atan2(Re G, Im G).
#[derive(Debug, Clone, PartialEq)]
pub struct StabilityLobes {
    pub points: Vec<LobePoint>,
}

/// Crossing of the axis: cutting stiffness at a frequency, and the phase beyond whole waves.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    rad_s: f64,
    grinding_n_mm: f64,
    phase_rad: f64,
}

impl StabilityLobes {
    /// Boundary at work speeds (rad/s).
    #[must_use]
    pub fn new(compliance: &ContactCompliance, speeds_rad_s: impl IntoIterator<Item = f64>) -> Self {
        let crossings = crossings(compliance);
        let points = speeds_rad_s.into_iter().map(|speed_rad_s| lowest(&crossings, speed_rad_s)).collect();
        Self { points }
    }
}

/// Frequencies with a negative real part, in order.
fn crossings(compliance: &ContactCompliance) -> Vec<Option<Crossing>> {
    let highest = compliance.highest_rad_s();
    let mut frequencies: Vec<f64> =
        (1..=FREQUENCIES).map(|i| highest * f64::from(i) / f64::from(FREQUENCIES)).collect();
    for natural in compliance.natural_rad_s() {
        frequencies.extend((0..=FREQUENCIES).map(|i| natural * (0.7 + 0.8 * f64::from(i) / f64::from(FREQUENCIES))));
    }
    frequencies.sort_by(f64::total_cmp);
    let crossing = |rad_s: &f64| {
        let at = compliance.at(Complex::new(0.0, *rad_s));
        let phase_rad = -2.0 * libm::atan2(at.re, at.im);
        let here = Crossing { rad_s: *rad_s, grinding_n_mm: -0.5 / at.re, phase_rad };
        (at.re < 0.0 && magnitude(at) > 0.0).then_some(here)
    };
    frequencies.iter().map(crossing).collect()
}

/// Lowest boundary at a speed: between two frequencies the number of waves passes a whole one.
fn lowest(crossings: &[Option<Crossing>], speed_rad_s: f64) -> LobePoint {
    let mut lowest = LobePoint { speed_rad_s, grinding_n_mm: f64::INFINITY, frequency_hz: 0.0, waves: 0 };
    let turn_s = TURN_RAD / speed_rad_s;
    for pair in crossings.windows(2) {
        let [Some(one), Some(other)] = pair else { continue };
        // ωT − phase passes a whole number of turns in between; the phase itself is continuous where Re G < 0.
        let beyond = |at: &Crossing| (at.rad_s * turn_s - at.phase_rad) / TURN_RAD;
        let (from, to) = (beyond(one), beyond(other));
        let (low, high) = (from.min(to), from.max(to));
        let whole = libm::ceil(low);
        let share = (whole - from) / (to - from);
        if whole > high || !share.is_finite() {
            continue;
        }
        let between = |a: f64, b: f64| a + share * (b - a);
        let grinding_n_mm = between(one.grinding_n_mm, other.grinding_n_mm);
        if grinding_n_mm < lowest.grinding_n_mm {
            let rad_s = between(one.rad_s, other.rad_s);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 on, some thousand")]
            let waves = libm::floor(rad_s * turn_s / TURN_RAD).max(0.0) as u32;
            lowest = LobePoint { grinding_n_mm, frequency_hz: rad_s / TURN_RAD, waves, ..lowest };
        }
    }
    lowest
}
