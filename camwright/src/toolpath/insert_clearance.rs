// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Clearance of the insert's flank from the part, and the best height of the insert below centre.
//!
//! ```text
//!   | part   \          Where the rake face meets the surface, the outward normal stands ν = ψ − atan(r′/r) above the X axis line.
//!   |    ψ<0  \ ν       Seen from a tool with its body below the rake plane, past which the surface moves downwards, the flank falls
//!   +----------\----    away from the surface by
//!   |           \===    relief − ν = relief + asin(H/r) + atan(r′/r),
//!   |            |      r the radius at the contact, H the depth of the rake plane below the axis, r′ signed, over the azimuth.
//! ```
//!
//! Every point of the surface becomes a contact as the part turns, so the minimum clearance is that over the whole surface. It grows with
//! H. The angle 90° + ν between the surface and the rake face shrinks with H; below it the tool scrapes instead of cutting. The best H
//! keeps both margins equal. H is given by the offset angle asin(H/rb) with rb the minimum radius: JP2012-71381A asks for 20° to 70°,
//! better 40° to 60°, the range of the balance for ordinary cams.
//!
//! A surface may clear the edge and still meet the flank farther down, so that is looked at too: the flank of a round insert is a cone.

use crate::cam::surface::Surface;
use crate::machine::description::InsertDescription;
use crate::math::named::named;
use crate::math::units::{TURN_RAD, deg_from_rad, rad_from_deg, wrap_turn};
use crate::toolpath::insert_path::{AngleAt, InsertPath};
use alloc::string::String;
use alloc::vec::Vec;
use core::f64::consts::FRAC_PI_2;
use thiserror::Error;

named! {
    /// Number that the clearance of an insert depends on.
    InsertClearanceKey {
        Relief = "the relief",
        MinClearance = "the minimum clearance",
        MinApproach = "the minimum angle to the rake face",
        Depth = "the depth of the flank",
        Begin = "the z to begin at",
        SurfaceRadius = "a radius of the surface",
    }
}

/// Why an insert cannot stand where it should.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InsertClearanceError {
    /// A number that is none, or out of its range.
    #[error("{what} is {value}, it must be {allowed}")]
    BadNumber { what: InsertClearanceKey, value: f64, allowed: &'static str },
    /// The flank touches the surface beside the edge.
    #[error(
        "with the insert {} the flank clears the surface by {clearance_deg:.2} deg, it must be at least \
         {bound_deg:.2} deg, turned to {turned_deg:.1} deg at z = {z_mm:.3} mm",
        beside_centre(*.height_mm)
    )]
    FlankTouches {
        /// H (mm), negative above centre.
        height_mm: f64,
        /// Clearance (deg).
        clearance_deg: f64,
        /// Least allowed (deg).
        bound_deg: f64,
        /// Turned angle θ (deg), in 0..360.
        turned_deg: f64,
        /// z (mm).
        z_mm: f64,
    },
    /// The surface is so flat to the rake face that the tool scrapes.
    #[error(
        "with the insert {} the surface lies at {approach_deg:.2} deg to the rake face, it must be at least \
         {bound_deg:.2} deg, turned to {turned_deg:.1} deg at z = {z_mm:.3} mm",
        beside_centre(*.height_mm)
    )]
    Scrapes {
        /// H (mm), negative above centre.
        height_mm: f64,
        /// Angle between surface and rake face (deg).
        approach_deg: f64,
        /// Least allowed (deg).
        bound_deg: f64,
        /// Turned angle θ (deg), in 0..360.
        turned_deg: f64,
        /// z (mm).
        z_mm: f64,
    },
    /// The rake plane passes beside part of the surface.
    #[error(
        "the insert stands {}, but at azimuth {azimuth_deg:.1} deg, z = {z_mm:.3} mm the part has a radius of \
         {bound_mm:.3} mm only: it must be less than that from centre",
        beside_centre(*.height_mm)
    )]
    Misses {
        /// H (mm), negative above centre.
        height_mm: f64,
        /// Azimuth (deg).
        azimuth_deg: f64,
        /// z (mm).
        z_mm: f64,
        /// Radius there (mm).
        bound_mm: f64,
    },
    /// The surface meets the flank below the edge.
    #[error(
        "turned to {turned_deg:.1} deg with the insert's centre at z = {z_mm:.3} mm, the surface enters the flank by {inside_mm:.4} mm, \
         {below_mm:.3} mm below the edge; allowed: {bound_mm} mm"
    )]
    MeetsFlank {
        /// Turned angle θ (deg), in 0..360.
        turned_deg: f64,
        /// z of the insert's centre (mm).
        z_mm: f64,
        /// Depth (mm).
        inside_mm: f64,
        /// Distance below the edge (mm).
        below_mm: f64,
        /// Allowed (mm).
        bound_mm: f64,
    },
    #[error(
        "no height of the insert works: it must stand {} or lower to clear the surface by {clearance_deg:.2} deg, \
         and {} or higher to meet it at {approach_deg:.2} deg",
        beside_centre(*.lowest_mm), beside_centre(*.highest_mm)
    )]
    NoHeight {
        /// Least H that clears (mm).
        lowest_mm: f64,
        /// Clearance asked for (deg).
        clearance_deg: f64,
        /// Largest H that cuts (mm).
        highest_mm: f64,
        /// Angle to the rake face asked for (deg).
        approach_deg: f64,
    },
}

