// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Required drives of a lathe: the form error of the present drives axis by axis, and the position loop gain of X that keeps a tolerance.
//!
//! The same plan is executed on the same machine with other drives, and the part is compared, cell by cell, with its design and with what
//! drives without any error turn. So the cusps of the feed, and hollows that the insert does not reach, do not count as theirs.

mod flaw;
mod gain;

pub use flaw::{AxisFlaw, DriveFlaw, FlawAxes, FlawEffect};
pub use gain::{FeedForward, GainSearch, GainTrial, MinimumGain};

use crate::interpolator::{Motion, MotionOutcome, PrepareError, Prepared};
use crate::job::turning::TurningJob;
use crate::machine::description::{Axis, DescriptionError, Effect, MachineDescription};
use crate::machine::persistent_state::PersistentState;
use crate::motion::plan::Plan;
use crate::simulation::Machine;
use crate::simulation::closed_loop::{ClosedLoop, Simulated, SimulationError};
use crate::simulation::turned_part::{FormMap, FormMapError, FormPoint, PartGrid, TurnedPart, TurnedPartError};
use crate::toolpath::insert_path::{InsertFeed, cusp_mm};
use alloc::boxed::Box;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::fmt;
use thiserror::Error;

/// Why nothing can be said about a job's drives.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TurningDrivesError {
    #[error("the machine grinds with a wheel; the drives of a turned part need a lathe")]
    NotALathe,
    /// A number out of its range.
    #[error("{what} is {value}, it must be {allowed}")]
    OutOfRange { what: &'static str, value: f64, allowed: String },
    /// The drives of a case make no machine.
    #[error(transparent)]
    Description(#[from] DescriptionError),
    /// No part of this grid.
    #[error(transparent)]
    Part(#[from] TurnedPartError),
    /// The plan is not for this machine.
    #[error(transparent)]
    Motion(#[from] PrepareError),
    /// The part was not turned to its end.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The same, without an alarm.
    #[error("the motion ended as {0:?}")]
    Ended(MotionOutcome),
    /// It cannot be compared with its design.
    #[error(transparent)]
    Form(#[from] FormMapError),
}

/// Form error of a set of drives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrivesForm {
    /// Most material above the design, cusps and all.
    pub highest: FormPoint,
    /// Position of the lowest or least excess form error.
    pub lowest: FormPoint,
    /// Form error beyond that of ideal drives (mm): above the cusp of the feed and the error of ideal drives in that cell, or below the
    /// design and their cut there.
    pub beyond_mm: f64,
}

/// Which drives a part is turned with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drives {
    Ideal,
    Own,
    /// The good drive of one axis, the machine's own of the others.
    GoodOn(Axis),
    /// The good drives of all axes that have one.
    Good,
}

impl Drives {
    pub const ALL: [Drives; 6] = [
        Drives::Ideal,
        Drives::Own,
        Drives::GoodOn(Axis::X),
        Drives::GoodOn(Axis::C),
        Drives::GoodOn(Axis::Z),
        Drives::Good,
    ];

    /// A machine with these drives; `None` where it has no good ones of that kind.
    #[must_use]
    pub fn on(self, machine: &MachineDescription) -> Option<MachineDescription> {
        match self {
            Drives::Ideal => Some(machine.clone().without(Effect::Servo)),
            Drives::Own => Some(machine.clone()),
            Drives::GoodOn(axis) => machine.clone().with_good_drive(axis),
            Drives::Good => machine.clone().with_good_drives(),
        }
    }
}

impl fmt::Display for Drives {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Drives::Ideal => write!(f, "ideal drives"),
            Drives::Own => write!(f, "the machine's drives"),
            Drives::GoodOn(axis) => write!(f, "a good drive of {}", axis.joint()),
            Drives::Good => write!(f, "good drives"),
        }
    }
}

/// Intermediate result for progress reports.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DrivesResult {
    Drives(Drives, DrivesForm),
    /// Result for a gain of X.
    Gain(GainTrial),
    Flaw(FlawEffect),
}

/// A job, its plan and its machine, to be turned with other drives.
#[derive(Debug, Clone)]
pub struct TurningDrives<'a> {
    job: &'a TurningJob,
    machine: &'a MachineDescription,
    plan: Arc<Plan>,
    grid: PartGrid,
    cusp_mm: f64,
    /// Deviations of the part that drives without error turn (mm).
    ideal: FormMap,
}

