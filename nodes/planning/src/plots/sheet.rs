// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A sheet of paper with title, foot and legend, for the drawings of a lobe and of its passes.

use super::chart::CURVE_MM;
use crate::PreparedJob;
use crate::chart::Frame;
use crate::drawing::{Anchor, Colour, Drawing, Lettering, Pen, Point};
use crate::summary::{LobeSummary, PassSummary};
use crate::turn::LobeTurn;
use crate::turn_summary::{Arc, bound_name};
use camwright::job::grinding::SpeedLaw;
use camwright::machine::description::Axis;
use camwright::motion::speed_plan::{Bound, LimitedQuantity};

/// Paper: A4, broadside (mm).
pub(super) const PAPER: (f64, f64) = (297.0, 210.0);

/// Room for charts on it.
pub(super) const ROOM: Frame = Frame { left: 32.0, top: 33.0, width: 252.0, height: 144.0 };

/// Margin of text at the sides.
const MARGIN_MM: f64 = 12.0;

/// Position of the first line of the legend, the distance of the next, and position of the foot.
const LEGEND_MM: f64 = 192.0;
const LEGEND_LINE_MM: f64 = 4.9;
const FOOT_MM: f64 = 204.5;

/// A lobe, for all of its drawings.
pub(super) struct Sheet<'a> {
    pub(super) prepared: &'a PreparedJob,
    pub(super) index: usize,
    pub(super) summary: &'a LobeSummary,
}

/// A pass over the lobe.
pub(super) struct DrawnPass<'a> {
    pub(super) turn: LobeTurn<'a>,
    pub(super) arcs: Vec<Arc>,
    pub(super) summary: &'a PassSummary,
}

/// A sheet with its title, what it shows, and what it was made from.
pub(super) fn sheet(title: &str, shows: &str, made_of: &str, by: &str) -> Drawing {
    let mut drawing = Drawing::new(PAPER.0, PAPER.1, &format!("{title}: {shows}"));
    let width = PAPER.0 - 2.0 * MARGIN_MM;
    let bold = Lettering { height_mm: 4.2, is_bold: true, ..Lettering::default() };
    drawing.text([MARGIN_MM, 14.0], bold, &bold.fitted(title, width));
    let about = Lettering { height_mm: 2.9, ..Lettering::default() };
    drawing.text([MARGIN_MM, 21.0], about, &about.fitted(shows, width));
    let small = Lettering { colour: Colour::GREY, ..Lettering::default() };
    let by = format!("camwright, {by}");
    let room = width - small.width_mm(&by) - 4.0;
    drawing.text([MARGIN_MM, FOOT_MM], small, &small.fitted(made_of, room));
    drawing.text([PAPER.0 - MARGIN_MM, FOOT_MM], Lettering { anchor: Anchor::End, ..small }, &by);
    drawing
}

/// Names of lines and areas along the foot of a sheet; a second line begins where the first is full.
#[derive(Debug)]
pub(super) struct Legend {
    x: f64,
    y: f64,
}

impl Legend {
    const START_MM: f64 = 14.0;

    pub(super) const fn new() -> Self {
        Self { x: Self::START_MM, y: LEGEND_MM }
    }

    /// A line with its name.
    pub(super) fn line(&mut self, drawing: &mut Drawing, text: &str, pen: Pen) {
        let [x, y] = self.place(drawing, text);
        drawing.line(&[[x, y - 1.25], [x + 7.0, y - 1.25]], pen);
    }

    /// A shaded area with its name and the line that is drawn on it.
    fn area(&mut self, drawing: &mut Drawing, text: &str, colour: Colour, pen: Pen) {
        let [x, y] = self.place(drawing, text);
        drawing.area(&[[x, y + 0.4], [x + 7.0, y + 0.4], [x + 7.0, y - 2.9], [x, y - 2.9]], colour);
        drawing.line(&[[x, y - 1.25], [x + 7.0, y - 1.25]], pen);
    }

    /// Writes a name and returns the position of its sample.
    fn place(&mut self, drawing: &mut Drawing, text: &str) -> Point {
        let lettering = Lettering::default();
        let width = 9.0 + lettering.width_mm(text);
        if self.x + width > PAPER.0 - MARGIN_MM && self.x > Self::START_MM {
            (self.x, self.y) = (Self::START_MM, self.y + LEGEND_LINE_MM);
        }
        let at = [self.x, self.y];
        drawing.text([self.x + 9.0, self.y], lettering, text);
        self.x += width + 5.0;
        at
    }
}

