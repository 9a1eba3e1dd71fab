//! What the machine finds its part with, as it runs: where the wheel touches, and where the key-way passes its switch.

use super::Machine;
use crate::machine::contact_law::ContactLaw;
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use crate::machine::setpoint::{Input, Latch};
use crate::math::fixed_list::FixedList;
use crate::math::units::TURN_RAD;
use crate::simulation::axis::Span;
use crate::simulation::sensors::Edge;
use crate::simulation::tick_report::MAX_LATCHES;
use crate::simulation::workpiece::{Deflection, Removal};

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GapWatch {
    holds_ticks: u32,
    closed: bool,
    silent_ticks: u32,
    /// Where X stood when the wheel first touched in this tick (counts, true).
    touched: Option<f64>,
}

crate::kept!(GapWatch { closed, silent_ticks, touched } on { holds_ticks });

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

    /// The wheel has gone from one place of X to another and stands in the part by so much (counts): it touched where X was when
    /// that began. Along a normal askew of X that is not where it stands back by its depth, but never before the step.
    pub(super) fn touch(&mut self, x: &Span, at: f64, depth: f64) {
        if depth > 0.0 && self.touched.is_none() {
            self.touched = Some((at + depth).min(x.from.max(x.to)));
        }
    }
}

/// How deep an undeflected wheel would stand in the part (mm): where nothing gives way, as deep as it cuts; else by the law, from how
/// far both have given way.
pub(super) fn engagement_mm(law: Option<&ContactLaw>, removal: Removal, deflection: Deflection, cuts: bool) -> f64 {
    let Some(law) = law else { return removal.depth_mm };
    let cutting_n = law.force_n(deflection.mm) - law.threshold_n();
    let depth_mm = if cuts && cutting_n > 0.0 { cutting_n / law.grinding_n_mm() } else { 0.0 };
    deflection.mm + depth_mm
}

impl Machine {
    /// The gap detector at the end of a tick.
    pub(super) fn sense_gap(&mut self, latches: &mut FixedList<Latch, MAX_LATCHES>) {
        let presses = self.force_n > 0.0;
        let Some(gap) = &mut self.gap else { return };
        let touched = gap.touched.take();
        gap.silent_ticks = if touched.is_some() || presses { 0 } else { gap.silent_ticks.saturating_add(1) };
        if !gap.closed && touched.is_some() {
            gap.closed = true;
            self.catch_one(Input::WheelContact, true, touched, latches);
        } else if gap.closed && gap.silent_ticks > gap.holds_ticks {
            gap.closed = false;
            self.catch_one(Input::WheelContact, false, None, latches);
        }
    }

    /// Where the key-way under its switch begins and ends (counts of C, modulo a turn), and a turn; `None` without a switch or a part.
    fn key_way(&self) -> Option<([f64; 2], f64)> {
        let probe = self.description.key_way_probe.filter(|_| self.has_part())?;
        let per_rad = self.axes[Axis::C.index()].counts_per_unit;
        let centre = probe.centre_rad(self.key_way_rad, self.description.rotation_sense) * per_rad;
        let half = 0.5 * probe.width_rad * per_rad;
        Some(([centre - half, centre + half], libm::round(TURN_RAD * per_rad)))
    }

    /// The key-way stands under its switch.
    pub(super) fn sees_key_way(&self) -> bool {
        self.key_way().is_some_and(|([begins, ends], turn)| {
            let position = self.axes[Axis::C.index()].true_position();
            libm::floor((position - begins) / turn) > libm::floor((position - ends) / turn)
        })
    }

    /// The switch of the key-way along a servo step.
    pub(super) fn sense_key_way(&mut self, spans: &[Span; AXIS_COUNT], latches: &mut FixedList<Latch, MAX_LATCHES>) {
        let c = &spans[Axis::C.index()];
        if c.is_still() {
            return;
        }
        let Some(([begins, ends], turn)) = self.key_way() else { return };
        for edge in key_way_edges(begins, ends, turn, c.from, c.to).into_iter().flatten() {
            self.catch_one(Input::KeyWay, edge.rising, Some(edge.position), latches);
        }
    }
}

/// The edges between two positions less than a turn apart, in the order in which they are met.
fn key_way_edges(begins: f64, ends: f64, turn: f64, from: f64, to: f64) -> [Option<Edge>; 2] {
    let upwards = to > from;
    let passed = |mark: f64, rising: bool| {
        let (before, after) = (libm::floor((from - mark) / turn), libm::floor((to - mark) / turn));
        let which = if upwards { after } else { before };
        (before - after != 0.0).then_some(Edge { rising, position: which * turn + mark })
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

    fn told(edges: [Option<Edge>; 2]) -> alloc::vec::Vec<(bool, f64)> {
        edges.into_iter().flatten().map(|edge| (edge.rising, edge.position)).collect()
    }

    #[test]
    fn a_key_way_has_its_edges_in_both_directions_and_in_every_turn() {
        let edges = |from, to| told(key_way_edges(-20.0, 30.0, 3600.0, from, to));
        assert_eq!(edges(-30.0, -10.0), [(true, -20.0)]);
        assert_eq!(edges(-10.0, -30.0), [(false, -20.0)]);
        assert_eq!(edges(20.0, 40.0), [(false, 30.0)]);
        assert_eq!(edges(40.0, 20.0), [(true, 30.0)]);
        assert_eq!(edges(7170.0, 7240.0), [(true, 7180.0), (false, 7230.0)]);
        assert_eq!(edges(-3560.0, -3630.0), [(true, -3570.0), (false, -3620.0)]);
        assert_eq!(edges(100.0, 3500.0), []);
    }

    /// Standing on an edge is within the key-way on one side only, so that no edge is told twice or never.
    #[test]
    fn an_edge_that_a_step_ends_on_is_told_once() {
        let edges = |from, to| told(key_way_edges(-20.0, 30.0, 3600.0, from, to));
        assert_eq!([edges(-30.0, -20.0), edges(-20.0, -10.0)].concat(), [(true, -20.0)]);
        assert_eq!([edges(-10.0, -20.0), edges(-20.0, -30.0)].concat(), [(false, -20.0)]);
    }
}
