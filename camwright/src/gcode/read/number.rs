// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Decimal numbers as they are written, without rounding.

use super::ReadFault;
use crate::math::units::from_increments;
use alloc::string::ToString;

/// Places of the unit of [`Fixed`]: one more than are read, so that a diameter can be halved.
const PLACES: u32 = 10;
const UNIT: i64 = 10_000_000_000;
/// Digits before and behind the point.
const MAX_WHOLE: i64 = 100_000_000;
const MAX_PLACES: u32 = 9;

/// A number in whole units of its tenth decimal place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) struct Fixed(i64);

impl Fixed {
    pub(super) const ZERO: Fixed = Fixed(0);

    /// A number at the beginning of a text: itself, whether it has a point, and its length.
    pub(super) fn parse(text: &str) -> Result<(Fixed, bool, usize), ReadFault> {
        let bytes = text.as_bytes();
        let signed = matches!(bytes.first(), Some(b'+' | b'-'));
        let mut length = usize::from(signed);
        let (mut whole, mut part, mut places, mut digits) = (0_i64, 0_i64, 0, 0_usize);
        let mut point = false;
        let mut fits = true;
        while let Some(byte) = bytes.get(length) {
            match byte {
                b'.' if !point => point = true,
                b'0'..=b'9' => {
                    let digit = i64::from(byte - b'0');
                    digits += 1;
                    if point {
                        places += 1;
                        fits &= places <= MAX_PLACES;
                        part = if fits { part * 10 + digit } else { 0 };
                    } else {
                        fits &= whole < MAX_WHOLE / 10;
                        whole = if fits { whole * 10 + digit } else { 0 };
                    }
                }
                _ => break,
            }
            length += 1;
        }
        if !fits || digits == 0 {
            return Err(ReadFault::Number { text: text.get(..length.max(1)).unwrap_or(text).to_string() });
        }
        let size = whole * UNIT + part * 10_i64.pow(PLACES - places);
        Ok((Fixed(if bytes[0] == b'-' { -size } else { size }), point, length))
    }

    /// A sum; it stays far below the end of the integers, for each number is below 10^18 units.
    pub(super) const fn plus(self, other: Fixed) -> Fixed {
        Fixed(self.0.saturating_add(other.0))
    }

    /// Half of it: exact, for no more than nine places are read.
    pub(super) const fn half(self) -> Fixed {
        Fixed(self.0 / 2)
    }

    pub(super) const fn is_positive(self) -> bool {
        self.0 > 0
    }

    /// The nearest number of the machine: the same that its decimal text means.
    pub(super) fn value(self) -> f64 {
        // Both numbers of the quotient must be exact for that.
        let (mut count, mut places) = (self.0, PLACES);
        while count.unsigned_abs() > 1 << 53 && places > 0 && count % 10 == 0 {
            (count, places) = (count / 10, places - 1);
        }
        from_increments(count, places)
    }

    /// It as a whole number.
    pub(super) fn whole(self) -> Option<u32> {
        (self.0 % UNIT == 0).then(|| u32::try_from(self.0 / UNIT).ok()).flatten()
    }

    /// Ten times of it as a whole number: codes like `G92.1` have one place.
    pub(super) fn tenths(self) -> Option<u32> {
        const TENTH: i64 = UNIT / 10;
        (self.0 % TENTH == 0).then(|| u32::try_from(self.0 / TENTH).ok()).flatten()
    }
}

impl core::fmt::Display for Fixed {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}", self.value())
    }
}
