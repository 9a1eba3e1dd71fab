// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Servo drive with its slide or spindle: loops, motor, friction, structure, encoder.
//!
//! Forces are those of the axis: N of a slide, N m of a spindle; lengths mm of a slide, rad of a spindle.

use crate::machine::description_error::DescriptionError;

/// Control loops of a servo drive, and the disturbances of its axis.
///
/// ```text
///              ff_a·a·m + friction ────────────────┐
/// setpoint ─── ff_v·v ──────────────┐              │    force limit    cutting force, friction
///    └─ − encoder ── error ── Kv ───┴─ u ─ − v ── PI ┴──────┴──────────── slide ──┬── play ── structure ── tool
///           └────────────────── counts, noise ────────────────────────────────────┘
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveSettings {
    /// Position loop gain Kv (1/s).
    pub kv_1_s: f64,
    /// Share by which the gain that acts is larger than [`kv_1_s`](Self::kv_1_s): what keeps the axes of a path from lagging alike.
    pub gain_error: f64,
    /// Velocity feed-forward, 0 none … 1 whole.
    pub velocity_feed_forward: f64,
    /// Acceleration feed-forward, 0 none … 1 whole: the force that the mass needs.
    pub acceleration_feed_forward: f64,
    /// Share of the friction that the drive gives as a force before it is felt, by the sign and size of the setpoint's speed.
    pub friction_feed_forward: f64,
    /// Bandwidth of the velocity loop (rad/s), its gain over the moving mass; `None` is an ideal, instantaneous loop, and nothing below
    /// applies.
    pub velocity_loop_rad_s: Option<f64>,
    /// Integral time of the velocity loop (s); `None`: it has only a gain, and yields to every lasting force.
    pub velocity_integral_s: Option<f64>,
    /// Most force of the motor; `None`: 1.2 times what the acceleration limit needs.
    pub max_force: Option<f64>,
    /// Coulomb's friction: a force against the motion, and at rest against whatever is smaller than it.
    pub coulomb_friction: f64,
    /// Friction per speed (N s/mm or N m s/rad).
    pub viscous_friction: f64,
    /// Lost motion between encoder and tool: the tool stays where it is until the play is taken up (mm or rad).
    pub backlash: f64,
    /// The first mode of the structure; `None`: it is rigid.
    pub structure: Option<Structure>,
    /// Resolution of the encoder (counts); 0: unlimited.
    pub encoder_step_counts: f64,
    /// Standard deviation of its noise (counts).
    pub encoder_noise_counts: f64,
}

/// The first mode of what an axis carries: part of its mass swings on a spring, and the tool (or the part) with it.
///
/// What a force on the tool does to it is not here but in the machine's stiffness at the contact; here it swings by what the axis
/// accelerates: it lags by a/ω² behind the encoder, and rings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Structure {
    /// Frequency with the slide held (rad/s).
    pub frequency_rad_s: f64,
    pub damping: f64,
    /// Share of the moving mass that swings, from 0 to below 1.
    pub mass_share: f64,
}

impl DriveSettings {
    /// Ideal drive that follows its setpoint exactly.
    pub const IDEAL: DriveSettings = DriveSettings {
        kv_1_s: 300.0,
        gain_error: 0.0,
        velocity_feed_forward: 1.0,
        acceleration_feed_forward: 1.0,
        friction_feed_forward: 0.0,
        velocity_loop_rad_s: None,
        velocity_integral_s: None,
        max_force: None,
        coulomb_friction: 0.0,
        viscous_friction: 0.0,
        backlash: 0.0,
        structure: None,
        encoder_step_counts: 0.0,
        encoder_noise_counts: 0.0,
    };

    /// This drive with an encoder that resolves everything.
    #[must_use]
    pub const fn with_exact_encoder(self) -> Self {
        Self { encoder_step_counts: 0.0, encoder_noise_counts: 0.0, ..self }
    }

    /// Checks that the values describe a possible drive for an axis with this inertia and servo steps of this length (s).
    pub(super) fn validate(&self, joint: &'static str, inertia: f64, step_s: f64) -> Result<(), DescriptionError> {
        let positive = |what: &'static str, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(DescriptionError::AxisNotPositive { joint, what, value }),
        };
        let from_zero = |what: &'static str, value: f64| match value >= 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(DescriptionError::AxisNegative { joint, what, value }),
        };
        let at_most = |what: &'static str, value: f64, allowed: f64| match value <= allowed {
            true => Ok(()),
            false => Err(DescriptionError::AxisAbove { joint, what, value, allowed }),
        };
        positive("position loop gain", self.kv_1_s)?;
        positive("position loop gain with its error", self.kv_1_s * (1.0 + self.gain_error))?;
        from_zero("velocity feed-forward", self.velocity_feed_forward)?;
        from_zero("acceleration feed-forward", self.acceleration_feed_forward)?;
        from_zero("friction feed-forward", self.friction_feed_forward)?;
        from_zero("Coulomb friction", self.coulomb_friction)?;
        from_zero("viscous friction", self.viscous_friction)?;
        from_zero("backlash", self.backlash)?;
        from_zero("step of the encoder (counts)", self.encoder_step_counts)?;
        from_zero("noise of the encoder (counts)", self.encoder_noise_counts)?;
        for (what, value) in [
            ("velocity loop bandwidth", self.velocity_loop_rad_s),
            ("integral time of the velocity loop", self.velocity_integral_s),
            ("most force", self.max_force),
        ] {
            value.map_or(Ok(()), |value| positive(what, value))?;
        }
        if let Some(structure) = self.structure {
            positive("frequency of the structure", structure.frequency_rad_s)?;
            from_zero("damping of the structure", structure.damping)?;
            from_zero("share of the mass that swings", structure.mass_share)?;
            at_most("damping of the structure", structure.damping, 0.99)?;
            at_most("share of the mass that swings", structure.mass_share, 0.9)?;
        }
        let Some(bandwidth) = self.velocity_loop_rad_s else {
            let plain = Self {
                kv_1_s: Self::IDEAL.kv_1_s,
                gain_error: 0.0,
                velocity_feed_forward: 1.0,
                acceleration_feed_forward: 1.0,
                ..*self
            };
            return if plain == Self::IDEAL { Ok(()) } else { Err(DescriptionError::NoVelocityLoop { joint }) };
        };
        positive("inertia", inertia)?;
        // A gain that takes more than the whole deviation of a step away swings.
        at_most("velocity loop bandwidth (rad/s)", bandwidth, 1.0 / step_s)?;
        if self.velocity_integral_s.is_none() && self.coulomb_friction > 0.0 {
            return Err(DescriptionError::NoIntegral { joint });
        }
        Ok(())
    }
}
