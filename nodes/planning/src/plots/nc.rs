// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Drawings of `camwright post`: the cutter along its path, and the segments of its program.

use super::chart::{CURVE_MM, HALF_MM, SMALL, TurnChart, plane_axes};
use super::contour::PartView;
use super::curves::{ALLOWED, frame};
use super::sheet::{Legend, PAPER, ROOM, sheet};
use crate::chart::Scale;
use crate::drawing::{Anchor, Colour, Dash, Drawing, Lettering, Pen, Plot, Point};
use crate::program::request::{Plane, ProgramOutline, ToPost, error_mm};
use camwright::gcode::post::{PostedProgram, PostedTurn};
use camwright::math::units::{TURN_RAD, deg_from_rad, rad_from_deg, um_from_mm};
use camwright::toolpath::cutter_path::{CarriageAxis, CutterPath};

/// Segments, one after the other.
const SEGMENTS: [Pen; 3] =
    [Pen::solid(Colour(0, 114, 178), 0.7), Pen::solid(Colour(230, 159, 0), 0.7), Pen::solid(Colour(0, 158, 115), 0.7)];
const OUTLINE: Pen = Pen::solid(Colour::BLACK, 0.4);
const HINT: Pen = Pen::solid(Colour(190, 190, 190), 0.15);
const AXIS: Pen = Pen { colour: Colour::GREY, width_mm: 0.18, dash: Dash::Centre };
const METAL: Colour = Colour(240, 240, 236);
const BEHIND: Colour = Colour(252, 252, 250);
const KNOT: Pen = Pen::solid(Colour(170, 0, 0), 0.25);
const CURVE: Pen = Pen::solid(Colour(0, 114, 178), CURVE_MM);

/// Radius of the degree labels, relative to the reach of shape and path.
const DEGREES_AT: f64 = 1.12;

/// Cutters that are hinted at along a turn.
const CUTTERS: u32 = 36;

/// Points of a segment, which is a spiral in the plane, and of a curve over a turn.
const POINTS_PER_RAD: f64 = 60.0;
const CURVE_POINTS: u32 = 7200;

/// All drawings of a program, with the name of the cam or groove they are of.
pub(crate) fn program_plots<'a>(to_post: &'a ToPost<'_>, posted: &PostedProgram) -> Vec<(&'a str, Plot)> {
    let mut plots = Vec::new();
    for (feature, of) in to_post.request.features.iter().enumerate() {
        let turns: Vec<&PostedTurn> = posted.turns.iter().filter(|turn| turn.feature == feature).collect();
        let (Some(last), Some(Some(outline))) = (turns.last(), to_post.outlines.get(feature)) else { continue };
        let is_last = !to_post.request.features[feature + 1..].iter().any(|other| other.name == of.name);
        if is_last {
            let drawing = tool_path(to_post, feature, last, outline);
            plots.push((
                of.name.as_str(),
                Plot { name: "tool_path".into(), caption: caption_of_path(outline), drawing },
            ));
        }
        for turn in turns {
            let name = format!("{}_segments", of.passes[turn.pass].name.replace(' ', "_"));
            let caption =
                format!("Pass {}: travel, slope and error of the program's segments.", of.passes[turn.pass].name);
            plots.push((of.name.as_str(), Plot { name, caption, drawing: segments(to_post, turn) }));
        }
    }
    plots
}

fn caption_of_path(outline: &ProgramOutline) -> String {
    match outline.plane {
        Plane::Across => "The shape with the cutter along its path, seen along the axis.".into(),
        Plane::Developed { is_folded: false, .. } => {
            "The groove unrolled at its mean radius, with the cutter along its path.".into()
        }
        Plane::Developed { is_folded: true, .. } => {
            "The groove unrolled at its mean radius, its turns over each other, with the cutter along its path.".into()
        }
    }
}

fn begin(to_post: &ToPost<'_>, turn: &PostedTurn, shows: &str) -> Drawing {
    let of = &to_post.request.features[turn.feature];
    let pass = &of.passes[turn.pass];
    let title = format!("{} · {} · {}", to_post.job, of.name, pass.name);
    let made_of = format!(
        "{} segments in a turn, tolerance {:.3} µm, largest error {:.3} µm, {}",
        turn.pieces_of_turn,
        um_from_mm(turn.tolerance_mm),
        um_from_mm(turn.deviation.error_mm),
        to_post.request.tool.text
    );
    sheet(&title, shows, &made_of, &format!("job {:.16}", to_post.job_hash))
}

/// Position of a cutter's centre on a sheet, from the programmed values.
struct CutterCentres<'a> {
    outline: &'a ProgramOutline,
    axes: Vec<CarriageAxis>,
    sense: f64,
}

