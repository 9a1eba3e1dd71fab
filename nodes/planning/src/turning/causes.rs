// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Causes of the form error of a turned part: the same job simulated on machines without some effects, or with better drives.

use super::super::causes::{beside_each_other, left_out};
use super::prepared::PreparedTurning;
use super::simulate::{simulate_turned_on, turned_form};
use crate::SimulationFailed;
use camwright::machine::description::MachineDescription;

/// Form error of a job on a different machine.
#[derive(Debug, Clone, PartialEq)]
pub struct OtherLathe {
    /// Difference: "without servo", "with good drives".
    pub name: String,
    /// Most material above the design, along its normal (mm).
    pub highest_mm: f64,
    /// Least of it (mm): below the design negative.
    pub lowest_mm: f64,
    /// Root mean square (mm).
    pub rms_mm: f64,
}

/// Simulates a job without each effect of its machine, without all of them, and with the good drives of its machine file. The
/// simulations run in parallel, one thread a processor. `on_done` receives how many are done, of how many.
///
/// # Errors
/// A motion that does not come to its end; what cannot be measured.
pub fn turned_causes(
    prepared: &PreparedTurning,
    on_done: &(dyn Fn(usize, usize) + Sync),
) -> Result<Vec<OtherLathe>, SimulationFailed> {
    let own = &prepared.machine;
    let lacking = left_out(own).into_iter().map(|effects| {
        let machine = effects.iter().fold(own.clone(), |machine, effect| machine.without(*effect));
        let names: Vec<&str> = effects.iter().map(|effect| effect.name()).collect();
        (format!("without {}", names.join(", ")), machine)
    });
    let good = own.clone().with_good_drives().map(|machine| ("with good drives".to_owned(), machine));
    let machines: Vec<(String, MachineDescription)> = lacking.chain(good).collect();
    let one = |(name, machine): &(String, MachineDescription)| {
        let (_, part) = simulate_turned_on(prepared, machine)?;
        let failed = |reason: String| SimulationFailed::new(&prepared.job.spec.name, &reason);
        let form = turned_form(prepared, &part).map_err(|error| failed(error.to_string()))?;
        Ok(OtherLathe {
            name: name.clone(),
            highest_mm: form.highest().deviation_mm,
            lowest_mm: form.lowest().deviation_mm,
            rms_mm: form.rms_mm(),
        })
    };
    beside_each_other(&machines, one, on_done)
}
