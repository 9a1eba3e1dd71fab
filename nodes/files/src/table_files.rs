// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Files of a lift table and the errors found in them.

use super::lift_text::Printed;
use super::{ConfigError, FileLocation};
use camwright::cam::lift::{LiftError, LiftTable, LiftWarning};
use std::path::Path;

/// The files of a table, the second one's lines counted on from the first one's.
pub(super) struct TableFiles<'a> {
    pub(super) files: Vec<(&'a Path, &'a Printed)>,
    /// One file holds the whole turn.
    is_whole: bool,
}

impl<'a> TableFiles<'a> {
    /// A file with a whole turn.
    pub(super) fn of_whole(path: &'a Path, printed: &'a Printed) -> Self {
        Self { files: vec![(path, printed)], is_whole: true }
    }

    /// Files with a flank each.
    pub(super) fn of_flanks(files: Vec<(&'a Path, &'a Printed)>) -> Self {
        Self { files, is_whole: false }
    }

    fn place(&self, line: Option<usize>) -> FileLocation {
        let (first, printed) = self.files[0];
        match (line, self.files.get(1)) {
            (Some(line), Some((second, _))) if line > printed.lines => {
                FileLocation::line(second, u64::try_from(line - printed.lines).unwrap_or(0))
            }
            (Some(line), _) => FileLocation::line(first, u64::try_from(line).unwrap_or(0)),
            (None, _) => FileLocation::file(first),
        }
    }

    /// The core writes the line at the head of its message; a message of this program begins with the file and that line.
    pub(super) fn error(&self, line: Option<usize>, text: &str) -> ConfigError {
        let message = match text.split_once(": ") {
            Some((head, message)) if head.starts_with("line ") => message,
            _ => text,
        };
        ConfigError::at(self.place(line), message)
    }

    pub(super) fn doubt(&self, doubt: &LiftWarning) -> ConfigError {
        self.error(doubt.line(), &doubt.to_string())
    }

    /// Findings of the text and of the core, row by row; a cell without a number is reported once, by the text.
    pub(super) fn errors(&self, findings: Vec<LiftError>) -> Vec<ConfigError> {
        let known: Vec<ConfigError> = self.files.iter().flat_map(|(_, printed)| printed.findings.clone()).collect();
        let core = findings.iter().map(|finding| {
            let text = format!(
                "{finding}{}",
                remedy(finding, self.is_whole).map_or(String::new(), |remedy| format!("; {remedy}"))
            );
            (finding, self.error(finding.line(), &text))
        });
        let new = core.filter(|(finding, error)| {
            !(matches!(finding, LiftError::NotFinite { .. }) && known.iter().any(|old| old.place == error.place))
        });
        let mut errors: Vec<ConfigError> = known.iter().cloned().chain(new.map(|(_, error)| error)).collect();
        let order = |error: &ConfigError| {
            let file = self.files.iter().position(|(path, _)| *path == error.place.file);
            (file, error.place.line)
        };
        errors.sort_by_key(order);
        // One finding for each row: the first, because the others may only follow from it.
        errors.dedup_by(|later, earlier| {
            later == earlier || (later.place == earlier.place && later.place.line.is_some())
        });
        errors
    }

    pub(super) fn table(
        &self,
        read: Result<(LiftTable, Vec<LiftWarning>), Vec<LiftError>>,
        warnings: &mut Vec<ConfigError>,
    ) -> Result<LiftTable, Vec<ConfigError>> {
        let (table, doubts) = read.map_err(|findings| self.errors(findings))?;
        let findings = self.errors(Vec::new());
        if !findings.is_empty() {
            return Err(findings);
        }
        for (_, printed) in &self.files {
            warnings.extend(printed.doubts.iter().cloned());
        }
        warnings.extend(doubts.iter().map(|doubt| self.doubt(doubt)));
        Ok(table)
    }
}

/// The key of a job that makes a table acceptable if it is right as it is.
fn remedy(finding: &LiftError, is_whole: bool) -> Option<&'static str> {
    match finding {
        LiftError::UnevenAngle { .. } | LiftError::MissingBlock { .. } if !is_whole => None,
        LiftError::UnevenAngle { .. } => Some("`uneven: true` reads rows at uneven angles"),
        LiftError::MissingBlock { .. } => {
            Some("`event_only: true` if only the base circle is missing, `uneven: true` if the angles are uneven")
        }
        LiftError::RowGap { .. } => Some("`event_only: true` if only the base circle is missing"),
        LiftError::BelowBase { .. } if is_whole => {
            Some("`smooth_within_um` or a coarser `resolution_mm` allows more, `lowest_lift_mm` a pocket")
        }
        LiftError::BelowBase { .. } | LiftError::FlankEndsHigh { .. } => {
            Some("`smooth_within_um` or a coarser `resolution_mm` allows more")
        }
        LiftError::Outlier { .. } | LiftError::Step { .. } | LiftError::Misclosure { .. } => {
            Some("a coarser `resolution_mm` allows more, `smooth_within_um` does not")
        }
        LiftError::CrankDegrees { .. } => Some("declare crank degrees"),
        LiftError::CamDegrees { .. } => {
            Some("declare cam degrees, or `event_only: true` if only the base circle is missing")
        }
        _ => None,
    }
}
