//! Peaks of the limit utilisation of a turn, between the points on which it was planned.

use super::square_speed::{SpeedKnots, SquareSpeed, to_f64};
use super::table::LimitTable;
use super::turn_request::TurnRequest;
use crate::math::hermite::Sample;
use crate::math::periodic_spline::Weights;
use crate::math::units::TURN_RAD;
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

/// Parts into which what lies between two of those is divided where the jerk of X may have its peak there.
const JERK_PARTS: u32 = 8;

/// Parts of an interval between which the bound is looked at in addition: a notch that a concave flank makes in it may be narrower than
/// the table is fine, and there the knots of a turn are close.
const BOUND_PARTS: usize = 4;

/// Margin of a point between the evaluated ones, in multiples of the bound's spread in an interval.
const SPREADS: f64 = 4.0;

/// Speed-independent data of the path and its bound in one interval.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    /// Largest magnitudes that X′, X″ and X‴ can have (mm over rad).
    pub(super) x: [f64; 3],
    /// Largest 1/bound² at the points where it is looked at, and how much smaller the least is there.
    per_bound: f64,
    per_bound_spread: f64,
    /// 1/bound² at equal parts from the first end to the last.
    per_bounds: [f64; BOUND_PARTS + 1],
}

impl Reach {
    /// 1/bound² at the beginning and in the middle.
    pub(super) fn per_bound_at_points(&self) -> [f64; 2] {
        [self.per_bounds[0], self.per_bounds[BOUND_PARTS / 2]]
    }

    /// 1/bound² that no point between those where it was looked at is expected above: a notch between them shows in their spread.
    pub(super) fn expected_per_bound(&self) -> f64 {
        self.per_bound + SPREADS * self.per_bound_spread
    }

