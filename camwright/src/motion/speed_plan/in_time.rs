// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Limit utilisation of a turn by the quintics in time that drive the axes.
//!
//! A quintic has the speed and acceleration of the plan at both of its knots and differs a little in between. The peaks of the plan over
//! the angle are proven, however rough path and bound are (see [`super::peaks`]). The difference depends on C alone and is smooth within
//! an interval, so a few points give its maximum. A use in time is at most the peak over the angle plus that of the difference.

use super::peaks::{PROVEN, Parabola, PeakSearch, Peaks};
use super::square_speed::{SquareSpeed, to_f64};
use crate::math::hermite::Knot;
use alloc::vec::Vec;

/// Parts of an interval at whose ends quintic and plan are compared.
const PARTS: usize = 8;

/// Share by which a difference may be larger between two of these points than at all of them.
const BETWEEN: f64 = 0.1;

/// Largest use of each limit by the quintics in time between these knots, or an upper bound of it. `peaks` are those of the plan over the
/// angle.
///
/// An upper bound up to `PROVEN`, or up to what was found before, counts as the use: the turn is slowed down by the largest use that is
/// returned, so the true use, which is below its bound, ends below 1.
pub(super) fn uses_in_time(knots: &[Knot], plan: &SquareSpeed, search: &PeakSearch<'_>, peaks: &[Peaks]) -> Peaks {
    let weights: [Weights; PARTS + 1] = core::array::from_fn(|part| Weights::at(to_f64(part) / to_f64(PARTS)));
    let mut found = Peaks::default();
    for (i, (pair, peaks)) in knots.windows(2).zip(peaks).enumerate() {
        let quintic = Quintic::between(&pair[0], &pair[1]);
        let hull = search.hull_of_motion(i, quintic.hull());
        if !(is_low(hull.c_acceleration, &mut found.c_acceleration) & is_low(hull.c_jerk, &mut found.c_jerk)) {
            let [acceleration, jerk] = quintic.largest();
            found = found.larger(search.uses_of_c(acceleration, jerk));
        }
        if is_kept(&hull, &mut found) {
            continue;
        }
        let z = Parabola::from_interval(plan, i);
        let at: [(f64, Difference); PARTS + 1] = core::array::from_fn(|part| quintic.beside(&z, &weights[part]));
        let largest = at.iter().fold(Difference::default(), |largest, (_, each)| largest.larger(each));
        if is_kept(&search.beside_plan(i, peaks, &largest.times(1.0 + BETWEEN)), &mut found) {
            continue;
        }
        let margin = largest.times(BETWEEN);
        let parts: Vec<(f64, f64, Difference)> =
            at.windows(2).map(|pair| (pair[0].0, pair[1].0, pair[0].1.larger(&pair[1].1).plus(&margin))).collect();
        found = found.larger(search.beside_plan_in_parts(plan, i, &parts));
    }
    found
}

/// Returns whether an upper bound counts as the use, which it then joins.
fn is_low(upper: f64, found: &mut f64) -> bool {
    let is_low = upper <= PROVEN.max(*found);
    if is_low && upper > 1.0 {
        *found = found.max(upper);
    }
    is_low
}

/// The same for the bound and the limits of X.
fn is_kept(upper: &Peaks, found: &mut Peaks) -> bool {
    is_low(upper.bound, &mut found.bound)
        & is_low(upper.x_acceleration, &mut found.x_acceleration)
        & is_low(upper.x_jerk, &mut found.x_jerk)
}

/// Largest magnitudes of what a motion of C has beyond the plan at the same angle.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Difference {
    /// Share of the square of the speed, 0 where it is slower.
    pub(super) faster: f64,
    /// Square of the speed.
    pub(super) square: f64,
    pub(super) acceleration: f64,
    /// Cube of the speed.
    pub(super) cube: f64,
    /// Product of speed and acceleration.
    pub(super) product: f64,
    pub(super) jerk: f64,
}

impl Difference {
    fn with(self, other: &Self, with: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            faster: with(self.faster, other.faster),
            square: with(self.square, other.square),
            acceleration: with(self.acceleration, other.acceleration),
            cube: with(self.cube, other.cube),
            product: with(self.product, other.product),
            jerk: with(self.jerk, other.jerk),
        }
    }

    fn larger(self, other: &Self) -> Self {
        self.with(other, f64::max)
    }

    fn plus(self, other: &Self) -> Self {
        self.with(other, |a, b| a + b)
    }

    fn times(self, factor: f64) -> Self {
        self.with(&self, |a, _| factor * a)
    }
}

/// Weights of control points at a share of an interval, by degree.
struct Weights {
    quadratic: [f64; 3],
    cubic: [f64; 4],
    quartic: [f64; 5],
    quintic: [f64; 6],
}

impl Weights {
    fn at(u: f64) -> Self {
        let v = 1.0 - u;
        let (u2, v2) = (u * u, v * v);
        Self {
            quadratic: [v2, 2.0 * u * v, u2],
            cubic: [v2 * v, 3.0 * u * v2, 3.0 * u2 * v, u2 * u],
            quartic: [v2 * v2, 4.0 * u * v2 * v, 6.0 * u2 * v2, 4.0 * u2 * u * v, u2 * u2],
            quintic: [
                v2 * v2 * v,
                5.0 * u * v2 * v2,
                10.0 * u2 * v2 * v,
                10.0 * u2 * u * v2,
                5.0 * u2 * u2 * v,
                u2 * u2 * u,
            ],
        }
    }
}

