// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! C turning on between two cuts, while the other axes do what the segments in between say.

use super::path_time::{PathClock, to_ticks};
use super::pose::in_counts;
use crate::machine::description::{Axis, MachineDescription, MotionLimits};
use crate::machine::setpoint::{Setpoint, StopPoint};
use crate::math::units::TURN_RAD;
use crate::motion::path_stop::path_stop_s;
use crate::motion::point_to_point::{JerkLaw, whole_ticks};
use crate::motion::speed_change::{SPEED_CHANGE_SHARE, change_of_speed};

/// Data of C between two cuts, known before anything moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SpinFacts {
    /// Angle over time since the cut before ended.
    pub(crate) law: JerkLaw,
    /// Length of a stop from anywhere in it (ticks).
    pub(crate) stop_ticks: u64,
}

impl SpinFacts {
    /// From the speed of one cut to that of the next (rad/s).
    pub(crate) fn new(from_rad_s: f64, to_rad_s: f64, machine: &MachineDescription) -> Self {
        let c = machine.axis(Axis::C).limits;
        let peaks = MotionLimits { velocity: from_rad_s.max(to_rad_s), ..c.with_share(SPEED_CHANGE_SHARE) };
        // Half the limits are free; only a speed that no axis has would need longer.
        let stop_s = path_stop_s(&peaks, &c).unwrap_or(1.0);
        let stop_ticks = whole_ticks(stop_s, machine.cycle_time_s()).max(1);
        Self { law: change_of_speed(from_rad_s, to_rad_s, &c), stop_ticks }
    }
}

/// C turning, in execution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FreeRotation {
    clock: PathClock,
    /// Path time at which it began.
    from: i64,
    /// C there: whole counts, and counts in addition.
    base: i64,
    offset: f64,
    facts: SpinFacts,
    cycle_s: f64,
}

impl FreeRotation {
    /// Goes on from a place of C (counts, and counts in addition) at a path time of a clock.
    pub(crate) fn new(clock: PathClock, from: i64, place: (i64, f64), facts: SpinFacts, cycle_s: f64) -> Self {
        Self { clock, from, base: place.0, offset: place.1, facts, cycle_s }
    }

    /// The clock that it goes by.
    pub(crate) fn clock(&self) -> PathClock {
        self.clock
    }

    /// C at a tick: whole counts, and counts in addition.
    pub(crate) fn place(&self, tick: u64, machine: &MachineDescription) -> (i64, f64) {
        let turned = self.facts.law.sample(self.since(tick)).value;
        (self.base, self.offset + in_counts(machine.axis(Axis::C).scale, turned))
    }

    fn since(&self, tick: u64) -> f64 {
        to_ticks(self.clock.at(tick).tau - self.from) * self.cycle_s
    }

    /// Velocity and acceleration of C at a tick (rad, s).
    fn rates(&self, tick: u64) -> (f64, f64) {
        self.clock.at(tick).scale(&self.facts.law.sample(self.since(tick)), self.cycle_s)
    }

    /// Puts C of a tick into a setpoint.
    #[allow(clippy::cast_possible_truncation, reason = "travel in counts is below 2^53")]
    pub(crate) fn apply(&self, tick: u64, machine: &MachineDescription, setpoint: &mut Setpoint) {
        let c = Axis::C.index();
        let (base, offset) = self.place(tick, machine);
        setpoint.counts[c] = base.saturating_add(libm::round(offset) as i64);
        (setpoint.velocity[c], setpoint.acceleration[c]) = self.rates(tick);
    }

    /// Puts C of a tick into a point of a stop.
    pub(crate) fn put_point(&self, tick: u64, machine: &MachineDescription, point: &mut StopPoint) {
        let c = Axis::C.index();
        let scale = machine.axis(Axis::C).scale;
        let (base, offset) = self.place(tick, machine);
        point.position[c] = scale.position(base) + offset / scale.counts_per_unit();
        (point.velocity[c], point.acceleration[c]) = self.rates(tick);
    }

    /// At the speed of the next cut.
    pub(crate) fn is_steady(&self, tick: u64) -> bool {
        self.since(tick) >= self.facts.law.duration()
    }

    pub(crate) fn is_stopped(&self, tick: u64) -> bool {
        self.clock.is_stopped(tick)
    }

    pub(crate) fn set_rate(&mut self, tick: u64, rate: i64) {
        self.clock.retarget(tick, rate, self.facts.stop_ticks);
    }

    /// The same, stopping as soon as it can, and the tick of its stop.
    pub(crate) fn stopping(&self, tick: u64) -> (Self, u64) {
        let (clock, end) = self.clock.stopping(tick, self.facts.stop_ticks);
        (Self { clock, ..*self }, end)
    }
}

/// Position in its law of a cut that C enters while turning (rad since the law's start, not above a tick's travel; below 0: C
/// has not reached it yet), and C at the start of the cut (counts): the next position with the cut's phase.
#[allow(clippy::cast_possible_truncation, reason = "travel in counts is below 2^53")]
pub(crate) fn next_start(
    place: (i64, f64),
    start_counts: i64,
    law_start_rad: f64,
    way_of_tick_rad: f64,
    machine: &MachineDescription,
) -> (f64, i64) {
    let scale = machine.axis(Axis::C).scale;
    let turn_counts = scale.counts(TURN_RAD).max(1);
    let (turn, per_rad) = (turn_counts as f64, scale.counts_per_unit());
    let since = (place.0 - start_counts) as f64 + place.1 - in_counts(scale, law_start_rad);
    let turns = libm::ceil((since - way_of_tick_rad * per_rad) / turn);
    ((since - turns * turn) / per_rad, start_counts + turns as i64 * turn_counts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::reference::cam_grinder;

    /// The next start lies less than a turn ahead, or less than a tick behind; its phase is the cut's.
    #[test]
    fn the_next_start_is_the_first_that_can_still_be_met() {
        let machine = cam_grinder();
        let scale = machine.axis(Axis::C).scale;
        let turn = scale.counts(TURN_RAD);
        let tick_rad = 0.006;
        for place in [-3 * turn - 7, -1, 0, 1, 100, turn / 3, 5 * turn + 11] {
            for start in [0, 1, turn / 2, turn - 1] {
                for law_start_rad in [0.0, -0.7, -7.0] {
                    let (since, counts) = next_start((place, 0.25), start, law_start_rad, tick_rad, &machine);
                    assert_eq!((counts - start).rem_euclid(turn), 0);
                    assert!(since <= tick_rad && since > tick_rad - TURN_RAD, "{since}");
                    let there = scale.position(counts) + law_start_rad + since;
                    let here = scale.position(place) + 0.25 / scale.counts_per_unit();
                    assert!((there - here).abs() < 1e-9, "{there} {here}");
                }
            }
        }
    }
}
