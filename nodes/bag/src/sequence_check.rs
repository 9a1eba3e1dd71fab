// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The numbers of one topic's messages: which is new, which fills a gap, which has come before.

use std::collections::BTreeSet;

/// Result for a sequence number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SequenceCheck {
    /// The message is new; so many before it are missing.
    New(u32),
    /// The message was missing.
    Missed,
    /// The message has come before.
    Again,
}

/// The numbers so far, from 1 on. Messages with the number 0 are not numbered and always new.
#[derive(Debug, Clone, Default)]
pub(super) struct Numbers {
    largest: u32,
    /// From and to of those that were omitted.
    left_out: BTreeSet<(u32, u32)>,
}

impl Numbers {
    /// The largest number so far; 0 where none came.
    pub(super) fn largest(&self) -> u32 {
        self.largest
    }

    /// Checks the number of the next message. Messages missing before the first one are not reported: a file may begin
    /// anywhere.
    pub(super) fn check(&mut self, number: u32) -> SequenceCheck {
        if number > self.largest {
            let before = std::mem::replace(&mut self.largest, number);
            let missing = if before == 0 { 0 } else { number - before - 1 };
            if missing > 0 {
                self.left_out.insert((before + 1, number - 1));
            }
            return SequenceCheck::New(missing);
        }
        if number == 0 {
            return SequenceCheck::New(0);
        }
        // Gaps do not overlap, so that only the last one that begins at or before the number can hold it.
        let gap = self.left_out.range(..=(number, u32::MAX)).next_back().copied();
        let Some((from, to)) = gap.filter(|(_, to)| number <= *to) else { return SequenceCheck::Again };
        self.left_out.remove(&(from, to));
        self.left_out.extend([(from, number - 1), (number + 1, to)].iter().filter(|(from, to)| from <= to));
        SequenceCheck::Missed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_and_late_messages_are_reported_once() {
        let mut numbers = Numbers::default();
        let checked = [5, 6, 10, 8, 8, 7, 9, 6, 11, 0, 0, u32::MAX].map(|number| numbers.check(number));
        use SequenceCheck::{Again, Missed, New};
        let expected =
            [New(0), New(0), New(3), Missed, Again, Missed, Missed, Again, New(0), New(0), New(0), New(u32::MAX - 12)];
        assert_eq!(checked, expected);
    }
}
