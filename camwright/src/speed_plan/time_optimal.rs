//! The fastest turn that keeps every limit: velocity, acceleration and jerk of C and of X, and a bound on C's speed.
//!
//! Unknowns are the coefficients of z = Ċ² over the path angle (see [`super::square_speed`]). Time ∫dφ/√z is convex in
//! them, and every limit is linear but those of jerk: |z″/2| ≤ j/√z. Their right side is convex, so its tangent lies below
//! it and a step that keeps the tangent keeps the limit. A primal-dual interior point method with these tangents goes from
//! one plan that keeps every limit to the next, faster one; its Newton matrix is a cyclic band of two neighbours. The
//! problem is not convex: what is found is the best nearby.

use super::envelope::Envelope;
use super::peaks::Peaks;
use super::square_speed::{Knots, SquareSpeed, Weights, to_f64};
use super::turn_request::TurnRequest;
use crate::machine::description::MotionLimits;
use crate::numeric::banded::CyclicBand;
use crate::numeric::hermite::Sample;
use alloc::vec;
use alloc::vec::Vec;

/// Where within an interval limits are held, as shares of it. The last belongs to the next interval too; only jerk jumps there.
const SHARES: [f64; 3] = [0.0, 0.5, 1.0];

/// Simpson's rule over them.
const SIMPSON: [f64; 3] = [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0];

/// Limits of one interval: at the first two points the bound and X acceleration (2); at the first C acceleration (2); C jerk
/// at the ends (2 each), X jerk at all three (2 each).
const ROOMS: usize = 2 * (1 + 2) + 2 + 2 * 2 + 3 * 2;

/// Share of the turn's time by which it may still be improved nearby when the search ends.
const GAP: f64 = 5e-4;

/// Iterations after which the search ends with what it has: a plan that keeps its limits in any case.
const MOST_ITERATIONS: usize = 100;

/// Slowdowns of the plan that a search begins with: of a first one 10⁻²⁸ of the speed of the envelope in all.
const MOST_SLOWDOWNS: u32 = 400;

/// How a search begins.
pub(super) struct Begin {
    /// Factor of each slowdown, in z.
    slowdown: f64,
    /// Room that every limit is left then, as a share of it.
    spare: f64,
    /// Share of the turn's time that may be won.
    far: f64,
}

impl Begin {
    /// With next to nothing known.
    pub(super) const COLD: Begin = Begin { slowdown: 0.85, spare: 0.1, far: 1.0 };

    /// With a plan that was the fastest under limits a little wider.
    pub(super) const WARM: Begin = Begin { slowdown: 0.995, spare: 0.002, far: 0.005 };
}

/// How much of a Newton step has to be taken before the next one aims nearer to the limits, and by which factor.
const TAKEN: f64 = 0.6;
const NEARER: f64 = 0.3;

/// A peak between points by which it is worth while to plan again; a smaller one slows the whole turn down by as much.
const WORTH_IT: f64 = 1.0005;

/// To begin with; jerk of X keeps a thousandth for what peaks between the points that are looked at.
const LOOSE: Peaks = Peaks { bound: 1.0, c_acceleration: 1.0, x_acceleration: 1.0, c_jerk: 1.0, x_jerk: 1.001 };

/// What one interval knows.
struct Interval {
    length: f64,
    /// Weights of z and z′ at the points, and of z″.
    z: [Weights; 3],
    first: [Weights; 3],
    second: Weights,
    /// X′, X″, X‴ over the limits of X, at the points.
    x: [[f64; 3]; 3],
    /// X″ and X′ over the jerk limit of X.
    x_jerk: [[f64; 2]; 3],
    /// 1/bound² at the first two points.
    per_bound: [f64; 2],
    /// Factors on what is held at the points, for what happens between them.
    tight: Peaks,
    /// Scale that brings the limits of jerk to the order of 1: √z as expected here.
    root: f64,
}

/// A limit at a point: what is left to it, and how that changes with the interval's three coefficients.
#[derive(Clone, Copy)]
struct Room {
    left: f64,
    slope: Weights,
}

fn dot(w: &Weights, c: &Weights) -> f64 {
    w[0] * c[0] + w[1] * c[1] + w[2] * c[2]
}

/// a·u + b·v.
fn mix(a: f64, u: &Weights, b: f64, v: &Weights) -> Weights {
    [a * u[0] + b * v[0], a * u[1] + b * v[1], a * u[2] + b * v[2]]
}

/// The plan that is being improved, with the room it leaves to every limit and the price of that.
struct Iterate {
    coefficients: Vec<f64>,
    rooms: Vec<[Room; ROOMS]>,
    prices: Vec<[f64; ROOMS]>,
}

/// The limits of a turn on given knots.
pub(super) struct Problem {
    knots: Knots,
    intervals: Vec<Interval>,
    c: MotionLimits,
}

