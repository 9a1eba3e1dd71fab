// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A servo drive: position loop, velocity loop, feed-forward, limits, and the encoder that it sees its axis through.
//!
//! Once per servo step, with e the error that the encoder shows, v̄ the mean speed that it shows for the last step, and v and a those of
//! the setpoint:
//!
//! ```text
//!  u = Kv e + ff v                                    speed that is asked for, limited
//!  F = w (u − v̄) + w/Tn ∫(v̂ − v̄) + ff_a a + friction  force over mass, limited
//! ```
//! v̂ is the speed of a rigid axis without friction under the first and third term: only what disturbs the axis reaches the integral, so
//! that it takes no part in how setpoints are followed (a reference model, as drives have it). Then a drive with an ideal motor is the
//! textbook's lag of first order with gain Kv behind one of bandwidth w.
//!
//! The state is the following error, not the position: with an error of exactly 0 the axis is exactly at its setpoint,
//! however far it has travelled. Everything here is in counts and seconds, forces over the moving mass.

use crate::machine::description::{Axis, AxisDescription, AxisScale};
use crate::math::noise::Noise;
use crate::simulation::mechanics::Mechanics;
use crate::simulation::plausibility::DRIVE_HEADROOM;

pub use crate::machine::drive::{DriveSettings, Structure};

/// Setpoint during one servo step, and external load of the axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ServoCommand {
    /// Setpoint at the end of the step (counts): the reference of the encoder counts.
    pub position: f64,
    /// Distance (counts).
    pub distance: f64,
    /// Velocity at the end (counts/s).
    pub velocity: f64,
    /// Mean acceleration (counts/s²).
    pub acceleration: f64,
    /// Force on the axis that is not the motor's (N or N m).
    pub disturbance: f64,
}

/// A servo drive and the axis it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Servo {
    settings: DriveSettings,
    step_s: f64,
    max_velocity: f64,
    /// Most force of the motor over the mass (counts/s²).
    max_acceleration: f64,
    brake: f64,
    /// Acceleration of the axis per force on it (counts/s² per N or N m).
    per_force: f64,
    gain: f64,
    /// Coulomb's friction (counts/s²), and friction per speed (1/s), over the mass.
    friction: (f64, f64),
    noise: Noise,
    seed: u64,
    error: f64,
    /// Error as the encoder shows it (counts).
    seen: f64,
    /// Way of the last step as the encoder shows it, and that of the setpoint (counts).
    seen_way: f64,
    demanded_way: f64,
    /// Speed v̂ now, and in the mean of the last step (counts/s).
    model: (f64, f64),
    /// Integral part (counts/s²).
    integral: f64,
    /// Force of the last step over the mass (counts/s²).
    force: f64,
    ideal_velocity: f64,
    mechanics: Mechanics,
}

crate::snapshot!(Servo {
    gain, noise, error, seen, seen_way, demanded_way, model, integral, force, ideal_velocity, mechanics,
} on { settings, step_s, max_velocity, max_acceleration, brake, per_force, friction, seed });

impl Servo {
    /// A drive at rest on its setpoint. `step_s` is the period of its position loop (s).
    #[must_use]
    pub fn new(axis: &AxisDescription, step_s: f64) -> Self {
        let counts = axis.scale.counts_per_unit();
        let per_force = match axis.scale {
            // A newton on a kilogram is 1000 mm/s².
            AxisScale::Linear { .. } => 1e3 / axis.inertia * counts,
            AxisScale::Rotary { .. } => counts / axis.inertia,
        };
        let drive = axis.drive;
        let friction = (drive.coulomb_friction * per_force, drive.viscous_friction * per_force / counts);
        let ordinary = axis.limits.acceleration * counts * DRIVE_HEADROOM;
        Self {
            settings: drive,
            step_s,
            max_velocity: axis.limits.velocity * counts * DRIVE_HEADROOM,
            max_acceleration: drive.max_force.map_or(ordinary, |force| force * per_force),
            brake: axis.limits.acceleration * counts,
            per_force,
            gain: 1.0,
            friction,
            noise: Noise::new(seed(axis.axis)),
            seed: seed(axis.axis),
            error: 0.0,
            seen: 0.0,
            seen_way: 0.0,
            demanded_way: 0.0,
            model: (0.0, 0.0),
            integral: 0.0,
            force: 0.0,
            ideal_velocity: 0.0,
            mechanics: Mechanics::new(drive.structure, friction.0, friction.1, drive.backlash * counts, step_s),
        }
    }