impl Sheet<'_> {
    /// A sheet with its title, what it shows, and what it was made from.
    pub(super) fn begin(&self, pass: Option<&str>, shows: &str) -> Drawing {
        let prepared = self.prepared;
        let mut title = format!("{} · lobe {}", prepared.planned.plan.job, self.summary.name);
        if let Some(pass) = pass {
            title += &format!(" · pass {pass}");
        }
        let lobe = &prepared.planned.lobes[self.index];
        let made_of = format!(
            "profile {}, phase {:.3}°, wheel radius {:.3} mm, machine {}",
            self.summary.profile,
            self.summary.phase_deg,
            lobe.tool_path.wheel_radius_mm(),
            prepared.machine.name
        );
        sheet(&title, shows, &made_of, &format!("plan {:.16}", prepared.plan_hash()))
    }

    /// The angle of C at which a cam angle faces the wheel (deg).
    pub(super) fn c_deg(&self, cam_deg: f64) -> f64 {
        f64::from(self.prepared.machine.rotation_sense) * (cam_deg + self.summary.phase_deg)
    }
}

impl DrawnPass<'_> {
    /// Points of an arc as indices into the turn, cut where the turn begins; the last is the first of the next arc.
    pub(super) fn stretches(&self, arc: Arc) -> Vec<std::ops::RangeInclusive<usize>> {
        let count = self.turn.points.len();
        let end = arc.from + arc.count;
        if end <= count { vec![arc.from..=end] } else { vec![arc.from..=count, 0..=end - count] }
    }

    /// Angle of C of a point, the one behind the last included (deg).
    pub(super) fn c_deg(&self, index: usize) -> f64 {
        let count = self.turn.points.len();
        self.turn.points[index % count].c_deg + if index < count { 0.0 } else { 360.0 }
    }

    /// Lines with their names, then a colour for each limit that acts with its share of the time, along the foot of a sheet.
    pub(super) fn legend(&self, drawing: &mut Drawing, first: &[(String, Pen)]) {
        let mut legend = Legend::new();
        for (text, pen) in first {
            legend.line(drawing, text, *pen);
        }
        for bound in self.ruling() {
            let name = bound_name(&self.turn.bounds.speed, bound);
            let found = self.summary.bounds.iter().find(|summary| summary.bound == name);
            let share = 100.0 * found.map_or(0.0, |found| found.share);
            let text = format!("{}: {share:.0} % of the time", bound_in_words(&self.turn.bounds.speed, bound));
            legend.area(drawing, &text, shade(bound), Pen::solid(colour(bound), CURVE_MM));
        }
    }

    /// The bounds that rule somewhere, in a fixed order.
    pub(super) fn ruling(&self) -> Vec<Option<Bound>> {
        let all = Bound::ALL.into_iter().map(Some).chain([None]);
        all.filter(|bound| self.arcs.iter().any(|arc| arc.bound == *bound)).collect()
    }

    /// Shades the background of a chart by the limit that acts.
    pub(super) fn shade(&self, drawing: &mut Drawing, frame: &Frame) {
        for arc in &self.arcs {
            for stretch in self.stretches(*arc) {
                let x = |index: usize| frame.left + frame.width * self.c_deg(index).min(360.0) / 360.0;
                let (from, to) = (x(*stretch.start()), x(*stretch.end()));
                let (top, bottom) = (frame.top, frame.bottom());
                drawing.area(&[[from, top], [to, top], [to, bottom], [from, bottom]], shade(arc.bound));
            }
        }
    }
}

/// The limit that acts, for people.
fn bound_in_words(law: &SpeedLaw, bound: Option<Bound>) -> String {
    match (bound, law) {
        (None, _) => "between two limits".into(),
        (Some(Bound::WorkSpeed), SpeedLaw::ConstantWorkSpeed { .. }) => "programmed work speed".into(),
        (Some(Bound::WorkSpeed), _) => "highest work speed allowed".into(),
        (Some(Bound::WheelPower), _) => "power of the wheel spindle".into(),
        (Some(Bound::Process), _) => format!("{} of the speed law", bound_name(law, bound).replace('_', " ")),
        (Some(Bound::Limit(axis, quantity)), _) => {
            let letter = if axis == Axis::C { 'C' } else { 'X' };
            format!("{} limit of {letter}", quantity.name())
        }
    }
}

/// Background where a limit acts.
fn shade(bound: Option<Bound>) -> Colour {
    colour(bound).tint(0.2)
}

/// Colours that colour-blind people can distinguish (after Okabe and Ito), dark enough for paper.
pub(super) const fn colour(bound: Option<Bound>) -> Colour {
    match bound {
        None => Colour(165, 165, 165),
        Some(Bound::WorkSpeed) => Colour(60, 60, 60),
        Some(Bound::WheelPower) => Colour(148, 0, 60),
        Some(Bound::Process) => Colour(0, 114, 178),
        Some(Bound::Limit(Axis::C, LimitedQuantity::Velocity)) => Colour(86, 180, 233),
        Some(Bound::Limit(Axis::C, LimitedQuantity::Acceleration)) => Colour(230, 159, 0),
        Some(Bound::Limit(Axis::C, LimitedQuantity::Jerk)) => Colour(213, 94, 0),
        Some(Bound::Limit(_, LimitedQuantity::Velocity)) => Colour(140, 110, 40),
        Some(Bound::Limit(_, LimitedQuantity::Acceleration)) => Colour(0, 158, 115),
        Some(Bound::Limit(_, LimitedQuantity::Jerk)) => Colour(204, 121, 167),
    }
}
