// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lines and arcs through the points of a contour.
//!
//! Points of a part with flats lie beside its lines by their rounding, and a curve through them is hollow between them. Here the drawing is
//! found again:
//!
//! 1. From one point on, the longest run of points within the tolerance of one line, or of one circle, is an element.
//! 2. All elements are moved at once, so that neighbours are tangent and the sum of the squares of all distances is smallest: Gauss and
//!    Newton's method with a multiplier of Lagrange for each tangency.
//! 3. Each point belongs to the element between whose tangent points it lies; step 2 is repeated until no point changes.
//!
//! A line is n(ψ)·p = d with its normal n to the outside; an arc has the centre c and the signed radius ρ, positive where it is convex. The
//! distances to the outside are n·p − d and ±|p − c| − ρ. A line and an arc are tangent where d − n·c = ρ, two arcs where
//! |c₂ − c₁| = |ρ₁ − ρ₂|.

use super::OutlineSegment;
use crate::cam::lift::LiftError;
use crate::cam::lift::points::{ContourPoint, unwrapped_points};
use crate::math::units::{TURN_RAD, wrap_turn};
use alloc::vec::Vec;
use core::f64::consts::PI;
use nalgebra::{DMatrix, DVector, Vector2};
use thiserror::Error;

/// Why points are no lines and arcs.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum OutlineFitError {
    /// A tolerance that is none.
    #[error("the tolerance is {tolerance_mm} mm; it must be above 0")]
    Tolerance {
        /// The tolerance (mm).
        tolerance_mm: f64,
    },
    /// Points that go not once round the axis.
    #[error("{} of the points cannot be used", .0.len())]
    Points(Vec<LiftError>),
    /// More lines and arcs than a drawing has.
    #[error(
        "lines and arcs within {tolerance_um} um of the points would be more than {max}: the contour is no outline of lines and arcs, or \
         the tolerance is smaller than the rounding of its points"
    )]
    TooMany {
        /// Tolerance (µm).
        tolerance_um: f64,
        /// Largest number of lines and arcs.
        max: usize,
    },
    /// A corner.
    #[error(
        "two lines meet in a corner at this point; a wheel cannot grind it: give at least 4 points of an arc between them"
    )]
    Corner {
        /// Line of the file.
        line: usize,
    },
    /// A point is too far from all lines and arcs that are tangent to each other.
    #[error(
        "this point is {deviation_um:.3} um away from the nearest outline of tangent lines and arcs; allowed: {tolerance_um} um"
    )]
    TooFar {
        /// Line of the file.
        line: usize,
        /// Its distance (µm).
        deviation_um: f64,
        /// Tolerance (µm).
        tolerance_um: f64,
    },
    /// Elements that cannot be made tangent.
    #[error("no lines and arcs through the points are tangent to each other near this point")]
    NotTangent {
        /// Line of the file.
        line: usize,
    },
}

impl OutlineFitError {
    /// Line of the file that it is about.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        match *self {
            Self::Corner { line } | Self::TooFar { line, .. } | Self::NotTangent { line } => Some(line),
            Self::Tolerance { .. } | Self::Points(_) | Self::TooMany { .. } => None,
        }
    }
}

/// Lines and arcs found through points.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedOutline {
    /// Start of the first segment (mm).
    pub start_mm: [f64; 2],
    /// Lines and arcs, counterclockwise; each begins where the one before ends.
    pub segments: Vec<OutlineSegment>,
    /// Largest distance of a point from them (mm).
    pub max_deviation_mm: f64,
    /// Number of points.
    pub points: usize,
}

impl FittedOutline {
    /// Number of lines.
    #[must_use]
    pub fn lines(&self) -> usize {
        self.segments.iter().filter(|segment| segment.radius_mm.is_none()).count()
    }
}

/// Largest number of elements that are fitted at once.
const MAX_ELEMENTS: usize = 64;

/// Steps of the fit, and rounds of new assignments of the points.
const MAX_STEPS: usize = 50;
const MAX_ROUNDS: usize = 20;

/// Change of an element below which the fit is at its end (mm, rad).
const AT_REST: f64 = 1e-12;

/// Error of a tangency by rounding (mm).
const TANGENT_MM: f64 = 1e-9;

/// Largest radius of an arc (mm), as in a job file.
const LARGEST_RADIUS_MM: f64 = 1e4;

const UM_PER_MM: f64 = 1e3;

