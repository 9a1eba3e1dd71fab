// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Machine motion of a program, as read from its text.

use super::{Direction, NcAxis};
use alloc::string::String;
use alloc::vec::Vec;

/// Position of the axes in the frame of the machine's zero point; X is the distance from the spindle axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ProgramPose {
    values: [f64; 4],
    known: u8,
}

impl ProgramPose {
    /// Position of an axis (mm, rad); `None` until a block has named it.
    #[must_use]
    pub fn position(&self, axis: NcAxis) -> Option<f64> {
        (self.known & Self::bit(axis) != 0).then_some(self.values[axis.index()])
    }

    /// The same with an axis elsewhere (mm, rad).
    #[must_use]
    pub fn with(mut self, axis: NcAxis, position: f64) -> Self {
        self.values[axis.index()] = position;
        self.known |= Self::bit(axis);
        self
    }

    const fn bit(axis: NcAxis) -> u8 {
        1 << axis.index()
    }
}

/// One thing that is done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MotionAction {
    /// Rapid motion to a pose.
    Rapid(ProgramPose),
    /// All axes in proportion.
    Feed {
        /// Pose at the end of the move.
        pose: ProgramPose,
        /// Duration (s).
        time_s: f64,
    },
    /// A tool with its length.
    ToolChange(u32),
    SpindleOn {
        direction: Direction,
        /// Speed (1/min).
        rpm: f64,
    },
    SpindleOff,
    /// Coolant on or off.
    Coolant(bool),
    /// Blocks may be joined as long as the path stays so close (mm); `None` where the machine's parameters say how close.
    PathTolerance(Option<f64>),
    /// A pause (s).
    Dwell(f64),
}

/// Something that is done, and where it is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Done {
    /// The file, by its place among those that were read.
    pub file: u32,
    /// The line in it, from 1.
    pub line: u32,
    /// The call by which it is done, by its place in [`ProgramMotion::calls`]; `None` in the main program.
    pub call: Option<u32>,
    pub action: MotionAction,
}

/// A call of a subprogram.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SubprogramCall {
    /// The subprogram, by its place in [`ProgramMotion::subprograms`].
    pub subprogram: u32,
    /// The file of the call, by its place among those that were read.
    pub file: u32,
    /// The line of the call, from 1.
    pub line: u32,
    /// The call by which the caller was called itself.
    pub by: Option<u32>,
}

/// All that a program does from its beginning to its end.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ProgramMotion {
    /// Names or numbers of the subprograms, as the control knows them.
    pub subprograms: Vec<String>,
    /// Calls in the order in which they are made.
    pub calls: Vec<SubprogramCall>,
    /// Actions in their order.
    pub done: Vec<Done>,
}

impl ProgramMotion {
    /// Time of all feeds and pauses (s); nobody knows here how long a rapid takes.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        let times = self.done.iter().map(|done| match done.action {
            MotionAction::Feed { time_s, .. } | MotionAction::Dwell(time_s) => time_s,
            _ => 0.0,
        });
        times.sum()
    }
}
