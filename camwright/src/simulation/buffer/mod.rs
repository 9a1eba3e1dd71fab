// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The machine's end of the stream of setpoints: chunks that end at rest, each replacing the one before from its first
//! tick on.
//!
//! ```text
//! tick ──────────────────────────────────────────────►
//! chunk 1   ├── dense ──┤~~ tail: a stop ~~│ rest
//! chunk 2               ├── dense ──┤~~ tail ~~│ rest
//! ```
//! A stream that falls silent runs out on the tail: silence is a stop on the path.

use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription, nearest_count};
use crate::machine::setpoint::Setpoint;
use crate::math::fixed_list::FixedList;
use crate::math::hermite::{Knot, quintic};
use crate::math::snapshot::{Snapshot, SnapshotCodec, SnapshotError};
use crate::simulation::plausibility::{ImplausibleSetpoint, Plausibility};
use alloc::collections::VecDeque;
use alloc::vec::Vec;
use thiserror::Error;

/// A point of a chunk's tail; between points every axis follows the quintic with their positions, speeds, accelerations.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TailPoint {
    /// Tick of the point.
    pub tick: u64,
    /// Setpoint at that tick.
    pub setpoint: Setpoint,
}

crate::snapshot!(TailPoint { tick, setpoint } on {});

/// A chunk of setpoints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chunk<'a> {
    /// Tick of the first setpoint.
    pub first_tick: u64,
    /// Setpoints of successive ticks, at least one.
    pub dense: &'a [Setpoint],
    /// The stop that follows if nothing newer comes; its last point is at rest. Empty if the dense part ends at rest.
    pub tail: &'a [TailPoint],
    /// The motion ends with this chunk: running out on it is no underrun.
    pub is_final: bool,
}

/// Why a chunk was refused; nothing has changed then.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ChunkError {
    /// The machine takes no setpoints now.
    #[error("the machine takes no setpoints: an alarm needs a reset")]
    Closed,
    /// There is no setpoint in it.
    #[error("the chunk has no setpoint")]
    Empty,
    /// It begins with a tick that has been executed.
    #[error("the chunk begins at tick {first_tick}, tick {executed} has been executed")]
    Late { first_tick: u64, executed: u64 },
    /// Setpoints before it are missing: the stream has begun, is not final, and was sent up to another tick.
    #[error("the chunk begins at tick {first_tick}, tick {expected} was to come next")]
    Lost {
        first_tick: u64,
        /// The first tick that is missing.
        expected: u64,
    },
    /// It reaches beyond the credit.
    #[error("the chunk ends at tick {last_tick}, credit reaches to tick {credit}")]
    BeyondCredit {
        /// Its last dense tick.
        last_tick: u64,
        credit: u64,
    },
    /// More points than there is room for.
    #[error("{count} {what}, at most {capacity}")]
    TooLong { what: &'static str, count: usize, capacity: usize },
    /// The ticks of the tail do not increase.
    #[error("tail point {index}: tick {tick} does not increase")]
    TailOrder {
        /// Index of the point.
        index: usize,
        tick: u64,
    },
    /// It does not end at rest.
    #[error("the chunk does not end at rest")]
    NotAtRest,
    /// A number is not finite.
    #[error("tail point {index}: not a finite number")]
    NotFinite {
        /// Index of the point.
        index: usize,
    },
    /// A setpoint cannot follow the one before.
    #[error("tick {tick}: {} {:?} of {} exceeds {}", .misfit.axis.joint(), .misfit.what, .misfit.value, .misfit.bound)]
    Misfit {
        /// Tick of the setpoint.
        tick: u64,
        misfit: ImplausibleSetpoint,
    },
}

/// Content of the buffer for a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Supply {
    /// A setpoint that was sent for this tick.
    Dense,
    /// Only the stop of the last chunk: an underrun unless that chunk was final.
    Tail,
    /// Nothing: the axes hold.
    Nothing,
}

/// A reading that shifts at a tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Shift {
    tick: u64,
    axis: Axis,
    counts: i64,
}

crate::snapshot!(Shift { tick, axis, counts } on {});

impl Shift {
    fn apply(&self, mut setpoint: Setpoint) -> Setpoint {
        let counts = &mut setpoint.counts[self.axis.index()];
        *counts = counts.saturating_sub(self.counts);
        setpoint
    }
}

