// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Text of `camwright plan` for a turned part.

use camwright::machine::description::Axis;
use camwright_planning::{TurnedLimitSummary, TurnedPassSummary, TurningSummary, turning_notes};

/// Verdict and one line for each pass.
pub(super) fn as_text(summary: &TurningSummary) -> String {
    let mut text = format!(
        "PLANNED: {}, {} passes, {:.3} s, plan {:.12}\n{:<4} {:>8} {:>14} {:>7} {:>8} {:>13} {:>7}  {}\n",
        summary.job,
        summary.passes.len(),
        summary.duration_s,
        summary.plan_hash,
        "pass",
        "depth mm",
        "feed mm",
        "turns",
        "cut s",
        "rpm",
        "cusp um",
        "slide limit"
    );
    for (index, pass) in summary.passes.iter().enumerate() {
        let [slowest, fastest] = pass.spindle_rpm;
        text += &format!(
            "{:<4} {:>8.3} {:>14} {:>7.1} {:>8.3} {:>13} {:>7.3}  {}\n",
            index + 1,
            pass.depth_mm,
            format!("{} per {}", pass.feed_mm, pass.feed_along),
            pass.turns,
            pass.cut_s,
            format!("{slowest:.1}-{fastest:.1}"),
            pass.cusp_um,
            highest_ratio(pass).map_or_else(String::new, |limit| format!("{:.1} %", 100.0 * limit.ratio)),
        );
    }
    text
}

/// Limits, strokes, hollows, and the position of the insert.
pub(super) fn details(summary: &TurningSummary) -> String {
    let mut text =
        format!("\n{:<5} {:>12} {:>11}  {}\n", "pass", "remaining mm", "X stroke mm", "highest limit use of a slide");
    for (index, pass) in summary.passes.iter().enumerate() {
        let limit = highest_ratio(pass).map_or_else(String::new, |limit| {
            format!("{} of {} at C {:.1} deg, z {:.2} mm", limit.quantity, limit.axis, limit.c_deg, limit.z_mm)
        });
        text += &format!("{:<5} {:>12.3} {:>11.3}  {limit}\n", index + 1, pass.leaves_mm, pass.x_stroke_mm);
    }
    text += &format!("\n{:<5} limits of the spindle speed, share of the path\n", "pass");
    for (index, pass) in summary.passes.iter().enumerate() {
        let bounds: Vec<String> =
            pass.bounds.iter().map(|bound| format!("{} {:.0} %", bound.bound, 100.0 * bound.share)).collect();
        text += &format!("{:<5} {}\n", index + 1, bounds.join("; "));
    }
    text.push('\n');
    for (index, pass) in summary.passes.iter().enumerate() {
        if let Some(hollow) = &pass.hollow {
            text += &format!(
                "pass {} bridges a hollow of radius {:.3} mm (insert with stock: {:.3} mm) at C {:.1} deg, z {:.3} mm; {:.2} um remain in it\n",
                index + 1,
                hollow.radius_mm,
                hollow.bound_mm,
                hollow.c_deg,
                hollow.z_mm,
                hollow.left_um
            );
        }
    }
    for note in turning_notes(summary) {
        text += &note;
        text.push('\n');
    }
    text + &format!("plan hash {}\n", summary.plan_hash)
}

/// The slide limit with the highest use. C uses all of its acceleration when it starts, whatever the path.
fn highest_ratio(pass: &TurnedPassSummary) -> Option<&TurnedLimitSummary> {
    let slides = pass.limits.iter().filter(|limit| limit.axis != Axis::C.joint());
    slides.max_by(|a, b| a.ratio.total_cmp(&b.ratio))
}