/// Position of an insert in words, from its height below centre (mm); a negative height is above.
#[must_use]
pub fn beside_centre(below_mm: f64) -> String {
    let side = if below_mm < 0.0 { "above" } else { "below" };
    alloc::format!("{:.3} mm {side} centre", below_mm.abs())
}

/// The insert's flank, and what is asked of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flank {
    /// Relief: by how much the flank falls away from the perpendicular to the rake face (rad).
    pub relief_rad: f64,
    /// Least clearance between flank and surface (rad); 3° to 5° are usual.
    pub min_clearance_rad: f64,
    /// Least angle between surface and rake face (rad).
    pub min_approach_rad: f64,
    /// Height of the flank below the edge (mm).
    pub depth_mm: f64,
}

impl Default for Flank {
    /// 7° of relief, 4° of clearance, 10° to the rake face, a flank of 12 mm.
    fn default() -> Self {
        Self {
            relief_rad: rad_from_deg(7.0),
            min_clearance_rad: rad_from_deg(4.0),
            min_approach_rad: rad_from_deg(10.0),
            depth_mm: 12.0,
        }
    }
}

impl Flank {
    /// The flank of a lathe's insert, and what is asked of every flank.
    #[must_use]
    pub fn from_insert(insert: &InsertDescription) -> Self {
        Self { relief_rad: insert.relief_rad, ..Self::default() }
    }
}

/// Clearance of an insert at one height on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clearance {
    /// H: how far the rake plane lies below the axis (mm), negative above.
    pub height_mm: f64,
    /// Offset angle asin(H/rb), rb the least radius (rad).
    pub offset_angle_rad: f64,
    /// Least clearance between flank and surface.
    pub clearance: AngleAt,
    /// Least angle between surface and rake face; the effective rake is smaller than that of the insert by 90° less this.
    pub approach: AngleAt,
}

/// The heights at which an insert can stand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightRange {
    /// Least H (mm): less, and the flank touches.
    pub lowest_mm: f64,
    /// Largest H (mm): more, and the tool scrapes.
    pub highest_mm: f64,
    /// The H proposed (mm).
    pub best_mm: f64,
    /// The least radius rb of the surface (mm), to which offset angles belong.
    pub min_radius_mm: f64,
}

/// Offset angles that the patent prefers, and those it asks for (deg).
pub const OFFSET_DEG: [(f64, f64); 2] = [(40.0, 60.0), (20.0, 70.0)];

/// Permitted depth of the surface in the flank (mm): the accuracy of the section itself.
const INSIDE_MM: f64 = 1e-4;

/// Start of the scan above the assumed edge (rad); points above the rake plane do not count.
const ABOVE_RAD: f64 = 0.15;

