// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Closed outlines of lines and arcs, with a curvature that is continuous.
//!
//! The curvature jumps between a line and an arc, and with it the acceleration of X: the jerk would be unbounded at any speed. Each element
//! therefore moves outwards, and more curved elements move less:
//!
//! ```text
//! o = t (κmax − κ)/(κmax − κmin)        t: tolerance, κ: curvature of the element
//! ```
//! A clothoid, whose curvature changes linearly with its length, bridges the gap between two elements. With length l it bridges Δκ l²/24, as
//! between a straight and a curve of a road. Lines stay straight, arcs stay arcs about their
//! centres, the curvature is nowhere outside the range of the drawing, and the curve lies 0 to t outside the drawing.

pub mod fit;

use crate::math::extremum::smallest_over_turn;
use crate::math::hermite::Sample;
use crate::math::root::growing_root;
use crate::math::units::{TURN_RAD, deg_from_rad, wrap_turn};
use alloc::vec::Vec;
use core::f64::consts::PI;
use nalgebra::{Matrix3, Vector2, Vector3};
use thiserror::Error;

/// A line or an arc of the drawing, from the end of the one before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutlineSegment {
    /// End (mm); the cam's axis is at 0, 0 and cam angle 0 on the x axis.
    pub to_mm: [f64; 2],
    /// Radius of an arc (mm): positive where the outline is convex, negative where it is hollow. `None`: a line. Arcs are at most half a
    /// circle.
    pub radius_mm: Option<f64>,
}

/// Why segments are no outline.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum OutlineError {
    /// Too few segments, or too many.
    #[error("an outline has {count} segments; 2 to {max} are allowed")]
    SegmentCount { count: usize, max: usize },
    /// A number of the whole outline that is not in its range.
    #[error("{what} is {value}; it must be {bound}")]
    BadNumber {
        what: &'static str,
        value: f64,
        /// Condition that it violates.
        bound: &'static str,
    },
    /// A number of a segment that is not finite, or not in its range.
    #[error("segment {segment}: {what} is {value}; it must be {bound}")]
    BadSegment {
        /// Number of the segment, from 1.
        segment: usize,
        what: &'static str,
        value: f64,
        /// Condition that it violates.
        bound: &'static str,
    },
    /// A segment without length.
    #[error("segment {segment} ends where it begins")]
    NoLength {
        /// Number of the segment, from 1.
        segment: usize,
    },
    /// An arc that does not reach its end.
    #[error(
        "segment {segment}: its ends are {chord_mm:.6} mm apart, which an arc of radius {radius_mm} mm does not reach"
    )]
    ArcTooSmall {
        /// Number of the segment, from 1.
        segment: usize,
        /// Distance of its ends (mm).
        chord_mm: f64,
        /// Its radius (mm).
        radius_mm: f64,
    },
    /// A corner.
    #[error(
        "segments {before} and {segment} meet at an angle of {angle_deg:.4} deg; it must be below {bound_deg} deg: put an arc between \
         them"
    )]
    Corner {
        /// Number of the segment before, from 1.
        before: usize,
        /// Number of the segment, from 1.
        segment: usize,
        /// Angle of the corner (deg), positive to the left.
        angle_deg: f64,
        /// Largest angle (deg).
        bound_deg: f64,
    },
    /// The outline does not go once round the axis, counterclockwise.
    #[error("the outline turns by {turned_deg:.3} deg; it must turn once, counterclockwise: 360 deg")]
    Turn {
        /// Turn of its direction (deg).
        turned_deg: f64,
    },
    /// The blends do not fit on a segment.
    #[error(
        "segment {segment} is {length_mm:.4} mm long, and the blends at its ends need {blends_mm:.4} mm of it; a smaller tolerance makes \
         them shorter"
    )]
    BlendsOverlap {
        /// Number of the segment, from 1.
        segment: usize,
        /// Its length (mm).
        length_mm: f64,
        /// Length that the blends need (mm).
        blends_mm: f64,
    },
    /// A blend was not found.
    #[error("no blend joins segments {before} and {segment}: their curvatures are {from_1_mm} and {to_1_mm} 1/mm")]
    NoBlend {
        /// Number of the segment before, from 1.
        before: usize,
        /// Number of the segment, from 1.
        segment: usize,
        /// Curvature of the segment before (1/mm).
        from_1_mm: f64,
        /// Curvature of the segment (1/mm).
        to_1_mm: f64,
    },
    /// The axis is not inside, or does not see the whole outline.
    #[error(
        "the line along the outline at azimuth {azimuth_deg:.3} deg passes the axis at {distance_mm:.4} mm; it must be above 0"
    )]
    PassesAxis {
        /// Azimuth (deg).
        azimuth_deg: f64,
        /// Distance of the tangent from the axis (mm), negative on the wrong side.
        distance_mm: f64,
    },
}

