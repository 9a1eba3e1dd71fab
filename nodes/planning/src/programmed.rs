// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A job that is ground or turned by an NC program: the program's motion in the place of its own cuts.

use super::PreparedTurning;
use super::program::refuse_what_needs_the_machine;
use camwright::gcode::post::NcControl;
use camwright::gcode::{Block, Program, ProgramFile, ProgramMotion, Step, read};
use camwright::machine::description::InsertDescription;
use camwright::machine::description::MachineDescription;
use camwright::planner::program_motion::{ProgramSetup, drivable_shares};
use camwright::planner::{
    PlanStart, PlannedJob, PlannedProgram, PlannedTurning, ProgramLobe, ProgramPlanError, ProgramRequest, TurningError,
    plan_program,
};
use camwright_files::ConfigError;
use camwright_files::job_file::Job;
use camwright_files::program_file::JobProgram;
use camwright_files::turning_file::TurnedJob;

/// The job's plan, or that of its program where it names one: lobes and what they are measured against stay the job's.
pub(super) fn with_program(
    job: &Job,
    machine: &MachineDescription,
    wheel_radius_mm: f64,
    planned: PlannedJob,
) -> Result<PlannedJob, ConfigError> {
    let Some(JobProgram { motion, files }) = &job.program else { return Ok(planned) };
    refuse_what_needs_the_machine(job)?;
    for (is_so, key, what) in [
        (job.spec.compensation.is_some(), "form_compensation", "corrects form by learning from its parts"),
        (job.spec.identification.is_some(), "identification", "measures the stiffness of its parts"),
        (job.starts_in_the_middle, "start_at", "begins in its middle"),
    ] {
        if is_so {
            let message = format!("the job {what}; an NC program grinds the whole part as it is written");
            return Err(job.document.error(key, message));
        }
    }
    let lobes: Vec<ProgramLobe<'_>> = (job.spec.lobes.iter())
        .filter_map(|lobe| {
            let z_mm = machine.station(&lobe.station)?.position_mm + lobe.offset_mm();
            Some(ProgramLobe { name: &lobe.name, z_mm, width_mm: lobe.width_mm })
        })
        .collect();
    let control = &job.nc.control;
    let setup = ProgramSetup {
        cutter_radius_mm: wheel_radius_mm,
        x_of_edge: job.nc.x_of_edge,
        z_zero_mm: 0.0,
        rotation_sense: control.rotation_sense,
        path_tolerance_mm: control.path_tolerance_mm.unwrap_or(job.nc.finish_tolerance_mm),
    };
    let request = ProgramRequest { name: &job.spec.name, motion, files, setup, x_clear_mm: None, lobes: &lobes };
    let start = PlanStart::at_home(&job.spec, machine);
    let programmed =
        plan_program(&request, machine, start).map_err(|error| job.document.error("program", error.to_string()))?;
    Ok(PlannedJob {
        plan: programmed.plan,
        report: programmed.report,
        dresses: Vec::new(),
        duration_with_stops_s: None,
        ..planned
    })
}

/// The turning job's plan, or that of its program where it names one: what the part is measured against stays the job's.
pub(super) fn turned_with_program(
    job: &TurnedJob,
    machine: &MachineDescription,
    planned: PlannedTurning,
) -> Result<PlannedTurning, ConfigError> {
    let (Some(JobProgram { motion, files }), Some(insert)) = (&job.program, &machine.insert) else {
        return Ok(planned);
    };
    let programmed = plan_turning_program(job, machine, insert, (motion, files), &planned)
        .map_err(|error| job.document.error("program", error.to_string()))?;
    Ok(PlannedTurning { plan: programmed.plan, report: programmed.report, ..planned })
}

/// Largest share of its speed at which the machine of a turning job drives each pass of a program.
pub(super) fn turning_program_shares(
    prepared: &PreparedTurning,
    control: &NcControl,
    program: &Program,
) -> Result<Vec<f64>, ConfigError> {
    let (job, machine) = (&prepared.job, &prepared.machine);
    let refused = |error: String| job.document.error("nc", error);
    let Some(insert) = &machine.insert else { return Err(refused(TurningError::NotALathe.to_string())) };
    // A control whose C counts against that of the machine drives the mirror image of its program.
    let program = mirrored(program, control.rotation_sense);
    let files = control.dialect.write(&program).map_err(|error| refused(error.to_string()))?;
    let motion =
        read(control.dialect, control.format.x_values(), &files).map_err(|error| refused(error.to_string()))?;
    let setup = ProgramSetup { rotation_sense: machine.rotation_sense, ..turning_setup(job, insert) };
    let start = turning_start(job, machine, insert, &prepared.planned);
    drivable_shares(&motion, &files, &setup, machine, start.counts).map_err(|error| refused(error.to_string()))
}

/// A program with C in the other direction, for a rotation sense of -1.
fn mirrored(program: &Program, rotation_sense: i8) -> Program {
    let mut program = program.clone();
    for step in &mut program.main {
        if let Step::Block(Block::Rapid(target) | Block::Feed { target, .. }) = step {
            target.c = target.c.map(|c| i64::from(rotation_sense) * c);
        }
    }
    program
}

fn turning_setup(job: &TurnedJob, insert: &InsertDescription) -> ProgramSetup {
    let control = &job.nc.control;
    ProgramSetup {
        cutter_radius_mm: insert.radius_mm,
        x_of_edge: job.nc.x_of_edge,
        z_zero_mm: -job.spec.part_zero_mm,
        rotation_sense: control.rotation_sense,
        path_tolerance_mm: control.path_tolerance_mm.unwrap_or(job.nc.finish_tolerance_mm),
    }
}

fn turning_start(
    job: &TurnedJob,
    machine: &MachineDescription,
    insert: &InsertDescription,
    planned: &PlannedTurning,
) -> PlanStart {
    let first_mm = planned.passes.first().map_or(job.spec.turned_mm.0, |pass| pass.path.request().from_mm);
    PlanStart::clear_of_bar(machine, job.spec.clear_mm(insert.radius_mm), first_mm - job.spec.part_zero_mm)
}

/// Plan of a program for a turning job, beside the plan of its own passes.
fn plan_turning_program(
    job: &TurnedJob,
    machine: &MachineDescription,
    insert: &InsertDescription,
    (motion, files): (&ProgramMotion, &[ProgramFile]),
    planned: &PlannedTurning,
) -> Result<PlannedProgram, ProgramPlanError> {
    let spec = &job.spec;
    let (low_mm, high_mm) = spec.range_mm();
    // A pass begins where the insert does not touch the bar yet: its radius before the part, and some air.
    let part = ProgramLobe {
        name: &spec.name,
        z_mm: 0.5 * (low_mm + high_mm) - spec.part_zero_mm,
        width_mm: high_mm - low_mm + 2.0 * insert.radius_mm,
    };
    let request = ProgramRequest {
        name: &spec.name,
        motion,
        files,
        setup: turning_setup(job, insert),
        x_clear_mm: Some(spec.clear_mm(insert.radius_mm)),
        lobes: &[part],
    };
    plan_program(&request, machine, turning_start(job, machine, insert, planned))
}