impl CutterCentres<'_> {
    /// The place at an angle of the part's frame, with the positions of the axes that move.
    fn at(&self, u_rad: f64, position: impl Fn(CarriageAxis) -> Option<f64>) -> Point {
        let azimuth = self.sense * u_rad;
        let of = |axis| self.axes.contains(&axis).then(|| position(axis)).flatten().unwrap_or(0.0);
        match self.outline.plane {
            Plane::Across => {
                let x_mm = of(CarriageAxis::X) + self.outline.edge_mm;
                [x_mm * azimuth.cos(), x_mm * azimuth.sin()]
            }
            Plane::Developed { radius_mm, .. } => [radius_mm * azimuth + of(CarriageAxis::Y), of(CarriageAxis::Z)],
        }
    }
}

/// The shape with the cutter along its path; segments in turn in three colours.
fn tool_path(to_post: &ToPost<'_>, feature: usize, turn: &PostedTurn, outline: &ProgramOutline) -> Drawing {
    let shows = match outline.plane {
        Plane::Across => "shape, cutter every 10° and the segments of its path, seen from +Z",
        Plane::Developed { .. } => {
            "walls rolled off at the mean radius, cutter every 10° and the segments of its path; Z upwards"
        }
    };
    let mut drawing = begin(to_post, turn, shows);
    let of = &to_post.request.features[feature];
    let sense = f64::from(to_post.request.control.rotation_sense);
    let places = CutterCentres { outline, axes: turn.axes.clone(), sense };
    let centre_at =
        |u_rad: f64| places.at(u_rad, |axis| of.path.sample(axis, sense * u_rad).map(|sample| sample.value));
    let (begin_rad, turns) = (begin_of(of.path, sense), of.path.turns());
    let centres: Vec<Point> = (0..CUTTERS * turns)
        .map(|index| centre_at(begin_rad + f64::from(index) * TURN_RAD / f64::from(CUTTERS)))
        .map(|centre| outline.plane.place(centre))
        .collect();
    let view = view(outline, &centres);
    let across = matches!(outline.plane, Plane::Across);
    for (index, line) in outline.closed.iter().enumerate() {
        if across {
            view.area(&mut drawing, line, if index == 0 { METAL } else { BEHIND });
        }
        view.line(&mut drawing, line.iter().copied(), OUTLINE);
    }
    if outline.cutter_mm > 0.0 {
        for centre in &centres {
            view.circle(&mut drawing, *centre, outline.cutter_mm, HINT);
        }
    }
    let reach = reach(outline, &centres);
    if across {
        for ends in [[[-reach, 0.0], [reach, 0.0]], [[0.0, -reach], [0.0, reach]]] {
            view.line(&mut drawing, ends.into_iter(), AXIS);
        }
    }
    for (index, pair) in turn.knots.windows(2).enumerate() {
        let [from, to] = pair else { continue };
        #[allow(clippy::cast_possible_truncation, reason = "degrees of some turns")]
        let points = ((to.0 - from.0) * POINTS_PER_RAD).ceil().clamp(1.0, 1e5) as u32;
        let along = (0..=points).map(|point| {
            let share = f64::from(point) / f64::from(points);
            places.at(from.0 + share * (to.0 - from.0), |axis| {
                let index = turn.axes.iter().position(|other| *other == axis)?;
                Some(from.1[index] + share * (to.1[index] - from.1[index]))
            })
        });
        for line in outline.plane.folded(along.map(Some)) {
            view.line(&mut drawing, line.into_iter(), SEGMENTS[index % SEGMENTS.len()]);
        }
    }
    let (to_the_right, upwards) = match outline.plane {
        Plane::Across => ("x of the part (mm)", "y of the part (mm)"),
        Plane::Developed { .. } => ("distance around the part (mm)", "z of the part (mm)"),
    };
    plane_axes(&mut drawing, &view, to_the_right, upwards);
    for deg in (0..360_u16).step_by(30).filter(|_| across).map(f64::from) {
        let (sin, cos) = rad_from_deg(deg).sin_cos();
        let [x, y] = view.at([DEGREES_AT * reach * cos, DEGREES_AT * reach * sin]);
        drawing.text([x, y + HALF_MM], SMALL, &format!("{deg}°"));
    }
    let mut legend = Legend::new();
    for (name, pen) in [
        ("shape", OUTLINE),
        ("cutter, every 10°", HINT),
        ("segments", SEGMENTS[0]),
        ("the next", SEGMENTS[1]),
        ("the one after it", SEGMENTS[2]),
    ] {
        legend.line(&mut drawing, name, pen);
    }
    drawing
}

/// Reach of shape and path from the axis (mm).
fn reach(outline: &ProgramOutline, centres: &[Point]) -> f64 {
    outline.closed.iter().flatten().chain(centres).map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max)
}

