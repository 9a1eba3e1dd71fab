// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Jerk-limited motion between two states: the moves of the axes that no part dictates.
//!
//! The fastest way from velocity v₀ to v₁ over a distance is two velocity ramps with a cruise at a peak velocity
//! between them; the distance grows with the peak velocity, so one bisection finds it. Everything is closed form but
//! that one number, nothing allocates, and only + − × ÷ √ are used, so the interpolator may solve within a tick and the
//! bits are the same on every machine. (`rsruckig` allocates and takes its cube roots from whatever mathematics library
//! its dependency tree selects; it is the oracle of the tests instead.)
//!
//! ```text
//!  v        ______
//!         /        \          phases:  ramp up (≤ 3) · cruise (≤ 1) · ramp down (≤ 3)
//!  v0 __/            \__ v1   constant jerk in each: cubics, which a quintic Hermite spline carries exactly
//! ```

use crate::machine::description::{AXIS_COUNT, MachineDescription, MotionLimits};
use crate::math::hermite::{HermiteError, HermiteSpline, Knot, Sample};
use crate::motion::plan::AxisTarget;
use alloc::vec::Vec;
use thiserror::Error;

/// Share of acceleration and jerk limits that a move uses. The rest lets the feed override change in the middle of a
/// move, and the tail of a chunk be interpolated from sparse samples, without exceeding a limit. It costs 5 % of the
/// time of a rapid move; at 0.95 the override would need two seconds to take effect.
pub const MOVE_SHARE: f64 = 0.9;

/// Why there is no move.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum PointToPointError {
    /// A limit is not a positive finite number.
    #[error("limits of a move must be positive: velocity {velocity}, acceleration {acceleration}, jerk {jerk}")]
    Limits { velocity: f64, acceleration: f64, jerk: f64 },
    /// A distance or velocity is not finite.
    #[error("a move needs finite numbers: distance {distance}, velocities {v0} and {v1}")]
    NotFinite {
        distance: f64,
        /// Velocity at the start.
        v0: f64,
        /// Velocity at the end.
        v1: f64,
    },
    /// A velocity at an end is beyond the limit.
    #[error("a move from velocity {v0} to {v1} exceeds its velocity limit {limit}")]
    EndVelocity {
        /// Velocity at the start.
        v0: f64,
        /// Velocity at the end.
        v1: f64,
        limit: f64,
    },
    /// The forward check found an exceeded limit or a missed target: a defect of the solver, reported before anything moves.
    #[error("a move over {distance} from velocity {v0} to {v1} failed its forward check")]
    Check {
        distance: f64,
        /// Velocity at the start.
        v0: f64,
        /// Velocity at the end.
        v1: f64,
    },
}

/// Position, velocity and acceleration at the beginning of a phase, and its jerk.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct JerkPhase {
    start: f64,
    x: f64,
    v: f64,
    a: f64,
    j: f64,
}

crate::snapshot!(JerkPhase { start, x, v, a, j } on {});

impl JerkPhase {
    fn at(&self, t: f64) -> Sample {
        let u = t - self.start;
        Sample {
            value: self.x + u * (self.v + u * (0.5 * self.a + u * self.j / 6.0)),
            first: self.v + u * (self.a + 0.5 * u * self.j),
            second: self.a + u * self.j,
            third: self.j,
        }
    }
}

const MAX_PHASES: usize = 8;

/// A motion of constant-jerk phases from a state to a state. Fixed size, so that it can be made within a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JerkLaw {
    phases: [JerkPhase; MAX_PHASES],
    count: usize,
    duration: f64,
    end: Sample,
}

crate::snapshot!(JerkLaw { phases, count, duration, end } on {} holds |law| {
    law.count <= MAX_PHASES => "a motion has more phases than there are",
});

impl Default for JerkLaw {
    /// It stays at 0.
    fn default() -> Self {
        Self::at_rest(0.0)
    }
}

