// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The part on a lathe: a polar radius over azimuth and place along the axis, from which a round insert takes away what its edge sweeps.
//!
//! ```text
//!        y                        seen from +Z, the rake plane is y = H
//!        │   part                 seen from above:      x
//!        │                                              │  insert, radius R about (x, z)
//!  ──────┼──────────── x                                │   ╭───╮
//!        │      ╲                                       │   ╰───╯   edge xₑ(z) = x − √(R² − (z' − z)²) at the column z'
//!     H ─┼───────●━━━━ rake face                        └────────────── z'
//! ```
//! Azimuths φ are in the part's frame, from the keyway. With the part turned by θ = σ·C, the edge's point at a column is at azimuth
//! φ = θ + atan2(H, xₑ) and at radius √(xₑ² + H²). Between two positions of the axes it draws a curve, and every azimuth of the grid that
//! it passes is left with at most the radius at which it passes there.
//!
//! What the rake face behind the edge meets is not looked at: it lies outside of the curve, where the edge arrives next, except when the
//! tool enters. So is the flank below the edge: clearance is the planner's to prove.

mod bounds;
mod cell_radii;
mod crossing;
mod form_map;
mod insert;
mod snapshot;
mod sweep;
#[cfg(test)]
mod tests;

use crate::math::units::TURN_RAD;
use alloc::string::String;
use alloc::vec::Vec;
use bounds::{CHUNK, RadiusBounds};
use cell_radii::CellRadii;
use thiserror::Error;

pub use form_map::{Cusps, FormBin, FormMap, FormMapError, FormPoint};
pub use insert::{Insert, InsertMove, InsertPose};

/// Fewest azimuths of a part.
pub const MIN_AZIMUTHS: usize = 16;
/// Fewest columns along it.
pub const MIN_COLUMNS: usize = 2;
/// Most cells: 720 azimuths at 2900 places. Their radii are 17 MB, which have to be carried away after every part.
pub const MAX_CELLS: usize = 1 << 21;

/// Columns whose largest radius is looked at anew in one [`TurnedPart::refresh`]. More narrow down sooner what a tool can reach.
const REFRESHED: usize = 2;

/// Why figures are not a part.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TurnedPartError {
    /// Too few azimuths or columns.
    #[error(
        "part {name}: {azimuths} azimuths and {columns} columns, at least {MIN_AZIMUTHS} and {MIN_COLUMNS} are needed"
    )]
    TooFew { name: String, azimuths: usize, columns: usize },
    /// More cells than a machine carries.
    #[error(
        "part {name}: {azimuths} azimuths and {columns} columns are {cells} cells, at most {MAX_CELLS} are allowed"
    )]
    TooMany {
        name: String,
        azimuths: usize,
        columns: usize,
        /// Cells of both, as far as that can be counted.
        cells: usize,
    },
    /// Columns that lie nowhere.
    #[error("part {name}: columns from {from_mm} to {to_mm} mm, which must increase and be finite")]
    Range {
        name: String,
        /// First column (mm).
        from_mm: f64,
        /// Last column (mm).
        to_mm: f64,
    },
    /// Not one radius for every cell.
    #[error("part {name}: {radii} radii, {cells} cells")]
    Count {
        name: String,
        radii: usize,
        /// Cells of the grid.
        cells: usize,
    },
    /// A radius is not positive.
    #[error(
        "part {name}: radius {radius_mm} mm at {azimuth_deg:.3} deg and z {z_mm:.3} mm, must be positive and finite"
    )]
    Radius {
        name: String,
        /// Azimuth (degrees).
        azimuth_deg: f64,
        /// Place along the part (mm).
        z_mm: f64,
        /// Its value (mm).
        radius_mm: f64,
    },
    /// The machine has no insert.
    #[error("part {name}: the machine grinds with a wheel, it turns nothing")]
    NotALathe { name: String },
    /// No number says where the part is clamped.
    #[error("part {name}: its zero is {part_zero_mm} mm, must be finite")]
    Zero {
        name: String,
        /// Given value (mm).
        part_zero_mm: f64,
    },
}

