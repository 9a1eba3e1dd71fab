// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Point-to-point moves: closed forms, limits on random moves, and Ruckig as the oracle of the shortest time.

use camwright::machine::description::MotionLimits;
use camwright::math::hermite::HermiteSpline;
use camwright::motion::point_to_point::{PointToPointError, from_velocity, rest_to_rest, solve, velocity_ramp};
use rsruckig::prelude::{InputParameter, Ruckig, ThrowErrorHandler, Trajectory};

const LIMITS: MotionLimits = MotionLimits { velocity: 500.0, acceleration: 1e4, jerk: 1e6 };

/// A small generator whose seed is printed by the assertion that fails.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);

        (self.0 >> 33) as f64 / (1u64 << 31) as f64
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    /// Magnitudes from 1e-4 to 1e3, either sign, sometimes zero.
    fn magnitude(&mut self) -> f64 {
        let sign = if self.next() < 0.5 { -1.0 } else { 1.0 };
        if self.next() < 0.1 { 0.0 } else { sign * 10f64.powf(self.within(-4.0, 3.0)) }
    }
}

/// Largest speed, acceleration and jerk, by sampling; jerk between knots, where it is constant.
fn largest(spline: &HermiteSpline) -> (f64, f64, f64) {
    let mut largest = (0.0_f64, 0.0_f64, 0.0_f64);
    for pair in spline.knots().windows(2) {
        for i in 1..20 {
            let sample = spline.sample(pair[0].at + (pair[1].at - pair[0].at) * f64::from(i) / 20.0);
            largest = (largest.0.max(sample.first.abs()), largest.1.max(sample.second.abs()), largest.2);
        }
        let step = pair[1].at - pair[0].at;
        if step > 1e-9 {
            largest.2 = largest.2.max((pair[1].second - pair[0].second).abs() / step);
        }
    }
    largest
}

/// With every phase present: T = d/v + v/a + a/j.
#[test]
fn a_long_move_takes_distance_over_velocity_plus_velocity_over_acceleration_plus_acceleration_over_jerk() {
    let law = rest_to_rest(100.0, &LIMITS).expect("valid");
    let expected = 100.0 / 500.0 + 500.0 / 1e4 + 1e4 / 1e6;
    assert!((law.end() - expected).abs() < 1e-12, "{} {expected}", law.end());
    assert_eq!(law.knots().len(), 8);
    assert!((law.sample(expected / 2.0).value - 50.0).abs() < 1e-9);
}

/// Only jerk matters on the shortest moves: T = 4 (d/2j)^(1/3).
#[test]
fn a_short_move_is_limited_by_jerk_alone() {
    let law = rest_to_rest(-0.001, &LIMITS).expect("valid");
    let expected = 4.0 * (0.001_f64 / 2.0 / 1e6).cbrt();
    assert!((law.end() - expected).abs() < 1e-12, "{} {expected}", law.end());
    assert!((law.sample(law.end()).value + 0.001).abs() < 1e-15);
}

#[test]
fn no_distance_is_no_move() {
    let law = rest_to_rest(0.0, &LIMITS).expect("valid");
    assert!(law.end() <= 1e-9 && law.sample(1.0).value.abs() < 1e-15);
}

#[test]
fn limits_that_are_not_positive_are_refused() {
    let limits = MotionLimits { jerk: 0.0, ..LIMITS };
    assert_eq!(
        rest_to_rest(1.0, &limits),
        Err(PointToPointError::Limits { velocity: 500.0, acceleration: 1e4, jerk: 0.0 })
    );
    assert_eq!(
        from_velocity(1.0, 501.0, 0.0, &LIMITS),
        Err(PointToPointError::EndVelocity { v0: 501.0, v1: 0.0, limit: 500.0 })
    );
    assert!(matches!(rest_to_rest(f64::NAN, &LIMITS), Err(PointToPointError::NotFinite { .. })));
}

/// A ramp over the whole acceleration: T = v/a + a/j, distance v/2 · T.
#[test]
fn a_velocity_ramp_covers_half_of_velocity_times_time() {
    let law = velocity_ramp(0.0, 400.0, &LIMITS).expect("valid");
    let expected = 400.0 / 1e4 + 1e4 / 1e6;
    assert!((law.end() - expected).abs() < 1e-12);
    assert!((law.sample(law.end()).value - 200.0 * expected).abs() < 1e-9);
}

