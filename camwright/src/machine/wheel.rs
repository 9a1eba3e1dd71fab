// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Grinding wheel: size, speed and wear.

use crate::machine::axial_profile::{AxialProfile, MAX_AXIAL_MM};
use crate::machine::description_error::{DescriptionError, ordered};
use crate::math::units::{TURN_RAD, rpm_from_rad_s};
use thiserror::Error;

/// Largest difference between the wheel a plan was made for and the wheel that is mounted (mm): at 1 µm the form error it
/// makes is a few tenths of it.
pub const WHEEL_TOLERANCE_MM: f64 = 1e-3;

/// The grinding wheel as it is mounted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelDescription {
    /// Radius when new (mm).
    pub new_radius_mm: f64,
    /// Smallest usable radius (mm).
    pub min_radius_mm: f64,
    /// Width (mm).
    pub width_mm: f64,
    /// Speed at the rim when running (m/s).
    pub surface_speed_m_s: f64,
    /// Time to reach its speed or to come to rest (s).
    pub spin_up_s: f64,
    /// Speed at the rim at which it must not be run, for its own strength (m/s); `None`: unknown.
    pub max_surface_speed_m_s: Option<f64>,
    /// Fastest its spindle may turn (rad/s). At one surface speed a smaller wheel turns faster.
    pub max_speed_rad_s: Option<f64>,
    /// G, volume of the part removed per volume that the wheel loses doing it; `None` is a wheel that does not wear.
    pub grinding_ratio: Option<f64>,
    /// Amplitude of its centre by unbalance at speed, once a turn (mm).
    pub unbalance_mm: f64,
    /// Profile that every dress gives its rim, over its width. Its radius is that in the middle of the width.
    pub rim: AxialProfile,
}

impl WheelDescription {
    /// Checks that the values describe a possible wheel, or the insert of a lathe as what a spindle rotates.
    ///
    /// # Errors
    /// The first value that does not.
    pub(super) fn validate(&self, is_insert: bool) -> Result<(), DescriptionError> {
        let positive = |what: &'static str, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(DescriptionError::NotPositive { what, value }),
        };
        positive("wheel width (mm)", self.width_mm)?;
        // An insert that does not rotate has no speed; the insert itself is checked for the speed of its spindle.
        if !(is_insert && self.surface_speed_m_s == 0.0) {
            positive("wheel surface speed (m/s)", self.surface_speed_m_s)?;
        }
        positive("smallest wheel radius (mm)", self.min_radius_mm)?;
        positive("new wheel radius (mm)", self.new_radius_mm)?;
        if !is_insert {
            ordered("wheel radius", self.min_radius_mm, self.new_radius_mm)?;
        }
        for (what, value) in
            [("wheel spin-up time (s)", self.spin_up_s), ("unbalance of the wheel (mm)", self.unbalance_mm)]
        {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(DescriptionError::Negative { what, value });
            }
        }
        for (what, value) in
            [("taper of the wheel's rim (mm)", self.rim.taper_mm), ("crown of the wheel's rim (mm)", self.rim.crown_mm)]
        {
            if !(-MAX_AXIAL_MM..=MAX_AXIAL_MM).contains(&value) {
                return Err(DescriptionError::Outside { what, value, low: -MAX_AXIAL_MM, high: MAX_AXIAL_MM });
            }
        }
        if let Some(allowed) = self.max_surface_speed_m_s
            && (self.surface_speed_m_s > allowed || allowed.is_nan())
        {
            let (what, value) = ("wheel surface speed (m/s)", self.surface_speed_m_s);
            return Err(DescriptionError::AboveLimit { what, value, allowed });
        }
        for (what, value) in [
            ("largest speed of the wheel spindle (rad/s)", self.max_speed_rad_s),
            ("grinding ratio of the wheel", self.grinding_ratio),
        ] {
            value.map_or(Ok(()), |value| positive(what, value))?;
        }
        Ok(())
    }

    /// Radius of the rim beside the middle of the wheel less that in the middle (mm along Z, towards the tailstock).
    #[must_use]
    pub fn rim_mm(&self, z_mm: f64) -> f64 {
        self.rim.height_mm(z_mm, self.width_mm)
    }

    /// Profile that it gives to a lobe of this width in front of its middle (mm).
    #[must_use]
    pub fn ground_profile(&self, lobe_mm: f64) -> AxialProfile {
        -self.rim.over(self.width_mm, lobe_mm)
    }

    /// Speed of the spindle with a wheel of this radius at its surface speed (rad/s).
    #[must_use]
    pub fn speed_rad_s(&self, radius_mm: f64) -> f64 {
        1e3 * self.surface_speed_m_s / radius_mm
    }

    /// Checks that a wheel of this radius may run at its surface speed.
    ///
    /// # Errors
    /// Its spindle would turn too fast.
    pub fn check_speed(&self, radius_mm: f64) -> Result<(), WheelTooFast> {
        let speed_rad_s = self.speed_rad_s(radius_mm);
        match self.max_speed_rad_s {
            Some(max) if speed_rad_s > max * (1.0 + 1e-9) => Err(WheelTooFast {
                radius_mm,
                surface_speed_m_s: self.surface_speed_m_s,
                speed_rpm: rpm_from_rad_s(speed_rad_s),
                max_rpm: rpm_from_rad_s(max),
            }),
            _ => Ok(()),
        }
    }

    /// Radius loss of a wheel of this radius by removing `area_mm2` per width of cut (mm): volume removed over G is
    /// 2π·R·w per width.
    #[must_use]
    pub fn wear_mm(&self, radius_mm: f64, area_mm2: f64) -> f64 {
        self.grinding_ratio.map_or(0.0, |ratio| area_mm2 / (TURN_RAD * radius_mm * ratio))
    }
}

/// A wheel that would turn too fast.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "a wheel of radius {radius_mm:.4} mm turns at {speed_rpm:.1} rpm for its surface speed of {surface_speed_m_s} m/s; its \
     spindle is allowed {max_rpm:.1} rpm"
)]
pub struct WheelTooFast {
    /// Radius of the wheel (mm).
    pub radius_mm: f64,
    /// Speed at its rim (m/s).
    pub surface_speed_m_s: f64,
    /// Speed of its spindle.
    pub speed_rpm: f64,
    pub max_rpm: f64,
}
