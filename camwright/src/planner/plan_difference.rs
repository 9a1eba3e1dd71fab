// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Two plans of a job, compared: what moved, where most, and by how much.
//!
//! Steps are paired by what they are for: the second cut of a lobe with the second cut of that lobe. Motions are compared over the angle of C, so
//! that one that only became slower is not taken for another way.

use crate::machine::description::{Axis, MachineDescription};
use crate::math::hermite::HermiteSpline;
use crate::math::units::{TURN_RAD, wrap_turn};
use crate::motion::plan::{AxisTarget, CutSegment, Plan, Segment, SegmentKind, SpiralSegment};
use alloc::vec::Vec;

/// Places of a turn at which laws and paths are looked at.
const PER_TURN: u32 = 1440;
/// Most places of a law that are looked at: laws of many turns are looked at more coarsely.
const MAX_PLACES: u32 = 2_000_000;

/// Parts of a step that can change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlanChange {
    /// Target of an axis (mm or rad).
    Target(Axis),
    /// X over the angle of C (mm at rad): the path of a lobe, or X of a spiral.
    PathOfX,
    /// Z over the angle of C (mm at rad), of a spiral.
    PathOfZ,
    /// Infeed over the angle since the cut begins (mm at rad).
    Infeed,
    /// Way of X per depth over the angle of the path (at rad).
    Ratio,
    /// C where the cut begins (rad).
    Start,
    /// Turns of C (turns).
    Turns,
    /// Speed of C over the angle since the start (rad/s at rad).
    Speed,
    /// Material above the contour when the step begins (mm).
    Stock,
    /// Predicted length (s).
    Time,
    /// Something else that it says: a limit, an input, an order, a retract.
    Words,
}

/// A difference between two steps that belong together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionDifference {
    /// Index of the step in the old plan.
    pub old_step: usize,
    /// Index of the step in the new plan.
    pub new_step: usize,
    pub moved: PlanChange,
    /// Old value in the unit of the change; 0 for [`PlanChange::Words`].
    pub old: f64,
    pub new: f64,
    /// Angle of the largest change (rad), for values over an angle.
    pub at_rad: Option<f64>,
}

impl MotionDifference {
    /// Size of the change, in its unit.
    #[must_use]
    pub fn by(&self) -> f64 {
        self.new - self.old
    }
}

/// Difference of two plans.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlanDifference {
    /// Steps that only the old plan has.
    pub only_old: Vec<usize>,
    /// Steps that only the new plan has.
    pub only_new: Vec<usize>,
    /// Changes, in the order of the new plan's steps.
    pub moved: Vec<MotionDifference>,
}

impl PlanDifference {
    /// Both plans move the axes alike, as far as was looked.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.only_old.is_empty() && self.only_new.is_empty() && self.moved.is_empty()
    }
}

/// Compares the motions of two plans for one machine.
#[must_use]
pub fn compare(old: &Plan, new: &Plan, machine: &MachineDescription) -> PlanDifference {
    let mut found = PlanDifference::default();
    let mut is_paired: Vec<bool> = old.segments.iter().map(|_| false).collect();
    for (new_step, segment) in new.segments.iter().enumerate() {
        let is_like = |(step, other): &(usize, &Segment)| !is_paired[*step] && purpose(old, other, segment, new);
        let Some((old_step, before)) = old.segments.iter().enumerate().find(is_like) else {
            found.only_new.push(new_step);
            continue;
        };
        is_paired[old_step] = true;
        let mut pair = Pair { old, new, machine, old_step, new_step, moved: Vec::new() };
        pair.compare(before, segment);
        found.moved.append(&mut pair.moved);
    }
    found.only_old = (0..old.segments.len()).filter(|step| !is_paired[*step]).collect();
    found
}

