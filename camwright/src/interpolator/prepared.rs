// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A motion made ready outside the cyclic path: checked, inputs resolved, limits of retracts computed.

use super::cut::Curves;
use super::free_rotation::SpinFacts;
use super::manual::{Jog, wheel_plan};
use super::prepare_error::PrepareError;
use super::setup::{self, Probe};
use super::trajectory::Trajectory;
use crate::machine::description::{AXIS_COUNT, Axis, MachineDescription, MotionLimits};
use crate::machine::setpoint::Input;
use crate::math::hermite::Knot;
use crate::math::units::TURN_RAD;
use crate::motion::path_stop::path_stop_s;
use crate::motion::plan::{
    AxisTarget, CutSegment, GaugeSize, HomeStep, Plan, PlanCommand, Segment, SegmentKind, SpiralSegment,
};
use crate::motion::point_to_point::{MOVE_SHARE, MoveLaw, whole_ticks};
use crate::motion::spiral_motion::SpiralMotion;
use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec::Vec;

/// Something for the axes to do.
#[derive(Debug, Clone)]
pub enum Motion {
    Plan(Arc<Plan>),
    /// A trajectory of a ROS client.
    Trajectory(Box<Trajectory>),
    /// Find the zero of these axes; those that know theirs are passed over.
    Home(Vec<Axis>),
    /// To these places, all together.
    Move(Vec<AxisTarget>),
    /// With one axis until an input closes or opens.
    Probe(Probe),
    /// With one axis by hand.
    Jog(Jog),
    /// The wheel to its speed (true), or to rest.
    Wheel(bool),
}

impl From<Trajectory> for Motion {
    fn from(trajectory: Trajectory) -> Self {
        Motion::Trajectory(Box::new(trajectory))
    }
}

/// Data of a segment for the interpolator in addition to the plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SegmentData {
    /// Input of a search.
    pub(crate) input: Option<Input>,
    /// Limits of X that the path of a cut leaves to a retract.
    pub(crate) retract_limits: MotionLimits,
    /// C between this cut and the next, where it turns on.
    pub(crate) spin: Option<SpinFacts>,
    /// Size on the gauge that ends the infeed of a cut.
    pub(crate) size: Option<GaugeSize>,
    /// Predicted ticks of all segments before this one.
    pub(crate) ticks_before: u64,
}

/// A motion ready for [`super::Interpolator::start`].
#[derive(Debug, Clone)]
pub struct Prepared {
    pub(crate) plan: Arc<Plan>,
    pub(crate) trajectory: Option<Trajectory>,
    pub(crate) facts: Vec<SegmentData>,
    /// Predicted ticks of everything.
    pub(crate) ticks: u64,
    /// Tick before which a trajectory does not begin.
    pub(crate) starts_at: u64,
    /// Stop of a trajectory on its path (ticks).
    pub(crate) stop_ticks: u64,
    /// Axes of set-up work, which does not begin without their zeros.
    pub(crate) setup_axes: Vec<Axis>,
    /// A jog of an axis whose zero is not known.
    pub(crate) is_lost: bool,
    /// Safe position of the wheel: the farthest position in any move of the plan (counts).
    pub(crate) safe_x_counts: Option<i64>,
}

impl Prepared {
    /// A job begins with it.
    #[must_use]
    pub fn begins_job(&self) -> bool {
        self.plan.half.begins()
    }

