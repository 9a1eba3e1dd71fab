// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The size monitor of the in-process gauge: the mean diameter over the last turn of the part against a size.
//!
//! Gauge amplifiers of cylindrical grinders switch an output at a size. This one averages the diameter over a whole turn of C. The mean
//! does not depend on where the gauge stands in the turn, no even wave of the part moves it, and noise averages out of it; the smallest
//! diameter would be reached too early by noise and by every flat. At a feed f per turn of the radius the mean lags the reading by f in
//! the diameter, which is the same on every part.
//!
//! ```text
//!  mean = (71 whole sectors + what has passed of the present one + what remains of the oldest)/72
//!         |--- a turn ---------------------------------|
//!  ... |oldest|  2  |  3  | ...                  | present
//! ```
//! Its output closes once and stays closed until it watches anew.

use crate::machine::wheel_state::mm_from_nm;
use crate::math::units::TURN_RAD;

/// Sectors of a turn: the 5° steps of the published measurement.
const SECTORS: u32 = 72;

/// Watches the mean diameter over the last whole turn of C.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizeMonitor {
    /// Diameter that closes the output (nm); 0: it does not watch.
    diameter_nm: i64,
    /// Sum of the diameter over C in each sector when it was last passed (mm·sectors).
    passed_mm: [f64; SECTORS as usize],
    /// Sectors passed forwards without a break, at most a turn and one. The first of them may have been entered in its middle.
    passed: u32,
    /// C (sectors) and diameter of the last reading (mm); none before the first.
    last: Option<[f64; 2]>,
    /// Sum over the present sector, from its beginning or from the first reading on (mm·sectors).
    present_mm: f64,
    is_closed: bool,
}

crate::snapshot!(SizeMonitor { diameter_nm, passed_mm, passed, last, present_mm, is_closed } on {});

impl Default for SizeMonitor {
    fn default() -> Self {
        Self {
            diameter_nm: 0,
            passed_mm: [0.0; SECTORS as usize],
            passed: 0,
            last: None,
            present_mm: 0.0,
            is_closed: false,
        }
    }
}

impl SizeMonitor {
    /// Watches anew, from the present on: its output is open until a whole turn has been read.
    pub fn watch(&mut self, diameter_nm: i64) {
        *self = Self { diameter_nm: diameter_nm.max(0), ..Self::default() };
    }

    #[must_use]
    pub const fn is_watching(&self) -> bool {
        self.diameter_nm > 0
    }

    /// Returns whether the size has been read since it watches.
    #[must_use]
    pub const fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// Ends a tick with C there (rad, counted on over turns) and this diameter (mm); `None`: the gauge reads nothing. True in the tick in
    /// which the output closes.
    pub fn tick(&mut self, c_rad: f64, diameter_mm: Option<f64>) -> bool {
        if !self.is_watching() || self.is_closed {
            return false;
        }
        let Some(diameter_mm) = diameter_mm.filter(|mm| mm.is_finite()) else {
            self.begin_again(None);
            return false;
        };
        let at = c_rad / TURN_RAD * f64::from(SECTORS);
        match self.last.replace([at, diameter_mm]) {
            // A part that turns forwards, by less than a turn in a tick.
            Some([from, from_mm]) if at > from && at - from < f64::from(SECTORS) => {
                self.add(from, from_mm, at, diameter_mm);
            }
            Some([from, _]) if at.to_bits() == from.to_bits() => {}
            _ => self.begin_again(Some([at, diameter_mm])),
        }
        self.is_closed = self.mean_mm().is_some_and(|mean_mm| mean_mm <= mm_from_nm(self.diameter_nm));
        self.is_closed
    }

    /// Mean diameter over the last turn (mm); `None` before a whole turn has been read.
    #[must_use]
    pub fn mean_mm(&self) -> Option<f64> {
        let [at, _] = self.last?;
        if self.passed <= SECTORS {
            return None;
        }
        let sector = libm::floor(at);
        let oldest_mm = self.passed_mm[place(sector)];
        let whole_mm: f64 = self.passed_mm.iter().sum();
        // What has passed of the present sector takes the place of as much of the oldest.
        Some((whole_mm - oldest_mm * (at - sector) + self.present_mm) / f64::from(SECTORS))
    }

    /// Discards what has been read.
    fn begin_again(&mut self, last: Option<[f64; 2]>) {
        (self.passed, self.present_mm, self.last) = (0, 0.0, last);
    }

    /// Adds the trapezoid between two readings, sector by sector.
    fn add(&mut self, from: f64, from_mm: f64, to: f64, to_mm: f64) {
        let slope = (to_mm - from_mm) / (to - from);
        let at_mm = |place: f64| from_mm + slope * (place - from);
        let mut begin = from;
        loop {
            let sector_end = libm::floor(begin) + 1.0;
            let end = to.min(sector_end);
            self.present_mm += (end - begin) * 0.5 * (at_mm(begin) + at_mm(end));
            if sector_end > to {
                return;
            }
            self.passed_mm[place(sector_end - 1.0)] = self.present_mm;
            self.passed = (self.passed + 1).min(SECTORS + 1);
            self.present_mm = 0.0;
            begin = sector_end;
            if begin >= to {
                return;
            }
        }
    }
}

