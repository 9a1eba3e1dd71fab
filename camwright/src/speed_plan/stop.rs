//! The shortest stop on the path: plan time runs at a rate r that falls from 1 to 0 by a quintic smoothstep, so that
//! position p(τ), τ' = r, gets the acceleration r²p'' + ṙp' and the jerk r³p''' + 3rṙp'' + r̈p'.

use crate::cut_motion::CutMotion;
use crate::machine::description::MotionLimits;
use crate::numeric::differences::largest_derivatives;
use crate::point_to_point::{JerkLaw, MOVE_SHARE};
use alloc::vec::Vec;

/// Longest stop tried (s).
pub(super) const LONGEST_S: f64 = 10.0;

/// Shortest stop tried (ticks): below it a tick is no longer fine against the smoothstep.
const SHORTEST_TICKS: u64 = 16;

/// Points per turn at which a stop may begin, and points within the stop. Paths change over tens of degrees and the
/// smoothstep over quarters of its length; the differenced check looks between them.
const STARTS_PER_TURN: f64 = 1440.0;
const WITHIN: u32 = 32;

/// Most starting points in all.
const MOST_STARTS: f64 = 200_000.0;

/// Share of the limits the search aims at, so that the finer check passes.
const SHARE: f64 = 0.99;

/// Rate and its derivatives by the share of the stop, and the share of its length by which plan time has advanced.
#[derive(Clone, Copy)]
struct Rate {
    rate: f64,
    first: f64,
    second: f64,
    advanced: f64,
}

impl Rate {
    /// At share `u` of the stop: r = 1 − (10u³ − 15u⁴ + 6u⁵).
    fn at(u: f64) -> Self {
        let (u2, u3) = (u * u, u * u * u);
        Self {
            rate: 1.0 - u3 * (10.0 + u * (-15.0 + 6.0 * u)),
            first: -30.0 * u2 * (1.0 - u) * (1.0 - u),
            second: -60.0 * u * (1.0 - u) * (1.0 - 2.0 * u),
            advanced: u - u3 * u * (2.5 + u * (-3.0 + u)),
        }
    }
}

/// Velocity, acceleration and jerk of each axis.
type Derivatives<const N: usize> = [[f64; 3]; N];

/// Ticks of the shortest stop that keeps both axes' limits from every point of a cut; `None` beyond [`LONGEST_S`].
pub(super) fn shortest(
    motion: &CutMotion<'_>,
    turn_s: f64,
    cycle_time_s: f64,
    c: &MotionLimits,
    x: &MotionLimits,
) -> Option<u64> {
    let duration = motion.duration_s();
    let count = (duration / turn_s * STARTS_PER_TURN).min(MOST_STARTS);
    let step = duration / count;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most MOST_STARTS")]
    let grid: Vec<Derivatives<2>> = (0..=count as u32)
        .map(|k| {
            let s = motion.at(f64::from(k) * step);
            [[s.c.first, s.c.second, s.c.third], [s.x.first, s.x.second, s.x.third]]
        })
        .collect();
    let mut ticks = search(&grid, step, cycle_time_s, [c, x])?;
    // What slipped between the points of the grid costs a somewhat longer stop, not a defect.
    while !passes_check(motion, seconds(ticks, cycle_time_s), turn_s, [c, x]) {
        ticks += 1 + ticks / 16;
        if seconds(ticks, cycle_time_s) > LONGEST_S {
            return None;
        }
    }
    Some(ticks)
}

/// Ticks of the shortest stop on a straight move that keeps the limits of its axes; `None` beyond [`LONGEST_S`].
///
/// `limits` are those with which the law was made, of which it used [`MOVE_SHARE`] in acceleration and jerk.
#[must_use]
pub fn shortest_on_line(law: &JerkLaw, limits: &MotionLimits, cycle_time_s: f64) -> Option<u64> {
    const POINTS: u32 = 2000;
    let step = law.duration() / f64::from(POINTS);
    let grid: Vec<Derivatives<1>> = (0..=POINTS)
        .map(|k| {
            let s = law.sample(f64::from(k) * step);
            [[s.first, s.second, s.third]]
        })
        .collect();
    if step <= 0.0 {
        return Some(0);
    }
    let whole =
        MotionLimits { acceleration: limits.acceleration / MOVE_SHARE, jerk: limits.jerk / MOVE_SHARE, ..*limits };
    search(&grid, step, cycle_time_s, [&whole])
}

