// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The paper and the marks on it.

use super::lettering::Lettering;
use super::pen::{Colour, Pen};
use crate::chart::Point;

/// A mark on the paper; later ones lie above.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum DrawingItem {
    /// A line through points.
    Line { points: Vec<Point>, pen: Pen },
    /// The inside of a closed line.
    Area { points: Vec<Point>, colour: Colour },
    /// Lettering of a height as its strokes.
    Text { text: String, height_mm: f64, strokes: Vec<Vec<Point>>, pen: Pen },
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Drawing {
    pub(super) width_mm: f64,
    pub(super) height_mm: f64,
    pub(super) title: String,
    pub(super) marks: Vec<DrawingItem>,
}

/// A drawing, the name of its files, and one sentence about it for the index.
pub(crate) struct Plot {
    pub(crate) name: String,
    pub(crate) caption: String,
    pub(crate) drawing: Drawing,
}

/// Maximum distance of a line from its points (mm): a tenth of the thinnest pen.
const TOLERANCE_MM: f64 = 0.01;

impl Drawing {
    pub(crate) fn new(width_mm: f64, height_mm: f64, title: &str) -> Self {
        Self { width_mm, height_mm, title: title.into(), marks: Vec::new() }
    }

    /// A line through points, without those that are not seen.
    pub(crate) fn line(&mut self, points: &[Point], pen: Pen) {
        if points.len() > 1 && points.iter().flatten().all(|value| value.is_finite()) {
            self.marks.push(DrawingItem::Line { points: thinned(points), pen });
        }
    }

    /// The inside of a closed line.
    pub(crate) fn area(&mut self, points: &[Point], colour: Colour) {
        if points.len() > 2 && points.iter().flatten().all(|value| value.is_finite()) {
            self.marks.push(DrawingItem::Area { points: thinned(points), colour });
        }
    }

    /// Lettering; `at` is the end or the middle of its base line.
    pub(crate) fn text(&mut self, at: Point, lettering: Lettering, text: &str) {
        let (strokes, pen) = lettering.strokes(at, text);
        self.marks.push(DrawingItem::Text { text: text.into(), height_mm: lettering.height_mm, strokes, pen });
    }
}

#[cfg(test)]
impl Drawing {
    /// The smallest and the largest place of anything on it (mm).
    pub(crate) fn extent(&self) -> [Point; 2] {
        let points = self.marks.iter().flat_map(|mark| match mark {
            DrawingItem::Line { points, .. } | DrawingItem::Area { points, .. } => points.clone(),
            DrawingItem::Text { strokes, .. } => strokes.concat(),
        });
        points.fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[low, high], point| {
            [[low[0].min(point[0]), low[1].min(point[1])], [high[0].max(point[0]), high[1].max(point[1])]]
        })
    }

    /// Texts that are cut at the border, overlap another text or are too small to read.
    pub(crate) fn text_faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        let mut seen: Vec<(&str, [Point; 2])> = Vec::new();
        for mark in &self.marks {
            let DrawingItem::Text { text, height_mm, strokes, pen } = mark else { continue };
            if *height_mm < Lettering::SMALLEST_MM {
                faults.push(format!("\"{text}\" is {height_mm:.2} mm high"));
            }
            if strokes.is_empty() {
                continue;
            }
            let half = 0.5 * pen.width_mm;
            let values = |side: usize| strokes.iter().flatten().map(move |point| point[side]);
            let low = [0, 1].map(|side| values(side).fold(f64::INFINITY, f64::min) - half);
            let high = [0, 1].map(|side| values(side).fold(f64::NEG_INFINITY, f64::max) + half);
            if low[0] < 0.0 || low[1] < 0.0 || high[0] > self.width_mm || high[1] > self.height_mm {
                faults.push(format!("\"{text}\" is cut: {low:.1?} to {high:.1?}"));
            }
            let overlapped = seen.iter().filter(|(_, [other_low, other_high])| {
                (0..2).all(|side| low[side] < other_high[side] && other_low[side] < high[side])
            });
            faults.extend(overlapped.map(|(other, _)| format!("\"{text}\" overlaps \"{other}\" at {low:.1?}")));
            seen.push((text, [low, high]));
        }
        faults
    }
}

