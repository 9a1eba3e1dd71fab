// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The text of a lift table: columns of numbers under comments and titles, in whatever separators and decimals its program
//! prints, with nothing guessed: what the file leaves open the job declares, and what contradicts it is refused.
//!
//! ```text
//! # anything                      comment lines begin with #, //, !, % or *; # also ends a row
//! LIFT TABLE 4711                 titles: lines before the first row
//! cam_angle_deg;lift_mm           a header that names the columns, unless the job does
//! 0,0;0,000                       rows: semicolon, |, tab, comma or blanks; decimal commas if declared
//! ```

use super::lift_preset::LiftPreset;
use super::locate::Located;
use super::{ConfigError, FileLocation};
use camwright::cam::lift::points::ContourPoint;
use camwright::cam::lift::{LengthUnit, LiftForm, LiftRow, LiftTable};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::Path;

/// Declared unit of the angles of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AngleUnitFile {
    /// Degrees of the cam: one turn is 360.
    Cam,
    /// Degrees of the crank: one turn of the cam is 720.
    Crank,
}

impl AngleUnitFile {
    /// Name of a column of such angles.
    #[must_use]
    pub const fn column(self) -> &'static str {
        match self {
            AngleUnitFile::Cam => "cam_angle_deg",
            AngleUnitFile::Crank => "crank_angle_deg",
        }
    }

    /// The same in the core.
    #[must_use]
    pub const fn core(self) -> camwright::cam::lift::AngleUnit {
        match self {
            AngleUnitFile::Cam => camwright::cam::lift::AngleUnit::CamDegrees,
            AngleUnitFile::Crank => camwright::cam::lift::AngleUnit::CrankDegrees,
        }
    }
}

/// Declared format of a table's text.
#[derive(Debug, Clone, Default)]
pub struct TextFormat {
    /// Names of the columns; none: the file's header has them.
    pub columns: Option<Vec<String>>,
    /// Unit of the angles; `None`: cam degrees, unless the declared columns say otherwise.
    pub angle: Option<AngleUnitFile>,
    /// Lines to skip before anything is read; none: what does not begin with a number is a title.
    pub header_lines: Option<usize>,
    /// Numbers have a decimal comma.
    pub decimal_comma: bool,
    /// Angle from row to row where the file has no angles (deg of `angle`).
    pub step_deg: Option<f64>,
    /// Arc of a degree of the arm (mm), for an oscillating follower.
    pub mm_per_deg: Option<f64>,
    /// Format of a control or program.
    pub preset: Option<LiftPreset>,
    /// Lift of the largest value in a column `lift_share` (mm).
    pub scale_mm: Option<f64>,
}

/// Content of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    /// Lifts of a follower, or their increments.
    Lift,
    /// Radii of the contour over the azimuth.
    Radius,
    /// Points of the contour.
    Points,
    /// Deviations from the contour, as reports of measuring machines have them.
    Deviation,
}

/// The text of a table as numbers.
#[derive(Debug, Clone)]
pub struct Printed {
    /// Rows; a cell without a number is NaN, and reported in `findings`.
    pub rows: Vec<LiftRow>,
    /// Points instead of rows, where the table is of those.
    pub points: Vec<ContourPoint>,
    /// Content of the table.
    pub content: Content,
    /// Meaning of the values.
    pub form: LiftForm,
    /// Unit of the printed values.
    pub unit: LengthUnit,
    /// Unit of the angles.
    pub angle: AngleUnitFile,
    /// The last digit printed (mm).
    pub last_digit_mm: f64,
    pub lines: usize,
    /// Cells and rows that are none.
    pub findings: Vec<ConfigError>,
    /// Words of comments and titles that contradict the declaration.
    pub doubts: Vec<ConfigError>,
}

impl Printed {
    /// Rounds rows that a spline gave to two digits more than the file prints: further digits mean nothing, and a table needs a last one.
    pub(super) fn round_resampled(&mut self) {
        let step = 0.01 * self.last_digit_mm;
        for row in &mut self.rows {
            row.value_mm = step * (row.value_mm / step).round();
        }
    }
}

/// Scale of printed angles.
#[derive(Debug, Clone, Copy, PartialEq)]
enum AngleScale {
    /// Degrees per printed unit.
    Degrees(f64),
    /// Shares of the largest angle, which is one turn.
    Share,
}

