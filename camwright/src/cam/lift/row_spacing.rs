// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Division of the turn by the rows of a table, with a finding for every angle that does not fit.

use super::declaration::{AngleUnit, LiftDeclaration, LiftForm, LiftRow};
use super::error::LiftError;
use super::table::LiftTable;
use alloc::vec::Vec;

/// Tolerance of a printed angle against the even division, in blocks: 51.43 for 360/7 passes, 51.1 does not. An angle
/// error of this size on a 0.1° table moves the steepest flank by less than a tenth of a micrometre.
pub(super) const ANGLE_TOLERANCE: f64 = 0.005;

/// Position of the rows in the even division of the turn.
#[derive(Debug, Clone)]
pub(super) struct Placement {
    /// Blocks over one turn.
    pub(super) blocks: usize,
    /// Block of the first slot.
    pub(super) first: usize,
    /// Row at each block from the first row on; none where it is missing.
    pub(super) slots: Vec<Option<usize>>,
    /// The last slot repeats the first after a whole turn.
    pub(super) repeats_first: bool,
}

impl Placement {
    /// The slots go once round.
    pub(super) fn is_whole(&self) -> bool {
        self.slots.len() == self.blocks + usize::from(self.repeats_first)
    }
}

/// Assigns the rows of a whole table to the division and reports every angle that does not fit. There is at least one
/// row.
pub(super) fn place(rows: &[LiftRow], declaration: &LiftDeclaration, findings: &mut Vec<LiftError>) -> Placement {
    if rows.iter().all(|row| row.angle_deg.is_none()) {
        return place_without_angles(rows, declaration, findings);
    }
    if !rows.iter().any(|row| row.angle_deg.is_some_and(f64::is_finite)) {
        // Every angle has its own finding; there is nothing to place by.
        findings.extend(angles_missing(rows));
        let slots = (0..rows.len()).map(Some).collect();
        return Placement { blocks: rows.len(), first: 0, slots, repeats_first: false };
    }
    let before = findings.len();
    let turn = declaration.angle_unit.turn_deg();
    let walk = walk(rows, turn, declaration.blocks, findings);
    let AngleSequence { step, blocks, ref angles } = walk;
    let (start, end) = (angles[0], angles[angles.len() - 1]);
    let last_line = rows[rows.len() - 1].line;
    let span = end - start;
    let repeats_first = declaration.form == LiftForm::Absolute && (span - turn).abs() <= ANGLE_TOLERANCE * step;
    let covered = if repeats_first { span } else { span + step };
    let declares = |unit| declaration.angle_unit == unit;
    if covered > turn + 0.5 * step {
        let line = (rows.iter().zip(angles))
            .find(|(_, angle)| **angle - start > turn - 0.5 * step)
            .map_or(last_line, |(row, _)| row.line);
        findings.push(if declares(AngleUnit::CamDegrees) && (covered - 720.0).abs() < 7.2 {
            LiftError::CrankDegrees { line, covered_deg: covered }
        } else {
            LiftError::AngleSpan { line, covered_deg: covered, turn_deg: turn }
        });
    } else if covered < turn - 0.5 * step {
        findings.push(if declares(AngleUnit::CrankDegrees) && (covered - 360.0).abs() < 3.6 {
            LiftError::CamDegrees { line: last_line, covered_deg: covered }
        } else {
            let count = whole((turn - covered) / step);
            let (expected_deg, angle_deg) = (start + covered, start + turn);
            LiftError::MissingBlock { line: last_line, count, expected_deg, angle_deg }
        });
    }
    let rows_per_turn = blocks + usize::from(repeats_first);
    if findings.len() == before && (rows.len() != rows_per_turn || declaration.blocks.is_some_and(|n| n != blocks)) {
        let declared = declaration.blocks.unwrap_or(blocks);
        findings.push(LiftError::BlockCount { line: last_line, count: rows.len(), declared });
    }
    let first = block_of(start, step).rem_euclid(i64::try_from(blocks).unwrap_or(i64::MAX).max(1));
    Placement { blocks, first: usize::try_from(first).unwrap_or(0), slots: walk.slots(), repeats_first }
}

