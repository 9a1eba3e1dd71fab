//! A job that is ground by an NC program: the program's motion in the place of its own cuts.

use super::program::refuse_what_needs_the_machine;
use camwright::machine::description::MachineDescription;
use camwright::planner::program_motion::ProgramSetup;
use camwright::planner::{PlanStart, PlannedJob, ProgramLobe, ProgramRequest, plan_program};
use camwright_files::ConfigError;
use camwright_files::job_file::Job;
use camwright_files::program_file::JobProgram;

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
            let z_mm = machine.station(&lobe.station)?.position_mm;
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
    let request = ProgramRequest { name: &job.spec.name, motion, files, setup, lobes: &lobes };
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
