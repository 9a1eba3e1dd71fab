// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A turn in a few figures: how long it removes how much, and what sets its speed where.

use super::turn::{LobeTurn, LobeTurnPoint};
use crate::chart::round_step;
use camwright::job::grinding::SpeedLaw;
use camwright::motion::speed_plan::Bound;
use serde::Serialize;

/// Most classes of a histogram.
const MAX_CLASSES: f64 = 10.0;

/// A peak this little above the edge of a class is the edge: a law keeps its rate to some 1e-4.
const EDGE: f64 = 1e-3;

/// Shorter arcs belong to their longer neighbour (points of a tenth of a degree): two knots of a plan, between which it goes
/// over from one bound to the next.
const SHORTEST_ARC: usize = 30;

/// A class of the specific removal rate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RemovalClass {
    pub from_mm2_s: f64,
    /// To here; the next class begins here.
    pub to_mm2_s: f64,
    /// Share of the time of a turn.
    pub share: f64,
}

/// A bound of the speed of C, and where it rules.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BoundSummary {
    /// `work_speed`, `footprint_speed`, `removal_rate`, `power`, `temperature`, `jerk of c_axis` and so on, or `none`.
    pub bound: String,
    /// Share of the time of a turn.
    pub share: f64,
    /// Angles of `c_axis` from and to which it rules, in their order; the last may go over 360 to an angle behind it.
    pub arcs_deg: Vec<[f64; 2]>,
}

/// A speed law as job files name it.
pub(super) const fn law_name(law: &SpeedLaw) -> &'static str {
    match law {
        SpeedLaw::ConstantWorkSpeed { .. } => "constant_work_speed",
        SpeedLaw::ConstantFootprintSpeed { .. } => "constant_footprint_speed",
        SpeedLaw::ConstantRemovalRate { .. } => "constant_removal_rate",
        SpeedLaw::ConstantRadialRemovalRate { .. } => "constant_radial_removal_rate",
        SpeedLaw::ConstantPower { .. } => "constant_power",
        SpeedLaw::ConstantTemperature { .. } => "constant_temperature",
        SpeedLaw::TimeOptimal { .. } => "time_optimal",
    }
}

/// A bound in the words of job files.
pub(super) fn bound_name(law: &SpeedLaw, bound: Option<Bound>) -> String {
    match bound {
        None => "none".into(),
        Some(Bound::Limit(axis, quantity)) => format!("{} of {}", quantity.name(), axis.joint()),
        Some(Bound::WorkSpeed) => "work_speed".into(),
        Some(Bound::WheelPower) => "wheel_power".into(),
        Some(Bound::Process) => law_name(law).trim_start_matches("constant_").into(),
    }
}

/// The turn's time at each class of the removal rate, classes of a round width from 0 on.
pub(super) fn removal_classes(turn: &LobeTurn<'_>) -> Vec<RemovalClass> {
    let peak = turn.peak_mm2_s() * (1.0 - EDGE);
    if peak <= 0.0 || peak.is_nan() {
        return Vec::new();
    }
    let width = round_step(peak, MAX_CLASSES);
    #[allow(clippy::cast_possible_truncation, reason = "at most ten classes")]
    let class = |rate: f64| (rate / width).floor() as usize;
    let count = class(peak) + 1;
    let edge = |index: usize| {
        let edge = index as f64 * width;
        // 3 · 0.1 is 0.30000000000000004.
        (edge * 1e9).round() / 1e9
    };
    let mut classes: Vec<RemovalClass> = (0..count)
        .map(|index| RemovalClass { from_mm2_s: edge(index), to_mm2_s: edge(index + 1), share: 0.0 })
        .collect();
    for point in &turn.points {
        classes[class(point.removal_mm2_s).min(count - 1)].share += point.share;
    }
    classes
}

/// An arc of a turn on which one bound sets the speed: points `from .. from + count`, over the end of the turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arc {
    pub(super) bound: Option<Bound>,
    pub(super) from: usize,
    pub(super) count: usize,
}

/// The arcs of a turn, in their order.
pub(super) fn arcs(points: &[LobeTurnPoint]) -> Vec<Arc> {
    let active: Vec<Option<Bound>> = points.iter().map(|point| point.active).collect();
    merged(&active)
}