#[allow(clippy::cast_possible_truncation, reason = "turns of a job, then below the number of sectors")]
fn place(sector: f64) -> usize {
    (sector as i64).rem_euclid(i64::from(SECTORS)) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::snapshot::{Snapshot, SnapshotCodec};
    use alloc::vec::Vec;

    /// C (turns) at which the output closes, read so many times a turn; the diameter depends on C.
    fn closes_at(nm: i64, per_turn: u32, turns: u32, diameter_mm: impl Fn(f64) -> f64) -> Option<f64> {
        let mut monitor = SizeMonitor::default();
        monitor.watch(nm);
        let mut at = (0..per_turn * turns).map(|tick| 0.37 / 72.0 + f64::from(tick) / f64::from(per_turn));
        at.find(|at| monitor.tick(at * TURN_RAD, Some(diameter_mm(*at))))
    }

    /// At a diameter that falls by 2f a turn the mean over a turn is the diameter half a turn ago, at every number of readings; waves of
    /// the part and its raw size do not matter.
    #[test]
    fn the_mean_of_a_turn_is_the_closed_form() {
        let fall_mm = 0.02;
        for per_turn in [997, 1000, 61, 7200] {
            for waves_mm in [0.0, 0.004] {
                let diameter = |at: f64| 40.1 - fall_mm * at + waves_mm * libm::cos(2.0 * TURN_RAD * at);
                let closed = closes_at(40_000_000, per_turn, 9, diameter).expect("it falls below");
                let expected = 5.0 + 0.5;
                let tick = 1.0 / f64::from(per_turn);
                let off = closed - expected;
                // 5 nm of the diameter, and the trapezoids of a wave between few readings.
                let slack = if per_turn > 100 { 2.5e-4 } else { 0.02 };
                assert!(off > -slack && off < tick + slack, "{per_turn} a turn, {waves_mm} mm: {closed} turns");
            }
        }
    }

    #[test]
    fn nothing_closes_before_a_whole_turn_and_after_it_stays_closed() {
        let closed = closes_at(40_000_000, 1000, 3, |_| 39.0).expect("it is below");
        assert!(closed > 1.0 && closed < 1.0 + 2.0 / 72.0, "{closed}");
        let mut monitor = SizeMonitor::default();
        monitor.watch(40_000_000);
        let edges: Vec<f64> = (0..4000_u32)
            .map(|tick| f64::from(tick) / 1000.0)
            .filter(|at| monitor.tick(at * TURN_RAD, Some(if *at < 2.0 { 39.0 } else { 41.0 })))
            .collect();
        assert!(edges.len() == 1 && monitor.is_closed(), "{edges:?}");
        monitor.watch(40_000_000);
        assert!(!monitor.is_closed());
        monitor.watch(0);
        assert!(!monitor.is_watching() && !monitor.tick(1.0, Some(1.0)));
    }

    /// A gauge that lifts off, reads no number or sees the part turn back has to read a whole turn again.
    #[test]
    fn what_interrupts_a_turn_begins_it_anew() {
        for broken in [None, Some(f64::NAN), Some(-1.0)] {
            let mut monitor = SizeMonitor::default();
            monitor.watch(40_000_000);
            let mut closed = None;
            for tick in 0..3000_u32 {
                let at = f64::from(tick) / 1000.0;
                let (c, diameter) = match (tick, broken) {
                    (900, Some(-1.0)) => (at - 0.01, Some(39.0)),
                    (900, reading) => (at, reading),
                    _ => (at, Some(39.0)),
                };
                if monitor.tick(c * TURN_RAD, diameter) {
                    closed = Some(at);
                }
            }
            let closed = closed.expect("it closes later");
            assert!(closed > 1.89 && closed < 1.95, "{broken:?}: {closed}");
        }
    }

    /// The tail of a keyframe is there only while the monitor watches, and brings it back to the bit.
    #[test]
    fn its_state_is_a_tail_that_comes_back() {
        let mut idle = SizeMonitor::default();
        let mut octets = [0; 1024];
        let mut codec = SnapshotCodec::writing(&mut octets);
        codec.tail(&mut idle, false).expect("nothing to write");
        assert_eq!(codec.octets(), 0);
        let mut monitor = SizeMonitor::default();
        monitor.watch(40_000_000);
        (0..700_u32).for_each(|tick| assert!(!monitor.tick(f64::from(tick) * 6e-3, Some(40.5))));
        let mut codec = SnapshotCodec::writing(&mut octets);
        codec.tail(&mut monitor, true).expect("it fits");
        let written = codec.octets();
        let mut again = SizeMonitor::default();
        let mut codec = SnapshotCodec::reading(&octets[..written]);
        codec.tail(&mut again, false).and_then(|()| codec.end()).expect("as written");
        assert_eq!(again, monitor);
        SnapshotCodec::comparing(&octets[..written]).tail(&mut again, true).expect("the same");
        assert!(SnapshotCodec::comparing(&[]).tail(&mut again, true).is_err(), "it watches, and the record has none");
        let mut codec = SnapshotCodec::reading(&[]);
        codec.tail(&mut again, false).expect("nothing to read");
        assert_eq!(again, SizeMonitor::default());
        assert!(SizeMonitor::default().snapshot(&mut SnapshotCodec::reading(&octets[..written - 1])).is_err());
    }
}
