//! Charts over one turn of `c_axis` on paper.

use crate::chart::{Axes, Frame, Scale};
use crate::drawing::{Anchor, Colour, Drawing, Lettering, Pen};

const FRAME: Pen = Pen::solid(Colour::BLACK, 0.25);
const GRID: Pen = Pen::solid(Colour::PALE, 0.12);
pub(super) const CURVE_MM: f64 = 0.45;

pub(super) const SMALL: Lettering =
    Lettering { height_mm: 2.1, anchor: Anchor::Middle, colour: Colour::BLACK, is_bold: false, is_upright: false };

/// Values over the angle of C.
#[derive(Debug, Clone, Copy)]
pub(super) struct TurnChart(pub(super) Axes);

impl TurnChart {
    pub(super) fn new(frame: Frame, up: Scale) -> Self {
        Self(Axes { frame, across: Scale::TURN_DEG, up })
    }

    /// Grid, frame, ticks; numbers of the angle where it is the lowest of its sheet.
    pub(super) fn axes(&self, drawing: &mut Drawing, label: &str, is_lowest: bool) {
        let Axes { frame, across, up } = self.0;
        for deg in across.ticks() {
            let x = self.0.x(deg);
            drawing.line(&[[x, frame.top], [x, frame.bottom()]], GRID);
            drawing.line(&[[x, frame.bottom()], [x, frame.bottom() - 1.2]], FRAME);
            if is_lowest {
                drawing.text([x, frame.bottom() + 3.6], SMALL, &across.label(deg));
            }
        }
        if is_lowest {
            let middle = frame.left + 0.5 * frame.width;
            drawing.text(
                [middle, frame.bottom() + 8.0],
                Lettering { height_mm: 2.5, ..SMALL },
                "angle of C axis (deg)",
            );
        }
        for value in up.ticks() {
            let y = self.0.y(value);
            drawing.line(&[[frame.left, y], [frame.right(), y]], GRID);
            drawing.line(&[[frame.left, y], [frame.left + 1.2, y]], FRAME);
            let number = Lettering { anchor: Anchor::End, ..SMALL };
            drawing.text([frame.left - 1.2, y + 0.8], number, &up.label(value));
        }
        if self.0.zero().is_some() {
            self.level(drawing, 0.0, Pen::solid(Colour::GREY, 0.18));
        }
        let upright = Lettering { height_mm: 2.5, is_upright: true, ..SMALL };
        drawing.text([frame.left - 17.0, frame.top + 0.5 * frame.height], upright, label);
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
        self.curve(drawing, [(0.0, value), (360.0, value)].into_iter(), pen);
    }
}
