// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Tables that leave the even division of the turn to the reader: rows at uneven angles, and rows of the lift event alone.

use super::check::unusable_number;
use super::declaration::{AngleUnit, LiftDeclaration, LiftRow};
use super::error::LiftError;
use super::points::{MAX_GAP_DEG, resampled};
use super::table::LiftTable;
use crate::math::units::rad_from_deg;
use alloc::vec;
use alloc::vec::Vec;

/// Share of a turn within which a last row repeats the first one, and below which two angles are the same.
const SAME_SHARE: f64 = 1e-6;

/// Rows of a whole turn from those of a lift event: lift 0 at the step of the event from its last row round to its first one.
///
/// # Errors
/// A row without a number or angle, an event that begins or ends above the base circle, more rows than a table may have.
pub fn with_base_circle(rows: &[LiftRow], declaration: &LiftDeclaration) -> Result<Vec<LiftRow>, Vec<LiftError>> {
    let angles = angles_of(rows)?;
    let bound_mm = (0.5 * declaration.resolution_mm).max(declaration.smooth_within_mm);
    let is_high = |row: &&LiftRow| row.value_mm > bound_mm * (1.0 + 1e-9);
    let high: Vec<LiftError> = [rows[0], rows[rows.len() - 1]]
        .iter()
        .filter(is_high)
        .map(|row| LiftError::FlankEndsHigh { line: row.line, lift_mm: row.value_mm, bound_mm })
        .collect();
    if !high.is_empty() {
        return Err(high);
    }
    let last = angles[angles.len() - 1];
    let gap = angles[0] + declaration.angle_unit.turn_deg() - last;
    let mut steps: Vec<f64> = angles.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    steps.sort_by(f64::total_cmp);
    let step = steps[steps.len() / 2];
    if step <= 0.0 {
        // Most rows stand at one angle, which the table reports row by row.
        return Ok(rows.to_vec());
    }
    let count = libm::round(gap / step);
    let max = LiftTable::MAX_BLOCKS;
    if count.is_nan() || count + rows.len() as f64 > max as f64 + 1.0 {
        return Err(vec![LiftError::TooManyRows { count: rows.len(), max }]);
    }
    let line = rows[rows.len() - 1].line;
    let mut whole = rows.to_vec();
    let mut filled = 1.0;
    while filled < count {
        whole.push(LiftRow { line, angle_deg: Some(last + gap * filled / count), value_mm: 0.0 });
        filled += 1.0;
    }
    Ok(whole)
}