impl JerkLaw {
    /// A law that stays where it is.
    #[must_use]
    pub fn at_rest(value: f64) -> Self {
        Self::starting(value, 0.0, 0.0)
    }

    fn starting(value: f64, first: f64, second: f64) -> Self {
        Self {
            phases: [JerkPhase::default(); MAX_PHASES],
            count: 0,
            duration: 0.0,
            end: Sample { value, first, second, third: 0.0 },
        }
    }

    fn push(&mut self, duration: f64, jerk: f64) {
        // Shorter phases than a femtosecond are rounding, and would make knots that coincide.
        if duration <= 1e-15 || self.count == MAX_PHASES {
            return;
        }
        let phase =
            JerkPhase { start: self.duration, x: self.end.value, v: self.end.first, a: self.end.second, j: jerk };
        self.phases[self.count] = phase;
        self.count += 1;
        self.duration += duration;
        self.end = Sample { third: 0.0, ..phase.at(self.duration) };
    }

    /// Appends the fastest change to velocity `v1` with acceleration 0.
    fn push_ramp(&mut self, v1: f64, limits: &MotionLimits) {
        let (v0, a0, j) = (self.end.first, self.end.second, limits.jerk);
        // Velocity reached by only taking the acceleration away: it decides which way to push.
        let direction = if v1 >= v0 + a0 * libm::fabs(a0) / (2.0 * j) { 1.0 } else { -1.0 };
        let (rise, along) = (direction * (v1 - v0), direction * a0);
        // An acceleration already beyond the limit (it cannot be, from our own laws) is kept, not jumped from.
        let bound = limits.acceleration.max(libm::fabs(a0));
        let peak = libm::sqrt((j * rise + 0.5 * along * along).max(0.0)).max(along).min(bound);
        let ramps = (2.0 * peak * peak - along * along) / (2.0 * j);
        let hold = if peak > 0.0 { ((rise - ramps) / peak).max(0.0) } else { 0.0 };
        self.push((peak - along) / j, direction * j);
        // Without an edge of its own the hold would be ulp-long where the peak is not cut off.
        if peak >= bound {
            self.end.second = direction * peak;
            self.push(hold, 0.0);
        }
        self.push(peak / j, -direction * j);
        self.end.first = v1;
        self.end.second = 0.0;
    }

    /// Duration (s).
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// The same law from another place.
    #[must_use]
    pub fn shifted(mut self, by: f64) -> Self {
        for phase in &mut self.phases[..self.count] {
            phase.x += by;
        }
        self.end.value += by;
        self
    }

    /// Value and derivatives at time `t` (s); constant before the start, uniform motion at the end velocity after it.
    #[must_use]
    pub fn sample(&self, t: f64) -> Sample {
        if t >= self.duration || self.count == 0 {
            let past = (t - self.duration).max(0.0);
            return Sample { value: self.end.value + past * self.end.first, ..self.end };
        }
        let phases = &self.phases[..self.count];
        let index = phases.partition_point(|phase| phase.start <= t);
        phases[index.saturating_sub(1)].at(t.max(0.0))
    }

    /// Largest speed and acceleration of the law.
    #[must_use]
    pub fn peaks(&self) -> (f64, f64) {
        let mut peaks = (libm::fabs(self.end.first), libm::fabs(self.end.second));
        for phase in &self.phases[..self.count] {
            peaks = (peaks.0.max(libm::fabs(phase.v)), peaks.1.max(libm::fabs(phase.a)));
        }
        peaks
    }

