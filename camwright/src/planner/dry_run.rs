// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The dry run of a job: the whole plan with X farther out by a stand-off, so that the wheel touches nothing.

use super::error::PlanError;
use super::error::RequiredPosition;
use super::lobe::{PlannedLobe, extremes, soft_limit};
use crate::job::grinding::JobSpec;
use crate::job::grinding::Subject;
use crate::machine::description::{Axis, MachineDescription};
use crate::math::units::TURN_RAD;
use crate::motion::plan::{Half, Plan, PlanCommand, SegmentKind};
use alloc::vec::Vec;

/// Places around a lobe at which the wheel's distance is looked at, and of its contour: every half degree the chord of an ordinary
/// contour is some µm off, and a clearance is a millimetre.
const PLACES: u32 = 720;

/// The wheel must be clear of every lobe and its stock wherever it would be ground, and X within its travel.
///
/// # Errors
/// A stand-off that is none or too small, with the one that would do; X beyond a soft limit.
pub(super) fn check(
    job: &JobSpec,
    machine: &MachineDescription,
    lobes: &[PlannedLobe],
    stand_off_mm: f64,
) -> Result<(), PlanError> {
    let needed_mm = job.maximum_stock_mm() + job.clearance_mm;
    for lobe in lobes {
        let place = || Subject::Lobe(lobe.design.name.clone());
        let outline: Vec<(f64, f64)> = (0..PLACES)
            .map(|i| lobe.design.contour.point_about_axis(f64::from(i) * TURN_RAD / f64::from(PLACES)))
            .map(|point| (point.x, point.y))
            .collect();
        let gap_mm = |stand_off_mm: f64| gap_mm(lobe, &outline, stand_off_mm);
        if !(stand_off_mm > 0.0 && stand_off_mm.is_finite() && gap_mm(stand_off_mm) >= needed_mm) {
            // A flank is left along a line askew of its normal; ten times as far is off every one that a follower can have.
            let (mut low, mut high) = (0.0, 10.0 * needed_mm);
            for _ in 0..20 {
                let middle = 0.5 * (low + high);
                if gap_mm(middle) < needed_mm { low = middle } else { high = middle }
            }
            return Err(PlanError::DryRun { lobe: lobe.design.name.clone(), stand_off_mm, needed_mm, min_mm: high });
        }
        let held_mm = extremes(lobe.tool_path.spline()).1 + job.passes_infeed_mm() + job.retract_clearance_mm;
        let what = RequiredPosition::DryRunHold;
        soft_limit(machine, Axis::X, held_mm + stand_off_mm, place(), what)?;
    }
    let what = RequiredPosition::DryRunHome;
    soft_limit(machine, Axis::X, job.home.x_mm + stand_off_mm, Subject::Job, what)
}

/// Least distance of the wheel from a finished lobe, all round (mm).
fn gap_mm(lobe: &PlannedLobe, outline: &[(f64, f64)], stand_off_mm: f64) -> f64 {
    let wheel_mm = lobe.tool_path.wheel_radius_mm();
    let at = |i: u32| {
        let angle = f64::from(i) * TURN_RAD / f64::from(PLACES);
        let centre = lobe.tool_path.sample(angle).value + wheel_mm + stand_off_mm;
        let (x, y) = (centre * libm::cos(angle), centre * libm::sin(angle));
        let square =
            outline.iter().map(|(px, py)| (px - x) * (px - x) + (py - y) * (py - y)).fold(f64::INFINITY, f64::min);
        libm::sqrt(square) - wheel_mm
    };
    (0..PLACES).map(at).fold(f64::INFINITY, f64::min)
}

/// Takes the whole of a plan outwards, on counts; what would change the wheel stands still instead.
pub(super) fn stand_off(plan: &mut Plan, machine: &MachineDescription, stand_off_mm: f64) {
    let scale = machine.axis(Axis::X).scale;
    let counts = scale.counts(stand_off_mm);
    let off_mm = scale.position(counts);
    for path in &mut plan.paths {
        // The basis functions sum to 1 everywhere.
        *path = path.raised(off_mm);
    }
    for segment in &mut plan.segments {
        match &mut segment.kind {
            SegmentKind::Move(targets) => {
                for target in targets.iter_mut().filter(|target| target.axis == Axis::X) {
                    target.target_counts += counts;
                }
            }
            SegmentKind::Command(PlanCommand::Dress { .. }) => segment.kind = SegmentKind::Dwell,
            _ => {}
        }
    }
    if plan.half != Half::First {
        plan.half = Half::NoPart;
    }
}