/// A line or a circle, of which the outline uses a part.
#[derive(Debug, Clone, Copy, PartialEq)]
enum OutlineElement {
    Line { normal_rad: f64, distance_mm: f64 },
    Arc { centre: Vector2<f64>, radius_mm: f64 },
}

/// A run of points and the element through it; `first` counts from the first point, `count` goes on round the closed contour.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PointRun {
    first: usize,
    count: usize,
    element: OutlineElement,
}

impl OutlineElement {
    /// Number of unknowns.
    fn unknowns(&self) -> usize {
        match self {
            OutlineElement::Line { .. } => 2,
            OutlineElement::Arc { .. } => 3,
        }
    }

    /// Distance of a point to the outside (mm).
    fn outside_mm(&self, point: Vector2<f64>) -> f64 {
        match *self {
            OutlineElement::Line { normal_rad, distance_mm } => unit(normal_rad).dot(&point) - distance_mm,
            OutlineElement::Arc { centre, radius_mm } => (point - centre).norm().copysign(radius_mm) - radius_mm,
        }
    }

    /// The same with its derivatives by the unknowns.
    fn outside_and_slopes(&self, point: Vector2<f64>) -> (f64, [f64; 3]) {
        let outside_mm = self.outside_mm(point);
        match *self {
            OutlineElement::Line { normal_rad, .. } => (outside_mm, [across(normal_rad).dot(&point), -1.0, 0.0]),
            OutlineElement::Arc { centre, radius_mm } => {
                let away = (point - centre).normalize() * 1.0_f64.copysign(radius_mm);
                (outside_mm, [-away.x, -away.y, -1.0])
            }
        }
    }

    fn moved(&self, by: &[f64]) -> Self {
        match *self {
            OutlineElement::Line { normal_rad, distance_mm } => {
                OutlineElement::Line { normal_rad: normal_rad + by[0], distance_mm: distance_mm + by[1] }
            }
            OutlineElement::Arc { centre, radius_mm } => {
                OutlineElement::Arc { centre: centre + Vector2::new(by[0], by[1]), radius_mm: radius_mm + by[2] }
            }
        }
    }

    /// Error of the tangency with the next element (mm), with its derivatives by the unknowns of both; `None` for two lines.
    fn tangency(&self, next: &Self) -> Option<(f64, [f64; 3], [f64; 3])> {
        match (*self, *next) {
            (OutlineElement::Line { .. }, OutlineElement::Line { .. }) => None,
            (OutlineElement::Line { normal_rad, distance_mm }, OutlineElement::Arc { centre, radius_mm }) => {
                let normal = unit(normal_rad);
                let error_mm = distance_mm - normal.dot(&centre) - radius_mm;
                Some((error_mm, [-across(normal_rad).dot(&centre), 1.0, 0.0], [-normal.x, -normal.y, -1.0]))
            }
            (OutlineElement::Arc { .. }, OutlineElement::Line { .. }) => {
                next.tangency(self).map(|(error_mm, line, arc)| (error_mm, arc, line))
            }
            (OutlineElement::Arc { centre: a, radius_mm: ra }, OutlineElement::Arc { centre: b, radius_mm: rb }) => {
                let way = b - a;
                let (along, sense) = (way.normalize(), 1.0_f64.copysign(ra - rb));
                let error_mm = way.norm() - (ra - rb).abs();
                Some((error_mm, [-along.x, -along.y, -sense], [along.x, along.y, sense]))
            }
        }
    }

    /// Point in which two tangent elements touch.
    fn touch(&self, next: &Self) -> Vector2<f64> {
        match (*self, *next) {
            (OutlineElement::Line { normal_rad, .. }, OutlineElement::Arc { centre, radius_mm })
            | (OutlineElement::Arc { centre, radius_mm }, OutlineElement::Line { normal_rad, .. }) => {
                centre + radius_mm * unit(normal_rad)
            }
            (OutlineElement::Arc { centre: a, radius_mm: ra }, OutlineElement::Arc { centre: b, radius_mm: rb }) => {
                a + (b - a) * (ra / (ra - rb))
            }
            // Two lines are refused before.
            (OutlineElement::Line { normal_rad, distance_mm }, OutlineElement::Line { .. }) => {
                distance_mm * unit(normal_rad)
            }
        }
    }
}

fn unit(angle_rad: f64) -> Vector2<f64> {
    let (sin, cos) = libm::sincos(angle_rad);
    Vector2::new(cos, sin)
}

