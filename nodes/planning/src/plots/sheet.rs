//! A sheet of paper with title, foot and legend, for the drawings of a lobe and of its passes.

use super::chart::{CURVE_MM, SMALL};
use crate::PreparedJob;
use crate::chart::Frame;
use crate::drawing::{Anchor, Colour, Drawing, Lettering, Pen};
use crate::summary::{LobeSummary, PassSummary};
use crate::turn::LobeTurn;
use crate::turn_summary::{Arc, bound_name};
use camwright::machine::description::Axis;
use camwright::motion::speed_plan::{Bound, LimitedQuantity};

/// Paper: A4, broadside (mm).
pub(super) const PAPER: (f64, f64) = (297.0, 210.0);

/// Room for charts on it.
pub(super) const ROOM: Frame = Frame { left: 32.0, top: 33.0, width: 252.0, height: 139.0 };

/// Positions of legend and foot.
const LEGEND_MM: f64 = 196.5;
const FOOT_MM: f64 = 204.0;

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
    let bold = Lettering { height_mm: 4.2, is_bold: true, ..Lettering::default() };
    drawing.text([12.0, 14.0], bold, title);
    drawing.text([12.0, 21.0], Lettering { height_mm: 2.9, ..Lettering::default() }, shows);
    let small = Lettering { height_mm: 2.1, colour: Colour::GREY, ..Lettering::default() };
    drawing.text([12.0, FOOT_MM], small, made_of);
    let by = format!("camwright, {by}");
    drawing.text([PAPER.0 - 12.0, FOOT_MM], Lettering { anchor: Anchor::End, ..small }, &by);
    drawing
}

/// A line with its name in the legend, which goes on from here to what is returned (mm).
pub(super) fn legend_entry(drawing: &mut Drawing, x: f64, text: &str, pen: Pen) -> f64 {
    let lettering = Lettering { height_mm: 2.3, ..Lettering::default() };
    drawing.line(&[[x, LEGEND_MM - 1.1], [x + 7.0, LEGEND_MM - 1.1]], pen);
    drawing.text([x + 9.0, LEGEND_MM], lettering, text);
    x + 9.0 + lettering.width_mm(text) + 5.5
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

    /// Lines with their names, then a colour for each bound that rules with its share of the time, along the foot of a sheet.
    pub(super) fn legend(&self, drawing: &mut Drawing, first: &[(String, Pen)]) {
        let mut x = 14.0;
        let mut entry = |text: &str, pen: Pen| x = legend_entry(drawing, x, text, pen);
        for (text, pen) in first {
            entry(text, *pen);
        }
        for bound in self.ruling() {
            let name = bound_name(&self.turn.bounds.speed, bound);
            let found = self.summary.bounds.iter().find(|summary| summary.bound == name);
            let share = found.map_or(0.0, |found| found.share);
            entry(&format!("{} {:.0} %", in_words(&name), 100.0 * share), Pen::solid(colour(bound), 3.0 * CURVE_MM));
        }
    }

    /// The bounds that rule somewhere, in a fixed order.
    pub(super) fn ruling(&self) -> Vec<Option<Bound>> {
        let all = Bound::ALL.into_iter().map(Some).chain([None]);
        all.filter(|bound| self.arcs.iter().any(|arc| arc.bound == *bound)).collect()
    }

    /// A band of the colours below the charts.
    pub(super) fn band(&self, drawing: &mut Drawing, frame: Frame) {
        for arc in &self.arcs {
            for stretch in self.stretches(*arc) {
                let x = |index: usize| frame.left + frame.width * self.c_deg(index).min(360.0) / 360.0;
                let (from, to) = (x(*stretch.start()), x(*stretch.end()));
                let (top, bottom) = (frame.top, frame.bottom());
                drawing.area(&[[from, top], [to, top], [to, bottom], [from, bottom]], colour(arc.bound));
            }
        }
        drawing.line(&frame.corners(), Pen::solid(Colour::BLACK, 0.2));
        let name = Lettering { anchor: Anchor::End, ..SMALL };
        drawing.text([frame.left - 1.2, frame.bottom() - 0.9], name, "set by");
    }
}

/// A bound's name for people.
fn in_words(name: &str) -> String {
    name.replace("c_axis", "C").replace("x_axis", "X").replace('_', " ").replace("none", "between two bounds")
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
