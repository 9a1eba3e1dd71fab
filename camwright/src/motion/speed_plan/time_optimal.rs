// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The fastest turn that keeps every limit: velocity, acceleration and jerk of C and of X, and a bound on C's speed.
//!
//! Unknowns are the coefficients of z = Ċ² over the path angle (see [`super::square_speed`]). Time ∫dφ/√z is convex in
//! them, and every limit is linear but those of jerk: |z″/2| ≤ j/√z. Their right side is convex, so its tangent lies below
//! it and a step that keeps the tangent keeps the limit. A primal-dual interior point method with these tangents improves a
//! plan; its Newton matrix is a cyclic band of two neighbours. Each limit has a slack of its own, so a plan may begin beyond its
//! limits and limits may be tightened on the way. The problem is not convex: what is found is the best nearby.
//!
//! Four neighbouring intervals are computed side by side.

use super::envelope::Envelope;
use super::peaks::{PeakSearch, Peaks};
use super::square_speed::{SpeedKnots, SpeedWeights, SquareSpeed, to_f64};
use super::turn_request::TurnRequest;
use crate::math::hermite::Sample;
use crate::math::lanes::{LANES, Lanes};
use crate::math::pentadiagonal::CyclicPentadiagonal;
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

/// Kinds of limits: C acceleration, C jerk, X acceleration, X jerk, bound.
const KINDS: usize = 5;
const KIND: [usize; PAIRS] = [0, 1, 1, 2, 2, 3, 3, 3];
const KIND_OF_BOUND: usize = 4;

/// Points at which the bound is held.
const BOUNDS: usize = 2;

/// Share of X's limits up to which the largest acceleration and jerk that X can have in an interval leave them out of it.
const X_IS_FREE: f64 = 0.9;

/// Share of the turn's time by which it may still be improved nearby when the search ends.
const GAP: f64 = 8e-4;

/// Shares of the turn's time that may be won when limits are tightened on the way, and the share of a limit from which on its use
/// counts then.
const TIGHTEN_AT: [(f64, f64); 3] = [(1.0, 0.5), (3e-2, 0.9), (PROVEN_AT, 0.97)];

/// Share from which on this is done with all peaks between the points, and not with estimates.
const PROVEN_AT: f64 = 6e-3;

/// The same when the search goes on after it had ended.
const AGAIN_AT: f64 = 1.5e-3;

/// Share of a limit by which a plan may be beyond it when the search ends: the turn is slowed down by as much.
const BEYOND: f64 = 2e-4;

/// Share of a limit by which a plan of a search that did not end may be beyond it.
const NEARLY_KEPT: f64 = 0.01;

/// Iterations after which the search ends with what it has.
const MAX_ITERATIONS: usize = 100;

/// Share of the turn's time that may be won at the beginning.
const FAR: f64 = 0.3;

/// Slack of a limit that is tightened, as a share of what the plan is beyond it.
const BEYOND_SLACK: f64 = 0.3;

/// Slack of a limit that a plan begins beyond.
const FIRST_SLACK: f64 = 0.1;

/// Slack of a limit that is tight when the search goes on.
const WIDE_SLACK: f64 = 2e-3;

/// Factor of the speed's square where a plan is slowed down until it keeps every limit, how often at most, and the room that is left
/// to every limit then.
const SLOWDOWN: f64 = 0.85;
const MAX_SLOWDOWNS: u32 = 400;
const SPARE: f64 = 0.1;

/// Shares of a Newton step required before the next one aims nearer to the limits, and the factors.
const TAKEN: f64 = 0.5;
const NEARER: f64 = 0.3;
const NEARLY_ALL: f64 = 0.9;
const MUCH_NEARER: f64 = 0.15;

/// A peak between points by which it is worth while to plan again; a smaller one slows the whole turn down by as much.
const WORTH_IT: f64 = 5e-4;

/// Jerk of X keeps a thousandth for what peaks between the points that are looked at.
const LOOSE_X_JERK: f64 = 1.001;

