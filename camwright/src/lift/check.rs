//! From rows to a table, or to everything that is wrong with them.

use super::error::LiftError;
use super::table::{AngleUnit, LiftDeclaration, LiftForm, LiftRow, LiftTable};
use alloc::vec;
use alloc::vec::Vec;

/// Resolutions that make sense: below a picometre the lift law would chase rounding, above a millimetre it is no table.
const RESOLUTION_MM: (f64, f64) = (1e-9, 1.0);

/// Largest lift or increment (mm); in units of the finest digit it stays inside 2^53.
const LARGEST_MM: f64 = 1000.0;

/// How far a printed angle may lie from the even division, in blocks: 51.43 for 360/7 passes, 51.1 does not. An angle
/// error of this size on a 0.1° table moves the steepest flank by less than a tenth of a micrometre.
const ANGLE_TOLERANCE: f64 = 0.005;

/// Finest digit looked for in the values (mm): [`LARGEST_MM`] is 1e15 of it, inside 2^53.
const FINEST_DIGIT_MM: f64 = 1e-12;

/// Checks rows; `Err` is never empty.
pub(super) fn inspect(rows: &[LiftRow], declaration: &LiftDeclaration) -> Result<LiftTable, Vec<LiftError>> {
    let resolution_mm = declaration.resolution_mm;
    let mut findings = Vec::new();
    if !(RESOLUTION_MM.0..=RESOLUTION_MM.1).contains(&resolution_mm) {
        findings.push(LiftError::BadResolution { resolution_mm, least_mm: RESOLUTION_MM.0, most_mm: RESOLUTION_MM.1 });
    }
    if rows.len() < LiftTable::MIN_BLOCKS {
        findings.push(LiftError::TooFewRows { count: rows.len(), least: LiftTable::MIN_BLOCKS });
    }
    if rows.len() > LiftTable::MAX_BLOCKS + 1 {
        findings.push(LiftError::TooManyRows { count: rows.len(), most: LiftTable::MAX_BLOCKS });
    }
    findings.extend(rows.iter().filter_map(unusable_number));
    if !findings.is_empty() {
        return Err(findings);
    }
    let division = divide(rows, declaration)?;
    let digit_mm = last_digit(rows, resolution_mm).map_err(|error| vec![error])?;
    let units: Vec<i64> = rows.iter().map(|row| in_units(row.value_mm, digit_mm)).collect();
    let lines: Vec<usize> = rows.iter().map(|row| row.line).collect();
    let closed = close(&units, &lines, declaration, &division, digit_mm).map_err(|error| vec![error])?;
    let table = LiftTable { lifts: closed.lifts, digit_mm, resolution_mm };
    findings.extend(below_base(&table, &closed.lines));
    findings.extend(steps(&table, &closed.lines));
    if findings.is_empty() { Ok(table) } else { Err(findings) }
}

fn unusable_number(row: &LiftRow) -> Option<LiftError> {
    let not_finite = |what, value| LiftError::NotFinite { line: row.line, what, value };
    match row.angle_deg {
        Some(angle) if !angle.is_finite() => Some(not_finite("the angle", angle)),
        _ if !row.value_mm.is_finite() => Some(not_finite("the lift", row.value_mm)),
        _ if row.value_mm.abs() > LARGEST_MM => {
            Some(LiftError::TooLarge { line: row.line, value_mm: row.value_mm, most_mm: LARGEST_MM })
        }
        _ => None,
    }
}

/// How the rows divide the turn.
struct Division {
    blocks: usize,
    /// Block of the first row.
    first: usize,
    /// The last row repeats the first after a whole turn.
    repeats_first: bool,
}

