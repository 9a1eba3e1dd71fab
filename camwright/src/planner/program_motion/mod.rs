// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The motion of a program as a plain control drives it on a machine with C, X and Z.
//!
//! ```text
//! what was read ─► rapids, orders, pauses                     one after the other, from rest to rest
//!               └► feeds between them ─► broken lines ─► run  C over time, X and Z over C, from rest to rest
//! ```
//!
//! A control that interpolates in straight lines does not follow a corner exactly: the acceleration and jerk limits behind its interpolation
//! average the commanded values. Here X and Z are averaged twice over an angle of C. A step of the slope becomes a pair of parabolic arcs with
//! bounded acceleration and jerk. The window is as small as the axes allow, and no wider than the program's path tolerance allows. The speed of
//! C is averaged in time the same way, including start and end. A run therefore takes two ramps longer than its blocks say, and the relation of
//! X and Z to C does not depend on it.
//!
//! [`ProgramSetup`] alone relates a program to the machine (rotation sense, zeros, counts).

mod error;
mod rounded;
mod run;
mod uses;

pub use error::{ProgramMotionError, ProgramMotionFault};
pub use run::RunLaws;

use crate::gcode::{Direction, Done, MotionAction, NcAxis, ProgramFile, ProgramMotion, ProgramPose};
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use alloc::string::String;
use alloc::vec::Vec;
use run::FeedBlock;

/// Farthest place of an axis (mm or rad): beyond it counts do not fit into their numbers.
const FARTHEST: f64 = 1e6;

/// Relation of a program to the machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProgramSetup {
    /// Radius of the cutter (mm).
    pub cutter_radius_mm: f64,
    /// The program's X is the distance of the cutting point; else that of the cutter's centre. `x_axis` is the cutting point on a grinder
    /// and the insert's centre on a lathe.
    pub x_of_edge: bool,
    /// `z_axis` where the program's Z is 0 (mm).
    pub z_zero_mm: f64,
    /// Rotation sense of the machine that the program was made for.
    pub rotation_sense: i8,
    /// Path tolerance where the program sets none (mm): a parameter of the control.
    pub path_tolerance_mm: f64,
}

/// Feeds between two rapids.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Motion laws.
    pub laws: RunLaws,
    /// Start of C (counts).
    pub start_counts: i64,
    /// Position of the axes at the end (counts).
    pub end_counts: [i64; AXIS_COUNT],
    pub blocks: usize,
    /// Tolerance for rounding its corners (mm).
    pub tolerance_mm: f64,
    /// First and last action of the program in it, by index into [`ProgramMotion::done`].
    pub done: (usize, usize),
}

/// A step of a program.
#[derive(Debug, Clone, PartialEq)]
pub enum ProgramStep {
    /// All axes to their targets (counts), as fast as they can.
    Rapid(Vec<(Axis, i64)>),
    /// A run of feeds.
    Run(Run),
    /// The cutter turns, or stops.
    Cutter(bool),
    /// A pause (s).
    Dwell(f64),
}

/// The steps of a program on a machine whose axes stand at `start` (counts), with the place of each among [`ProgramMotion::done`]. `files` are those
/// that were read, for their names.
///
/// # Errors
/// The first thing that the machine does not do, with file and line.
pub fn program_steps(
    motion: &ProgramMotion,
    files: &[ProgramFile],
    setup: &ProgramSetup,
    machine: &MachineDescription,
    start: [i64; AXIS_COUNT],
) -> Result<Vec<(usize, ProgramStep)>, ProgramMotionError> {
    walk_program(motion, files, setup, machine, start, None).map(|walk| walk.steps)
}

/// Largest share of its programmed speed at which the machine drives each run of feeds of a program, 0 to 1: corners are rounded as the path
/// tolerance allows, and every axis keeps its limits.
///
/// # Errors
/// As [`program_steps`], but for limits that a slower run keeps.
pub fn drivable_shares(
    motion: &ProgramMotion,
    files: &[ProgramFile],
    setup: &ProgramSetup,
    machine: &MachineDescription,
    start: [i64; AXIS_COUNT],
) -> Result<Vec<f64>, ProgramMotionError> {
    walk_program(motion, files, setup, machine, start, Some(Vec::new())).map(|walk| walk.shares.unwrap_or_default())
}

