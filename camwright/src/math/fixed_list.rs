// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A list of fixed capacity: what a cyclic step hands out, since it must not allocate.

use crate::math::snapshot::{Snapshot, SnapshotCodec, SnapshotError};
use core::ops::Deref;

/// At most `N` values, in the order in which they were pushed.
#[derive(Debug, Clone, Copy)]
pub struct FixedList<T, const N: usize> {
    values: [T; N],
    len: usize,
}

impl<T: Snapshot, const N: usize> Snapshot for FixedList<T, N> {
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        let len = codec.count(self.len, N)?;
        if codec.is_reading() {
            self.len = len;
        }
        self.values
            .iter_mut()
            .take(len)
            .enumerate()
            .try_for_each(|(i, value)| codec.item(i, |codec| value.snapshot(codec)))
    }
}

impl<T: Copy + Default, const N: usize> FixedList<T, N> {
    /// A list without values.
    #[must_use]
    pub fn new() -> Self {
        Self { values: [T::default(); N], len: 0 }
    }

    /// Appends a value; `false` if the list is full and the value was not taken.
    pub fn push(&mut self, value: T) -> bool {
        self.insert(self.len, value)
    }

    /// Inserts a value before position `index`, at most the length; `false` if the list is full.
    pub fn insert(&mut self, index: usize, value: T) -> bool {
        if self.is_full() || index > self.len {
            return false;
        }
        self.values.copy_within(index..self.len, index + 1);
        self.values[index] = value;
        self.len += 1;
        true
    }

    /// Removes the first `count` values.
    pub fn remove_first(&mut self, count: usize) {
        let count = count.min(self.len);
        self.values.copy_within(count..self.len, 0);
        self.len -= count;
    }

    /// No room for another value.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.len == N
    }
}

impl<T: Copy + Default, const N: usize> Default for FixedList<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T, const N: usize> Deref for FixedList<T, N> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.values[..self.len]
    }
}

impl<T: PartialEq, const N: usize> PartialEq for FixedList<T, N> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_keep_their_order_and_a_full_list_takes_no_more() {
        let mut list = FixedList::<u8, 3>::new();
        assert!(list.push(1) && list.push(3) && list.insert(1, 2) && !list.push(4));
        assert_eq!(&*list, [1, 2, 3]);
        list.remove_first(2);
        assert_eq!(&*list, [3]);
    }
}
