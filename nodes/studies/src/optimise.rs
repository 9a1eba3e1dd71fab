// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Search for the best feasible point of a study: the cases of the design first, then COBYLA from the best of them.
//!
//! A search moves the factors with ranges; lists keep the values of its start. COBYLA (Powell, 1994) needs no derivatives and keeps
//! each limit as a constraint of its own. Each search depends on its own results only, so that the cases are the same with any number of
//! workers, and a search that was interrupted repeats its way with the cases of the log.

use super::StudyError;
use super::case_log::CaseLog;
use super::case_run::{CaseOutcome, CaseStatus, run_case};
use super::cases::{StudyCase, cases, controlled, point_cases, share_of, value_at};
use super::engine::{CaseOutcomes, EngineSettings, on_workers, run_cases};
use camwright_files::study_file::{FactorValues, Study};
use camwright_files::yaml::YamlValue;
use cobyla::{RhoBeg, StopTols, minimize};
use std::cell::RefCell;
use std::cmp::Ordering;
use std::collections::{HashMap, HashSet};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Maximum number of searches.
const SEARCHES: usize = 4;

/// Size of the first steps of a search (share of the range).
const FIRST_STEP: f64 = 0.2;

/// Size of the last steps of a search (share of the range).
const LAST_STEP: f64 = 1e-3;

/// Violation of a case that makes no part.
const NO_PART: f64 = 1.0;

/// Values of the controlled factors of a point.
type Point = Vec<YamlValue>;

/// Runs the design and searches from its best points; at most `max_cases` cases, or those of the design if they are more. Returns the cases
/// of the design, then those of the searches.
///
/// # Errors
/// The log cannot be written, or no worker starts.
pub fn optimise(
    study: &Study,
    max_cases: u32,
    (log, outcomes): (&CaseLog, &mut CaseOutcomes),
    settings: &EngineSettings<'_>,
) -> Result<Vec<StudyCase>, StudyError> {
    let mut all = cases(study);
    run_cases(study, &all, (log, outcomes), settings)?;
    let starts = starts(study, &all, outcomes);
    let left = (max_cases as usize).saturating_sub(all.len()) / study.replicates as usize;
    let evaluations = left / starts.len().max(1);
    if (settings.is_stopped)() || evaluations == 0 || !has_ranges(study) {
        return Ok(all);
    }
    let runner = Runner::new(study, log, outcomes, settings);
    let found: Mutex<Vec<(usize, Vec<Point>)>> = Mutex::default();
    let indexed: Vec<(usize, Point)> = starts.into_iter().enumerate().collect();
    on_workers(settings.workers, &indexed, |(index, start)| {
        let visited = search(&runner, start, evaluations);
        found.lock().unwrap_or_else(PoisonError::into_inner).push((*index, visited));
        runner.failure()
    })?;
    let mut found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    found.sort_by_key(|(index, _)| *index);
    outcomes.extend(runner.finished());
    let mut point = all.last().map_or(0, |case| case.point);
    let mut known: HashSet<String> = all.iter().map(|case| case.hash.clone()).collect();
    for values in found.into_iter().flat_map(|(_, visited)| visited) {
        let new = point_cases(study, &values, point + 1);
        if new.iter().all(|case| outcomes.contains_key(&case.hash)) && known.insert(new[0].hash.clone()) {
            point += 1;
            all.extend(new);
        }
    }
    Ok(all)
}

fn has_ranges(study: &Study) -> bool {
    controlled(study).any(|factor| matches!(factor.values, FactorValues::Range { .. }))
}

