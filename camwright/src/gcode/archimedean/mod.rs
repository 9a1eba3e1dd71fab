// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Travels of linear axes over the turned angle as chains of straight pieces: X = a + kC, an Archimedean spiral on the part, which is what
//! any control with linear interpolation can run as one block.
//!
//! With knots on the curve a piece of tolerance ε spans √(8ε/|X″|), so that a turn takes ∮√(|X″|/8ε) of them; with knots anywhere in the
//! tube of half width ε it spans √(16ε/|X″|). Where two pieces meet their slopes differ, which at the surface is a step of the velocity
//! along X: for knots on the curve √(8ε|X″|) times the speed of C. Every chain is measured against the travels on a grid of its own.

mod grid;
mod on_curve;
mod tunnel;

use crate::math::hermite::Sample;
use crate::math::units::deg_from_rad;
use alloc::vec::Vec;
use grid::SampleGrid;
use thiserror::Error;

/// Motion of one axis over the turned angle (mm over rad).
pub type Travelling<'a> = &'a dyn Fn(f64) -> Sample;

/// Permitted positions of the knots of a chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Knots {
    /// On the curve: every programmed point is one of the path.
    OnCurve,
    /// Anywhere within the tolerance: the fewest pieces there can be. Where more than one axis travels they lie on the curve.
    #[default]
    Free,
}

/// A travel to be cut into pieces.
#[derive(Clone, Copy)]
#[allow(missing_debug_implementations, reason = "travels are functions")]
pub struct ChainRequest<'a> {
    /// Axes that move, all in the same blocks.
    pub travels: &'a [Travelling<'a>],
    /// Angle at which the chain begins (rad); its first knot lies on the curve.
    pub from_rad: f64,
    /// Angle at which it ends (rad); its last knot lies on the curve.
    pub to_rad: f64,
    /// Most that a piece may be off along any axis (mm).
    pub tolerance_mm: f64,
    /// Share of the tolerance reserved for the rounding of the knots (mm).
    pub rounding_mm: f64,
    /// Permitted positions of the knots.
    pub knots: Knots,
}

/// Why there is no chain.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ChainError {
    /// Rounding leaves nothing of the tolerance.
    #[error(
        "a tolerance of {tolerance_um} um leaves nothing beside {rounding_um:.4} um of rounding; it must be at least {min_um:.4} um: \
         more decimals, or a larger tolerance"
    )]
    BadTolerance {
        /// Requested tolerance (um).
        tolerance_um: f64,
        /// Error of the rounding (um).
        rounding_um: f64,
        /// Least that works (um).
        min_um: f64,
    },
    /// No travel, or no way.
    #[error(
        "a chain from {from_deg} deg to {to_deg} deg over {axes} axes: it needs a way forwards of at most {max_turns} turns and an axis"
    )]
    BadSpan {
        /// Start (deg).
        from_deg: f64,
        /// End (deg).
        to_deg: f64,
        axes: usize,
        /// Longest way (turns).
        max_turns: u32,
    },
    /// A travel that is not finite.
    #[error("the travel is not a finite number at {angle_deg} deg")]
    NotFinite {
        /// Position (deg).
        angle_deg: f64,
    },
    /// The tolerance is so fine that the computation would take too long.
    #[error("the travel must be looked at in {points} places for a tolerance of {tolerance_um} um; at most {max} are")]
    TooFine {
        points: u64,
        /// The tolerance (um).
        tolerance_um: f64,
        max: u64,
    },
}

/// Straight pieces, knot by knot.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// Turned angle of every knot (rad), growing.
    pub angles_rad: Vec<f64>,
    /// Positions of every axis at the knots (mm), an axis after the other.
    pub positions_mm: Vec<Vec<f64>>,
}

/// Deviation of a chain from the travel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ChainDeviation {
    /// Largest distance along an axis between chain and travel (mm).
    pub error_mm: f64,
    /// The axis, by its place in the request.
    pub error_axis: usize,
    /// Turned angle there (rad).
    pub error_at_rad: f64,
    /// Largest change of slope from a piece to the next (mm/rad).
    pub slope_jump_mm_rad: f64,
    pub slope_axis: usize,
    /// Turned angle there (rad).
    pub slope_at_rad: f64,
}

/// The judge looks this many times closer than the chain was made.
const JUDGED_FINER: u32 = 8;

