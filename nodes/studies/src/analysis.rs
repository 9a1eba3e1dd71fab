// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Answers of a study: main effects, the front of time against error, the best feasible point, and failures by reason.

use super::case_run::CaseStatus;
use super::folder::{StudyFolder, set_text};
use super::results::{StudyResults, StudyRow, as_number};
use camwright_files::study_file::{FactorValues, StudyFactor, StudyResponse, StudySetting};
use camwright_files::yaml::YamlValue;
use std::collections::BTreeMap;

/// Maximum number of different values that are shown one by one; more are grouped.
const MAX_LEVELS: usize = 12;

/// Number of groups of a factor with many values.
const GROUPS: usize = 8;

/// Response at one value, or one group of values, of a factor.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectLevel {
    /// The value, or the middle of the group.
    pub label: String,
    /// The same as a number, if the factor has numbers.
    pub at: Option<f64>,
    pub mean: f64,
    pub min: f64,
    pub max: f64,
    pub count: usize,
}

/// Effect of a factor on a response: means over all cases with the same value of the factor.
#[derive(Debug, Clone, PartialEq)]
pub struct FactorEffect {
    pub key: String,
    pub response: StudyResponse,
    pub levels: Vec<EffectLevel>,
}

impl FactorEffect {
    /// Largest minus smallest mean.
    #[must_use]
    pub fn span(&self) -> f64 {
        let means = || self.levels.iter().map(|level| level.mean);
        means().fold(f64::NEG_INFINITY, f64::max) - means().fold(f64::INFINITY, f64::min)
    }
}

/// The feasible point of the design with the smallest mean of the minimised response.
#[derive(Debug, Clone, PartialEq)]
pub struct BestPoint {
    /// Index of the row of its first replicate.
    pub row: usize,
    /// Mean over its replicates.
    pub value: f64,
    pub replicates: usize,
    /// Settings of the design; random values and seeds are not among them.
    pub settings: Vec<StudySetting>,
}

/// Cases that failed for the same reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FailureReason {
    pub status: CaseStatus,
    /// Reason of the first of them.
    pub reason: String,
    /// Number of the first of them.
    pub first_case: u32,
    pub count: usize,
}