/// Most segments of an outline.
const MAX_SEGMENTS: usize = 1000;

/// Angle up to which two segments meet without a corner (deg): what rounded figures of a drawing leave.
const MAX_CORNER_DEG: f64 = 0.05;

/// The same of two segments of one curvature (deg), between which no blend takes it up.
const SAME_DEG: f64 = 1e-7;

/// Largest gap at the end of a blend, by rounding (mm).
const FOUND_MM: f64 = 1e-9;

/// Largest turn of a piece (rad), so that the axis sees it under less than half a turn.
const PIECE_RAD: f64 = 1.0;

/// Curvatures that differ by less than this share of the largest are the same.
const SAME: f64 = 1e-9;

/// Coordinates of decimal figures are the same up to this distance (mm).
const SAME_MM: f64 = 1e-9;

/// A piece of constant or linear curvature.
#[derive(Debug, Clone, Copy, PartialEq)]
struct OutlinePiece {
    from: Vector2<f64>,
    heading_rad: f64,
    /// Curvature at its start (1/mm), positive to the left, and its change along the way (1/mm²).
    curvature: f64,
    rate: f64,
    length_mm: f64,
}

/// Nodes and weights of Gauss and Legendre's rule of eight points between −1 and 1, the positive half.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_27),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// Largest change of direction for one application of the rule (rad): its error is then below rounding.
const GAUSS_RAD: f64 = 0.5;

impl OutlinePiece {
    fn heading(&self, s: f64) -> f64 {
        self.heading_rad + s * (self.curvature + 0.5 * s * self.rate)
    }

    /// Point after a length.
    fn at(&self, s: f64) -> Vector2<f64> {
        if self.rate == 0.0 {
            // Chord and middle direction, exact for lines too.
            let half = 0.5 * self.curvature * s;
            let chord = s * sin_over(half);
            let (sin, cos) = libm::sincos(self.heading_rad + half);
            return self.from + Vector2::new(chord * cos, chord * sin);
        }
        let turned = s.abs() * (self.curvature.abs() + s.abs() * self.rate.abs());
        let count = libm::ceil(turned / GAUSS_RAD).clamp(1.0, 64.0);
        let half = 0.5 * s / count;
        let (mut sum, mut middle) = (Vector2::zeros(), half);
        while middle.abs() < s.abs() {
            for (node, weight) in GAUSS {
                for at in [middle - node * half, middle + node * half] {
                    let (sin, cos) = libm::sincos(self.heading(at));
                    sum += Vector2::new(weight * cos, weight * sin);
                }
            }
            middle += 2.0 * half;
        }
        self.from + sum * half
    }

    fn end(&self) -> Vector2<f64> {
        self.at(self.length_mm)
    }

    fn end_heading(&self) -> f64 {
        self.heading(self.length_mm)
    }

    /// The same piece outside by a distance; of constant curvature.
    fn outside(&self, distance_mm: f64) -> Self {
        let stretch = 1.0 + self.curvature * distance_mm;
        let (sin, cos) = libm::sincos(self.heading_rad);
        Self {
            from: self.from + distance_mm * Vector2::new(sin, -cos),
            curvature: self.curvature / stretch,
            length_mm: self.length_mm * stretch,
            ..*self
        }
    }

    /// Equal parts that turn by [`PIECE_RAD`] at most; none of a piece without length.
    fn divided(self) -> impl Iterator<Item = Self> {
        let turned = self.length_mm * self.curvature.abs().max((self.curvature + self.length_mm * self.rate).abs());
        let count = if self.length_mm > 0.0 { libm::ceil(turned / PIECE_RAD).clamp(1.0, 100.0) } else { 0.0 };
        let step = self.length_mm / count;
        (0..100_u32)
            .map(f64::from)
            .take_while(move |i| *i < count)
            .map(move |i| self.between(i * step, (i + 1.0) * step))
    }

