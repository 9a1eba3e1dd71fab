// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Tolerances of following a trajectory, by the rules of `control_msgs/JointTolerance`.

use super::quantity::MotionQuantity;
use crate::machine::description::{AXIS_COUNT, Axis};
use core::fmt;
use thiserror::Error;

/// A negative tolerance other than −1.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("joint {}: {quantity} tolerance {value} is negative; 0 takes the default, -1 means none", axis.joint())]
pub struct InvalidTolerance {
    pub axis: Axis,
    pub quantity: MotionQuantity,
    pub value: f64,
}

/// Tolerances of one axis; `None` means any error is allowed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tolerance {
    pub position: Option<f64>,
    /// mm/s or rad/s.
    pub velocity: Option<f64>,
    /// mm/s² or rad/s².
    pub acceleration: Option<f64>,
}

impl Tolerance {
    /// The tolerance a client asks for over these defaults: above 0 its value, 0 the default, −1 none.
    ///
    /// # Errors
    /// Any other negative value, or one that is not a number.
    pub fn requested(self, axis: Axis, asked: [f64; 3]) -> Result<Self, InvalidTolerance> {
        let resolve = |quantity, default: Option<f64>, value: f64| {
            if value > 0.0 {
                Ok(Some(value))
            } else if libm::fabs(value) <= f64::EPSILON {
                Ok(default)
            } else if libm::fabs(value + 1.0) <= f64::EPSILON {
                Ok(None)
            } else {
                Err(InvalidTolerance { axis, quantity, value })
            }
        };
        Ok(Self {
            position: resolve(MotionQuantity::Position, self.position, asked[0])?,
            velocity: resolve(MotionQuantity::Velocity, self.velocity, asked[1])?,
            acceleration: resolve(MotionQuantity::Acceleration, self.acceleration, asked[2])?,
        })
    }
}

/// Desired minus actual of one axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FollowingState {
    pub position: f64,
    /// mm/s or rad/s.
    pub velocity: f64,
    /// mm/s² or rad/s².
    pub acceleration: f64,
}

/// Tolerances for following a trajectory; none by default.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FollowingTolerances {
    /// On the way, per axis.
    pub path: [Tolerance; AXIS_COUNT],
    /// At the end, per axis.
    pub goal: [Tolerance; AXIS_COUNT],
    /// Ticks after the end within which every axis must be inside its goal tolerance; `None`: as long as it takes.
    pub goal_time_ticks: Option<u64>,
}

impl FollowingTolerances {
    /// Something is to be kept at the end.
    #[must_use]
    pub fn has_goal(&self) -> bool {
        self.goal.iter().any(|tolerance| *tolerance != Tolerance::default())
    }
}

/// Phase of the motion in which a tolerance was violated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionPhase {
    Path,
    /// After the end, when the time for it was over.
    Goal,
}

/// Which joint broke which tolerance, by how much, and when.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToleranceViolation {
    pub axis: Axis,
    pub quantity: MotionQuantity,
    pub error: f64,
    /// Allowed value.
    pub allowed: f64,
    /// On the way or at the end.
    pub stretch: MotionPhase,
    /// Time of the trajectory (s from its start, held time not counted); at the end: how long after it.
    pub time_s: f64,
}

impl fmt::Display for ToleranceViolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = self.quantity.unit(self.axis);
        write!(
            f,
            "{}: {} error {:.6} {unit} exceeds {:.6} {unit} by {:.6} {unit} {:.3} s after the {}",
            self.axis.joint(),
            self.quantity,
            self.error,
            self.allowed,
            libm::fabs(self.error) - self.allowed,
            self.time_s,
            match self.stretch {
                MotionPhase::Path => "start",
                MotionPhase::Goal => "end",
            }
        )
    }
}

/// The first tolerance broken, in the order of the axes, or `None`.
#[must_use]
pub fn violation(
    tolerances: &[Tolerance; AXIS_COUNT],
    errors: &[FollowingState; AXIS_COUNT],
    stretch: MotionPhase,
    time_s: f64,
) -> Option<ToleranceViolation> {
    for axis in Axis::ALL {
        let (tolerance, error) = (&tolerances[axis.index()], &errors[axis.index()]);
        for (quantity, allowed, error) in [
            (MotionQuantity::Position, tolerance.position, error.position),
            (MotionQuantity::Velocity, tolerance.velocity, error.velocity),
            (MotionQuantity::Acceleration, tolerance.acceleration, error.acceleration),
        ] {
            if let Some(allowed) = allowed
                && libm::fabs(error) > allowed
            {
                return Some(ToleranceViolation { axis, quantity, error, allowed, stretch, time_s });
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::string::ToString;

    #[test]
    fn zero_takes_the_default_minus_one_none_and_other_negatives_are_refused() {
        let default = Tolerance { position: Some(0.1), velocity: None, acceleration: None };
        let asked = default.requested(Axis::X, [0.0, -1.0, 5.0]).expect("legal");
        assert_eq!(asked, Tolerance { position: Some(0.1), velocity: None, acceleration: Some(5.0) });
        assert_eq!(default.requested(Axis::X, [-1.0, 0.0, 0.0]).expect("legal").position, None);
        assert_eq!(
            default.requested(Axis::X, [-2.0, 0.0, 0.0]),
            Err(InvalidTolerance { axis: Axis::X, quantity: MotionQuantity::Position, value: -2.0 })
        );
        assert!(default.requested(Axis::X, [f64::NAN, 0.0, 0.0]).is_err());
    }

    #[test]
    fn a_violation_names_joint_tolerance_and_amount() {
        let mut tolerances = [Tolerance::default(); AXIS_COUNT];
        tolerances[1].position = Some(0.5);
        let mut errors = [FollowingState { position: 9.0, velocity: 9.0, acceleration: 9.0 }; AXIS_COUNT];
        errors[1].position = -0.75;
        let violation = violation(&tolerances, &errors, MotionPhase::Path, 1.25).expect("broken");
        let text = "x_axis: position error -0.750000 mm exceeds 0.500000 mm by 0.250000 mm 1.250 s after the start";
        assert_eq!(violation.to_string(), text);
        errors[1].position = 0.5;
        assert_eq!(super::violation(&tolerances, &errors, MotionPhase::Path, 1.25), None);
    }
}
