//! A chart over one turn of `c_axis`: frame, ticks at round numbers, curves.

use super::super::turn_summary::round_step;
use crate::drawing::{Anchor, Colour, Drawing, Lettering, Pen, Point};

/// Angles of C that have a tick (deg).
const TICK_DEG: usize = 30;

/// Most steps of a value axis.
const MOST_STEPS: f64 = 7.5;

const FRAME: Pen = Pen::solid(Colour::BLACK, 0.25);
const GRID: Pen = Pen::solid(Colour::PALE, 0.12);
pub(super) const CURVE_MM: f64 = 0.45;

pub(super) const SMALL: Lettering =
    Lettering { height_mm: 2.1, anchor: Anchor::Middle, colour: Colour::BLACK, is_bold: false, is_upright: false };

/// A rectangle on the paper (mm).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Frame {
    pub(super) fn right(&self) -> f64 {
        self.left + self.width
    }

    pub(super) fn bottom(&self) -> f64 {
        self.top + self.height
    }

    pub(super) fn corners(&self) -> [Point; 5] {
        let (left, right, top, bottom) = (self.left, self.right(), self.top, self.bottom());
        [[left, top], [right, top], [right, bottom], [left, bottom], [left, top]]
    }
}

/// Room beyond the outermost values, as a share of their range, so that a limit does not lie on the frame; 0 stays an end.
const ROOM_BEYOND: f64 = 0.06;

/// A value axis with ticks at round numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    pub low: f64,
    pub high: f64,
    pub(super) step: f64,
}

impl Scale {
    /// One that has these values; equal values get room on both sides.
    pub fn around(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        let (low, high) = if low > high { (0.0, 0.0) } else { (low, high) };
        let least = 1e-6 * low.abs().max(high.abs()).max(1e-6);
        let (low, high) = if high - low > least { (low, high) } else { (low - 1.0, high + 1.0) };
        let room = |end: f64| if end.abs() > 0.0 { ROOM_BEYOND * (high - low) } else { 0.0 };
        let (low, high) = (low - room(low), high + room(high));
        Self { low, high, step: round_step(high - low, MOST_STEPS) }
    }

    /// A tick's number with the digits of the step.
    pub fn label(&self, value: f64) -> String {
        #[allow(clippy::cast_possible_truncation, reason = "between 0 and 12")]
        let digits = (-(self.step * 1.0001).log10().floor()).clamp(0.0, 12.0) as usize;
        let text = format!("{value:.digits$}");
        match text.strip_prefix('-') {
            Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.into(),
            Some(rest) => format!("−{rest}"),
            None => text,
        }
    }

    pub fn ticks(&self) -> impl Iterator<Item = f64> {
        let (step, first) = (self.step, (self.low / self.step - 1e-9).ceil());
        #[allow(clippy::cast_possible_truncation, reason = "some seven")]
        let count = ((self.high / step + 1e-9).floor() - first).max(0.0) as u32;
        (0..=count).map(move |index| (first + f64::from(index)) * step)
    }
}

/// Values over the angle of C.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chart {
    pub(super) frame: Frame,
    pub(super) scale: Scale,
}

impl Chart {
    /// Where a value stands.
    pub(super) fn at(&self, c_deg: f64, value: f64) -> Point {
        [self.frame.left + self.frame.width * c_deg / 360.0, self.height(value)]
    }

    fn height(&self, value: f64) -> f64 {
        self.frame.bottom() - self.frame.height * (value - self.scale.low) / (self.scale.high - self.scale.low)
    }

