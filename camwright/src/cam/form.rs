// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Form: how far a measured part lies from the contour it should have.

use crate::cam::contour::Contour;
use crate::math::range::minimum_and_maximum;
use crate::math::units::{TURN_RAD, deg_from_rad, wrap_turn};
use alloc::vec::Vec;
use thiserror::Error;

/// Why a form cannot be judged.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FormError {
    #[error("no radii were measured")]
    NoRadii,
    /// A radius that is none.
    #[error("radius {radius_mm} mm at azimuth {azimuth_deg:.3} deg is not a positive number")]
    BadRadius {
        /// Measured radius (mm).
        radius_mm: f64,
        /// Azimuth (deg).
        azimuth_deg: f64,
    },
}

/// One deviation from the contour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FormDeviation {
    /// Distance along the contour's normal (mm), positive where material is left.
    pub deviation_mm: f64,
    /// Azimuth of the measured point in the part's frame (rad).
    pub azimuth_rad: f64,
    /// Cam angle of the contour's nearest point (rad), in 0..2π.
    pub cam_angle_rad: f64,
}

/// A lift below this is none (mm): half of the last digit of a table in thousandths.
pub(super) const RESTS_MM: f64 = 0.000_5;

/// Shortest base circle that is one (rad): 20°.
pub const MIN_BASE_RAD: f64 = TURN_RAD / 18.0;

/// Undulations per turn of which waviness has a half: the usual limit between form and waviness of round parts (ISO 12181-2).
pub const WAVINESS_CUTOFF: usize = 15;

/// The form of one lobe.
#[derive(Debug, Clone, PartialEq)]
pub struct Form {
    /// Deviation along the normal at every azimuth (mm), in the order measured.
    pub deviations_mm: Vec<f64>,
    /// The deviation largest in size, with its sign.
    pub largest: FormDeviation,
    /// Root mean square over the azimuths (mm).
    pub rms_mm: f64,
}

impl Form {
    /// Mean deviation over the azimuths (mm).
    #[must_use]
    pub fn mean_mm(&self) -> f64 {
        self.deviations_mm.iter().sum::<f64>() / self.deviations_mm.len() as f64
    }
}

/// A measured crank pin: its least-squares circle, and what of the outline is off that circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PinForm {
    /// Radius of the circle less that of the design (mm).
    pub radius_error_mm: f64,
    /// Distance of its centre from the axis (mm).
    pub throw_mm: f64,
    /// That distance less the throw of the design (mm).
    pub throw_error_mm: f64,
    /// Angle about the axis from the design's centre to that of the circle (rad), positive with the azimuth.
    pub angle_error_rad: f64,
    /// Roundness: largest less smallest distance of the outline from the centre of the circle (mm).
    pub roundness_mm: f64,
}

impl Form {
    /// Compares radii measured at the azimuths i·2π/n of the part with a contour turned by `phase_rad` (its cam angle 0
    /// lies at that azimuth). Radii of a bore are negative, as [`Lobe::radii_mm`] has them; a positive deviation is material left in
    /// both cases.
    ///
    /// [`Lobe::radii_mm`]: crate::simulation::workpiece::Lobe::radii_mm
    ///
    /// # Errors
    /// No radii, or one that is not a positive number (of a bore a negative one).
    pub fn measure(radii_mm: &[f64], contour: &Contour, phase_rad: f64) -> Result<Self, FormError> {
        Self::measure_parallel(radii_mm, contour, phase_rad, 0.0)
    }

    /// The same with the parallel curve of the contour `above_mm` outside it as the design.
    ///
    /// # Errors
    /// See [`Form::measure`].
    pub fn measure_parallel(
        radii_mm: &[f64],
        contour: &Contour,
        phase_rad: f64,
        above_mm: f64,
    ) -> Result<Self, FormError> {
        let mut deviations_mm = Vec::with_capacity(radii_mm.len());
        let mut largest: Option<FormDeviation> = None;
        for (i, &radius_mm) in radii_mm.iter().enumerate() {
            let azimuth_rad = i as f64 * TURN_RAD / radii_mm.len() as f64;
            let distance_mm = contour.radius_sign() * radius_mm;
            if !distance_mm.is_finite() || distance_mm <= 0.0 {
                return Err(FormError::BadRadius { radius_mm, azimuth_deg: deg_from_rad(azimuth_rad) });
            }
            let (outside_mm, cam_angle) = contour.distance(distance_mm, azimuth_rad - phase_rad);
            let deviation_mm = outside_mm - above_mm;
            deviations_mm.push(deviation_mm);
            if largest.is_none_or(|largest| deviation_mm.abs() > largest.deviation_mm.abs()) {
                largest = Some(FormDeviation { deviation_mm, azimuth_rad, cam_angle_rad: wrap_turn(cam_angle) });
            }
        }
        let largest = largest.ok_or(FormError::NoRadii)?;
        let mean_square = deviations_mm.iter().map(|d| d * d).sum::<f64>() / deviations_mm.len() as f64;
        Ok(Self { deviations_mm, largest, rms_mm: libm::sqrt(mean_square) })
    }

