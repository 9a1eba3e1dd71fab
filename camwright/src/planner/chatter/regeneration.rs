// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Growth of waves from turn to turn: roots of the characteristic equation.

use super::compliance::ContactCompliance;
use crate::job::speed_variation::SpeedVariation;
use crate::math::complex::{Complex, exponential, logarithm, magnitude};
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;

/// Newton steps until a root is given up.
const MAX_STEPS: u32 = 60;

/// Largest number of waves in a turn that is examined.
const MAX_WAVES: f64 = 5000.0;

/// Waves that the wheel wears into its own rim.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelRegeneration {
    /// Time of a turn of the wheel (s).
    pub turn_s: f64,
    /// ks: force per depth that a turn wears off the wheel (N/mm).
    pub stiffness_n_mm: f64,
}

impl WheelRegeneration {
    /// Wheel of a grinding ratio G: the volume that the cut removes, over G, is the volume that it loses.
    #[must_use]
    pub fn new(
        grinding_n_mm: f64,
        grinding_ratio: f64,
        part_speed_mm_s: f64,
        (wheel_mm_s, turn_s): (f64, f64),
    ) -> Self {
        Self { turn_s, stiffness_n_mm: grinding_n_mm * grinding_ratio * wheel_mm_s / part_speed_mm_s }
    }

    /// Compliance that the worn waves add (mm/N).
    fn at(&self, s: Complex<f64>) -> Complex<f64> {
        regeneration(s, self.turn_s) / self.stiffness_n_mm
    }
}

/// 1/(1 − e^(−sT)).
fn regeneration(s: Complex<f64>, turn_s: f64) -> Complex<f64> {
    Complex::new(1.0, 0.0) / (Complex::new(1.0, 0.0) - exponential(-s * turn_s))
}

/// Plunge cut that meets its own waves every turn.
#[derive(Debug, Clone, PartialEq)]
pub struct RegenerativeCut {
    pub compliance: ContactCompliance,
    /// kg: normal force per depth of cut of a turn (N/mm).
    pub grinding_n_mm: f64,
    /// Time of a turn of the part (s).
    pub turn_s: f64,
    /// Waves on the wheel; `None`: it stays round.
    pub wheel: Option<WheelRegeneration>,
}

/// Wave with its growth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaveGrowth {
    /// Frequency of the vibration (Hz).
    pub frequency_hz: f64,
    /// Periods in a turn: of the part, or of the wheel for its own waves.
    pub waves_per_turn: f64,
    /// Factor of the amplitude after a turn; above 1 it grows.
    pub per_turn: f64,
    /// Factor of the amplitude after a second.
    pub per_s: f64,
}

impl WaveGrowth {
    fn from_root(s: Complex<f64>, turn_s: f64) -> Self {
        Self {
            frequency_hz: s.im / TURN_RAD,
            waves_per_turn: s.im * turn_s / TURN_RAD,
            per_turn: libm::exp(s.re * turn_s),
            per_s: libm::exp(s.re),
        }
    }

    #[must_use]
    pub fn is_growing(&self) -> bool {
        self.per_turn > 1.0
    }
}

impl RegenerativeCut {
    /// Compliance that a wave of the part meets (mm/N): the structure, and the waves on the wheel.
    fn total(&self, s: Complex<f64>) -> Complex<f64> {
        self.compliance.at(s) + self.wheel.map_or(Complex::ZERO, |wheel| wheel.at(s))
    }

    /// Λ: complex factor by which a turn multiplies a wave of the part at a complex frequency.
    #[must_use]
    pub fn wave_factor(&self, s: Complex<f64>) -> Complex<f64> {
        let force = self.total(s) * self.grinding_n_mm;
        force / (force + 1.0)
    }

    /// Factor of the amplitude of this number of waves after a turn, while the part turns at this speed (rad/s).
    #[must_use]
    pub fn planted_wave_per_turn(&self, waves: f64, speed_rad_s: f64) -> f64 {
        magnitude(self.wave_factor(Complex::new(0.0, waves * speed_rad_s)))
    }

    /// Mean factor by which a turn multiplies the wave that grows fastest while the work speed varies, and its number of waves.
    ///
    /// Waves keep their number on the part while the speed changes their frequency, so a slow turn multiplies a wave by another Λ. Half of
    /// the turns are slow, so the mean is the geometric one of both. It leaves out the changes of speed: a wave that crosses one gets another
    /// number, so that longer periods calm less. A simulation agrees within 6 % up to 2.5 turns and grows 12 % more at 3.
    #[must_use]
    pub fn varied_growth(&self, variation: &SpeedVariation) -> (f64, u32) {
        let planned_rad_s = TURN_RAD / self.turn_s;
        let growth = |waves: u32| {
            let factor = |speed_rad_s: f64| self.planted_wave_per_turn(f64::from(waves), speed_rad_s);
            libm::sqrt(factor(planned_rad_s) * factor(planned_rad_s * variation.slow_rate()))
        };
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most some ten thousand")]
        let max_waves = libm::ceil(f64::from(self.max_waves()) / variation.slow_rate()) as u32;
        let all = (1..=max_waves).map(|waves| (growth(waves), waves));
        all.fold((0.0, 1), |best, next| if next.0 > best.0 { next } else { best })
    }

