// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The axes that programs drive.

use crate::toolpath::cutter_path::CarriageAxis;

/// An axis of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum NcAxis {
    /// Away from the spindle axis.
    X,
    /// Across X and the spindle axis.
    Y,
    /// Along the spindle axis.
    Z,
    C,
}

impl NcAxis {
    /// All of them, in the order in which they are written.
    pub const ALL: [NcAxis; 4] = [NcAxis::X, NcAxis::Y, NcAxis::Z, NcAxis::C];

    #[must_use]
    pub const fn letter(self) -> char {
        match self {
            NcAxis::X => 'X',
            NcAxis::Y => 'Y',
            NcAxis::Z => 'Z',
            NcAxis::C => 'C',
        }
    }

    /// Its place in [`NcAxis::ALL`].
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }
}

impl From<CarriageAxis> for NcAxis {
    fn from(axis: CarriageAxis) -> Self {
        match axis {
            CarriageAxis::X => NcAxis::X,
            CarriageAxis::Y => NcAxis::Y,
            CarriageAxis::Z => NcAxis::Z,
        }
    }
}
