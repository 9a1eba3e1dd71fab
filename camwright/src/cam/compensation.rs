// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Form compensation from part to part: the form error that was measured on the last part shifts the wheel's path of the next one.
//!
//! What drives, structure and grinding leave on a lobe comes back turn after turn and part after part. With the correction c of the
//! path along the contour's normal, the error e of the part, and G, what a correction does to the part (near 1), the law
//!
//! ```text
//! c(n+1) = c(n) − γ·e(n)      gives      e(n+1) = (1 − γG)·e(n)
//! ```
//!
//! which shrinks by 1 − γ a part where G is 1, and for a harmonic that comes with the phase lag λ and the amplitude g by
//! |1 − γ g e^(−iλ)|² = 1 − 2 γ g cos λ + γ² g², below 1 for γ g < 2 cos λ. So a smaller gain mends every lag below a quarter turn, and
//! no gain mends a larger one: there learning has to stop. [`LobeLearning`] sees which it is by what the parts say.

use crate::cam::contour::Contour;
use crate::cam::form::{Form, FormError};
use crate::math::periodic_spline::Sample;
use crate::math::range::minimum_and_maximum;
use crate::math::units::TURN_RAD;
use alloc::string::String;
use alloc::vec::Vec;

/// Harmonics of a turn that are learned unless a job says otherwise.
///
/// At 60 rpm harmonic k asks `x_axis` for k Hz. Up to 40 Hz a drive with feed-forward and a velocity loop of 95 Hz (600 rad/s) lags by
/// less than 25°, where every gain up to 1 converges; and a valve lobe's opening flank, some 60° of cam angle with four changes of
/// sign of its jerk, lies below harmonic 40.
pub const USUAL_HARMONICS: u32 = 40;

/// Most harmonics: beyond them a wave is shorter than 2°, on a base circle half a millimetre; no axis repeats what is that short.
pub const MAX_HARMONICS: u32 = 180;

/// Largest correction that can be allowed (mm): what is off by more is not the part that was measured.
pub const MAX_CORRECTION_MM: f64 = 0.1;

/// Steepest correction that can be allowed (mm/rad): 20 µm a degree, a hundredth of a valve lobe's flank.
pub const MAX_SLOPE_MM_RAD: f64 = 0.020 * 180.0 / core::f64::consts::PI;

/// Settings for learning the form error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompensationSpec {
    /// γ, share of the measured error that the next part is corrected by, above 0 and at most 1.
    pub gain: f64,
    /// Harmonics of a turn that are learned; what is shorter is left alone.
    pub harmonics: u32,
    /// Largest correction along the normal (mm).
    pub max_mm: f64,
    /// Steepest correction over the cam angle (mm/rad).
    pub max_slope_mm_rad: f64,
}

impl Default for CompensationSpec {
    fn default() -> Self {
        Self {
            gain: 0.7,
            harmonics: USUAL_HARMONICS,
            max_mm: 0.02,
            max_slope_mm_rad: 0.005 * 180.0 / core::f64::consts::PI,
        }
    }
}

/// Compensation of a job: its settings, and the corrections learned before this part.
#[derive(Debug, Clone, PartialEq)]
pub struct Compensation {
    /// Settings.
    pub spec: CompensationSpec,
    /// The corrections of this part; a lobe without one is ground as designed.
    pub learned: Vec<LearnedError>,
    /// Nothing learned earlier must be used: learning begins with this part.
    pub afresh: bool,
}

/// Learned correction of a lobe: the shift of its path.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnedError {
    /// Name of the lobe.
    pub lobe: String,
    /// Shift of the contour along its normal over the cam angle, positive outwards: less some share of the errors measured.
    pub correction: FormCurve,
}

/// A smooth periodic deviation along a contour's normal (mm) over the cam angle: m + Σ (aₖ cos kφ + bₖ sin kφ).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FormCurve {
    mean_mm: f64,
    waves_mm: Vec<[f64; 2]>,
}

impl FormCurve {
    /// From its mean and the cosine and sine of every harmonic from the first on (mm). `None` for what is not finite, or more than
    /// [`MAX_HARMONICS`].
    #[must_use]
    pub fn new(mean_mm: f64, waves_mm: Vec<[f64; 2]>) -> Option<Self> {
        let finite = mean_mm.is_finite() && waves_mm.iter().flatten().all(|value| value.is_finite());
        (finite && waves_mm.len() <= MAX_HARMONICS as usize).then_some(Self { mean_mm, waves_mm })
    }

    /// The deviation of a measured outline (radii at the azimuths i·2π/n of the part) from a contour that is turned by `phase_rad`,
    /// without anything shorter than these harmonics.
    ///
    /// The deviation at equal cam angles is read between the measured azimuths, and its Fourier sums are taken there.
    ///
    /// # Errors
    /// No radii, or one that is not a positive number.
    pub fn measure(radii_mm: &[f64], contour: &Contour, phase_rad: f64, harmonics: u32) -> Result<Self, FormError> {
        let deviations = Form::measure(radii_mm, contour, phase_rad)?.deviations_mm;
        let samples: Vec<f64> = (0..SAMPLES)
            .map(|i| f64::from(i) * TURN_RAD / f64::from(SAMPLES))
            .map(|cam_angle| between(&deviations, contour.azimuth(cam_angle) + phase_rad))
            .collect();
        Ok(Self::of_samples(&samples, harmonics))
    }

