// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Units inside the core: mm, rad, s, N, unless a name says otherwise. Angles of people are degrees, positions of
//! encoders are counts; both are converted here and nowhere else.

use core::f64::consts::PI;

/// One turn (rad).
pub const TURN_RAD: f64 = 2.0 * PI;

#[must_use]
pub fn rad_from_deg(deg: f64) -> f64 {
    deg * (PI / 180.0)
}

#[must_use]
pub fn deg_from_rad(rad: f64) -> f64 {
    rad * (180.0 / PI)
}

#[must_use]
pub fn um_from_mm(mm: f64) -> f64 {
    mm * 1000.0
}

#[must_use]
pub fn mm_from_um(um: f64) -> f64 {
    um / 1000.0
}

/// Revolutions per minute to radians per second.
#[must_use]
pub fn rad_s_from_rpm(rpm: f64) -> f64 {
    rpm * (TURN_RAD / 60.0)
}

/// Radians per second to revolutions per minute.
#[must_use]
pub fn rpm_from_rad_s(rad_s: f64) -> f64 {
    rad_s * (60.0 / TURN_RAD)
}

/// Wraps an angle into `[0, 2 pi)`.
#[must_use]
pub fn wrap_turn(rad: f64) -> f64 {
    wrap_period(rad, TURN_RAD)
}

/// Wraps an angle into `[0, period)`; the period is positive.
#[must_use]
pub fn wrap_period(rad: f64, period_rad: f64) -> f64 {
    let wrapped = rad - period_rad * libm::floor(rad / period_rad);
    // A tiny negative angle rounds up to a whole period, which is the same place as zero.
    if wrapped >= period_rad { 0.0 } else { wrapped }
}

/// A value as a whole number of units of its last decimal place, as controls count it: 1.25 with three decimals is 1250. Half a unit goes
/// away from zero. `None` where it is no finite number, or has more than the 15 digits that a number of this size keeps.
#[must_use]
pub fn increments(value: f64, decimals: u32) -> Option<i64> {
    const MAX_COUNT: f64 = 1e15;
    let count = libm::round(value * per_unit(decimals));
    #[allow(clippy::cast_possible_truncation, reason = "a whole number of 15 digits")]
    let whole = count as i64;
    (libm::fabs(count) < MAX_COUNT).then_some(whole)
}

/// The value of so many units of the last decimal place: the number that its decimal text means.
#[must_use]
pub fn from_increments(count: i64, decimals: u32) -> f64 {
    count as f64 / per_unit(decimals)
}

fn per_unit(decimals: u32) -> f64 {
    10_u64.saturating_pow(decimals) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn increments_are_those_of_the_decimal_text() {
        for (value, decimals, count) in
            [(1.25, 3, 1250), (-0.000_05, 4, -1), (0.3, 4, 3000), (359.999_949, 4, 3_599_999), (-7.0, 0, -7)]
        {
            assert_eq!(increments(value, decimals), Some(count), "{value} with {decimals}");
        }
        assert_eq!(from_increments(3_000_001, 4).to_bits(), 300.0001_f64.to_bits());
        assert_eq!(from_increments(-123_456_789, 5).to_bits(), (-1_234.567_89_f64).to_bits());
    }

    #[test]
    fn what_cannot_be_counted_is_no_number_of_increments() {
        for (value, decimals) in [(f64::NAN, 4), (f64::INFINITY, 0), (1e15, 0), (-1e11, 4), (1.0, 40)] {
            assert_eq!(increments(value, decimals), None, "{value} with {decimals}");
        }
    }
}
