// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Joins a trajectory from an axis that rests near its first point.
//!
//! Clients plan from measured positions, and an axis that has just moved is still settling on its setpoint. The
//! difference between setpoint and first point fades out on the way: d(t) = e·(1 − 10u³ + 15u⁴ − 6u⁵), u = t/T. A
//! quintic plus a quintic is a quintic, so after T the path and its times are exactly the client's. Where the path
//! leaves no room in the limits, the axes first move to its first point and follow it that much later.

use super::trajectory_limits::{TrajectoryError, check_limits};
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription, MotionLimits};
use crate::math::hermite::{HermiteSpline, Knot};
use alloc::vec::Vec;

/// Longest time in which a trajectory is joined (s).
pub const MAX_JOIN_S: f64 = 0.5;
/// Share of the limits that the fading difference may take at first; where the path leaves less, it fades longer.
const GENTLE_SHARE: f64 = 0.1;
/// Share of the limits of a move to the first point, as of other moves.
const MOVE_SHARE: f64 = 0.9;
/// Factor from one trial of the time to the next.
const LONGER: f64 = 1.3;
/// Two knots are at least this far apart (s).
const KNOT_DISTANCE_S: f64 = 1e-6;

/// Largest distance of each axis from the first point of its trajectory (mm or rad); 0: the same count.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StartTolerance(pub [f64; AXIS_COUNT]);

/// Law of an axis from its first point on, and the setpoint less that point where they differ.
pub(super) struct AxisLaw {
    pub(super) axis: Axis,
    pub(super) law: HermiteSpline,
    pub(super) difference: f64,
}

/// Laws that begin at the setpoints, with their largest derivatives.
pub(super) fn all(
    all: &[AxisLaw],
    machine: &MachineDescription,
) -> Result<Vec<(Axis, HermiteSpline, MotionLimits)>, TrajectoryError> {
    let limits = |axis: Axis| &machine.axis(axis).limits;
    let mut joined = Vec::with_capacity(all.len());
    let mut refused = None;
    for AxisLaw { axis, law, difference } in all {
        let plain = check_limits(*axis, law, machine)?;
        if *difference == 0.0 {
            joined.push((*axis, law.clone(), plain));
            continue;
        }
        let mut found = None;
        for time_s in times_s(*difference, limits(*axis), law.end() - law.start()) {
            let Some(law) = faded(law, *difference, time_s) else { continue };
            match check_limits(*axis, &law, machine) {
                Ok(peaks) => {
                    found = Some((*axis, law, peaks));
                    break;
                }
                Err(error) => refused = Some(error),
            }
        }
        joined.extend(found);
    }
    let Some(error) = refused.filter(|_| joined.len() < all.len()) else { return Ok(joined) };
    // No room beside the path: to its first point, and then along it.
    let mut time_s: f64 = 0.0;
    for AxisLaw { axis, law, difference } in all {
        let first = law.knots()[0];
        let own_s = move_s(*difference, limits(*axis)).filter(|_| first.first == 0.0 && first.second == 0.0);
        let Some(own_s) = own_s else { return Err(error) };
        time_s = time_s.max(own_s);
    }
    let later = |AxisLaw { axis, law, difference }: &AxisLaw| {
        let law = after_move(law, law.knots()[0].value + difference, time_s).ok_or_else(|| error.clone())?;
        let peaks = check_limits(*axis, &law, machine)?;
        Ok((*axis, law, peaks))
    };
    all.iter().map(later).collect()
}

/// Shortest time in which a difference fades within a share of the limits (s).
fn shortest_s(difference: f64, limits: &MotionLimits, share: f64) -> f64 {
    // Largest derivatives of the quintic from 1 to 0 in unit time.
    const PEAKS: [f64; 3] = [1.875, 5.773_502_691_896_258, 60.0];
    let size = libm::fabs(difference) / share;
    let by_velocity = PEAKS[0] * size / limits.velocity;
    let by_acceleration = libm::sqrt(PEAKS[1] * size / limits.acceleration);
    let by_jerk = libm::cbrt(PEAKS[2] * size / limits.jerk);
    by_velocity.max(by_acceleration).max(by_jerk)
}

