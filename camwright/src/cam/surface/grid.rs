// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Radii on a grid, and the C² surface through them: quintic B-splines round the turn (C⁴ there), cubics along z.
//!
//! Along z the spline is the cubic through its rows whose third derivative does not jump at the second row from either end ("not a
//! knot"), so that cubics come back exactly; beyond its ends it goes on along its tangent.

use super::{SurfaceError, SurfaceKey, SurfacePoint};
use crate::math::periodic_spline::{PeriodicSpline, Weights};
use crate::math::units::{TURN_RAD, deg_from_rad};
use alloc::vec;
use alloc::vec::Vec;

/// Radii at equal steps of a turn and at increasing z.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceGrid {
    /// Azimuths of the columns (rad): equal steps of a turn, from anywhere; one more that closes the turn is allowed, and must have the
    /// radii of the first.
    pub azimuths_rad: Vec<f64>,
    /// z of the rows (mm), increasing.
    pub z_mm: Vec<f64>,
    /// Radii (mm), row by row: that of row k and column i at `k · columns + i`.
    pub radii_mm: Vec<f64>,
}

impl SurfaceGrid {
    /// A grid of what a function says.
    #[must_use]
    pub fn sampled(angles: u32, z_mm: Vec<f64>, radius: impl Fn(f64, f64) -> f64) -> Self {
        let azimuths_rad: Vec<f64> = (0..angles).map(|i| f64::from(i) * TURN_RAD / f64::from(angles)).collect();
        let radii_mm = z_mm.iter().flat_map(|z| azimuths_rad.iter().map(|azimuth| radius(*azimuth, *z))).collect();
        Self { azimuths_rad, z_mm, radii_mm }
    }
}

/// Fewest and most azimuths of a grid: what a quintic needs, and 0.01°.
const ANGLES: (usize, usize) = (6, 36_000);

/// Fewest and most rows.
const ROWS: (usize, usize) = (2, 200_000);

/// Tolerance of an azimuth against its equal step, in steps.
const UNEVEN: f64 = 1e-3;

/// Tolerance between the first radii and those after a turn (mm): a digit of a table in µm.
const OPEN_MM: f64 = 1e-3;

/// Largest radius (mm).
const LARGEST_MM: f64 = 1e5;

/// The surface through a grid.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct GridSpline {
    /// B-spline coefficients round the turn, relative to `level`: value and second derivative over z, row by row.
    nodes: Vec<[f64; 2]>,
    z_mm: Vec<f64>,
    angles: usize,
    start_rad: f64,
    level_mm: f64,
    /// Rows per mm, if they were equally spaced: where to begin looking.
    rows_per_mm: f64,
}

impl GridSpline {
    pub(super) fn new(grid: &SurfaceGrid) -> Result<Self, SurfaceError> {
        let (columns, rows) = (grid.azimuths_rad.len(), grid.z_mm.len());
        let wanted = columns.saturating_mul(rows);
        if grid.radii_mm.len() != wanted {
            let count = grid.radii_mm.len();
            return Err(SurfaceError::GridSize { angles: columns, rows, count, wanted });
        }
        let count = |what, count: usize, (min, max): (usize, usize)| {
            let fits = (min..=max).contains(&count);
            if fits { Ok(()) } else { Err(SurfaceError::Count { what, count, min, max }) }
        };
        count(SurfaceKey::Azimuths, columns, ANGLES)?;
        count(SurfaceKey::Rows, rows, ROWS)?;
        check_radii(grid)?;
        let angles = columns_of_a_turn(grid)?;
        count(SurfaceKey::Azimuths, angles, ANGLES)?;
        check_z(&grid.z_mm)?;
        let level_mm = grid.radii_mm[0];
        let mut nodes = Vec::with_capacity(angles * rows);
        // As `PeriodicSpline::interpolate` does it, with one factor for all rows.
        let factor = PeriodicSpline::interpolation(angles).expect("at least six azimuths");
        for row in grid.radii_mm.chunks_exact(columns) {
            let first = row[0];
            let mut values: Vec<f64> = row[..angles].iter().map(|radius| radius - first).collect();
            factor.solve(&mut values);
            nodes.extend(values.iter().map(|c| [c + (first - level_mm), 0.0]));
        }
        second_derivatives(&grid.z_mm, angles, &mut nodes);
        let rows_per_mm = (rows - 1) as f64 / (grid.z_mm[rows - 1] - grid.z_mm[0]);
        let (z_mm, start_rad) = (grid.z_mm.clone(), grid.azimuths_rad[0]);
        Ok(Self { nodes, z_mm, angles, start_rad, level_mm, rows_per_mm })
    }

