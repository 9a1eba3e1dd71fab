// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The contour with the wheel and its path.

use super::super::lobes::blank_outline_mm;
use super::super::turn::LobeTurn;
use super::super::turn_summary::arcs;
use super::chart::{HALF_MM, SMALL, plane_axes, scale_bar};
use super::sheet::{DrawnPass, Sheet, colour};
use crate::chart::{Frame, round_step};
use crate::drawing::{Anchor, Colour, Dash, Drawing, Lettering, Pen, Point};
use crate::summary::PassSummary;
use camwright::math::units::{TURN_RAD, rad_from_deg};
use camwright::planner::PlannedLobe;

/// The lobe by itself, large, and with its wheel, small.
const LARGE: Frame = Frame { left: 30.0, top: 27.0, width: 148.0, height: 150.0 };
const OVERVIEW: Frame = Frame { left: 184.0, top: 27.0, width: 101.0, height: 84.0 };

/// Room for the figures below the overview, and minimum distance of their lines (mm).
const FIGURES_MM: f64 = 71.0;
const FIGURE_LINE_MM: f64 = 4.4;

/// Points of a closed line.
const POINTS: u32 = 1440;

/// Wheels that are hinted at around the lobe.
const WHEELS: u32 = 36;

/// The contour where nothing sets its colour, and where something does.
const OUTLINE: Pen = Pen::solid(Colour::BLACK, 0.4);
const RULED_MM: f64 = 1.1;

const AXIS: Pen = Pen { colour: Colour::GREY, width_mm: 0.18, dash: Dash::Centre };
const BASE: Pen = Pen::dashed(Colour::GREY, 0.2);
const BLANK: Pen = Pen { colour: Colour(150, 90, 40), width_mm: 0.22, dash: Dash::Centre };
const HINT: Pen = Pen::solid(Colour(205, 205, 205), 0.15);
const CENTRES: Pen = Pen::solid(Colour(0, 114, 178), 0.3);
const METAL: Colour = Colour(240, 240, 236);

/// A plane of the part on the paper: mm of the part, y up, turned.
pub(super) struct PartView {
    pub(super) frame: Frame,
    pub(super) centre: Point,
    pub(super) scale: f64,
    pub(super) turn_rad: f64,
}

impl PartView {
    pub(super) fn at(&self, [x, y]: Point) -> Point {
        let (sin, cos) = self.turn_rad.sin_cos();
        let (right, up) = (x * cos - y * sin, x * sin + y * cos);
        [self.centre[0] + self.scale * right, self.centre[1] - self.scale * up]
    }

    /// A line through points of the part, cut off at the frame.
    pub(super) fn line(&self, drawing: &mut Drawing, points: impl Iterator<Item = Point>, pen: Pen) {
        let mut line: Vec<Point> = Vec::new();
        let mut before: Option<Point> = None;
        for point in points.map(|point| self.at(point)) {
            match before.and_then(|before| clipped(before, point, &self.frame)) {
                Some((from, to)) => {
                    let goes_on = line.last().is_some_and(|last| (last[0] - from[0]).hypot(last[1] - from[1]) < 1e-9);
                    if !goes_on {
                        drawing.line(&line, pen);
                        line = vec![from];
                    }
                    line.push(to);
                }
                None => {
                    drawing.line(&line, pen);
                    line.clear();
                }
            }
            before = Some(point);
        }
        drawing.line(&line, pen);
    }

    pub(super) fn circle(&self, drawing: &mut Drawing, [x, y]: Point, radius: f64, pen: Pen) {
        let points = turn().map(|angle| [x + radius * angle.cos(), y + radius * angle.sin()]);
        self.line(drawing, points, pen);
    }

    pub(super) fn area(&self, drawing: &mut Drawing, points: &[Point], colour: Colour) {
        let on_paper: Vec<Point> = points.iter().map(|point| self.at(*point)).collect();
        drawing.area(&on_paper, colour);
    }
}

/// Angles of a whole turn, both ends included.
fn turn() -> impl Iterator<Item = f64> {
    (0..=POINTS).map(|index| f64::from(index) * TURN_RAD / f64::from(POINTS))
}

