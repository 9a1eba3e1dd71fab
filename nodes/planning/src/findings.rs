// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Everything that can be said about a job or a lift table before anything moves.

use super::finding::{CheckReport, Finding, warning};
use super::program::check_milled;
use super::turning::check_turned;
use super::{PreparedJob, chatter, deflection, error_location::blame, finishing, plan, process_warnings};
use camwright::job::grinding::{JobError, LobeSpec};
use camwright::math::units::{deg_from_rad, um_from_mm};
use camwright::planner::PlannedLobe;
use camwright::planner::{PlanError, plan_job};
use camwright_files::ConfigError;
use camwright_files::any_job::{self, AnyJob};
use camwright_files::convert::machine_now::MachineNow;
use camwright_files::job_file::Job;
use camwright_files::lift_file;
use camwright_files::locate::{Located, locate};
use std::path::Path;

/// Checks a job, planning it to the end for the machine as it is now (see [`super::prepare`]), or a lift table. `name` is a
/// path or the name of a job or of a table.
///
/// # Errors
/// There is no such file.
pub fn check(name: &str, overrides: &[String], machine: Option<&MachineNow>) -> Result<CheckReport, ConfigError> {
    let table = || locate("lifts", name, "csv", None).map(|located| check_table(&located, overrides));
    match if is_table(name) { None } else { Some(locate("jobs", name, "yaml", None)) } {
        Some(Ok(located)) => Ok(check_job(&located, overrides, machine)),
        Some(Err(error)) => table().map_err(|_| error),
        None => table(),
    }
}

/// Returns whether a name is that of a file with a lift table.
pub(super) fn is_table(name: &str) -> bool {
    let extension = Path::new(name).extension().map(|extension| extension.to_string_lossy().to_lowercase());
    extension.is_some_and(|extension| ["csv", "txt", "tab", "tsv", "dat"].contains(&extension.as_str()))
}

pub(super) fn check_job(located: &Located, overrides: &[String], machine: Option<&MachineNow>) -> CheckReport {
    let job = match any_job::read(located, overrides) {
        Ok(AnyJob::Ground(job)) => *job,
        Ok(AnyJob::Turned(job)) => return check_turned(&located.path, *job, machine),
        Ok(AnyJob::Milled(job)) => return check_milled(&located.path, &job),
        Err(errors) => return CheckReport::refused(&located.path, errors),
    };
    let warnings = warnings(&job);
    match plan(job.clone(), machine) {
        Ok(prepared) => {
            let findings = all_warnings(&prepared);
            let mut notes = super::lifts::notes(&prepared.job, Some(&prepared));
            notes.extend(finishing::notes(&prepared));
            CheckReport { file: located.path.clone(), findings, summary: Some(prepared.summary()), notes }
        }
        Err(first) => {
            let mut report = CheckReport::refused(&located.path, all_errors(&job, machine, first));
            // Why a table makes no contour often shows in the jerk of its reading.
            report.notes = super::lifts::notes(&job, None);
            report.findings.extend(warnings);
            report
        }
    }
}

/// The core stops at its first refusal. Asking it about every lobe, alone and together with those before it that have no
/// fault, finds the others.
fn all_errors(job: &Job, machine: Option<&MachineNow>, first: ConfigError) -> Vec<ConfigError> {
    let mut errors = vec![first];
    let mut add = |error: ConfigError| {
        // What one lobe alone says may stand in what all of them said before.
        let is_same = |known: &ConfigError| known.place == error.place && known.message.contains(&error.message);
        if !errors.iter().any(is_same) {
            errors.push(error);
        }
    };
    let description = machine.map_or(&job.machine.description, |now| &now.description);
    let wheels = match machine {
        Some(now) => now.wheels,
        None => job.wheel_radius_mm.unwrap_or(description.wheel.new_radius_mm).into(),
    };
    let mut accepted = Vec::new();
    for lobe in &job.spec.lobes {
        let mut tried = job.spec.clone();
        tried.lobes = accepted.clone();
        tried.lobes.push(lobe.clone());
        match tried.check(description) {
            // The number of a lobe in this shorter job is not its number in the file.
            Err(JobError::SameName { .. }) => {}
            Err(error) => add(blame(job, &error.into())),
            Ok(()) => accepted = tried.lobes,
        }
    }
    for lobe in accepted {
        let mut alone = job.spec.clone();
        alone.profiles = job.spec.profiles.get(lobe.profile).cloned().into_iter().collect();
        alone.lobes = vec![LobeSpec { profile: 0, ..lobe }];
        alone.wheels = Vec::new();
        match plan_job(&alone, description, wheels, None) {
            Err(PlanError::Path { profile, source, .. }) => {
                add(blame(job, &PlanError::Path { lobes: String::new(), advice: String::new(), profile, source }));
            }
            Err(error) => add(blame(job, &error)),
            Ok(_) => {}
        }
    }
    errors
}

/// Warnings about a planned job and its files.
pub(super) fn all_warnings(prepared: &PreparedJob) -> Vec<Finding> {
    let mut findings = warnings(&prepared.job);
    findings.extend(planned_warnings(prepared));
    findings
}

