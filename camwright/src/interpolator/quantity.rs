//! Derivatives of a position, with their units.

use crate::machine::description::Axis;
use core::fmt;

/// Derivative of a position that a limit or a tolerance bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    Position,
    /// mm/s or rad/s.
    Velocity,
    /// mm/s² or rad/s².
    Acceleration,
    /// mm/s³ or rad/s³.
    Jerk,
}

impl Quantity {
    /// Its unit for an axis.
    #[must_use]
    pub const fn unit(self, axis: Axis) -> &'static str {
        match (self, axis) {
            (Quantity::Position, Axis::C) => "rad",
            (Quantity::Velocity, Axis::C) => "rad/s",
            (Quantity::Acceleration, Axis::C) => "rad/s^2",
            (Quantity::Jerk, Axis::C) => "rad/s^3",
            (Quantity::Position, _) => "mm",
            (Quantity::Velocity, _) => "mm/s",
            (Quantity::Acceleration, _) => "mm/s^2",
            (Quantity::Jerk, _) => "mm/s^3",
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Quantity::Position => "position",
            Quantity::Velocity => "velocity",
            Quantity::Acceleration => "acceleration",
            Quantity::Jerk => "jerk",
        })
    }
}