    /// Makes a motion ready. Allocates; not for the cyclic path.
    ///
    /// # Errors
    /// A motion that this machine cannot execute.
    pub fn new(motion: Motion, machine: &MachineDescription) -> Result<Self, PrepareError> {
        match motion {
            Motion::Plan(plan) => Self::from_plan(plan, machine),
            Motion::Trajectory(trajectory) => Ok(Self::from_trajectory(*trajectory, machine)),
            Motion::Home(axes) => Self::from_plan(Arc::new(super::homing::homing_plan(&axes, machine)?), machine),
            Motion::Move(targets) => {
                let axes = targets.iter().map(|target| target.axis).collect();
                Self::from_setup(axes, setup::move_plan(targets), machine)
            }
            Motion::Probe(probe) => Self::from_setup(alloc::vec![probe.axis()], probe.plan(machine), machine),
            Motion::Jog(Jog { target, knows_zero }) => {
                let axes = if knows_zero { alloc::vec![target.axis] } else { Vec::new() };
                let prepared = Self::from_setup(axes, setup::move_plan(alloc::vec![target]), machine)?;
                Ok(Self { is_lost: !knows_zero, ..prepared })
            }
            Motion::Wheel(turns) => Self::from_setup(Vec::new(), wheel_plan(turns, machine), machine),
        }
    }

    /// Cancelled set-up work keeps its position: no safer position is known.
    fn from_setup(axes: Vec<Axis>, plan: Plan, machine: &MachineDescription) -> Result<Self, PrepareError> {
        let prepared = Self::from_plan(Arc::new(plan), machine)?;
        Ok(Self { setup_axes: axes, safe_x_counts: None, ..prepared })
    }

    /// A trajectory of a client: whether it was followed its own tolerances say.
    #[must_use]
    pub fn is_trajectory(&self) -> bool {
        self.trajectory.is_some()
    }

    /// A trajectory that begins no earlier than a tick; the axes rest until then.
    #[must_use]
    pub fn starting_at(self, tick: u64) -> Self {
        Self { starts_at: tick, ..self }
    }

    /// Predicted length without holds and at full override (ticks).
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.ticks
    }

    fn from_trajectory(trajectory: Trajectory, machine: &MachineDescription) -> Self {
        let cycle_s = machine.cycle_time_s();
        let stop_s = Axis::ALL.into_iter().map(|axis| {
            let (peaks, own) = (trajectory.peaks(axis), machine.axis(axis).limits);
            // A trajectory may use its limits to the full; then a stop on the path can only exceed them. It gets 5 %
            // above whichever is larger, which lengthens it to some tenths of a second.
            let limits = MotionLimits {
                velocity: own.velocity.max(1.01 * peaks.velocity),
                acceleration: own.acceleration.max(1.05 * peaks.acceleration),
                jerk: own.jerk.max(1.05 * peaks.jerk),
            };
            path_stop_s(peaks, &limits).unwrap_or(1.0)
        });
        let stop_ticks = whole_ticks(stop_s.fold(0.0, f64::max), cycle_s).max(1);
        let ticks = whole_ticks(trajectory.duration_s(), cycle_s);
        Self {
            plan: Arc::default(),
            trajectory: Some(trajectory),
            facts: Vec::new(),
            ticks,
            starts_at: 0,
            stop_ticks,
            setup_axes: Vec::new(),
            is_lost: false,
            safe_x_counts: None,
        }
    }

    fn from_plan(plan: Arc<Plan>, machine: &MachineDescription) -> Result<Self, PrepareError> {
        let mut walk = PlanWalk::new(&plan, machine);
        for (index, segment) in plan.segments.iter().enumerate() {
            walk.segment(index, segment)?;
        }
        let PlanWalk { facts, ticks, safe_x_counts, .. } = walk;
        let (trajectory, setup_axes) = (None, Vec::new());
        Ok(Self {
            plan,
            trajectory,
            facts,
            ticks,
            starts_at: 0,
            stop_ticks: 0,
            setup_axes,
            is_lost: false,
            safe_x_counts,
        })
    }
}

/// Check of a plan, segment by segment, with what earlier segments leave to later ones.
struct PlanWalk<'a> {
    plan: &'a Plan,
    machine: &'a MachineDescription,
    facts: Vec<SegmentData>,
    /// Predicted ticks of the segments so far.
    ticks: u64,
    /// Axes with an edge that can become their zero.
    searched: [bool; AXIS_COUNT],
    /// Farthest position of X of all moves (counts).
    safe_x_counts: Option<i64>,
    /// C turns on from the cut before.
    turns_on: bool,
    /// Variation that the force monitor watches for (N); 0: none.
    watched_n: i64,
}