fn across(angle_rad: f64) -> Vector2<f64> {
    let (sin, cos) = libm::sincos(angle_rad);
    Vector2::new(-sin, cos)
}

fn azimuth(point: Vector2<f64>) -> f64 {
    libm::atan2(point.y, point.x)
}

/// The contour's points counterclockwise, with their lines in the file.
struct OutlinePoints {
    points: Vec<Vector2<f64>>,
    lines: Vec<usize>,
    tolerance_mm: f64,
}

/// Lines and arcs within a tolerance of the points of a contour, each tangent to the next.
///
/// # Errors
/// Points that do not go once round the axis; corners; a contour that is no outline of lines and arcs within the tolerance.
pub fn lines_and_arcs(points: &[ContourPoint], tolerance_mm: f64) -> Result<FittedOutline, OutlineFitError> {
    if !(tolerance_mm > 0.0 && tolerance_mm.is_finite()) {
        return Err(OutlineFitError::Tolerance { tolerance_mm });
    }
    let ordered = unwrapped_points(points).map_err(OutlineFitError::Points)?;
    let contour = OutlinePoints {
        points: ordered.iter().map(|(angle, radius, _)| *radius * unit(*angle)).collect(),
        lines: ordered.iter().map(|(_, _, line)| *line).collect(),
        tolerance_mm,
    };
    let mut runs = contour.runs()?;
    loop {
        let error = match contour.fitted(&runs) {
            Ok(fitted) => return Ok(fitted),
            Err(error) => error,
        };
        // A run that covers a transition of two others, or a wrong point, is no element of the drawing.
        let shortest = (0..runs.len()).min_by_key(|index| runs[*index].count);
        match shortest.filter(|index| runs.len() > 3 && runs[*index].count <= TRANSITION) {
            Some(index) => contour.without(&mut runs, index),
            None => return Err(error),
        }
    }
}

/// Largest number of points of a run that may be a transition.
const TRANSITION: usize = 5;

impl OutlinePoints {
    fn len(&self) -> usize {
        self.points.len()
    }