/// One row per block from block 0 on.
fn place_without_angles(rows: &[LiftRow], declaration: &LiftDeclaration, findings: &mut Vec<LiftError>) -> Placement {
    let blocks = declaration.blocks.unwrap_or(rows.len());
    let repeats_first = declaration.form == LiftForm::Absolute && rows.len() == blocks + 1;
    if rows.len() != blocks && !repeats_first {
        let line = rows[rows.len() - 1].line;
        findings.push(LiftError::BlockCount { line, count: rows.len(), declared: blocks });
    }
    Placement { blocks, first: 0, slots: (0..rows.len()).map(Some).collect(), repeats_first }
}

/// Angles in the order of the file, with the even step that most of them keep.
pub(super) struct AngleSequence {
    /// One block (deg of the file).
    pub(super) step: f64,
    /// Blocks over one turn.
    pub(super) blocks: usize,
    /// Angle of every row (deg of the file); where it is missing, one step after the row before.
    pub(super) angles: Vec<f64>,
}

impl AngleSequence {
    /// Row at each block from the first row on. Of two rows at one block the first counts.
    pub(super) fn slots(&self) -> Vec<Option<usize>> {
        let first = block_of(self.angles[0], self.step);
        let max = 2 * LiftTable::MAX_BLOCKS;
        let mut slots = Vec::new();
        for (row, angle) in self.angles.iter().enumerate() {
            let Ok(index) = usize::try_from(block_of(*angle, self.step).saturating_sub(first)) else { continue };
            if index > max {
                continue;
            }
            if index >= slots.len() {
                slots.resize(index + 1, None);
            }
            if slots[index].is_none() {
                slots[index] = Some(row);
            }
        }
        slots
    }
}

/// Walks along the angles: missing ones, duplicates, steps back, gaps, and angles off the even division. At least one row
/// has an angle.
pub(super) fn walk(
    rows: &[LiftRow],
    turn: f64,
    declared: Option<usize>,
    findings: &mut Vec<LiftError>,
) -> AngleSequence {
    let usable = |row: &LiftRow| row.angle_deg.filter(|angle| angle.is_finite());
    let known: Vec<f64> = rows.iter().filter_map(usable).collect();
    let step = nominal_step(&known, turn, declared);
    let blocks = whole((turn / step).min(1e9));
    findings.extend(angles_missing(rows));
    // A row without a usable angle has its own finding; it is taken to stand where the even division has it.
    let leading = rows.iter().take_while(|row| usable(row).is_none()).count() as f64;
    let mut expected = known.first().copied().unwrap_or(0.0) - leading * step;
    let angles: Vec<f64> = rows
        .iter()
        .map(|row| {
            let angle = usable(row).unwrap_or(expected);
            expected = angle + step;
            angle
        })
        .collect();
    let tolerance = ANGLE_TOLERANCE * step;
    let off_step = |angle: f64| angle - step * libm::round(angle / step);
    let uneven = |line, angle_deg, off_deg| LiftError::UnevenAngle { line, angle_deg, off_deg, bound_deg: tolerance };
    // A table with a constant offset is reported once, at its first row; a single bad row is reported at its line.
    let start_off = off_step(angles[0]);
    let mut offs: Vec<f64> = angles.iter().map(|angle| off_step(*angle)).collect();
    offs.sort_by(f64::total_cmp);
    let all_off = start_off.abs() > tolerance && (offs[offs.len() / 2] - start_off).abs() <= tolerance;
    let phase = if all_off { start_off } else { 0.0 };
    if start_off.abs() > tolerance {
        findings.push(uneven(rows[0].line, angles[0], start_off));
    }
    for i in 1..rows.len() {
        let (angle, previous, line) = (angles[i], angles[i - 1], rows[i].line);
        let ahead = angle - previous;
        if ahead.abs() <= tolerance {
            findings.push(LiftError::DuplicateAngle { line, angle_deg: angle, previous_line: rows[i - 1].line });
        } else if ahead < 0.0 {
            findings.push(LiftError::AngleNotIncreasing { line, angle_deg: angle, previous_deg: previous });
        } else if ahead > 1.5 * step {
            let (count, expected_deg) = (whole(ahead / step).saturating_sub(1), previous + step);
            findings.push(LiftError::MissingBlock { line, count, expected_deg, angle_deg: angle });
        } else if off_step(angle - phase).abs() > tolerance {
            findings.push(uneven(line, angle, off_step(angle - phase)));
        }
    }
    AngleSequence { step, blocks, angles }
}

