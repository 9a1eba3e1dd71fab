//! A turned part in a keyframe: its radii are read as those of a raw part are taken.

use super::{PartGrid, TurnedPart};
use crate::math::snapshot::{Kept, Tape, TapeError};
use alloc::string::String;
use alloc::vec::Vec;

crate::kept!(PartGrid { azimuths, columns, from_mm, to_mm } on {});

fn keep_cells(
    tape: &mut Tape<'_>,
    name: &mut String,
    grid: &mut PartGrid,
    radii: &mut Vec<f64>,
) -> Result<(), TapeError> {
    tape.field("name", |tape| name.keep(tape))?;
    tape.field("grid", |tape| grid.keep(tape))?;
    tape.field("radii", |tape| tape.list_of_numbers(radii, super::MAX_CELLS))
}

impl TurnedPart {
    pub(crate) fn read(tape: &mut Tape<'_>) -> Result<Self, TapeError> {
        let (mut name, mut radii) = (String::new(), Vec::new());
        let mut grid = PartGrid { azimuths: 0, columns: 0, from_mm: 0.0, to_mm: 0.0 };
        keep_cells(tape, &mut name, &mut grid, &mut radii)?;
        let part = Self::new(name, grid, radii);
        let mut part = part.map_err(|_| TapeError::Impossible("a turned part that is none"))?;
        part.keep_rest(tape)?;
        Ok(part)
    }

    fn keep_rest(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
        let Self { raw_reach, least, reach, refresh, changed, grid, .. } = self;
        tape.field("raw_reach", |tape| raw_reach.keep(tape))?;
        tape.field("least", |tape| least.keep(tape))?;
        tape.field("reach", |tape| reach.keep(tape))?;
        tape.field("refresh", |tape| refresh.keep(tape))?;
        tape.field("changed", |tape| changed.keep(tape))?;
        if refresh.0 >= grid.columns {
            return Err(TapeError::Impossible("there is no such column"));
        }
        Ok(())
    }
}

impl Kept for TurnedPart {
    /// A part that is there; one that is read is made anew.
    fn keep(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
        let Self { name, grid, radii, .. } = self;
        // What else it has: `cos` and `sin`, which its grid decides.
        keep_cells(tape, name, grid, radii)?;
        self.keep_rest(tape)
    }
}
