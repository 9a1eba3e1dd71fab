// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The fastest turn of a lobe, over and over again.

use super::envelope::Envelope;
use super::in_time::uses_in_time;
use super::peaks::{PeakSearch, Peaks};
use super::square_speed::{SquareSample, SquareSpeed};
use super::table::LimitTable;
use super::time_optimal::{Problem, Search};
use super::turn_request::{TurnError, TurnRequest};
use crate::machine::description::Axis;
use crate::math::hermite::Knot;
use crate::math::units::{TURN_RAD, rad_from_deg, wrap_turn};
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
    /// The fastest turn that keeps the limits, over the angle and as the quintics in time that drive the axes: slowed down by what
    /// their proofs find.
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
        let in_time = uses_in_time(&turn.knots(0.0, 0.0, 2.0 * TURN_RAD), &turn.speed, &between, &peaks);
        let worst = peaks.into_iter().fold(in_time, Peaks::larger).excess();
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
}