/// Walks through a program; with `shares` runs are slowed down where an axis would exceed a limit, and their shares are added.
fn walk_program<'a>(
    motion: &ProgramMotion,
    files: &[ProgramFile],
    setup: &'a ProgramSetup,
    machine: &'a MachineDescription,
    start: [i64; AXIS_COUNT],
    shares: Option<Vec<f64>>,
) -> Result<ProgramWalk<'a>, ProgramMotionError> {
    let at_line = |(done, fault): (usize, ProgramMotionFault)| {
        let place = motion.done.get(done).copied();
        let file = place.and_then(|done| files.get(done.file as usize)).map_or(String::new(), |file| file.name.clone());
        ProgramMotionError { file, line: place.map_or(1, |done| done.line), fault }
    };
    setup.check(machine).map_err(|fault| at_line((0, fault)))?;
    let mut walk = ProgramWalk {
        setup,
        machine,
        at: start,
        feeds: Vec::new(),
        from: [0.0; AXIS_COUNT],
        tolerance_mm: setup.path_tolerance_mm,
        run_tolerance_mm: setup.path_tolerance_mm,
        tool: None,
        is_known: [true, true, !machine.is_lathe()],
        shares,
        steps: Vec::new(),
    };
    for (index, done) in motion.done.iter().enumerate() {
        walk.check_move(index, done).map_err(at_line)?;
    }
    walk.end_run().map_err(at_line)?;
    if !walk.steps.iter().any(|(_, step)| matches!(step, ProgramStep::Run(_))) {
        return Err(at_line((motion.done.len().saturating_sub(1), ProgramMotionFault::NoFeed)));
    }
    Ok(walk)
}

impl ProgramSetup {
    fn check(&self, machine: &MachineDescription) -> Result<(), ProgramMotionFault> {
        let length = |value: f64| value > 0.0 && value <= FARTHEST;
        for (what, value, is_right, allowed) in [
            (
                "the cutter's radius (mm)",
                self.cutter_radius_mm,
                length(self.cutter_radius_mm),
                "above 0 and up to a kilometre",
            ),
            (
                "the position of the program's Z 0 (mm)",
                self.z_zero_mm,
                self.z_zero_mm.abs() <= FARTHEST,
                "within a kilometre",
            ),
            (
                "the control's path tolerance (mm)",
                self.path_tolerance_mm,
                length(self.path_tolerance_mm),
                "above 0 and up to a kilometre",
            ),
        ] {
            if !is_right {
                return Err(ProgramMotionFault::OutOfRange { what, value, allowed });
            }
        }
        if self.rotation_sense != machine.rotation_sense {
            let (program, machine) = (self.rotation_sense, machine.rotation_sense);
            return Err(ProgramMotionFault::OtherSense { program, machine });
        }
        Ok(())
    }

    /// Position of the machine's axis (mm or rad) for a pose of the program; `None` if the program has not set it.
    fn position(&self, axis: Axis, pose: &ProgramPose, machine: &MachineDescription) -> Option<f64> {
        match axis {
            Axis::C => pose.position(NcAxis::C),
            Axis::X if machine.is_lathe() == self.x_of_edge => {
                let to_axis_mm = if self.x_of_edge { self.cutter_radius_mm } else { -self.cutter_radius_mm };
                pose.position(NcAxis::X).map(|x_mm| x_mm + to_axis_mm)
            }
            Axis::X => pose.position(NcAxis::X),
            Axis::Z => pose.position(NcAxis::Z).map(|z_mm| z_mm + self.z_zero_mm),
        }
    }
}

/// A program that is being walked through.
struct ProgramWalk<'a> {
    setup: &'a ProgramSetup,
    machine: &'a MachineDescription,
    /// Position of the axes at rest (counts), before the current feeds.
    at: [i64; AXIS_COUNT],
    /// Feeds since then, and where they began (rad, mm).
    feeds: Vec<FeedBlock>,
    from: [f64; AXIS_COUNT],
    /// The tolerance in force, and the least of those feeds (mm).
    tolerance_mm: f64,
    run_tolerance_mm: f64,
    tool: Option<u32>,
    /// True for an axis that is known to stand at its start; a lathe leaves Z where its last part ended.
    is_known: [bool; AXIS_COUNT],
    /// Shares of the programmed speed of the runs so far, where they may be slowed down.
    shares: Option<Vec<f64>>,
    steps: Vec<(usize, ProgramStep)>,
}

type LocatedFault = (usize, ProgramMotionFault);