impl<'a> PlanWalk<'a> {
    fn new(plan: &'a Plan, machine: &'a MachineDescription) -> Self {
        Self {
            plan,
            machine,
            facts: Vec::with_capacity(plan.segments.len()),
            ticks: 0,
            searched: [false; AXIS_COUNT],
            safe_x_counts: None,
            turns_on: false,
            watched_n: 0,
        }
    }

    fn segment(&mut self, index: usize, segment: &Segment) -> Result<(), PrepareError> {
        let machine = self.machine;
        let mut facts = SegmentData {
            input: None,
            retract_limits: machine.axis(Axis::X).limits,
            spin: None,
            size: None,
            ticks_before: self.ticks,
        };
        match &segment.kind {
            SegmentKind::Move(targets) => self.check_move(index, targets)?,
            SegmentKind::Search { axis, input, limits, travel_counts, .. } => {
                self.check_targets(
                    index,
                    &[AxisTarget { axis: *axis, target_counts: *travel_counts, limits: *limits }],
                )?;
                let known = input_named(input, machine);
                facts.input =
                    Some(known.ok_or_else(|| PrepareError::UnknownInput { segment: index, input: input.clone() })?);
                self.searched[axis.index()] = true;
            }
            SegmentKind::Cut(cut) => self.check_cut(index, cut, segment, &mut facts)?,
            SegmentKind::Spiral(spiral) => {
                let curves =
                    self.plan.motion_of_spiral(spiral).ok_or(PrepareError::MissingSpline { segment: index })?;
                check_spiral(index, spiral, segment, &curves, machine)?;
            }
            SegmentKind::Command(PlanCommand::SetHome(axis)) if !self.searched[axis.index()] => {
                return Err(PrepareError::NothingCaught { segment: index, axis: *axis });
            }
            SegmentKind::Command(PlanCommand::WatchForce { max_n }) => self.watched_n = *max_n,
            SegmentKind::Home(step) => facts.input = self.check_home(index, step)?,
            SegmentKind::Dwell | SegmentKind::Wait | SegmentKind::Command(_) => {}
        }
        self.ticks += segment.ticks;
        self.facts.push(facts);
        Ok(())
    }

    fn check_targets(&self, segment: usize, targets: &[AxisTarget]) -> Result<(), PrepareError> {
        let law = MoveLaw::new([0; AXIS_COUNT], targets, self.machine);
        law.map(|_| ()).map_err(|error| PrepareError::Move { segment, error })
    }

    fn check_move(&mut self, index: usize, targets: &[AxisTarget]) -> Result<(), PrepareError> {
        self.check_targets(index, targets)?;
        let of_x = targets.iter().filter(|target| target.axis == Axis::X).map(|target| target.target_counts);
        self.safe_x_counts = self.safe_x_counts.max(of_x.max());
        Ok(())
    }

    fn check_cut(
        &mut self,
        index: usize,
        cut: &CutSegment,
        segment: &Segment,
        facts: &mut SegmentData,
    ) -> Result<(), PrepareError> {
        let curves = Curves::from_segment(self.plan, cut).ok_or(PrepareError::MissingSpline { segment: index })?;
        check_plateau(index, cut, segment, &curves)?;
        if cut.until_steady_n.is_some_and(|max_n| i64::from(max_n) != self.watched_n) {
            let what = "a cut ends at a steady force, but the force monitor has no threshold";
            return Err(PrepareError::BadCut { segment: index, what });
        }
        check_ends(index, &curves, self.turns_on, self.machine)?;
        facts.size = self.plan.size_of(index).filter(|size| size.diameter_nm > 0);
        check_size(index, &curves, facts.size, self.machine)?;
        facts.retract_limits = spare_limits(index, &curves, self.machine)?;
        facts.spin = spin_after(index, &curves, self.plan, self.machine)?;
        self.turns_on = facts.spin.is_some();
        Ok(())
    }

