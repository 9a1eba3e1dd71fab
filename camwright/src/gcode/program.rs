// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Typed NC program, independent of a dialect.

use super::NcAxis;
use crate::machine::description::InsertRotation;
use crate::math::units::{deg_from_rad, from_increments, increments, rad_from_deg};
use crate::toolpath::cutter_path::CarriageAxis;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;
use thiserror::Error;

/// Most decimal places of a coordinate.
const MAX_DECIMALS: u32 = 6;

/// Coordinates have fewer increments than this; what is shifted by a call stays far from the end of the integers.
pub const MAX_INCREMENTS: i64 = 1_000_000_000_000_000;

/// Meaning of X: distance from the spindle axis, or twice that distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum XValues {
    /// The distance from the spindle axis.
    Radius,
    Diameter,
}

impl XValues {
    /// Written value for a distance of 1 mm.
    #[must_use]
    pub const fn factor(self) -> f64 {
        match self {
            XValues::Radius => 1.0,
            XValues::Diameter => 2.0,
        }
    }
}

/// Resolution of coordinates: an increment is one unit of the last decimal place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NumberFormat {
    linear_decimals: u32,
    rotary_decimals: u32,
    x_values: XValues,
}

/// Why a format or a coordinate is none.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum FormatError {
    /// A number of decimal places that no control reads.
    #[error("{decimals} decimal places of {what} are not within 1 to {MAX_DECIMALS}")]
    Decimals {
        what: &'static str,
        /// Requested decimals.
        decimals: u32,
    },
    /// A coordinate that cannot be counted.
    #[error("{axis:?} of {value} is not a number of at most 15 digits with {decimals} decimal places")]
    Coordinate {
        axis: NcAxis,
        /// Value, in the unit that is written.
        value: f64,
        decimals: u32,
    },
}

impl NumberFormat {
    /// Decimal places of mm and of degrees, 1 to 6, and what X means.
    ///
    /// # Errors
    /// Another number of places.
    pub const fn new(linear_decimals: u32, rotary_decimals: u32, x_values: XValues) -> Result<Self, FormatError> {
        if linear_decimals < 1 || linear_decimals > MAX_DECIMALS {
            return Err(FormatError::Decimals { what: "lengths", decimals: linear_decimals });
        }
        if rotary_decimals < 1 || rotary_decimals > MAX_DECIMALS {
            return Err(FormatError::Decimals { what: "angles", decimals: rotary_decimals });
        }
        Ok(Self { linear_decimals, rotary_decimals, x_values })
    }

    /// Decimal places of an axis.
    #[must_use]
    pub const fn decimals(self, axis: NcAxis) -> u32 {
        match axis {
            NcAxis::X | NcAxis::Y | NcAxis::Z => self.linear_decimals,
            NcAxis::C => self.rotary_decimals,
        }
    }

    #[must_use]
    pub const fn x_values(self) -> XValues {
        self.x_values
    }

    /// A position, a distance or a shift of an axis in increments, from mm (of X the distance from the axis, whatever is written) or rad.
    ///
    /// # Errors
    /// What cannot be counted: no finite number, or more than 15 digits.
    pub fn count(self, axis: NcAxis, mm_or_rad: f64) -> Result<i64, FormatError> {
        let value = match axis {
            NcAxis::X => mm_or_rad * self.x_values.factor(),
            NcAxis::Y | NcAxis::Z => mm_or_rad,
            NcAxis::C => deg_from_rad(mm_or_rad),
        };
        let decimals = self.decimals(axis);
        increments(value, decimals).ok_or(FormatError::Coordinate { axis, value, decimals })
    }

    /// Value of a number of increments in mm (X: distance from the axis) or rad.
    #[must_use]
    pub fn value(self, axis: NcAxis, count: i64) -> f64 {
        let written = from_increments(count, self.decimals(axis));
        match axis {
            NcAxis::X => written / self.x_values.factor(),
            NcAxis::Y | NcAxis::Z => written,
            NcAxis::C => rad_from_deg(written),
        }
    }
}

/// Target of a block in increments; axes that are not named keep their position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Target {
    /// X, as it is written: the distance from the axis, or the diameter.
    pub x: Option<i64>,
    pub y: Option<i64>,
    pub z: Option<i64>,
    pub c: Option<i64>,
}

