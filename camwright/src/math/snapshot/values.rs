// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Numbers, yes or no, texts and lists.

use super::{Snapshot, SnapshotCodec, SnapshotError, SnapshotValue};
use alloc::collections::VecDeque;
use alloc::string::String;
use alloc::vec::Vec;

/// Largest whole number of a state: 285 000 years of milliseconds. Sums of a few stay far from where they overflow.
const MAX_WHOLE: u64 = 1 << 53;
/// Largest number of a state, whatever its unit.
const MAX_NUMBER: f64 = 1e15;
const MAX_TEXT: usize = 4096;

impl SnapshotCodec<'_> {
    /// Reads a value from the codec, or compares it with the codec.
    fn settle<T: Copy>(
        &self,
        own: &mut T,
        there: T,
        is_same: bool,
        value: impl Fn(T) -> SnapshotValue,
    ) -> Result<(), SnapshotError> {
        if self.is_comparing() && !is_same {
            return Err(SnapshotError::Differs { recorded: value(there), now: value(*own) });
        }
        if self.is_reading() {
            *own = there;
        }
        Ok(())
    }

    /// Sixty-four bits that are no number.
    ///
    /// # Errors
    /// Those of the walk.
    pub fn bits(&mut self, own: &mut u64) -> Result<(), SnapshotError> {
        let there = u64::from_le_bytes(self.word(own.to_le_bytes())?);
        self.settle(own, there, there == *own, |bits| SnapshotValue::Whole(bits.cast_signed()))
    }

    /// Length of a list, at most `max`; on the codec it is followed by its items.
    ///
    /// # Errors
    /// Those of the walk; a list that is too long, or longer than what is on the codec.
    pub fn count(&mut self, own: usize, max: usize) -> Result<usize, SnapshotError> {
        let mut count = own;
        count.snapshot(self)?;
        // Every item takes an octet at least.
        if count > max.min(self.left()) {
            return Err(SnapshotError::Impossible("a list is longer than it can be"));
        }
        Ok(count)
    }

    /// All numbers of a slice.
    ///
    /// # Errors
    /// Those of the walk.
    pub fn numbers(&mut self, own: &mut [f64]) -> Result<(), SnapshotError> {
        if self.left() / size_of::<f64>() < own.len() {
            return Err(SnapshotError::Ended);
        }
        if self.put_numbers(own)? {
            return Ok(());
        }
        own.iter_mut().enumerate().try_for_each(|(index, number)| self.item(index, |codec| number.snapshot(codec)))
    }

    /// A list of numbers, at most `max`.
    ///
    /// # Errors
    /// Those of the walk; a list that is too long, or longer than what is on the codec.
    pub fn list_of_numbers(&mut self, own: &mut Vec<f64>, max: usize) -> Result<(), SnapshotError> {
        let count = self.count(own.len(), max.min(self.left() / size_of::<f64>()))?;
        if self.is_reading() {
            own.clear();
            own.resize(count, 0.0);
        }
        self.numbers(own)
    }
}

/// A whole number within bounds, as eight octets.
macro_rules! whole {
    ($($type:ty, $max:expr);+ $(;)?) => { $(
        impl Snapshot for $type {
            fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
                // No state has a number that does not fit, so that nothing is cut off.
                let own = u64::try_from(*self).unwrap_or(u64::MAX);
                let there = u64::from_le_bytes(codec.word(own.to_le_bytes())?);
                let value = <$type>::try_from(there).ok().filter(|_| there <= $max);
                let value = value.ok_or(SnapshotError::Impossible("a whole number is larger than it can be"))?;
                let whole = |value: $type| SnapshotValue::Whole(i64::try_from(value).unwrap_or(i64::MAX));
                codec.settle(self, value, value == *self, whole)
            }
        }
    )+ };
}

whole! {
    u64, MAX_WHOLE;
    usize, MAX_WHOLE;
    u32, u64::from(u32::MAX >> 1);
    u16, u64::from(u16::MAX);
}

impl Snapshot for u8 {
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        let [there] = codec.word([*self])?;
        codec.settle(self, there, there == *self, |value| SnapshotValue::Whole(value.into()))
    }
}

