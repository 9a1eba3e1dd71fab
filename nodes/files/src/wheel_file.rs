//! What files say about the wheel's surroundings and its dressing.

use super::ConfigError;
use super::yaml::Document;
use camwright::job::dressing::DressingSpec;
use camwright::job::grinding::{ObstacleSpec, WheelPower, WheelWish};
use camwright::machine::description::ThermalDescription;
use camwright::machine::fixture::{Dresser, Extent};
use camwright::math::units::mm_from_um;
use serde::Deserialize;

/// Bound on the power of the wheel's spindle.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WheelPowerFile {
    most_w: f64,
    specific_energy_j_mm3: f64,
    rubbing_n_mm2: f64,
}

impl WheelPowerFile {
    pub(super) fn spec(&self) -> WheelPower {
        WheelPower {
            most_w: self.most_w,
            specific_energy_j_mm3: self.specific_energy_j_mm3,
            rubbing_n_mm2: self.rubbing_n_mm2,
        }
    }
}

/// The dresser of a machine.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DresserFile {
    x_mm: f64,
    z_mm: f64,
    width_mm: f64,
    infeed_speed_mm_s: f64,
    traverse_speed_mm_s: f64,
    dwell_s: f64,
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

    /// Its values with their ranges, by key.
    pub(super) fn ranges(&self, z: (f64, f64), x: (f64, f64)) -> [(&'static str, f64, f64, f64); 7] {
        [
            ("dresser.x_mm", self.x_mm, x.0, x.1),
            ("dresser.z_mm", self.z_mm, z.0, z.1),
            ("dresser.width_mm", self.width_mm, 0.1, 100.0),
            ("dresser.infeed_speed_mm_s", self.infeed_speed_mm_s, 1e-3, 1e3),
            ("dresser.traverse_speed_mm_s", self.traverse_speed_mm_s, 1e-3, 1e3),
            ("dresser.dwell_s", self.dwell_s, 0.0, 600.0),
            ("dresser.max_depth_um", self.max_depth_um, 1e-3, 1e4),
        ]
    }
}

/// How the wheelhead grows.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ThermalFile {
    pub(super) growth_um: f64,
    pub(super) time_constant_s: f64,
    #[serde(default)]
    start: StartFile,
}

/// How a machine that has never run begins.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
enum StartFile {
    #[default]
    Cold,
    Warm,
}

impl ThermalFile {
    pub(super) fn thermal(&self) -> ThermalDescription {
        let start_share = match self.start {
            StartFile::Cold => 0.0,
            StartFile::Warm => 1.0,
        };
        ThermalDescription { growth_mm: mm_from_um(self.growth_um), time_constant_s: self.time_constant_s, start_share }
    }
}

/// A body of revolution on the table.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ExtentFile {
    from_mm: f64,
    to_mm: f64,
    radius_mm: f64,
}

impl ExtentFile {
    pub(super) fn extent(&self) -> Extent {
        Extent { from_mm: self.from_mm, to_mm: self.to_mm, radius_mm: self.radius_mm }
    }

    /// Whether it is a body, with the key of what is wrong.
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
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DressingFile {
    every_lobes: Option<u32>,
    every_parts: Option<u32>,
    predicted_error_um: Option<f64>,
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

/// What the part has besides its lobes.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ObstacleFile {
    name: String,
    from_mm: f64,
    to_mm: f64,
    radius_mm: f64,
}

impl ObstacleFile {
    pub(super) fn spec(&self) -> ObstacleSpec {
        let extent = Extent { from_mm: self.from_mm, to_mm: self.to_mm, radius_mm: self.radius_mm };
        ObstacleSpec { name: self.name.clone(), extent }
    }
}

/// What lobes and passes say about wheels, in the order of the file.
pub(super) fn wishes<'a>(of: impl Iterator<Item = (&'static str, &'a str, Option<f64>)>) -> Vec<WheelWish> {
    let wish = |(kind, name, radius): (_, _, Option<f64>)| {
        Some(WheelWish { of: format!("{kind} {name}"), radius_mm: radius? })
    };
    of.filter_map(wish).collect()
}
