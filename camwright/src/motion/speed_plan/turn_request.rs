// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Input for the fastest turn.

use crate::machine::description::{Axis, MotionLimits};
use crate::math::hermite::Sample;
use crate::math::periodic_spline::PeriodicSpline;
use thiserror::Error;

/// Share of the limits of X that the start of a search uses at constant speed.
const START_USE: f64 = 0.7;

/// A path, a bound on the speed over it, and the limits of the axes.
#[derive(Clone, Copy)]
pub struct TurnRequest<'a> {
    /// `x_axis` position over the path angle (mm over rad).
    pub path: &'a PeriodicSpline,
    /// Slope of X that the infeed adds to the path's (mm/rad).
    pub infeed_slope_mm_rad: f64,
    /// Largest speed of C that the process allows (rad/s), over the path angle and the path there, infeed not included.
    pub bound: &'a dyn Fn(f64, Sample) -> f64,
    pub c: MotionLimits,
    pub x: MotionLimits,
}

impl core::fmt::Debug for TurnRequest<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("TurnRequest").field("c", &self.c).field("x", &self.x).finish_non_exhaustive()
    }
}

impl TurnRequest<'_> {
    /// The path with the infeed in its slope.
    pub(super) fn with_infeed(&self, path: Sample) -> Sample {
        Sample { first: path.first + self.infeed_slope_mm_rad, ..path }
    }

    /// Largest share of its acceleration and jerk that X can use while C keeps its own limits and z = Ċ² is not above this, where X′, X″
    /// and X‴ are not above these.
    pub(super) fn largest_x_use(&self, [x1, x2, x3]: [f64; 3], z: f64) -> f64 {
        let acceleration = x2 * z + x1 * self.c.acceleration;
        let jerk = libm::sqrt(z) * (x3 * z + 3.0 * x2 * self.c.acceleration) + x1 * self.c.jerk;
        (acceleration / self.x.acceleration).max(jerk / self.x.jerk)
    }

    /// z = Ċ², or less where X′, X″ and X‴ of this size would use up the limits of X at a constant speed.
    pub(super) fn slowed_by_x(&self, [_, x2, x3]: [f64; 3], z: f64) -> f64 {
        let by_jerk = libm::cbrt(START_USE * self.x.jerk / x3);
        z.min(START_USE * self.x.acceleration / x2).min(by_jerk * by_jerk)
    }

    /// 1/Ċ² of the largest speed allowed by the process and by the velocities of both axes where the path is as given, infeed not
    /// included. Not a number where the process allows none.
    pub(super) fn per_square_bound(&self, angle_rad: f64, path: Sample) -> f64 {
        let process = (self.bound)(angle_rad, path);
        if process.is_nan() || process <= 0.0 {
            return f64::NAN;
        }
        // Infinite where the process does not care.
        let speed = process.min(self.c.velocity);
        let by_x = self.with_infeed(path).first / self.x.velocity;
        (1.0 / (speed * speed)).max(by_x * by_x)
    }
}

/// Why there is no turn.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TurnError {
    /// The process allows no speed somewhere.
    #[error(
        "the speed law allows {speed_rad_s:.3} rad/s at {angle_deg:.1} deg of the path; it must be a number above 0"
    )]
    NoSpeed {
        angle_deg: f64,
        /// Speed of the process law there (rad/s).
        speed_rad_s: f64,
    },
    /// The path is so rough that X cannot follow it at any speed worth the name.
    #[error("no speed keeps the limits of x_axis on this path")]
    NoStart,
    /// A limit is not a positive number.
    #[error("{} has a limit that is not a number above 0", .axis.joint())]
    BadLimit { axis: Axis },
}
