// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A turned part in a keyframe: its radii are read as those of a raw part are taken.

use super::cell_radii::CellRadii;
use super::{PartGrid, TurnedPart};
use crate::math::snapshot::{Snapshot, SnapshotCodec, SnapshotError};
use alloc::string::String;
use alloc::vec::Vec;

crate::snapshot!(PartGrid { azimuths, columns, from_mm, to_mm } on {});

/// Cells that are written at a time.
const WRITTEN: usize = 64;

/// Walks through the radii of a part that is written or compared.
fn snapshot_radii(codec: &mut SnapshotCodec<'_>, cells: &CellRadii) -> Result<(), SnapshotError> {
    codec.count(cells.len(), super::MAX_CELLS)?;
    let (mut all, mut first) = (cells.all(), 0);
    while first < cells.len() {
        let (mut some, count) = ([0.0; WRITTEN], WRITTEN.min(cells.len() - first));
        some.iter_mut().zip(all.by_ref().take(count)).for_each(|(some, radius)| *some = radius);
        if !codec.put_numbers(&some[..count])? {
            let mut items = (first..).zip(&mut some[..count]);
            items.try_for_each(|(index, radius)| codec.item(index, |codec| radius.snapshot(codec)))?;
        }
        first += count;
    }
    Ok(())
}

impl TurnedPart {
    pub(crate) fn read(codec: &mut SnapshotCodec<'_>) -> Result<Self, SnapshotError> {
        let (mut name, mut radii) = (String::new(), Vec::new());
        let mut grid = PartGrid { azimuths: 0, columns: 0, from_mm: 0.0, to_mm: 0.0 };
        codec.field("name", |codec| name.snapshot(codec))?;
        codec.field("grid", |codec| grid.snapshot(codec))?;
        codec.field("radii", |codec| codec.list_of_numbers(&mut radii, super::MAX_CELLS))?;
        let part = Self::new(name, grid, radii);
        let mut part = part.map_err(|_| SnapshotError::Impossible("a turned part that is none"))?;
        part.snapshot_rest(codec)?;
        Ok(part)
    }

    fn snapshot_rest(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        let Self { raw_reach, min, reach, refresh, changed, grid, .. } = self;
        codec.field("raw_reach", |codec| raw_reach.snapshot(codec))?;
        codec.field("least", |codec| min.snapshot(codec))?;
        codec.field("reach", |codec| reach.snapshot(codec))?;
        codec.field("refresh", |codec| refresh.snapshot(codec))?;
        codec.field("changed", |codec| changed.snapshot(codec))?;
        if refresh.0 >= grid.columns {
            return Err(SnapshotError::Impossible("there is no such column"));
        }
        Ok(())
    }
}

impl Snapshot for TurnedPart {
    /// A part that is there; one that is read is made anew.
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        let Self { name, grid, cells, .. } = self;
        // What else it has: `cos` and `sin`, which its grid decides.
        codec.field("name", |codec| name.snapshot(codec))?;
        codec.field("grid", |codec| grid.snapshot(codec))?;
        codec.field("radii", |codec| snapshot_radii(codec, cells))?;
        self.snapshot_rest(codec)
    }
}
