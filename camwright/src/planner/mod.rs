// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Room 9. From a job to its plan: the main routine of JPS6156064B2 (its Fig. 6), complete, before anything moves.
//!
//! ```text
//! home C on the origin detector · wheel up to speed
//! for each lobe:
//!    (wheel to the dresser, where the job says so         Dress)
//!     table to the lobe's limit switch                    Index
//!    (C to the lobe's cam angle 0, conventional way only  RotaryIndex)
//!     X corrected by the lift at the phase C stands at    Position   (Fig. 7)
//!     rapid advance R0 at F0, to just before the blank    Approach
//!     C and X together: infeed turns, spark-out turns     Cut        (Fig. 8), ends on the phase it began at
//!     rapid retract                                       Retract
//! X, then the table, to the home position                 Return
//! ```
//!
//! Where the job says so, C turns on from lobe to lobe: then the lead-in and the lead-out of the cuts take the place of rapid advance
//! and retract.
//!
//! Turns are whole, so C ends each lobe at the phase it had before. Without rotary indexing, lobe j is read from the angle σ·C − αj
//! on, wherever in its table that is. Both variants are built, and both times are reported.
//!
//! ```
//! use camwright::{job::grinding::JobSpec, machine::reference::cam_grinder, planner::plan_job};
//!
//! let nothing = JobSpec::without_lobes("nothing to grind", 120.0, 100.0);
//! let refused = plan_job(&nothing, &cam_grinder(), 60.0, None);
//! assert!(refused.is_err()); // a job without a lobe, and the reason in words
//! ```

pub mod chatter;
mod clearance;
mod continuous_c;
mod correct;
pub mod deflection;
mod dress;
mod dress_now;
mod dry_run;
mod error;
mod gouge;
mod host;
mod identify;
mod journal_readings;
mod lathe;
mod lobe;
mod measure;
mod order;
mod outline;
pub mod plan_check;
pub mod plan_difference;
mod program;
pub mod program_motion;
mod sequence;
mod steps;
mod wheels;

pub use correct::{PlannedCorrection, decide_corrections, plan_corrections};
pub use dress_now::{DressNowError, plan_dress};
pub use error::{IdleWheelStep, PlanError, RequiredPosition};
pub use host::{OneByOne, PlanHost, PlanStage};
pub use identify::identify;
pub use journal_readings::{ContactFrom, JournalReadings, UncorrectedJournal, rests_rad};
pub use lathe::{MAX_SURFACE_LOOKS, PlannedPass, PlannedTurning, TurningError, TurningKey, plan_turning};
pub use lobe::{LobeDesign, PlannedLobe, designs};
pub use measure::{MeasuredJob, PlannedMeasuring, SkippedTurns, measured_stocks, plan_measured_job, plan_measuring};
pub use order::{LobeOrder, fastest_order};
pub use program::{PlannedProgram, ProgramLobe, ProgramPlanError, ProgramRequest, plan_program};

use crate::job::dressing::PlannedDress;
use crate::job::grinding::{BetweenLobes, JobSpec};
use crate::job::infeed::InfeedSchedule;
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription, WheelsNow};
use crate::motion::plan::Plan;
use crate::planner::plan_check::{PlanReport, check_plan};
use gouge::{GougeRequest, check_gouges};
use lobe::LobePlanner;
use sequence::Sequence;

use alloc::vec::Vec;

/// Position of the axes before the part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanStart {
    /// Positions (counts).
    pub counts: [i64; AXIS_COUNT],
    /// True if C knows its zero; otherwise half a turn to the origin is predicted.
    pub c_homed: bool,
}

impl PlanStart {
    /// X and Z at the home position of a job, C unhomed.
    #[must_use]
    pub fn at_home(job: &JobSpec, machine: &MachineDescription) -> Self {
        let counts = |axis: Axis, at: f64| machine.axis(axis).scale.counts(at);
        Self { counts: [0, counts(Axis::X, job.home.x_mm), counts(Axis::Z, job.home.z_mm)], c_homed: false }
    }

    /// A lathe with the insert's centre clear of the bar, C not homed.
    #[must_use]
    pub fn clear_of_bar(machine: &MachineDescription, x_mm: f64, z_mm: f64) -> Self {
        let counts = |axis: Axis, at: f64| machine.axis(axis).scale.counts(at);
        Self { counts: [0, counts(Axis::X, x_mm), counts(Axis::Z, z_mm)], c_homed: false }
    }
}

/// A job planned: what to execute, and what it was made of.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedJob {
    pub plan: Plan,
    /// Per lobe: geometry, start and speed, in the order of machining.
    pub lobes: Vec<PlannedLobe>,
    /// The dresses of the wheel, in their order.
    pub dresses: Vec<PlannedDress>,
    /// Predicted duration of the same job with C stopping between its lobes, where it turns on (s).
    pub duration_with_stops_s: Option<f64>,
    /// Result of the forward check.
    pub report: PlanReport,
    /// C where the plan begins (counts).
    pub start_c_counts: i64,
}

