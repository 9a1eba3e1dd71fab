// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A whole plan, walked through once more before anything moves: positions join in counts, every segment keeps the limits
//! by differencing its positions, nothing leaves the soft limits, and turns close.
//!
//! Nothing of how the plan was made is used, only what it says.

mod spiral;

use crate::job::infeed::differs_by_turn;
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription};
use crate::machine::wheel_state::{mm_from_nm, nm_from_mm};
use crate::math::differences::largest_derivatives;
use crate::math::units::TURN_RAD;
use crate::motion::cut_motion::CutMotion;
use crate::motion::plan::{AxisTarget, CutSegment, Plan, PlanCommand, Segment, SegmentKind};
use crate::motion::point_to_point::{MoveLaw, PointToPointError};
use crate::motion::speed_plan::{LimitUse, LimitedQuantity, uses_by_differences, windows};
use alloc::string::String;
use alloc::vec::Vec;
use thiserror::Error;

/// Result of the check.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanReport {
    /// For each segment that moves, the limit it uses most.
    pub uses: Vec<(usize, LimitUse)>,
    /// Positions after the last segment (counts).
    pub end_counts: [i64; AXIS_COUNT],
}

impl PlanReport {
    /// The largest use of a limit over the whole plan, 1 for all of it.
    #[must_use]
    pub fn max_ratio(&self) -> f64 {
        self.uses.iter().map(|(_, found)| found.ratio()).fold(0.0, f64::max)
    }
}

/// A plan that must not be executed.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("segment {segment} ({label}): {fault}")]
pub struct PlanCheckError {
    /// Index of the segment.
    pub segment: usize,
    pub label: String,
    pub fault: PlanFault,
}

/// Faults of a segment.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PlanFault {
    /// A step of homing, which is no part of a job.
    #[error("the plan of a job contains a homing step")]
    Homing,
    /// It names a spline that the plan does not have.
    #[error("it names a spline that the plan does not have")]
    UnknownSpline,
    /// It names an input that the machine does not have.
    #[error("the machine has no input {input}")]
    UnknownInput { input: String },
    /// It begins elsewhere than the one before ended.
    #[error("{} begins at {begins} counts, the segment before ended at {ended}", axis.joint())]
    Jump {
        axis: Axis,
        /// Start (counts).
        begins: i64,
        /// End of the previous segment (counts).
        ended: i64,
    },
    /// A cut does not end where it should.
    #[error("{} ends {counts} counts off the place it should come back to", axis.joint())]
    NotClosed {
        axis: Axis,
        /// Difference (counts).
        counts: i64,
    },
    /// C turns on from the cut before, where something else moves it or nothing comes after.
    #[error("c_axis still turns on from the cut before")]
    TurnsOn,
    /// The way onto the path, or off it, dips below the path, or the wheel is off it in the cut.
    #[error("x_axis is {beside_mm} mm beside the path at {time_s} s of the cut")]
    BadLead {
        /// Distance from the path (mm).
        beside_mm: f64,
        time_s: f64,
    },
    /// A cut begins or ends with C neither at rest nor turning on, or turns back.
    #[error("c_axis turns at {speed_rad_s} rad/s at {time_s} s of the cut")]
    BadSpeed { speed_rad_s: f64, time_s: f64 },
    /// A limit is exceeded.
    #[error("{0}")]
    Limit(LimitUse),
    /// A soft limit is exceeded.
    #[error("{} goes to {position} mm; its soft limits are {low} to {high} mm", axis.joint())]
    SoftLimit {
        axis: Axis,
        /// Position (mm).
        position: f64,
        /// Smallest allowed (mm).
        low: f64,
        /// Largest allowed (mm).
        high: f64,
    },
    /// A search cannot meet what it searches for.
    #[error("the search goes from {from} to {to} mm and its switch is at {switch} mm")]
    OutOfReach {
        /// Start (mm).
        from: f64,
        /// Farthest position (mm).
        to: f64,
        /// The switch (mm).
        switch: f64,
    },
    /// The wheel is to be dressed where the dresser is not, or there is none.
    #[error("the wheel is dressed with x_axis at {x_mm} mm and z_axis at {z_mm} mm, where no dresser is")]
    NotAtDresser {
        /// Position of the cutting point (mm).
        x_mm: f64,
        /// Position of the table (mm).
        z_mm: f64,
    },
    /// A wheel cannot be mounted there.
    #[error("the wheel with index {wheel} cannot be mounted: {why}")]
    WheelChange { wheel: u32, why: &'static str },
    /// The wheel is to be dressed to a radius that it cannot have.
    #[error("the wheel is dressed to {radius_mm} mm; it must have at least {min_mm} mm and less than {before_mm} mm")]
    WheelRadius {
        /// Radius wanted (mm).
        radius_mm: f64,
        /// Smallest usable (mm).
        min_mm: f64,
        /// Radius before (mm).
        before_mm: f64,
    },
    /// A path is used that was made for the wheel as it was before a dress.
    #[error("it uses path {path} again, which was used before the wheel was dressed")]
    OldPath {
        /// Index of the path.
        path: usize,
    },
    /// The motion is too long to be checked.
    #[error(
        "it takes {:.0} h, and its check would need {points:.1e} points (at most {:.0e} are allowed): shorten the pass, or raise its feed or speed",
        duration_s / 3600.0, spiral::MAX_POINTS
    )]
    TooLong {
        /// Points of the check.
        points: f64,
        /// Time of the motion (s).
        duration_s: f64,
    },
    /// A move cannot be made.
    #[error(transparent)]
    Move(#[from] PointToPointError),
}