    fn run(&self, first: usize, count: usize) -> impl Iterator<Item = Vector2<f64>> + Clone + '_ {
        (first..first + count).map(|index| self.points[index % self.len()])
    }

    /// Runs of points that each have one element, round the contour.
    fn runs(&self) -> Result<Vec<PointRun>, OutlineFitError> {
        // The end of a first run is where one of the outline's elements ends, about.
        let begin = self.longest_run(0, self.len()).count % self.len();
        let mut runs: Vec<PointRun> = Vec::new();
        let mut done = 0;
        while done < self.len() {
            if runs.len() == MAX_ELEMENTS {
                let tolerance_um = self.tolerance_mm * UM_PER_MM;
                return Err(OutlineFitError::TooMany { tolerance_um, max: MAX_ELEMENTS });
            }
            let run = self.longest_run(begin + done, self.len() - done);
            done += run.count;
            runs.push(run);
        }
        // The last and the first may be one.
        if let [first, .., last] = runs.as_slice() {
            let (from, count) = (last.first, last.count + first.count);
            if let Some(element) = self.element_like(&last.element, from, count) {
                runs.pop();
                runs[0] = PointRun { first: from % self.len(), count, element };
            }
        }
        Ok(runs)
    }

    /// The longest run from a point on, of at most so many, that has a line or, where that is clearly longer, a circle.
    fn longest_run(&self, first: usize, most: usize) -> PointRun {
        let has_all = |element: &OutlineElement, count: usize| self.has_all(element, first, count);
        let line_of = |count: usize| self.line(first, count).filter(|line| has_all(line, count));
        // A few points on a line may have no circle, and more of them have one again.
        let arc_of = |count: usize| self.arc(first, count).filter(|arc| has_all(arc, count)).or_else(|| line_of(count));
        let (line, arc) = (self.longest(first, most, line_of), self.longest(first, most, arc_of));
        match (line, arc) {
            (Some(line), Some(arc)) if 2 * arc.count > 3 * line.count && arc.count >= line.count + 2 => arc,
            (Some(line), _) => line,
            (None, Some(arc)) => arc,
            // A single point at the end.
            (None, None) => {
                let point = self.points[first % self.len()];
                let element = OutlineElement::Line { normal_rad: azimuth(point), distance_mm: point.norm() };
                PointRun { first: first % self.len(), count: 1, element }
            }
        }
    }

    /// The longest run whose element has all its points: doubled until it has not, then halved between.
    fn longest(&self, first: usize, most: usize, fits: impl Fn(usize) -> Option<OutlineElement>) -> Option<PointRun> {
        let mut known = None;
        let (mut good, mut bad) = (0, most + 1);
        for start in [2, 3] {
            if let Some(found) = (start <= most).then(|| fits(start)).flatten() {
                (known, good) = (Some(found), start);
            }
        }
        known?;
        while good + 1 < bad {
            let next = if bad > most { (2 * good).min(most) } else { usize::midpoint(good, bad) };
            match fits(next) {
                Some(found) => (known, good) = (Some(found), next),
                None => bad = next,
            }
            if good == most {
                break;
            }
        }
        known.map(|element| PointRun { first: first % self.len(), count: good, element })
    }

    fn has_all(&self, element: &OutlineElement, first: usize, count: usize) -> bool {
        self.run(first, count).all(|point| element.outside_mm(point).abs() <= self.tolerance_mm)
    }

    /// An element of the same kind through a run, if it has all of its points.
    fn element_like(&self, kind: &OutlineElement, first: usize, count: usize) -> Option<OutlineElement> {
        let element = match kind {
            OutlineElement::Line { .. } => self.line(first, count),
            OutlineElement::Arc { .. } => self.arc(first, count),
        };
        element.filter(|element| self.has_all(element, first, count))
    }

    /// The line with the smallest squares of distances.
    fn line(&self, first: usize, count: usize) -> Option<OutlineElement> {
        if count < 2 {
            return None;
        }
        let middle = self.run(first, count).sum::<Vector2<f64>>() / count as f64;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for point in self.run(first, count).map(|point| point - middle) {
            (xx, xy, yy) = (xx + point.x * point.x, xy + point.x * point.y, yy + point.y * point.y);
        }
        let along_rad = 0.5 * libm::atan2(2.0 * xy, xx - yy);
        let normal_rad = along_rad + 0.5 * PI;
        let distance_mm = unit(normal_rad).dot(&middle);
        let inwards = distance_mm < 0.0;
        let normal_rad = if inwards { normal_rad + PI } else { normal_rad };
        Some(OutlineElement::Line { normal_rad, distance_mm: distance_mm.abs() })
    }

    /// The circle with the smallest squares of the differences of squared radii (I. Kåsa, 1976).
    fn arc(&self, first: usize, count: usize) -> Option<OutlineElement> {
        if count < 3 {
            return None;
        }
        let middle = self.run(first, count).sum::<Vector2<f64>>() / count as f64;
        let (mut xx, mut xy, mut yy, mut right) = (0.0, 0.0, 0.0, Vector2::zeros());
        for point in self.run(first, count).map(|point| point - middle) {
            (xx, xy, yy) = (xx + point.x * point.x, xy + point.x * point.y, yy + point.y * point.y);
            right += 0.5 * point.norm_squared() * point;
        }
        let determinant = xx * yy - xy * xy;
        let centre = Vector2::new(yy * right.x - xy * right.y, xx * right.y - xy * right.x) / determinant;
        let radius_mm = libm::sqrt(centre.norm_squared() + (xx + yy) / count as f64);
        if radius_mm.is_nan() || radius_mm > LARGEST_RADIUS_MM {
            return None;
        }
        // Convex where the contour turns to the left.
        let at = |index: usize| self.points[(first + index) % self.len()];
        let (from, half, to) = (at(0), at(count / 2), at(count - 1));
        let left = (half - from).perp(&(to - half)) > 0.0;
        // Of a whole turn the chords say nothing, and it is convex.
        let convex = left || count == self.len();
        Some(OutlineElement::Arc { centre: centre + middle, radius_mm: if convex { radius_mm } else { -radius_mm } })
    }

    /// Divides the points of a run between its neighbours, or makes one element of all three if only the run is beside it.
    fn without(&self, runs: &mut Vec<PointRun>, index: usize) {
        let run = runs.remove(index);
        let count = runs.len();
        let (before, after) = ((index + count - 1) % count, index % count);
        let together = PointRun { count: runs[before].count + run.count + runs[after].count, ..runs[before] };
        if let Some(element) = self.without_outliers(&together, &runs[after].element) {
            runs[before] = PointRun { element, ..together };
            runs.remove(after);
            return;
        }
        let half = run.count / 2;
        runs[before].count += half;
        runs[after].first = (runs[after].first + self.len() - (run.count - half)) % self.len();
        runs[after].count += run.count - half;
    }

    /// The element of two runs of a kind and what lies between, if a few points at the most are beside it.
    fn without_outliers(&self, together: &PointRun, other: &OutlineElement) -> Option<OutlineElement> {
        let PointRun { first, count, element } = *together;
        let element = match (element, other) {
            (OutlineElement::Line { .. }, OutlineElement::Line { .. }) => self.line(first, count),
            (OutlineElement::Arc { .. }, OutlineElement::Arc { .. }) => self.arc(first, count),
            _ => None,
        }?;
        // The outliers have moved it a little.
        let beside = |point: &Vector2<f64>| element.outside_mm(*point).abs() > 3.0 * self.tolerance_mm;
        (self.run(first, count).filter(beside).count() <= TRANSITION).then_some(element)
    }

    /// Makes the elements of runs tangent, and their tangent points the segments of an outline.
    fn fitted(&self, runs: &[PointRun]) -> Result<FittedOutline, OutlineFitError> {
        let mut runs = runs.to_vec();
        if let [run] = runs.as_slice() {
            return self.circle(&run.element);
        }
        for (index, run) in runs.iter().enumerate() {
            if run.element.tangency(&runs[(index + 1) % runs.len()].element).is_none() {
                return Err(OutlineFitError::Corner { line: self.line_of(run.first + run.count) });
            }
        }
        let mut touches = Vec::new();
        for _ in 0..MAX_ROUNDS {
            self.make_tangent(&mut runs)?;
            touches = (0..runs.len()).map(|i| runs[i].element.touch(&runs[(i + 1) % runs.len()].element)).collect();
            if !self.assign(&mut runs, &touches)? {
                break;
            }
        }
        let mut max_deviation_mm: f64 = 0.0;
        for run in &runs {
            for index in run.first..run.first + run.count {
                let deviation_mm = run.element.outside_mm(self.points[index % self.len()]).abs();
                if deviation_mm.is_nan() || deviation_mm > self.tolerance_mm {
                    let (deviation_um, tolerance_um) = (deviation_mm * UM_PER_MM, self.tolerance_mm * UM_PER_MM);
                    return Err(OutlineFitError::TooFar { line: self.line_of(index), deviation_um, tolerance_um });
                }
                max_deviation_mm = max_deviation_mm.max(deviation_mm);
            }
        }
        let last = touches[touches.len() - 1];
        let mut from = last;
        let mut segments = Vec::with_capacity(runs.len());
        for (run, to) in runs.iter().zip(&touches) {
            push_segments(&run.element, from, *to, &mut segments);
            from = *to;
        }
        Ok(FittedOutline { start_mm: [last.x, last.y], segments, max_deviation_mm, points: self.len() })
    }

    fn line_of(&self, index: usize) -> usize {
        self.lines[index % self.len()]
    }

    /// A contour that is one circle.
    fn circle(&self, element: &OutlineElement) -> Result<FittedOutline, OutlineFitError> {
        let OutlineElement::Arc { centre, radius_mm } = *element else {
            return Err(OutlineFitError::Corner { line: self.lines[0] });
        };
        let [right, left] = [1.0, -1.0].map(|side| [centre.x + side * radius_mm, centre.y]);
        let segments = [left, right].map(|to_mm| OutlineSegment { to_mm, radius_mm: Some(radius_mm) });
        let deviations = self.points.iter().map(|point| element.outside_mm(*point).abs());
        let max_deviation_mm = deviations.fold(0.0, f64::max);
        Ok(FittedOutline { start_mm: right, segments: segments.into(), max_deviation_mm, points: self.len() })
    }

    /// Moves all elements so that neighbours are tangent, and the squares of the distances of their points are smallest.
    fn make_tangent(&self, runs: &mut [PointRun]) -> Result<(), OutlineFitError> {
        let failed = OutlineFitError::NotTangent { line: self.line_of(runs[0].first) };
        let starts: Vec<usize> = runs
            .iter()
            .scan(0, |next, run| {
                let start = *next;
                *next += run.element.unknowns();
                Some(start)
            })
            .collect();
        let unknowns: usize = runs.iter().map(|run| run.element.unknowns()).sum();
        let size = unknowns + runs.len();
        for _ in 0..MAX_STEPS {
            let (mut matrix, mut right) = (DMatrix::zeros(size, size), DVector::zeros(size));
            for (run, start) in runs.iter().zip(&starts) {
                let width = run.element.unknowns();
                for point in self.run(run.first, run.count) {
                    let (outside_mm, slopes) = run.element.outside_and_slopes(point);
                    for i in 0..width {
                        right[start + i] -= slopes[i] * outside_mm;
                        for j in 0..width {
                            matrix[(start + i, start + j)] += slopes[i] * slopes[j];
                        }
                    }
                }
                // An element of few points has its place by its neighbours.
                for i in 0..width {
                    matrix[(start + i, start + i)] += 1e-9;
                }
            }
            let mut error_mm: f64 = 0.0;
            for (index, run) in runs.iter().enumerate() {
                let next = (index + 1) % runs.len();
                let tangency = run.element.tangency(&runs[next].element);
                let (error, of_this, of_next) = tangency.ok_or_else(|| failed.clone())?;
                let row = unknowns + index;
                right[row] = -error;
                error_mm = error_mm.max(error.abs());
                let both = [(starts[index], of_this, &runs[index]), (starts[next], of_next, &runs[next])];
                for (start, slopes, run) in both {
                    for (i, slope) in slopes.iter().enumerate().take(run.element.unknowns()) {
                        matrix[(row, start + i)] += slope;
                        matrix[(start + i, row)] += slope;
                    }
                }
            }
            let step = matrix.lu().solve(&right).ok_or_else(|| failed.clone())?;
            if step.iter().any(|value| !value.is_finite()) {
                return Err(failed);
            }
            for (run, start) in runs.iter_mut().zip(&starts) {
                let width = run.element.unknowns();
                run.element = run.element.moved(&step.as_slice()[*start..start + width]);
                if let OutlineElement::Arc { radius_mm, .. } = run.element
                    && (radius_mm.is_nan() || radius_mm.abs() > LARGEST_RADIUS_MM)
                {
                    return Err(failed);
                }
            }
            let moved = step.rows(0, unknowns).amax();
            if error_mm <= TANGENT_MM && moved <= AT_REST * LARGEST_RADIUS_MM {
                return Ok(());
            }
        }
        Err(failed)
    }

    /// Gives each point to the element between whose tangent points it lies; true if one changed.
    fn assign(&self, runs: &mut [PointRun], touches: &[Vector2<f64>]) -> Result<bool, OutlineFitError> {
        let from_rad = azimuth(touches[touches.len() - 1]);
        let round = |point: Vector2<f64>| wrap_turn(azimuth(point) - from_rad);
        let first = (0..self.len()).min_by(|a, b| round(self.points[*a]).total_cmp(&round(self.points[*b])));
        let Some(first) = first else { return Ok(false) };
        let (mut done, mut changed, mut begin_rad) = (0, false, 0.0);
        let count = runs.len();
        for (index, (run, touch)) in runs.iter_mut().zip(touches).enumerate() {
            let end_rad = if index + 1 == count { TURN_RAD } else { round(*touch) };
            if end_rad <= begin_rad {
                return Err(OutlineFitError::NotTangent { line: self.line_of(run.first) });
            }
            let begin = done;
            while done < self.len() && round(self.points[(first + done) % self.len()]) < end_rad {
                done += 1;
            }
            let now = ((first + begin) % self.len(), done - begin);
            changed |= now != (run.first, run.count);
            (run.first, run.count) = now;
            begin_rad = end_rad;
        }
        Ok(changed)
    }
}

/// A line, or an arc in pieces of at most half a circle.
fn push_segments(element: &OutlineElement, from: Vector2<f64>, to: Vector2<f64>, segments: &mut Vec<OutlineSegment>) {
    let to_mm = [to.x, to.y];
    let OutlineElement::Arc { centre, radius_mm } = *element else {
        segments.push(OutlineSegment { to_mm, radius_mm: None });
        return;
    };
    let sense = 1.0_f64.copysign(radius_mm);
    let begin_rad = azimuth(from - centre);
    let turned_rad = wrap_turn(sense * (azimuth(to - centre) - begin_rad));
    let radius_mm = Some(radius_mm);
    if turned_rad > 0.99 * PI {
        let middle = centre + (from - centre).norm() * unit(begin_rad + sense * 0.5 * turned_rad);
        segments.push(OutlineSegment { to_mm: [middle.x, middle.y], radius_mm });
    }
    segments.push(OutlineSegment { to_mm, radius_mm });
}

#[cfg(test)]
mod tests;