    /// Least-squares circle and roundness of a crank pin; `None` for other contours.
    ///
    /// The mean of the deviations is the error of the radius, their first harmonic the displacement of the centre, and the rest the
    /// roundness: but for the square of the displacement over four radii, 0.001 µm for 10 µm on a pin of 50 mm.
    #[must_use]
    pub fn pin(&self, contour: &Contour, phase_rad: f64) -> Option<PinForm> {
        if !contour.is_pin() {
            return None;
        }
        let count = self.deviations_mm.len() as f64;
        let from_throw = |i: usize| libm::sincos(i as f64 * TURN_RAD / count - phase_rad);
        let (mut mean, mut along, mut across) = (0.0, 0.0, 0.0);
        for (i, deviation) in self.deviations_mm.iter().enumerate() {
            let (sin, cos) = from_throw(i);
            mean += deviation / count;
            along += 2.0 * deviation * cos / count;
            across += 2.0 * deviation * sin / count;
        }
        let off_circle = self.deviations_mm.iter().enumerate().map(|(i, deviation)| {
            let (sin, cos) = from_throw(i);
            deviation - mean - along * cos - across * sin
        });
        let (low, high) = minimum_and_maximum(off_circle);
        let throw_mm = libm::hypot(contour.throw_mm() + along, across);
        Some(PinForm {
            radius_error_mm: mean,
            throw_mm,
            throw_error_mm: throw_mm - contour.throw_mm(),
            angle_error_rad: libm::atan2(across, contour.throw_mm() + along),
            roundness_mm: high - low,
        })
    }

    /// Peak-to-valley error of the follower's lift (mm, or deg for an angular lift): the error along the normal times the transmission of
    /// the follower. A size error lifts the follower everywhere and is not part of it. See [`Contour::lift_per_depth`].
    #[must_use]
    pub fn lift_error(&self, contour: &Contour, phase_rad: f64) -> f64 {
        let azimuth = |i: usize| i as f64 * TURN_RAD / self.deviations_mm.len() as f64;
        let errors = self.deviations_mm.iter().enumerate().map(|(i, deviation_mm)| {
            deviation_mm * contour.lift_per_depth(contour.cam_angle_at(azimuth(i) - phase_rad))
        });
        let (low, high) = minimum_and_maximum(errors);
        if low <= high { high - low } else { 0.0 }
    }

    /// Peak-to-valley deviation (mm) without the slow waves of the form: a Gaussian filter transmits half of a wave with
    /// [`WAVINESS_CUTOFF`] undulations per turn, more of a faster one (ISO 16610-21).
    #[must_use]
    pub fn waviness_mm(&self) -> f64 {
        let count = self.deviations_mm.len();
        let turn: Vec<(f64, f64)> = (0..count)
            .map(|i| i as f64 * TURN_RAD / count as f64)
            .map(|angle| (libm::cos(angle), libm::sin(angle)))
            .collect();
        let mut waves = self.deviations_mm.clone();
        // The filter leaves less than 1e-4 of a wave with four times the cutoff.
        for order in 0..=(4 * WAVINESS_CUTOFF).min(count / 2) {
            let at = |i: usize| turn[order * i % count];
            let (cos, sin) =
                self.deviations_mm.iter().enumerate().fold((0.0, 0.0), |(cos, sin), (i, deviation)| {
                    (cos + deviation * at(i).0, sin + deviation * at(i).1)
                });
            let ratio = order as f64 / WAVINESS_CUTOFF as f64;
            // A wave has two coefficients, but the mean and the fastest one.
            let share = if order == 0 || 2 * order == count { 1.0 } else { 2.0 };
            let slow = libm::exp(-core::f64::consts::LN_2 * ratio * ratio) * share / count as f64;
            for (i, wave) in waves.iter_mut().enumerate() {
                *wave -= slow * (cos * at(i).0 + sin * at(i).1);
            }
        }
        let (low, high) = minimum_and_maximum(waves);
        if low <= high { high - low } else { 0.0 }
    }

    /// Size: the mean deviation (mm) over the base circle, where the lift is 0 but for the last digit of a table. What has no base
    /// circle of at least [`MIN_BASE_RAD`] (an eccentric) or is nothing else (a journal) is as large as it is all round.
    #[must_use]
    pub fn size_mm(&self, contour: &Contour, phase_rad: f64) -> f64 {
        let azimuth = |i: usize| i as f64 * TURN_RAD / self.deviations_mm.len() as f64;
        let rests =
            |i: usize| contour.lift().sample(contour.cam_angle_at(azimuth(i) - phase_rad)).value.abs() < RESTS_MM;
        let all = || self.deviations_mm.iter().copied().enumerate();
        let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
        let base: Vec<f64> = all().filter(|(i, _)| rests(*i)).map(|(_, deviation)| deviation).collect();
        let share = base.len() as f64 / self.deviations_mm.len() as f64;
        mean(if share * TURN_RAD < MIN_BASE_RAD { self.deviations_mm.clone() } else { base })
    }
}

