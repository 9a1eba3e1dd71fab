// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Peaks of the limit utilisation of a turn, between the points on which it was planned.

use super::in_time::Difference;
use super::square_speed::{SpeedKnots, SquareSpeed, to_f64};
use super::table::LimitTable;
use super::turn_request::TurnRequest;
use crate::math::hermite::Sample;
use crate::math::periodic_spline::Weights;
use crate::math::units::{TURN_RAD, wrap_turn};
use alloc::vec::Vec;

/// Largest ratios to their limits.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Peaks {
    pub(super) bound: f64,
    pub(super) c_acceleration: f64,
    pub(super) x_acceleration: f64,
    pub(super) c_jerk: f64,
    pub(super) x_jerk: f64,
}

impl Peaks {
    /// The larger of each.
    pub(super) fn larger(self, other: Self) -> Self {
        Self {
            bound: self.bound.max(other.bound),
            c_acceleration: self.c_acceleration.max(other.c_acceleration),
            x_acceleration: self.x_acceleration.max(other.x_acceleration),
            c_jerk: self.c_jerk.max(other.c_jerk),
            x_jerk: self.x_jerk.max(other.x_jerk),
        }
    }

    /// Factor by which z = Ċ² is beyond what the limits allow: accelerations go with it, jerks with its power 3/2.
    pub(super) fn excess(self) -> f64 {
        let jerk = libm::cbrt(self.c_jerk.max(self.x_jerk));
        self.bound.max(self.c_acceleration).max(self.x_acceleration).max(jerk * jerk)
    }
}

/// Points of a turn on which the path is looked at, at least, and at least two in each of its intervals.
const POINTS: usize = 14_400;

/// Share of a limit of X by which a peak between two points that are looked at may be above both, and most parts into which what lies
/// between two points of the path is divided for that.
const LEFT_OUT: f64 = 2e-5;
const MAX_LOOKS: f64 = 64.0;

/// Excess up to which an upper bound is taken as the use itself: the turn is slowed down by it, so that is on the safe side.
pub(super) const PROVEN: f64 = 1.0001;

/// Parts of an interval between which the bound is looked at in addition: a notch that a concave flank makes in it may be narrower than
/// the table is fine, and there the knots of a turn are close.
const BOUND_PARTS: usize = 4;

/// Use of the bound, in z, from which on a peak of it between points of the table is looked for.
const TOP_FROM: f64 = 0.97;

/// Speed-independent data of the path and its bound in one interval.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    /// Largest magnitudes that X′, X″ and X‴ can have (mm over rad).
    pub(super) x: [f64; 3],
    /// Largest 1/bound² at the points where it is looked at.
    per_bound: f64,
    /// 1/bound² at equal parts from the first end to the last.
    per_bounds: [f64; BOUND_PARTS + 1],
}

impl Reach {
    /// 1/bound² at the beginning and in the middle.
    pub(super) fn per_bound_at_points(&self) -> [f64; 2] {
        [self.per_bounds[0], self.per_bounds[BOUND_PARTS / 2]]
    }
}

/// Peaks of the limit utilisation for given knots.
pub(super) struct PeakSearch<'a> {
    request: &'a TurnRequest<'a>,
    table: &'a LimitTable,
    reach: Vec<Reach>,
    /// Weights at the points of an interval of the path.
    weights: Vec<Weights>,
}

impl<'a> PeakSearch<'a> {
    pub(super) fn new(request: &'a TurnRequest<'a>, table: &'a LimitTable, knots: &SpeedKnots) -> Self {
        let per_bound = |angle: f64| request.per_square_bound(angle, request.path.sample(angle));
        let at_knots: Vec<f64> = (0..knots.count()).map(|i| per_bound(knots.at(i))).collect();
        let reach = (0..knots.count()).map(|i| {
            let (begin, length) = (knots.at(i), knots.length(i));
            let per_bounds: [f64; BOUND_PARTS + 1] = core::array::from_fn(|part| match part {
                0 => at_knots[i],
                BOUND_PARTS => at_knots[knots.beside(i).1],
                _ => per_bound(begin + length * to_f64(part) / to_f64(BOUND_PARTS)),
            });
            let within = table.within(begin, length).map(|(_, per)| per);
            let largest = per_bounds.into_iter().chain(within).fold(0.0, f64::max);
            let x = largest_derivatives(request, begin, length);
            Reach { x, per_bound: largest, per_bounds }
        });
        let parts = 2 * POINTS.div_ceil(2 * request.path.coefficients().len());
        let weights = Weights::at_parts(u32::try_from(parts).unwrap_or(u32::MAX));
        Self { request, table, reach: reach.collect(), weights }
    }

