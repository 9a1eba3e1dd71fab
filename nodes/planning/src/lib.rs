// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! From a job file to a plan that can be sent: what `camwright plan`, `camwright check` and the job planner share. No ROS.
//!
//! ```text
//! job file ─► Job ─► plan_job ─► Plan ─► pages        refused anywhere: one sentence, with file and line
//!                        └─► LobeDesign ─► blank outline, form of the ground lobe
//! ```

pub mod chart;
pub mod colour_scale;
pub mod drawing;
pub mod markup;
pub mod surface_view;

mod any_prepared;
mod capability;
mod causes;
mod chatter;
mod check_file;
mod compensation;
mod cut_table;
mod deflection;
mod dresses;
mod dry_run;
mod error_location;
mod export;
mod files;
mod finding;
mod findings;
mod finishing;
mod inspect;
mod journals;
mod lifts;
mod lobe_shapes;
mod lobe_tables;
mod lobes;
mod part_support;
mod picture_index;
mod plots;
mod process_warnings;
mod program;
mod programmed;
mod pulses;
mod recorded;
mod simulate;
mod stored_stiffness;
mod summary;
mod table;
mod times;
mod timings;
mod trace;
mod turn;
mod turn_curve;
mod turn_summary;
mod turning;
mod wheel_changes;
mod wide_lobes;

pub use any_prepared::{AnyPrepared, is_milled, plan_any, prepare_any, prepare_any_timed};
pub use camwright::cam::gauge_report::Alignment;
pub use camwright_files::convert::machine_now::MachineNow;
pub use capability::{LobeCapability, MeasuredLobe, capability, measure_lobe, tolerance_text};
pub use causes::{Causes, EffectRemoved, OtherMachine, causes};
pub use chatter::{ChatterReport, PassChatter, VariationSummary, WaveSummary, chatter, wave_causes};
pub use check_file::check_file;
pub use compensation::{
    LearnedJob, LobeReport, ReportedCorrections, ReportedLobe, learn_reports, simulate_learned, with_learned,
};
pub use deflection::LobeDeflection;
pub use dresses::{DressSummary, KeptPathSummary, dresses};
pub use error_location::blame;
pub use export::write;
pub use finding::{CheckReport, Finding, Severity};
pub use findings::check;
pub use finishing::FinishingSummary;
pub use inspect::inspections;
pub use journals::{
    CorrectionFailed, MeasuredContacts, PreparedCorrection, PreparedForStock, PreparedMeasuring, correct, for_stock,
    hash_of, measured_contacts, raw_part,
};
pub use lifts::{AxisJerk, LiftSummary, ReadingSummary};
pub use lobe_shapes::{ShapeSummary, lobe_shape, shape_line};
pub use lobes::{BLANK_POINTS, LobeFormError, lobe_result, measured_form, pin_line, sections_result};
pub use part_support::LobeSupport;
pub use program::{ProgramSummary, ProgrammedTurn, compare_program, write_program};
pub use recorded::{NO_JOB_FILE, plan_recorded};
pub use simulate::with_raw_part;
pub use simulate::{
    Outlines, SimulationFailed, simulate_job, simulate_job_on, simulate_outlines_on, simulate_wide_lobes,
};
pub use stored_stiffness::{StoredContacts, kept_contacts, learn_stiffness};
pub use summary::{LimitSummary, LobeSummary, PassSummary, Summary, lobe_times_s, summary};
pub use table::{NumberColumn, NumberTable};
pub use times::{TimeCompared, compare_times};
pub use timings::{PlanningStage, Timings};
pub use trace::{
    PositionTrace, TraceError, TraceRequest, TracedContact, TracedInfeed, TracedLift, TracedRow, TracedSetpoint,
    TracedSpeed, trace,
};
pub use turn_curve::{TurnCurvePoint, turn_curve};
pub use turn_summary::{BoundSummary, RemovalClass};
pub use turning::{
    OtherLathe, PreparedTurning, TurnedLimitSummary, TurnedPassSummary, TurningSummary, bar, form_map_message,
    plan_turned, simulate_turned, simulate_turned_on, turned_causes, turned_form, turned_result, turning_notes,
    turning_s, turning_summary, write_turning,
};