    pub(super) fn ends_mm(&self) -> (f64, f64) {
        (self.z_mm[0], self.z_mm[self.z_mm.len() - 1])
    }

    /// A grid that has at least the azimuths and, up to a number, the rows of this one.
    pub(super) fn fine_grid(&self) -> (u32, u32) {
        let number = |count: usize, max: u32| u32::try_from(count).unwrap_or(max).min(max);
        (number(self.angles, 1440).max(360), number(self.z_mm.len() - 1, 400).max(64))
    }

    pub(super) fn point(&self, azimuth_rad: f64, z_mm: f64) -> SurfacePoint {
        let (row, along) = self.along(z_mm);
        let n = self.angles;
        let per_rad = n as f64 / TURN_RAD;
        let x = (azimuth_rad - self.start_rad) * per_rad;
        // Into the turn without a whole-number remainder, which takes longer than the rest.
        let x = x - n as f64 * libm::floor(x / n as f64);
        #[allow(clippy::cast_possible_truncation, reason = "within the turn; what is none gives 0")]
        let knot = (x as usize).min(n - 1);
        let round = Weights::from_coefficients(x - knot as f64);
        // The two rows of six coefficients, and what they are in value, slope and bend along z.
        let here = |k: usize| self.nodes[row * n + k];
        let above = |k: usize| self.nodes[(row + 1) * n + k];
        let mut sums = [[0.0; 3]; 3];
        let mut k = if knot < 2 { knot + n - 2 } else { knot - 2 };
        let [value, first, second] = round;
        for ((value, first), second) in value.into_iter().zip(first).zip(second) {
            let ([c0, m0], [c1, m1]) = (here(k), above(k));
            for (sums, w) in sums.iter_mut().zip(&along) {
                let node = w[0] * c0 + w[1] * c1 + w[2] * m0 + w[3] * m1;
                sums[0] += value * node;
                sums[1] += first * node;
                sums[2] += second * node;
            }
            k = if k + 1 < n { k + 1 } else { 0 };
        }
        SurfacePoint {
            radius_mm: self.level_mm + sums[0][0],
            by_azimuth: sums[0][1] * per_rad,
            by_z: sums[1][0],
            by_azimuth_twice: sums[0][2] * per_rad * per_rad,
            by_azimuth_and_z: sums[1][1] * per_rad,
            by_z_twice: sums[2][0],
        }
    }

    /// The row below a z, and what values and second derivatives of that row and the next count in value, first and second derivative
    /// there.
    fn along(&self, z_mm: f64) -> (usize, [[f64; 4]; 3]) {
        let last = self.z_mm.len() - 1;
        let inside = z_mm.clamp(self.z_mm[0], self.z_mm[last]);
        #[allow(clippy::cast_possible_truncation, reason = "it lies between the ends")]
        let mut row = (((inside - self.z_mm[0]) * self.rows_per_mm) as usize).min(last - 1);
        if !(self.z_mm[row] <= inside && inside <= self.z_mm[row + 1]) {
            row = self.z_mm.partition_point(|z| *z <= inside).clamp(1, last) - 1;
        }
        let h = self.z_mm[row + 1] - self.z_mm[row];
        let u = (inside - self.z_mm[row]) / h;
        let v = 1.0 - u;
        let mut value = [v, u, h * h * v * (v * v - 1.0) / 6.0, h * h * u * (u * u - 1.0) / 6.0];
        let first = [-1.0 / h, 1.0 / h, h * (1.0 - 3.0 * v * v) / 6.0, h * (3.0 * u * u - 1.0) / 6.0];
        let beyond = z_mm - inside;
        // Not a number is beyond too, and gives what is not a number.
        if beyond == 0.0 {
            return (row, [value, first, [0.0, 0.0, v, u]]);
        }
        for (value, first) in value.iter_mut().zip(first) {
            *value += beyond * first;
        }
        (row, [value, first, [0.0; 4]])
    }
}

fn check_radii(grid: &SurfaceGrid) -> Result<(), SurfaceError> {
    let columns = grid.azimuths_rad.len();
    let bad = |radius: &f64| !(*radius > 0.0 && *radius <= LARGEST_MM);
    if let Some(index) = grid.radii_mm.iter().position(bad) {
        let azimuth_deg = deg_from_rad(grid.azimuths_rad[index % columns]);
        return Err(SurfaceError::BadRadius { row: index / columns, azimuth_deg, radius_mm: grid.radii_mm[index] });
    }
    Ok(())
}

