// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Room 8. Programs for machines whose controls read text: a main program, a subprogram for each cam, in the dialect of the control.
//!
//! A [`Program`] says what is to be driven, in whole least increments, so that what is written is what was meant. [`Dialect::write`] makes
//! its text, and [`read`] interprets such text, that of others too, as a control would. In C and X every block is an Archimedean segment: both axes travel in proportion.
//!
//! The part is the same on all of them: C is the rotary axis (degrees in text, counted on over whole turns), X, Y and Z are linear (mm), a
//! feed is given by its time alone (G93), because what a feed in mm/min means for a rotary axis differs from control to control.
//!
//! ```
//! use camwright::gcode::{Dialect, ProgramFile, XValues, read};
//!
//! let text = "G21 G90 G93\nG0 X50 C0\nG1 X20 C360 F10\nM2\n".to_owned();
//! let motion = read(Dialect::LinuxCnc, XValues::Radius, &[ProgramFile { name: "cam.ngc".into(), text }])?;
//! assert!(motion.done.len() >= 2);
//! # Ok::<(), camwright::gcode::ReadError>(())
//! ```

pub mod archimedean;
mod axis;
mod dialect;
mod driven;
mod error;
mod fitted;
mod motion;
pub mod post;
mod program;
mod raised_feed;
mod read;
mod write;

pub use axis::NcAxis;
pub use dialect::{Dialect, ProgramFile};
pub use driven::{DrivenMove, driven};
pub use error::{BlockLocation, WriteError};
pub use motion::{Done, MotionAction, ProgramMotion, ProgramPose, SubprogramCall};
pub use program::{
    Block, Call, Direction, FormatError, MAX_INCREMENTS, NumberFormat, Program, Step, Subprogram, Target, Tool, XValues,
};
pub use raised_feed::{MIN_RATE_MM_MIN, RaisedFeed, raised_feeds};
pub use read::{LONGEST_LINE, MAX_BLOCKS, MAX_DEPTH, MAX_TEXT_BYTES, ReadError, ReadFault, read};
