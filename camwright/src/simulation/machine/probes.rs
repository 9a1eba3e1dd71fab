// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Detectors that find the part: the gap detector of the wheel and the switch of the keyway.

use crate::machine::contact_law::ContactLaw;
use crate::machine::description::{KeyWayProbe, MachineDescription};
use crate::math::units::TURN_RAD;
use crate::simulation::axis::Span;
use crate::simulation::sensors::InputEdge;
use crate::simulation::workpiece::{Deflection, Removal};

/// The gap detector: closed while the wheel touches the part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GapWatch {
    holds_ticks: u32,
    closed: bool,
    silent_ticks: u32,
    /// Position of X when the wheel first touched in this tick (counts, true).
    touched: Option<f64>,
}

crate::snapshot!(GapWatch { closed, silent_ticks, touched } on { holds_ticks });

impl GapWatch {
    #[allow(clippy::cast_possible_truncation, reason = "clamped to u32 before the cast")]
    pub(super) fn new(description: &MachineDescription) -> Option<Self> {
        let detector = description.gap_detector?;
        let ticks = libm::ceil(detector.holds_s / description.cycle_time_s());
        let holds_ticks = ticks.clamp(0.0, f64::from(u32::MAX)) as u32;
        Some(Self { holds_ticks, closed: false, silent_ticks: 0, touched: None })
    }

    pub(super) const fn is_closed(&self) -> bool {
        self.closed
    }

    /// The wheel has moved along a span of X and stands in the part by `depth` (counts): it touched where X was when
    /// that began. Along a normal askew of X that is not where it stands back by its depth, but never before the step.
    pub(super) fn touch(&mut self, x: &Span, at: f64, depth: f64) {
        if depth > 0.0 && self.touched.is_none() {
            self.touched = Some((at + depth).min(x.from.max(x.to)));
        }
    }

    /// Edge at the end of a tick: its direction, and the position of X where the wheel touched (counts).
    pub(super) fn end_tick(&mut self, presses: bool) -> Option<(bool, Option<f64>)> {
        let touched = self.touched.take();
        self.silent_ticks = if touched.is_some() || presses { 0 } else { self.silent_ticks.saturating_add(1) };
        if !self.closed && touched.is_some() {
            self.closed = true;
            Some((true, touched))
        } else if self.closed && self.silent_ticks > self.holds_ticks {
            self.closed = false;
            Some((false, None))
        } else {
            None
        }
    }
}

/// Depth of an undeflected wheel in the part (mm): where nothing deflects, the depth of its cut; else by the law, from the
/// deflection.
pub(super) fn engagement_mm(law: Option<&ContactLaw>, removal: Removal, deflection: Deflection, cuts: bool) -> f64 {
    let Some(law) = law else { return removal.depth_mm };
    let cutting_n = law.force_n(deflection.mm) - law.threshold_n();
    let depth_mm = if cuts && cutting_n > 0.0 { cutting_n / law.grinding_n_mm() } else { 0.0 };
    deflection.mm + depth_mm
}

/// The keyway of the clamped part and its switch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Keyway {
    /// Positions of C between which the switch is closed, modulo a turn, and a turn (counts).
    begins: f64,
    ends: f64,
    turn: f64,
}

impl Keyway {
    pub(super) fn new(probe: &KeyWayProbe, key_way_rad: f64, rotation_sense: i8, counts_per_rad: f64) -> Self {
        let centre = probe.centre_rad(key_way_rad, rotation_sense) * counts_per_rad;
        let half = 0.5 * probe.width_rad * counts_per_rad;
        Self { begins: centre - half, ends: centre + half, turn: libm::round(TURN_RAD * counts_per_rad) }
    }

    /// The keyway stands under its switch with C at this true position (counts).
    pub(super) fn is_under_switch(&self, position: f64) -> bool {
        libm::floor((position - self.begins) / self.turn) > libm::floor((position - self.ends) / self.turn)
    }

    /// Edges of the switch along a servo step of C, in order.
    pub(super) fn edges(&self, c: &Span) -> [Option<InputEdge>; 2] {
        key_way_edges(self.begins, self.ends, self.turn, c.from, c.to)
    }
}

/// The edges between two positions less than a turn apart, in the order in which they are met.
fn key_way_edges(begins: f64, ends: f64, turn: f64, from: f64, to: f64) -> [Option<InputEdge>; 2] {
    let upwards = to > from;
    let passed = |mark: f64, rising: bool| {
        let (before, after) = (libm::floor((from - mark) / turn), libm::floor((to - mark) / turn));
        let which = if upwards { after } else { before };
        (before - after != 0.0).then_some(InputEdge { rising, position: which * turn + mark })
    };
    let edges = [passed(begins, upwards), passed(ends, !upwards)];
    match edges {
        [Some(one), Some(other)] if (one.position > other.position) == upwards => [Some(other), Some(one)],
        edges => edges,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edge_positions(edges: [Option<InputEdge>; 2]) -> alloc::vec::Vec<(bool, f64)> {
        edges.into_iter().flatten().map(|edge| (edge.rising, edge.position)).collect()
    }

    #[test]
    fn a_key_way_has_its_edges_in_both_directions_and_in_every_turn() {
        let edges = |from, to| edge_positions(key_way_edges(-20.0, 30.0, 3600.0, from, to));
        assert_eq!(edges(-30.0, -10.0), [(true, -20.0)]);
        assert_eq!(edges(-10.0, -30.0), [(false, -20.0)]);
        assert_eq!(edges(20.0, 40.0), [(false, 30.0)]);
        assert_eq!(edges(40.0, 20.0), [(true, 30.0)]);
        assert_eq!(edges(7170.0, 7240.0), [(true, 7180.0), (false, 7230.0)]);
        assert_eq!(edges(-3560.0, -3630.0), [(true, -3570.0), (false, -3620.0)]);
        assert_eq!(edges(100.0, 3500.0), []);
    }

    /// A position on an edge is within the keyway on one side only, so every edge is reported exactly once.
    #[test]
    fn an_edge_at_a_step_boundary_is_reported_once() {
        let edges = |from, to| edge_positions(key_way_edges(-20.0, 30.0, 3600.0, from, to));
        assert_eq!([edges(-30.0, -20.0), edges(-20.0, -10.0)].concat(), [(true, -20.0)]);
        assert_eq!([edges(-10.0, -20.0), edges(-20.0, -30.0)].concat(), [(false, -20.0)]);
    }
}