    /// Uses of the limits of C by an acceleration and a jerk.
    pub(super) fn uses_of_c(&self, acceleration: f64, jerk: f64) -> Peaks {
        let c = &self.request.c;
        Peaks { c_acceleration: acceleration / c.acceleration, c_jerk: jerk / c.jerk, ..Peaks::default() }
    }

    /// Upper bounds of the uses in an interval for largest magnitudes of speed, acceleration and jerk of C.
    pub(super) fn hull_of_motion(&self, interval: usize, [v, a, j]: [f64; 3]) -> Peaks {
        let (reach, limits) = (&self.reach[interval], &self.request.x);
        let [x1, x2, x3] = reach.x;
        Peaks {
            bound: v * v * reach.per_bound,
            x_acceleration: (x2 * v * v + x1 * a) / limits.acceleration,
            x_jerk: (x3 * v * v * v + 3.0 * x2 * v * a + x1 * j) / limits.jerk,
            ..self.uses_of_c(a, j)
        }
    }

    /// Upper bounds of bound and X for a motion that differs from the plan by no more than this, from the peaks of the plan in an interval.
    pub(super) fn beside_plan(&self, interval: usize, peaks: &Peaks, difference: &Difference) -> Peaks {
        let [x_acceleration, x_jerk] = self.x_of_difference(self.reach[interval].x, difference);
        Peaks {
            bound: peaks.bound * (1.0 + difference.faster),
            x_acceleration: peaks.x_acceleration + x_acceleration,
            x_jerk: peaks.x_jerk + x_jerk,
            ..Peaks::default()
        }
    }

    /// Same as [`PeakSearch::beside_plan`], closer: with a difference in each part of the interval, given from one angle to another.
    pub(super) fn beside_plan_in_parts(
        &self,
        speed: &SquareSpeed,
        i: usize,
        parts: &[(f64, f64, Difference)],
    ) -> Peaks {
        let (begin, length) = (speed.knots().at(i), speed.knots().length(i));
        let z = Parabola::from_interval(speed, i);
        let faster = |along: f64| {
            let around = parts.iter().filter(|(from, to, _)| *from <= along && along <= *to);
            1.0 + around.map(|(_, _, difference)| difference.faster).fold(0.0, f64::max)
        };
        let bound = self.bound_peak(begin, length, &self.reach[i], &z, faster);
        let mut found = Peaks { bound, ..Peaks::default() };
        for (from, to, difference) in parts {
            let (begin, length) = (begin + from, to - from);
            let (acceleration, jerk) = self.x_peaks(begin, length, &z.beginning_at(*from));
            let x = largest_derivatives(self.request, begin, length);
            let [more_acceleration, more_jerk] = self.x_of_difference(x, difference);
            found.x_acceleration = found.x_acceleration.max(acceleration + more_acceleration);
            found.x_jerk = found.x_jerk.max(jerk + more_jerk);
        }
        found
    }

    /// Largest uses of X's acceleration and jerk by a difference where X′, X″ and X‴ are not above these.
    fn x_of_difference(&self, [x1, x2, x3]: [f64; 3], difference: &Difference) -> [f64; 2] {
        let limits = &self.request.x;
        [
            (x2 * difference.square + x1 * difference.acceleration) / limits.acceleration,
            (x3 * difference.cube + 3.0 * x2 * difference.product + x1 * difference.jerk) / limits.jerk,
        ]
    }

    /// Data of every interval.
    pub(super) fn reach(&self) -> &[Reach] {
        &self.reach
    }

    /// Peaks in each interval of a turn. An interval that cannot exceed 1 is not refined.
    pub(super) fn peaks(&self, speed: &SquareSpeed) -> Vec<Peaks> {
        (0..speed.knots().count()).map(|i| self.in_interval(speed, i)).collect()
    }

