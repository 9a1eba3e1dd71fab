//! The fastest turn of a lobe, over and over again.

use super::envelope::Envelope;
use super::peaks::{PROVEN, PeakSearch, Peaks, Reach};
use super::square_speed::{SquareSample, SquareSpeed};
use super::table::LimitTable;
use super::time_optimal::{Problem, Search};
use super::turn_request::{TurnError, TurnRequest};
use crate::machine::description::Axis;
use crate::math::hermite::{Knot, quintic};
use crate::math::units::{TURN_RAD, rad_from_deg, wrap_turn};
use crate::motion::cut_motion::chain;
use alloc::vec::Vec;

/// Knots in the time in which C's acceleration changes from nothing to its limit.
const KNOTS_PER_CHANGE: f64 = 4.0;

/// Widest spacing of knots: the path of a cam changes over some degrees.
const WIDEST_DEG: f64 = 1.5;

/// Shortest time between knots (s): below it a turn would have tens of thousands.
const SHORTEST_STEP_S: f64 = 2e-4;

/// Excess of the square of the speed for which a search goes on. A smaller one slows the whole turn down by half of that, which keeps
/// every limit as well: the peaks of the search are part of the excess by which a turn is slowed down in the end.
const AGAIN: f64 = 1.001;

/// Rounds in which intervals are held tighter where something peaked between their points.
const MORE_ROUNDS: u32 = 3;

/// Refinement of the check against the knots: beside a corner of the bound the remaining error is 3e-5.
const CHECK_FACTOR: u32 = 16;

/// Up to which share of the bound that is expected in an interval, in z, the speed there is not looked at more closely.
const FAR_FROM_BOUND: f64 = 0.95;

/// C's speed over one turn, periodic, near the fastest that keeps every limit.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnSpeed {
    speed: SquareSpeed,
    /// Time since the first knot, at every knot and once more after the turn (s).
    times: Vec<f64>,
    min_s: f64,
}

/// Speed and acceleration of C at a path angle (rad, s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurnPoint {
    /// Ċ (rad/s).
    pub speed: f64,
    /// C̈ (rad/s²).
    pub acceleration: f64,
}

impl TurnSpeed {
    /// The fastest turn that keeps the limits. Checked afterwards on a grid sixteen times finer than its own, as the quintic
    /// in time that drives the axes, wherever that is not proven by hulls, and slowed down by what is found there.
    ///
    /// # Errors
    /// A bound or a limit that is not a positive number.
    pub fn fastest(request: &TurnRequest<'_>) -> Result<Self, TurnError> {
        for (axis, limits) in [(Axis::C, &request.c), (Axis::X, &request.x)] {
            let is_good = |limit: f64| limit.is_finite() && limit > 0.0;
            if ![limits.velocity, limits.acceleration, limits.jerk].into_iter().all(is_good) {
                return Err(TurnError::BadLimit { axis });
            }
        }
        let table = LimitTable::new(request)?;
        let envelope = Envelope::new(table.per_bounds(), &request.c);
        let change_s = request.c.acceleration / request.c.jerk;
        let step_s = (change_s / KNOTS_PER_CHANGE).max(SHORTEST_STEP_S);
        let knots = envelope.knots(request, step_s, rad_from_deg(WIDEST_DEG));
        let between = PeakSearch::new(request, &table, &knots);
        #[allow(clippy::cast_possible_truncation, reason = "some ten intervals")]
        let round = libm::ceil(2.0 * change_s / step_s) as usize;
        let mut search = Search::new(Problem::new(request, &envelope, &between, knots, round));
        let mut fastest = search.fastest(&between).ok_or(TurnError::NoStart)?;
        let mut peaks = between.peaks(&fastest);
        for _ in 0..MORE_ROUNDS {
            let worst = peaks.iter().copied().fold(Peaks::default(), Peaks::larger).excess();
            if worst < AGAIN {
                break;
            }
            let Some(again) = search.again(&between, &peaks) else { break };
            fastest = again;
            peaks = between.peaks(&fastest);
        }
        let turn = Self::from_square(fastest, envelope.minimum_s());
        // What is left is little. A slower turn runs through the same positions at other times: every use falls with the scale of z
        // as it should, and nothing has to be looked at again.
        let worst = peaks.into_iter().fold(turn.used_in_time(request, between.reach()), Peaks::larger).excess();
        Ok(if worst > 1.0 { turn.slower(worst * (1.0 + 1e-9)) } else { turn })
    }