/// Turned angles of a turn, places along the path, places along z within the insert, and places down the flank that are looked at.
const LOOKED_AT: (u32, u32, u32, u32) = (90, 24, 12, 40);

/// A point of the surface: radius, atan(r′/r), azimuth, z.
#[derive(Debug, Clone, Copy)]
struct SurfaceSample {
    radius: f64,
    slope: f64,
    azimuth: f64,
    z: f64,
}

/// Data that decide the clearance of a surface at every height.
///
/// The clearance of a spot grows with its slope and falls with its radius (for H above 0), so only spots count that have none with both a
/// smaller slope and a larger radius, or for H below 0 with both smaller.
#[derive(Debug, Clone)]
pub struct ClearanceMap {
    low: [Vec<SurfaceSample>; 2],
    high: [Vec<SurfaceSample>; 2],
    min: SurfaceSample,
    flank: Flank,
}

/// Keeps spots that no other beats: in the order given, those whose slope is lower than all before.
fn front(
    mut spots: Vec<SurfaceSample>,
    order: impl Fn(&SurfaceSample) -> f64,
    slope: impl Fn(&SurfaceSample) -> f64,
) -> Vec<SurfaceSample> {
    spots.sort_by(|a, b| order(a).total_cmp(&order(b)).then(slope(a).total_cmp(&slope(b))));
    let mut best = f64::INFINITY;
    spots.retain(|spot| {
        let better = slope(spot) < best;
        best = best.min(slope(spot));
        better
    });
    spots
}

impl ClearanceMap {
    /// Looks at a surface between two z (mm).
    ///
    /// # Errors
    /// Numbers of the flank that are out of range.
    pub fn new(surface: &Surface, from_mm: f64, to_mm: f64, flank: Flank) -> Result<Self, InsertClearanceError> {
        let quarter = |what, value: f64| {
            if (0.0..FRAC_PI_2).contains(&value) {
                Ok(())
            } else {
                Err(InsertClearanceError::BadNumber { what, value, allowed: "0 rad up to a quarter turn" })
            }
        };
        quarter(InsertClearanceKey::Relief, flank.relief_rad)?;
        quarter(InsertClearanceKey::MinClearance, flank.min_clearance_rad)?;
        quarter(InsertClearanceKey::MinApproach, flank.min_approach_rad)?;
        if !(0.0..=1000.0).contains(&flank.depth_mm) {
            let (what, value) = (InsertClearanceKey::Depth, flank.depth_mm);
            return Err(InsertClearanceError::BadNumber { what, value, allowed: "0 to 1000 mm" });
        }
        if !(from_mm.is_finite() && to_mm.is_finite() && from_mm <= to_mm) {
            let what = InsertClearanceKey::Begin;
            return Err(InsertClearanceError::BadNumber {
                what,
                value: from_mm,
                allowed: "no more than that to end at",
            });
        }
        let (angles, rows) = surface.looked_at();
        let mut spots = Vec::with_capacity(angles as usize * (rows as usize + 1));
        for row in 0..=rows {
            let z = from_mm + (to_mm - from_mm) * f64::from(row) / f64::from(rows);
            for angle in 0..angles {
                let azimuth = f64::from(angle) * TURN_RAD / f64::from(angles);
                let point = surface.point(azimuth, z);
                spots.push(SurfaceSample { radius: point.radius_mm, slope: -point.normal_lead_rad(), azimuth, z });
            }
        }
        let min = spots.iter().copied().fold(spots[0], |a, b| if b.radius < a.radius { b } else { a });
        // A radius that is none, beyond the ends of a cone, has no place in any order.
        if spots.iter().any(|spot| !(spot.radius > 0.0 && spot.radius.is_finite())) {
            let (what, value) = (InsertClearanceKey::SurfaceRadius, min.radius);
            return Err(InsertClearanceError::BadNumber { what, value, allowed: "above 0 and finite" });
        }
        let low = [
            front(spots.clone(), |spot| -spot.radius, |spot| spot.slope),
            front(spots.clone(), |spot| spot.radius, |spot| spot.slope),
        ];
        let high = [
            front(spots.clone(), |spot| spot.radius, |spot| -spot.slope),
            front(spots, |spot| -spot.radius, |spot| -spot.slope),
        ];
        Ok(Self { low, high, min, flank })
    }