/// Factor by which a price may differ from that of the central path.
const ASTRAY: f64 = 30.0;

/// Below it a slack is rounding.
const MIN_SLACK: f64 = 1e-13;

/// Weights of the three coefficients that an interval sees, of four intervals.
type LaneWeights = [Lanes; 3];

/// Data of four intervals.
struct Group {
    length: Lanes,
    /// Weights of z at the points.
    z: [LaneWeights; 3],
    /// Weights of the values that are limited, in the order of pairs, factors of tightening included.
    values: [LaneWeights; PAIRS],
    /// The limits of X are part of the problem.
    has_x: bool,
    /// 1/bound² at the first two points.
    per_bound: [Lanes; BOUNDS],
    /// Factors of tightening, by kind.
    tight: [Lanes; KINDS],
    /// Scale that brings the limits of jerk to the order of 1: √z as expected here.
    root: Lanes,
}

/// A limit of four intervals under the plan at hand.
#[derive(Clone, Copy)]
struct Limit {
    slack: Lanes,
    per_slack: Lanes,
    price: Lanes,
    /// Difference of room and slack.
    residual: Lanes,
    /// Changes with the step at hand.
    slack_change: Lanes,
    price_change: Lanes,
}

impl Limit {
    const NONE: Limit = Limit {
        slack: Lanes::ZERO,
        per_slack: Lanes::ZERO,
        price: Lanes::ZERO,
        residual: Lanes::ZERO,
        slack_change: Lanes::ZERO,
        price_change: Lanes::ZERO,
    };
}

/// Shares of a step, μ, and what comes together over all limits.
struct Advance {
    primal: Lanes,
    dual: Lanes,
    mu: Lanes,
    /// Range of prices times slacks: prices that have strayed from what the slacks say hold the next steps back.
    low: Lanes,
    high: Lanes,
    gap: Lanes,
    beyond: Lanes,
}

/// μ, and the largest rates at which a step uses up slacks and prices.
struct Follow {
    mu: Lanes,
    primal: Lanes,
    dual: Lanes,
}

impl Limit {
    /// Takes the shares of the step. Returns the weight of the limit in the Newton matrix, and its pull in the right side.
    #[inline(always)]
    fn advance(&mut self, room: Lanes, by: &mut Advance) -> (Lanes, Lanes) {
        let slack = (self.slack + by.primal * self.slack_change).larger(room).larger(Lanes::splat(MIN_SLACK));
        let per = Lanes::splat(1.0) / slack;
        let price = (self.price + by.dual * self.price_change).larger(by.low * per).smaller(by.high * per);
        let residual = room - slack;
        by.gap += price * slack;
        by.beyond = by.beyond.larger(-room);
        let weight = price * per;
        (self.slack, self.per_slack, self.price, self.residual) = (slack, per, price, residual);
        (weight, by.mu * per - weight * residual)
    }

    /// Changes with a step along which the room changes like this.
    #[inline(always)]
    fn follow(&mut self, along: Lanes, by: &mut Follow) {
        let slack_change = self.residual + along;
        let rate = slack_change * self.per_slack;
        let price_change = by.mu * self.per_slack - self.price * (Lanes::splat(1.0) + rate);
        by.primal = by.primal.larger(-rate);
        by.dual = by.dual.larger(-(price_change / self.price));
        (self.slack_change, self.price_change) = (slack_change, price_change);
    }
}

/// Every limit of four intervals: of each pair its upper and its lower side.
#[derive(Clone, Copy)]
struct Limits {
    upper: [Limit; PAIRS],
    lower: [Limit; PAIRS],
    bound: [Limit; BOUNDS],
}

#[inline(always)]
fn dot(w: &LaneWeights, c: &LaneWeights) -> Lanes {
    w[0] * c[0] + w[1] * c[1] + w[2] * c[2]
}

fn times(factor: f64, w: &SpeedWeights) -> SpeedWeights {
    w.map(|w| factor * w)
}