/// Scale of printed lifts.
#[derive(Debug, Clone, Copy, PartialEq)]
enum LiftScale {
    /// Millimetres per printed unit.
    Millimetres(f64),
    /// Degrees of a follower's arm.
    ArmDegrees,
    /// Shares of the largest lift, which the job declares.
    Share,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum TableColumn {
    Angle {
        unit: AngleUnitFile,
        scale: AngleScale,
    },
    /// Type of a segment of a KAS profile: only splines are read.
    KasSegment,
    /// Lifts or increments.
    Value {
        form: LiftForm,
        scale: LiftScale,
        unit: LengthUnit,
    },
    /// Radii of the contour.
    Radius(LengthUnit),
    /// The first coordinate of its points, towards azimuth 0.
    X(LengthUnit),
    Y(LengthUnit),
    /// Deviations along the normal (mm per printed unit).
    Deviation(f64, LengthUnit),
    Ignored,
}

const KNOWN: &str = "block, cam_angle_deg, crank_angle_deg, cam_angle_rad, crank_angle_rad, turn_share, lift_mm, lift_um, \
                     lift_inch, lift_deg, lift_1e-4_mm, lift_share, kas_segment, increment_mm, \
                     increment_um, increment_inch, increment_deg, azimuth_deg, radius_mm, radius_inch, x_mm, y_mm, x_inch, y_inch";

const DEG_PER_RAD: f64 = 180.0 / std::f64::consts::PI;

fn column(name: &str) -> Option<TableColumn> {
    let value = |form, mm, unit| Some(TableColumn::Value { form, scale: LiftScale::Millimetres(mm), unit });
    let scaled = |form, scale| Some(TableColumn::Value { form, scale, unit: LengthUnit::Millimetre });
    let degrees = |form| scaled(form, LiftScale::ArmDegrees);
    let angle = |unit, deg| Some(TableColumn::Angle { unit, scale: AngleScale::Degrees(deg) });
    match name {
        "block" | "-" => Some(TableColumn::Ignored),
        "cam_angle_deg" | "azimuth_deg" => angle(AngleUnitFile::Cam, 1.0),
        "crank_angle_deg" => angle(AngleUnitFile::Crank, 1.0),
        "cam_angle_rad" => angle(AngleUnitFile::Cam, DEG_PER_RAD),
        "crank_angle_rad" => angle(AngleUnitFile::Crank, DEG_PER_RAD),
        "turn_share" => Some(TableColumn::Angle { unit: AngleUnitFile::Cam, scale: AngleScale::Share }),
        "lift_share" => scaled(LiftForm::Absolute, LiftScale::Share),
        "kas_segment" => Some(TableColumn::KasSegment),
        "lift_1e-4_mm" => value(LiftForm::Absolute, 1e-4, LengthUnit::Millimetre),
        "deviation_um" => Some(TableColumn::Deviation(1e-3, LengthUnit::Millimetre)),
        "deviation_mm" => Some(TableColumn::Deviation(1.0, LengthUnit::Millimetre)),
        "deviation_inch" => Some(TableColumn::Deviation(LengthUnit::Inch.mm(), LengthUnit::Inch)),
        "radius_mm" => Some(TableColumn::Radius(LengthUnit::Millimetre)),
        "radius_inch" => Some(TableColumn::Radius(LengthUnit::Inch)),
        "x_mm" => Some(TableColumn::X(LengthUnit::Millimetre)),
        "x_inch" => Some(TableColumn::X(LengthUnit::Inch)),
        "y_mm" => Some(TableColumn::Y(LengthUnit::Millimetre)),
        "y_inch" => Some(TableColumn::Y(LengthUnit::Inch)),
        "lift_mm" => value(LiftForm::Absolute, 1.0, LengthUnit::Millimetre),
        "lift_um" => value(LiftForm::Absolute, 1e-3, LengthUnit::Millimetre),
        "lift_inch" => value(LiftForm::Absolute, LengthUnit::Inch.mm(), LengthUnit::Inch),
        "lift_deg" => degrees(LiftForm::Absolute),
        "increment_deg" => degrees(LiftForm::Increments),
        "increment_mm" => value(LiftForm::Increments, 1.0, LengthUnit::Millimetre),
        "increment_um" => value(LiftForm::Increments, 1e-3, LengthUnit::Millimetre),
        "increment_inch" => value(LiftForm::Increments, LengthUnit::Inch.mm(), LengthUnit::Inch),
        _ => None,
    }
}

/// Most rows of a table: one for every block, and the first again.
const MAX_ROWS: usize = LiftTable::MAX_BLOCKS + 1;

/// Separator between two cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Separator {
    Char(char),
    Blanks,
}

