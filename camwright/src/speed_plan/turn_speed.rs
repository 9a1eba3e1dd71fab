//! The fastest turn of a lobe, over and over again.

use super::envelope::Envelope;
use super::square_speed::{SquareSample, SquareSpeed, to_f64};
use super::time_optimal::{Peaks, Problem, solve};
use super::turn_request::TurnRequest;
use crate::cut_motion::chain;
use crate::machine::description::Axis;
use crate::numeric::hermite::{Knot, quintic};
use crate::units::{TURN_RAD, rad_from_deg, wrap_turn};
use alloc::vec::Vec;
use thiserror::Error;

/// Points on which the bound of the process is looked at, at least; and how many for each interval of the path, which has
/// the more of them the narrower the notches are that a concave flank makes in the bound.
const ENVELOPE_POINTS: usize = 3600;
const PER_PATH_INTERVAL: usize = 1;

/// Knots in the time in which C's acceleration changes from nothing to its limit.
const KNOTS_PER_CHANGE: f64 = 4.0;

/// Widest spacing of knots: the path of a cam changes over some degrees.
const WIDEST_DEG: f64 = 1.5;

/// Shortest time between knots (s): below it a turn would have tens of thousands.
const SHORTEST_STEP_S: f64 = 2e-4;

/// Rounds in which intervals are held tighter where something peaked between their points, and the share of the time that
/// such a round may win back.
const MORE_ROUNDS: u32 = 3;
const AGAIN: f64 = 0.1;

/// Fewest points between two knots that are looked at for peaks; where the path has its own knots denser, two for each.
const LEAST_BETWEEN: f64 = 8.0;

/// From which share of its limit on the jerk of X is looked at between those points too, and into how many parts they are
/// divided: third derivatives of a path are parabolas between its knots.
const NEAR_JERK: f64 = 0.7;
const PARTS: u32 = 8;

/// How much finer than the knots limits are checked: beside a corner of the bound the rest is 3e-5.
const CHECK_FACTOR: u32 = 16;

/// C's speed over one turn, periodic, near the fastest that keeps every limit.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnSpeed {
    speed: SquareSpeed,
    /// Time since the first knot, at every knot and once more after the turn (s).
    times: Vec<f64>,
    least_s: f64,
}