fn sum<const N: usize>(all: [SpeedWeights; N]) -> SpeedWeights {
    all.iter().fold([0.0; 3], |sum, w| [sum[0] + w[0], sum[1] + w[1], sum[2] + w[2]])
}

/// z at the points, and the right sides of the limits of jerk there.
#[derive(Clone, Copy)]
struct Points {
    z: [Lanes; 3],
    per_z: [Lanes; 3],
    right: [Lanes; 3],
    /// Slopes of the right sides by z.
    slope: [Lanes; 3],
}

impl Group {
    const NONE: Group = Group {
        length: Lanes::ZERO,
        z: [[Lanes::ZERO; 3]; 3],
        values: [[Lanes::ZERO; 3]; PAIRS],
        has_x: false,
        per_bound: [Lanes::ZERO; BOUNDS],
        tight: [Lanes::splat(1.0); KINDS],
        root: Lanes::ZERO,
    };

    #[inline(always)]
    fn points(&self, c: &LaneWeights) -> Points {
        let z = [0, 1, 2].map(|k| dot(&self.z[k], c));
        let per_z = z.map(|z| Lanes::splat(1.0) / z);
        let right = per_z.map(|per_z| self.root * per_z.sqrt());
        let slope = [0, 1, 2].map(|k| -0.5 * (right[k] * per_z[k]));
        Points { z, per_z, right, slope }
    }

    /// Calls with every pair, and its right side's point if it is not 1.
    #[inline(always)]
    fn for_each_pair(&self, mut pair: impl FnMut(usize, Option<usize>)) {
        pair(0, None);
        pair(1, Some(0));
        pair(2, Some(2));
        if self.has_x {
            pair(3, None);
            pair(4, None);
            pair(5, Some(0));
            pair(6, Some(1));
            pair(7, Some(2));
        }
    }

    fn pairs(&self) -> usize {
        if self.has_x { PAIRS } else { PAIRS_OF_C }
    }
}

/// Coefficients of a turn with the last before the first and the first after the last.
struct Ring(Vec<f64>);

impl Ring {
    fn new(count: usize) -> Self {
        Self(vec![0.0; count + 2])
    }

    fn set(&mut self, values: &[f64]) {
        let n = values.len();
        self.0[0] = values[n - 1];
        self.0[1..=n].copy_from_slice(values);
        self.0[n + 1] = values[0];
    }

    #[inline(always)]
    fn around(&self, group: usize) -> LaneWeights {
        [0, 1, 2].map(|k| Lanes::load(&self.0, LANES * group + k))
    }
}

/// The limits of a turn on given knots.
pub(super) struct Problem {
    knots: SpeedKnots,
    groups: Vec<Group>,
    /// Coefficients with which a search begins.
    begin: Vec<f64>,
}

impl Problem {
    /// `round`: intervals over which the start is rounded either way.
    pub(super) fn new(
        request: &TurnRequest<'_>,
        envelope: &Envelope,
        between: &PeakSearch<'_>,
        knots: SpeedKnots,
        round: usize,
    ) -> Self {
        let count = knots.count();
        debug_assert!(count.is_multiple_of(LANES), "whole groups");
        let at_knots: Vec<Sample> = (0..count).map(|i| request.path.sample(knots.at(i))).collect();
        let (c, limits) = (request.c, request.x);
        let mut begin = Vec::with_capacity(count);
        let groups = (0..count / LANES).map(|group| {
            let mut lanes = Group::NONE;
            for lane in 0..LANES {
                let i = LANES * group + lane;
                let (from, length) = (knots.at(i), knots.length(i));
                let weights = SHARES.map(|u| knots.weights(i, u));
                let path = [at_knots[i], request.path.sample(from + SHARES[1] * length), at_knots[knots.beside(i).1]];
                let reach = &between.reach()[i];
                let x = path.map(|path| request.with_infeed(path));
                let square = envelope.square_at(from + 0.5 * length);
                let root = libm::sqrt(square);
                begin.push(request.slowed_by_x(reach.x, square));
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
                // The envelope may rise and fall by the acceleration of C within the interval.
                let largest = square + c.acceleration * length;
                lanes.has_x |= request.largest_x_use(reach.x, largest) > X_IS_FREE;
                let put = |to: &mut LaneWeights, from: &SpeedWeights| {
                    to.iter_mut().zip(from).for_each(|(to, from)| to.0[lane] = *from);
                };
                lanes.values.iter_mut().zip(&values).for_each(|(to, from)| put(to, from));
                lanes.z.iter_mut().zip(&weights).for_each(|(to, from)| put(to, &from[0]));
                for (to, per) in lanes.per_bound.iter_mut().zip(reach.per_bound_at_points()) {
                    to.0[lane] = per;
                }
                (lanes.length.0[lane], lanes.root.0[lane]) = (length, root);
            }
            lanes
        });
        let groups = groups.collect();
        let begin = rounded(&begin, round);
        Self { knots, groups, begin }
    }

