// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Why a program cannot be read, with the line.

use super::{LONGEST_LINE, MAX_BLOCKS, MAX_DEPTH, MAX_TEXT_BYTES};
use alloc::string::String;
use thiserror::Error;

/// A fault of a program and where it stands.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{file}, line {line}: {fault}")]
pub struct ReadError {
    /// Name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: u32,
    pub fault: ReadFault,
}

/// Errors in a line of a program.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ReadFault {
    /// There is nothing to read.
    #[error("there is no program")]
    NoProgram,
    /// More text than is read.
    #[error("the files have {bytes} bytes, at most {MAX_TEXT_BYTES} are read")]
    TooMuchText {
        /// Size of the program.
        bytes: usize,
    },
    /// A line that is too long.
    #[error("the line has {bytes} bytes, at most {LONGEST_LINE} are read")]
    LongLine {
        /// Length of the line.
        bytes: usize,
    },
    /// A comment without its end.
    #[error("the comment is not closed")]
    UnclosedComment,
    /// A comment that the control executes.
    #[error("the comment ({word},…) is executed by the control with unknown effect")]
    ActiveComment { word: String },
    /// Something that is no word.
    #[error("{text:?} is no word that is read here")]
    NoWord { text: String },
    /// A word that means nothing in its block.
    #[error("the word {word} is not understood here")]
    UnknownWord { word: String },
    /// A word that is there twice.
    #[error("{word} is there twice in one block")]
    Twice { word: String },
    /// Two words of one modal group.
    #[error("{first} and {second} exclude each other in one block")]
    OneGroup { first: String, second: String },
    /// A number that cannot be read.
    #[error("{text:?} is no decimal number below 100000000 with at most 9 places")]
    Number { text: String },
    /// A number without a point, on a control where that means another number.
    #[error("{word} has no decimal point; on this control that counts increments or units, as a parameter says")]
    NoPoint { word: String },
    /// A value that must be a whole number in a range.
    #[error("{word}: a whole number within {min} to {max} is needed")]
    NotWhole { word: String, min: u32, max: u32 },
    /// A parameter that was not passed.
    #[error("{name} was not passed by the call")]
    NotPassed { name: String },
    /// A word that needs another one.
    #[error("{word} needs {needs}")]
    Needs { word: String, needs: &'static str },
    /// A word that is understood but not allowed.
    #[error("{word}: {why}")]
    Refused { word: String, why: &'static str },
    /// A call of something that is not there.
    #[error("subprogram {name} is missing")]
    NoSubprogram { name: String },
    /// A subprogram that is there twice.
    #[error("program {name} is there twice")]
    SameProgram { name: String },
    /// A subprogram that is never called and therefore was not read.
    #[error("subprogram {name} is never called, so it was not read")]
    NeverCalled { name: String },
    /// A call with another number of parameters than are declared.
    #[error("{name} is called with {passed} parameters, {declared} are declared")]
    Parameters {
        name: String,
        /// Number of passed arguments.
        passed: usize,
        /// Number of declared arguments, or the maximum.
        declared: usize,
    },
    #[error("subprogram {name} would be called {MAX_DEPTH} calls deep, that is too deep")]
    TooDeep { name: String },
    /// A subprogram that calls itself.
    #[error("subprogram {name} is called while it is running")]
    Recursion { name: String },
    /// A program or subprogram without its end.
    #[error("the program ends here without {end}")]
    NoEnd { end: &'static str },
    /// Something behind the end.
    #[error("there is text behind the end of the program")]
    AfterEnd,
    /// More blocks than are executed.
    #[error("more than {MAX_BLOCKS} blocks are executed")]
    TooManyBlocks,
}
