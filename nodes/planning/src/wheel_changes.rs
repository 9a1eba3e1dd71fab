// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The wheels that a job mounts, for people and for `summary.json`.

use super::{PreparedJob, deflection};
use camwright::machine::wheel_state::mm_from_nm;
use camwright::math::units::{mm_from_um, um_from_mm};
use camwright::motion::plan::{Phase, PlanCommand, SegmentKind};
use serde::Serialize;
use std::fmt;

/// Wheel change of a job.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WheelChangeSummary {
    /// Lobe, or visit to one, that it comes before.
    pub before_lobe: String,
    /// Wheel that is mounted.
    pub wheel: String,
    /// Its radius then.
    pub radius_mm: f64,
    /// Time from the stop of the wheel before to the speed of this one.
    pub duration_s: f64,
}

/// The wheels that a prepared job mounts, in their order; empty where it names none.
#[must_use]
pub fn wheel_changes(prepared: &PreparedJob) -> Vec<WheelChangeSummary> {
    let (plan, machine) = (&prepared.planned.plan, &prepared.machine);
    let mut changes: Vec<WheelChangeSummary> = Vec::new();
    let mut ticks = 0;
    for segment in &plan.segments {
        if segment.phase == Phase::WheelChange {
            ticks += segment.ticks;
        }
        match &segment.kind {
            SegmentKind::Command(PlanCommand::ChangeWheel { wheel }) => changes.push(WheelChangeSummary {
                before_lobe: String::new(),
                wheel: machine.wheel_name(*wheel as usize).unwrap_or_default().to_owned(),
                radius_mm: 0.0,
                duration_s: 0.0,
            }),
            SegmentKind::Command(PlanCommand::ExpectWheel { radius_nm }) => {
                if let Some(change) = changes.last_mut() {
                    change.radius_mm = mm_from_nm(*radius_nm);
                }
            }
            _ => {}
        }
        let open = changes.last_mut().filter(|change| change.before_lobe.is_empty());
        if let (Some(change), Some(lobe)) = (open, segment.lobe.and_then(|lobe| plan.lobes.get(lobe))) {
            change.before_lobe.clone_from(lobe);
            change.duration_s = ticks as f64 * machine.cycle_time_s();
            ticks = 0;
        }
    }
    changes
}

/// Warning where another order of the lobes needs fewer wheel changes.
pub(super) fn order_warning(prepared: &PreparedJob) -> Option<String> {
    let spec = &prepared.job.spec;
    let changes = wheel_changes(prepared);
    let stages = || spec.lobes.iter().filter_map(|lobe| lobe.visit.as_ref());
    let mut needed = Vec::new();
    for visit in stages() {
        if !needed.contains(&(visit.first_pass, visit.wheel)) {
            needed.push((visit.first_pass, visit.wheel));
        }
    }
    let saved = changes.len().saturating_sub(needed.len());
    let longest_s = changes.iter().map(|change| change.duration_s).fold(0.0, f64::max);
    (saved > 0).then(|| {
        format!(
            "the order of the lobes needs {} wheel changes; with the lobes of a wheel after each other {} are enough, which saves about {:.0} s",
            changes.len(),
            needed.len(),
            saved as f64 * longest_s
        )
    })
}

/// Warning where deflection in the passes before a wheel leaves more than its approach clears: its rapid advance would meet the part.
pub(super) fn approach_warning(prepared: &PreparedJob) -> Option<String> {
    let spec = &prepared.job.spec;
    let lacking = |index: usize| {
        let before = spec.visit_before(index)?;
        let left_mm = mm_from_um(deflection::from_lobe(prepared, before)?.left_um);
        let air_mm = spec.passes_of(index).first()?.air_mm;
        let needed_mm = left_mm - spec.stock_of_mm(index);
        (needed_mm > air_mm).then_some((index, needed_mm, air_mm))
    };
    let lobes = (0..spec.lobes.len()).filter_map(lacking);
    let (index, needed_mm, air_mm) = lobes.max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(format!(
        "lobe {}: deflection in the passes before leaves {:.1} um more than planned, above wheel_approach_mm, {air_mm}: the rapid advance of the wheel \
         would meet the part; set wheel_approach_mm to {:.3} or more, or add spark-out turns to those passes",
        spec.lobes[index].name,
        um_from_mm(needed_mm),
        mm_from_um(um_from_mm(1.2 * needed_mm).ceil())
    ))
}

impl fmt::Display for WheelChangeSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { before_lobe, wheel, radius_mm, duration_s } = self;
        write!(f, "wheel {wheel} of radius {radius_mm:.4} mm before {before_lobe}: change {duration_s:.2} s")
    }
}
