// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Supports of the part in machine and job files.

use super::ConfigError;
use super::contact_file::PER_MM;
use super::yaml::Document;
use camwright::job::part_support::{HeadstockGrip, PartSupport};
use camwright::machine::description::{SteadyRest, WorkholdingDescription};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// N m/rad to N mm/rad.
const N_MM_PER_N_M: f64 = 1e3;

/// Gigapascal to N/mm².
const N_MM2_PER_GPA: f64 = 1e3;

/// Radial stiffness of the supports of a machine.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct WorkholdingFile {
    /// Stiffness of the headstock at its centre or chuck.
    #[schemars(range(min = 0.1, max = 1e4))]
    headstock_stiffness_n_um: f64,
    /// Moment per angle by which a part tilts in the chuck. Default: no chuck, parts between centres only.
    #[schemars(range(min = 1.0, max = 1e12))]
    chuck_tilt_n_m_rad: Option<f64>,
    /// Stiffness of the tailstock at its centre. Default: no tailstock.
    #[schemars(range(min = 0.1, max = 1e4))]
    tailstock_stiffness_n_um: Option<f64>,
    /// Steady rest that jobs may use. Default: none.
    steady_rest: Option<SteadyRestFile>,
}

/// Steady rest of a machine.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct SteadyRestFile {
    /// Stiffness of the jaws.
    #[schemars(range(min = 0.1, max = 1e4))]
    stiffness_n_um: f64,
    /// Width of the jaws along the part.
    #[schemars(range(min = 0.1, max = 1e3))]
    jaw_width_mm: f64,
}

impl WorkholdingFile {
    pub(super) fn workholding(&self) -> WorkholdingDescription {
        WorkholdingDescription {
            headstock_n_mm: PER_MM * self.headstock_stiffness_n_um,
            chuck_tilt_n_mm_rad: self.chuck_tilt_n_m_rad.map(|n_m_rad| N_MM_PER_N_M * n_m_rad),
            tailstock_n_mm: self.tailstock_stiffness_n_um.map(|n_um| PER_MM * n_um),
            steady_rest: self
                .steady_rest
                .as_ref()
                .map(|rest| SteadyRest { n_mm: PER_MM * rest.stiffness_n_um, jaw_width_mm: rest.jaw_width_mm }),
        }
    }

    /// Refuses supports on a machine where nothing deflects.
    pub(super) fn check(&self, document: &Document, has_contact: bool) -> Result<(), ConfigError> {
        match has_contact {
            true => Ok(()),
            false => Err(document.error(
                "workholding",
                "workholding needs contact: without it the machine is rigid and no force deflects the part",
            )),
        }
    }
}

/// Support of the part by the machine's `workholding`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PartSupportFile {
    /// Diameter of the part as a round shaft.
    #[schemars(range(min = 1.0, max = 1e3))]
    diameter_mm: f64,
    /// Young's modulus of the part.
    #[schemars(range(min = 1.0, max = 1e3))]
    #[serde(default = "steel_gpa")]
    modulus_gpa: f64,
    /// Position of `z_axis` at the headstock's centre, or at the front of the jaws of its chuck.
    #[schemars(range(min = -1e4, max = 1e4))]
    headstock_z_mm: f64,
    /// Length from there to the centre of the tailstock; without tailstock the free length.
    #[schemars(range(min = 10.0, max = 1e4))]
    length_mm: f64,
    /// Hold of the part at the headstock.
    #[serde(default)]
    headstock: GripFile,
    /// The tailstock holds the other end.
    #[serde(default = "yes")]
    tailstock: bool,
    /// Position of `z_axis` at the middle of the steady rest's jaws. Default: not in use.
    #[schemars(range(min = -1e4, max = 1e4))]
    steady_rest_z_mm: Option<f64>,
}

/// Hold of the part at the headstock.
#[derive(Debug, Default, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum GripFile {
    #[default]
    /// A centre, which resists radial force only.
    Centre,
    /// A chuck, which also resists tilt.
    Chuck,
}

/// Steel.
const fn steel_gpa() -> f64 {
    210.0
}

const fn yes() -> bool {
    true
}

impl PartSupportFile {
    pub(super) fn support(&self) -> PartSupport {
        PartSupport {
            diameter_mm: self.diameter_mm,
            modulus_n_mm2: N_MM2_PER_GPA * self.modulus_gpa,
            headstock_z_mm: self.headstock_z_mm,
            length_mm: self.length_mm,
            grip: match self.headstock {
                GripFile::Centre => HeadstockGrip::Centre,
                GripFile::Chuck => HeadstockGrip::Chuck,
            },
            tailstock: self.tailstock,
            steady_rest_z_mm: self.steady_rest_z_mm,
        }
    }
}
