// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Chains whose knots lie on the curve: from every knot as far as one straight piece can go.

use super::Chain;
use super::grid::SampleGrid;
use alloc::vec::Vec;

/// Slopes that a line from a knot may have to pass every place so far.
#[derive(Clone, Copy)]
struct Cone {
    min: f64,
    max: f64,
}

/// Halvings in search of the narrowest tolerance that takes no more pieces.
const HALVINGS: u32 = 12;

/// The same number of pieces in the narrowest half width that takes no more of them, so their errors are even.
pub(super) fn farthest_evenly(grid: &SampleGrid, half_width_mm: f64) -> Chain {
    let mut best = farthest(grid, half_width_mm);
    let (mut too_narrow, mut wide_enough) = (0.0, half_width_mm);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (too_narrow + wide_enough);
        let tried = farthest(grid, middle);
        if tried.pieces() <= best.pieces() {
            (best, wide_enough) = (tried, middle);
        } else {
            too_narrow = middle;
        }
    }
    best
}

/// From every knot the farthest place of the grid that all axes reach in one piece.
pub(super) fn farthest(grid: &SampleGrid, half_width_mm: f64) -> Chain {
    let places = grid.angles_rad.len();
    let mut knots = alloc::vec![0];
    let mut from = 0;
    while from + 1 < places {
        from = reach(grid, from, half_width_mm);
        knots.push(from);
    }
    let at_knots = |values: &[f64]| -> Vec<f64> { knots.iter().map(|place| values[*place]).collect() };
    Chain { angles_rad: at_knots(&grid.angles_rad), positions_mm: grid.values.iter().map(|v| at_knots(v)).collect() }
}

/// The farthest place that one piece from a place reaches with all axes within the tolerance; at least the next.
fn reach(grid: &SampleGrid, from: usize, half_width_mm: f64) -> usize {
    let mut cones = alloc::vec![Cone { min: f64::NEG_INFINITY, max: f64::INFINITY }; grid.values.len()];
    let mut farthest = from + 1;
    for to in from + 1..grid.angles_rad.len() {
        let way_rad = grid.angles_rad[to] - grid.angles_rad[from];
        let mut reached = true;
        for (cone, values) in cones.iter_mut().zip(&grid.values) {
            let rise_mm = values[to] - values[from];
            let slope = rise_mm / way_rad;
            reached &= slope >= cone.min && slope <= cone.max;
            cone.min = cone.min.max((rise_mm - half_width_mm) / way_rad);
            cone.max = cone.max.min((rise_mm + half_width_mm) / way_rad);
            if cone.min > cone.max {
                return farthest;
            }
        }
        if reached {
            farthest = to;
        }
    }
    farthest
}
