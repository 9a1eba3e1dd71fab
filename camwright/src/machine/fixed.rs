//! A short list without a heap: what a cyclic step hands back.

/// A list of at most `N` values that never allocates; what does not fit is dropped and counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedList<T, const N: usize> {
    items: [Option<T>; N],
    len: usize,
    dropped: u32,
}

impl<T: Copy, const N: usize> FixedList<T, N> {
    /// An empty list.
    #[must_use]
    pub const fn new() -> Self {
        Self { items: [None; N], len: 0, dropped: 0 }
    }

    /// Appends a value; false, and counted in [`FixedList::dropped`], when the list is full.
    pub fn push(&mut self, value: T) -> bool {
        if self.len == N {
            self.dropped = self.dropped.saturating_add(1);
            return false;
        }
        self.items[self.len] = Some(value);
        self.len += 1;
        true
    }

    /// Takes every value away.
    pub fn clear(&mut self) {
        *self = Self::new();
    }

    /// Keeps the values of which `keep` is true, in order.
    pub fn retain(&mut self, mut keep: impl FnMut(&T) -> bool) {
        let mut kept = Self { dropped: self.dropped, ..Self::new() };
        for value in self.iter().filter(|value| keep(value)) {
            kept.push(*value);
        }
        *self = kept;
    }

    /// The values, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.items[..self.len].iter().flatten()
    }

    /// Number of values.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.len
    }

    /// No value.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Number of values that did not fit.
    #[must_use]
    pub const fn dropped(&self) -> u32 {
        self.dropped
    }
}

impl<T: Copy, const N: usize> Default for FixedList<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_counted_and_the_rest_is_kept_in_order() {
        let mut list = FixedList::<u32, 2>::new();
        assert!(list.push(7) && list.push(8) && !list.push(9));
        assert!(list.iter().copied().eq([7, 8]));
        assert_eq!((list.len(), list.dropped()), (2, 1));
        list.retain(|value| *value != 7);
        assert!(list.iter().copied().eq([8]));
    }
}
