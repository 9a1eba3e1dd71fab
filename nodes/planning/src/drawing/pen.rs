// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Pens and colours.

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Colour(pub(crate) u8, pub(crate) u8, pub(crate) u8);

impl Colour {
    pub(crate) const BLACK: Self = Self(0, 0, 0);
    pub(crate) const GREY: Self = Self(110, 110, 110);
    pub(crate) const PALE: Self = Self(222, 222, 222);

    /// The colour as a tint of white paper: `share` of it, 0 to 1.
    pub(crate) fn tint(self, share: f64) -> Self {
        #[allow(clippy::cast_possible_truncation, reason = "between 0 and 255")]
        let mixed = |value: u8| (255.0 - share * (255.0 - f64::from(value))).round() as u8;
        Self(mixed(self.0), mixed(self.1), mixed(self.2))
    }
}

/// Pattern of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Dash {
    Solid,
    Dashed,
    /// Long dashes and points: centre lines.
    Centre,
}

impl Dash {
    /// Lengths of strokes and gaps (mm).
    pub(super) fn lengths_mm(self) -> &'static [f64] {
        match self {
            Dash::Solid => &[],
            Dash::Dashed => &[1.8, 1.2],
            Dash::Centre => &[5.0, 1.2, 0.4, 1.2],
        }
    }
}

/// Colour, width and pattern of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pen {
    pub(crate) colour: Colour,
    pub(crate) width_mm: f64,
    pub(crate) dash: Dash,
}

impl Pen {
    pub(crate) const fn solid(colour: Colour, width_mm: f64) -> Self {
        Self { colour, width_mm, dash: Dash::Solid }
    }

    pub(crate) const fn dashed(colour: Colour, width_mm: f64) -> Self {
        Self { colour, width_mm, dash: Dash::Dashed }
    }
}