/// Most shifts that may be pending at once.
const MAX_SHIFTS: usize = 8;

/// Longest tail, in points.
pub const MAX_TAIL_POINTS: usize = 64;

/// Setpoints that wait for their tick. Never allocates after its construction.
#[derive(Debug, Clone, PartialEq)]
pub struct SetpointBuffer {
    plausibility: Plausibility,
    counts_per_unit: [f64; AXIS_COUNT],
    cycle_time_s: f64,
    delay_ticks: u64,
    capacity: usize,
    /// Tick of the first dense setpoint.
    first: u64,
    dense: VecDeque<Setpoint>,
    /// The last dense setpoint, where the tail begins.
    anchor: TailPoint,
    tail: Vec<TailPoint>,
    is_final: bool,
    is_open: bool,
    shifts: FixedList<Shift, MAX_SHIFTS>,
}

impl Snapshot for SetpointBuffer {
    fn snapshot(&mut self, codec: &mut SnapshotCodec<'_>) -> Result<(), SnapshotError> {
        let Self {
            plausibility: _,
            counts_per_unit: _,
            cycle_time_s: _,
            delay_ticks: _,
            capacity,
            first,
            dense,
            anchor,
            tail,
            is_final,
            is_open,
            shifts,
        } = self;
        codec.field("first", |codec| first.snapshot(codec))?;
        codec.field("dense", |codec| codec.queue(dense, *capacity))?;
        codec.field("anchor", |codec| anchor.snapshot(codec))?;
        codec.field("tail", |codec| codec.list(tail, MAX_TAIL_POINTS))?;
        codec.field("is_final", |codec| is_final.snapshot(codec))?;
        codec.field("is_open", |codec| is_open.snapshot(codec))?;
        codec.field("shifts", |codec| shifts.snapshot(codec))?;
        let ticks = [self.anchor.tick].into_iter().chain(self.tail.iter().map(|point| point.tick));
        if !ticks.is_sorted_by(|one, next| one < next) {
            return Err(SnapshotError::Impossible("ticks of a tail do not increase"));
        }
        Ok(())
    }
}

impl SetpointBuffer {
    /// A buffer for a machine that rests at `rest`, open. It holds twice the feedback delay and one chunk more.
    #[must_use]
    pub fn new(description: &MachineDescription, rest: Setpoint) -> Self {
        let delay_ticks = u64::from(description.feedback_delay_ticks);
        let capacity = usize::try_from(description.feedback_delay_ticks).unwrap_or(usize::MAX / 4) * 2 + 256;
        Self {
            plausibility: Plausibility::new(description),
            counts_per_unit: core::array::from_fn(|i| description.axes[i].scale.counts_per_unit()),
            cycle_time_s: description.cycle_time_s(),
            delay_ticks,
            capacity,
            first: 0,
            dense: VecDeque::with_capacity(capacity),
            anchor: TailPoint { tick: 0, setpoint: Setpoint { velocity: [0.0; 3], acceleration: [0.0; 3], ..rest } },
            tail: Vec::with_capacity(MAX_TAIL_POINTS),
            is_final: true,
            is_open: true,
            shifts: FixedList::new(),
        }
    }

    /// Largest tick for which setpoints may be sent when `executed` has been executed.
    #[must_use]
    pub fn credit(&self, executed: u64) -> u64 {
        executed + self.delay_ticks
    }

    /// Takes no chunk from now on; what is there runs out. For an alarm: the stop is the tail of the last chunk.
    pub fn close(&mut self) {
        self.is_open = false;
    }

    /// Forgets everything and begins anew from a machine that rests at `rest`.
    pub fn open(&mut self, rest: Setpoint) {
        self.dense.clear();
        self.tail.clear();
        self.shifts = FixedList::new();
        self.anchor = TailPoint { tick: 0, setpoint: Setpoint { velocity: [0.0; 3], acceleration: [0.0; 3], ..rest } };
        self.first = 0;
        self.is_final = true;
        self.is_open = true;
    }

    /// Schedules a shift of an axis' reading by `counts` at a tick: a setpoint of that tick or later is in the new
    /// reading. Must be called before chunks in the new reading arrive. Returns false if too many shifts are pending.
    pub fn schedule_home(&mut self, tick: u64, axis: Axis, counts: i64) -> bool {
        self.shifts.push(Shift { tick, axis, counts })
    }

