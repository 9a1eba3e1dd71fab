// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Grooves in which a roller runs, and the paths of end mills that cut them.
//!
//! The roller's centre runs on the pitch curve, and the walls lie a roller's radius to either side of it. A mill of that radius runs on
//! the pitch curve itself, one that is smaller beside it, once along each wall, and in between as often as it takes to leave nothing:
//!
//! ```text
//!   ───────────────────── wall
//!     ( mill )                    P + (rr − rc) N
//!   · · · · · · · · · · · pitch curve P
//!               ( mill )          P − (rr − rc) N
//!   ───────────────────── wall
//! ```
//!
//! In the face of a plate ([`plate`]) that is exact at every depth. On a cylinder ([`barrel`]) the normal N turns with the radius, and a
//! mill that is smaller than the roller leaves something at most radii, which is computed. There a groove may run over several turns and
//! cross itself, or have two ends beyond the end faces ([`course`]); ribs remain between its turns ([`rib`]).

pub mod barrel;
pub mod course;
mod open_path;
pub mod plate;
pub mod rib;
pub mod wall_error;

use crate::cam::contour::ContourError;
use crate::toolpath::wheel_path::ToolPathError;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use thiserror::Error;

/// Which of a groove's walls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wall {
    /// In a plate the one nearer to the axis, on a cylinder the one towards −Z.
    Inner,
    /// In a plate the one farther from the axis, on a cylinder the one towards +Z.
    Outer,
}

impl Wall {
    pub const BOTH: [Wall; 2] = [Wall::Inner, Wall::Outer];

    /// On which side of the pitch curve it lies, along its normal.
    #[must_use]
    pub const fn side(self) -> f64 {
        match self {
            Wall::Inner => -1.0,
            Wall::Outer => 1.0,
        }
    }

    /// Name in a plate, for people.
    #[must_use]
    pub const fn name_in_plate(self) -> &'static str {
        match self {
            Wall::Inner => "inner wall",
            Wall::Outer => "outer wall",
        }
    }

    /// Name on a cylinder, for people.
    #[must_use]
    pub const fn name_on_cylinder(self) -> &'static str {
        match self {
            Wall::Inner => "wall towards -Z",
            Wall::Outer => "wall towards +Z",
        }
    }
}

/// Which paths of a groove are wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coverage {
    /// All that it takes to leave nothing between the walls, from the inner one to the outer.
    Slot,
    /// Those along the walls.
    Walls,
}

