// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The part in a keyframe: outlines are read as those of a raw part are taken, then what a cut has left in addition to them.

use super::{CutRecord, Lobe, MAX_AT_STATION, Workpiece};
use crate::cam::contour::LobeCentre;
use crate::math::snapshot::{Snapshot, SnapshotCodec, SnapshotError};
use alloc::string::String;
use alloc::vec::Vec;

impl Workpiece {
    /// Goes through the part; `new` makes what a lobe keeps of its cut on this machine, and the compliance of its supports (mm/N).
    ///
    /// # Errors
    /// Those of the walk; lobes that cannot be on a machine with so many stations.
    pub(crate) fn snapshot(
        &mut self,
        codec: &mut SnapshotCodec<'_>,
        stations: usize,
        new: impl Fn() -> (Option<CutRecord>, Option<f64>),
    ) -> Result<(), SnapshotError> {
        let count = codec.count(self.lobes.len(), stations.saturating_mul(MAX_AT_STATION))?;
        if codec.is_reading() {
            self.lobes.clear();
            for index in 0..count {
                self.lobes.push(codec.item(index, |codec| Lobe::read(codec, stations, new()))?);
            }
            return Ok(());
        }
        self.lobes.iter_mut().enumerate().try_for_each(|(index, lobe)| codec.item(index, |codec| lobe.snapshot(codec)))
    }
}

/// Outline of the raw lobe. The sign of the width says whether a place follows it, and the sign of the throw whether the place is beside the
/// station: what is about the axis and at its station is written as it was before there were pins and sections.
fn snapshot_outline(
    codec: &mut SnapshotCodec<'_>,
    name: &mut String,
    station: &mut usize,
    (width_mm, offset_mm, centre): (&mut f64, &mut f64, &mut Option<LobeCentre>),
    radii: &mut Vec<f64>,
) -> Result<(), SnapshotError> {
    codec.field("name", |codec| name.snapshot(codec))?;
    codec.field("station", |codec| station.snapshot(codec))?;
    let is_placed = centre.is_some() || *offset_mm != 0.0;
    let mut marked_mm = if is_placed { -*width_mm } else { *width_mm };
    codec.field("width_mm", |codec| marked_mm.snapshot(codec))?;
    *width_mm = marked_mm.abs();
    if marked_mm < 0.0 {
        let LobeCentre { distance_mm, mut azimuth_rad } =
            centre.unwrap_or(LobeCentre { distance_mm: 0.0, azimuth_rad: 0.0 });
        let mut throw_mm = if *offset_mm == 0.0 { distance_mm } else { -distance_mm };
        codec.field("throw_mm", |codec| throw_mm.snapshot(codec))?;
        codec.field("throw_azimuth_rad", |codec| azimuth_rad.snapshot(codec))?;
        if throw_mm.is_sign_negative() {
            codec.field("offset_mm", |codec| offset_mm.snapshot(codec))?;
        }
        *centre =
            Some(LobeCentre { distance_mm: throw_mm.abs(), azimuth_rad }).filter(|centre| centre.distance_mm != 0.0);
    }
    codec.field("radii", |codec| codec.list_of_numbers(radii, usize::MAX))
}

impl Lobe {
    fn read(
        codec: &mut SnapshotCodec<'_>,
        stations: usize,
        (record, part_mm_n): (Option<CutRecord>, Option<f64>),
    ) -> Result<Self, SnapshotError> {
        let (mut name, mut station, mut width_mm, mut radii) = (String::new(), 0, 0.0, Vec::new());
        let (mut offset_mm, mut centre) = (0.0, None);
        let place = (&mut width_mm, &mut offset_mm, &mut centre);
        snapshot_outline(codec, &mut name, &mut station, place, &mut radii)?;
        if station >= stations {
            return Err(SnapshotError::Impossible("a lobe stands at no station"));
        }
        let lobe = Self::new(name, station, width_mm, radii)
            .and_then(|lobe| lobe.about(centre))
            .and_then(|lobe| lobe.beside_station(offset_mm));
        let mut lobe = lobe.map_err(|_| SnapshotError::Impossible("an outline that is none"))?;
        (lobe.record, lobe.part_mm_n) = (record, part_mm_n);
        lobe.snapshot_rest(codec)?;
        Ok(lobe)
    }

    fn snapshot_rest(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        let Self { block_reach, reach, changed, met, record, part_mm_n, .. } = self;
        codec.field("block_reach", |codec| codec.numbers(block_reach))?;
        codec.field("reach", |codec| reach.snapshot(codec))?;
        codec.field("changed", |codec| changed.snapshot(codec))?;
        codec.field("met", |codec| met.snapshot(codec))?;
        codec.field("record", |codec| record.as_mut().map_or(Ok(()), |record| record.snapshot(codec)))?;
        let Some(part_mm_n) = part_mm_n else { return Ok(()) };
        codec.field("part_mm_n", |codec| part_mm_n.snapshot(codec))?;
        match *part_mm_n >= 0.0 && part_mm_n.is_finite() {
            true => Ok(()),
            false => Err(SnapshotError::Impossible("a compliance that is none")),
        }
    }
}

impl Snapshot for Lobe {
    /// A lobe that is there; one that is read is made anew.
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        let Self { name, station, width_mm, offset_mm, centre, radii, .. } = self;
        // What else it has: `cos` and `sin`, which its number of radii decides.
        snapshot_outline(codec, name, station, (width_mm, offset_mm, centre), radii)?;
        self.snapshot_rest(codec)
    }
}
