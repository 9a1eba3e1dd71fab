// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Onto a turn whose speed varies, from rest or from another speed. A run-down is the same backwards.
//!
//! From rest two kinds are tried and the one that loses less time is taken. A single quintic in time onto a knot of the turn, with
//! its speed and acceleration, is short where X moves little. Elsewhere the turn itself is followed from its first angle on while the
//! rate of its time rises from 0 to 1: where a turn can be run, it can be run slower. From a speed it is a quintic.

use crate::machine::description::MotionLimits;
use crate::math::hermite::{Knot, Sample, quintic};
use crate::math::units::TURN_RAD;
use crate::motion::cut_motion::chain;
use crate::motion::path_stop::{rate_step, rate_step_area, rate_step_bend, rate_step_slope};
use alloc::vec::Vec;

pub(super) struct RunUp {
    /// The knot of the turn that it meets.
    pub(super) knot: usize,
    /// Its own knots from time 0 on, without the one it meets.
    pub(super) way: Vec<Knot>,
    /// Duration (s).
    pub(super) time_s: f64,
}

/// Points at which a ramp is looked at: few to see that it does not fit, many to see that it does.
const RAMP_POINTS: [u32; 2] = [24, 400];

/// Tried durations of a quintic, in multiples of its angle over the sum of its speeds; a run-up at constant acceleration takes 2.
const QUINTIC_FACTORS: [f64; 12] = [1.5, 1.6, 1.7, 1.8, 1.9, 2.0, 2.1, 2.2, 2.4, 2.6, 2.8, 3.2];

/// Knots of the turn tried beyond the first that a quintic can meet: a later one may cost less time.
const MORE_KNOTS: usize = 40;

/// Length of the shortest rise of the rate that is tried, as a share of the time of a turn, and the factor to the next.
const SHORTEST_RISE: f64 = 0.02;
const NEXT_RISE: f64 = 1.05;

/// Knots of a rising rate: fine against the changes of speed that it passes.
const RISE_KNOTS: u32 = 256;

/// Limits of a ramp.
struct RunUpBounds<A> {
    c: MotionLimits,
    x: MotionLimits,
    along: A,
}

impl<A: Fn(f64) -> (Sample, f64)> RunUpBounds<A> {
    /// Returns whether a ramp keeps the limits, given the angle by the share of its time.
    fn keeps(&self, angle_at: impl Fn(f64) -> Sample) -> bool {
        RAMP_POINTS.into_iter().all(|points| {
            (0..=points).all(|i| {
                let angle = angle_at(f64::from(i) / f64::from(points));
                let (over_angle, allowed) = (self.along)(angle.value);
                let moved = chain(over_angle, angle);
                let is_within = |sample: Sample, limits: &MotionLimits| {
                    sample.first.abs() <= limits.velocity
                        && sample.second.abs() <= limits.acceleration
                        && sample.third.abs() <= limits.jerk
                };
                angle.first >= -1e-9 && angle.first <= allowed && is_within(angle, &self.c) && is_within(moved, &self.x)
            })
        })
    }
}

/// The run-up from a speed (rad/s), or from rest, within limits that loses least time onto a turn given by its knots, angles since
/// the start. `along` gives X and the speed that the process allows over that angle.
pub(super) fn run_up(
    knots: &[Knot],
    from_rad_s: f64,
    c: MotionLimits,
    x: MotionLimits,
    along: impl Fn(f64) -> (Sample, f64),
) -> Option<RunUp> {
    let bounds = RunUpBounds { c, x, along };
    let first_turn = &knots[..knots.iter().position(|knot| knot.value > TURN_RAD).unwrap_or(knots.len())];
    let turn = FirstTurn::from(first_turn)?;
    let start = Knot { at: 0.0, value: 0.0, first: from_rad_s, second: 0.0 };
    let quintic = by_quintic(&turn, start, &bounds);
    if from_rad_s > 0.0 {
        return quintic;
    }
    let min_lost_s = quintic.as_ref().map_or(f64::INFINITY, |quintic| turn.lost_s(quintic));
    by_rising_rate(&turn, start, &bounds, min_lost_s).or(quintic)
}

