// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The shortest change of path time that keeps the limits.
//!
//! A hold, an override and their end change the rate r at which plan time τ passes, from one value in 0..1 to another, by
//! a quintic smoothstep over a fixed length. Position p(τ) then has the acceleration r²p″ + ṙp′ and the jerk
//! r³p‴ + 3rṙp″ + r̈p′. The longest change is the stop, from 1 to 0, but it is not always the worst one: half-way down, a
//! change from 1 to ½ still has most of the path's own jerk.

use crate::machine::description::MotionLimits;
use crate::math::differences::largest_exact_derivatives;
use crate::math::twofold::Twofold;
use crate::motion::cut_motion::{CutMotion, ExactCut};
use crate::motion::path_stop::{rate_step, rate_step_area, rate_step_bend, rate_step_slope};
use alloc::vec::Vec;

/// Longest stop tried (s).
pub(super) const LONGEST_S: f64 = 10.0;

/// Shortest stop tried (ticks): below it a tick is no longer fine against the smoothstep.
const SHORTEST_TICKS: u64 = 16;

/// Points per turn of the path, points within a change, and rates between which changes are tried. Paths change over tens
/// of degrees and the smoothstep over quarters of its length; the differenced check looks between them.
const POINTS_PER_TURN: f64 = 720.0;
const WITHIN: u32 = 32;
const RATES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// Share of the limits the search aims at, so that the finer check passes.
const SHARE: f64 = 0.99;

/// Rate and its derivatives by the share of the change.
#[derive(Clone, Copy)]
struct Rate {
    rate: f64,
    first: f64,
    second: f64,
}

/// Every rate that a change may have on its way, with its derivatives.
fn rates() -> Vec<Rate> {
    let mut rates = Vec::with_capacity(RATES.len() * RATES.len() * (WITHIN as usize + 1));
    for from in RATES {
        for to in RATES.into_iter().filter(|to| (to - from).abs() > 0.1) {
            rates.extend((0..=WITHIN).map(|i| {
                let u = f64::from(i) / f64::from(WITHIN);
                Rate {
                    rate: from + (to - from) * rate_step(u),
                    first: (to - from) * rate_step_slope(u),
                    second: (to - from) * rate_step_bend(u),
                }
            }));
        }
    }
    rates
}

/// Ticks of the shortest stop that keeps both axes' limits from every point of a cut, and over which every other change
/// of rate keeps them too; `None` beyond [`LONGEST_S`].
///
/// Since a change may begin anywhere, every point of the path meets every rate: the two are independent.
pub(super) fn shortest(
    motion: &CutMotion<'_>,
    windows: &[(f64, f64)],
    turn_s: f64,
    cycle_time_s: f64,
    limits: [&MotionLimits; 2],
) -> Option<u64> {
    let points = derivatives(motion, windows, turn_s / POINTS_PER_TURN);
    let rates = rates();
    let seconds = |ticks: u64| ticks as f64 * cycle_time_s;
    let keeps = |ticks: u64| keeps_limits(&points, &rates, seconds(ticks), limits);
    let mut high = SHORTEST_TICKS;
    while !keeps(high) {
        high *= 2;
        if seconds(high) > LONGEST_S {
            return None;
        }
    }
    let mut low = (high / 2).max(SHORTEST_TICKS - 1);
    while high - low > 1 + high / 64 {
        let middle = low + (high - low) / 2;
        if keeps(middle) { high = middle } else { low = middle }
    }
    // What slipped between the points of the grid costs a somewhat longer stop, not a defect.
    while !passes_check(motion, seconds(high), turn_s, limits) {
        high += 1 + high / 16;
        if seconds(high) > LONGEST_S {
            return None;
        }
    }
    Some(high)
}

/// Velocity, acceleration and jerk of C and X all over the windows.
fn derivatives(motion: &CutMotion<'_>, windows: &[(f64, f64)], step: f64) -> Vec<[[f64; 3]; 2]> {
    let mut points = Vec::new();
    for (from, to) in windows {
        #[allow(clippy::cast_possible_truncation, reason = "some turns of some hundred points")]
        let count = libm::ceil((to - from) / step) as u32;
        points.extend((0..=count).map(|k| {
            let s = motion.at((from + f64::from(k) * step).min(*to));
            [[s.c.first, s.c.second, s.c.third], [s.x.first, s.x.second, s.x.third]]
        }));
    }
    points
}

fn keeps_limits(points: &[[[f64; 3]; 2]], rates: &[Rate], stop_s: f64, limits: [&MotionLimits; 2]) -> bool {
    let bounds = limits.map(|l| (SHARE * l.acceleration, SHARE * l.jerk));
    rates.iter().all(|r| {
        let (first, second) = (r.first / stop_s, r.second / (stop_s * stop_s));
        let (square, cube, mixed) = (r.rate * r.rate, r.rate * r.rate * r.rate, 3.0 * r.rate * first);
        points.iter().all(|point| {
            point.iter().zip(bounds).all(|([v, a, j], (acceleration, jerk))| {
                (square * a + first * v).abs() <= acceleration && (cube * j + mixed * a + second * v).abs() <= jerk
            })
        })
    })
}

/// Differences the positions of stops, and of their reverse, that begin all over the first and last turns.
fn passes_check(motion: &CutMotion<'_>, stop_s: f64, turn_s: f64, limits: [&MotionLimits; 2]) -> bool {
    let (begin, end) = (motion.start_s(), motion.end_s());
    let step = (stop_s / 512.0).max(1e-5);
    // The turns that a cut begins and ends with, and what is before and after them where C turns on.
    let first_turns = (2.0 * turn_s + (-begin).max(0.0)).min(end - begin);
    // A golden-section sequence falls between the points of any grid.
    (0..192_u32).all(|k| {
        let share = f64::from(k) * 0.618_033_988_749_894_9;
        let into = (share - libm::floor(share)) * first_turns;
        let start = if k % 2 == 0 { begin + into } else { end - into };
        let time = |t: Twofold| {
            let u = (t.value() / stop_s).clamp(0.0, 1.0);
            let advanced = if k % 4 < 2 { u - rate_step_area(u) } else { rate_step_area(u) };
            Twofold::sum(start, stop_s * advanced)
        };
        let mut exact = ExactCut::new(motion);
        let (from, to) = (Twofold::from(0.0), Twofold::from(stop_s));
        let found = largest_exact_derivatives(|t| exact.at(time(t)), from, to, step);
        found
            .iter()
            .zip(limits)
            .all(|(extremes, limit)| extremes[1].value <= limit.acceleration && extremes[2].value <= limit.jerk)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rates lie in 0..1, and their derivatives agree with differences of the rates themselves.
    #[test]
    fn the_rates_of_changes_agree_with_their_derivatives() {
        let per_change = WITHIN as usize + 1;
        let rates = rates();
        assert_eq!(rates.len(), 20 * per_change);
        let h = 1.0 / f64::from(WITHIN);
        for change in rates.chunks(per_change) {
            for w in change.windows(3) {
                assert!((0.0..=1.0).contains(&w[1].rate));
                assert!(((w[2].rate - w[0].rate) / (2.0 * h) - w[1].first).abs() < 0.02);
                assert!(((w[2].first - w[0].first) / (2.0 * h) - w[1].second).abs() < 0.12);
            }
        }
    }
}
