//! What is turned, from what, and how.

use crate::cam::surface::Surface;
use crate::toolpath::insert_path::{Feed, Passes};
use alloc::string::String;

/// How fast the spindle turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TurningSpeed {
    /// As fast as the axes allow everywhere, at constant speed.
    Fastest,
    /// At this speed (rad/s).
    Constant(f64),
    /// As fast as the axes allow everywhere, faster where X works less.
    Varied,
}

/// A part to be turned that is not round.
#[derive(Debug, Clone, PartialEq)]
pub struct TurningJob {
    pub name: String,
    /// What it is to be: z along the part (mm), the tool coming from where it begins.
    pub surface: Surface,
    /// Between which z it is turned (mm); the tool begins outside the first and ends over the second.
    pub turned_mm: (f64, f64),
    /// Radius of the bar that it is turned from (mm).
    pub bar_radius_mm: f64,
    /// z of the part at which the insert's centre stands where Z is 0 (mm).
    pub part_zero_mm: f64,
    /// Passes: roughing, then finishing.
    pub passes: Passes,
    /// How the finishing pass advances.
    pub feed: Feed,
    /// Angles a turn at which the path is computed: 180 to 3600.
    pub angles: u32,
    /// Speed of the spindle.
    pub speed: TurningSpeed,
    /// How far from the bar the insert stands before it comes to the part, and after (mm).
    pub clearance_mm: f64,
    /// Speed of X there and back (mm/s).
    pub rapid_speed_mm_s: f64,
}

impl TurningJob {
    /// Between which z it is turned, the lower first (mm).
    #[must_use]
    pub fn range_mm(&self) -> (f64, f64) {
        let (from_mm, to_mm) = self.turned_mm;
        (from_mm.min(to_mm), from_mm.max(to_mm))
    }
}
