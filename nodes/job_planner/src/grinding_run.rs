// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A job that grinds, on a thread of its own: pages, blanks, execution, measuring.

use super::execution::{Execution, JobFailure, PlanShare};
use super::plan_progress::last_cuts;
use super::{identify, lock};
use camwright::motion::speed_plan::SpeedPlan;
use camwright::planner::PlannedLobe;
use camwright_files::stiffness_file::StoredContact;
use camwright_msgs::camwright_msgs::action::RunJobResult;
use camwright_msgs::camwright_msgs::msg::{LobeResult, LobeShape, PartLobe};
use camwright_planning::{self as planning, MeasuredContacts, PreparedJob, hash_of, lobe_count};
use std::time::Duration;

/// Maximum delay of the finished part: one page of outline per lobe.
const MEASURING: Duration = Duration::from_secs(20);
/// Maximum delay of the part after a job that was cancelled or stopped. A machine need not report it.
const MEASURING_UNFINISHED: Duration = Duration::from_secs(5);
/// Start of the message of a dry run.
const DRY_RUN: &str = "dry run";

/// One run of a job that grinds.
pub(super) struct GrindingRun {
    pub(super) execution: Execution,
    pub(super) prepared: PreparedJob,
    /// Stiffness that was measured and is kept, in the order of machining.
    pub(super) stiffness: Vec<StoredContact>,
    /// Time saved by skipped turns after the stock measurement.
    pub(super) saved: Option<String>,
    /// Index of the last cut of each lobe in the plan that finishes the part, once that is executed.
    last_cuts: Vec<Option<usize>>,
    /// Turns of spark-out that the last plan omitted, by lobe.
    turns_left_out: Vec<u32>,
    /// Measured values of each ground crank pin, wide lobe and lobe with taper or crown, and finishing turns of journals.
    measured: Vec<String>,
    /// Taper and crown of each ground lobe that has them.
    shapes: Vec<LobeShape>,
}

impl GrindingRun {
    pub(super) fn new(execution: Execution, prepared: PreparedJob) -> Self {
        let (stiffness, last_cuts, turns_left_out) = Default::default();
        let (measured, shapes) = Default::default();
        Self { execution, prepared, stiffness, saved: None, last_cuts, turns_left_out, measured, shapes }
    }

    /// The whole run; the course is idle again when it returns.
    pub(super) fn run(mut self) {
        for dress in planning::dresses(&self.prepared) {
            self.execution.shared.node.logger().info(&dress.to_string());
        }
        let mut result = RunJobResult { plan_hash: self.prepared.plan_hash().to_owned(), ..RunJobResult::default() };
        let outcome = self.proceed(&mut result);
        if outcome.is_err() {
            result.lobes = self.measure_finished(&result);
        }
        let journals = self.stiffness.iter().map(identify::message).collect();
        self.execution.end(outcome, result, journals);
    }

    /// One of its plans, before which so much was done and which takes so long itself (s, as predicted).
    pub(super) fn execute(
        &mut self,
        result: &mut RunJobResult,
        plan_hash: &str,
        done_s: f64,
        own_s: f64,
    ) -> Result<(), JobFailure> {
        let share = PlanShare { done_s, own_s, whole_s: self.prepared.duration_s() };
        let (status, ended) = self.execution.execute(plan_hash, share)?;
        self.turns_left_out.clone_from(&ended.turns_left_out);
        let noted = self.execution.note(result, (status, ended));
        result.duration_with_indexing = result.duration + self.prepared.planned.saved_by_not_indexing_s();
        noted
    }

