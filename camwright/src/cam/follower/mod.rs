// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Followers of a cam.

pub(crate) mod frame;
pub(crate) mod mount;
pub(crate) mod touch;

use thiserror::Error;

/// The follower for which a lift is specified. The cam angle φ is the azimuth, seen from the cam, of the line along which
/// a sliding follower moves, or of the pivot of an oscillating one. An offset is the distance of that line from the cam's
/// axis, positive in the direction of increasing cam angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Follower {
    /// A point on a slide.
    KnifeEdge {
        /// Distance of its line from the cam's axis (mm).
        offset_mm: f64,
    },
    /// A roller on a slide.
    Roller {
        /// Radius (mm).
        radius_mm: f64,
        /// Distance of its line from the cam's axis (mm).
        offset_mm: f64,
    },
    /// A round face on a slide, its centre of curvature on the line through the cam's axis: for the contour the same as a
    /// roller of that radius without offset.
    Mushroom {
        /// Radius of the face (mm).
        radius_mm: f64,
    },
    /// A flat face square to its slide; an offset of its stem changes nothing.
    Flat,
    /// A roller on an arm that swings about a pivot.
    OscillatingRoller {
        /// Radius (mm).
        radius_mm: f64,
        /// Length of the arm, pivot to roller centre (mm).
        arm_mm: f64,
        /// Pivot of the arm.
        pivot: Pivot,
    },
    /// A flat face on an arm that swings about a pivot.
    OscillatingFlat {
        /// Distance of the face's plane from the pivot (mm), positive where the pivot lies on the cam's side of it.
        face_offset_mm: f64,
        /// Pivot of the arm.
        pivot: Pivot,
    },
}

/// The pivot of an oscillating follower.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pivot {
    /// Distance from the cam's axis (mm).
    pub distance_mm: f64,
    /// To which side of it the arm reaches.
    pub side: ArmSide,
    /// Meaning of the lift values.
    pub lift: SwingLift,
}

/// To which side of its pivot an arm reaches, seen from the cam.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ArmSide {
    /// In the direction of increasing cam angle.
    Ahead,
    Behind,
}

impl Follower {
    /// The numbers of its lift are lengths (mm), not angles.
    #[must_use]
    pub fn lift_is_length(&self) -> bool {
        match self {
            Follower::OscillatingRoller { pivot, .. } | Follower::OscillatingFlat { pivot, .. } => {
                pivot.lift != SwingLift::Degrees
            }
            _ => true,
        }
    }
}

/// Meaning of the lift values of an oscillating follower: swing of the arm away from the cam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SwingLift {
    /// The angle in degrees. The one angle inside that is not in rad: a table is read within half a digit of what it
    /// prints, and it prints degrees.
    Degrees,
    /// The arc (mm) of a point of the arm.
    Arc {
        /// Distance of that point from the pivot (mm).
        radius_mm: f64,
    },
}

/// Why a follower cannot ride on a cam.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FollowerError {
    /// A roller without a radius.
    #[error("roller radius {radius_mm} mm is not a positive number")]
    BadRadius {
        /// Given value (mm).
        radius_mm: f64,
    },
    /// The line of the follower misses the prime circle.
    #[error("follower offset {offset_mm} mm is not within the prime radius of {prime_radius_mm} mm")]
    OffsetTooLarge {
        /// Offset (mm).
        offset_mm: f64,
        /// Base radius and roller radius (mm).
        prime_radius_mm: f64,
    },
    /// A number of the follower is out of its range.
    #[error("{what} {value} mm is not {bound}")]
    BadNumber {
        what: &'static str,
        /// Given value (mm).
        value: f64,
        /// Condition that it violates.
        bound: &'static str,
    },
    /// The roller cannot lie on the base circle.
    #[error(
        "an arm of {arm_mm} mm about a pivot {pivot_mm} mm from the cam's axis cannot hold the roller at the prime radius \
         of {prime_radius_mm} mm, which must be above {min_mm} mm and below {max_mm} mm"
    )]
    ArmOutOfReach {
        /// Length of the arm (mm).
        arm_mm: f64,
        /// Distance of the pivot (mm).
        pivot_mm: f64,
        /// Base radius and roller radius (mm).
        prime_radius_mm: f64,
        /// Difference of arm and pivot distance (mm).
        min_mm: f64,
        /// Their sum (mm).
        max_mm: f64,
    },
    /// The face cannot lie on the base circle.
    #[error(
        "a face {face_offset_mm} mm from a pivot {pivot_mm} mm from the cam's axis cannot lie on the base circle of \
         {base_radius_mm} mm: the offset must be above {min_mm} mm and below {max_mm} mm"
    )]
    FaceOutOfReach {
        /// Offset of the face (mm).
        face_offset_mm: f64,
        /// Distance of the pivot (mm).
        pivot_mm: f64,
        /// Base radius (mm).
        base_radius_mm: f64,
        /// Base radius less pivot distance (mm).
        min_mm: f64,
        /// Base radius and pivot distance (mm).
        max_mm: f64,
    },
    /// The lift swings the arm past where it still lifts.
    #[error(
        "the lift swings the arm to {swing_deg:.3} deg from the line between pivot and cam axis, it must stay above {min_deg} deg and below \
         {bound_deg} deg"
    )]
    SwingTooFar {
        /// Angle between the arm (or the face) and the line from the pivot to the cam's axis (deg).
        swing_deg: f64,
        /// Lower bound, exclusive (deg).
        min_deg: f64,
        /// Upper bound, exclusive (deg).
        bound_deg: f64,
    },
}

impl Follower {
    /// Radius of what touches the cam (mm): 0 for a knife edge, `None` for a flat face.
    #[must_use]
    pub const fn tip_radius_mm(self) -> Option<f64> {
        match self {
            Follower::KnifeEdge { .. } => Some(0.0),
            Follower::Roller { radius_mm, .. }
            | Follower::Mushroom { radius_mm }
            | Follower::OscillatingRoller { radius_mm, .. } => Some(radius_mm),
            Follower::Flat | Follower::OscillatingFlat { .. } => None,
        }
    }
}
