// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Radii of the cells, in the order in which the insert cuts them.

use super::PartGrid;
use super::bounds::CHUNK;
use alloc::vec::Vec;

/// Radii of a part. The insert cuts neighbouring columns of one azimuth at a time, so a chunk of columns lies together.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CellRadii {
    azimuths: usize,
    columns: usize,
    /// All azimuths of the first chunk of columns first (mm). A chunk at the end is filled up with 0, which nothing cuts.
    chunks: Vec<[f64; CHUNK]>,
}

impl CellRadii {
    /// Takes radii (mm) of all cells, all azimuths of the first column first.
    pub(super) fn new(grid: &PartGrid, radii: &[f64]) -> Self {
        let PartGrid { azimuths, columns, .. } = *grid;
        let mut cells =
            Self { azimuths, columns, chunks: alloc::vec![[0.0; CHUNK]; azimuths * columns.div_ceil(CHUNK)] };
        for (index, radius) in radii.iter().enumerate() {
            *cells.cell_mut(index % azimuths, index / azimuths) = *radius;
        }
        cells
    }

    pub(super) fn len(&self) -> usize {
        self.azimuths * self.columns
    }

    /// Radius of a cell (mm).
    pub(super) fn cell(&self, azimuth: usize, column: usize) -> f64 {
        self.chunks[column / CHUNK * self.azimuths + azimuth][column % CHUNK]
    }

    pub(super) fn cell_mut(&mut self, azimuth: usize, column: usize) -> &mut f64 {
        &mut self.chunks[column / CHUNK * self.azimuths + azimuth][column % CHUNK]
    }

    /// Radii of a chunk of columns at an azimuth (mm).
    pub(super) fn chunk(&self, azimuth: usize, chunk: usize) -> &[f64; CHUNK] {
        &self.chunks[chunk * self.azimuths + azimuth]
    }

    pub(super) fn chunk_mut(&mut self, azimuth: usize, chunk: usize) -> &mut [f64; CHUNK] {
        &mut self.chunks[chunk * self.azimuths + azimuth]
    }

    /// Largest radius of a chunk of columns (mm).
    pub(super) fn largest_mm(&self, chunk: usize) -> f64 {
        super::largest(self.chunks[chunk * self.azimuths..][..self.azimuths].as_flattened())
    }

    /// Radii of a column (mm), one for every azimuth.
    pub(super) fn column(&self, column: usize) -> impl ExactSizeIterator<Item = f64> + Clone {
        let first = column / CHUNK * self.azimuths;
        self.chunks[first..first + self.azimuths].iter().map(move |chunk| chunk[column % CHUNK])
    }

    /// Radii of all cells (mm), all azimuths of the first column first.
    pub(super) fn all(&self) -> impl Iterator<Item = f64> + Clone {
        (0..self.columns).flat_map(|column| self.column(column))
    }
}
