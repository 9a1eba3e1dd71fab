// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A cut whose way of X over C is known as a whole: C from rest to rest, at one speed on the way, as fast as wanted or as X can.

use super::limit_use::{LimitUse, uses_by_differences};
use super::{
    CHECK_FACTOR, LimitViolation, PATH_SHARE, PLANNING_GRID, RAMP_SHARES, SHORTEST_CHECK_STEP_S, SpeedPlanError,
    between, ramp, stop,
};
use crate::machine::description::MotionLimits;
use crate::math::hermite::HermiteSpline;
use crate::math::periodic_spline::PeriodicSpline;
use crate::math::units::TURN_RAD;
use crate::motion::cut_motion::CutMotion;

#[derive(Debug, Clone, Copy)]
pub(crate) struct FixedPathRequest<'a> {
    /// Base of the way (mm over rad).
    pub(crate) path: &'a PeriodicSpline,
    /// Addition over the angle since the start (mm over rad).
    pub(crate) offset: &'a HermiteSpline,
    pub(crate) turns: u32,
    /// Largest speed of C wanted (rad/s).
    pub(crate) max_rad_s: f64,
    pub(crate) c: MotionLimits,
    pub(crate) x: MotionLimits,
    /// Interpolation period (s).
    pub(crate) cycle_time_s: f64,
}

/// C over time for it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FixedPathSpeed {
    pub(crate) law: HermiteSpline,
    pub(crate) plateau_s: (f64, f64),
    pub(crate) turn_s: f64,
    pub(crate) stop_ticks: u64,
    pub(crate) speed_rad_s: f64,
}

/// Times that a speed is lowered by [`SLOWER`] before the way is given up: to a hundredth of what was wanted.
const MAX_ATTEMPTS: u32 = 45;
const SLOWER: f64 = 0.9;

impl FixedPathSpeed {
    /// The speed wanted, or the largest below it, in steps of a tenth, at which both axes keep their limits.
    ///
    /// # Errors
    /// No such speed down to a hundredth of that, no room for the ramps, no stop.
    pub(crate) fn new(request: &FixedPathRequest<'_>) -> Result<Self, SpeedPlanError> {
        let mut speed_rad_s = request.max_rad_s.min(request.c.velocity);
        let mut exceeded = None;
        for _ in 0..MAX_ATTEMPTS {
            match request.at(speed_rad_s)? {
                Ok(found) => return Ok(found),
                Err(worst) => exceeded = Some(worst),
            }
            speed_rad_s *= SLOWER;
        }
        let no_stop = SpeedPlanError::NoStop { longest_s: stop::LONGEST_S };
        Err(exceeded.map_or(no_stop, |worst| SpeedPlanError::TooFast {
            work_speed_rad_s: speed_rad_s,
            worst,
            largest_rad_s: None,
        }))
    }
}