/// Rows at even angles from the periodic cubic spline through rows at any rising angles. A last row one turn after the first repeats it.
///
/// # Errors
/// A row without a number or angle, angles that do not rise, gaps, more or less than one turn, a turn that does not close.
pub fn evenly_spaced(rows: &[LiftRow], declaration: &LiftDeclaration) -> Result<Vec<LiftRow>, Vec<LiftError>> {
    let min = LiftTable::MIN_BLOCKS;
    if rows.len() < min {
        return Err(vec![LiftError::TooFewRows { count: rows.len(), min }]);
    }
    let mut angles = angles_of(rows)?;
    let turn = declaration.angle_unit.turn_deg();
    let same = SAME_SHARE * turn;
    let mut findings = Vec::new();
    for (pair, around) in angles.windows(2).zip(rows.windows(2)) {
        let (line, previous_line) = (around[1].line, around[0].line);
        let (previous_deg, angle_deg) = (pair[0], pair[1]);
        if (angle_deg - previous_deg).abs() <= same {
            findings.push(LiftError::DuplicateAngle { line, angle_deg, previous_line });
        } else if angle_deg < previous_deg {
            findings.push(LiftError::AngleNotIncreasing { line, angle_deg, previous_deg });
        }
    }
    let mut rows = rows.to_vec();
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    let covered_deg = angles[angles.len() - 1] - angles[0];
    if (covered_deg - turn).abs() <= same {
        let (misclosure_mm, bound_mm) = (last.value_mm - first.value_mm, 0.5 * declaration.resolution_mm);
        if misclosure_mm.abs() > bound_mm {
            let digit_mm = declaration.resolution_mm;
            #[allow(clippy::cast_possible_truncation, reason = "at most 1000 mm over a nanometre; it saturates")]
            let units = libm::round(misclosure_mm / digit_mm) as i64;
            findings.push(LiftError::Misclosure { line: last.line, misclosure_mm, units, digit_mm, bound_mm });
        }
        rows.pop();
        angles.pop();
    } else if covered_deg > turn {
        let two_turns = declaration.angle_unit == AngleUnit::CamDegrees && (covered_deg - 720.0).abs() < 7.2;
        findings.push(if two_turns {
            LiftError::CrankDegrees { line: last.line, covered_deg }
        } else {
            LiftError::AngleSpan { line: last.line, covered_deg, turn_deg: turn }
        });
    }
    let max_deg = MAX_GAP_DEG * turn / 360.0;
    for i in 0..angles.len() {
        let (from, to) = (i, (i + 1) % angles.len());
        let gap_deg = angles[to] - angles[from] + if to == 0 { turn } else { 0.0 };
        if gap_deg > max_deg {
            let previous_line = rows[from].line;
            findings.push(LiftError::RowGap { line: rows[to].line, gap_deg, max_deg, previous_line });
        }
    }
    if !findings.is_empty() {
        findings.sort_by_key(|finding| finding.line().unwrap_or(0));
        return Err(findings);
    }
    let known: Vec<(f64, f64, usize)> = (rows.iter().zip(&angles))
        .map(|(row, angle)| (rad_from_deg(angle * 360.0 / turn), row.value_mm, row.line))
        .collect();
    let mut even = resampled(&known)?;
    for row in &mut even {
        row.angle_deg = row.angle_deg.map(|angle| angle * turn / 360.0);
    }
    Ok(even)
}

