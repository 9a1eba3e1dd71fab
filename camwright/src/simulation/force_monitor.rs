// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The force monitor of the wheelhead: whether the normal force has been the same over the last turn of the part.
//!
//! A load cell under the wheel spindle, as cylindrical grinders carry it to end spark-out (Toyoda, JPS61103770: spark-out ends when the
//! change of the force over a turn of the part is small). What the force still differs by over a turn, divided by the machine's
//! stiffness km, is what wheel and part still deflect differently. Since a turn of spark-out leaves kg/(kg + km) of what the force is
//! above its threshold F0, a change of ΔF over a turn means that at most (ΔF (1 + kg/km) + F0)/km is left on the part.

use crate::math::range::minimum_and_maximum;
use crate::math::units::TURN_RAD;

/// Sectors of a turn; the force of a sector is the mean over it, so that what the wheel's own turning does to it averages out.
const SECTORS: u32 = 72;

/// Watches the force over the last whole turn of C.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceMonitor {
    /// Most that the sectors of a turn may differ by (N); 0: it does not watch.
    max_n: f64,
    /// Mean force of each sector when it was last passed (N).
    mean_n: [f64; SECTORS as usize],
    /// Sectors passed in one direction without a break, at most a turn.
    passed: u32,
    /// The sector under way, counted on over turns, and what is summed up in it.
    sector: i64,
    sum_n: f64,
    count: u32,
    is_closed: bool,
}

crate::snapshot!(ForceMonitor { max_n, mean_n, passed, sector, sum_n, count, is_closed } on {});

impl Default for ForceMonitor {
    fn default() -> Self {
        Self {
            max_n: 0.0,
            mean_n: [0.0; SECTORS as usize],
            passed: 0,
            sector: 0,
            sum_n: 0.0,
            count: 0,
            is_closed: false,
        }
    }
}

impl ForceMonitor {
    /// Watches anew, from the present on: its input is open until a whole turn has been seen.
    pub fn watch(&mut self, max_n: f64) {
        *self = Self { max_n, ..Self::default() };
    }

    /// The force has been the same over the last turn, within what was asked for.
    #[must_use]
    pub const fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// A tick is over, with C there (rad, counted on over turns) and this normal force (N). Says so when its input closes or opens.
    pub fn tick(&mut self, c_rad: f64, force_n: f64) -> Option<bool> {
        if self.max_n <= 0.0 {
            return None;
        }
        #[allow(clippy::cast_possible_truncation, reason = "turns of a job")]
        let sector = libm::floor(c_rad / TURN_RAD * f64::from(SECTORS)) as i64;
        if sector == self.sector {
            self.sum_n += force_n;
            self.count = self.count.saturating_add(1);
            return None;
        }
        let step = sector.saturating_sub(self.sector);
        let mean_n = if self.count > 0 { self.sum_n / f64::from(self.count) } else { force_n };
        let same_way = (1..=i64::from(SECTORS)).contains(&step);
        if same_way && self.count > 0 {
            // A part that turns fast passes several sectors in a tick.
            for passed in self.sector..sector {
                self.mean_n[Self::place(passed)] = mean_n;
            }
            let step = u32::try_from(step).unwrap_or(SECTORS);
            self.passed = (self.passed + step).min(SECTORS);
        } else {
            self.passed = 0;
        }
        (self.sector, self.sum_n, self.count) = (sector, force_n, 1);
        let closed = self.passed == SECTORS && self.variation_n() <= self.max_n;
        let changed = closed != self.is_closed;
        self.is_closed = closed;
        changed.then_some(closed)
    }

    /// Difference between the sectors of the last turn (N).
    #[must_use]
    pub fn variation_n(&self) -> f64 {
        let (low, high) = minimum_and_maximum(self.mean_n);
        high - low
    }

    #[allow(clippy::cast_possible_truncation, reason = "below the number of sectors")]
    const fn place(sector: i64) -> usize {
        sector.rem_euclid(SECTORS as i64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    /// Ticks of a turn in the tests.
    const TICKS: u32 = 1000;

    /// C after so many ticks, and the edges, over a force that depends on the turn and on where C is in it.
    fn edges(monitor: &mut ForceMonitor, turns: u32, mut force_n: impl FnMut(u32, f64) -> f64) -> Vec<(f64, bool)> {
        let ticks = (0..turns * TICKS).map(|tick| {
            let turned = f64::from(tick) / f64::from(TICKS);
            let edge = monitor.tick(turned * TURN_RAD, force_n(tick / TICKS, turned.fract()));
            edge.map(|closed| (turned, closed))
        });
        ticks.flatten().collect()
    }

    /// The force halves from turn to turn on one side of the part: the first whole turn below the bound closes the input.
    #[test]
    fn the_input_closes_when_a_whole_turn_is_within_the_bound() {
        let mut monitor = ForceMonitor::default();
        monitor.watch(10.0);
        let force_n = |turn: u32, place: f64| if place < 0.5 { 80.0 / f64::from(1 << turn) } else { 0.0 };
        let edges = edges(&mut monitor, 8, force_n);
        // Turn 3 has 10 N on its first half; the other half was never other than 0: it closes with the middle of turn 3.
        assert_eq!(edges.len(), 1, "{edges:?}");
        assert!(edges[0].1 && (edges[0].0 - 3.5).abs() < 0.02, "{edges:?}");
        assert!(monitor.is_closed() && monitor.variation_n() < 1.0);
    }

    #[test]
    fn no_reading_before_a_whole_turn_or_without_request() {
        let mut monitor = ForceMonitor::default();
        assert!(edges(&mut monitor, 3, |_, _| 5.0).is_empty());
        monitor.watch(1.0);
        let edges = edges(&mut monitor, 3, |_, _| 5.0);
        assert_eq!(edges.len(), 1);
        assert!(edges[0].0 >= 1.0, "{edges:?}");
    }

    #[test]
    fn a_force_that_comes_back_opens_it_and_a_part_turned_back_begins_anew() {
        let mut monitor = ForceMonitor::default();
        monitor.watch(1.0);
        let edges =
            edges(&mut monitor, 4, |turn, place| if turn == 2 && place > 0.25 && place < 0.5 { 50.0 } else { 5.0 });
        assert_eq!(edges.iter().map(|edge| edge.1).collect::<Vec<_>>(), [true, false, true], "{edges:?}");
        assert!(edges[1].0 < 2.5 && edges[2].0 > 3.45);
        assert_eq!(monitor.tick(3.0 * TURN_RAD, 5.0), Some(false));
    }

    /// The force variation by the wheel's own rotation averages out within a sector.
    #[test]
    fn a_fast_wave_of_the_wheel_is_no_variation_of_a_turn() {
        let mut monitor = ForceMonitor::default();
        monitor.watch(2.0);
        let mut tick = 0_u32;
        let edges = edges(&mut monitor, 3, |_, _| {
            tick += 1;
            20.0 + 5.0 * libm::cos(f64::from(tick) * 2.1)
        });
        assert_eq!(edges.len(), 1, "{edges:?} {} N", monitor.variation_n());
    }
}
