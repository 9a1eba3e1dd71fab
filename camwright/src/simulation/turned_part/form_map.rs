// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Form error of a turned part over azimuth and axial position: the map, its extreme positions, and the cusps of the feed.

use super::TurnedPart;
use crate::cam::surface::SurfacePoint;
use crate::math::range::minimum_and_maximum;
use crate::math::units::TURN_RAD;
use alloc::vec::Vec;
use thiserror::Error;

/// Why there is no map.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum FormMapError {
    /// No column between these places.
    #[error("the part has no column from {from_mm} to {to_mm} mm")]
    NoColumns {
        /// First place (mm).
        from_mm: f64,
        /// Last place (mm).
        to_mm: f64,
    },
    /// The design has no surface there.
    #[error("the design has the radius {radius_mm} mm at {azimuth_deg:.3} deg and z {z_mm:.3} mm")]
    NoSurface {
        /// Azimuth (degrees).
        azimuth_deg: f64,
        /// Place along the part (mm).
        z_mm: f64,
        /// Radius there (mm).
        radius_mm: f64,
    },
}

/// A deviation with its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FormPoint {
    /// Material above the design along its normal (mm); below it negative.
    pub deviation_mm: f64,
    /// Azimuth from the keyway (rad).
    pub azimuth_rad: f64,
    /// Place along the part (mm).
    pub z_mm: f64,
}

/// Deviations of some cells together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FormBin {
    /// The lowest (mm).
    pub min_mm: f64,
    /// The highest (mm).
    pub max_mm: f64,
    /// Their mean (mm).
    pub mean_mm: f64,
}

/// Cusps along the axis, from valley to peak within one feed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cusps {
    /// The highest (mm).
    pub max_mm: f64,
    /// Their mean (mm).
    pub mean_mm: f64,
}

/// Deviations of a part from its design along the design's normal, for every cell between two places.
#[derive(Debug, Clone, PartialEq)]
pub struct FormMap {
    azimuths: usize,
    /// Places of its columns (mm).
    places: Vec<f64>,
    /// Column by column (mm).
    deviations: Vec<f64>,
}

impl FormMap {
    /// The map of a part between two places along it (mm), against a design by azimuth from the keyway (rad) and place (mm).
    ///
    /// A cell at radius r stands (r − d)/√(1 + (δ/d)² + ζ²) above a design d(φ, z) with the derivatives δ and ζ, to first order: a
    /// deviation e is off by e²κ/2, κ being the curvature of the design. Between its cells the map knows nothing.
    ///
    /// # Errors
    /// No column between the places, a design without a surface.
    pub fn new(
        part: &TurnedPart,
        design: impl Fn(f64, f64) -> SurfacePoint,
        from_mm: f64,
        to_mm: f64,
    ) -> Result<Self, FormMapError> {
        let grid = part.grid();
        let within = |z: f64| z >= from_mm - 1e-9 && z <= to_mm + 1e-9;
        let columns: Vec<usize> = (0..grid.columns).filter(|column| within(grid.z_mm(*column))).collect();
        if columns.is_empty() {
            return Err(FormMapError::NoColumns { from_mm, to_mm });
        }
        let mut deviations = Vec::with_capacity(columns.len() * grid.azimuths);
        for column in &columns {
            let z_mm = grid.z_mm(*column);
            for (index, radius) in part.column_mm(*column).enumerate() {
                let azimuth_rad = grid.azimuth_rad(index);
                let SurfacePoint { radius_mm, by_azimuth, by_z, .. } = design(azimuth_rad, z_mm);
                let across = by_azimuth / radius_mm;
                let deviation = (radius - radius_mm) / libm::sqrt(1.0 + across * across + by_z * by_z);
                if !(radius_mm > 0.0 && deviation.is_finite()) {
                    let azimuth_deg = crate::math::units::deg_from_rad(azimuth_rad);
                    return Err(FormMapError::NoSurface { azimuth_deg, z_mm, radius_mm });
                }
                deviations.push(deviation);
            }
        }
        let places = columns.into_iter().map(|column| grid.z_mm(column)).collect();
        Ok(Self { azimuths: grid.azimuths, places, deviations })
    }

    /// Azimuths of a turn.
    #[must_use]
    pub fn azimuths(&self) -> usize {
        self.azimuths
    }

    /// Places of its columns along the part (mm).
    #[must_use]
    pub fn places_mm(&self) -> &[f64] {
        &self.places
    }