    /// Peaks in each interval of a turn, only at the points of the table where one may be above `nearly`.
    pub(super) fn estimate(&self, speed: &SquareSpeed, nearly: f64) -> Vec<Peaks> {
        let request = self.request;
        let in_interval = |i: usize| {
            let (begin, length) = (speed.knots().at(i), speed.knots().length(i));
            let z = Parabola::from_interval(speed, i);
            let mut found = self.hull(&self.reach[i], &z, length);
            if found.bound.max(found.x_acceleration).max(found.x_jerk) > nearly {
                let (mut bound, mut acceleration, mut jerk) = (0.0_f64, 0.0_f64, 0.0_f64);
                for (along, per_bound, x) in self.table.path_within(begin, length) {
                    let (z0, slope) = (z.at(along), z.first + along * z.second);
                    let x = request.with_infeed(*x);
                    bound = bound.max(per_bound * z0);
                    acceleration = acceleration.max((x.second * z0 + 0.5 * x.first * slope).abs());
                    let over_root = x.third * z0 + 1.5 * x.second * slope + 0.5 * x.first * z.second;
                    jerk = jerk.max(z0 * over_root * over_root);
                }
                found.bound = bound;
                found.x_acceleration = acceleration / request.x.acceleration;
                found.x_jerk = libm::sqrt(jerk) / request.x.jerk;
            }
            found
        };
        (0..speed.knots().count()).map(in_interval).collect()
    }

    /// Upper bounds of the peaks in an interval.
    fn hull(&self, reach: &Reach, z: &Parabola, length: f64) -> Peaks {
        let request = self.request;
        let (largest, steepest) = (z.largest(length), z.first.abs().max((z.first + length * z.second).abs()));
        let root = libm::sqrt(largest);
        let [x1, x2, x3] = reach.x;
        Peaks {
            bound: largest * reach.per_bound,
            c_acceleration: 0.5 * steepest / request.c.acceleration,
            c_jerk: 0.5 * root * z.second.abs() / request.c.jerk,
            x_acceleration: (x2 * largest + 0.5 * x1 * steepest) / request.x.acceleration,
            x_jerk: root * (x3 * largest + 1.5 * x2 * steepest + 0.5 * x1 * z.second.abs()) / request.x.jerk,
        }
    }

    fn in_interval(&self, speed: &SquareSpeed, i: usize) -> Peaks {
        let reach = &self.reach[i];
        let (begin, length) = (speed.knots().at(i), speed.knots().length(i));
        let z = Parabola::from_interval(speed, i);
        let mut found = self.hull(reach, &z, length);
        if found.bound > 1.0 {
            found.bound = self.bound_peak(begin, length, reach, &z, |_| 1.0);
        }
        if found.x_acceleration > 1.0 || found.x_jerk > 1.0 {
            (found.x_acceleration, found.x_jerk) = self.x_peaks(begin, length, &z);
        }
        found
    }

    /// Largest z/bound² in an interval, where z is larger than planned by a factor that depends on the angle.
    fn bound_peak(&self, begin: f64, length: f64, reach: &Reach, z: &Parabola, factor: impl Fn(f64) -> f64) -> f64 {
        let parts = reach.per_bounds.iter().enumerate();
        let parts = parts.map(|(part, per)| (length * to_f64(part) / to_f64(BOUND_PARTS), *per));
        let points = parts.clone().chain(self.table.within(begin, length));
        let mut largest = points.map(|(along, per)| per * z.at(along) * factor(along)).fold(0.0, f64::max);
        let mut look = |along: f64| largest = largest.max(self.per_bound(begin + along) * z.at(along) * factor(along));
        let [first, last] = [(0.0, reach.per_bounds[0]), (length, reach.per_bounds[BOUND_PARTS])];
        // The parts are closer than the points of the table where knots are close.
        bound_tops(parts, z, &mut look);
        bound_tops([first].into_iter().chain(self.table.in_order_within(begin, length)).chain([last]), z, &mut look);
        // z alone peaks where the bound is flat.
        if let Some(along) = z.peak(length) {
            look(along);
        }
        largest
    }