fn check_z(z_mm: &[f64]) -> Result<(), SurfaceError> {
    for (row, z) in z_mm.iter().enumerate() {
        if !z.is_finite() || z.abs() > LARGEST_MM {
            return Err(SurfaceError::BadNumber { what: SurfaceKey::RowZ, value: *z, allowed: "within ±1e5 mm" });
        }
        if row > 0 && z - z_mm[row - 1] < 1e-9 {
            return Err(SurfaceError::ZNotIncreasing { row, z_mm: *z, previous_mm: z_mm[row - 1] });
        }
    }
    Ok(())
}

/// Columns without one that closes the turn.
fn columns_of_a_turn(grid: &SurfaceGrid) -> Result<usize, SurfaceError> {
    let columns = grid.azimuths_rad.len();
    let first = grid.azimuths_rad[0];
    let span = grid.azimuths_rad[columns - 1] - first;
    let closing = (span - TURN_RAD).abs() < UNEVEN * TURN_RAD / columns as f64;
    let angles = if closing { columns - 1 } else { columns };
    let step = TURN_RAD / angles as f64;
    for (column, azimuth) in grid.azimuths_rad.iter().enumerate() {
        let wanted = first + column as f64 * step;
        let off = (azimuth - wanted).abs();
        if off.is_nan() || off > UNEVEN * step || !azimuth.is_finite() || azimuth.abs() > 1e3 * TURN_RAD {
            let (azimuth_deg, wanted_deg) = (deg_from_rad(*azimuth), deg_from_rad(wanted));
            return Err(SurfaceError::UnevenAzimuth { column, azimuth_deg, wanted_deg });
        }
    }
    if closing {
        for (row, radii) in grid.radii_mm.chunks_exact(columns).enumerate() {
            let gap_mm = radii[columns - 1] - radii[0];
            if gap_mm.abs() > OPEN_MM {
                return Err(SurfaceError::NotClosed { row, gap_mm, bound_mm: OPEN_MM });
            }
        }
    }
    Ok(angles)
}

/// Second derivatives over z of every column's spline: h₋M₋ + 2(h₋ + h₊)M + h₊M₊ = 6(δ₊ − δ₋), the outermost two taken out by letting the
/// third derivative go on. Elimination without exchange of rows is safe: every diagonal outweighs its row.
fn second_derivatives(z_mm: &[f64], angles: usize, nodes: &mut [[f64; 2]]) {
    let rows = z_mm.len();
    if rows == 2 {
        return;
    }
    let h: Vec<f64> = z_mm.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let bend = |nodes: &[[f64; 2]], k: usize, i: usize| {
        let slope = |k: usize| (nodes[(k + 1) * angles + i][0] - nodes[k * angles + i][0]) / h[k];
        6.0 * (slope(k) - slope(k - 1))
    };
    if rows == 3 {
        for i in 0..angles {
            let second = bend(nodes, 1, i) / (3.0 * (h[0] + h[1]));
            for k in 0..3 {
                nodes[k * angles + i][1] = second;
            }
        }
        return;
    }
    // Rows 1 … last − 1 of the matrix: what stands left of, on and right of the diagonal.
    let last = rows - 1;
    let mut band = vec![[0.0; 3]; rows];
    for k in 1..last {
        band[k] = [h[k - 1], 2.0 * (h[k - 1] + h[k]), h[k]];
    }
    let (near, far) = (h[0] / h[1], h[last - 1] / h[last - 2]);
    band[1][1] += h[0] * (1.0 + near);
    band[1][2] -= h[0] * near;
    band[last - 1][1] += h[last - 1] * (1.0 + far);
    band[last - 1][0] -= h[last - 1] * far;
    // Forwards: every row less a share of the one before.
    for i in 0..angles {
        nodes[angles + i][1] = bend(nodes, 1, i);
    }
    for k in 2..last {
        let share = band[k][0] / band[k - 1][1];
        band[k][1] -= share * band[k - 1][2];
        for i in 0..angles {
            nodes[k * angles + i][1] = bend(nodes, k, i) - share * nodes[(k - 1) * angles + i][1];
        }
    }
    for k in (1..last).rev() {
        let [_, diagonal, right] = band[k];
        for i in 0..angles {
            let above = if k + 1 < last { right * nodes[(k + 1) * angles + i][1] } else { 0.0 };
            nodes[k * angles + i][1] = (nodes[k * angles + i][1] - above) / diagonal;
        }
    }
    for i in 0..angles {
        let m = |k: usize| nodes[k * angles + i][1];
        let (first, end) = (m(1) - near * (m(2) - m(1)), m(last - 1) + far * (m(last - 1) - m(last - 2)));
        nodes[i][1] = first;
        nodes[last * angles + i][1] = end;
    }
}
