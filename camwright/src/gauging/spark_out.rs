// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Turns of spark-out that would achieve the effect of a one-turn correction.

use crate::machine::contact_law::ContactLaw;
use thiserror::Error;

/// Reasons why the number of turns cannot be computed.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SparkOutError {
    /// A runout must be a number above 0.
    #[error("{what} runout must be positive and finite, not {runout_mm} mm")]
    Runout {
        what: &'static str,
        /// Given value (mm).
        runout_mm: f64,
    },
}

/// Turns at constant wheel position until a runout has come from one value to another (mm): ln(to/from)/ln λ, 0 where it is there
/// already. A whole turn counts when it is over: round up.
///
/// # Errors
/// Runouts that are not above 0.
pub fn turns(law: &ContactLaw, from_mm: f64, to_mm: f64) -> Result<f64, SparkOutError> {
    for (what, runout_mm) in [("present", from_mm), ("wanted", to_mm)] {
        if !(runout_mm > 0.0 && runout_mm.is_finite()) {
            return Err(SparkOutError::Runout { what, runout_mm });
        }
    }
    Ok((libm::log(to_mm / from_mm) / libm::log(law.decay())).max(0.0))
}

/// Share of a runout that is left after so many turns at constant wheel position: λⁿ.
#[must_use]
pub fn left(law: &ContactLaw, turns: f64) -> f64 {
    libm::pow(law.decay(), turns)
}

/// The same as published, (1 − km/kg)ⁿ: the first terms of [`left`], too little for every n.
#[must_use]
pub fn left_as_published(law: &ContactLaw, turns: u32) -> f64 {
    libm::pow(1.0 - law.machine_n_mm() / law.grinding_n_mm(), f64::from(turns))
}
