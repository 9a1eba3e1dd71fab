// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A quintic Hermite spline evaluated with twice the digits, one abscissa after the other: for checks that difference positions.

use super::hermite::{HermiteSpline, Knot};
use super::twofold::Twofold;

/// A spline that is evaluated at abscissae near each other: the piece between two knots is kept as long as they stay in it.
#[derive(Debug, Clone)]
pub(crate) struct ExactHermite<'a> {
    knots: &'a [Knot],
    piece: Option<QuinticPiece>,
}

/// The quintic between two knots, in powers of the distance from the left one.
#[derive(Debug, Clone, Copy)]
struct QuinticPiece {
    left: f64,
    right: f64,
    value: f64,
    first: f64,
    half_second: f64,
    cubic: f64,
    quartic: f64,
    quintic: f64,
}

impl QuinticPiece {
    /// Same as [`super::hermite::quintic`], but the right knot's deviation from the Taylor parabola keeps all its digits: the piece ends on
    /// the right knot even for large values.
    fn between(left: &Knot, right: &Knot) -> Self {
        let width = Twofold::sum(right.at, -left.at);
        let h = width.value();
        let rise = Twofold::sum(right.value, -left.value);
        let slope = Twofold::from(left.first).plus(width.times(Twofold::from(0.5 * left.second)));
        let value = rise.minus(width.times(slope));
        let first = right.first - (left.first + h * left.second);
        let second = right.second - left.second;
        Self {
            left: left.at,
            right: right.at,
            value: left.value,
            first: left.first,
            half_second: 0.5 * left.second,
            cubic: (10.0 * value - 4.0 * h * first + 0.5 * h * h * second) / (h * h * h),
            quartic: (-15.0 * value + 7.0 * h * first - h * h * second) / (h * h * h * h),
            quintic: (6.0 * value - 3.0 * h * first + 0.5 * h * h * second) / (h * h * h * h * h),
        }
    }

    fn holds(&self, at: f64) -> bool {
        at >= self.left && at < self.right
    }

    /// The tangent with all digits. What the piece bends away from it is at most as large as the piece, not as the value, so that one float
    /// has its digits.
    fn at(&self, at: Twofold) -> Twofold {
        let u = at.plus_float(-self.left);
        let s = u.value();
        let bent = s * s * (self.half_second + s * (self.cubic + s * (self.quartic + s * self.quintic)));
        u.times(Twofold::from(self.first)).plus_float(bent).plus_float(self.value)
    }
}

impl<'a> ExactHermite<'a> {
    pub(crate) fn new(spline: &'a HermiteSpline) -> Self {
        Self { knots: spline.knots(), piece: None }
    }

    /// The value; before the first and after the last knot that of the knot.
    pub(crate) fn at(&mut self, at: Twofold) -> Twofold {
        let rounded = at.value();
        if let Some(piece) = self.piece.filter(|piece| piece.holds(rounded)) {
            return piece.at(at);
        }
        let right = self.knots.partition_point(|knot| knot.at <= rounded);
        match (right.checked_sub(1).and_then(|left| self.knots.get(left)), self.knots.get(right)) {
            (Some(left), Some(right)) => {
                let piece = QuinticPiece::between(left, right);
                self.piece = Some(piece);
                piece.at(at)
            }
            (Some(end), None) | (None, Some(end)) => Twofold::from(end.value),
            (None, None) => Twofold::from(f64::NAN),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::differences::largest_exact_derivatives;
    use alloc::vec;

    /// C at 20 rad/s after 2,000 turns, on knots a millisecond apart: the same as the float, and without its steps.
    #[test]
    fn a_law_far_from_its_start_is_the_same_and_smooth() {
        let knot = |i: f64| Knot { at: 600.0 + 1e-3 * i, value: 12_000.0 + 0.02 * i, first: 20.0, second: 0.0 };
        let spline = HermiteSpline::new(vec![knot(0.0), knot(1.0), knot(2.0)]).expect("knots that increase");
        let mut exact = ExactHermite::new(&spline);
        let mut before = None;
        for k in 0..400_u32 {
            let at = Twofold::from(600.0).plus(Twofold::product(f64::from(k), 5e-6));
            let here = exact.at(at);
            assert!((here.value() - spline.sample(at.value()).value).abs() < 1e-11, "{k}");
            if let Some(before) = before {
                let step: f64 = here.minus(before);
                // The knots themselves are rounded to 2e-12, which is spread over a piece.
                assert!((step - 1e-4).abs() < 1e-13, "{k}: {step}");
            }
            before = Some(here);
        }
    }

    /// A turn that begins with a jerk of 3e4 rad/s³ after 2,000 turns: differences over 10 µs show it within a thousandth.
    #[test]
    fn a_bent_piece_far_from_its_start_has_the_jerk_of_its_law() {
        let knot = |t: f64| Knot {
            at: 600.0 + t,
            value: 12_000.0 + t * (20.0 + t * (150.0 + 5000.0 * t)),
            first: 20.0 + t * (300.0 + 15e3 * t),
            second: 300.0 + 30e3 * t,
        };
        let spline = HermiteSpline::new(vec![knot(0.0), knot(0.05), knot(0.1)]).expect("knots that increase");
        let mut exact = ExactHermite::new(&spline);
        let from = Twofold::from(600.002);
        let found = largest_exact_derivatives(|at| exact.at(at), from, from.plus_float(0.09), 1e-5);
        assert!((found[2].value / 30e3 - 1.0).abs() < 1e-3, "{found:?}");
        assert!((found[1].value - (300.0 + 30e3 * 0.092)).abs() < 1.0, "{found:?}");
    }

    #[test]
    fn beyond_its_ends_a_spline_stands() {
        let knot = |at: f64, value: f64| Knot { at, value, first: 0.0, second: 0.0 };
        let spline = HermiteSpline::new(vec![knot(0.0, 1.0), knot(1.0, 2.0)]).expect("knots that increase");
        let mut exact = ExactHermite::new(&spline);
        for (at, value) in [(-1.0, 1.0), (0.0, 1.0), (0.5, 1.5), (1.0, 2.0), (7.0, 2.0)] {
            assert_eq!(exact.at(Twofold::from(at)).value().to_bits(), f64::to_bits(value), "{at}");
        }
    }
}