impl Chain {
    /// The fewest pieces within the tolerance.
    ///
    /// # Errors
    /// A tolerance that rounding uses up, no way to go, a travel that is not finite, one that would take too many points to look at.
    pub fn new(request: &ChainRequest<'_>) -> Result<Self, ChainError> {
        let grid = SampleGrid::new(request, 1)?;
        let half_width_mm = grid.half_width_mm(request);
        let free = match (request.knots, &grid.values[..]) {
            (Knots::Free, [values]) => tunnel::fewest_evenly(&grid.angles_rad, values, half_width_mm),
            _ => None,
        };
        Ok(match free {
            Some((angles_rad, positions)) => Self { angles_rad, positions_mm: alloc::vec![positions] },
            None => on_curve::farthest(&grid, half_width_mm),
        })
    }

    /// As many pieces as [`Self::new`] has, in the narrowest tolerance that takes no more of them: no piece is left over at the end.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn evenly(request: &ChainRequest<'_>) -> Result<Self, ChainError> {
        let grid = SampleGrid::new(request, 1)?;
        let half_width_mm = grid.half_width_mm(request);
        if request.knots == Knots::Free
            && let [values] = &grid.values[..]
            && let Some((angles_rad, positions)) = tunnel::fewest_evenly(&grid.angles_rad, values, half_width_mm)
        {
            return Ok(Self { angles_rad, positions_mm: alloc::vec![positions] });
        }
        Ok(on_curve::farthest_evenly(&grid, half_width_mm))
    }

    #[must_use]
    pub fn pieces(&self) -> usize {
        self.angles_rad.len().saturating_sub(1)
    }

    /// Slope of an axis in a piece (mm/rad).
    #[must_use]
    pub fn slope(&self, axis: usize, piece: usize) -> f64 {
        let (angles, positions) = (&self.angles_rad, &self.positions_mm[axis]);
        (positions[piece + 1] - positions[piece]) / (angles[piece + 1] - angles[piece])
    }

    /// Compares the chain with its travels on a grid 8 times finer than the planning grid.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn judge(&self, request: &ChainRequest<'_>) -> Result<ChainDeviation, ChainError> {
        let grid = SampleGrid::new(request, JUDGED_FINER)?;
        let mut found = ChainDeviation::default();
        for (axis, values) in grid.values.iter().enumerate() {
            let mut piece = 0;
            for (angle_rad, value_mm) in grid.angles_rad.iter().zip(values) {
                while piece + 1 < self.pieces() && *angle_rad > self.angles_rad[piece + 1] {
                    piece += 1;
                }
                let on_chain =
                    self.positions_mm[axis][piece] + self.slope(axis, piece) * (angle_rad - self.angles_rad[piece]);
                let error_mm = (on_chain - value_mm).abs();
                if error_mm > found.error_mm || error_mm.is_nan() {
                    (found.error_mm, found.error_axis, found.error_at_rad) = (error_mm, axis, *angle_rad);
                }
            }
            for piece in 1..self.pieces() {
                let jump = (self.slope(axis, piece) - self.slope(axis, piece - 1)).abs();
                if jump > found.slope_jump_mm_rad {
                    (found.slope_jump_mm_rad, found.slope_axis) = (jump, axis);
                    found.slope_at_rad = self.angles_rad[piece];
                }
            }
        }
        Ok(found)
    }
}

/// Theoretical number of pieces: ∫√(|X″|/8ε) with knots on the curve, ∫√(|X″|/16ε) with free knots, of the axis that needs most.
///
/// # Errors
/// As [`Chain::new`].
pub fn theoretical_pieces(request: &ChainRequest<'_>) -> Result<f64, ChainError> {
    const PARTS: u32 = 36_000;
    grid::check_span(request)?;
    let step = (request.to_rad - request.from_rad) / f64::from(PARTS);
    let sag = if request.knots == Knots::Free && request.travels.len() == 1 { 16.0 } else { 8.0 };
    let needs = |travel: Travelling<'_>| {
        let root = |part: u32| libm::sqrt(travel(request.from_rad + (f64::from(part) + 0.5) * step).second.abs());
        (0..PARTS).map(root).sum::<f64>() * step / libm::sqrt(sag * request.tolerance_mm)
    };
    let pieces = request.travels.iter().map(|travel| needs(*travel)).fold(0.0, f64::max);
    if pieces.is_finite() {
        Ok(pieces)
    } else {
        Err(ChainError::NotFinite { angle_deg: deg_from_rad(request.from_rad) })
    }
}
