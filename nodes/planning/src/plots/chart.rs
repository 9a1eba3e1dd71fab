// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Charts over one turn of `c_axis` on paper, and the axes of what is drawn to scale.

use super::contour::PartView;
use crate::chart::{Axes, Frame, Scale};
use crate::drawing::{Anchor, Colour, Drawing, Lettering, Pen};

const FRAME: Pen = Pen::solid(Colour::BLACK, 0.25);
const GRID: Pen = Pen::solid(Colour::PALE, 0.12);
pub(super) const CURVE_MM: f64 = 0.45;

pub(super) const SMALL: Lettering = Lettering {
    height_mm: Lettering::SMALLEST_MM,
    anchor: Anchor::Middle,
    colour: Colour::BLACK,
    is_bold: false,
    is_upright: false,
};

/// Half the height of a small capital: a number beside its tick.
pub(super) const HALF_MM: f64 = 0.5 * Lettering::SMALLEST_MM;

/// Minimum distance of two ticks of an axis upwards, and of one to the right (mm): their numbers must not touch.
const TICK_UP_MM: f64 = 4.0;
const TICK_ACROSS_MM: f64 = 14.0;

/// Distance of the name of an axis from its frame (mm): to the left, and below.
const NAME_LEFT_MM: f64 = 19.0;
const NAME_BELOW_MM: f64 = 8.8;

/// Values over the angle of C.
#[derive(Debug, Clone, Copy)]
pub(super) struct TurnChart(pub(super) Axes);

impl TurnChart {
    pub(super) fn new(frame: Frame, up: Scale) -> Self {
        Self(Axes { frame, across: Scale::TURN_DEG, up: up.with_steps(frame.height / TICK_UP_MM) })
    }

    /// Values over another angle than a turn (deg).
    pub(super) fn over(frame: Frame, (from_deg, to_deg): (f64, f64), up: Scale) -> Self {
        let turn = from_deg.abs() < 1e-6 && (to_deg - 360.0).abs() < 1e-6;
        let step = Scale::TURN_DEG.step * ((to_deg - from_deg) / 360.0).ceil().max(1.0);
        let across = if turn { Scale::TURN_DEG } else { Scale { low: from_deg, high: to_deg, step } };
        Self(Axes { frame, across, up: up.with_steps(frame.height / TICK_UP_MM) })
    }

    /// Grid, frame, ticks; numbers of the angle where it is the lowest of its sheet.
    pub(super) fn axes(&self, drawing: &mut Drawing, label: &str, is_lowest: bool) {
        self.axes_over(drawing, label, is_lowest.then_some("angle of C axis (deg)"));
    }

    /// The same over an angle with a name of its own.
    pub(super) fn axes_over(&self, drawing: &mut Drawing, label: &str, angle: Option<&str>) {
        let Axes { frame, across, up } = self.0;
        for deg in across.ticks() {
            let x = self.0.x(deg);
            drawing.line(&[[x, frame.top], [x, frame.bottom()]], GRID);
            drawing.line(&[[x, frame.bottom()], [x, frame.bottom() - 1.2]], FRAME);
            if angle.is_some() {
                drawing.text([x, frame.bottom() + 4.0], SMALL, &across.label(deg));
            }
        }
        if let Some(angle) = angle {
            let middle = frame.left + 0.5 * frame.width;
            drawing.text([middle, frame.bottom() + NAME_BELOW_MM], SMALL, angle);
        }
        for value in up.ticks() {
            let y = self.0.y(value);
            drawing.line(&[[frame.left, y], [frame.right(), y]], GRID);
            drawing.line(&[[frame.left, y], [frame.left + 1.2, y]], FRAME);
            let number = Lettering { anchor: Anchor::End, ..SMALL };
            drawing.text([frame.left - 1.2, y + HALF_MM], number, &up.label(value));
        }
        if self.0.zero().is_some() {
            self.level(drawing, 0.0, Pen::solid(Colour::GREY, 0.18));
        }
        let upright = Lettering { is_upright: true, ..SMALL };
        drawing.text([frame.left - NAME_LEFT_MM, frame.top + 0.5 * frame.height], upright, label);
        drawing.line(&frame.corners(), FRAME);
    }