/// Points at which a straight move is differenced.
const MOVE_GRID: f64 = 4096.0;

/// Points per turn at which a cut is differenced where something happens in it, and everywhere. The first is eight times
/// the planner's least; steps below 5 µs would drown a jerk in rounding.
const FINE_GRID: f64 = 28_800.0;
const COARSE_GRID: f64 = 1_000.0;
const SHORTEST_STEP_S: f64 = 5e-6;

/// Walks through a plan.
///
/// # Errors
/// The first segment that must not be executed, and why.
pub fn check_plan(
    plan: &Plan,
    machine: &MachineDescription,
    start_counts: [i64; AXIS_COUNT],
) -> Result<PlanReport, PlanCheckError> {
    let mut walk = PlanCheck {
        plan,
        machine,
        at: start_counts,
        uses: Vec::new(),
        turns: false,
        wheel: machine.mounted_wheel(),
        wheel_runs: false,
        wheel_nm: nm_from_mm(machine.wheel.new_radius_mm) + 1,
        paths: alloc::vec![PathState::Unused; plan.paths.len()],
    };
    for (index, segment) in plan.segments.iter().enumerate() {
        let worst = walk.step(segment).map_err(|fault| PlanCheckError {
            segment: index,
            label: segment.label.clone(),
            fault,
        })?;
        walk.uses.extend(worst.map(|worst| (index, worst)));
    }
    if walk.turns {
        let label = plan.segments.last().map(|segment| segment.label.clone()).unwrap_or_default();
        return Err(PlanCheckError { segment: plan.segments.len() - 1, label, fault: PlanFault::TurnsOn });
    }
    Ok(PlanReport { uses: walk.uses, end_counts: walk.at })
}

struct PlanCheck<'a> {
    plan: &'a Plan,
    machine: &'a MachineDescription,
    at: [i64; AXIS_COUNT],
    uses: Vec<(usize, LimitUse)>,
    /// C turns on from the cut before: where it is depends on when it is asked.
    turns: bool,
    /// Position of the mounted wheel in the changer.
    wheel: usize,
    /// The wheel has been started.
    wheel_runs: bool,
    /// Radius that the wheel is smaller than (nm), or known to have.
    wheel_nm: i64,
    paths: Vec<PathState>,
}

/// A path belongs to one radius of the wheel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PathState {
    Unused,
    /// With the wheel at this position of the changer.
    Used(usize),
    Old,
}

