// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Curves over one turn of C.

use super::super::turn::LobeTurnPoint;
use super::chart::{CURVE_MM, SMALL, TurnChart};
use super::sheet::{DrawnPass, ROOM, Sheet, colour};
use crate::chart::{Frame, Scale, round_step};
use crate::drawing::{Anchor, Colour, Drawing, Lettering, Pen};
use camwright::machine::description::{Axis, MotionLimits};
use camwright::math::hermite::Sample;
use camwright::math::units::{TURN_RAD, rad_from_deg};
use camwright::motion::speed_plan::LimitedQuantity;

/// Gap between two charts on a sheet (mm).
const BETWEEN_MM: f64 = 5.0;

/// A limit is drawn where at least this share of it is used; else its number stands there, and the curve keeps its size.
const NEAR: f64 = 0.25;

/// The axis' own limit, and what planning may use of it.
pub(super) const LIMIT: Pen = Pen::dashed(Colour(200, 0, 0), 0.3);
pub(super) const ALLOWED: Pen = Pen::solid(Colour(200, 0, 0), 0.2);

/// Limit of the speed law.
const LAW: Pen = Pen::dashed(Colour(0, 114, 178), 0.3);

/// Points of a turn of the path, which has no pass: a tenth of a degree.
const PATH_POINTS: u32 = 3600;

/// The frame of one of so many charts, from above.
pub(super) fn frame(index: u8, count: u8) -> Frame {
    let height = (ROOM.height - f64::from(count - 1) * BETWEEN_MM) / f64::from(count);
    Frame { top: ROOM.top + f64::from(index) * (height + BETWEEN_MM), height, ..ROOM }
}

/// X and its derivatives by the angle of C.
pub(super) fn tool_path(sheet: &Sheet<'_>) -> Drawing {
    let shows = "X axis at finished size over one turn, with its derivatives by the angle of C";
    let mut drawing = sheet.begin(None, shows);
    let path = &sheet.prepared.planned.lobes[sheet.index].tool_path;
    let sense = f64::from(sheet.prepared.machine.rotation_sense);
    let samples: Vec<(f64, Sample)> = (0..=PATH_POINTS)
        .map(|index| {
            let c_deg = f64::from(index) * 360.0 / f64::from(PATH_POINTS);
            let theta = sense * rad_from_deg(c_deg) - rad_from_deg(sheet.summary.phase_deg);
            let x = path.sample(theta);
            (c_deg, Sample { first: sense * x.first, third: sense * x.third, ..x })
        })
        .collect();
    let labels = ["X (mm)", "X′ (mm/rad)", "X″ (mm/rad²)", "X‴ (mm/rad³)"];
    let of: [fn(&Sample) -> f64; 4] = [|x| x.value, |x| x.first, |x| x.second, |x| x.third];
    for (row, (label, of)) in (0_u8..).zip(labels.into_iter().zip(of)) {
        let chart = TurnChart::new(frame(row, 4), Scale::around(samples.iter().map(|(_, x)| of(x))));
        chart.axes(&mut drawing, label, row == 3);
        if row == 0 {
            chart.cam_angles(&mut drawing, |cam_deg| sheet.c_deg(cam_deg));
        }
        let points = samples.iter().map(|(c_deg, x)| (*c_deg, of(x)));
        chart.curve(&mut drawing, points, Pen::solid(Colour(0, 114, 178), CURVE_MM));
    }
    let values = || samples.iter().map(|(_, x)| x.value);
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    let notes = [
        format!("X: distance of the wheel's cutting point from the spindle axis, {low:.4} – {high:.4} mm"),
        format!(
            "the path has {} knots and grinds within {:.1e} mm of the contour",
            sheet.summary.path_knots, sheet.summary.contour_error_mm
        ),
    ];
    for (y, note) in [191.5, 196.5].into_iter().zip(notes) {
        drawing.text([ROOM.left, y], Lettering::default(), &note);
    }
    drawing
}