/// Why a groove cannot be, or cannot be cut.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum GrooveError {
    /// A follower that runs in no groove.
    #[error("a groove guides a roller, on a slide or on an arm; this follower is none")]
    NoRoller,
    /// A number that is out of its range.
    #[error("{what} is {value} mm, it must be {bound}")]
    BadNumber {
        what: &'static str,
        /// Its value (mm).
        value: f64,
        /// Condition that it violates.
        bound: &'static str,
    },
    /// The pitch curve bends more tightly than the roller is round.
    #[error(
        "the groove is undercut at its {wall}, at cam angle {angle_deg:.2} deg, {from_axis_mm:.3} mm from the axis: the pitch curve has a radius of \
         curvature of {slot_radius_mm:.3} mm there, it must be above {bound_mm:.3} mm"
    )]
    Undercut {
        wall: &'static str,
        /// Cam angle (deg).
        angle_deg: f64,
        /// Distance from the axis (mm).
        from_axis_mm: f64,
        /// Radius of curvature of the pitch curve (mm).
        slot_radius_mm: f64,
        /// Lower bound, exclusive (mm): the roller's radius, on a cylinder a little more.
        bound_mm: f64,
    },
    /// A number of turns that is none.
    #[error("a groove runs over {turns} turns; 1 to {max} are allowed")]
    TurnCount { turns: u32, max: u32 },
    /// A program that closes, for a groove with ends.
    #[error("the lift of an open groove has two ends; this one closes")]
    NoEnds,
    /// A turret that turns its roller to the side of the barrel or behind itself.
    #[error(
        "the turret turns its roller to {angle_deg:.3} deg from the line through both axes; it must stay below {max_deg:.0} deg on either side"
    )]
    TurretTurnsAway {
        /// Angle of the turret (deg).
        angle_deg: f64,
        /// Bound (deg).
        max_deg: f64,
    },
    /// A turret without rollers.
    #[error("a turret has at least one station")]
    NoStations,
    /// Turns of an indexing groove that do not fit the spacing of the rollers.
    #[error(
        "the lift turns the turret by {turned_deg:.6} deg from azimuth {azimuth_deg:.2} deg to the same place a turn later; with {stations} \
         stations it must be a multiple of {station_deg:.6} deg other than 0"
    )]
    Stations {
        /// Angle of the turret over a turn (deg).
        turned_deg: f64,
        /// Azimuth (deg).
        azimuth_deg: f64,
        stations: u32,
        /// Angle from roller to roller (deg).
        station_deg: f64,
    },
    /// A roller of a turret that stands in no groove.
    #[error(
        "at azimuth {angle_deg:.2} deg the neighbouring roller stands inside the cylinder at {roller_deg:.4} deg of the turret, where no groove \
         is; the rollers are {station_deg:.4} deg apart: shorten the cylinder, or add the groove of that roller"
    )]
    NoGroove {
        /// Azimuth along the groove (deg).
        angle_deg: f64,
        /// Angle of the neighbouring roller (deg).
        roller_deg: f64,
        /// Angle from roller to roller (deg).
        station_deg: f64,
    },
    /// A groove that crosses itself and may not.
    #[error(
        "the groove crosses itself at azimuth {angle_deg:.2} deg, where its follower loses both walls; `may_cross: true` allows that for a long \
         follower"
    )]
    Crosses {
        /// Azimuth of the first crossing (deg).
        angle_deg: f64,
    },
    /// A roller that moves across on a machine that cannot.
    #[error("the roller of a turret moves across the part; this takes a machine with a Y axis (y_axis: true)")]
    TurretNeedsY,
    /// A roller that leaves the cylinder sideways.
    #[error(
        "at azimuth {angle_deg:.2} deg the roller stands {beside_mm:.3} mm beside the radial line, where the cylinder of radius \
         {outer_radius_mm} mm ends {surface_mm:.3} mm from the axis; the floor of radius {floor_radius_mm} mm must lie below that"
    )]
    BesideCylinder {
        /// Azimuth (deg).
        angle_deg: f64,
        /// Y of the roller's centre (mm).
        beside_mm: f64,
        /// Radius of the cylinder (mm).
        outer_radius_mm: f64,
        /// X at which the cylinder ends there (mm).
        surface_mm: f64,
        /// Radius of the floor (mm).
        floor_radius_mm: f64,
    },
    /// Neighbouring turns of a groove, or neighbouring grooves, that leave no rib between them and do not cross.
    #[error(
        "the rib between {turns} vanishes at azimuth {angle_deg:.2} deg: their centres come within {distance_mm:.3} mm of each other on the \
         floor without a crossing; a rib needs more than {bound_mm:.3} mm, the width of the groove"
    )]
    NoRib {
        /// The neighbours, for people.
        turns: String,
        /// Azimuth along the first of them (deg).
        angle_deg: f64,
        /// Distance of the pitch curves (mm).
        distance_mm: f64,
        /// Distance at which the rib vanishes (mm).
        bound_mm: f64,
    },
    /// An open groove of a cylinder whose faces are unknown.
    #[error("an open groove begins and ends beyond the end faces of the cylinder, which are unknown")]
    NoFaces,
    /// A closed groove that leaves the cylinder.
    #[error(
        "the groove leaves the cylinder: its walls reach from Z {low_mm:.3} to {high_mm:.3} mm, the end faces lie at {from_mm} and {to_mm} mm; a \
         closed groove stays between them"
    )]
    LeavesCylinder {
        /// Lowest and highest Z of the walls (mm).
        low_mm: f64,
        high_mm: f64,
        /// End faces (mm).
        from_mm: f64,
        to_mm: f64,
    },
    /// An open groove with an end inside the cylinder.
    #[error(
        "the open groove {end} at Z {z_mm:.3} mm, inside the cylinder or too near to it: the end faces lie at {from_mm} and {to_mm} mm, and the \
         mill comes down and retracts beyond them, at most at Z {below_mm:.3} or at least at Z {above_mm:.3} mm"
    )]
    EndsInside {
        /// `begins` or `ends`.
        end: &'static str,
        /// Z of the roller's centre there (mm).
        z_mm: f64,
        /// End faces (mm).
        from_mm: f64,
        to_mm: f64,
        /// Z of a mill beyond the faces (mm).
        below_mm: f64,
        above_mm: f64,
    },
    /// The inner wall is no contour.
    #[error("the inner wall of the groove: {0}")]
    InnerWall(#[from] ContourError),
    /// A mill that does not go into the slot.
    #[error(
        "a mill of radius {cutter_radius_mm} mm does not go into the groove, whose half width is {half_width_mm} mm with what is to be left on \
         its walls"
    )]
    CutterTooLarge {
        /// Radius of the mill (mm).
        cutter_radius_mm: f64,
        /// Half the width of the groove less what is left on a wall (mm).
        half_width_mm: f64,
    },
    /// A mill that would have to go round far too often.
    #[error(
        "a mill of radius {cutter_radius_mm} mm needs {paths} paths beside each other in a groove of half width {half_width_mm} mm; at most \
         {max} are allowed"
    )]
    CutterTooSmall {
        /// Radius of the mill (mm).
        cutter_radius_mm: f64,
        /// Half the width of the groove less what is left on a wall (mm).
        half_width_mm: f64,
        /// Paths it would take.
        paths: f64,
        /// Most that are allowed.
        max: u32,
    },
    /// A path that is not smooth enough, or not confirmed on its way back.
    #[error(transparent)]
    Path(#[from] ToolPathError),
}

