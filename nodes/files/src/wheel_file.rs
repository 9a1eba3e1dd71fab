// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Surroundings and dressing of the wheel in files.

use super::ConfigError;
use super::yaml::Document;
use camwright::job::dressing::DressingSpec;
use camwright::job::grinding::{ObstacleSpec, Subject, WheelPower, WheelRequirement};
use camwright::machine::axial_profile::AxialProfile;
use camwright::machine::description::ThermalDescription;
use camwright::machine::fixture::{Dresser, Extent};
use camwright::math::units::mm_from_um;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Bound on the power of the wheel's spindle.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct WheelPowerFile {
    /// Maximum power of the wheel spindle: width * (specific energy * Q' + rubbing * contact length * wheel
    /// speed).
    #[schemars(range(min = 1e-6, max = 1e9))]
    most_w: f64,
    /// Energy per removed volume.
    #[schemars(range(min = 1e-6, max = 1e6))]
    specific_energy_j_mm3: f64,
    /// Force of rubbing per contact area.
    #[schemars(range(min = 1e-6, max = 1e6))]
    rubbing_n_mm2: f64,
}

impl WheelPowerFile {
    pub(super) fn spec(&self) -> WheelPower {
        WheelPower {
            max_w: self.most_w,
            specific_energy_j_mm3: self.specific_energy_j_mm3,
            rubbing_n_mm2: self.rubbing_n_mm2,
        }
    }
}

/// Profile of a wheel's rim.
#[derive(Debug, Clone, Copy, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RimFile {
    /// Radius of the rim at the end of its width towards the tailstock minus that at the other end. A lobe gets the opposite taper.
    #[schemars(range(min = -500.0, max = 500.0))]
    #[serde(default)]
    taper_um: f64,
    /// Radius in the middle minus the mean of both ends, of a parabola. A lobe gets the opposite crown.
    #[schemars(range(min = -500.0, max = 500.0))]
    #[serde(default)]
    crown_um: f64,
}

impl RimFile {
    pub(super) fn profile(self) -> AxialProfile {
        AxialProfile { taper_mm: mm_from_um(self.taper_um), crown_mm: mm_from_um(self.crown_um) }
    }
}

/// The dresser of a machine.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct DresserFile {
    /// Distance of the dresser's rim from the spindle axis; within the soft limits of X.
    #[schemars(range(min = -1e5, max = 1e5))]
    pub(super) x_mm: f64,
    /// Position of `z_axis` with the dresser in front of the wheel; within the soft limits of Z.
    #[schemars(range(min = -1e5, max = 1e5))]
    pub(super) z_mm: f64,
    /// Width of the dresser; the table travels 1 mm beyond the wheel on either side.
    #[schemars(range(min = 0.1, max = 100.0))]
    width_mm: f64,
    /// Speed of X on the last 0.5 mm before the dresser.
    #[schemars(range(min = 1e-3, max = 1e3))]
    infeed_speed_mm_s: f64,
    /// Speed of the table past the dresser.
    #[schemars(range(min = 1e-3, max = 1e3))]
    traverse_speed_mm_s: f64,
    /// Time after a dress.
    #[schemars(range(min = 0.0, max = 600.0))]
    dwell_s: f64,
    /// Maximum radius that one dress removes, wear included.
    #[schemars(range(min = 1e-3, max = 1e4))]
    max_depth_um: f64,
}

impl DresserFile {
    pub(super) fn dresser(&self) -> Dresser {
        Dresser {
            x_mm: self.x_mm,
            z_mm: self.z_mm,
            width_mm: self.width_mm,
            infeed_speed_mm_s: self.infeed_speed_mm_s,
            traverse_speed_mm_s: self.traverse_speed_mm_s,
            dwell_s: self.dwell_s,
            max_depth_mm: mm_from_um(self.max_depth_um),
        }
    }
}

/// Growth of the wheelhead.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ThermalFile {
    /// G: the wheelhead grows towards the part by G (1 - exp(-t/tau)) while its spindle runs.
    #[schemars(range(min = -1000.0, max = 1000.0))]
    pub(super) growth_um: f64,
    /// Time constant tau of the growth.
    #[schemars(range(min = 1.0, max = 1e6))]
    pub(super) time_constant_s: f64,
    /// State of a machine without a state file.
    #[serde(default)]
    start: ThermalStartFile,
}