impl Target {
    /// That of an axis.
    #[must_use]
    pub const fn value(&self, axis: NcAxis) -> Option<i64> {
        match axis {
            NcAxis::X => self.x,
            NcAxis::Y => self.y,
            NcAxis::Z => self.z,
            NcAxis::C => self.c,
        }
    }

    /// The same with one axis named.
    #[must_use]
    pub const fn with(mut self, axis: NcAxis, count: i64) -> Self {
        match axis {
            NcAxis::X => self.x = Some(count),
            NcAxis::Y => self.y = Some(count),
            NcAxis::Z => self.z = Some(count),
            NcAxis::C => self.c = Some(count),
        }
        self
    }

    /// The axes that are named, with their increments.
    pub fn named(&self) -> impl Iterator<Item = (NcAxis, i64)> {
        let target = *self;
        NcAxis::ALL.into_iter().filter_map(move |axis| target.value(axis).map(|count| (axis, count)))
    }
}

/// Direction of a cutter's spindle, seen from the spindle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// M3.
    Clockwise,
    /// M4.
    Counterclockwise,
}

impl Direction {
    /// Its code, as every control reads it.
    #[must_use]
    pub const fn code(self) -> &'static str {
        match self {
            Self::Clockwise => "M3",
            Self::Counterclockwise => "M4",
        }
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Clockwise => "clockwise",
            Self::Counterclockwise => "counterclockwise",
        })
    }
}

impl From<InsertRotation> for Direction {
    fn from(rotation: InsertRotation) -> Self {
        match rotation {
            InsertRotation::Clockwise => Self::Clockwise,
            InsertRotation::Counterclockwise => Self::Counterclockwise,
        }
    }
}

/// One thing that the machine does.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// A line for people.
    Comment(String),
    /// A tool of the program's list, by its number, with its length.
    ToolChange(u32),
    SpindleOn {
        direction: Direction,
        /// Speed (1/min).
        rpm: u32,
    },
    SpindleOff,
    /// Coolant on or off.
    Coolant(bool),
    /// Blocks may be joined as long as the path stays within so many increments of a length.
    PathTolerance(i64),
    /// Rapid motion, away from the part.
    Rapid(Target),
    /// All axes in proportion, in a given time.
    Feed {
        target: Target,
        /// Duration (s).
        time_s: f64,
    },
    Dwell {
        /// Duration (ms).
        ms: u32,
    },
}

/// One cam: written in numbers that its call shifts, so that the control can read ahead.
#[derive(Debug, Clone, PartialEq)]
pub struct Subprogram {
    /// Its name, for dialects that call by name.
    pub name: String,
    /// Its number, for those that call by number.
    pub number: u32,
    /// Title for the operator.
    pub title: String,
    /// The linear axis that a call shifts beside C: stock that is left, or a depth.
    pub offset_axis: Option<CarriageAxis>,
    /// Blocks between the shift by its parameters and the end of that shift.
    pub blocks: Vec<Block>,
}

/// A call of a subprogram.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Call {
    /// Its place in the program's list.
    pub subprogram: usize,
    /// Shift of C, in increments.
    pub phase: i64,
    /// Shift of the subprogram's linear axis, in increments (of X as it is written).
    pub offset: i64,
}

/// A step of the main program.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    /// A block of its own.
    Block(Block),
    Call(Call),
}

#[derive(Debug, Clone, PartialEq)]
pub struct Tool {
    /// Its number in the turret or magazine.
    pub number: u32,
    /// Its radius, for which the program was made (mm).
    pub radius_mm: f64,
    /// Comment for the operator.
    pub text: String,
}

/// A program: it starts from a safe state, does its steps and ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    pub name: String,
    /// Its number, for dialects that have numbers.
    pub number: u32,
    /// Lines for people, at its head.
    pub header: Vec<String>,
    /// Resolution of coordinates.
    pub format: NumberFormat,
    /// The tools that it changes to.
    pub tools: Vec<Tool>,
    /// The main program; its end is written in addition.
    pub main: Vec<Step>,
    pub subprograms: Vec<Subprogram>,
}