    /// The same law as a spline over time, knots at the phase boundaries.
    ///
    /// A law of no duration becomes a nanosecond of rest, since a spline needs two knots.
    ///
    /// # Errors
    /// Phases so long against others, or numbers so large, that floats do not hold them.
    pub fn to_spline(&self) -> Result<HermiteSpline, HermiteError> {
        let mut knots: Vec<Knot> = Vec::with_capacity(self.count + 1);
        for phase in &self.phases[..self.count] {
            // Over less than a microsecond the digits of the values no longer carry an acceleration (1e-13 mm / h²);
            // the neighbour takes such a phase over, and its acceleration errs by jerk times a microsecond.
            let apart = knots.last().is_none_or(|last| phase.start - last.at >= 1e-6);
            if apart && (knots.is_empty() || self.duration - phase.start >= 1e-6) {
                knots.push(Knot { at: phase.start, value: phase.x, first: phase.v, second: phase.a });
            }
        }
        let end = self.end;
        if knots.is_empty() {
            knots.push(Knot { at: 0.0, value: end.value, first: end.first, second: end.second });
        }
        let at = if self.count == 0 { 1e-9 } else { self.duration };
        knots.push(Knot { at, value: end.value, first: end.first, second: end.second });
        HermiteSpline::new(knots)
    }
}

/// The fastest stop from a velocity and an acceleration; its distance is whatever it takes.
#[must_use]
pub fn stop(value: f64, velocity: f64, acceleration: f64, limits: &MotionLimits) -> JerkLaw {
    let mut law = JerkLaw::starting(value, velocity, acceleration);
    law.push_ramp(0.0, limits);
    law
}

/// A motion over `distance` from velocity `v0` and acceleration `a0` to velocity `v1` and no acceleration.
///
/// Time optimal from and to rest, and whenever the peak velocity lies outside `v0..v1`; between them it touches
/// acceleration 0 once more than it must. Limits must be positive.
#[must_use]
pub fn solve(distance: f64, v0: f64, a0: f64, v1: f64, limits: &MotionLimits) -> JerkLaw {
    let through = |peak: f64, cruise: f64| {
        let mut law = JerkLaw::starting(0.0, v0, a0);
        law.push_ramp(peak, limits);
        law.push(cruise, 0.0);
        law.push_ramp(v1, limits);
        law
    };
    let covered = |peak: f64| through(peak, 0.0).end.value;
    let top = limits.velocity;
    let mut law = if distance >= covered(top) {
        through(top, (distance - covered(top)) / top)
    } else if distance <= covered(-top) {
        through(-top, (covered(-top) - distance) / top)
    } else {
        let eased = v0 + a0 * libm::fabs(a0) / (2.0 * limits.jerk);
        let (low, high) = (eased.min(v1).clamp(-top, top), eased.max(v1).clamp(-top, top));
        let (mut under, mut over) = if covered(high) <= distance {
            (high, top)
        } else if covered(low) >= distance {
            (-top, low)
        } else {
            (low, high)
        };
        // 80 halvings exhaust a double; the count is fixed so that the time of a tick is.
        for _ in 0..80 {
            let middle = 0.5 * (under + over);
            if covered(middle) <= distance {
                under = middle;
            } else {
                over = middle;
            }
        }
        through(under, 0.0)
    };
    law.end.value = distance;
    law
}

/// Checks a solved law forwards, from the phases' own end states: limits, continuity and target.
fn check(law: &JerkLaw, distance: f64, v0: f64, v1: f64, limits: &MotionLimits) -> Result<(), PointToPointError> {
    let error = PointToPointError::Check { distance, v0, v1 };
    let slack = 1.0 + 1e-9;
    let scale = libm::fabs(distance) + limits.velocity * law.duration + f64::MIN_POSITIVE;
    let mut state = Sample { first: v0, ..Sample::default() };
    for (index, phase) in law.phases[..law.count].iter().enumerate() {
        let end = law.phases[..law.count].get(index + 1).map_or(law.duration, |next| next.start);
        let joined = libm::fabs(state.value - phase.x) <= 1e-9 * scale
            && libm::fabs(state.first - phase.v) <= 1e-6 * limits.velocity
            && libm::fabs(state.second - phase.a) <= 1e-6 * limits.acceleration;
        let kept = libm::fabs(phase.v) <= limits.velocity * slack
            && libm::fabs(phase.a) <= limits.acceleration * slack
            && libm::fabs(phase.j) <= limits.jerk * slack;
        if !(joined && kept) {
            return Err(error);
        }
        state = phase.at(end);
    }
    let arrived = libm::fabs(state.value - distance) <= 1e-9 * scale
        && libm::fabs(state.first - v1) <= 1e-6 * limits.velocity
        && libm::fabs(state.second) <= 1e-6 * limits.acceleration;
    if arrived { Ok(()) } else { Err(error) }
}