/// The part of a straight line within a frame (Liang and Barsky).
fn clipped(from: Point, to: Point, frame: &Frame) -> Option<(Point, Point)> {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (towards, room) in [
        (-dx, from[0] - frame.left),
        (dx, frame.right() - from[0]),
        (-dy, from[1] - frame.top),
        (dy, frame.bottom() - from[1]),
    ] {
        if towards.abs() < 1e-12 {
            if room < 0.0 {
                return None;
            }
        } else if towards < 0.0 {
            enter = enter.max(room / towards);
        } else {
            leave = leave.min(room / towards);
        }
    }
    let at = |share: f64| [from[0] + share * dx, from[1] + share * dy];
    (enter < leave).then(|| (at(enter), at(leave)))
}

pub(super) fn drawing(sheet: &Sheet<'_>) -> Drawing {
    let shows = "contour, blank and path of the wheel, seen from +Z; azimuths from cam angle 0";
    let mut drawing = sheet.begin(None, shows);
    let lobe = &sheet.prepared.planned.lobes[sheet.index];
    let point = |angle: f64| {
        let point = lobe.design.contour.point(angle);
        [point.x, point.y]
    };
    let outline: Vec<Point> = turn().map(point).collect();
    let last = sheet.summary.passes.len().saturating_sub(1);
    let cut = LobeTurn::new(sheet.prepared, sheet.index, last).map(|turn| DrawnPass {
        arcs: arcs(&turn.points),
        turn,
        summary: &sheet.summary.passes[last],
    });
    large(&mut drawing, sheet, lobe, &outline, cut.as_ref());
    overview(&mut drawing, lobe);
    figures(&mut drawing, sheet, lobe);
    if let Some(cut) = &cut {
        let lines = [("base circle", BASE), ("blank", BLANK), ("wheel, every 10°", HINT)];
        cut.legend(&mut drawing, &lines.map(|(name, pen)| (name.to_owned(), pen)));
    }
    drawing
}

fn large(drawing: &mut Drawing, sheet: &Sheet<'_>, lobe: &PlannedLobe, outline: &[Point], cut: Option<&DrawnPass<'_>>) {
    let blank = blank_outline_mm(&lobe.design, sheet.prepared.job.spec.stock_mm);
    let reach = blank.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max);
    // The middle of the part's own extent, so that a high lobe fills the frame.
    let extent = |of: fn(&Point) -> f64| {
        let values = || outline.iter().map(of);
        (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
    };
    let ((left, right), (low, high)) = (extent(|point| point[0]), extent(|point| point[1]));
    let room = 0.5 * reach;
    let scale = (LARGE.width / (right - left + room)).min(LARGE.height / (high - low + room));
    let centre = [
        LARGE.left + 0.5 * LARGE.width - scale * 0.5 * (left + right),
        LARGE.top + 0.5 * LARGE.height + scale * 0.5 * (low + high),
    ];
    let view = PartView { frame: LARGE, centre, scale, turn_rad: 0.0 };
    for index in 0..WHEELS {
        let theta = f64::from(index) * TURN_RAD / f64::from(WHEELS);
        let [x, y] = wheel_centre(lobe, theta);
        let throw_mm = lobe.design.contour.throw_mm();
        view.circle(drawing, [x - throw_mm, y], lobe.tool_path.wheel_radius_mm(), HINT);
    }
    let contour = &lobe.design.contour;
    if !contour.is_bore() {
        view.area(drawing, outline, METAL);
    }
    for deg in [0.0, 90.0] {
        let [from, to] = [deg, deg + 180.0].map(rad_from_deg).map(|angle| {
            let radius = contour.radius_at(angle) + 0.03 * reach;
            [radius * angle.cos(), radius * angle.sin()]
        });
        view.line(drawing, [from, to].into_iter(), AXIS);
    }
    view.circle(drawing, [0.0, 0.0], contour.base_radius_mm(), BASE);
    view.line(drawing, blank.iter().copied(), BLANK);
    match cut {
        Some(cut) => {
            let sense = f64::from(sheet.prepared.machine.rotation_sense);
            let points = &cut.turn.points;
            let contact = |index: usize| {
                let point = lobe.tool_path.contact(sense * points[index % points.len()].c.value);
                [point.x, point.y]
            };
            for arc in &cut.arcs {
                for stretch in cut.stretches(*arc) {
                    view.line(drawing, stretch.map(contact), Pen::solid(colour(arc.bound), RULED_MM));
                }
            }
        }
        None => view.line(drawing, outline.iter().copied(), OUTLINE),
    }
    for deg in (0..360_u16).step_by(30).map(f64::from) {
        let (sin, cos) = rad_from_deg(deg).sin_cos();
        let radius = contour.radius_at(rad_from_deg(deg));
        let out = |share: f64| [(radius + share * reach) * cos, (radius + share * reach) * sin];
        view.line(drawing, [out(0.05), out(0.08)].into_iter(), Pen::solid(Colour::BLACK, 0.25));
        let [x, y] = view.at(out(0.14));
        drawing.text([x, y + HALF_MM], SMALL, &format!("{deg}°"));
    }
    plane_axes(drawing, &view, "x of the lobe (mm)", "y of the lobe (mm)");
}