    /// Returns whether setpoints are pending.
    #[must_use]
    pub fn has_setpoints(&self) -> bool {
        !self.dense.is_empty()
    }

    /// Returns whether a motion has ended: its final chunk has been executed.
    #[must_use]
    pub fn is_spent(&self) -> bool {
        self.is_final && self.dense.is_empty()
    }

    /// Content for a tick.
    #[must_use]
    pub fn supply(&self, tick: u64) -> Supply {
        if !self.dense.is_empty() && tick >= self.first && tick < self.end() {
            Supply::Dense
        } else if tick > self.anchor.tick && self.tail.last().is_some_and(|last| tick <= last.tick) {
            Supply::Tail
        } else {
            Supply::Nothing
        }
    }

    /// Returns whether executing this tick is an underrun: the stream has begun, is not final, and has nothing newer than
    /// a tail.
    #[must_use]
    pub fn is_underrun(&self, tick: u64) -> bool {
        !self.is_final && tick > self.anchor.tick && self.supply(tick) != Supply::Dense
    }

    /// The setpoint of a tick; `None` where the axes hold.
    #[must_use]
    pub fn at(&self, tick: u64) -> Option<Setpoint> {
        match self.supply(tick) {
            Supply::Dense => usize::try_from(tick - self.first).ok().and_then(|i| self.dense.get(i)).copied(),
            Supply::Tail => Some(self.shifted(self.sample_tail(tick), self.anchor.tick, tick)),
            Supply::Nothing => None,
        }
    }

    /// Forgets what lies before the next tick to execute.
    pub fn executed(&mut self, tick: u64) {
        while !self.dense.is_empty() && self.first <= tick {
            self.dense.pop_front();
            self.first += 1;
        }
        let shifts = self.shifts;
        for shift in shifts.iter().filter(|shift| shift.tick <= tick && self.anchor.tick < shift.tick) {
            // What rests or stops in the old reading is turned into the new one, and the shift is done.
            self.anchor.setpoint = shift.apply(self.anchor.setpoint);
            self.tail.iter_mut().for_each(|point| point.setpoint = shift.apply(point.setpoint));
        }
        self.shifts = FixedList::new();
        for shift in shifts.iter().filter(|shift| shift.tick > tick) {
            self.shifts.push(*shift);
        }
    }

    /// Takes a chunk. `executed` is the last tick executed.
    ///
    /// # Errors
    /// See [`ChunkError`]; the buffer is unchanged then.
    pub fn accept(&mut self, chunk: &Chunk<'_>, executed: u64) -> Result<(), ChunkError> {
        let last_tick = self.check_shape(chunk, executed)?;
        let gap = self.gap(chunk.first_tick, executed);
        let expected = self.anchor.tick + 1;
        if !self.is_final && chunk.first_tick > expected {
            return Err(ChunkError::Lost { first_tick: chunk.first_tick, expected });
        }
        let kept = self.kept(chunk.first_tick);
        let count = kept.saturating_add(gap).saturating_add(chunk.dense.len());
        if count > self.capacity {
            return Err(ChunkError::TooLong { what: "setpoints", count, capacity: self.capacity });
        }
        let mut before = self.value(chunk.first_tick - 1);
        let mut tick_before = chunk.first_tick - 1;
        for (tick, setpoint) in (chunk.first_tick..).zip(chunk.dense) {
            before = self.shifted(before, tick_before, tick);
            if let Some(misfit) = self.plausibility.misfit(&before, setpoint) {
                return Err(ChunkError::Misfit { tick, misfit });
            }
            (before, tick_before) = (*setpoint, tick);
        }
        // From here on nothing is refused.
        self.dense.truncate(kept);
        let from = chunk.first_tick - gap as u64;
        if kept == 0 {
            self.first = from;
        }
        for tick in from..chunk.first_tick {
            let setpoint = self.value(tick);
            self.dense.push_back(setpoint);
        }
        self.dense.extend(chunk.dense);
        self.anchor = TailPoint { tick: last_tick, setpoint: before };
        self.tail.clear();
        self.tail.extend_from_slice(chunk.tail);
        self.is_final = chunk.is_final;
        Ok(())
    }