fn validate(distance: f64, v0: f64, v1: f64, limits: &MotionLimits) -> Result<(), PointToPointError> {
    let MotionLimits { velocity, acceleration, jerk } = *limits;
    if ![velocity, acceleration, jerk].iter().all(|limit| limit.is_finite() && *limit > 0.0) {
        return Err(PointToPointError::Limits { velocity, acceleration, jerk });
    }
    if ![distance, v0, v1].iter().all(|x| x.is_finite()) {
        return Err(PointToPointError::NotFinite { distance, v0, v1 });
    }
    if libm::fabs(v0) > velocity || libm::fabs(v1) > velocity {
        return Err(PointToPointError::EndVelocity { v0, v1, limit: velocity });
    }
    Ok(())
}

/// The fastest change of velocity from `v0` to `v1`, which it then keeps; its distance is whatever it takes. Limits must be positive.
#[must_use]
pub fn velocity_change(v0: f64, v1: f64, limits: &MotionLimits) -> JerkLaw {
    let mut law = JerkLaw::starting(0.0, v0, 0.0);
    law.push_ramp(v1, limits);
    law
}

/// The fastest motion over `distance` (mm or rad) from rest to rest, a spline over time (s) that starts at (0, 0).
///
/// # Errors
/// Limits that are not positive, a distance that is not finite.
pub fn rest_to_rest(distance: f64, limits: &MotionLimits) -> Result<HermiteSpline, PointToPointError> {
    from_velocity(distance, 0.0, 0.0, limits)
}

/// A motion over `distance` (mm or rad) from velocity `v0` to `v1`, a spline over time (s) that starts at (0, 0).
///
/// # Errors
/// Limits that are not positive, numbers that are not finite, an end velocity beyond the limit.
pub fn from_velocity(
    distance: f64,
    v0: f64,
    v1: f64,
    limits: &MotionLimits,
) -> Result<HermiteSpline, PointToPointError> {
    validate(distance, v0, v1, limits)?;
    let law = solve(distance, v0, 0.0, v1, limits);
    check(&law, distance, v0, v1, limits)?;
    law.to_spline().map_err(|_| PointToPointError::Check { distance, v0, v1 })
}

/// The fastest change of velocity from `v0` to `v1`, a spline over time (s) that starts at (0, 0): a run-up.
///
/// # Errors
/// Limits that are not positive, numbers that are not finite, a velocity beyond the limit.
pub fn velocity_ramp(v0: f64, v1: f64, limits: &MotionLimits) -> Result<HermiteSpline, PointToPointError> {
    validate(0.0, v0, v1, limits)?;
    let law = velocity_change(v0, v1, limits);
    check(&law, law.end.value, v0, v1, limits)?;
    law.to_spline().map_err(|_| PointToPointError::Check { distance: law.end.value, v0, v1 })
}

/// A straight line in the space of the axes, from rest to rest: all axes start and arrive together.
///
/// One law s(t) from 0 to 1 moves all of them, with the limits of whichever axis is tightest, so a stop on the way is
/// a stop on the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MoveLaw {
    start_counts: [i64; AXIS_COUNT],
    delta_counts: [i64; AXIS_COUNT],
    limits: MotionLimits,
    law: JerkLaw,
}