    /// Least and largest asin(H/r) + atan(r′/r), which is −ν, and where.
    fn lean(&self, height_mm: f64) -> (AngleAt, AngleAt) {
        let side = usize::from(height_mm < 0.0);
        let at = |spot: &SurfaceSample| {
            let offset = libm::asin(height_mm / spot.radius);
            AngleAt { angle_rad: offset + spot.slope, turned_rad: spot.azimuth + offset, z_mm: spot.z }
        };
        let first = at(&self.low[side][0]);
        let low = self.low[side].iter().map(at).fold(first, |a, b| if b.angle_rad < a.angle_rad { b } else { a });
        let high = self.high[side].iter().map(at).fold(first, |a, b| if b.angle_rad > a.angle_rad { b } else { a });
        (low, high)
    }

    /// Clearance and angle to the rake face at a height, whether or not they are enough.
    ///
    /// # Errors
    /// A rake plane that passes beside the surface.
    pub fn at(&self, height_mm: f64) -> Result<Clearance, InsertClearanceError> {
        let bound_mm = self.min.radius;
        if height_mm.is_nan() || height_mm.abs() >= bound_mm {
            let (azimuth_deg, z_mm) = (deg_from_rad(self.min.azimuth), self.min.z);
            return Err(InsertClearanceError::Misses { height_mm, azimuth_deg, z_mm, bound_mm });
        }
        let (low, high) = self.lean(height_mm);
        Ok(Clearance {
            height_mm,
            offset_angle_rad: libm::asin(height_mm / bound_mm),
            clearance: AngleAt { angle_rad: self.flank.relief_rad + low.angle_rad, ..low },
            approach: AngleAt { angle_rad: FRAC_PI_2 - high.angle_rad, ..high },
        })
    }

    /// Clearance and angle to the rake face at a height, if both are enough.
    ///
    /// # Errors
    /// A flank that touches, a tool that scrapes, with angle, z, value and bound; a rake plane that passes beside the surface.
    pub fn check(&self, height_mm: f64) -> Result<Clearance, InsertClearanceError> {
        let found = self.at(height_mm)?;
        let turned_deg = |place: AngleAt| deg_from_rad(wrap_turn(place.turned_rad));
        if found.clearance.angle_rad < self.flank.min_clearance_rad {
            return Err(InsertClearanceError::FlankTouches {
                height_mm,
                clearance_deg: deg_from_rad(found.clearance.angle_rad),
                bound_deg: deg_from_rad(self.flank.min_clearance_rad),
                turned_deg: turned_deg(found.clearance),
                z_mm: found.clearance.z_mm,
            });
        }
        if found.approach.angle_rad < self.flank.min_approach_rad {
            return Err(InsertClearanceError::Scrapes {
                height_mm,
                approach_deg: deg_from_rad(found.approach.angle_rad),
                bound_deg: deg_from_rad(self.flank.min_approach_rad),
                turned_deg: turned_deg(found.approach),
                z_mm: found.approach.z_mm,
            });
        }
        Ok(found)
    }