/// Why there is no turn.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TurnError {
    /// The process allows no speed somewhere.
    #[error(
        "the speed law allows {speed_rad_s:.3} rad/s at {angle_deg:.1} deg of the path; it must be a number above 0"
    )]
    NoSpeed {
        /// Where.
        angle_deg: f64,
        /// What the law of the process gives there (rad/s).
        speed_rad_s: f64,
    },
    /// The path is so rough that X cannot follow it at any speed worth the name.
    #[error("no speed keeps the limits of x_axis on this path")]
    NoStart,
    /// A limit is not a positive number.
    #[error("{} has a limit that is not a number above 0", .axis.joint())]
    BadLimit {
        /// Whose.
        axis: Axis,
    },
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
    /// in time that drives the axes, and slowed down by what is found there.
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
        let points = ENVELOPE_POINTS.max(PER_PATH_INTERVAL * request.path.coefficients().len());
        let envelope = Envelope::new(request, points)?;
        let change_s = request.c.acceleration / request.c.jerk;
        let step_s = (change_s / KNOTS_PER_CHANGE).max(SHORTEST_STEP_S);
        let knots = envelope.knots(step_s, rad_from_deg(WIDEST_DEG));
        let mut problem = Problem::new(request, &envelope, knots);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some ten intervals")]
        let round = libm::ceil(2.0 * change_s / step_s) as usize;
        let mut fastest = solve(&problem, problem.start(round), 1.0).ok_or(TurnError::NoStart)?;
        for _ in 0..MORE_ROUNDS {
            if !problem.tighten(&peaks(request, &fastest)) {
                break;
            }
            fastest = solve(&problem, fastest.coefficients().to_vec(), AGAIN).ok_or(TurnError::NoStart)?;
        }
        let mut turn = Self::from_square(fastest, envelope.least_s());
        // What is left is little; the last time proves it.
        for _ in 0..4 {
            let excess = turn.excess(request).max(envelope.excess(|angle| turn.square_at(angle).z));
            let between = peaks(request, &turn.speed).into_iter().fold(excess, |excess, peak| {
                let jerk = libm::cbrt(peak.c_jerk.max(peak.x_jerk));
                excess.max(peak.bound).max(peak.x_acceleration).max(jerk * jerk)
            });
            let excess = excess.max(between);
            if excess <= 1.0 {
                break;
            }
            turn.speed.scale(1.0 / (excess * (1.0 + 1e-12)));
            turn = Self::from_square(turn.speed, turn.least_s);
        }
        Ok(turn)
    }

    fn from_square(speed: SquareSpeed, least_s: f64) -> Self {
        let n = speed.knots().count();
        let mut times = Vec::with_capacity(n + 1);
        let mut at = 0.0;
        for i in 0..n {
            times.push(at);
            at += speed.time_across(i);
        }
        times.push(at);
        Self { speed, times, least_s }
    }

    /// The same turn with every limit used less by this factor, of acceleration at least.
    pub(super) fn slower(mut self, factor: f64) -> Self {
        self.speed.scale(1.0 / factor);
        Self::from_square(self.speed, self.least_s)
    }

    /// Time of a turn (s).
    #[must_use]
    pub fn turn_s(&self) -> f64 {
        self.times[self.times.len() - 1]
    }

    /// A time below which no plan can be, whatever its jerk and whatever X does (s).
    #[must_use]
    pub fn least_s(&self) -> f64 {
        self.least_s
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
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some thousand turns")]
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

    /// Largest factor by which z is beyond what the limits allow, on a grid finer than the knots.
    fn excess(&self, request: &TurnRequest<'_>) -> f64 {
        let knots = self.knots(0.0, 0.0, 2.0 * TURN_RAD);
        let n = self.times.len() - 1;
        let mut excess = 0.0_f64;
        for pair in knots.windows(2).take(n) {
            for k in 0..CHECK_FACTOR {
                let at = pair[0].at + (pair[1].at - pair[0].at) * f64::from(k) / f64::from(CHECK_FACTOR);
                let c = quintic(&pair[0], &pair[1], at);
                let over_angle = request.over_angle(c.value);
                let x = chain(over_angle, c);
                excess = excess.max(c.first * c.first * request.per_square_bound(c.value, over_angle.first));
                for (sample, limits) in [(c, &request.c), (x, &request.x)] {
                    let jerk = libm::cbrt(sample.third.abs() / limits.jerk);
                    excess = excess.max(sample.second.abs() / limits.acceleration).max(jerk * jerk);
                }
            }
        }
        excess
    }
}

/// What peaks in each interval of a plan, on a grid finer than its knots and than those of the path; where jerk comes near its
/// limit, finer still.
fn peaks(request: &TurnRequest<'_>, speed: &SquareSpeed) -> Vec<Peaks> {
    let per_rad = 2.0 * to_f64(request.path.coefficients().len()) / TURN_RAD;
    let knots = speed.knots();
    let in_interval = |i: usize| {
        let length = knots.length(i);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some dozen points")]
        let count = libm::ceil(length * per_rad).max(LEAST_BETWEEN) as u32;
        let mut found = Peaks { bound: 0.0, x_acceleration: 0.0, c_jerk: 0.0, x_jerk: 0.0 };
        let mut look = |u: f64, with_bound: bool| {
            let angle = knots.at(i) + u * length;
            let (s, x) = (speed.within(i, u), request.over_angle(angle));
            let root = libm::sqrt(s.z);
            let x_acceleration = (x.second * s.z + 0.5 * x.first * s.first).abs() / request.x.acceleration;
            let x_jerk = root * (x.third * s.z + 1.5 * x.second * s.first + 0.5 * x.first * s.second).abs();
            found.x_acceleration = found.x_acceleration.max(x_acceleration);
            found.c_jerk = found.c_jerk.max(0.5 * root * s.second.abs() / request.c.jerk);
            found.x_jerk = found.x_jerk.max(x_jerk / request.x.jerk);
            if with_bound {
                found.bound = found.bound.max(s.z * request.per_square_bound(angle, x.first));
            }
            x_jerk / request.x.jerk
        };
        let mut before = 0.0;
        for k in 0..=count {
            let u = f64::from(k) / f64::from(count);
            let here = look(u, k.is_multiple_of(2) || k == count);
            if k > 0 && f64::max(before, here) > NEAR_JERK {
                for part in 1..PARTS {
                    look(u - f64::from(part) / f64::from(PARTS * count), false);
                }
            }
            before = here;
        }
        found
    };
    (0..knots.count()).map(in_interval).collect()
}
