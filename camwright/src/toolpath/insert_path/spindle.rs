// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Spindle law along a path: from rest to a constant speed and to rest again, with every slide within its limits.
//!
//! While C runs up, X moves with ẋ = X′ω, ẍ = X″ω² + X′ω̇, and the jerk X‴ω³ + 3X″ωω̇ + X′ω̈. With the largest magnitudes of X′, X″ and X‴
//! of the whole path these are bounds wherever on the path the part stands, so the ramp is proven without walking it. Its speed is
//! ω₁(3u² − 2u³) over u = t/T, which one quintic over time holds exactly; T is the shortest that keeps all bounds.

use super::{AxisLimits, InsertPath, InsertPathError, InsertPathKey, SpeedBound, SpindleSpeed};
use crate::machine::description::MotionLimits;
use crate::math::hermite::{HermiteError, HermiteSpline, Knot};
use alloc::vec;
use alloc::vec::Vec;

/// Motion of C along a path.
#[derive(Debug, Clone, PartialEq)]
pub struct SpindleLaw {
    /// Angle since the path begins over time (rad over s), from rest to rest; it ends where the path does.
    pub law: HermiteSpline,
    /// Speed in between (rad/s); of a varied one the slowest.
    pub rad_s: f64,
    /// Slowest and fastest in between (rad/s).
    pub range_rad_s: (f64, f64),
    /// Time in which it runs up, and in which it comes to rest (s); where they differ the longer one.
    pub ramp_s: f64,
    /// Bounds of the speed with their shares of the path; for a constant speed the bound of the fastest.
    pub bounds: Vec<BoundShare>,
    /// The fastest constant speed that the slides and C allow, and what holds it.
    pub fastest: SpindleSpeed,
}

/// Bound of the spindle speed, and its share of the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundShare {
    pub bound: SpeedBound,
    /// Share, 0 to 1.
    pub share: f64,
}

/// Share of the fastest speed that is turned at most: at all of it a slide at its jerk limit would leave nothing for the ramp.
const SHARE: f64 = 0.98;

/// Places of the ramp at which the bounds are looked at. They are smooth there, and are kept with a thousandth to spare.
const PLACES: u32 = 256;
const SPARE: f64 = 0.999;

/// Shortest and longest ramp (s).
const RAMP_S: (f64, f64) = (1e-4, 1e4);

/// Maximum number of speed reductions for a path that is shorter than its ramps.
const MAX_TRIES: u32 = 200;

impl InsertPath {
    /// The time law of C along this path, no faster than `spindle_rad_s` and 98 % of the fastest that the slides allow, within the limits
    /// of C (rad/s, rad/s², rad/s³).
    ///
    /// # Errors
    /// Limits that are not positive numbers, or so small that a ramp would take hours.
    pub fn spindle_law(
        &self,
        spindle_rad_s: f64,
        limits: &AxisLimits,
        c: MotionLimits,
    ) -> Result<SpindleLaw, InsertPathError> {
        for (what, value) in [
            (InsertPathKey::SpindleSpeed, spindle_rad_s),
            (InsertPathKey::CVelocity, c.velocity),
            (InsertPathKey::CAcceleration, c.acceleration),
            (InsertPathKey::CJerk, c.jerk),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(InsertPathError::BadNumber { what, value, allowed: "above 0 and finite" });
            }
        }
        let rates = self.rates();
        let fastest =
            self.fastest_at(&rates, &AxisLimits { spindle_rad_s: limits.spindle_rad_s.min(c.velocity), ..*limits })?;
        let mut rad_s = spindle_rad_s.min(SHARE * fastest.rad_s);
        let slides = [rates.x, rates.z]
            .map(|rates| [rates.velocity, rates.acceleration, rates.jerk].map(|maximum| maximum.value));
        let way = self.x().end() - self.x().start();
        for _ in 0..MAX_TRIES {
            let Some(ramp_s) = ramp_s(rad_s, &slides, limits, &c) else {
                let (what, value) = (InsertPathKey::RunUpTime, f64::INFINITY);
                return Err(InsertPathError::BadNumber {
                    what,
                    value,
                    allowed: "up to 1e4 s: limits are too small for the path",
                });
            };
            // Either ramp covers half of what its time would at full speed.
            let plateau_s = way / rad_s - ramp_s;
            if plateau_s >= 0.0 {
                let ramp = 0.5 * rad_s * ramp_s;
                let knot = |at: f64, value: f64, first: f64| Knot { at, value, first, second: 0.0 };
                let mut knots = vec![knot(0.0, 0.0, 0.0), knot(ramp_s, ramp, rad_s)];
                if plateau_s > 1e-6 {
                    knots.push(knot(ramp_s + plateau_s, way - ramp, rad_s));
                } else if let Some(knot) = knots.last_mut() {
                    knot.value = 0.5 * way;
                }
                knots.push(knot(2.0 * ramp_s + plateau_s, way, 0.0));
                let bad = |_: HermiteError| InsertPathError::BadNumber {
                    what: InsertPathKey::SpindleTime,
                    value: ramp_s,
                    allowed: "finite",
                };
                let bounds = vec![BoundShare { bound: fastest.bound, share: 1.0 }];
                return Ok(SpindleLaw {
                    law: HermiteSpline::new(knots).map_err(bad)?,
                    rad_s,
                    range_rad_s: (rad_s, rad_s),
                    ramp_s,
                    bounds,
                    fastest,
                });
            }
            rad_s *= 0.9;
        }
        let (what, allowed) = (InsertPathKey::Length, "long enough to run up and stop on");
        Err(InsertPathError::BadNumber { what, value: way, allowed })
    }
}

/// The shortest ramp to a speed (s) that keeps the limits of C and of both slides, whose derivatives over the turned angle have these
/// largest magnitudes; `None` where hours would not do.
pub(super) fn ramp_s(rad_s: f64, slides: &[[f64; 3]; 2], limits: &AxisLimits, c: &MotionLimits) -> Option<f64> {
    let keeps = |ramp_s: f64| {
        let slides = slides.iter().zip([&limits.x, &limits.z]);
        keeps(rad_s, ramp_s, c)
            && slides.into_iter().all(|(maximum, limits)| slide_keeps(maximum, limits, rad_s, ramp_s))
    };
    let (mut low, mut high) = RAMP_S;
    if !keeps(high) {
        return None;
    }
    while high > 1.001 * low {
        let middle = libm::sqrt(low * high);
        if keeps(middle) { high = middle } else { low = middle }
    }
    Some(high)
}

/// Returns whether C keeps its limits: the acceleration is largest midway, the jerk at both ends.
fn keeps(rad_s: f64, ramp_s: f64, c: &MotionLimits) -> bool {
    1.5 * rad_s / ramp_s <= SPARE * c.acceleration && 6.0 * rad_s / (ramp_s * ramp_s) <= SPARE * c.jerk
}

/// Returns whether a slide keeps its limits over the whole ramp.
fn slide_keeps(&[v, a, j]: &[f64; 3], limits: &MotionLimits, rad_s: f64, ramp_s: f64) -> bool {
    (0..=PLACES).all(|place| {
        let u = f64::from(place) / f64::from(PLACES);
        let speed = rad_s * u * u * (3.0 - 2.0 * u);
        let rise = 6.0 * rad_s * u * (1.0 - u) / ramp_s;
        let bend = (6.0 * rad_s * (1.0 - 2.0 * u) / (ramp_s * ramp_s)).abs();
        a * speed * speed + v * rise <= SPARE * limits.acceleration
            && j * speed * speed * speed + 3.0 * a * speed * rise + v * bend <= SPARE * limits.jerk
    })
}
