//! A servo drive: position loop, feed-forward, velocity loop, limits.
//!
//! ```text
//!            ff_a·a/w ──────────┐
//! setpoint ── ff_v·v ──────────┐│     limits    1st-order lag w      ∫
//!    └── − actual ── error ─ Kv ┴┴─ u ──────── velocity ─────────── position
//! ```
//! The state is the following error, not the position: with an error of exactly 0 the axis is exactly at its setpoint,
//! however far it has travelled. Everything here is in counts and seconds.

use crate::machine::description::{AxisDescription, DriveSettings};
use crate::machine::plausibility::DRIVE_HEADROOM;

/// What the setpoint does during one servo step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Demand {
    /// Distance (counts).
    pub distance: f64,
    /// Velocity at the end (counts/s).
    pub velocity: f64,
    /// Mean acceleration (counts/s²).
    pub acceleration: f64,
}

/// A servo drive and the axis it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Servo {
    settings: DriveSettings,
    step_s: f64,
    max_velocity: f64,
    max_acceleration: f64,
    brake: f64,
    gain: f64,
    error: f64,
    velocity: f64,
}

impl Servo {
    /// A drive at rest on its setpoint. `step_s` is the period of its position loop (s).
    #[must_use]
    pub fn new(axis: &AxisDescription, step_s: f64) -> Self {
        let counts = axis.scale.counts_per_unit();
        Self {
            settings: axis.drive,
            step_s,
            max_velocity: axis.limits.velocity * counts * DRIVE_HEADROOM,
            max_acceleration: axis.limits.acceleration * counts * DRIVE_HEADROOM,
            brake: axis.limits.acceleration * counts,
            gain: 1.0,
            error: 0.0,
            velocity: 0.0,
        }
    }

    /// Setpoint minus measured position (counts).
    #[must_use]
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Velocity of the axis (counts/s).
    #[must_use]
    pub fn velocity(&self) -> f64 {
        self.velocity
    }

    /// The reading of the encoder jumps by `counts`.
    pub fn disturb(&mut self, counts: f64) {
        self.error -= counts;
    }

    /// All gains are this fraction of their settings from now on.
    pub fn set_gain(&mut self, fraction: f64) {
        self.gain = fraction;
    }

    /// At rest on the setpoint, exactly.
    pub fn clamp(&mut self) {
        self.error = 0.0;
        self.velocity = 0.0;
    }

    /// Without power the axis leaves its setpoint behind: from now on there is no error, only speed.
    pub fn release(&mut self) {
        self.error = 0.0;
    }

    /// One servo step under power; returns the distance the axis moved (counts).
    ///
    /// The velocity loop is a first-order lag of bandwidth w, solved exactly for the command u held over the step:
    /// v₁ = u + (v₀ − u) e^(−wh), distance = u h + (v₀ − u)(1 − e^(−wh))/w. Feed-forward of the mean speed over the step
    /// makes the error at constant speed exactly v (1 − ff)/Kv at every servo step.
    ///
    /// Without a bandwidth the loop is ideal and the position loop continuous: de/dt = (1 − ff) v − Kv e, solved exactly
    /// for the step's mean setpoint speed; only the speed is limited then.
    pub fn step(&mut self, demand: Demand) -> f64 {
        let h = self.step_s;
        let kv = self.settings.kv_1_s * self.gain;
        let ff = self.settings.velocity_feed_forward * self.gain;
        let mean = demand.distance / h;
        let distance = match self.settings.velocity_loop_rad_s {
            Some(w) => {
                let ff_a = self.settings.acceleration_feed_forward * self.gain;
                let u = (kv * self.error + ff * mean + ff_a * demand.acceleration / w)
                    .clamp(-self.max_velocity, self.max_velocity);
                let forgotten = -libm::expm1(-w * h);
                let after = self.velocity + (u - self.velocity) * forgotten;
                let most = self.max_acceleration * h;
                if (after - self.velocity).abs() <= most {
                    let distance = u * h + (self.velocity - u) * forgotten / w;
                    self.velocity = after;
                    distance
                } else {
                    let limited = self.velocity + libm::copysign(most, after - self.velocity);
                    let distance = 0.5 * (self.velocity + limited) * h;
                    self.velocity = limited;
                    distance
                }
            }
            None => {
                let forgotten = -libm::expm1(-kv * h);
                let lag_s = if kv > 0.0 { forgotten / kv } else { h };
                let error = self.error * (1.0 - forgotten) + (1.0 - ff) * mean * lag_s;
                let most = self.max_velocity * h;
                let distance = demand.distance + (self.error - error);
                if distance.abs() <= most {
                    self.velocity = ff * demand.velocity + kv * error;
                    self.error = error;
                    return distance;
                }
                let distance = libm::copysign(most, distance);
                self.velocity = distance / h;
                distance
            }
        };
        self.error += demand.distance - distance;
        distance
    }

