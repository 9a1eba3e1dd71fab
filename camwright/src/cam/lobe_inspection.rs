// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Inspection of a measured lobe as a cam measuring machine reports it: size, timing, lift error zone by zone, velocity error, waves.
//!
//! The lift error is that of the follower of the design, with the base circle at 0 and the lobe aligned in phase. The velocity error is the
//! change of the lift error over one degree of the cam.

use crate::cam::compensation::{MAX_HARMONICS, SAMPLES, fourier_sums};
use crate::cam::contour::Contour;
use crate::cam::form::WAVINESS_CUTOFF;
use crate::cam::form_tolerance::LobeZone;
use crate::cam::gauge_report::{
    Alignment, GaugeReport, GaugeReportError, Mounting, ReportKind, ReportedValue, VALUES_PER_WAVE,
};
use crate::math::range::minimum_and_maximum;
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;

/// Lift error in one zone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZoneError {
    pub zone: LobeZone,
    /// Smallest and largest lift error (mm, or deg of an angular lift).
    pub lift_error: (f64, f64),
}

/// Wave of the form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FormWave {
    /// Waves per turn of the cam.
    pub per_turn: usize,
    /// Amplitude along the normal (mm).
    pub amplitude_mm: f64,
}

/// Inspection of one lobe.
#[derive(Debug, Clone, PartialEq)]
pub struct LobeInspection {
    /// Mean deviation of the base circle (mm); of the whole lobe where there is none.
    pub size_mm: f64,
    /// Size, eccentricity and timing by least squares over the whole lobe.
    pub mounting: Mounting,
    /// Radial runout of the base circle (mm); `None` where there is none.
    pub base_runout_mm: Option<f64>,
    /// Zones that the lobe has.
    pub zones: Vec<ZoneError>,
    /// Largest velocity error in size (mm/deg, or deg/deg), and its cam angle (rad).
    pub velocity_error: (f64, f64),
    /// Strongest waves above the limit of waviness, the largest first.
    pub waves: Vec<FormWave>,
}

/// Waves that are listed.
const LISTED_WAVES: usize = 3;

impl LobeInspection {
    /// Inspects radii (mm) at the azimuths i·2π/n of a part on which cam angle 0 lies at `phase_rad`.
    ///
    /// # Errors
    /// Radii that are not positive numbers, or too few for the harmonics of a form.
    pub fn new(radii_mm: &[f64], contour: &Contour, phase_rad: f64) -> Result<Self, GaugeReportError> {
        let count = radii_mm.len();
        let value = |(index, radius_mm): (usize, &f64)| ReportedValue {
            line: index,
            angle_rad: index as f64 * TURN_RAD / count as f64,
            value_mm: *radius_mm,
        };
        let values: Vec<ReportedValue> = radii_mm.iter().enumerate().map(value).collect();
        let report = GaugeReport::new(ReportKind::Radius, &values, contour, phase_rad, MAX_HARMONICS)?;
        let angle = |i: u32| f64::from(i) * TURN_RAD / f64::from(SAMPLES);
        let aligned = report.without(Alignment { size: true, phase: true, eccentricity: false });
        let zone_of: Vec<LobeZone> = (0..SAMPLES).map(|i| LobeZone::at(contour, angle(i))).collect();
        let has_base = zone_of.contains(&LobeZone::Base);
        let base_mean = |deviations: &[f64]| {
            let is_base = |zone: &LobeZone| !has_base || *zone == LobeZone::Base;
            let chosen = deviations.iter().zip(&zone_of).filter(|(_, zone)| is_base(zone));
            let (sum, count) = chosen.fold((0.0, 0.0), |(sum, count), (deviation, _)| (sum + deviation, count + 1.0));
            sum / count
        };
        let zero_mm = base_mean(aligned.deviations_mm());
        let lift_errors: Vec<f64> = (0..)
            .zip(aligned.deviations_mm())
            .map(|(i, off)| (off - zero_mm) * contour.lift_per_depth(angle(i)))
            .collect();
        let within = |zone: LobeZone, errors: &[f64]| {
            let chosen = errors.iter().zip(&zone_of).filter(|(_, at)| **at == zone).map(|(error, _)| *error);
            let (low, high) = minimum_and_maximum(chosen);
            (low <= high).then_some((low, high))
        };
        let zones = LobeZone::ALL
            .into_iter()
            .filter_map(|zone| Some(ZoneError { zone, lift_error: within(zone, &lift_errors)? }))
            .collect();
        let base_runout_mm = within(LobeZone::Base, report.deviations_mm()).map(|(low, high)| high - low);
        // Half a degree is five samples of a tenth.
        let half = SAMPLES as usize / 720;
        let all = lift_errors.len();
        let change = |i: usize| lift_errors[(i + half) % all] - lift_errors[(i + all - half) % all];
        let velocity_error = (0..all)
            .map(|i| (change(i), i as f64 * TURN_RAD / all as f64))
            .fold((0.0, 0.0), |largest: (f64, f64), at| if at.0.abs() > largest.0.abs() { at } else { largest });
        let mut waves = all_waves(&report, count);
        waves.sort_by(|one, other| other.amplitude_mm.total_cmp(&one.amplitude_mm));
        waves.truncate(LISTED_WAVES);
        let size_mm = base_mean(report.deviations_mm());
        Ok(Self { size_mm, mounting: report.mounting(), base_runout_mm, zones, velocity_error, waves })
    }
}

