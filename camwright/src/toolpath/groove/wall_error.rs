// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Error of a mill on the walls of a barrel groove: the swept mill compared with the wall that the roller sweeps.
//!
//! A point of the roller's wall is taken to the part, and from there into the frame of the mill at every azimuth at which it can come
//! near: its distance from the mill's axis, less the mill's radius, is what the mill still has to go, and the least of that is what it
//! leaves. Only the path that is driven enters, not the formula by which it was found.

use super::Wall;
use super::barrel::{BarrelGroove, DEPTHS};
use super::course::RollerCentre;
use crate::math::extremum::golden_section;
use crate::math::units::wrap_period;
use crate::toolpath::cutter_path::{CarriageAxis, CutterPath};
use core::f64::consts::FRAC_PI_2;

/// Error of a wall at one position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallError {
    /// Material left along the wall's normal (mm); negative if the mill cuts into the wall.
    pub error_mm: f64,
    /// Distance of the place from the part's axis (mm).
    pub radius_mm: f64,
    /// Its azimuth (rad), counted on over the turns of the groove.
    pub azimuth_rad: f64,
}

/// The two ends of what a mill does to a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallErrors {
    /// Position with most material left.
    pub max: WallError,
    /// Position with least material left, or the deepest cut.
    pub min: WallError,
}

impl WallErrors {
    /// The larger of the two, by size.
    #[must_use]
    pub fn worst(&self) -> WallError {
        if self.max.error_mm.abs() >= self.min.error_mm.abs() { self.max } else { self.min }
    }
}

/// Azimuths of a turn at which walls are looked at before the worst places are refined.
const AZIMUTHS: u32 = 720;

/// Azimuths of the mill that are tried for a place of a wall, before the nearest is refined.
const TRIED: u32 = 48;

/// A mill comes near a place while the place lies within this share of the roller's radius beside its axis.
const REACH: f64 = 1.1;

/// A mill on its path, seen from a wall that has so much left on it.
struct Swept<'a> {
    groove: &'a BarrelGroove,
    path: &'a CutterPath,
    cutter_radius_mm: f64,
    wall: Wall,
    wall_radius_mm: f64,
    /// Farthest that the roller stands beside the radial line (mm).
    beside_mm: f64,
}

impl BarrelGroove {
    /// Error of a mill on a wall between floor and surface, relative to the intended stock. Material left by its end in the corner of the
    /// floor is not considered, and neither is what another turn of the groove cuts from the wall where they cross.
    #[must_use]
    pub fn wall_errors(&self, path: &CutterPath, cutter_radius_mm: f64, leaves_mm: f64, wall: Wall) -> WallErrors {
        let wall_radius_mm = self.roller_radius_mm() - leaves_mm;
        let (count, span_rad) = (AZIMUTHS * self.course().turns(), self.course().span_rad());
        let angles = (0..count).map(|i| f64::from(i) * span_rad / f64::from(count));
        // Beyond the end faces there is no wall.
        let places = angles
            .clone()
            .filter(|angle| self.is_inside(self.course().centre(*angle).z.value))
            .flat_map(|angle| (0..=DEPTHS).map(move |depth| (angle, f64::from(depth) / f64::from(DEPTHS))));
        let inside = angles.map(|angle| self.course().centre(angle)).filter(|at| self.is_inside(at.z.value));
        let beside_mm = inside.map(|at| at.y.value.abs()).fold(0.0, f64::max);
        let swept = Swept { groove: self, path, cutter_radius_mm, wall, wall_radius_mm, beside_mm };
        let (mut max, mut min) = ((f64::NEG_INFINITY, 0.0, 0.0), (f64::INFINITY, 0.0, 0.0));
        for (angle, share) in places {
            let error = swept.error(angle, share).error_mm;
            if error > max.0 {
                max = (error, angle, share);
            }
            if error < min.0 {
                min = (error, angle, share);
            }
        }
        WallErrors { max: swept.refined(max, -1.0), min: swept.refined(min, 1.0) }
    }
}

