// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A motion computed again: from where it began, and from its inputs as they were applied.
//!
//! What an interpolator at rest knows is little: where the axes rest, which zeros are known, and the override. So every motion can be computed
//! again by itself, whatever was before it.

use super::{AppliedInput, Interpolator, MotionRequest, PendingFeedback};
use crate::machine::description::AXIS_COUNT;

/// State of an interpolator at rest that a motion depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RestState {
    /// Rest position of the axes (counts).
    pub counts: [i64; AXIS_COUNT],
    /// Which zeros are known.
    pub homed: [bool; AXIS_COUNT],
    /// The override, as path time counts it.
    pub feed_override: i64,
}

impl Interpolator {
    /// State that a motion beginning now would start from.
    #[must_use]
    pub fn rest_state(&self) -> RestState {
        RestState { counts: self.setpoint.counts, homed: self.homed, feed_override: self.feed_override }
    }

    /// Rests there, with that knowledge. A motion in execution is dropped.
    pub fn rest_as(&mut self, rest: &RestState) {
        self.resync(rest.counts);
        self.homed = rest.homed;
        self.feed_override = rest.feed_override;
    }

    /// Takes an input that a tick applied once, to be applied by that tick again. What came from the machine comes into sight then; a
    /// request is given back, to be made with that tick.
    pub fn replay(&mut self, tick: u64, input: &AppliedInput) -> Option<MotionRequest> {
        // Whatever tick it was of: it came into sight with this one.
        let seen = tick.saturating_sub(u64::from(self.machine.feedback_delay_ticks));
        let feedback = match input {
            AppliedInput::Request(request) => return Some(*request),
            AppliedInput::Feedback(latch) => PendingFeedback::Latch(*latch),
            AppliedInput::Alarm(number) => PendingFeedback::Alarm(seen, *number),
            AppliedInput::OutOfTolerance(broken) => PendingFeedback::OutOfTolerance(seen, *broken),
            AppliedInput::Settled => PendingFeedback::Settled(seen),
        };
        // One that finds no room is missing among those that the tick applies, which the comparison shows.
        let _has_room = self.remember(feedback);
        None
    }
}
