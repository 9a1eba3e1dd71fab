// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! From a program that was read to its plan: what a control would drive, block for block, with the headstock homed before.

use super::PlanStart;
use super::error::PlanError;
use super::steps::{PlanSteps, StepSubject};

use crate::gcode::{ProgramFile, ProgramMotion};
use crate::machine::description::{Axis, MachineDescription};
use crate::machine::wheel_state::nm_from_mm;
use crate::math::units::TURN_RAD;
use crate::motion::plan::{AxisTarget, Phase, Plan, PlanCommand, SegmentKind, SpiralSegment};
use crate::motion::point_to_point::whole_ticks;
use crate::planner::plan_check::{PlanCheckError, PlanReport, check_plan};
use crate::planner::program_motion::{ProgramMotionError, ProgramSetup, ProgramStep, Run, program_steps};
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
    /// Motion of the program.
    pub motion: &'a ProgramMotion,
    /// The files that it was read from, for their names.
    pub files: &'a [ProgramFile],
    /// Setup of the program on the machine.
    pub setup: ProgramSetup,
    /// X of a lathe clear of the bar (mm), where it moves before the headstock turns. `None`: X is clear at the start.
    pub x_clear_mm: Option<f64>,
    /// Lobes of the part in report order; empty if it does not matter which one is ground.
    pub lobes: &'a [ProgramLobe<'a>],
}

/// A lobe that a program may grind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProgramLobe<'a> {
    pub name: &'a str,
    /// Position of `z_axis` with the lobe's middle before the wheel (mm).
    pub z_mm: f64,
    /// Its width (mm).
    pub width_mm: f64,
}

/// Why a program cannot be driven.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ProgramPlanError {
    /// Something that it says.
    #[error(transparent)]
    Motion(#[from] ProgramMotionError),
    /// It feeds where no lobe is.
    #[error(
        "{lines}: z_axis is at {z_mm} mm, where no lobe is before the wheel; the nearest, {lobe}, is at {lobe_mm} mm"
    )]
    OffThePart {
        lines: String,
        /// Position of the table (mm).
        z_mm: f64,
        lobe: String,
        /// Position of that lobe (mm).
        lobe_mm: f64,
    },
    /// No room for a stop on the path.
    #[error("{} leaves no room for a stop on the path", axis.joint())]
    NoStop { axis: Axis },
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

#[derive(Debug, Clone, PartialEq)]
pub struct PlannedProgram {
    pub plan: Plan,
    /// Its runs of feeds, each with its segment of the plan.
    pub runs: Vec<(usize, Run)>,
    /// Result of the forward check.
    pub report: PlanReport,
}

