// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! From rows to a table, or to everything that is wrong with them.

use super::declaration::{LiftDeclaration, LiftForm, LiftRow, mm_from_units};
use super::error::LiftError;
use super::outliers::{RowDeviation, deviations};
use super::row_spacing::{Placement, place};
use super::table::LiftTable;
use super::warning::{self, LiftWarning};
use alloc::vec::Vec;

/// Resolutions that make sense: below a picometre the lift law would chase rounding, above a millimetre it is no table.
const RESOLUTION_MM: (f64, f64) = (1e-9, 1.0);

/// Largest lift or increment (mm); in units of the finest digit it stays inside 2^53.
const LARGEST_MM: f64 = 1000.0;

/// Finest digit looked for in the values (mm): [`LARGEST_MM`] is 1e15 of it, inside 2^53.
const FINEST_DIGIT_MM: f64 = 1e-12;

/// Share of rows above which values beyond the finest digit are the way the table was printed (all digits of a formula),
/// and not the fault of a row.
const ALL_DIGITS: f64 = 0.1;

impl LiftTable {
    /// A table from the rows of a file. Rows stand in the order of the turn from any angle that is a multiple of the
    /// block; a last absolute row that repeats the first after a whole turn is accepted if its lift is the same.
    ///
    /// # Errors
    /// The first of [`Self::findings`].
    pub fn from_rows(rows: &[LiftRow], declaration: &LiftDeclaration) -> Result<Self, LiftError> {
        Self::read(rows, declaration).map(|(table, _)| table).map_err(|mut findings| findings.swap_remove(0))
    }

    /// Everything that is wrong with the rows of a file, row by row; empty when [`Self::from_rows`] succeeds. A bad row
    /// does not hide another: the checks go round it.
    #[must_use]
    pub fn findings(rows: &[LiftRow], declaration: &LiftDeclaration) -> Vec<LiftError> {
        Self::read(rows, declaration).err().unwrap_or_default()
    }

    /// A table as [`Self::from_rows`] makes it, with what is lawful about it and yet looks wrong.
    ///
    /// # Errors
    /// [`Self::findings`], at least one.
    pub fn read(rows: &[LiftRow], declaration: &LiftDeclaration) -> Result<(Self, Vec<LiftWarning>), Vec<LiftError>> {
        inspect(rows, declaration)
    }
}

/// Checks rows; `Err` is never empty, and in the order of the file.
fn inspect(rows: &[LiftRow], declaration: &LiftDeclaration) -> Result<(LiftTable, Vec<LiftWarning>), Vec<LiftError>> {
    let resolution_mm = declaration.resolution_mm;
    let mut findings: Vec<LiftError> = bad_resolution(declaration).into_iter().collect();
    if rows.len() < LiftTable::MIN_BLOCKS {
        findings.push(LiftError::TooFewRows { count: rows.len(), min: LiftTable::MIN_BLOCKS });
    }
    if rows.len() > LiftTable::MAX_BLOCKS + 1 {
        findings.push(LiftError::TooManyRows { count: rows.len(), max: LiftTable::MAX_BLOCKS });
    }
    let nothing_to_place = !findings.is_empty();
    findings.extend(rows.iter().filter_map(unusable_number));
    if nothing_to_place {
        return Err(findings);
    }
    let placement = place(rows, declaration, &mut findings);
    let inspected = values(rows, &placement, declaration, &mut findings);
    let Placement { blocks, first, .. } = placement;
    // Slot i belongs to block first + i; the base centre of a table of increments is block 0.
    let slot_of = |block: usize| (block + blocks - first) % blocks;
    let lift = |block: usize| inspected.lifts.get(slot_of(block)).copied().flatten();
    let base = if declaration.form == LiftForm::Increments { lift(0) } else { Some(0) };
    findings.extend(base.into_iter().flat_map(|base| below_base(&inspected, base, declaration)));
    findings.sort_by_key(|finding| finding.line().unwrap_or(0));
    // A mirrored row has its twin in the file, which is reported.
    if findings.iter().any(|finding| finding.line().is_some()) {
        findings.retain(|finding| finding.row_line() != Some(0));
    }
    if !findings.is_empty() {
        return Err(findings);
    }
    let base = base.unwrap_or(0);
    let lifts = (0..blocks).map(|block| lift(block).unwrap_or(base) - base).collect();
    let lines: Vec<usize> = (0..blocks).map(|block| inspected.lines[slot_of(block)]).collect();
    let table = LiftTable { lifts, digit_mm: inspected.digit_mm, resolution_mm, lowest_mm: declaration.lowest_mm };
    let doubts = warning::doubts(&table, &lines, declaration);
    Ok((table, doubts))
}

