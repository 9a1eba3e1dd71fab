// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Tables of the contour itself, radii over the azimuth or points, as lifts of a point that runs round it above its smallest radius.

use super::lift_text::{Content, Printed};
use super::table_files::TableFiles;
use super::{ConfigError, FileLocation};
use camwright::cam::lift::points::{ContourPoint, rows_of};
use camwright::cam::outline::fit::{self, FittedOutline, OutlineFitError};
use std::path::Path;

/// Share of a turn that the files of a table hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Orientation {
    Whole,
    Half,
}

/// A point this near to the axis of a mirror is its own image (mm).
const ON_THE_MIRROR_MM: f64 = 1e-9;

/// Makes the tables of a cam lifts above its smallest radius, and says that (mm); `None` where they are lifts already.
pub(super) fn make_lifts(
    files: &mut [(&Path, &mut Printed)],
    turn: Orientation,
) -> Result<Option<f64>, Vec<ConfigError>> {
    let Some(content) = files.first().map(|(_, printed)| printed.content) else { return Ok(None) };
    if let Some((path, _)) = files.iter().find(|(_, printed)| printed.content != content) {
        return Err(vec![ConfigError::at(FileLocation::file(path), "the two flanks are not tables of the same")]);
    }
    match content {
        Content::Lift => return Ok(None),
        Content::Radius => {}
        Content::Deviation => {
            let path = files[0].0;
            let message = "holds deviations, as a report does; a lift, a radius or points are needed";
            return Err(vec![ConfigError::at(FileLocation::file(path), message)]);
        }
        Content::Points => {
            for (path, printed) in files.iter_mut() {
                lay_out(path, printed, turn)?;
            }
        }
    }
    let line = |line: usize| u64::try_from(line).unwrap_or(0);
    let not_positive: Vec<ConfigError> = (files.iter())
        .flat_map(|(path, printed)| {
            let bad = printed.rows.iter().filter(|row| row.value_mm <= 0.0);
            bad.map(|row| {
                let message = format!("the radius is {} mm; it must be a positive number", row.value_mm);
                ConfigError::at(FileLocation::line(path, line(row.line)), message)
            })
        })
        .collect();
    if !not_positive.is_empty() {
        return Err(not_positive);
    }
    let radii = files.iter().flat_map(|(_, printed)| &printed.rows).map(|row| row.value_mm);
    let base_mm = radii.filter(|radius| radius.is_finite()).fold(f64::INFINITY, f64::min);
    for (_, printed) in files.iter_mut() {
        for row in &mut printed.rows {
            row.value_mm -= base_mm;
        }
        if content == Content::Points {
            printed.round_resampled();
        }
    }
    // Without a finite radius the table says why it is none.
    Ok(Some(base_mm))
}

/// Place of a table's points in the cam, and the tolerance of lines and arcs through them.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointsInCam {
    pub orientation: Orientation,
    /// Cam angle of the file's azimuth 0 (deg).
    pub turned_deg: f64,
    /// Azimuths count against the cam angle.
    pub mirrored: bool,
    pub tolerance_mm: f64,
}

/// Lines and arcs through the points of a table.
pub(super) fn lines_and_arcs(
    path: &Path,
    printed: &Printed,
    place: &PointsInCam,
) -> Result<FittedOutline, Vec<ConfigError>> {
    let files = TableFiles::of_whole(path, printed);
    if !printed.findings.is_empty() {
        return Err(files.errors(Vec::new()));
    }
    let mut points = whole_turn(printed.points.clone(), place.orientation);
    let (sin, cos) = place.turned_deg.to_radians().sin_cos();
    for point in &mut points {
        let (x_mm, y_mm) = (point.x_mm, if place.mirrored { -point.y_mm } else { point.y_mm });
        (point.x_mm, point.y_mm) = (cos * x_mm - sin * y_mm, sin * x_mm + cos * y_mm);
    }
    fit::lines_and_arcs(&points, place.tolerance_mm).map_err(|error| match error {
        OutlineFitError::Points(findings) => files.errors(findings),
        error => vec![files.error(error.line(), &error.to_string())],
    })
}

/// The points of a whole turn: those of a half are mirrored at azimuth 0.
fn whole_turn(mut points: Vec<ContourPoint>, turn: Orientation) -> Vec<ContourPoint> {
    if turn == Orientation::Half {
        let mirrored = points.iter().rev().filter(|point| point.y_mm.abs() > ON_THE_MIRROR_MM);
        let mirrored: Vec<_> = mirrored.map(|point| ContourPoint { y_mm: -point.y_mm, ..*point }).collect();
        points.extend(mirrored);
    }
    points
}

/// Points as rows of radii at even azimuths. Of a half they are mirrored at azimuth 0, and the rows of the half that is left go from the
/// nose there to opposite it.
fn lay_out(path: &Path, printed: &mut Printed, turn: Orientation) -> Result<(), Vec<ConfigError>> {
    let points = whole_turn(std::mem::take(&mut printed.points), turn);
    let rows = rows_of(&points);
    let mut rows = rows.map_err(|findings| TableFiles::of_whole(path, printed).errors(findings))?;
    if turn == Orientation::Half {
        rows.truncate(rows.len() / 2 + 1);
    }
    printed.rows = rows;
    Ok(())
}
