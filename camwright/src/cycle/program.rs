//! From a program that was read to its plan: what a control would drive, block for block, with the headstock homed before.

use super::PlanStart;
use super::error::PlanError;
use super::steps::{Of, Steps};

use crate::machine::description::{Axis, MachineDescription};
use crate::nc::{Motion, ProgramFile};
use crate::plan::{AxisTarget, Command, Phase, Plan, SegmentKind, SpiralSegment};
use crate::plan_check::{PlanCheckError, PlanReport, check_plan};
use crate::point_to_point::whole_ticks;
use crate::program_motion::{ProgramMotionError, ProgramSetup, ProgramStep, Run, program_steps};
use crate::units::TURN_RAD;
use crate::wheel::nm_from_mm;
use alloc::boxed::Box;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use thiserror::Error;

/// A program to be driven.
#[derive(Debug, Clone, Copy)]
pub struct ProgramRequest<'a> {
    /// Name of the part.
    pub name: &'a str,
    /// What the program does.
    pub motion: &'a Motion,
    /// The files that it was read from, for their names.
    pub files: &'a [ProgramFile],
    /// How it stands to the machine.
    pub setup: ProgramSetup,
}

/// Why a program cannot be driven.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ProgramPlanError {
    /// Something that it says.
    #[error(transparent)]
    Motion(#[from] ProgramMotionError),
    /// It feeds where no part can be.
    #[error(
        "{lines}: z_axis is at {z_mm} mm, where no lobe is before the wheel; the nearest, {switch}, is at {station_mm} mm"
    )]
    OffThePart {
        /// File and lines.
        lines: String,
        /// Where the table is (mm).
        z_mm: f64,
        /// The nearest station.
        switch: String,
        /// Where that is (mm).
        station_mm: f64,
    },
    /// No room for a stop on the path.
    #[error("{} leaves no room for a stop on the path", axis.joint())]
    NoStop {
        /// The axis.
        axis: Axis,
    },
    /// A step that cannot be made.
    #[error(transparent)]
    Step(Box<PlanError>),
    /// The forward check does not confirm the plan; the label of the segment says its file and lines.
    #[error(transparent)]
    Check(Box<PlanCheckError>),
}

impl From<PlanError> for ProgramPlanError {
    fn from(error: PlanError) -> Self {
        Self::Step(Box::new(error))
    }
}

/// A program planned.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedProgram {
    /// The plan.
    pub plan: Plan,
    /// Its runs of feeds, each with its segment of the plan.
    pub runs: Vec<(usize, Run)>,
    /// What the forward check found.
    pub report: PlanReport,
}

