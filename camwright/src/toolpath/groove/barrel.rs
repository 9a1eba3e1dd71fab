// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A groove round a cylinder, by a mill whose axis is radial, or parallel to a radial one.
//!
//! In the frame that turns with the carriage, x along the axis of the roller, y in the direction of growing azimuth, z along the part, the
//! roller stands at y = 0, z = s(φ). Against the part it moves with (−y, x, s′), so it touches its walls at every x where its normal is
//! square to that: at ±(−sin γ, cos γ), tan γ = s′/x. Both walls are regular where
//!
//! ```text
//! 1 ∓ rr κ − (rr sin γ / L)² > 0,   L² = x² + s′²,   κ = x s″/L³
//! ```
//!
//! κ is the curvature of the pitch curve developed at the radius x; the last term is that the walls are twisted.
//!
//! A mill of another radius than the roller's leads along a wall beside the pitch curve by (−sin γ, cos γ)·(rr − rc). With a Y axis it is
//! shifted so, with γ half-way between those of both ends of the depth; where γ(x) is that γ its wall is the roller's, and elsewhere it
//! leaves (rr − rc)(1 − cos Δγ). Without a Y axis the part of the shift that lies across is a turn of C by its size over the mean radius,
//! right there and wrong in proportion to the distance from there: (rr − rc)(1 − cos γ cos γm − (x/xm) sin γ sin γm).

use super::{Coverage, GrooveError, Wall, positive, side_by_side};
use crate::cam::lift::LiftLaw;
use crate::math::extremum::smallest_over_turn;
use crate::math::hermite::Sample;
use crate::math::root::growing_root;
use crate::math::units::deg_from_rad;
use crate::toolpath::cutter_path::{CarriageAxis, CutterPath, Travel};
use crate::toolpath::wheel_path::resample;
use alloc::vec::Vec;

/// A groove round a cylinder.
#[derive(Debug, Clone, PartialEq)]
pub struct BarrelGroove {
    lift: LiftLaw,
    roller_radius_mm: f64,
    outer_radius_mm: f64,
    floor_radius_mm: f64,
}

/// A mill in a barrel groove, and how its carriage moves it across.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BarrelCutter {
    /// Radius (mm).
    pub radius_mm: f64,
    /// The carriage has an axis across; without one C does it.
    pub y_axis: bool,
}

/// Places along the roller at which its walls are looked at.
pub(super) const DEPTHS: u32 = 16;

/// Rounding error of a zero.
const ROUNDING: f64 = 1e-9;

impl BarrelGroove {
    /// The groove that moves a roller along the part by a lift law, from the surface of a cylinder down to a floor.
    ///
    /// # Errors
    /// Radii that are none; a wall that is undercut at some radius, with place and figures.
    pub fn new(
        lift: &LiftLaw,
        roller_radius_mm: f64,
        outer_radius_mm: f64,
        floor_radius_mm: f64,
    ) -> Result<Self, GrooveError> {
        positive("the radius of the roller", roller_radius_mm)?;
        positive("the radius of the floor", floor_radius_mm)?;
        // Nearer to the axis the last term can reach 1 on straight flanks.
        if floor_radius_mm <= 0.5 * roller_radius_mm {
            let (what, bound) = ("the radius of the floor", "larger than half that of the roller");
            return Err(GrooveError::BadNumber { what, value: floor_radius_mm, bound });
        }
        if !outer_radius_mm.is_finite() || outer_radius_mm <= floor_radius_mm {
            let (what, bound) = ("the radius of the cylinder", "larger than that of the floor");
            return Err(GrooveError::BadNumber { what, value: outer_radius_mm, bound });
        }
        let groove = Self { lift: lift.clone(), roller_radius_mm, outer_radius_mm, floor_radius_mm };
        for wall in Wall::BOTH {
            let worst = |angle: f64| {
                let z = lift.sample(angle);
                (0..=DEPTHS)
                    .map(|depth| (groove.regularity(&z, groove.at_depth(depth), wall), groove.at_depth(depth)))
                    .fold((f64::INFINITY, 0.0), |min, new| if new.0 < min.0 || new.0.is_nan() { new } else { min })
            };
            let thinnest = smallest_over_turn(lift.grid(), &lift.breaks(), |angle| worst(angle).0);
            if thinnest.value.is_nan() || thinnest.value <= ROUNDING {
                let (z, x) = (lift.sample(thinnest.angle_rad), worst(thinnest.angle_rad).1);
                let (curvature, twist) = groove.bending(&z, x);
                return Err(GrooveError::Undercut {
                    wall: wall.name_on_cylinder(),
                    angle_deg: deg_from_rad(thinnest.angle_rad),
                    from_axis_mm: x,
                    slot_radius_mm: wall.side() / curvature,
                    bound_mm: roller_radius_mm / (1.0 - twist),
                });
            }
        }
        Ok(groove)
    }

    /// Lift along the part over the azimuth of the roller (mm over rad).
    #[must_use]
    pub fn lift(&self) -> &LiftLaw {
        &self.lift
    }

    /// Radius of the roller (mm).
    #[must_use]
    pub fn roller_radius_mm(&self) -> f64 {
        self.roller_radius_mm
    }

    /// Radius of the cylinder (mm).
    #[must_use]
    pub fn outer_radius_mm(&self) -> f64 {
        self.outer_radius_mm
    }

