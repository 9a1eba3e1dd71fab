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
    /// Lettering as its strokes.
    Text { text: String, strokes: Vec<Vec<Point>>, pen: Pen },
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Drawing {
    pub(super) width_mm: f64,
    pub(super) height_mm: f64,
    pub(super) title: String,
    pub(super) marks: Vec<DrawingItem>,
}

/// A drawing, and the name of its files.
pub(crate) struct Plot {
    pub(crate) name: String,
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
        self.marks.push(DrawingItem::Text { text: text.into(), strokes, pen });
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