/// A view in which the shape and the cutters have room.
fn view(outline: &ProgramOutline, centres: &[Point]) -> PartView {
    let all = outline.closed.iter().flatten().copied();
    let cutters = centres.iter().flat_map(|[x, y]| {
        let r = outline.cutter_mm;
        [[x - r, y - r], [x + r, y + r]]
    });
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    // Degrees stand around the axis.
    let reach = DEGREES_AT * reach(outline, centres);
    let degrees = [[-reach, -reach], [reach, reach]].into_iter().filter(|_| matches!(outline.plane, Plane::Across));
    for point in all.chain(cutters).chain(degrees) {
        for axis in 0..2 {
            (low[axis], high[axis]) = (low[axis].min(point[axis]), high[axis].max(point[axis]));
        }
    }
    let room = 0.08 * (high[0] - low[0]).max(high[1] - low[1]);
    let scale = (ROOM.width / (high[0] - low[0] + room)).min(ROOM.height / (high[1] - low[1] + room));
    let middle = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])];
    let centre = [ROOM.left + 0.5 * ROOM.width - scale * middle[0], ROOM.top + 0.5 * ROOM.height + scale * middle[1]];
    PartView { frame: ROOM, centre, scale, turn_rad: 0.0 }
}

/// Angle of the part at which a run at full depth begins (rad).
fn begin_of(path: &CutterPath, sense: f64) -> f64 {
    if path.is_open() && sense < 0.0 { -path.span_rad() } else { 0.0 }
}

/// Travels over a turn at full depth with their knots, slopes of the segments, and what they are off.
fn segments(to_post: &ToPost<'_>, turn: &PostedTurn) -> Drawing {
    let mut drawing =
        begin(to_post, turn, "travel with its knots, slope of the segments, distance from the path with the tolerance");
    let of = &to_post.request.features[turn.feature];
    let sense = f64::from(to_post.request.control.rotation_sense);
    let (begin_rad, turns) = (begin_of(of.path, sense), of.path.turns());
    let end_rad = begin_rad + f64::from(turns) * TURN_RAD;
    let full = |u_rad: f64| (begin_rad - 1e-9..=end_rad + 1e-9).contains(&u_rad);
    let (begin_deg, end_deg) = (deg_from_rad(begin_rad), deg_from_rad(end_rad));
    let chart = |frame, up| TurnChart::over(frame, (begin_deg, end_deg), up);
    let moving: Vec<(usize, CarriageAxis)> =
        turn.axes.iter().copied().enumerate().filter(|(_, axis)| of.path.sample(*axis, 0.0).is_some()).collect();
    // One axis, or two: C has what is left of the sheet.
    let rows = 3 * u8::try_from(moving.len()).unwrap_or(1);
    for (place, (index, axis)) in (0_u8..).zip(moving) {
        let wanted = |u_rad: f64| of.path.sample(axis, sense * u_rad).map_or(0.0, |sample| sample.value);
        let knots: Vec<(f64, f64)> =
            turn.knots.iter().filter(|knot| full(knot.0)).map(|knot| (deg_from_rad(knot.0), knot.1[index])).collect();
        let letter = axis.letter();
        let travel = chart(frame(3 * place, rows), Scale::around(knots.iter().map(|knot| knot.1)));
        travel.axes(&mut drawing, &format!("{letter} (mm)"), false);
        travel.curve(&mut drawing, knots.iter().copied(), CURVE);
        for (c_deg, value) in &knots {
            let [x, y] = travel.0.at(c_deg.clamp(begin_deg, end_deg), *value);
            drawing.line(&[[x, y - 0.8], [x, y + 0.8]], KNOT);
        }
        let slopes: Vec<(f64, f64)> = knots
            .windows(2)
            .flat_map(|pair| {
                let slope = (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0);
                [(pair[0].0, slope), (pair[1].0, slope)]
            })
            .collect();
        let steps = chart(frame(3 * place + 1, rows), Scale::around(slopes.iter().map(|slope| slope.1)));
        steps.axes(&mut drawing, &format!("d{letter}/dC (mm/deg)"), false);
        steps.curve(&mut drawing, slopes.into_iter(), CURVE);
        let errors: Vec<(f64, f64)> = (0..=CURVE_POINTS * turns)
            .map(|point| {
                let u_rad = begin_rad + f64::from(point) * TURN_RAD / f64::from(CURVE_POINTS);
                (deg_from_rad(u_rad), um_from_mm(error_mm(turn, index, u_rad, wanted(u_rad))))
            })
            .collect();
        let allowed = um_from_mm(turn.tolerance_mm);
        let off = chart(frame(3 * place + 2, rows), Scale::around([-allowed, allowed].into_iter()));
        off.axes(&mut drawing, "error (µm)", 3 * place + 3 == rows);
        off.curve(&mut drawing, errors.into_iter(), Pen::solid(Colour(0, 114, 178), 0.2));
        for level in [-allowed, allowed] {
            off.level(&mut drawing, level, ALLOWED);
        }
    }
    let mut legend = Legend::new();
    for (name, pen) in [("travel, slope, error", CURVE), ("knot", KNOT), ("tolerance", ALLOWED)] {
        legend.line(&mut drawing, name, pen);
    }
    let text = format!(
        "largest step of the slope {:.4} mm/deg, of the velocity {:.3} mm/s",
        turn.deviation.slope_jump_mm_rad / deg_from_rad(1.0),
        turn.velocity_step_mm_s
    );
    drawing.text([PAPER.0 - 12.0, 26.5], Lettering { anchor: Anchor::End, ..SMALL }, &text);
    drawing
}
