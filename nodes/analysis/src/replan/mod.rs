// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Plans archived jobs again with this program, and finds what moved and by how much (`camwright replan`).
//!
//! ```text
//! bag ─► archive (job, machine, plan as they were) ─┬─► old plan ─┐
//!                                                   └─► planning ─┴─► camwright::planner::plan_difference ─► outcome
//! ```

mod archive;
mod outcome;

#[cfg(test)]
mod tests;

pub use archive::{ArchivedJob, archived_jobs, bags_in};
pub use outcome::{ChangeLine, ReplanOutcome, replan};