    /// Time of a plan (s).
    fn time(&self, ring: &Ring) -> f64 {
        let mut time = Lanes::ZERO;
        for (i, group) in self.groups.iter().enumerate() {
            let c = ring.around(i);
            let mut sum = Lanes::ZERO;
            for (w, part) in group.z.iter().zip(SIMPSON) {
                sum += Lanes::splat(part) / dot(w, &c).sqrt();
            }
            time += group.length * sum;
        }
        time.sum()
    }

    /// Number of limits.
    fn limits(&self) -> f64 {
        to_f64(self.groups.iter().map(|group| LANES * (2 * group.pairs() + BOUNDS)).sum())
    }

    /// Smallest room that a plan leaves to a limit.
    fn room(&self, ring: &Ring) -> f64 {
        let mut least = Lanes::splat(f64::INFINITY);
        for (i, group) in self.groups.iter().enumerate() {
            let c = ring.around(i);
            let at = group.points(&c);
            group.for_each_pair(|p, point| {
                let value = dot(&group.values[p], &c);
                let right = point.map_or(Lanes::splat(1.0), |k| at.right[k]);
                least = least.smaller(right - value).smaller(right + value);
            });
            for k in 0..BOUNDS {
                least = least.smaller(Lanes::splat(1.0) - group.per_bound[k] * at.z[k]);
            }
            for z in at.z {
                if z.0.iter().any(|z| z.is_nan() || *z <= 0.0) {
                    return f64::NEG_INFINITY;
                }
            }
        }
        -(-least).largest()
    }

    /// Tightens limits of intervals by what peaks between their points, and loosens what was tightened too much. Returns whether
    /// it made a noticeable difference.
    fn tighten(&mut self, ring: &Ring, peaks: &[Peaks], nearly: f64) -> bool {
        let mut is_changed = false;
        for (i, group) in self.groups.iter_mut().enumerate() {
            let c = ring.around(i);
            let at = group.points(&c);
            let mut used = [Lanes::ZERO; KINDS];
            let (values, mut is_beyond) = (group.values, false);
            group.for_each_pair(|p, point| {
                let value = dot(&values[p], &c);
                let value = value.larger(-value);
                let used = &mut used[KIND[p]];
                *used = used.larger(point.map_or(value, |k| value / at.right[k]));
            });
            used[KIND_OF_BOUND] = (group.per_bound[0] * at.z[0]).larger(group.per_bound[1] * at.z[1]);
            for (lane, found) in peaks[LANES * i..].iter().take(LANES).enumerate() {
                let mut by = [1.0; KINDS];
                for (kind, peak) in
                    [0.0, found.c_jerk, found.x_acceleration, found.x_jerk, found.bound].into_iter().enumerate()
                {
                    let (used, tight) = (used[kind].0[lane], &mut group.tight[kind].0[lane]);
                    let tighter = peak / used.clamp(nearly, 1.0);
                    let tighter = (if used < nearly { tighter.max(1.0) } else { tighter }).max(1.0 / *tight);
                    if peak.max(used) > nearly && (tighter - 1.0).abs() > WORTH_IT {
                        *tight *= tighter;
                        by[kind] = tighter;
                        is_changed = true;
                    }
                }
                for (values, kind) in group.values.iter_mut().zip(KIND) {
                    values.iter_mut().for_each(|weight| weight.0[lane] *= by[kind]);
                }
                group.per_bound.iter_mut().for_each(|per| per.0[lane] *= by[KIND_OF_BOUND]);
                is_beyond |= found.x_acceleration.max(found.x_jerk) > 1.0;
            }
            // X was thought to be free there.
            group.has_x |= is_beyond;
        }
        is_changed
    }
}

