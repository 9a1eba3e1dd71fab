// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Motion of a milling cutter along its feature: the axes of its carriage over the turned angle, for foreign machines.
//!
//! Angles are azimuths of the cutter's carriage seen from the part (θ = σ·C, with the lobe's phase taken off), so that a path is the part's
//! and not the machine's. It is read in the direction of growing θ. It closes after one turn, or along a groove after several; an open groove
//! has two ends.

pub mod face;

use crate::math::hermite::HermiteSpline;
use crate::math::periodic_spline::{PeriodicSpline, Sample};
use crate::math::units::TURN_RAD;
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

/// Position of an axis over the azimuth (mm over rad).
#[derive(Debug, Clone, PartialEq)]
pub enum TravelCurve {
    /// It closes: one turn of the spline is so many turns of the part.
    Closed { spline: PeriodicSpline, turns: u32 },
    /// It has two ends, at azimuth 0 and at its last knot, and stands beyond them.
    Open(HermiteSpline),
}

impl From<PeriodicSpline> for TravelCurve {
    fn from(spline: PeriodicSpline) -> Self {
        TravelCurve::Closed { spline, turns: 1 }
    }
}

impl TravelCurve {
    /// Position and derivatives at an azimuth (rad).
    #[must_use]
    pub fn sample(&self, azimuth_rad: f64) -> Sample {
        match self {
            TravelCurve::Closed { spline, turns: 1 } => spline.sample(azimuth_rad),
            TravelCurve::Closed { spline, turns } => {
                let turns = f64::from(*turns);
                spline.sample(azimuth_rad / turns).stretched(turns)
            }
            TravelCurve::Open(spline) => spline.sample(azimuth_rad),
        }
    }

    /// The same with a constant added.
    #[must_use]
    pub fn raised(&self, by_mm: f64) -> Self {
        match self {
            TravelCurve::Closed { spline, turns } => {
                TravelCurve::Closed { spline: spline.raised(by_mm), turns: *turns }
            }
            TravelCurve::Open(spline) => TravelCurve::Open(spline.raised(by_mm)),
        }
    }

    /// Positions between which it stays (mm): the hull of its control points.
    #[must_use]
    pub fn hull_mm(&self) -> (f64, f64) {
        let wider = |(low, high): (f64, f64), mm: f64| (low.min(mm), high.max(mm));
        let nothing = (f64::INFINITY, f64::NEG_INFINITY);
        match self {
            TravelCurve::Closed { spline, .. } => spline.coefficients().iter().copied().fold(nothing, wider),
            TravelCurve::Open(spline) => spline.control_points().fold(nothing, wider),
        }
    }

    /// Azimuth over which it runs once (rad).
    #[must_use]
    pub fn span_rad(&self) -> f64 {
        match self {
            TravelCurve::Closed { turns, .. } => f64::from(*turns) * TURN_RAD,
            TravelCurve::Open(spline) => spline.end(),
        }
    }
}

/// Travel of one axis along a feature.
#[derive(Debug, Clone, PartialEq)]
pub struct Travel {
    pub axis: CarriageAxis,
    pub position: TravelCurve,
}

/// A run of a cutter along its feature at full depth.
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
        let position = position.into();
        Self { name: name.into(), travels: [Travel { axis: CarriageAxis::X, position }].into(), infeed }
    }

    /// Azimuth over which it runs once (rad): one turn, along a groove perhaps several. All its axes have the same.
    #[must_use]
    pub fn span_rad(&self) -> f64 {
        self.travels.first().map_or(TURN_RAD, |travel| travel.position.span_rad())
    }

    /// Turns of the part over which it runs once, begun ones included.
    #[must_use]
    pub fn turns(&self) -> u32 {
        #[allow(clippy::cast_possible_truncation, reason = "some turns")]
        let turns = libm::ceil(self.span_rad() / TURN_RAD - 1e-9).clamp(1.0, 1e6) as u32;
        turns
    }

    /// Returns whether it has two ends, at azimuth 0 and at [`Self::span_rad`].
    #[must_use]
    pub fn is_open(&self) -> bool {
        matches!(self.travels.first(), Some(Travel { position: TravelCurve::Open(_), .. }))
    }

    /// Position of an axis and its derivatives (mm, mm/rad, …) at an azimuth (rad); `None` for one that does not move with C.
    #[must_use]
    pub fn sample(&self, axis: CarriageAxis, azimuth_rad: f64) -> Option<Sample> {
        self.travels.iter().find(|travel| travel.axis == axis).map(|travel| travel.position.sample(azimuth_rad))
    }
}
