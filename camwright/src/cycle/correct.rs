//! The second half of a job whose runout is corrected: what is planned when the gauge has told what the first half left.
//!
//! ```text
//! for each journal:
//!     table to the journal's limit switch                 Index
//!     X to just clear of the journal                      Approach
//!     C turns, X comes in, corrects for a turn, leaves    Cut
//!     rapid retract                                       Retract
//! X, then the table, to the home position                 Return
//! ```
//! C is homed and the wheel runs from the first half, which ends with X at its home position.

use super::clearance::check_clearance;
use super::dry_run;
use super::error::PlanError;
use super::identify::Contact;
use super::lobe::{begin_at, soft_limit};
use super::sequence::Sequence;
use super::{PlanStart, PlannedJob};
use crate::job::{HoldInCut, JobSpec};
use crate::machine::description::{Axis, MachineDescription};
use crate::numeric::hermite::{HermiteSpline, Knot};
use crate::numeric::periodic_spline::PeriodicSpline;
use crate::plan::{Command, CutSegment, Half, Plan, SegmentKind};
use crate::plan_check::{PlanReport, check_plan};
use crate::runout::identify::Identified;
use crate::runout::journal::{JournalCorrection, JournalError, JournalRequest, needed_log};
use crate::speed_plan::{WayRequest, WaySpeed};
use crate::units::TURN_RAD;
use alloc::string::String;
use alloc::vec::Vec;
use thiserror::Error;

/// Knots of a path that is a circle: it carries nothing but the radius.
const CIRCLE_KNOTS: usize = 8;

/// Why a journal is not corrected.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("lobe {lobe}: {source}")]
pub struct NotCorrected {
    /// Name of the journal.
    pub lobe: String,
    /// Why.
    pub source: JournalError,
}

/// C where it comes to rest after each lobe of a plan (rad), without turns that a hold puts in. Counted from the origin.
#[must_use]
pub fn rests_rad(plan: &Plan, machine: &MachineDescription) -> Vec<f64> {
    let scale = machine.axis(Axis::C).scale;
    let mut c_counts = 0;
    let mut rests = alloc::vec![0.0; plan.lobes.len()];
    for segment in &plan.segments {
        match &segment.kind {
            SegmentKind::Command(Command::SetHome(Axis::C)) => c_counts = 0,
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
            SegmentKind::Search { .. }
            | SegmentKind::Dwell
            | SegmentKind::Wait
            | SegmentKind::Command(_)
            | SegmentKind::Home(_) => {}
        }
    }
    rests
}

/// How each journal of a job is corrected, from what was logged of it in the first half: for each, ticks in their order. By the contact
/// that was measured on it, or, where none was, that of the machine's description.
///
/// # Errors
/// Which journal cannot be, and why.
pub fn decide_corrections(
    job: &JobSpec,
    machine: &MachineDescription,
    first: &PlannedJob,
    logs: &[Contact],
    measured: &[Identified],
) -> Result<Vec<JournalCorrection>, NotCorrected> {
    let rests = rests_rad(&first.plan, machine);
    let decide = |(index, log): (usize, &Contact)| {
        let gauged = log.gauged.as_slice();
        let lobe = &first.lobes[index];
        let failed = |source| NotCorrected { lobe: lobe.design.name.clone(), source };
        let spec = job.correction.ok_or(JournalError::NotKnown { what: "how it is corrected" }).map_err(failed)?;
        let gauge = machine.gauge.as_ref().ok_or(JournalError::NotKnown { what: "the gauge" }).map_err(failed)?;
        let contact = machine.contact.as_ref();
        let z_mm = machine.station(&lobe.design.station).map_or(0.0, |station| station.position_mm);
        let described = contact.and_then(|contact| contact.law(z_mm, lobe.design.width_mm));
        let law = measured.get(index).map(|measured| measured.law).or(described);
        let law = law.ok_or(JournalError::NotKnown { what: "the stiffness" }).map_err(failed)?;
        // A hold puts whole turns in.
        let logged_rad = gauged.last().map_or(0.0, |last| last.c_rad);
        let put_in = libm::round((logged_rad - rests[index]) / TURN_RAD).max(0.0);
        let rest_rad = rests[index] + put_in * TURN_RAD;
        let dwell_turns = job.passes.last().map_or(0, |pass| pass.spark_out_turns);
        let part_share = contact.map_or(0.0, |contact| contact.part_share);
        JournalCorrection::decide(&JournalRequest {
            gauge: gauge.seen(part_share).map_err(|source| failed(source.into()))?,
            lag_s: gauge.bandwidth_rad_s.map_or(0.0, f64::recip),
            cycle_time_s: machine.cycle_time_s(),
            gauged: needed_log(gauged, rest_rad, dwell_turns),
            law,
            mode: spec.mode,
            harmonics: spec.harmonics,
            radius_mm: lobe.design.contour.radius_at(0.0),
            rest_rad,
        })
        .map_err(failed)
    };
    logs.iter().enumerate().map(decide).collect()
}

