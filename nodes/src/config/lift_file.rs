//! Lift tables as CSV: comment lines, a header that names the columns with their units, rows.
//!
//! ```text
//! # anything
//! cam_angle_deg,lift_mm        or crank_angle_deg, or no angle column at all
//! 0.0,0.000                    or increment_um, increment_mm, lift_um
//! ```
//! Comma, semicolon and tab separate columns. The resolution is the last digit printed unless the job declares a coarser
//! one.

use super::locate::Located;
use super::{ConfigError, Place};
use camwright::lift::{LiftDeclaration, LiftError, LiftForm, LiftRow, LiftTable};
use serde::Deserialize;
use std::path::Path;

/// What a job declares the angles of a table to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AngleUnit {
    /// Degrees of the cam: one turn is 360.
    #[default]
    Cam,
    /// Degrees of the crank: one turn of the cam is 720.
    Crank,
}

impl AngleUnit {
    fn column(self) -> &'static str {
        match self {
            AngleUnit::Cam => "cam_angle_deg",
            AngleUnit::Crank => "crank_angle_deg",
        }
    }
}

/// Columns of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Columns {
    angle: Option<usize>,
    value: usize,
    form: LiftForm,
    mm_per_unit: f64,
    count: usize,
    separator: char,
}

const VALUE_COLUMNS: [(&str, LiftForm, f64); 4] = [
    ("lift_mm", LiftForm::Absolute, 1.0),
    ("lift_um", LiftForm::Absolute, 1e-3),
    ("increment_mm", LiftForm::Increments, 1.0),
    ("increment_um", LiftForm::Increments, 1e-3),
];

/// A lift table from a file that has been read.
///
/// # Errors
/// The first of what [`read`] finds.
pub fn parse(located: &Located, angle: AngleUnit, resolution_mm: Option<f64>) -> Result<LiftTable, ConfigError> {
    read(located, angle, resolution_mm).map_err(|mut findings| findings.swap_remove(0))
}

/// A lift table from a file that has been read, or everything that is wrong with it, in the order of the checks.
///
/// # Errors
/// At least one sentence, with file, line, value and bound.
pub fn read(located: &Located, angle: AngleUnit, resolution_mm: Option<f64>) -> Result<LiftTable, Vec<ConfigError>> {
    let (rows, declaration) = rows(located, angle, resolution_mm).map_err(|error| vec![error])?;
    let findings = LiftTable::findings(&rows, &declaration);
    if findings.is_empty() {
        LiftTable::from_rows(&rows, &declaration).map_err(|error| vec![lift_error(&located.path, &error)])
    } else {
        Err(findings.iter().map(|error| lift_error(&located.path, error)).collect())
    }
}

/// What the header of a table says its angles are; cam degrees where it has none.
#[must_use]
pub fn declared_angle(located: &Located) -> AngleUnit {
    let header = located.text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
    match header {
        Some(header) if header.contains(AngleUnit::Crank.column()) => AngleUnit::Crank,
        _ => AngleUnit::Cam,
    }
}

/// The core writes the line at the head of its message; a message of this program begins with the file and that line.
fn lift_error(path: &Path, error: &LiftError) -> ConfigError {
    let text = error.to_string();
    let place = Place { file: path.to_path_buf(), line: error.line().and_then(|line| u64::try_from(line).ok()) };
    let message = match (error.line(), text.split_once(": ")) {
        (Some(_), Some((_, message))) => message,
        _ => &text,
    };
    ConfigError::at(place, message)
}

fn rows(
    located: &Located,
    angle: AngleUnit,
    resolution_mm: Option<f64>,
) -> Result<(Vec<LiftRow>, LiftDeclaration), ConfigError> {
    let mut columns: Option<Columns> = None;
    let mut rows = Vec::new();
    let mut digits = 0;
    for (number, line) in (1_u64..).zip(located.text.lines()) {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let refuse = |message: String| ConfigError::at(Place::line(&located.path, number), message);
        let Some(columns) = columns else {
            columns = Some(header(line, angle).map_err(refuse)?);
            continue;
        };
        let cells: Vec<&str> = line.split(columns.separator).map(str::trim).collect();
        if cells.len() != columns.count {
            return Err(refuse(format!("{} columns, the header has {}", cells.len(), columns.count)));
        }
        let parse = |cell: &str| cell.parse::<f64>().map_err(|_| refuse(format!("{cell:?} is not a number")));
        digits = digits.max(decimals(cells[columns.value]));
        rows.push(LiftRow {
            line: usize::try_from(number).unwrap_or(usize::MAX),
            angle_deg: columns.angle.map(|index| parse(cells[index])).transpose()?,
            value_mm: parse(cells[columns.value])? * columns.mm_per_unit,
        });
    }
    let Some(columns) = columns else {
        return Err(ConfigError::at(Place::file(&located.path), "is empty; a header line and rows are needed"));
    };
    let last_digit_mm = columns.mm_per_unit * 10f64.powi(-i32::try_from(digits).unwrap_or(i32::MAX));
    let declaration = LiftDeclaration {
        form: columns.form,
        angle_unit: match angle {
            AngleUnit::Cam => camwright::lift::AngleUnit::CamDegrees,
            AngleUnit::Crank => camwright::lift::AngleUnit::CrankDegrees,
        },
        resolution_mm: resolution_mm.unwrap_or(last_digit_mm),
        blocks: None,
    };
    Ok((rows, declaration))
}