impl PlanCheck<'_> {
    /// One segment; the limit it uses most, if it moves.
    fn step(&mut self, segment: &Segment) -> Result<Option<LimitUse>, PlanFault> {
        let moves_c = match &segment.kind {
            SegmentKind::Move(targets) => targets.iter().any(|target| target.axis == Axis::C),
            SegmentKind::Search { axis, .. } | SegmentKind::Command(PlanCommand::SetHome(axis)) => *axis == Axis::C,
            SegmentKind::Home(_) | SegmentKind::Spiral(_) => true,
            SegmentKind::Cut(_) | SegmentKind::Dwell | SegmentKind::Wait | SegmentKind::Command(_) => false,
        };
        if self.turns && moves_c {
            return Err(PlanFault::TurnsOn);
        }
        match &segment.kind {
            SegmentKind::Move(targets) => self.line(targets),
            SegmentKind::Search { axis, input, travel_counts, offset_counts, limits } => {
                let mut to = self.at;
                to[axis.index()] += travel_counts;
                let target = AxisTarget { axis: *axis, target_counts: to[axis.index()], limits: *limits };
                let from = self.at;
                let worst = self.line(&[target])?;
                self.at = from;
                self.found(*axis, input, *travel_counts, *offset_counts)?;
                Ok(worst)
            }
            SegmentKind::Home(_) => Err(PlanFault::Homing),
            SegmentKind::Cut(cut) => self.cut(cut).map(Some),
            SegmentKind::Spiral(spiral) => self.spiral(spiral).map(Some),
            SegmentKind::Command(PlanCommand::SetHome(axis)) => {
                self.at[axis.index()] = 0;
                Ok(None)
            }
            SegmentKind::Command(PlanCommand::ExpectWheel { radius_nm }) => {
                self.wheel_nm = *radius_nm;
                Ok(None)
            }
            SegmentKind::Command(PlanCommand::Dress { radius_nm }) => self.dress(*radius_nm).map(|()| None),
            SegmentKind::Command(PlanCommand::ChangeWheel { wheel }) => self.change_wheel(*wheel).map(|()| None),
            SegmentKind::Command(command @ (PlanCommand::WheelStart | PlanCommand::WheelStop)) => {
                self.wheel_runs = *command == PlanCommand::WheelStart;
                Ok(None)
            }
            SegmentKind::Command(
                PlanCommand::Push { .. } | PlanCommand::WatchForce { .. } | PlanCommand::WatchSize(_),
            )
            | SegmentKind::Dwell
            | SegmentKind::Wait => Ok(None),
        }
    }

    /// Position of an axis after a search. The origin's position is unknown until it is the zero.
    fn found(&mut self, axis: Axis, input: &str, travel_counts: i64, offset_counts: i64) -> Result<(), PlanFault> {
        if input == "origin" {
            return Ok(());
        }
        let unknown = || PlanFault::UnknownInput { input: String::from(input) };
        let station = self.machine.station(input).ok_or_else(unknown)?;
        let scale = self.machine.axis(axis).scale;
        let (from, switch) = (self.at[axis.index()], scale.counts(station.position_mm));
        if switch <= from || switch >= from + travel_counts {
            let (from, to) = (scale.position(from), scale.position(from + travel_counts));
            return Err(PlanFault::OutOfReach { from, to, switch: station.position_mm });
        }
        self.at[axis.index()] = switch + offset_counts;
        Ok(())
    }

    /// Another wheel, with the wheel at rest and X clear.
    fn change_wheel(&mut self, wheel: u32) -> Result<(), PlanFault> {
        let fault = |why| Err(PlanFault::WheelChange { wheel, why });
        let Some(changer) = &self.machine.wheel_changer else { return fault("the machine has no wheel changer") };
        let Some(mounted) = changer.wheels.get(wheel as usize) else { return fault("the changer has fewer wheels") };
        if self.wheel_runs {
            return fault("the wheel runs");
        }
        if self.machine.axis(Axis::X).scale.position(self.at[Axis::X.index()]) < changer.min_x_mm {
            return fault("x_axis is nearer to the part than wheel_changer.min_x_mm");
        }
        self.wheel = wheel as usize;
        self.wheel_nm = nm_from_mm(mounted.wheel.new_radius_mm) + 1;
        Ok(())
    }

    /// The wheel gets smaller, at the dresser, and every path used so far is not its path any more.
    fn dress(&mut self, radius_nm: i64) -> Result<(), PlanFault> {
        let position = |axis: Axis| self.machine.axis(axis).scale.position(self.at[axis.index()]);
        let (x_mm, z_mm) = (position(Axis::X), position(Axis::Z));
        let at_dresser = self.machine.dresser.is_some_and(|dresser| {
            let beside_mm = 0.5 * dresser.traverse_mm(self.machine.wheel_at(self.wheel).width_mm) + 1e-3;
            (x_mm - dresser.x_mm).abs() <= 1e-3 && (z_mm - dresser.z_mm).abs() <= beside_mm
        });
        if !at_dresser {
            return Err(PlanFault::NotAtDresser { x_mm, z_mm });
        }
        let min_mm = self.machine.wheel_at(self.wheel).min_radius_mm;
        let (radius_mm, before_mm) = (mm_from_nm(radius_nm), mm_from_nm(self.wheel_nm));
        if radius_mm < min_mm || radius_nm >= self.wheel_nm {
            return Err(PlanFault::WheelRadius { radius_mm, min_mm, before_mm });
        }
        self.wheel_nm = radius_nm;
        let used = PathState::Used(self.wheel);
        self.paths.iter_mut().filter(|path| **path == used).for_each(|path| *path = PathState::Old);
        Ok(())
    }

    fn soft_limit(&self, axis: Axis, position: f64) -> Result<(), PlanFault> {
        match self.machine.axis(axis).soft_limits {
            Some((low, high)) if !(low..=high).contains(&position) => {
                Err(PlanFault::SoftLimit { axis, position, low, high })
            }
            _ => Ok(()),
        }
    }

    /// A straight line from where the axes stand.
    fn line(&mut self, targets: &[AxisTarget]) -> Result<Option<LimitUse>, PlanFault> {
        let law = MoveLaw::new(self.at, targets, self.machine)?;
        let step = law.duration_s() / MOVE_GRID;
        let mut worst: Option<LimitUse> = None;
        for target in targets {
            let index = target.axis.index();
            let description = self.machine.axis(target.axis);
            self.soft_limit(target.axis, description.scale.position(target.target_counts))?;
            if step > 0.0 {
                let per_unit = description.scale.counts_per_unit();
                let at = |t: f64| law.along(index, law.law().sample(t.max(0.0)).value) / per_unit;
                let extremes = largest_derivatives(at, -3.0 * step, law.duration_s() + 3.0 * step, step);
                for (quantity, extreme) in LimitedQuantity::ALL.into_iter().zip(extremes) {
                    let allowed = quantity.limit(&description.limits).min(quantity.limit(&target.limits));
                    let (axis, angle_rad) = (target.axis, 0.0);
                    let found =
                        LimitUse { axis, quantity, value: extreme.value, allowed, angle_rad, time_s: extreme.at };
                    worst = larger(worst, found);
                }
            }
            self.at[index] = target.target_counts;
        }
        within(worst)
    }

    fn cut(&mut self, cut: &CutSegment) -> Result<LimitUse, PlanFault> {
        let motion = self.plan.motion_of(cut).ok_or(PlanFault::UnknownSpline)?;
        match &mut self.paths[cut.path] {
            PathState::Old => return Err(PlanFault::OldPath { path: cut.path }),
            path => *path = PathState::Used(self.wheel),
        }
        let (c, x) = (self.machine.axis(Axis::C), self.machine.axis(Axis::X));
        let turn_counts = c.scale.counts(TURN_RAD);
        if self.turns {
            // Wherever C is, it comes by the cut's phase.
            let c_at = &mut self.at[Axis::C.index()];
            *c_at += (cut.start_counts - *c_at).rem_euclid(turn_counts);
        }
        let (c_at, x_at) = (self.at[Axis::C.index()], self.at[Axis::X.index()]);
        if (c_at - cut.start_counts).rem_euclid(turn_counts) != 0 {
            let (begins, ended) = (cut.start_counts, c_at.rem_euclid(turn_counts));
            return Err(PlanFault::Jump { axis: Axis::C, begins, ended });
        }
        let (start_s, end_s) = (motion.start_s(), motion.end_s());
        let x_begins = x.scale.counts(motion.x_mm(start_s));
        if x_begins != x_at {
            return Err(PlanFault::Jump { axis: Axis::X, begins: x_begins, ended: x_at });
        }
        speed_is_sane(&motion, cut, self.turns)?;
        lead_is_sane(&motion, cut)?;
        self.turns = motion.end_speeds_rad_s().1 > 0.0;

        let wanted = i64::from(cut.turns) * turn_counts;
        let angle = if self.turns { f64::from(cut.turns) * TURN_RAD } else { motion.law.sample(end_s).value };
        let turned = c.scale.counts(angle);
        if turned != wanted {
            return Err(PlanFault::NotClosed { axis: Axis::C, counts: turned - wanted });
        }
        let begins = x.scale.counts(motion.over_angle(0.0).value);
        let infeed_at = |angle: f64| x.scale.counts(motion.offset_over_angle(angle).value);
        let infeed_counts = infeed_at(0.0) - infeed_at(angle);
        let ends = x.scale.counts(motion.over_angle(angle).value);
        // Where the way of X is rounded apart from the path, a count may lie between.
        let apart = i64::from(cut.ratio.is_some());
        if (ends - (begins - infeed_counts)).abs() > apart {
            return Err(PlanFault::NotClosed { axis: Axis::X, counts: ends - (begins - infeed_counts) });
        }

        let infeed_knots = motion.infeed.knots();
        let varies = differs_by_turn(motion.infeed, cut.infeed_turns);
        let blend = (if varies { 0.0 } else { infeed_knots[infeed_knots.len() - 2].at }, motion.infeed.end());
        let fine = (cut.turn_s / FINE_GRID).max(SHORTEST_STEP_S);
        let mut worst: Option<LimitUse> = None;
        for (stretches, step) in [
            (windows(&motion, cut.plateau_s, cut.turn_s, blend), fine),
            (alloc::vec![(start_s, end_s)], cut.turn_s / COARSE_GRID),
        ] {
            for mut found in uses_by_differences(&motion, &stretches, step, &c.limits, &x.limits) {
                found.angle_rad *= f64::from(self.machine.rotation_sense.signum());
                worst = larger(worst, found);
            }
        }
        for k in 0..=3600_u32 {
            let at_angle = f64::from(k) * TURN_RAD / 3600.0;
            self.soft_limit(Axis::X, motion.over_angle(at_angle).value)?;
            self.soft_limit(Axis::X, motion.over_angle(angle - at_angle).value)?;
        }
        for time_s in [start_s, end_s] {
            self.soft_limit(Axis::X, motion.x_mm(time_s))?;
        }
        self.at[Axis::C.index()] += wanted;
        self.at[Axis::X.index()] = x.scale.counts(motion.x_mm(end_s));
        within(worst)?.ok_or(PlanFault::UnknownSpline)
    }
}

