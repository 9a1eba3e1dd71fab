// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! X onto a path that moves, and off it again, while C turns at one speed: lead-in and lead-out.
//!
//! ```text
//!  X  ────.                             .────   rests where the table may move
//!          \                           /        the way beside the path: jerk-limited, from the velocity and
//!           \_   path of the lobe   __/         acceleration that the path has against a wheel at rest, to none
//!             ~~\____/~~\____/~~\__/
//!        lead-in │      cut        │ lead-out   C turns all the time
//! ```
//!
//! A way that begins T before the cut must take just T. Its length depends on where the path is then, so T is searched for.

use crate::machine::description::MotionLimits;
use crate::math::hermite::{HermiteSpline, Knot, Sample};
use crate::math::periodic_spline::PeriodicSpline;
use crate::motion::cut_motion::chain;
use crate::motion::point_to_point::{MOVE_SHARE, solve};
use alloc::vec::Vec;

/// C turns before a cut, or after it, with X at rest away from the part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlyingStart {
    /// Speed of C (rad/s).
    pub speed_rad_s: f64,
    /// Rest position of X (mm).
    pub clear_x_mm: f64,
    /// Speed of X against the path (mm/s).
    pub rapid_mm_s: f64,
}

/// Share of X's limits that a path may use at one speed of C for a lead to go with it.
pub const LEAD_PATH_SHARE: f64 = 0.5;

/// Step of the search for the length of a lead, and its longest (s).
const STEP_S: f64 = 2e-3;
const LONGEST_S: f64 = 20.0;

/// Points of a way that are looked at.
const POINTS: u32 = 256;

/// Rounding tolerance of a move below the path (mm).
const ROUNDING_MM: f64 = 1e-9;

/// The largest speed of C at which a path uses no more than [`LEAD_PATH_SHARE`] of X's limits all round (rad/s).
#[must_use]
pub fn largest_lead_speed_rad_s(path: &PeriodicSpline, x: &MotionLimits) -> f64 {
    let peaks = peaks(path);
    let largest = |limit: f64, peak: f64| if peak > 0.0 { LEAD_PATH_SHARE * limit / peak } else { f64::INFINITY };
    largest(x.velocity, peaks.first)
        .min(libm::sqrt(largest(x.acceleration, peaks.second)))
        .min(libm::cbrt(largest(x.jerk, peaks.third)))
}

/// Largest derivatives of a path by the angle.
fn peaks(path: &PeriodicSpline) -> Sample {
    path.samples(2).iter().fold(Sample::default(), |max, x| Sample {
        value: 0.0,
        first: max.first.max(x.first.abs()),
        second: max.second.max(x.second.abs()),
        third: max.third.max(x.third.abs()),
    })
}

/// Limits of X that remain beside a path at constant speed; `None` if the path exceeds its share.
pub(super) fn beside(path: &PeriodicSpline, x: &MotionLimits, turning: &FlyingStart) -> Option<MotionLimits> {
    let w = turning.speed_rad_s;
    if w > largest_lead_speed_rad_s(path, x) * (1.0 + 1e-9) {
        return None;
    }
    let peaks = peaks(path);
    Some(MotionLimits {
        velocity: turning.rapid_mm_s.min(x.velocity - peaks.first * w),
        acceleration: MOVE_SHARE * x.acceleration - peaks.second * w * w,
        jerk: MOVE_SHARE * x.jerk - peaks.third * w * w * w,
    })
}

/// Length of the lead-in onto a path from a path angle on, above it by so much (mm); `None` if there is none (s).
#[must_use]
pub fn shortest_lead_s(
    path: &PeriodicSpline,
    path_rad: f64,
    above_mm: f64,
    turning: &FlyingStart,
    x: &MotionLimits,
) -> Option<f64> {
    let limits = beside(path, x, turning)?;
    let along = |angle: f64| {
        let x = path.sample(path_rad + angle);
        Sample { value: x.value + above_mm, ..x }
    };
    Some(-lead_in(turning, &limits, along)?[0].at)
}

