//! Keyframes: the state of the machine and of its cyclic thread after a tick, from which a replay can begin.
//!
//! The cyclic thread writes them itself, into room that it was given: the thousands of numbers of a part are written in some ten
//! microseconds, without an allocation, and nothing can change meanwhile. The pump makes messages of them and gives the room back.

use super::cyclic_loop::{Pace, Ticker};
use super::messages::Outbound;
use camwright::math::snapshot::{Kept, Place, Tape, TapeError};

/// Form of the state: it grows with every change of what a keyframe holds, and only the same form can be read.
pub const FORM: u32 = 1;

/// Default time of the machine between two keyframes (s).
pub const PERIOD_S: f64 = 10.0;
/// Most that keyframes add to a recording (B/s of the machine's time): a large state is written less often.
const BYTES_PER_S: f64 = 100_000.0;
/// A state above this (B) takes a good part of a tick: a machine that keeps pace with the clock writes it while nothing moves.
const MAX_MOVING: usize = 4 << 20;
/// Room beyond a state at rest, for what comes and goes: setpoints, commands, alarms (B).
const SLACK: usize = 64 << 10;

/// Ticks between two keyframes of a state of this size (B) that are `period_s` apart (s) at least; 0: there are none.
#[allow(clippy::cast_possible_truncation, reason = "hours of ticks")]
pub fn ticks_between(size: usize, period_s: f64, cycle_s: f64) -> u64 {
    if period_s <= 0.0 {
        return 0;
    }
    let periods = (size as f64 / (BYTES_PER_S * period_s)).ceil().max(1.0);
    (periods * (period_s / cycle_s).round()).max(1.0) as u64
}

/// What a keyframe is written into.
#[derive(Debug)]
pub struct Room {
    octets: Vec<u8>,
    written: Result<usize, (TapeError, Place)>,
}

impl Room {
    fn of(size: usize) -> Box<Self> {
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
    pub fn again(mut self: Box<Self>) -> Box<Self> {
        if matches!(self.written, Err((TapeError::NoRoom, _))) {
            self.octets.resize(2 * self.octets.len(), 0);
        }
        self
    }
}

/// When the cyclic thread writes keyframes, and into what.
#[derive(Debug, Default)]
pub struct Keyframes {
    /// (s); 0: none.
    period_s: f64,
    cycle_s: f64,
    /// A clock waits for nobody.
    by_the_clock: bool,
    /// The tick from which on one is due.
    due: u64,
    /// Octets of the state with its part.
    size: usize,
    pub room: Option<Box<Room>>,
}

impl Keyframes {
    pub fn new(period_s: f64, cycle_s: f64, pace: Pace) -> Self {
        Self { period_s, cycle_s, by_the_clock: pace == Pace::Realtime, ..Self::default() }
    }

    fn ticks(&self) -> u64 {
        ticks_between(self.size, self.period_s, self.cycle_s)
    }
}

impl Ticker {
    /// With keyframes from now on.
    pub fn with_keyframes(mut self, keyframes: Keyframes) -> Self {
        self.keyframes = keyframes;
        if self.keyframes.period_s > 0.0 {
            self.keyframes.room = Some(Room::of(0));
            self.keyframes.due = self.keyframes.ticks();
        }
        self.measure_keyframe();
        self
    }

    /// A part was taken: there is room for it. Called where allocating is allowed, at rest.
    pub fn measure_keyframe(&mut self) {
        let mut tape = Tape::measuring();
        if self.keyframes.period_s <= 0.0 || self.keep(&mut tape).is_err() {
            return;
        }
        self.keyframes.size = tape.octets();
        if let Some(room) = self.keyframes.room.as_mut().filter(|room| room.octets.len() < tape.octets() + SLACK) {
            *room = Room::of(tape.octets());
        }
    }

    /// A tick is over: writes a keyframe if one is due.
    pub fn write_keyframe(&mut self) {
        let tick = self.machine.tick();
        if self.keyframes.period_s <= 0.0 || tick < self.keyframes.due {
            return;
        }
        let rests = self.machine.is_at_rest() && !self.buffer.has_setpoints();
        if self.keyframes.by_the_clock && self.keyframes.size > MAX_MOVING && !rests {
            return;
        }
        let Some(mut room) = self.keyframes.room.take() else { return };
        let mut tape = Tape::writing(&mut room.octets);
        let written = self.keep(&mut tape);
        room.written = written.map(|()| tape.octets()).map_err(|error| (error, tape.place()));
        let ticks = self.keyframes.ticks().max(1);
        self.keyframes.due = (tick / ticks + 1).saturating_mul(ticks);
        self.send(Outbound::Keyframe(room));
    }
}
