//! What a job says about the NC program that is made of it: the key `nc`.

use super::ConfigError;
use super::yaml::Document;
use camwright::gcode::archimedean::Knots;
use camwright::gcode::post::Control;
use camwright::gcode::{Dialect, Format, XValues};
use camwright::math::units::{mm_from_um, rad_from_deg};
use serde::Deserialize;

/// `nc` of a job as written; everything has a default.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NcFile {
    control: ControlFile,
    program_number: u32,
    linear_decimals: u32,
    rotary_decimals: u32,
    x_values: XValuesFile,
    x_of: XOfFile,
    knots: KnotsFile,
    rough_tolerance_um: f64,
    finish_tolerance_um: f64,
    widest_tolerance_um: Option<f64>,
    most_blocks_s: f64,
    path_tolerance_um: Option<f64>,
    lead_deg: f64,
    tool_number: u32,
    spindle_rpm: Option<u32>,
    coolant: bool,
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
            knots: KnotsFile::Free,
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

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum ControlFile {
    Linuxcnc,
    Fanuc,
    Siemens,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum XValuesFile {
    Radius,
    Diameter,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum XOfFile {
    ToolCentre,
    CuttingEdge,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum KnotsFile {
    OnCurve,
    Free,
}

/// How a program is made of a job.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NcSettings {
    /// The control that runs it.
    pub control: Control,
    /// Number of the main program.
    pub program_number: u32,
    /// X is where the cutting edge meets the wheel line, not the cutter's centre.
    pub x_of_edge: bool,
    /// Where knots may lie.
    pub knots: Knots,
    /// Tolerance of passes that leave material (mm).
    pub rough_tolerance_mm: f64,
    /// Tolerance of those that leave none (mm).
    pub finish_tolerance_mm: f64,
    /// How large a tolerance may become where the control reads too slowly (mm).
    pub widest_tolerance_mm: f64,
    /// Angle of C over which the cutter comes and goes (rad).
    pub lead_rad: f64,
    /// Number of the tool.
    pub tool_number: u32,
    /// Speed of its spindle (1/min), if the job says.
    pub spindle_rpm: Option<u32>,
    /// Whether there is coolant.
    pub coolant: bool,
}

impl NcFile {
    /// What it means, or everything that is wrong with it.
    pub(super) fn read(&self, document: &Document) -> Result<NcSettings, Vec<ConfigError>> {
        let mut findings = Vec::new();
        for (key, value, low, high) in [
            ("rough_tolerance_um", self.rough_tolerance_um, 0.01, 1000.0),
            ("finish_tolerance_um", self.finish_tolerance_um, 0.01, 1000.0),
            ("widest_tolerance_um", self.widest_tolerance_um.unwrap_or(self.rough_tolerance_um), 0.01, 1000.0),
            ("path_tolerance_um", self.path_tolerance_um.unwrap_or(self.finish_tolerance_um), 0.01, 1000.0),
            ("most_blocks_s", self.most_blocks_s, 1.0, 100_000.0),
            ("lead_deg", self.lead_deg, 1.0, 360.0),
        ] {
            if !(low..=high).contains(&value) {
                findings.push(
                    document.error(&format!("nc.{key}"), format!("{key} is {value}; it must be {low} to {high}")),
                );
            }
        }
        if self.rotation_sense.abs() != 1 {
            let message = format!("rotation_sense is {}; it must be 1 or -1", self.rotation_sense);
            findings.push(document.error("nc.rotation_sense", message));
        }
        let x_values = match self.x_values {
            XValuesFile::Radius => XValues::Radius,
            XValuesFile::Diameter => XValues::Diameter,
        };
        let format = Format::new(self.linear_decimals, self.rotary_decimals, x_values);
        let format = format.map_err(|error| {
            let linear = Format::new(self.linear_decimals, 1, x_values).is_err();
            let key = if linear { "nc.linear_decimals" } else { "nc.rotary_decimals" };
            findings.push(document.error(key, error.to_string()));
        });
        let Some(format) = format.ok().filter(|_| findings.is_empty()) else { return Err(findings) };
        Ok(NcSettings {
            control: Control {
                dialect: match self.control {
                    ControlFile::Linuxcnc => Dialect::LinuxCnc,
                    ControlFile::Fanuc => Dialect::Fanuc,
                    ControlFile::Siemens => Dialect::Siemens,
                },
                format,
                most_blocks_s: self.most_blocks_s,
                path_tolerance_mm: self.path_tolerance_um.map(mm_from_um),
                rotation_sense: self.rotation_sense,
            },
            program_number: self.program_number,
            x_of_edge: matches!(self.x_of, XOfFile::CuttingEdge),
            knots: match self.knots {
                KnotsFile::OnCurve => Knots::OnCurve,
                KnotsFile::Free => Knots::Free,
            },
            rough_tolerance_mm: mm_from_um(self.rough_tolerance_um),
            finish_tolerance_mm: mm_from_um(self.finish_tolerance_um),
            widest_tolerance_mm: mm_from_um(self.widest_tolerance_um.unwrap_or(self.rough_tolerance_um)),
            lead_rad: rad_from_deg(self.lead_deg),
            tool_number: self.tool_number,
            spindle_rpm: self.spindle_rpm,
            coolant: self.coolant,
        })
    }
}