/// The lowest values around each, rounded.
fn rounded(squares: &[f64], round: usize) -> Vec<f64> {
    let low = over_neighbours(squares, round, |low, each| low.min(each), f64::INFINITY);
    let reach = round / 2;
    let mut coefficients = low;
    for _ in 0..2 {
        coefficients = over_neighbours(&coefficients, reach, |sum, each| sum + each, 0.0);
        let count = to_f64(2 * reach.min(squares.len() / 2) + 1);
        coefficients.iter_mut().for_each(|coefficient| *coefficient /= count);
    }
    coefficients
}

/// Folds each value with those up to `reach` places away, round the end.
fn over_neighbours(values: &[f64], reach: usize, fold: impl Fn(f64, f64) -> f64, from: f64) -> Vec<f64> {
    let n = values.len();
    let reach = reach.min(n / 2);
    (0..n).map(|i| (0..=2 * reach).map(|k| values[(i + n + k - reach) % n]).fold(from, &fold)).collect()
}

/// Four intervals under the plan at hand.
#[derive(Clone, Copy)]
struct GroupState {
    points: Points,
    limits: Limits,
}

/// A search for the fastest turn: the plan that is being improved, with the slack it leaves to every limit and the price of that.
pub(super) struct Search {
    problem: Problem,
    coefficients: Vec<f64>,
    ring: Ring,
    /// The step at hand.
    change: Vec<f64>,
    change_ring: Ring,
    at: Vec<GroupState>,
    /// Rows of the Newton matrix and of its right side, as in a ring.
    sums: Vec<[f64; 4]>,
    band: CyclicPentadiagonal,
    mu: f64,
    /// Sum of all prices times slacks (s): how far the plan is from the best nearby.
    gap: f64,
    /// Largest share of a limit by which the plan is beyond it.
    beyond: f64,
    /// Time of the turn (s).
    time: f64,
}

/// Shares of a Newton step.
#[derive(Clone, Copy)]
struct StepLengths {
    primal: f64,
    dual: f64,
}

impl Search {
    pub(super) fn new(problem: Problem) -> Self {
        let n = problem.knots.count();
        let points =
            Points { z: [Lanes::ZERO; 3], per_z: [Lanes::ZERO; 3], right: [Lanes::ZERO; 3], slope: [Lanes::ZERO; 3] };
        let limits = Limits { upper: [Limit::NONE; PAIRS], lower: [Limit::NONE; PAIRS], bound: [Limit::NONE; BOUNDS] };
        let mut search = Self {
            coefficients: problem.begin.clone(),
            ring: Ring::new(n),
            change: vec![0.0; n],
            change_ring: Ring::new(n),
            at: vec![GroupState { points, limits }; n / LANES],
            sums: vec![[0.0; 4]; n + 2],
            band: CyclicPentadiagonal::new(n),
            mu: 0.0,
            gap: 0.0,
            beyond: 0.0,
            time: 0.0,
            problem,
        };
        search.ring.set(&search.coefficients);
        search.restart(FAR);
        search
    }

