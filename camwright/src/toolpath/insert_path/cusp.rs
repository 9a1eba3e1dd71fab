// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The cusps that a feed must leave on a surface, whatever turns it.
//!
//! At a turned angle the insert's centre advances by c once a turn, parallel to the section's tangent, and the place where it touches by
//! s = c/(1 − Rκ), κ being the section's curvature, positive where it is hollow: between two touches edge and section part by
//! s²/8 · (1/R − κ) = c²/8R/(1 − Rκ). Seen along the normal of the surface, which leans out of the rake plane by some angle, it is that
//! times the cosine.

use super::{InsertFeed, InsertPath, InsertPathError};
use crate::cam::surface::Surface;
use crate::math::units::TURN_RAD;
use crate::toolpath::rake_section::{RakeSection, SectionPoint};

/// The highest cusp of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cusp {
    /// Height along the normal of the surface (mm).
    pub height_mm: f64,
    /// Turned angle θ (rad), in 0..2π.
    pub turned_rad: f64,
    /// z (mm).
    pub z_mm: f64,
}

/// Turned angles of a turn, and places along z, at which cusps are looked at.
const ANGLES: u32 = 180;
const ROWS: u32 = 200;

/// Least 1 − Rκ at which a section can be touched all along.
const MIN_OPEN: f64 = 0.02;

impl InsertPath {
    /// The highest cusp that this path must leave on the surface between two z (mm).
    ///
    /// # Errors
    /// A surface that has no section there.
    pub fn highest_cusp(&self, surface: &Surface, from_mm: f64, to_mm: f64) -> Result<Cusp, InsertPathError> {
        let request = self.request();
        let section = RakeSection::new(surface, request.plane_y_mm, from_mm, to_mm)?;
        let mut highest = Cusp { height_mm: 0.0, turned_rad: 0.0, z_mm: from_mm };
        for angle in 0..ANGLES {
            let turned_rad = TURN_RAD * f64::from(angle) / f64::from(ANGLES);
            for row in 0..=ROWS {
                let z_mm = from_mm + (to_mm - from_mm) * f64::from(row) / f64::from(ROWS);
                let height_mm = height_mm(&section.point(turned_rad, z_mm)?, request.feed, request.insert_radius_mm);
                if height_mm > highest.height_mm {
                    highest = Cusp { height_mm, turned_rad, z_mm };
                }
            }
        }
        Ok(highest)
    }
}

fn height_mm(point: &SectionPoint, feed: InsertFeed, insert_radius_mm: f64) -> f64 {
    let steep = libm::sqrt(1.0 + point.by_z * point.by_z);
    // The insert does not touch a section as hollow as its own radius: that is reported as a hollow, not as a cusp.
    let open = 1.0 - insert_radius_mm * point.hollow();
    if open < MIN_OPEN {
        return 0.0;
    }
    let in_plane_mm = match feed {
        InsertFeed::AlongZ(feed_mm) => (feed_mm * steep) * (feed_mm * steep) / open,
        InsertFeed::AlongCurve(feed_mm) => feed_mm * feed_mm * open,
    } / (8.0 * insert_radius_mm);
    // (1, −r′/r, −r_z) outward, round and along the part; the section's normal is (1, −dx/dz) in x and z, and x leans by ψ.
    let (round, along) = (-point.surface.by_azimuth / point.surface.radius_mm, -point.surface.by_z);
    let (sin, cos) = (libm::sin(point.lead_rad), libm::cos(point.lead_rad));
    let length = libm::sqrt(1.0 + round * round + along * along);
    let lean = (cos - round * sin - point.by_z * along) / (steep * length);
    in_plane_mm * lean
}
