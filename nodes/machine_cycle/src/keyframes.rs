// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Keyframes: the state of the machine and of its cyclic thread after a tick, from which a replay can begin.
//!
//! The cyclic thread writes them itself, into room that it was given (`keyframe_writing.rs`): the thousands of numbers of a part are
//! written in some ten microseconds, without an allocation, and nothing can change meanwhile. The pump makes messages of them and gives
//! the room back.

use super::pacing::Pace;
use camwright::math::snapshot::{FieldPath, SnapshotError};

/// Form of the state: it grows with every change of what a keyframe holds, and only the same form can be read.
pub const FORM: u32 = 1;

/// Default time of the machine between two keyframes (s).
pub const PERIOD_S: f64 = 10.0;
/// Most that keyframes add to a recording (B/s of the machine's time): a large state is written less often.
const BYTES_PER_S: f64 = 100_000.0;
/// A state above this (B) takes a good part of a tick: a machine that keeps pace with the clock writes it while nothing moves.
pub(super) const MAX_MOVING: usize = 4 << 20;
/// Room beyond a state at rest, for what comes and goes: setpoints, commands, alarms (B).
pub(super) const SLACK: usize = 64 << 10;

/// Ticks between two keyframes of a state of this size (B) that are `period_s` apart (s) at least; 0: there are none.
#[allow(clippy::cast_possible_truncation, reason = "hours of ticks")]
pub fn ticks_between(size: usize, period_s: f64, cycle_s: f64) -> u64 {
    if period_s <= 0.0 {
        return 0;
    }
    let periods = (size as f64 / (BYTES_PER_S * period_s)).ceil().max(1.0);
    (periods * (period_s / cycle_s).round()).max(1.0) as u64
}

/// Buffer of a keyframe.
#[derive(Debug)]
pub struct Room {
    pub(super) octets: Vec<u8>,
    pub(super) written: Result<usize, (SnapshotError, FieldPath)>,
}

impl Room {
    pub(super) fn with_size(size: usize) -> Box<Self> {
        Box::new(Self { octets: vec![0; size + SLACK], written: Ok(0) })
    }

    /// The state that was written.
    ///
    /// # Errors
    /// It was not, and why.
    pub fn state(&self) -> Result<&[u8], String> {
        match self.written {
            Ok(octets) => Ok(self.octets.get(..octets).unwrap_or_default()),
            Err((error, place)) => Err(format!("{place}: {error}")),
        }
    }

    /// The same for the next one, larger where there was no room.
    pub fn reset(mut self: Box<Self>) -> Box<Self> {
        if matches!(self.written, Err((SnapshotError::NoRoom, _))) {
            self.octets.resize(2 * self.octets.len(), 0);
        }
        self
    }
}

/// When the cyclic thread writes keyframes, and into what.
#[derive(Debug, Default)]
pub struct Keyframes {
    /// (s); 0: none.
    pub(super) period_s: f64,
    pub(super) cycle_s: f64,
    /// A clock does not wait.
    pub(super) by_the_clock: bool,
    /// The tick from which on one is due.
    pub(super) due: u64,
    /// Octets of the state with its part.
    pub(super) size: usize,
    pub room: Option<Box<Room>>,
}

impl Keyframes {
    pub fn new(period_s: f64, cycle_s: f64, pace: Pace) -> Self {
        Self { period_s, cycle_s, by_the_clock: pace == Pace::Realtime, ..Self::default() }
    }

    pub(super) fn ticks(&self) -> u64 {
        ticks_between(self.size, self.period_s, self.cycle_s)
    }
}
