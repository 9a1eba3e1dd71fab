// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A stop on the path: path time slows down, the path stays.

use crate::machine::description::MotionLimits;

/// Rate of path time during a stop on the path, from 1 to 0: S(u) = 10u³ − 15u⁴ + 6u⁵, the quintic smoothstep, u from 0
/// to 1 over the change.
#[must_use]
pub fn rate_step(u: f64) -> f64 {
    u * u * u * (10.0 + u * (-15.0 + 6.0 * u))
}

/// First derivative of [`rate_step`].
#[must_use]
pub fn rate_step_slope(u: f64) -> f64 {
    30.0 * u * u * (1.0 + u * (-2.0 + u))
}

/// Second derivative of [`rate_step`].
#[must_use]
pub fn rate_step_bend(u: f64) -> f64 {
    60.0 * u * (1.0 - u) * (1.0 - 2.0 * u)
}

/// Integral of [`rate_step`] from 0.
#[must_use]
pub fn rate_step_area(u: f64) -> f64 {
    u * u * u * u * (2.5 + u * (-3.0 + u))
}

/// Length (s) of a stop on the path that keeps an axis within `limits` wherever it begins, for an axis whose motion on
/// the path reaches at most `peaks`; `None` if the peaks leave no room for any stop.
///
/// With path time passing at rate r and primes for derivatives by path time: v = r·p′, a = r²·p″ + ṙ·p′ and
/// j = r³·p‴ + 3·r·ṙ·p″ + r̈·p′. The peaks are taken together, although they seldom are, so the result is safe for a
/// stop that begins anywhere, and for any smaller change of the rate over the same time.
#[must_use]
pub fn path_stop_s(peaks: &MotionLimits, limits: &MotionLimits) -> Option<f64> {
    const GRID: u32 = 64;
    let keeps = |length: f64| {
        (0..=GRID).all(|i| {
            let u = f64::from(i) / f64::from(GRID);
            let rate = 1.0 - rate_step(u);
            let slope = rate_step_slope(u) / length;
            let bend = libm::fabs(rate_step_bend(u)) / (length * length);
            rate * rate * peaks.acceleration + slope * peaks.velocity <= limits.acceleration
                && rate * rate * rate * peaks.jerk + 3.0 * rate * slope * peaks.acceleration + bend * peaks.velocity
                    <= limits.jerk
        })
    };
    // A path that needs longer than a minute to stop in has no room in its limits.
    let (mut short, mut long) = (1e-4, 60.0);
    if peaks.velocity > limits.velocity || !keeps(long) {
        return None;
    }
    for _ in 0..50 {
        let middle = 0.5 * (short + long);
        if keeps(middle) {
            long = middle;
        } else {
            short = middle;
        }
    }
    // The grid may miss a maximum by a thousandth.
    Some(long * 1.001)
}