impl PlannedJob {
    /// Predicted time saved by not turning the part to each lobe's base (s), the claim of the patent; negative times
    /// the job's own way if that is the conventional one.
    #[must_use]
    pub fn saved_by_not_indexing_s(&self) -> f64 {
        self.plan.duration_with_indexing_s - self.plan.duration_s
    }

    /// Predicted time saved by C turning on between the lobes (s), where it does.
    #[must_use]
    pub fn saved_by_turning_on_s(&self) -> Option<f64> {
        Some(self.duration_with_stops_s? - self.plan.duration_s)
    }
}

/// Plans a job for a machine and its wheels: the radius of the mounted one (mm), or what is known of it, or of all wheels of a changer.
///
/// `start` is where the axes stand; without it X and Z are taken to be at the home position and C unhomed. It changes
/// the predicted duration, and nothing else but the first moves.
///
/// # Errors
/// Everything that cannot be made, in one sentence; nothing has moved.
pub fn plan_job(
    job: &JobSpec,
    machine: &MachineDescription,
    wheels: impl Into<WheelsNow>,
    start: Option<PlanStart>,
) -> Result<PlannedJob, PlanError> {
    plan_job_on(&OneByOne, job, machine, wheels, start)
}

/// [`plan_job`] on a host, which changes no bit of it.
///
/// # Errors
/// Those of [`plan_job`].
pub fn plan_job_on(
    host: &impl PlanHost,
    job: &JobSpec,
    machine: &MachineDescription,
    wheels: impl Into<WheelsNow>,
    start: Option<PlanStart>,
) -> Result<PlannedJob, PlanError> {
    host.begins(PlanStage::Prepare);
    job.check(machine)?;
    let schedules = schedules(job, machine)?;
    host.begins(PlanStage::Contour);
    let contours = lobe::contours(job, host)?;
    host.begins(PlanStage::Path);
    let wheels_now = wheels.into();
    wheels::check_one_wheel(job, &contours, wheels_now.mounted.radius_mm)?;
    let wheel = lobe::wheel_course(job, machine, &contours, &wheels_now)?;
    let shapes = lobe::shapes(job, machine, &contours, &wheel, host)?;
    let begins = lobe::begins(job, machine, &schedules, job.rotary_indexing);
    let planner = LobePlanner { job, machine, shapes: &shapes, schedules: &schedules, wheel: &wheel };
    host.begins(PlanStage::Speed);
    let stopping = planner.all(&begins, host)?;
    let clear_x_mm = match job.c_between_lobes {
        BetweenLobes::Stops => None,
        BetweenLobes::TurnsOn { .. } => Some(continuous_c::clear_x_mm(&planner, &stopping)),
    };
    lobe::check_travel(job, machine, &schedules, &stopping, clear_x_mm)?;

    host.begins(PlanStage::Sequence);
    let start = start.unwrap_or_else(|| PlanStart::at_home(job, machine));
    // Where wheels are dressed, a plan may be older than the wheel.
    let expected_wheel_mm = machine.dresser.map(|_| wheels_now.mounted.radius_mm);
    let build = Build { planner, stopping: &stopping, start, expected_wheel_mm };
    let (mut plan, lobes, duration_with_stops_s) = match job.c_between_lobes {
        BetweenLobes::Stops => (build.stopping(job.rotary_indexing)?, stopping.clone(), None),
        BetweenLobes::TurnsOn { margin_s } => {
            let (plan, lobes) = build.turning(margin_s)?;
            (plan, lobes, Some(build.stopping(false)?.duration_s))
        }
    };
    if let Some(stand_off_mm) = job.dry_run_mm {
        dry_run::check(job, machine, &lobes, stand_off_mm)?;
        dry_run::stand_off(&mut plan, machine, stand_off_mm);
    }
    plan.duration_with_indexing_s = if job.rotary_indexing {
        plan.duration_s
    } else {
        // Same cuts from other phases: a ramp may differ by hundredths of a second there, which is omitted.
        build.stopping(true)?.duration_s
    };
    host.begins(PlanStage::Check);
    let report = check_forwards(&GougeRequest {
        job,
        machine,
        lobes: &lobes,
        plan: &plan,
        start_counts: start.counts,
        c_homed: start.c_homed,
        stock_mm: &(0..lobes.len()).map(|lobe| job.maximum_stock_of_mm(lobe)).collect::<Vec<_>>(),
        corrections: &[],
    })?;
    host.begins(PlanStage::Dress);
    let dresses = dress::with_kept_paths(job, machine, &contours, &shapes, &wheels_now, &wheel);
    let start_c_counts = start.counts[Axis::C.index()];
    Ok(PlannedJob { plan, lobes, dresses, duration_with_stops_s, report, start_c_counts })
}