/// Centre of the wheel about the axis, from the direction of cam angle 0.
fn wheel_centre(lobe: &PlannedLobe, theta: f64) -> Point {
    let distance = lobe.tool_path.sample(theta).value + lobe.tool_path.wheel_radius_mm();
    [distance * theta.cos(), distance * theta.sin()]
}

/// Part and wheel as they stand at the start of the cut, the wheel on the right, or in the bore.
fn overview(drawing: &mut Drawing, lobe: &PlannedLobe) {
    let about_axis = |angle: f64| {
        let point = lobe.design.contour.point_about_axis(angle);
        [point.x, point.y]
    };
    let outline: Vec<Point> = turn().map(about_axis).collect();
    let path: Vec<Point> = turn().map(|theta| wheel_centre(lobe, theta)).collect();
    let farthest = |points: &[Point]| points.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max);
    // The wall of a bore is around the wheel.
    let is_bore = lobe.design.contour.is_bore();
    let far = if is_bore { farthest(&outline) } else { farthest(&path) };
    let wheel_mm = lobe.tool_path.wheel_radius_mm();
    let start = lobe.tool_path.sample(lobe.start_rad).value + wheel_mm;
    let (left, right, up) = (far, far.max(start + wheel_mm), far.max(wheel_mm));
    let frame = OVERVIEW;
    // Room for the name of the axis on the right, for a line of text above.
    let scale = ((frame.width - 21.0) / (left + right)).min((frame.height - 18.0) / (2.0 * up));
    let middle = [frame.left + 0.5 * frame.width - 5.0, frame.top + 0.5 * frame.height + 1.0];
    let centre = [middle[0] + 0.5 * scale * (left - right), middle[1]];
    let view = PartView { frame, centre, scale, turn_rad: -lobe.start_rad };
    let straight = PartView { turn_rad: 0.0, frame, centre, scale };
    if !is_bore {
        view.area(drawing, &outline, METAL);
    }
    straight.line(drawing, [[-1.03 * left, 0.0], [1.02 * right, 0.0]].into_iter(), AXIS);
    for (x, reach) in [(0.0, 0.35 * up), (start, 0.3 * wheel_mm)] {
        straight.line(drawing, [[x, -reach], [x, reach]].into_iter(), AXIS);
    }
    view.line(drawing, path.into_iter(), CENTRES);
    view.line(drawing, outline.iter().copied(), OUTLINE);
    straight.circle(drawing, [start, 0.0], wheel_mm, OUTLINE);
    drawing.line(&frame.corners(), Pen::solid(Colour::BLACK, 0.25));
    let text = Lettering { anchor: Anchor::Start, ..SMALL };
    drawing.text(
        [frame.left + 3.0, frame.top + 5.0],
        text,
        "start of the cut; wheel R in mm; blue: path of its centre",
    );
    let [x, y] = straight.at([start + 0.48 * wheel_mm, 0.3 * wheel_mm]);
    drawing.text([x, y], SMALL, &format!("R {wheel_mm:.3}"));
    let [x, y] = straight.at([1.02 * right, 0.0]);
    drawing.text([x + 5.5, y + HALF_MM], SMALL, "X →");
    let length = round_step(0.12 * frame.width / scale, 1.0);
    scale_bar(drawing, [frame.left + 4.0, frame.bottom() - 3.5], length, scale);
}

