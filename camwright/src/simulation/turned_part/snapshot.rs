//! A turned part in a keyframe: its radii are read as those of a raw part are taken.

use super::{PartGrid, TurnedPart};
use crate::math::snapshot::{Snapshot, SnapshotCodec, SnapshotError};
use alloc::string::String;
use alloc::vec::Vec;

crate::snapshot!(PartGrid { azimuths, columns, from_mm, to_mm } on {});

fn snapshot_cells(
    codec: &mut SnapshotCodec<'_>,
    name: &mut String,
    grid: &mut PartGrid,
    radii: &mut Vec<f64>,
) -> Result<(), SnapshotError> {
    codec.field("name", |codec| name.snapshot(codec))?;
    codec.field("grid", |codec| grid.snapshot(codec))?;
    codec.field("radii", |codec| codec.list_of_numbers(radii, super::MAX_CELLS))
}

impl TurnedPart {
    pub(crate) fn read(codec: &mut SnapshotCodec<'_>) -> Result<Self, SnapshotError> {
        let (mut name, mut radii) = (String::new(), Vec::new());
        let mut grid = PartGrid { azimuths: 0, columns: 0, from_mm: 0.0, to_mm: 0.0 };
        snapshot_cells(codec, &mut name, &mut grid, &mut radii)?;
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
        let Self { name, grid, radii, .. } = self;
        // What else it has: `cos` and `sin`, which its grid decides.
        snapshot_cells(codec, name, grid, radii)?;
        self.snapshot_rest(codec)
    }
}
