// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The bound of a turn, looked at once: at equal angles, fine enough for all that has to be known of it.

use super::square_speed::to_f64;
use super::turn_request::{TurnError, TurnRequest};
use crate::math::hermite::Sample;
use crate::math::periodic_spline::{PeriodicSpline, Weights};
use crate::math::units::{TURN_RAD, deg_from_rad};
use alloc::vec::Vec;

/// Points on which the bound of the process is looked at, at least: a multiple or, for a path of many intervals, a fraction of them.
const BOUND_POINTS: usize = 2880;

/// Share of 1/bound² by which its arc between two points may be above their chord and not be looked at.
const FLAT: f64 = 3e-5;

/// Share of X and X″ up to which the arc of X″ between two points makes no notch.
const SMOOTH: f64 = 1.5e-6;

/// Largest change of X‴ between two points up to which X‴ at one of them makes X″ rise or fall all the way, as a share of X‴: 1 would do
/// for X″ alone.
const STEADY: f64 = 0.5;

/// Most parts into which an interval of the path, or what lies between two points in it, is divided to look at it.
const MAX_PARTS: f64 = 32.0;

/// The bound of a turn.
#[derive(Debug)]
pub(super) struct LimitTable {
    per_bound: Vec<f64>,
    /// The path there.
    path: Vec<Sample>,
    /// Angle and 1/bound² between those points, in the order of angles, where a notch of the bound may have its bottom there.
    notches: Vec<(f64, f64)>,
}

impl LimitTable {
    /// # Errors
    /// An angle at which the process allows no speed.
    pub(super) fn new(request: &TurnRequest<'_>) -> Result<Self, TurnError> {
        let grid = Grid::new(request.path.coefficients().len());
        let weights = Weights::at_parts(u32::try_from(grid.parts).unwrap_or(u32::MAX));
        let mut per_bound = Vec::with_capacity(grid.count);
        let mut samples = Vec::with_capacity(grid.count);
        for knot in (0..request.path.coefficients().len()).step_by(grid.stride) {
            for weights in &weights {
                let angle = to_f64(per_bound.len()) * grid.spacing;
                let path = request.path.combine(knot, weights);
                per_bound.push(inverse_square_bound(request, angle, path)?);
                samples.push(path);
            }
        }
        let notches = notches(request, &per_bound, &samples, &grid)?;
        Ok(Self { per_bound, path: samples, notches })
    }

    /// Data of an interval between its ends: the angle from the first, and 1/bound²; first the points at equal angles.
    pub(super) fn within(&self, begin: f64, length: f64) -> impl Iterator<Item = (f64, f64)> {
        self.even_within(begin, length).chain(self.notches_within(begin, length))
    }

    /// The same in the order of angles.
    pub(super) fn in_order_within(&self, begin: f64, length: f64) -> impl Iterator<Item = (f64, f64)> {
        let mut even = self.even_within(begin, length).peekable();
        let mut notches = self.notches_within(begin, length).peekable();
        core::iter::from_fn(move || match (even.peek(), notches.peek()) {
            (Some(point), Some(notch)) if notch.0 < point.0 => notches.next(),
            (None, _) => notches.next(),
            _ => even.next(),
        })
    }

    fn even_within(&self, begin: f64, length: f64) -> impl Iterator<Item = (f64, f64)> {
        let (spacing, per_bounds) = (self.spacing(), &self.per_bound);
        #[allow(clippy::cast_possible_truncation, reason = "some ten thousand points")]
        let first = (begin / spacing) as usize + 1;
        let mut index = first % per_bounds.len();
        let even = (first..).map(move |point| to_f64(point) * spacing - begin).take_while(move |along| *along < length);
        even.map(move |along| {
            let per = per_bounds[index];
            index = if index + 1 < per_bounds.len() { index + 1 } else { 0 };
            (along, per)
        })
    }

    fn notches_within(&self, begin: f64, length: f64) -> impl Iterator<Item = (f64, f64)> {
        let notches = &self.notches[self.notches.partition_point(|(angle, _)| *angle <= begin)..];
        let notches = notches.iter().map(move |(angle, per)| (angle - begin, *per));
        notches.take_while(move |(along, _)| *along < length)
    }

    /// The points at equal angles of an interval between its ends: the angle from the first, 1/bound² and the path there.
    pub(super) fn path_within(&self, begin: f64, length: f64) -> impl Iterator<Item = (f64, f64, &Sample)> {
        let spacing = self.spacing();
        #[allow(clippy::cast_possible_truncation, reason = "some ten thousand points")]
        let first = (begin / spacing) as usize + 1;
        let points = (first..).map(move |point| (to_f64(point) * spacing - begin, point));
        points.take_while(move |(along, _)| *along < length).map(|(along, point)| {
            let point = if point < self.path.len() { point } else { point - self.path.len() };
            (along, self.per_bound[point], &self.path[point])
        })
    }

