//! What the fastest turn is sought for.

use crate::machine::description::MotionLimits;
use crate::numeric::hermite::Sample;
use crate::numeric::periodic_spline::PeriodicSpline;

/// A path, a bound on the speed over it, and the limits of the axes.
#[derive(Clone, Copy)]
pub struct TurnRequest<'a> {
    /// `x_axis` position over the path angle (mm over rad).
    pub path: &'a PeriodicSpline,
    /// Slope of X that the infeed adds to the path's (mm/rad).
    pub infeed_slope_mm_rad: f64,
    /// Largest speed of C that the process allows, over the path angle (rad/s).
    pub bound: &'a dyn Fn(f64) -> f64,
    /// Limits of C.
    pub c: MotionLimits,
    /// Limits of X.
    pub x: MotionLimits,
}

impl core::fmt::Debug for TurnRequest<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("TurnRequest").field("c", &self.c).field("x", &self.x).finish_non_exhaustive()
    }
}

impl TurnRequest<'_> {
    /// X over the path angle, infeed included in its slope.
    pub(super) fn over_angle(&self, angle_rad: f64) -> Sample {
        let mut x = self.path.sample(angle_rad);
        x.first += self.infeed_slope_mm_rad;
        x
    }

    /// 1/Ċ² of the largest speed allowed by the process and by the velocities of both axes; X has this slope there. Not a number
    /// where the process allows none.
    pub(super) fn per_square_bound(&self, angle_rad: f64, slope: f64) -> f64 {
        let process = (self.bound)(angle_rad);
        if process.is_nan() || process <= 0.0 {
            return f64::NAN;
        }
        // Infinite where the process does not care.
        let speed = process.min(self.c.velocity);
        let by_x = slope / self.x.velocity;
        (1.0 / (speed * speed)).max(by_x * by_x)
    }
}