impl Separator {
    /// The strongest one in a line; a comma is none where it is the decimal one.
    fn from_line(line: &str, decimal_comma: bool) -> Self {
        let candidates: &[char] = if decimal_comma { &[';', '|', '\t'] } else { &[';', '|', '\t', ','] };
        candidates.iter().find(|c| line.contains(**c)).map_or(Separator::Blanks, |c| Separator::Char(*c))
    }

    /// Cells, trimmed. A separator at the end of the line has nothing behind it.
    fn split(self, line: &str) -> Vec<&str> {
        match self {
            Separator::Blanks => line.split_whitespace().collect(),
            Separator::Char(c) => line.trim_end().trim_end_matches(c).split(c).map(str::trim).collect(),
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct AngleColumn {
    index: usize,
    unit: AngleUnitFile,
    scale: AngleScale,
}

/// Columns with what they mean.
struct TableColumns {
    angle: Option<AngleColumn>,
    value: usize,
    /// The values are shares of the largest.
    is_share: bool,
    /// Column of the types of segments of a KAS profile.
    kas_segment: Option<usize>,
    /// For points: column of y; `value` is x.
    second: Option<usize>,
    content: Content,
    form: LiftForm,
    mm_per_unit: f64,
    unit: LengthUnit,
    count: usize,
}

/// Reads the text of a table.
///
/// # Errors
/// No rows, or columns that are not known or contradict the declaration. Faults of single rows are in
/// [`Printed::findings`].
pub fn read(located: &Located, format: &TextFormat) -> Result<Printed, Vec<ConfigError>> {
    let path = &located.path;
    let text = located.text.trim_start_matches('\u{feff}');
    let lines = text.lines().count();
    let framed = format.preset.map(|preset| preset.rows(path, text)).transpose()?.unwrap_or(0..lines);
    let skipped = format.header_lines.unwrap_or(0).min(lines).max(framed.start);
    let SortedLines { titles, mut comments, body } = sorted(path, text, skipped..framed.end)?;
    let at = |number: u64, message: String| vec![ConfigError::at(FileLocation::line(path, number), message)];
    let Some(&(first_row, first_text)) = body.first() else {
        return Err(match titles.last() {
            None => vec![ConfigError::at(FileLocation::file(path), "is empty; a header line and rows are needed")],
            Some((number, _)) => at(*number, "no row of numbers follows this line".into()),
        });
    };
    let separator = Separator::from_line(first_text, format.decimal_comma);
    let commas = if format.decimal_comma { Vec::new() } else { decimal_commas(&body, separator) };
    let example = Example { path, cells: separator.split(first_text).len(), decimal_comma: !commas.is_empty() };
    let (columns, header) = columns(path, &titles, first_row, format, &example)?;
    if let [(number, cell), others @ ..] = commas.as_slice() {
        let count = if others.is_empty() { String::new() } else { format!(", as have {} others", others.len()) };
        return Err(at(
            *number,
            format!("{cell:?} has a decimal comma{count}; the job must declare `decimal_comma: true`"),
        ));
    }
    comments.extend(titles.iter().filter(|(number, _)| header != Some(*number)));
    let angle = columns.angle.map_or(format.angle.unwrap_or(AngleUnitFile::Cam), |column| column.unit);
    if columns.angle.is_some() && format.step_deg.is_some() {
        let message = "the table has a column of angles, and the job declares a step as if it had none";
        return Err(at(header.unwrap_or(first_row), message.into()));
    }
    if columns.second.is_some() && format.step_deg.is_some() {
        let message = "the table is of points, and the job declares a step of their angles";
        return Err(at(header.unwrap_or(first_row), message.into()));
    }
    let mut printed = Printed {
        rows: Vec::new(),
        points: Vec::new(),
        content: columns.content,
        form: columns.form,
        unit: columns.unit,
        angle,
        last_digit_mm: columns.mm_per_unit,
        lines,
        findings: Vec::new(),
        doubts: doubts(path, &comments, columns.unit, columns.angle.map(|column| column.unit).or(format.angle)),
    };
    read_rows(&mut printed, path, &body, &columns, separator, format);
    scale_shares(&mut printed, &columns, format);
    Ok(printed)
}

/// Scales shares of the largest angle and of the largest lift.
fn scale_shares(printed: &mut Printed, columns: &TableColumns, format: &TextFormat) {
    let largest = |values: &mut dyn Iterator<Item = f64>| values.filter(|value| value.is_finite()).fold(0.0, f64::max);
    if columns.angle.is_some_and(|column| column.scale == AngleScale::Share) {
        // Without a positive share every row stands at one angle, which is reported as such.
        let turn = largest(&mut printed.rows.iter().filter_map(|row| row.angle_deg));
        for row in printed.rows.iter_mut().filter(|_| turn > 0.0) {
            row.angle_deg = row.angle_deg.map(|share| share * (360.0 / turn));
        }
    }
    if let Some(scale_mm) = format.scale_mm.filter(|_| columns.is_share) {
        let share = largest(&mut printed.rows.iter().map(|row| row.value_mm));
        let mm_per_share = if share > 0.0 { scale_mm / share } else { 1.0 };
        for row in &mut printed.rows {
            row.value_mm *= mm_per_share;
        }
        printed.last_digit_mm *= mm_per_share;
    }
}

/// Cells with a decimal comma, each with its line.
fn decimal_commas<'a>(body: &[(u64, &'a str)], separator: Separator) -> Vec<(u64, &'a str)> {
    let has_comma = |cell: &&str| cell.parse::<f64>().is_err() && cell.replacen(',', ".", 1).parse::<f64>().is_ok();
    body.iter()
        .flat_map(|&(number, text)| separator.split(text).into_iter().filter(has_comma).map(move |cell| (number, cell)))
        .collect()
}

