// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Allowed form error of a lobe, zone by zone, and the place that uses most of it.

use crate::cam::contour::Contour;
use crate::cam::form::{Form, FormDeviation, RESTS_MM};
use crate::math::units::{TURN_RAD, wrap_turn};
use core::ops::RangeInclusive;

/// Zone of a lobe by the motion of its follower.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LobeZone {
    /// Lift 0.
    Base,
    /// The lift, or the depth of a pocket below the base circle, rises and its velocity grows: ramp and flank.
    Opening,
    /// The velocity of the lift falls: between the largest velocities of both flanks.
    Nose,
    /// The lift falls and its velocity grows towards 0.
    Closing,
}

impl LobeZone {
    /// All zones in the order of the cam angle.
    pub const ALL: [Self; 4] = [Self::Base, Self::Opening, Self::Nose, Self::Closing];

    /// Zone of a cam angle (rad).
    #[must_use]
    pub fn at(contour: &Contour, cam_angle_rad: f64) -> Self {
        let lift = contour.lift().sample(cam_angle_rad);
        let sense = if lift.value < 0.0 { -1.0 } else { 1.0 };
        if lift.value.abs() < RESTS_MM {
            Self::Base
        } else if sense * lift.second < 0.0 {
            Self::Nose
        } else if sense * lift.first >= 0.0 {
            Self::Opening
        } else {
            Self::Closing
        }
    }
}

/// Allowed deviation along the normal (mm), in both directions, for each zone of a lobe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FormTolerance {
    pub base_mm: f64,
    pub opening_mm: f64,
    pub nose_mm: f64,
    pub closing_mm: f64,
}

impl Default for FormTolerance {
    /// 5 µm everywhere.
    fn default() -> Self {
        Self::uniform(0.005)
    }
}

/// Deviation that uses most of what is allowed in its zone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JudgedDeviation {
    pub deviation: FormDeviation,
    /// Allowed deviation there (mm).
    pub allowed_mm: f64,
    pub zone: LobeZone,
}

impl JudgedDeviation {
    /// Deviation relative to what is allowed; above 1 the lobe is out of tolerance.
    #[must_use]
    pub fn used(&self) -> f64 {
        self.deviation.deviation_mm.abs() / self.allowed_mm
    }
}

impl FormTolerance {
    /// Range of an allowed deviation (mm).
    pub const RANGE_MM: RangeInclusive<f64> = 1e-5..=1.0;

    /// The same allowed deviation (mm) in every zone.
    #[must_use]
    pub const fn uniform(allowed_mm: f64) -> Self {
        Self { base_mm: allowed_mm, opening_mm: allowed_mm, nose_mm: allowed_mm, closing_mm: allowed_mm }
    }

    /// Allowed deviation in a zone (mm).
    #[must_use]
    pub fn allowed_mm(&self, zone: LobeZone) -> f64 {
        match zone {
            LobeZone::Base => self.base_mm,
            LobeZone::Opening => self.opening_mm,
            LobeZone::Nose => self.nose_mm,
            LobeZone::Closing => self.closing_mm,
        }
    }

    /// Smallest allowed deviation of all zones (mm).
    #[must_use]
    pub fn smallest_mm(&self) -> f64 {
        LobeZone::ALL.into_iter().map(|zone| self.allowed_mm(zone)).fold(f64::INFINITY, f64::min)
    }

    /// Largest allowed deviation of all zones (mm).
    #[must_use]
    pub fn largest_mm(&self) -> f64 {
        LobeZone::ALL.into_iter().map(|zone| self.allowed_mm(zone)).fold(0.0, f64::max)
    }

