// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Plunges side by side over a lobe that is wider than the wheel.

use super::chart::{HALF_MM, SMALL};
use super::sheet::{ROOM, Sheet};
use crate::chart::{Frame, Scale};
use crate::drawing::{Anchor, Colour, Drawing, Lettering, Pen};
use camwright::planner::LobeDesign;

const FRAME: Pen = Pen::solid(Colour::BLACK, 0.25);
const EDGE: Pen = Pen::dashed(Colour::GREY, 0.15);
const WHEEL: Colour = Colour(0, 114, 178);
const OBSTACLE: Colour = Colour(165, 165, 165);
/// Sections that one, two and three plunges cut.
const METAL: [Colour; 3] = [Colour(240, 240, 236), Colour(222, 222, 210), Colour(200, 200, 182)];

/// Room of the wheels above the lobe (mm), largest height of a wheel, and smallest with room for its name.
const WHEELS_MM: f64 = 88.0;
const ROW_MM: f64 = 26.0;
const NAMED_ROW_MM: f64 = 4.2;

/// Share of the lobe's width that is seen on either side.
const BESIDE: f64 = 0.12;

/// The wheel of every plunge over the lobe, and the sections that they leave; `None` for a lobe that the wheel covers.
pub(super) fn drawing(sheet: &Sheet<'_>) -> Option<Drawing> {
    let (prepared, plunge) = (sheet.prepared, sheet.summary.plunge.as_ref()?);
    let designs = prepared.planned.lobes.iter().map(|lobe| &lobe.design);
    let plunges: Vec<&LobeDesign> =
        designs.filter(|design| design.plunge.as_ref().is_some_and(|other| other.lobe == plunge.lobe)).collect();
    let own = &prepared.planned.lobes[sheet.index].design;
    let middle_mm = own.z_mm(&prepared.machine)? - own.offset_mm();
    let lobe_mm = own.plunge.as_ref()?.lobe_width_mm;
    let shows = format!(
        "lobe {}, {lobe_mm} mm wide: {} plunges of a wheel of {} mm, which overlap by {:.3} mm",
        plunge.lobe, plunge.count, own.width_mm, plunge.overlap_mm
    );
    let mut drawing = sheet.begin(None, &shows);
    let half_mm = (0.5 + BESIDE) * lobe_mm;
    let along = Along { frame: ROOM, low_mm: middle_mm - half_mm, high_mm: middle_mm + half_mm };
    let wheels_end = ROOM.top + WHEELS_MM;
    let row_mm = (WHEELS_MM / plunges.len() as f64).min(ROW_MM);
    for (row, design) in plunges.iter().enumerate() {
        let z_mm = design.z_mm(&prepared.machine)?;
        let top = wheels_end - row_mm * (plunges.len() - row) as f64;
        let [left, right] = [-0.5, 0.5].map(|side| along.x(z_mm + side * design.width_mm));
        let is_own = design.name == own.name;
        let (low, high) = (top + 0.1 * row_mm, top + 0.9 * row_mm);
        let corners = [[left, low], [right, low], [right, high], [left, high], [left, low]];
        drawing.area(&corners, WHEEL.tint(if is_own { 0.55 } else { 0.15 }));
        drawing.line(&corners, Pen::solid(WHEEL, if is_own { 0.5 } else { 0.2 }));
        for x in [left, right] {
            drawing.line(&[[x, high], [x, ROOM.bottom()]], EDGE);
        }
        let name = format!("{} at {z_mm:.3} mm", design.name);
        if row_mm >= NAMED_ROW_MM && SMALL.width_mm(&name) < right - left - 2.0 {
            drawing.text([0.5 * (left + right), 0.5 * (low + high) + HALF_MM], SMALL, &name);
        }
    }
    let (top, bottom) = (wheels_end + 2.0, ROOM.bottom());
    for section in plunges.iter().flat_map(|design| design.sections()) {
        let [left, right] = [-0.5, 0.5].map(|side| along.x(middle_mm + section.offset_mm + side * section.width_mm));
        let at_mm = middle_mm + section.offset_mm;
        let covers = |design: &&&LobeDesign| {
            design.z_mm(&prepared.machine).is_some_and(|z_mm| (z_mm - at_mm).abs() < 0.5 * design.width_mm)
        };
        let count = plunges.iter().filter(covers).count().clamp(1, METAL.len());
        let corners = [[left, top], [right, top], [right, bottom], [left, bottom], [left, top]];
        drawing.area(&corners, METAL[count - 1]);
        drawing.line(&corners, FRAME);
        if SMALL.width_mm(&section.name) < right - left - 2.0 {
            drawing.text([0.5 * (left + right), 0.5 * (top + bottom) + HALF_MM], SMALL, &section.name);
        }
    }
    for obstacle in &prepared.job.spec.obstacles {
        let (from, to) = (obstacle.extent.from_mm.max(along.low_mm), obstacle.extent.to_mm.min(along.high_mm));
        if from < to {
            let (left, right) = (along.x(from), along.x(to));
            drawing.area(&[[left, top], [right, top], [right, bottom], [left, bottom]], OBSTACLE);
        }
    }
    along.axis(&mut drawing);
    let text = Lettering { anchor: Anchor::Start, ..SMALL };
    let about =
        "blue: the wheel of every plunge; below: sections of the lobe, darker where more plunges cut; grey: obstacles";
    drawing.text([ROOM.left, 192.0], text, about);
    Some(drawing)
}

/// A length of Z on the paper.
struct Along {
    frame: Frame,
    low_mm: f64,
    high_mm: f64,
}

impl Along {
    fn x(&self, z_mm: f64) -> f64 {
        self.frame.left + self.frame.width * (z_mm - self.low_mm) / (self.high_mm - self.low_mm)
    }

    fn axis(&self, drawing: &mut Drawing) {
        let (frame, scale) = (self.frame, Scale::exactly(self.low_mm, self.high_mm, self.frame.width / 14.0));
        for z_mm in scale.ticks() {
            let x = self.x(z_mm);
            drawing.line(&[[x, frame.bottom()], [x, frame.bottom() - 1.2]], FRAME);
            drawing.text([x, frame.bottom() + 4.0], SMALL, &scale.label(z_mm));
        }
        let middle = frame.left + 0.5 * frame.width;
        drawing.text([middle, frame.bottom() + 8.8], SMALL, "position of the table (mm)");
        drawing.line(&frame.corners(), FRAME);
    }
}