fn merged(active: &[Option<Bound>]) -> Vec<Arc> {
    let mut arcs: Vec<Arc> = Vec::new();
    for (from, bound) in active.iter().enumerate() {
        match arcs.last_mut() {
            Some(last) if last.bound == *bound => last.count += 1,
            _ => arcs.push(Arc { bound: *bound, from, count: 1 }),
        }
    }
    join(&mut arcs, active.len());
    // The shortest first: what is left then are arcs that a person can see.
    while arcs.len() > 1 {
        let Some(shortest) = (0..arcs.len()).min_by_key(|index| arcs[*index].count) else { break };
        if arcs[shortest].count >= SHORTEST_ARC {
            break;
        }
        let before = arcs[(shortest + arcs.len() - 1) % arcs.len()];
        let after = arcs[(shortest + 1) % arcs.len()];
        arcs[shortest].bound = if before.count >= after.count { before.bound } else { after.bound };
        join(&mut arcs, active.len());
    }
    arcs
}

/// Joins neighbours with one bound, the last with the first too.
fn join(arcs: &mut Vec<Arc>, count: usize) {
    arcs.dedup_by(|after, before| {
        let is_same = after.bound == before.bound;
        if is_same {
            before.count += after.count;
        }
        is_same
    });
    if arcs.len() > 1 && arcs[0].bound == arcs[arcs.len() - 1].bound {
        let first = arcs.remove(0);
        if let Some(last) = arcs.last_mut() {
            last.count += first.count;
        }
    }
    if arcs.len() == 1 {
        (arcs[0].from, arcs[0].count) = (0, count);
    }
}

/// An angle to a tenth, the spacing of the points.
fn tenth(deg: f64) -> f64 {
    (deg * 10.0).round() / 10.0
}