    /// Begins with the plan at hand where that share of the time may be won, with prices of the central path.
    fn restart(&mut self, far: f64) {
        self.mu = far * self.problem.time(&self.ring) / self.problem.limits();
        let mu = Lanes::splat(self.mu);
        self.for_each_limit(|room, limit| {
            let slack = room.larger(Lanes::splat(FIRST_SLACK)).larger(BEYOND_SLACK * -room);
            *limit = Limit { slack, price: mu / slack, ..Limit::NONE };
        });
    }

    /// Goes on from the plan at hand, with wider slacks, where that share of the time may be won.
    fn widen(&mut self, far: f64) {
        self.mu = far * self.problem.time(&self.ring) / self.problem.limits();
        let mu = Lanes::splat(self.mu);
        self.for_each_limit(|room, limit| {
            let slack = room.larger(Lanes::splat(WIDE_SLACK));
            *limit = Limit { slack, price: (mu / slack).larger(limit.price), ..Limit::NONE };
        });
    }

    /// Begins with limits that were not looked at so far, and gives those that the plan is far beyond now some slack.
    fn begin_tightened_limits(&mut self) {
        let mu = Lanes::splat(self.mu);
        self.for_each_limit(|room, limit| {
            if limit.slack == Lanes::ZERO {
                let slack = room.larger(Lanes::splat(FIRST_SLACK));
                *limit = Limit { slack, price: mu / slack, ..Limit::NONE };
            }
            limit.slack = limit.slack.larger(BEYOND_SLACK * -room);
        });
    }

    /// Calls with the room of every limit.
    fn for_each_limit(&mut self, mut each: impl FnMut(Lanes, &mut Limit)) {
        for (i, (group, at)) in self.problem.groups.iter().zip(&mut self.at).enumerate() {
            let c = self.ring.around(i);
            let points = group.points(&c);
            group.for_each_pair(|p, point| {
                let value = dot(&group.values[p], &c);
                let right = point.map_or(Lanes::splat(1.0), |k| points.right[k]);
                each(right - value, &mut at.limits.upper[p]);
                each(right + value, &mut at.limits.lower[p]);
            });
            for k in 0..BOUNDS {
                each(Lanes::splat(1.0) - group.per_bound[k] * points.z[k], &mut at.limits.bound[k]);
            }
        }
    }