/// Radii that differ by no more than this are the same (mm).
const SAME_MM: f64 = 1e-9;

/// Most paths beside each other.
const MAX_PATHS: u32 = 64;

/// Distance of neighbouring paths in diameters of the mill. What is missing to 1 makes up for rotation taking the place of a shift, which
/// is wider at larger radii.
const STEP_OVER: f64 = 0.75;

/// A number that must be positive.
fn positive(what: &'static str, value: f64) -> Result<f64, GrooveError> {
    let good = value.is_finite() && value > 0.0;
    if good { Ok(value) } else { Err(GrooveError::BadNumber { what, value, bound: "a positive number" }) }
}

/// Paths of a mill in a slot: how far each lies from the pitch curve along its normal (mm), with its name.
fn side_by_side(
    roller_radius_mm: f64,
    cutter_radius_mm: f64,
    leaves_mm: f64,
    coverage: Coverage,
    name: fn(Wall) -> &'static str,
) -> Result<Vec<(String, f64)>, GrooveError> {
    positive("the radius of the mill", cutter_radius_mm)?;
    if !leaves_mm.is_finite() || leaves_mm < 0.0 {
        let (what, bound) = ("what is left on the walls", "0 or more");
        return Err(GrooveError::BadNumber { what, value: leaves_mm, bound });
    }
    let half_width_mm = roller_radius_mm - leaves_mm;
    let beside_mm = half_width_mm - cutter_radius_mm;
    if beside_mm < -SAME_MM {
        return Err(GrooveError::CutterTooLarge { cutter_radius_mm, half_width_mm });
    }
    if beside_mm <= SAME_MM {
        return Ok([("groove".to_string(), 0.0)].into());
    }
    let paths = libm::ceil(beside_mm / (STEP_OVER * cutter_radius_mm)).max(1.0) + 1.0;
    if coverage == Coverage::Slot && paths > f64::from(MAX_PATHS) {
        return Err(GrooveError::CutterTooSmall { cutter_radius_mm, half_width_mm, paths, max: MAX_PATHS });
    }
    let mut offsets = Vec::new();
    offsets.push((name(Wall::Inner).to_string(), -beside_mm));
    if coverage == Coverage::Slot {
        for between in (1..MAX_PATHS).take_while(|between| f64::from(*between) < paths - 1.0) {
            let share = f64::from(between) / (paths - 1.0);
            offsets.push((format!("between {between}"), beside_mm * (2.0 * share - 1.0)));
        }
    }
    offsets.push((name(Wall::Outer).to_string(), beside_mm));
    Ok(offsets)
}
