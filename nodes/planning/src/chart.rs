// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Geometry of charts: axes with ticks at round numbers, curves as lines within a frame.
//!
//! The plots of `camwright plan` draw it on paper, the report of a run as SVG in its page.

/// A point of a chart: x to the right, y down from the upper edge.
pub type Point = [f64; 2];

/// A rectangle: millimetres on paper, pixels in a page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

impl Frame {
    #[must_use]
    pub fn right(&self) -> f64 {
        self.left + self.width
    }

    #[must_use]
    pub fn bottom(&self) -> f64 {
        self.top + self.height
    }

    /// Corners as a closed line.
    #[must_use]
    pub fn corners(&self) -> [Point; 5] {
        let (left, right, top, bottom) = (self.left, self.right(), self.top, self.bottom());
        [[left, top], [right, top], [right, bottom], [left, bottom], [left, top]]
    }
}

/// Maximum number of steps of a value axis.
const MAX_STEPS: f64 = 7.5;

/// Margin beyond the outermost values, as a share of their range: a limit does not lie on the frame. An end at 0 has none.
const MARGIN: f64 = 0.06;

/// Range of an axis with ticks at round numbers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Scale {
    pub low: f64,
    pub high: f64,
    pub step: f64,
}

impl Scale {
    /// Scale of the angles of one turn (deg).
    pub const TURN_DEG: Self = Self { low: 0.0, high: 360.0, step: 30.0 };

    /// Scale around values; equal values get a margin on both sides.
    pub fn around(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        let (low, high) = if low > high { (0.0, 0.0) } else { (low, high) };
        let min = 1e-6 * low.abs().max(high.abs()).max(1e-6);
        let (low, high) = if high - low > min { (low, high) } else { (low - 1.0, high + 1.0) };
        let margin = |end: f64| if end.abs() > 0.0 { MARGIN * (high - low) } else { 0.0 };
        let (low, high) = (low - margin(low), high + margin(high));
        Self { low, high, step: round_step(high - low, MAX_STEPS) }
    }

    /// The same range with at most so many steps.
    pub(crate) fn with_steps(self, max: f64) -> Self {
        Self { step: self.step.max(round_step(self.high - self.low, max)), ..self }
    }

    /// A range as it is, without a margin.
    #[must_use]
    pub fn exactly(low: f64, high: f64, max_steps: f64) -> Self {
        Self { low, high, step: round_step((high - low).max(1e-9), max_steps) }
    }

    /// Number of a tick, with the digits of the step.
    #[must_use]
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

    pub fn ticks(&self) -> impl Iterator<Item = f64> + use<> {
        let (step, first) = (self.step, (self.low / self.step - 1e-9).ceil());
        #[allow(clippy::cast_possible_truncation, reason = "some seven")]
        let count = ((self.high / step + 1e-9).floor() - first).max(0.0) as u32;
        (0..=count).map(move |index| (first + f64::from(index)) * step)
    }

    /// Share of the range below a value.
    fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    fn contains(&self, value: f64) -> bool {
        let tolerance = 1e-9 * (self.high - self.low);
        (self.low - tolerance..=self.high + tolerance).contains(&value)
    }
}

/// The largest of 1, 2 and 5 times a power of ten that divides `range` into as few parts as `max`.
#[must_use]
pub fn round_step(range: f64, max: f64) -> f64 {
    let min = range / max;
    let power = 10.0_f64.powf(min.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|digit| digit * power).find(|step| *step >= min * (1.0 - 1e-9)).unwrap_or(min)
}

/// Axes of a chart: a scale across and a scale up, in a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axes {
    pub frame: Frame,
    pub across: Scale,
    pub up: Scale,
}

impl Axes {
    #[must_use]
    pub fn x(&self, across: f64) -> f64 {
        self.frame.left + self.frame.width * self.across.share(across)
    }

    #[must_use]
    pub fn y(&self, value: f64) -> f64 {
        self.frame.bottom() - self.frame.height * self.up.share(value)
    }

    #[must_use]
    pub fn at(&self, across: f64, value: f64) -> Point {
        [self.x(across), self.y(value)]
    }

    /// Height of the line of zero; none if zero is an end of the scale or outside of it.
    #[must_use]
    pub fn zero(&self) -> Option<f64> {
        (self.up.low < 0.0 && self.up.high > 0.0).then(|| self.y(0.0))
    }

    /// Lines of a curve. It is interrupted where its values leave the scale, and where its points are farther apart than `gap`.
    pub fn lines(&self, points: impl IntoIterator<Item = (f64, f64)>, gap: f64) -> Vec<Vec<Point>> {
        let mut lines: Vec<Vec<Point>> = Vec::new();
        let mut before = None;
        for (across, value) in points {
            if !self.up.contains(value) {
                before = None;
                continue;
            }
            let point = self.at(across.clamp(self.across.low, self.across.high), value);
            match lines.last_mut().filter(|_| before.is_some_and(|before| across - before <= gap)) {
                Some(line) => line.push(point),
                None => lines.push(vec![point]),
            }
            before = Some(across);
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_few() {
        for (range, step) in [(9.99, 1.0), (17.06, 2.0), (0.499, 0.05), (41.0, 5.0), (1.0, 0.1), (0.012, 0.002)] {
            assert!((round_step(range, 10.0) / step - 1.0).abs() < 1e-12, "{range}: {}", round_step(range, 10.0));
        }
    }

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
        assert_eq!(Scale::TURN_DEG.ticks().count(), 13);
    }

    #[test]
    fn ticks_have_the_digits_of_their_step() {
        let scale = Scale::around([-0.2, 0.3].into_iter());
        let labels: Vec<String> = scale.ticks().map(|tick| scale.label(tick)).collect();
        assert_eq!(labels, ["−0.2", "−0.1", "0.0", "0.1", "0.2", "0.3"]);
        let scale = Scale::around([0.0, 30_000.0].into_iter());
        assert_eq!(scale.ticks().map(|tick| scale.label(tick)).last().as_deref(), Some("30000"));
    }

    #[test]
    fn a_curve_is_interrupted_outside_of_the_scale_and_at_a_gap() {
        let frame = Frame { left: 10.0, top: 20.0, width: 360.0, height: 100.0 };
        let axes = Axes { frame, across: Scale::TURN_DEG, up: Scale { low: -1.0, high: 1.0, step: 0.5 } };
        assert_eq!((axes.at(0.0, -1.0), axes.at(360.0, 1.0), axes.zero()), ([10.0, 120.0], [370.0, 20.0], Some(70.0)));
        let points = [(0.0, 0.0), (1.0, 1.0), (2.0, 3.0), (3.0, -1.0), (4.0, 0.0), (90.0, 0.0)];
        let lines = axes.lines(points, 9.0);
        assert_eq!(lines.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2, 1]);
        assert_eq!(axes.lines(points, f64::INFINITY).len(), 2);
    }
}
