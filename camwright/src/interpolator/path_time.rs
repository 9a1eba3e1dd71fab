// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Path time: how far a motion has come, in ticks of its own undisturbed clock.
//!
//! Override, hold and cancel scale path time; the path stays. Path time is a fixed-point number (ticks, 32 fractional
//! bits) computed from the tick and an anchor, never summed up tick by tick: undisturbed it is the integer tick
//! itself, and however long a part takes nothing drifts.

use crate::math::hermite::Sample;
use crate::motion::path_stop::{rate_step, rate_step_area, rate_step_slope};

/// Rate 1, and one tick of path time.
pub(crate) const ONE: i64 = 1 << 32;

/// Ticks (not rounded) as path time.
#[allow(clippy::cast_possible_truncation, reason = "motions are below 2^31 ticks, 24 days at 1 kHz")]
pub(crate) fn from_ticks(ticks: f64) -> i64 {
    libm::round(ticks * ONE as f64) as i64
}

/// Path time in ticks.
pub(crate) fn to_ticks(tau: i64) -> f64 {
    tau as f64 / ONE as f64
}

/// Whole ticks as path time.
pub(crate) fn whole(ticks: u64) -> i64 {
    i64::try_from(ticks).unwrap_or(i64::MAX >> 33).saturating_mul(ONE)
}

/// Path time at one tick, with the rate at which it passes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PathTime {
    /// Path time (ticks, fixed point).
    pub(crate) tau: i64,
    /// Rate: path time per time.
    pub(crate) rate: f64,
    /// Change of the rate (1/tick).
    pub(crate) slope: f64,
}

impl PathTime {
    /// First and second derivative in time (s) of what goes by a law over path time (s), of which a tick takes `cycle_s`.
    pub(super) fn scale(&self, law: &Sample, cycle_s: f64) -> (f64, f64) {
        (self.rate * law.first, self.rate * self.rate * law.second + self.slope / cycle_s * law.first)
    }
}

/// From an anchor on, a rate that changes from one value to another by a quintic smoothstep and then stays.
#[derive(Debug, Clone, Copy, PartialEq)]
struct RateSegment {
    anchor: u64,
    tau: i64,
    from: i64,
    to: i64,
    ticks: u64,
}

impl RateSegment {
    #[allow(clippy::cast_possible_truncation, reason = "bounded by ticks · 2^32")]
    fn at(&self, tick: u64) -> PathTime {
        let n = tick.saturating_sub(self.anchor);
        let count = |ticks: u64| i64::try_from(ticks).unwrap_or(i64::MAX >> 33);
        let change = self.to - self.from;
        if n >= self.ticks {
            let ramp = self.from.saturating_mul(count(self.ticks)) + change.saturating_mul(count(self.ticks)) / 2;
            let tau = self.tau + ramp + self.to.saturating_mul(count(n - self.ticks));
            return PathTime { tau, rate: to_ticks(self.to), slope: 0.0 };
        }
        let length = self.ticks as f64;
        let u = n as f64 / length;
        let area = libm::round(change as f64 * length * rate_step_area(u)) as i64;
        PathTime {
            tau: self.tau + self.from.saturating_mul(count(n)) + area,
            rate: to_ticks(self.from) + to_ticks(change) * rate_step(u),
            slope: to_ticks(change) * rate_step_slope(u) / length,
        }
    }

    fn steady_from(&self) -> u64 {
        self.anchor + self.ticks
    }
}

/// Clock of a motion. It retains the piece before its last one too: a stop that can only begin after a change in progress
/// must be reported as a whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PathClock {
    piece: RateSegment,
    earlier: Option<RateSegment>,
}

impl PathClock {
    /// Path time 0 at a tick, passing at a steady rate.
    pub(crate) fn starting(tick: u64, rate: i64) -> Self {
        Self { piece: RateSegment { anchor: tick, tau: 0, from: rate, to: rate, ticks: 0 }, earlier: None }
    }

    /// First tick of the last change of its rate; of a clock that just started, the tick from which path time passes.
    pub(super) fn begins(&self) -> u64 {
        self.piece.anchor
    }

    /// Lets a clock that has not begun begin no earlier than a tick.
    pub(super) fn postpone(&mut self, tick: u64) {
        self.piece.anchor = self.piece.anchor.max(tick);
    }

    /// Path time at a tick.
    pub(crate) fn at(&self, tick: u64) -> PathTime {
        match &self.earlier {
            Some(earlier) if tick < self.piece.anchor => earlier.at(tick),
            _ => self.piece.at(tick),
        }
    }

    /// The rate is 0 and stays 0.
    pub(crate) fn is_stopped(&self, tick: u64) -> bool {
        self.piece.to == 0 && tick >= self.piece.steady_from()
    }

    /// Turns towards another rate from a tick on. A change already under way is finished first, so that the slope of
    /// the rate never jumps; the caller asks again every tick.
    pub(crate) fn retarget(&mut self, tick: u64, rate: i64, ticks: u64) {
        let piece = self.piece;
        if rate != piece.to && tick >= piece.steady_from() {
            self.piece =
                RateSegment { anchor: tick, tau: piece.at(tick).tau, from: piece.to, to: rate, ticks: ticks.max(1) };
            self.earlier = Some(piece);
        }
    }

    /// The clock that comes to a stop as soon as it can, and the tick of the stop.
    pub(crate) fn stopping(&self, tick: u64, ticks: u64) -> (Self, u64) {
        let mut clock = *self;
        clock.retarget(self.piece.steady_from().max(tick), 0, ticks);
        (clock, clock.piece.steady_from().max(tick))
    }

    /// Takes path time back, where a motion repeats itself.
    pub(crate) fn rewind(&mut self, by: i64) {
        self.piece.tau -= by;
        if let Some(earlier) = &mut self.earlier {
            earlier.tau -= by;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undisturbed_path_time_is_the_tick() {
        let clock = PathClock::starting(1000, ONE);
        for n in [0, 1, 17, 86_400_000] {
            assert_eq!(clock.at(1000 + n).tau, whole(n));
        }
    }

    /// Half the length of a stop passes during it: the smoothstep is symmetrical.
    #[test]
    fn a_stop_covers_half_its_length_and_a_ramp_is_smooth() {
        let mut clock = PathClock::starting(0, ONE);
        clock.retarget(100, 0, 50);
        assert_eq!(clock.at(150).tau, whole(125));
        assert_eq!(clock.at(900).tau, whole(125));
        assert!(clock.is_stopped(150) && !clock.is_stopped(149));
        for tick in 100..160 {
            let (left, mid, right) = (clock.at(tick), clock.at(tick + 1), clock.at(tick + 2));
            let rate = to_ticks(right.tau - left.tau) / 2.0;
            assert!((rate - mid.rate).abs() < 1e-3, "{tick}: {rate} {}", mid.rate);
            assert!(((right.rate - left.rate) / 2.0 - mid.slope).abs() < 1e-3);
        }
    }

    #[test]
    fn a_new_target_waits_for_the_change_under_way() {
        let mut clock = PathClock::starting(0, ONE);
        clock.retarget(0, ONE / 2, 10);
        clock.retarget(5, ONE, 10);
        assert_eq!(clock.piece.to, ONE / 2);
        clock.retarget(10, ONE, 10);
        assert_eq!(clock.piece.to, ONE);
        let (stopping, stop) = clock.stopping(12, 10);
        assert_eq!(stop, 30);
        assert!(stopping.is_stopped(30));
        // The change under way goes on as it was until the stop begins.
        assert_eq!(stopping.at(15), clock.at(15));
    }
}