    fn proceed(&mut self, result: &mut RunJobResult) -> Result<(), JobFailure> {
        // A job that begins in its middle goes on with the part as it is, and a dry run leaves it.
        let keeps = self.prepared.job.starts_in_the_middle
            || (self.prepared.dry_run_mm().is_some() && self.execution.shared.parts.is_there());
        if !keeps {
            self.load_blanks()?;
        }
        let measures = self.prepared.measuring.is_some();
        if measures {
            self.measure_stock(result)?;
        }
        self.execution.publish(&self.prepared.pages)?;
        if !measures {
            self.execution.arm_faults()?;
        }
        self.listen();
        let done_s = self.prepared.measuring_s();
        let own_s = self.prepared.planned.plan.duration_s;
        let plan_hash = hash_of(&self.prepared.pages).to_owned();
        self.last_cuts = last_cuts(&self.prepared.planned.plan);
        self.execute(result, &plan_hash, done_s, own_s)?;
        let turns_left_out = self.turns_left_out.clone();
        let mut correction = None;
        let mut measured = MeasuredContacts::default();
        let is_dry = self.prepared.dry_run_mm().is_some();
        if self.prepared.expected_correction.is_some() {
            let second = self.correct()?;
            self.execution.publish(&second.pages)?;
            lock(&self.execution.times).next_half();
            self.last_cuts = last_cuts(&second.planned.plan);
            self.execute(result, second.plan_hash(), done_s + own_s, second.planned.plan.duration_s)?;
            correction = Some(second);
        } else if self.prepared.job.spec.identification.is_some() && !is_dry {
            measured = self.identify()?;
        }
        if is_dry {
            result.message = self.dry_run_message(result);
            return Ok(());
        }
        result.lobes = self.measure(result, turns_left_out)?;
        result.shapes.clone_from(&self.shapes);
        measured.add_to(&mut result.lobes);
        if let Some(correction) = &correction {
            correction.add_to(&mut result.lobes);
            self.measured.extend(correction.finishing_lines(&self.prepared));
        }
        let times = planning::compare_times(&self.prepared, &result.lobes, result.duration);
        let lines: Vec<String> = times.iter().map(ToString::to_string).collect();
        self.execution.shared.node.logger().info(&lines.join("; "));
        result.message = self.message(result);
        Ok(())
    }

    fn dry_run_message(&self, result: &RunJobResult) -> String {
        format!(
            "{} in {:.2} s, predicted {:.2} s, with the wheel {} mm farther out: nothing was cut, and nothing is judged",
            DRY_RUN,
            result.duration,
            self.prepared.duration_s(),
            self.prepared.dry_run_mm().unwrap_or_default()
        )
    }

    fn message(&self, result: &RunJobResult) -> String {
        let (lobes, predicted_s) = (lobe_count(result.lobes.len()), self.prepared.duration_s());
        let late_s = result.duration - predicted_s;
        let mut took = format!("{lobes} in {:.2} s, predicted {predicted_s:.2} s ({late_s:+.2} s)", result.duration);
        if let Some(saved_s) = self.prepared.planned.saved_by_turning_on_s() {
            let stops_s = result.duration + saved_s;
            took += &format!("; with C stopping between lobes {stops_s:.2} s: {saved_s:.2} s saved");
        }
        if let Some(saved) = &self.saved {
            took += &format!("; {saved}");
        }
        for line in &self.measured {
            took += &format!("; {line}");
        }
        if self.prepared.job.spec.rotary_indexing {
            return format!("{took}, with rotary indexing before each");
        }
        format!(
            "{took}; with rotary indexing before each {:.2} s: {:.2} s saved",
            result.duration_with_indexing,
            result.duration_with_indexing - result.duration
        )
    }

    /// Puts the raw part between the centres.
    fn load_blanks(&self) -> Result<(), JobFailure> {
        let cancelled = || self.execution.is_cancelled();
        Ok(self.execution.shared.put_in(&self.prepared, &cancelled)?)
    }

    /// The form of every lobe of the finished part.
    fn measure(&mut self, ended: &RunJobResult, turns_left_out: Vec<u32>) -> Result<Vec<LobeResult>, JobFailure> {
        self.turns_left_out = turns_left_out;
        let lobes: Vec<(usize, &PlannedLobe)> = self.prepared.finished_lobes().collect();
        let sections: Vec<Vec<String>> = lobes.iter().map(|(_, lobe)| section_names(lobe)).collect();
        let names: Vec<&str> = sections.iter().flatten().map(String::as_str).collect();
        let parts =
            self.execution.shared.parts.wait_finished(&names, ended.first_tick, MEASURING).map_err(|missing| {
                JobFailure::Failed(format!(
                    "the job was executed, but the machine did not report the finished lobe {missing}"
                ))
            })?;
        let by_lobe = split_parts(&parts, &sections);
        let own: Vec<PartLobe> = by_lobe.iter().filter_map(|parts| parts.first().cloned()).collect();
        self.learn(&own);
        let pins = lobes.iter().zip(&own).filter_map(|((_, lobe), part)| planning::pin_line(&lobe.design, part));
        let wide = planning::wide_lobe_forms(&self.prepared, &parts).into_iter().map(|form| form.to_string());
        let shapes =
            lobes.iter().zip(&by_lobe).filter_map(|((_, lobe), parts)| planning::lobe_shape(&lobe.design, parts));
        self.shapes = shapes.collect();
        let shapes = self.shapes.iter().map(planning::shape_line);
        self.measured = pins.chain(wide).chain(shapes).collect();
        lobes.iter().zip(by_lobe).map(|((index, _), parts)| self.lobe_result(*index, parts, ended)).collect()
    }

