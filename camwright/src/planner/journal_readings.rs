// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Log of the journals of a job, as read by identification and correction.

use super::PlannedJob;
use super::lobe::PlannedLobe;
use crate::gauging::gauge_setup::GaugeSetup;
use crate::gauging::gauged_tick::GaugedTick;
use crate::gauging::identify::PushTick;
use crate::gauging::journal::JournalError;
use crate::job::grinding::{JobSpec, StiffnessSource};
use crate::machine::contact_law::ContactLaw;
use crate::machine::description::{Axis, MachineDescription};
use crate::math::units::TURN_RAD;
use crate::motion::plan::{PlanCommand, SegmentKind};
use alloc::string::String;
use alloc::vec::Vec;
use thiserror::Error;

/// Logged data of a journal.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct JournalReadings {
    /// While it was ground.
    pub gauged: Vec<GaugedTick>,
    /// While the wheel did not turn.
    pub pushed: Vec<PushTick>,
}

/// Why a journal is not measured or not corrected.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("lobe {lobe}: {source}")]
pub struct UncorrectedJournal {
    /// Name of the journal.
    pub lobe: String,
    pub source: JournalError,
}

/// C where it comes to rest after each lobe of a planned job (rad), without turns that a hold puts in. Counted from the origin.
#[must_use]
pub fn rests_rad(planned: &PlannedJob, machine: &MachineDescription) -> Vec<f64> {
    let plan = &planned.plan;
    let scale = machine.axis(Axis::C).scale;
    let mut c_counts = planned.start_c_counts;
    let mut rests = alloc::vec![0.0; plan.lobes.len()];
    for segment in &plan.segments {
        match &segment.kind {
            SegmentKind::Command(PlanCommand::SetHome(Axis::C)) => c_counts = 0,
            SegmentKind::Move(targets) => {
                let of_c = targets.iter().find(|target| target.axis == Axis::C);
                c_counts = of_c.map_or(c_counts, |target| target.target_counts);
            }
            SegmentKind::Cut(cut) => {
                c_counts += i64::from(cut.turns) * scale.counts(TURN_RAD);
                if let Some(rest) = segment.lobe.and_then(|lobe| rests.get_mut(lobe)) {
                    *rest = scale.position(c_counts);
                }
            }
            _ => {}
        }
    }
    rests
}

/// The logs of all journals of a job.
pub(super) struct Logged<'a> {
    machine: &'a MachineDescription,
    first: &'a PlannedJob,
    logs: &'a [JournalReadings],
    rests: Vec<f64>,
}

/// The log of one.
pub(super) struct JournalLog<'a> {
    pub(super) lobe: &'a PlannedLobe,
    pub(super) log: &'a JournalReadings,
    /// C where it rests after it (rad), with the turns that holds put in.
    pub(super) rest_rad: f64,
    /// Turns that holds put into its own cut.
    pub(super) held_turns: f64,
}

impl<'a> Logged<'a> {
    pub(super) fn new(machine: &'a MachineDescription, first: &'a PlannedJob, logs: &'a [JournalReadings]) -> Self {
        Self { machine, first, logs, rests: rests_rad(first, machine) }
    }

    /// Every journal with what `of` makes of it.
    pub(super) fn each<T>(
        &self,
        of: impl Fn(usize, JournalLog<'a>) -> Result<T, JournalError>,
    ) -> impl Iterator<Item = Result<T, UncorrectedJournal>> {
        self.logs.iter().zip(&self.first.lobes).enumerate().map(move |(index, (log, lobe))| {
            let put_in = self.put_in(index);
            let before = index.checked_sub(1).map_or(0.0, |before| self.put_in(before));
            let journal =
                JournalLog { lobe, log, rest_rad: self.rests[index] + put_in * TURN_RAD, held_turns: put_in - before };
            of(index, journal).map_err(|source| UncorrectedJournal { lobe: lobe.design.name.clone(), source })
        })
    }

    /// Turns that holds put in up to the end of a journal: whole ones, and C has never turned less than planned.
    fn put_in(&self, index: usize) -> f64 {
        let logged_rad = self.logs[index].gauged.last().map_or(0.0, |last| last.c_rad);
        libm::round((logged_rad - self.rests[index]) / TURN_RAD).max(0.0)
    }

    /// Gauge that measures a journal on the machine.
    pub(super) fn seen(&self, lobe: &PlannedLobe) -> Result<GaugeSetup, JournalError> {
        seen(self.machine, lobe)
    }
}

/// Gauge that measures a journal on a machine.
pub(super) fn seen(machine: &MachineDescription, lobe: &PlannedLobe) -> Result<GaugeSetup, JournalError> {
    let gauge = machine.gauge.as_ref().ok_or(JournalError::NotKnown { what: "the gauge" })?;
    let part_mm_n = lobe.design.part_compliance_mm_n(machine, 0.0);
    let z_mm = lobe.design.z_mm(machine).unwrap_or(0.0);
    let part_share = machine.contact.as_ref().map_or(0.0, |contact| contact.part_share_with(z_mm, part_mm_n));
    Ok(gauge.seen(part_share, machine.cycle_time_s())?)
}

/// Builds the error for data that a job lacks.
pub(super) const fn unknown(what: &'static str) -> JournalError {
    JournalError::NotKnown { what }
}

impl JournalLog<'_> {
    /// Refuses a journal whose cut a hold made longer: where in it nobody logged.
    pub(super) fn is_whole(&self) -> Result<(), JournalError> {
        match self.held_turns > 0.0 {
            true => Err(JournalError::Held { turns: self.held_turns }),
            false => Ok(()),
        }
    }
}

/// The contact that a journal is corrected with is of one of these.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactFrom {
    /// It was measured on the journal itself.
    Measured,
    /// It is what was kept for the machine.
    Kept,
    /// It is that of the machine's description.
    Nominal,
}

impl core::fmt::Display for ContactFrom {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            ContactFrom::Measured => "measured on it",
            ContactFrom::Kept => "kept for the machine",
            ContactFrom::Nominal => "of the machine's description",
        })
    }
}

impl PlannedLobe {
    /// The contact that it is corrected with as a journal of a job: what was measured on it, else what is kept, else the description's.
    #[must_use]
    pub fn contact(
        &self,
        job: &JobSpec,
        machine: &MachineDescription,
        measured: Option<ContactLaw>,
    ) -> Option<(ContactLaw, ContactFrom)> {
        let name = &self.design.name;
        let kept = job.correction.iter().filter(|spec| spec.stiffness != StiffnessSource::Nominal);
        let kept = kept.flat_map(|spec| &spec.contacts).find(|contact| contact.lobe == *name);
        let part_mm_n = self.design.part_compliance_mm_n(machine, 0.0);
        let nominal = || {
            let law = machine.contact_law(&self.design.station, self.design.width_mm)?;
            Some(law.in_series(part_mm_n))
        };
        measured
            .map(|law| (law, ContactFrom::Measured))
            .or_else(|| kept.map(|kept| (kept.law, ContactFrom::Kept)))
            .or_else(|| nominal().map(|law| (law, ContactFrom::Nominal)))
    }
}
