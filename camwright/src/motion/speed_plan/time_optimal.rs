//! The fastest turn that keeps every limit: velocity, acceleration and jerk of C and of X, and a bound on C's speed.
//!
//! Unknowns are the coefficients of z = Ċ² over the path angle (see [`super::square_speed`]). Time ∫dφ/√z is convex in
//! them, and every limit is linear but those of jerk: |z″/2| ≤ j/√z. Their right side is convex, so its tangent lies below
//! it and a step that keeps the tangent keeps the limit. A primal-dual interior point method with these tangents goes from
//! one plan that keeps every limit to the next, faster one; its Newton matrix is a cyclic band of two neighbours. The
//! problem is not convex: what is found is the best nearby.

use super::envelope::Envelope;
use super::peaks::{PeakSearch, Peaks};
use super::square_speed::{SpeedKnots, SpeedWeights, SquareSpeed, to_f64};
use super::turn_request::TurnRequest;
use crate::math::banded::CyclicBand;
use crate::math::hermite::Sample;
use alloc::vec;
use alloc::vec::Vec;

/// Points within an interval at which limits are held, as shares of it. The last belongs to the next interval too; only jerk jumps
/// there.
const SHARES: [f64; 3] = [0.0, 0.5, 1.0];

/// Simpson's rule over them.
const SIMPSON: [f64; 3] = [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0];

/// Limits on both sides of 0 in one interval, in this order: C acceleration at the first point, C jerk at the ends; X acceleration
/// at the first two points, X jerk at all three.
const PAIRS: usize = 3 + 2 + 3;

/// Those of C, which are all that an interval has where X can do whatever C can.
const PAIRS_OF_C: usize = 3;

/// Points of the pairs whose right side is √z there; what has another is at a point of its own.
const POINT: [usize; PAIRS] = [3, 0, 2, 3, 3, 0, 1, 2];

/// Points at which the bound is held.
const BOUNDS: usize = 2;

/// Share of X's limits up to which the largest acceleration and jerk that X can have in an interval leave them out of it.
const X_IS_FREE: f64 = 0.9;

/// Share of the turn's time by which it may still be improved nearby when the search ends.
const GAP: f64 = 5e-4;

/// Iterations after which the search ends with what it has: a plan that keeps its limits in any case.
const MAX_ITERATIONS: usize = 100;

/// Slowdowns of the plan that a search begins with: of a first one 10⁻²⁸ of the speed of the envelope in all.
const MAX_SLOWDOWNS: u32 = 400;

/// Start of a search.
pub(super) struct SearchStart {
    /// Factor of each slowdown, in z.
    slowdown: f64,
    /// Room that every limit is left then, as a share of it.
    spare: f64,
    /// Share of the turn's time that may be won.
    far: f64,
}

impl SearchStart {
    /// With next to nothing known.
    pub(super) const COLD: SearchStart = SearchStart { slowdown: 0.85, spare: 0.1, far: 1.0 };

    /// With a plan that was the fastest under limits a little wider.
    pub(super) const WARM: SearchStart = SearchStart { slowdown: 0.995, spare: 0.002, far: 0.005 };
}

/// Share of a Newton step required before the next one aims nearer to the limits, and the factor.
const TAKEN: f64 = 0.6;
const NEARER: f64 = 0.3;

/// A peak between points by which it is worth while to plan again; a smaller one slows the whole turn down by as much.
const WORTH_IT: f64 = 1.0005;

/// Jerk of X keeps a thousandth for what peaks between the points that are looked at.
const LOOSE_X_JERK: f64 = 1.001;

/// Data of one interval.
struct Interval {
    length: f64,
    /// Weights of z at the points; none at the point of those that have another right side.
    z: [SpeedWeights; 4],
    /// Weights of the values that are limited, in the order of pairs, factors of `tight` included.
    values: [SpeedWeights; PAIRS],
    /// Number of pairs.
    pairs: usize,
    /// 1/bound² at the first two points.
    per_bound: [f64; BOUNDS],
    /// Scale that brings the limits of jerk to the order of 1: √z as expected here.
    root: f64,
}