    /// Returns the input that a step of homing looks for.
    fn check_home(&mut self, index: usize, step: &HomeStep) -> Result<Option<Input>, PrepareError> {
        match step {
            HomeStep::Forget(_) => Ok(None),
            HomeStep::Here { axis, .. } => {
                self.searched[axis.index()] = true;
                Ok(None)
            }
            HomeStep::Seek { axis, input, travel_counts, limits, .. }
            | HomeStep::Probe { axis, input, travel_counts, limits, .. } => {
                self.check_targets(
                    index,
                    &[AxisTarget { axis: *axis, target_counts: *travel_counts, limits: *limits }],
                )?;
                self.searched[axis.index()] = true;
                Ok(Some(*input))
            }
        }
    }
}

fn input_named(name: &str, machine: &MachineDescription) -> Option<Input> {
    if name == "origin" {
        return Some(Input::Origin);
    }
    machine.stations.iter().position(|station| station.switch == name).map(Input::Station)
}

fn check_plateau(index: usize, cut: &CutSegment, segment: &Segment, curves: &Curves<'_>) -> Result<(), PrepareError> {
    let duration_s = curves.motion().end_s();
    let (begin, end) = cut.plateau_s;
    if !(begin >= 0.0
        && begin <= end
        && end <= duration_s * (1.0 + 1e-12)
        && cut.turn_s > 0.0
        && cut.turn_s.is_finite())
    {
        let (plateau_s, turn_s) = (cut.plateau_s, cut.turn_s);
        return Err(PrepareError::Plateau { segment: index, plateau_s, turn_s, duration_s });
    }
    if segment.stop_ticks == 0 {
        return Err(PrepareError::NoStop { segment: index });
    }
    Ok(())
}

/// An infeed that ends at a size needs a gauge, and turns that repeat, without which no turn can be left out.
fn check_size(
    index: usize,
    curves: &Curves<'_>,
    size: Option<GaugeSize>,
    machine: &MachineDescription,
) -> Result<(), PrepareError> {
    let wrong = |what| Err(PrepareError::BadCut { segment: index, what });
    if size.is_none() {
        return Ok(());
    }
    if machine.gauge.is_none() {
        return wrong("the infeed of a cut ends at a size, but the machine has no gauge");
    }
    if curves.motion().end_speeds_rad_s().1 > 0.0 {
        return wrong("the infeed of a cut ends at a size, but c_axis turns on at its end");
    }
    if curves.cut.infeed_turns >= curves.cut.turns {
        return wrong("the infeed of a cut ends at a size, and no turn without infeed follows");
    }
    Ok(())
}

/// Longest cut (s), and a speed that no headstock has (rad/s): beyond them a plan is damaged, and counts no longer fit into their
/// numbers.
const LONGEST_CUT_S: f64 = 86_400.0;
const FASTEST_RAD_S: f64 = 1e4;
const FARTHEST_MM: f64 = 1e6;

