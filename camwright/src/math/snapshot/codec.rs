// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The codec: where the octets of a state go to, or come from.

use super::Snapshot;
use core::fmt;
use thiserror::Error;

/// Fields within fields that a place can name; of deeper ones the outer are named.
const DEPTH: usize = 10;

/// A value that is not as it was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SnapshotValue {
    /// A whole number, a yes or no (1 or 0), a case by its number.
    Whole(i64),
    Number(f64),
    Text,
}

impl fmt::Display for SnapshotValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole(whole) => write!(f, "{whole}"),
            Self::Number(number) => write!(f, "{number:?}"),
            Self::Text => write!(f, "another text"),
        }
    }
}

/// Why a walk ended. Where, [`SnapshotCodec::place`] says.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SnapshotError {
    /// The room is too small.
    #[error("there is no room for it")]
    NoRoom,
    /// The octets end too early.
    #[error("its octets end there")]
    Ended,
    /// There are octets after the state's end.
    #[error("{octets} octets follow its end")]
    Rest { octets: usize },
    /// A value that no machine has.
    #[error("{0}")]
    Impossible(&'static str),
    /// Compared, a value is another one.
    #[error("it was {recorded}, it is {now}")]
    Differs { recorded: SnapshotValue, now: SnapshotValue },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum CodecStep {
    Field(&'static str),
    Item(usize),
}

/// Path of the current field in the state, for example `axes[1].servo.error`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FieldPath {
    steps: [CodecStep; DEPTH],
    depth: usize,
}

impl fmt::Display for FieldPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, step) in self.steps.iter().take(self.depth).enumerate() {
            match step {
                CodecStep::Field(name) if index == 0 => write!(f, "{name}")?,
                CodecStep::Field(name) => write!(f, ".{name}")?,
                CodecStep::Item(item) => write!(f, "[{item}]")?,
            }
        }
        Ok(())
    }
}