fn dot<const N: usize>(weights: &[f64; N], points: &[f64; N]) -> f64 {
    weights.iter().zip(points).map(|(weight, point)| weight * point).sum()
}

fn largest_magnitude(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |largest, value| f64::max(largest, value.abs()))
}

/// C over time between two knots: control points of angle since the first knot, speed, acceleration and jerk.
struct Quintic {
    angle: [f64; 6],
    speed: [f64; 5],
    acceleration: [f64; 4],
    jerk: [f64; 3],
}

impl Quintic {
    fn between(left: &Knot, right: &Knot) -> Self {
        let h = right.at - left.at;
        let (v0, v1) = (left.first, left.first + 0.25 * h * left.second);
        let (v3, v4) = (right.first - 0.25 * h * right.second, right.first);
        let way = right.value - left.value;
        // The mean of the control points is the mean speed.
        let v = [v0, v1, 5.0 * way / h - (v0 + v1 + v3 + v4), v3, v4];
        let a: [f64; 4] = core::array::from_fn(|i| 4.0 / h * (v[i + 1] - v[i]));
        let j: [f64; 3] = core::array::from_fn(|i| 3.0 / h * (a[i + 1] - a[i]));
        let step = 0.2 * h;
        let (s1, s2, s4) = (step * v0, step * (v0 + v1), way - step * v4);
        let angle = [0.0, s1, s2, s4 - step * v3, s4, way];
        Self { angle, speed: v, acceleration: a, jerk: j }
    }

    /// Upper bounds of the magnitudes of speed, acceleration and jerk.
    fn hull(&self) -> [f64; 3] {
        [largest_magnitude(self.speed), largest_magnitude(self.acceleration), largest_magnitude(self.jerk)]
    }

    /// Largest magnitudes of acceleration and jerk: at the ends, or where their derivative is 0.
    fn largest(&self) -> [f64; 2] {
        let within = |u: &f64| *u > 0.0 && *u < 1.0;
        let [j0, j1, j2] = self.jerk;
        let (rise, bend) = (j1 - j0, j0 - 2.0 * j1 + j2);
        let jerk_at = |u: f64| j0 + u * (2.0 * rise + u * bend);
        let jerk = largest_magnitude([0.0, 1.0].into_iter().chain(Some(-rise / bend).filter(within)).map(jerk_at));
        let root = libm::sqrt((rise * rise - bend * j0).max(0.0));
        let half = if rise < 0.0 { root - rise } else { -root - rise };
        let zeros = [half / bend, j0 / half].into_iter().filter(within);
        let ends = [self.acceleration[0], self.acceleration[3]].into_iter();
        let acceleration = ends.chain(zeros.map(|u| dot(&Weights::at(u).cubic, &self.acceleration)));
        [largest_magnitude(acceleration), jerk]
    }

    /// The angle since the first knot where these weights belong, and the difference to the plan there.
    fn beside(&self, plan: &Parabola, weights: &Weights) -> (f64, Difference) {
        let along = dot(&weights.quintic, &self.angle);
        let (v, a) = (dot(&weights.quartic, &self.speed), dot(&weights.cubic, &self.acceleration));
        let z = plan.at(along);
        let (speed, acceleration) = (libm::sqrt(z), 0.5 * (plan.first + along * plan.second));
        let difference = Difference {
            faster: (v * v / z - 1.0).max(0.0),
            square: (v * v - z).abs(),
            acceleration: (a - acceleration).abs(),
            cube: (v * v * v - z * speed).abs(),
            product: (v * a - speed * acceleration).abs(),
            jerk: (dot(&weights.quadratic, &self.jerk) - 0.5 * speed * plan.second).abs(),
        };
        (along, difference)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hermite::quintic;

    const LEFT: Knot = Knot { at: 1.0, value: 0.3, first: 4.0, second: 90.0 };
    const RIGHT: Knot = Knot { at: 1.02, value: 0.402, first: 5.9, second: 30.0 };

    /// Control points give the quintic; its largest acceleration and jerk are those of many samples, and within the hull.
    #[test]
    fn control_points_are_those_of_the_quintic() {
        let curve = Quintic::between(&LEFT, &RIGHT);
        let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-9 * (1.0 + b.abs()), "{a} {b}");
        let mut sampled = [0.0_f64; 3];
        for i in 0..=1000 {
            let u = f64::from(i) / 1000.0;
            let (weights, wanted) = (Weights::at(u), quintic(&LEFT, &RIGHT, LEFT.at + u * (RIGHT.at - LEFT.at)));
            close(LEFT.value + dot(&weights.quintic, &curve.angle), wanted.value);
            close(dot(&weights.quartic, &curve.speed), wanted.first);
            close(dot(&weights.cubic, &curve.acceleration), wanted.second);
            close(dot(&weights.quadratic, &curve.jerk), wanted.third);
            for (largest, value) in sampled.iter_mut().zip([wanted.first, wanted.second, wanted.third]) {
                *largest = largest.max(value.abs());
            }
        }
        let [acceleration, jerk] = curve.largest();
        assert!(acceleration > 90.0 && sampled[1] <= acceleration && acceleration < 1.0001 * sampled[1]);
        assert!(sampled[2] <= jerk * (1.0 + 1e-9) && jerk < 1.0001 * sampled[2]);
        for (hull, sampled) in curve.hull().into_iter().zip(sampled) {
            assert!(hull * (1.0 + 1e-12) >= sampled);
        }
    }
}