#[allow(clippy::cast_precision_loss, reason = "a few thousand ticks")]
fn seconds(ticks: u64, cycle_time_s: f64) -> f64 {
    ticks as f64 * cycle_time_s
}

fn search<const N: usize>(
    grid: &[Derivatives<N>],
    step: f64,
    cycle_time_s: f64,
    limits: [&MotionLimits; N],
) -> Option<u64> {
    let rates: Vec<Rate> = (0..=WITHIN).map(|i| Rate::at(f64::from(i) / f64::from(WITHIN))).collect();
    let keeps = |ticks: u64| keeps_limits(grid, step, &rates, seconds(ticks, cycle_time_s), limits);
    let mut high = SHORTEST_TICKS;
    while !keeps(high) {
        high *= 2;
        if seconds(high, cycle_time_s) > LONGEST_S {
            return None;
        }
    }
    let mut low = (high / 2).max(SHORTEST_TICKS - 1);
    while high - low > 1 + high / 64 {
        let middle = low + (high - low) / 2;
        if keeps(middle) { high = middle } else { low = middle }
    }
    Some(high)
}

fn keeps_limits<const N: usize>(
    grid: &[Derivatives<N>],
    step: f64,
    rates: &[Rate],
    stop_s: f64,
    limits: [&MotionLimits; N],
) -> bool {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a stop of at most LONGEST_S")]
    let points: Vec<(usize, Rate)> = rates
        .iter()
        .map(|r| {
            let scaled = Rate { first: r.first / stop_s, second: r.second / (stop_s * stop_s), ..*r };
            (libm::round(r.advanced * stop_s / step) as usize, scaled)
        })
        .collect();
    let bounds = limits.map(|l| (SHARE * l.acceleration, SHARE * l.jerk));
    grid.iter().enumerate().all(|(start, _)| {
        points.iter().all(|(offset, r)| {
            // Beyond the end everything rests.
            grid.get(start + offset).is_none_or(|derivatives| {
                derivatives.iter().zip(bounds).all(|([v, a, j], (a_bound, j_bound))| {
                    let acceleration = r.rate * r.rate * a + r.first * v;
                    let jerk = r.rate * r.rate * r.rate * j + 3.0 * r.rate * r.first * a + r.second * v;
                    acceleration.abs() <= a_bound && jerk.abs() <= j_bound
                })
            })
        })
    })
}

/// Differences the positions of stops that begin all over the first and last turns.
fn passes_check(motion: &CutMotion<'_>, stop_s: f64, turn_s: f64, limits: [&MotionLimits; 2]) -> bool {
    let duration = motion.duration_s();
    let step = (stop_s / 512.0).max(1e-5);
    let first_turns = (2.0 * turn_s).min(duration);
    // A golden-section sequence falls between the points of any grid.
    (0..192_u32).all(|k| {
        let share = f64::from(k) * 0.618_033_988_749_894_9;
        let share = share - libm::floor(share);
        let into = share * first_turns;
        let start = if k % 2 == 0 { into } else { duration - into };
        let time = |t: f64| start + stop_s * Rate::at((t / stop_s).clamp(0.0, 1.0)).advanced;
        let c_at = |t: f64| motion.law.sample(time(t)).value;
        let found = [
            largest_derivatives(c_at, 0.0, stop_s, step),
            largest_derivatives(|t| motion.over_angle(c_at(t)).value, 0.0, stop_s, step),
        ];
        found
            .iter()
            .zip(limits)
            .all(|(extremes, limit)| extremes[1].value <= limit.acceleration && extremes[2].value <= limit.jerk)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rate's closed forms agree with each other: derivatives by differences, advance by summing.
    #[test]
    fn the_rate_agrees_with_its_derivatives_and_integral() {
        let h = 1e-5;
        let mut advanced = 0.0;
        for i in 0..100_000_u32 {
            let u = (f64::from(i) + 0.5) * h;
            let (left, middle, right) = (Rate::at(u - 0.5 * h), Rate::at(u), Rate::at(u + 0.5 * h));
            assert!(((right.rate - left.rate) / h - middle.first).abs() < 1e-6);
            assert!(((right.first - left.first) / h - middle.second).abs() < 1e-6);
            advanced += h * middle.rate;
            assert!((right.advanced - advanced).abs() < 1e-9);
        }
        assert!((Rate::at(1.0).advanced - 0.5).abs() < 1e-15);
    }
}
