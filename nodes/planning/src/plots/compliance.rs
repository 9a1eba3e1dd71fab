// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Compliance of a slender part along Z, with its supports and lobes.

use super::chart::{CURVE_MM, SMALL, TurnChart};
use super::sheet::{Legend, ROOM, Sheet};
use crate::chart::{Axes, Scale};
use crate::drawing::{Colour, Drawing, Pen};
use crate::part_support;
use camwright::job::supported_shaft::SupportedShaft;
use camwright::math::units::um_from_mm;

const HELD: Pen = Pen::solid(Colour(0, 114, 178), CURVE_MM);
const WITHOUT_REST: Pen = Pen::dashed(Colour(213, 94, 0), CURVE_MM);
const SUPPORT: Pen = Pen::solid(Colour::BLACK, 0.4);
const LOBE: Colour = Colour(240, 240, 236);
const OWN_LOBE: Colour = Colour(200, 200, 182);

/// Share of the length that is seen on either side.
const BESIDE: f64 = 0.03;

/// Points of a curve.
const POINTS: u32 = 400;

/// Half the width and the height of the mark of a support (mm).
const MARK_MM: (f64, f64) = (2.0, 3.5);

/// Compliance of the part over the length between its supports; `None` of a job without `part_support`.
pub(super) fn drawing(sheet: &Sheet<'_>) -> Option<Drawing> {
    let (prepared, shaft) = (sheet.prepared, part_support::shaft(sheet.prepared)?);
    let own = part_support::at_lobe(prepared, sheet.index)?;
    let shows = format!(
        "Radial compliance of the part on its supports: {:.4} µm/N at the lobe, {:.1} N/µm with the machine",
        own.part_compliance_um_n, own.stiffness_n_um
    );
    let mut drawing = sheet.begin(None, &shows);
    let (low_mm, high_mm) = shaft.ends_mm();
    let compliance = |shaft: SupportedShaft| {
        (0..=POINTS).map(move |point| {
            let z_mm = low_mm + (high_mm - low_mm) * f64::from(point) / f64::from(POINTS);
            (z_mm, um_from_mm(shaft.compliance_mm_n(z_mm)))
        })
    };
    let without = shaft.rest_mm().map(|_| shaft.without_rest());
    let highest = without.into_iter().chain([shaft]).flat_map(compliance).map(|point| point.1).fold(0.0, f64::max);
    let up = Scale::exactly(0.0, 1.1 * highest, 8.0);
    let beside_mm = BESIDE * (high_mm - low_mm);
    let across = Scale::exactly(low_mm - beside_mm, high_mm + beside_mm, 12.0);
    let axes = Axes { frame: ROOM, across, up };
    for (index, lobe) in prepared.planned.lobes.iter().enumerate() {
        let z_mm = lobe.design.z_mm(&prepared.machine)?;
        let [left, right] = [-0.5, 0.5].map(|side| axes.x(z_mm + side * lobe.design.width_mm));
        let colour = if index == sheet.index { OWN_LOBE } else { LOBE };
        let (top, bottom) = (ROOM.top, ROOM.bottom());
        drawing.area(&[[left, top], [right, top], [right, bottom], [left, bottom]], colour);
        if SMALL.width_mm(&lobe.design.name) < right - left {
            drawing.text([0.5 * (left + right), top + 4.0], SMALL, &lobe.design.name);
        }
    }
    let chart = TurnChart(axes);
    chart.axes_over(&mut drawing, "compliance of the part (µm/N)", Some("position of the table (mm)"));
    let mut legend = Legend::new();
    legend.line(&mut drawing, "on its supports", HELD);
    if let Some(without) = without {
        chart.curve(&mut drawing, compliance(without), WITHOUT_REST);
        legend.line(&mut drawing, "without steady rest", WITHOUT_REST);
    }
    chart.curve(&mut drawing, compliance(shaft), HELD);
    let support = prepared.job.spec.part_support?;
    let ends = [Some(low_mm), support.tailstock.then_some(high_mm), shaft.rest_mm()];
    for z_mm in ends.into_iter().flatten() {
        let (x, y) = (axes.x(z_mm), ROOM.bottom());
        let (half, height) = MARK_MM;
        drawing.line(&[[x - half, y], [x, y - height], [x + half, y]], SUPPORT);
    }
    legend.line(&mut drawing, "supports: headstock, steady rest, tailstock; bands: lobes", SUPPORT);
    Some(drawing)
}