    /// Mean and at most [`MAX_HARMONICS`] harmonics of deviations at [`SAMPLES`] equal cam angles (mm).
    pub(super) fn of_samples(deviations_mm: &[f64], harmonics: u32) -> Self {
        let (mean_mm, waves_mm) = fourier_sums(deviations_mm, harmonics.min(MAX_HARMONICS));
        Self { mean_mm, waves_mm }
    }

    /// Its mean over the turn (mm).
    #[must_use]
    pub fn mean_mm(&self) -> f64 {
        self.mean_mm
    }

    /// Cosine and sine of every harmonic from the first on (mm).
    #[must_use]
    pub fn waves_mm(&self) -> &[[f64; 2]] {
        &self.waves_mm
    }

    #[must_use]
    pub fn is_zero(&self) -> bool {
        self.mean_mm.abs() <= 0.0 && self.waves_mm.iter().flatten().all(|value| value.abs() <= 0.0)
    }

    /// Root of its mean square over the turn (mm), by Parseval.
    #[must_use]
    pub fn rms_mm(&self) -> f64 {
        let waves: f64 = self.waves_mm.iter().flatten().map(|value| 0.5 * value * value).sum();
        libm::sqrt(self.mean_mm * self.mean_mm + waves)
    }

    /// Deviation (mm) and its derivatives (mm/rad, …) at a cam angle (rad).
    #[must_use]
    pub fn sample(&self, cam_angle_rad: f64) -> Sample {
        let (step_sin, step_cos) = libm::sincos(cam_angle_rad);
        let (mut sin, mut cos, mut k) = (0.0, 1.0, 0.0);
        let mut at = Sample { value: self.mean_mm, ..Sample::default() };
        for [a, b] in &self.waves_mm {
            (sin, cos) = (sin * step_cos + cos * step_sin, cos * step_cos - sin * step_sin);
            k += 1.0;
            let (value, slope) = (a * cos + b * sin, k * (b * cos - a * sin));
            at.value += value;
            at.first += slope;
            at.second -= k * k * value;
            at.third -= k * k * slope;
        }
        at
    }

    /// Largest size (mm) and largest slope (mm/rad), on a grid of a tenth of the shortest wave and at least every degree.
    #[must_use]
    pub fn largest(&self) -> (f64, f64) {
        #[allow(clippy::cast_possible_truncation, reason = "at most 180 harmonics")]
        let count = (10 * self.waves_mm.len() as u32).max(360);
        (0..count)
            .map(|i| self.sample(f64::from(i) * TURN_RAD / f64::from(count)))
            .fold((0.0, 0.0), |(size, slope), at| (f64::max(size, at.value.abs()), f64::max(slope, at.first.abs())))
    }

    /// Largest less smallest value over the turn (mm), on the same grid.
    #[must_use]
    pub fn peak_to_valley_mm(&self) -> f64 {
        #[allow(clippy::cast_possible_truncation, reason = "at most 180 harmonics")]
        let count = (10 * self.waves_mm.len() as u32).max(360);
        let values = (0..count).map(|i| self.sample(f64::from(i) * TURN_RAD / f64::from(count)).value);
        let (low, high) = minimum_and_maximum(values);
        high - low
    }

    /// This and so many times another; it has the harmonics of both.
    #[must_use]
    pub fn plus(&self, times: f64, other: &Self) -> Self {
        let wave = |of: &Self, k: usize| of.waves_mm.get(k).copied().unwrap_or_default();
        let waves = (0..self.waves_mm.len().max(other.waves_mm.len())).map(|k| {
            let ([a, b], [c, d]) = (wave(self, k), wave(other, k));
            [a + times * c, b + times * d]
        });
        Self { mean_mm: self.mean_mm + times * other.mean_mm, waves_mm: waves.collect() }
    }

    /// Without what is shorter than these harmonics.
    #[must_use]
    pub fn low_pass(&self, harmonics: u32) -> Self {
        Self { mean_mm: self.mean_mm, waves_mm: self.waves_mm.iter().take(harmonics as usize).copied().collect() }
    }

    /// The same made smaller all over until it keeps within what a job allows, and whether it had to be.
    #[must_use]
    pub fn bounded(&self, spec: &CompensationSpec) -> (Self, bool) {
        let (size, slope) = self.largest();
        let fits = |value: f64, max: f64| if value > max { max / value } else { 1.0 };
        let times = fits(size, spec.max_mm).min(fits(slope, spec.max_slope_mm_rad));
        (Self::default().plus(times, self), times < 1.0)
    }
}

/// Cam angles at which a measured deviation is read: twenty to a wave of the highest harmonic.
pub(super) const SAMPLES: u32 = 3600;

