// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Limits of the machine, applied to the law of one axis, and the errors of a trajectory.

use super::quantity::MotionQuantity;
use crate::machine::description::{Axis, MachineDescription, MotionLimits};
use crate::math::hermite::HermiteSpline;
use thiserror::Error;

/// Points that make no trajectory that this machine can follow.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TrajectoryError {
    /// No joints, or no points.
    #[error("a trajectory needs at least one joint and one point, not {joints} joints and {points} points")]
    Empty { joints: usize, points: usize },
    /// A joint is named twice.
    #[error("joint {} is named twice", axis.joint())]
    JointTwice { axis: Axis },
    /// A point has another number of values than there are joints.
    #[error("point {point}: {count} {quantity} values for {joints} joints")]
    Size {
        /// Index of the point.
        point: usize,
        quantity: MotionQuantity,
        count: usize,
        joints: usize,
    },
    /// Some points give a quantity and others do not.
    #[error("point {point}: every point or none must give a {quantity}, and accelerations need velocities")]
    Mixed {
        /// First point that differs.
        point: usize,
        quantity: MotionQuantity,
    },
    /// A number is not finite, or a time is negative.
    #[error("point {point}: not a finite number, or a negative time")]
    NotFinite {
        /// Index of the point.
        point: usize,
    },
    /// Times do not increase.
    #[error("point {point}: time {time_s} s does not increase (previous {previous_s} s)")]
    TimeNotIncreasing {
        /// Index of the point.
        point: usize,
        time_s: f64,
        previous_s: f64,
    },
    /// The trajectory does not end at rest.
    #[error("joint {}: the last point moves at {velocity} {}, it must be at rest", axis.joint(), MotionQuantity::Velocity.unit(*axis))]
    EndNotAtRest { axis: Axis, velocity: f64 },
    /// A first point at time 0 that is farther from the axis than allowed.
    #[error(
        "joint {}: the point at time 0 is at {asked} {unit}, the setpoint of the axis at {actual} {unit}; allowed: {allowed} {unit} \
         between them; plan from the present position, or raise the start tolerance",
        axis.joint(), unit = MotionQuantity::Position.unit(*axis)
    )]
    StartsElsewhere {
        axis: Axis,
        /// Position of the point.
        asked: f64,
        /// Setpoint of the axis.
        actual: f64,
        allowed: f64,
    },
    /// A moving joint has no target.
    #[error("joint {} still moves and the new trajectory does not name it", axis.joint())]
    StillMoves { axis: Axis },
    /// A limit of the machine would be exceeded.
    #[error(
        "joint {} at {time_s:.3} s: {quantity} {value:.4} {unit}, the machine allows {bound} {unit}",
        axis.joint(), unit = quantity.unit(*axis)
    )]
    Limit {
        axis: Axis,
        quantity: MotionQuantity,
        /// When it is largest (s from the start).
        time_s: f64,
        value: f64,
        /// Allowed value.
        bound: f64,
    },
}

/// Largest derivatives, or the limit that is exceeded most.
pub(super) fn check_limits(
    axis: Axis,
    law: &HermiteSpline,
    machine: &MachineDescription,
) -> Result<MotionLimits, TrajectoryError> {
    // Derivatives of a quintic have few extremes between knots; 32 points see them to a per mille.
    const POINTS: u32 = 32;
    let description = machine.axis(axis);
    let bounds = [description.limits.velocity, description.limits.acceleration, description.limits.jerk];
    let quantities = [MotionQuantity::Velocity, MotionQuantity::Acceleration, MotionQuantity::Jerk];
    let mut peaks = [0.0_f64; 3];
    let mut worst: Option<(f64, TrajectoryError)> = None;
    let mut farthest: Option<(f64, TrajectoryError)> = None;
    for pair in law.knots().windows(2) {
        for i in 0..=POINTS {
            // Just inside: at a knot itself the third derivative has two values.
            let share = (f64::from(i) / f64::from(POINTS)).clamp(1e-9, 1.0 - 1e-9);
            let time_s = pair[0].at + (pair[1].at - pair[0].at) * share;
            let sample = law.sample(time_s);
            if let Some((low, high)) = description.soft_limits {
                let beyond = (low - sample.value).max(sample.value - high);
                if beyond > farthest.as_ref().map_or(0.0, |(max, _)| *max) {
                    let bound = if sample.value < low { low } else { high };
                    let (quantity, value) = (MotionQuantity::Position, sample.value);
                    farthest = Some((beyond, TrajectoryError::Limit { axis, quantity, time_s, value, bound }));
                }
            }
            for (k, value) in [sample.first, sample.second, sample.third].into_iter().enumerate() {
                let (size, bound) = (libm::fabs(value), bounds[k]);
                peaks[k] = peaks[k].max(size);
                // A client computes with the same limits and other roundings: a millionth is not an excess.
                let excess = size / bound;
                if excess > 1.0 + 1e-6 && worst.as_ref().is_none_or(|(max, _)| excess > *max) {
                    let quantity = quantities[k];
                    worst = Some((excess, TrajectoryError::Limit { axis, quantity, time_s, value, bound }));
                }
            }
        }
    }
    match farthest.or(worst) {
        Some((_, error)) => Err(error),
        None => Ok(MotionLimits { velocity: peaks[0], acceleration: peaks[1], jerk: peaks[2] }),
    }
}
