// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The state of what runs, at one moment, as octets: written down, taken up again, or compared with what it is now.
//!
//! One walk through the state serves all three ([`Snapshot::snapshot`]): what is written and what is read cannot come apart, and a field that is
//! added does not compile until it is declared as state or as part of the description. What a description decides is not
//! written. Octets are little-endian and carry no names; of which form they are, who stores them has to say.
//!
//! Writing neither allocates nor fails where there is room. What is read is not trusted: every number is finite and of a size that a
//! machine can have, every index has its place.

mod codec;
mod macros;
mod values;

pub use codec::{FieldPath, SnapshotCodec, SnapshotError, SnapshotValue};

/// State that can be written and restored.
pub trait Snapshot {
    /// Goes through the whole state, field by field. See [`SnapshotCodec`] for what that does.
    ///
    /// # Errors
    /// See [`SnapshotError`]. What was being read is not to be used then.
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError>;
}
