// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Key `nc` of a job: settings of its NC program.

use super::ConfigError;
use super::yaml::Document;
use camwright::gcode::archimedean::Knots;
use camwright::gcode::post::NcControl;
use camwright::gcode::{Dialect, NumberFormat, XValues};
use camwright::math::units::{mm_from_um, rad_from_deg};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `nc` of a job as written; everything has a default.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct NcFile {
    /// Control that runs the program.
    control: ControlFile,
    /// Number of the main program on a control with numbers; subprograms follow.
    program_number: u32,
    /// Decimals of lengths in mm.
    #[schemars(range(min = 1, max = 6))]
    linear_decimals: u32,
    /// Decimals of angles in degrees.
    #[schemars(range(min = 1, max = 6))]
    rotary_decimals: u32,
    /// Meaning of an X value.
    x_values: XValuesFile,
    /// Point that X is programmed for.
    x_of: XOfFile,
    /// Position of the ends of segments. Default: free, in turning jobs `on_curve`, which a control drives
    /// faster.
    knots: Option<KnotsFile>,
    /// Tolerance of passes that leave material. A milling job has a tolerance per pass.
    #[schemars(range(min = 0.01, max = 1000.0))]
    rough_tolerance_um: f64,
    /// Tolerance of passes that leave no material. A milling job has a tolerance per pass.
    #[schemars(range(min = 0.01, max = 1000.0))]
    finish_tolerance_um: f64,
    /// Maximum tolerance for a control that reads blocks slowly. Default: `rough_tolerance_um`; in turning jobs
    /// the tolerance of the pass, and C turns more slowly instead.
    #[schemars(range(min = 0.01, max = 1000.0))]
    widest_tolerance_um: Option<f64>,
    /// Blocks that the control reads per second, over ten of them.
    #[schemars(range(min = 1.0, max = 1e5))]
    most_blocks_s: f64,
    /// Tolerance of the control's rounding between blocks (`G64 P`, `CTOL`). Default: four times the tolerance
    /// of the pass.
    #[schemars(range(min = 0.01, max = 1000.0))]
    path_tolerance_um: Option<f64>,
    /// Angle of C over which the cutter enters and leaves a cam; not in turning jobs.
    #[schemars(range(min = 1.0, max = 360.0))]
    lead_deg: f64,
    /// Number of the tool. A milling job has `tool.number`.
    tool_number: u32,
    /// Speed of the tool's spindle. Default: by the surface speed of the wheel, or `tool.spindle_rpm`.
    spindle_rpm: Option<u32>,
    /// Switches the coolant on.
    coolant: bool,
    /// 1: a positive C turns the part clockwise seen from +Z, -1: against it.
    #[schemars(extend("enum" = [1, -1]))]
    rotation_sense: i8,
}

impl Default for NcFile {
    fn default() -> Self {
        Self {
            control: ControlFile::Linuxcnc,
            program_number: 1000,
            linear_decimals: 4,
            rotary_decimals: 4,
            x_values: XValuesFile::Radius,
            x_of: XOfFile::ToolCentre,
            knots: None,
            rough_tolerance_um: 10.0,
            finish_tolerance_um: 0.5,
            widest_tolerance_um: None,
            most_blocks_s: 500.0,
            path_tolerance_um: None,
            lead_deg: 45.0,
            tool_number: 1,
            spindle_rpm: None,
            coolant: true,
            rotation_sense: 1,
        }
    }
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum ControlFile {
    /// LinuxCNC.
    Linuxcnc,
    /// Fanuc and compatible controls with custom macros.
    Fanuc,
    /// SINUMERIK.
    Siemens,
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum XValuesFile {
    /// Distance from the axis of C.
    Radius,
    /// Twice the distance.
    Diameter,
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum XOfFile {
    /// Centre of the cutter or wheel.
    ToolCentre,
    /// Cutting edge on the line of X.
    CuttingEdge,
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum KnotsFile {
    /// Ends lie on the path.
    OnCurve,
    /// Ends lie anywhere within the tolerance: the fewest segments.
    Free,
}

/// Settings of the NC program of a job.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NcSettings {
    /// The control that runs it.
    pub control: NcControl,
    /// Number of the main program.
    pub program_number: u32,
    /// X is where the cutting edge meets the wheel line, not the cutter's centre.
    pub x_of_edge: bool,
    /// Permitted positions of the knots.
    pub knots: Knots,
    /// Tolerance of passes that leave material (mm).
    pub rough_tolerance_mm: f64,
    /// Tolerance of those that leave none (mm).
    pub finish_tolerance_mm: f64,
    /// Largest tolerance for controls that read too slowly (mm); no pass has less than its own.
    pub widest_tolerance_mm: f64,
    /// Angle of C over which the cutter comes and goes (rad).
    pub lead_rad: f64,
    /// Number of the tool.
    pub tool_number: u32,
    /// Speed of its spindle (1/min), if the job says.
    pub spindle_rpm: Option<u32>,
    /// True if the coolant is on.
    pub coolant: bool,
}

impl NcFile {
    /// Settings of the program.
    pub(super) fn settings(&self, document: &Document) -> Result<NcSettings, ConfigError> {
        self.settings_with(document, Knots::Free, self.rough_tolerance_um)
    }

    /// Settings of the program of a turning job: knots on the path, and no tolerance wider than that of the pass unless the job states it.
    pub(super) fn turning_settings(&self, document: &Document) -> Result<NcSettings, ConfigError> {
        self.settings_with(document, Knots::OnCurve, 0.0)
    }

    /// Settings with defaults for the positions of the knots and for the widest tolerance (µm).
    fn settings_with(&self, document: &Document, knots: Knots, widest_um: f64) -> Result<NcSettings, ConfigError> {
        let x_values = match self.x_values {
            XValuesFile::Radius => XValues::Radius,
            XValuesFile::Diameter => XValues::Diameter,
        };
        let format = NumberFormat::new(self.linear_decimals, self.rotary_decimals, x_values)
            .map_err(|error| document.error("nc", error.to_string()))?;
        Ok(NcSettings {
            control: NcControl {
                dialect: match self.control {
                    ControlFile::Linuxcnc => Dialect::LinuxCnc,
                    ControlFile::Fanuc => Dialect::Fanuc,
                    ControlFile::Siemens => Dialect::Siemens,
                },
                format,
                max_blocks_s: self.most_blocks_s,
                path_tolerance_mm: self.path_tolerance_um.map(mm_from_um),
                rotation_sense: self.rotation_sense,
            },
            program_number: self.program_number,
            x_of_edge: matches!(self.x_of, XOfFile::CuttingEdge),
            knots: match self.knots {
                Some(KnotsFile::OnCurve) => Knots::OnCurve,
                Some(KnotsFile::Free) => Knots::Free,
                None => knots,
            },
            rough_tolerance_mm: mm_from_um(self.rough_tolerance_um),
            finish_tolerance_mm: mm_from_um(self.finish_tolerance_um),
            widest_tolerance_mm: mm_from_um(self.widest_tolerance_um.unwrap_or(widest_um)),
            lead_rad: rad_from_deg(self.lead_deg),
            tool_number: self.tool_number,
            spindle_rpm: self.spindle_rpm,
            coolant: self.coolant,
        })
    }
}