/// Speed, acceleration and jerk of C.
pub(super) fn c_axis(sheet: &Sheet<'_>, cut: &DrawnPass<'_>) -> Drawing {
    let shows = format!(
        "C axis over one turn of {:.3} s: speed, acceleration and jerk; shading shows the limit that acts",
        cut.turn.turn_s
    );
    let mut drawing = sheet.begin(Some(&cut.summary.name), &shows);
    let rpm = 60.0 / TURN_RAD;
    let bounds = &cut.turn.bounds;
    let speed = AxisDerivative {
        label: "speed (rpm)",
        unit: "rpm",
        factor: rpm,
        of: |point| point.c.first,
        limit: bounds.c.velocity,
        allowed: None,
    };
    let count = cut.turn.points.len();
    let law: Vec<(f64, f64)> = (0..=count)
        .filter_map(|index| {
            let process = bounds.process_rad_s(cut.turn.points[index % count].c.value)?;
            Some((cut.c_deg(index), rpm * process.min(bounds.work_speed_rad_s())))
        })
        .collect();
    let chart = speed.draw(&mut drawing, cut, 0);
    chart.cam_angles(&mut drawing, |cam_deg| sheet.c_deg(cam_deg));
    chart.curve(&mut drawing, law.iter().copied(), LAW);
    speed.curve(&mut drawing, cut, &chart);
    let of: [fn(&LobeTurnPoint) -> f64; 2] = [|point| point.c.second, |point| point.c.third];
    higher(&mut drawing, cut, Axis::C, &bounds.c, of);
    let mut first = limit_lines(cut);
    if !law.is_empty() {
        first.push(("speed law allows".into(), LAW));
    }
    cut.legend(&mut drawing, &first);
    drawing
}

/// Speed, acceleration and jerk of X.
pub(super) fn x_axis(sheet: &Sheet<'_>, cut: &DrawnPass<'_>) -> Drawing {
    let shows = format!(
        "X axis over one turn of {:.3} s with infeed: speed, acceleration and jerk; shading shows the limit that acts on C",
        cut.turn.turn_s
    );
    let mut drawing = sheet.begin(Some(&cut.summary.name), &shows);
    let limits = cut.turn.bounds.x;
    let speed = AxisDerivative {
        label: "speed (mm/s)",
        unit: "mm/s",
        factor: 1.0,
        of: |point| point.x.first,
        limit: limits.velocity,
        allowed: None,
    };
    let chart = speed.draw(&mut drawing, cut, 0);
    chart.cam_angles(&mut drawing, |cam_deg| sheet.c_deg(cam_deg));
    speed.curve(&mut drawing, cut, &chart);
    let of: [fn(&LobeTurnPoint) -> f64; 2] = [|point| point.x.second, |point| point.x.third];
    higher(&mut drawing, cut, Axis::X, &limits, of);
    cut.legend(&mut drawing, &limit_lines(cut));
    drawing
}

fn limit_lines(cut: &DrawnPass<'_>) -> Vec<(String, Pen)> {
    if cut.turn.bounds.varies() {
        vec![("limit".into(), LIMIT), ("planning uses".into(), ALLOWED)]
    } else {
        vec![("limit".into(), LIMIT)]
    }
}

/// Acceleration and jerk of an axis.
fn higher(
    drawing: &mut Drawing,
    cut: &DrawnPass<'_>,
    axis: Axis,
    limits: &MotionLimits,
    of: [fn(&LobeTurnPoint) -> f64; 2],
) {
    let allowed = cut.turn.allowed()[usize::from(axis != Axis::C)];
    let quantities = [LimitedQuantity::Acceleration, LimitedQuantity::Jerk];
    for (row, (quantity, of)) in (1_u8..).zip(quantities.into_iter().zip(of)) {
        let unit = quantity.unit(axis);
        let motion = AxisDerivative {
            label: &format!("{} ({unit})", quantity.name()),
            unit,
            factor: 1.0,
            of,
            limit: quantity.limit(limits),
            allowed: Some(quantity.limit(&allowed)),
        };
        let chart = motion.draw(drawing, cut, row);
        motion.curve(drawing, cut, &chart);
    }
}