/// Finds the number of blocks, and every angle that does not fit it.
fn divide(rows: &[LiftRow], declaration: &LiftDeclaration) -> Result<Division, Vec<LiftError>> {
    let last_line = rows[rows.len() - 1].line;
    let angles: Vec<f64> = rows.iter().filter_map(|row| row.angle_deg).collect();
    if angles.is_empty() {
        let blocks = declaration.blocks.unwrap_or(rows.len());
        let repeats_first = declaration.form == LiftForm::Absolute && rows.len() == blocks + 1;
        if rows.len() != blocks && !repeats_first {
            return Err(vec![LiftError::BlockCount { line: last_line, count: rows.len(), declared: blocks }]);
        }
        return Ok(Division { blocks, first: 0, repeats_first });
    }
    let missing: Vec<LiftError> = (rows.iter().filter(|row| row.angle_deg.is_none()))
        .map(|row| LiftError::AngleMissing { line: row.line })
        .collect();
    if !missing.is_empty() {
        return Err(missing);
    }
    let turn = declaration.angle_unit.turn_deg();
    let step = nominal_step(&angles, turn, declaration.blocks);
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "bounded by the number of rows checked next"
    )]
    let blocks = libm::round((turn / step).min(1e9)) as usize;
    let mut findings = Vec::new();
    let tolerance = ANGLE_TOLERANCE * step;
    let start = angles[0];
    for i in 1..rows.len() {
        let (angle, previous, line) = (angles[i], angles[i - 1], rows[i].line);
        let ahead = angle - previous;
        if ahead.abs() <= tolerance {
            let previous_line = rows[i - 1].line;
            findings.push(LiftError::DuplicateAngle { line, angle_deg: angle, previous_line });
        } else if ahead < 0.0 {
            findings.push(LiftError::AngleNotIncreasing { line, angle_deg: angle, previous_deg: previous });
        } else if ahead > 1.5 * step {
            let count = whole(ahead / step) - 1;
            let expected_deg = previous + step;
            findings.push(LiftError::MissingBlock { line, count, expected_deg, angle_deg: angle });
        } else {
            let off_deg = (angle - start) - step * libm::round((angle - start) / step);
            if off_deg.abs() > tolerance {
                findings.push(LiftError::UnevenAngle { line, angle_deg: angle, off_deg, bound_deg: tolerance });
            }
        }
    }
    let off_deg = start - step * libm::round(start / step);
    if off_deg.abs() > tolerance {
        findings.push(LiftError::UnevenAngle { line: rows[0].line, angle_deg: start, off_deg, bound_deg: tolerance });
    }
    let span = angles[angles.len() - 1] - start;
    let repeats_first = declaration.form == LiftForm::Absolute && (span - turn).abs() <= tolerance;
    let covered = if repeats_first { span } else { span + step };
    if covered > turn + 0.5 * step {
        let line = rows
            .iter()
            .zip(&angles)
            .find(|(_, angle)| **angle - start > turn - 0.5 * step)
            .map_or(last_line, |(row, _)| row.line);
        let twice = declaration.angle_unit == AngleUnit::CamDegrees && (covered - 720.0).abs() < 7.2;
        findings.push(if twice {
            LiftError::CrankDegrees { line, covered_deg: covered }
        } else {
            LiftError::AngleSpan { line, covered_deg: covered, turn_deg: turn }
        });
    } else if covered < turn - 0.5 * step {
        let count = whole((turn - covered) / step);
        let (expected_deg, angle_deg) = (start + covered, start + turn);
        findings.push(LiftError::MissingBlock { line: last_line, count, expected_deg, angle_deg });
    }
    let rows_per_turn = blocks + usize::from(repeats_first);
    if findings.is_empty() && (rows.len() != rows_per_turn || declaration.blocks.is_some_and(|n| n != blocks)) {
        let declared = declaration.blocks.unwrap_or(blocks);
        findings.push(LiftError::BlockCount { line: last_line, count: rows.len(), declared });
    }
    if !findings.is_empty() {
        return Err(findings);
    }
    #[allow(clippy::cast_possible_truncation, reason = "angles are finite and few turns from zero")]
    let first = (libm::round(start / step) as i64).rem_euclid(i64::try_from(blocks).unwrap_or(i64::MAX));
    Ok(Division { blocks, first: usize::try_from(first).unwrap_or(0), repeats_first })
}