/// Bounds of the speed of a turn, the longest first.
pub(super) fn bounds_used(turn: &LobeTurn<'_>) -> Vec<BoundSummary> {
    let points = &turn.points;
    let mut found: Vec<BoundSummary> = Vec::new();
    for arc in arcs(points) {
        let bound = bound_name(&turn.bounds.speed, arc.bound);
        let share: f64 = (arc.from..arc.from + arc.count).map(|index| points[index % points.len()].share).sum();
        let place = if arc.count == points.len() {
            [0.0, 360.0]
        } else {
            [points[arc.from].c_deg, points[(arc.from + arc.count) % points.len()].c_deg].map(tenth)
        };
        match found.iter_mut().find(|summary| summary.bound == bound) {
            Some(summary) => {
                summary.share += share;
                summary.arcs_deg.push(place);
            }
            None => found.push(BoundSummary { bound, share, arcs_deg: vec![place] }),
        }
    }
    found.sort_by(|a, b| b.share.total_cmp(&a.share));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PreparedJob, prepare, summary};
    use camwright::machine::description::Axis;
    use camwright::motion::speed_plan::LimitedQuantity;

    fn prepared(set: &[&str]) -> PreparedJob {
        prepare("four_lobe_camshaft", &set.iter().map(ToString::to_string).collect::<Vec<_>>(), None).unwrap()
    }

    /// A stretch too short to be seen goes to its longer neighbour, and a turn has no seam.
    #[test]
    fn arcs_are_few_and_go_over_the_seam() {
        let (jerk, law) = (Some(Bound::Limit(Axis::C, LimitedQuantity::Jerk)), Some(Bound::Process));
        let mut active = vec![law; 3600];
        active[100..400].fill(jerk);
        active[200..203].fill(None);
        active[900..910].fill(jerk);
        let arcs = merged(&active);
        assert_eq!(arcs, [Arc { bound: jerk, from: 100, count: 300 }, Arc { bound: law, from: 400, count: 3300 }]);
        assert_eq!(merged(&[None; 3600]), [Arc { bound: None, from: 0, count: 3600 }]);
    }

    #[test]
    fn at_a_constant_work_speed_it_alone_sets_the_speed() {
        let prepared = prepared(&[]);
        for pass in summary(&prepared).lobes.iter().map(|lobe| &lobe.passes[0]) {
            assert_eq!(pass.speed_law, "constant_work_speed");
            assert_eq!((pass.bounds.len(), &*pass.bounds[0].bound), (1, "work_speed"));
            assert_eq!(pass.bounds[0].arcs_deg, [[0.0, 360.0]]);
            assert!((pass.bounds[0].share - 1.0).abs() < 1e-9);
            assert!((pass.constant_speed_turn_s.unwrap() / pass.turn_s - 1.0).abs() < 1e-9);
        }
    }

    /// Shares of all classes and of all bounds are whole turns; a slow constant removal rate holds nearly all the time, and then
    /// the last class has nearly all of it.
    #[test]
    fn a_slow_constant_removal_rate_holds_nearly_all_the_time() {
        let set = ["speed.law=constant_removal_rate", "speed.removal_rate_mm2_s=1.0", "work_speed_rpm=300.0"];
        for pass in summary(&prepared(&set)).lobes.iter().map(|lobe| &lobe.passes[0]) {
            let shares: f64 = pass.removal_classes.iter().map(|class| class.share).sum();
            assert!((shares - 1.0).abs() < 1e-9, "{shares}");
            let shares: f64 = pass.bounds.iter().map(|bound| bound.share).sum();
            assert!((shares - 1.0).abs() < 1e-9, "{shares}");
            assert_eq!(pass.removal_classes.len(), 10, "{:?}", pass.removal_classes);
            assert!(pass.removal_classes[9].share > 0.85, "{:?}", pass.removal_classes);
            assert_eq!(pass.bounds[0].bound, "removal_rate");
            assert!(pass.bounds[0].share > 0.8, "{:?}", pass.bounds);
        }
    }

    /// The exact removal rate is the stated one under the exact law, and cos β/cos α times the stated one under the published law of radial
    /// stock: β between normal and X, α between normal and radius of the contour.
    #[test]
    fn the_radial_law_exceeds_its_rate_on_flanks() {
        const STATED_MM2_S: f64 = 1.0;
        for (law, least, most) in [("constant_removal_rate", 1.0, 1.0), ("constant_radial_removal_rate", 1.0, 1.05)] {
            let prepared =
                prepared(&[&format!("speed.law={law}"), "speed.removal_rate_mm2_s=1.0", "work_speed_rpm=300.0"]);
            let turn = LobeTurn::new(&prepared, 0, 0).unwrap();
            let lobe = &prepared.planned.lobes[0];
            let (contour, sense) = (&lobe.design.contour, f64::from(prepared.machine.rotation_sense));
            let held = turn.points.iter().filter(|point| point.active == Some(Bound::Process));
            let (mut low, mut high, mut count) = (f64::INFINITY, 0.0_f64, 0);
            for point in held {
                let theta = sense * point.c.value;
                let cam_angle = contour.cam_angle_at(lobe.tool_path.contact_azimuth(theta));
                let (at, normal_rad) = (contour.point(cam_angle), contour.normal_angle(cam_angle));
                let cos_alpha = (at.x * normal_rad.cos() + at.y * normal_rad.sin()) / at.norm();
                let wanted =
                    if law == "constant_removal_rate" { 1.0 } else { lobe.tool_path.beta(theta).cos() / cos_alpha };
                let rate = point.removal_mm2_s / STATED_MM2_S;
                // Within 5 % of its bound a law is said to set the speed.
                assert!(
                    rate <= wanted * 1.001 && rate >= wanted * 0.94,
                    "{law} at {} deg: {rate}, not {wanted}",
                    point.c_deg
                );
                (low, high, count) = (low.min(wanted), high.max(wanted), count + 1);
            }
            assert!(count > 2000, "{law}: {count} of 3600");
            let peak = turn.peak_mm2_s() / STATED_MM2_S;
            eprintln!("{law}: {low:.4} to {high:.4} of the stated rate, peak {peak:.4}, turn {:.4} s", turn.turn_s);
            assert!(peak >= least - 0.001 && high >= most - 1e-9, "{law}: {high}, peak {peak}");
        }
    }

    /// The same profile at another phase is ground the same, elsewhere on C.
    #[test]
    fn a_phase_turns_the_arcs_and_leaves_their_shares() {
        let set = ["speed.law=constant_removal_rate", "speed.removal_rate_mm2_s=10.0", "work_speed_rpm=300.0"];
        let lobes = summary(&prepared(&set)).lobes;
        let (one, other) = (&lobes[0].passes[0], &lobes[2].passes[0]);
        assert_eq!(one.removal_classes.len(), other.removal_classes.len());
        let turned = lobes[2].phase_deg - lobes[0].phase_deg;
        for (a, b) in one.bounds.iter().zip(&other.bounds) {
            assert_eq!(a.bound, b.bound);
            assert!((a.share - b.share).abs() < 0.01, "{a:?} {b:?}");
            for arc in &a.arcs_deg {
                let is_there = |other: &[f64; 2]| {
                    let apart = (other[0] - arc[0] - turned + 180.0).rem_euclid(360.0) - 180.0;
                    apart.abs() < 0.15
                };
                assert!(b.arcs_deg.iter().any(is_there), "{a:?} {b:?}");
            }
        }
    }
}