impl StudyResults<'_> {
    fn done(&self) -> impl Iterator<Item = &StudyRow> {
        self.rows.iter().filter(|row| row.outcome.status == CaseStatus::Done)
    }

    /// Effects of every factor on every response of the study, in their order.
    #[must_use]
    pub fn effects(&self) -> Vec<FactorEffect> {
        let responses = &self.study.responses;
        let factors = self.study.factors.iter().enumerate();
        factors.flat_map(|(index, factor)| responses.iter().map(move |r| self.effect(index, factor, *r))).collect()
    }

    fn effect(&self, index: usize, factor: &StudyFactor, response: StudyResponse) -> FactorEffect {
        let values: Vec<(&YamlValue, f64)> = self
            .done()
            .filter_map(|row| Some((&row.case.settings.get(index)?.1, row.outcome.response(response)?)))
            .collect();
        let mut groups: Vec<(String, Option<f64>, Vec<f64>)> = Vec::new();
        for (value, result) in &values {
            let label = match value {
                YamlValue::Text(text) => text.clone(),
                other => other.to_flow(),
            };
            match groups.iter_mut().find(|group| group.0 == label) {
                Some(group) => group.2.push(*result),
                None => groups.push((label, as_number(value), vec![*result])),
            }
            if groups.len() > MAX_LEVELS && as_number(value).is_some() {
                groups = grouped(factor, &values);
                break;
            }
        }
        groups.sort_by(|a, b| match (a.1, b.1) {
            (Some(a), Some(b)) => a.total_cmp(&b),
            _ => std::cmp::Ordering::Equal,
        });
        let level = |(label, at, results): (String, Option<f64>, Vec<f64>)| EffectLevel {
            label,
            at,
            mean: results.iter().sum::<f64>() / results.len() as f64,
            min: results.iter().copied().fold(f64::INFINITY, f64::min),
            max: results.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            count: results.len(),
        };
        FactorEffect { key: factor.key.clone(), response, levels: groups.into_iter().map(level).collect() }
    }

    /// Cases that no other one beats in both time and form error, fastest first; indices of rows.
    #[must_use]
    pub fn front(&self) -> Vec<usize> {
        let point = |row: &StudyRow| {
            let response = |response| row.outcome.response(response);
            Some((response(StudyResponse::JobTimeS)?, response(StudyResponse::FormErrorMaxUm)?))
        };
        let mut points: Vec<(usize, (f64, f64))> =
            self.rows.iter().enumerate().filter_map(|(index, row)| Some((index, point(row)?))).collect();
        points.sort_by(|(_, a), (_, b)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut smallest = f64::INFINITY;
        points.retain(|(_, (_, error))| {
            let is_better = *error < smallest;
            smallest = smallest.min(*error);
            is_better
        });
        points.into_iter().map(|(index, _)| index).collect()
    }

    /// The best feasible point, all of whose replicates are finished and feasible.
    #[must_use]
    pub fn best(&self) -> Option<BestPoint> {
        let mut points: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (index, row) in self.rows.iter().enumerate() {
            points.entry(row.case.point).or_default().push(index);
        }
        let mut best: Option<BestPoint> = None;
        for rows in points.values() {
            let is_whole = rows.len() == self.study.replicates as usize;
            let values: Option<Vec<f64>> =
                rows.iter().map(|row| self.rows[*row].outcome.response(self.study.minimise)).collect();
            let (true, Some(values)) = (is_whole && rows.iter().all(|row| self.rows[*row].is_feasible), values) else {
                continue;
            };
            let value = values.iter().sum::<f64>() / values.len() as f64;
            if best.as_ref().is_none_or(|best| value < best.value) {
                let settings = self.point_settings(&self.rows[rows[0]]);
                best = Some(BestPoint { row: rows[0], value, replicates: rows.len(), settings });
            }
        }
        best
    }

    /// Settings of a case that the design makes.
    fn point_settings(&self, row: &StudyRow) -> Vec<StudySetting> {
        let of_design = self.study.factors.iter().zip(&row.case.settings);
        of_design.filter(|(factor, _)| !factor.values.is_random()).map(|(_, setting)| setting.clone()).collect()
    }

    /// Command that runs the best point on the whole cell.
    #[must_use]
    pub fn command(&self, best: &BestPoint, folder: &StudyFolder) -> String {
        let all: Vec<&StudySetting> = self.study.base.fixed().iter().chain(&best.settings).collect();
        let has_machine = all.iter().any(|(key, _)| key.starts_with("machine."));
        let mut command = format!("camwright run {}", shell_word(&self.study.job));
        let mut set = |text: String| command += &format!(" --set {}", shell_word(&text));
        match &self.study.machine {
            _ if has_machine => set(format!("machine={}", folder.file("best_machine.yaml").display())),
            Some(machine) => set(format!("machine={machine}")),
            None => {}
        }
        for setting in all.into_iter().filter(|(key, _)| !key.starts_with("machine.")) {
            let text = set_text(setting);
            set(text.strip_prefix("job.").map_or(text.clone(), str::to_owned));
        }
        command
    }

    /// Failures by reason, the most frequent first.
    #[must_use]
    pub fn failures(&self) -> Vec<FailureReason> {
        let mut groups: BTreeMap<(CaseStatus, String), FailureReason> = BTreeMap::new();
        for row in self.rows.iter().filter(|row| row.outcome.status != CaseStatus::Done) {
            let outcome = &row.outcome;
            let reason = || FailureReason {
                status: outcome.status,
                reason: outcome.reason.clone(),
                first_case: row.case.number,
                count: 0,
            };
            groups.entry((outcome.status, kind_of(&outcome.reason))).or_insert_with(reason).count += 1;
        }
        let mut failures: Vec<FailureReason> = groups.into_values().collect();
        failures.sort_by_key(|failure| (std::cmp::Reverse(failure.count), failure.first_case));
        failures
    }
}

/// Reason without its numbers, which differ from case to case.
fn kind_of(reason: &str) -> String {
    let mut kind = String::new();
    for c in reason.chars() {
        let c = if c.is_ascii_digit() { '0' } else { c };
        let is_number = |c: char| c == '0' || c == '.';
        if !(is_number(c) && kind.ends_with(is_number)) {
            kind.push(c);
        }
    }
    kind
}

/// Results in groups of equal width of the factor; of equal ratio for a logarithmic range.
fn grouped(factor: &StudyFactor, values: &[(&YamlValue, f64)]) -> Vec<(String, Option<f64>, Vec<f64>)> {
    let is_log = matches!(factor.values, FactorValues::Range { is_log: true, .. });
    let scaled = |value: f64| if is_log { value.ln() } else { value };
    let points: Vec<(f64, f64)> =
        values.iter().filter_map(|(value, result)| Some((scaled(as_number(value)?), *result))).collect();
    let low = points.iter().map(|point| point.0).fold(f64::INFINITY, f64::min);
    let high = points.iter().map(|point| point.0).fold(f64::NEG_INFINITY, f64::max);
    let width = ((high - low) / GROUPS as f64).max(f64::MIN_POSITIVE);
    let mut groups: Vec<Vec<f64>> = vec![Vec::new(); GROUPS];
    for (value, result) in points {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below the number of groups")]
        let group = ((value - low) / width) as usize;
        groups[group.min(GROUPS - 1)].push(result);
    }
    let middle = |group: usize| {
        let value = low + width * (group as f64 + 0.5);
        if is_log { value.exp() } else { value }
    };
    let filled = groups.into_iter().enumerate().filter(|(_, results)| !results.is_empty());
    filled.map(|(group, results)| (short(middle(group)), Some(middle(group)), results)).collect()
}