/// The block: as declared, else the whole division of the turn nearest to the median difference, which neither a missing
/// row nor a duplicate moves.
fn nominal_step(angles: &[f64], turn: f64, declared: Option<usize>) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "block counts are far below 2^53")]
    if let Some(blocks) = declared.filter(|blocks| *blocks > 0) {
        return turn / blocks as f64;
    }
    let mut differences: Vec<f64> = angles.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    differences.sort_by(f64::total_cmp);
    let median = differences[differences.len() / 2].max(turn / 1e9);
    let by_median = turn / libm::round(turn / median).max(1.0);
    // Angles rounded to few digits spoil the median of narrow blocks; the whole span of an unbroken table does not.
    #[allow(clippy::cast_precision_loss, reason = "row counts are far below 2^53")]
    let mean = (angles[angles.len() - 1] - angles[0]).abs().max(turn / 1e9) / (angles.len() - 1) as f64;
    let by_mean = turn / libm::round(turn / mean).max(1.0);
    #[allow(clippy::cast_precision_loss, reason = "row counts are far below 2^53")]
    let fits = |step: f64| {
        angles
            .iter()
            .enumerate()
            .all(|(i, angle)| (angle - angles[0] - i as f64 * step).abs() <= ANGLE_TOLERANCE * step)
    };
    if fits(by_mean) { by_mean } else { by_median }
}

fn whole(value: f64) -> usize {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of blocks, saturating")]
    let count = libm::round(value) as usize;
    count
}

/// The coarsest of resolution, resolution/10, … of which every value is a multiple.
fn last_digit(rows: &[LiftRow], resolution_mm: f64) -> Result<f64, LiftError> {
    let off = |digit_mm: f64| {
        rows.iter().find(|row| {
            let units = row.value_mm / digit_mm;
            // 1e-6 of a digit, and what f64 itself cannot resolve of a long number.
            (units - libm::round(units)).abs() > 1e-6 + 4.0 * f64::EPSILON * units.abs()
        })
    };
    let mut finer = 1.0;
    loop {
        let digit_mm = resolution_mm / finer;
        match off(digit_mm) {
            None => return Ok(digit_mm),
            Some(_) if digit_mm > 9.0 * FINEST_DIGIT_MM => finer *= 10.0,
            Some(row) => return Err(LiftError::OffDigit { line: row.line, value_mm: row.value_mm, digit_mm }),
        }
    }
}

fn in_units(value_mm: f64, digit_mm: f64) -> i64 {
    #[allow(clippy::cast_possible_truncation, reason = "at most LARGEST_MM over 1e-15 mm, below 2^63")]
    let units = libm::round(value_mm / digit_mm) as i64;
    units
}

/// Lifts in the order of the cam angle from 0, each with the line it came from.
struct Closed {
    lifts: Vec<i64>,
    lines: Vec<usize>,
}

/// Sums increments, checks that the turn closes, and turns the table so that it begins at angle 0.
fn close(
    units: &[i64],
    lines: &[usize],
    declaration: &LiftDeclaration,
    division: &Division,
    digit_mm: f64,
) -> Result<Closed, LiftError> {
    let Division { blocks, first, repeats_first } = *division;
    let (read, remaining) = match declaration.form {
        LiftForm::Absolute => {
            let remaining = if repeats_first { units[blocks] - units[0] } else { 0 };
            (units[..blocks].to_vec(), remaining)
        }
        LiftForm::Increments => {
            let mut sum = 0_i64;
            let mut lifts = Vec::with_capacity(units.len());
            for (unit, &line) in units.iter().zip(lines) {
                lifts.push(sum);
                sum += unit;
                // Both are below 2^53 before the sum, so it cannot overflow.
                if sum.abs() > in_units(LARGEST_MM, digit_mm) {
                    let value_mm = sum as f64 * digit_mm;
                    return Err(LiftError::TooLarge { line, value_mm, most_mm: LARGEST_MM });
                }
            }
            (lifts, sum)
        }
    };
    #[allow(clippy::cast_precision_loss, reason = "a report")]
    let misclosure_mm = remaining as f64 * digit_mm;
    let bound_mm = 0.5 * declaration.resolution_mm;
    if misclosure_mm.abs() >= bound_mm {
        let line = lines[lines.len() - 1];
        return Err(LiftError::Misclosure { line, misclosure_mm, units: remaining, digit_mm, bound_mm });
    }
    // Row i belongs to block first + i; the base centre of a table of increments is block 0.
    let row_of = |block: usize| (block + blocks - first) % blocks;
    let base = match declaration.form {
        LiftForm::Absolute => 0,
        LiftForm::Increments => read[row_of(0)],
    };
    Ok(Closed {
        lifts: (0..blocks).map(|block| read[row_of(block)] - base).collect(),
        lines: (0..blocks).map(|block| lines[row_of(block)]).collect(),
    })
}