impl ProgramWalk<'_> {
    fn check_move(&mut self, index: usize, done: &Done) -> Result<(), LocatedFault> {
        match done.action {
            MotionAction::Rapid(pose) => {
                self.end_run()?;
                self.rapid(index, &pose).map_err(|fault| (index, fault))
            }
            MotionAction::Feed { pose, time_s } => {
                if self.feeds.is_empty() {
                    self.from = Axis::ALL.map(|axis| self.machine.axis(axis).scale.position(self.at[axis.index()]));
                    self.run_tolerance_mm = self.tolerance_mm;
                }
                let before = self.feeds.last().map_or(self.from, |feed| feed.to);
                let to = self.targets(&pose).map_err(|fault| (index, fault))?;
                let to = Axis::ALL.map(|axis| to[axis.index()].unwrap_or(before[axis.index()]));
                self.feeds.push(FeedBlock { to, time_s, done: index });
                Ok(())
            }
            MotionAction::Dwell(time_s) => self.order(index, ProgramStep::Dwell(time_s)),
            MotionAction::SpindleOn { direction, .. } => {
                self.check_spindle(direction).map_err(|fault| (index, fault))?;
                self.order(index, ProgramStep::Cutter(true))
            }
            MotionAction::SpindleOff => self.order(index, ProgramStep::Cutter(false)),
            MotionAction::ToolChange(wanted) => {
                self.end_run()?;
                match self.tool.replace(wanted) {
                    Some(mounted) if mounted != wanted => {
                        Err((index, ProgramMotionFault::OtherTool { wanted, mounted }))
                    }
                    _ => Ok(()),
                }
            }
            MotionAction::PathTolerance(tolerance_mm) => {
                self.tolerance_mm = tolerance_mm.unwrap_or(self.setup.path_tolerance_mm);
                self.run_tolerance_mm = self.run_tolerance_mm.min(self.tolerance_mm);
                Ok(())
            }
            MotionAction::Coolant(_) => Ok(()),
        }
    }

    /// Refuses a spindle that a lathe's insert does not have, or one that turns it the other way.
    fn check_spindle(&self, program: Direction) -> Result<(), ProgramMotionFault> {
        let Some(insert) = &self.machine.insert else { return Ok(()) };
        let machine = insert.spindle.ok_or(ProgramMotionFault::NoSpindle)?.rotation.into();
        if program == machine { Ok(()) } else { Err(ProgramMotionFault::SpindleDirection { program, machine }) }
    }

    fn order(&mut self, index: usize, step: ProgramStep) -> Result<(), LocatedFault> {
        self.end_run()?;
        self.steps.push((index, step));
        Ok(())
    }

    /// Targets of the axes that the program has named (rad, mm).
    fn targets(&self, pose: &ProgramPose) -> Result<[Option<f64>; AXIS_COUNT], ProgramMotionFault> {
        if let Some(position_mm) = pose.position(NcAxis::Y) {
            return Err(ProgramMotionFault::NoY { position_mm });
        }
        let mut targets = [None; AXIS_COUNT];
        for axis in Axis::ALL {
            let target = self.setup.position(axis, pose, self.machine);
            let too_far = |position: &f64| position.abs() > FARTHEST || position.is_nan();
            if let Some(position) = target.filter(too_far) {
                return Err(ProgramMotionFault::TooFar { axis, position });
            }
            targets[axis.index()] = target;
        }
        Ok(targets)
    }

    fn rapid(&mut self, index: usize, pose: &ProgramPose) -> Result<(), ProgramMotionFault> {
        let mut moves = Vec::new();
        for (axis, target) in Axis::ALL.into_iter().zip(self.targets(pose)?) {
            let Some(counts) = target.map(|position| self.machine.axis(axis).scale.counts(position)) else { continue };
            let is_known = core::mem::replace(&mut self.is_known[axis.index()], true);
            if counts != self.at[axis.index()] || !is_known {
                moves.push((axis, counts));
                self.at[axis.index()] = counts;
            }
        }
        if !moves.is_empty() {
            self.steps.push((index, ProgramStep::Rapid(moves)));
        }
        Ok(())
    }

    /// Ends the current run of feeds.
    fn end_run(&mut self) -> Result<(), LocatedFault> {
        let mut feeds = core::mem::take(&mut self.feeds);
        let (Some(first), Some(last)) = (feeds.first(), feeds.last()) else { return Ok(()) };
        let done = (first.done, last.done);
        let laws = match &mut self.shares {
            None => RunLaws::new(self.from, &feeds, self.run_tolerance_mm, self.machine)?,
            Some(shares) => {
                let (laws, share) = RunLaws::slowed(self.from, &mut feeds, self.run_tolerance_mm, self.machine)?;
                shares.push(share);
                laws
            }
        };
        let start_counts = self.at[Axis::C.index()];
        let angle_rad = laws.angle_rad();
        let counts = |axis: Axis, end: f64| self.machine.axis(axis).scale.counts(end);
        self.at = [
            start_counts + counts(Axis::C, angle_rad),
            counts(Axis::X, laws.path.sample(angle_rad).value),
            counts(Axis::Z, laws.advance.sample(angle_rad).value),
        ];
        let (blocks, tolerance_mm) = (feeds.len(), self.run_tolerance_mm);
        let run = Run { laws, start_counts, end_counts: self.at, blocks, tolerance_mm, done };
        self.steps.push((done.0, ProgramStep::Run(run)));
        Ok(())
    }
}
