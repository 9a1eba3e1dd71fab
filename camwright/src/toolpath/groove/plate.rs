// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A groove in the face of a plate cam, by a mill whose axis is parallel to the part's.
//!
//! The inner wall is the contour of a cam for the same roller, Q = P − rr N. What runs at a distance R outside it, Q + R N, is the centre of
//! a wheel of that radius, so the mill's paths are those of wheels: R = rr is the pitch curve, R = rc and R = 2rr − rc lead along the walls.
//! Both walls are regular, and the azimuth grows along them (Q·N > 0); so it does on all curves between, and the groove cannot meet itself.

use super::{Coverage, GrooveError, SAME_MM, Wall, positive, side_by_side};
use crate::cam::contour::Contour;
use crate::cam::follower::Follower;
use crate::cam::lift::LiftLaw;
use crate::math::extremum::{Extremum, smallest_over_turn};
use crate::math::units::deg_from_rad;
use crate::toolpath::cutter_path::{CarriageAxis, CutterPath};
use crate::toolpath::wheel_path::ToolPath;
use alloc::vec::Vec;

#[derive(Debug, Clone, PartialEq)]
pub struct PlateGroove {
    inner: Contour,
    roller_radius_mm: f64,
    tightest: [Extremum; 2],
}

impl PlateGroove {
    /// The groove in which a roller, on a slide or on an arm, does what a lift law says; its base circle is that of the inner wall.
    ///
    /// # Errors
    /// Another follower than a roller; what the inner wall has against it; an outer wall that is undercut, with place and figures.
    pub fn new(lift: &LiftLaw, follower: &Follower, base_radius_mm: f64) -> Result<Self, GrooveError> {
        let (Follower::Roller { radius_mm, .. } | Follower::OscillatingRoller { radius_mm, .. }) = *follower else {
            return Err(GrooveError::NoRoller);
        };
        let inner = Contour::from_lift(lift, follower, base_radius_mm)?;
        let roller_radius_mm = positive("the radius of the roller", radius_mm)?;
        let (grid, breaks) = (lift.grid(), lift.breaks());
        // Of the pitch curve: dl/dφ is a roller's radius outside that of the inner wall.
        let curvature = |angle: f64| {
            let frame = inner.local(angle);
            frame.turning / (frame.arc + roller_radius_mm * frame.turning)
        };
        let clearance = |angle: f64| {
            let frame = inner.local(angle);
            (frame.arc + 2.0 * roller_radius_mm * frame.turning) / (frame.arc + roller_radius_mm * frame.turning)
        };
        let thinnest = smallest_over_turn(grid, &breaks, clearance);
        if thinnest.value.is_nan() || thinnest.value <= SAME_MM {
            let frame = inner.local(thinnest.angle_rad);
            let (along, across) = frame.outside(2.0 * roller_radius_mm);
            return Err(GrooveError::Undercut {
                wall: Wall::Outer.name_in_plate(),
                angle_deg: deg_from_rad(thinnest.angle_rad),
                from_axis_mm: libm::hypot(along, across),
                slot_radius_mm: -1.0 / curvature(thinnest.angle_rad),
                bound_mm: roller_radius_mm,
            });
        }
        let tightest = Wall::BOTH.map(|wall| {
            let found = smallest_over_turn(grid, &breaks, |angle| wall.side() * curvature(angle));
            Extremum { angle_rad: found.angle_rad, value: wall.side() * found.value }
        });
        Ok(Self { inner, roller_radius_mm, tightest })
    }

    /// Its inner wall, which is the contour of a cam.
    #[must_use]
    pub fn inner_wall(&self) -> &Contour {
        &self.inner
    }

    /// Radius of the roller (mm).
    #[must_use]
    pub fn roller_radius_mm(&self) -> f64 {
        self.roller_radius_mm
    }

    /// Least radius of curvature of the pitch curve where it bends round a wall (mm), and the cam angle; `None` if it does so nowhere.
    #[must_use]
    pub fn tightest(&self, wall: Wall) -> Option<Extremum> {
        let found = match wall {
            Wall::Inner => self.tightest[0],
            Wall::Outer => self.tightest[1],
        };
        let radius_mm = -wall.side() / found.value;
        (radius_mm > 0.0).then_some(Extremum { angle_rad: found.angle_rad, value: radius_mm })
    }

    /// Checks that a mill fits into the slot, without computing its paths.
    ///
    /// # Errors
    /// A mill that does not, or is far too small for it.
    pub fn fits(&self, cutter_radius_mm: f64, leaves_mm: f64, coverage: Coverage) -> Result<(), GrooveError> {
        side_by_side(self.roller_radius_mm, cutter_radius_mm, leaves_mm, coverage, Wall::name_in_plate).map(|_| ())
    }

    /// Paths of a mill that cuts the groove, or leaves so much on each of its walls: X of its centre, depth along Z. One path where the mill
    /// is as wide as the slot.
    ///
    /// # Errors
    /// A mill that does not go into the slot or is far too small for it; a path that is not smooth enough.
    pub fn paths(
        &self,
        cutter_radius_mm: f64,
        leaves_mm: f64,
        coverage: Coverage,
    ) -> Result<Vec<CutterPath>, GrooveError> {
        let beside = side_by_side(self.roller_radius_mm, cutter_radius_mm, leaves_mm, coverage, Wall::name_in_plate)?;
        let path = |(name, offset_mm): (_, f64)| {
            let path = ToolPath::for_wheel(&self.inner, self.roller_radius_mm + offset_mm)?;
            Ok(CutterPath::round(name, &path, CarriageAxis::Z))
        };
        beside.iter().map(|(name, offset_mm)| path((name.as_str(), *offset_mm))).collect()
    }
}