/// A cut begins as C comes: turning before time 0, or at rest at time 0.
fn check_ends(
    index: usize,
    curves: &Curves<'_>,
    turns: bool,
    machine: &MachineDescription,
) -> Result<(), PrepareError> {
    let wrong = |what| Err(PrepareError::BadCut { segment: index, what });
    let (motion, knots) = (curves.motion(), curves.motion().law.knots());
    let (comes_rad_s, goes_rad_s) = motion.end_speeds_rad_s();
    let longest_turn_rad_s = TURN_RAD / LONGEST_CUT_S;
    let turns_so = |speed: f64| speed == 0.0 || (longest_turn_rad_s..=FASTEST_RAD_S).contains(&speed);
    if !(turns_so(comes_rad_s) && turns_so(goes_rad_s)) {
        return wrong("a cut begins or ends with c_axis turning backwards, too slowly or too fast to be met");
    }
    if !(0..machine.axis(Axis::C).scale.counts(TURN_RAD)).contains(&curves.cut.start_counts) {
        return wrong("the start of a cut must lie within one turn of c_axis");
    }
    if !(0.0..=FARTHEST_MM).contains(&curves.cut.retract_mm) || !(0.0..=FARTHEST_MM).contains(&curves.cut.hold_mm) {
        return wrong("a cut is left by less than nothing or by more than a kilometre");
    }
    let is_short = knots[0].at.abs() <= LONGEST_CUT_S && motion.end_s().abs() <= LONGEST_CUT_S;
    let is_near = |knot: &Knot| knot.value.abs() <= FASTEST_RAD_S * LONGEST_CUT_S;
    if !(is_short && knots.iter().all(is_near)) {
        return wrong("a cut takes longer than a day or turns c_axis farther than it could in one");
    }
    match (turns, comes_rad_s > 0.0) {
        (true, false) => wrong("a cut begins at rest, and c_axis turns on from the one before"),
        (false, true) => wrong("a cut begins with c_axis turning, and it does not turn before"),
        (false, false) if knots[0].at != 0.0 || knots[0].value != 0.0 => {
            wrong("a cut that begins at rest must begin at time 0 and angle 0")
        }
        _ => Ok(()),
    }
}

/// A spiral begins and ends at rest, turns as often as it says, and stays within numbers that counts fit into and within the soft limits.
fn check_spiral(
    index: usize,
    spiral: &SpiralSegment,
    segment: &Segment,
    curves: &SpiralMotion<'_>,
    machine: &MachineDescription,
) -> Result<(), PrepareError> {
    let wrong = |what| Err(PrepareError::BadCut { segment: index, what });
    let knots = curves.law.knots();
    let (first, last) = (knots[0], knots[knots.len() - 1]);
    if first.at != 0.0 || first.value != 0.0 || [first, last].iter().any(|end| end.first != 0.0 || end.second != 0.0) {
        return wrong("a spiral must begin at time 0 and angle 0, and begin and end at rest");
    }
    if last.at > LONGEST_CUT_S || knots.iter().any(|knot| knot.value.abs() > FASTEST_RAD_S * LONGEST_CUT_S) {
        return wrong("a spiral takes longer than a day or turns c_axis farther than it could in one");
    }
    let scale = machine.axis(Axis::C).scale;
    if last.value <= 0.0 {
        return wrong("a spiral must turn c_axis forwards");
    }
    if !(0..scale.counts(TURN_RAD)).contains(&spiral.start_counts) {
        return wrong("the start of a spiral must lie within one turn of c_axis");
    }
    if segment.stop_ticks == 0 {
        return Err(PrepareError::NoStop { segment: index });
    }
    if segment.ticks != whole_ticks(last.at, machine.cycle_time_s()) {
        return wrong("the predicted length of a spiral is not that of its law");
    }
    for (axis, law) in [(Axis::X, curves.path), (Axis::Z, curves.advance)] {
        let (low, high) = machine.axis(axis).soft_limits.unwrap_or((-FARTHEST_MM, FARTHEST_MM));
        // Half a count: a limit is met by its own rounding. Between its knots a law is looked at when it is checked forwards.
        let half = 0.5 / machine.axis(axis).scale.counts_per_unit();
        for knot in law.knots() {
            let bound_mm = if knot.value < low - half { low } else { high };
            if !(low - half..=high + half).contains(&knot.value) {
                return Err(PrepareError::SoftLimit { segment: index, x_mm: knot.value, bound_mm });
            }
        }
    }
    Ok(())
}

