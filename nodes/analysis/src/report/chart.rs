//! A chart as SVG: numbers on round ticks, curves by columns, colours by classes that follow light and dark.

use super::text::{escape, fixed};
use camwright_planning::Scale;
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
pub(super) struct Level {
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
    pub(super) levels: Vec<Level>,
    /// Half the height of the field that is allowed around 0.
    pub(super) allowed: Option<f64>,
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

    fn scale(&self) -> Scale {
        let points = self.curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.1));
        let levels = self.levels.iter().map(|level| level.value);
        let allowed = self.allowed.iter().flat_map(|allowed| [-allowed, *allowed]);
        Scale::around(points.chain(levels).chain(allowed).chain(self.has_zero.then_some(0.0)))
    }

    fn svg(&self, out: &mut String) {
        let Size(width, height) = self.size;
        let field = Field { size: self.size, across: (self.from, self.to), scale: self.scale() };
        let _infallible = write!(
            out,
            "<svg viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" aria-label=\"{}\">",
            escape(&self.title)
        );
        self.zones(out, &field);
        self.axes(out, &field);
        self.bounds(out, &field);
        for curve in &self.curves {
            let _infallible = write!(out, "<path class=\"{}\" d=\"{}\"/>", curve.class, field.path(curve));
        }
        if let Some(mark) = &self.mark {
            field.mark(out, mark);
        }
        out.push_str("</svg>");
    }

    fn zones(&self, out: &mut String, field: &Field) {
        for zone in &self.zones {
            let (from, to) = (field.x(zone.from.max(self.from)), field.x(zone.to.min(self.to)));
            let _infallible = write!(
                out,
                "<rect class=\"{}\" x=\"{from:.1}\" y=\"{TOP:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>",
                zone.class,
                (to - from).max(0.0),
                field.bottom() - TOP
            );
        }
    }

    /// What is allowed around 0, and lines across.
    fn bounds(&self, out: &mut String, field: &Field) {
        let right = field.right();
        if let Some(allowed) = self.allowed {
            let (high, low) = (field.y(allowed), field.y(-allowed));
            let _infallible = write!(
                out,
                "<rect class=\"allowed\" x=\"{LEFT:.1}\" y=\"{high:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>\
                 <path class=\"limit\" d=\"M{LEFT:.1} {high:.1}H{right:.1}M{LEFT:.1} {low:.1}H{right:.1}\"/>",
                right - LEFT,
                low - high
            );
        }
        for level in &self.levels {
            let at = field.y(level.value);
            let _infallible = write!(
                out,
                "<path class=\"limit\" d=\"M{LEFT:.1} {at:.1}H{right:.1}\"/><text x=\"{:.1}\" y=\"{:.1}\" class=\"end limit-text\">{}</text>",
                right - 4.0,
                at - 4.0,
                escape(&level.label)
            );
        }
    }

    fn axes(&self, out: &mut String, field: &Field) {
        let (scale, right, bottom) = (&field.scale, field.right(), field.bottom());
        let mut grid = String::new();
        for tick in scale.ticks() {
            let at = field.y(tick);
            let _infallible = write!(grid, "M{LEFT:.1} {at:.1}H{right:.1}");
            let _infallible = write!(
                out,
                "<text class=\"end\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                LEFT - 6.0,
                at + 4.0,
                scale.label(tick)
            );
        }
        let count = ((self.to - self.from) / self.step + 1e-9).floor();
        let mut index = 0.0;
        while index <= count.min(60.0) {
            let value = self.from + index * self.step;
            let at = field.x(value);
            let _infallible = write!(grid, "M{at:.1} {TOP:.1}V{bottom:.1}");
            let _infallible = write!(
                out,
                "<text class=\"mid\" x=\"{at:.1}\" y=\"{:.1}\">{}</text>",
                bottom + 15.0,
                scale_free(value, self.step)
            );
            index += 1.0;
        }
        let _infallible = write!(
            out,
            "<path class=\"grid\" d=\"{grid}\"/><text class=\"mid\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            0.5 * (LEFT + right),
            self.size.1 - 4.0,
            escape(self.across)
        );
        if scale.low < 0.0 && scale.high > 0.0 {
            let zero = field.y(0.0);
            let _infallible = write!(out, "<path class=\"zero\" d=\"M{LEFT:.1} {zero:.1}H{right:.1}\"/>");
        }
    }
}

/// Where what stands on the axes of a chart is drawn.
struct Field {
    size: Size,
    across: (f64, f64),
    scale: Scale,
}

impl Field {
    fn right(&self) -> f64 {
        self.size.0 - RIGHT
    }

    fn bottom(&self) -> f64 {
        self.size.1 - BOTTOM
    }

    fn x(&self, value: f64) -> f64 {
        let (from, to) = self.across;
        LEFT + (self.size.0 - LEFT - RIGHT) * (value - from) / (to - from)
    }

    fn y(&self, value: f64) -> f64 {
        let (height, scale) = (self.size.1, &self.scale);
        height - BOTTOM - (height - TOP - BOTTOM) * (value - scale.low) / (scale.high - scale.low)
    }

    fn path(&self, curve: &Curve) -> String {
        let mut path = String::with_capacity(10 * curve.points.len());
        let mut before = f64::NEG_INFINITY;
        for (at, value) in &curve.points {
            let letter = if at - before > GAP * (self.across.1 - self.across.0) { 'M' } else { 'L' };
            let _infallible = write!(path, "{letter}{:.1} {:.1}", self.x(*at), self.y(*value));
            before = *at;
        }
        path
    }

    fn mark(&self, out: &mut String, mark: &Mark) {
        let (at_x, at_y) = (self.x(mark.at.0), self.y(mark.at.1));
        let middle = (0.5 * (self.across.0 + self.across.1), 0.5 * (self.scale.low + self.scale.high));
        let anchor = if mark.at.0 > middle.0 { ("end", -9.0) } else { ("start", 9.0) };
        // Beside the point, where the curve has just turned round, there is room on the side towards the middle.
        let above = if mark.at.1 > middle.1 { 4.0 } else { 5.0 };
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
}

/// A tick's number with the digits that its step needs.
fn scale_free(value: f64, step: f64) -> String {
    fixed(value, if step < 0.1 { 2 } else { usize::from(step < 1.0) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_not_joined_over_a_gap_and_nothing_recorded_is_said_so() {
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
