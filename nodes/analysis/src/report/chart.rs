// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Charts as SVG in the page. Colours are classes that follow light and dark.

use camwright_planning::chart::{Axes, Frame, Scale};
use camwright_planning::markup::escape;
use std::fmt::Write as _;

/// A curve and what it is drawn as.
#[derive(Debug, Clone)]
pub(super) struct Curve {
    /// Class of its colour.
    pub(super) class: &'static str,
    pub(super) name: String,
    pub(super) points: Vec<(f64, f64)>,
}

/// A bound, drawn as a line across.
#[derive(Debug, Clone)]
pub(super) struct LevelLine {
    pub(super) value: f64,
    pub(super) label: String,
}

/// A place that is pointed at.
#[derive(Debug, Clone)]
pub(super) struct Mark {
    pub(super) at: (f64, f64),
    pub(super) label: String,
}

/// A coloured field behind the curves.
#[derive(Debug, Clone)]
pub(super) struct Zone {
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) class: &'static str,
}

#[derive(Debug, Clone, Default)]
pub(super) struct Chart {
    pub(super) title: String,
    /// Name and unit of what goes to the right.
    pub(super) across: &'static str,
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) step: f64,
    pub(super) curves: Vec<Curve>,
    pub(super) levels: Vec<LevelLine>,
    /// Half the height of the field that is allowed around 0, at even steps from `from` to `to`; empty: no field.
    pub(super) allowed: Vec<f64>,
    pub(super) mark: Option<Mark>,
    pub(super) zones: Vec<Zone>,
    /// 0 belongs into it.
    pub(super) has_zero: bool,
    pub(super) size: Size,
}

/// Width and height in its own pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Size(pub(super) f64, pub(super) f64);

impl Default for Size {
    fn default() -> Self {
        Self(600.0, 210.0)
    }
}

const LEFT: f64 = 58.0;
const RIGHT: f64 = 18.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 36.0;

/// Points farther apart than this share of the width are not joined.
const GAP: f64 = 0.025;

/// Maximum number of ticks across.
const MAX_TICKS: usize = 61;

impl Chart {
    /// A chart over the azimuth of the part.
    pub(super) fn over_azimuth(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            across: "azimuth on the part from C 0 (°)",
            from: 0.0,
            to: 360.0,
            step: 30.0,
            ..Self::default()
        }
    }

    /// A figure with its title and the names of its curves; one sentence where there is nothing to draw.
    pub(super) fn figure(&self) -> String {
        let mut out = format!("<figure><figcaption>{}</figcaption>", escape(&self.title));
        if self.curves.iter().all(|curve| curve.points.is_empty()) {
            out.push_str("<p class=\"none\">not recorded</p></figure>");
            return out;
        }
        self.svg(&mut out);
        let named = self.curves.iter().filter(|curve| !curve.name.is_empty() && !curve.points.is_empty());
        out.push_str("<div class=\"legend\">");
        for curve in named {
            let _infallible = write!(out, "<span><i class=\"{}\"></i>{}</span>", curve.class, escape(&curve.name));
        }
        out.push_str("</div></figure>");
        out
    }

    fn axes(&self) -> Axes {
        let points = self.curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.1));
        let levels = self.levels.iter().map(|level| level.value);
        let allowed = self.allowed.iter().flat_map(|allowed| [-allowed, *allowed]);
        let Size(width, height) = self.size;
        Axes {
            frame: Frame { left: LEFT, top: TOP, width: width - LEFT - RIGHT, height: height - TOP - BOTTOM },
            across: Scale { low: self.from, high: self.to, step: self.step },
            up: Scale::around(points.chain(levels).chain(allowed).chain(self.has_zero.then_some(0.0))),
        }
    }

    fn svg(&self, out: &mut String) {
        let Size(width, height) = self.size;
        let axes = self.axes();
        let _infallible = write!(
            out,
            "<svg viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" aria-label=\"{}\">",
            escape(&self.title)
        );
        self.write_zones(out, &axes);
        self.write_axes(out, &axes);
        self.write_bounds(out, &axes);
        for curve in &self.curves {
            let _infallible = write!(out, "<path class=\"{}\" d=\"{}\"/>", curve.class, path(&axes, &curve.points));
        }
        if let Some(mark) = &self.mark {
            write_mark(out, &axes, mark);
        }
        out.push_str("</svg>");
    }

    fn write_zones(&self, out: &mut String, axes: &Axes) {
        for zone in &self.zones {
            let (from, to) = (axes.x(zone.from.max(self.from)), axes.x(zone.to.min(self.to)));
            let _infallible = write!(
                out,
                "<rect class=\"{}\" x=\"{from:.1}\" y=\"{TOP:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>",
                zone.class,
                (to - from).max(0.0),
                axes.frame.height
            );
        }
    }

    /// The allowed field around 0, and lines across.
    fn write_bounds(&self, out: &mut String, axes: &Axes) {
        let right = axes.frame.right();
        if !self.allowed.is_empty() {
            let step = (self.to - self.from) / self.allowed.len() as f64;
            // Only the ends of equal values are drawn.
            let ends = |sign: f64| {
                self.allowed.chunk_by(|one, next| one.to_bits() == next.to_bits()).scan(0, move |at, same| {
                    let (from, to) = (*at, *at + same.len());
                    *at = to;
                    Some([from, to].map(|index| (self.from + index as f64 * step, sign * same[0])))
                })
            };
            let (high, low): (Vec<_>, Vec<_>) = (ends(1.0).flatten().collect(), ends(-1.0).flatten().collect());
            let line = |points: &mut dyn Iterator<Item = &(f64, f64)>| {
                let mut text = String::new();
                for (index, (x, y)) in points.enumerate() {
                    let letter = if index == 0 { 'M' } else { 'L' };
                    let _infallible = write!(text, "{letter}{:.1} {:.1}", axes.x(*x), axes.y(*y));
                }
                text
            };
            let _infallible = write!(
                out,
                "<path class=\"allowed\" d=\"{}Z\"/><path class=\"limit\" d=\"{}{}\"/>",
                line(&mut high.iter().chain(low.iter().rev())),
                line(&mut high.iter()),
                line(&mut low.iter())
            );
        }
        for level in &self.levels {
            let at = axes.y(level.value);
            let _infallible = write!(
                out,
                "<path class=\"limit\" d=\"M{LEFT:.1} {at:.1}H{right:.1}\"/><text x=\"{:.1}\" y=\"{:.1}\" class=\"end limit-text\">{}</text>",
                right - 4.0,
                at - 4.0,
                escape(&level.label)
            );
        }
    }

    fn write_axes(&self, out: &mut String, axes: &Axes) {
        let (right, bottom) = (axes.frame.right(), axes.frame.bottom());
        let mut grid = String::new();
        for tick in axes.up.ticks() {
            let at = axes.y(tick);
            let label = axes.up.label(tick);
            let _infallible = write!(grid, "M{LEFT:.1} {at:.1}H{right:.1}");
            let _infallible =
                write!(out, "<text class=\"end\" x=\"{:.1}\" y=\"{:.1}\">{label}</text>", LEFT - 6.0, at + 4.0);
        }
        for tick in axes.across.ticks().take(MAX_TICKS) {
            let at = axes.x(tick);
            let label = axes.across.label(tick);
            let _infallible = write!(grid, "M{at:.1} {TOP:.1}V{bottom:.1}");
            let _infallible =
                write!(out, "<text class=\"mid\" x=\"{at:.1}\" y=\"{:.1}\">{label}</text>", bottom + 15.0);
        }
        let _infallible = write!(
            out,
            "<path class=\"grid\" d=\"{grid}\"/><text class=\"mid\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            0.5 * (LEFT + right),
            self.size.1 - 4.0,
            escape(self.across)
        );
        if let Some(zero) = axes.zero() {
            let _infallible = write!(out, "<path class=\"zero\" d=\"M{LEFT:.1} {zero:.1}H{right:.1}\"/>");
        }
    }
}