    /// Returns the deviation of a form that uses most of what is allowed; its contour is turned by `phase_rad`, as for [`Form::measure`].
    #[must_use]
    pub fn judge(&self, form: &Form, contour: &Contour, phase_rad: f64) -> JudgedDeviation {
        let count = form.deviations_mm.len();
        let at = |deviation: FormDeviation| {
            let zone = LobeZone::at(contour, deviation.cam_angle_rad);
            JudgedDeviation { deviation, allowed_mm: self.allowed_mm(zone), zone }
        };
        let mut worst = at(form.largest);
        // No zone allows more than the largest: what uses less of that is not the worst.
        let largest_mm = self.largest_mm();
        if self.smallest_mm() < largest_mm {
            for (index, &deviation_mm) in form.deviations_mm.iter().enumerate() {
                if deviation_mm.abs() <= worst.used() * self.smallest_mm() {
                    continue;
                }
                let azimuth_rad = index as f64 * TURN_RAD / count as f64;
                let cam_angle_rad = wrap_turn(contour.cam_angle_at(azimuth_rad - phase_rad));
                let judged = at(FormDeviation { deviation_mm, azimuth_rad, cam_angle_rad });
                if judged.used() > worst.used() {
                    worst = judged;
                }
            }
        }
        worst
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::cam::follower::Follower;
    use crate::cam::lift::LiftLaw;
    use crate::math::units::rad_from_deg;
    use alloc::vec::Vec;

    /// 3 mm (1 − x²)⁶ over ±100° about 180°, under a flat follower: lift error and error along the normal are the same.
    pub(in crate::cam) fn lobe() -> Contour {
        let lift = |angle: f64| {
            let x = (angle - TURN_RAD / 2.0) / rad_from_deg(100.0);
            if x.abs() < 1.0 { 3.0 * libm::pow(1.0 - x * x, 6.0) } else { 0.0 }
        };
        Contour::from_lift(&LiftLaw::from_fn(lift).expect("a lift"), &Follower::Flat, 25.0).expect("a contour")
    }

    /// A form with deviations (mm) at azimuths (deg), 0 elsewhere.
    fn form(contour: &Contour, phase_rad: f64, deviations: &[(f64, f64)]) -> Form {
        let radii: Vec<f64> = (0..3600)
            .map(|i| {
                let azimuth_deg = f64::from(i) / 10.0;
                let deviation = deviations.iter().find(|(deg, _)| (deg - azimuth_deg).abs() < 0.01);
                contour.radius_at(rad_from_deg(azimuth_deg) - phase_rad) + deviation.map_or(0.0, |(_, mm)| *mm)
            })
            .collect();
        Form::measure(&radii, contour, phase_rad).expect("radii")
    }

    /// 3 µm on the base circle count more than 6 µm on the nose where 2 and 8 µm are allowed.
    #[test]
    fn the_worst_deviation_is_that_which_uses_most_of_its_tolerance() {
        let contour = lobe();
        for phase_rad in [0.0, 0.7] {
            let phase_deg = phase_rad * 360.0 / TURN_RAD;
            let at = |cam_deg: f64| ((cam_deg + phase_deg) * 10.0).round().rem_euclid(3600.0) / 10.0;
            let form = form(&contour, phase_rad, &[(at(20.0), -0.003), (at(180.0), 0.006)]);
            let tolerance = FormTolerance { base_mm: 0.002, nose_mm: 0.008, ..FormTolerance::default() };
            let worst = tolerance.judge(&form, &contour, phase_rad);
            assert_eq!((worst.zone, worst.allowed_mm), (LobeZone::Base, 0.002), "{worst:?}");
            assert!((worst.used() - 1.5).abs() < 1e-6, "{worst:?}");
            assert!((worst.deviation.azimuth_rad - rad_from_deg(at(20.0))).abs() < 1e-9, "{worst:?}");
            let worst = FormTolerance::uniform(0.008).judge(&form, &contour, phase_rad);
            assert_eq!(worst.zone, LobeZone::Nose);
            assert!((worst.used() - 0.75).abs() < 1e-3, "{worst:?}");
        }
    }

    #[test]
    fn a_tolerance_has_its_smallest_and_largest_zone() {
        let tolerance = FormTolerance { opening_mm: 0.001, closing_mm: 0.02, ..FormTolerance::default() };
        assert_eq!((tolerance.smallest_mm(), tolerance.largest_mm()), (0.001, 0.02));
    }
}