pub use wheel_changes::{WheelChangeSummary, wheel_changes};
pub use wide_lobes::{PlungeStep, PlungeSummary, WideLobeForm, wide_lobe_forms};

use camwright::cam::inspection::Inspection;
use camwright::machine::description::{MachineDescription, WheelsNow};
use camwright::planner::{PlannedCorrection, PlannedJob, PlannedLobe, plan_job_on};
use camwright_files::ConfigError;
use camwright_files::convert::plan::{Provenance, pages_from_plan};
use camwright_files::job_file::{self, Job};
use camwright_files::limits::MAX_JOB_S;
use camwright_files::yaml::Document;
use camwright_msgs::camwright_msgs::msg::PlanPage;

/// Largest difference between the wheel a job was written for and the wheel that is mounted.
pub use camwright::machine::WHEEL_TOLERANCE_MM;

/// A job, planned and ready to send.
#[derive(Debug, Clone)]
pub struct PreparedJob {
    /// The job as it was read.
    pub job: Job,
    /// The plan and what it was made of; designs per lobe are in `planned.lobes`.
    pub planned: PlannedJob,
    /// Measurement of its stock before anything is cut, the first of its plans, if the job has one. `planned` follows it, and is the
    /// expectation until then.
    pub measuring: Option<PreparedMeasuring>,
    /// The second half of a job whose runout is corrected, as it is expected.
    pub expected_correction: Option<PlannedCorrection>,
    /// Each lobe under the gauge it is inspected with, where the job says so.
    pub inspections: Vec<Option<Inspection>>,
    /// The machine it was planned for.
    pub machine: MachineDescription,
    /// Radius of the wheel that it was planned for, before its first dress (mm).
    pub wheel_radius_mm: f64,
    /// The wheels that it was planned for.
    pub wheels: WheelsNow,
    /// Provenance of the plan.
    pub provenance: Provenance,
    /// The plan as messages, the header first.
    pub pages: Vec<PlanPage>,
}

impl PreparedJob {
    /// Hash of the first plan, 64 hexadecimal digits.
    #[must_use]
    pub fn plan_hash(&self) -> &str {
        self.measuring.as_ref().map_or_else(|| hash_of(&self.pages), PreparedMeasuring::plan_hash)
    }

    /// Lobes with their index that are finished: all but the visits of a wheel after which another one comes.
    pub fn finished_lobes(&self) -> impl Iterator<Item = (usize, &PlannedLobe)> {
        self.planned.lobes.iter().enumerate().filter(|(_, lobe)| lobe.design.is_finished())
    }

    /// Predicted duration of all of it (s).
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        let second_s = self.expected_correction.as_ref().map_or(0.0, |second| second.plan.duration_s);
        self.measuring_s() + self.planned.plan.duration_s + second_s
    }

    /// Predicted duration of the plan that measures its stock, if there is one (s).
    #[must_use]
    pub fn measuring_s(&self) -> f64 {
        self.measuring.as_ref().map_or(0.0, |measuring| measuring.planned.plan.duration_s)
    }

    /// One sentence about it.
    #[must_use]
    pub fn summary(&self) -> String {
        let plan = &self.planned.plan;
        let conventional = self.duration_s() + self.planned.saved_by_not_indexing_s();
        let compared = if self.job.spec.rotary_indexing {
            String::from("with rotary indexing before each lobe")
        } else {
            format!("{conventional:.2} s with rotary indexing, {:.2} s saved", self.planned.saved_by_not_indexing_s())
        };
        let stops = self.planned.saved_by_turning_on_s().map_or_else(String::new, |saved_s| {
            format!(", {:.2} s with C stopping between lobes, {saved_s:.2} s saved", self.duration_s() + saved_s)
        });
        let compared = compared + &stops;
        format!(
            "{}: {}, {:.2} s ({compared}), plan {:.12}",
            plan.job,
            lobe_count(plan.lobes.len()),
            self.duration_s(),
            self.plan_hash()
        )
    }
}