/// A resolution in which nothing can be counted.
pub(super) fn bad_resolution(declaration: &LiftDeclaration) -> Option<LiftError> {
    let (resolution_mm, (min_mm, max_mm)) = (declaration.resolution_mm, RESOLUTION_MM);
    let good = (min_mm..=max_mm).contains(&resolution_mm);
    (!good).then_some(LiftError::BadResolution { resolution_mm, min_mm, max_mm })
}

pub(super) fn unusable_number(row: &LiftRow) -> Option<LiftError> {
    let not_finite = |what, value| LiftError::NotFinite { line: row.line, what, value };
    match row.angle_deg {
        Some(angle) if !angle.is_finite() => Some(not_finite("the angle", angle)),
        _ if !row.value_mm.is_finite() => Some(not_finite("the lift", row.value_mm)),
        _ if row.value_mm.abs() > LARGEST_MM => {
            Some(LiftError::TooLarge { line: row.line, value_mm: row.value_mm, max_mm: LARGEST_MM })
        }
        _ => None,
    }
}

/// Lifts slot by slot, none where a row is missing or unusable, each with its line.
pub(super) struct Inspected {
    lifts: Vec<Option<i64>>,
    lines: Vec<usize>,
    digit_mm: f64,
}

/// Checks the values of placed rows: digits, closure, lifts below the base circle, rows off the trend, jumps.
pub(super) fn values(
    rows: &[LiftRow],
    placement: &Placement,
    declaration: &LiftDeclaration,
    findings: &mut Vec<LiftError>,
) -> Inspected {
    let digit_mm = last_digit(rows, declaration, findings);
    let mut line = rows.first().map_or(0, |row| row.line);
    let mut lines = Vec::with_capacity(placement.slots.len());
    let mut read: Vec<Option<i64>> = Vec::with_capacity(placement.slots.len());
    for slot in &placement.slots {
        let row = slot.and_then(|index| rows.get(index));
        line = row.map_or(line, |row| row.line);
        lines.push(line);
        let usable = row.filter(|row| row.value_mm.is_finite() && row.value_mm.abs() <= LARGEST_MM);
        read.push(usable.map(|row| in_units(row.value_mm, digit_mm)));
    }
    let whole = placement.is_whole();
    let misclosure = match declaration.form {
        LiftForm::Absolute if placement.repeats_first && whole => {
            let repeated = read.pop().flatten();
            let first = read.first().copied().flatten();
            repeated.zip(first).map(|(repeated, first)| repeated - first)
        }
        LiftForm::Absolute => None,
        LiftForm::Increments => {
            let complete = whole && read.iter().all(Option::is_some);
            sum(&mut read, &lines, digit_mm, findings).filter(|_| complete)
        }
    };
    let bound_mm = 0.5 * declaration.resolution_mm;
    if let Some((units, misclosure_mm)) =
        misclosure.map(|units| (units, units as f64 * digit_mm)).filter(|(_, mm)| mm.abs() >= bound_mm)
    {
        let line = lines[lines.len() - 1];
        findings.push(LiftError::Misclosure { line, misclosure_mm, units, digit_mm, bound_mm });
    }
    let digits = declaration.resolution_mm / digit_mm;
    // An increment sum that does not return to zero is reported as such; its seam is no jump.
    let closed = match declaration.form {
        LiftForm::Absolute => whole,
        LiftForm::Increments => misclosure.is_some_and(|units| units.unsigned_abs() as f64 * digit_mm < bound_mm),
    };
    // An increment that is wrong stands at the beginning of the block over which the lift jumps.
    let back = usize::from(declaration.form == LiftForm::Increments);
    for deviation in deviations(&read, closed, digits) {
        findings.push(match deviation {
            RowDeviation::Row { at, off, bound } => {
                LiftError::Outlier { line: lines[at], off_mm: off * digit_mm, bound_mm: bound * digit_mm }
            }
            RowDeviation::Jump { at, height, bound } => LiftError::Step {
                line: lines[(at + lines.len() - back) % lines.len()],
                jump_mm: height * digit_mm,
                bound_mm: bound * digit_mm,
            },
        });
    }
    Inspected { lifts: read, lines, digit_mm }
}