    fn from_square(speed: SquareSpeed, min_s: f64) -> Self {
        let n = speed.knots().count();
        let mut times = Vec::with_capacity(n + 1);
        let mut at = 0.0;
        for i in 0..n {
            times.push(at);
            at += speed.time_across(i);
        }
        times.push(at);
        Self { speed, times, min_s }
    }

    /// The same turn with every limit used less by this factor, of acceleration at least.
    pub(super) fn slower(mut self, factor: f64) -> Self {
        self.speed.scale(1.0 / factor);
        Self::from_square(self.speed, self.min_s)
    }

    /// Time of a turn (s).
    #[must_use]
    pub fn turn_s(&self) -> f64 {
        self.times[self.times.len() - 1]
    }

    /// Knots over the turn.
    pub(super) fn knots_of_turn(&self) -> usize {
        self.times.len() - 1
    }

    /// A time below which no plan can be, whatever its jerk and whatever X does (s).
    #[must_use]
    pub fn minimum_s(&self) -> f64 {
        self.min_s
    }

    /// Slowest and fastest (rad/s).
    #[must_use]
    pub fn range_rad_s(&self) -> (f64, f64) {
        let speeds = (0..self.times.len() - 1).map(|i| libm::sqrt(self.speed.within(i, 0.0).z));
        speeds.fold((f64::INFINITY, 0.0), |(low, high), speed| (f64::min(low, speed), f64::max(high, speed)))
    }

    /// Speed and acceleration at a path angle.
    #[must_use]
    pub fn at(&self, angle_rad: f64) -> TurnPoint {
        let s = self.square_at(angle_rad);
        TurnPoint { speed: libm::sqrt(s.z), acceleration: 0.5 * s.first }
    }

    fn square_at(&self, angle_rad: f64) -> SquareSample {
        let (interval, u) = self.speed.knots().find(wrap_turn(angle_rad));
        self.speed.within(interval, u)
    }

    /// Knots of C over time for some turns from a path angle on: value 0 there, angles counted from there. The first is at
    /// the first knot of the turn after `from`, the last at the last before `to` (rad since the start), times so that the
    /// first is at 0.
    pub(super) fn knots(&self, start_rad: f64, from: f64, to: f64) -> Vec<Knot> {
        let n = self.times.len() - 1;
        let turn_s = self.turn_s();
        // Turns of path angle: the start lies in turn 0.
        let start = wrap_turn(start_rad);
        let mut knots: Vec<Knot> = Vec::new();
        let mut first_s = 0.0;
        #[allow(clippy::cast_possible_truncation, reason = "some thousand turns")]
        let turns = libm::ceil((start + to) / TURN_RAD) as u32;
        for turn in 0..=turns {
            for i in 0..n {
                let value = self.speed.knots().at(i) + f64::from(turn) * TURN_RAD - start;
                if value < from || value > to {
                    continue;
                }
                let at = f64::from(turn) * turn_s + self.times[i];
                if knots.is_empty() {
                    first_s = at;
                }
                let here = self.speed.within(i, 0.0);
                let (first, second) = (libm::sqrt(here.z), 0.5 * here.first);
                knots.push(Knot { at: at - first_s, value, first, second });
            }
        }
        knots
    }