/// C from the end of a cut to the next one, where it turns on; nothing in between may move it.
fn spin_after(
    index: usize,
    curves: &Curves<'_>,
    plan: &Plan,
    machine: &MachineDescription,
) -> Result<Option<SpinFacts>, PrepareError> {
    let (_, from_rad_s) = curves.motion().end_speeds_rad_s();
    if from_rad_s <= 0.0 {
        return Ok(None);
    }
    for (segment, later) in plan.segments.iter().enumerate().skip(index + 1) {
        let moves_c = match &later.kind {
            SegmentKind::Cut(next) => {
                let next = Curves::from_segment(plan, next).ok_or(PrepareError::MissingSpline { segment })?;
                return Ok(Some(SpinFacts::new(from_rad_s, next.motion().end_speeds_rad_s().0, machine)));
            }
            SegmentKind::Move(targets) => targets.iter().any(|target| target.axis == Axis::C),
            SegmentKind::Spiral(_) => true,
            SegmentKind::Search { axis, .. } | SegmentKind::Command(PlanCommand::SetHome(axis)) => *axis == Axis::C,
            SegmentKind::Home(_) => true,
            SegmentKind::Dwell | SegmentKind::Wait | SegmentKind::Command(_) => false,
        };
        if moves_c {
            return Err(PrepareError::BadCut { segment, what: "c_axis still turns on from the cut before" });
        }
    }
    Err(PrepareError::BadCut { segment: index, what: "c_axis turns on, and no cut comes after" })
}

/// Limits of X that remain for a retract on top of the path; and whether both stay inside the soft limits.
fn spare_limits(index: usize, curves: &Curves<'_>, machine: &MachineDescription) -> Result<MotionLimits, PrepareError> {
    let axis = machine.axis(Axis::X);
    // Every tick, up to a fifth of a million of them: the path is sampled no more finely when it is executed.
    let ticks = whole_ticks(curves.motion().duration_s(), machine.cycle_time_s());
    let stride = ticks / 200_000 + 1;
    let mut peaks = [0.0_f64; 3];
    let mut range = (f64::INFINITY, f64::NEG_INFINITY);
    for tick in (0..=ticks).step_by(usize::try_from(stride).unwrap_or(1)) {
        let time_s = curves.motion().start_s() + tick as f64 * machine.cycle_time_s();
        let x = curves.x(time_s);
        for (peak, value) in peaks.iter_mut().zip([x.first, x.second, x.third]) {
            *peak = peak.max(libm::fabs(value));
        }
        range = (range.0.min(x.value), range.1.max(x.value));
        if !(x.value.abs() <= FARTHEST_MM && curves.angle(time_s).value.abs() <= FASTEST_RAD_S * LONGEST_CUT_S) {
            let what = "x_axis would go farther than a kilometre, or c_axis turn farther than it could in a day";
            return Err(PrepareError::BadCut { segment: index, what });
        }
    }
    if let Some((low, high)) = axis.soft_limits {
        let farthest = range.1 + curves.cut.retract_mm.max(curves.cut.hold_mm);
        // Half a count: a limit is met by its own rounding.
        let half = 0.5 / axis.scale.counts_per_unit();
        if range.0 < low - half {
            return Err(PrepareError::SoftLimit { segment: index, x_mm: range.0, bound_mm: low });
        }
        if farthest > high + half {
            return Err(PrepareError::SoftLimit { segment: index, x_mm: farthest, bound_mm: high });
        }
    }
    // A path at its limits leaves nothing, and still the wheel must come off: a twentieth is then used above them.
    let spare = |limit: f64, peak: f64| (limit - peak).max(0.05 * limit);
    Ok(MotionLimits {
        velocity: spare(axis.limits.velocity, peaks[0]),
        acceleration: spare(axis.limits.acceleration * MOVE_SHARE, peaks[1]),
        jerk: spare(axis.limits.jerk * MOVE_SHARE, peaks[2]),
    })
}