/// The first turn from the start on.
struct FirstTurn<'a> {
    knots: &'a [Knot],
    /// Time at which its angle is 0 (s): the first knot lies a little later.
    zero_s: f64,
}

impl<'a> FirstTurn<'a> {
    fn from(knots: &'a [Knot]) -> Option<Self> {
        let (first, second) = (knots.first()?, knots.get(1)?);
        let mut zero_s = first.at;
        for _ in 0..3 {
            let here = quintic(first, second, zero_s);
            zero_s -= here.value / here.first;
        }
        Some(Self { knots, zero_s })
    }

    fn at(&self, time_s: f64) -> Sample {
        let next = self.knots.partition_point(|knot| knot.at <= time_s).clamp(1, self.knots.len() - 1);
        quintic(&self.knots[next - 1], &self.knots[next], time_s)
    }

    /// Time that a run-up loses against being at speed from the start (s).
    fn lost_s(&self, run_up: &RunUp) -> f64 {
        run_up.time_s - (self.knots[run_up.knot].at - self.zero_s)
    }
}

fn by_quintic<A: Fn(f64) -> (Sample, f64)>(
    turn: &FirstTurn<'_>,
    start: Knot,
    bounds: &RunUpBounds<A>,
) -> Option<RunUp> {
    let mut best: Option<(RunUp, f64)> = None;
    let mut left = usize::MAX;
    for (knot, target) in turn.knots.iter().enumerate().filter(|(_, knot)| knot.value > 1e-6) {
        if left == 0 {
            break;
        }
        left = left.saturating_sub(1);
        for factor in QUINTIC_FACTORS {
            let time_s = factor * target.value / (start.first + target.first);
            let found = RunUp { knot, way: alloc::vec![start], time_s };
            let lost_s = turn.lost_s(&found);
            let is_worse = best.as_ref().is_some_and(|(_, min_s)| lost_s >= *min_s);
            let to = Knot { at: time_s, ..*target };
            if is_worse || !bounds.keeps(|u| quintic(&start, &to, time_s * u)) {
                continue;
            }
            if best.is_none() {
                left = MORE_KNOTS;
            }
            best = Some((found, lost_s));
        }
    }
    best.map(|(run_up, _)| run_up)
}

/// The turn from its first angle on, at a rate that rises by a quintic smoothstep; if that loses less than `min_lost_s`.
fn by_rising_rate<A: Fn(f64) -> (Sample, f64)>(
    turn: &FirstTurn<'_>,
    rest: Knot,
    bounds: &RunUpBounds<A>,
    min_lost_s: f64,
) -> Option<RunUp> {
    let turn_s = turn.knots[turn.knots.len() - 1].at - turn.zero_s;
    let mut rise_s = SHORTEST_RISE * turn_s;
    // It passes half its time of the turn's, and loses the other half.
    while 0.5 * rise_s < turn_s && 0.5 * rise_s < min_lost_s {
        let knot = turn.knots.partition_point(|knot| knot.at < turn.zero_s + 0.5 * rise_s).min(turn.knots.len() - 1);
        let time_s = 2.0 * (turn.knots[knot].at - turn.zero_s);
        let angle_at = |u: f64| {
            let (rate, slope) = (rate_step(u), rate_step_slope(u) / time_s);
            let bend = rate_step_bend(u) / (time_s * time_s);
            let s = turn.at(turn.zero_s + time_s * rate_step_area(u));
            Sample {
                value: s.value,
                first: rate * s.first,
                second: rate * rate * s.second + slope * s.first,
                third: rate * rate * rate * s.third + 3.0 * rate * slope * s.second + bend * s.first,
            }
        };
        if 0.5 * time_s < min_lost_s && bounds.keeps(angle_at) {
            let rises = (1..RISE_KNOTS).map(|i| {
                let u = f64::from(i) / f64::from(RISE_KNOTS);
                let here = angle_at(u);
                Knot { at: time_s * u, value: here.value, first: here.first, second: here.second }
            });
            let way = [rest].into_iter().chain(rises).collect();
            return Some(RunUp { knot, way, time_s });
        }
        rise_s *= NEXT_RISE;
    }
    None
}
