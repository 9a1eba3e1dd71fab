// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A turning job, planned and ready to send.

use super::error_location;
use crate::programmed::turned_with_program;
use crate::{fits_cell, hash_of, not_too_long};
use camwright::machine::description::MachineDescription;
use camwright::math::units::rpm_from_rad_s;
use camwright::planner::{PlannedPass, PlannedTurning, plan_turning};
use camwright::toolpath::insert_path::Cusp;
use camwright_files::ConfigError;
use camwright_files::convert::machine_now::MachineNow;
use camwright_files::convert::plan::{Provenance, pages_from_plan};
use camwright_files::turning_file::TurnedJob;
use camwright_msgs::camwright_msgs::msg::PlanPage;

/// A turning job, planned and ready to send.
#[derive(Debug, Clone)]
pub struct PreparedTurning {
    /// The job as it was read.
    pub job: TurnedJob,
    /// The plan and what it was made of.
    pub planned: PlannedTurning,
    /// The machine it was planned for.
    pub machine: MachineDescription,
    /// Provenance of the plan.
    pub provenance: Provenance,
    /// The plan as messages, the header first.
    pub pages: Vec<PlanPage>,
}

impl PreparedTurning {
    /// Hash of the plan, 64 hexadecimal digits.
    #[must_use]
    pub fn plan_hash(&self) -> &str {
        hash_of(&self.pages)
    }

    /// Predicted duration (s).
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.planned.plan.duration_s
    }

    /// One sentence about it.
    #[must_use]
    pub fn summary(&self) -> String {
        let passes = &self.planned.passes;
        let turns: f64 = passes.iter().map(|pass| pass.turns).sum();
        let speeds = passes.iter().map(PlannedPass::speed_range_rad_s);
        let (slowest, fastest) = speeds.fold((f64::INFINITY, 0.0_f64), |(slowest, fastest), (low, high)| {
            (slowest.min(rpm_from_rad_s(low)), fastest.max(rpm_from_rad_s(high)))
        });
        let speed = if fastest - slowest < 0.05 {
            format!("{fastest:.1} rpm")
        } else {
            format!("{slowest:.1} to {fastest:.1} rpm")
        };
        let count = match passes.len() {
            1 => String::from("1 pass"),
            count => format!("{count} passes"),
        };
        format!(
            "{}: {count}, {turns:.1} turns at {speed}, {:.2} s, plan {:.12}",
            self.planned.plan.job,
            self.duration_s(),
            self.plan_hash()
        )
    }
}

/// Plans a turning job that has been read, for the machine as it is now, or, where there is none, for the machine the job names.
///
/// # Errors
/// Everything that cannot be made, one sentence with the file and the line that causes it.
pub fn plan_turned(job: TurnedJob, machine: Option<&MachineNow>) -> Result<PreparedTurning, ConfigError> {
    let machine = match machine {
        Some(now) => {
            fits_cell(&job.document, &job.machine.description.name, now)?;
            now.description.clone()
        }
        None => job.machine.description.clone(),
    };
    let provenance = Provenance { job_hash: job.hash.clone(), machine_hash: machine.hash.clone() };
    let planned =
        plan_turning(&job.spec, &machine, None).map_err(|error| error_location::blame(&job, &machine, &error))?;
    let planned = turned_with_program(&job, &machine, planned)?;
    not_too_long(&job.document, planned.plan.duration_s)?;
    let pages = pages_from_plan(&planned.plan, &provenance);
    Ok(PreparedTurning { job, planned, machine, provenance, pages })
}

/// The highest cusp that a pass must leave. What is under the stock of a pass to come is not seen: only the last pass has cusps that stay.
pub(super) fn highest_cusp(prepared: &PreparedTurning, pass: &PlannedPass) -> Option<Cusp> {
    if pass.path.request().stock_mm > 0.0 {
        return None;
    }
    let (from_mm, to_mm) = prepared.job.spec.range_mm();
    pass.path.highest_cusp(&prepared.job.spec.surface, from_mm, to_mm).ok()
}
