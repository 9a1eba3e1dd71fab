// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The smallest value of a function over one turn: a dense grid, then golden section around the best places.

use crate::math::units::{TURN_RAD, wrap_period};
use alloc::vec::Vec;

/// A value and the angle at which it occurs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extremum {
    /// Angle (rad), in 0..2π.
    pub angle_rad: f64,
    /// Value of the function there.
    pub value: f64,
}

/// Number of local minima of the grid that are refined. More than one, because the grid may rank two nearly equal ones
/// the wrong way; more than a dozen never changed a result on rounded tables, which have hundreds.
const REFINED: usize = 12;

/// Distance (rad) from a break at which the function is looked at on either side.
const BESIDE_RAD: f64 = 1e-9;

/// Smallest value of `function` over one turn, looked for on `count` equal steps, beside every break (where the
/// function may jump), and between the steps around the lowest places.
///
/// `count` must be at least 3 for a grid to exist; fewer are taken as 3.
pub fn smallest_over_turn(count: usize, breaks: &[f64], function: impl Fn(f64) -> f64) -> Extremum {
    smallest_over_period(TURN_RAD, count, breaks, function)
}

/// The same over a period of the function.
pub fn smallest_over_period(period_rad: f64, count: usize, breaks: &[f64], function: impl Fn(f64) -> f64) -> Extremum {
    let count = count.max(3);
    let at = |i: usize| i as f64 * period_rad / count as f64;
    let values: Vec<f64> = (0..count).map(|i| function(at(i))).collect();
    let mut best = Extremum { angle_rad: 0.0, value: values[0] };
    let mut consider = |angle_rad: f64, value: f64| {
        // A value that is not a number is worse than any: it must not hide.
        if value < best.value || (value.is_nan() && !best.value.is_nan()) {
            best = Extremum { angle_rad: wrap_period(angle_rad, period_rad), value };
        }
    };
    let mut local: Vec<usize> = Vec::new();
    for i in 0..count {
        consider(at(i), values[i]);
        if values[i] <= values[(i + count - 1) % count] && values[i] <= values[(i + 1) % count] {
            local.push(i);
        }
    }
    for &place in breaks {
        for beside in [place - BESIDE_RAD, place + BESIDE_RAD] {
            consider(beside, function(beside));
        }
    }
    local.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let step = at(1);
    for &i in local.iter().take(REFINED) {
        let (angle, value) = golden_section(at(i) - step, at(i) + step, &function);
        consider(angle, value);
    }
    best
}

/// Golden section on an interval that holds one minimum; 40 steps shrink it by 4e-9.
pub(crate) fn golden_section(left: f64, right: f64, function: &impl Fn(f64) -> f64) -> (f64, f64) {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let (mut a, mut b) = (left, right);
    let (mut x1, mut x2) = (b - RATIO * (b - a), a + RATIO * (b - a));
    let (mut f1, mut f2) = (function(x1), function(x2));
    for _ in 0..40 {
        if f1 <= f2 {
            b = x2;
            (x2, f2) = (x1, f1);
            x1 = b - RATIO * (b - a);
            f1 = function(x1);
        } else {
            a = x1;
            (x1, f1) = (x2, f2);
            x2 = a + RATIO * (b - a);
            f2 = function(x2);
        }
    }
    if f1 <= f2 { (x1, f1) } else { (x2, f2) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minimum_between_grid_points_is_found() {
        let found = smallest_over_turn(36, &[], |x| -libm::cos(x - 1.234_567));
        assert!((found.angle_rad - 1.234_567).abs() < 1e-6 && (found.value + 1.0).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn one_sided_minimum_at_a_break_is_found() {
        let found = smallest_over_turn(36, &[2.0], |x| if x < 2.0 { -x } else { 0.0 });
        assert!((found.value + 2.0).abs() < 1e-8, "{found:?}");
    }

    #[test]
    fn what_is_not_a_number_does_not_hide() {
        let found = smallest_over_turn(100, &[], |x| if (2.0..3.0).contains(&x) { f64::NAN } else { x });
        assert!(found.value.is_nan());
    }
}