/// Facts about a table without known columns, for an example of its declaration.
struct Example<'a> {
    path: &'a Path,
    cells: usize,
    decimal_comma: bool,
}

impl Example<'_> {
    /// The key `lift` of a job for this table. Columns that a header names keep their names.
    fn declaration(&self, header: &[String]) -> String {
        let is_value = |name: &str| {
            column(name).is_some_and(|known| {
                !matches!(known, TableColumn::Angle { .. } | TableColumn::Ignored | TableColumn::KasSegment)
            })
        };
        let is_angle = |name: &str| matches!(column(name), Some(TableColumn::Angle { .. }));
        let is_inch = |name: &&String| ["inch", "zoll"].iter().any(|word| name.to_lowercase().contains(word));
        let mut needs_angle = self.cells > 1 && !header.iter().any(|name| is_angle(name));
        let mut needs_value = !header.iter().any(|name| is_value(name));
        let columns: Vec<&str> = (0..self.cells)
            .map(|index| match header.get(index).filter(|name| column(name).is_some()) {
                Some(known) => known.as_str(),
                None if std::mem::take(&mut needs_angle) => "cam_angle_deg",
                None if std::mem::take(&mut needs_value) => {
                    if header.get(index).filter(is_inch).is_some() {
                        "lift_inch"
                    } else {
                        "lift_mm"
                    }
                }
                None => "\"-\"",
            })
            .collect();
        let file = self.path.file_name().unwrap_or_default().to_string_lossy();
        let step = if self.cells == 1 { ", step_cam_deg: 1" } else { "" };
        let comma = if self.decimal_comma { ", decimal_comma: true" } else { "" };
        format!("lift: {{table: {file}, columns: [{}]{step}{comma}}}", columns.join(", "))
    }
}

