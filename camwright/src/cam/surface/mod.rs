// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The surface of a part that is not round: its distance r(azimuth, z) from the spindle axis.
//!
//! The azimuth is that of the point in the part's frame, from the keyway on, counted as [`crate::cam::contour`] counts it; z runs along the
//! axis. What stands at an azimuth φ passes the X axis line where θ = σ·C = φ.
//!
//! | kind | made of | beyond its ends goes on |
//! |---|---|---|
//! | [`solid`] | a formula: cylinder, eccentric, elliptic cone, lobes | as the formula says |
//! | [`grid`] | figures on a grid of azimuths and z | along its tangent |
//! | [`cams`] | contours along z, one blending into the next | as it ends |
//! | [`mesh`] | triangles, read as points of a smooth surface | along its tangent |
//!
//! Every surface is C², finite and positive within its ends. How it goes on beyond them is for the insert, which is round: it touches the
//! end of a part while its centre stands beyond it.

pub mod cams;
pub mod grid;
mod key;
pub mod mesh;
pub mod solid;

pub use key::SurfaceKey;

use crate::math::jet::Jet;
use crate::math::units::{TURN_RAD, deg_from_rad};
use cams::{CamAlong, CamStack};
use grid::{GridSpline, SurfaceGrid};
use solid::Solid;
use thiserror::Error;

/// Why something is not the surface of a part.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SurfaceError {
    /// A number that describes the surface is out of its range.
    #[error("{what} is {value}, it must be {allowed}")]
    BadNumber { what: SurfaceKey, value: f64, allowed: &'static str },
    /// The ends of the part are not in order.
    #[error("the part ends at z = {to_mm} mm, it must end above z = {from_mm} mm, where it begins")]
    NoLength {
        /// Start (mm).
        from_mm: f64,
        /// End (mm).
        to_mm: f64,
    },
    /// Too few, or too many, of something.
    #[error("{count} {what}, there must be {min} to {max}")]
    Count {
        what: SurfaceKey,
        /// Given number.
        count: usize,
        min: usize,
        max: usize,
    },
    /// A grid is not as large as its axes say.
    #[error("a grid of {angles} azimuths and {rows} rows has {count} radii, not {wanted}")]
    GridSize { angles: usize, rows: usize, count: usize, wanted: usize },
    /// A radius of a grid is not a positive number.
    #[error("row {row}, azimuth {azimuth_deg:.3} deg: radius {radius_mm} mm is not a positive number")]
    BadRadius {
        /// Row of the grid, from 0.
        row: usize,
        /// Azimuth (deg).
        azimuth_deg: f64,
        /// Given value (mm).
        radius_mm: f64,
    },
    /// z does not increase.
    #[error("row {row}: z = {z_mm} mm does not increase (previous {previous_mm} mm)")]
    ZNotIncreasing {
        /// Row, from 0.
        row: usize,
        /// Its z (mm).
        z_mm: f64,
        /// The one before (mm).
        previous_mm: f64,
    },
    /// Azimuths are not equal steps of a turn.
    #[error("column {column}: azimuth {azimuth_deg:.6} deg, equal steps of a turn would have {wanted_deg:.6} deg")]
    UnevenAzimuth {
        /// Column, from 0.
        column: usize,
        /// Its azimuth (deg).
        azimuth_deg: f64,
        /// Azimuth of equal steps (deg).
        wanted_deg: f64,
    },
    /// The surface does not close after a turn.
    #[error("row {row}: the radius after a turn differs by {gap_mm:e} mm from the first; allowed: {bound_mm:e} mm")]
    NotClosed {
        /// Row, from 0.
        row: usize,
        /// Difference (mm).
        gap_mm: f64,
        /// Allowed (mm).
        bound_mm: f64,
    },
    /// The surface reaches the axis.
    #[error(
        "the radius at azimuth {azimuth_deg:.2} deg, z = {z_mm:.3} mm is {radius_mm:.4} mm, it must stay above {bound_mm} mm"
    )]
    ReachesAxis {
        /// Azimuth (deg).
        azimuth_deg: f64,
        /// z (mm).
        z_mm: f64,
        /// Radius there (mm).
        radius_mm: f64,
        /// Lower bound, exclusive (mm).
        bound_mm: f64,
    },
    /// A cam's outline is too rough for its spline.
    #[error(
        "the outline of cam {cam} bends too sharply: {knots} knots leave {error_mm:e} mm; allowed: {bound_mm:e} mm"
    )]
    RoughCam {
        /// Which cam, from 0.
        cam: usize,
        knots: usize,
        /// Remaining error (mm).
        error_mm: f64,
        /// Allowed (mm).
        bound_mm: f64,
    },
    /// Two triangles lie behind one another.
    #[error(
        "at azimuth {azimuth_deg:.2} deg, z = {z_mm:.3} mm the mesh has radius {radius_mm:.4} mm and {other_mm:.4} mm: a part to be \
         turned has one"
    )]
    TwoRadii {
        /// Azimuth (deg).
        azimuth_deg: f64,
        /// z (mm).
        z_mm: f64,
        /// One radius (mm).
        radius_mm: f64,
        /// The other (mm).
        other_mm: f64,
    },
    /// A mesh with a hole.
    #[error(
        "no triangle covers azimuth {azimuth_deg:.2} deg, z = {z_mm:.3} mm: the mesh must go round the axis without a hole"
    )]
    Hole {
        /// Azimuth (deg).
        azimuth_deg: f64,
        /// z (mm).
        z_mm: f64,
    },
    /// Triangles that do not close around the axis, though they say something everywhere.
    #[error(
        "the triangles cover {share:.6} of the turn and length that they span, it must be 1: one is missing, or there twice"
    )]
    OpenMesh {
        /// Area in azimuth and z that they cover, of the whole.
        share: f64,
    },
    /// No smooth surface goes through the corners of a mesh.
    #[error(
        "the corner at azimuth {azimuth_deg:.2} deg, z = {z_mm:.3} mm lies {off_mm:.6} mm off the smoothest surface through the mesh; \
         allowed: {bound_mm} mm"
    )]
    RoughMesh {
        /// Azimuth (deg).
        azimuth_deg: f64,
        /// z (mm).
        z_mm: f64,
        /// Distance (mm).
        off_mm: f64,
        /// Allowed (mm).
        bound_mm: f64,
    },
}