impl<'a> TurningDrives<'a> {
    /// Turns the job with ideal drives, on a part with this grid.
    ///
    /// # Errors
    /// A machine that grinds, a plan that is not for it, a grid that is none.
    pub fn new(
        job: &'a TurningJob,
        plan: &Plan,
        machine: &'a MachineDescription,
        grid: PartGrid,
    ) -> Result<Self, TurningDrivesError> {
        let insert = machine.insert.ok_or(TurningDrivesError::NotALathe)?;
        let (InsertFeed::AlongZ(feed_mm) | InsertFeed::AlongCurve(feed_mm)) = job.feed;
        let plan = Arc::new(plan.clone());
        let ideal = machine.clone().without(Effect::Servo);
        let ideal = map(job, &plan, &ideal, grid)?;
        Ok(Self { job, machine, plan, grid, cusp_mm: cusp_mm(insert.radius_mm, feed_mm), ideal })
    }

    /// Height of the cusps that the feed leaves where the section does not curve (mm).
    #[must_use]
    pub fn cusp_mm(&self) -> f64 {
        self.cusp_mm
    }

    /// The machine that it was made for.
    #[must_use]
    pub fn machine(&self) -> &MachineDescription {
        self.machine
    }

    /// Form error of a machine that differs only in its drives.
    ///
    /// # Errors
    /// Drives that make no machine, or do not turn the part to its end.
    pub fn form(&self, machine: &MachineDescription) -> Result<DrivesForm, TurningDrivesError> {
        let map = map(self.job, &self.plan, machine, self.grid)?;
        Ok(self.compared(&map))
    }

    fn compared(&self, map: &FormMap) -> DrivesForm {
        let beyond = |(off_mm, ideal_mm): (&f64, &f64)| {
            let above = off_mm - ideal_mm.max(self.cusp_mm);
            above.max(ideal_mm.min(0.0) - off_mm)
        };
        let cells = map.deviations_mm().iter().zip(self.ideal.deviations_mm());
        let beyond_mm = cells.map(beyond).fold(0.0, f64::max);
        DrivesForm { highest: map.highest(), lowest: map.lowest(), beyond_mm }
    }

    /// Compares ideal drives, the machine's own, and its good drives on single axes and on all; drives that the machine file lacks are
    /// skipped.
    ///
    /// # Errors
    /// See [`Self::form`].
    pub fn compare(
        &self,
        mut report: impl FnMut(&DrivesResult),
    ) -> Result<Vec<(Drives, DrivesForm)>, TurningDrivesError> {
        let mut found = Vec::new();
        for drives in Drives::ALL {
            let Some(machine) = drives.on(self.machine) else { continue };
            let form = if drives == Drives::Ideal { self.compared(&self.ideal) } else { self.form(&machine)? };
            report(&DrivesResult::Drives(drives, form));
            found.push((drives, form));
        }
        Ok(found)
    }
}

/// The part that a lathe turns by a plan, from a bar on this grid.
///
/// # Errors
/// A machine that grinds, a plan that is not for it, a grid that is none, a part that was not turned to its end.
pub fn turn(
    job: &TurningJob,
    plan: &Arc<Plan>,
    description: &MachineDescription,
    grid: PartGrid,
) -> Result<(Simulated, TurnedPart), TurningDrivesError> {
    let mut machine = Machine::new(description.clone(), PersistentState::new(description))?;
    machine.load_turned_part(TurnedPart::round(job.name.clone(), grid, job.bar_radius_mm)?, job.part_zero_mm)?;
    let motion = Prepared::new(Motion::Plan(plan.clone()), description)?;
    let mut closed_loop = ClosedLoop::direct(machine);
    let simulated = closed_loop.simulate(Box::new(motion), |_, _| {})?;
    if simulated.outcome != MotionOutcome::Completed {
        return Err(TurningDrivesError::Ended(simulated.outcome));
    }
    let part = closed_loop.machine().turned_part().ok_or(TurningDrivesError::NotALathe)?.clone();
    Ok((simulated, part))
}

/// Form error of a part against the design of its job, over the turned length.
///
/// # Errors
/// A part that has nothing there.
pub fn form_of(job: &TurningJob, part: &TurnedPart) -> Result<FormMap, FormMapError> {
    let (from_mm, to_mm) = job.range_mm();
    FormMap::new(part, |azimuth_rad, z_mm| job.surface.point(azimuth_rad, z_mm), from_mm, to_mm)
}

/// The form of the part that a machine turns.
fn map(
    job: &TurningJob,
    plan: &Arc<Plan>,
    description: &MachineDescription,
    grid: PartGrid,
) -> Result<FormMap, TurningDrivesError> {
    Ok(form_of(job, &turn(job, plan, description, grid)?.1)?)
}
