// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Sampling grid of a travel: dense enough that linear interpolation between two points errs by a small share of the
//! tolerance.

use super::{ChainError, ChainRequest};
use crate::math::units::{TURN_RAD, deg_from_rad, um_from_mm};
use alloc::vec::Vec;

/// Longest way of a chain (turns).
const MAX_TURNS: u32 = 1000;

/// Most places at which a travel is looked at.
const MAX_POINTS: u64 = 40_000_000;

/// Share of the tolerance that a travel may bend off a straight line between two places.
const SHARE: f64 = 1.0 / 800.0;

/// Cells of a turn in which the places are spread evenly, each by what the travel bends in it.
const CELLS_PER_TURN: f64 = 720.0;

/// Looks into a cell for the largest second derivative, and how much larger it may be between two looks.
const LOOKS: (u32, f64) = (8, 1.25);

/// Fewest places in a cell.
const MIN_STEPS: f64 = 2.0;

/// The places with the travels at them.
pub(super) struct SampleGrid {
    /// Turned angles (rad), growing, from the beginning of the way to its end.
    pub angles_rad: Vec<f64>,
    /// Positions of every axis there (mm).
    pub values: Vec<Vec<f64>>,
}

/// Checks that the span is valid and that something travels over it.
pub(super) fn check_span(request: &ChainRequest<'_>) -> Result<(), ChainError> {
    let way_rad = request.to_rad - request.from_rad;
    if way_rad > 0.0 && way_rad <= f64::from(MAX_TURNS) * TURN_RAD && !request.travels.is_empty() {
        return Ok(());
    }
    Err(ChainError::BadSpan {
        from_deg: deg_from_rad(request.from_rad),
        to_deg: deg_from_rad(request.to_rad),
        axes: request.travels.len(),
        max_turns: MAX_TURNS,
    })
}

impl SampleGrid {
    /// The places for a request, so many times finer than a chain needs.
    pub(super) fn new(request: &ChainRequest<'_>, finer: u32) -> Result<Self, ChainError> {
        check_span(request)?;
        let usable_mm = request.tolerance_mm - request.rounding_mm;
        if !(usable_mm > 0.0 && usable_mm.is_finite() && request.rounding_mm >= 0.0) {
            return Err(ChainError::BadTolerance {
                tolerance_um: um_from_mm(request.tolerance_mm),
                rounding_um: um_from_mm(request.rounding_mm),
                min_um: um_from_mm(2.0 * request.rounding_mm.max(1e-9)),
            });
        }
        let way_rad = request.to_rad - request.from_rad;
        let cells = libm::ceil(way_rad / TURN_RAD * CELLS_PER_TURN).max(1.0);
        let cell_rad = way_rad / cells;
        #[allow(clippy::cast_possible_truncation, reason = "at most 720 000 cells")]
        let cells = cells as u32;
        let mut steps = Vec::with_capacity(cells as usize);
        let mut points = 1_u64;
        for cell in 0..cells {
            let bend = Self::largest_second(request, f64::from(cell) * cell_rad, cell_rad)?;
            let step_rad = libm::sqrt(8.0 * SHARE * usable_mm / bend.max(f64::MIN_POSITIVE));
            let count = f64::from(finer) * libm::ceil(cell_rad / step_rad).max(MIN_STEPS);
            #[allow(clippy::cast_possible_truncation, reason = "a count below 2^53")]
            let whole = count.min(MAX_POINTS as f64) as u64;
            steps.push(whole);
            points = points.saturating_add(whole);
        }
        if points > MAX_POINTS {
            let tolerance_um = um_from_mm(request.tolerance_mm);
            return Err(ChainError::TooFine { points, tolerance_um, max: MAX_POINTS });
        }
        Self::at(request, cell_rad, &steps)
    }

    /// Largest second derivative of any axis in a cell that begins so far on the way (mm/rad²).
    fn largest_second(request: &ChainRequest<'_>, begins_rad: f64, cell_rad: f64) -> Result<f64, ChainError> {
        let mut largest = 0.0_f64;
        for look in 0..=LOOKS.0 {
            let angle_rad = request.from_rad + begins_rad + cell_rad * f64::from(look) / f64::from(LOOKS.0);
            for travel in request.travels {
                let second = travel(angle_rad).second.abs();
                if !second.is_finite() {
                    return Err(ChainError::NotFinite { angle_deg: deg_from_rad(angle_rad) });
                }
                largest = largest.max(second);
            }
        }
        Ok(LOOKS.1 * largest)
    }

    /// The travels at evenly spread places of every cell.
    fn at(request: &ChainRequest<'_>, cell_rad: f64, steps: &[u64]) -> Result<Self, ChainError> {
        let mut angles_rad = Vec::new();
        for (cell, count) in steps.iter().enumerate() {
            let begins_rad = request.from_rad + cell as f64 * cell_rad;
            angles_rad.extend((0..*count).map(|step| begins_rad + cell_rad * step as f64 / *count as f64));
        }
        angles_rad.push(request.to_rad);
        let mut values = Vec::with_capacity(request.travels.len());
        for travel in request.travels {
            let along: Vec<f64> = angles_rad.iter().map(|angle| travel(*angle).value).collect();
            if let Some(bad) = along.iter().position(|value| !value.is_finite()) {
                return Err(ChainError::NotFinite { angle_deg: deg_from_rad(angles_rad[bad]) });
            }
            values.push(along);
        }
        Ok(Self { angles_rad, values })
    }

    /// Half width at the grid points (mm) that keeps a chain within the tolerance between the points and after rounding.
    pub(super) fn half_width_mm(&self, request: &ChainRequest<'_>) -> f64 {
        (1.0 - SHARE) * (request.tolerance_mm - request.rounding_mm)
    }
}