/// The lines of a text by what they are, each with its number.
struct SortedLines<'a> {
    /// Before the first row.
    titles: Vec<(u64, &'a str)>,
    /// Comments, and lines that the job skips.
    comments: Vec<(u64, &'a str)>,
    body: Vec<(u64, &'a str)>,
}

fn sorted<'a>(path: &Path, text: &'a str, rows: Range<usize>) -> Result<SortedLines<'a>, Vec<ConfigError>> {
    let mut titles: Vec<(u64, &str)> = Vec::new();
    let mut comments: Vec<(u64, &str)> = (1_u64..).zip(text.lines()).take(rows.start).collect();
    let mut body: Vec<(u64, &str)> = Vec::new();
    for (number, line) in (1_u64..).zip(text.lines()).take(rows.end).skip(rows.start) {
        let content = line.split('#').next().unwrap_or("").trim();
        if content.is_empty() || content.starts_with("//") || content.starts_with(['!', '%', '*']) {
            comments.push((number, line));
        } else if body.is_empty() && !begins_with_number(content) {
            titles.push((number, content));
        } else if body.len() == MAX_ROWS {
            let message = format!("is a row too many: a table has at most {MAX_ROWS}, for steps of 0.01 deg");
            return Err(vec![ConfigError::at(FileLocation::line(path, number), message)]);
        } else {
            // Tabs at the head of a row are an empty cell, not space.
            body.push((number, line.split('#').next().unwrap_or("").trim_matches(' ').trim_end()));
        }
    }
    Ok(SortedLines { titles, comments, body })
}

/// Reads rows into what is printed, with what is wrong in them.
fn read_rows(
    printed: &mut Printed,
    path: &Path,
    body: &[(u64, &str)],
    columns: &TableColumns,
    separator: Separator,
    format: &TextFormat,
) {
    let mut digits = 0;
    for (index, &(number, text)) in body.iter().enumerate() {
        let mut refuse =
            |message: String| printed.findings.push(ConfigError::at(FileLocation::line(path, number), message));
        let cells = separator.split(text);
        let mut number_of = |index: usize| match cells.get(index) {
            Some(cell) => parse(cell, format.decimal_comma).unwrap_or_else(|message| {
                refuse(message);
                f64::NAN
            }),
            None => f64::NAN,
        };
        let (mut angle_deg, mut value) =
            (columns.angle.map(|column| number_of(column.index)), number_of(columns.value));
        let second = columns.second.map(&mut number_of);
        if let Some(kind) = columns.kas_segment.and_then(|index| cells.get(index)).filter(|kind| **kind != "SPLINE") {
            refuse(format!("segment {kind}: of a KAS profile only segments SPLINE are read"));
        }
        if cells.len() != columns.count {
            refuse(format!("{} columns, the header has {}", cells.len(), columns.count));
            (angle_deg, value) = (angle_deg.map(|_| f64::NAN), f64::NAN);
        } else if value.is_finite() {
            let printed = [Some(columns.value), columns.second].into_iter().flatten().filter_map(|at| cells.get(at));
            digits = printed.map(|cell| decimals(cell)).fold(digits, i32::max);
        }
        let line = usize::try_from(number).unwrap_or(usize::MAX);
        if let Some(second) = second {
            let (x_mm, y_mm) = (value * columns.mm_per_unit, second * columns.mm_per_unit);
            printed.points.push(ContourPoint { line, x_mm, y_mm });
            continue;
        }
        let stepped = || format.step_deg.map(|step| index as f64 * step);
        if let Some(AngleColumn { scale: AngleScale::Degrees(deg), .. }) = columns.angle {
            angle_deg = angle_deg.map(|angle| angle * deg);
        }
        printed.rows.push(LiftRow {
            line,
            angle_deg: angle_deg.or_else(stepped),
            value_mm: value * columns.mm_per_unit,
        });
    }
    printed.last_digit_mm /= 10_f64.powi(digits);
}