/// Angle of every row; there are two rows or more.
fn angles_of(rows: &[LiftRow]) -> Result<Vec<f64>, Vec<LiftError>> {
    if rows.len() < 2 {
        return Err(vec![LiftError::TooFewRows { count: rows.len(), min: LiftTable::MIN_BLOCKS }]);
    }
    let missing = rows.iter().filter(|row| row.angle_deg.is_none());
    let mut findings: Vec<LiftError> = missing.map(|row| LiftError::AngleMissing { line: row.line }).collect();
    findings.extend(rows.iter().filter_map(unusable_number));
    if findings.is_empty() { Ok(rows.iter().filter_map(|row| row.angle_deg).collect()) } else { Err(findings) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cam::lift::declaration::{LengthUnit, LiftForm};
    use crate::math::units::TURN_RAD;

    fn declaration(angle_unit: AngleUnit) -> LiftDeclaration {
        LiftDeclaration {
            form: LiftForm::Absolute,
            angle_unit,
            resolution_mm: 1e-4,
            unit: LengthUnit::Millimetre,
            smooth_within_mm: 0.0,
            lowest_mm: 0.0,
            blocks: None,
        }
    }

    fn row(line: usize, angle_deg: f64, value_mm: f64) -> LiftRow {
        LiftRow { line, angle_deg: Some(angle_deg), value_mm }
    }

    /// 2.5 (1 − cos φ) at 240 angles that lie up to 0.4 of a step off the even ones, with and without its first row again at the end.
    #[test]
    fn a_cosine_at_uneven_angles_is_the_same_at_even_ones() {
        for (unit, repeated) in [(AngleUnit::CamDegrees, false), (AngleUnit::CrankDegrees, true)] {
            let turn = unit.turn_deg();
            let lift = |angle: f64| 2.5 * (1.0 - libm::cos(angle / turn * TURN_RAD));
            let at = |i: u32| (f64::from(i) + 0.4 * libm::sin(2.3 * f64::from(i))) * turn / 240.0 + 3.0;
            let mut rows: Vec<LiftRow> = (0..240_u32).map(|i| row(i as usize + 2, at(i), lift(at(i)))).collect();
            if repeated {
                rows.push(row(242, at(0) + turn, lift(at(0))));
            }
            let even = evenly_spaced(&rows, &declaration(unit)).expect("rows");
            assert_eq!(even.len(), 720);
            for row in even {
                let off = row.value_mm - lift(row.angle_deg.expect("an angle"));
                assert!(off.abs() < 1e-6, "{row:?}: {off}");
            }
        }
    }

    #[test]
    fn what_is_wrong_with_uneven_rows_is_reported_by_its_line() {
        let even = |i: u32| row(i as usize + 1, f64::from(i) * 20.0, 1.0);
        let rows: Vec<LiftRow> = (0..18).map(even).collect();
        let declared = declaration(AngleUnit::CamDegrees);
        let check = |rows: &[LiftRow]| evenly_spaced(rows, &declared).expect_err("refused");
        let changed = |index: usize, angle_deg: f64| {
            let mut rows = rows.clone();
            rows[index].angle_deg = Some(angle_deg);
            rows
        };
        assert!(evenly_spaced(&rows, &declared).is_ok());
        assert!(matches!(
            check(&changed(4, 60.0))[..],
            [LiftError::DuplicateAngle { line: 5, previous_line: 4, .. }, ..]
        ));
        assert!(matches!(check(&changed(4, 50.0))[..], [LiftError::AngleNotIncreasing { line: 5, .. }, ..]));
        assert!(matches!(
            check(&changed(4, 95.0))[..],
            [LiftError::RowGap { line: 5, previous_line: 4, gap_deg, .. }] if (gap_deg - 35.0).abs() < 1e-9
        ));
        assert!(matches!(
            check(&changed(17, 400.0))[..],
            [.., LiftError::AngleSpan { line: 18, .. }, _] | [.., LiftError::AngleSpan { line: 18, .. }]
        ));
        assert!(matches!(check(&rows[..11])[..], [LiftError::TooFewRows { count: 11, .. }]));
        let mut open = rows.clone();
        open.push(row(19, 360.0, 1.1));
        assert!(matches!(check(&open)[..], [LiftError::Misclosure { line: 19, units: 1000, .. }]));
        let mut no_angle = rows.clone();
        no_angle[3].angle_deg = None;
        assert!(matches!(check(&no_angle)[..], [LiftError::AngleMissing { line: 4 }]));
    }

    /// 5 (1 + cos 2φ)/2 from −90° to 90° in steps of 1°, whose base circle is not printed.
    #[test]
    fn the_base_circle_fills_what_an_event_leaves_out() {
        let lift = |angle: f64| 2.5 * (1.0 + libm::cos(2.0 * rad_from_deg(angle)));
        let at = |i: u32| f64::from(i) - 90.0;
        let event: Vec<LiftRow> = (0..=180_u32).map(|i| row(i as usize + 1, at(i), lift(at(i)))).collect();
        let whole = with_base_circle(&event, &declaration(AngleUnit::CamDegrees)).expect("a turn");
        assert_eq!(whole.len(), 360);
        for (i, row) in (0_u32..).zip(&whole) {
            let angle = row.angle_deg.expect("an angle");
            assert!((angle - at(i)).abs() < 1e-9, "{row:?}");
            assert!((row.value_mm - if i <= 180 { lift(angle) } else { 0.0 }).abs() < 1e-12, "{row:?}");
        }
        let cut = &event[10..];
        assert!(matches!(
            with_base_circle(cut, &declaration(AngleUnit::CamDegrees)).expect_err("refused")[..],
            [LiftError::FlankEndsHigh { line: 11, .. }]
        ));
        // Rows at one angle are left for the table to report.
        let same = [row(1, 5.0, 0.0); 4];
        assert_eq!(with_base_circle(&same, &declaration(AngleUnit::CamDegrees)).as_deref(), Ok(&same[..]));
        // A whole turn has nothing to fill.
        let again = with_base_circle(&whole, &declaration(AngleUnit::CamDegrees)).expect("a turn");
        assert_eq!(again.len(), 360);
    }
}