/// A number for every limit of an interval: of each pair for its upper and for its lower side.
#[derive(Clone, Copy)]
struct PerLimit {
    upper: [f64; PAIRS],
    lower: [f64; PAIRS],
    bound: [f64; BOUNDS],
}

impl PerLimit {
    const NONE: PerLimit = PerLimit { upper: [0.0; PAIRS], lower: [0.0; PAIRS], bound: [0.0; BOUNDS] };

    /// Room that is left to every limit.
    fn min(&self, pairs: usize) -> f64 {
        let sides = self.upper[..pairs].iter().chain(&self.lower[..pairs]).chain(&self.bound);
        sides.fold(f64::INFINITY, |min, room| min.min(*room))
    }
}

fn dot(w: &SpeedWeights, c: &SpeedWeights) -> f64 {
    w[0] * c[0] + w[1] * c[1] + w[2] * c[2]
}

fn times(factor: f64, w: &SpeedWeights) -> SpeedWeights {
    w.map(|w| factor * w)
}

fn sum<const N: usize>(all: [SpeedWeights; N]) -> SpeedWeights {
    all.iter().fold([0.0; 3], |sum, w| [sum[0] + w[0], sum[1] + w[1], sum[2] + w[2]])
}

/// The plan that is being improved, with the room it leaves to every limit and the price of that.
struct Iterate {
    coefficients: Vec<f64>,
    at: Vec<IntervalState>,
    /// Change of the prices with the current step.
    changes: Vec<PerLimit>,
    /// Sum of all prices times rooms (s): how far the plan is from the best nearby.
    gap: f64,
}

/// An interval under the plan at hand.
#[derive(Clone, Copy)]
struct IntervalState {
    /// 1/z at the points.
    per_z: [f64; 3],
    /// Slope of the right side of jerk by z, at the points.
    right_slope: [f64; 4],
    /// 1/room of every limit, and the price of it.
    per_room: PerLimit,
    price: PerLimit,
}

/// The limits of a turn on given knots.
pub(super) struct Problem {
    knots: SpeedKnots,
    intervals: Vec<Interval>,
}

impl Problem {
    pub(super) fn new(
        request: &TurnRequest<'_>,
        envelope: &Envelope,
        between: &PeakSearch<'_>,
        knots: SpeedKnots,
    ) -> Self {
        let at_knots: Vec<Sample> = (0..knots.count()).map(|i| request.path.sample(knots.at(i))).collect();
        let (c, limits) = (request.c, request.x);
        let intervals = (0..knots.count())
            .map(|i| {
                let (begin, length) = (knots.at(i), knots.length(i));
                let weights = SHARES.map(|u| knots.weights(i, u));
                let path = [at_knots[i], request.path.sample(begin + SHARES[1] * length), at_knots[knots.beside(i).1]];
                let reach = &between.reach()[i];
                let x = path.map(|path| request.with_infeed(path));
                let root = libm::sqrt(envelope.square_at(begin + 0.5 * length));
                let mut values = [[0.0; 3]; PAIRS];
                let (first, second) = (weights.map(|w| w[1]), weights[0][2]);
                values[0] = times(0.5 / c.acceleration, &first[0]);
                // Limits of jerk times root: root/√z ∓ root·z″/(2j) ≥ 0, by the tangent of the first term.
                values[1] = times(root * 0.5 / c.jerk, &second);
                values[2] = values[1];
                for k in 0..3 {
                    let [z, first, second] = weights[k];
                    if k < 2 {
                        values[3 + k] = sum([
                            times(x[k].second / limits.acceleration, &z),
                            times(0.5 * x[k].first / limits.acceleration, &first),
                        ]);
                    }
                    values[5 + k] = times(
                        root * LOOSE_X_JERK / limits.jerk,
                        &sum([
                            times(x[k].third, &z),
                            times(1.5 * x[k].second, &first),
                            times(0.5 * x[k].first, &second),
                        ]),
                    );
                }
                let z = [weights[0][0], weights[1][0], weights[2][0], [0.0; 3]];
                // The envelope may rise and fall by the acceleration of C within the interval.
                let largest = envelope.square_at(begin + 0.5 * length) + c.acceleration * length;
                let per_bound = reach.per_bound_at_points();
                let is_free = reach.largest_x_use(request, largest) <= X_IS_FREE;
                let pairs = if is_free { PAIRS_OF_C } else { PAIRS };
                Interval { length, z, values, pairs, per_bound, root }
            })
            .collect();
        Self { knots, intervals }
    }