    /// Checks a chunk without its neighbours; returns its last dense tick.
    fn check_shape(&self, chunk: &Chunk<'_>, executed: u64) -> Result<u64, ChunkError> {
        if !self.is_open {
            return Err(ChunkError::Closed);
        }
        let Some(last) = chunk.dense.last() else { return Err(ChunkError::Empty) };
        if chunk.first_tick <= executed {
            return Err(ChunkError::Late { first_tick: chunk.first_tick, executed });
        }
        let last_tick = chunk.first_tick.saturating_add(chunk.dense.len() as u64 - 1);
        if last_tick > self.credit(executed) {
            return Err(ChunkError::BeyondCredit { last_tick, credit: self.credit(executed) });
        }
        if chunk.tail.len() > MAX_TAIL_POINTS {
            let (count, capacity) = (chunk.tail.len(), MAX_TAIL_POINTS);
            return Err(ChunkError::TooLong { what: "tail points", count, capacity });
        }
        let mut previous = last_tick;
        for (index, point) in chunk.tail.iter().enumerate() {
            if point.tick <= previous {
                return Err(ChunkError::TailOrder { index, tick: point.tick });
            }
            let numbers = point.setpoint.velocity.iter().chain(&point.setpoint.acceleration);
            if !numbers.into_iter().all(|number| number.is_finite()) {
                return Err(ChunkError::NotFinite { index });
            }
            previous = point.tick;
        }
        let end = chunk.tail.last().map_or(last, |point| &point.setpoint);
        if end.velocity.iter().chain(&end.acceleration).all(|number| *number == 0.0) {
            Ok(last_tick)
        } else {
            Err(ChunkError::NotAtRest)
        }
    }

    /// One tick after the last dense setpoint.
    fn end(&self) -> u64 {
        self.first + self.dense.len() as u64
    }

    /// Dense setpoints that stay before a chunk.
    fn kept(&self, first_tick: u64) -> usize {
        let before = first_tick.saturating_sub(self.first);
        usize::try_from(before).map_or(self.dense.len(), |before| before.min(self.dense.len()))
    }

    /// Ticks before a chunk that only the present tail, or the rest after it, supplies, and that must become dense.
    fn gap(&self, first_tick: u64, executed: u64) -> usize {
        let from = self.end().max(self.anchor.tick + 1).max(executed + 1);
        let supplied = !self.dense.is_empty() || self.supply(from) == Supply::Tail;
        if supplied { usize::try_from(first_tick.saturating_sub(from)).unwrap_or(usize::MAX) } else { 0 }
    }

    /// The setpoint of a tick, resting ones included, in the reading of that tick.
    fn value(&self, tick: u64) -> Setpoint {
        self.at(tick).unwrap_or_else(|| {
            // Right after the last dense setpoint was executed the tail has not begun.
            let end = self.tail.last().filter(|_| tick > self.anchor.tick).unwrap_or(&self.anchor);
            self.shifted(end.setpoint, self.anchor.tick, tick)
        })
    }

    /// A setpoint in the reading of tick `from`, in the reading of tick `to`.
    fn shifted(&self, mut setpoint: Setpoint, from: u64, to: u64) -> Setpoint {
        for shift in self.shifts.iter().filter(|shift| shift.tick > from && shift.tick <= to) {
            setpoint = shift.apply(setpoint);
        }
        setpoint
    }

    fn sample_tail(&self, tick: u64) -> Setpoint {
        let right = self.tail.partition_point(|point| point.tick <= tick);
        let left = if right == 0 { &self.anchor } else { &self.tail[right - 1] };
        let Some(right) = self.tail.get(right) else { return left.setpoint };
        let seconds = |ticks: u64| ticks as f64 * self.cycle_time_s;
        let mut setpoint = Setpoint::default();
        for i in 0..AXIS_COUNT {
            let scale = self.counts_per_unit[i];
            let start = left.setpoint.counts[i];
            let knot = |at: f64, point: &TailPoint| Knot {
                at,
                value: point.setpoint.counts[i].saturating_sub(start) as f64,
                first: point.setpoint.velocity[i] * scale,
                second: point.setpoint.acceleration[i] * scale,
            };
            let (end, at) = (seconds(right.tick - left.tick), seconds(tick - left.tick));
            let sample = quintic(&knot(0.0, left), &knot(end, right), at);
            setpoint.counts[i] = start.saturating_add(nearest_count(sample.value));
            setpoint.velocity[i] = sample.first / scale;
            setpoint.acceleration[i] = sample.second / scale;
        }
        setpoint
    }
}

#[cfg(test)]
mod tests;