    /// Distance of the floor from the part's axis (mm): that of the mill's end.
    #[must_use]
    pub fn floor_radius_mm(&self) -> f64 {
        self.floor_radius_mm
    }

    /// Radius at which a shift by C is right (mm): half-way down.
    #[must_use]
    pub fn mean_radius_mm(&self) -> f64 {
        0.5 * (self.outer_radius_mm + self.floor_radius_mm)
    }

    /// Checks that a mill fits into the slot, without computing its paths.
    ///
    /// # Errors
    /// A mill that does not, or is far too small for it.
    pub fn fits(&self, cutter_radius_mm: f64, leaves_mm: f64, coverage: Coverage) -> Result<(), GrooveError> {
        side_by_side(self.roller_radius_mm, cutter_radius_mm, leaves_mm, coverage, Wall::name_on_cylinder).map(|_| ())
    }

    /// Paths of a mill that cuts the groove, or leaves so much on each of its walls: Z, and Y if there is one, with depth along X. One path
    /// where the mill is as wide as the slot.
    ///
    /// # Errors
    /// A mill that does not go into the slot or is far too small for it; a path that is not smooth enough.
    pub fn paths(
        &self,
        cutter: BarrelCutter,
        leaves_mm: f64,
        coverage: Coverage,
    ) -> Result<Vec<CutterPath>, GrooveError> {
        let beside =
            side_by_side(self.roller_radius_mm, cutter.radius_mm, leaves_mm, coverage, Wall::name_on_cylinder)?;
        beside.into_iter().map(|(name, offset_mm)| self.path(name, offset_mm, cutter.y_axis)).collect()
    }

    /// The path at a distance from the pitch curve along its normal.
    fn path(&self, name: alloc::string::String, offset_mm: f64, y_axis: bool) -> Result<CutterPath, GrooveError> {
        let across = |angle: f64| -offset_mm * libm::sin(self.mean_slope(&self.lift.sample(angle)));
        let along = |angle: f64| {
            let z = self.lift.sample(angle);
            z.value + offset_mm * libm::cos(self.mean_slope(&z))
        };
        let centred = offset_mm.abs() <= super::SAME_MM;
        let mut travels = Vec::new();
        if centred {
            let (position, _) = resample(|angle, _| self.lift.sample(angle).value)?;
            travels.push(Travel { axis: CarriageAxis::Z, position });
        } else if y_axis {
            for (axis, position) in [
                (CarriageAxis::Y, resample(|angle, _| across(angle))?.0),
                (CarriageAxis::Z, resample(|angle, _| along(angle))?.0),
            ] {
                travels.push(Travel { axis, position });
            }
        } else {
            let (position, _) = resample(|azimuth, guess| {
                let cam_angle = self.turned_from(azimuth, offset_mm, azimuth + *guess);
                *guess = cam_angle - azimuth;
                let z = self.lift.sample(cam_angle);
                z.value + offset_mm * libm::cos(self.slope(&z, self.mean_radius_mm()))
            })?;
            travels.push(Travel { axis: CarriageAxis::Z, position });
        }
        Ok(CutterPath { name, travels, infeed: CarriageAxis::X })
    }

    /// Azimuth of the roller for which the mill stands at another azimuth, turned by C: θ = φ − (offset/xm) sin γ(φ), which grows with φ
    /// at the rate 1 − κ·offset.
    fn turned_from(&self, azimuth_rad: f64, offset_mm: f64, guess_rad: f64) -> f64 {
        let mean_mm = self.mean_radius_mm();
        let max_rad = offset_mm.abs() / mean_mm;
        growing_root(azimuth_rad - max_rad, azimuth_rad + max_rad, guess_rad, |angle| {
            let z = self.lift.sample(angle);
            let slope = self.slope(&z, mean_mm);
            let (curvature, _) = self.bending(&z, mean_mm);
            (angle - offset_mm / mean_mm * libm::sin(slope) - azimuth_rad, 1.0 - offset_mm * curvature)
        })
    }

    /// γ at a distance x from the part's axis (rad).
    pub(super) fn slope(&self, z: &Sample, x: f64) -> f64 {
        libm::atan2(z.first, x)
    }

    /// γ half-way between those at the surface and at the floor (rad): what a mill then leaves is the same at both.
    fn mean_slope(&self, z: &Sample) -> f64 {
        0.5 * (self.slope(z, self.outer_radius_mm) + self.slope(z, self.floor_radius_mm))
    }

    /// κ, and the square of rr sin γ / L.
    fn bending(&self, z: &Sample, x: f64) -> (f64, f64) {
        let square = x * x + z.first * z.first;
        let twist = self.roller_radius_mm * z.first / square;
        (x * z.second / (square * libm::sqrt(square)), twist * twist)
    }

    /// Expression that must be positive for a regular wall.
    fn regularity(&self, z: &Sample, x: f64, wall: Wall) -> f64 {
        let (curvature, twist) = self.bending(z, x);
        1.0 - wall.side() * self.roller_radius_mm * curvature - twist
    }

    /// Distance from the part's axis at a share of the depth, along the roller.
    fn at_depth(&self, depth: u32) -> f64 {
        let share = f64::from(depth) / f64::from(DEPTHS);
        self.floor_radius_mm + share * (self.outer_radius_mm - self.floor_radius_mm)
    }
}
