// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The trajectory that follows the one in execution without a stop.

use super::engine_messages::PreparedMotion;

/// Trajectory that replaces the one in execution.
#[derive(Debug, Default)]
pub(super) enum NextTrajectory {
    #[default]
    None,
    /// A forecast is requested, for this tick or a later one; the one in command has not begun.
    Requested(u64),
    /// One is being made for this tick.
    Awaited(u64),
    Ready(u64, PreparedMotion),
}

impl NextTrajectory {
    /// Last tick that may be computed before it is known what comes next.
    pub(super) fn last_tick(&self) -> u64 {
        match self {
            NextTrajectory::None | NextTrajectory::Requested(_) => u64::MAX,
            NextTrajectory::Awaited(tick) | NextTrajectory::Ready(tick, _) => tick - 1,
        }
    }
}
