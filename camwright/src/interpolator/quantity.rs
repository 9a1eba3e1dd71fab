// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Derivatives of a position, with their units.

use crate::machine::description::Axis;
use core::fmt;

/// Derivative of a position that a limit or a tolerance bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionQuantity {
    Position,
    /// mm/s or rad/s.
    Velocity,
    /// mm/s² or rad/s².
    Acceleration,
    /// mm/s³ or rad/s³.
    Jerk,
}

impl MotionQuantity {
    /// Its unit for an axis.
    #[must_use]
    pub const fn unit(self, axis: Axis) -> &'static str {
        match (self, axis) {
            (MotionQuantity::Position, Axis::C) => "rad",
            (MotionQuantity::Velocity, Axis::C) => "rad/s",
            (MotionQuantity::Acceleration, Axis::C) => "rad/s^2",
            (MotionQuantity::Jerk, Axis::C) => "rad/s^3",
            (MotionQuantity::Position, _) => "mm",
            (MotionQuantity::Velocity, _) => "mm/s",
            (MotionQuantity::Acceleration, _) => "mm/s^2",
            (MotionQuantity::Jerk, _) => "mm/s^3",
        }
    }
}

impl fmt::Display for MotionQuantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            MotionQuantity::Position => "position",
            MotionQuantity::Velocity => "velocity",
            MotionQuantity::Acceleration => "acceleration",
            MotionQuantity::Jerk => "jerk",
        })
    }
}
