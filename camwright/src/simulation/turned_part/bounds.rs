// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Upper bounds of the radii, along the lines: what was cut in the turn before is passed over by them, without a look at its cells.

use super::PartGrid;
use super::cell_radii::CellRadii;
use alloc::vec::Vec;

/// Columns of a line whose largest radius is known. The edge must rise less over a chunk than it moves in a turn.
pub(super) const CHUNK: usize = 8;

/// They decide what is looked at, never what is cut: two parts are equal whatever their bounds.
#[derive(Debug, Clone)]
pub(super) struct RadiusBounds {
    /// Largest radius of every chunk, line by line (mm).
    chunks: Vec<f64>,
    per_line: usize,
    /// Upper bound of every line (mm).
    lines: Vec<f64>,
}

impl PartialEq for RadiusBounds {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl RadiusBounds {
    pub(super) fn new(grid: &PartGrid, cells: &CellRadii) -> Self {
        let per_line = grid.columns.div_ceil(CHUNK);
        let chunks = (0..grid.azimuths)
            .flat_map(|line| (0..per_line).map(move |chunk| super::largest(cells.chunk(line, chunk))))
            .collect();
        let mut bounds = Self { chunks, per_line, lines: alloc::vec![0.0; grid.azimuths] };
        (0..grid.azimuths).for_each(|line| bounds.refresh_line(line));
        bounds
    }

    /// Upper bound of the radii of a line (mm).
    pub(super) fn line_mm(&self, line: usize) -> f64 {
        self.lines[line]
    }

    /// Largest radii of the chunks of a line (mm).
    pub(super) fn chunks_mut(&mut self, line: usize) -> &mut [f64] {
        &mut self.chunks[line * self.per_line..][..self.per_line]
    }

    /// Lowers the bound of a line to the largest radius of its chunks.
    pub(super) fn refresh_line(&mut self, line: usize) {
        self.lines[line] = super::largest(self.chunks_mut(line));
    }
}