/// Checks a grinding plan forwards: clearance, depth of the wheel in the part, limits of the axes.
fn check_forwards(request: &GougeRequest<'_>) -> Result<PlanReport, PlanError> {
    let GougeRequest { job, machine, lobes, plan, start_counts, .. } = *request;
    clearance::check_clearance(job, machine, lobes, plan, start_counts)?;
    check_gouges(request)?;
    Ok(check_plan(plan, machine, start_counts)?)
}

/// The infeed of every pass; each begins where the one before ended.
fn schedules(job: &JobSpec, machine: &MachineDescription) -> Result<Vec<InfeedSchedule>, PlanError> {
    let scale = machine.axis(Axis::X).scale;
    let allowance_counts = scale.counts(job.allowance_mm());
    let mut left_counts = allowance_counts - job.size_control().map_or(0, |size| scale.counts(size.beyond_mm));
    let mut schedules = Vec::with_capacity(job.passes.len());
    for pass in job.passes.iter().rev() {
        let schedule = match pass.infeed_of_turns_mm.as_slice() {
            [] => InfeedSchedule::new(pass.total_infeed_mm, pass.infeed_per_block_mm, job.blocks_per_turn, scale),
            each_mm => InfeedSchedule::from_list(pass.total_infeed_mm, each_mm, scale),
        };
        let schedule = schedule
            .map_err(|source| PlanError::Infeed { pass: pass.name.clone(), source })?
            .spread(pass.infeed_course)
            .sparking_out(pass.spark_out_turns > 0);
        let total_counts = schedule.total_counts();
        schedules.push(schedule.above(scale.position(left_counts)));
        left_counts += total_counts - scale.counts(pass.air_mm);
    }
    schedules.reverse();
    Ok(schedules)
}

/// Input for building a plan.
#[derive(Clone, Copy)]
struct Build<'a> {
    planner: LobePlanner<'a>,
    /// The lobes with C stopping between them.
    stopping: &'a [PlannedLobe],
    start: PlanStart,
    expected_wheel_mm: Option<f64>,
}

impl<'a> Build<'a> {
    /// The steps before the first lobe.
    fn sequence(&self) -> Result<Sequence<'a>, PlanError> {
        let LobePlanner { job, machine, shapes, .. } = self.planner;
        let mut sequence = Sequence::new(job, machine, shapes, self.start);
        // A plan that mounts its wheels expects each of them then.
        if let Some(radius_mm) = self.expected_wheel_mm.filter(|_| job.wheels_in_order().is_empty()) {
            sequence.expect_wheel(radius_mm);
        }
        sequence.prepare(self.planner.wheel.mounts.first())?;
        Ok(sequence)
    }

    fn begins(&self, rotary_indexing: bool) -> Vec<lobe::LobeStart> {
        lobe::begins(self.planner.job, self.planner.machine, self.planner.schedules, rotary_indexing)
    }

    /// The plan with C stopping between lobes.
    fn stopping(&self, rotary_indexing: bool) -> Result<Plan, PlanError> {
        self.steps(self.sequence()?, &self.begins(rotary_indexing), rotary_indexing)
    }

    /// The steps of all lobes, each from where C stands then, and of the end.
    fn steps(
        &self,
        mut sequence: Sequence<'a>,
        begins: &[lobe::LobeStart],
        rotary_indexing: bool,
    ) -> Result<Plan, PlanError> {
        for (index, (lobe, begin)) in self.stopping.iter().zip(begins.iter().copied()).enumerate() {
            sequence.change_wheel(index, self.planner.wheel)?;
            for dress in self.planner.wheel.dresses.iter().filter(|dress| dress.before_lobe == index) {
                sequence.dress(dress, &lobe.design.name)?;
            }
            sequence.index_to(index)?;
            if rotary_indexing {
                sequence.turn_to_lobe(index, begin.c_counts)?;
            }
            sequence.grind(index, lobe, begin, 0)?;
            if let Some(identification) = &self.planner.job.identification {
                sequence.push(index, lobe, identification)?;
            }
        }
        // Where runout is corrected a second half follows.
        if self.planner.job.is_corrected().is_some() { sequence.stand_by() } else { sequence.finish() }
    }

    /// The plan with C turning on from lobe to lobe, and its lobes.
    fn turning(&self, margin_s: f64) -> Result<(Plan, Vec<PlannedLobe>), PlanError> {
        let mut sequence = self.sequence()?;
        let begins = self.begins(false);
        let dresses = &self.planner.wheel.dresses;
        let lobes =
            continuous_c::grind_turning(&self.planner, &mut sequence, self.stopping, &begins, dresses, margin_s)?;
        Ok((sequence.finish()?, lobes))
    }
}

#[cfg(test)]
pub(crate) mod tests;
