// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Infeed of all passes of a lobe over the turns of C.

use super::chart::{CURVE_MM, SMALL, TurnChart};
use super::sheet::{Legend, ROOM, Sheet};
use crate::chart::{Axes, Scale};
use crate::drawing::{Colour, Drawing, Pen};
use camwright::math::units::{TURN_RAD, um_from_mm};
use camwright::motion::speed_plan::SpeedPlan;

const OFFSET: Pen = Pen::solid(Colour(0, 114, 178), CURVE_MM);
const PASS: Pen = Pen::dashed(Colour::GREY, 0.2);
const SPARK_OUT: Colour = Colour(240, 240, 236);

/// Points of a curve in each turn.
const POINTS: u32 = 60;

/// Distance of X from the finished path over the turns of all passes; `None` of a single pass with the same infeed in every turn and
/// spark-out.
pub(super) fn drawing(sheet: &Sheet<'_>) -> Option<Drawing> {
    let passes = &sheet.prepared.planned.lobes.get(sheet.index)?.passes;
    let sparks_out = |pass: &SpeedPlan| pass.turns() > pass.infeed().schedule().turns();
    let is_plain = |pass: &SpeedPlan| pass.infeed().schedule().each_mm().is_empty() && sparks_out(pass);
    if passes.len() == 1 && passes.iter().all(is_plain) {
        return None;
    }
    let turns: u32 = passes.iter().map(SpeedPlan::turns).sum();
    let begins_um = um_from_mm(passes.first()?.infeed().law().sample(0.0).value);
    let shows = format!(
        "distance of X from the finished path over {turns} turns of all passes, {begins_um:.2} µm at the start"
    );
    let mut drawing = sheet.begin(None, &shows);
    let across = Scale::exactly(0.0, f64::from(turns), ROOM.width / 14.0);
    let axes = Axes { frame: ROOM, across, up: Scale::exactly(0.0, 1.05 * begins_um, ROOM.height / 8.0) };
    let chart = TurnChart(axes);
    let mut from = 0;
    for (pass, summary) in passes.iter().zip(&sheet.summary.passes) {
        let infeed_ends = axes.x(f64::from(from + pass.infeed().schedule().turns()));
        let [left, right] = [from, from + pass.turns()].map(|turn| axes.x(f64::from(turn)));
        let (top, bottom) = (ROOM.top, ROOM.bottom());
        drawing.area(&[[infeed_ends, top], [right, top], [right, bottom], [infeed_ends, bottom]], SPARK_OUT);
        drawing.line(&[[right, top], [right, bottom]], PASS);
        if SMALL.width_mm(&summary.name) < right - left - 1.0 {
            drawing.text([0.5 * (left + right), top + 4.0], SMALL, &summary.name);
        }
        from += pass.turns();
    }
    chart.axes_over(&mut drawing, "distance from the finished path (µm)", Some("turns of C axis"));
    from = 0;
    for pass in passes {
        let points = (0..=pass.turns() * POINTS).map(|point| {
            let turned = f64::from(point) / f64::from(POINTS);
            let offset_um = um_from_mm(pass.infeed().law().sample(turned * TURN_RAD).value);
            (f64::from(from) + turned, offset_um.min(begins_um))
        });
        chart.curve(&mut drawing, points, OFFSET);
        from += pass.turns();
    }
    let mut legend = Legend::new();
    legend.line(&mut drawing, "distance from the finished path", OFFSET);
    legend.line(&mut drawing, "end of a pass; bands: turns without infeed", PASS);
    Some(drawing)
}
