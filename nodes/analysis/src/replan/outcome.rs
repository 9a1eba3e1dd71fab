// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Result of replanning an archived job, in shop words and units.

use super::archive::ArchivedJob;
use camwright::machine::description::Axis;
use camwright::math::units::{deg_from_rad, rpm_from_rad_s, um_from_mm};
use camwright::motion::plan::{Plan, Segment};
use camwright::planner::plan_difference::{MotionDifference, PlanChange, PlanDifference, compare};
use camwright_files::convert::machine_now::recorded_machine;
use camwright_files::convert::plan::{hash_with_version, phase_name, plan_from_pages};
use camwright_planning::plan_recorded;
use std::fmt;

#[derive(Debug, Clone, PartialEq)]
pub struct ChangeLine {
    /// Which step, by its number and what it is for.
    pub step: String,
    /// Changed value, old and new.
    pub text: String,
}

/// Result of replanning a job.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplanOutcome {
    /// Hashes of the plan as it was and as it is.
    pub hashes: [String; 2],
    /// Both plans are the same in every value.
    pub is_same: bool,
    /// Predicted durations (s).
    pub duration_s: [f64; 2],
    /// Changes beyond the tolerance.
    pub lines: Vec<ChangeLine>,
    /// Differences that were no more than was allowed.
    pub within: usize,
}

impl ReplanOutcome {
    #[must_use]
    pub fn moved(&self) -> bool {
        !self.lines.is_empty()
    }
}

/// Plans a job again, on the machine as it was but for `set_machine`, as it was but for `set`.
///
/// # Errors
/// Why it cannot be planned or compared, as the end of a sentence.
pub fn replan(
    job: &ArchivedJob,
    set: &[String],
    set_machine: &[String],
    tolerance_um: f64,
) -> Result<ReplanOutcome, String> {
    let message = job.machine.as_ref().ok_or("no machine description is recorded")?;
    let machine = recorded_machine(message, set_machine)?;
    let old = job.plan(&machine)?;
    let prepared = plan_recorded(&job.status, job.files.clone(), message, machine.clone(), set)?;
    let new = plan_from_pages(prepared.first_pages(), &machine).map(|(plan, _)| plan).map_err(|e| e.to_string())?;
    let difference = compare(&old, &new, &machine);
    let is_same = old == new;
    let mut lines = lines_of(&old, &new, &difference, tolerance_um);
    let changes = difference.moved.len() + difference.only_old.len() + difference.only_new.len();
    let within = changes - lines.len();
    if difference.is_none() && !is_same {
        let text = "same motion at all compared points, but other values".to_owned();
        lines.push(ChangeLine { step: "the plan".to_owned(), text });
    }
    let version = job.pages.iter().flat_map(|page| &page.header).next().map_or("", |header| header.version.as_str());
    let hashes = [job.status.plan_hash.clone(), hash_with_version(prepared.first_pages(), version)];
    Ok(ReplanOutcome { hashes, is_same, duration_s: [old.duration_s, new.duration_s], lines, within })
}

fn lines_of(old: &Plan, new: &Plan, difference: &PlanDifference, tolerance_um: f64) -> Vec<ChangeLine> {
    let mut lines: Vec<ChangeLine> = Vec::new();
    let only = |plan: &Plan, steps: &[usize], text: &str| -> Vec<ChangeLine> {
        let named = steps.iter().filter_map(|step| Some((*step, plan.segments.get(*step)?)));
        named.map(|(step, segment)| ChangeLine { step: name(plan, step, segment), text: text.to_owned() }).collect()
    };
    lines.extend(only(old, &difference.only_old, "was removed"));
    lines.extend(only(new, &difference.only_new, "is new"));
    for found in &difference.moved {
        let Some(segment) = new.segments.get(found.new_step) else { continue };
        if let Some(text) = text(found, tolerance_um) {
            lines.push(ChangeLine { step: name(new, found.new_step, segment), text });
        }
    }
    lines
}

/// A step by its number, from 1 on, phase and lobe.
fn name(plan: &Plan, step: usize, segment: &Segment) -> String {
    let lobe = segment.lobe.and_then(|lobe| plan.lobes.get(lobe));
    let lobe = lobe.map_or_else(String::new, |lobe| format!(" of {lobe}"));
    format!("step {} ({}{lobe})", step + 1, phase_name(segment.phase))
}

/// Text of a change; `None` within the tolerance.
fn text(found: &MotionDifference, tolerance_um: f64) -> Option<String> {
    let at = found.at_rad.map_or_else(String::new, |at| format!(" at {:.2} deg", deg_from_rad(at)));
    let way = |what: &str| {
        let by = um_from_mm(found.by());
        (by.abs() > tolerance_um).then(|| format!("{what} by {by:+.6} um{at}"))
    };
    let turned = |what: &str| {
        // As much as the same number of um on a radius of 1 m.
        let is_more = um_from_mm(um_from_mm(found.by())).abs() > tolerance_um;
        is_more.then(|| format!("{what} by {:+.6} deg{at}", deg_from_rad(found.by())))
    };
    let change = |what: &str, old: f64, new: f64, unit: &str| Some(format!("{what} {old} -> {new}{unit}{at}"));
    match found.moved {
        PlanChange::Target(Axis::C) => turned("moves c_axis to another position,"),
        PlanChange::Target(axis) => way(&format!("moves to another position of {},", axis.joint())),
        PlanChange::PathOfX => way("path of x_axis over c_axis moved"),
        PlanChange::PathOfZ => way("path of z_axis over c_axis moved"),
        PlanChange::Infeed => way("infeed moved"),
        PlanChange::Stock => way("material above the contour at its beginning changed"),
        PlanChange::Start => turned("begins at another angle,"),
        PlanChange::Ratio => Some(format!("travel of x_axis per depth changed by {:+.3e}{at}", found.by())),
        PlanChange::Turns => change("turns", found.old, found.new, ""),
        PlanChange::Speed => {
            let rpm = [found.old, found.new].map(rpm_from_rad_s);
            Some(format!("speed of c_axis {:.4} -> {:.4} rpm ({:+.4} rpm){at}", rpm[0], rpm[1], rpm[1] - rpm[0]))
        }
        PlanChange::Time => Some(format!("takes {:.3} -> {:.3} s ({:+.3} s)", found.old, found.new, found.by())),
        PlanChange::Words => Some("changed: a limit, an input, an order, or its end".to_owned()),
    }
}

impl fmt::Display for ReplanOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [old, new] = &self.hashes;
        match (self.is_same, old == new) {
            (true, true) => return write!(f, "the same plan {old:.12}"),
            (true, false) => return write!(f, "the same motions to the bit; plan {old:.12} is {new:.12} now"),
            _ => {}
        }
        let [before, after] = self.duration_s;
        write!(f, "plan {old:.12} is {new:.12} now, {before:.3} -> {after:.3} s ({:+.3} s)", after - before)?;
        for line in &self.lines {
            write!(f, "\n    {}: {}", line.step, line.text)?;
        }
        if self.within > 0 {
            write!(f, "\n    {} more within the tolerance", self.within)?;
        }
        Ok(())
    }
}