    /// Distance of its points (rad).
    fn spacing(&self) -> f64 {
        TURN_RAD / to_f64(self.per_bound.len())
    }

    /// 1/bound² at equal angles from 0 on.
    pub(super) fn per_bounds(&self) -> &[f64] {
        &self.per_bound
    }
}

/// Points at equal angles.
struct Grid {
    /// Points in an interval of the path.
    parts: usize,
    /// Intervals of the path from a point to the next, where there are fewer points.
    stride: usize,
    count: usize,
    /// Distance of the points (rad).
    spacing: f64,
}

impl Grid {
    fn new(intervals: usize) -> Self {
        let parts = BOUND_POINTS.div_ceil(intervals);
        let mut stride = 1;
        while intervals.is_multiple_of(2 * stride) && intervals >= 2 * stride * BOUND_POINTS {
            stride *= 2;
        }
        let count = parts * intervals / stride;
        Self { parts, stride, count, spacing: TURN_RAD / to_f64(count) }
    }

    /// Arcs of X″ from each point to the next: largest distance from their chord.
    fn arcs(&self, path: &PeriodicSpline) -> Vec<f64> {
        let fourth = path.largest_fourth_derivatives(self.stride);
        let arc = 0.125 * self.spacing * self.spacing;
        fourth.iter().flat_map(|fourth| core::iter::repeat_n(arc * fourth, self.parts)).collect()
    }
}

/// 1/bound² where the path is as given: a number above 0.
fn inverse_square_bound(request: &TurnRequest<'_>, angle: f64, path: Sample) -> Result<f64, TurnError> {
    let per = request.per_square_bound(angle, path);
    if per.is_nan() || per <= 0.0 || per.is_infinite() {
        return Err(TurnError::NoSpeed { angle_deg: deg_from_rad(angle), speed_rad_s: (request.bound)(angle, path) });
    }
    Ok(per)
}

/// Points between the even ones wherever 1/bound² bends down so much that it may be noticeably above both of its neighbours, or the path
/// so much that a notch which both of them miss may have its bottom there.
fn notches(
    request: &TurnRequest<'_>,
    per_bound: &[f64],
    samples: &[Sample],
    grid: &Grid,
) -> Result<Vec<(f64, f64)>, TurnError> {
    let n = per_bound.len();
    let arcs = grid.arcs(request.path);
    // Height of a point above the chord of its neighbours: four times that of an arc of the same bend between two points.
    let above = |before: usize, i: usize, next: usize| per_bound[i] - 0.5 * (per_bound[before] + per_bound[next]);
    // X″ is not farther above or below both neighbours than its own arc: 1/bound² there, of a process that X″ decides.
    let by_path = |point: usize, arc: f64| {
        let path = samples[point];
        if arc <= SMOOTH * (path.value.abs() + path.second.abs()) {
            return 0.0;
        }
        let with = |second: f64| request.per_square_bound(to_f64(point) * grid.spacing, Sample { second, ..path });
        with(path.second - arc).max(with(path.second + arc))
    };
    let mut notches = Vec::new();
    let mut left = above(n - 1, 0, 1);
    for (i, arc) in arcs.into_iter().enumerate() {
        let next = if i + 1 < n { i + 1 } else { 0 };
        let right = above(i, next, if next + 1 < n { next + 1 } else { 0 });
        let largest = per_bound[i].max(per_bound[next]);
        let seen = 0.25 * left.max(right) / largest;
        // Where X″ rises or falls all the way it is between both neighbours.
        let change = 8.0 * arc / grid.spacing;
        let is_steady = change <= STEADY * samples[i].third.abs().max(samples[next].third.abs());
        let hidden = if is_steady { 0.0 } else { by_path(i, arc).max(by_path(next, arc)) / largest - 1.0 };
        let height = seen.max(hidden);
        left = right;
        if height <= FLAT {
            continue;
        }
        let parts = libm::ceil(libm::sqrt(height / FLAT)).min(MAX_PARTS * to_f64(grid.stride));
        #[allow(clippy::cast_possible_truncation, reason = "at most some hundred parts")]
        let parts = parts as u32;
        for part in 1..parts {
            let angle = (to_f64(i) + f64::from(part) / f64::from(parts)) * grid.spacing;
            notches.push((angle, inverse_square_bound(request, angle, request.path.sample(angle))?));
        }
    }
    Ok(notches)
}