/// The second half, planned.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedCorrection {
    /// The plan.
    pub plan: Plan,
    /// Work speed of every journal's turn (rad/s).
    pub speeds_rad_s: Vec<f64>,
    /// What the forward check found.
    pub report: PlanReport,
}

/// Plans the turns that correct the journals of a job, one for each, in their order, after its first half.
///
/// # Errors
/// A way that X cannot go, a position beyond a soft limit, a collision; nothing has moved.
pub fn plan_corrections(
    job: &JobSpec,
    machine: &MachineDescription,
    first: &PlannedJob,
    corrections: &[JournalCorrection],
) -> Result<PlannedCorrection, PlanError> {
    let start = PlanStart { counts: first.report.end_counts, c_homed: true };
    let mut sequence = Sequence::new(job, machine, &[], start);
    let mut speeds_rad_s = Vec::with_capacity(corrections.len());
    let most_rad_s = job.passes.last().map_or(0.0, |pass| pass.speed.most_rad_s());
    for (index, (lobe, correction)) in first.lobes.iter().zip(corrections).enumerate() {
        let name = &lobe.design.name;
        let place = || alloc::format!("lobe {name}: ");
        let radius_mm = lobe.design.contour.radius_at(0.0);
        let path = PeriodicSpline::from_coefficients(alloc::vec![radius_mm; CIRCLE_KNOTS]).expect("finite numbers");
        let offset = lowered(&correction.way, radius_mm);
        let (lowest_mm, highest_mm) = extremes(&correction.way);
        soft_limit(machine, Axis::X, lowest_mm, place(), "the lowest point of the correction")?;
        let held_mm = highest_mm + job.retract_clearance_mm;
        soft_limit(machine, Axis::X, held_mm, place(), "a hold in the correction")?;
        let speed = WaySpeed::new(&WayRequest {
            path: &path,
            offset: &offset,
            turns: correction.turns,
            most_rad_s,
            c: machine.axis(Axis::C).limits,
            x: machine.axis(Axis::X).limits,
            cycle_time_s: machine.cycle_time_s(),
        })
        .map_err(|source| PlanError::Speed {
            lobe: name.clone(),
            pass: String::from("correction"),
            source,
        })?;
        let c_counts = start.counts[Axis::C.index()];
        let cut = CutSegment {
            path: index,
            speed: 0,
            infeed: 0,
            ratio: None,
            lead: None,
            start_counts: 0,
            path_start_rad: begin_at(machine, lobe.design.phase_rad, c_counts).path_rad,
            turns: correction.turns,
            infeed_turns: correction.turns - 1,
            plateau_s: speed.plateau_s,
            turn_s: speed.turn_s,
            retract_mm: job.retract_clearance_mm,
            hold_mm: match job.hold_in_cut {
                HoldInCut::Retract => job.retract_clearance_mm,
                HoldInCut::StopInfeed => 0.0,
            },
            until_steady_n: None,
        };
        sequence.index_to(index)?;
        sequence.correct(index, name, cut, path, &speed, offset)?;
        speeds_rad_s.push(speed.speed_rad_s);
    }
    let mut plan = sequence.finish()?;
    plan.duration_with_indexing_s = plan.duration_s;
    plan.half = Half::Second;
    if let Some(stand_off_mm) = job.dry_run_mm {
        dry_run::stand_off(&mut plan, machine, stand_off_mm);
    }
    check_clearance(job, machine, &first.lobes, &plan, start.counts)?;
    let report = check_plan(&plan, machine, start.counts)?;
    Ok(PlannedCorrection { plan, speeds_rad_s, report })
}

/// The way above a radius.
fn lowered(way: &HermiteSpline, radius_mm: f64) -> HermiteSpline {
    let knots = way.knots().iter().map(|knot| Knot { value: knot.value - radius_mm, ..*knot });
    HermiteSpline::new(knots.collect()).expect("as many knots in the same order, all finite")
}

/// Smallest and largest value at its knots, which lie closer than it bends.
fn extremes(way: &HermiteSpline) -> (f64, f64) {
    let values = way.knots().iter().map(|knot| knot.value);
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}
