//! What a machine file says about a servo drive. Keys of a slide and of a spindle differ in their units.

use super::ConfigError;
use super::machine_file::RangeCheck;
use camwright::machine::description::{DriveSettings, Structure};
use camwright::math::units::{TURN_RAD, mm_from_um, rad_from_deg};
use serde::Deserialize;

/// The first mode of what an axis carries.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct StructureFile {
    frequency_hz: f64,
    #[serde(default = "steel")]
    damping: f64,
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
        #[derive(Debug, Deserialize)]
        #[serde(deny_unknown_fields)]
        pub(super) struct $name {
            kv_1_s: f64,
            #[serde(default)]
            kv_error_percent: f64,
            velocity_feed_forward: f64,
            acceleration_feed_forward: f64,
            #[serde(default)]
            friction_feed_forward: f64,
            velocity_loop_hz: Option<f64>,
            velocity_integral_ms: Option<f64>,
            $force: Option<f64>,
            #[serde(default)]
            $coulomb: f64,
            #[serde(default)]
            $viscous: f64,
            #[serde(default)]
            $backlash: f64,
            structure: Option<StructureFile>,
            #[serde(default = "one")]
            encoder_step_counts: f64,
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

            /// `key` is that of the drive.
            pub(super) fn check(&self, key: &str, within: &RangeCheck<'_>) -> Result<(), ConfigError> {
                let within = |name: &str, value: f64, low: f64, high: f64| {
                    within(&format!("{key}.{name}"), value, low, high)
                };
                within("kv_1_s", self.kv_1_s, 1.0, 2000.0)?;
                within("kv_error_percent", self.kv_error_percent, -90.0, 100.0)?;
                within("velocity_feed_forward", self.velocity_feed_forward, 0.0, 1.0)?;
                within("acceleration_feed_forward", self.acceleration_feed_forward, 0.0, 1.0)?;
                within("friction_feed_forward", self.friction_feed_forward, 0.0, 1.0)?;
                for (name, value, low, high) in [
                    ("velocity_loop_hz", self.velocity_loop_hz, 1.0, 5000.0),
                    ("velocity_integral_ms", self.velocity_integral_ms, 0.1, 1e4),
                    (stringify!($force), self.$force, 1e-3, 1e7),
                ] {
                    value.map_or(Ok(()), |value| within(name, value, low, high))?;
                }
                within(stringify!($coulomb), self.$coulomb, 0.0, 1e5)?;
                within(stringify!($viscous), self.$viscous, 0.0, 1e6)?;
                within(stringify!($backlash), self.$backlash, 0.0, 1e3)?;
                within("encoder_step_counts", self.encoder_step_counts, 0.0, 1e4)?;
                within("encoder_noise_counts", self.encoder_noise_counts, 0.0, 1e3)?;
                let Some(structure) = &self.structure else { return Ok(()) };
                within("structure.frequency_hz", structure.frequency_hz, 5.0, 2000.0)?;
                within("structure.damping", structure.damping, 0.0, 0.9)?;
                within("structure.mass_share", structure.mass_share, 0.0, 0.9)
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