    fn around(&self, values: &[f64], interval: usize) -> SpeedWeights {
        let (before, after) = self.knots.beside(interval);
        [values[before], values[interval], values[after]]
    }

    /// The plan at hand in an interval, without prices, and the room of every limit.
    #[inline]
    fn rooms(interval: &Interval, c: &SpeedWeights) -> (IntervalState, PerLimit) {
        let z = [0, 1, 2].map(|k| dot(&interval.z[k], c));
        let per_z = z.map(|z| 1.0 / z);
        let right = per_z.map(|per_z| interval.root * libm::sqrt(per_z));
        let right_slope = [0, 1, 2].map(|k| -0.5 * right[k] * per_z[k]);
        let right = [right[0], right[1], right[2], 1.0];
        let mut room = PerLimit::NONE;
        for p in 0..interval.pairs {
            let value = dot(&interval.values[p], c);
            room.upper[p] = right[POINT[p]] - value;
            room.lower[p] = right[POINT[p]] + value;
        }
        room.bound = [0, 1].map(|k| 1.0 - interval.per_bound[k] * z[k]);
        let right_slope = [right_slope[0], right_slope[1], right_slope[2], 0.0];
        (IntervalState { per_z, right_slope, per_room: PerLimit::NONE, price: PerLimit::NONE }, room)
    }

    fn time(&self, coefficients: &[f64]) -> f64 {
        let mut time = 0.0;
        for (i, interval) in self.intervals.iter().enumerate() {
            let c = self.around(coefficients, i);
            let sum: f64 = interval.z.iter().zip(SIMPSON).map(|(w, part)| part / libm::sqrt(dot(w, &c))).sum();
            time += interval.length * sum;
        }
        time
    }

    /// Returns whether a plan keeps every limit with this margin.
    fn keeps(&self, coefficients: &[f64], spare: f64) -> bool {
        self.intervals.iter().enumerate().all(|(i, interval)| {
            let c = self.around(coefficients, i);
            let is_positive = interval.z[..3].iter().all(|w| dot(w, &c) > 0.0);
            is_positive && Self::rooms(interval, &c).1.min(interval.pairs) > spare
        })
    }

    /// Number of limits.
    fn limits(&self) -> f64 {
        to_f64(self.intervals.iter().map(|interval| 2 * interval.pairs + BOUNDS).sum())
    }

    /// Tightens an interval with a peak between its points. Returns whether one was tightened.
    pub(super) fn tighten(&mut self, peaks: &[Peaks]) -> bool {
        let mut is_tighter = false;
        for (interval, found) in self.intervals.iter_mut().zip(peaks) {
            let (jerk_of_c, acceleration_of_x, jerk_of_x) = (1..3, 3..5, 5..8);
            for (ratio, pairs) in
                [(found.c_jerk, jerk_of_c), (found.x_acceleration, acceleration_of_x), (found.x_jerk, jerk_of_x)]
            {
                if ratio > WORTH_IT {
                    interval.values[pairs].iter_mut().for_each(|value| *value = times(ratio, value));
                    is_tighter = true;
                }
            }
            if found.bound > WORTH_IT {
                interval.per_bound.iter_mut().for_each(|per| *per *= found.bound);
                is_tighter = true;
            }
            // X was thought to be free there.
            if found.x_acceleration.max(found.x_jerk) > WORTH_IT {
                interval.pairs = PAIRS;
            }
        }
        is_tighter
    }

