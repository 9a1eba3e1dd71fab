// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Why a program cannot be written in a dialect.

use super::NcAxis;
use alloc::string::String;
use core::fmt;
use thiserror::Error;

/// A block of a program, for people.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct BlockLocation {
    /// The subprogram; `None` for the main program.
    pub subprogram: Option<String>,
    /// The block, from 1.
    pub block: usize,
}

impl fmt::Display for BlockLocation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.subprogram {
            Some(name) => write!(f, "subprogram {name}, block {}", self.block),
            None => write!(f, "main program, block {}", self.block),
        }
    }
}

/// Reasons why a dialect cannot express a program.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum WriteError {
    /// A name of which nothing is left.
    #[error("the name {name:?} has no letter or digit that a program's name may have")]
    NoName { name: String },
    /// Two names that become one.
    #[error("programs {first:?} and {second:?} would both be named {fitted} on this control; names must differ there")]
    SameName { first: String, second: String, fitted: String },
    /// Two programs have one number.
    #[error("programs {first:?} and {second:?} both have the number {number}; numbers must differ")]
    SameNumber { first: String, second: String, number: u32 },
    /// A number that the control has no program for.
    #[error("program {name:?}: the number {number} is not within {min} to {max}")]
    ProgramNumber { name: String, number: u32, min: u32, max: u32 },
    /// A line for people that is too long.
    #[error("a comment has {characters} characters, at most {max} are allowed: {text:?}")]
    LongText {
        /// Length of the text.
        characters: usize,
        /// Maximum length.
        max: usize,
        text: String,
    },
    /// A tool that cannot be named.
    #[error("tool {number}, radius {radius_mm} mm: the number must be within 1 to {max} and the radius positive")]
    BadTool {
        number: u32,
        /// Its radius (mm).
        radius_mm: f64,
        max: u32,
    },
    /// Two tools have one number.
    #[error("two tools have the number {number}; numbers must differ")]
    SameTool { number: u32 },
    /// A tool that is not in the list.
    #[error("{place}: tool {number} is not among the tools of the program")]
    UnknownTool {
        place: BlockLocation,
        /// Number of the tool.
        number: u32,
    },
    /// A call of nothing.
    #[error("{place}: subprogram {index} is called, the program has {count}")]
    NoSuchSubprogram {
        place: BlockLocation,
        /// Which, from 0.
        index: usize,
        /// Number of items.
        count: usize,
    },
    /// A shift of an axis that the subprogram does not shift.
    #[error("{place}: an offset of {offset} increments is passed to {subprogram:?}, which shifts no linear axis")]
    OffsetOfNoAxis { place: BlockLocation, offset: i64, subprogram: String },
    /// A motion to nowhere.
    #[error("{place}: a motion names no axis")]
    NoTarget { place: BlockLocation },
    /// A coordinate with more digits than the control reads.
    #[error("{place}: {word} has {digits} digits, this control reads at most {max}")]
    TooManyDigits {
        place: BlockLocation,
        word: String,
        /// Required digits.
        digits: u32,
        /// Maximum digits.
        max: u32,
    },
    /// A shift that would send an axis beyond the control's digits.
    #[error("{place}: {axis:?} shifted by the call has {digits} digits, this control reads at most {max}")]
    ShiftedTooFar {
        place: BlockLocation,
        axis: NcAxis,
        /// Required digits.
        digits: u32,
        /// Maximum digits.
        max: u32,
    },
    /// A time that is none.
    #[error("{place}: a feed takes {time_s} s; it must be a positive time")]
    NoTime {
        place: BlockLocation,
        /// The time (s).
        time_s: f64,
    },
    /// A feed that the control does not read.
    #[error("{place}: F {feed_per_min}/min ({time_s} s) is not within {min} to {max}/min on this control")]
    FeedOutOfRange {
        place: BlockLocation,
        /// Inverse time (1/min).
        feed_per_min: f64,
        /// Time (s).
        time_s: f64,
        /// Smallest (1/min).
        min: f64,
        /// Largest (1/min).
        max: f64,
    },
    /// A spindle speed that the control does not read.
    #[error("{place}: a spindle speed of {rpm} rpm is not within 1 to {max} rpm")]
    SpindleSpeed {
        place: BlockLocation,
        /// Speed (1/min).
        rpm: u32,
        /// Largest (1/min).
        max: u32,
    },
    /// A tolerance that is none.
    #[error("{place}: a path tolerance of {increments} increments is not within 1 to {max}")]
    Tolerance { place: BlockLocation, increments: i64, max: i64 },
    /// A pause that the control does not read.
    #[error("{place}: a dwell of {ms} ms is not within 1 to {max} ms")]
    Dwell {
        place: BlockLocation,
        /// Requested dwell (ms).
        ms: u32,
        /// Longest (ms).
        max: u32,
    },
}
