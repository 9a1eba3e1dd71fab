// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Why a motion cannot be made ready.

use crate::machine::description::Axis;
use crate::motion::point_to_point::PointToPointError;
use alloc::string::String;
use thiserror::Error;

/// Why a motion cannot be executed on this machine.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PrepareError {
    /// A search names an input that the machine lacks.
    #[error("segment {segment}: the machine has no input \"{input}\" to search for")]
    UnknownInput {
        /// Index of the segment.
        segment: usize,
        input: String,
    },
    /// The limits of a move or of a search.
    #[error("segment {segment}: {error}")]
    Move {
        /// Index of the segment.
        segment: usize,
        error: PointToPointError,
    },
    /// A cut names splines that the plan lacks.
    #[error("segment {segment}: a cut names a path, a speed law or an infeed law that is not in the plan")]
    MissingSpline {
        /// Index of the segment.
        segment: usize,
    },
    /// Times of a cut that cannot be.
    #[error(
        "segment {segment}: a plateau from {} s to {} s with turns of {turn_s} s does not lie in a cut of {duration_s} s",
        plateau_s.0, plateau_s.1
    )]
    Plateau {
        /// Index of the segment.
        segment: usize,
        plateau_s: (f64, f64),
        /// Time of a turn given.
        turn_s: f64,
        /// Length of the speed law.
        duration_s: f64,
    },
    /// A cut that no machine could follow, or one that does not fit to the one before or after it.
    #[error("segment {segment}: {what}")]
    BadCut {
        /// Index of the segment.
        segment: usize,
        /// Part that does not fit.
        what: &'static str,
    },
    /// A cut without a length of its stop.
    #[error("segment {segment}: a cut needs a stop of at least 1 tick")]
    NoStop {
        /// Index of the segment.
        segment: usize,
    },
    /// A cut would leave the soft limits of X.
    #[error("segment {segment}: x_axis would go to {x_mm:.4} mm, the soft limit is {bound_mm} mm")]
    SoftLimit {
        /// Index of the segment.
        segment: usize,
        /// Farthest position (mm).
        x_mm: f64,
        /// The bound (mm).
        bound_mm: f64,
    },
    /// A zero is to be set without a search before.
    #[error("segment {segment}: the zero of {} is set, but no search of that axis comes before it", axis.joint())]
    NothingCaught {
        /// Index of the segment.
        segment: usize,
        axis: Axis,
    },
    /// An axis that must be homed has nothing to be homed on.
    #[error("{} has no reference to be homed on", axis.joint())]
    NoReference { axis: Axis },
}