impl Swept<'_> {
    /// The place near one of the grid where the error, times a sign, is least.
    fn refined(&self, (_, angle, share): (f64, f64, f64), sign: f64) -> WallError {
        let step = self.groove.course().span_rad() / f64::from(AZIMUTHS * self.groove.course().turns());
        let (angle, _) = golden_section(angle - step, angle + step, &|a| sign * self.error(a, share).error_mm);
        let step = 1.0 / f64::from(DEPTHS);
        let (from, to) = ((share - step).max(0.0), (share + step).min(1.0));
        let (inside, value) = golden_section(from, to, &|share| sign * self.error(angle, share).error_mm);
        // The ends of the depth, where it mostly is, are no places of golden section.
        let best = [
            (inside, value),
            (from, sign * self.error(angle, from).error_mm),
            (to, sign * self.error(angle, to).error_mm),
        ]
        .into_iter()
        .fold((share, f64::INFINITY), |best, new| if new.1 < best.1 { new } else { best });
        self.error(angle, best.0)
    }

    /// Error of the wall that the roller touches at an azimuth, at a share of its depth.
    fn error(&self, angle: f64, share: f64) -> WallError {
        let centre = self.groove.course().centre(angle);
        let x = self.place_along(&centre, share);
        let slope = self.groove.slope(&centre, x);
        let beside = self.wall.side() * self.wall_radius_mm;
        let (y, along) = (centre.y.value - beside * libm::sin(slope), centre.z.value + beside * libm::cos(slope));
        let (radius_mm, azimuth) = (libm::hypot(x, y), angle + libm::atan2(y, x));
        let error_mm = self.left_at(radius_mm, azimuth, along);
        WallError { error_mm, radius_mm, azimuth_rad: wrap_period(azimuth, self.groove.course().span_rad()) }
    }

    /// Place along the roller at a share of the depth: from the floor to where the wall meets the cylinder, x² + y² = R².
    fn place_along(&self, centre: &RollerCentre, share: f64) -> f64 {
        let (floor, outer) = (self.groove.floor_radius_mm(), self.groove.outer_radius_mm());
        let mut surface = outer;
        for _ in 0..SURFACE_STEPS {
            let beside = self.wall.side() * self.wall_radius_mm;
            let y = beside * libm::sin(self.groove.slope(centre, surface)) - centre.y.value;
            surface = libm::sqrt((outer * outer - y * y).max(floor * floor));
        }
        floor + share * (surface - floor)
    }

    /// Least distance of a point of the part from the mill, over all azimuths at which the mill comes near (mm).
    fn left_at(&self, radius_mm: f64, azimuth: f64, along: f64) -> f64 {
        let distance = |carriage: f64| {
            let across = self.path.sample(CarriageAxis::Y, carriage).map_or(0.0, |y| y.value);
            let z = self.path.sample(CarriageAxis::Z, carriage).map_or(0.0, |z| z.value);
            libm::hypot(radius_mm * libm::sin(azimuth - carriage) - across, along - z) - self.cutter_radius_mm
        };
        let share = (REACH * self.groove.roller_radius_mm() + self.beside_mm) / radius_mm;
        let reach = if share < 1.0 { libm::asin(share) } else { FRAC_PI_2 };
        let step = 2.0 * reach / f64::from(TRIED);
        let mut nearest = (azimuth, f64::INFINITY);
        for i in 0..=TRIED {
            let carriage = azimuth - reach + f64::from(i) * step;
            let found = distance(carriage);
            if found < nearest.1 {
                nearest = (carriage, found);
            }
        }
        golden_section(nearest.0 - step, nearest.0 + step, &distance).1.min(nearest.1)
    }
}

/// Steps to where a wall meets the cylinder; each leaves a share of (rr/R)² of what was wrong.
const SURFACE_STEPS: usize = 8;