    /// Waves of the part in a turn up to which the structure can vibrate.
    #[must_use]
    pub fn max_waves(&self) -> u32 {
        let waves = self.compliance.highest_rad_s() * self.turn_s / TURN_RAD;
        #[allow(clippy::cast_possible_truncation, reason = "clamped to 1 … 5000")]
        let waves = libm::ceil(waves).clamp(1.0, MAX_WAVES) as u32;
        waves
    }

    /// Growth of every wave of the part: a root of the characteristic equation for each number of waves, and those near the natural
    /// frequencies that belong to none.
    #[must_use]
    pub fn part_waves(&self) -> Vec<WaveGrowth> {
        let turn_s = self.turn_s;
        // (1 + kg G) − kg G e^(−sT), which has no poles but those of G.
        let equation = |s: Complex<f64>| {
            let force = self.total(s) * self.grinding_n_mm;
            force + 1.0 - force * exponential(-s * turn_s)
        };
        let start = |waves: u32| {
            let s = Complex::new(0.0, TURN_RAD * f64::from(waves) / turn_s);
            s + logarithm(self.wave_factor(s)) / turn_s
        };
        let natural = self.compliance.natural_rad_s().map(|rad_s| Complex::new(-0.05 * rad_s, rad_s));
        let starts = (1..=self.max_waves()).map(start).chain(natural);
        let roots = starts.filter_map(|start| root(start, &equation)).filter(|s| s.im > 0.1 / turn_s);
        roots.map(|s| WaveGrowth::from_root(s, turn_s)).collect()
    }

    /// Fastest growing wave of the part; `None` where no root was found.
    #[must_use]
    pub fn dominant(&self) -> Option<WaveGrowth> {
        self.part_waves().into_iter().max_by(|one, other| one.per_turn.total_cmp(&other.per_turn))
    }

    /// Fastest growing wave of the wheel; `None`: it stays round.
    #[must_use]
    pub fn dominant_of_wheel(&self) -> Option<WaveGrowth> {
        let wheel = self.wheel?;
        // What a wave of the wheel meets: the structure, and the waves of the part.
        let total = |s: Complex<f64>| self.compliance.at(s) + regeneration(s, self.turn_s) / self.grinding_n_mm;
        let equation = |s: Complex<f64>| {
            let force = total(s) * wheel.stiffness_n_mm;
            force + 1.0 - force * exponential(-s * wheel.turn_s)
        };
        let waves = self.compliance.highest_rad_s() * wheel.turn_s / TURN_RAD;
        #[allow(clippy::cast_possible_truncation, reason = "clamped to 1 … 5000")]
        let max_waves = libm::ceil(waves).clamp(1.0, MAX_WAVES) as u32;
        let roots = (1..=max_waves).filter_map(|waves| {
            // Beside the axis: on it 1 − e^(−sT) may be 0.
            let s = Complex::new(1e-3 / self.turn_s, TURN_RAD * f64::from(waves) / wheel.turn_s);
            let force = total(s) * wheel.stiffness_n_mm;
            root(s + logarithm(force / (force + 1.0)) / wheel.turn_s, &equation)
        });
        roots
            .filter(|s| s.im > 0.1 / wheel.turn_s)
            .map(|s| WaveGrowth::from_root(s, wheel.turn_s))
            .max_by(|one, other| one.per_turn.total_cmp(&other.per_turn))
    }

    /// Cutting stiffness up to which no wave grows at any work speed, −1/(2 min Re G) (N/mm); `None`: no cut chatters.
    #[must_use]
    pub fn unconditional_n_mm(&self) -> Option<f64> {
        self.compliance.unconditional_n_mm()
    }

    /// This cut at another time of a turn (s).
    #[must_use]
    pub fn at_turn(&self, turn_s: f64) -> Self {
        // ks goes with the speed of the wheel over that of the part.
        let faster = turn_s / self.turn_s;
        let wheel =
            self.wheel.map(|wheel| WheelRegeneration { stiffness_n_mm: wheel.stiffness_n_mm * faster, ..wheel });
        Self { turn_s, wheel, ..self.clone() }
    }
}

/// Root of an analytic function near a start, by Newton's method with the step limited; `None` where it does not converge.
fn root(start: Complex<f64>, function: &dyn Fn(Complex<f64>) -> Complex<f64>) -> Option<Complex<f64>> {
    let mut s = start;
    let reach = 0.05 * magnitude(start);
    for _ in 0..MAX_STEPS {
        let value = function(s);
        let side = 1e-6 * (1.0 + magnitude(s));
        let slope = (function(s + side) - function(s - side)) / (2.0 * side);
        let mut step = value / slope;
        let size = magnitude(step);
        if !size.is_finite() {
            return None;
        }
        if size > reach {
            step *= reach / size;
        }
        s -= step;
        if size < 1e-10 * (1.0 + magnitude(s)) {
            return Some(s);
        }
    }
    None
}