    /// The piece between two lengths.
    fn between(&self, from_mm: f64, to_mm: f64) -> Self {
        Self {
            from: self.at(from_mm),
            heading_rad: self.heading(from_mm),
            curvature: self.curvature + from_mm * self.rate,
            length_mm: to_mm - from_mm,
            ..*self
        }
    }
}

/// sin x / x.
fn sin_over(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { libm::sin(x) / x }
}

/// Angle between −π and π.
fn around_zero(angle_rad: f64) -> f64 {
    angle_rad - TURN_RAD * libm::floor(angle_rad / TURN_RAD + 0.5)
}

/// A closed curve of lines, arcs and clothoids about the axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// Pieces in the order of their azimuths, which begin at these (rad), growing from that of the first by less than a turn.
    pieces: Vec<OutlinePiece>,
    begins_rad: Vec<f64>,
    /// Smallest distance from the axis (mm).
    smallest_mm: f64,
}

impl Outline {
    /// Outline of segments that begin at `start_mm` and end there, 0 to `tolerance_mm` outside of them.
    ///
    /// # Errors
    /// Segments that are no closed, smooth curve counterclockwise round the axis; blends that find no place.
    pub fn new(start_mm: [f64; 2], segments: &[OutlineSegment], tolerance_mm: f64) -> Result<Self, OutlineError> {
        if segments.len() < 2 || segments.len() > MAX_SEGMENTS {
            return Err(OutlineError::SegmentCount { count: segments.len(), max: MAX_SEGMENTS });
        }
        if !(tolerance_mm > 0.0 && tolerance_mm.is_finite()) {
            let (what, bound) = ("the tolerance (mm)", "above 0");
            return Err(OutlineError::BadNumber { what, value: tolerance_mm, bound });
        }
        let elements = joined(&elements(start_mm, segments)?)?;
        let curvatures = elements.iter().map(|(_, element)| element.curvature);
        let (low, high) = curvatures.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), k| (a.min(k), b.max(k)));
        let per_curvature = if high > low { tolerance_mm / (high - low) } else { 0.0 };
        let outside: Vec<(usize, OutlinePiece)> = (elements.iter())
            .map(|(segment, element)| (*segment, element.outside(per_curvature * (high - element.curvature))))
            .collect();
        let count = outside.len();
        let blends: Vec<Blend> = (0..count)
            .filter(|_| count > 1)
            .map(|i| Blend::new(outside[i], outside[(i + 1) % count]))
            .collect::<Result<_, _>>()?;
        let mut pieces = Vec::with_capacity(2 * count);
        for (i, (segment, element)) in outside.iter().enumerate() {
            let Some((before, after)) = blends.get((i + count - 1) % count).zip(blends.get(i)) else {
                pieces.push(*element);
                continue;
            };
            let (from_mm, to_mm) = (before.after_mm, element.length_mm - after.before_mm);
            if from_mm > to_mm {
                let (length_mm, blends_mm) = (element.length_mm, before.after_mm + after.before_mm);
                return Err(OutlineError::BlendsOverlap { segment: *segment, length_mm, blends_mm });
            }
            pieces.push(element.between(from_mm, to_mm));
            pieces.push(after.piece);
        }
        Self::about_axis(pieces)
    }

    /// A regular polygon with rounded corners, the middle of its first side at cam angle 0.
    ///
    /// # Errors
    /// See [`Outline::new`]; fewer than three sides, corners that leave no flats.
    pub fn polygon(
        sides: usize,
        across_flats_mm: f64,
        corner_radius_mm: f64,
        tolerance_mm: f64,
    ) -> Result<Self, OutlineError> {
        let bad = |what, value, bound| Err(OutlineError::BadNumber { what, value, bound });
        if sides < 3 || 2 * sides > MAX_SEGMENTS {
            return bad("the number of sides", sides as f64, "3 to 500");
        }
        let inner_mm = 0.5 * across_flats_mm;
        if !(inner_mm > 0.0 && inner_mm.is_finite()) {
            return bad("the distance across the flats (mm)", across_flats_mm, "above 0");
        }
        if !(corner_radius_mm > 0.0 && corner_radius_mm < inner_mm) {
            return bad(
                "the corner radius (mm)",
                corner_radius_mm,
                "above 0 and below half the distance across the flats",
            );
        }
        let half_rad = PI / sides as f64;
        let half_mm = (inner_mm - corner_radius_mm) * libm::tan(half_rad);
        let on_side = |side: usize, along: f64| {
            let (sin, cos) = libm::sincos(2.0 * half_rad * side as f64);
            [inner_mm * cos - along * sin, inner_mm * sin + along * cos]
        };
        let segments: Vec<OutlineSegment> = (0..sides)
            .flat_map(|side| {
                let flat = OutlineSegment { to_mm: on_side(side, half_mm), radius_mm: None };
                let corner = on_side((side + 1) % sides, -half_mm);
                [flat, OutlineSegment { to_mm: corner, radius_mm: Some(corner_radius_mm) }]
            })
            .collect();
        Self::new(on_side(0, -half_mm), &segments, tolerance_mm)
    }

    /// Orders pieces by their azimuth, and checks that the axis sees all of them.
    fn about_axis(pieces: Vec<OutlinePiece>) -> Result<Self, OutlineError> {
        let pieces: Vec<OutlinePiece> = pieces.into_iter().flat_map(OutlinePiece::divided).collect();
        let azimuth = |point: Vector2<f64>| libm::atan2(point.y, point.x);
        let mut begins_rad = Vec::with_capacity(pieces.len());
        let mut at_rad = azimuth(pieces[0].from);
        for (i, piece) in pieces.iter().enumerate() {
            begins_rad.push(at_rad);
            if let Some((azimuth_rad, distance_mm)) = passes_axis(piece) {
                let azimuth_deg = deg_from_rad(wrap_turn(azimuth_rad));
                return Err(OutlineError::PassesAxis { azimuth_deg, distance_mm });
            }
            let next = pieces[(i + 1) % pieces.len()].from;
            at_rad += wrap_turn(azimuth(next) - at_rad);
        }
        let turned_rad = at_rad - begins_rad[0];
        if (turned_rad - TURN_RAD).abs() > 1e-6 {
            return Err(OutlineError::Turn { turned_deg: deg_from_rad(turned_rad) });
        }
        let mut outline = Self { pieces, begins_rad, smallest_mm: 0.0 };
        outline.smallest_mm =
            smallest_over_turn(outline.grid(), &outline.breaks(), |angle| outline.sample(angle).value).value;
        Ok(outline)
    }

    /// Smallest distance from the axis (mm).
    #[must_use]
    pub fn smallest_mm(&self) -> f64 {
        self.smallest_mm
    }

    /// Azimuths at which the jerk jumps (rad).
    #[must_use]
    pub fn breaks(&self) -> Vec<f64> {
        self.begins_rad.iter().map(|begin| wrap_turn(*begin)).collect()
    }

    /// Steps of a grid over one turn with at least four in every piece.
    pub(crate) fn grid(&self) -> usize {
        let ends = self.begins_rad.iter().skip(1).copied().chain([self.begins_rad[0] + TURN_RAD]);
        let narrowest = self.begins_rad.iter().zip(ends).map(|(begin, end)| end - begin).fold(TURN_RAD, f64::min);
        let steps = (4.0 * TURN_RAD / narrowest).clamp(7200.0, 200_000.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped above")]
        let steps = libm::ceil(steps) as usize;
        steps
    }

    /// Height above the smallest distance from the axis (mm) over the azimuth (rad), with its derivatives.
    ///
    /// With h the distance of the tangent from the axis, κ the curvature and u = dρ/(ρ dφ): du/dφ = (1 + u²) − κ h (1 + u²)²,
    /// dh/dφ = κ u h² (1 + u²), and a way of h (1 + u²) per dφ.
    #[must_use]
    pub fn sample(&self, azimuth_rad: f64) -> Sample {
        let first_rad = self.begins_rad[0];
        let azimuth_rad = first_rad + wrap_turn(azimuth_rad - first_rad);
        let index = self.begins_rad.partition_point(|begin| *begin <= azimuth_rad).max(1) - 1;
        let piece = &self.pieces[index];
        let (sin, cos) = libm::sincos(azimuth_rad);
        let seen = |s: f64| {
            let (point, heading) = (piece.at(s), piece.heading(s));
            let (sin_heading, cos_heading) = libm::sincos(heading);
            let distance = point.x * sin_heading - point.y * cos_heading;
            (point, distance, point.x * cos_heading + point.y * sin_heading)
        };
        let ahead = |s: f64| {
            let (point, distance, _) = seen(s);
            (libm::atan2(point.y * cos - point.x * sin, point.x * cos + point.y * sin), distance / point.norm_squared())
        };
        let s = growing_root(0.0, piece.length_mm, 0.5 * piece.length_mm, ahead);
        let (point, h, along) = seen(s);
        let (radius, u) = (point.norm(), along / h);
        let curvature = piece.curvature + s * piece.rate;
        let spread = 1.0 + u * u;
        let u1 = spread - curvature * h * spread * spread;
        let (h1, curvature1) = (curvature * u * h * h * spread, piece.rate * h * spread);
        let u2 =
            2.0 * u * u1 - (curvature1 * h + curvature * h1) * spread * spread - 4.0 * curvature * h * spread * u * u1;
        let second = u * u + u1;
        Sample {
            value: radius - self.smallest_mm,
            first: radius * u,
            second: radius * second,
            third: radius * (u * second + 2.0 * u * u1 + u2),
        }
    }
}