    /// The envelope, rounded over some intervals either way, and slowed down until it keeps every limit.
    pub(super) fn start(&self, round: usize) -> Vec<f64> {
        let squares: Vec<f64> = self.intervals.iter().map(|interval| interval.root * interval.root).collect();
        let low = over_neighbours(&squares, round, |low, each| low.min(each), f64::INFINITY);
        let reach = round / 2;
        let mut coefficients = low;
        for _ in 0..2 {
            coefficients = over_neighbours(&coefficients, reach, |sum, each| sum + each, 0.0);
            // A mean, but for a factor that the next loop takes out with the rest.
            let count = to_f64(2 * reach + 1);
            coefficients.iter_mut().for_each(|coefficient| *coefficient /= count);
        }
        coefficients
    }

    /// A plan slowed down until it keeps every limit.
    fn slowed_down(&self, mut coefficients: Vec<f64>, begin: &SearchStart) -> Option<Vec<f64>> {
        for _ in 0..MAX_SLOWDOWNS {
            if self.keeps(&coefficients, begin.spare) {
                return Some(coefficients);
            }
            coefficients.iter_mut().for_each(|coefficient| *coefficient *= begin.slowdown);
        }
        None
    }
}

/// Folds each value with those up to `reach` places away, round the end.
fn over_neighbours(values: &[f64], reach: usize, fold: impl Fn(f64, f64) -> f64, from: f64) -> Vec<f64> {
    let n = values.len();
    let reach = reach.min(n / 2);
    (0..n).map(|i| (0..=2 * reach).map(|k| values[(i + n + k - reach) % n]).fold(from, &fold)).collect()
}

/// The fastest turn found, `None` where not even standing nearly still keeps the limits; they hold at the points of the intervals.
///
/// `from` is where to begin, slowed down as need be.
pub(super) fn solve(problem: &Problem, from: Vec<f64>, begin: &SearchStart) -> Option<SquareSpeed> {
    let limits = problem.limits();
    let coefficients = problem.slowed_down(from, begin)?;
    let mut mu = begin.far * problem.time(&coefficients) / limits;
    let n = problem.knots.count();
    let none =
        IntervalState { per_z: [0.0; 3], right_slope: [0.0; 4], per_room: PerLimit::NONE, price: PerLimit::NONE };
    let mut it = Iterate { coefficients, at: vec![none; n], changes: vec![PerLimit::NONE; n], gap: 0.0 };
    // All prices at first are those of the central path: whatever is not there yet is brought to it.
    it.update_slacks(problem, mu, 0.0, f64::INFINITY);
    for _ in 0..MAX_ITERATIONS {
        let Some(stepped) = step(problem, &mut it, mu) else { break };
        if stepped.primal.min(stepped.dual) > TAKEN {
            let near = GAP * problem.time(&it.coefficients);
            if stepped.gap < near && mu * limits < near {
                break;
            }
            mu *= NEARER;
        }
    }
    Some(SquareSpeed::new(problem.knots.clone(), it.coefficients))
}

/// Factor by which a price may differ from that of the central path.
const ASTRAY: f64 = 30.0;

/// Below it a room is rounding.
const MIN_ROOM: f64 = 1e-13;

/// Share of a Newton step that was taken, and the distance of the plan from the best nearby before it (s).
struct StepLengths {
    primal: f64,
    dual: f64,
    gap: f64,
}