impl MoveLaw {
    /// The move of some axes from where they rest (counts) to their targets. Each axis keeps both its target's and the
    /// machine's limits; of acceleration and jerk it uses [`MOVE_SHARE`].
    ///
    /// # Errors
    /// Limits that are not positive.
    pub fn new(
        start_counts: [i64; AXIS_COUNT],
        targets: &[AxisTarget],
        machine: &MachineDescription,
    ) -> Result<Self, PointToPointError> {
        let mut limits = MotionLimits { velocity: f64::INFINITY, acceleration: f64::INFINITY, jerk: f64::INFINITY };
        let mut delta_counts = [0; AXIS_COUNT];
        for target in targets {
            validate(0.0, 0.0, 0.0, &target.limits)?;
            let axis = machine.axis(target.axis);
            let delta = target.target_counts - start_counts[target.axis.index()];
            delta_counts[target.axis.index()] = delta;
            if delta == 0 {
                continue;
            }
            let distance = libm::fabs(delta as f64) / axis.scale.counts_per_unit();
            let own = axis.limits;
            limits.velocity = limits.velocity.min(own.velocity.min(target.limits.velocity) / distance);
            limits.acceleration =
                limits.acceleration.min(MOVE_SHARE * own.acceleration.min(target.limits.acceleration) / distance);
            limits.jerk = limits.jerk.min(MOVE_SHARE * own.jerk.min(target.limits.jerk) / distance);
        }
        if delta_counts.iter().all(|delta| *delta == 0) {
            let limits = MotionLimits { velocity: 1.0, acceleration: 1.0, jerk: 1.0 };
            return Ok(Self { start_counts, delta_counts, limits, law: JerkLaw::at_rest(1.0) });
        }
        validate(1.0, 0.0, 0.0, &limits)?;
        let law = solve(1.0, 0.0, 0.0, 0.0, &limits);
        check(&law, 1.0, 0.0, 0.0, &limits)?;
        Ok(Self { start_counts, delta_counts, limits, law })
    }

    /// Duration (s).
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.law.duration()
    }

    /// Duration in whole interpolation periods: the first tick at which all axes rest at their targets.
    #[must_use]
    pub fn ticks(&self, cycle_time_s: f64) -> u64 {
        whole_ticks(self.law.duration(), cycle_time_s)
    }

    /// Start position of the line (counts).
    #[must_use]
    pub fn start_counts(&self) -> [i64; AXIS_COUNT] {
        self.start_counts
    }

    /// From start to target (counts).
    #[must_use]
    pub fn delta_counts(&self) -> [i64; AXIS_COUNT] {
        self.delta_counts
    }

    /// Limits of the law s(t) (1/s, 1/s², 1/s³), those of moves.
    #[must_use]
    pub fn limits(&self) -> &MotionLimits {
        &self.limits
    }

    /// The law s(t), from 0 at the start to 1 at the target.
    #[must_use]
    pub fn law(&self) -> &JerkLaw {
        &self.law
    }

    /// Position of an axis at `s` of the line, relative to its start (counts, not rounded).
    #[must_use]
    pub fn along(&self, axis: usize, s: f64) -> f64 {
        s * self.delta_counts[axis] as f64
    }

    /// Positions of all axes at time `t` (s), rounded to counts.
    #[must_use]
    pub fn counts(&self, t: f64) -> [i64; AXIS_COUNT] {
        let s = self.law.sample(t).value;
        #[allow(clippy::cast_possible_truncation, reason = "travel in counts is below 2^53")]
        core::array::from_fn(|axis| self.start_counts[axis] + libm::round(self.along(axis, s)) as i64)
    }
}

/// A duration (s) in whole ticks, rounded up; a rounding error above a whole tick does not cost another one.
#[must_use]
#[allow(clippy::cast_possible_truncation, reason = "durations are positive and far below 2^53 ticks")]
pub fn whole_ticks(duration_s: f64, cycle_time_s: f64) -> u64 {
    libm::ceil(duration_s / cycle_time_s - 1e-6).max(0.0) as u64
}
