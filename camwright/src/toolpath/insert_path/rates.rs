// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Demand of a path on the axes, and the fastest speed of the spindle.

use super::{InsertPath, InsertPathError, InsertPathKey, ZLaw};
use crate::machine::description::MotionLimits;
use crate::math::differences::{Extreme, largest_derivatives};
use crate::math::uniform_hermite::UniformHermite;
use crate::math::units::deg_from_rad;
use core::fmt;

/// Largest magnitudes of an axis over the turned angle, and where (at, rad): mm/rad, mm/rad², mm/rad³.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rates {
    pub velocity: Extreme,
    pub acceleration: Extreme,
    pub jerk: Extreme,
}

/// Rates of both slides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathRates {
    pub x: Rates,
    pub z: Rates,
}

/// Limits of the axes (mm/s, mm/s², mm/s³; the spindle rad/s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisLimits {
    pub x: MotionLimits,
    pub z: MotionLimits,
    /// Fastest speed of the spindle (rad/s).
    pub spindle_rad_s: f64,
}

/// Bound that limits the speed of the spindle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpeedBound {
    Spindle,
    /// Velocity of a slide.
    Velocity(&'static str),
    /// Acceleration of a slide.
    Acceleration(&'static str),
    /// Jerk of a slide.
    Jerk(&'static str),
}

impl fmt::Display for SpeedBound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Spindle => write!(f, "the limit of the spindle"),
            Self::Velocity(axis) => write!(f, "the velocity of {axis}"),
            Self::Acceleration(axis) => write!(f, "the acceleration of {axis}"),
            Self::Jerk(axis) => write!(f, "the jerk of {axis}"),
        }
    }
}

/// A constant speed of the spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpindleSpeed {
    /// Speed (rad/s).
    pub rad_s: f64,
    pub bound: SpeedBound,
    /// Turned angle at which that is reached (rad).
    pub at_rad: f64,
}

/// Motion of the slides at a speed of the spindle: mm/s, mm/s², mm/s³ and the angle (rad).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathUse {
    pub x: Rates,
    pub z: Rates,
}

/// The forward check looks at so many places from one knot to the next.
const PARTS: usize = 8;
const FINER: f64 = 8.0;

/// Share by which differences may exceed a limit: their own rounding, in addition to that of the positions.
const ROUNDING: f64 = 1e-6;

impl Rates {
    fn from_spline(spline: &UniformHermite) -> Self {
        let mut rates = Self::default();
        for left in 0..spline.knots().len() - 1 {
            let [velocity, acceleration, jerk] = spline.bounds(left);
            let at = spline.at(left);
            rates.velocity.add(velocity, at);
            rates.acceleration.add(acceleration, at);
            rates.jerk.add(jerk, at);
        }
        rates
    }

    fn scaled(self, speed: f64) -> Self {
        let times = |extreme: Extreme, factor: f64| Extreme { value: extreme.value * factor, ..extreme };
        Self {
            velocity: times(self.velocity, speed),
            acceleration: times(self.acceleration, speed * speed),
            jerk: times(self.jerk, speed * speed * speed),
        }
    }
}

impl InsertPath {
    /// Magnitudes over the turned angle that both slides stay below, by the hull of every piece: they are reached but for a little.
    #[must_use]
    pub fn rates(&self) -> PathRates {
        let z = match self.z() {
            ZLaw::Straight { per_rad, .. } => {
                let velocity = Extreme { value: per_rad.abs(), at: self.x().start() };
                Rates { velocity, ..Rates::default() }
            }
            ZLaw::Spline(spline) => Rates::from_spline(spline),
        };
        PathRates { x: Rates::from_spline(self.x()), z }
    }

    /// The fastest constant speed of the spindle at which all limits are kept: velocity grows with it, acceleration with its square, jerk
    /// with its cube.
    ///
    /// # Errors
    /// Limits that are not positive numbers; a forward check that finds a limit exceeded.
    pub fn fastest_spindle(&self, limits: &AxisLimits) -> Result<SpindleSpeed, InsertPathError> {
        self.fastest_at(&self.rates(), limits)
    }

    /// The fastest constant speed, for the magnitudes that [`Self::rates`] says.
    pub(super) fn fastest_at(&self, rates: &PathRates, limits: &AxisLimits) -> Result<SpindleSpeed, InsertPathError> {
        if !(limits.spindle_rad_s > 0.0 && limits.spindle_rad_s.is_finite()) {
            let (what, value) = (InsertPathKey::MaxSpindleSpeed, limits.spindle_rad_s);
            return Err(InsertPathError::BadNumber { what, value, allowed: "above 0 and finite" });
        }
        let mut best =
            SpindleSpeed { rad_s: limits.spindle_rad_s, bound: SpeedBound::Spindle, at_rad: self.x().start() };
        for (axis, rates, limits) in [("x_axis", rates.x, limits.x), ("z_axis", rates.z, limits.z)] {
            for (what, value) in [
                (InsertPathKey::Velocity, limits.velocity),
                (InsertPathKey::Acceleration, limits.acceleration),
                (InsertPathKey::Jerk, limits.jerk),
            ] {
                if !(value > 0.0 && value.is_finite()) {
                    return Err(InsertPathError::BadNumber { what, value, allowed: "above 0 and finite" });
                }
            }
            for (extreme, rad_s, bound) in [
                (rates.velocity, limits.velocity / rates.velocity.value, SpeedBound::Velocity(axis)),
                (
                    rates.acceleration,
                    libm::sqrt(limits.acceleration / rates.acceleration.value),
                    SpeedBound::Acceleration(axis),
                ),
                (rates.jerk, libm::cbrt(limits.jerk / rates.jerk.value), SpeedBound::Jerk(axis)),
            ] {
                if rad_s < best.rad_s {
                    best = SpindleSpeed { rad_s, bound, at_rad: extreme.at };
                }
            }
        }
        self.keeps(best.rad_s, limits)?;
        Ok(best)
    }