#[derive(Debug)]
enum CodecMode<'a> {
    Measuring,
    Writing(&'a mut [u8]),
    Reading(&'a [u8]),
    Comparing(&'a [u8]),
}

/// Codec that writes, reads, compares or measures a state.
#[derive(Debug)]
pub struct SnapshotCodec<'a> {
    mode: CodecMode<'a>,
    octets: usize,
    place: FieldPath,
}

impl<'a> SnapshotCodec<'a> {
    fn new(mode: CodecMode<'a>) -> Self {
        Self { mode, octets: 0, place: FieldPath { steps: [CodecStep::Item(0); DEPTH], depth: 0 } }
    }

    /// Counts the octets that a state takes.
    #[must_use]
    pub fn measuring() -> Self {
        Self::new(CodecMode::Measuring)
    }

    /// Writes a state into this room.
    #[must_use]
    pub fn writing(room: &'a mut [u8]) -> Self {
        Self::new(CodecMode::Writing(room))
    }

    /// Takes a state up from these octets.
    #[must_use]
    pub fn reading(octets: &'a [u8]) -> Self {
        Self::new(CodecMode::Reading(octets))
    }

    /// Compares a state with these octets, and leaves it as it is.
    #[must_use]
    pub fn comparing(octets: &'a [u8]) -> Self {
        Self::new(CodecMode::Comparing(octets))
    }

    #[must_use]
    pub fn octets(&self) -> usize {
        self.octets
    }

    /// Path of the current field; after an error, of the failed field.
    #[must_use]
    pub fn place(&self) -> FieldPath {
        self.place
    }

    /// Returns whether values come from the codec.
    #[must_use]
    pub fn is_reading(&self) -> bool {
        matches!(self.mode, CodecMode::Reading(_))
    }

    pub(super) fn is_comparing(&self) -> bool {
        matches!(self.mode, CodecMode::Comparing(_))
    }

    /// Octets that are still to be read or compared; as many as can be where nothing is.
    pub(super) fn left(&self) -> usize {
        match &self.mode {
            CodecMode::Measuring | CodecMode::Writing(_) => usize::MAX,
            CodecMode::Reading(octets) | CodecMode::Comparing(octets) => octets.len().saturating_sub(self.octets),
        }
    }

    /// The state is at its end, and so must be what was read.
    ///
    /// # Errors
    /// [`SnapshotError::Rest`].
    pub fn end(&self) -> Result<(), SnapshotError> {
        match self.left() {
            0 | usize::MAX => Ok(()),
            octets => Err(SnapshotError::Rest { octets }),
        }
    }

    /// Walks through a part at the end of a state that is only written while it is in use; read where there is none, it is as new.
    ///
    /// # Errors
    /// Those of the walk.
    pub fn tail<T: Snapshot + Default>(&mut self, part: &mut T, is_in_use: bool) -> Result<(), SnapshotError> {
        let is_there = match &self.mode {
            CodecMode::Measuring | CodecMode::Writing(_) => is_in_use,
            CodecMode::Reading(_) => self.left() > 0,
            CodecMode::Comparing(_) => is_in_use || self.left() > 0,
        };
        if is_there {
            return part.snapshot(self);
        }
        if self.is_reading() {
            *part = T::default();
        }
        Ok(())
    }

    /// Walks through a field with this name.
    ///
    /// # Errors
    /// Those of the walk.
    pub fn field<R>(
        &mut self,
        name: &'static str,
        walk: impl FnOnce(&mut Self) -> Result<R, SnapshotError>,
    ) -> Result<R, SnapshotError> {
        self.step(CodecStep::Field(name), walk)
    }

    /// Walks through an item of a list.
    ///
    /// # Errors
    /// Those of the walk.
    pub fn item<R>(
        &mut self,
        index: usize,
        walk: impl FnOnce(&mut Self) -> Result<R, SnapshotError>,
    ) -> Result<R, SnapshotError> {
        self.step(CodecStep::Item(index), walk)
    }

    fn step<R>(
        &mut self,
        step: CodecStep,
        walk: impl FnOnce(&mut Self) -> Result<R, SnapshotError>,
    ) -> Result<R, SnapshotError> {
        let depth = self.place.depth;
        if let Some(place) = self.place.steps.get_mut(depth) {
            *place = step;
            self.place.depth = depth + 1;
        }
        let walked = walk(self)?;
        self.place.depth = depth;
        Ok(walked)
    }

    /// A word of the state, as it stands on the codec.
    pub(super) fn word<const N: usize>(&mut self, own: [u8; N]) -> Result<[u8; N], SnapshotError> {
        let (from, to) = (self.octets, self.octets.saturating_add(N));
        let word = match &mut self.mode {
            CodecMode::Measuring => own,
            CodecMode::Writing(room) => {
                room.get_mut(from..to).ok_or(SnapshotError::NoRoom)?.copy_from_slice(&own);
                own
            }
            CodecMode::Reading(octets) | CodecMode::Comparing(octets) => {
                let there = octets.get(from..to).ok_or(SnapshotError::Ended)?;
                <[u8; N]>::try_from(there).map_err(|_| SnapshotError::Ended)?
            }
        };
        self.octets = to;
        Ok(word)
    }

    /// Numbers of the state, where they are only written or counted: thousands of them are, within a tick. False where they are not.
    pub(crate) fn put_numbers(&mut self, own: &[f64]) -> Result<bool, SnapshotError> {
        let (from, to) = (self.octets, self.octets.saturating_add(size_of_val(own)));
        match &mut self.mode {
            CodecMode::Measuring => {}
            CodecMode::Writing(room) => {
                let room = room.get_mut(from..to).ok_or(SnapshotError::NoRoom)?;
                for (octets, number) in room.as_chunks_mut().0.iter_mut().zip(own) {
                    *octets = number.to_le_bytes();
                }
            }
            CodecMode::Reading(_) | CodecMode::Comparing(_) => return Ok(false),
        }
        self.octets = to;
        Ok(true)
    }
}
