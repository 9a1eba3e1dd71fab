// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! One case: planned, simulated and measured without ROS.

use super::simulated_part::{SimulatedPart, simulate_part};
use camwright_files::ConfigError;
use camwright_files::study_file::{Study, StudyResponse, StudySetting};
use camwright_planning::{self as planning, SimulationFailed};
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

    fn refused(error: &ConfigError) -> Self {
        Self::failed(CaseStatus::Refused, error.to_string(), None)
    }

    #[must_use]
    pub const fn response(&self, response: StudyResponse) -> Option<f64> {
        self.responses[response.index()]
    }
}

impl From<Result<SimulatedPart, SimulationFailed>> for CaseOutcome {
    fn from(simulated: Result<SimulatedPart, SimulationFailed>) -> Self {
        match simulated {
            Ok(part) => Self {
                status: CaseStatus::Done,
                reason: String::new(),
                alarm: None,
                worst_lobe: part.worst_lobe,
                responses: part.responses,
            },
            Err(failed) => {
                let status = if failed.alarm.is_some() { CaseStatus::Alarm } else { CaseStatus::Failed };
                Self::failed(status, failed.reason, failed.alarm)
            }
        }
    }
}

/// Plans and simulates the job of a study with these settings. Whatever fails is part of the result.
#[must_use]
pub fn run_case(study: &Study, settings: &[StudySetting]) -> CaseOutcome {
    guarded(|| {
        let job = study.base.job_with(settings).map_err(|mut errors| errors.swap_remove(0));
        match job.and_then(|job| planning::plan_any(job, None)) {
            Ok(prepared) => CaseOutcome::from(simulate_part(&prepared)),
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