/// The radius and how it changes, at one place of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SurfacePoint {
    /// Distance from the spindle axis r (mm).
    pub radius_mm: f64,
    /// ∂r/∂φ (mm/rad).
    pub by_azimuth: f64,
    /// ∂r/∂z (mm/mm).
    pub by_z: f64,
    /// ∂²r/∂φ² (mm/rad²).
    pub by_azimuth_twice: f64,
    /// ∂²r/∂φ∂z (1/rad).
    pub by_azimuth_and_z: f64,
    /// ∂²r/∂z² (1/mm).
    pub by_z_twice: f64,
}

impl SurfacePoint {
    /// Azimuth of the outward normal's part across the axis, beyond that of the point: −atan(r′/r) over the azimuth (rad).
    #[must_use]
    pub fn normal_lead_rad(&self) -> f64 {
        -libm::atan2(self.by_azimuth, self.radius_mm)
    }
}

impl From<Jet> for SurfacePoint {
    fn from(jet: Jet) -> Self {
        Self {
            radius_mm: jet.value,
            by_azimuth: jet.a,
            by_z: jet.z,
            by_azimuth_twice: jet.aa,
            by_azimuth_and_z: jet.az,
            by_z_twice: jet.zz,
        }
    }
}

/// Bounds of a surface within a range of z; see [`Surface::bounds`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceBounds {
    /// Least radius (mm).
    pub min_mm: f64,
    /// Azimuth (rad) and z (mm) near which it is least.
    pub min_at: (f64, f64),
    /// Largest radius (mm).
    pub largest_mm: f64,
    /// Largest |∂r/∂φ| (mm/rad).
    pub steepest_mm_rad: f64,
    /// Largest |∂r/∂φ|/r.
    pub steepest_ratio: f64,
    /// Azimuth (rad) and z (mm) near which it is largest.
    pub steepest_at: (f64, f64),
    /// Largest |∂r/∂z|.
    pub steepest_along: f64,
}