/// The wheel is on the path and the infeed from the first turn to the last, and above them before and after.
fn lead_is_sane(motion: &CutMotion<'_>, cut: &CutSegment) -> Result<(), PlanFault> {
    const ROUNDING_MM: f64 = 1e-6;
    if motion.lead.is_none() {
        return Ok(());
    }
    let total_rad = f64::from(cut.turns) * TURN_RAD;
    let on_part = (motion.time_of(0.0), motion.time_of(total_rad));
    let at = |from: f64, to: f64, k: u32| from + (to - from) * f64::from(k) / 1024.0;
    for k in 0..=1024 {
        for (from, to) in [(motion.start_s(), on_part.0), on_part, (on_part.1, motion.end_s())] {
            let time_s = at(from, to, k);
            let beside_mm = motion.beside_path(time_s).value;
            let is_on_part = time_s >= on_part.0 && time_s <= on_part.1;
            if beside_mm < -ROUNDING_MM || (is_on_part && beside_mm > ROUNDING_MM) {
                return Err(PlanFault::BadLead { beside_mm, time_s });
            }
        }
    }
    Ok(())
}

/// C begins and ends without acceleration, at rest or as it turns on, never turns back, and repeats from turn to turn on its plateau.
fn speed_is_sane(motion: &CutMotion<'_>, cut: &CutSegment, turns: bool) -> Result<(), PlanFault> {
    const ROUNDING: f64 = 1e-9;
    let (start_s, end_s) = (motion.start_s(), motion.end_s());
    let knots = motion.law.knots();
    let (first, last) = (knots[0], knots[knots.len() - 1]);
    if turns != (first.first > ROUNDING) || (!turns && (first.at != 0.0 || first.value != 0.0)) {
        return Err(PlanFault::BadSpeed { speed_rad_s: first.first, time_s: first.at });
    }
    for knot in [first, last] {
        if knot.first < -ROUNDING || knot.second.abs() > ROUNDING {
            return Err(PlanFault::BadSpeed { speed_rad_s: knot.first, time_s: knot.at });
        }
    }
    for k in 0..=4096_u32 {
        let time_s = start_s + (end_s - start_s) * f64::from(k) / 4096.0;
        let here = motion.law.sample(time_s);
        if here.first < -ROUNDING {
            return Err(PlanFault::BadSpeed { speed_rad_s: here.first, time_s });
        }
        let later = time_s + cut.turn_s;
        if time_s >= cut.plateau_s.0 && later <= cut.plateau_s.1 {
            let after = motion.law.sample(later);
            let turned = after.value - here.value - TURN_RAD;
            if turned.abs() > ROUNDING || (after.first - here.first).abs() > ROUNDING * (1.0 + here.first.abs()) {
                return Err(PlanFault::BadSpeed { speed_rad_s: after.first, time_s: later });
            }
        }
    }
    Ok(())
}

fn larger(worst: Option<LimitUse>, found: LimitUse) -> Option<LimitUse> {
    match worst {
        Some(worst) if worst.ratio() >= found.ratio() => Some(worst),
        _ => Some(found),
    }
}

fn within(worst: Option<LimitUse>) -> Result<Option<LimitUse>, PlanFault> {
    match worst {
        // Differences of a law that sits on its limit may round a digit above it.
        Some(worst) if worst.ratio() > 1.0 + 1e-6 => Err(PlanFault::Limit(worst)),
        other => Ok(other),
    }
}