impl Iterate {
    /// Rooms of the coefficients at hand, and prices after a share of their change, none farther from those of the central path
    /// than by this factor: prices that have strayed from what the rooms now say hold the next steps back.
    fn update_slacks(&mut self, problem: &Problem, mu: f64, share: f64, astray: f64) {
        let is_first = astray.is_infinite();
        let (low, high) = if is_first { (mu, mu) } else { (mu / astray, mu * astray) };
        self.gap = 0.0;
        for (i, interval) in problem.intervals.iter().enumerate() {
            let (mut at, room) = Problem::rooms(interval, &problem.around(&self.coefficients, i));
            let (old, change) = (&self.at[i].price, &self.changes[i]);
            let mut gap = 0.0;
            let mut side = |room: &[f64], old: &[f64], change: &[f64], per_room: &mut [f64], price: &mut [f64]| {
                for p in 0..room.len() {
                    let per = 1.0 / room[p].max(MIN_ROOM);
                    per_room[p] = per;
                    price[p] = (old[p] + share * change[p]).max(low * per).min(high * per);
                    gap += price[p] * room[p];
                }
            };
            let n = interval.pairs;
            let (per, price) = (&mut at.per_room, &mut at.price);
            side(&room.upper[..n], &old.upper[..n], &change.upper[..n], &mut per.upper[..n], &mut price.upper[..n]);
            side(&room.lower[..n], &old.lower[..n], &change.lower[..n], &mut per.lower[..n], &mut price.lower[..n]);
            side(&room.bound, &old.bound, &change.bound, &mut per.bound, &mut price.bound);
            self.gap += gap;
            self.at[i] = at;
        }
    }
}

/// Adds an interval's part of the Newton matrix, upper half (0,0) (0,1) (0,2) (1,1) (1,2) (2,2), and of its right side.
#[inline]
fn assemble(interval: &Interval, at: &IntervalState, mu: f64) -> ([f64; 6], [f64; 3]) {
    let (mut h, mut g) = ([0.0; 6], [0.0; 3]);
    // A side's slope is that of its right side along z, less or more the value's: what goes with z is gathered by point.
    let (mut square, mut pull, mut cross) = ([0.0; 4], [0.0; 4], [[0.0; 3]; 4]);
    let (price, per) = (&at.price, &at.per_room);
    for (p, &point) in POINT.iter().enumerate().take(interval.pairs) {
        let value = &interval.values[p];
        let (upper, lower) = (price.upper[p] * per.upper[p], price.lower[p] * per.lower[p]);
        let slope = at.right_slope[point];
        square[point] += (upper + lower) * slope * slope;
        pull[point] += mu * (per.upper[p] + per.lower[p]) * slope;
        let by = (upper - lower) * slope;
        for (cross, value) in cross[point].iter_mut().zip(value) {
            *cross += by * value;
        }
        add(&mut h, &mut g, value, upper + lower, mu * (per.lower[p] - per.upper[p]));
    }
    for k in 0..BOUNDS {
        let slope = interval.per_bound[k];
        square[k] += price.bound[k] * per.bound[k] * slope * slope;
        pull[k] -= mu * per.bound[k] * slope;
    }
    for k in 0..3 {
        // Simpson's part of the time, 1/√z: its slope is that of the right side of jerk.
        let slope = -at.right_slope[k] * SIMPSON[k] * interval.length / interval.root;
        let [a, b, c] = interval.z[k];
        let [u, v, w] = cross[k];
        add(&mut h, &mut g, &interval.z[k], square[k] + 1.5 * slope * at.per_z[k], pull[k] + slope);
        h[0] -= 2.0 * a * u;
        h[1] -= a * v + b * u;
        h[2] -= a * w + c * u;
        h[3] -= 2.0 * b * v;
        h[4] -= b * w + c * v;
        h[5] -= 2.0 * c * w;
    }
    (h, g)
}

