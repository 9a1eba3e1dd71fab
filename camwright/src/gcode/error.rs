//! Why a program cannot be written in a dialect.

use super::NcAxis;
use alloc::string::String;
use core::fmt;
use thiserror::Error;

/// A block of a program, for people.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct BlockPlace {
    /// The subprogram; `None` for the main program.
    pub subprogram: Option<String>,
    /// The block, from 1.
    pub block: usize,
}

impl fmt::Display for BlockPlace {
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
    #[error("program {name:?}: the number {number} is not within {least} to {most}")]
    ProgramNumber { name: String, number: u32, least: u32, most: u32 },
    /// A line for people that is too long.
    #[error("a comment has {characters} characters, at most {most} are allowed: {text:?}")]
    LongText {
        /// Length of the text.
        characters: usize,
        /// Maximum length.
        most: usize,
        text: String,
    },
    /// A tool that cannot be named.
    #[error("tool {number}, radius {radius_mm} mm: the number must be within 1 to {most} and the radius positive")]
    BadTool {
        number: u32,
        /// Its radius (mm).
        radius_mm: f64,
        most: u32,
    },
    /// Two tools have one number.
    #[error("two tools have the number {number}; numbers must differ")]
    SameTool { number: u32 },
    /// A tool that is not in the list.
    #[error("{place}: tool {number} is not among the tools of the program")]
    UnknownTool {
        place: BlockPlace,
        /// Number of the tool.
        number: u32,
    },
    /// A call of nothing.
    #[error("{place}: subprogram {index} is called, the program has {count}")]
    NoSuchSubprogram {
        place: BlockPlace,
        /// Which, from 0.
        index: usize,
        /// Number of items.
        count: usize,
    },
    /// A shift of an axis that the subprogram does not shift.
    #[error("{place}: an offset of {offset} increments is passed to {subprogram:?}, which shifts no linear axis")]
    OffsetOfNoAxis { place: BlockPlace, offset: i64, subprogram: String },
    /// A motion to nowhere.
    #[error("{place}: a motion names no axis")]
    NoTarget { place: BlockPlace },
    /// A coordinate with more digits than the control reads.
    #[error("{place}: {word} has {digits} digits, this control reads at most {most}")]
    TooManyDigits {
        place: BlockPlace,
        word: String,
        /// Required digits.
        digits: u32,
        /// Maximum digits.
        most: u32,
    },
    /// A shift that would send an axis beyond the control's digits.
    #[error("{place}: {axis:?} shifted by the call has {digits} digits, this control reads at most {most}")]
    ShiftedTooFar {
        place: BlockPlace,
        axis: NcAxis,
        /// Required digits.
        digits: u32,
        /// Maximum digits.
        most: u32,
    },
    /// A time that is none.
    #[error("{place}: a feed takes {time_s} s; it must be a positive time")]
    NoTime {
        place: BlockPlace,
        /// The time (s).
        time_s: f64,
    },
    /// A feed that the control does not read.
    #[error("{place}: F {feed_per_min}/min ({time_s} s) is not within {least} to {most}/min on this control")]
    FeedOutOfRange {
        place: BlockPlace,
        /// Inverse time (1/min).
        feed_per_min: f64,
        /// Time (s).
        time_s: f64,
        /// Smallest (1/min).
        least: f64,
        /// Largest (1/min).
        most: f64,
    },
    /// A spindle speed that the control does not read.
    #[error("{place}: a spindle speed of {rpm} rpm is not within 1 to {most} rpm")]
    SpindleSpeed {
        place: BlockPlace,
        /// Speed (1/min).
        rpm: u32,
        /// Largest (1/min).
        most: u32,
    },
    /// A tolerance that is none.
    #[error("{place}: a path tolerance of {increments} increments is not within 1 to {most}")]
    Tolerance { place: BlockPlace, increments: i64, most: i64 },
    /// A pause that the control does not read.
    #[error("{place}: a dwell of {ms} ms is not within 1 to {most} ms")]
    Dwell {
        place: BlockPlace,
        /// Requested dwell (ms).
        ms: u32,
        /// Longest (ms).
        most: u32,
    },
}
