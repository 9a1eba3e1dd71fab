// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Errors of measuring the state of a part.

use super::runout::PhasesError;
use crate::math::periodic_spline::PeriodicSplineError;
use crate::math::units::um_from_mm;
use thiserror::Error;

/// Readings that do not determine the state of the part.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StateError {
    /// Not every phase has a cut in the record.
    #[error("depths of cut are known over {known_deg:.2} deg of C, a whole turn is needed")]
    LessThanATurn {
        /// Angle between the first and the last (deg).
        known_deg: f64,
    },
    /// The wheel's log ends before the readings do.
    #[error(
        "wheel positions are logged up to {logged_deg:.3} deg of C, the last cut that the gauge saw is at {needed_deg:.3} deg"
    )]
    LogTooShort {
        /// Last angle of the log (deg).
        logged_deg: f64,
        /// Angle needed (deg).
        needed_deg: f64,
    },
    /// Phases too few for the harmonics, or for anything, or too many.
    #[error("{phases} phases for {harmonics} harmonics: between {min} and {max} are needed")]
    Phases { phases: usize, harmonics: u32, min: usize, max: usize },
    /// More harmonics than any gauge resolves.
    #[error("{harmonics} harmonics, at most {max} are allowed")]
    Harmonics { harmonics: u32, max: u32 },
    /// More unknowns than the readings determine.
    #[error("{readings} readings while every phase was cut cannot determine {harmonics} harmonics")]
    Undetermined { readings: usize, harmonics: u32 },
    /// The readings do not follow the contact law.
    #[error(
        "readings scatter by {:.3} um about the contact law, at most {:.3} um are allowed: gauge, wheel positions or stiffness are wrong",
        um_from_mm(*.scatter_mm), um_from_mm(*.max_mm)
    )]
    Scatter {
        /// Standard deviation found (mm).
        scatter_mm: f64,
        /// Allowed (mm).
        max_mm: f64,
    },
    /// A phase that was not cut.
    #[error(
        "phase {phase_deg:.2} deg was not cut at C = {c_deg:.2} deg: depth {:.3} um, more than {:.3} um are needed",
        um_from_mm(*.depth_mm), um_from_mm(*.min_mm)
    )]
    NotCut {
        /// The phase (deg).
        phase_deg: f64,
        /// Angle of the headstock (deg).
        c_deg: f64,
        /// Its depth of cut, as measured (mm).
        depth_mm: f64,
        /// Least (mm).
        min_mm: f64,
    },
    /// Radii that are no numbers, or too few of them.
    #[error(transparent)]
    Phase(#[from] PhasesError),
    /// Values that make no curve.
    #[error(transparent)]
    Spline(#[from] PeriodicSplineError),
}
