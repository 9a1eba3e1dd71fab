//! Measuring the stiffness of machine and cut as a part of a job: the push of a stopped wheel after each journal, and what the log of a
//! journal tells.

use super::PlannedJob;
use super::correct::{NotCorrected, rests_rad};
use super::error::PlanError;
use super::lobe::PlannedLobe;
use super::sequence::{Of, Sequence};
use crate::job::{IdentificationSpec, JobSpec};
use crate::machine::description::{Axis, MachineDescription};
use crate::plan::{Command, Phase, SegmentKind};
use crate::point_to_point::whole_ticks;
use crate::runout::identify::{Identified, IdentifyRequest, Pushed};
use crate::runout::journal::{DWELL_LEAVES_RAD, Gauged, JournalError};
use crate::units::TURN_RAD;
use alloc::vec::Vec;

/// Where a push begins above the radius that the journal has been ground to (mm), besides what the raw part was off: in the air.
const AIR_MM: f64 = 0.03;
/// Where in the first turn of infeed the turn in the air begins: C is at its speed by then.
const AIR_FROM_RAD: f64 = TURN_RAD * 0.25;

/// What was logged of a journal.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Contact {
    /// While it was ground.
    pub gauged: Vec<Gauged>,
    /// While the wheel did not turn.
    pub pushed: Vec<Pushed>,
}

impl Sequence<'_> {
    /// The wheel stops, comes to the journal that was just ground, pushes it, and goes back.
    pub(super) fn push(
        &mut self,
        index: usize,
        lobe: &PlannedLobe,
        spec: &IdentificationSpec,
    ) -> Result<(), PlanError> {
        let name = lobe.design.name.as_str();
        let of = Of::lobe(Phase::Position, index, name);
        let machine = self.machine;
        let still = |sequence: &mut Self, label: &str| {
            let ticks = whole_ticks(machine.wheel.spin_up_s, machine.cycle_time_s());
            sequence.add(of, SegmentKind::Dwell, ticks, 0, label);
        };
        let allowance_mm = self.job.correction.map_or(0.0, |correction| correction.allowance_mm);
        let ground_mm = lobe.design.contour.radius_at(0.0) + allowance_mm;
        let home = self.counts(Axis::X, self.job.home.x_mm);
        let air = self.counts(Axis::X, ground_mm + AIR_MM + self.job.raw_part.reach_mm());
        let pushed = self.counts(Axis::X, ground_mm - spec.push_mm);
        let rapid = Some(self.job.rapid_speed_mm_s);
        self.move_axis(of, Axis::X, home, rapid, "wheel clear of the part")?;
        self.command(of, Command::WheelStop, "wheel stop");
        still(self, "wheel to rest");
        self.move_axis(of, Axis::X, air, rapid, "stopped wheel to just clear of the journal")?;
        self.command(of, Command::Push { most_n: spec.most_n }, "the stopped wheel may press");
        self.move_axis(of, Axis::X, pushed, Some(spec.push_speed_mm_s), "push of the stopped wheel")?;
        self.move_axis(of, Axis::X, home, rapid, "wheel clear of the part")?;
        self.command(of, Command::WheelStart, "wheel start");
        still(self, "wheel to its speed");
        Ok(())
    }
}

/// The contact of each journal of a job, measured from what was logged of it in the first half.
///
/// # Errors
/// Which journal tells none, and why.
pub fn identify(
    job: &JobSpec,
    machine: &MachineDescription,
    first: &PlannedJob,
    logs: &[Contact],
) -> Result<Vec<Identified>, NotCorrected> {
    let rests = rests_rad(&first.plan, machine);
    let one = |(index, log): (usize, &Contact)| {
        let lobe = &first.lobes[index];
        let failed = |source: JournalError| NotCorrected { lobe: lobe.design.name.clone(), source };
        let unknown = |what| failed(JournalError::NotKnown { what });
        let spec = job.identification.as_ref().ok_or_else(|| unknown("how its stiffness is measured"))?;
        let gauge = machine.gauge.as_ref().ok_or_else(|| unknown("the gauge"))?;
        let part_share = machine.contact.as_ref().map_or(0.0, |contact| contact.part_share);
        let turns: u32 = lobe.passes.iter().map(crate::speed_plan::SpeedPlan::turns).sum();
        let begins_rad = rests[index] - f64::from(turns) * TURN_RAD;
        let (mut at_rad, mut infeed_ends_rad) = (begins_rad, Vec::with_capacity(lobe.passes.len()));
        for pass in &lobe.passes {
            infeed_ends_rad.push(at_rad + f64::from(pass.infeed().schedule().turns()) * TURN_RAD);
            at_rad += f64::from(pass.turns()) * TURN_RAD;
        }
        let dwell_from_rad = infeed_ends_rad.last().copied().unwrap_or(begins_rad);
        Identified::from_log(&IdentifyRequest {
            gauge: gauge.seen(part_share).map_err(|source| failed(source.into()))?,
            lag_s: gauge.bandwidth_rad_s.map_or(0.0, f64::recip),
            cycle_time_s: machine.cycle_time_s(),
            gauged: &log.gauged,
            air_from_rad: begins_rad + AIR_FROM_RAD,
            infeed_ends_rad: &infeed_ends_rad,
            dwell_rad: (dwell_from_rad + 0.1 * TURN_RAD, rests[index] - DWELL_LEAVES_RAD.0),
            pushed: &log.pushed,
            push_speed_mm_s: spec.push_speed_mm_s,
            friction_n: machine.axis(Axis::X).drive.coulomb_friction,
        })
        .map_err(|source| failed(source.into()))
    };
    logs.iter().enumerate().map(one).collect()
}
