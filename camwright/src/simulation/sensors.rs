// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Origin detector, limit switches with dogs, overtravel switches: what they see, and where their edges are.
//!
//! Positions are true positions in counts. An edge lies at a known position, so what a latch catches is exact at any
//! speed.

use crate::math::units::TURN_RAD;

/// An edge of an input within a servo step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InputEdge {
    /// It closed; false: it opened.
    pub rising: bool,
    /// True position of the axis at the edge (counts).
    pub position: f64,
}

/// The origin detector of the headstock.
///
/// ```text
/// detector        ┌────────┬────────┐
/// (input)     ────┘        │        └────   closed within half a window of the mark
/// index mark  ─────────────┴─────────────   latched, in either direction: keyway's centre faces the wheel
/// ```
/// The latch catches the index mark at the window's centre, not the window's edge, so the caught position is the
/// machine's C zero whichever way the headstock turns. An axis that starts on the mark finds it again after a turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OriginDetector {
    counts_per_turn: f64,
    half_window: f64,
    stuck: Option<bool>,
    /// Position of a spurious second mark (counts from the first).
    second: Option<f64>,
}

crate::snapshot!(OriginDetector { stuck, second } on { counts_per_turn, half_window });

impl OriginDetector {
    /// A detector for a headstock of so many counts per turn; `half_window_rad` on both sides of the mark.
    #[must_use]
    pub fn new(counts_per_turn: f64, half_window_rad: f64) -> Self {
        Self { counts_per_turn, half_window: half_window_rad / TURN_RAD * counts_per_turn, stuck: None, second: None }
    }

    /// A second mark, so many counts from the first; `None`: there is one.
    pub fn set_second(&mut self, counts: Option<f64>) {
        self.second = counts;
    }

    /// Distance of a position from the mark (counts), at most half a turn.
    #[must_use]
    pub fn off_mark(&self, position: f64) -> f64 {
        let turns = position / self.counts_per_turn;
        (turns - libm::round(turns)).abs() * self.counts_per_turn
    }

    /// The input shows this level whatever happens, and nothing is latched.
    pub fn set_stuck(&mut self, level: Option<bool>) {
        self.stuck = level;
    }

    /// Returns whether the detector sees its mark.
    #[must_use]
    pub fn is_closed(&self, position: f64) -> bool {
        let sees = |position: f64| self.off_mark(position) <= self.half_window;
        self.stuck.unwrap_or_else(|| sees(position) || self.second.is_some_and(|second| sees(position - second)))
    }

    /// Edge captured by the latch between two positions less than a turn apart: the index mark, or a second one.
    #[must_use]
    pub fn edge(&self, from: f64, to: f64) -> Option<InputEdge> {
        if self.stuck.is_some() {
            return None;
        }
        self.mark(from, to).or_else(|| {
            let second = self.second?;
            let edge = self.mark(from - second, to - second)?;
            Some(InputEdge { position: edge.position + second, ..edge })
        })
    }

    /// The index mark passed between two positions less than a turn apart, whether the detector sees it or not.
    #[must_use]
    pub fn mark(&self, from: f64, to: f64) -> Option<InputEdge> {
        let (from, to) = (from / self.counts_per_turn, to / self.counts_per_turn);
        let turn = if libm::floor(to) > libm::floor(from) {
            libm::floor(to)
        } else if libm::ceil(to) < libm::ceil(from) {
            libm::ceil(to)
        } else {
            return None;
        };
        Some(InputEdge { rising: true, position: turn * self.counts_per_turn })
    }
}

/// A limit switch and the dog on the table that presses it.
///
/// ```text
/// table →      closes at p ┌───────────┐ opens at p + dog + hysteresis
/// table ←  opens at p − h  └───────────┘ closes at p + dog
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StationSwitch {
    start: f64,
    end: f64,
    hysteresis: f64,
    closed: bool,
    stuck: Option<bool>,
    bounces: bool,
    /// Times that it still toggles after its last edge.
    chatter: u32,
}

crate::snapshot!(StationSwitch { closed, stuck, bounces, chatter } on { start, end, hysteresis });

/// Times that a switch toggles after each edge when it bounces, once in each servo step: an even number, so that it shows
/// its true level afterwards.
const CHATTER: u32 = 6;