/// Finds, reads and plans a job with `key=value` overrides, for the machine as it is now, or, where there is none, for
/// the machine the job names with a new wheel or the wheel the job names.
///
/// # Errors
/// Everything that cannot be made, one sentence with the file and the line that causes it.
pub fn prepare(name: &str, overrides: &[String], machine: Option<&MachineNow>) -> Result<PreparedJob, ConfigError> {
    plan(job_file::load(name, overrides)?, machine)
}

/// Number of lobes in words.
#[must_use]
pub fn lobe_count(lobes: usize) -> String {
    format!("{lobes} lobe{}", if lobes == 1 { "" } else { "s" })
}

/// Plans a job that has been read; see [`prepare`].
///
/// # Errors
/// Everything that cannot be made.
pub fn plan(job: Job, machine: Option<&MachineNow>) -> Result<PreparedJob, ConfigError> {
    plan_timed(job, machine, &Timings::start())
}

/// [`plan`] with a stopwatch.
fn plan_timed(job: Job, machine: Option<&MachineNow>, timings: &Timings) -> Result<PreparedJob, ConfigError> {
    let (description, wheels) = match machine {
        Some(now) => {
            fits_machine(&job, now)?;
            (now.description.clone(), now.wheels)
        }
        None => {
            let description = job.machine.description.clone();
            let radius_mm = job.wheel_radius_mm.unwrap_or(description.wheel.new_radius_mm);
            (description, WheelsNow::from(radius_mm))
        }
    };
    let provenance = Provenance { job_hash: job.hash.clone(), machine_hash: description.hash.clone() };
    let planned = plan_job_on(timings, &job.spec, &description, wheels, None).map_err(|error| blame(&job, &error))?;
    let wheel = wheels.mounted;
    timings.enter(PlanningStage::Complete);
    not_too_long(&job.document, planned.plan.duration_s)?;
    let planned = programmed::with_program(&job, &description, wheel.radius_mm, planned)?;
    let (planned, measuring) = journals::measuring(&job, &description, wheel, planned, &provenance)?;
    let expected_correction = journals::expected(&job, &description, &planned)?;
    let inspections = inspections(&job, &planned)?;
    timings.enter(PlanningStage::Hash);
    let pages = pages_from_plan(&planned.plan, &provenance);
    let wheel_radius_mm = wheel.radius_mm;
    Ok(PreparedJob {
        job,
        planned,
        measuring,
        expected_correction,
        inspections,
        machine: description,
        wheel_radius_mm,
        wheels,
        provenance,
        pages,
    })
}

/// Refuses a plan that takes longer than a job may, however fast its cuts are.
fn not_too_long(document: &Document, duration_s: f64) -> Result<(), ConfigError> {
    if duration_s <= MAX_JOB_S {
        return Ok(());
    }
    let message = format!(
        "the job takes {duration_s:.3e} s; at most {MAX_JOB_S} s, a day, are allowed: faster speeds of cuts and rapids, or fewer turns"
    );
    Err(document.error("rapid_speed_mm_s", message))
}

fn fits_cell(document: &Document, wanted: &str, now: &MachineNow) -> Result<(), ConfigError> {
    let there = &now.description.name;
    if wanted == there {
        Ok(())
    } else {
        Err(document.error("machine", format!("the job is for machine {wanted}, the cell has {there}")))
    }
}

fn fits_machine(job: &Job, now: &MachineNow) -> Result<(), ConfigError> {
    fits_cell(&job.document, &job.machine.description.name, now)?;
    match job.wheel_radius_mm {
        Some(wanted) if (wanted - now.wheels.mounted.radius_mm).abs() > WHEEL_TOLERANCE_MM => Err(job.document.error(
            "wheel_radius_mm",
            format!(
                "wheel_radius_mm is {wanted}, the wheel mounted on {} has {:.4}; the maximum difference is {WHEEL_TOLERANCE_MM}; mount that wheel or change the key",
                now.description.name, now.wheels.mounted.radius_mm
            ),
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
