// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Turning job: surface, bar and passes.

use crate::cam::surface::Surface;
use crate::toolpath::insert_path::{InsertFeed, Passes};
use alloc::string::String;

/// Speed of the spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TurningSpeed {
    /// The fastest constant speed that the axes allow everywhere.
    Fastest,
    /// At this speed (rad/s).
    Constant(f64),
    /// The fastest speed that the axes allow at each angle, faster where X works less.
    Varied,
}

impl TurningSpeed {
    /// Returns whether the job states the speed.
    #[must_use]
    pub fn is_stated(&self) -> bool {
        matches!(self, Self::Constant(_))
    }
}

/// A part to be turned that is not round.
#[derive(Debug, Clone, PartialEq)]
pub struct TurningJob {
    pub name: String,
    /// Nominal surface: z along the part (mm), the tool coming from its start.
    pub surface: Surface,
    /// Between which z it is turned (mm); the tool begins outside the first and ends over the second.
    pub turned_mm: (f64, f64),
    /// Radius of the bar that it is turned from (mm).
    pub bar_radius_mm: f64,
    /// z of the part at which the insert's centre stands where Z is 0 (mm).
    pub part_zero_mm: f64,
    /// Passes: roughing, then finishing.
    pub passes: Passes,
    /// Feed of the finishing pass.
    pub feed: InsertFeed,
    /// Angles a turn at which the path is computed: 180 to 3600.
    pub angles: u32,
    /// Speed of the spindle.
    pub speed: TurningSpeed,
    /// Distance of the insert from the bar before and after the cut (mm).
    pub clearance_mm: f64,
    /// Speed of X there and back (mm/s).
    pub rapid_speed_mm_s: f64,
}

impl TurningJob {
    /// X of the centre of an insert of a radius (mm) clear of the bar (mm).
    #[must_use]
    pub fn clear_mm(&self, insert_radius_mm: f64) -> f64 {
        self.bar_radius_mm + insert_radius_mm + self.clearance_mm
    }

    /// Between which z it is turned, the lower first (mm).
    #[must_use]
    pub fn range_mm(&self) -> (f64, f64) {
        let (from_mm, to_mm) = self.turned_mm;
        (from_mm.min(to_mm), from_mm.max(to_mm))
    }
}