impl StationSwitch {
    /// A switch that closes at `start` when the table comes in the positive direction (counts).
    #[must_use]
    pub fn new(start: f64, dog_length: f64, hysteresis: f64, table: f64) -> Self {
        let mut switch =
            Self { start, end: start + dog_length, hysteresis, closed: false, stuck: None, bounces: false, chatter: 0 };
        switch.update(table);
        switch
    }

    /// Looks anew where the table stands, as after power-up.
    pub fn update(&mut self, table: f64) {
        self.closed = table >= self.start && table <= self.end;
    }

    /// The switch shows this level whatever happens.
    pub fn set_stuck(&mut self, level: Option<bool>) {
        self.stuck = level;
    }

    /// The switch bounces from its next edge on, or no longer.
    pub fn set_bouncing(&mut self, bounces: bool) {
        self.bounces = bounces;
        self.chatter = 0;
    }

    /// Returns whether the switch is closed.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.stuck.unwrap_or(self.closed != (self.chatter % 2 == 1))
    }

    /// A bouncing switch toggles once more, with the table at this position.
    pub fn bounce(&mut self, table: f64) -> Option<InputEdge> {
        self.chatter = self.chatter.checked_sub(1)?;
        if self.stuck.is_some() { None } else { Some(InputEdge { rising: self.is_closed(), position: table }) }
    }

    /// Expected state of a working switch with the table at this position, with a tolerance (counts); `None` near its edges.
    #[must_use]
    pub fn expected(&self, table: f64, tolerance: f64) -> Option<bool> {
        let beyond = self.hysteresis + tolerance;
        if table < self.start - beyond || table > self.end + beyond {
            Some(false)
        } else if table > self.start + tolerance && table < self.end - tolerance {
            Some(true)
        } else {
            None
        }
    }

    /// Returns whether a switch that closed with the table at `closed_at` must still be closed at `table` (counts): further on its dog, in
    /// the half where it closed, or not yet back by its hysteresis.
    #[must_use]
    pub fn must_hold(&self, closed_at: f64, table: f64) -> bool {
        let middle = 0.5 * (self.start + self.end);
        let further = if closed_at < middle { table - closed_at } else { closed_at - table };
        further > -0.5 * self.hysteresis && further < 0.5 * (self.end - self.start)
    }

    /// The table moves; the edges on the way, in order. A stuck switch moves but shows none.
    pub fn pass(&mut self, from: f64, to: f64) -> [Option<InputEdge>; 2] {
        let (closes, opens, passed_closing, passed_opening) = if to > from {
            let opens = self.end + self.hysteresis;
            (self.start, opens, from <= self.end && to >= self.start, to > opens)
        } else {
            let opens = self.start - self.hysteresis;
            (self.end, opens, from >= self.start && to <= self.end, to < opens)
        };
        let mut edges = [None, None];
        if !self.closed && passed_closing {
            self.closed = true;
            edges[0] = Some(InputEdge { rising: true, position: closes });
        }
        if self.closed && passed_opening {
            self.closed = false;
            edges[1] = Some(InputEdge { rising: false, position: opens });
        }
        if self.bounces && edges.iter().any(Option::is_some) {
            self.chatter = CHATTER;
        }
        if self.stuck.is_some() { [None, None] } else { edges }
    }
}

/// The two hard limit switches of a slide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OvertravelSwitches {
    min: f64,
    max: f64,
}

impl OvertravelSwitches {
    /// Switches that close beyond these positions (counts); infinite where there is none.
    #[must_use]
    pub fn new(min: f64, max: f64) -> Self {
        Self { min, max }
    }

    /// The limit (counts) beyond which this position lies.
    #[must_use]
    pub fn beyond(&self, position: f64) -> Option<f64> {
        if position < self.min {
            Some(self.min)
        } else if position > self.max {
            Some(self.max)
        } else {
            None
        }
    }

