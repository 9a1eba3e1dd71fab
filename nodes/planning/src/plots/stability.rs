// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Stability lobes: width of cut at which chatter begins, over the work speed.

use super::chart::{CURVE_MM, TurnChart};
use super::sheet::{Legend, ROOM, sheet};
use crate::chart::{Axes, Scale};
use crate::chatter::{ChatterReport, PassChatter};
use crate::drawing::{Colour, Drawing, Pen};
use camwright::math::units::rpm_from_rad_s;

/// Work speeds along the chart.
const SPEEDS: u32 = 1200;

/// Height of the chart, relative to the larger of planned and unconditional width.
const HEADROOM: f64 = 2.5;

const BOUNDARY: Pen = Pen::solid(Colour(0, 114, 178), CURVE_MM);
const UNCONDITIONAL: Pen = Pen::dashed(Colour(0, 158, 115), CURVE_MM);
const PLANNED: Pen = Pen::solid(Colour(213, 94, 0), 0.6);

/// Drawing of the lobes of one pass, with the planned cut.
pub(crate) fn stability_plot(report: &ChatterReport, pass: &PassChatter) -> Drawing {
    let state = if pass.is_stable { "stable" } else { "chatters" };
    let title = format!("{} · lobe {} · pass {}", report.job, pass.lobe, pass.pass);
    let shows = format!(
        "Stability lobes: width of cut at which chatter begins. The cut of {:.1} mm at {:.1} rpm {}.",
        pass.width_mm,
        pass.work_speed_rpm,
        if pass.is_stable { "is stable" } else { state }
    );
    let made_of = format!("machine {}, stiffness of the cut {:.0} N/mm per mm", report.machine, pass.grinding_n_mm2);
    let mut drawing = sheet(&title, &shows, &made_of, "camwright chatter");
    let [slowest, fastest] = [pass.range.slowest_rad_s, pass.range.fastest_rad_s].map(rpm_from_rad_s);
    let highest = HEADROOM * pass.width_mm.max(pass.unconditional_width_mm.unwrap_or(0.0));
    let axes =
        Axes { frame: ROOM, across: Scale::exactly(slowest, fastest, 12.0), up: Scale::exactly(0.0, highest, 8.0) };
    let chart = TurnChart(axes);
    chart.axes_over(&mut drawing, "width of cut (mm)", Some("work speed (rpm)"));
    let lobes = pass.forecast.lobes(pass.range, SPEEDS);
    let boundary =
        lobes.points.iter().map(|point| (rpm_from_rad_s(point.speed_rad_s), point.grinding_n_mm / pass.grinding_n_mm2));
    chart.curve(&mut drawing, boundary, BOUNDARY);
    if let Some(width_mm) = pass.unconditional_width_mm {
        chart.curve(&mut drawing, [(slowest, width_mm), (fastest, width_mm)].into_iter(), UNCONDITIONAL);
    }
    let [x, y] = axes.at(pass.work_speed_rpm, pass.width_mm);
    drawing.line(&[[x - 2.0, y], [x + 2.0, y]], PLANNED);
    drawing.line(&[[x, y - 2.0], [x, y + 2.0]], PLANNED);
    let mut legend = Legend::new();
    legend.line(&mut drawing, "chatter begins", BOUNDARY);
    legend.line(&mut drawing, "below: stable at every speed", UNCONDITIONAL);
    legend.line(&mut drawing, &format!("planned cut: {state}"), PLANNED);
    drawing
}