    /// A job begins: the noise of the encoder is that of every job.
    pub fn begin_job(&mut self) {
        self.noise = Noise::new(self.seed);
    }

    fn is_ideal(&self) -> bool {
        self.settings.velocity_loop_rad_s.is_none()
    }

    /// Setpoint minus position of the slide, with what the encoder reads too much, finer than a count (counts).
    #[must_use]
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Setpoint minus what the encoder reads (counts).
    #[must_use]
    pub fn error_seen(&self) -> f64 {
        if self.is_ideal() { self.error } else { self.seen }
    }

    /// Velocity of the slide (counts/s).
    #[must_use]
    pub fn velocity(&self) -> f64 {
        if self.is_ideal() { self.ideal_velocity } else { self.mechanics.velocity() }
    }

    /// Lead of the tool over the encoder: play and structure (counts).
    #[must_use]
    pub fn tool_ahead(&self) -> f64 {
        self.mechanics.tool_ahead()
    }

    /// Lead of the structure over the slide (counts), and its rate (counts/s).
    #[must_use]
    pub fn swing(&self) -> (f64, f64) {
        self.mechanics.swing()
    }

    /// Velocity of the tool (counts/s).
    #[must_use]
    pub fn tool_velocity(&self) -> f64 {
        if self.is_ideal() { self.ideal_velocity } else { self.mechanics.tool_velocity() }
    }

    /// Force of the motor in the last step (N or N m); `None` of an ideal drive, which has whatever it needs.
    #[must_use]
    pub fn force(&self) -> Option<f64> {
        (!self.is_ideal()).then(|| self.force / self.per_force)
    }

    /// Error at which the axis counts as on a resting setpoint (counts): half of what the encoder resolves, and its noise.
    #[must_use]
    pub fn window(&self) -> f64 {
        0.5 * self.settings.encoder_step_counts.max(1.0) + self.settings.encoder_noise_counts
    }

    #[must_use]
    pub fn is_quiet(&self) -> bool {
        self.mechanics.is_quiet(self.window())
    }

    /// The reading of the encoder jumps by `counts`.
    pub fn disturb(&mut self, counts: f64) {
        self.error -= counts;
        self.seen -= counts;
        self.seen_way += counts;
    }

    /// A real drive stands so far behind its setpoint (counts) and moves so fast (counts/s).
    pub(crate) fn measure(&mut self, error: f64, velocity: f64) {
        (self.error, self.seen, self.ideal_velocity) = (error, error, velocity);
    }

    /// All gains are this fraction of their settings from now on.
    pub fn set_gain(&mut self, fraction: f64) {
        self.gain = fraction;
    }

    /// At rest on the setpoint, exactly; the motor holds against what it held against.
    pub fn clamp(&mut self) {
        (self.error, self.seen, self.seen_way, self.demanded_way) = (0.0, 0.0, 0.0, 0.0);
        self.model = (0.0, 0.0);
        self.ideal_velocity = 0.0;
        self.force = self.integral;
        self.mechanics.rest();
    }

    /// At rest on the setpoint, free of everything that was.
    pub fn place(&mut self) {
        self.integral = 0.0;
        self.clamp();
        self.mechanics.place();
    }

    /// Without power the axis leaves its setpoint behind: from now on there is no error, only speed.
    pub fn release(&mut self) {
        (self.error, self.seen, self.seen_way, self.demanded_way) = (0.0, 0.0, 0.0, 0.0);
        self.model = (0.0, 0.0);
        (self.integral, self.force) = (0.0, 0.0);
    }

