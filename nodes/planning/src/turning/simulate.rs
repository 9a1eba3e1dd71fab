// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A prepared turning job run through interpolator and machine without ROS, and the form of what was turned.

use super::prepared::PreparedTurning;
use crate::SimulationFailed;
use camwright::machine::description::{Effect, MachineDescription};
use camwright::simulation::closed_loop::Simulated;
use camwright::simulation::lathe_drives::{TurningDrivesError, form_of, turn};
use camwright::simulation::turned_part::{FormMap, FormMapError, TurnedPart};
use camwright_files::convert::plan::plan_from_pages;
use std::sync::Arc;

/// Runs a job on its machine without these effects; the part as it was turned.
///
/// # Errors
/// A motion that does not come to its end.
pub fn simulate_turned(
    prepared: &PreparedTurning,
    without: &[Effect],
) -> Result<(Simulated, TurnedPart), SimulationFailed> {
    let own = prepared.machine.clone();
    simulate_turned_on(prepared, &without.iter().fold(own, |machine, effect| machine.without(*effect)))
}

/// Runs a job on a machine that differs from its own in nothing that its plan was made for.
///
/// # Errors
/// A motion that does not come to its end.
pub fn simulate_turned_on(
    prepared: &PreparedTurning,
    description: &MachineDescription,
) -> Result<(Simulated, TurnedPart), SimulationFailed> {
    let (spec, grid) = (&prepared.job.spec, prepared.job.grid);
    let failed = |reason: String| SimulationFailed::new(&spec.name, &reason);
    // The plan as a receiver of its pages has it: the way through metres is part of it.
    let (plan, _) = plan_from_pages(&prepared.pages, description).map_err(|error| failed(error.to_string()))?;
    turn(spec, &Arc::new(plan), description, grid).map_err(|error| match &error {
        TurningDrivesError::Simulation(stopped) => SimulationFailed::stopped(&spec.name, stopped),
        other => failed(other.to_string()),
    })
}

/// Form error of a part against its job, over the turned length.
///
/// # Errors
/// A part that is not on the job's grid.
pub fn turned_form(prepared: &PreparedTurning, part: &TurnedPart) -> Result<FormMap, FormMapError> {
    form_of(&prepared.job.spec, part)
}