/// Times to try, the gentlest use of the limits that is soon over first.
fn times_s(difference: f64, limits: &MotionLimits, duration_s: f64) -> impl Iterator<Item = f64> {
    let longest = duration_s.min(MAX_JOIN_S);
    let first = shortest_s(difference, limits, GENTLE_SHARE);
    core::iter::successors(Some(first), |time_s| Some(time_s * LONGER))
        .take_while(move |time_s| *time_s < longest)
        .chain([longest])
}

/// Time of a move of its own to the first point (s); `None` where it would take too long.
pub(super) fn move_s(difference: f64, limits: &MotionLimits) -> Option<f64> {
    Some(shortest_s(difference, limits, MOVE_SHARE)).filter(|time_s| *time_s <= MAX_JOIN_S)
}

/// The law with a difference that fades out within a time of its first knot.
fn faded(law: &HermiteSpline, difference: f64, time_s: f64) -> Option<HermiteSpline> {
    let start = law.start();
    // Not a hair beside a knot that is there already.
    let near = |knot: &&Knot| libm::fabs(knot.at - start - time_s) < KNOT_DISTANCE_S;
    let end = law.knots().iter().skip(1).find(near).map_or(start + time_s, |knot| knot.at);
    let fade = |knot: &Knot| {
        let u = ((knot.at - start) / (end - start)).clamp(0.0, 1.0);
        let (w, length) = (1.0 - u, end - start);
        Knot {
            at: knot.at,
            value: knot.value + difference * (w * w * w * (1.0 + u * (3.0 + 6.0 * u))),
            first: knot.first - difference * 30.0 * u * u * w * w / length,
            second: knot.second - difference * 60.0 * u * w * (1.0 - 2.0 * u) / (length * length),
        }
    };
    let before = law.knots().iter().filter(|knot| knot.at < end).map(fade);
    let mut knots: Vec<Knot> = before.collect();
    let after = law.knots().iter().filter(|knot| knot.at >= end);
    if law.knots().iter().all(|knot| knot.at.total_cmp(&end).is_ne()) {
        let at = law.sample(end);
        knots.push(Knot { at: end, value: at.value, first: at.first, second: at.second });
    }
    knots.extend(after);
    HermiteSpline::new(knots).ok()
}

/// The law that much later, from rest at a position.
fn after_move(law: &HermiteSpline, from: f64, time_s: f64) -> Option<HermiteSpline> {
    let rest = Knot { at: law.start(), value: from, first: 0.0, second: 0.0 };
    let later = law.knots().iter().map(|knot| Knot { at: knot.at + time_s, ..*knot });
    HermiteSpline::new(core::iter::once(rest).chain(later).collect()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_difference_fades_without_a_step_and_the_rest_of_the_law_is_the_same() {
        let knot = |at: f64, value: f64, first: f64| Knot { at, value, first, second: 0.3 * value };
        let knots: Vec<Knot> =
            (0..20).map(|i| f64::from(i) * 0.07).map(|t| knot(t, libm::sin(t), libm::cos(t))).collect();
        let law = HermiteSpline::new(knots).expect("a law");
        for time_s in [0.05, 0.07, 0.070_000_01, 0.3] {
            let joined = faded(&law, 0.25, time_s).expect("a law");
            assert!((joined.sample(0.0).value - law.sample(0.0).value - 0.25).abs() < 1e-15);
            for i in 0..1300 {
                let t = f64::from(i) * 1e-3;
                let u = (t / time_s).min(1.0);
                let fade = 0.25 * (1.0 - u * u * u * (10.0 - 15.0 * u + 6.0 * u * u));
                let (is, plain) = (joined.sample(t), law.sample(t));
                assert!((is.value - plain.value - fade).abs() < 1e-6, "{time_s} {t}");
                if t > time_s + 1e-6 {
                    assert!((is.value - plain.value).abs() < 1e-12 && (is.first - plain.first).abs() < 1e-9);
                }
            }
        }
    }
}
