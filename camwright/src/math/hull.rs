// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lowest place of a quintic spline, proven by the hulls of its control points.
//!
//! Between two knots a quintic lies within the hull of its six Bernstein coefficients. Halving an interval brings the hull closer to the
//! curve by a factor of four, so a few halvings bound the lowest value, where samples could miss it.

use super::hermite::{HermiteSpline, Knot};

/// Gap between hull and curve at which halving ends, as a share of the spline's largest magnitude.
const ROUNDING: f64 = 1e-14;

/// Largest number of halvings: 2⁻⁴⁰ of an interval.
const MAX_HALVINGS: u32 = 40;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HullMinimum {
    pub at: f64,
    pub value: f64,
}

/// Returns the lowest place of a spline.
#[must_use]
pub fn lowest(spline: &HermiteSpline) -> HullMinimum {
    let knots = spline.knots();
    let first = HullMinimum { at: knots[0].at, value: knots[0].value };
    let of_knots = knots.iter().map(|knot| HullMinimum { at: knot.at, value: knot.value }).fold(first, lower);
    let size = knots.iter().map(|knot| knot.value.abs()).fold(0.0, f64::max);
    knots.windows(2).fold(of_knots, |best, pair| {
        below(coefficients(&pair[0], &pair[1]), (pair[0].at, pair[1].at), ROUNDING * size, MAX_HALVINGS, best)
    })
}

fn lower(a: HullMinimum, b: HullMinimum) -> HullMinimum {
    if b.value < a.value { b } else { a }
}

/// Bernstein coefficients of the quintic between two knots.
fn coefficients(left: &Knot, right: &Knot) -> [f64; 6] {
    let h = right.at - left.at;
    let first = left.value + 0.2 * h * left.first;
    let last = right.value - 0.2 * h * right.first;
    [
        left.value,
        first,
        2.0 * first - left.value + 0.05 * h * h * left.second,
        2.0 * last - right.value + 0.05 * h * h * right.second,
        last,
        right.value,
    ]
}

/// The lower of `best` and the lowest place of a quintic over an interval.
fn below(curve: [f64; 6], (from, to): (f64, f64), rounding: f64, halvings: u32, best: HullMinimum) -> HullMinimum {
    let hull = curve.iter().copied().fold(f64::INFINITY, f64::min);
    if hull >= best.value - rounding {
        return best;
    }
    let (left, right) = halves(curve);
    let middle = 0.5 * (from + to);
    let best = lower(best, HullMinimum { at: middle, value: right[0] });
    if halvings == 0 {
        return best;
    }
    let best = below(left, (from, middle), rounding, halvings - 1, best);
    below(right, (middle, to), rounding, halvings - 1, best)
}

fn halves(curve: [f64; 6]) -> ([f64; 6], [f64; 6]) {
    let (mut row, mut left, mut right) = (curve, [0.0; 6], [0.0; 6]);
    for level in 0..6 {
        left[level] = row[0];
        right[5 - level] = row[5 - level];
        for index in 0..5 - level {
            row[index] = 0.5 * (row[index] + row[index + 1]);
        }
    }
    (left, right)
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    fn knot(at: f64, value: f64, first: f64, second: f64) -> Knot {
        Knot { at, value, first, second }
    }

    #[test]
    fn a_monotone_step_is_lowest_at_its_end() {
        let step = HermiteSpline::new(Vec::from([knot(0.0, 3.0, 0.0, 0.0), knot(2.0, 1.0, 0.0, 0.0)])).expect("a step");
        assert_eq!(lowest(&step), HullMinimum { at: 2.0, value: 1.0 });
    }

    /// A steep end over a long interval overshoots far below both knots.
    #[test]
    fn an_overshoot_between_two_knots_is_found() {
        for (slope, curvature) in [(-0.4, 0.0), (0.3, 4.0), (1.0, -3.0), (0.0, 5.0)] {
            let knots = [knot(0.0, 0.03, 0.0, 0.0), knot(3.8, 0.0, slope, curvature), knot(4.0, 0.2, 0.0, 0.0)];
            let spline = HermiteSpline::new(Vec::from(knots)).expect("a spline");
            let sampled = (0..=100_000).map(|i| spline.sample(f64::from(i) * 4e-5).value).fold(f64::INFINITY, f64::min);
            let found = lowest(&spline);
            assert!((found.value - sampled).abs() < 1e-8, "{found:?} {sampled}");
            assert!((spline.sample(found.at).value - found.value).abs() < 1e-12, "{found:?}");
        }
    }
}
