//! One case: planned, simulated and measured without ROS.

use camwright::cam::form::Form;
use camwright::math::units::um_from_mm;
use camwright::planner::PlannedLobe;
use camwright::simulation::closed_loop::Simulated;
use camwright_files::ConfigError;
use camwright_files::convert::um_from_m;
use camwright_files::study_file::{Study, StudyResponse, StudySetting};
use camwright_planning::{self as planning, AnyPrepared, PreparedJob, PreparedTurning, SimulationFailed};
use serde::{Deserialize, Serialize};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// End of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CaseStatus {
    /// A part was made and measured.
    Done,
    /// The planner refused the job.
    Refused,
    /// The machine stopped with an alarm.
    Alarm,
    /// Neither: a defect of the program, or a part that cannot be measured.
    Failed,
}

impl CaseStatus {
    pub const ALL: [Self; 4] = [Self::Done, Self::Refused, Self::Alarm, Self::Failed];

    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Refused => "refused",
            Self::Alarm => "alarm",
            Self::Failed => "failed",
        }
    }
}

/// Results of a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CaseOutcome {
    pub status: CaseStatus,
    /// Why there is no part; empty if there is one.
    pub reason: String,
    /// Number of the alarm that stopped the machine.
    pub alarm: Option<u16>,
    /// Lobe with the largest form error.
    pub worst_lobe: Option<String>,
    /// Results in the order of [`StudyResponse::ALL`]; none where the job has no such result.
    pub responses: [Option<f64>; StudyResponse::ALL.len()],
}

impl CaseOutcome {
    fn failed(status: CaseStatus, reason: impl Into<String>, alarm: Option<u16>) -> Self {
        Self { status, reason: reason.into(), alarm, worst_lobe: None, responses: [None; StudyResponse::ALL.len()] }
    }

    fn stopped(failed: &SimulationFailed) -> Self {
        let status = if failed.alarm.is_some() { CaseStatus::Alarm } else { CaseStatus::Failed };
        Self::failed(status, failed.reason.clone(), failed.alarm)
    }

    fn refused(error: &ConfigError) -> Self {
        Self::failed(CaseStatus::Refused, error.to_string(), None)
    }

    #[must_use]
    pub const fn response(&self, response: StudyResponse) -> Option<f64> {
        self.responses[response.index()]
    }

    fn set(&mut self, response: StudyResponse, value: Option<f64>) {
        self.responses[response.index()] = value.filter(|value| value.is_finite());
    }
}

/// Plans and simulates the job of a study with these settings. Whatever fails is part of the result.
#[must_use]
pub fn run_case(study: &Study, settings: &[StudySetting]) -> CaseOutcome {
    guarded(|| {
        let job = study.base.job_with(settings).map_err(|mut errors| errors.swap_remove(0));
        match job.and_then(|job| planning::plan_any(job, None)) {
            Ok(AnyPrepared::Ground(prepared)) => ground(&prepared).unwrap_or_else(|failed| *failed),
            Ok(AnyPrepared::Turned(prepared)) => turned(&prepared).unwrap_or_else(|failed| *failed),
            Err(error) => CaseOutcome::refused(&error),
        }
    })
}

/// Outcome of a case, also if it panics: a defect in one case must not end the others.
fn guarded(run: impl FnOnce() -> CaseOutcome) -> CaseOutcome {
    catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("a thread panicked");
        CaseOutcome::failed(CaseStatus::Failed, format!("defect of the program: {text}"), None)
    })
}

fn time_s(simulated: &Simulated, cycle_time_s: f64) -> f64 {
    (simulated.last_tick + 1 - simulated.first_tick) as f64 * cycle_time_s
}

fn largest(values: impl Iterator<Item = f64>) -> Option<f64> {
    values.max_by(f64::total_cmp)
}

fn ground(prepared: &PreparedJob) -> Result<CaseOutcome, Box<CaseOutcome>> {
    let mut warnings = 0_usize;
    let count = |report: &camwright::simulation::tick_report::TickReport| report.raised.iter().count();
    let simulated = planning::simulate_outlines_on(prepared, &prepared.machine, |_, report| warnings += count(report));
    let (simulated, results, outlines_mm) = simulated.map_err(|failed| Box::new(CaseOutcome::stopped(&failed)))?;
    let mut waviness_mm: Option<f64> = None;
    for (lobe, radii_mm) in prepared.planned.lobes.iter().zip(&outlines_mm) {
        let phase_rad = lobe.design.phase_on_rad(prepared.job.spec.raw_part.clamped_at_rad);
        let form = Form::measure(radii_mm, &lobe.design.contour, phase_rad)
            .map_err(|error| Box::new(CaseOutcome::failed(CaseStatus::Failed, error.to_string(), None)))?;
        waviness_mm = largest(waviness_mm.into_iter().chain([form.waviness_mm()]));
    }
    let worst = results.iter().max_by(|a, b| a.form_error_max.abs().total_cmp(&b.form_error_max.abs()));
    let has_length = |lobe: &&PlannedLobe| lobe.design.contour.follower().lift_is_length();
    let has_lift = prepared.planned.lobes.iter().any(|lobe| has_length(&lobe));
    let has_process = prepared.machine.process.is_some();
    let mut outcome = CaseOutcome::failed(CaseStatus::Done, "", None);
    outcome.worst_lobe = worst.map(|lobe| lobe.name.clone());
    outcome.set(StudyResponse::FormErrorMaxUm, worst.map(|lobe| um_from_m(lobe.form_error_max.abs())));
    let lift = largest(results.iter().map(|lobe| um_from_m(lobe.lift_error)));
    outcome.set(StudyResponse::LiftErrorPvUm, lift.filter(|_| has_lift));
    outcome.set(StudyResponse::WavinessUm, waviness_mm.map(um_from_mm));
    outcome.set(StudyResponse::JobTimeS, Some(time_s(&simulated, prepared.machine.cycle_time_s())));
    let power = largest(results.iter().map(|lobe| lobe.power_max));
    outcome.set(StudyResponse::PowerMaxW, power.filter(|_| has_process));
    let burn = largest(results.iter().map(|lobe| lobe.burn_index_max));
    outcome.set(StudyResponse::BurnIndex, burn.filter(|_| has_process));
    outcome.set(StudyResponse::Alarms, Some(warnings as f64));
    Ok(outcome)
}

fn turned(prepared: &PreparedTurning) -> Result<CaseOutcome, Box<CaseOutcome>> {
    let simulated = planning::simulate_turned(prepared, &[]);
    let (simulated, part) = simulated.map_err(|failed| Box::new(CaseOutcome::stopped(&failed)))?;
    let form = planning::turned_form(prepared, &part)
        .map_err(|error| Box::new(CaseOutcome::failed(CaseStatus::Failed, error.to_string(), None)))?;
    let result = planning::turned_result(prepared, &form);
    let mut outcome = CaseOutcome::failed(CaseStatus::Done, "", None);
    outcome.set(StudyResponse::FormErrorMaxUm, Some(um_from_m(result.form_error_max.abs())));
    outcome.set(StudyResponse::JobTimeS, Some(time_s(&simulated, prepared.machine.cycle_time_s())));
    Ok(outcome)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_outcome_with_its_reason() {
        let value = std::hint::black_box(3);
        let outcome = guarded(|| panic!("the value is {value}"));
        assert_eq!(outcome, CaseOutcome::failed(CaseStatus::Failed, "defect of the program: the value is 3", None));
    }
}
