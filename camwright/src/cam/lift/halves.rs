// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Half tables, as cam designers hand them over: one flank each, the nose first, down to the base circle.
//!
//! ```text
//!   opening flank read backwards │ nose │ closing flank      one flank alone is mirrored;
//!   … 3 2 1 ─────────────────────┤  0   ├── 1 2 3 …          what neither covers is the base circle
//! ```

use super::check;
use super::declaration::{LiftDeclaration, LiftRow};
use super::error::LiftError;
use super::row_spacing::{AngleSequence, Placement, block_of, walk};
use super::table::LiftTable;
use super::warning::{self, LiftWarning};
use alloc::vec;
use alloc::vec::Vec;

/// One flank, placed: slot i is i steps from the nose.
struct PlacedFlank<'a> {
    rows: &'a [LiftRow],
    step: f64,
    blocks: usize,
    slots: Vec<Option<usize>>,
}

impl PlacedFlank<'_> {
    fn lift_mm(&self, slot: usize) -> Option<f64> {
        self.slots.get(slot).copied().flatten().map(|row| self.rows[row].value_mm)
    }
}

/// The rows of a whole turn from the closing flank and the opening flank (`None`: the closing flank mirrored), whose nose
/// stands at cam angle `nose_deg`. Angles of the rows are those of the declaration, from the nose on; mirrored and
/// filled-in rows have line 0. Then [`super::LiftTable::read`] looks at the whole.
///
/// # Errors
/// Everything that is wrong with either flank, row by row.
pub fn whole_turn(
    closing: &[LiftRow],
    opening: Option<&[LiftRow]>,
    nose_deg: f64,
    declaration: &LiftDeclaration,
) -> Result<(Vec<LiftRow>, Vec<LiftWarning>), Vec<LiftError>> {
    let mut findings = Vec::new();
    let mut doubts = Vec::new();
    let second = half(closing, declaration, &mut findings, &mut doubts);
    let first = opening.and_then(|rows| half(rows, declaration, &mut findings, &mut doubts));
    let (Some(second), true) = (second, opening.is_none() || first.is_some()) else {
        return Err(sorted(findings));
    };
    if let Some(first) = first.as_ref().filter(|first| first.blocks != second.blocks) {
        let (opening_deg, closing_deg) = (first.step, second.step);
        let line = second.rows[0].line;
        findings.push(LiftError::HalvesStep { line, opening_deg, closing_deg });
        return Err(sorted(findings));
    }
    let (blocks, step) = (second.blocks, second.step);
    let bound_mm = (0.5 * declaration.resolution_mm).max(declaration.smooth_within_mm);
    // Where both flanks have a row: at the nose, and opposite it if they go so far.
    let opposite = (blocks.is_multiple_of(2)).then_some(blocks / 2);
    for slot in [Some(0), opposite].into_iter().flatten() {
        let Some((first, closing_mm)) = first.as_ref().zip(second.lift_mm(slot)) else { continue };
        let Some(opening_mm) = first.lift_mm(slot).filter(|lift| (lift - closing_mm).abs() > bound_mm) else {
            continue;
        };
        let line = second.slots[slot].map_or(0, |row| second.rows[row].line);
        findings.push(LiftError::HalvesDisagree { line, opening_mm, closing_mm, bound_mm });
    }
    let turn = declaration.angle_unit.turn_deg();
    let cam_step = step * 360.0 / turn;
    let nose = block_of(nose_deg, cam_step);
    let off_deg = nose_deg - nose as f64 * cam_step;
    if off_deg.is_nan() || off_deg.abs() > super::row_spacing::ANGLE_TOLERANCE * cam_step {
        findings.push(LiftError::ZeroOffStep { zero_deg: nose_deg, off_deg, step_deg: cam_step });
    }
    if !findings.is_empty() {
        return Err(sorted(findings));
    }
    let nose = usize::try_from(nose.rem_euclid(i64::try_from(blocks).unwrap_or(i64::MAX))).unwrap_or(0);
    let base = |block: usize| LiftRow { line: 0, angle_deg: Some(turn * block as f64 / blocks as f64), value_mm: 0.0 };
    let mut rows: Vec<LiftRow> = (0..blocks).map(base).collect();
    let mut put = |block: usize, half: &PlacedFlank<'_>, slot: usize, mirrored: bool| {
        let Some(row) = half.slots[slot] else { return };
        rows[block].value_mm = half.rows[row].value_mm;
        rows[block].line = if mirrored { 0 } else { half.rows[row].line };
    };
    let flank = first.as_ref().unwrap_or(&second);
    for slot in 0..flank.slots.len().min(blocks) {
        put((nose + blocks - slot) % blocks, flank, slot, first.is_none());
    }
    for slot in 0..second.slots.len().min(blocks) {
        put((nose + slot) % blocks, &second, slot, false);
    }
    Ok((rows, doubts))
}

