// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! From the file of a turning job to a plan that can be sent.
//!
//! ```text
//! job file ─► TurnedJob ─► plan_turning ─► Plan ─► pages      refused anywhere: one sentence, with file and line
//! ```

mod causes;
mod clearance;
pub(super) mod clearance_rows;
mod error_location;
mod export;
mod findings;
pub(super) mod prepared;
mod result;
mod simulate;
pub(super) mod summary;
pub(super) mod tables;
pub(super) mod walk;

pub use causes::{OtherLathe, turned_causes};
use clearance::clearance_map;
pub use export::write_turning;
pub use findings::turning_notes;
pub(super) use findings::{all_warnings, check_turned};
pub use prepared::{PreparedTurning, plan_turned};
pub use result::{bar, form_map_message, turned_result, turning_s};
pub use simulate::{simulate_turned, simulate_turned_on, turned_form};
pub use summary::{TurnedLimitSummary, TurnedPassSummary, TurningSummary, turning_summary};

#[cfg(test)]
mod tests;