/// Initial state of a machine that has never run.
#[derive(Debug, Clone, Copy, Default, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum ThermalStartFile {
    #[default]
    /// Without growth.
    Cold,
    /// Grown by G, with the wheel dressed in that state.
    Warm,
}

impl ThermalFile {
    pub(super) fn thermal(&self) -> ThermalDescription {
        let start_share = match self.start {
            ThermalStartFile::Cold => 0.0,
            ThermalStartFile::Warm => 1.0,
        };
        ThermalDescription { growth_mm: mm_from_um(self.growth_um), time_constant_s: self.time_constant_s, start_share }
    }
}

/// A body of revolution on the table.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ExtentFile {
    /// Begin of the body, as a position of `z_axis` with the wheel's middle in front of it.
    #[schemars(range(min = -1e5, max = 1e5))]
    from_mm: f64,
    /// End of the body.
    #[schemars(range(min = -1e5, max = 1e5))]
    to_mm: f64,
    /// Radius of the body about the spindle axis.
    #[schemars(range(min = 1e-6, max = 1e4))]
    radius_mm: f64,
}

impl ExtentFile {
    pub(super) fn extent(&self) -> Extent {
        Extent { from_mm: self.from_mm, to_mm: self.to_mm, radius_mm: self.radius_mm }
    }

    /// Checks that it is a body; an error names the wrong key.
    pub(super) fn check(&self, document: &Document, key: &str) -> Result<(), ConfigError> {
        if self.extent().is_body() {
            return Ok(());
        }
        let Self { from_mm, to_mm, radius_mm } = self;
        let message = format!(
            "{key} reaches from {from_mm} to {to_mm} mm with a radius of {radius_mm} mm; it must begin before it ends and \
             have a radius above 0"
        );
        Err(document.error(key, message))
    }
}

/// When a job dresses the wheel.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct DressingFile {
    /// Dresses before a lobe after this many lobes.
    #[schemars(range(min = 1, max = 1000000))]
    every_lobes: Option<u32>,
    /// Dresses before a part after this many parts.
    #[schemars(range(min = 1, max = 1000000))]
    every_parts: Option<u32>,
    /// Dresses before a lobe whose form error from wheel wear would exceed this; needs `wheel.grinding_ratio`.
    #[schemars(range(min = 1e-6, max = 1e6))]
    predicted_error_um: Option<f64>,
    /// Depth that a dress removes from the radius of the worn wheel.
    #[schemars(range(min = 1e-6, max = 1e4))]
    depth_um: f64,
}

impl DressingFile {
    pub(super) fn spec(&self) -> DressingSpec {
        DressingSpec {
            every_lobes: self.every_lobes,
            every_parts: self.every_parts,
            predicted_error_mm: self.predicted_error_um.map(mm_from_um),
            depth_mm: mm_from_um(self.depth_um),
        }
    }
}

/// Feature of the part in addition to its lobes.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ObstacleFile {
    /// Name of the obstacle, for messages.
    #[schemars(length(max = 64))]
    name: String,
    /// Begin of the obstacle, as a position of `z_axis`.
    #[schemars(range(min = -1e5, max = 1e5))]
    from_mm: f64,
    /// End of the obstacle.
    #[schemars(range(min = -1e5, max = 1e5))]
    to_mm: f64,
    /// Radius of the obstacle about the spindle axis.
    #[schemars(range(min = 1e-6, max = 1e4))]
    radius_mm: f64,
}

impl ObstacleFile {
    pub(super) fn spec(&self) -> ObstacleSpec {
        let extent = Extent { from_mm: self.from_mm, to_mm: self.to_mm, radius_mm: self.radius_mm };
        ObstacleSpec { name: self.name.clone(), extent }
    }
}

/// Wheel requirements of lobes and passes, in the order of the file.
pub(super) fn wishes(of: impl Iterator<Item = (Subject, Option<f64>)>) -> Vec<WheelRequirement> {
    of.filter_map(|(of, radius_mm)| Some(WheelRequirement { of, radius_mm: radius_mm? })).collect()
}
