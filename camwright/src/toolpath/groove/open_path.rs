// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Travels of a mill along a groove with two ends: quintic Hermite splines over the azimuth, constant beyond the ends.
//!
//! The roller's centre is known with three derivatives, so that value, velocity and acceleration of every place beside it are known too. The
//! acceleration of a path beside the pitch curve jumps where the jerk of the lift does; a knot stands on either side of such a place.

use super::GrooveError;
use super::course::RollerCentre;
use crate::math::hermite::{HermiteSpline, Knot, Sample};
use crate::math::units::TURN_RAD;
use crate::toolpath::wheel_path::{ALLOWED_ERROR_MM, ToolPathError, WANTED_ERROR_MM};
use alloc::vec::Vec;

/// Fewest and most knots of a turn, doubling.
const KNOTS_PER_TURN: (usize, usize) = (360, 23_040);

/// Distance of the knots on either side of a place where the acceleration may jump (rad).
const BESIDE_RAD: f64 = 1e-6;

/// An even knot this near to one of those is left out (rad).
const APART_RAD: f64 = 1e-5;

/// γ at a distance x from the part's axis, with its derivatives: atan2(a, b), a = z′, b = x + y′.
pub(super) fn slope(centre: &RollerCentre, x: f64) -> Sample {
    let (a, a1, a2) = (centre.z.first, centre.z.second, centre.z.third);
    let (b, b1, b2) = (x + centre.y.first, centre.y.second, centre.y.third);
    let square = a * a + b * b;
    let turned = a1 * b - a * b1;
    Sample {
        value: libm::atan2(a, b),
        first: turned / square,
        second: (a2 * b - a * b2) / square - 2.0 * turned * (a * a1 + b * b1) / (square * square),
        third: 0.0,
    }
}

/// The mean of two.
pub(super) fn half_way([from, to]: [Sample; 2]) -> Sample {
    Sample {
        value: 0.5 * (from.value + to.value),
        first: 0.5 * (from.first + to.first),
        second: 0.5 * (from.second + to.second),
        third: 0.0,
    }
}

pub(super) fn sine(angle: Sample) -> Sample {
    let (sin, cos) = (libm::sin(angle.value), libm::cos(angle.value));
    Sample {
        value: sin,
        first: cos * angle.first,
        second: cos * angle.second - sin * angle.first * angle.first,
        third: 0.0,
    }
}

pub(super) fn cosine(angle: Sample) -> Sample {
    let (sin, cos) = (libm::sin(angle.value), libm::cos(angle.value));
    Sample {
        value: cos,
        first: -sin * angle.first,
        second: -sin * angle.second - cos * angle.first * angle.first,
        third: 0.0,
    }
}

/// A sum, the second term times a factor.
pub(super) fn plus(to: Sample, factor: f64, what: Sample) -> Sample {
    Sample {
        value: to.value + factor * what.value,
        first: to.first + factor * what.first,
        second: to.second + factor * what.second,
        third: 0.0,
    }
}

/// The angle itself over the angle.
pub(super) fn line(angle_rad: f64) -> Sample {
    Sample { value: angle_rad, first: 1.0, second: 0.0, third: 0.0 }
}

/// A place over the azimuth at which it is computed.
pub(super) fn knot(azimuth_rad: f64, place: Sample) -> Knot {
    Knot { at: azimuth_rad, value: place.value, first: place.first, second: place.second }
}

/// A place over another azimuth, both over one parameter.
pub(super) fn knot_over(azimuth: Sample, place: Sample) -> Knot {
    let rate = azimuth.first;
    Knot {
        at: azimuth.value,
        value: place.value,
        first: place.first / rate,
        second: (place.second * rate - place.first * azimuth.second) / (rate * rate * rate),
    }
}

/// The spline through the places of a parameter from 0 to a span, with as many knots as make it right between them.
///
/// # Errors
/// Places that no number of knots resolves.
pub(super) fn through(
    span_rad: f64,
    breaks_rad: &[f64],
    place: &dyn Fn(f64) -> Knot,
) -> Result<HermiteSpline, GrooveError> {
    let turns = libm::ceil(span_rad / TURN_RAD - 1e-9).max(1.0);
    let mut knots_of_turn = KNOTS_PER_TURN.0;
    loop {
        let at = parameters(span_rad, knots_of_turn as f64 * turns, breaks_rad);
        let knots = at.len();
        let unresolved = |error_mm| ToolPathError::Unresolved { knots, error_mm, bound_mm: ALLOWED_ERROR_MM };
        let spline = HermiteSpline::new(at.iter().map(|at| place(*at)).collect()).map_err(|_| unresolved(f64::NAN))?;
        let error_mm = (at.windows(2))
            .map(|pair| place(0.5 * (pair[0] + pair[1])))
            .map(|between| (spline.sample(between.at).value - between.value).abs())
            .fold(0.0, |a: f64, b| if b.is_nan() { b } else { a.max(b) });
        let last = 2 * knots_of_turn > KNOTS_PER_TURN.1;
        if error_mm <= WANTED_ERROR_MM || (last && error_mm <= ALLOWED_ERROR_MM) {
            return Ok(spline);
        }
        if last || error_mm.is_nan() {
            return Err(unresolved(error_mm).into());
        }
        knots_of_turn *= 2;
    }
}

/// Even steps over the span, with two places around every break instead of the steps nearest to it.
fn parameters(span_rad: f64, steps: f64, breaks_rad: &[f64]) -> Vec<f64> {
    let mut breaks: Vec<f64> =
        breaks_rad.iter().copied().filter(|at| *at > APART_RAD && *at < span_rad - APART_RAD).collect();
    breaks.sort_by(f64::total_cmp);
    breaks.dedup_by(|a, b| (*a - *b).abs() < APART_RAD);
    #[allow(clippy::cast_possible_truncation, reason = "some turns of at most 23 040 steps")]
    let count = steps as u32;
    let mut at = Vec::new();
    let mut next = 0;
    for step in 0..=count {
        let even = if step == count { span_rad } else { span_rad * f64::from(step) / steps };
        while breaks.get(next).is_some_and(|place| *place <= even + APART_RAD) {
            at.extend([breaks[next] - BESIDE_RAD, breaks[next] + BESIDE_RAD]);
            next += 1;
        }
        if at.last().is_none_or(|last| even > last + APART_RAD - BESIDE_RAD) {
            at.push(even);
        }
    }
    at
}