fn warnings(job: &Job) -> Vec<Finding> {
    let mut findings: Vec<Finding> =
        job.lifts.iter().flat_map(|lift| lift.warnings.iter().cloned().map(warning)).collect();
    for (index, profile) in job.spec.profiles.iter().enumerate() {
        if job.spec.lobes.iter().all(|lobe| lobe.profile != index) {
            let message = format!("profile {} is used by no lobe", profile.name);
            findings.push(warning(job.document.error(&format!("profiles.{index}.name"), message)));
        }
    }
    let wheel = &job.machine.description.wheel;
    if let Some(radius) = job.wheel_radius_mm.filter(|r| !(wheel.min_radius_mm..=wheel.new_radius_mm).contains(r)) {
        let message = format!(
            "wheel_radius_mm is {radius}; the wheel of machine {} has {} to {}: the job can be planned, not run",
            job.machine.description.name, wheel.min_radius_mm, wheel.new_radius_mm
        );
        findings.push(warning(job.document.error("wheel_radius_mm", message)));
    }
    findings
}

/// Stock after a single spark-out turn that needs no warning (mm).
const LEFT_ON_PART_MM: f64 = 1e-4;

fn planned_warnings(prepared: &PreparedJob) -> Vec<Finding> {
    let mut findings = overlooked(prepared);
    // What a pass leaves, the next one takes; the last one's stays.
    let spark_out = prepared.job.spec.passes.last().map_or(0, |pass| pass.spark_out_turns);
    let left = |lobe: &PlannedLobe| lobe.passes.last().map_or(0.0, |pass| pass.infeed().left_on_part_mm(spark_out));
    let finished = prepared.finished_lobes().map(|(_, lobe)| (left(lobe), &lobe.design.name));
    let worst = finished.max_by(|a, b| a.0.total_cmp(&b.0));
    match worst {
        Some((left_mm, lobe)) if left_mm > LEFT_ON_PART_MM => {
            let (left_um, allowed_um) = (um_from_mm(left_mm), um_from_mm(LEFT_ON_PART_MM));
            let message = match spark_out {
                0 => format!(
                    "lobe {lobe}: without spark-out the infeed of the last turn stays on the part as a step of {left_um:.2} um; 2 turns leave \
                     nothing"
                ),
                _ => format!(
                    "lobe {lobe}: {spark_out} spark-out turn leaves up to {left_um:.2} um of the infeed's end on the part, above \
                     {allowed_um} um; 2 leave nothing"
                ),
            };
            findings.push(warning(prepared.job.document.error("infeed.spark_out_turns", message)));
        }
        _ => {}
    }
    if let Some(message) = deflection::too_little_spark_out(prepared) {
        findings.push(warning(prepared.job.document.error("infeed.spark_out_turns", message)));
    }
    for (key, message) in deflection::size_warnings(prepared) {
        findings.push(warning(prepared.job.document.error(key, message)));
    }
    if let Some(message) = finishing::unmeasured_warning(prepared) {
        findings.push(warning(prepared.job.document.error(finishing::FORCE_KEY, message)));
    }
    if let Some(message) = super::wheel_changes::approach_warning(prepared) {
        findings.push(warning(prepared.job.document.error("wheel_approach_mm", message)));
    }
    if let Some(message) = super::wheel_changes::order_warning(prepared) {
        findings.push(warning(prepared.job.document.error("lobes", message)));
    }
    if let Some(message) = chatter::chatter_warning(prepared) {
        findings.push(warning(prepared.job.document.error("work_speed_rpm", message)));
    }
    findings.extend(process_warnings::of_process(prepared));
    findings
}

/// Hollows that a gauge lies across.
fn overlooked(prepared: &PreparedJob) -> Vec<Finding> {
    let Job { spec, gauges, document, .. } = &prepared.job;
    let of_profile = |profile: usize| {
        let lobe = spec.lobes.iter().position(|lobe| lobe.profile == profile)?;
        let hollow = prepared.inspections[lobe].as_ref()?.overlooked()?;
        let message = format!(
            "profile {}: the gauge lies across the hollow at cam angle {:.2} deg, whose radius of {:.3} mm it does not fit: \
             what lies between is not inspected",
            spec.profiles[profile].name,
            deg_from_rad(hollow.angle_rad),
            -1.0 / hollow.value
        );
        Some(warning(document.error(&format!("profiles.{profile}.gauge"), message)))
    };
    (0..gauges.len()).filter_map(of_profile).collect()
}

pub(super) fn check_table(located: &Located, overrides: &[String]) -> CheckReport {
    let lift = match lift_file::read_alone(located, overrides) {
        Ok(lift) => lift,
        Err(errors) => return CheckReport::refused(&located.path, errors),
    };
    let summary = lift.table.as_ref().map(|table| {
        format!(
            "{}: {} blocks over one turn, largest lift {} mm, last digit {} mm",
            located.path.display(),
            table.blocks(),
            written(table.max_lift_mm()),
            written(table.digit_mm())
        )
    });
    let notes = super::lifts::readings(&lift).iter().map(ToString::to_string).collect();
    let findings = lift.warnings.into_iter().map(warning).collect();
    CheckReport { file: located.path.clone(), findings, summary, notes }
}

/// A length as people write it: to a picometre, below which an inch is no decimal part of a millimetre.
fn written(mm: f64) -> f64 {
    const PER_MM: f64 = 1e9;
    (mm * PER_MM).round() / PER_MM
}