    /// Largest utilisation of the limits by the quintics in time, on a grid finer than the knots, or upper bounds of it.
    ///
    /// - A hull up to `PROVEN`, or up to what was found before, is recorded as the use. The turn is slowed down by the largest recorded
    ///   use, so the true use, which is below its hull, ends below 1.
    /// - The hull of the bound holds only as far as the bound is known between the points of the table. It therefore counts only below
    ///   `FAR_FROM_BOUND`, also where those points show a flat bound: a notch may reach above it between two of them.
    /// - Bound and path vary over the angle. Intervals wider than `WIDEST_DEG`, which exist where X stays far from its limits, get
    ///   points at the same angles as the widest others. C's own quantities are polynomials of the interval, whatever its width.
    fn used_in_time(&self, request: &TurnRequest<'_>, reach: &[Reach]) -> Peaks {
        let knots = self.knots(0.0, 0.0, 2.0 * TURN_RAD);
        let mut found = Peaks::default();
        for (pair, reach) in knots.windows(2).zip(reach) {
            let hull = within_hull(&pair[0], &pair[1], request, reach);
            let is_proven = |hull: f64, found: &mut f64| {
                let is_low = hull <= PROVEN.max(*found);
                if is_low && hull > 1.0 {
                    *found = found.max(hull);
                }
                is_low
            };
            let is_c_free =
                is_proven(hull.c_acceleration, &mut found.c_acceleration) & is_proven(hull.c_jerk, &mut found.c_jerk);
            let is_x_free =
                is_proven(hull.x_acceleration, &mut found.x_acceleration) & is_proven(hull.x_jerk, &mut found.x_jerk);
            let is_bound_free = hull.bound <= FAR_FROM_BOUND;
            if is_c_free && is_x_free && is_bound_free {
                continue;
            }
            let parts = f64::from(CHECK_FACTOR) * ((pair[1].value - pair[0].value) / rad_from_deg(WIDEST_DEG)).max(1.0);
            #[allow(clippy::cast_possible_truncation, reason = "some ten parts")]
            let parts = libm::ceil(parts) as u32;
            for k in 0..parts {
                let at = pair[0].at + (pair[1].at - pair[0].at) * f64::from(k) / f64::from(parts);
                let c = quintic(&pair[0], &pair[1], at);
                found.c_acceleration = found.c_acceleration.max(c.second.abs() / request.c.acceleration);
                found.c_jerk = found.c_jerk.max(c.third.abs() / request.c.jerk);
                if is_x_free && is_bound_free {
                    continue;
                }
                let path = request.path.sample(c.value);
                if !is_bound_free {
                    found.bound = found.bound.max(c.first * c.first * request.per_square_bound(c.value, path));
                }
                if !is_x_free {
                    let x = chain(request.with_infeed(path), c);
                    found.x_acceleration = found.x_acceleration.max(x.second.abs() / request.x.acceleration);
                    found.x_jerk = found.x_jerk.max(x.third.abs() / request.x.jerk);
                }
            }
        }
        found
    }
}

/// Upper bound of the utilisation by the quintic between two knots: its derivatives lie within the hulls of their control points.
fn within_hull(left: &Knot, right: &Knot, request: &TurnRequest<'_>, reach: &Reach) -> Peaks {
    let h = right.at - left.at;
    let (v0, v1) = (left.first, left.first + 0.25 * h * left.second);
    let (v3, v4) = (right.first - 0.25 * h * right.second, right.first);
    // The mean of the control points is the mean speed.
    let v = [v0, v1, 5.0 * (right.value - left.value) / h - (v0 + v1 + v3 + v4), v3, v4];
    let a: [f64; 4] = core::array::from_fn(|i| 4.0 / h * (v[i + 1] - v[i]));
    let j: [f64; 3] = core::array::from_fn(|i| 3.0 / h * (a[i + 1] - a[i]));
    let largest = |values: &[f64]| values.iter().fold(0.0, |max, value| f64::max(max, value.abs()));
    let (v, a, j) = (largest(&v), largest(&a), largest(&j));
    let [x1, x2, x3] = reach.x;
    Peaks {
        bound: v * v * reach.expected_per_bound(),
        c_acceleration: a / request.c.acceleration,
        c_jerk: j / request.c.jerk,
        x_acceleration: (x2 * v * v + x1 * a) / request.x.acceleration,
        x_jerk: (x3 * v * v * v + 3.0 * x2 * v * a + x1 * j) / request.x.jerk,
    }
}
