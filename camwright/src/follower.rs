//! What rides on the cam.

use thiserror::Error;

/// The follower for which a lift is specified. It moves along a line through the cam's axis, or beside it by an offset:
/// positive in the direction of increasing cam angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Follower {
    /// A point.
    KnifeEdge {
        /// Distance of its line from the cam's axis (mm).
        offset_mm: f64,
    },
    /// A roller.
    Roller {
        /// Radius (mm).
        radius_mm: f64,
        /// Distance of its line from the cam's axis (mm).
        offset_mm: f64,
    },
    /// A flat face square to its motion; an offset of its stem changes nothing.
    Flat,
}

/// Why a follower cannot ride on a cam.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FollowerError {
    /// A roller without a radius.
    #[error("roller radius {radius_mm} mm is not a positive number")]
    BadRadius {
        /// What was given (mm).
        radius_mm: f64,
    },
    /// The line of the follower misses the prime circle.
    #[error("follower offset {offset_mm} mm is not within the prime radius of {prime_radius_mm} mm")]
    OffsetTooLarge {
        /// Offset (mm).
        offset_mm: f64,
        /// Base radius and roller radius (mm).
        prime_radius_mm: f64,
    },
}

impl Follower {
    /// Radius of the roller (mm), 0 for a knife edge and a flat face.
    #[must_use]
    pub const fn roller_radius_mm(self) -> f64 {
        match self {
            Follower::Roller { radius_mm, .. } => radius_mm,
            Follower::KnifeEdge { .. } | Follower::Flat => 0.0,
        }
    }

    /// Distance of the follower's line from the cam's axis (mm).
    #[must_use]
    pub const fn offset_mm(self) -> f64 {
        match self {
            Follower::Roller { offset_mm, .. } | Follower::KnifeEdge { offset_mm } => offset_mm,
            Follower::Flat => 0.0,
        }
    }

    /// Height d₀ of the trace point above the axis at lift 0 (mm): √(prime radius² − offset²).
    ///
    /// # Errors
    /// A radius that is not positive, an offset that is not within the prime radius.
    pub fn trace_height_mm(self, base_radius_mm: f64) -> Result<f64, FollowerError> {
        let (radius_mm, offset_mm) = (self.roller_radius_mm(), self.offset_mm());
        if matches!(self, Follower::Roller { .. }) && (!radius_mm.is_finite() || radius_mm <= 0.0) {
            return Err(FollowerError::BadRadius { radius_mm });
        }
        let prime_radius_mm = base_radius_mm + radius_mm;
        if !offset_mm.is_finite() || offset_mm.abs() >= prime_radius_mm {
            return Err(FollowerError::OffsetTooLarge { offset_mm, prime_radius_mm });
        }
        Ok(libm::sqrt((prime_radius_mm - offset_mm) * (prime_radius_mm + offset_mm)))
    }
}