    /// 1/bound² at an angle, also behind the turn.
    fn per_bound(&self, angle_rad: f64) -> f64 {
        let angle_rad = wrap_turn(angle_rad);
        self.request.per_square_bound(angle_rad, self.request.path.sample(angle_rad))
    }

    /// Largest acceleration and jerk of X over their limits: at the points of the path, and between two of them where one can be larger
    /// there.
    ///
    /// Between two points neither exceeds the larger of its ends by more than an eighth of its bend times the square of their distance.
    /// The bend is an upper bound of its second derivative by the angle, from hulls of the path and of z. An upper bound hardly above
    /// the limit is taken as the peak. Above that, the gap is divided until a peak between two points exceeds both by less than
    /// `LEFT_OUT`.
    fn x_peaks(&self, begin: f64, length: f64, z: &Parabola) -> (f64, f64) {
        let (request, path) = (self.request, self.request.path);
        let (n, parts) = (path.coefficients().len(), self.weights.len());
        let spacing = TURN_RAD / to_f64(n * parts);
        let limits = [request.x.acceleration, request.x.jerk];
        // Acceleration and jerk, at the points and above what lies between them.
        let mut found = [0.0_f64; 2];
        let mut largest_between = [0.0_f64; 2];
        let look = |along: f64, x: Sample| {
            let x = request.with_infeed(x);
            let (z0, slope) = (z.at(along), z.first + along * z.second);
            let over_root = x.third * z0 + 1.5 * x.second * slope + 0.5 * x.first * z.second;
            [(x.second * z0 + 0.5 * x.first * slope).abs(), (libm::sqrt(z0) * over_root).abs()]
        };
        let mut before = (0.0, look(0.0, path.sample(begin)));
        found = larger_of(found, before.1);
        let hull = ZHull::new(z, length);
        let (from, to) = knots_of_path(request, begin, length);
        for knot in from..to {
            let in_turn = if knot < n { knot } else { knot - n };
            let bends = hull.bends_of_x(request, in_turn);
            for part in 1..=parts {
                let along = to_f64(knot * parts + part) * spacing - begin;
                let is_last = along >= length;
                if along <= before.0 {
                    continue;
                }
                let along = along.min(length);
                let x = match self.weights.get(part) {
                    _ if is_last => path.sample(begin + along),
                    Some(weights) => path.combine(in_turn, weights),
                    None => path.combine(if in_turn + 1 < n { in_turn + 1 } else { 0 }, &self.weights[0]),
                };
                let here = look(along, x);
                found = larger_of(found, here);
                let step = along - before.0;
                let mut looks = 1.0_f64;
                for k in 0..2 {
                    let arc = 0.125 * step * step * bends[k];
                    let most = before.1[k].max(here[k]) + arc;
                    let allowed = found[k].max(limits[k]);
                    if most > PROVEN * allowed {
                        looks = looks.max(libm::sqrt(arc / (LEFT_OUT * allowed)));
                    } else if most > allowed {
                        largest_between[k] = largest_between[k].max(most);
                    }
                }
                #[allow(clippy::cast_possible_truncation, reason = "at most some ten looks")]
                let looks = libm::ceil(looks.min(MAX_LOOKS)) as u32;
                for between in 1..looks {
                    let between = before.0 + step * f64::from(between) / f64::from(looks);
                    found = larger_of(found, look(between, path.sample(begin + between)));
                }
                before = (along, here);
                if is_last {
                    break;
                }
            }
        }
        let [acceleration, jerk] = larger_of(found, largest_between);
        (acceleration / limits[0], jerk / limits[1])
    }
}

fn larger_of(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].max(b[0]), a[1].max(b[1])]
}

/// Calls with the angles of the tops of z/bound² beside points, angle and 1/bound², that are above both of their neighbours: those of the
/// parabolas through the three.
fn bound_tops(points: impl Iterator<Item = (f64, f64)>, z: &Parabola, look: &mut impl FnMut(f64)) {
    let mut before: [Option<(f64, f64)>; 2] = [None, None];
    for (along, per) in points {
        let right = (along, per * z.at(along));
        if let [Some(left), Some(middle)] = before {
            let rise = (middle.1 - left.1) / (middle.0 - left.0);
            let fall = (middle.1 - right.1) / (right.0 - middle.0);
            if middle.1 > TOP_FROM && rise >= 0.0 && fall >= 0.0 && rise + fall > 0.0 {
                look(0.5 * (left.0 + middle.0 + (right.0 - left.0) * rise / (rise + fall)));
            }
        }
        before = [before[1], Some(right)];
    }
}

