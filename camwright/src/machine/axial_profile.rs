// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Radius along the axis: taper and crown of a wheel's rim, and of the lobe that it grinds.
//!
//! The rim of a wheel has the radius R + h(z), with z from the middle of the wheel towards the tailstock. Its centre is on the path for the
//! contour, so it is at the distance R from the contour. A lobe that has the profile −h keeps the distance R + h from it: at every z the
//! section of the lobe is the parallel curve of the contour at the distance −h(z). X and C move as for a straight wheel.
//!
//! A hollow flank of radius ρ has the radius ρ + h on the section at z, and the rim there R + h: where R is smaller than ρ, the rim fits every
//! section. A section inside the contour (h above 0) is the parallel curve where h is smaller than every radius of a convex flank.

use core::ops::{Add, Neg};

/// Largest taper or crown (mm); a larger one is likelier a mistyped unit.
pub const MAX_AXIAL_MM: f64 = 0.5;

/// Largest difference between the lobe that a rim grinds and that of the job, at any place of the width (mm).
pub const AXIAL_TOLERANCE_MM: f64 = 0.5e-3;

/// Difference of a radius from that in the middle of a width W: a line and a parabola.
///
/// ```text
/// h(z) = taper z/W − 4 crown z²/W²          −W/2 ≤ z ≤ W/2
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AxialProfile {
    /// Radius at the end towards the tailstock less that at the other end (mm).
    pub taper_mm: f64,
    /// Radius in the middle less the mean of both ends (mm).
    pub crown_mm: f64,
}

impl AxialProfile {
    /// The radius is the same over the width.
    #[must_use]
    pub fn is_straight(&self) -> bool {
        self.taper_mm == 0.0 && self.crown_mm == 0.0
    }

    /// Both numbers are finite and at most [`MAX_AXIAL_MM`].
    #[must_use]
    pub fn is_possible(&self) -> bool {
        [self.taper_mm, self.crown_mm].iter().all(|mm| mm.abs() <= MAX_AXIAL_MM)
    }

    /// h at a distance from the middle of a width, the end beyond it (mm).
    #[must_use]
    pub fn height_mm(&self, z_mm: f64, width_mm: f64) -> f64 {
        if self.is_straight() {
            return 0.0;
        }
        let share = (z_mm / width_mm).clamp(-0.5, 0.5);
        self.taper_mm * share - 4.0 * self.crown_mm * share * share
    }

    /// The same profile of a width, over another width with the same middle.
    #[must_use]
    pub fn over(&self, width_mm: f64, other_mm: f64) -> Self {
        let ratio = other_mm / width_mm;
        Self { taper_mm: self.taper_mm * ratio, crown_mm: self.crown_mm * ratio * ratio }
    }

    /// Largest h over the width (mm), at least 0 in its middle.
    #[must_use]
    pub fn highest_mm(&self) -> f64 {
        let at = |share: f64| self.height_mm(share, 1.0);
        let vertex = if self.crown_mm > 0.0 { at(self.taper_mm / (8.0 * self.crown_mm)) } else { 0.0 };
        at(-0.5).max(at(0.5)).max(vertex).max(0.0)
    }

    /// Largest size of h over the width (mm).
    #[must_use]
    pub fn largest_mm(&self) -> f64 {
        self.highest_mm().max((-*self).highest_mm())
    }

    /// The profile with these heights in the middles of the three thirds of the width, from the headstock on (mm).
    #[must_use]
    pub fn from_thirds([head_mm, middle_mm, tail_mm]: [f64; 3]) -> Self {
        Self { taper_mm: 1.5 * (tail_mm - head_mm), crown_mm: 2.25 * (middle_mm - 0.5 * (head_mm + tail_mm)) }
    }
}

impl Neg for AxialProfile {
    type Output = Self;

    fn neg(self) -> Self {
        Self { taper_mm: -self.taper_mm, crown_mm: -self.crown_mm }
    }
}

impl Add for AxialProfile {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { taper_mm: self.taper_mm + other.taper_mm, crown_mm: self.crown_mm + other.crown_mm }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::unit_numbers;

    /// Taper and crown are what their definitions say, and thirds recover them, for any profile and width.
    #[test]
    fn thirds_recover_taper_and_crown() {
        let mut random = unit_numbers(0x51f3_22d1);
        for _ in 0..200 {
            let profile = AxialProfile { taper_mm: random() - 0.5, crown_mm: random() - 0.5 };
            let width_mm = 1.0 + 60.0 * random();
            let at = |share: f64| profile.height_mm(share * width_mm, width_mm);
            assert!((at(0.5) - at(-0.5) - profile.taper_mm).abs() < 1e-14);
            assert!((at(0.0) - 0.5 * (at(0.5) + at(-0.5)) - profile.crown_mm).abs() < 1e-14);
            let size_mm = 3.0;
            let found = AxialProfile::from_thirds([-1.0, 0.0, 1.0].map(|third| size_mm + at(third / 3.0)));
            assert!((found.taper_mm - profile.taper_mm).abs() < 1e-12);
            assert!((found.crown_mm - profile.crown_mm).abs() < 1e-12);
            // Over another width the heights are the same.
            let other_mm = width_mm * random();
            let narrow = profile.over(width_mm, other_mm);
            let z_mm = other_mm * (random() - 0.5);
            let (one, other) = (profile.height_mm(z_mm, width_mm), narrow.height_mm(z_mm, other_mm));
            assert!((one - other).abs() < 1e-13, "{one} {other}");
            // The highest place, against many.
            let most = (-500..=500).map(|i| at(f64::from(i) / 1000.0)).fold(0.0, f64::max);
            let highest = profile.highest_mm();
            assert!(highest >= most && highest - most < 1e-5, "{highest} {most}");
            assert!((profile + -profile).is_straight());
            assert!(profile.largest_mm() >= at(0.5).abs().max(at(-0.5).abs()));
        }
    }

    #[test]
    fn impossible_profiles_are_found() {
        let taper = |taper_mm: f64| AxialProfile { taper_mm, crown_mm: 0.0 };
        assert!(taper(0.5).is_possible() && taper(-0.5).is_possible());
        for taper_mm in [0.51, -0.51, f64::NAN, f64::INFINITY] {
            assert!(!taper(taper_mm).is_possible(), "{taper_mm}");
            assert!(!AxialProfile { taper_mm: 0.0, crown_mm: taper_mm }.is_possible(), "{taper_mm}");
        }
    }
}