/// Waves above the limit of waviness, up to the shortest that the radii and the samples show.
fn all_waves(report: &GaugeReport, radii: usize) -> Vec<FormWave> {
    #[allow(clippy::cast_possible_truncation, reason = "at most a quarter of the samples")]
    let shortest = ((radii as f64).min(f64::from(SAMPLES)) / VALUES_PER_WAVE) as u32;
    let (_, waves_mm) = fourier_sums(report.deviations_mm(), shortest);
    let wave = |(index, [cos, sin]): (usize, &[f64; 2])| FormWave {
        per_turn: index + 1,
        amplitude_mm: libm::hypot(*cos, *sin),
    };
    waves_mm.iter().enumerate().skip(WAVINESS_CUTOFF - 1).map(wave).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cam::form_tolerance::tests::lobe;
    use crate::math::units::rad_from_deg;
    use nalgebra::Vector2;

    /// Radii at even azimuths of a lobe with a deviation along its normal over the cam angle, turned by `turned_rad`.
    fn radii(contour: &Contour, turned_rad: f64, deviation: impl Fn(f64) -> f64) -> Vec<f64> {
        let radius = |azimuth: f64| {
            // The point whose offset lies at the azimuth, by bisection of what grows with the cam angle.
            let place = |cam_angle: f64| contour.point(cam_angle) + contour.normal(cam_angle) * deviation(cam_angle);
            let (mut low, mut high) = (azimuth - 1.0, azimuth + 1.0);
            let (sin, cos) = libm::sincos(azimuth);
            for _ in 0..80 {
                let middle = 0.5 * (low + high);
                let at: Vector2<f64> = place(middle);
                if cos * at.y - sin * at.x > 0.0 { high = middle } else { low = middle }
            }
            place(low).norm()
        };
        (0..3600_u32).map(|i| radius(f64::from(i) * TURN_RAD / 3600.0 - turned_rad)).collect()
    }

    #[test]
    fn planted_size_timing_and_wave_are_reported() {
        let contour = lobe();
        let turned_rad = rad_from_deg(0.03);
        let wave = |angle: f64| 0.004 + 0.000_5 * libm::cos(30.0 * angle);
        let found = LobeInspection::new(&radii(&contour, turned_rad, wave), &contour, 0.0).expect("an inspection");
        assert!((found.mounting.size_mm - 0.004).abs() < 2e-5 && (found.size_mm - 0.004).abs() < 2e-5, "{found:?}");
        assert!((found.mounting.phase_rad.expect("separable") - turned_rad).abs() < 1e-5, "{found:?}");
        assert!((found.base_runout_mm.expect("a base circle") - 0.001).abs() < 2e-5, "{found:?}");
        let zones: Vec<LobeZone> = found.zones.iter().map(|zone| zone.zone).collect();
        assert_eq!(zones, LobeZone::ALL);
        for zone in &found.zones {
            let (low, high) = zone.lift_error;
            assert!((low + 0.000_5).abs() < 3e-5 && (high - 0.000_5).abs() < 3e-5, "{zone:?}");
        }
        // The change of a cosine over one degree: 2 A sin(k/2 deg).
        let velocity = 2.0 * 0.000_5 * libm::sin(30.0 * rad_from_deg(0.5));
        assert!((found.velocity_error.0.abs() - velocity).abs() < 2e-5, "{:?} {velocity}", found.velocity_error);
        assert_eq!(found.waves[0].per_turn, 30);
        let chatter = |angle: f64| 0.000_5 * libm::cos(600.0 * angle);
        let fast = LobeInspection::new(&radii(&contour, 0.0, chatter), &contour, 0.0).expect("an inspection");
        let strongest = fast.waves[0];
        assert!(strongest.per_turn == 600 && (strongest.amplitude_mm - 0.000_5).abs() < 5e-5, "{:?}", fast.waves);
        assert!(
            (found.waves[0].amplitude_mm - 0.000_5).abs() < 1e-6 && found.waves[1].amplitude_mm < 1e-5,
            "{found:?}"
        );
    }

    #[test]
    fn zones_follow_the_motion_of_the_follower() {
        let contour = lobe();
        // 2x²(2n − 1) = 1 gives the largest velocity of (1 − x²)ⁿ: x = 0.302 of 100° for n = 6.
        let zones =
            [(0.0, LobeZone::Base), (140.0, LobeZone::Opening), (151.0, LobeZone::Nose), (209.0, LobeZone::Nose)];
        for (deg, zone) in zones.into_iter().chain([(149.0, LobeZone::Opening), (211.0, LobeZone::Closing)]) {
            assert_eq!(LobeZone::at(&contour, rad_from_deg(deg)), zone, "{deg}");
        }
        let too_few = LobeInspection::new(&[20.0; 100], &contour, 0.0);
        assert!(matches!(too_few, Err(GaugeReportError::Gap { .. })), "{too_few:?}");
    }
}
