// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lathe tool: a round insert, rotated by a spindle of its own or clamped.

use crate::machine::axial_profile::AxialProfile;
use crate::machine::description_error::{DescriptionError, ordered};
use crate::machine::wheel::WheelDescription;
use crate::math::units::TURN_RAD;

/// A round insert. A machine with one is a lathe. JP2012-71381A turns parts that are not round with a driven one.
///
/// A driven insert turns about the normal of its rake face, so its edge stays the same circle; where it stands is its centre.
/// ```text
///        y
///        │    part turns, the surface comes down on the rake face when H is below the axis
///  ──────●─────────── x
///        │     ╲
///      H ┼──────●═══════  rake face, towards +y
///        │      ╲│        flank, by the relief angle off the normal of the rake face
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InsertDescription {
    /// R, radius of the edge (mm).
    pub radius_mm: f64,
    /// H, height of the rake face above the part's axis (mm); below it negative.
    pub height_mm: f64,
    /// Between which heights the tool can be set (mm).
    pub height_range_mm: (f64, f64),
    /// γ, how far the flank leans back from the normal of the rake face (rad).
    pub relief_rad: f64,
    /// Arc of the edge that may cut; `None`: the whole circle.
    pub edge: Option<EdgeArc>,
    /// Spindle of the insert; `None`: the insert is clamped and does not rotate.
    pub spindle: Option<InsertSpindle>,
}

/// Spindle of a driven insert.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InsertSpindle {
    /// Speed of the edge along itself when the insert runs (m/s).
    pub surface_speed_m_s: f64,
    /// Time to reach its speed or to come to rest (s).
    pub spin_up_s: f64,
    /// Fastest it may turn (rad/s); `None`: unknown.
    pub max_speed_rad_s: Option<f64>,
    /// Direction, seen from the spindle towards the rake face.
    pub rotation: InsertRotation,
}

/// Direction of a driven insert, seen from its spindle towards the rake face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InsertRotation {
    #[default]
    Clockwise,
    Counterclockwise,
}

/// Arc of the edge of a round insert in the rake plane.
///
/// The angle is measured at the insert's centre: 0 faces the spindle axis (−X), positive angles lie towards +z. The contact with a section
/// of slope dx/dz = tan τ lies at τ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeArc {
    pub from_rad: f64,
    pub to_rad: f64,
}

impl InsertDescription {
    /// The insert as what a spindle rotates: as wide along the part as its edge, without wear or unbalance. A clamped one has speed 0.
    ///
    /// The drive of a lathe's insert is that of a grinder's wheel, so are its speed, its orders and its alarms.
    #[must_use]
    pub fn tool(&self) -> WheelDescription {
        WheelDescription {
            new_radius_mm: self.radius_mm,
            min_radius_mm: self.radius_mm,
            width_mm: 2.0 * self.radius_mm,
            surface_speed_m_s: self.spindle.map_or(0.0, |spindle| spindle.surface_speed_m_s),
            spin_up_s: self.spindle.map_or(0.0, |spindle| spindle.spin_up_s),
            max_surface_speed_m_s: None,
            max_speed_rad_s: self.spindle.and_then(|spindle| spindle.max_speed_rad_s),
            grinding_ratio: None,
            unbalance_mm: 0.0,
            rim: AxialProfile::default(),
        }
    }

    pub(super) fn validate(&self) -> Result<(), DescriptionError> {
        let positive = |what: &'static str, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(DescriptionError::NotPositive { what, value }),
        };
        positive("radius of the insert (mm)", self.radius_mm)?;
        if let Some(spindle) = &self.spindle {
            positive("surface speed of the insert (m/s)", spindle.surface_speed_m_s)?;
        }
        if let Some(EdgeArc { from_rad, to_rad }) = self.edge {
            let half = 0.5 * TURN_RAD;
            for (what, value) in [("begin of the edge (rad)", from_rad), ("end of the edge (rad)", to_rad)] {
                if !(-half..=half).contains(&value) {
                    return Err(DescriptionError::Outside { what, value, low: -half, high: half });
                }
            }
            ordered("arc of the edge (rad)", from_rad, to_rad)?;
        }
        let (low, high) = self.height_range_mm;
        for (what, value) in
            [("lowest height of the rake face (mm)", low), ("highest height of the rake face (mm)", high)]
        {
            if !value.is_finite() {
                return Err(DescriptionError::NotFinite { what, value });
            }
        }
        ordered("heights of the rake face (mm)", low, high)?;
        if !(low..=high).contains(&self.height_mm) {
            let (what, value) = ("height of the rake face (mm)", self.height_mm);
            return Err(DescriptionError::Outside { what, value, low, high });
        }
        let (what, value) = ("relief angle of the insert (rad)", self.relief_rad);
        match (0.0..0.25 * TURN_RAD).contains(&value) {
            true => Ok(()),
            false => Err(DescriptionError::Outside { what, value, low: 0.0, high: 0.25 * TURN_RAD }),
        }
    }
}