    /// One servo step under power; returns the distance the slide moved (counts).
    ///
    /// Without a bandwidth the loop is ideal and the position loop continuous: de/dt = (1 − ff) v − Kv e, solved exactly
    /// for the step's mean setpoint speed; only the speed is limited then.
    pub fn step(&mut self, demand: ServoCommand) -> f64 {
        let kv = self.settings.kv_1_s * (1.0 + self.settings.gain_error) * self.gain;
        let ff = self.settings.velocity_feed_forward * self.gain;
        let Some(bandwidth) = self.settings.velocity_loop_rad_s else { return self.ideal_step(demand, kv, ff) };
        let h = self.step_s;
        // All that is known at the beginning of the step is of the step before, the setpoint's speed too: with whole feed-forward an axis
        // on its setpoint is asked for exactly the speed that it shows.
        let (shown, asked) = (self.seen_way / h, self.demanded_way / h);
        let wanted = (kv * self.seen + ff * asked).clamp(-self.max_velocity, self.max_velocity);
        let ahead = self.settings.acceleration_feed_forward * self.gain * demand.acceleration;
        let modelled =
            (bandwidth * (wanted - self.model.1) + ahead).clamp(-self.max_acceleration, self.max_acceleration);
        let after = self.model.0 + modelled * h;
        let asked_force = bandwidth * (wanted - shown) + ahead + self.integral + self.friction_ahead(demand.velocity);
        let at_limit = asked_force.abs() > self.max_acceleration;
        let force = asked_force.clamp(-self.max_acceleration, self.max_acceleration);
        if let Some(integral_s) = self.settings.velocity_integral_s {
            let more = bandwidth * h / integral_s * (self.model.1 - shown);
            // At the motor's limit the integral only goes back.
            if !at_limit || more * asked_force < 0.0 {
                self.integral = (self.integral + more).clamp(-self.max_acceleration, self.max_acceleration);
            }
        }
        self.model = (after, 0.5 * (self.model.0 + after));
        // What the motor cannot do the model does not ask for for ever.
        if at_limit {
            self.model = (self.mechanics.velocity(), shown);
        }
        self.force = force;
        let distance = self.mechanics.step(force + demand.disturbance * self.per_force);
        self.error += demand.distance - distance;
        let seen = self.read_encoder(demand.position);
        self.seen_way = demand.distance - (seen - self.seen);
        (self.seen, self.demanded_way) = (seen, demand.distance);
        distance
    }

    /// Feed-forward against friction.
    fn friction_ahead(&self, velocity: f64) -> f64 {
        let share = self.settings.friction_feed_forward * self.gain;
        if share == 0.0 || velocity == 0.0 {
            return 0.0;
        }
        share * (libm::copysign(self.friction.0, velocity) + self.friction.1 * velocity)
    }

    /// The error that the encoder shows, with the setpoint at a position (counts).
    fn read_encoder(&mut self, position: f64) -> f64 {
        let (step, noise) = (self.settings.encoder_step_counts, self.settings.encoder_noise_counts);
        let noisy = if noise > 0.0 { noise * self.noise.quick() } else { 0.0 };
        if step > 0.0 {
            position - step * libm::rint((position - self.error + noisy) / step)
        } else {
            self.error - noisy
        }
    }

    fn ideal_step(&mut self, demand: ServoCommand, kv: f64, ff: f64) -> f64 {
        let h = self.step_s;
        let mean = demand.distance / h;
        let forgotten = -libm::expm1(-kv * h);
        let lag_s = if kv > 0.0 { forgotten / kv } else { h };
        let error = self.error * (1.0 - forgotten) + (1.0 - ff) * mean * lag_s;
        let max = self.max_velocity * h;
        let distance = demand.distance + (self.error - error);
        if distance.abs() <= max {
            self.ideal_velocity = ff * demand.velocity + kv * error;
            self.error = error;
            return distance;
        }
        let distance = libm::copysign(max, distance);
        self.ideal_velocity = distance / h;
        self.error += demand.distance - distance;
        distance
    }

    /// One servo step without power: the axis brakes; returns the distance it moved (counts).
    pub fn coast(&mut self) -> f64 {
        let before = self.velocity();
        let change = (self.brake * self.step_s).min(before.abs());
        self.lead(before - libm::copysign(change, before))
    }

    /// One servo step without power, drawn outwards (positive) by a weight or a spring that gives an acceleration `pull`
    /// (counts/s²) while `left` counts remain, no faster than `fastest` (counts/s); a brake stops what comes the other
    /// way first, and the axis at the end. Returns the distance it moved (counts).
    pub fn draw(&mut self, pull: f64, left: f64, fastest: f64) -> f64 {
        let (h, velocity) = (self.step_s, self.velocity());
        let to_stop = 0.5 * velocity * velocity / self.brake + velocity * h;
        if velocity < 0.0 || left <= to_stop {
            return self.coast();
        }
        self.lead((velocity + pull * h).min(fastest.max(velocity)))
    }

    /// One servo step in which something else than the motor brings the axis to a speed; returns the distance it moved (counts).
    fn lead(&mut self, after: f64) -> f64 {
        if self.is_ideal() {
            let before = self.ideal_velocity;
            self.ideal_velocity = after;
            0.5 * (before + after) * self.step_s
        } else {
            self.mechanics.lead(after)
        }
    }
}

/// Seed of the encoder noise of an axis: different for every axis.
fn seed(axis: Axis) -> u64 {
    0x5eed_0000 + axis.index() as u64
}

#[cfg(test)]
mod tests;