    /// Largest share of its acceleration and jerk that X can use while C keeps its own limits and z is not above this.
    pub(super) fn largest_x_use(&self, request: &TurnRequest<'_>, z: f64) -> f64 {
        let ([x1, x2, x3], c) = (self.x, request.c);
        let acceleration = x2 * z + x1 * c.acceleration;
        let jerk = libm::sqrt(z) * (x3 * z + 3.0 * x2 * c.acceleration) + x1 * c.jerk;
        (acceleration / request.x.acceleration).max(jerk / request.x.jerk)
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
            let all = per_bounds.into_iter().chain(within);
            let (min, largest) =
                all.fold((f64::INFINITY, 0.0), |(min, largest), per| (f64::min(min, per), f64::max(largest, per)));
            let (from, to) = knots_of_path(request, begin, length);
            let mut x = request.path.largest_derivatives(from, to);
            x[0] += request.infeed_slope_mm_rad.abs();
            Reach { x, per_bound: largest, per_bound_spread: largest - min, per_bounds }
        });
        let parts = 2 * POINTS.div_ceil(2 * request.path.coefficients().len());
        let weights = Weights::at_parts(u32::try_from(parts).unwrap_or(u32::MAX));
        Self { request, table, reach: reach.collect(), weights }
    }

    /// Data of every interval.
    pub(super) fn reach(&self) -> &[Reach] {
        &self.reach
    }

    /// Peaks in each interval of a turn. An interval that cannot exceed 1 is not refined.
    pub(super) fn peaks(&self, speed: &SquareSpeed) -> Vec<Peaks> {
        (0..speed.knots().count()).map(|i| self.in_interval(speed, i)).collect()
    }

    fn in_interval(&self, speed: &SquareSpeed, i: usize) -> Peaks {
        let (request, reach) = (self.request, &self.reach[i]);
        let (begin, length) = (speed.knots().at(i), speed.knots().length(i));
        let z = Parabola::from_interval(speed, i);
        let (largest, steepest) = (z.largest(length), z.first.abs().max((z.first + length * z.second).abs()));
        let root = libm::sqrt(largest);
        let [x1, x2, x3] = reach.x;
        let mut found = Peaks {
            bound: largest * reach.per_bound,
            c_acceleration: 0.5 * steepest / request.c.acceleration,
            c_jerk: 0.5 * root * z.second.abs() / request.c.jerk,
            x_acceleration: (x2 * largest + 0.5 * x1 * steepest) / request.x.acceleration,
            x_jerk: root * (x3 * largest + 1.5 * x2 * steepest + 0.5 * x1 * z.second.abs()) / request.x.jerk,
        };
        if found.bound > 1.0 {
            let parts = reach.per_bounds.iter().enumerate();
            let parts = parts.map(|(part, per)| per * z.at(length * to_f64(part) / to_f64(BOUND_PARTS)));
            let within = self.table.within(begin, length).map(|(along, per)| per * z.at(along));
            found.bound = parts.chain(within).fold(0.0, f64::max);
        }
        if found.x_acceleration > 1.0 || found.x_jerk > 1.0 {
            (found.x_acceleration, found.x_jerk) = self.x_peaks(begin, length, &z);
        }
        found
    }

    /// Largest acceleration and jerk of X over their limits: at the points of the path, and between them where jerk can be larger.
    fn x_peaks(&self, begin: f64, length: f64, z: &Parabola) -> (f64, f64) {
        let (request, path) = (self.request, self.request.path);
        let (n, parts) = (path.coefficients().len(), self.weights.len());
        let spacing = TURN_RAD / to_f64(n * parts);
        let (mut acceleration, mut jerk) = (0.0_f64, 0.0_f64);
        // Magnitude of the jerk over √z, and √z.
        let mut look = |along: f64, x: Sample| {
            let x = request.with_infeed(x);
            let (z0, slope) = (z.at(along), z.first + along * z.second);
            let over_root = (x.third * z0 + 1.5 * x.second * slope + 0.5 * x.first * z.second).abs();
            let root = libm::sqrt(z0);
            acceleration = acceleration.max((x.second * z0 + 0.5 * x.first * slope).abs());
            jerk = jerk.max(root * over_root);
            (over_root, root, jerk)
        };
        let mut before = (0.0, look(0.0, path.sample(begin)));
        let largest = z.largest(length);
        let steepest = z.first.abs().max((z.first + length * z.second).abs());
        let largest_third = |knot: usize| path.largest_derivatives(knot, knot + 1)[2];
        let (from, to) = knots_of_path(request, begin, length);
        for knot in from..to {
            let in_turn = if knot < n { knot } else { knot - n };
            let (fourth, fifth) = path.fourth_and_fifth(in_turn);
            // Second derivative of X‴z + 3/2·X″z′ + 1/2·X′z″, an eighth of which times the square of a distance is what a chord misses.
            let bend = fifth * largest + 3.5 * fourth * steepest + 4.5 * largest_third(in_turn) * z.second.abs();
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
                let ((left, left_root, _), (right, right_root, so_far)) = (before.1, here);
                let step = along - before.0;
                let chord = 0.125 * step * step;
                let root = left_root.max(right_root) + chord * z.second.abs() / left_root.min(right_root);
                if root * (left.max(right) + chord * bend) > so_far.max(request.x.jerk) {
                    for between in 1..JERK_PARTS {
                        let between = before.0 + step * f64::from(between) / f64::from(JERK_PARTS);
                        look(between, path.sample(begin + between));
                    }
                }
                before = (along, here);
                if is_last {
                    break;
                }
            }
        }
        (acceleration / request.x.acceleration, jerk / request.x.jerk)
    }
}

/// z within an interval over the angle from its first knot.
struct Parabola {
    z: f64,
    first: f64,
    second: f64,
}

impl Parabola {
    fn from_interval(speed: &SquareSpeed, interval: usize) -> Self {
        let start = speed.within(interval, 0.0);
        Self { z: start.z, first: start.first, second: start.second }
    }

    fn at(&self, along: f64) -> f64 {
        self.z + along * (self.first + 0.5 * along * self.second)
    }

    fn largest(&self, length: f64) -> f64 {
        let ends = self.z.max(self.at(length));
        let is_inside = self.second < 0.0 && self.first > 0.0 && self.first + length * self.second < 0.0;
        if is_inside { self.z - 0.5 * self.first * self.first / self.second } else { ends }
    }
}

/// The knots of the path before and after an interval; the latter may be beyond the turn.
fn knots_of_path(request: &TurnRequest<'_>, begin: f64, length: f64) -> (usize, usize) {
    let per_rad = request.path.per_rad();
    #[allow(clippy::cast_possible_truncation, reason = "some ten thousand knots")]
    let knot = |angle: f64| (angle * per_rad) as usize;
    (knot(begin), knot(begin + length) + 1)
}
