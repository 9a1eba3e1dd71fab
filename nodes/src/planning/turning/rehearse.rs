//! A prepared turning job run through interpolator and machine without ROS, and the form of what was turned.

use super::PreparedTurning;
use crate::convert::plan::plan_from_pages;
use crate::planning::RehearsalFailed;
use camwright::interpolator::{Interpolator, Motion, Prepared};
use camwright::machine::Machine;
use camwright::machine::description::{Effect, MachineDescription};
use camwright::machine::state::LastingState;
use camwright::machine::turned_part::{FormMap, FormMapError, TurnedPart, TurnedPartError};
use camwright::rehearsal::{Rehearsed, rehearse};
use std::sync::Arc;

/// The bar that a job begins with.
///
/// # Errors
/// None for a job that could be planned: its grid was checked and its bar has a radius.
pub fn raw_bar(prepared: &PreparedTurning) -> Result<TurnedPart, TurnedPartError> {
    let spec = &prepared.job.spec;
    TurnedPart::round(spec.name.clone(), prepared.job.grid, spec.bar_radius_mm)
}

/// Runs a job on its machine without these effects; the part as it was turned.
///
/// # Errors
/// A motion that does not come to its end.
pub fn rehearse_turned(
    prepared: &PreparedTurning,
    without: &[Effect],
) -> Result<(Rehearsed, TurnedPart), RehearsalFailed> {
    let own = prepared.machine.clone();
    rehearse_turned_on(prepared, &without.iter().fold(own, |machine, effect| machine.without(*effect)))
}

/// Runs a job on a machine that differs from its own in nothing that its plan was made for.
///
/// # Errors
/// A motion that does not come to its end.
pub fn rehearse_turned_on(
    prepared: &PreparedTurning,
    description: &MachineDescription,
) -> Result<(Rehearsed, TurnedPart), RehearsalFailed> {
    let failed = |reason: String| RehearsalFailed { job: prepared.job.spec.name.clone(), reason };
    let mut machine =
        Machine::new(description.clone(), LastingState::new(description)).map_err(|error| failed(error.to_string()))?;
    let bar = raw_bar(prepared).map_err(|error| failed(error.to_string()))?;
    machine.load_turned_part(bar, prepared.job.spec.part_zero_mm).map_err(|error| failed(error.to_string()))?;
    // The plan as a receiver of its pages has it: the way through metres is part of it.
    let (plan, _) = plan_from_pages(&prepared.pages, description).map_err(|error| failed(error.to_string()))?;
    let motion = Prepared::new(Motion::Plan(Arc::new(plan)), description).map_err(|error| failed(error.to_string()))?;
    let mut interpolator = Interpolator::new(description);
    let rehearsed = rehearse(Box::new(motion), &mut interpolator, &mut machine, |_, _| {})
        .map_err(|error| failed(error.to_string()))?;
    match machine.turned_part() {
        Some(part) => Ok((rehearsed, part.clone())),
        None => Err(failed("the machine has no part".to_owned())),
    }
}

/// How far a part is off what a job turns, over the length that it turns.
///
/// # Errors
/// A part that is not on the job's grid.
pub fn turned_form(prepared: &PreparedTurning, part: &TurnedPart) -> Result<FormMap, FormMapError> {
    let spec = &prepared.job.spec;
    let (from_mm, to_mm) = spec.turned_mm;
    FormMap::new(
        part,
        |azimuth_rad, z_mm| spec.surface.point(azimuth_rad, z_mm),
        from_mm.min(to_mm),
        from_mm.max(to_mm),
    )
}
