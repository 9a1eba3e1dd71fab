// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The axes by name, how they count, and what they may do.

use crate::math::units::TURN_RAD;

/// Index of an axis in everything that has one value per axis. The order is that of the setpoint message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub enum Axis {
    /// Headstock: rotates the part. Continuous, positive turns the part clockwise seen from +Z when `rotation_sense` is +1.
    #[default]
    C = 0,
    /// Wheelhead: distance of the wheel's cutting point from the spindle axis, + away from the part.
    X = 1,
    /// Table: moves the part along its axis past the wheel.
    Z = 2,
}

crate::snapshot_cases!(Axis { 0 C, 1 X, 2 Z });

impl Axis {
    /// Every axis, in the order of the setpoint message.
    pub const ALL: [Axis; AXIS_COUNT] = [Axis::C, Axis::X, Axis::Z];

    /// Joint name in URDF, joint states, trajectories and parameters.
    #[must_use]
    pub const fn joint(self) -> &'static str {
        match self {
            Axis::C => "c_axis",
            Axis::X => "x_axis",
            Axis::Z => "z_axis",
        }
    }

    /// The axis with this joint name.
    #[must_use]
    pub fn from_joint(joint: &str) -> Option<Axis> {
        Axis::ALL.into_iter().find(|axis| axis.joint() == joint)
    }

    /// Position in arrays with one value per axis.
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }
}

/// Number of axes that take setpoints.
pub const AXIS_COUNT: usize = 3;

/// Scale of an axis: encoder counts per mm (linear) or per turn (rotary).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AxisScale {
    Linear {
        /// Counts per millimetre, at least 1.
        counts_per_mm: i64,
    },
    Rotary {
        /// Counts per turn, at least 1.
        counts_per_turn: i64,
    },
}

impl AxisScale {
    /// Counts per mm or per rad.
    #[must_use]
    pub fn counts_per_unit(self) -> f64 {
        match self {
            AxisScale::Linear { counts_per_mm } => counts_per_mm as f64,
            AxisScale::Rotary { counts_per_turn } => counts_per_turn as f64 / TURN_RAD,
        }
    }

    /// The nearest count to a position (mm or rad).
    #[must_use]
    #[allow(clippy::cast_possible_truncation, reason = "positions are bounded by travel, far inside i64")]
    pub fn counts(self, position: f64) -> i64 {
        libm::round(match self {
            AxisScale::Linear { counts_per_mm } => position * counts_per_mm as f64,
            // The turn is divided out first so that whole turns give whole counts.
            AxisScale::Rotary { counts_per_turn } => position / TURN_RAD * counts_per_turn as f64,
        }) as i64
    }

    /// Position of a count (mm or rad).
    #[must_use]
    pub fn position(self, counts: i64) -> f64 {
        match self {
            AxisScale::Linear { counts_per_mm } => counts as f64 / counts_per_mm as f64,
            AxisScale::Rotary { counts_per_turn } => counts as f64 / counts_per_turn as f64 * TURN_RAD,
        }
    }
}

/// Limits of motion of an axis (mm or rad, s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionLimits {
    /// Largest speed (mm/s or rad/s).
    pub velocity: f64,
    /// Largest acceleration (mm/s² or rad/s²).
    pub acceleration: f64,
    /// Largest jerk (mm/s³ or rad/s³).
    pub jerk: f64,
}

impl MotionLimits {
    /// These limits with the velocity held at or below `velocity` (mm/s or rad/s).
    #[must_use]
    pub fn at_most(self, velocity: f64) -> Self {
        Self { velocity: self.velocity.min(velocity), ..self }
    }

    /// These limits with a share of their acceleration and jerk.
    #[must_use]
    pub fn with_share(self, share: f64) -> Self {
        Self { acceleration: share * self.acceleration, jerk: share * self.jerk, ..self }
    }
}
