// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Reports of measuring machines: deviation, lift or radius of one lobe in a table of text.

use super::lift_text::{self, AngleUnitFile, Content, TextFormat};
use super::table_files::TableFiles;
use super::{ConfigError, FileLocation};
use camwright::cam::gauge_report::{ReportKind, ReportedValue};
use camwright::cam::lift::{LiftForm, LiftRow};
use camwright::math::units::rad_from_deg;

/// Declared format of a report.
#[derive(Debug, Clone, Default)]
pub struct ReportFormat {
    /// Names of the columns; none: the header of the file.
    pub columns: Option<Vec<String>>,
    /// Numbers have a decimal comma.
    pub decimal_comma: bool,
    /// The angles count against the cam angle.
    pub mirrored: bool,
    /// Deviations are positive where material is missing.
    pub positive_inward: bool,
}

/// A report as it was read.
#[derive(Debug, Clone)]
pub struct ReportTable {
    pub kind: ReportKind,
    pub values: Vec<ReportedValue>,
}

/// Reads the report of one lobe from a path, or by its name in a folder `reports`.
///
/// # Errors
/// A file that cannot be read, columns that are not known, rows without numbers or angles.
pub fn read(name: &str, format: &ReportFormat) -> Result<ReportTable, Vec<ConfigError>> {
    let located = super::locate::locate("reports", name, "csv", None).map_err(|error| vec![error])?;
    let path = located.path.as_path();
    let refuse = |message: &str| vec![ConfigError::at(FileLocation::file(path), message)];
    let text_format =
        TextFormat { columns: format.columns.clone(), decimal_comma: format.decimal_comma, ..TextFormat::default() };
    let printed = lift_text::read(&located, &text_format)?;
    if !printed.findings.is_empty() {
        return Err(TableFiles::of_whole(path, &printed).errors(Vec::new()));
    }
    let kind = match printed.content {
        Content::Lift => ReportKind::Lift,
        Content::Radius | Content::Points => ReportKind::Radius,
        Content::Deviation => ReportKind::Deviation,
    };
    if printed.form != LiftForm::Absolute {
        return Err(refuse("holds increments; a report needs lifts, radii or deviations"));
    }
    if kind != ReportKind::Deviation && format.positive_inward {
        return Err(refuse("holds lifts or radii; only deviations can be positive inward"));
    }
    let sense = if format.mirrored { -1.0 } else { 1.0 };
    let cam_deg = if printed.angle == AngleUnitFile::Crank { 0.5 } else { 1.0 };
    let sign = if format.positive_inward { -1.0 } else { 1.0 };
    let value = |row: &LiftRow| {
        let angle_rad = sense * cam_deg * rad_from_deg(row.angle_deg?);
        Some(ReportedValue { line: row.line, angle_rad, value_mm: sign * row.value_mm })
    };
    let mut values: Vec<ReportedValue> = printed.rows.iter().filter_map(value).collect();
    if values.len() < printed.rows.len() {
        return Err(refuse("has no column of angles"));
    }
    values.extend(printed.points.iter().map(|point| ReportedValue {
        line: point.line,
        angle_rad: sense * point.y_mm.atan2(point.x_mm),
        value_mm: point.x_mm.hypot(point.y_mm),
    }));
    Ok(ReportTable { kind, values })
}