/// Grid of the cells of a part: azimuths i·2π/n from the keyway, columns evenly spaced along the axis with one at either end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartGrid {
    /// Azimuths of a turn.
    pub azimuths: usize,
    pub columns: usize,
    /// First column (mm, along the part).
    pub from_mm: f64,
    /// Last column (mm).
    pub to_mm: f64,
}

impl PartGrid {
    /// An azimuth from the keyway (rad).
    #[must_use]
    pub fn azimuth_rad(&self, index: usize) -> f64 {
        TURN_RAD * index as f64 / self.azimuths as f64
    }

    /// Distance of two columns (mm).
    #[must_use]
    pub fn column_step_mm(&self) -> f64 {
        (self.to_mm - self.from_mm) / (self.columns - 1) as f64
    }

    /// Place of a column along the part (mm).
    #[must_use]
    pub fn z_mm(&self, column: usize) -> f64 {
        let share = column as f64 / (self.columns - 1) as f64;
        self.from_mm + (self.to_mm - self.from_mm) * share
    }

    /// Cells in all, as far as that can be counted.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.azimuths.saturating_mul(self.columns)
    }

    /// Checks that a part can have this grid.
    ///
    /// # Errors
    /// Too few or too many cells, columns that lie nowhere.
    pub fn check(&self, name: &str) -> Result<(), TurnedPartError> {
        let (Self { azimuths, columns, from_mm, to_mm }, name) = (*self, String::from(name));
        if azimuths < MIN_AZIMUTHS || columns < MIN_COLUMNS {
            return Err(TurnedPartError::TooFew { name, azimuths, columns });
        }
        if self.cells() > MAX_CELLS {
            return Err(TurnedPartError::TooMany { name, azimuths, columns, cells: self.cells() });
        }
        if !(from_mm < to_mm && from_mm.is_finite() && to_mm.is_finite()) {
            return Err(TurnedPartError::Range { name, from_mm, to_mm });
        }
        Ok(())
    }
}

/// Material removed by the insert.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TurnedRemoval {
    /// Volume (mm³).
    pub volume_mm3: f64,
    /// Deepest penetration of the edge, measured along the radius (mm).
    pub depth_mm: f64,
    /// Position of the deepest cut: azimuth from the keyway (rad), position along the part (mm).
    pub deepest: Option<(f64, f64)>,
    /// The edge is over the part's axis, where it can cut nothing.
    pub is_over_axis: bool,
}

impl TurnedRemoval {
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let deeper = if other.depth_mm > self.depth_mm { other } else { self };
        Self {
            volume_mm3: self.volume_mm3 + other.volume_mm3,
            depth_mm: deeper.depth_mm,
            deepest: deeper.deepest,
            is_over_axis: self.is_over_axis || other.is_over_axis,
        }
    }
}

/// A part as it is turned.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnedPart {
    name: String,
    grid: PartGrid,
    cells: CellRadii,
    /// Cosine and sine of every azimuth.
    cos: Vec<f64>,
    sin: Vec<f64>,
    bounds: RadiusBounds,
    raw_reach: f64,
    min: f64,
    /// An upper bound of its radius.
    reach: f64,
    /// The column to be looked at next, and the largest radius of those before it.
    refresh: (usize, f64),
    changed: bool,
}

impl TurnedPart {
    /// A part from a radius (mm) for every cell, all azimuths of the first column first.
    ///
    /// # Errors
    /// A grid that is none, another number of radii than cells, a radius that is not positive.
    pub fn new(name: String, grid: PartGrid, radii: Vec<f64>) -> Result<Self, TurnedPartError> {
        grid.check(&name)?;
        let azimuths = grid.azimuths;
        if radii.len() != grid.cells() {
            return Err(TurnedPartError::Count { name, radii: radii.len(), cells: grid.cells() });
        }
        if let Some(index) = radii.iter().position(|r| !(*r > 0.0 && r.is_finite())) {
            return Err(TurnedPartError::Radius {
                name,
                azimuth_deg: crate::math::units::deg_from_rad(grid.azimuth_rad(index % azimuths)),
                z_mm: grid.z_mm(index / azimuths),
                radius_mm: radii[index],
            });
        }
        let reach = largest(&radii);
        let min = radii.iter().fold(reach, |min, r| min.min(*r));
        let cos = (0..azimuths).map(|i| libm::cos(grid.azimuth_rad(i))).collect();
        let sin = (0..azimuths).map(|i| libm::sin(grid.azimuth_rad(i))).collect();
        let cells = CellRadii::new(&grid, &radii);
        let bounds = RadiusBounds::new(&grid, &cells);
        let (raw_reach, refresh, changed) = (reach, (0, 0.0), false);
        Ok(Self { name, grid, cells, cos, sin, bounds, raw_reach, min, reach, refresh, changed })
    }

