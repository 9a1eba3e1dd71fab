// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Second half of a job with runout correction, planned from the gauge readings of the first half.
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

use super::check_forwards;
use super::dry_run;
use super::error::PlanError;
use super::error::RequiredPosition;
use super::gouge::GougeRequest;
use super::journal_readings::{JournalReadings, Logged, UncorrectedJournal, unknown};
use super::lobe::{begin_at, soft_limit};
use super::sequence::Sequence;
use super::{PlanStart, PlannedJob};
use crate::gauging::identify::Identified;
use crate::gauging::journal::{JournalCorrection, JournalRequest, needed_log};
use crate::job::grinding::JobSpec;
use crate::job::grinding::Subject;
use crate::machine::description::{Axis, MachineDescription};
use crate::math::hermite::{HermiteSpline, Knot};
use crate::math::hull::lowest;
use crate::math::periodic_spline::PeriodicSpline;
use crate::math::range::minimum_and_maximum;
use crate::motion::plan::{CutSegment, Half, Plan};
use crate::motion::speed_plan::{FixedPathRequest, FixedPathSpeed};
use crate::planner::plan_check::PlanReport;
use alloc::string::String;
use alloc::vec::Vec;

/// Knots of a path that is a circle: it carries nothing but the radius.
const CIRCLE_KNOTS: usize = 8;

/// Decides the correction of each journal from the log of the first half: ticks in order for each journal. Uses the measured contact;
/// without one, [`PlannedLobe::contact`](super::PlannedLobe::contact).
///
/// # Errors
/// Which journal cannot be, and why.
pub fn decide_corrections(
    job: &JobSpec,
    machine: &MachineDescription,
    first: &PlannedJob,
    logs: &[JournalReadings],
    measured: &[Option<Identified>],
) -> Result<Vec<JournalCorrection>, UncorrectedJournal> {
    let logged = Logged::new(machine, first, logs);
    let decided = logged.each(|index, journal| {
        let spec = job.correction.as_ref().ok_or(unknown("how it is corrected"))?;
        let seen = logged.seen(journal.lobe)?;
        let measured = measured.get(index).and_then(Option::as_ref);
        let law = measured.map(|measured| measured.law);
        let (law, _) = journal.lobe.contact(job, machine, law).ok_or(unknown("the stiffness"))?;
        let dwell_turns = job.passes.last().map_or(0, |pass| pass.spark_out_turns);
        JournalCorrection::decide(&JournalRequest {
            seen,
            gauged: needed_log(&journal.log.gauged, journal.rest_rad, dwell_turns),
            law,
            ratio_uncertainty: measured.map(|measured| measured.known_to.ratio.uncertainty),
            mode: spec.mode,
            harmonics: spec.harmonics,
            published: spec.published,
            finishing: spec.finishing,
            radius_mm: journal.lobe.design.contour.radius_at(0.0),
            rest_rad: journal.rest_rad,
        })
    });
    decided.collect()
}

/// The second half, planned.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedCorrection {
    pub plan: Plan,
    /// Result of the forward check.
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
    let max_rad_s = job.passes.last().map_or(0.0, |pass| pass.speed.maximum_rad_s());
    for (index, (lobe, correction)) in first.lobes.iter().zip(corrections).enumerate() {
        let name = &lobe.design.name;
        let place = || Subject::Lobe(name.clone());
        let radius_mm = lobe.design.contour.radius_at(0.0);
        let path = PeriodicSpline::from_coefficients(alloc::vec![radius_mm; CIRCLE_KNOTS]).expect("finite numbers");
        let offset = lowered(&correction.way, radius_mm);
        let lowest_mm = lowest(&correction.way).value;
        // Its knots lie closer than it bends.
        let (_, highest_mm) = minimum_and_maximum(correction.way.knots().iter().map(|knot| knot.value));
        soft_limit(machine, Axis::X, lowest_mm, place(), RequiredPosition::LowestCorrection)?;
        let held_mm = highest_mm + job.retract_clearance_mm;
        soft_limit(machine, Axis::X, held_mm, place(), RequiredPosition::CorrectionHold)?;
        let speed = FixedPathSpeed::new(&FixedPathRequest {
            path: &path,
            offset: &offset,
            turns: correction.turns,
            max_rad_s,
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
            hold_mm: job.hold_mm(),
            until_steady_n: None,
            variation: None,
        };
        sequence.index_to(index)?;
        sequence.correct(index, name, cut, path, &speed, offset)?;
    }
    let mut plan = sequence.finish()?;
    plan.duration_with_indexing_s = plan.duration_s;
    plan.half = Half::Second;
    if let Some(stand_off_mm) = job.dry_run_mm {
        dry_run::stand_off(&mut plan, machine, stand_off_mm);
    }
    let stock_mm = first.lobes.iter().zip(corrections);
    let stock_mm =
        stock_mm.map(|(lobe, correction)| correction.highest_before_mm() - lobe.design.contour.radius_at(0.0));
    let report = check_forwards(&GougeRequest {
        job,
        machine,
        lobes: &first.lobes,
        plan: &plan,
        start_counts: start.counts,
        c_homed: start.c_homed,
        stock_mm: &stock_mm.collect::<Vec<_>>(),
        corrections,
    })?;
    Ok(PlannedCorrection { plan, report })
}

/// The way above a radius.
fn lowered(way: &HermiteSpline, radius_mm: f64) -> HermiteSpline {
    let knots = way.knots().iter().map(|knot| Knot { value: knot.value - radius_mm, ..*knot });
    HermiteSpline::new(knots.collect()).expect("as many knots in the same order, all finite")
}