impl Contour {
    /// Signed distance of a point (polar, in the cam's frame) from the contour along its normal (mm, positive outside),
    /// and the cam angle of the nearest point. Exact for points nearer than the radius of curvature.
    #[must_use]
    pub fn distance(&self, radius_mm: f64, azimuth_rad: f64) -> (f64, f64) {
        let mut cam_angle = self.cam_angle_at(azimuth_rad);
        // Newton's method on (P − Q)·T = 0, whose rate is −dl/dφ (1 + κ d); from the point at the same azimuth it needs
        // two or three steps for deviations of a machined part.
        for _ in 0..20 {
            let frame = self.local(cam_angle);
            let (x, y) = (
                radius_mm * libm::cos(azimuth_rad - cam_angle) - frame.along,
                radius_mm * libm::sin(azimuth_rad - cam_angle) - frame.across,
            );
            let outside = x * frame.normal_along + y * frame.normal_across;
            let beside = -x * frame.normal_across + y * frame.normal_along;
            let rate = frame.arc + frame.turning * outside;
            if self.radius_sign() * rate <= 0.0 {
                return (outside, cam_angle);
            }
            let change = beside / rate;
            if change.abs() <= 1e-12 {
                return (outside, cam_angle);
            }
            cam_angle += change.clamp(-0.1, 0.1);
        }
        let frame = self.local(cam_angle);
        let (x, y) = (
            radius_mm * libm::cos(azimuth_rad - cam_angle) - frame.along,
            radius_mm * libm::sin(azimuth_rad - cam_angle) - frame.across,
        );
        (x * frame.normal_along + y * frame.normal_across, cam_angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A circle of 25.002 mm about a centre 4 µm too far out and 3 µm aside, with three waves of 1 µm: each value is found again.
    #[test]
    fn a_pin_is_measured_about_its_own_circle() {
        let (throw_mm, radius_mm, phase) = (40.0, 25.0, 0.7);
        let contour = Contour::pin(throw_mm, radius_mm).expect("a pin");
        let (along, across) = (0.004, 0.003);
        let radius_at = |azimuth: f64| {
            let (sin, cos) = libm::sincos(azimuth - phase);
            let (forwards, aside) = (along * cos + across * sin, across * cos - along * sin);
            forwards + libm::sqrt(25.002 * 25.002 - aside * aside) + 0.001 * libm::cos(3.0 * azimuth)
        };
        let radii: Vec<f64> = (0..3600_u32).map(|i| radius_at(f64::from(i) * TURN_RAD / 3600.0)).collect();
        let form = Form::measure(&radii, &contour, phase).expect("an outline");
        let pin = form.pin(&contour, phase).expect("a pin");
        assert!((pin.radius_error_mm - 0.002).abs() < 3e-7, "{pin:?}");
        assert!((pin.throw_mm - libm::hypot(throw_mm + along, across)).abs() < 1e-8, "{pin:?}");
        assert!((pin.throw_error_mm - pin.throw_mm + throw_mm).abs() < 1e-12, "{pin:?}");
        assert!((pin.angle_error_rad - libm::atan2(across, throw_mm + along)).abs() < 1e-9, "{pin:?}");
        assert!((pin.roundness_mm - 0.002).abs() < 1e-6, "{pin:?}");
        let journal = Contour::eccentric(0.0, radius_mm).expect("a journal");
        assert_eq!(form.pin(&journal, phase), None);
    }

    /// Waves of the form are transmitted by 1 - 2^-(k/15)²: the mean not at all, half at the cutoff, a fast wave as a whole.
    #[test]
    fn waviness_is_the_form_without_its_slow_waves() {
        let waviness = |order: u32| {
            let count = 3600_u32;
            let deviation = |i: u32| 0.002 + 0.001 * libm::cos(TURN_RAD * f64::from(order * i) / f64::from(count));
            let deviations_mm: Vec<f64> = (0..count).map(deviation).collect();
            let largest = FormDeviation { deviation_mm: 0.003, azimuth_rad: 0.0, cam_angle_rad: 0.0 };
            Form { deviations_mm, largest, rms_mm: 0.0 }.waviness_mm()
        };
        for (order, share) in [(0, 0.0), (1, 1.0 - libm::exp2(-1.0 / 225.0)), (15, 0.5), (30, 0.9375), (90, 1.0)] {
            let found = waviness(order);
            assert!((found - 0.002 * share).abs() < 1e-9, "{order}: {found}");
        }
    }
}