/// Upper bounds of z and its derivatives in an interval, and of those of √z.
struct ZHull {
    z: f64,
    first: f64,
    second: f64,
    root: f64,
    root_first: f64,
    root_second: f64,
}

impl ZHull {
    fn new(z: &Parabola, length: f64) -> Self {
        let (largest, second) = (z.largest(length), z.second.abs());
        let first = z.first.abs().max((z.first + length * z.second).abs());
        let least = z.least(length);
        let least_root = libm::sqrt(least);
        Self {
            z: largest,
            first,
            second,
            root: libm::sqrt(largest),
            root_first: 0.5 * first / least_root,
            root_second: 0.5 * (second + 0.5 * first * first / least) / least_root,
        }
    }

    /// Upper bounds of the second derivatives of X's acceleration g = X″z + ½X′z′ and jerk √z·g′ by the angle, between a knot of the path
    /// and the next.
    fn bends_of_x(&self, request: &TurnRequest<'_>, knot: usize) -> [f64; 2] {
        let [mut x1, x2, x3] = request.path.largest_derivatives(knot, knot + 1);
        x1 += request.infeed_slope_mm_rad.abs();
        let (x4, x5) = request.path.fourth_and_fifth(knot);
        let first = x3 * self.z + 1.5 * x2 * self.first + 0.5 * x1 * self.second;
        let second = x4 * self.z + 2.5 * x3 * self.first + 2.0 * x2 * self.second;
        let third = x5 * self.z + 3.5 * x4 * self.first + 4.5 * x3 * self.second;
        [second, self.root_second * first + 2.0 * self.root_first * second + self.root * third]
    }
}

/// z within an interval over the angle from its first knot.
pub(super) struct Parabola {
    z: f64,
    pub(super) first: f64,
    pub(super) second: f64,
}

impl Parabola {
    pub(super) fn from_interval(speed: &SquareSpeed, interval: usize) -> Self {
        let start = speed.within(interval, 0.0);
        Self { z: start.z, first: start.first, second: start.second }
    }

    pub(super) fn at(&self, along: f64) -> f64 {
        self.z + along * (self.first + 0.5 * along * self.second)
    }

    /// The same from an angle of the interval on.
    fn beginning_at(&self, along: f64) -> Self {
        Self { z: self.at(along), first: self.first + along * self.second, second: self.second }
    }

    /// The angle of a maximum between the ends.
    fn peak(&self, length: f64) -> Option<f64> {
        let is_inside = self.second < 0.0 && self.first > 0.0 && self.first + length * self.second < 0.0;
        is_inside.then(|| -self.first / self.second)
    }

    fn largest(&self, length: f64) -> f64 {
        let ends = self.z.max(self.at(length));
        self.peak(length).map_or(ends, |along| self.at(along))
    }

    fn least(&self, length: f64) -> f64 {
        let ends = self.z.min(self.at(length));
        let is_inside = self.second > 0.0 && self.first < 0.0 && self.first + length * self.second > 0.0;
        if is_inside { self.z - 0.5 * self.first * self.first / self.second } else { ends }
    }
}

/// Largest magnitudes that X′, X″ and X‴ can have over an interval (mm over rad).
fn largest_derivatives(request: &TurnRequest<'_>, begin: f64, length: f64) -> [f64; 3] {
    let (from, to) = knots_of_path(request, begin, length);
    let mut x = request.path.largest_derivatives(from, to);
    x[0] += request.infeed_slope_mm_rad.abs();
    x
}

/// The knots of the path before and after an interval; the latter may be beyond the turn.
fn knots_of_path(request: &TurnRequest<'_>, begin: f64, length: f64) -> (usize, usize) {
    let per_rad = request.path.per_rad();
    #[allow(clippy::cast_possible_truncation, reason = "some ten thousand knots")]
    let knot = |angle: f64| (angle * per_rad) as usize;
    (knot(begin), knot(begin + length) + 1)
}