impl Problem {
    pub(super) fn new(request: &TurnRequest<'_>, envelope: &Envelope, knots: Knots) -> Self {
        let at_knots: Vec<Sample> = (0..knots.count()).map(|i| request.path.sample(knots.at(i))).collect();
        let intervals = (0..knots.count())
            .map(|i| {
                let (begin, length) = (knots.at(i), knots.length(i));
                let weights = SHARES.map(|u| knots.weights(i, u));
                let path = [at_knots[i], request.path.sample(begin + SHARES[1] * length), at_knots[knots.beside(i).1]];
                let per_bound = [0, 1].map(|k| request.per_square_bound(begin + SHARES[k] * length, path[k]));
                let path = path.map(|path| request.with_infeed(path));
                Interval {
                    length,
                    z: weights.map(|w| w[0]),
                    first: weights.map(|w| w[1]),
                    second: weights[0][2],
                    x: path.map(|x| {
                        let limits = request.x;
                        [0.5 * x.first / limits.acceleration, x.second / limits.acceleration, x.third / limits.jerk]
                    }),
                    x_jerk: path.map(|x| [0.5 * x.first / request.x.jerk, 1.5 * x.second / request.x.jerk]),
                    per_bound,
                    tight: LOOSE,
                    root: libm::sqrt(envelope.square_at(begin + 0.5 * length)),
                }
            })
            .collect();
        Self { knots, intervals, c: request.c }
    }

    fn around(&self, values: &[f64], interval: usize) -> Weights {
        let (before, after) = self.knots.beside(interval);
        [values[before], values[interval], values[after]]
    }

    /// Every limit of an interval.
    #[inline]
    fn rooms(&self, interval: &Interval, c: &Weights) -> [Room; ROOMS] {
        let mut rooms = [Room { left: 0.0, slope: [0.0; 3] }; ROOMS];
        let mut count = 0;
        let mut put = |left: f64, slope: Weights| {
            rooms[count] = Room { left, slope };
            count += 1;
        };
        let second = dot(&interval.second, c);
        for k in 0..3 {
            let (z, first) = (dot(&interval.z[k], c), dot(&interval.first[k], c));
            let mut both = |right: f64, right_slope: f64, value: f64, slope: Weights| {
                put(right - value, mix(right_slope, &interval.z[k], -1.0, &slope));
                put(right + value, mix(right_slope, &interval.z[k], 1.0, &slope));
            };
            let [x1, x2, x3] = interval.x[k];
            if k < 2 {
                let (x1, x2) = (x1 * interval.tight.x_acceleration, x2 * interval.tight.x_acceleration);
                both(1.0, 0.0, x2 * z + x1 * first, mix(x2, &interval.z[k], x1, &interval.first[k]));
            }
            if k == 0 {
                let per = 0.5 / self.c.acceleration;
                both(1.0, 0.0, per * first, mix(per, &interval.first[k], 0.0, &interval.first[k]));
            }
            // Limits of jerk times root: root/√z ∓ root·z″/(2j) ≥ 0, by the tangent of the first term.
            let right = interval.root / libm::sqrt(z);
            let right_slope = -0.5 * right / z;
            if k != 1 {
                let per = interval.root * interval.tight.c_jerk * 0.5 / self.c.jerk;
                both(right, right_slope, per * second, mix(per, &interval.second, 0.0, &interval.second));
            }
            let [j1, j2] = interval.x_jerk[k];
            let root = interval.root * interval.tight.x_jerk;
            let value = root * (x3 * z + j2 * first + j1 * second);
            let outer = mix(root * x3, &interval.z[k], root * j2, &interval.first[k]);
            both(right, right_slope, value, mix(1.0, &outer, root * j1, &interval.second));
            if k < 2 {
                let per = interval.per_bound[k] * interval.tight.bound;
                put(1.0 - per * z, mix(-per, &interval.z[k], 0.0, &interval.z[k]));
            }
        }
        rooms
    }