/// The columns, declared or from the header, and the line of the header.
fn columns(
    path: &Path,
    titles: &[(u64, &str)],
    first_row: u64,
    format: &TextFormat,
    example: &Example<'_>,
) -> Result<(TableColumns, Option<u64>), Vec<ConfigError>> {
    let names = |text: &str| -> Vec<String> {
        Separator::from_line(text, false)
            .split(text)
            .into_iter()
            .map(|name| name.trim_matches('"').to_owned())
            .collect()
    };
    let is_value = |name: &String| {
        matches!(
            column(name),
            Some(
                TableColumn::Value { .. }
                    | TableColumn::Radius(_)
                    | TableColumn::X(_)
                    | TableColumn::Y(_)
                    | TableColumn::Deviation(..)
            )
        )
    };
    let header = titles.iter().rev().find(|(_, text)| names(text).iter().any(is_value));
    let refuse = |number, message: String| vec![ConfigError::at(FileLocation::line(path, number), message)];
    let preset = || format.preset.map(|preset| preset.columns(example.cells));
    if let Some(declared) = &format.columns.clone().or_else(preset) {
        let columns = understand(declared, None, format).map_err(|message| refuse(first_row, message))?;
        // A header that the file has all the same must not say something else.
        for (number, text) in titles {
            for (index, name) in names(text).into_iter().enumerate() {
                if column(&name).is_some_and(|known| known != TableColumn::Ignored)
                    && declared.get(index) != Some(&name)
                {
                    let comments = declared.get(index).map_or("no such column", String::as_str);
                    return Err(refuse(*number, format!("column {name}, but the job declares {comments}")));
                }
            }
        }
        return Ok((columns, None));
    }
    match (header, titles.last()) {
        (Some((number, text)), _) => {
            let columns =
                understand(&names(text), Some(AngleUnitFile::Cam), format).map_err(|error| refuse(*number, error))?;
            Ok((columns, Some(*number)))
        }
        (None, Some((number, text))) => {
            let header = names(text);
            let message = match header.iter().find(|name| column(name).is_none()) {
                Some(name) => format!(
                    "unknown column {name:?}; name the columns in the job, for example `{}`; known columns: {KNOWN}",
                    example.declaration(&header)
                ),
                None => format!("no column of lifts or increments in the header; known are {KNOWN}"),
            };
            Err(refuse(*number, message))
        }
        (None, None) => {
            let message = format!(
                "no header line names the columns; the job must, for example `{}`; known columns: {KNOWN}",
                example.declaration(&[])
            );
            Err(refuse(first_row, message))
        }
    }
}

/// Checks columns that a job declares.
pub(super) fn check_columns(format: &TextFormat) -> Result<(), String> {
    let Some(declared) = &format.columns else { return Ok(()) };
    understand(declared, None, format).map(|_| ())
}

/// Columns by their names; `default_angle` is what the angles must be where the job does not declare it.
fn understand(
    names: &[String],
    default_angle: Option<AngleUnitFile>,
    format: &TextFormat,
) -> Result<TableColumns, String> {
    type Found = (usize, Content, LiftForm, f64, LengthUnit);
    let mut found: Option<Found> = None;
    let mut is_share = false;
    let mut kas_segment = None;
    let mut second: Option<(usize, LengthUnit)> = None;
    let mut angles: Option<AngleColumn> = None;
    for (index, name) in names.iter().enumerate() {
        let mut take = |new: Found| match found.replace(new) {
            None => Ok(()),
            Some((_, Content::Lift, ..)) if new.1 == Content::Lift => {
                Err("two columns of lifts or increments; one is needed".to_owned())
            }
            Some(_) => {
                Err(format!("column {name} beside another of lifts, radii or points; one kind of them is needed"))
            }
        };
        let contour = |content, unit: LengthUnit| (index, content, LiftForm::Absolute, unit.mm(), unit);
        match column(name) {
            Some(TableColumn::Ignored) => {}
            Some(TableColumn::KasSegment) => kas_segment = Some(index),
            Some(TableColumn::Angle { unit, scale }) => match format.angle.or(default_angle) {
                Some(declared) if declared != unit => {
                    return Err(format!("column {name}, but the job declares {}", declared.column()));
                }
                _ if angles.is_some() => return Err("two columns of angles; one is needed".into()),
                _ => angles = Some(AngleColumn { index, unit, scale }),
            },
            Some(TableColumn::Deviation(mm, unit)) => {
                take((index, Content::Deviation, LiftForm::Absolute, mm, unit))?;
            }
            Some(TableColumn::Radius(unit)) => take(contour(Content::Radius, unit))?,
            Some(TableColumn::X(unit)) => take(contour(Content::Points, unit))?,
            Some(TableColumn::Y(_)) if second.is_some() => return Err("two columns of y; one is needed".into()),
            Some(TableColumn::Y(unit)) => second = Some((index, unit)),
            Some(TableColumn::Value { form, scale, unit }) => {
                let mm_per_unit = match scale {
                    LiftScale::Millimetres(mm) => mm,
                    LiftScale::ArmDegrees => format.mm_per_deg.ok_or_else(|| {
                        format!("column {name} holds the angle of an arm, and no follower that swings is given")
                    })?,
                    LiftScale::Share => format.scale_mm.map(|_| 1.0).ok_or_else(|| {
                        format!("column {name} holds shares of the largest lift; `scale_mm` must say how large that is")
                    })?,
                };
                is_share = scale == LiftScale::Share;
                take((index, Content::Lift, form, mm_per_unit, unit))?;
            }
            None => return Err(format!("unknown column {name:?}; known are {KNOWN}")),
        }
    }
    let (value, content, form, mm_per_unit, unit) =
        found.ok_or_else(|| format!("no column of lifts or increments, of radii, or of x and y; known are {KNOWN}"))?;
    match (content, second) {
        (Content::Points, Some((_, other))) if other != unit => {
            return Err("x and y are in two units; one is needed".into());
        }
        (Content::Points, None) => return Err("a column of x needs one of y".into()),
        (Content::Points, Some(_)) if angles.is_some() => {
            return Err("a column of angles beside x and y, which say the azimuth themselves".into());
        }
        (Content::Lift | Content::Radius | Content::Deviation, Some(_)) => {
            return Err("a column of y needs one of x".into());
        }
        _ => {}
    }
    if format.scale_mm.is_some() && !is_share {
        return Err("scale_mm is about a column lift_share; the table has none".into());
    }
    let second = second.map(|(index, _)| index);
    let count = names.len();
    Ok(TableColumns { angle: angles, value, is_share, kas_segment, second, content, form, mm_per_unit, unit, count })
}

