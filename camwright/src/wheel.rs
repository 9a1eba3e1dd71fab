//! The grinding wheel as geometry.

use thiserror::Error;

/// A wheel at one moment of its life; dressing makes a new one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wheel {
    radius_mm: f64,
    width_mm: f64,
}

/// Why this is no wheel.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{what} of the wheel is {value_mm} mm, not a positive number")]
pub struct WheelError {
    /// Which dimension.
    pub what: &'static str,
    /// What was given (mm).
    pub value_mm: f64,
}

impl Wheel {
    /// A wheel.
    ///
    /// # Errors
    /// A dimension that is not a positive number.
    pub fn new(radius_mm: f64, width_mm: f64) -> Result<Self, WheelError> {
        for (what, value_mm) in [("the radius", radius_mm), ("the width", width_mm)] {
            if !value_mm.is_finite() || value_mm <= 0.0 {
                return Err(WheelError { what, value_mm });
            }
        }
        Ok(Self { radius_mm, width_mm })
    }

    /// Radius (mm).
    #[must_use]
    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// Width (mm).
    #[must_use]
    pub fn width_mm(&self) -> f64 {
        self.width_mm
    }
}
