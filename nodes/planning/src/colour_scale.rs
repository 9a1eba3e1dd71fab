// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Colours of values: bands of a round width, so that a legend can name each.

use crate::chart::{Scale, round_step};

/// Red, green and blue.
pub type Rgb = [u8; 3];

/// Maximum number of bands.
const MAX_BANDS: f64 = 12.0;

/// From dark violet over green to yellow: brightness grows with the value, also in grey and for colour-blind people.
const GROWING: [Rgb; 5] = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

/// From blue over white to red: white is 0.
const SIGNED: [Rgb; 5] = [[33, 102, 172], [146, 197, 222], [247, 247, 247], [244, 165, 130], [178, 24, 43]];

/// Scale of colours over a range of values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColourScale {
    /// Range and width of the bands.
    pub scale: Scale,
    is_signed: bool,
}

impl ColourScale {
    /// Scale of values of one sign; a range narrower than `min_range` is widened to it.
    #[must_use]
    pub fn growing(values: impl Iterator<Item = f64>, min_range: f64) -> Self {
        let (low, high) = values
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        let (low, high) = if low > high { (0.0, 0.0) } else { (low, high) };
        let middle = 0.5 * (low + high);
        let half = 0.5 * (high - low).max(min_range);
        Self { scale: whole_bands(middle - half, middle + half), is_signed: false }
    }

    /// Scale around 0 that reaches as far on both sides; one narrower than `min_largest` is widened to it.
    #[must_use]
    pub fn signed(values: impl Iterator<Item = f64>, min_largest: f64) -> Self {
        let largest = values.filter(|value| value.is_finite()).map(f64::abs).fold(min_largest, f64::max);
        Self { scale: whole_bands(-largest, largest), is_signed: true }
    }

    #[must_use]
    pub fn bands(&self) -> usize {
        #[allow(clippy::cast_possible_truncation, reason = "some twelve")]
        let count = ((self.scale.high - self.scale.low) / self.scale.step).round().max(1.0) as usize;
        count
    }

    /// Band of a value; values outside belong to the band at the end.
    #[must_use]
    pub fn band(&self, value: f64) -> usize {
        #[allow(clippy::cast_possible_truncation, reason = "saturates, and is brought into the scale")]
        let band = ((value - self.scale.low) / self.scale.step).floor().max(0.0) as usize;
        band.min(self.bands() - 1)
    }

    /// Lower end of a band; that behind the last is the upper end of the scale.
    #[must_use]
    pub fn edge(&self, band: usize) -> f64 {
        // Whole multiples of the step: 3 · 0.1 is 0.30000000000000004.
        ((self.scale.low / self.scale.step).round() + band as f64) * self.scale.step
    }

    #[must_use]
    pub fn colour(&self, band: usize) -> Rgb {
        let anchors = if self.is_signed { SIGNED } else { GROWING };
        let share = if self.bands() > 1 { band as f64 / (self.bands() - 1) as f64 } else { 0.5 };
        let at = share.clamp(0.0, 1.0) * (anchors.len() - 1) as f64;
        #[allow(clippy::cast_possible_truncation, reason = "between 0 and 3")]
        let from = (at as usize).min(anchors.len() - 2);
        let between = at - from as f64;
        #[allow(clippy::cast_possible_truncation, reason = "between 0 and 255")]
        let mixed = |side: usize| {
            let (a, b) = (f64::from(anchors[from][side]), f64::from(anchors[from + 1][side]));
            (a + between * (b - a)).round() as u8
        };
        [mixed(0), mixed(1), mixed(2)]
    }
}

/// The range widened to whole bands of a round width.
fn whole_bands(low: f64, high: f64) -> Scale {
    let step = round_step(high - low, MAX_BANDS);
    let low = (low / step + 1e-9).floor() * step;
    Scale { low, high: (high / step - 1e-9).ceil() * step, step }
}

/// A colour in a light from 0 to 1.
#[must_use]
pub fn lit(colour: Rgb, light: f64) -> Rgb {
    #[allow(clippy::cast_possible_truncation, reason = "between 0 and 255")]
    let dimmed = |value: u8| (f64::from(value) * light.clamp(0.0, 1.0)).round() as u8;
    colour.map(dimmed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_have_round_edges_and_hold_all_values() {
        let scale = ColourScale::growing([18.53, 22.21].into_iter(), 0.001);
        assert!(scale.edge(0) <= 18.53 && scale.edge(scale.bands()) >= 22.21, "{scale:?}");
        assert_eq!((scale.scale.step, scale.bands()), (0.5, 8));
        assert_eq!((scale.band(18.53), scale.band(22.21), scale.band(99.0)), (0, 7, 7));
        assert_eq!((scale.colour(0), scale.colour(7)), ([68, 1, 84], [253, 231, 37]));
    }

    #[test]
    fn zero_of_a_signed_scale_is_in_its_middle() {
        let scale = ColourScale::signed([-1.0, 4.2].into_iter(), 0.1);
        assert_eq!(scale.bands() % 2, 0);
        assert!((scale.edge(scale.bands() / 2)).abs() < 1e-12, "{scale:?}");
        assert_eq!((scale.colour(0), scale.colour(scale.bands() - 1)), ([33, 102, 172], [178, 24, 43]));
    }

    /// A cylinder has one radius, a part that is not measured no value at all.
    #[test]
    fn equal_values_and_none_have_a_scale_too() {
        for values in [vec![21.0; 4], vec![], vec![f64::NAN]] {
            let scale = ColourScale::growing(values.iter().copied(), 0.01);
            assert!(scale.bands() >= 1 && scale.scale.high > scale.scale.low, "{scale:?}");
        }
    }
}