impl Snapshot for i64 {
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        let there = i64::from_le_bytes(codec.word(self.to_le_bytes())?);
        if there.unsigned_abs() > MAX_WHOLE {
            return Err(SnapshotError::Impossible("a whole number is larger than it can be"));
        }
        codec.settle(self, there, there == *self, SnapshotValue::Whole)
    }
}

impl Snapshot for f64 {
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        let there = Self::from_le_bytes(codec.word(self.to_le_bytes())?);
        if there.is_nan() || there.abs() > MAX_NUMBER {
            return Err(SnapshotError::Impossible("a number is larger than it can be, or none"));
        }
        codec.settle(self, there, there.to_bits() == self.to_bits(), SnapshotValue::Number)
    }
}

impl SnapshotCodec<'_> {
    /// Walks through a number that may be NaN, for "not measured".
    ///
    /// # Errors
    /// A number that is larger than it can be; see [`Snapshot::snapshot`].
    pub fn measured(&mut self, own: &mut f64) -> Result<(), SnapshotError> {
        let there = f64::from_le_bytes(self.word(own.to_le_bytes())?);
        if there.abs() > MAX_NUMBER {
            return Err(SnapshotError::Impossible("a number is larger than it can be"));
        }
        self.settle(own, there, there.to_bits() == own.to_bits(), SnapshotValue::Number)
    }
}

impl Snapshot for bool {
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        let [there] = codec.word([u8::from(*self)])?;
        let there = match there {
            0 => false,
            1 => true,
            _ => return Err(SnapshotError::Impossible("neither yes nor no")),
        };
        codec.settle(self, there, there == *self, |yes| SnapshotValue::Whole(yes.into()))
    }
}

impl Snapshot for String {
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        let count = codec.count(self.len(), MAX_TEXT)?;
        if !codec.is_reading() {
            return self.bytes().try_for_each(|octet| match codec.word([octet])? {
                [there] if there == octet => Ok(()),
                _ => Err(SnapshotError::Differs { recorded: SnapshotValue::Text, now: SnapshotValue::Text }),
            });
        }
        let mut octets = Vec::with_capacity(count);
        for _ in 0..count {
            octets.extend(codec.word([0])?);
        }
        *self = Self::from_utf8(octets).map_err(|_| SnapshotError::Impossible("a text that is none"))?;
        Ok(())
    }
}

impl<T: Snapshot + Default> Snapshot for Option<T> {
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        let mut is_there = self.is_some();
        is_there.snapshot(codec)?;
        if codec.is_reading() {
            *self = is_there.then(T::default);
        }
        self.as_mut().map_or(Ok(()), |value| value.snapshot(codec))
    }
}

/// All elements of a slice.
impl<T: Snapshot> Snapshot for [T] {
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        self.iter_mut().enumerate().try_for_each(|(index, item)| codec.item(index, |codec| item.snapshot(codec)))
    }
}

impl<T: Snapshot, const N: usize> Snapshot for [T; N] {
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        self.as_mut_slice().snapshot(codec)
    }
}

impl<A: Snapshot, B: Snapshot> Snapshot for (A, B) {
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        codec.item(0, |codec| self.0.snapshot(codec))?;
        codec.item(1, |codec| self.1.snapshot(codec))
    }
}

/// A list in whose room a state is taken up: at most `max` items.
macro_rules! list {
    ($($list:ident, $push:ident, $name:ident);+ $(;)?) => { impl SnapshotCodec<'_> { $(
        /// A list with at most `max` items.
        ///
        /// # Errors
        /// Those of the walk; a list that is too long.
        pub fn $name<T: Snapshot + Default>(&mut self, own: &mut $list<T>, max: usize) -> Result<(), SnapshotError> {
            let count = self.count(own.len(), max)?;
            if self.is_reading() {
                own.clear();
                (0..count).for_each(|_| own.$push(T::default()));
            }
            own.iter_mut().enumerate().try_for_each(|(index, item)| self.item(index, |codec| item.snapshot(codec)))
        }
    )+ } };
}

list! {
    Vec, push, list;
    VecDeque, push_back, queue;
}