/// Points from which the searches start, the best first: one for each combination of list values, then others.
fn starts(study: &Study, cases: &[StudyCase], outcomes: &CaseOutcomes) -> Vec<Point> {
    let replicates = study.replicates as usize;
    let mut ranked: Vec<(Point, Judged)> = cases
        .chunks(replicates)
        .filter_map(|point| {
            let outcomes = point.iter().map(|case| outcomes.get(&case.hash)).collect::<Option<Vec<_>>>()?;
            Some((point_values(study, &point[0]), Judged::new(study, &outcomes)))
        })
        .collect();
    ranked.sort_by(|(_, a), (_, b)| a.rank(b));
    let mut combinations = HashSet::new();
    let lists = |point: &Point| {
        let of_list =
            controlled(study).zip(point).filter(|(factor, _)| matches!(factor.values, FactorValues::Levels(_)));
        of_list.map(|(_, value)| value.to_flow()).collect::<Vec<_>>()
    };
    let (first, others): (Vec<_>, Vec<_>) =
        ranked.into_iter().partition(|(point, _)| combinations.insert(lists(point)));
    first.into_iter().chain(others).take(SEARCHES).map(|(point, _)| point).collect()
}

/// Values of the controlled factors of a case.
fn point_values(study: &Study, case: &StudyCase) -> Point {
    let settings = study.factors.iter().zip(&case.settings);
    settings.filter(|(factor, _)| !factor.values.is_random()).map(|(_, (_, value))| value.clone()).collect()
}

/// A point by its replicates.
#[derive(Debug, Clone)]
struct Judged {
    /// Mean of the minimised response; none where a replicate has none.
    value: Option<f64>,
    /// Excess over each limit as a share of the limit, the largest of the replicates; positive: beyond it.
    excess: Vec<f64>,
    makes_part: bool,
}

impl Judged {
    fn new(study: &Study, outcomes: &[&CaseOutcome]) -> Self {
        if outcomes.iter().any(|outcome| outcome.status != CaseStatus::Done) {
            return Self::no_part(study);
        }
        let values: Option<Vec<f64>> = outcomes.iter().map(|outcome| outcome.response(study.minimise)).collect();
        let excess = study.limits.iter().map(|(response, max)| {
            let scale = if *max > 0.0 { *max } else { 1.0 };
            // A response that the job does not have keeps its limit.
            let of = |outcome: &&CaseOutcome| outcome.response(*response).map_or(-1.0, |value| (value - max) / scale);
            outcomes.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
        });
        Self {
            value: values.map(|values| values.iter().sum::<f64>() / values.len() as f64),
            excess: excess.collect(),
            makes_part: true,
        }
    }

    fn no_part(study: &Study) -> Self {
        Self { value: None, excess: vec![NO_PART; study.limits.len()], makes_part: false }
    }

    fn violation(&self) -> f64 {
        let beyond = self.excess.iter().map(|excess| excess.max(0.0)).sum::<f64>();
        if self.makes_part { beyond } else { f64::INFINITY }
    }

    /// The better one is less.
    fn rank(&self, other: &Self) -> Ordering {
        let value = |judged: &Self| judged.value.unwrap_or(f64::INFINITY);
        self.violation().total_cmp(&other.violation()).then(value(self).total_cmp(&value(other)))
    }
}

/// Runs cases for several searches; each case once.
struct Runner<'a> {
    study: &'a Study,
    log: &'a CaseLog,
    settings: &'a EngineSettings<'a>,
    known: &'a CaseOutcomes,
    /// Cases that the searches asked for, none where a stop came first.
    new: Mutex<HashMap<String, Arc<OnceLock<Option<CaseOutcome>>>>>,
    failure: Mutex<Option<StudyError>>,
    done: AtomicUsize,
}

impl<'a> Runner<'a> {
    fn new(study: &'a Study, log: &'a CaseLog, known: &'a CaseOutcomes, settings: &'a EngineSettings<'a>) -> Self {
        Self {
            study,
            log,
            settings,
            known,
            new: Mutex::default(),
            failure: Mutex::default(),
            done: AtomicUsize::new(0),
        }
    }