/// Random moves between random velocities stay within their limits and arrive.
#[test]
fn random_moves_keep_their_limits_and_arrive() {
    let seed = 20_260_730;
    let mut random = Random(seed);
    for case in 0..5000 {
        // Axes reach their speed in 10 ms to 1 s and their acceleration in 3 ms to 1 s.
        let velocity = 10f64.powf(random.within(-1.0, 3.0));
        let acceleration = velocity * 10f64.powf(random.within(0.0, 2.0));
        let jerk = acceleration * 10f64.powf(random.within(0.0, 2.5));
        let limits = MotionLimits { velocity, acceleration, jerk };
        let distance = random.magnitude();
        let v0 = limits.velocity * random.within(-1.0, 1.0) * f64::from(u8::from(random.next() > 0.3));
        let v1 = limits.velocity * random.within(-1.0, 1.0) * f64::from(u8::from(random.next() > 0.3));
        let what = format!("seed {seed} case {case}: {distance} {v0} {v1} {limits:?}");
        let law = from_velocity(distance, v0, v1, &limits).unwrap_or_else(|error| panic!("{what}: {error}"));
        let (v, a, j) = largest(&law);
        assert!(v <= limits.velocity * (1.0 + 1e-6), "{what}: velocity {v}");
        assert!(a <= limits.acceleration * (1.0 + 1e-6), "{what}: acceleration {a}");
        // Jerk from differences of accelerations over phases that may last nanoseconds.
        assert!(j <= limits.jerk * (1.0 + 1e-3), "{what}: jerk {j}");
        let end = law.knots()[law.knots().len() - 1];
        assert!((end.value - distance).abs() <= 1e-9 * (1.0 + distance.abs()), "{what}: {}", end.value);
        assert!((end.first - v1).abs() <= 1e-9 * limits.velocity, "{what}: {}", end.first);
    }
}

/// Shortest time by Ruckig; `None` where its port finds no solution.
fn ruckig_duration(distance: f64, v0: f64, a0: f64, limits: &MotionLimits) -> Option<f64> {
    let mut ruckig = Ruckig::<1, ThrowErrorHandler>::new(None, 0.001);
    let mut input = InputParameter::<1>::new(None);
    let mut trajectory = Trajectory::<1>::new(None);
    input.current_velocity[0] = v0;
    input.current_acceleration[0] = a0;
    input.target_position[0] = distance;
    input.max_velocity[0] = limits.velocity;
    input.max_acceleration[0] = limits.acceleration;
    input.max_jerk[0] = limits.jerk;
    ruckig.calculate(&input, &mut trajectory).ok()?;
    Some(trajectory.get_duration())
}

/// From any velocity to rest Ruckig is never faster. (Its port 3.0.1 is slower in a few cases, such as 9.494884050992336
/// mm from 264.10097582265735 mm/s: 71.9 ms, where 52.3 ms keep every limit.)
#[test]
fn coming_to_rest_takes_the_time_that_ruckig_finds() {
    let seed = 7;
    let mut random = Random(seed);
    let (mut equal, mut cases) = (0, 0);
    for case in 0..2000 {
        let distance = random.magnitude();
        let v0 = if random.next() < 0.4 { 0.0 } else { LIMITS.velocity * random.within(-1.0, 1.0) };
        let ours = solve(distance, v0, 0.0, 0.0, &LIMITS).duration();
        let Some(shortest) = ruckig_duration(distance, v0, 0.0, &LIMITS) else { continue };
        assert!(ours < shortest + 1e-6, "seed {seed} case {case}: {distance} {v0}: {ours} {shortest}");
        cases += 1;
        equal += i32::from((ours - shortest).abs() < 1e-6);
    }
    assert!(cases > 1900 && equal * 100 > cases * 95, "seed {seed}: {equal} of {cases} equal");
}

/// A start with acceleration arrives too, and within a quarter more than the shortest time.
#[test]
fn a_start_with_acceleration_arrives_at_rest() {
    let seed = 11;
    let mut random = Random(seed);
    let (mut worst, mut compared): (f64, u32) = (0.0, 0);
    for case in 0..2000 {
        let distance = random.magnitude();
        let a0 = LIMITS.acceleration * random.within(-1.0, 1.0);
        // A velocity that the acceleration does not carry beyond the limit.
        let v0 = (LIMITS.velocity - a0 * a0 / (2.0 * LIMITS.jerk)) * random.within(-1.0, 1.0);
        let law = solve(distance, v0, a0, 0.0, &LIMITS);
        if let Some(shortest) = ruckig_duration(distance, v0, a0, &LIMITS) {
            worst = worst.max(law.duration() / shortest);
            compared += 1;
        }
        let end = law.sample(law.duration());
        let before = law.sample(law.duration() - 1e-9);
        assert!((end.value - distance).abs() < 1e-12 && end.first.abs() < 1e-12, "seed {seed} case {case}");
        assert!((before.value - distance).abs() < 1e-7, "seed {seed} case {case}: {before:?} {distance}");
    }
    assert!(worst < 1.25 && compared > 1000, "seed {seed}: {worst} in {compared}");
}