    /// Deviations (mm), all azimuths of the first column first.
    #[must_use]
    pub fn deviations_mm(&self) -> &[f64] {
        &self.deviations
    }

    fn point(&self, index: usize) -> FormPoint {
        FormPoint {
            deviation_mm: self.deviations[index],
            azimuth_rad: TURN_RAD * (index % self.azimuths) as f64 / self.azimuths as f64,
            z_mm: self.places[index / self.azimuths],
        }
    }

    fn extreme(&self, beats: impl Fn(f64, f64) -> bool) -> FormPoint {
        let best = (1..self.deviations.len())
            .fold(0, |best, index| if beats(self.deviations[index], self.deviations[best]) { index } else { best });
        self.point(best)
    }

    /// Most material above the design, the first such place.
    #[must_use]
    pub fn highest(&self) -> FormPoint {
        self.extreme(|one, best| one > best)
    }

    /// Lowest point relative to the design; the first such point.
    #[must_use]
    pub fn lowest(&self) -> FormPoint {
        self.extreme(|one, best| one < best)
    }

    /// Largest deviation either way (mm).
    #[must_use]
    pub fn largest_mm(&self) -> f64 {
        self.highest().deviation_mm.abs().max(self.lowest().deviation_mm.abs())
    }

    /// Root of the mean square (mm).
    #[must_use]
    pub fn rms_mm(&self) -> f64 {
        let sum: f64 = self.deviations.iter().map(|deviation| deviation * deviation).sum();
        libm::sqrt(sum / self.deviations.len() as f64)
    }

    /// Cusps of a tool that goes `feed_mm` along the part in a turn: at every azimuth, from the lowest to the highest cell in stretches as
    /// long as the feed. What the form changes within one is in them. None where no stretch fits, or one has fewer than three columns.
    ///
    /// Peaks and valleys between two columns are missed: with n columns in a feed at most 2/n of the height of a parabola, which is what
    /// a round insert leaves.
    #[must_use]
    #[allow(clippy::cast_possible_truncation, reason = "checked to be between 3 and the columns")]
    pub fn cusps(&self, feed_mm: f64) -> Option<Cusps> {
        let step = (self.places.last()? - self.places.first()?) / (self.places.len() as f64 - 1.0);
        let columns = libm::round(feed_mm / step);
        if !(columns >= 3.0 && columns < self.places.len() as f64) {
            return None;
        }
        let columns = columns as usize;
        let (mut max_mm, mut sum, mut count) = (0.0_f64, 0.0, 0.0);
        for azimuth in 0..self.azimuths {
            // Valley to valley: both ends of the stretch belong to it.
            for first in (0..self.places.len() - columns).step_by(columns) {
                let cells = (first..=first + columns).map(|column| self.deviations[column * self.azimuths + azimuth]);
                let (min, max) = minimum_and_maximum(cells);
                max_mm = max_mm.max(max - min);
                sum += max - min;
                count += 1.0;
            }
        }
        Some(Cusps { max_mm, mean_mm: sum / count })
    }

    /// The map in no more than so many azimuths and columns, column by column, without losing an extreme: for a report.
    #[must_use]
    pub fn bins(&self, azimuths: usize, columns: usize) -> Vec<FormBin> {
        let azimuths = azimuths.clamp(1, self.azimuths);
        let columns = columns.clamp(1, self.places.len());
        let share = |index: usize, parts: usize, whole: usize| index * whole / parts;
        let mut bins = Vec::with_capacity(azimuths * columns);
        for column in 0..columns {
            let along = share(column, columns, self.places.len())..share(column + 1, columns, self.places.len());
            for azimuth in 0..azimuths {
                let around = share(azimuth, azimuths, self.azimuths)..share(azimuth + 1, azimuths, self.azimuths);
                let mut bin = FormBin { min_mm: f64::INFINITY, max_mm: f64::NEG_INFINITY, mean_mm: 0.0 };
                for column in along.clone() {
                    let start = column * self.azimuths;
                    for deviation in &self.deviations[start + around.start..start + around.end] {
                        bin.min_mm = bin.min_mm.min(*deviation);
                        bin.max_mm = bin.max_mm.max(*deviation);
                        bin.mean_mm += deviation;
                    }
                }
                // A sum of equal figures over their number may differ from them by rounding.
                bin.mean_mm = (bin.mean_mm / (along.len() * around.len()) as f64).clamp(bin.min_mm, bin.max_mm);
                bins.push(bin);
            }
        }
        bins
    }
}