    /// Outcome of a case; none after a stop.
    fn outcome(&self, case: &StudyCase) -> Option<CaseOutcome> {
        if let Some(known) = self.known.get(&case.hash) {
            return Some(known.clone());
        }
        let slot =
            Arc::clone(self.new.lock().unwrap_or_else(PoisonError::into_inner).entry(case.hash.clone()).or_default());
        slot.get_or_init(|| {
            let has_failed = self.failure.lock().unwrap_or_else(PoisonError::into_inner).is_some();
            if has_failed || (self.settings.is_stopped)() {
                return None;
            }
            let outcome = run_case(self.study, &case.settings);
            if let Err(error) = self.log.append(&case.hash, &outcome) {
                self.failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                return None;
            }
            (self.settings.on_done)(self.done.fetch_add(1, Relaxed) + 1);
            Some(outcome)
        })
        .clone()
    }

    fn failure(&self) -> Result<(), StudyError> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).take().map_or(Ok(()), Err)
    }

    /// New outcomes by hash.
    fn finished(self) -> Vec<(String, CaseOutcome)> {
        let new = self.new.into_inner().unwrap_or_else(PoisonError::into_inner);
        new.into_iter().filter_map(|(hash, slot)| Some((hash, slot.get()?.clone()?))).collect()
    }
}

/// Search from a point; returns the points that it visited, in order.
fn search(runner: &Runner<'_>, start: &Point, evaluations: usize) -> Vec<Point> {
    let study = runner.study;
    let moved: Vec<usize> = controlled(study)
        .enumerate()
        .filter(|(_, factor)| matches!(factor.values, FactorValues::Range { .. }))
        .map(|(index, _)| index)
        .collect();
    let factors: Vec<_> = controlled(study).collect();
    let point_at = |shares: &[f64]| {
        let mut point = start.clone();
        for (index, share) in moved.iter().zip(shares) {
            point[*index] = value_at(factors[*index], share.clamp(0.0, 1.0));
        }
        point
    };
    let visited: RefCell<Vec<(Point, Judged)>> = RefCell::default();
    let first_value = RefCell::new(None);
    let judge = |shares: &[f64]| -> Judged {
        let point = point_at(shares);
        if let Some((_, judged)) = visited.borrow().iter().rev().find(|(known, _)| *known == point) {
            return judged.clone();
        }
        let outcomes =
            point_cases(study, &point, 1).iter().map(|case| runner.outcome(case)).collect::<Option<Vec<_>>>();
        // After a stop the search ends with the same answer at every point.
        let Some(outcomes) = outcomes else { return Judged::no_part(study) };
        let judged = Judged::new(study, &outcomes.iter().collect::<Vec<_>>());
        visited.borrow_mut().push((point, judged.clone()));
        judged
    };
    let objective = |shares: &[f64], _: &mut ()| {
        let judged = judge(shares);
        let scale = *first_value.borrow_mut().get_or_insert_with(|| judged.value.map_or(1.0, f64::abs).max(1e-9));
        let worst = visited.borrow().iter().filter_map(|(_, judged)| judged.value).fold(scale, f64::max);
        judged.value.unwrap_or(worst) / scale
    };
    type Constraint<'a> = Box<dyn Fn(&[f64], &mut ()) -> f64 + 'a>;
    let makes_part = |shares: &[f64], _: &mut ()| if judge(shares).makes_part { 0.1 } else { -NO_PART };
    let mut constraints: Vec<Constraint<'_>> = vec![Box::new(makes_part)];
    for limit in 0..study.limits.len() {
        let judge = &judge;
        constraints.push(Box::new(move |shares: &[f64], _: &mut ()| {
            judge(shares).excess.get(limit).map_or(-NO_PART, |excess| -excess)
        }));
    }
    let shares: Vec<f64> =
        moved.iter().map(|index| share_of(factors[*index], &start[*index]).clamp(0.0, 1.0)).collect();
    let bounds = vec![(0.0, 1.0); shares.len()];
    let tolerance = StopTols { xtol_abs: vec![LAST_STEP; shares.len()], ..StopTols::default() };
    // The way is what counts: the best feasible point of all is taken from the results.
    let _end =
        minimize(objective, &shares, &bounds, &constraints, (), evaluations, RhoBeg::All(FIRST_STEP), Some(tolerance));
    drop(constraints);
    visited.into_inner().into_iter().map(|(point, _)| point).collect()
}
