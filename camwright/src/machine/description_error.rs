// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Errors of a machine description.

use alloc::string::String;
use thiserror::Error;

/// Most stations a machine may have: their switches are one word of inputs.
pub const MAX_STATIONS: usize = 64;

/// Values that do not describe a machine.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DescriptionError {
    /// A homing that is none, or that does not fit its axis.
    #[error("homing of {joint}: {what}")]
    Homing { joint: &'static str, what: &'static str },
    /// A velocity (mm/s) or a position (mm) of a homing that its axis does not reach.
    #[error("homing of {joint}: its {what} is {value}; the axis allows {low} to {high}")]
    HomingOutside { joint: &'static str, what: &'static str, value: f64, low: f64, high: f64 },
    /// A figure must be positive.
    #[error("{what} must be positive and finite, not {value}")]
    NotPositive { what: &'static str, value: f64 },
    /// A figure must not be negative.
    #[error("{what} must be finite and not negative, not {value}")]
    Negative { what: &'static str, value: f64 },
    /// A figure must be a number.
    #[error("{what} must be finite, not {value}")]
    NotFinite { what: &'static str, value: f64 },
    /// A figure lies outside of its range.
    #[error("{what} is {value}; allowed: {low} to {high}")]
    Outside { what: &'static str, value: f64, low: f64, high: f64 },
    /// A lathe has something that only a grinder is simulated with.
    #[error("a lathe, which turns with an insert, cannot have {what}")]
    OnlyOfAGrinder { what: &'static str },
    /// A grinder has no insert.
    #[error("the machine grinds with a wheel; only a lathe has an insert")]
    NotALathe,
    /// A figure of an axis must be positive, or at least finite.
    #[error("{joint}: {what} must be positive and finite, not {value}")]
    AxisNotPositive { joint: &'static str, what: &'static str, value: f64 },
    /// A figure of an axis must not be negative.
    #[error("{joint}: {what} must be finite and not negative, not {value}")]
    AxisNegative { joint: &'static str, what: &'static str, value: f64 },
    /// A figure of an axis is above what it may be.
    #[error("{joint}: {what} is {value}; at most {allowed} is allowed")]
    AxisAbove { joint: &'static str, what: &'static str, value: f64, allowed: f64 },
    /// An ideal loop has no motor that anything could act on.
    #[error("{joint}: friction, backlash, structure, encoder and force limit need a bandwidth of the velocity loop")]
    NoVelocityLoop { joint: &'static str },
    /// Friction would hold an axis off its setpoint for ever.
    #[error("{joint}: a drive with Coulomb friction needs an integral time of its velocity loop")]
    NoIntegral { joint: &'static str },
    /// A figure is above what another one allows.
    #[error("{what} is {value}; at most {allowed} is allowed")]
    AboveLimit { what: &'static str, value: f64, allowed: f64 },
    /// Two figures must increase.
    #[error("{what}: {low} must be less than {high}")]
    NotOrdered {
        what: &'static str,
        /// The one that must be smaller.
        low: f64,
        high: f64,
    },
    /// Axes are in another order than [`Axis::ALL`](crate::machine::axes::Axis::ALL).
    #[error("axis {found} stands where {expected} must")]
    AxisOrder {
        /// Joint expected at this place.
        expected: &'static str,
        found: &'static str,
    },
    /// The headstock counts per turn, slides per millimetre, at least 1.
    #[error("{joint}: {counts} counts of this kind do not fit; c_axis counts per turn, slides per mm, at least 1")]
    AxisScale { joint: &'static str, counts: i64 },
    /// More stations than inputs.
    #[error("{count} stations, at most {MAX_STATIONS}")]
    TooManyStations { count: usize },
    /// The changer has no wheel at this position.
    #[error("the machine has no wheel {index}")]
    NoSuchWheel { index: usize },
    /// Two wheels of a changer have one name.
    #[error("two wheels of the changer have the name {name}")]
    WheelName { name: String },
    /// The machine's wheel is not the one that its changer says is mounted.
    #[error("the changer has {name} mounted, the machine grinds with another wheel")]
    OtherMountedWheel { name: String },
    /// A changer has too few or too many wheels.
    #[error("a wheel changer with {count} wheels; it must have 2 to {}", crate::machine::description::MAX_WHEELS)]
    WheelCount { count: usize },
    /// A state of wheels that is not of this machine's changer.
    #[error("a state of {states} wheels does not fit a machine whose changer has {wheels}")]
    WheelStates { states: usize, wheels: usize },
    /// The sense of rotation is +1 or −1.
    #[error("rotation sense {sense}, allowed +1 and -1")]
    RotationSense { sense: i8 },
}

pub(super) fn ordered(what: &'static str, low: f64, high: f64) -> Result<(), DescriptionError> {
    if low < high { Ok(()) } else { Err(DescriptionError::NotOrdered { what, low, high }) }
}