/// Path of a curve, in one line for each part without a gap.
fn path(axes: &Axes, points: &[(f64, f64)]) -> String {
    let mut path = String::with_capacity(10 * points.len());
    let gap = GAP * (axes.across.high - axes.across.low);
    for line in axes.lines(points.iter().copied(), gap) {
        for (index, [x, y]) in line.into_iter().enumerate() {
            let _infallible = write!(path, "{}{x:.1} {y:.1}", if index == 0 { 'M' } else { 'L' });
        }
    }
    path
}

/// A circle around a point, with its label on the side towards the middle.
fn write_mark(out: &mut String, axes: &Axes, mark: &Mark) {
    let [at_x, at_y] = axes.at(mark.at.0, mark.at.1);
    let middle = [0.5 * (axes.across.low + axes.across.high), 0.5 * (axes.up.low + axes.up.high)];
    let anchor = if mark.at.0 > middle[0] { ("end", -9.0) } else { ("start", 9.0) };
    let above = if mark.at.1 > middle[1] { 4.0 } else { 5.0 };
    let _infallible = write!(
        out,
        "<circle class=\"worst\" cx=\"{at_x:.1}\" cy=\"{at_y:.1}\" r=\"5\"/>\
         <text class=\"worst-text {}\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
        anchor.0,
        at_x + anchor.1,
        at_y + above,
        escape(&mark.label)
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_stop_at_gaps_and_missing_data_is_reported() {
        let curve = |points: Vec<(f64, f64)>| Curve { class: "is", name: "<b>".into(), points };
        let chart =
            Chart { curves: vec![curve(vec![(0.0, 1.0), (1.0, 2.0), (180.0, 3.0)])], ..Chart::over_azimuth("a & b") };
        let figure = chart.figure();
        let path = figure.split("<path class=\"is\" d=\"").nth(1).and_then(|rest| rest.split('"').next());
        let path = path.expect("a curve");
        assert_eq!((path.matches('M').count(), path.matches('L').count()), (2, 1), "{path}");
        assert!(figure.contains("a &amp; b") && figure.contains("&lt;b&gt;"), "{figure}");
        let none = Chart { curves: vec![curve(Vec::new())], ..Chart::over_azimuth("x") }.figure();
        assert!(none.contains("not recorded") && !none.contains("<svg"), "{none}");
    }
}
