// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Servo drive in a machine file. Keys of a slide and of a spindle differ in their units.

use camwright::machine::description::{DriveSettings, Structure};
use camwright::math::units::{TURN_RAD, mm_from_um, rad_from_deg};
use schemars::JsonSchema;
use serde::Deserialize;

/// The first mode of what an axis carries.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct StructureFile {
    /// Frequency of the mode with the slide held.
    #[schemars(range(min = 5.0, max = 2000.0))]
    frequency_hz: f64,
    /// Damping ratio.
    #[schemars(range(min = 0.0, max = 0.9))]
    #[serde(default = "steel")]
    damping: f64,
    /// Share of the moving mass in the mode.
    #[schemars(range(min = 0.0, max = 0.9))]
    #[serde(default = "a_fifth")]
    mass_share: f64,
}

/// Damping of a bolted machine of steel and iron.
fn steel() -> f64 {
    0.04
}

fn a_fifth() -> f64 {
    0.2
}

/// An encoder shows counts.
fn one() -> f64 {
    1.0
}

macro_rules! drive_file {
    ($(#[$doc:meta])* $name:ident, $force:ident, $coulomb:ident, $viscous:ident, $backlash:ident, $si:expr, $play:expr) => {
        $(#[$doc])*
        #[derive(Debug, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub(super) struct $name {
            /// Position loop gain.
            #[schemars(range(min = 1.0, max = 2000.0))]
            kv_1_s: f64,
            /// Error of the acting gain.
            #[schemars(range(min = -90.0, max = 100.0))]
            #[serde(default)]
            kv_error_percent: f64,
            /// Share of the setpoint speed that is fed forward.
            #[schemars(range(min = 0.0, max = 1.0))]
            velocity_feed_forward: f64,
            /// Share of the force of the mass that is fed forward.
            #[schemars(range(min = 0.0, max = 1.0))]
            acceleration_feed_forward: f64,
            /// Share of the friction that is fed forward, by the setpoint speed.
            #[schemars(range(min = 0.0, max = 1.0))]
            #[serde(default)]
            friction_feed_forward: f64,
            /// Bandwidth of the velocity loop, at most one radian per servo step. Default: ideal, and then no other effect of the drive acts.
            #[schemars(range(min = 1.0, max = 5000.0))]
            velocity_loop_hz: Option<f64>,
            /// Integral time of the velocity loop; required with friction. Default: none.
            #[schemars(range(min = 0.1, max = 1e4))]
            velocity_integral_ms: Option<f64>,
            /// Maximum force (torque) of the motor. Default: 1.2 times that of the acceleration limit.
            #[schemars(range(min = 1e-3, max = 1e7))]
            $force: Option<f64>,
            /// Friction against the motion, independent of speed.
            #[schemars(range(min = 0.0, max = 1e5))]
            #[serde(default)]
            $coulomb: f64,
            /// Friction per speed.
            #[schemars(range(min = 0.0, max = 1e6))]
            #[serde(default)]
            $viscous: f64,
            /// Play between encoder and tool.
            #[schemars(range(min = 0.0, max = 1e3))]
            #[serde(default)]
            $backlash: f64,
            /// First mode of the structure on the slide. Default: rigid.
            structure: Option<StructureFile>,
            /// Resolution of the drive's encoder; 0: exact.
            #[schemars(range(min = 0.0, max = 1e4))]
            #[serde(default = "one")]
            encoder_step_counts: f64,
            /// Standard deviation of the encoder's noise.
            #[schemars(range(min = 0.0, max = 1e3))]
            #[serde(default)]
            encoder_noise_counts: f64,
        }

        impl $name {
            /// An ideal velocity loop has no motor, and nothing that is in a motor's way.
            pub(super) fn settings(&self) -> DriveSettings {
                let loops = DriveSettings {
                    kv_1_s: self.kv_1_s,
                    gain_error: 0.01 * self.kv_error_percent,
                    velocity_feed_forward: self.velocity_feed_forward,
                    acceleration_feed_forward: self.acceleration_feed_forward,
                    ..DriveSettings::IDEAL
                };
                let Some(bandwidth_hz) = self.velocity_loop_hz else { return loops };
                DriveSettings {
                    friction_feed_forward: self.friction_feed_forward,
                    velocity_loop_rad_s: Some(bandwidth_hz * TURN_RAD),
                    velocity_integral_s: self.velocity_integral_ms.map(|ms| 1e-3 * ms),
                    max_force: self.$force,
                    coulomb_friction: self.$coulomb,
                    viscous_friction: $si(self.$viscous),
                    backlash: $play(self.$backlash),
                    structure: self.structure.as_ref().map(|structure| Structure {
                        frequency_rad_s: structure.frequency_hz * TURN_RAD,
                        damping: structure.damping,
                        mass_share: structure.mass_share,
                    }),
                    encoder_step_counts: self.encoder_step_counts,
                    encoder_noise_counts: self.encoder_noise_counts,
                    ..loops
                }
            }
        }
    };
}

/// N s/m to N s/mm.
fn per_mm(per_m: f64) -> f64 {
    1e-3 * per_m
}

fn as_it_is(per_rad: f64) -> f64 {
    per_rad
}

drive_file!(
    /// The drive of a slide.
    SlideDriveFile,
    max_force_n,
    coulomb_friction_n,
    viscous_friction_n_s_m,
    backlash_um,
    per_mm,
    mm_from_um
);

drive_file!(
    /// The drive of a spindle.
    SpindleDriveFile,
    max_torque_n_m,
    coulomb_friction_n_m,
    viscous_friction_n_m_s,
    backlash_deg,
    as_it_is,
    rad_from_deg
);