    /// Which of the two are closed: (min, max).
    #[must_use]
    pub fn closed(&self, position: f64) -> (bool, bool) {
        (position < self.min, position > self.max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mark_is_caught_at_the_same_count_in_both_directions_and_at_every_speed() {
        let detector = OriginDetector::new(3600.0, TURN_RAD / 3600.0 * 5.0);
        for speed in [0.1, 1.0, 333.3, 3000.0] {
            for (mark, start) in [(-3600.0_f64, -3600.0 - 0.37 * speed), (7200.0, 7200.0 - 0.01 * speed)] {
                let edge = detector.edge(start, start + speed).expect("the mark lies between");
                assert_eq!(edge.position.to_bits(), mark.to_bits());
                assert_eq!(detector.edge(start + speed, start).map(|e| e.position), Some(edge.position));
            }
        }
        assert_eq!(detector.edge(1.0, 3599.0), None);
        assert_eq!(detector.edge(0.0, 5.0), None, "standing on the mark is not passing it");
        assert!(detector.edge(-5.0, 0.0).is_some());
        assert!(detector.is_closed(7204.9) && detector.is_closed(-4.9) && !detector.is_closed(5.5));
    }

    #[test]
    fn a_switch_opens_later_than_it_closed_in_both_directions() {
        let mut switch = StationSwitch::new(100.0, 20.0, 3.0, 0.0);
        let positions = |edges: [Option<InputEdge>; 2]| edges.map(|e| e.map(|e| (e.rising, e.position)));
        assert_eq!(positions(switch.pass(0.0, 99.0)), [None, None]);
        assert_eq!(positions(switch.pass(99.0, 100.5)), [Some((true, 100.0)), None]);
        assert_eq!(positions(switch.pass(100.5, 98.0)), [None, None]);
        assert_eq!(positions(switch.pass(98.0, 96.0)), [None, Some((false, 97.0))]);
        assert_eq!(positions(switch.pass(96.0, 200.0)), [Some((true, 100.0)), Some((false, 123.0))]);
        assert_eq!(positions(switch.pass(200.0, 119.0)), [Some((true, 120.0)), None]);
        assert_eq!(positions(switch.pass(119.0, 122.0)), [None, None]);
        assert_eq!(positions(switch.pass(122.0, 123.5)), [None, Some((false, 123.0))]);
    }

    #[test]
    fn a_second_mark_is_caught_like_the_first() {
        let mut detector = OriginDetector::new(3600.0, TURN_RAD / 3600.0 * 5.0);
        detector.set_second(Some(900.0));
        assert_eq!(detector.edge(890.0, 910.0), Some(InputEdge { rising: true, position: 900.0 }));
        assert_eq!(detector.edge(3590.0, 3610.0), Some(InputEdge { rising: true, position: 3600.0 }));
        assert!(detector.is_closed(902.0) && detector.is_closed(-2.0) && !detector.is_closed(450.0));
        assert!((detector.off_mark(900.0) - 900.0).abs() < 1e-9);
        detector.set_second(None);
        assert_eq!(detector.edge(890.0, 910.0), None);
    }

    #[test]
    fn a_bouncing_switch_toggles_and_ends_on_its_true_level() {
        let mut switch = StationSwitch::new(100.0, 20.0, 3.0, 0.0);
        switch.set_bouncing(true);
        assert!(switch.pass(99.0, 101.0)[0].is_some() && switch.is_closed());
        let levels: alloc::vec::Vec<bool> =
            core::iter::from_fn(|| switch.bounce(101.0).map(|edge| edge.rising)).collect();
        assert_eq!(levels, [false, true, false, true, false, true]);
        assert!(switch.is_closed());
    }

    #[test]
    fn what_a_switch_must_show_is_known_away_from_its_edges() {
        let switch = StationSwitch::new(100.0, 20.0, 3.0, 0.0);
        for (table, expected) in
            [(90.0, Some(false)), (98.0, None), (110.0, Some(true)), (125.0, None), (130.0, Some(false))]
        {
            assert_eq!(switch.expected(table, 5.0), expected, "{table}");
        }
    }

    #[test]
    fn a_switch_that_has_closed_must_hold_until_the_table_is_back_by_its_hysteresis_or_over_the_dog() {
        let switch = StationSwitch::new(1000.0, 800.0, 5.0, 0.0);
        for (closed_at, table, holds) in [
            (1000.0, 1000.0, true),
            (1000.0, 1010.5, true),
            (1000.0, 998.0, true),
            (1000.0, 995.0, false),
            (1000.0, 1805.0, false),
            (1800.0, 1799.0, true),
            (1800.0, 1805.0, false),
            (1800.0, 995.0, false),
        ] {
            assert_eq!(switch.must_hold(closed_at, table), holds, "closed at {closed_at}, table at {table}");
        }
    }

    #[test]
    fn a_stuck_switch_shows_its_level_and_no_edge() {
        let mut switch = StationSwitch::new(100.0, 20.0, 3.0, 0.0);
        switch.set_stuck(Some(false));
        assert_eq!(switch.pass(0.0, 110.0), [None, None]);
        assert!(!switch.is_closed());
        switch.set_stuck(None);
        assert!(switch.is_closed());
    }
}