/// A number with four digits.
pub(crate) fn short(value: f64) -> String {
    format!("{value:.3e}").parse::<f64>().map_or_else(|_| value.to_string(), |value| value.to_string())
}

/// A word of a shell command, in quotes where it needs them.
fn shell_word(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-./=:,+@%".contains(c);
    if word.chars().all(is_plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case_run::CaseOutcome;
    use crate::cases::cases;
    use crate::engine::CaseOutcomes;
    use camwright_files::locate::Located;
    use camwright_files::study_file::{self, Study};

    fn study() -> Study {
        let text = "schema: camwright/study/1\nname: small\njob: eccentric\nfactors:\n  work_speed_rpm: [30.0, 60.0]\n  infeed.spark_out_turns: [1, 2]\n  machine.x_axis.drive.kv_1_s: [150.0]\ndesign: {kind: grid}\n";
        study_file::read(&Located::new("study.yaml", text), &[]).unwrap_or_else(|errors| panic!("{errors:?}"))
    }

    fn outcome(status: CaseStatus, error_um: f64, time_s: f64, reason: &str) -> CaseOutcome {
        let mut responses = [None; StudyResponse::ALL.len()];
        responses[StudyResponse::FormErrorMaxUm.index()] = Some(error_um).filter(|_| status == CaseStatus::Done);
        responses[StudyResponse::JobTimeS.index()] = Some(time_s).filter(|_| status == CaseStatus::Done);
        CaseOutcome { status, reason: reason.into(), alarm: None, worst_lobe: None, responses }
    }

    fn with_results(study: &Study, check: impl Fn(&StudyResults<'_>)) {
        let cases = cases(study);
        let all = [
            outcome(CaseStatus::Done, 2.0, 80.0, ""),
            outcome(CaseStatus::Done, 3.0, 90.0, ""),
            outcome(CaseStatus::Done, 6.0, 40.0, ""),
            outcome(CaseStatus::Done, 4.0, 50.0, ""),
        ];
        let outcomes: CaseOutcomes = cases.iter().map(|case| case.hash.clone()).zip(all).collect();
        check(&StudyResults::new(study, &cases, &outcomes));
    }

    #[test]
    fn the_best_point_is_the_fastest_that_keeps_the_limits() {
        with_results(&study(), |results| {
            let best = results.best().expect("three are feasible");
            assert_eq!((best.row, best.value), (3, 50.0));
            let folder = StudyFolder::create(&std::env::temp_dir()).expect("a folder");
            let command = results.command(&best, &folder);
            let machine = folder.file("best_machine.yaml").display().to_string();
            let job = shell_word(&results.study.job);
            assert_eq!(
                command,
                format!(
                    "camwright run {job} --set machine={machine} --set work_speed_rpm=60.0 --set infeed.spark_out_turns=2"
                )
            );
        });
    }

    #[test]
    fn the_front_holds_cases_that_no_other_beats() {
        with_results(&study(), |results| assert_eq!(results.front(), [2, 3, 0]));
    }

    #[test]
    fn effects_are_means_over_the_other_factors() {
        with_results(&study(), |results| {
            let effects = results.effects();
            let effect = |key: &str| {
                let is_this = |effect: &&FactorEffect| effect.key == key && effect.response == StudyResponse::JobTimeS;
                effects.iter().find(is_this).expect("an effect")
            };
            let means =
                |key| effect(key).levels.iter().map(|level| (level.label.clone(), level.mean)).collect::<Vec<_>>();
            assert_eq!(means("work_speed_rpm"), [("30.0".to_owned(), 85.0), ("60.0".to_owned(), 45.0)]);
            assert_eq!(means("infeed.spark_out_turns"), [("1".to_owned(), 60.0), ("2".to_owned(), 70.0)]);
            assert!((effect("work_speed_rpm").span() - 40.0).abs() < 1e-12);
        });
    }

    #[test]
    fn failures_with_other_numbers_are_one_reason() {
        let study = study();
        let cases = cases(&study);
        let all = ["lobe A: 3.25 mm of 2", "lobe A: 17 mm of 2", "another reason"]
            .map(|reason| outcome(CaseStatus::Refused, 0.0, 0.0, reason));
        let outcomes: CaseOutcomes = cases.iter().map(|case| case.hash.clone()).zip(all).collect();
        let results = StudyResults::new(&study, &cases, &outcomes);
        let failures = results.failures();
        assert_eq!(failures.iter().map(|failure| failure.count).collect::<Vec<_>>(), [2, 1]);
        assert_eq!((results.best(), results.is_complete()), (None, false));
    }
}