fn below_base(table: &LiftTable, lines: &[usize]) -> Vec<LiftError> {
    let bound_mm = 0.5 * table.resolution_mm;
    (0..table.blocks())
        .filter(|&block| table.lift_mm(block) < -bound_mm)
        .map(|block| LiftError::BelowBase { line: lines[block], lift_mm: table.lift_mm(block), bound_mm })
        .collect()
}

/// Jumps. With d(k) = y(k + 1) − y(k), the deviation of a difference from the mean of its neighbours is
/// e(k) = d(k) − (d(k − 1) + d(k + 1))/2: a step of J gives J, a stray point 1.5 J, rounding at most 2 digits, a jump of
/// the acceleration half a second difference, and a smooth law next to nothing. Allowed are 4 digits and 3 times the
/// larger of two second differences that the jump itself does not spoil: the 90 % quantile of the whole table, and the
/// upper median of the eight around the place (so that a short steep ramp in a long dwell speaks for itself).
fn steps(table: &LiftTable, lines: &[usize]) -> Vec<LiftError> {
    let n = table.blocks();
    let y = |k: usize| table.lifts[k % n];
    #[allow(clippy::cast_precision_loss, reason = "units are far below 2^53")]
    let second: Vec<f64> = (0..n).map(|k| (y(k + 1) + y(k + n - 1) - 2 * y(k)).unsigned_abs() as f64).collect();
    let mut sorted = second.clone();
    sorted.sort_by(f64::total_cmp);
    let overall = sorted[(9 * n / 10).min(n - 1)];
    let digits = table.resolution_mm / table.digit_mm;
    let mut findings: Vec<LiftError> = Vec::new();
    let mut previous: Option<(usize, f64)> = None;
    for k in 0..n {
        let (before, here, after) = (y(k) - y(k + n - 1), y(k + 1) - y(k), y(k + 2) - y(k + 1));
        #[allow(clippy::cast_precision_loss, reason = "units are far below 2^53")]
        let jump = (2 * here - before - after) as f64 / 2.0;
        let mut around = [n - 4, n - 3, n - 2, n - 1, 2, 3, 4, 5].map(|j| second[(k + j) % n]);
        around.sort_by(f64::total_cmp);
        let bound = 4.0 * digits + 3.0 * overall.max(around[4]);
        if jump.abs() <= bound {
            continue;
        }
        let (jump_mm, bound_mm) = (jump * table.digit_mm, bound * table.digit_mm);
        // One fault shows at up to three neighbouring differences: only the largest is told.
        let beside = previous.is_some_and(|(at, _)| k - at <= 2);
        let finding = LiftError::Step { line: lines[(k + 1) % n], jump_mm, bound_mm };
        match previous {
            Some((_, size)) if beside && jump.abs() <= size => {}
            Some(_) if beside => {
                findings.pop();
                findings.push(finding);
                previous = Some((k, jump.abs()));
            }
            _ => {
                findings.push(finding);
                previous = Some((k, jump.abs()));
            }
        }
    }
    findings
}
