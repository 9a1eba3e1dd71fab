// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Points of a contour, as drawings and measuring machines give them, made rows of radii at even azimuths.
//!
//! The azimuth goes on from point to point, all the same way, once round the axis; the radius over it is the periodic cubic spline through
//! the points. Rows are twice as dense as points at least, and read like those of any other table: within half a digit of each.

use super::declaration::LiftRow;
use super::error::LiftError;
use super::table::LiftTable;
use crate::math::uneven_cubic::UnevenCubic;
use crate::math::units::{TURN_RAD, deg_from_rad, rad_from_deg};
use alloc::vec::Vec;

/// A point of a contour, in the cam's frame: x towards azimuth 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContourPoint {
    /// Line of the file, for the user who corrects it.
    pub line: usize,
    /// x (mm).
    pub x_mm: f64,
    /// y (mm).
    pub y_mm: f64,
}

/// Largest azimuth between two points (deg): what lies between is guessed beyond it.
pub(super) const MAX_GAP_DEG: f64 = 30.0;

/// Largest radius (mm), as of a lift.
const LARGEST_MM: f64 = 1000.0;

/// Azimuths that differ by less are the same (rad): a billionth of a turn.
const SAME_RAD: f64 = 1e-9 * TURN_RAD;

/// Even divisions of a turn that people use.
const DIVISIONS: [usize; 7] = [360, 720, 1440, 3600, 7200, 14_400, LiftTable::MAX_BLOCKS];

/// Rows of radii (mm) at even azimuths (cam deg) from points of a contour, each with the line of the point before it. A last point that
/// repeats the first is passed over.
///
/// # Errors
/// Numbers that are none, too few points, points on the axis; azimuths that turn back, leave gaps, or go round other than once: each with
/// its line.
pub fn rows_of(points: &[ContourPoint]) -> Result<Vec<LiftRow>, Vec<LiftError>> {
    resampled(&unwrapped_points(points)?)
}

/// Azimuth (rad, rising), radius (mm) and line of every point of a contour, counterclockwise. A last point that repeats the first is
/// passed over. The errors are those of [`rows_of`].
pub(crate) fn unwrapped_points(points: &[ContourPoint]) -> Result<Vec<(f64, f64, usize)>, Vec<LiftError>> {
    let points = match points {
        [first, .., last] if close(first, last) => &points[..points.len() - 1],
        all => all,
    };
    if points.len() < LiftTable::MIN_BLOCKS {
        return Err([LiftError::TooFewRows { count: points.len(), min: LiftTable::MIN_BLOCKS }].into());
    }
    if points.len() > LiftTable::MAX_BLOCKS {
        return Err([LiftError::TooManyRows { count: points.len(), max: LiftTable::MAX_BLOCKS }].into());
    }
    let unusable: Vec<LiftError> = points.iter().filter_map(unusable).collect();
    if !unusable.is_empty() {
        return Err(unusable);
    }
    unwrapped(points)
}

/// Rows at even angles (cam deg) from the periodic cubic spline through angles (rad, rising, less than a turn), values and lines; twice as
/// many at least, each with the line of the row before it.
pub(super) fn resampled(known: &[(f64, f64, usize)]) -> Result<Vec<LiftRow>, Vec<LiftError>> {
    let found: Vec<(f64, f64)> = known.iter().map(|(angle, value, _)| (*angle, *value)).collect();
    let Some(spline) = UnevenCubic::interpolate(&found) else {
        // Angles rise and are finite by now; what is left is a division finer than numbers.
        return Err([LiftError::TooManyRows { count: known.len(), max: LiftTable::MAX_BLOCKS }].into());
    };
    let blocks = DIVISIONS.into_iter().find(|blocks| *blocks >= 2 * known.len()).unwrap_or(LiftTable::MAX_BLOCKS);
    let first_rad = known[0].0;
    let row = |block: usize| {
        let angle_deg = 360.0 * block as f64 / blocks as f64;
        let angle = rad_from_deg(angle_deg);
        let round = first_rad + crate::math::units::wrap_turn(angle - first_rad);
        let before = known.partition_point(|(azimuth, _, _)| *azimuth <= round).max(1) - 1;
        LiftRow { line: known[before].2, angle_deg: Some(angle_deg), value_mm: spline.value(angle) }
    };
    Ok((0..blocks).map(row).collect())
}

/// Returns whether a list ends at its start.
fn close(first: &ContourPoint, last: &ContourPoint) -> bool {
    (first.x_mm - last.x_mm).abs() <= f64::EPSILON * LARGEST_MM
        && (first.y_mm - last.y_mm).abs() <= f64::EPSILON * LARGEST_MM
}

fn unusable(point: &ContourPoint) -> Option<LiftError> {
    let line = point.line;
    for (what, value) in [("x", point.x_mm), ("y", point.y_mm)] {
        if !value.is_finite() {
            return Some(LiftError::NotFinite { line, what, value });
        }
        if value.abs() > LARGEST_MM {
            return Some(LiftError::TooLarge { line, value_mm: value, max_mm: LARGEST_MM });
        }
    }
    // Nearer than a nanometre an azimuth says nothing.
    (libm::hypot(point.x_mm, point.y_mm) < 1e-6).then_some(LiftError::PointOnAxis { line })
}

/// Azimuth (rad, rising), radius (mm) and line of every point, in the direction of growing azimuth.
fn unwrapped(points: &[ContourPoint]) -> Result<Vec<(f64, f64, usize)>, Vec<LiftError>> {
    let azimuth = |point: &ContourPoint| libm::atan2(point.y_mm, point.x_mm);
    let half_turn = |angle: f64| angle - TURN_RAD * libm::round(angle / TURN_RAD);
    let sense = if half_turn(azimuth(&points[1]) - azimuth(&points[0])) < 0.0 { -1.0 } else { 1.0 };
    let mut findings = Vec::new();
    let mut covered = 0.0;
    for i in 0..points.len() {
        let (previous, point) = (&points[i], &points[(i + 1) % points.len()]);
        let step = sense * half_turn(azimuth(point) - azimuth(previous));
        covered += step;
        let line = point.line;
        if step < SAME_RAD {
            let (azimuth_deg, previous_deg) = (deg_from_rad(azimuth(point)), deg_from_rad(azimuth(previous)));
            findings.push(LiftError::AzimuthTurnsBack {
                line,
                azimuth_deg,
                previous_deg,
                previous_line: previous.line,
            });
        } else if step > rad_from_deg(MAX_GAP_DEG) {
            let gap_deg = deg_from_rad(step);
            findings.push(LiftError::PointGap { line, gap_deg, max_deg: MAX_GAP_DEG, previous_line: previous.line });
        }
    }
    let line = points[points.len() - 1].line;
    if findings.is_empty() && (covered - TURN_RAD).abs() > SAME_RAD {
        findings.push(LiftError::NotOnceRound { line, covered_deg: deg_from_rad(covered) });
    }
    if !findings.is_empty() {
        findings.sort_by_key(|finding| finding.line().unwrap_or(0));
        return Err(findings);
    }
    let ordered: Vec<&ContourPoint> = if sense < 0.0 { points.iter().rev().collect() } else { points.iter().collect() };
    let mut at = azimuth(ordered[0]);
    let mut polar = Vec::with_capacity(ordered.len());
    for (i, point) in ordered.iter().enumerate() {
        if i > 0 {
            at += half_turn(azimuth(point) - azimuth(ordered[i - 1]));
        }
        polar.push((at, libm::hypot(point.x_mm, point.y_mm), point.line));
    }
    Ok(polar)
}
