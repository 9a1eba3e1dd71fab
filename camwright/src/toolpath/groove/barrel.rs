// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A groove round a cylinder, by a mill whose axis is radial, or parallel to a radial one.
//!
//! In the frame that turns with the carriage, x along the axis of the roller, y in the direction of growing azimuth, z along the part, the
//! centre of the roller stands at y = q(φ), z = s(φ), with q = 0 on a slide ([`GrooveCourse`]). Against the part it moves with
//! (−y, x + q′, s′), so it touches its walls at every x where its normal is square to that: at ±(−sin γ, cos γ), tan γ = s′/(x + q′). Both
//! walls are regular where
//!
//! ```text
//! 1 ∓ rr κ − (rr sin γ / L)² ± rr q sin γ / L² > 0,   L² = (x + q′)² + s′²,   κ = ((x + q′) s″ − q″ s′)/L³
//! ```
//!
//! κ is the curvature of the pitch curve developed at the radius x; the last terms are that the walls are twisted. All of this is about one
//! wall at its own azimuth: a groove of several turns may cross itself.
//!
//! A mill of another radius than the roller's leads along a wall beside the pitch curve by (−sin γ, cos γ)·(rr − rc). With a Y axis it is
//! shifted so, with γ half-way between those of both ends of the depth; where γ(x) is that γ its wall is the roller's, and elsewhere it
//! leaves (rr − rc)(1 − cos Δγ). Without a Y axis the part of the shift that lies across is a turn of C by its size over the mean radius,
//! right there and wrong in proportion to the distance from there: (rr − rc)(1 − cos γ cos γm − (x/xm) sin γ sin γm).

use super::course::{GrooveCourse, RollerCentre};
use super::open_path;
use super::{Coverage, GrooveError, Wall, positive, side_by_side};
use crate::cam::lift::LiftLaw;
use crate::math::extremum::smallest_over_period;
use crate::math::hermite::Knot;
use crate::math::periodic_spline::PeriodicSpline;
use crate::math::root::growing_root;
use crate::math::units::deg_from_rad;
use crate::toolpath::cutter_path::{CarriageAxis, CutterPath, Travel, TravelCurve};
use crate::toolpath::wheel_path::resample;
use alloc::string::String;
use alloc::vec::Vec;

/// A groove round a cylinder.
#[derive(Debug, Clone, PartialEq)]
pub struct BarrelGroove {
    course: GrooveCourse,
    roller_radius_mm: f64,
    outer_radius_mm: f64,
    floor_radius_mm: f64,
    faces: Option<EndFaces>,
}