#[derive(Debug, Clone, PartialEq)]
enum SurfaceShape {
    Solid(Solid),
    Grid(GridSpline),
    Cams(CamStack),
}

/// The surface of a part.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    shape: SurfaceShape,
    from_mm: f64,
    to_mm: f64,
}

/// Longest part (mm): far beyond any lathe, and small enough that nothing overflows.
const LONGEST_MM: f64 = 1e5;

/// Azimuths and rows on which bounds are looked for.
const BOUNDS_GRID: (u32, u32) = (720, 64);

impl Surface {
    /// A solid by formula between two z (mm).
    ///
    /// # Errors
    /// Ends that are not in order; a formula with numbers out of range, or one that reaches the axis.
    pub fn solid(solid: Solid, from_mm: f64, to_mm: f64) -> Result<Self, SurfaceError> {
        solid.check()?;
        Self::checked(SurfaceShape::Solid(solid), from_mm, to_mm)
    }

    /// The C² surface through radii on a grid.
    ///
    /// # Errors
    /// See [`SurfaceGrid`]; a spline between the radii that reaches the axis.
    pub fn grid(grid: &SurfaceGrid) -> Result<Self, SurfaceError> {
        let spline = GridSpline::new(grid)?;
        let (from_mm, to_mm) = spline.ends_mm();
        Self::checked(SurfaceShape::Grid(spline), from_mm, to_mm)
    }

