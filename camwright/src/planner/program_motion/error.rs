// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Why the motion of a program cannot be driven.

use crate::gcode::Direction;
use crate::machine::description::Axis;
use crate::math::units::{deg_from_rad, um_from_mm};
use crate::motion::speed_plan::{LimitedQuantity, figures};
use alloc::string::String;
use thiserror::Error;

/// Something that a program asks for and the machine does not do, and where it is written.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{file}, line {line}: {fault}")]
pub struct ProgramMotionError {
    /// Name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: u32,
    pub fault: ProgramMotionFault,
}

/// Program requests that the machine cannot execute.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ProgramMotionFault {
    /// A number of the setup that is none.
    #[error("{what} is {value}, it must be {allowed}")]
    OutOfRange { what: &'static str, value: f64, allowed: &'static str },
    /// A program for a machine whose part turns the other way.
    #[error(
        "the program is for a rotation sense of {program}, this machine's is {machine}: it would make the part's mirror image"
    )]
    OtherSense {
        /// Direction of the program.
        program: i8,
        machine: i8,
    },
    /// A program that turns a lathe's insert the other way.
    #[error(
        "the program turns the insert {program} ({}), insert.rotation of the machine is {machine} ({}): write the program again, or change the \
         machine",
        program.code(), machine.code()
    )]
    SpindleDirection { program: Direction, machine: Direction },
    /// A program that turns an insert that is clamped.
    #[error("the program turns the insert; the machine's insert does not rotate (insert.rotates: false)")]
    NoSpindle,
    /// An axis that the machine does not have.
    #[error("Y goes to {position_mm} mm; the machine has no Y")]
    NoY {
        /// Target (mm).
        position_mm: f64,
    },
    #[error("tool {wanted} is selected after tool {mounted}; the machine has one tool and changes none")]
    OtherTool {
        /// Requested value.
        wanted: u32,
        mounted: u32,
    },
    /// A feed in which C does not turn forwards.
    #[error(
        "the feed turns C from {from_deg} to {to_deg} deg; X and Z follow C here, so every feed must turn it forwards"
    )]
    NotForwards {
        /// Start of C (deg).
        from_deg: f64,
        /// Target of C (deg).
        to_deg: f64,
    },
    /// A place that no axis has.
    #[error("{} goes to {position}, beyond what can be counted", axis.joint())]
    TooFar {
        axis: Axis,
        /// Target (mm or rad).
        position: f64,
    },
    /// A block that is too fast for an axis, whatever is rounded.
    #[error(
        "in {time_s} s {} would go at {} {unit}, {} {unit} are allowed: the block needs {} s",
        axis.joint(), figures(*.speed), figures(*.allowed), figures(.time_s * .speed / .allowed),
        unit = LimitedQuantity::Velocity.unit(*axis)
    )]
    TooFast {
        axis: Axis,
        /// Time of the block (s).
        time_s: f64,
        /// Its speed (mm/s or rad/s).
        speed: f64,
        /// Most (mm/s or rad/s).
        allowed: f64,
    },
    /// Corners that cannot be rounded as much as the axes need.
    #[error(
        "{} needs a {} of {} {unit} at C {:.3} deg, {} {unit} are allowed; the corners are rounded over {:.4} deg as the path tolerance \
         of {:.3} um allows",
        axis.joint(), quantity.name(), figures(*.value), deg_from_rad(*.c_rad), figures(*.allowed), deg_from_rad(*.window_rad),
        um_from_mm(*.tolerance_mm), unit = quantity.unit(*axis)
    )]
    Limit {
        axis: Axis,
        quantity: LimitedQuantity,
        /// Value (mm or rad, s).
        value: f64,
        /// Most (mm or rad, s).
        allowed: f64,
        /// C there, as programmed (rad).
        c_rad: f64,
        /// The window to either side (rad).
        window_rad: f64,
        /// Path tolerance at a corner (mm).
        tolerance_mm: f64,
    },
    /// More than is driven between two rapids.
    #[error("{count} blocks feed between two rapids, at most {max} are driven")]
    TooManyBlocks {
        /// Number of items.
        count: usize,
        max: usize,
    },
    /// Blocks that are much shorter than what they are averaged over.
    #[error(
        "{count} blocks end within {window_deg:.4} deg, over which corners are rounded; at most {max} are averaged"
    )]
    TooDense {
        count: usize,
        /// Both sides of the window (deg).
        window_deg: f64,
        max: usize,
    },
    /// A line of no spline: angles or times that are equal in their last bit.
    #[error(transparent)]
    Spline(#[from] crate::math::hermite::HermiteError),
    #[error("no block of the program feeds")]
    NoFeed,
}

impl ProgramMotionFault {
    /// Share of the speed that would keep the exceeded limit; `None` if no speed would.
    pub(super) fn speed_share(&self) -> Option<f64> {
        let share = match self {
            Self::TooFast { speed, allowed, .. } => allowed / speed,
            Self::Limit { quantity, value, allowed, .. } => match quantity {
                LimitedQuantity::Velocity => allowed / value,
                LimitedQuantity::Acceleration => libm::sqrt(allowed / value),
                LimitedQuantity::Jerk => libm::cbrt(allowed / value),
            },
            _ => return None,
        };
        (share > 0.0 && share < 1.0).then_some(share)
    }
}