impl FixedPathRequest<'_> {
    /// At one speed: the law, or the limit that it breaks.
    fn at(&self, speed_rad_s: f64) -> Result<Result<FixedPathSpeed, LimitUse>, SpeedPlanError> {
        let total_rad = f64::from(self.turns) * TURN_RAD;
        let limits = MotionLimits { velocity: self.c.velocity.max(speed_rad_s), ..self.c.with_share(RAMP_SHARES[1]) };
        let up = ramp(0.0, speed_rad_s, &limits).map_err(|misfit| match misfit {
            LimitViolation::Ramp(error) => SpeedPlanError::Ramp(error),
            _ => SpeedPlanError::NoStop { longest_s: stop::LONGEST_S },
        })?;
        let ramps_rad = 2.0 * up[up.len() - 1].value;
        if ramps_rad > total_rad - TURN_RAD {
            let ramps_deg = crate::math::units::deg_from_rad(ramps_rad);
            let (work_speed_rad_s, turns) = (speed_rad_s, self.turns);
            return Err(SpeedPlanError::NoPlateau { work_speed_rad_s, ramps_deg, turns, largest_rad_s: None });
        }
        let too_long = |duration_s| {
            let (turns, max_s) = (self.turns, super::MAX_CUT_S);
            Err(SpeedPlanError::TooLong { turns, duration_s, max_s })
        };
        let way_s = total_rad / speed_rad_s;
        if way_s.is_nan() || way_s > super::MAX_CUT_S {
            return too_long(way_s);
        }
        let Ok((law, plateau_s)) = between(&up, &up, speed_rad_s, total_rad) else {
            return too_long(way_s);
        };
        let motion =
            CutMotion { path: self.path, path_start_rad: 0.0, infeed: self.offset, ratio: None, lead: None, law: &law };
        let (turn_s, stretches) = (TURN_RAD / speed_rad_s, [(law.start(), law.end())]);
        let step = (turn_s / PLANNING_GRID as f64 / CHECK_FACTOR).max(SHORTEST_CHECK_STEP_S);
        let path_limits = |limits: MotionLimits| limits.with_share(PATH_SHARE);
        let found = uses_by_differences(&motion, &stretches, step, &path_limits(self.c), &path_limits(self.x));
        if let Some(exceeded) = found.into_iter().find(|found| found.ratio() > 1.0) {
            return Ok(Err(exceeded));
        }
        let stop_ticks = stop::shortest(&motion, &stretches, turn_s, self.cycle_time_s, [&self.c, &self.x])
            .ok_or(SpeedPlanError::NoStop { longest_s: stop::LONGEST_S })?;
        Ok(Ok(FixedPathSpeed { law: law.clone(), plateau_s, turn_s, stop_ticks, speed_rad_s }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hermite::Knot;
    use alloc::vec;

    const X: MotionLimits = MotionLimits { velocity: 500.0, acceleration: 1e4, jerk: 1e6 };
    const C: MotionLimits = MotionLimits { velocity: 31.0, acceleration: 300.0, jerk: 3e4 };

    /// A quintic step over an angle a: peaks of the third derivative over C are 60 h/a³, and the jerk of X that with ω³.
    #[test]
    fn the_way_is_gone_at_the_speed_wanted_or_as_fast_as_x_can() {
        let path = PeriodicSpline::from_coefficients(vec![20.0; 8]).expect("a circle");
        let still = |at: f64, value: f64| Knot { at, value, first: 0.0, second: 0.0 };
        let (height_mm, angle) = (1.0, 0.5);
        let offset = HermiteSpline::new(vec![
            still(0.0, height_mm),
            still(TURN_RAD, height_mm),
            still(TURN_RAD + angle, 0.0),
            still(2.0 * TURN_RAD, 0.0),
            still(3.0 * TURN_RAD, height_mm),
        ])
        .expect("a way");
        let request = |max_rad_s: f64| FixedPathRequest {
            path: &path,
            offset: &offset,
            turns: 3,
            max_rad_s,
            c: C,
            x: X,
            cycle_time_s: 1e-3,
        };
        let largest = (PATH_SHARE * X.jerk * angle * angle * angle / (60.0 * height_mm)).cbrt();
        let slow = FixedPathSpeed::new(&request(0.5 * largest)).expect("slow enough");
        assert!((slow.speed_rad_s - 0.5 * largest).abs() < 1e-12);
        let fast = FixedPathSpeed::new(&request(20.0)).expect("slower will do");
        assert!(fast.speed_rad_s <= largest && fast.speed_rad_s > 0.89 * largest, "{} {largest}", fast.speed_rad_s);
        assert!((fast.law.sample(fast.law.end()).value - 3.0 * TURN_RAD).abs() < 1e-9);
        assert!(fast.stop_ticks > 0);
    }

    #[test]
    fn a_way_that_no_speed_makes_possible_is_refused() {
        let path = PeriodicSpline::from_coefficients(vec![20.0; 8]).expect("a circle");
        let still = |at: f64, value: f64| Knot { at, value, first: 0.0, second: 0.0 };
        let offset = HermiteSpline::new(vec![still(0.0, 5.0), still(6.0, 5.0), still(6.001, 0.0), still(13.0, 0.0)]);
        let offset = offset.expect("a way");
        let request =
            FixedPathRequest { path: &path, offset: &offset, turns: 3, max_rad_s: 6.0, c: C, x: X, cycle_time_s: 1e-3 };
        assert!(matches!(FixedPathSpeed::new(&request), Err(SpeedPlanError::TooFast { .. })));
    }
}