/// The shortest lead-in: distance of X from what it must follow over the time before 0 (mm over s), 0 at time 0. `along` gives
/// X over the angle of C before and at 0 (mm over rad); `limits` are those of the way beside the path.
pub(super) fn lead_in(
    turning: &FlyingStart,
    limits: &MotionLimits,
    along: impl Fn(f64) -> Sample,
) -> Option<Vec<Knot>> {
    let w = turning.speed_rad_s;
    // Beginning so long before, the way there against the path.
    let way = |before_s: f64| {
        let angle = Sample { value: -w * before_s, first: w, second: 0.0, third: 0.0 };
        let x = chain(along(angle.value), angle);
        let from_mm = turning.clear_x_mm - x.value;
        (from_mm, solve(-from_mm, -x.first, -x.second, 0.0, limits).shifted(from_mm))
    };
    let late_s = |before_s: f64| way(before_s).1.duration() - before_s;
    let mut low_s = 0.0;
    let mut high_s = STEP_S;
    while high_s < LONGEST_S {
        if late_s(low_s) > 0.0 && late_s(high_s) <= 0.0 {
            let (mut low, mut high) = (low_s, high_s);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if late_s(middle) > 0.0 { low = middle } else { high = middle }
            }
            let (from_mm, law) = way(high);
            let is_above = (0..POINTS)
                .all(|i| law.sample(law.duration() * f64::from(i) / f64::from(POINTS)).value >= -ROUNDING_MM);
            // Where the length jumps over the time there is, the two do not meet.
            if from_mm > 0.0 && is_above && (law.duration() - high).abs() < 1e-9 {
                return law.to_spline().ok().map(|way| before_zero(&way));
            }
        }
        low_s = high_s;
        high_s += STEP_S;
    }
    None
}

/// A way that ends at 0, at time 0.
fn before_zero(way: &HermiteSpline) -> Vec<Knot> {
    let mut knots: Vec<Knot> = way.knots().iter().map(|knot| Knot { at: knot.at - way.end(), ..*knot }).collect();
    if let Some(last) = knots.last_mut() {
        *last = ON_PATH;
    }
    knots
}

/// X follows the path.
pub(super) const ON_PATH: Knot = Knot { at: 0.0, value: 0.0, first: 0.0, second: 0.0 };

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::speed_plan::tests::{C, X, eccentric};

    fn turning(speed_rad_s: f64) -> FlyingStart {
        FlyingStart { speed_rad_s, clear_x_mm: 60.0, rapid_mm_s: 100.0 }
    }

    /// A path that does not move is met like any target: the lead is a move from rest to rest.
    #[test]
    fn onto_a_circle_a_lead_is_a_move_from_rest_to_rest() {
        let limits = MotionLimits { velocity: 100.0, ..X.with_share(MOVE_SHARE) };
        let along = |_| Sample { value: 20.0, ..Sample::default() };
        let lead = lead_in(&turning(6.0), &limits, along).expect("it can be met");
        let law = crate::motion::point_to_point::rest_to_rest(40.0, &limits).expect("a move");
        assert!((lead[0].at + law.end()).abs() < 1e-9, "{} {}", lead[0].at, law.end());
        assert!((lead[0].value - 40.0).abs() < 1e-9 && lead[0].first.abs() < 1e-12);
    }

    /// The wheel rests until the lead begins and is on the path when it ends, with the path's own velocity and acceleration, and
    /// on the way neither dips below the path nor uses more than its limits, wherever the cut begins.
    #[test]
    fn a_lead_joins_rest_and_moving_path_within_the_limits() {
        let path = eccentric(30.0, 4.2);
        assert!(largest_lead_speed_rad_s(&path, &X) > C.velocity);
        for w in [2.0, 6.0, 20.0] {
            let turning = turning(w);
            let limits = beside(&path, &X, &turning).expect("it leaves room");
            for step in 0..36_u32 {
                let start = f64::from(step) * crate::math::units::TURN_RAD / 36.0;
                let along = |angle: f64| path.sample(start + angle);
                let lead = lead_in(&turning, &limits, along).expect("it can be met");
                let begin_s = lead[0].at;
                let lead = HermiteSpline::new(lead).expect("its knots increase");
                let x_at = |t: f64| {
                    let angle = Sample { value: w * t, first: w, second: 0.0, third: 0.0 };
                    crate::motion::cut_motion::sum(chain(along(w * t), angle), lead.sample(t))
                };
                let rest = x_at(begin_s);
                assert!((rest.value - 60.0).abs() < 1e-9, "{rest:?}");
                assert!(rest.first.abs() < 1e-6 && rest.second.abs() < 1e-3, "{rest:?}");
                for i in 1..1000 {
                    let t = begin_s * f64::from(i) / 1000.0;
                    let x = x_at(t);
                    assert!(lead.sample(t).value >= -1e-9);
                    assert!(x.first.abs() <= X.velocity && x.second.abs() <= 0.901 * X.acceleration);
                    assert!(x.third.abs() <= 0.901 * X.jerk, "{x:?}");
                }
            }
        }
    }

    #[test]
    fn a_wheel_that_rests_below_the_path_has_no_lead() {
        let limits = MotionLimits { velocity: 100.0, ..X };
        let below = FlyingStart { clear_x_mm: 10.0, ..turning(6.0) };
        assert!(lead_in(&below, &limits, |_| Sample { value: 20.0, ..Sample::default() }).is_none());
    }
}
