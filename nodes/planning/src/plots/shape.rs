// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Taper and crown of a lobe over its width, and the rim of the wheel that grinds them.

use super::chart::{CURVE_MM, SMALL, TurnChart};
use super::sheet::{Legend, ROOM, Sheet};
use crate::chart::{Axes, Scale};
use crate::drawing::{Colour, Drawing, Pen};
use camwright::math::units::um_from_mm;

const RIM: Pen = Pen::solid(Colour(0, 114, 178), CURVE_MM);
const LOBE: Pen = Pen::solid(Colour(213, 94, 0), CURVE_MM);
const GROUND: Pen = Pen::dashed(Colour(0, 158, 115), CURVE_MM);
const ZERO: Pen = Pen::solid(Colour::GREY, 0.18);
/// Sections in turn.
const METAL: [Colour; 2] = [Colour(240, 240, 236), Colour(222, 222, 210)];

/// Share of the wheel's width that is seen on either side.
const BESIDE: f64 = 0.04;

/// Points of a curve.
const POINTS: u32 = 200;

/// Rim and lobe over z; `None` of a lobe without taper and crown.
pub(super) fn drawing(sheet: &Sheet<'_>) -> Option<Drawing> {
    let (machine, shape) = (&sheet.prepared.machine, sheet.summary.shape.as_ref()?);
    let design = &sheet.prepared.planned.lobes[sheet.index].design;
    let (wheel, axial) = (machine.wheel_at(design.wheel(machine)), design.axial?);
    let (wheel_mm, lobe_mm) = (wheel.width_mm, design.width_mm);
    let shows = format!(
        "lobe {}, {lobe_mm} mm wide: taper {:+.3} µm, crown {:+.3} µm; the rim grinds {:+.3} µm and {:+.3} µm",
        design.name, shape.taper_um, shape.crown_um, shape.rim_taper_um, shape.rim_crown_um
    );
    let mut drawing = sheet.begin(None, &shows);
    let over = |width_mm: f64, height_um: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        let at_mm = |point: u32| (f64::from(point) / f64::from(POINTS) - 0.5) * width_mm;
        (0..=POINTS).map(|point| (at_mm(point), height_um(at_mm(point)))).collect()
    };
    let rim = over(wheel_mm, &|z_mm| um_from_mm(wheel.rim_mm(z_mm)));
    let lobe = over(lobe_mm, &|z_mm| um_from_mm(axial.height_mm(z_mm, lobe_mm)));
    let ground = over(lobe_mm, &|z_mm| -um_from_mm(wheel.rim_mm(z_mm)));
    let half_mm = (0.5 + BESIDE) * wheel_mm;
    let heights = rim.iter().chain(&lobe).chain(&ground).map(|point| point.1);
    let up = Scale::around(heights).with_steps(20.0);
    let axes = Axes { frame: ROOM, across: Scale::exactly(-half_mm, half_mm, 14.0), up };
    for (index, section) in shape.sections.iter().enumerate() {
        let [left, right] = [-0.5, 0.5].map(|side| axes.x(section.offset_mm + side * section.width_mm));
        let (top, bottom) = (ROOM.top, ROOM.bottom());
        drawing.area(&[[left, top], [right, top], [right, bottom], [left, bottom]], METAL[index % METAL.len()]);
        if SMALL.width_mm(&section.name) < right - left {
            drawing.text([0.5 * (left + right), top + 4.0], SMALL, &section.name);
        }
    }
    let chart = TurnChart(axes);
    chart.axes_over(
        &mut drawing,
        "height (µm)",
        Some("position from the middle of the wheel, towards the tailstock (mm)"),
    );
    chart.curve(&mut drawing, [(-half_mm, 0.0), (half_mm, 0.0)].into_iter(), ZERO);
    let mut legend = Legend::new();
    for (points, pen, text) in [
        (rim, RIM, "rim of the wheel: radius minus that in its middle"),
        (lobe, LOBE, "lobe: distance outside the contour"),
        (ground, GROUND, "lobe as the rim grinds it; bands: sections"),
    ] {
        chart.curve(&mut drawing, points.into_iter(), pen);
        legend.line(&mut drawing, text, pen);
    }
    Some(drawing)
}