/// One derivative of an axis.
struct AxisDerivative<'a> {
    label: &'a str,
    unit: &'a str,
    /// From the plan's unit to the chart's.
    factor: f64,
    of: fn(&LobeTurnPoint) -> f64,
    limit: f64,
    /// Planning limit, if it is lower.
    allowed: Option<f64>,
}

impl AxisDerivative<'_> {
    fn draw(&self, drawing: &mut Drawing, cut: &DrawnPass<'_>, row: u8) -> TurnChart {
        // Digits of a constant speed are no motion.
        let tiny = 1e-9 * self.limit;
        let value =
            |point: &LobeTurnPoint| self.factor * Some((self.of)(point)).filter(|v| v.abs() > tiny).unwrap_or(0.0);
        let values = || cut.turn.points.iter().map(value);
        let limit = self.factor * self.limit;
        let used = values().map(f64::abs).fold(0.0, f64::max) / limit;
        // What does not move at all is shown between its limits.
        let rests = used <= 0.0;
        let has_both = rests || values().any(|value| value < 0.0);
        let is_near = rests || used >= NEAR;
        let limits = [Some(limit), has_both.then_some(-limit), (!has_both).then_some(0.0)];
        let shown = limits.into_iter().flatten().filter(|value| is_near || *value == 0.0);
        let chart = TurnChart::new(frame(row, 3), Scale::around(values().chain(shown)));
        cut.shade(drawing, &chart.0.frame);
        chart.axes(drawing, self.label, row == 2);
        if is_near {
            for sign in if has_both { &[1.0, -1.0][..] } else { &[1.0] } {
                chart.level(drawing, sign * limit, LIMIT);
                if let Some(allowed) = self.allowed.filter(|_| cut.turn.bounds.varies()) {
                    chart.level(drawing, sign * self.factor * allowed, ALLOWED);
                }
            }
        }
        let note = format!("limit {limit:.0} {}, used {:.1} %", self.unit, 100.0 * used);
        let lettering = Lettering { anchor: Anchor::End, colour: LIMIT.colour, ..SMALL };
        let above = if row == 0 { 6.0 } else { 1.3 };
        drawing.text([chart.0.frame.right(), chart.0.frame.top - above], lettering, &note);
        chart
    }

    /// The curve in the colours of what sets the speed.
    fn curve(&self, drawing: &mut Drawing, cut: &DrawnPass<'_>, chart: &TurnChart) {
        coloured(drawing, cut, chart, |point| self.factor * (self.of)(point));
    }
}

fn coloured(drawing: &mut Drawing, cut: &DrawnPass<'_>, chart: &TurnChart, of: impl Fn(&LobeTurnPoint) -> f64) {
    let points = &cut.turn.points;
    for arc in &cut.arcs {
        for stretch in cut.stretches(*arc) {
            let values = stretch.map(|index| (cut.c_deg(index), of(&points[index % points.len()])));
            chart.curve(drawing, values, Pen::solid(colour(arc.bound), CURVE_MM));
        }
    }
}