    /// A second scale above: cam angles, of which `c_deg` gives the angle of C.
    pub(super) fn cam_angles(&self, drawing: &mut Drawing, c_deg: impl Fn(f64) -> f64) {
        let Frame { left, top, .. } = self.0.frame;
        // The last tick of a turn is the first one.
        for cam_deg in self.0.across.ticks().filter(|deg| *deg < 360.0) {
            let x = self.0.x(c_deg(cam_deg).rem_euclid(360.0));
            drawing.line(&[[x, top], [x, top - 1.2]], FRAME);
            drawing.text([x, top - 2.0], Lettering { colour: Colour::GREY, ..SMALL }, &self.0.across.label(cam_deg));
        }
        let name = Lettering { anchor: Anchor::End, colour: Colour::GREY, ..SMALL };
        drawing.text([left - 5.5, top - 2.0], name, "cam angle");
    }

    /// A curve through points of angle and value, within the frame.
    pub(super) fn curve(&self, drawing: &mut Drawing, points: impl Iterator<Item = (f64, f64)>, pen: Pen) {
        for line in self.0.lines(points, f64::INFINITY) {
            drawing.line(&line, pen);
        }
    }

    /// A line at one value.
    pub(super) fn level(&self, drawing: &mut Drawing, value: f64, pen: Pen) {
        let across = self.0.across;
        self.curve(drawing, [(across.low, value), (across.high, value)].into_iter(), pen);
    }
}

/// Axes in mm around a view of the part that is not turned: both have the scale of the view.
pub(super) fn plane_axes(drawing: &mut Drawing, view: &PartView, across: &str, up: &str) {
    let frame = view.frame;
    let at_left = (frame.left - view.centre[0]) / view.scale;
    let at_bottom = (view.centre[1] - frame.bottom()) / view.scale;
    let right = Scale::exactly(at_left, at_left + frame.width / view.scale, frame.width / TICK_ACROSS_MM);
    let upward = Scale::exactly(at_bottom, at_bottom + frame.height / view.scale, frame.height / 10.0);
    // One step for both: squares stay squares.
    let step = right.step.max(upward.step);
    let (right, upward) = (Scale { step, ..right }, Scale { step, ..upward });
    for value in right.ticks() {
        let x = view.centre[0] + view.scale * value;
        drawing.line(&[[x, frame.bottom()], [x, frame.bottom() - 1.2]], FRAME);
        drawing.text([x, frame.bottom() + 4.0], SMALL, &right.label(value));
    }
    for value in upward.ticks() {
        let y = view.centre[1] - view.scale * value;
        drawing.line(&[[frame.left, y], [frame.left + 1.2, y]], FRAME);
        let number = Lettering { anchor: Anchor::End, ..SMALL };
        drawing.text([frame.left - 1.2, y + HALF_MM], number, &upward.label(value));
    }
    drawing.text([frame.left + 0.5 * frame.width, frame.bottom() + NAME_BELOW_MM], SMALL, across);
    let upright = Lettering { is_upright: true, ..SMALL };
    drawing.text([frame.left - 15.0, frame.top + 0.5 * frame.height], upright, up);
    drawing.line(&frame.corners(), FRAME);
}

/// A length to measure by, from a point to the right, with its number above.
pub(super) fn scale_bar(drawing: &mut Drawing, [x, y]: [f64; 2], length_mm: f64, scale: f64) {
    let end = x + scale * length_mm;
    drawing.line(&[[x, y - 1.2], [x, y], [end, y], [end, y - 1.2]], Pen::solid(Colour::BLACK, 0.4));
    drawing.text([end + 2.0, y], Lettering { anchor: Anchor::Start, ..SMALL }, &format!("{length_mm} mm"));
}
