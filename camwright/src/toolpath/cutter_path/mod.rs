// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Motion of a milling cutter over one turn of the part: the axes of its carriage over the turned angle, for foreign machines.
//!
//! Angles are azimuths of the cutter's carriage seen from the part (θ = σ·C, with the lobe's phase taken off), so that a path is the part's
//! and not the machine's; it is closed, and read in the direction of growing θ.

pub mod face;

use crate::math::periodic_spline::{PeriodicSpline, Sample};
use crate::toolpath::wheel_path::ToolPath;
use alloc::string::String;
use alloc::vec::Vec;

/// A linear axis of a cutter's carriage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum CarriageAxis {
    /// Away from the spindle axis.
    X,
    /// Across X and the spindle axis, in the direction in which the azimuth grows.
    Y,
    /// Along the spindle axis.
    Z,
}

impl CarriageAxis {
    #[must_use]
    pub const fn letter(self) -> char {
        match self {
            CarriageAxis::X => 'X',
            CarriageAxis::Y => 'Y',
            CarriageAxis::Z => 'Z',
        }
    }
}

/// Travel of one axis over a turn.
#[derive(Debug, Clone, PartialEq)]
pub struct Travel {
    pub axis: CarriageAxis,
    /// Its position over the azimuth (mm over rad).
    pub position: PeriodicSpline,
}

/// A turn of a cutter at its full depth.
#[derive(Debug, Clone, PartialEq)]
pub struct CutterPath {
    /// Name, for people: `contour`, `inner wall`.
    pub name: String,
    /// Axes that move with C, each once, in the order of their letters.
    pub travels: Vec<Travel>,
    /// Axis along which the cutter comes to its depth. Its positive direction leads out of the part.
    pub infeed: CarriageAxis,
}

impl CutterPath {
    /// A contour by the periphery of a cutter whose axis is parallel to the part's, as a wheel of its radius grinds it: X of its centre. What
    /// is to be left on the contour counts as radius of that wheel.
    #[must_use]
    pub fn from_periphery(path: &ToolPath) -> Self {
        Self::round("contour", path, CarriageAxis::X)
    }

    /// X of the centre of what goes round as a wheel.
    pub(crate) fn round(name: &str, path: &ToolPath, infeed: CarriageAxis) -> Self {
        let position = path.spline().raised(path.wheel_radius_mm());
        Self { name: name.into(), travels: [Travel { axis: CarriageAxis::X, position }].into(), infeed }
    }

    /// Position of an axis and its derivatives (mm, mm/rad, …) at an azimuth (rad); `None` for one that does not move with C.
    #[must_use]
    pub fn sample(&self, axis: CarriageAxis, azimuth_rad: f64) -> Option<Sample> {
        self.travels.iter().find(|travel| travel.axis == axis).map(|travel| travel.position.sample(azimuth_rad))
    }
}
