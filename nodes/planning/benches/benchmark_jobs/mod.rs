// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Shipped jobs for benchmarks of the simulated machines.

use camwright::interpolator::{Motion, Prepared};
use camwright::machine::description::MachineDescription;
use camwright::machine::persistent_state::PersistentState;
use camwright::simulation::Machine;
use camwright::simulation::closed_loop::ClosedLoop;
use camwright::simulation::turned_part::TurnedPart;
use camwright_planning::{AnyPrepared, prepare_any, with_raw_part};
use std::error::Error;
use std::sync::Arc;

/// A planned job.
pub(crate) struct Benchmark(AnyPrepared);

impl Benchmark {
    /// The default job of the grinder.
    pub(crate) fn ground() -> Result<Self, Box<dyn Error>> {
        Ok(Self(prepare_any("four_lobe_camshaft", &[], None)?))
    }

    /// The 3-D cam of the lathe.
    pub(crate) fn turned() -> Result<Self, Box<dyn Error>> {
        Ok(Self(prepare_any("turned_cam", &[], None)?))
    }

    /// Machine of the job with all effects.
    pub(crate) fn machine(&self) -> MachineDescription {
        self.0.machine().clone()
    }

    /// The machine with the raw part, and the motion of the job started.
    pub(crate) fn start(&self, description: &MachineDescription) -> Result<ClosedLoop, Box<dyn Error>> {
        let (mut machine, plan) = match &self.0 {
            AnyPrepared::Ground(prepared) => (with_raw_part(prepared, description)?, &prepared.planned.plan),
            AnyPrepared::Turned(prepared) => {
                let (job, grid) = (&prepared.job.spec, prepared.job.grid);
                let mut machine = Machine::new(description.clone(), PersistentState::new(description))?;
                machine.load_turned_part(
                    TurnedPart::round(job.name.clone(), grid, job.bar_radius_mm)?,
                    job.part_zero_mm,
                )?;
                (machine, &prepared.planned.plan)
            }
        };
        let motion = Prepared::new(Motion::Plan(Arc::new(plan.clone())), description)?;
        machine.begin_job();
        let mut closed_loop = ClosedLoop::direct(machine);
        closed_loop.start(Box::new(motion))?;
        Ok(closed_loop)
    }
}