/// Both steps are for the same: phase, lobe by its name, and kind.
fn purpose(old_plan: &Plan, old: &Segment, new: &Segment, new_plan: &Plan) -> bool {
    let kind = core::mem::discriminant::<SegmentKind>;
    let old_lobe = old.lobe.and_then(|lobe| old_plan.lobes.get(lobe));
    let new_lobe = new.lobe.and_then(|lobe| new_plan.lobes.get(lobe));
    old.phase == new.phase && kind(&old.kind) == kind(&new.kind) && old_lobe == new_lobe
}

/// Two steps that belong together.
struct Pair<'a> {
    old: &'a Plan,
    new: &'a Plan,
    machine: &'a MachineDescription,
    old_step: usize,
    new_step: usize,
    moved: Vec<MotionDifference>,
}

impl Pair<'_> {
    fn compare(&mut self, old: &Segment, new: &Segment) {
        match (&old.kind, &new.kind) {
            (SegmentKind::Move(before), SegmentKind::Move(after)) => self.targets(before, after),
            (SegmentKind::Cut(before), SegmentKind::Cut(after)) => self.cut(before, after),
            (SegmentKind::Spiral(before), SegmentKind::Spiral(after)) => self.spiral(before, after),
            (before, after) if before != after => self.words(),
            _ => {}
        }
        self.number(PlanChange::Stock, old.stock_mm, new.stock_mm);
        if old.ticks != new.ticks {
            self.number(PlanChange::Time, self.seconds(old.ticks), self.seconds(new.ticks));
        } else if self.moved.is_empty() && old.stop_ticks != new.stop_ticks {
            self.words();
        }
    }

    fn seconds(&self, ticks: u64) -> f64 {
        ticks as f64 * self.machine.cycle_time_s()
    }

    fn number(&mut self, moved: PlanChange, old: f64, new: f64) {
        if old.to_bits() != new.to_bits() {
            self.moved.push(self.difference(moved, old, new, None));
        }
    }

    fn words(&mut self) {
        self.moved.push(self.difference(PlanChange::Words, 0.0, 0.0, None));
    }

    fn difference(&self, moved: PlanChange, old: f64, new: f64, at_rad: Option<f64>) -> MotionDifference {
        MotionDifference { old_step: self.old_step, new_step: self.new_step, moved, old, new, at_rad }
    }

    fn in_units(&self, axis: Axis, counts: i64) -> f64 {
        counts as f64 / self.machine.axis(axis).scale.counts_per_unit()
    }

    fn targets(&mut self, old: &[AxisTarget], new: &[AxisTarget]) {
        for axis in Axis::ALL {
            let of = |targets: &[AxisTarget]| targets.iter().find(|target| target.axis == axis).copied();
            match (of(old), of(new)) {
                (Some(before), Some(after)) => {
                    let (from, to) = (before.target_counts, after.target_counts);
                    if from != to {
                        self.number(PlanChange::Target(axis), self.in_units(axis, from), self.in_units(axis, to));
                    }
                    if before.limits != after.limits {
                        self.words();
                    }
                }
                (None, None) => {}
                _ => self.words(),
            }
        }
    }

    /// An angle at which something begins, the shorter way round.
    fn start(&mut self, old: f64, new: f64) {
        let forwards = wrap_turn(new - old);
        let by = if forwards > 0.5 * TURN_RAD { forwards - TURN_RAD } else { forwards };
        self.number(PlanChange::Start, old, old + by);
    }

    /// Largest difference of two functions of an angle, at equal steps from `from` to `to`.
    fn over(&mut self, moved: PlanChange, (from, to): (f64, f64), old: impl Fn(f64) -> f64, new: impl Fn(f64) -> f64) {
        let places = places(to - from);
        let mut max: Option<MotionDifference> = None;
        for place in 0..=places {
            let at = from + (to - from) * f64::from(place) / f64::from(places);
            let (before, after) = (old(at), new(at));
            let by = |difference: &MotionDifference| difference.by().abs();
            if before.to_bits() != after.to_bits() && max.as_ref().is_none_or(|max| (after - before).abs() > by(max)) {
                max = Some(self.difference(moved, before, after, Some(at)));
            }
        }
        self.moved.extend(max);
    }

    fn cut(&mut self, old: &CutSegment, new: &CutSegment) {
        self.start(old.path_start_rad, new.path_start_rad);
        if old.start_counts != new.start_counts && old.path_start_rad.to_bits() == new.path_start_rad.to_bits() {
            self.start(self.in_units(Axis::C, old.start_counts), self.in_units(Axis::C, new.start_counts));
        }
        self.number(PlanChange::Turns, f64::from(old.turns), f64::from(new.turns));
        let (before, after) = (self.old, self.new);
        if let (Some(path), Some(other)) = (before.paths.get(old.path), after.paths.get(new.path)) {
            self.over(PlanChange::PathOfX, (0.0, TURN_RAD), |at| path.sample(at).value, |at| other.sample(at).value);
        }
        let old_ratio = old.ratio.and_then(|ratio| before.ratios.get(ratio));
        let new_ratio = new.ratio.and_then(|ratio| after.ratios.get(ratio));
        match (old_ratio, new_ratio) {
            (Some(ratio), Some(other)) => {
                self.over(PlanChange::Ratio, (0.0, TURN_RAD), |at| ratio.sample(at).value, |at| other.sample(at).value);
            }
            (None, None) => {}
            _ => self.words(),
        }
        if let (Some(law), Some(other)) = (before.angle_laws.get(old.infeed), after.angle_laws.get(new.infeed)) {
            let ends = (law.start().min(other.start()), law.end().max(other.end()));
            self.over(PlanChange::Infeed, ends, |at| law.sample(at).value, |at| other.sample(at).value);
        }
        // The cut itself: where C comes turning or turns on is in the predicted time.
        let max = f64::from(old.turns.min(new.turns)) * TURN_RAD;
        self.speed((old.speed, new.speed), (0.0, max));
        let rest =
            |cut: &CutSegment| (cut.retract_mm.to_bits(), cut.hold_mm.to_bits(), cut.until_steady_n, cut.infeed_turns);
        if rest(old) != rest(new) || old.lead.is_some() != new.lead.is_some() || old.variation != new.variation {
            self.words();
        }
    }

    fn spiral(&mut self, old: &SpiralSegment, new: &SpiralSegment) {
        let (before, after) = (self.old, self.new);
        let laws = |old: usize, new: usize| before.angle_laws.get(old).zip(after.angle_laws.get(new));
        if old.start_counts != new.start_counts {
            self.start(self.in_units(Axis::C, old.start_counts), self.in_units(Axis::C, new.start_counts));
        }
        let mut max = 0.0;
        for (moved, pair) in
            [(PlanChange::PathOfX, laws(old.path, new.path)), (PlanChange::PathOfZ, laws(old.advance, new.advance))]
        {
            let Some((law, other)) = pair else { continue };
            max = law.end().min(other.end());
            if moved == PlanChange::PathOfX {
                self.number(PlanChange::Turns, law.end() / TURN_RAD, other.end() / TURN_RAD);
            }
            self.over(moved, (0.0, max), |at| law.sample(at).value, |at| other.sample(at).value);
        }
        self.speed((old.speed, new.speed), (0.0, max));
    }

    /// The speed of C where it has come to an angle.
    fn speed(&mut self, (old, new): (usize, usize), ends: (f64, f64)) {
        let (before, after) = (self.old, self.new);
        if let (Some(law), Some(other)) = (before.time_laws.get(old), after.time_laws.get(new))
            && law != other
        {
            let speed = |law: &HermiteSpline, at: f64| law.sample(law.place_of(at)).first;
            self.over(PlanChange::Speed, ends, |at| speed(law, at), |at| speed(other, at));
        }
    }
}

/// Steps in which a range of angles is looked at.
#[allow(clippy::cast_possible_truncation, reason = "not negative, and no more than the most")]
fn places(range_rad: f64) -> u32 {
    let wanted = range_rad / TURN_RAD * f64::from(PER_TURN);
    libm::ceil(wanted.clamp(1.0, f64::from(MAX_PLACES))) as u32
}
