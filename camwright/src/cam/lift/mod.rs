// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Lift: what the follower does over one turn of the cam, as a printed table, as a formula, and as the law both give.
//!
//! ```text
//! rows ─► division ─► check ─► LiftTable ─► reading ─► LiftLaw ◄─ program (motion laws), formula
//! half tables ─┤        ├─ outliers
//! points, uneven rows ──┘  └─ warning
//! ```

mod check;
pub mod declaration;
mod error;
pub mod halves;
pub mod law;
mod outliers;
pub mod points;
pub mod program;
pub mod reading;
mod row_spacing;
pub mod table;
pub mod uneven;
mod warning;

pub use declaration::{AngleUnit, LengthUnit, LiftDeclaration, LiftForm, LiftRow};
pub use error::LiftError;
pub use law::{LiftLaw, LiftLawError};
pub use program::{MAX_PROGRAM_TURNS, MotionProgram, MotionSegment, ProgramError};
pub use reading::{TableMethod, TableReading};
pub use table::LiftTable;
pub use warning::LiftWarning;
