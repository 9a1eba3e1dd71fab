// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Variation of the work speed as a remedy against chatter.

use super::regeneration::RegenerativeCut;
use crate::math::units::TURN_RAD;

/// Sinusoidal variation of the work speed about its mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedVariation {
    /// Amplitude as a share of the mean speed, 0 to below 1.
    pub amplitude: f64,
    /// Turns of the part in one period of the variation.
    pub period_turns: f64,
}

/// Phases of the variation and turns over which its growth is averaged.
const PHASES: u32 = 24;
const TURNS: u32 = 240;

impl SpeedVariation {
    /// Mean factor by which a turn multiplies the wave that grows fastest, and its number of waves.
    ///
    /// Waves keep their number on the part while the speed changes their frequency, so every turn multiplies a wave by another Λ: that of
    /// the speed at which the wheel meets it. The mean is the geometric one. It holds while the speed changes slowly against the
    /// vibration, which has many periods in a turn. A variation that repeats in every turn meets every place at the same speed always
    /// and has no effect.
    #[must_use]
    pub fn growth(&self, cut: &RegenerativeCut) -> (f64, u32) {
        let speed_rad_s = TURN_RAD / cut.turn_s;
        let fastest = speed_rad_s * (1.0 + self.amplitude);
        // Λ over the frequency in even steps, finer than a wave.
        let max_waves = cut.max_waves();
        let table = GrowthTable::new(cut, f64::from(max_waves) * fastest, 4 * max_waves.max(250));
        let mut highest = (0.0, 1);
        for waves in 1..=max_waves {
            for phase in 0..PHASES {
                let logarithms = (0..TURNS).map(|turn| {
                    let angle = TURN_RAD * (f64::from(phase) / f64::from(PHASES) + f64::from(turn) / self.period_turns);
                    let speed = speed_rad_s * (1.0 + self.amplitude * libm::sin(angle));
                    table.logarithm_at(f64::from(waves) * speed)
                });
                let mean = logarithms.sum::<f64>() / f64::from(TURNS);
                let factor = libm::exp(mean);
                if factor > highest.0 {
                    highest = (factor, waves);
                }
            }
        }
        highest
    }
}

/// Logarithm of the size of Λ over the frequency.
struct GrowthTable {
    logarithms: alloc::vec::Vec<f64>,
    step_rad_s: f64,
}

impl GrowthTable {
    fn new(cut: &RegenerativeCut, to_rad_s: f64, steps: u32) -> Self {
        let step_rad_s = to_rad_s / f64::from(steps);
        let logarithm =
            |i: u32| libm::log(cut.planted_wave_per_turn(1.0, (f64::from(i) * step_rad_s).max(1e-3 * step_rad_s)));
        Self { logarithms: (0..=steps + 1).map(logarithm).collect(), step_rad_s }
    }

    fn logarithm_at(&self, rad_s: f64) -> f64 {
        let at = rad_s / self.step_rad_s;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the table")]
        let index = at.clamp(0.0, (self.logarithms.len() - 2) as f64) as usize;
        let share = (at - index as f64).clamp(0.0, 1.0);
        self.logarithms[index] + share * (self.logarithms[index + 1] - self.logarithms[index])
    }
}