    /// Every limit of every interval.
    fn all_rooms(&self, coefficients: &[f64]) -> Vec<[Room; ROOMS]> {
        let each = self.intervals.iter().enumerate();
        each.map(|(i, interval)| self.rooms(interval, &self.around(coefficients, i))).collect()
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

    /// Whether a plan keeps every limit with this much room to spare.
    fn keeps(&self, coefficients: &[f64], spare: f64) -> bool {
        self.intervals.iter().enumerate().all(|(i, interval)| {
            let c = self.around(coefficients, i);
            interval.z.iter().all(|w| dot(w, &c) > 0.0) && self.rooms(interval, &c).iter().all(|room| room.left > spare)
        })
    }

    /// Holds an interval tighter where something peaked between its points. Tells whether it did.
    pub(super) fn tighten(&mut self, peaks: &[Peaks]) -> bool {
        let mut is_tighter = false;
        for (interval, found) in self.intervals.iter_mut().zip(peaks) {
            let tight = &mut interval.tight;
            for (factor, ratio) in [
                (&mut tight.bound, found.bound),
                (&mut tight.x_acceleration, found.x_acceleration),
                (&mut tight.c_jerk, found.c_jerk),
                (&mut tight.x_jerk, found.x_jerk),
            ] {
                if ratio > WORTH_IT {
                    *factor *= ratio;
                    is_tighter = true;
                }
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
    fn slowed_down(&self, mut coefficients: Vec<f64>, begin: &Begin) -> Option<Vec<f64>> {
        for _ in 0..MOST_SLOWDOWNS {
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
pub(super) fn solve(problem: &Problem, from: Vec<f64>, begin: &Begin) -> Option<SquareSpeed> {
    let limits = to_f64(problem.knots.count() * ROOMS);
    let coefficients = problem.slowed_down(from, begin)?;
    let mut mu = begin.far * problem.time(&coefficients) / limits;
    let rooms = problem.all_rooms(&coefficients);
    let prices = rooms.iter().map(|rooms| rooms.map(|room| mu / room.left)).collect();
    let mut it = Iterate { coefficients, rooms, prices };
    for _ in 0..MOST_ITERATIONS {
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
const LEAST_ROOM: f64 = 1e-13;

/// How much of a Newton step was taken, and how far the plan was from the best nearby before it (s).
struct Stepped {
    primal: f64,
    dual: f64,
    gap: f64,
}

/// One Newton step towards the point of the central path at μ.
fn step(problem: &Problem, it: &mut Iterate, mu: f64) -> Option<Stepped> {
    let n = problem.knots.count();
    let mut band = CyclicBand::<3>::circulant(n, [0.0; 3]);
    let mut right = vec![0.0; n];
    let mut gap = 0.0;
    for (i, interval) in problem.intervals.iter().enumerate() {
        let c = problem.around(&it.coefficients, i);
        // Upper half: (0,0) (0,1) (0,2) (1,1) (1,2) (2,2).
        let (mut h, mut g) = ([0.0; 6], [0.0; 3]);
        for (w, part) in interval.z.iter().zip(SIMPSON) {
            let z = dot(w, &c);
            let per = part * interval.length / (z * libm::sqrt(z));
            add(&mut h, &mut g, w, 0.75 * per / z, 0.5 * per);
        }
        for (room, price) in it.rooms[i].iter().zip(&it.prices[i]) {
            let per = 1.0 / room.left.max(LEAST_ROOM);
            gap += price * room.left;
            add(&mut h, &mut g, &room.slope, price * per, mu * per);
        }
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
    let (mut primal, mut dual) = (1.0_f64, 1.0_f64);
    // Coefficients are the middle Bézier points of z: above 0 with both ends they keep it so in between.
    for (coefficient, along) in it.coefficients.iter().zip(&change) {
        if *along < 0.0 {
            primal = primal.min(-0.9 * coefficient / along);
        }
    }
    let mut price_changes = vec![[0.0; ROOMS]; n];
    for (i, interval) in problem.intervals.iter().enumerate() {
        let (c, moved) = (problem.around(&it.coefficients, i), problem.around(&change, i));
        for w in &interval.z {
            let (z, along) = (dot(w, &c), dot(w, &moved));
            if along < 0.0 {
                primal = primal.min(-0.9 * z / along);
            }
        }
        for ((room, price), new) in it.rooms[i].iter().zip(&it.prices[i]).zip(&mut price_changes[i]) {
            let along = dot(&room.slope, &moved);
            if along < 0.0 {
                primal = primal.min(-0.99 * room.left / along);
            }
            *new = (mu - price * along) / room.left.max(LEAST_ROOM) - price;
            if *new < 0.0 {
                dual = dual.min(-0.99 * price / *new);
            }
        }
    }
    for (coefficient, along) in it.coefficients.iter_mut().zip(&change) {
        *coefficient += primal * along;
    }
    for (prices, changes) in it.prices.iter_mut().zip(&price_changes) {
        for (price, along) in prices.iter_mut().zip(changes) {
            *price += dual * along;
        }
    }
    // Prices that have strayed from what the rooms now say hold the next steps back.
    it.rooms = problem.all_rooms(&it.coefficients);
    for (prices, rooms) in it.prices.iter_mut().zip(&it.rooms) {
        for (price, room) in prices.iter_mut().zip(rooms) {
            let central = mu / room.left.max(LEAST_ROOM);
            *price = price.clamp(central / ASTRAY, central * ASTRAY);
        }
    }
    Some(Stepped { primal, dual, gap })
}

fn add(h: &mut [f64; 6], g: &mut [f64; 3], slope: &Weights, weight: f64, pull: f64) {
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