/// Turns increments into lifts in place and returns what remains after the last. Past a missing increment the lift is
/// known but for a constant: the slot behind it stays empty, so that no check looks across.
fn sum(read: &mut [Option<i64>], lines: &[usize], digit_mm: f64, findings: &mut Vec<LiftError>) -> Option<i64> {
    let max = in_units(LARGEST_MM, digit_mm);
    let mut sum = 0_i64;
    let mut is_known = true;
    for (slot, line) in read.iter_mut().zip(lines) {
        let increment = *slot;
        *slot = is_known.then_some(sum);
        is_known = increment.is_some();
        // Both are below 2^53 before the sum, so it cannot overflow.
        sum += increment.unwrap_or(0);
        if sum.abs() > max {
            let value_mm = sum as f64 * digit_mm;
            findings.push(LiftError::TooLarge { line: *line, value_mm, max_mm: LARGEST_MM });
            return None;
        }
    }
    Some(sum)
}

/// The coarsest of the resolution and the decimal parts of the unit below it of which every value is a multiple.
fn last_digit(rows: &[LiftRow], declaration: &LiftDeclaration, findings: &mut Vec<LiftError>) -> f64 {
    let usable = |row: &&LiftRow| row.value_mm.is_finite() && row.value_mm.abs() <= LARGEST_MM;
    let is_off = |row: &&LiftRow, digit_mm: f64| {
        let units = row.value_mm / digit_mm;
        // 1e-6 of a digit, and what f64 itself cannot resolve of a long number.
        (units - libm::round(units)).abs() > 1e-6 + 4.0 * f64::EPSILON * units.abs()
    };
    // The resolution itself, whatever it is a part of: the arc of a thousandth of a degree of an arm, for example.
    if !rows.iter().filter(usable).any(|row| is_off(&row, declaration.resolution_mm)) {
        return declaration.resolution_mm;
    }
    let unit_mm = declaration.unit.mm();
    let decimals = libm::ceil(-libm::log10(declaration.resolution_mm / unit_mm) - 1e-9);
    // A resolution like 0.005 mm begins at 0.001 mm.
    let coarsest = unit_mm / libm::round(libm::pow(10.0, decimals.max(0.0)));
    let mut finer = 1.0;
    loop {
        let digit_mm = coarsest / finer;
        if !rows.iter().filter(usable).any(|row| is_off(&row, digit_mm)) {
            return digit_mm;
        }
        if digit_mm <= 9.0 * FINEST_DIGIT_MM {
            let off: Vec<&LiftRow> = rows.iter().filter(usable).filter(|row| is_off(row, digit_mm)).collect();
            if off.len() as f64 <= ALL_DIGITS * rows.len() as f64 {
                findings.extend(off.iter().map(|row| LiftError::OffDigit {
                    line: row.line,
                    value_mm: row.value_mm,
                    digit_mm,
                }));
            }
            return digit_mm;
        }
        finer *= 10.0;
    }
}

fn in_units(value_mm: f64, digit_mm: f64) -> i64 {
    #[allow(clippy::cast_possible_truncation, reason = "at most LARGEST_MM over 1e-12 mm, below 2^63")]
    let units = libm::round(value_mm / digit_mm) as i64;
    units
}

/// Lifts below the lowest; the base circle is the lift 0 of the table.
fn below_base(inspected: &Inspected, base: i64, declaration: &LiftDeclaration) -> impl Iterator<Item = LiftError> {
    let bound_mm = (0.5 * declaration.resolution_mm).max(declaration.smooth_within_mm);
    let lowest_mm = declaration.lowest_mm;
    (inspected.lifts.iter().zip(&inspected.lines))
        .filter_map(move |(lift, line)| Some((mm_from_units(lift.as_ref()? - base, inspected.digit_mm), *line)))
        .filter(move |(lift_mm, _)| *lift_mm < lowest_mm - bound_mm * (1.0 + 1e-9))
        .map(move |(lift_mm, line)| LiftError::BelowBase { line, lift_mm, lowest_mm, bound_mm })
}

/// Checks the values of rows that stand one block apart but make no whole turn.
pub(super) fn part(rows: &[LiftRow], placement: &Placement, declaration: &LiftDeclaration) -> Vec<LiftError> {
    let mut findings: Vec<LiftError> = rows.iter().filter_map(unusable_number).collect();
    values(rows, placement, declaration, &mut findings);
    findings
}