    /// Motion of the slides at a constant speed of the spindle (rad/s), by the hulls of [`Self::rates`].
    #[must_use]
    pub fn at_speed(&self, spindle_rad_s: f64) -> PathUse {
        let rates = self.rates();
        PathUse { x: rates.x.scaled(spindle_rad_s), z: rates.z.scaled(spindle_rad_s) }
    }

    /// Walks the whole path at a speed of the spindle (rad/s) on a grid eight times finer than its knots and differences positions.
    ///
    /// # Errors
    /// A speed that is not a positive number; the first limit that is exceeded, with value, bound and place.
    pub fn keeps(&self, spindle_rad_s: f64, limits: &AxisLimits) -> Result<PathUse, InsertPathError> {
        if !(spindle_rad_s > 0.0 && spindle_rad_s <= limits.spindle_rad_s) {
            let (what, allowed) = (InsertPathKey::SpindleSpeed, "above 0 and within the spindle's limit");
            return Err(InsertPathError::BadNumber { what, value: spindle_rad_s, allowed });
        }
        let scale = self.x_range_mm().1.abs().max(1.0);
        let x = walked(self.x());
        let z = match self.z() {
            ZLaw::Straight { per_rad, .. } => {
                Rates { velocity: Extreme { value: per_rad.abs(), at: self.x().start() }, ..Rates::default() }
            }
            ZLaw::Spline(spline) => walked(spline),
        };
        let used = PathUse { x: x.scaled(spindle_rad_s), z: z.scaled(spindle_rad_s) };
        let dt = self.x().step() / FINER / spindle_rad_s;
        for (axis, rates, limits) in [("x_axis", used.x, limits.x), ("z_axis", used.z, limits.z)] {
            for (power, quantity, extreme, bound) in [
                (1, "a velocity (mm/s) of", rates.velocity, limits.velocity),
                (2, "an acceleration (mm/s^2) of", rates.acceleration, limits.acceleration),
                (3, "a jerk (mm/s^3) of", rates.jerk, limits.jerk),
            ] {
                let noise = 8.0 * f64::EPSILON * scale / (0..power).fold(1.0, |product, _| product * dt);
                if extreme.value > bound * (1.0 + ROUNDING) + noise {
                    return Err(InsertPathError::ExceedsLimit {
                        axis,
                        quantity,
                        value: extreme.value,
                        bound,
                        turned_deg: deg_from_rad(extreme.at),
                        spindle_rad_s,
                    });
                }
            }
        }
        Ok(used)
    }
}

/// Differences of a spline over its whole length. Positions are given in knots, where they are exact: far along a path an angle is
/// rounded so much that third differences would be noise. Values come from the quintic's blending functions, not from its coefficients.
fn walked(spline: &UniformHermite) -> Rates {
    let (knots, h) = (spline.knots(), spline.step());
    let blends: [[f64; 5]; PARTS] = core::array::from_fn(|part| blend(part as f64 / FINER, h));
    let last = knots.len() - 1;
    let value = |place: f64| {
        #[allow(clippy::cast_possible_truncation, reason = "a place between the ends")]
        let index = (place * FINER) as usize;
        let (left, part) = (index / PARTS, index % PARTS);
        if left >= last {
            return knots[last][0];
        }
        let ([a, a1, a2], [b, b1, b2], w) = (knots[left], knots[left + 1], &blends[part]);
        a + (w[0] * (b - a) + w[1] * a1 + w[2] * a2 + w[3] * b1 + w[4] * b2)
    };
    let mut rates = largest_derivatives(value, 0.0, last as f64, 1.0 / FINER);
    let mut per = 1.0;
    for extreme in &mut rates {
        per /= h;
        *extreme = Extreme { value: extreme.value * per, at: spline.start() + extreme.at * h };
    }
    let [velocity, acceleration, jerk] = rates;
    Rates { velocity, acceleration, jerk }
}

/// Weights of the rise, and of slope and bend at the left and the right knot, at `u` in 0..1 of a step `h`.
fn blend(u: f64, h: f64) -> [f64; 5] {
    let v = 1.0 - u;
    let (u3, v3) = (u * u * u, v * v * v);
    let slope = |t: f64, cube: f64| t * cube * (1.0 + 3.0 * t);
    [
        u3 * (10.0 + u * (6.0 * u - 15.0)),
        h * slope(u, v3),
        h * h * 0.5 * u * u * v3,
        -h * slope(v, u3),
        h * h * 0.5 * v * v * u3,
    ]
}