    /// Result of a lobe from the outlines of its sections.
    fn lobe_result(&self, index: usize, parts: &[PartLobe], ended: &RunJobResult) -> Result<LobeResult, JobFailure> {
        let lobe = &self.prepared.planned.lobes[index];
        let result = planning::sections_result(&lobe.design, parts);
        let mut result = result.map_err(|error| JobFailure::Failed(error.to_string()))?;
        if let Some(own) = parts.first() {
            self.execution.shared.lobe_forms.ground(&self.prepared, index, own);
        }
        result.start_angle = lobe.start_rad;
        let left_out = self.turns_left_out.get(index).copied().unwrap_or_default();
        let visits = self.prepared.job.spec.visits_of(index);
        let lobes = &self.prepared.planned.lobes;
        let passes = visits.iter().filter_map(|visit| lobes.get(*visit)).flat_map(|lobe| &lobe.passes);
        let planned = passes.map(SpeedPlan::turns).sum::<u32>();
        result.turns = f64::from(planned.saturating_sub(left_out));
        let predicted_s = planning::lobe_times_s(&self.prepared);
        let times = lock(&self.execution.times);
        let of_visit = |visit: &usize| match times.first_tick(*visit, ended.last_tick) {
            Some(ticks) => self.execution.seconds(ticks),
            // Feedback may be lost on its way; then the plan's time is the best there is.
            None => predicted_s.get(*visit).copied().unwrap_or_default(),
        };
        result.duration = visits.iter().map(of_visit).sum();
        Ok(result)
    }

    /// Results of the lobes that were finished before the job was cancelled or stopped, from the part as it is.
    fn measure_finished(&self, ended: &RunJobResult) -> Vec<LobeResult> {
        // After an alarm the rest of the stream is executed beside the path.
        let until_tick = match ended.alarm {
            0 => u64::MAX,
            number => self.execution.shared.alarm(number).map_or(ended.last_tick, |alarm| alarm.tick),
        };
        let (mut finished, last_tick) = lock(&self.execution.progress).finished(&self.last_cuts, until_tick);
        finished.retain(|index| self.prepared.finished_lobes().any(|(other, _)| other == *index));
        if finished.is_empty() {
            return Vec::new();
        }
        let logger = self.execution.shared.node.logger();
        let lobes = &self.prepared.planned.lobes;
        let sections: Vec<Vec<String>> = finished.iter().map(|index| section_names(&lobes[*index])).collect();
        let names: Vec<&str> = sections.iter().flatten().map(String::as_str).collect();
        let since_tick = ended.last_tick.max(last_tick);
        let measured = match self.execution.shared.parts.wait_reported(&names, since_tick, MEASURING_UNFINISHED) {
            Ok(parts) => parts,
            Err(missing) => {
                logger.warn(&format!("lobe {missing} is finished, but the machine did not report its outline"));
                return Vec::new();
            }
        };
        let by_lobe = split_parts(&measured, &sections);
        let results = finished.iter().zip(by_lobe).map(|(index, parts)| self.lobe_result(*index, parts, ended));
        let judged = |result: Result<LobeResult, JobFailure>| match result {
            Ok(result) => Some(result),
            Err(JobFailure::Failed(reason) | JobFailure::Cancelled(reason)) => {
                logger.warn(&format!("a finished lobe cannot be judged: {reason}"));
                None
            }
        };
        results.filter_map(judged).collect()
    }
}

impl GrindingRun {
    /// Learns from a finished part if the job says so. A failure to store the result is reported and does not change the verdict. A
    /// part that was started twice is not used.
    fn learn(&self, parts: &[PartLobe]) {
        if self.prepared.job.spec.compensation.is_none() || self.prepared.job.starts_in_the_middle {
            return;
        }
        let logger = self.execution.shared.node.logger();
        match self.execution.shared.learned.learn(&self.prepared, parts) {
            Ok(lines) => lines.iter().for_each(|lines| logger.info(lines)),
            Err(error) => logger.error(&format!("nothing was learned from the part: {error}")),
        }
    }
}

/// Names of the sections that are finished with a lobe, its own first.
fn section_names(lobe: &PlannedLobe) -> Vec<String> {
    lobe.design.sections().into_iter().map(|section| section.name).collect()
}

/// Outlines of consecutive sections, by lobe.
fn split_parts<'a>(mut parts: &'a [PartLobe], sections: &[Vec<String>]) -> Vec<&'a [PartLobe]> {
    let split = |names: &Vec<String>| {
        let (own, rest) = parts.split_at(names.len().min(parts.len()));
        parts = rest;
        own
    };
    sections.iter().map(split).collect()
}