    /// One servo step without power: the axis brakes; returns the distance it moved (counts).
    pub fn coast(&mut self) -> f64 {
        let change = (self.brake * self.step_s).min(self.velocity.abs());
        let after = self.velocity - libm::copysign(change, self.velocity);
        let distance = 0.5 * (self.velocity + after) * self.step_s;
        self.velocity = after;
        distance
    }
}

impl Servo {
    /// One servo step without power, drawn outwards (positive) by a weight or a spring that gives an acceleration `pull`
    /// (counts/s²) while `left` counts remain, no faster than `fastest` (counts/s); a brake stops what comes the other
    /// way first, and the axis at the end. Returns the distance it moved (counts).
    pub fn draw(&mut self, pull: f64, left: f64, fastest: f64) -> f64 {
        let h = self.step_s;
        let to_stop = 0.5 * self.velocity * self.velocity / self.brake + self.velocity * h;
        if self.velocity < 0.0 || left <= to_stop {
            return self.coast();
        }
        let after = (self.velocity + pull * h).min(fastest.max(self.velocity));
        let distance = 0.5 * (self.velocity + after) * h;
        self.velocity = after;
        distance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::description::Axis;
    use crate::machine::reference::cam_grinder;

    const STEP_S: f64 = 0.25e-3;

    fn servo(drive: DriveSettings) -> Servo {
        let mut axis = cam_grinder().axis(Axis::X).clone();
        axis.drive = drive;
        Servo::new(&axis, STEP_S)
    }

    fn drive(kv: f64, ff: f64, bandwidth: Option<f64>) -> DriveSettings {
        DriveSettings {
            kv_1_s: kv,
            velocity_feed_forward: ff,
            acceleration_feed_forward: 0.0,
            velocity_loop_rad_s: bandwidth,
        }
    }

    /// Constant speed v: following error v (1 − ff)/Kv, with and without a lag in the velocity loop.
    #[test]
    fn at_constant_speed_the_error_is_speed_over_gain() {
        let v = 2.0e6;
        for (kv, ff, bandwidth) in
            [(100.0, 0.0, None), (300.0, 0.9, None), (100.0, 0.0, Some(600.0)), (150.0, 0.97, Some(500.0))]
        {
            let mut servo = servo(drive(kv, ff, bandwidth));
            for _ in 0..40_000 {
                servo.step(Demand { distance: v * STEP_S, velocity: v, acceleration: 0.0 });
            }
            let expected = v * (1.0 - ff) / kv;
            assert!((servo.error() - expected).abs() < 1e-6 * expected, "{} {expected}", servo.error());
            assert!((servo.velocity() - v).abs() < 1e-6 * v);
        }
    }

    /// From rest, a step to speed v gives e(t) = v (1 − ff)/Kv (1 − exp(−Kv t)) with an ideal velocity loop.
    #[test]
    fn the_error_of_a_ramp_grows_exponentially() {
        let (v, kv) = (1.0e6, 120.0);
        let mut servo = servo(drive(kv, 0.0, None));
        for k in 1..=400 {
            servo.step(Demand { distance: v * STEP_S, velocity: v, acceleration: 0.0 });
            let t = f64::from(k) * STEP_S;
            let expected = v / kv * (1.0 - libm::exp(-kv * t));
            assert!((servo.error() - expected).abs() < 1e-6 * v / kv, "{k}");
        }
    }

    #[test]
    fn an_ideal_drive_is_exactly_where_it_is_told_to_be() {
        let mut servo = servo(DriveSettings::IDEAL);
        for k in 0..10_000_u32 {
            let distance = f64::from((k * 7919) % 1000) - 500.0;
            let moved = servo.step(Demand { distance, velocity: distance / STEP_S, acceleration: 0.0 });
            assert_eq!((moved.to_bits(), servo.error().to_bits()), (distance.to_bits(), 0.0_f64.to_bits()));
        }
    }

    /// With a first-order loop a sine of amplitude A and frequency W comes out smaller by the factor
    /// 1/√(1 + (W/Kv)²), that is by A W²/(2 Kv²), the part of the error that no common delay of the axes takes away.
    #[test]
    fn a_first_order_lag_leaves_the_residual_of_its_second_order() {
        let (amplitude, kv) = (3.0e5, 100.0);
        let w = 2.0 * core::f64::consts::PI * 3.0;
        let mut servo = servo(drive(kv, 0.0, None));
        let at = |k: u32| amplitude * libm::sin(w * f64::from(k) * STEP_S);
        let mut largest = 0.0_f64;
        for k in 1..20_000 {
            let distance = at(k) - at(k - 1);
            let velocity = amplitude * w * libm::cos(w * f64::from(k) * STEP_S);
            servo.step(Demand { distance, velocity, acceleration: 0.0 });
            if k > 10_000 {
                largest = largest.max((at(k) - servo.error()).abs());
            }
        }
        let expected = amplitude / libm::sqrt(1.0 + (w / kv) * (w / kv));
        assert!((largest - expected).abs() < 1e-4 * amplitude, "{largest} {expected}");
        let residual = amplitude * w * w / (2.0 * kv * kv);
        assert!((amplitude - largest - residual).abs() < 0.05 * residual);
    }

    #[test]
    fn whole_feed_forward_leaves_little_of_the_lag() {
        let ordinary = DriveSettings {
            kv_1_s: 200.0,
            velocity_feed_forward: 1.0,
            acceleration_feed_forward: 1.0,
            velocity_loop_rad_s: Some(628.0),
        };
        let (amplitude, w) = (3.0e5, 2.0 * core::f64::consts::PI * 3.0);
        let run = |settings: DriveSettings| {
            let mut servo = servo(settings);
            let mut largest = 0.0_f64;
            for k in 1..20_000_u32 {
                let t = |k: f64| k * STEP_S;
                let distance = amplitude * (libm::sin(w * t(f64::from(k))) - libm::sin(w * t(f64::from(k - 1))));
                let velocity = amplitude * w * libm::cos(w * t(f64::from(k)));
                let acceleration = -amplitude * w * w * libm::sin(w * t(f64::from(k) - 0.5));
                servo.step(Demand { distance, velocity, acceleration });
                if k > 10_000 {
                    largest = largest.max(servo.error().abs());
                }
            }
            largest
        };
        let without = run(drive(200.0, 0.0, Some(628.0)));
        assert!(run(ordinary) < 1e-3 * without, "{} {without}", run(ordinary));
    }

    #[test]
    fn neither_speed_nor_acceleration_exceeds_what_the_drive_can() {
        let axis = cam_grinder().axis(Axis::X).clone();
        let counts = axis.scale.counts_per_unit();
        let mut servo = Servo::new(&axis, STEP_S);
        servo.disturb(-200.0 * counts);
        let mut before = 0.0;
        for _ in 0..8_000 {
            servo.step(Demand::default());
            let acceleration = (servo.velocity() - before).abs() / STEP_S;
            assert!(servo.velocity().abs() <= axis.limits.velocity * counts * DRIVE_HEADROOM * (1.0 + 1e-12));
            assert!(acceleration <= axis.limits.acceleration * counts * DRIVE_HEADROOM * (1.0 + 1e-9));
            before = servo.velocity();
        }
        assert!(servo.error().abs() < 1.0, "{}", servo.error());
    }

    #[test]
    fn without_power_the_axis_brakes_at_its_acceleration_limit() {
        let axis = cam_grinder().axis(Axis::X).clone();
        let counts = axis.scale.counts_per_unit();
        let mut servo = Servo::new(&axis, STEP_S);
        servo.velocity = 400.0 * counts;
        let mut distance = 0.0;
        while servo.velocity() > 0.0 {
            distance += servo.coast();
        }
        // v²/(2 a)
        assert!((distance / counts - 400.0 * 400.0 / (2.0 * axis.limits.acceleration)).abs() < 1e-9);
    }
}