    /// Takes the shares of the last step into slacks and prices, and sets up the next: Newton matrix and right side.
    fn assemble(&mut self, taken: StepLengths) {
        let mu = Lanes::splat(self.mu);
        let mut advance = Advance {
            primal: Lanes::splat(taken.primal),
            dual: Lanes::splat(taken.dual),
            mu,
            low: Lanes::splat(self.mu / ASTRAY),
            high: Lanes::splat(self.mu * ASTRAY),
            gap: Lanes::ZERO,
            beyond: Lanes::ZERO,
        };
        let mut time = Lanes::ZERO;
        self.sums.fill([0.0; 4]);
        for (i, (group, at)) in self.problem.groups.iter().zip(&mut self.at).enumerate() {
            let c = self.ring.around(i);
            let points = group.points(&c);
            let (mut h, mut g) = ([Lanes::ZERO; 6], [Lanes::ZERO; 3]);
            // A side's slope is that of its right side along z, less or more the value's: what goes with z is gathered by point.
            let (mut square, mut pull, mut cross) = ([Lanes::ZERO; 3], [Lanes::ZERO; 3], [[Lanes::ZERO; 3]; 3]);
            group.for_each_pair(|p, point| {
                let value = &group.values[p];
                let size = dot(value, &c);
                let right = point.map_or(Lanes::splat(1.0), |k| points.right[k]);
                let upper = at.limits.upper[p].advance(right - size, &mut advance);
                let lower = at.limits.lower[p].advance(right + size, &mut advance);
                if let Some(k) = point {
                    let slope = points.slope[k];
                    square[k] += (upper.0 + lower.0) * slope * slope;
                    pull[k] += (upper.1 + lower.1) * slope;
                    let by = (upper.0 - lower.0) * slope;
                    for (cross, value) in cross[k].iter_mut().zip(value) {
                        *cross += by * *value;
                    }
                }
                add(&mut h, &mut g, value, upper.0 + lower.0, lower.1 - upper.1);
            });
            for k in 0..BOUNDS {
                let per_bound = group.per_bound[k];
                let room = Lanes::splat(1.0) - per_bound * points.z[k];
                let (weight, toward) = at.limits.bound[k].advance(room, &mut advance);
                square[k] += weight * per_bound * per_bound;
                pull[k] -= toward * per_bound;
            }
            let scale = group.length / group.root;
            time +=
                scale * (SIMPSON[0] * points.right[0] + SIMPSON[1] * points.right[1] + SIMPSON[2] * points.right[2]);
            for k in 0..3 {
                // Simpson's part of the time, 1/√z: its slope is that of the right side of jerk.
                let slope = -(points.slope[k] * (SIMPSON[k] * scale));
                let z = &group.z[k];
                add(&mut h, &mut g, z, square[k] + 1.5 * (slope * points.per_z[k]), pull[k] + slope);
                let [a, b, c] = *z;
                let [u, v, w] = cross[k];
                h[0] -= 2.0 * (a * u);
                h[1] -= a * v + b * u;
                h[2] -= a * w + c * u;
                h[3] -= 2.0 * (b * v);
                h[4] -= b * w + c * v;
                h[5] -= 2.0 * (c * w);
            }
            at.points = points;
            for lane in 0..LANES {
                let [before, here, after] = [0, 1, 2].map(|k| LANES * i + lane + k);
                let (h, g) = (h.map(|h| h.0[lane]), g.map(|g| g.0[lane]));
                add_row(&mut self.sums[before], [h[0], h[1], h[2], g[0]]);
                add_row(&mut self.sums[here], [h[3], h[4], 0.0, g[1]]);
                add_row(&mut self.sums[after], [h[5], 0.0, 0.0, g[2]]);
            }
        }
        // The last row stands before the first too, and the first after the last.
        let n = self.change.len();
        let (first, last) = (self.sums[0], self.sums[n + 1]);
        add_row(&mut self.sums[n], first);
        add_row(&mut self.sums[1], last);
        for ((row, right), sums) in self.band.rows_mut().iter_mut().zip(&mut self.change).zip(&self.sums[1..]) {
            *row = [sums[0], sums[1], sums[2]];
            *right = sums[3];
        }
        (self.gap, self.beyond, self.time) = (advance.gap.sum(), advance.beyond.largest(), time.sum());
    }

    /// Changes of slacks and prices with the step at hand, and the largest shares of it that keep them and z above 0.
    fn follow(&mut self) -> StepLengths {
        let mut follow = Follow { mu: Lanes::splat(self.mu), primal: Lanes::ZERO, dual: Lanes::ZERO };
        let mut by_z = Lanes::ZERO;
        for (i, (group, at)) in self.problem.groups.iter().zip(&mut self.at).enumerate() {
            let moved = self.change_ring.around(i);
            // Coefficients are the middle Bézier points of z: above 0 with both ends they keep it so in between.
            by_z = by_z.larger(-(moved[1] / self.ring.around(i)[1]));
            let z = [0, 1, 2].map(|k| dot(&group.z[k], &moved));
            for (z, per_z) in z.iter().zip(at.points.per_z) {
                by_z = by_z.larger(-(*z * per_z));
            }
            group.for_each_pair(|p, point| {
                let value = dot(&group.values[p], &moved);
                let right = point.map_or(Lanes::ZERO, |k| at.points.slope[k] * z[k]);
                at.limits.upper[p].follow(right - value, &mut follow);
                at.limits.lower[p].follow(right + value, &mut follow);
            });
            for ((limit, per_bound), z) in at.limits.bound.iter_mut().zip(group.per_bound).zip(z) {
                limit.follow(-(per_bound * z), &mut follow);
            }
        }
        // A step uses up 0.99 of a slack or a price and 0.9 of z at most.
        let (primal, dual) = (follow.primal.largest().max(0.99), follow.dual.largest().max(0.99));
        StepLengths { primal: (0.99 / primal).min(0.9 / by_z.largest().max(0.9)), dual: 0.99 / dual }
    }