fn header(line: &str, angle: AngleUnit) -> Result<Columns, String> {
    let separator = [';', '\t', ','].into_iter().find(|separator| line.contains(*separator)).unwrap_or(',');
    let names: Vec<&str> = line.split(separator).map(str::trim).collect();
    let (mut angle_column, mut value_column) = (None, None);
    for (index, name) in names.iter().enumerate() {
        if let Some((_, form, mm_per_unit)) = VALUE_COLUMNS.iter().find(|(known, _, _)| known == name) {
            value_column = Some((index, *form, *mm_per_unit));
        } else if *name == angle.column() {
            angle_column = Some(index);
        } else if matches!(*name, "cam_angle_deg" | "crank_angle_deg") {
            return Err(format!("column {name}, but the job declares {}", angle.column()));
        } else if *name != "block" {
            return Err(format!(
                "unknown column {name:?}; known are block, cam_angle_deg, crank_angle_deg, lift_mm, lift_um, \
                 increment_mm, increment_um"
            ));
        }
    }
    let (value, form, mm_per_unit) =
        value_column.ok_or("no column of lift_mm, lift_um, increment_mm, increment_um in the header")?;
    Ok(Columns { angle: angle_column, value, form, mm_per_unit, count: names.len(), separator })
}

/// Digits after the decimal point.
fn decimals(cell: &str) -> usize {
    let mantissa = cell.split(['e', 'E']).next().unwrap_or(cell);
    mantissa.split_once('.').map_or(0, |(_, fraction)| fraction.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    fn located(text: &str) -> Located {
        Located { path: PathBuf::from("lift.csv"), text: text.to_owned() }
    }

    fn printed(form: &str) -> String {
        #[allow(clippy::cast_possible_truncation, reason = "at most 2000 um")]
        let lift = |i: i32| 1000 + (1000.0 * (f64::from(i) * std::f64::consts::TAU / 360.0).cos()).round() as i64;
        let rows: Vec<String> = match form {
            "lift_mm" => (0..360).map(|i| format!("{i},{:.3}", (lift(i + 180)) as f64 / 1000.0)).collect(),
            _ => (0..360).map(|i| format!("{i},{}", lift(i + 181) - lift(i + 180))).collect(),
        };
        format!("# test\ncam_angle_deg,{form}\n{}\n", rows.join("\n"))
    }

    /// Increments per block, as on the tape, and absolute lifts give the same table.
    #[test]
    fn either_form_gives_the_same_table() {
        let absolute = parse(&located(&printed("lift_mm")), AngleUnit::Cam, None).unwrap();
        let increments = parse(&located(&printed("increment_um")), AngleUnit::Cam, None).unwrap();
        assert_eq!(absolute.blocks(), 360);
        assert_eq!(absolute.lifts_mm(), increments.lifts_mm());
        assert!((absolute.resolution_mm() - 0.001).abs() < 1e-15);
    }

    #[test]
    fn a_cell_that_is_no_number_is_refused_with_its_line() {
        let text = printed("lift_mm").replace("5,0.004", "5,x");
        let error = parse(&located(&text), AngleUnit::Cam, None).unwrap_err();
        assert_eq!(error.to_string(), "lift.csv:8: \"x\" is not a number");
    }

    #[test]
    fn a_column_of_crank_degrees_needs_the_declaration() {
        let text = printed("lift_mm").replace("cam_angle_deg", "crank_angle_deg");
        let error = parse(&located(&text), AngleUnit::Cam, None).unwrap_err();
        assert_eq!(error.to_string(), "lift.csv:2: column crank_angle_deg, but the job declares cam_angle_deg");
    }
}
