// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Hollows of a section with a smaller radius than the insert.

use super::InsertPathError;
use crate::math::units::{TURN_RAD, wrap_turn};
use crate::toolpath::rake_section::RakeSection;
use alloc::vec;
use alloc::vec::Vec;

/// The tightest hollow of all sections, which the insert bridges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hollow {
    /// Turned angle θ (deg), in 0..360.
    pub turned_deg: f64,
    /// z (mm).
    pub z_mm: f64,
    /// Radius of the hollow (mm).
    pub radius_mm: f64,
    /// Required radius: the radius of the insert with its stock (mm).
    pub bound_mm: f64,
    /// Most that is left in the hollows at that angle, along x (mm).
    pub left_mm: f64,
}

/// Turned angles of a turn at which sections are looked at.
const ANGLES: u32 = 360;

/// Places along z within the insert's radius.
const PER_RADIUS: f64 = 8.0;

/// Fewest and most places along z.
const ROWS: (u32, u32) = (64, 2000);

/// From this share of the insert's curvature on a hollow counts as too tight: what lies between two places that are looked at may be
/// tighter.
const TIGHT: f64 = 0.9;

/// Hollows of the sections of a surface.
#[derive(Debug)]
pub(super) struct Hollows {
    /// For every angle the range of z within which sections are too hollow; empty where they are not.
    ranges: Vec<Option<(f64, f64)>>,
    reach_mm: f64,
    /// Turned angle (rad), z (mm) and curvature (1/mm) of the tightest.
    tightest: Option<(f64, f64, f64)>,
}

impl Hollows {
    pub(super) fn find(section: &RakeSection<'_>, reach_mm: f64) -> Result<Self, InsertPathError> {
        let (from, to) = section.range_mm();
        #[allow(clippy::cast_possible_truncation, reason = "it saturates, and is cut off")]
        let rows = (libm::ceil(PER_RADIUS * (to - from) / reach_mm) as u32).max(section.surface().looked_at().1);
        let rows = rows.clamp(ROWS.0, ROWS.1);
        let mut ranges = vec![None; ANGLES as usize];
        let mut tightest: Option<(f64, f64, f64)> = None;
        for (angle, range) in (0..ANGLES).zip(&mut ranges) {
            let turned = f64::from(angle) * TURN_RAD / f64::from(ANGLES);
            let mut before = None;
            for row in 0..=rows {
                let z = from + (to - from) * f64::from(row) / f64::from(rows);
                let point = match before {
                    Some(lead) if section.is_single() => section.checked(section.near(turned, z, lead), turned)?,
                    _ => section.point(turned, z)?,
                };
                before = Some(point.lead_rad);
                let curvature = point.hollow();
                if reach_mm * curvature < TIGHT {
                    continue;
                }
                *range = Some(range.map_or((z, z), |(low, _): (f64, f64)| (low, z)));
                if tightest.is_none_or(|(_, _, max)| curvature > max) {
                    tightest = Some((turned, z, curvature));
                }
            }
        }
        Ok(Self { ranges, reach_mm, tightest })
    }

    /// Turned angle (rad), z and radius (mm) of the tightest.
    pub(super) fn tightest(&self) -> Option<(f64, f64, f64)> {
        self.tightest.map(|(turned, z, curvature)| (turned, z, 1.0 / curvature))
    }

    /// Returns whether a hollow may be within the insert's reach.
    pub(super) fn within_reach(&self, turned_rad: f64, centre_mm: f64) -> bool {
        if self.tightest.is_none() {
            return false;
        }
        let place = wrap_turn(turned_rad) / TURN_RAD * f64::from(ANGLES);
        #[allow(clippy::cast_possible_truncation, reason = "it lies within the turn")]
        let left = place as usize % self.ranges.len();
        // Two angles on either side, for a hollow between those looked at.
        let count = self.ranges.len();
        (0..4).any(|k| {
            self.ranges[(left + count + k - 1) % count].is_some_and(|(low, high)| {
                centre_mm > low - 1.1 * self.reach_mm && centre_mm < high + 1.1 * self.reach_mm
            })
        })
    }

    /// Range of z of all hollows that are too tight (mm); `None` without one.
    pub(super) fn range_mm(&self) -> Option<(f64, f64)> {
        self.ranges.iter().flatten().copied().reduce(|(low, high), range| (low.min(range.0), high.max(range.1)))
    }
}
