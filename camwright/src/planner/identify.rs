// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Measurement of the stiffness of machine and cut within a job: the push of a stopped wheel after each journal, and the evaluation of
//! its log.

use super::PlannedJob;
use super::error::PlanError;
use super::journal_readings::{JournalReadings, Logged, UncorrectedJournal, unknown};
use super::lobe::PlannedLobe;
use super::sequence::Sequence;
use super::steps::StepSubject;
use crate::gauging::identify::{Identified, IdentifyRequest};
use crate::gauging::journal::DWELL_LEAVES_RAD;
use crate::job::grinding::{IdentificationSpec, JobSpec};
use crate::machine::description::{Axis, MachineDescription};
use crate::math::units::TURN_RAD;
use crate::motion::plan::{Phase, PlanCommand, SegmentKind};
use crate::motion::point_to_point::whole_ticks;
use alloc::vec::Vec;

/// Start of a push above the ground radius of the journal (mm), in addition to the error of the raw part: in the air.
const AIR_MM: f64 = 0.03;
/// Angle in the first turn of infeed at which the turn in the air begins: C has reached its speed by then.
const AIR_FROM_RAD: f64 = TURN_RAD * 0.25;

impl Sequence<'_> {
    /// The wheel stops, comes to the journal that was just ground, pushes it, and goes back.
    pub(super) fn push(
        &mut self,
        index: usize,
        lobe: &PlannedLobe,
        spec: &IdentificationSpec,
    ) -> Result<(), PlanError> {
        let name = lobe.design.name.as_str();
        let of = StepSubject::lobe(Phase::Position, index, name);
        let machine = self.steps.machine;
        let still = |sequence: &mut Self, label: &str| {
            let ticks = whole_ticks(machine.wheel.spin_up_s, machine.cycle_time_s());
            sequence.steps.add(of, SegmentKind::Dwell, ticks, 0, label);
        };
        let ground_mm = lobe.design.contour.radius_at(0.0) + self.job.allowance_mm();
        let home = self.steps.counts(Axis::X, self.job.home.x_mm);
        let air = self.steps.counts(Axis::X, ground_mm + AIR_MM + self.job.raw_part.reach_mm());
        let pushed = self.steps.counts(Axis::X, ground_mm - spec.push_mm);
        let rapid = Some(self.job.rapid_speed_mm_s);
        self.steps.move_axis(of, Axis::X, home, rapid, "wheel clear of the part")?;
        self.steps.command(of, PlanCommand::WheelStop, "wheel stop");
        still(self, "wheel to rest");
        self.steps.move_axis(of, Axis::X, air, rapid, "stopped wheel to just clear of the journal")?;
        self.steps.command(of, PlanCommand::Push { max_n: spec.max_n }, "the stopped wheel may press");
        self.steps.move_axis(of, Axis::X, pushed, Some(spec.push_speed_mm_s), "push of the stopped wheel")?;
        self.steps.move_axis(of, Axis::X, home, rapid, "wheel clear of the part")?;
        self.steps.command(of, PlanCommand::WheelStart, "wheel start");
        still(self, "wheel to its speed");
        Ok(())
    }
}

/// The contact of each journal of a job, measured from what was logged of it in the first half.
///
/// Turns that a hold adds are counted; but a journal whose own cut was held gives no result, because its log does not contain the
/// position of the hold.
///
/// # Errors
/// Reason for every journal without a result.
pub fn identify(
    job: &JobSpec,
    machine: &MachineDescription,
    first: &PlannedJob,
    logs: &[JournalReadings],
) -> Vec<Result<Identified, UncorrectedJournal>> {
    let logged = Logged::new(machine, first, logs);
    let measured = logged.each(|_, journal| {
        let spec = job.identification.as_ref().ok_or(unknown("how its stiffness is measured"))?;
        let seen = logged.seen(journal.lobe)?;
        journal.is_whole()?;
        let (lobe, rest_rad) = (journal.lobe, journal.rest_rad);
        let turns: u32 = lobe.passes.iter().map(crate::motion::speed_plan::SpeedPlan::turns).sum();
        let begins_rad = rest_rad - f64::from(turns) * TURN_RAD;
        let (mut at_rad, mut infeed_ends_rad) = (begins_rad, Vec::with_capacity(lobe.passes.len()));
        for pass in &lobe.passes {
            infeed_ends_rad.push(at_rad + f64::from(pass.infeed().schedule().turns()) * TURN_RAD);
            at_rad += f64::from(pass.turns()) * TURN_RAD;
        }
        let dwell_from_rad = infeed_ends_rad.last().copied().unwrap_or(begins_rad);
        Ok(Identified::from_log(&IdentifyRequest {
            seen,
            gauged: &journal.log.gauged,
            air_from_rad: begins_rad + AIR_FROM_RAD,
            infeed_ends_rad: &infeed_ends_rad,
            dwell_rad: (dwell_from_rad + 0.1 * TURN_RAD, rest_rad - DWELL_LEAVES_RAD.0),
            pushed: &journal.log.pushed,
            push_speed_mm_s: spec.push_speed_mm_s,
            friction_n: machine.axis(Axis::X).drive.coulomb_friction,
        })?)
    });
    measured.collect()
}
