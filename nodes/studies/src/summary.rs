// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Results of a study as text for a terminal, verdict first, and as JSON.

use super::analysis::{FactorEffect, short};
use super::case_run::CaseStatus;
use super::folder::{StudyFolder, set_text};
use super::results::{StudyResults, StudyRow};
use camwright_files::study_file::StudyResponse;
use serde_json::{Map, Value, json};

/// Maximum number of failure reasons in the text; the report lists all.
const MAX_REASONS: usize = 4;

impl StudyResults<'_> {
    /// Returns true if a point keeps every limit of the study.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.best().is_some()
    }

    /// One sentence about the study.
    #[must_use]
    pub fn verdict(&self) -> String {
        let limits = match self.limits_text() {
            text if text.is_empty() => "no limits".to_owned(),
            text => text,
        };
        match self.best() {
            Some(best) => format!(
                "GOOD: case {} of {} is feasible with the smallest {}: {}",
                self.rows[best.row].case.number,
                self.case_count,
                self.study.minimise.name(),
                short(best.value)
            ),
            None => format!("NOT GOOD: no point of {} cases is feasible ({limits})", self.case_count),
        }
    }

    /// The whole text. Lines may exceed 80 columns.
    #[must_use]
    pub fn text(&self, folder: &StudyFolder) -> String {
        let best = self.best();
        let mut text = self.verdict() + "\n";
        let value = |row: &StudyRow, response| row.outcome.response(response).map_or_else(|| "-".to_owned(), short);
        text += &format!("{:<18} {:>12} {:>12} {:>12} {:>12}\n", "result", "limit", "best case", "lowest", "highest");
        for response in &self.study.responses {
            let limit = self.study.limits.iter().find(|(limited, _)| limited == response);
            let values = || self.rows.iter().filter_map(|row| row.outcome.response(*response));
            let bound = |bound: Option<f64>| bound.map_or_else(|| "-".to_owned(), short);
            text += &format!(
                "{:<18} {:>12} {:>12} {:>12} {:>12}\n",
                response.name(),
                limit.map_or_else(|| "-".to_owned(), |(_, max)| short(*max)),
                best.as_ref().map_or_else(|| "-".to_owned(), |best| value(&self.rows[best.row], *response)),
                bound(values().min_by(f64::total_cmp)),
                bound(values().max_by(f64::total_cmp)),
            );
        }
        text += &format!("cases:   {}\n", self.counts_text());
        for failure in self.failures().iter().take(MAX_REASONS) {
            text += &format!(
                "  {} {}, first case {}: {}\n",
                failure.count,
                failure.status.name(),
                failure.first_case,
                failure.reason
            );
        }
        if let more @ 1.. = self.failures().len().saturating_sub(MAX_REASONS) {
            text += &format!("  {more} more reasons in the report\n");
        }
        for line in self.effect_lines() {
            text += &format!("effect:  {line}\n");
        }
        if let Some(best) = best {
            if self.study.factors.iter().any(|factor| factor.values.is_random()) || best.replicates > 1 {
                text += &format!("best:    mean of {} replicates; random values are not set\n", best.replicates);
            }
            // Lines that a shell takes as one command.
            let command = self.command(&best, folder).replace(" --set ", " \\\n         --set ");
            text += &format!("command: {command}\n");
        }
        text
    }

    fn counts_text(&self) -> String {
        let counts = CaseStatus::ALL.map(|status| (self.count(status), status.name()));
        let counts = counts.iter().filter(|(count, _)| *count > 0).map(|(count, name)| format!("{count} {name}"));
        let feasible = self.rows.iter().filter(|row| row.is_feasible).count();
        let open = self.case_count - self.rows.len();
        let open = if open > 0 { format!(", {open} not run yet") } else { String::new() };
        format!("{}, {feasible} feasible{open}", counts.collect::<Vec<_>>().join(", "))
    }

    /// One line for each factor: means of form error and time at its first and its last value.
    fn effect_lines(&self) -> Vec<String> {
        let effects = self.effects();
        let part = |effect: &&FactorEffect| {
            let (first, last) = (effect.levels.first()?, effect.levels.last()?);
            Some(format!("{} {} to {}", effect.response.name(), short(first.mean), short(last.mean)))
        };
        let line = |key: &String| {
            let shown = [StudyResponse::FormErrorMaxUm, StudyResponse::JobTimeS];
            let own = || effects.iter().filter(|effect| effect.key == *key && shown.contains(&effect.response));
            let levels = &own().next()?.levels;
            let (first, last) = (levels.first()?, levels.last()?);
            let parts: Vec<String> = own().filter_map(|effect| part(&effect)).collect();
            (levels.len() > 1).then(|| format!("{key} {} to {}: {}", first.label, last.label, parts.join(", ")))
        };
        self.study.factors.iter().filter_map(|factor| line(&factor.key)).collect()
    }

    /// The results as one JSON object.
    #[must_use]
    pub fn json(&self, folder: &StudyFolder) -> Value {
        let row = |row: &StudyRow| {
            let responses: Map<String, Value> =
                self.study.responses.iter().map(|r| (r.name().to_owned(), json!(row.outcome.response(*r)))).collect();
            let set: Vec<String> = row.case.settings.iter().map(set_text).collect();
            json!({ "case": row.case.number, "hash": row.case.hash, "set": set, "responses": responses })
        };
        let best = self.best();
        let failure = |failure: &super::FailureReason| {
            json!({
                "status": failure.status.name(), "reason": failure.reason, "first_case": failure.first_case,
                "count": failure.count,
            })
        };
        json!({
            "study": self.study.name,
            "verdict": if best.is_some() { "good" } else { "not good" },
            "cases": self.case_count,
            "finished": self.rows.len(),
            "done": self.count(CaseStatus::Done),
            "feasible": self.rows.iter().filter(|row| row.is_feasible).count(),
            "best": best.as_ref().map(|best| row(&self.rows[best.row])),
            "command": best.as_ref().map(|best| self.command(best, folder)),
            "front": self.front().into_iter().map(|index| row(&self.rows[index])).collect::<Vec<_>>(),
            "failures": self.failures().iter().map(failure).collect::<Vec<_>>(),
        })
    }
}