/// Place of a piece whose tangent passes the axis, or does so on the wrong side: azimuth (rad) and distance (mm).
fn passes_axis(piece: &OutlinePiece) -> Option<(f64, f64)> {
    const STEPS: u32 = 64;
    let at = (0..=STEPS).map(|i| f64::from(i) / f64::from(STEPS) * piece.length_mm).map(|s| {
        let (point, (sin, cos)) = (piece.at(s), libm::sincos(piece.heading(s)));
        (libm::atan2(point.y, point.x), point.x * sin - point.y * cos)
    });
    let nearest = at.fold((0.0, f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a });
    (nearest.1 <= SAME_MM).then_some(nearest)
}

fn finite(segment: usize, what: &'static str, value: f64) -> Result<(), OutlineError> {
    if value.is_finite() { Ok(()) } else { Err(OutlineError::BadSegment { segment, what, value, bound: "finite" }) }
}

/// Segments as pieces of constant curvature.
fn elements(start_mm: [f64; 2], segments: &[OutlineSegment]) -> Result<Vec<OutlinePiece>, OutlineError> {
    let mut from = Vector2::from(start_mm);
    finite(1, "x of the start (mm)", from.x)?;
    finite(1, "y of the start (mm)", from.y)?;
    let mut elements = Vec::with_capacity(segments.len());
    for (i, OutlineSegment { to_mm, radius_mm }) in segments.iter().enumerate() {
        let (segment, to) = (i + 1, Vector2::from(*to_mm));
        finite(segment, "x (mm)", to.x)?;
        finite(segment, "y (mm)", to.y)?;
        let chord = to - from;
        let chord_mm = chord.norm();
        if chord_mm <= SAME_MM {
            return Err(OutlineError::NoLength { segment });
        }
        let towards = libm::atan2(chord.y, chord.x);
        let radius_mm = radius_mm.unwrap_or(f64::INFINITY);
        if radius_mm == 0.0 || radius_mm.is_nan() {
            let (what, bound) = ("its radius (mm)", "positive, or negative where the outline is hollow");
            return Err(OutlineError::BadSegment { segment, what, value: radius_mm, bound });
        }
        let sine = 0.5 * chord_mm / radius_mm;
        if sine.abs() > 1.0 + SAME {
            return Err(OutlineError::ArcTooSmall { segment, chord_mm, radius_mm });
        }
        let half_rad = libm::asin(sine.clamp(-1.0, 1.0));
        elements.push(OutlinePiece {
            from,
            heading_rad: towards - half_rad,
            curvature: 1.0 / radius_mm,
            rate: 0.0,
            length_mm: chord_mm / sin_over(half_rad),
        });
        from = to;
    }
    let gap = from - Vector2::from(start_mm);
    if gap.norm() > 1e-6 {
        let (what, bound) = ("the distance of its end from the start (mm)", "0: the outline is closed");
        return Err(OutlineError::BadSegment { segment: segments.len(), what, value: gap.norm(), bound });
    }
    Ok(elements)
}