/// Plans the motion of a program for a machine whose axes stand at `start`, X clear of the part.
///
/// The wheel runs while the program says so; where it never does, all the time. A clamped insert never does.
///
/// # Errors
/// The first thing that the machine does not do, with file and line; nothing has moved.
pub fn plan_program(
    request: &ProgramRequest<'_>,
    machine: &MachineDescription,
    start: PlanStart,
) -> Result<PlannedProgram, ProgramPlanError> {
    let lobes = request.lobes.iter().map(|lobe| String::from(lobe.name)).collect();
    let plan = Plan { job: String::from(request.name), lobes, ..Plan::default() };
    let mut steps = PlanSteps { machine, at: start.counts, ticks: 0, plan };
    let home = StepSubject::part(Phase::Home);
    if !machine.is_lathe() {
        let radius_nm = nm_from_mm(request.setup.cutter_radius_mm);
        steps.command(home, PlanCommand::ExpectWheel { radius_nm }, "the program's cutter");
    }
    if let Some(x_clear_mm) = request.x_clear_mm {
        steps.move_axis(home, Axis::X, steps.counts(Axis::X, x_clear_mm), None, "insert clear of the bar")?;
    }
    steps.home_headstock(home, start.c_homed)?;
    let driven = program_steps(request.motion, request.files, &request.setup, machine, steps.at)?;
    let is_commanded = driven.iter().any(|(_, step)| matches!(step, ProgramStep::Cutter(true)));
    if !is_commanded {
        steps.start_wheel(home);
    }
    let mut runs = Vec::new();
    let mut cutter_runs = !is_commanded && !machine.cuts_at_rest();
    let faced = request.faced(&driven, machine)?;
    for ((done, step), lobe) in driven.into_iter().zip(faced) {
        let of = |phase: Phase| match lobe.and_then(|index| Some((index, request.lobes.get(index)?))) {
            Some((index, lobe)) => StepSubject::lobe(phase, index, lobe.name),
            None => StepSubject::part(phase),
        };
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
                runs.push((steps.plan.segments.len(), run.clone()));
                let label = format!("feeds of {}", request.lines(run.done.0, run.done.1));
                add_run(&mut steps, of(Phase::Cut), run, &label)?;
            }
            ProgramStep::Cutter(true) if !cutter_runs => {
                steps.start_wheel(home);
                cutter_runs = true;
            }
            ProgramStep::Cutter(false) if cutter_runs => {
                steps.command(home, PlanCommand::WheelStop, "wheel stop");
                cutter_runs = false;
            }
            ProgramStep::Cutter(_) => {}
            ProgramStep::Dwell(time_s) => {
                let ticks = whole_ticks(time_s, machine.cycle_time_s());
                let label = format!("pause of {}", request.lines(done, done));
                steps.add(of(Phase::Position), SegmentKind::Dwell, ticks, 0, &label);
            }
        }
    }
    if cutter_runs {
        steps.command(StepSubject::part(Phase::Return), PlanCommand::WheelStop, "wheel stop");
    }
    let mut plan = steps.done();
    plan.duration_with_indexing_s = plan.duration_s;
    let report = check_plan(&plan, machine, start.counts).map_err(|error| ProgramPlanError::Check(Box::new(error)))?;
    Ok(PlannedProgram { plan, runs, report })
}

impl ProgramRequest<'_> {
    /// Position in the program, for the operator.
    fn lines(&self, first: usize, last: usize) -> String {
        let place = |done: usize| self.motion.done.get(done).map_or((0, 1), |done| (done.file, done.line));
        let ((file, first), (last_file, last)) = (place(first), place(last));
        let name = self.files.get(file as usize).map_or("", |file| file.name.as_str());
        match file == last_file && last > first {
            true => format!("{name}, lines {first} to {last}"),
            false => format!("{name}, line {first}"),
        }
    }

    /// The lobe of every step: that which the wheel is before when it feeds next.
    fn faced(
        &self,
        steps: &[(usize, ProgramStep)],
        machine: &MachineDescription,
    ) -> Result<Vec<Option<usize>>, ProgramPlanError> {
        let mut faced = alloc::vec![None; steps.len()];
        let mut next = None;
        for (index, (_, step)) in steps.iter().enumerate().rev() {
            if let ProgramStep::Run(run) = step {
                next = self.lobe_before(run, machine)?;
            }
            faced[index] = next;
        }
        Ok(faced)
    }

    /// Finds the lobe before the wheel; feeds elsewhere would cut nothing unnoticed.
    fn lobe_before(&self, run: &Run, machine: &MachineDescription) -> Result<Option<usize>, ProgramPlanError> {
        let z_mm = run.laws.advance.sample(0.0).value;
        let beside = |lobe: &ProgramLobe<'_>| (lobe.z_mm - z_mm).abs();
        let nearest = self.lobes.iter().enumerate().min_by(|(_, a), (_, b)| beside(a).total_cmp(&beside(b)));
        match nearest {
            Some((_, lobe)) if beside(lobe) >= 0.5 * (lobe.width_mm + machine.wheel.width_mm) => {
                Err(ProgramPlanError::OffThePart {
                    lines: self.lines(run.done.0, run.done.1),
                    z_mm,
                    lobe: String::from(lobe.name),
                    lobe_mm: lobe.z_mm,
                })
            }
            nearest => Ok(nearest.map(|(index, _)| index)),
        }
    }
}

/// A run as a spiral.
fn add_run(steps: &mut PlanSteps<'_>, of: StepSubject<'_>, run: Run, label: &str) -> Result<(), ProgramPlanError> {
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