/// Figures of the drawing.
fn figures(drawing: &mut Drawing, sheet: &Sheet<'_>, lobe: &PlannedLobe) {
    let summary = sheet.summary;
    let largest =
        summary.largest_wheel_radius_mm.map_or_else(|| "any".into(), |radius| format!("below {radius:.3} mm"));
    let turns =
        |pass: &PassSummary| format!("{} turns in {:.3} s, a turn {:.3} s", pass.turns, pass.cut_s, pass.turn_s);
    let radius_mm = lobe.design.contour.base_radius_mm();
    let stock = ("stock".into(), format!("{:.3} mm", sheet.prepared.job.spec.stock_mm));
    let shape: [(String, String); 5] = match &summary.crank_pin {
        None => [
            ("base circle radius".into(), format!("{radius_mm:.3} mm")),
            ("largest lift".into(), format!("{:.4} mm", summary.max_lift_mm)),
            stock,
            ("largest pressure angle".into(), format!("{:.2}°", summary.max_pressure_angle_deg)),
            ("wheel radius that fits".into(), largest),
        ],
        Some(pin) => [
            ("radius of the pin".into(), format!("{radius_mm:.3} mm")),
            ("throw".into(), format!("{:.3} mm", pin.throw_mm)),
            stock,
            ("largest contact angle".into(), format!("{:.2}°", pin.max_contact_angle_deg)),
            ("wheel radius that fits".into(), format!("from {:.3} mm", pin.smallest_wheel_radius_mm)),
        ],
    };
    let mut rows: Vec<(String, String)> = shape.into();
    rows.extend([
        ("cam angle at the start of the cut".into(), format!("{:.3}°", summary.start_deg)),
        ("predicted time of the lobe".into(), format!("{:.3} s", summary.duration_s)),
    ]);
    rows.extend(summary.passes.iter().map(|pass| (format!("pass {}", pass.name), turns(pass))));
    #[allow(clippy::cast_possible_truncation, reason = "some ten lines")]
    let most = (FIGURES_MM / FIGURE_LINE_MM) as usize;
    if let Some(hidden) = rows.len().checked_sub(most).filter(|hidden| *hidden > 0) {
        rows.truncate(most - 1);
        rows.push((format!("{} more passes", hidden + 1), "in summary.json".into()));
    }
    let count = u32::try_from(rows.len()).unwrap_or(u32::MAX);
    let height = (FIGURES_MM / f64::from(count)).min(6.2);
    let lettering = Lettering::default();
    for (row, (name, value)) in (1_u32..).zip(&rows) {
        let y = OVERVIEW.bottom() + height * f64::from(row);
        let room = OVERVIEW.width - lettering.width_mm(value) - 3.0;
        drawing.text([OVERVIEW.left, y], lettering, &lettering.fitted(name, room));
        drawing.text([OVERVIEW.right(), y], Lettering { anchor: Anchor::End, ..lettering }, value);
        let below = y + 1.1;
        drawing.line(&[[OVERVIEW.left, below], [OVERVIEW.right(), below]], Pen::solid(Colour::PALE, 0.15));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_cut_off_at_the_frame() {
        let frame = Frame { left: 0.0, top: 0.0, width: 10.0, height: 10.0 };
        assert_eq!(clipped([-5.0, 5.0], [15.0, 5.0], &frame), Some(([0.0, 5.0], [10.0, 5.0])));
        assert_eq!(clipped([2.0, 2.0], [3.0, 3.0], &frame), Some(([2.0, 2.0], [3.0, 3.0])));
        assert_eq!(clipped([-5.0, -5.0], [-1.0, 20.0], &frame), None);
    }
}