/// The specific removal rate with its bound, the one speed that peaks as high, and how long which rate lasts.
pub(super) fn removal_rate(sheet: &Sheet<'_>, cut: &DrawnPass<'_>) -> Drawing {
    let turn = &cut.turn;
    let constant_s = turn.constant_speed_turn_s();
    let varies = turn.bounds.varies();
    let mut shows = format!("specific removal rate over one turn of {:.3} s with its whole infeed", turn.turn_s);
    if varies {
        shows += &format!("; one speed with the same peak takes {constant_s:.3} s");
    }
    let mut drawing = sheet.begin(Some(&cut.summary.name), &shows);
    let wide = Frame { width: 192.0, ..ROOM };
    let count = turn.points.len();
    let peak = turn.peak_mm2_s();
    // A bound far above what is reached would make the curve small.
    let bound = turn.points.iter().map(|point| point.allowed_mm2_s).fold(0.0, f64::max);
    let highest = if varies && bound < 1.6 * peak { bound } else { peak };
    let chart = TurnChart::new(wide, Scale::around([0.0, 1.03 * highest].into_iter()));
    cut.shade(&mut drawing, &wide);
    chart.axes(&mut drawing, "Q′ (mm³ per mm of width and s)", true);
    chart.cam_angles(&mut drawing, |cam_deg| sheet.c_deg(cam_deg));
    let mut legend = Vec::new();
    if varies {
        let constant = Pen::dashed(Colour::GREY, 0.3);
        let speed = TURN_RAD / constant_s;
        let at_constant = |index: usize| {
            let point = &turn.points[index % count];
            (cut.c_deg(index), point.removal_mm2_s / point.c.first * speed)
        };
        let allowed = |index: usize| (cut.c_deg(index), turn.points[index % count].allowed_mm2_s);
        chart.curve(&mut drawing, (0..=count).map(at_constant), constant);
        chart.curve(&mut drawing, (0..=count).map(allowed), LIMIT);
        legend.push(("allowed".to_owned(), LIMIT));
        legend.push((format!("at constant {:.1} rpm", speed * 60.0 / TURN_RAD), constant));
    }
    coloured(&mut drawing, cut, &chart, |point| point.removal_mm2_s);
    histogram(&mut drawing, cut, &chart);
    cut.legend(&mut drawing, &legend);
    drawing
}

/// Shares of the turn's time beside the chart, on its scale.
fn histogram(drawing: &mut Drawing, cut: &DrawnPass<'_>, chart: &TurnChart) {
    let classes = &cut.summary.removal_classes;
    let left = chart.0.frame.right() + 8.0;
    let frame = Frame { left, width: ROOM.right() - left, ..chart.0.frame };
    let largest = 100.0 * classes.iter().map(|class| class.share).fold(0.0, f64::max).max(0.05);
    let step = round_step(largest, 4.0);
    let ticks = (largest / step - 1e-6).ceil();
    let x = |percent: f64| frame.left + frame.width * percent / (ticks * step);
    for class in classes {
        let bottom = chart.0.y(class.from_mm2_s);
        let top = chart.0.y(class.to_mm2_s.min(chart.0.up.high));
        let (right, gap) = (x(100.0 * class.share), 0.08 * (bottom - top));
        let corners = [[frame.left, top + gap], [right, top + gap], [right, bottom - gap], [frame.left, bottom - gap]];
        drawing.area(&corners, Colour(150, 178, 205));
        if class.share >= 0.005 {
            let text = format!("{:.0} %", 100.0 * class.share);
            let lettering = Lettering { anchor: Anchor::Start, ..SMALL };
            let is_inside = right + 2.0 + lettering.width_mm(&text) > frame.right();
            let at = if is_inside { right - 1.5 - lettering.width_mm(&text) } else { right + 1.0 };
            drawing.text([at, 0.5 * (top + bottom) + 1.0], lettering, &text);
        }
    }
    let thin = Pen::solid(Colour::BLACK, 0.25);
    let mut tick = 0.0;
    while tick <= ticks {
        let at = x(tick * step);
        drawing.line(&[[at, frame.bottom()], [at, frame.bottom() - 1.2]], thin);
        drawing.text([at, frame.bottom() + 4.0], SMALL, &format!("{:.0}", tick * step));
        tick += 1.0;
    }
    drawing.line(&frame.corners(), thin);
    let middle = frame.left + 0.5 * frame.width;
    drawing.text([middle, frame.bottom() + 8.8], SMALL, "share of the time (%)");
}