/// Ramer, Douglas and Peucker: as few of the points as keep the line.
fn thinned(points: &[Point]) -> Vec<Point> {
    let last = points.len() - 1;
    let mut keep = vec![false; points.len()];
    (keep[0], keep[last]) = (true, true);
    let mut stretches = vec![(0, last)];
    while let Some((from, to)) = stretches.pop() {
        let ([ax, ay], [bx, by]) = (points[from], points[to]);
        let (dx, dy) = (bx - ax, by - ay);
        let length = dx.hypot(dy);
        let distance = |[x, y]: Point| match length {
            // A closed line: as far as from its first point.
            length if length < TOLERANCE_MM => (x - ax).hypot(y - ay),
            length => ((x - ax) * dy - (y - ay) * dx).abs() / length,
        };
        let farthest = (from + 1..to).max_by(|a, b| distance(points[*a]).total_cmp(&distance(points[*b])));
        if let Some(farthest) = farthest.filter(|index| distance(points[*index]) > TOLERANCE_MM) {
            keep[farthest] = true;
            stretches.push((from, farthest));
            stretches.push((farthest, to));
        }
    }
    points.iter().zip(keep).filter_map(|(point, keep)| keep.then_some(*point)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The check itself: a text over the border, two over one another, a small one, and two neighbours that are fine.
    #[test]
    fn texts_that_cannot_be_read_are_found() {
        let of = |texts: &[(Point, f64, &str)]| {
            let mut drawing = Drawing::new(60.0, 40.0, "texts");
            for (at, height_mm, text) in texts {
                drawing.text(*at, Lettering { height_mm: *height_mm, ..Lettering::default() }, text);
            }
            drawing.text_faults()
        };
        assert_eq!(
            of(&[([5.0, 10.0], 2.5, "one"), ([5.0, 13.5], 2.5, "below"), ([20.0, 10.0], 2.5, "beside")]),
            [""; 0]
        );
        for (texts, fault) in [
            (vec![([55.0, 10.0], 2.5, "beyond")], "cut"),
            (vec![([5.0, 1.0], 2.5, "above")], "cut"),
            (vec![([5.0, 10.0], 2.5, "one"), ([9.0, 11.0], 2.5, "other")], "overlaps"),
            (vec![([5.0, 10.0], 2.4, "small")], "high"),
        ] {
            let faults = of(&texts);
            assert!(faults.len() == 1 && faults[0].contains(fault), "{texts:?}: {faults:?}");
        }
    }

    #[test]
    fn a_straight_line_keeps_its_ends_and_a_corner_its_point() {
        let straight: Vec<Point> = (0..100).map(|i| [f64::from(i), 2.0 * f64::from(i)]).collect();
        assert_eq!(thinned(&straight), [[0.0, 0.0], [99.0, 198.0]]);
        let corner = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 2.0]];
        assert_eq!(thinned(&corner), [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0]]);
    }

    /// No point of a thinned circle lies farther off than the tolerance: the sagitta of its chords.
    #[test]
    fn a_thinned_circle_stays_within_the_tolerance() {
        let circle: Vec<Point> = (0..=3600)
            .map(|i| f64::from(i) * std::f64::consts::TAU / 3600.0)
            .map(|a| [50.0 * a.cos(), 50.0 * a.sin()])
            .collect();
        let thin = thinned(&circle);
        assert!(thin.len() < 400, "{}", thin.len());
        for pair in thin.windows(2) {
            let middle = [0.5 * (pair[0][0] + pair[1][0]), 0.5 * (pair[0][1] + pair[1][1])];
            assert!(50.0 - middle[0].hypot(middle[1]) <= 1.001 * TOLERANCE_MM);
        }
    }
}