    /// Searches on until the plan is near the best nearby. `None` where no plan was found that keeps its limits.
    fn run(&mut self, between: &PeakSearch<'_>, tighten_at: &[(f64, f64)]) -> Option<()> {
        let limits = self.problem.limits();
        let mut tighten_at = tighten_at.iter().peekable();
        let mut taken = StepLengths { primal: 0.0, dual: 0.0 };
        for _ in 0..MAX_ITERATIONS {
            self.assemble(taken);
            let gap = self.gap;
            self.band.solve(&mut self.change)?;
            self.change_ring.set(&self.change);
            taken = self.follow();
            for (coefficient, along) in self.coefficients.iter_mut().zip(&self.change) {
                *coefficient += taken.primal * along;
            }
            self.ring.set(&self.coefficients);
            let share = taken.primal.min(taken.dual);
            let time = self.time;
            if share > TAKEN {
                let (near, mu) = (GAP * time, self.mu * limits);
                if gap < near && mu < near && self.beyond < BEYOND {
                    return Some(());
                }
                if let Some((at, nearly)) = tighten_at.next_if(|(at, _)| mu < at * time) {
                    let peaks = if *at <= PROVEN_AT {
                        between.peaks(&self.speed())
                    } else {
                        between.estimate(&self.speed(), *nearly)
                    };
                    self.problem.tighten(&self.ring, &peaks, *nearly);
                    self.begin_tightened_limits();
                    continue;
                }
                self.mu *= if share > NEARLY_ALL { MUCH_NEARER } else { NEARER };
            }
        }
        None
    }

    /// The plan at hand.
    pub(super) fn speed(&self) -> SquareSpeed {
        SquareSpeed::new(self.problem.knots.clone(), self.coefficients.clone())
    }

    /// The fastest turn found, `None` where not even standing nearly still keeps the limits; they hold at the points of the intervals.
    pub(super) fn fastest(&mut self, between: &PeakSearch<'_>) -> Option<SquareSpeed> {
        if self.run(between, &TIGHTEN_AT).is_none() {
            self.slow_down()?;
            self.restart(1.0);
            // From there on a plan keeps its limits, however far the search comes.
            if self.run(between, &[]).is_none() && self.problem.room(&self.ring) < -NEARLY_KEPT {
                self.slow_down()?;
            }
        }
        Some(self.speed())
    }

    /// Tightens limits where these peaks exceed them and searches on; `None` if nothing is worth it.
    pub(super) fn again(&mut self, between: &PeakSearch<'_>, peaks: &[Peaks]) -> Option<SquareSpeed> {
        if !self.problem.tighten(&self.ring, peaks, 1.0) {
            return None;
        }
        self.widen(AGAIN_AT);
        self.run(between, &[])?;
        Some(self.speed())
    }

    /// Slows the start of the problem down until it keeps every limit.
    fn slow_down(&mut self) -> Option<()> {
        self.coefficients.copy_from_slice(&self.problem.begin);
        for _ in 0..MAX_SLOWDOWNS {
            self.ring.set(&self.coefficients);
            if self.problem.room(&self.ring) > SPARE {
                return Some(());
            }
            self.coefficients.iter_mut().for_each(|coefficient| *coefficient *= SLOWDOWN);
        }
        None
    }
}

#[inline(always)]
fn add_row(to: &mut [f64; 4], row: [f64; 4]) {
    for (to, from) in to.iter_mut().zip(row) {
        *to += from;
    }
}

/// Adds to the Newton matrix, upper half (0,0) (0,1) (0,2) (1,1) (1,2) (2,2), and to its right side.
#[inline(always)]
fn add(h: &mut [Lanes; 6], g: &mut [Lanes; 3], slope: &LaneWeights, weight: Lanes, pull: Lanes) {
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
