//! The part in a keyframe: outlines are read as those of a raw part are taken, then what a cut has left besides them.

use super::{CutRecord, Lobe, Workpiece};
use crate::math::snapshot::{Kept, Tape, TapeError};
use alloc::string::String;
use alloc::vec::Vec;

impl Workpiece {
    /// Goes through the part; `record` makes what a lobe keeps of its cut on this machine.
    ///
    /// # Errors
    /// Those of the walk; lobes that cannot be on a machine with so many stations.
    pub(crate) fn keep(
        &mut self,
        tape: &mut Tape<'_>,
        stations: usize,
        record: impl Fn() -> Option<CutRecord>,
    ) -> Result<(), TapeError> {
        let count = tape.count(self.lobes.len(), stations)?;
        if tape.is_reading() {
            self.lobes.clear();
            for index in 0..count {
                self.lobes.push(tape.item(index, |tape| Lobe::read(tape, stations, record()))?);
            }
            return Ok(());
        }
        self.lobes.iter_mut().enumerate().try_for_each(|(index, lobe)| tape.item(index, |tape| lobe.keep(tape)))
    }
}

/// What a raw lobe is made from.
fn keep_outline(
    tape: &mut Tape<'_>,
    name: &mut String,
    station: &mut usize,
    width_mm: &mut f64,
    radii: &mut Vec<f64>,
) -> Result<(), TapeError> {
    tape.field("name", |tape| name.keep(tape))?;
    tape.field("station", |tape| station.keep(tape))?;
    tape.field("width_mm", |tape| width_mm.keep(tape))?;
    tape.field("radii", |tape| tape.list_of_numbers(radii, usize::MAX))
}

impl Lobe {
    fn read(tape: &mut Tape<'_>, stations: usize, record: Option<CutRecord>) -> Result<Self, TapeError> {
        let (mut name, mut station, mut width_mm, mut radii) = (String::new(), 0, 0.0, Vec::new());
        keep_outline(tape, &mut name, &mut station, &mut width_mm, &mut radii)?;
        if station >= stations {
            return Err(TapeError::Impossible("a lobe stands at no station"));
        }
        let lobe = Self::new(name, station, width_mm, radii);
        let mut lobe = lobe.map_err(|_| TapeError::Impossible("an outline that is none"))?;
        lobe.record = record;
        lobe.keep_rest(tape)?;
        Ok(lobe)
    }

    fn keep_rest(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
        let Self { block_reach, reach, changed, met, record, .. } = self;
        tape.field("block_reach", |tape| tape.numbers(block_reach))?;
        tape.field("reach", |tape| reach.keep(tape))?;
        tape.field("changed", |tape| changed.keep(tape))?;
        tape.field("met", |tape| met.keep(tape))?;
        tape.field("record", |tape| record.as_mut().map_or(Ok(()), |record| record.keep(tape)))
    }
}

impl Kept for Lobe {
    /// A lobe that is there; one that is read is made anew.
    fn keep(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
        let Self { name, station, width_mm, radii, .. } = self;
        // What else it has: `cos` and `sin`, which its number of radii decides.
        keep_outline(tape, name, station, width_mm, radii)?;
        self.keep_rest(tape)
    }
}
