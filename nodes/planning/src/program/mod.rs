// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! NC programs of jobs, for machines whose controls read text: what `camwright post` makes.
//!
//! ```text
//! PreparedJob ─► ground ─┐
//! MilledJob ───► milled ─┴► PostRequest ─► camwright::gcode::post ─► Program ─► files ─► read back from the disk ─► compared with the paths
//! PreparedTurning ─► turned ─► InsertPostRequest ─► the same
//! ```

mod export;
mod ground;
mod milled;
pub(super) mod request;
mod summary;
mod turned;

pub(super) use export::check_milled;
pub use export::{compare_program, write_program};
pub(super) use ground::refuse_what_needs_the_machine;
pub use summary::{ProgramSummary, TurnSummary as ProgrammedTurn};