    /// A round bar of this radius (mm).
    ///
    /// # Errors
    /// See [`TurnedPart::new`].
    pub fn round(name: String, grid: PartGrid, radius_mm: f64) -> Result<Self, TurnedPartError> {
        // Before memory is taken for it.
        grid.check(&name)?;
        let radii = alloc::vec![radius_mm; grid.cells()];
        Self::new(name, grid, radii)
    }

    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Grid of its cells.
    #[must_use]
    pub fn grid(&self) -> &PartGrid {
        &self.grid
    }

    /// Radii (mm) of a column, one for every azimuth.
    pub fn column_mm(&self, column: usize) -> impl ExactSizeIterator<Item = f64> + Clone {
        self.cells.column(column)
    }

    /// Radii (mm) of all cells, all azimuths of the first column first.
    pub fn radii_mm(&self) -> impl Iterator<Item = f64> + Clone {
        self.cells.all()
    }

    /// Radius of a cell (mm).
    #[must_use]
    pub fn radius_mm(&self, azimuth: usize, column: usize) -> f64 {
        self.cells.cell(azimuth, column)
    }

    /// Largest radius of the raw part (mm).
    #[must_use]
    pub fn raw_reach_mm(&self) -> f64 {
        self.raw_reach
    }

    /// Its smallest radius (mm).
    #[must_use]
    pub fn minimum_mm(&self) -> f64 {
        self.min
    }

    /// An upper bound of its radius (mm): it follows what is cut once [`TurnedPart::refresh`] has gone over all columns.
    #[must_use]
    pub fn reach_mm(&self) -> f64 {
        self.reach
    }

    /// Volume (mm³): every cell is the sector of a ring as wide as the column spacing.
    #[must_use]
    pub fn volume_mm3(&self) -> f64 {
        self.cells.all().map(|r| r * r).sum::<f64>() * self.half_sector()
    }

    /// Volume of a cell over the square of its radius (mm).
    fn half_sector(&self) -> f64 {
        0.5 * TURN_RAD / self.grid.azimuths as f64 * self.grid.column_step_mm()
    }

    /// Looks after the upper bound of its radius, a few columns at a time. It decides what is looked at, never what is cut.
    pub fn refresh(&mut self) {
        if !self.changed {
            return;
        }
        for _ in 0..REFRESHED {
            let (column, so_far) = self.refresh;
            let is_last = column + 1 == self.grid.columns;
            let ends_chunk = is_last || (column + 1) % CHUNK == 0;
            let max = if ends_chunk { so_far.max(self.cells.largest_mm(column / CHUNK)) } else { so_far };
            self.refresh = if is_last {
                // Radii only get smaller: what was the largest some time ago is no less than now.
                self.reach = max;
                (0, 0.0)
            } else {
                (column + 1, max)
            };
        }
    }
}

/// Largest of radii, none of which is NaN: four at a time, which do not wait for each other.
fn largest(radii: &[f64]) -> f64 {
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    let (fours, rest) = radii.as_chunks::<4>();
    let max = fours.iter().fold([0.0; 4], |max, four| core::array::from_fn(|i| larger(max[i], four[i])));
    rest.iter().chain(&max).fold(0.0, |max, radius| larger(max, *radius))
}

/// Smallest of eight radii and one more, none of which is NaN: pairs, which do not wait for each other.
fn smallest(radii: &[f64; CHUNK], other: f64) -> f64 {
    let smaller = |a: f64, b: f64| if b < a { b } else { a };
    let [a, b, c, d, e, f, g, h] = *radii;
    let (one, two) = (smaller(smaller(a, e), smaller(c, g)), smaller(smaller(b, f), smaller(d, h)));
    smaller(smaller(one, two), other)
}