    /// Cams along z.
    ///
    /// # Errors
    /// See [`CamAlong`].
    pub fn cams(cams: &[CamAlong<'_>]) -> Result<Self, SurfaceError> {
        let stack = CamStack::new(cams)?;
        let (from_mm, to_mm) = stack.ends_mm();
        Self::checked(SurfaceShape::Cams(stack), from_mm, to_mm)
    }

    fn checked(shape: SurfaceShape, from_mm: f64, to_mm: f64) -> Result<Self, SurfaceError> {
        for (what, value) in [(SurfaceKey::Begin, from_mm), (SurfaceKey::End, to_mm)] {
            if !value.is_finite() || value.abs() > LONGEST_MM {
                return Err(SurfaceError::BadNumber { what, value, allowed: "within ±1e5 mm" });
            }
        }
        if to_mm <= from_mm {
            return Err(SurfaceError::NoLength { from_mm, to_mm });
        }
        let surface = Self { shape, from_mm, to_mm };
        let bounds = surface.bounds(from_mm, to_mm);
        if !bounds.min_mm.is_finite() || !bounds.largest_mm.is_finite() || bounds.min_mm <= 0.0 {
            let (azimuth_rad, z_mm) = bounds.min_at;
            let radius_mm = surface.radius(azimuth_rad, z_mm);
            return Err(SurfaceError::ReachesAxis {
                azimuth_deg: deg_from_rad(azimuth_rad),
                z_mm,
                radius_mm: radius_mm.min(bounds.min_mm),
                bound_mm: 0.0,
            });
        }
        Ok(surface)
    }

    /// Start and end along the axis (mm).
    #[must_use]
    pub fn ends_mm(&self) -> (f64, f64) {
        (self.from_mm, self.to_mm)
    }

    /// Distance from the spindle axis (mm) at an azimuth of the part (rad) and z (mm).
    #[must_use]
    pub fn radius(&self, azimuth_rad: f64, z_mm: f64) -> f64 {
        self.point(azimuth_rad, z_mm).radius_mm
    }

    /// Radius and derivatives at an azimuth of the part (rad) and z (mm).
    #[must_use]
    #[inline]
    pub fn point(&self, azimuth_rad: f64, z_mm: f64) -> SurfacePoint {
        match &self.shape {
            SurfaceShape::Solid(solid) => solid.jet(azimuth_rad, z_mm).into(),
            SurfaceShape::Grid(spline) => spline.point(azimuth_rad, z_mm),
            SurfaceShape::Cams(stack) => stack.point(azimuth_rad, z_mm),
        }
    }

    /// Bounds of radius and slopes between two z (mm), and the positions at which they are approached. Computed on a grid at least as fine
    /// as the data of the surface, and widened by what its own derivatives allow between two grid points; the second derivatives are known
    /// on that grid only and are therefore increased by half.
    #[must_use]
    pub fn bounds(&self, from_mm: f64, to_mm: f64) -> SurfaceBounds {
        let (angles, rows) = self.looked_at();
        let azimuth_step = TURN_RAD / f64::from(angles);
        let z_step = (to_mm - from_mm) / f64::from(rows);
        let mut bounds = SurfaceBounds {
            min_mm: f64::INFINITY,
            min_at: (0.0, from_mm),
            largest_mm: 0.0,
            steepest_mm_rad: 0.0,
            steepest_ratio: 0.0,
            steepest_at: (0.0, from_mm),
            steepest_along: 0.0,
        };
        let mut second = [0.0_f64; 3];
        for row in 0..=rows {
            let z = from_mm + f64::from(row) * z_step;
            for angle in 0..angles {
                let azimuth = f64::from(angle) * azimuth_step;
                let point = self.point(azimuth, z);
                // What is not a number is worse than any, so that it cannot hide.
                if point.radius_mm < bounds.min_mm || !point.radius_mm.is_finite() {
                    bounds.min_at = (azimuth, z);
                    bounds.min_mm = if point.radius_mm.is_finite() { point.radius_mm } else { f64::NEG_INFINITY };
                }
                let ratio = point.by_azimuth.abs() / point.radius_mm;
                if ratio > bounds.steepest_ratio {
                    bounds.steepest_ratio = ratio;
                    bounds.steepest_at = (azimuth, z);
                }
                bounds.largest_mm = bounds.largest_mm.max(point.radius_mm);
                bounds.steepest_mm_rad = bounds.steepest_mm_rad.max(point.by_azimuth.abs());
                bounds.steepest_along = bounds.steepest_along.max(point.by_z.abs());
                let seconds = [point.by_azimuth_twice, point.by_azimuth_and_z, point.by_z_twice];
                for (largest, value) in second.iter_mut().zip(seconds) {
                    *largest = largest.max(value.abs());
                }
            }
        }
        // The nearest place of the grid is half a step away in both directions.
        let (da, dz) = (0.5 * azimuth_step, 0.5 * z_step.abs());
        let [aa, az, zz] = second.map(|value| 1.5 * value);
        bounds.steepest_mm_rad += da * aa + dz * az;
        bounds.steepest_along += da * az + dz * zz;
        // At an extreme of the grid the slope is what half a step can build up.
        let room = da * (da * aa + dz * az) + dz * (da * az + dz * zz);
        bounds.min_mm -= room;
        bounds.largest_mm += room;
        let slack = if bounds.min_mm > 0.0 { (da * aa + dz * az) / bounds.min_mm } else { 0.0 };
        bounds.steepest_ratio += slack;
        bounds
    }

    /// Azimuths and rows on which every feature of the surface is seen, as many as that may be.
    pub(crate) fn looked_at(&self) -> (u32, u32) {
        let (angles, rows) = match &self.shape {
            SurfaceShape::Solid(solid) => (solid.grid(), BOUNDS_GRID.1),
            // Its own azimuths hold all the data; they may be many.
            SurfaceShape::Grid(spline) => return spline.fine_grid(),
            SurfaceShape::Cams(stack) => stack.fine_grid(),
        };
        (angles.max(BOUNDS_GRID.0), rows.max(BOUNDS_GRID.1))
    }
}
