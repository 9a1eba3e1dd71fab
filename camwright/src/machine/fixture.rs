// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Bodies around the wheel in addition to the part: the dresser, headstock and tailstock on the table.

use crate::machine::description_error::DescriptionError;

/// A body of revolution about the spindle axis, on the table. `z` as `z_axis` reads when the middle of the wheel faces it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Start (mm of `z_axis`).
    pub from_mm: f64,
    /// End (mm of `z_axis`).
    pub to_mm: f64,
    /// Its largest radius about the spindle axis (mm).
    pub radius_mm: f64,
}

impl Extent {
    /// Returns whether it starts before it ends and has a size.
    #[must_use]
    pub fn is_body(&self) -> bool {
        self.from_mm < self.to_mm && self.radius_mm > 0.0 && self.to_mm - self.from_mm + self.radius_mm < f64::INFINITY
    }
}

/// A rotating dressing disc on the table. Its rim is what the wheel is measured by: a wheel that has been dressed at
/// `x_axis` = `x_mm` ends there, whatever it was before, so that its radius is known without measuring it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dresser {
    /// Distance of its rim from the spindle axis along X (mm): the wheel's cutting point stands there while it is dressed.
    pub x_mm: f64,
    /// `z_axis` at which its middle faces the wheel's (mm).
    pub z_mm: f64,
    /// Width along Z (mm).
    pub width_mm: f64,
    /// Speed of X on the last stretch up to it (mm/s).
    pub infeed_speed_mm_s: f64,
    /// Speed of the table while the wheel passes it (mm/s).
    pub traverse_speed_mm_s: f64,
    /// Time it stays in contact at the end of its way (s).
    pub dwell_s: f64,
    /// Most it may take off a wheel's radius in one dress (mm).
    pub max_depth_mm: f64,
}

/// Overtravel of the table beyond the wheel's edges during dressing (mm).
const OVERRUN_MM: f64 = 1.0;

impl Dresser {
    /// Way of the table that takes a wheel past it (mm), centred on `z_mm`.
    #[must_use]
    pub fn traverse_mm(&self, wheel_width_mm: f64) -> f64 {
        wheel_width_mm + self.width_mm + 2.0 * OVERRUN_MM
    }

    /// The room it takes.
    #[must_use]
    pub fn extent(&self) -> Extent {
        let half_mm = 0.5 * self.width_mm;
        Extent { from_mm: self.z_mm - half_mm, to_mm: self.z_mm + half_mm, radius_mm: self.x_mm }
    }

    pub(super) fn validate(&self) -> Result<(), DescriptionError> {
        for (what, value) in [
            ("position of the dresser along X (mm)", self.x_mm),
            ("width of the dresser (mm)", self.width_mm),
            ("infeed speed of the dresser (mm/s)", self.infeed_speed_mm_s),
            ("traverse speed of the dresser (mm/s)", self.traverse_speed_mm_s),
            ("largest depth of a dress (mm)", self.max_depth_mm),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(DescriptionError::NotPositive { what, value });
            }
        }
        for (what, value) in [("dwell of the dresser (s)", self.dwell_s), ("position of the dresser (mm)", self.z_mm)] {
            if !value.is_finite() || (what.starts_with("dwell") && value < 0.0) {
                return Err(DescriptionError::Negative { what, value });
            }
        }
        Ok(())
    }
}