fn begins_with_number(line: &str) -> bool {
    let first = line.split([';', '\t', ',', ' ']).next().unwrap_or("");
    first.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.')) && first.parse::<f64>().is_ok()
}

fn parse(cell: &str, decimal_comma: bool) -> Result<f64, String> {
    let no_number = || format!("{cell:?} is not a number");
    if decimal_comma {
        if cell.contains('.') {
            return Err(format!("{cell:?} has a decimal point, the job declares decimal commas"));
        }
        return cell.replace(',', ".").parse().map_err(|_| no_number());
    }
    cell.parse().map_err(|_| no_number())
}

/// Digits after the decimal point of a number, its exponent counted in.
fn decimals(cell: &str) -> i32 {
    let (mantissa, exponent) = cell.split_once(['e', 'E']).unwrap_or((cell, "0"));
    let fraction = mantissa.split_once(['.', ',']).map_or(0, |(_, fraction)| fraction.len());
    let fraction = i32::try_from(fraction).unwrap_or(i32::MAX);
    fraction.saturating_sub(exponent.parse::<i32>().unwrap_or(0)).clamp(0, 300)
}

/// Comments and titles that name another unit than the declared one.
fn doubts(path: &Path, comments: &[(u64, &str)], unit: LengthUnit, angle: Option<AngleUnitFile>) -> Vec<ConfigError> {
    let mut doubts = Vec::new();
    for (number, line) in comments {
        let words: Vec<String> =
            line.split(|c: char| !c.is_ascii_alphanumeric()).map(str::to_ascii_lowercase).collect();
        let has_unit = |known: &[&str]| words.iter().find(|word| known.contains(&word.as_str()));
        let (inches, millimetres) = (
            has_unit(&["inch", "inches"]),
            has_unit(&["mm", "millimetre", "millimetres", "millimeter", "millimeters"]),
        );
        let (cam, crank) = (has_unit(&["cam", "camshaft"]), has_unit(&["crank", "crankshaft"]));
        let mut doubt = |comments: Option<&String>, against: Option<&String>, declared: &str| {
            if let (Some(word), None) = (comments, against) {
                let message = format!("the file says {word:?} here, declared are {declared}");
                doubts.push(ConfigError::at(FileLocation::line(path, *number), message));
            }
        };
        match unit {
            LengthUnit::Millimetre => doubt(inches, millimetres, "millimetres"),
            LengthUnit::Inch => doubt(millimetres, inches, "inches"),
        }
        if angle == Some(AngleUnitFile::Cam) {
            doubt(crank, cam, "cam degrees");
        }
    }
    doubts
}
