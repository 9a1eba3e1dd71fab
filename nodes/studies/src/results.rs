// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Results of a study: one row for each finished case, in the order of the cases.

use super::case_run::{CaseOutcome, CaseStatus};
use super::cases::StudyCase;
use super::engine::CaseOutcomes;
use super::table::{ColumnData, ResultTable};
use camwright_files::study_file::{Study, StudyResponse};
use camwright_files::yaml::YamlValue;

/// A finished case.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyRow {
    pub case: StudyCase,
    pub outcome: CaseOutcome,
    /// The case keeps every limit of the study.
    pub is_feasible: bool,
}

/// All finished cases of a study.
#[derive(Debug, Clone)]
pub struct StudyResults<'a> {
    pub study: &'a Study,
    /// Finished cases in their order.
    pub rows: Vec<StudyRow>,
    /// Number of all cases.
    pub case_count: usize,
    /// Kind of each setting, that of all cases, so that tables of some of them fit together.
    setting_kinds: Vec<SettingKind>,
}

/// Column for the values of a setting.
#[derive(Debug, Clone, Copy)]
enum SettingKind {
    Whole,
    Number,
    Text,
}

impl SettingKind {
    fn of_all<'v>(values: impl Iterator<Item = &'v YamlValue> + Clone) -> Self {
        if values.clone().all(|value| matches!(value, YamlValue::Integer(_))) {
            Self::Whole
        } else if values.clone().all(|value| as_number(value).is_some()) {
            Self::Number
        } else {
            Self::Text
        }
    }
}

impl<'a> StudyResults<'a> {
    #[must_use]
    pub fn new(study: &'a Study, cases: &[StudyCase], outcomes: &CaseOutcomes) -> Self {
        let row = |case: &StudyCase| {
            let outcome = outcomes.get(&case.hash)?.clone();
            let is_feasible = is_feasible(study, &outcome);
            Some(StudyRow { case: case.clone(), outcome, is_feasible })
        };
        let count = cases.first().map_or(0, |case| case.settings.len());
        let values =
            |index: usize| cases.iter().filter_map(move |case| case.settings.get(index)).map(|(_, value)| value);
        let setting_kinds = (0..count).map(|index| SettingKind::of_all(values(index))).collect();
        Self { study, rows: cases.iter().filter_map(row).collect(), case_count: cases.len(), setting_kinds }
    }

    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.rows.len() == self.case_count
    }

    /// Number of cases with this end.
    #[must_use]
    pub fn count(&self, status: CaseStatus) -> usize {
        self.rows.iter().filter(|row| row.outcome.status == status).count()
    }

    /// Limits of the study in words.
    #[must_use]
    pub fn limits_text(&self) -> String {
        let limit = |(response, max): &(StudyResponse, f64)| format!("{} <= {max}", response.name());
        self.study.limits.iter().map(limit).collect::<Vec<_>>().join(", ")
    }

    /// One row for each case, for files.
    pub(crate) fn table(&self) -> ResultTable {
        let whole = |of: &dyn Fn(&StudyRow) -> Option<i64>| ColumnData::Whole(self.rows.iter().map(of).collect());
        let text = |of: &dyn Fn(&StudyRow) -> String| ColumnData::Text(self.rows.iter().map(of).map(Some).collect());
        let mut columns: Vec<(String, ColumnData)> = vec![
            ("case".into(), whole(&|row| Some(i64::from(row.case.number)))),
            ("hash".into(), text(&|row| row.case.hash.clone())),
            ("point".into(), whole(&|row| Some(i64::from(row.case.point)))),
            ("replicate".into(), whole(&|row| Some(i64::from(row.case.replicate)))),
        ];
        let keys = self.study.factors.iter().map(|factor| &factor.key).chain(&self.study.seeds);
        for (index, key) in keys.enumerate() {
            columns.push((key.clone(), self.setting_column(index)));
        }
        columns.push(("status".into(), text(&|row| row.outcome.status.name().to_owned())));
        columns.push(("feasible".into(), whole(&|row| Some(i64::from(row.is_feasible)))));
        for response in &self.study.responses {
            let values = self.rows.iter().map(|row| row.outcome.response(*response)).collect();
            columns.push((response.name().into(), ColumnData::Number(values)));
        }
        let worst = self.rows.iter().map(|row| row.outcome.worst_lobe.clone()).collect();
        columns.push(("worst_lobe".into(), ColumnData::Text(worst)));
        columns.push(("alarm".into(), whole(&|row| row.outcome.alarm.map(i64::from))));
        columns.push(("reason".into(), text(&|row| row.outcome.reason.clone())));
        ResultTable { columns }
    }

    /// Values of a setting: whole numbers, numbers or texts.
    fn setting_column(&self, index: usize) -> ColumnData {
        let values = self.rows.iter().map(|row| row.case.settings.get(index).map(|(_, value)| value));
        let whole = |value: &YamlValue| match value {
            YamlValue::Integer(value) => Some(*value),
            _ => None,
        };
        let text = |value: &YamlValue| match value {
            YamlValue::Text(text) => text.clone(),
            other => other.to_flow(),
        };
        match self.setting_kinds.get(index) {
            Some(SettingKind::Whole) => ColumnData::Whole(values.map(|value| value.and_then(whole)).collect()),
            Some(SettingKind::Number) => ColumnData::Number(values.map(|value| value.and_then(as_number)).collect()),
            Some(SettingKind::Text) | None => ColumnData::Text(values.map(|value| value.map(text)).collect()),
        }
    }
}

/// Number of a value, if it is one.
pub(crate) fn as_number(value: &YamlValue) -> Option<f64> {
    match value {
        YamlValue::Integer(value) => Some(*value as f64),
        YamlValue::Float(value) => Some(*value),
        _ => None,
    }
}

/// Returns whether a part was made and keeps all limits. A result that the job does not have keeps its limit.
fn is_feasible(study: &Study, outcome: &CaseOutcome) -> bool {
    let is_kept =
        |(response, max): &(StudyResponse, f64)| outcome.response(*response).is_none_or(|value| value <= *max);
    outcome.status == CaseStatus::Done && study.limits.iter().all(is_kept)
}