/// Plans the motion of a program for a machine whose axes stand at `start`, X clear of the part.
///
/// The wheel runs while the program says so; where it never does, all the time.
///
/// # Errors
/// The first thing that the machine does not do, with file and line; nothing has moved.
pub fn plan_program(
    request: &ProgramRequest<'_>,
    machine: &MachineDescription,
    start: PlanStart,
) -> Result<PlannedProgram, ProgramPlanError> {
    let lobes = alloc::vec![String::from(request.name)];
    let plan = Plan { job: String::from(request.name), lobes, ..Plan::default() };
    let mut steps = Steps { machine, at: start.counts, ticks: 0, plan };
    let home = Of::part(Phase::Home);
    if !machine.is_lathe() {
        let radius_nm = nm_from_mm(request.setup.cutter_radius_mm);
        steps.command(home, Command::ExpectWheel { radius_nm }, "the program's cutter");
    }
    steps.home_headstock(home, start.c_homed)?;
    let driven = program_steps(request.motion, request.files, &request.setup, machine, steps.at)?;
    let is_told = driven.iter().any(|(_, step)| matches!(step, ProgramStep::Cutter(true)));
    if !is_told {
        steps.start_wheel(home);
    }
    let mut runs = Vec::new();
    let mut cutter_runs = !is_told;
    for (done, step) in driven {
        let of = |phase: Phase| Of::lobe(phase, 0, request.name);
        match step {
            ProgramStep::Rapid(targets) => {
                let targets = targets.into_iter().map(|(axis, target_counts)| AxisTarget {
                    axis,
                    target_counts,
                    limits: machine.axis(axis).limits,
                });
                let label = format!("rapid of {}", request.lines(done, done));
                steps.move_axes(of(Phase::Position), targets.collect(), &label)?;
            }
            ProgramStep::Run(run) => {
                request.faces_a_lobe(&run, machine)?;
                runs.push((steps.plan.segments.len(), run.clone()));
                let label = format!("feeds of {}", request.lines(run.done.0, run.done.1));
                add_run(&mut steps, of(Phase::Cut), run, &label)?;
            }
            ProgramStep::Cutter(true) if !cutter_runs => {
                steps.start_wheel(home);
                cutter_runs = true;
            }
            ProgramStep::Cutter(false) if cutter_runs => {
                steps.command(home, Command::WheelStop, "wheel stop");
                cutter_runs = false;
            }
            ProgramStep::Cutter(_) => {}
            ProgramStep::Dwell(time_s) => {
                let ticks = whole_ticks(time_s, machine.cycle_time_s());
                steps.add(
                    of(Phase::Position),
                    SegmentKind::Dwell,
                    ticks,
                    0,
                    &format!("pause of {}", request.lines(done, done)),
                );
            }
        }
    }
    if cutter_runs {
        steps.command(Of::part(Phase::Return), Command::WheelStop, "wheel stop");
    }
    let mut plan = steps.done();
    plan.duration_with_indexing_s = plan.duration_s;
    let report = check_plan(&plan, machine, start.counts).map_err(|error| ProgramPlanError::Check(Box::new(error)))?;
    Ok(PlannedProgram { plan, runs, report })
}

impl ProgramRequest<'_> {
    /// Where something is written, for people.
    fn lines(&self, first: usize, last: usize) -> String {
        let place = |done: usize| self.motion.done.get(done).map_or((0, 1), |done| (done.file, done.line));
        let ((file, first), (last_file, last)) = (place(first), place(last));
        let name = self.files.get(file as usize).map_or("", |file| file.name.as_str());
        match file == last_file && last > first {
            true => format!("{name}, lines {first} to {last}"),
            false => format!("{name}, line {first}"),
        }
    }

    /// Lobes stand at stations; what feeds elsewhere would cut nothing and tell nobody.
    fn faces_a_lobe(&self, run: &Run, machine: &MachineDescription) -> Result<(), ProgramPlanError> {
        let z_mm = run.laws.advance.sample(0.0).value;
        let beside = |station_mm: f64| (station_mm - z_mm).abs();
        let nearest = machine.stations.iter().min_by(|a, b| beside(a.position_mm).total_cmp(&beside(b.position_mm)));
        match nearest {
            Some(station) if beside(station.position_mm) > 0.5 * machine.wheel.width_mm => {
                Err(ProgramPlanError::OffThePart {
                    lines: self.lines(run.done.0, run.done.1),
                    z_mm,
                    switch: station.switch.clone(),
                    station_mm: station.position_mm,
                })
            }
            _ => Ok(()),
        }
    }
}

/// A run as a spiral.
fn add_run(steps: &mut Steps<'_>, of: Of<'_>, run: Run, label: &str) -> Result<(), ProgramPlanError> {
    let stop_ticks = steps.stop_ticks().map_err(|axis| ProgramPlanError::NoStop { axis })?;
    let ticks = whole_ticks(run.laws.duration_s(), steps.machine.cycle_time_s());
    let turn_counts = steps.counts(Axis::C, TURN_RAD);
    let spiral = SpiralSegment {
        path: steps.plan.angle_laws.len(),
        advance: steps.plan.angle_laws.len() + 1,
        speed: steps.plan.time_laws.len(),
        start_counts: run.start_counts.rem_euclid(turn_counts),
    };
    steps.plan.time_laws.push(run.laws.speed);
    steps.plan.angle_laws.push(run.laws.path);
    steps.plan.angle_laws.push(run.laws.advance);
    steps.add(of, SegmentKind::Spiral(spiral), ticks, stop_ticks, label);
    steps.at = run.end_counts;
    Ok(())
}