    /// The heights that work, and the best of them: where clearance and angle to the rake face exceed what is asked by the same, moved into
    /// the offset angles that the patent prefers where that works.
    ///
    /// # Errors
    /// No height works.
    pub fn heights(&self) -> Result<HeightRange, InsertClearanceError> {
        let min_radius_mm = self.min.radius;
        let edge = min_radius_mm * (1.0 - 1e-9);
        let margins = |height: f64| {
            let (low, high) = self.lean(height);
            let flank = &self.flank;
            let clearance = flank.relief_rad + low.angle_rad - flank.min_clearance_rad;
            (clearance, FRAC_PI_2 - high.angle_rad - flank.min_approach_rad)
        };
        // Where a function that grows with the height passes 0; at the edges if it does nowhere.
        let zero = |function: &dyn Fn(f64) -> f64| {
            let (mut low, mut high) = (-edge, edge);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if function(middle) < 0.0 { low = middle } else { high = middle }
            }
            0.5 * (low + high)
        };
        let lowest_mm = zero(&|height| margins(height).0);
        let highest_mm = zero(&|height| -margins(height).1);
        let (clearance, approach) = (margins(edge).0, margins(-edge).1);
        if lowest_mm > highest_mm || clearance < 0.0 || approach < 0.0 {
            return Err(InsertClearanceError::NoHeight {
                lowest_mm,
                clearance_deg: deg_from_rad(self.flank.min_clearance_rad),
                highest_mm,
                approach_deg: deg_from_rad(self.flank.min_approach_rad),
            });
        }
        let mut best_mm = zero(&|height| margins(height).0 - margins(height).1).clamp(lowest_mm, highest_mm);
        for (from, to) in OFFSET_DEG {
            let height = |deg: f64| min_radius_mm * libm::sin(rad_from_deg(deg));
            let (low, high) = (lowest_mm.max(height(from)), highest_mm.min(height(to)));
            if low <= high {
                best_mm = best_mm.clamp(low, high);
                break;
            }
        }
        Ok(HeightRange { lowest_mm, highest_mm, best_mm, min_radius_mm })
    }
}

/// Least distance of a surface from the insert's flank along a path (mm), negative inside: the flank is a cone with the insert's radius
/// at the edge, narrower by the tangent of its relief with every mm below. The part is taken as finished, with the stock that the path
/// leaves.
///
/// # Errors
/// A surface that enters the flank, with angle, z, value and bound where it enters farthest.
pub fn flank_distance_mm(surface: &Surface, path: &InsertPath, flank: &Flank) -> Result<f64, InsertClearanceError> {
    let request = path.request();
    let reach = request.insert_radius_mm + request.stock_mm;
    let narrower = libm::tan(flank.relief_rad);
    let (angles, places, across, down) = LOOKED_AT;
    let (start, end) = (path.x().start(), path.x().end());
    let mut min = (f64::INFINITY, start, request.from_mm, 0.0);
    for place in 0..places {
        let from = start + (end - start) * f64::from(place) / f64::from(places);
        for angle in 0..angles {
            // A turn from each place, at angles that do not repeat from place to place.
            let share = f64::from(angle) + f64::from(place) / f64::from(places);
            let turned = from + share * TURN_RAD / f64::from(angles);
            if turned > end {
                break;
            }
            let (x, z_mm) = (path.x().sample(turned).value, path.z_at(turned).value);
            for k in 0..=across {
                let z = z_mm + reach * (2.0 * f64::from(k) / f64::from(across) - 1.0);
                // From the edge downwards: what stands at ψ below the rake plane, on the tool's side.
                let edge = libm::asin((request.plane_y_mm / surface.radius(turned, z)).clamp(-1.0, 1.0)) + ABOVE_RAD;
                for step in 1..=down {
                    let share = f64::from(step) / f64::from(down);
                    let lead = edge - share * share * (FRAC_PI_2 + edge);
                    let radius = surface.radius(lead + turned, z);
                    let (sin, cos) = libm::sincos(lead);
                    let below_mm = request.plane_y_mm - radius * sin;
                    let cone = reach - below_mm * narrower;
                    if below_mm <= 0.0 || below_mm > flank.depth_mm || cone <= 0.0 {
                        continue;
                    }
                    let distance = libm::hypot(radius * cos - x, z - z_mm) - cone;
                    // What is not a number is nowhere, and must not hide.
                    if distance < min.0 || distance.is_nan() {
                        min = (if distance.is_nan() { f64::NEG_INFINITY } else { distance }, turned, z_mm, below_mm);
                    }
                }
            }
        }
    }
    let (distance, turned, z_mm, below_mm) = min;
    if distance < -INSIDE_MM {
        let turned_deg = deg_from_rad(wrap_turn(turned));
        return Err(InsertClearanceError::MeetsFlank {
            turned_deg,
            z_mm,
            inside_mm: -distance,
            below_mm,
            bound_mm: INSIDE_MM,
        });
    }
    Ok(distance)
}