/// Change of an interval's prices with a step of its coefficients; and the largest rates at which the step uses up margins,
/// prices, and z, as shares of them.
#[inline]
fn follow(
    interval: &Interval,
    at: &IntervalState,
    moved: &SpeedWeights,
    mu: f64,
    change: &mut PerLimit,
) -> (f64, f64, f64) {
    let z = [0, 1, 2].map(|k| dot(&interval.z[k], moved));
    let (mut primal, mut dual, mut by_z) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (z, per_z) in z.iter().zip(&at.per_z) {
        by_z = by_z.max(-z * per_z);
    }
    let along_z = [z[0], z[1], z[2], 0.0];
    let mut side = |along: f64, per: f64, price: f64| {
        let rate = along * per;
        let new = mu * per - price * (1.0 + rate);
        primal = primal.max(-rate);
        dual = dual.max(-new / price);
        new
    };
    for p in 0..interval.pairs {
        let right = at.right_slope[POINT[p]] * along_z[POINT[p]];
        let value = dot(&interval.values[p], moved);
        change.upper[p] = side(right - value, at.per_room.upper[p], at.price.upper[p]);
        change.lower[p] = side(right + value, at.per_room.lower[p], at.price.lower[p]);
    }
    for (k, z) in z.iter().enumerate().take(BOUNDS) {
        change.bound[k] = side(-interval.per_bound[k] * z, at.per_room.bound[k], at.price.bound[k]);
    }
    (primal, dual, by_z)
}

/// One Newton step towards the point of the central path at μ.
fn step(problem: &Problem, it: &mut Iterate, mu: f64) -> Option<StepLengths> {
    let n = problem.knots.count();
    let mut band = CyclicBand::<3>::circulant(n, [0.0; 3]);
    let mut right = vec![0.0; n];
    let gap = it.gap;
    for (i, (interval, at)) in problem.intervals.iter().zip(&it.at).enumerate() {
        let (h, g) = assemble(interval, at, mu);
        let (before, after) = problem.knots.beside(i);
        let rows = band.rows_mut();
        rows[before][0] += h[0];
        rows[before][1] += h[1];
        rows[before][2] += h[2];
        rows[i][0] += h[3];
        rows[i][1] += h[4];
        rows[after][0] += h[5];
        right[before] += g[0];
        right[i] += g[1];
        right[after] += g[2];
    }
    band.factor().ok()?.solve(&mut right);
    let change = right;
    // Largest rates; a step uses up 0.99 of a room or a price and 0.9 of z at most.
    let (mut primal, mut dual, mut by_z) = (0.99_f64, 0.99_f64, 0.9_f64);
    // Coefficients are the middle Bézier points of z: above 0 with both ends they keep it so in between.
    for (coefficient, along) in it.coefficients.iter().zip(&change) {
        by_z = by_z.max(-along / coefficient);
    }
    for (i, ((interval, at), new)) in problem.intervals.iter().zip(&it.at).zip(&mut it.changes).enumerate() {
        let rates = follow(interval, at, &problem.around(&change, i), mu, new);
        primal = primal.max(rates.0);
        dual = dual.max(rates.1);
        by_z = by_z.max(rates.2);
    }
    let (primal, dual) = ((0.99 / primal).min(0.9 / by_z), 0.99 / dual);
    for (coefficient, along) in it.coefficients.iter_mut().zip(&change) {
        *coefficient += primal * along;
    }
    it.update_slacks(problem, mu, dual, ASTRAY);
    Some(StepLengths { primal, dual, gap })
}

fn add(h: &mut [f64; 6], g: &mut [f64; 3], slope: &SpeedWeights, weight: f64, pull: f64) {
    let [a, b, c] = *slope;
    let (wa, wb) = (weight * a, weight * b);
    h[0] += wa * a;
    h[1] += wa * b;
    h[2] += wa * c;
    h[3] += wb * b;
    h[4] += wb * c;
    h[5] += weight * c * c;
    g[0] += pull * a;
    g[1] += pull * b;
    g[2] += pull * c;
}