    /// Grid, frame, ticks; numbers of the angle where it is the lowest of its sheet.
    pub(super) fn axes(&self, drawing: &mut Drawing, label: &str, is_lowest: bool) {
        let frame = self.frame;
        for deg in (0..=360_u16).step_by(TICK_DEG).map(f64::from) {
            let [x, _] = self.at(deg, 0.0);
            drawing.line(&[[x, frame.top], [x, frame.bottom()]], GRID);
            drawing.line(&[[x, frame.bottom()], [x, frame.bottom() - 1.2]], FRAME);
            if is_lowest {
                drawing.text([x, frame.bottom() + 3.6], SMALL, &format!("{deg}"));
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
        for value in self.scale.ticks() {
            let y = self.height(value);
            drawing.line(&[[frame.left, y], [frame.right(), y]], GRID);
            drawing.line(&[[frame.left, y], [frame.left + 1.2, y]], FRAME);
            let number = Lettering { anchor: Anchor::End, ..SMALL };
            drawing.text([frame.left - 1.2, y + 0.8], number, &self.scale.label(value));
        }
        if self.scale.low < 0.0 && self.scale.high > 0.0 {
            self.level(drawing, 0.0, Pen::solid(Colour::GREY, 0.18));
        }
        let upright = Lettering { height_mm: 2.5, is_upright: true, ..SMALL };
        drawing.text([frame.left - 17.0, frame.top + 0.5 * frame.height], upright, label);
        drawing.line(&frame.corners(), FRAME);
    }

    /// A second scale above: cam angles, of which `c_deg` gives the angle of C.
    pub(super) fn cam_angles(&self, drawing: &mut Drawing, c_deg: impl Fn(f64) -> f64) {
        let top = self.frame.top;
        for cam_deg in (0..360_u16).step_by(TICK_DEG).map(f64::from) {
            let [x, _] = self.at(c_deg(cam_deg).rem_euclid(360.0), 0.0);
            drawing.line(&[[x, top], [x, top - 1.2]], FRAME);
            drawing.text([x, top - 2.0], Lettering { colour: Colour::GREY, ..SMALL }, &format!("{cam_deg}"));
        }
        let name = Lettering { anchor: Anchor::End, colour: Colour::GREY, ..SMALL };
        drawing.text([self.frame.left - 5.5, top - 2.0], name, "cam angle");
    }

    /// A curve through points of angle and value, where they lie within the frame.
    pub(super) fn curve(&self, drawing: &mut Drawing, points: impl Iterator<Item = (f64, f64)>, pen: Pen) {
        let mut line: Vec<Point> = Vec::new();
        let room = 1e-9 * (self.scale.high - self.scale.low);
        for (c_deg, value) in points {
            if (self.scale.low - room..=self.scale.high + room).contains(&value) {
                line.push(self.at(c_deg.clamp(0.0, 360.0), value));
            } else {
                drawing.line(&line, pen);
                line.clear();
            }
        }
        drawing.line(&line, pen);
    }

    /// The same value all the way.
    pub(super) fn level(&self, drawing: &mut Drawing, value: f64, pen: Pen) {
        self.curve(drawing, [(0.0, value), (360.0, value)].into_iter(), pen);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_has_its_values_inside_and_round_ticks() {
        for (low, high, ticks) in [
            (-9000.0, 9000.0, vec![-10_000.0, -5000.0, 0.0, 5000.0, 10_000.0]),
            (0.0, 10.0, vec![0.0, 2.0, 4.0, 6.0, 8.0, 10.0]),
            (20.3, 27.9, vec![20.0, 22.0, 24.0, 26.0, 28.0]),
            (-300.0, 300.0, vec![-300.0, -200.0, -100.0, 0.0, 100.0, 200.0, 300.0]),
        ] {
            let scale = Scale::around([low, high].into_iter());
            assert!(scale.low <= low && scale.high > high, "{scale:?}");
            assert_eq!(scale.ticks().collect::<Vec<_>>(), ticks, "{scale:?}");
        }
        let flat = Scale::around([6.0, 6.0].into_iter());
        assert!(flat.low < 6.0 && flat.high > 6.0);
    }

    #[test]
    fn ticks_have_the_digits_of_their_step() {
        let scale = Scale::around([-0.2, 0.3].into_iter());
        let labels: Vec<String> = scale.ticks().map(|tick| scale.label(tick)).collect();
        assert_eq!(labels, ["−0.2", "−0.1", "0.0", "0.1", "0.2", "0.3"]);
        let scale = Scale::around([0.0, 30_000.0].into_iter());
        assert_eq!(scale.ticks().map(|tick| scale.label(tick)).last().as_deref(), Some("30000"));
    }
}
