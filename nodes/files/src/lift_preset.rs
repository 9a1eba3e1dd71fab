// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Formats in which controls and programs write lift tables: what their files look like and what their columns are.

use super::{ConfigError, FileLocation};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::Path;

/// Format of a table. It presets the columns and their reading; keys beside it have priority.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LiftPreset {
    /// Cam profile of Kollmorgen KAS as CSV: rows X;Y;SPLINE between `TABLE_BEGIN` and `TABLE_END`. The largest X is one turn, the largest Y is
    /// `scale_mm`.
    Kas,
    /// Cam table of the ISG kernel (Beckhoff CNC): positions at even angles in 0.0001 mm between `Begintable` and `EndTable`.
    Isg,
    /// Points of a CODESYS cam: master (degrees of the cam), slave (mm), and perhaps velocity and acceleration, which are not read.
    Codesys,
    /// Lift event of an engine: crank degrees and mm. The rows of the base circle may be missing.
    Engine,
}

impl LiftPreset {
    const fn name(self) -> &'static str {
        match self {
            Self::Kas => "kas",
            Self::Isg => "isg",
            Self::Codesys => "codesys",
            Self::Engine => "engine",
        }
    }

    /// Columns of a table with so many cells in a row.
    pub(super) fn columns(self, cells: usize) -> Vec<String> {
        let columns: &[&str] = match (self, cells) {
            (Self::Kas, _) => &["turn_share", "lift_share", "kas_segment"],
            (Self::Isg, _) => &["lift_1e-4_mm"],
            (Self::Codesys, 2) => &["cam_angle_deg", "lift_mm"],
            (Self::Codesys, _) => &["cam_angle_deg", "lift_mm", "-", "-"],
            (Self::Engine, _) => &["crank_angle_deg", "lift_mm"],
        };
        columns.iter().map(|name| (*name).to_owned()).collect()
    }

    /// True if the rows may stand at any angles.
    pub(super) const fn uneven(self) -> bool {
        matches!(self, Self::Kas | Self::Codesys)
    }

    /// True if the rows of the base circle may be missing.
    pub(super) const fn event_only(self) -> bool {
        matches!(self, Self::Engine)
    }

    /// Words that begin the lines before and after the rows.
    const fn frame(self) -> Option<(&'static str, &'static str)> {
        match self {
            Self::Kas => Some(("TABLE_BEGIN", "TABLE_END")),
            Self::Isg => Some(("Begintable", "EndTable")),
            Self::Codesys | Self::Engine => None,
        }
    }

    /// Indices of the lines with the rows.
    ///
    /// # Errors
    /// A table that does not begin or end as the format has it, or that is not made of points.
    pub(super) fn rows(self, path: &Path, text: &str) -> Result<Range<usize>, Vec<ConfigError>> {
        let name = self.name();
        let Some((begin, end)) = self.frame() else { return Ok(0..text.lines().count()) };
        let starts =
            |line: &str, word: &str| line.trim().get(..word.len()).is_some_and(|head| head.eq_ignore_ascii_case(word));
        let missing = |word: &str| {
            let message = format!(
                "no line {word}: `preset: {name}` needs the rows between {begin} and {end}; is the file complete?"
            );
            vec![ConfigError::at(FileLocation::file(path), message)]
        };
        let first = text.lines().position(|line| starts(line, begin)).ok_or_else(|| missing(begin))?;
        let last = text.lines().position(|line| starts(line, end)).ok_or_else(|| missing(end))?;
        if last < first {
            return Err(missing(end));
        }
        if self == Self::Isg {
            check_isg_header(path, text, first + 1..last)?;
        }
        Ok(first + 1..last)
    }
}

/// Checks the header of a cam table of the ISG kernel: its type of interpolation and its number of rows.
fn check_isg_header(path: &Path, text: &str, rows: Range<usize>) -> Result<(), Vec<ConfigError>> {
    let mut errors = Vec::new();
    let has_content = |line: &str| !line.split('#').next().unwrap_or("").trim().is_empty();
    let count = text.lines().skip(rows.start).take(rows.len()).filter(|line| has_content(line)).count();
    for (number, line) in (1_u64..).zip(text.lines().take(rows.start)) {
        let Some((key, value)) = line.split('#').next().unwrap_or("").split_once('=') else { continue };
        let (key, value) = (key.trim(), value.trim());
        let message = match key.to_ascii_lowercase().as_str() {
            "functiontype" if !matches!(value, "0" | "1" | "2") => Some(format!(
                "{key} = {value}: only interpolation points at even angles are read (0, 1 or 2), not sections of motion"
            )),
            "lines" if value.parse() != Ok(count) => {
                Some(format!("{key} = {value}, but {count} rows follow; is the file complete?"))
            }
            _ => None,
        };
        errors.extend(message.map(|message| ConfigError::at(FileLocation::line(path, number), message)));
    }
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}