fn angles_missing(rows: &[LiftRow]) -> impl Iterator<Item = LiftError> {
    rows.iter().filter(|row| row.angle_deg.is_none()).map(|row| LiftError::AngleMissing { line: row.line })
}

/// The block: as declared, else the whole division of the turn nearest to the median difference, which neither a missing
/// row nor a duplicate moves.
fn nominal_step(angles: &[f64], turn: f64, declared: Option<usize>) -> f64 {
    if let Some(blocks) = declared.filter(|blocks| *blocks > 0) {
        return turn / blocks as f64;
    }
    if angles.len() < 2 {
        return turn;
    }
    let mut differences: Vec<f64> = angles.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    differences.sort_by(f64::total_cmp);
    let median = differences[differences.len() / 2].max(turn / 1e9);
    let by_median = turn / libm::round(turn / median).max(1.0);
    // Angles rounded to few digits spoil the median of narrow blocks; the whole span of an unbroken table does not.
    let mean = (angles[angles.len() - 1] - angles[0]).abs().max(turn / 1e9) / (angles.len() - 1) as f64;
    let by_mean = turn / libm::round(turn / mean).max(1.0);
    let fits = |step: f64| {
        angles
            .iter()
            .enumerate()
            .all(|(i, angle)| (angle - angles[0] - i as f64 * step).abs() <= ANGLE_TOLERANCE * step)
    };
    if fits(by_mean) { by_mean } else { by_median }
}

/// Nearest block of an angle; saturating.
pub(super) fn block_of(angle_deg: f64, step_deg: f64) -> i64 {
    #[allow(clippy::cast_possible_truncation, reason = "saturates")]
    let block = libm::round(angle_deg / step_deg) as i64;
    block
}

fn whole(value: f64) -> usize {
    #[allow(clippy::cast_possible_truncation, reason = "a count of blocks, saturating")]
    let count = libm::round(value) as usize;
    count
}

impl LiftTable {
    /// The same table with its angles against their direction: the lift at angle a is that at −a before.
    #[must_use]
    pub fn mirrored(mut self) -> Self {
        self.lifts[1..].reverse();
        self
    }

    /// The same table with its angle 0 at the cam angle `zero_deg` (deg).
    ///
    /// # Errors
    /// An angle that is no multiple of the block.
    pub fn turned_by(mut self, zero_deg: f64) -> Result<Self, LiftError> {
        let step_deg = 360.0 / self.blocks() as f64;
        let turned = block_of(zero_deg, step_deg);
        let off_deg = zero_deg - turned as f64 * step_deg;
        if off_deg.is_nan() || off_deg.abs() > ANGLE_TOLERANCE * step_deg {
            return Err(LiftError::ZeroOffStep { zero_deg, off_deg, step_deg });
        }
        let turned = turned.rem_euclid(i64::try_from(self.blocks()).unwrap_or(i64::MAX));
        self.lifts.rotate_right(usize::try_from(turned).unwrap_or(0));
        Ok(self)
    }
}