/// End faces of a cylinder along the part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndFaces {
    /// Z of the face towards −Z (mm).
    pub from_mm: f64,
    /// Z of the face towards +Z (mm).
    pub to_mm: f64,
    /// Z of the roller at lift 0, or of the turret's axis (mm).
    pub zero_mm: f64,
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
    /// The groove that moves a roller along the part by a lift law over one turn, from the surface of a cylinder down to a floor.
    ///
    /// # Errors
    /// Radii that are none; a wall that is undercut at some radius, with place and figures.
    pub fn new(
        lift: &LiftLaw,
        roller_radius_mm: f64,
        outer_radius_mm: f64,
        floor_radius_mm: f64,
    ) -> Result<Self, GrooveError> {
        Self::along(GrooveCourse::closed(lift, 1)?, roller_radius_mm, (outer_radius_mm, floor_radius_mm), None)
    }

    /// The groove of a roller on a course, between end faces if they are known.
    ///
    /// # Errors
    /// Radii or faces that are none; a closed groove that leaves the cylinder; an open one that begins or ends inside; a roller beside the
    /// cylinder; a wall that is undercut at some radius, with place and figures.
    pub fn along(
        course: GrooveCourse,
        roller_radius_mm: f64,
        (outer_radius_mm, floor_radius_mm): (f64, f64),
        faces: Option<EndFaces>,
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
        let groove = Self { course, roller_radius_mm, outer_radius_mm, floor_radius_mm, faces };
        groove.check_faces()?;
        groove.check_beside()?;
        // A roller on a turret moves wildly beyond the faces, where it makes no wall.
        let has_walls = |z_mm: f64| groove.course.turret().is_none() || groove.is_inside(z_mm);
        for wall in Wall::BOTH {
            let worst = |angle: f64| {
                let centre = groove.course.centre(angle);
                if !has_walls(centre.z.value) {
                    return (1.0, 0.0);
                }
                (0..=DEPTHS)
                    .map(|depth| (groove.regularity(&centre, groove.at_depth(depth), wall), groove.at_depth(depth)))
                    .fold((f64::INFINITY, 0.0), |min, new| if new.0 < min.0 || new.0.is_nan() { new } else { min })
            };
            let (grid, breaks) = (groove.course.grid(), groove.course.breaks());
            let thinnest = smallest_over_period(groove.course.span_rad(), grid, &breaks, |angle| worst(angle).0);
            if thinnest.value.is_nan() || thinnest.value <= ROUNDING {
                let (centre, x) = (groove.course.centre(thinnest.angle_rad), worst(thinnest.angle_rad).1);
                let (curvature, twist) = groove.bending(&centre, x, wall);
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

    /// Course of the roller.
    #[must_use]
    pub fn course(&self) -> &GrooveCourse {
        &self.course
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

    /// Returns whether a roller at a Z of the course cuts into the cylinder; without known faces it does.
    #[must_use]
    pub fn is_inside(&self, z_mm: f64) -> bool {
        self.faces.is_none_or(|faces| {
            let z_mm = faces.zero_mm + z_mm;
            z_mm > faces.from_mm - self.roller_radius_mm && z_mm < faces.to_mm + self.roller_radius_mm
        })
    }

    /// Refuses a closed groove that leaves the cylinder.
    fn check_faces(&self) -> Result<(), GrooveError> {
        let Some(EndFaces { from_mm, to_mm, zero_mm }) = self.faces else { return Ok(()) };
        for (what, value) in [("the end face towards -Z", from_mm), ("the end face towards +Z", to_mm)] {
            if !value.is_finite() || from_mm >= to_mm {
                let bound = "a number, and the face towards -Z below the other one";
                return Err(GrooveError::BadNumber { what, value, bound });
            }
        }
        if self.course.is_open() {
            return Ok(());
        }
        let (low_mm, high_mm) = self.course.z_range_mm();
        let (low_mm, high_mm) = (zero_mm + low_mm - self.roller_radius_mm, zero_mm + high_mm + self.roller_radius_mm);
        if low_mm > from_mm && high_mm < to_mm {
            return Ok(());
        }
        Err(GrooveError::LeavesCylinder { low_mm, high_mm, from_mm, to_mm })
    }

    /// Refuses an open groove whose ends do not lie beyond the faces by the roller's radius and a clearance.
    ///
    /// # Errors
    /// An end inside the cylinder or near it; an open groove of a cylinder without known faces.
    pub fn check_ends(&self, clearance_mm: f64) -> Result<(), GrooveError> {
        if !self.course.is_open() {
            return Ok(());
        }
        let Some(EndFaces { from_mm, to_mm, zero_mm }) = self.faces else { return Err(GrooveError::NoFaces) };
        let beyond_mm = self.roller_radius_mm + clearance_mm;
        let (below_mm, above_mm) = (from_mm - beyond_mm, to_mm + beyond_mm);
        for (end, azimuth_rad) in [("begins", 0.0), ("ends", self.course.span_rad())] {
            let z_mm = zero_mm + self.course.centre(azimuth_rad).z.value;
            if z_mm > below_mm + super::SAME_MM && z_mm < above_mm - super::SAME_MM {
                return Err(GrooveError::EndsInside { end, z_mm, from_mm, to_mm, below_mm, above_mm });
            }
        }
        Ok(())
    }

    /// Refuses a roller so far beside the radial line that its groove has no depth.
    fn check_beside(&self) -> Result<(), GrooveError> {
        if self.course.turret().is_none() {
            return Ok(());
        }
        let surface_mm = |angle: f64| {
            let centre = self.course.centre(angle);
            let (outer, y) = (self.outer_radius_mm, centre.y.value);
            if self.is_inside(centre.z.value) { libm::sqrt((outer * outer - y * y).max(0.0)) } else { outer }
        };
        let (span_rad, grid) = (self.course.span_rad(), self.course.grid());
        let lowest = smallest_over_period(span_rad, grid, &self.course.breaks(), surface_mm);
        if lowest.value > self.floor_radius_mm {
            return Ok(());
        }
        Err(GrooveError::BesideCylinder {
            angle_deg: deg_from_rad(lowest.angle_rad),
            beside_mm: self.course.centre(lowest.angle_rad).y.value,
            outer_radius_mm: self.outer_radius_mm,
            surface_mm: lowest.value,
            floor_radius_mm: self.floor_radius_mm,
        })
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
    /// A mill that does not go into the slot or is far too small for it; a path that is not smooth enough; a turret without a Y axis.
    pub fn paths(
        &self,
        cutter: BarrelCutter,
        leaves_mm: f64,
        coverage: Coverage,
    ) -> Result<Vec<CutterPath>, GrooveError> {
        self.needs_y(cutter.y_axis)?;
        let beside =
            side_by_side(self.roller_radius_mm, cutter.radius_mm, leaves_mm, coverage, Wall::name_on_cylinder)?;
        beside.into_iter().map(|(name, offset_mm)| self.path(name, offset_mm, cutter.y_axis)).collect()
    }

    /// Refuses a roller that moves across on a machine that cannot.
    ///
    /// # Errors
    /// A turret without a Y axis.
    pub fn needs_y(&self, y_axis: bool) -> Result<(), GrooveError> {
        if self.course.turret().is_some() && !y_axis { Err(GrooveError::TurretNeedsY) } else { Ok(()) }
    }

    /// The path at a distance from the pitch curve along its normal.
    fn path(&self, name: String, offset_mm: f64, y_axis: bool) -> Result<CutterPath, GrooveError> {
        let travels = if self.course.is_open() {
            self.open_travels(offset_mm, y_axis)?
        } else {
            self.closed_travels(offset_mm, y_axis)?
        };
        Ok(CutterPath { name, travels, infeed: CarriageAxis::X })
    }

    fn closed_travels(&self, offset_mm: f64, y_axis: bool) -> Result<Vec<Travel>, GrooveError> {
        // One turn of a spline is all turns of the course.
        let turns = f64::from(self.course.turns());
        let travel = |axis, spline: PeriodicSpline| Travel {
            axis,
            position: TravelCurve::Closed { spline, turns: self.course.turns() },
        };
        let across = |angle: f64| {
            let centre = self.course.centre(angle);
            centre.y.value - offset_mm * libm::sin(self.mean_slope(&centre))
        };
        let along = |angle: f64| {
            let centre = self.course.centre(angle);
            centre.z.value + offset_mm * libm::cos(self.mean_slope(&centre))
        };
        let centred = offset_mm.abs() <= super::SAME_MM;
        if centred && self.course.turret().is_none() {
            let (position, _) = resample(|angle, _| self.course.centre(turns * angle).z.value)?;
            return Ok([travel(CarriageAxis::Z, position)].into());
        }
        if y_axis {
            return Ok([
                travel(CarriageAxis::Y, resample(|angle, _| across(turns * angle))?.0),
                travel(CarriageAxis::Z, resample(|angle, _| along(turns * angle))?.0),
            ]
            .into());
        }
        let (position, _) = resample(|share, guess| {
            let azimuth = turns * share;
            let cam_angle = self.turned_from(azimuth, offset_mm, azimuth + *guess);
            *guess = cam_angle - azimuth;
            let centre = self.course.centre(cam_angle);
            centre.z.value + offset_mm * libm::cos(self.slope(&centre, self.mean_radius_mm()))
        })?;
        Ok([travel(CarriageAxis::Z, position)].into())
    }

    /// Travels with two ends. Velocity and acceleration of every place are known, also over the azimuth of a mill that C shifts.
    fn open_travels(&self, offset_mm: f64, y_axis: bool) -> Result<Vec<Travel>, GrooveError> {
        let span_rad = self.course.span_rad();
        let breaks = self.course.breaks();
        let travel = |axis, place: &dyn Fn(f64) -> Knot| -> Result<Travel, GrooveError> {
            let spline = open_path::through(span_rad, &breaks, place)?;
            Ok(Travel { axis, position: TravelCurve::Open(spline) })
        };
        let centred = offset_mm.abs() <= super::SAME_MM;
        if centred && self.course.turret().is_none() {
            let along = |angle: f64| open_path::knot(angle, self.course.centre(angle).z);
            return Ok([travel(CarriageAxis::Z, &along)?].into());
        }
        if y_axis {
            let mean = |centre: &RollerCentre| {
                let ends = [self.outer_radius_mm, self.floor_radius_mm].map(|x| open_path::slope(centre, x));
                open_path::half_way(ends)
            };
            let across = |angle: f64| {
                let centre = self.course.centre(angle);
                open_path::knot(angle, open_path::plus(centre.y, -offset_mm, open_path::sine(mean(&centre))))
            };
            let along = |angle: f64| {
                let centre = self.course.centre(angle);
                open_path::knot(angle, open_path::plus(centre.z, offset_mm, open_path::cosine(mean(&centre))))
            };
            return Ok([travel(CarriageAxis::Y, &across)?, travel(CarriageAxis::Z, &along)?].into());
        }
        let mean_mm = self.mean_radius_mm();
        let along = |angle: f64| {
            let centre = self.course.centre(angle);
            let slope = open_path::slope(&centre, mean_mm);
            let turned = open_path::plus(open_path::line(angle), -offset_mm / mean_mm, open_path::sine(slope));
            let along = open_path::plus(centre.z, offset_mm, open_path::cosine(slope));
            open_path::knot_over(turned, along)
        };
        Ok([travel(CarriageAxis::Z, &along)?].into())
    }

    /// Azimuth of the roller for which the mill stands at another azimuth, turned by C: θ = φ − (offset/xm) sin γ(φ), which grows with φ
    /// at the rate 1 − κ·offset.
    fn turned_from(&self, azimuth_rad: f64, offset_mm: f64, guess_rad: f64) -> f64 {
        let mean_mm = self.mean_radius_mm();
        let max_rad = offset_mm.abs() / mean_mm;
        growing_root(azimuth_rad - max_rad, azimuth_rad + max_rad, guess_rad, |angle| {
            let centre = self.course.centre(angle);
            let slope = self.slope(&centre, mean_mm);
            let (curvature, _) = self.bending(&centre, mean_mm, Wall::Outer);
            (angle - offset_mm / mean_mm * libm::sin(slope) - azimuth_rad, 1.0 - offset_mm * curvature)
        })
    }

    /// γ at a distance x from the part's axis (rad).
    pub(super) fn slope(&self, centre: &RollerCentre, x: f64) -> f64 {
        libm::atan2(centre.z.first, x + centre.y.first)
    }

    /// γ half-way between those at the surface and at the floor (rad): what a mill then leaves is the same at both.
    fn mean_slope(&self, centre: &RollerCentre) -> f64 {
        0.5 * (self.slope(centre, self.outer_radius_mm) + self.slope(centre, self.floor_radius_mm))
    }

    /// κ, and what the twist of a wall takes: (rr sin γ / L)², on a turret also ∓ rr q sin γ / L².
    fn bending(&self, centre: &RollerCentre, x: f64, wall: Wall) -> (f64, f64) {
        let (y, z) = (&centre.y, &centre.z);
        let x = x + y.first;
        let square = x * x + z.first * z.first;
        let length = libm::sqrt(square);
        let twist = self.roller_radius_mm * z.first / square;
        let beside = wall.side() * self.roller_radius_mm * y.value * (z.first / length) / square;
        ((x * z.second - y.second * z.first) / (square * length), twist * twist - beside)
    }

    /// Expression that must be positive for a regular wall.
    fn regularity(&self, centre: &RollerCentre, x: f64, wall: Wall) -> f64 {
        let (curvature, twist) = self.bending(centre, x, wall);
        1.0 - wall.side() * self.roller_radius_mm * curvature - twist
    }

    /// Distance from the part's axis at a share of the depth, along the roller.
    fn at_depth(&self, depth: u32) -> f64 {
        let share = f64::from(depth) / f64::from(DEPTHS);
        self.floor_radius_mm + share * (self.outer_radius_mm - self.floor_radius_mm)
    }
}