/// Everything that can be said about one flank alone: what [`whole_turn`] would refuse it for, and its doubts.
#[must_use]
pub fn check_flank(rows: &[LiftRow], declaration: &LiftDeclaration) -> (Vec<LiftError>, Vec<LiftWarning>) {
    let (mut findings, mut doubts) = (Vec::new(), Vec::new());
    half(rows, declaration, &mut findings, &mut doubts);
    (sorted(findings), doubts)
}

fn sorted(mut findings: Vec<LiftError>) -> Vec<LiftError> {
    findings.sort_by_key(|finding| finding.line().unwrap_or(0));
    findings
}

/// Checks one flank; `None` and at least one finding if it cannot be placed.
fn half<'a>(
    rows: &'a [LiftRow],
    declaration: &LiftDeclaration,
    findings: &mut Vec<LiftError>,
    doubts: &mut Vec<LiftWarning>,
) -> Option<PlacedFlank<'a>> {
    const MIN_ROWS: usize = 4;
    if let Some(error) = check::bad_resolution(declaration) {
        findings.push(error);
        return None;
    }
    if rows.len() < MIN_ROWS {
        findings.push(LiftError::TooFewRows { count: rows.len(), min: MIN_ROWS });
        return None;
    }
    if rows.iter().all(|row| row.angle_deg.is_none()) {
        findings.push(LiftError::AngleMissing { line: rows[0].line });
        return None;
    }
    if !rows.iter().any(|row| row.angle_deg.is_some_and(f64::is_finite)) {
        let line = rows[0].line;
        findings.push(LiftError::NotFinite { line, what: "the angle", value: f64::NAN });
        return None;
    }
    let before = findings.len();
    let turn = declaration.angle_unit.turn_deg();
    let walk = walk(rows, turn, declaration.blocks, findings);
    let slots = walk.slots();
    let AngleSequence { step, blocks, angles } = walk;
    if blocks > LiftTable::MAX_BLOCKS {
        findings.push(LiftError::TooManyRows { count: blocks, max: LiftTable::MAX_BLOCKS });
        return None;
    }
    if angles[0].abs() > super::row_spacing::ANGLE_TOLERANCE * step {
        findings.push(LiftError::HalfStart { line: rows[0].line, angle_deg: angles[0] });
    }
    let max_deg = 0.5 * turn;
    if let Some(at) = angles.iter().position(|angle| *angle > max_deg + 0.5 * step) {
        findings.push(LiftError::HalfSpan { line: rows[at].line, angle_deg: angles[at], max_deg });
    }
    let bound_mm = (0.5 * declaration.resolution_mm).max(declaration.smooth_within_mm);
    let (nose, last) = (rows[0], rows[rows.len() - 1]);
    let finite = rows.iter().filter(|row| row.value_mm.is_finite());
    let highest = finite.max_by(|a, b| a.value_mm.total_cmp(&b.value_mm)).unwrap_or(&nose);
    if highest.value_mm > nose.value_mm + bound_mm * (1.0 + 1e-9) {
        let (line, lift_mm) = (highest.line, highest.value_mm);
        findings.push(LiftError::NoseNotFirst { line, lift_mm, nose_line: nose.line, nose_mm: nose.value_mm });
    }
    let reaches_opposite = (angles[angles.len() - 1] - max_deg).abs() < 0.75 * step;
    if !reaches_opposite && last.value_mm > bound_mm * (1.0 + 1e-9) {
        findings.push(LiftError::FlankEndsHigh { line: last.line, lift_mm: last.value_mm, bound_mm });
    }
    let lifted = (rows.iter().zip(&angles)).rev().find(|(row, _)| row.value_mm > bound_mm);
    doubts.extend(lifted.and_then(|(row, angle)| warning::flank(row.line, *angle, declaration.angle_unit)));
    if findings.len() > before {
        // It will not become part of a whole turn, whose check would look at its values.
        let slots = if slots.is_empty() { vec![None] } else { slots };
        let placement = Placement { blocks: usize::MAX, first: 0, slots, repeats_first: false };
        findings.extend(check::part(rows, &placement, declaration));
        return None;
    }
    Some(PlacedFlank { rows, step, blocks, slots })
}