/// Mean of deviations at [`SAMPLES`] equal cam angles, and cosine and sine of their harmonics from the first on (mm).
pub(super) fn fourier_sums(deviations_mm: &[f64], harmonics: u32) -> (f64, Vec<[f64; 2]>) {
    let mut sums = alloc::vec![[0.0; 2]; harmonics as usize];
    let mut mean = 0.0;
    for (i, deviation) in (0_u32..).zip(deviations_mm) {
        let cam_angle = f64::from(i) * TURN_RAD / f64::from(SAMPLES);
        mean += deviation;
        let (step_sin, step_cos) = libm::sincos(cam_angle);
        let (mut sin, mut cos) = (0.0, 1.0);
        for sum in &mut sums {
            (sin, cos) = (sin * step_cos + cos * step_sin, cos * step_cos - sin * step_sin);
            sum[0] += deviation * cos;
            sum[1] += deviation * sin;
        }
    }
    let count = f64::from(SAMPLES);
    (mean / count, sums.iter().map(|[a, b]| [2.0 * a / count, 2.0 * b / count]).collect())
}

/// A curve over equal azimuths of a turn, read linearly between them.
#[allow(clippy::cast_possible_truncation, reason = "a few thousand azimuths")]
fn between(values: &[f64], azimuth_rad: f64) -> f64 {
    let place = azimuth_rad / TURN_RAD;
    let place = (place - libm::floor(place)) * values.len() as f64;
    let index = place as usize % values.len();
    let share = place - libm::floor(place);
    values[index] + share * (values[(index + 1) % values.len()] - values[index])
}

/// Use of the form error of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Learned {
    /// The correction went a step on.
    Step,
    /// The same, but the bounds of the job made the correction smaller.
    Bounded,
    /// The error had grown: the steps since it was least are taken back, and the gain is halved.
    TakenBack,
    /// It grew with every gain that was tried: the correction with which it was least stays, and no more is learned.
    Stopped,
}

/// An error this much larger than the least one has not grown (mm): what measuring and counts leave from part to part.
pub const SAME_MM: f64 = 0.000_1;

/// Below this share of the gain of the job learning stops: six halvings.
const MIN_GAIN: f64 = 1.0 / 64.0;

/// The learning of one lobe from part to part.
#[derive(Debug, Clone, PartialEq)]
pub struct LobeLearning {
    /// Correction of the next part.
    pub correction: FormCurve,
    /// γ of the next step (0: learning has stopped).
    pub gain: f64,
    /// Parts that were learned from.
    pub parts: u64,
    /// Correction and error of the part with the smallest error.
    pub smallest: Option<(FormCurve, FormCurve)>,
    /// The correction was taken back to that one: the next part says what error it has now.
    pub taken_back: bool,
}

impl LobeLearning {
    #[must_use]
    pub fn new(spec: &CompensationSpec) -> Self {
        Self { correction: FormCurve::default(), gain: spec.gain, parts: 0, smallest: None, taken_back: false }
    }

    /// Learns from the error of the part that was ground with [`Self::correction`].
    ///
    /// If the error grew by more than [`SAME_MM`], every step since the minimum is reverted and the gain is halved. The next part shows
    /// the error of the reverted correction: if that has changed, the machine has changed, and learning continues from there. A step
    /// that reduced the error as the gain predicts, to 1 − γ/2 or less, doubles the gain again, up to that of the job. The error with
    /// any correction that stays is therefore at most [`SAME_MM`] above the minimum, for any response of the machine.
    pub fn learn(&mut self, spec: &CompensationSpec, measured: &FormCurve) -> Learned {
        let error = measured.low_pass(spec.harmonics);
        self.parts += 1;
        if self.gain <= 0.0 {
            return Learned::Stopped;
        }
        let rms_mm = error.rms_mm();
        let min_mm = self.smallest.as_ref().map(|(_, error)| error.rms_mm());
        match &self.smallest {
            Some((correction, _)) if !self.taken_back && min_mm.is_some_and(|least| rms_mm > least + SAME_MM) => {
                self.correction = correction.clone();
                self.taken_back = true;
                self.gain *= 0.5;
                if self.gain < MIN_GAIN * spec.gain {
                    self.gain = 0.0;
                    return Learned::Stopped;
                }
                return Learned::TakenBack;
            }
            _ => {}
        }
        if self.taken_back || min_mm.is_none_or(|least| rms_mm <= least) {
            let as_expected = min_mm.is_some_and(|least| rms_mm <= (1.0 - 0.5 * self.gain) * least);
            if as_expected && !self.taken_back {
                self.gain = (2.0 * self.gain).min(spec.gain);
            }
            self.smallest = Some((self.correction.clone(), error.clone()));
            self.taken_back = false;
        }
        let (correction, was_bounded) = self.correction.plus(-self.gain, &error).bounded(spec);
        self.correction = correction;
        if was_bounded { Learned::Bounded } else { Learned::Step }
    }
}
