//! Numbers, yes or no, texts and lists.

use super::{Kept, Tape, TapeError, Value};
use alloc::collections::VecDeque;
use alloc::string::String;
use alloc::vec::Vec;

/// Largest whole number of a state: 285 000 years of milliseconds. Sums of a few stay far from where they overflow.
const MAX_WHOLE: u64 = 1 << 53;
/// Largest number of a state, whatever its unit.
const MAX_NUMBER: f64 = 1e15;
const MAX_TEXT: usize = 4096;

impl Tape<'_> {
    /// What stands on the tape for a value: taken over, or held against it.
    fn settle<T: Copy>(
        &self,
        own: &mut T,
        there: T,
        is_same: bool,
        value: impl Fn(T) -> Value,
    ) -> Result<(), TapeError> {
        if self.is_comparing() && !is_same {
            return Err(TapeError::Differs { recorded: value(there), now: value(*own) });
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
    pub fn bits(&mut self, own: &mut u64) -> Result<(), TapeError> {
        let there = u64::from_le_bytes(self.word(own.to_le_bytes())?);
        self.settle(own, there, there == *own, |bits| Value::Whole(bits.cast_signed()))
    }

    /// Length of a list, at most `most`; on the tape it is followed by its items.
    ///
    /// # Errors
    /// Those of the walk; a list that is too long, or longer than what is on the tape.
    pub fn count(&mut self, own: usize, most: usize) -> Result<usize, TapeError> {
        let mut count = own;
        count.keep(self)?;
        // Every item takes an octet at least.
        if count > most.min(self.left()) {
            return Err(TapeError::Impossible("a list is longer than it can be"));
        }
        Ok(count)
    }

    /// As many numbers as there are.
    ///
    /// # Errors
    /// Those of the walk.
    pub fn numbers(&mut self, own: &mut [f64]) -> Result<(), TapeError> {
        if self.left() / size_of::<f64>() < own.len() {
            return Err(TapeError::Ended);
        }
        if self.put_numbers(own)? {
            return Ok(());
        }
        own.iter_mut().enumerate().try_for_each(|(index, number)| self.item(index, |tape| number.keep(tape)))
    }

    /// A list of numbers, at most `most`.
    ///
    /// # Errors
    /// Those of the walk; a list that is too long, or longer than what is on the tape.
    pub fn list_of_numbers(&mut self, own: &mut Vec<f64>, most: usize) -> Result<(), TapeError> {
        let count = self.count(own.len(), most.min(self.left() / size_of::<f64>()))?;
        if self.is_reading() {
            own.clear();
            own.resize(count, 0.0);
        }
        self.numbers(own)
    }
}

/// A whole number within bounds, as eight octets.
macro_rules! whole {
    ($($type:ty, $most:expr);+ $(;)?) => { $(
        impl Kept for $type {
            fn keep(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
                // No state has a number that does not fit, so that nothing is cut off.
                let own = u64::try_from(*self).unwrap_or(u64::MAX);
                let there = u64::from_le_bytes(tape.word(own.to_le_bytes())?);
                let value = <$type>::try_from(there).ok().filter(|_| there <= $most);
                let value = value.ok_or(TapeError::Impossible("a whole number is larger than it can be"))?;
                let told = |value: $type| Value::Whole(i64::try_from(value).unwrap_or(i64::MAX));
                tape.settle(self, value, value == *self, told)
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

impl Kept for u8 {
    fn keep(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
        let [there] = tape.word([*self])?;
        tape.settle(self, there, there == *self, |value| Value::Whole(value.into()))
    }
}

impl Kept for i64 {
    fn keep(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
        let there = i64::from_le_bytes(tape.word(self.to_le_bytes())?);
        if there.unsigned_abs() > MAX_WHOLE {
            return Err(TapeError::Impossible("a whole number is larger than it can be"));
        }
        tape.settle(self, there, there == *self, Value::Whole)
    }
}

impl Kept for f64 {
    fn keep(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
        let there = Self::from_le_bytes(tape.word(self.to_le_bytes())?);
        if there.is_nan() || there.abs() > MAX_NUMBER {
            return Err(TapeError::Impossible("a number is larger than it can be, or none"));
        }
        tape.settle(self, there, there.to_bits() == self.to_bits(), Value::Number)
    }
}

impl Kept for bool {
    fn keep(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
        let [there] = tape.word([u8::from(*self)])?;
        let there = match there {
            0 => false,
            1 => true,
            _ => return Err(TapeError::Impossible("neither yes nor no")),
        };
        tape.settle(self, there, there == *self, |yes| Value::Whole(yes.into()))
    }
}

impl Kept for String {
    fn keep(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
        let count = tape.count(self.len(), MAX_TEXT)?;
        if !tape.is_reading() {
            return self.bytes().try_for_each(|octet| match tape.word([octet])? {
                [there] if there == octet => Ok(()),
                _ => Err(TapeError::Differs { recorded: Value::Text, now: Value::Text }),
            });
        }
        let mut octets = Vec::with_capacity(count);
        for _ in 0..count {
            octets.extend(tape.word([0])?);
        }
        *self = Self::from_utf8(octets).map_err(|_| TapeError::Impossible("a text that is none"))?;
        Ok(())
    }
}

impl<T: Kept + Default> Kept for Option<T> {
    fn keep(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
        let mut is_there = self.is_some();
        is_there.keep(tape)?;
        if tape.is_reading() {
            *self = is_there.then(T::default);
        }
        self.as_mut().map_or(Ok(()), |value| value.keep(tape))
    }
}

/// As many as there are.
impl<T: Kept> Kept for [T] {
    fn keep(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
        self.iter_mut().enumerate().try_for_each(|(index, item)| tape.item(index, |tape| item.keep(tape)))
    }
}

impl<T: Kept, const N: usize> Kept for [T; N] {
    fn keep(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
        self.as_mut_slice().keep(tape)
    }
}

impl<A: Kept, B: Kept> Kept for (A, B) {
    fn keep(&mut self, tape: &mut Tape<'_>) -> Result<(), TapeError> {
        tape.item(0, |tape| self.0.keep(tape))?;
        tape.item(1, |tape| self.1.keep(tape))
    }
}

/// A list in whose room a state is taken up: at most `most` items.
macro_rules! list {
    ($($list:ident, $push:ident, $name:ident);+ $(;)?) => { impl Tape<'_> { $(
        /// A list with at most `most` items.
        ///
        /// # Errors
        /// Those of the walk; a list that is too long.
        pub fn $name<T: Kept + Default>(&mut self, own: &mut $list<T>, most: usize) -> Result<(), TapeError> {
            let count = self.count(own.len(), most)?;
            if self.is_reading() {
                own.clear();
                (0..count).for_each(|_| own.$push(T::default()));
            }
            own.iter_mut().enumerate().try_for_each(|(index, item)| self.item(index, |tape| item.keep(tape)))
        }
    )+ } };
}

list! {
    Vec, push, list;
    VecDeque, push_back, queue;
}