/// Elements with the numbers of their segments: neighbours of one curvature are one element, and none of the others has a corner.
fn joined(elements: &[OutlinePiece]) -> Result<Vec<(usize, OutlinePiece)>, OutlineError> {
    let largest = elements.iter().map(|element| element.curvature.abs()).fold(0.0, f64::max);
    let count = elements.len();
    let mut turned_rad = 0.0;
    let mut joins = Vec::with_capacity(count);
    for (i, element) in elements.iter().enumerate() {
        let (before, own) = ((i + count - 1) % count, i);
        let angle_rad = around_zero(element.heading_rad - elements[before].end_heading());
        turned_rad += angle_rad + element.curvature * element.length_mm;
        let is_same = (element.curvature - elements[before].curvature).abs() <= SAME * largest;
        let (angle_deg, bound_deg) = (deg_from_rad(angle_rad), if is_same { SAME_DEG } else { MAX_CORNER_DEG });
        if angle_deg.abs() > bound_deg {
            return Err(OutlineError::Corner { before: before + 1, segment: own + 1, angle_deg, bound_deg });
        }
        joins.push(is_same);
    }
    if (turned_rad - TURN_RAD).abs() > 1e-3 {
        return Err(OutlineError::Turn { turned_deg: deg_from_rad(turned_rad) });
    }
    // From an element that begins at a jump of the curvature on, so that none is cut by the start of the list.
    let first = joins.iter().position(|is_same| !is_same).unwrap_or(0);
    let mut joined: Vec<(usize, OutlinePiece)> = Vec::with_capacity(count);
    for i in (first..count).chain(0..first) {
        match joined.last_mut() {
            Some((_, last)) if joins[i] => last.length_mm += elements[i].length_mm,
            _ => joined.push((i + 1, elements[i])),
        }
    }
    Ok(joined)
}

