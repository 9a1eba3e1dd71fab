// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Tables of a turned part.

use super::clearance_rows::{ClearanceRow, clearance_rows};
use super::error_location;
use super::prepared::PreparedTurning;
use crate::table::NumberTable;
use camwright::math::units::deg_from_rad;
use camwright::planner::{PlannedPass, TurningError};
use camwright::toolpath::insert_path::InsertPathError;
use camwright_files::ConfigError;

/// Name of the table of clearances.
pub(crate) const CLEARANCE: &str = "clearance";

/// Name of the table of a pass, from 0.
pub(crate) fn insert_path_name(pass: usize) -> String {
    format!("pass_{}/insert_path", pass + 1)
}

/// X and Z of the insert's centre with their derivatives over the turned angle; `z_axis_mm` is where the axis of the machine stands.
pub(crate) fn insert_path_table(pass: &PlannedPass, part_zero_mm: f64) -> NumberTable {
    let rows = pass.path.x().knots().iter().enumerate().map(|(index, [x, x1, x2])| {
        let turned_rad = pass.path.x().at(index);
        let z = pass.path.z_at(turned_rad);
        [deg_from_rad(turned_rad), *x, z.value, *x1, *x2, z.first, z.second, z.value - part_zero_mm]
    });
    let columns = [
        ("turned_deg", "deg"),
        ("x_mm", "mm"),
        ("z_mm", "mm"),
        ("x_mm_rad", "mm/rad"),
        ("x_mm_rad2", "mm/rad²"),
        ("z_mm_rad", "mm/rad"),
        ("z_mm_rad2", "mm/rad²"),
        ("z_axis_mm", "mm"),
    ];
    NumberTable::from_rows(columns, rows)
}

pub(crate) fn clearance_table(rows: &[ClearanceRow]) -> NumberTable {
    let columns = [
        ("turned_deg", "deg"),
        ("clearance_deg", "deg"),
        ("clearance_z_mm", "mm"),
        ("clearance_azimuth_deg", "deg"),
        ("approach_deg", "deg"),
        ("approach_z_mm", "mm"),
        ("approach_azimuth_deg", "deg"),
    ];
    let row = |row: &ClearanceRow| {
        let (a, b) = (row.clearance, row.approach);
        [row.turned_deg, a.angle_deg, a.z_mm, a.azimuth_deg, b.angle_deg, b.z_mm, b.azimuth_deg]
    };
    NumberTable::from_rows(columns, rows.iter().map(row))
}

/// Clearances of a planned part.
///
/// # Errors
/// A surface that has no section in the rake plane.
pub(crate) fn planned_clearance(prepared: &PreparedTurning) -> Result<Vec<ClearanceRow>, ConfigError> {
    clearance_rows(prepared).map_err(|error| {
        let source = InsertPathError::Section(error);
        let error = TurningError::Path { pass: prepared.planned.passes.len(), source };
        error_location::blame(&prepared.job, &prepared.machine, &error)
    })
}