/// A clothoid between two elements, and the lengths that it takes of them.
struct Blend {
    piece: OutlinePiece,
    before_mm: f64,
    after_mm: f64,
}

impl Blend {
    /// Clothoid from the end of one element into the start of the next.
    fn new(
        (before, one): (usize, OutlinePiece),
        (segment, other): (usize, OutlinePiece),
    ) -> Result<Self, OutlineError> {
        let jump = other.curvature - one.curvature;
        let none = OutlineError::NoBlend { before, segment, from_1_mm: one.curvature, to_1_mm: other.curvature };
        // Gap between the elements, along the normal.
        let (sin, cos) = libm::sincos(one.end_heading());
        let gap = (other.from - one.end()).dot(&Vector2::new(-sin, cos));
        let square = 24.0 * gap / jump;
        if !(square > 0.0 && square.is_finite()) {
            return Err(none);
        }
        let begin_mm = libm::sqrt(square);
        let turn_rad = around_zero(other.heading_rad - one.end_heading());
        let blend = |unknown: &Vector3<f64>| {
            let (before_mm, after_mm, length_mm) = (unknown[0], unknown[1], unknown[2]);
            let start = one.length_mm - before_mm;
            let piece = OutlinePiece {
                from: one.at(start),
                heading_rad: one.heading(start),
                curvature: one.curvature,
                rate: jump / length_mm,
                length_mm,
            };
            Blend { piece, before_mm, after_mm }
        };
        let miss = |unknown: &Vector3<f64>| {
            let (before_mm, after_mm, length_mm) = (unknown[0], unknown[1], unknown[2]);
            let turned = 0.5 * length_mm * (one.curvature + other.curvature);
            let heading = turned - one.curvature * before_mm - other.curvature * after_mm - turn_rad;
            let gap = blend(unknown).piece.end() - other.at(after_mm);
            Vector3::new(gap.x, gap.y, heading * begin_mm)
        };
        let mut unknown = Vector3::new(0.5 * begin_mm, 0.5 * begin_mm, begin_mm);
        for _ in 0..50 {
            let here = miss(&unknown);
            if here.norm() <= 1e-13 * (1.0 + one.from.norm()) {
                break;
            }
            let step = 1e-5 * begin_mm;
            let columns = [0, 1, 2].map(|i| {
                let mut beside = [unknown, unknown];
                beside[0][i] -= step;
                beside[1][i] += step;
                (miss(&beside[1]) - miss(&beside[0])) / (2.0 * step)
            });
            let change = Matrix3::from_columns(&columns).lu().solve(&here).ok_or_else(|| none.clone())?;
            // Lengths stay positive.
            let limit = (0..3).map(|i| change[i] / (0.5 * unknown[i])).fold(1.0, f64::max);
            unknown -= change / limit;
        }
        let far = miss(&unknown).norm();
        if far.is_nan() || far > FOUND_MM || unknown.iter().any(|length| *length <= 0.0) {
            return Err(none);
        }
        Ok(blend(&unknown))
    }
}

#[cfg(test)]
mod tests;
