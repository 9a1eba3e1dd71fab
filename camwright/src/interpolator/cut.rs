// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Generation in execution: C by its law, X by the path and the infeed, and the hold that takes the wheel off the part or
//! stops its infeed.
//!
//! ```text
//!  X offset                 .-------------------.            C keeps turning on the plateau of its law, which
//!   (infeed + law)         /   held, C turning   \           repeats every turn; path time is folded back by whole
//!                         /                       \          turns there, and the turns are inserted into C.
//!  ------ infeed --------'u_h                  u_s '-- u_r --- infeed goes on        u_r = u_h + whole turns
//! ```
//! The wheel leaves with the velocity it has and returns to the same phase of the same turn of the infeed with the
//! same velocity and acceleration: afterwards the path is the one that was left. A hold that stops the infeed only is the
//! same with no distance to go.

use super::exchange::InfeedEnd;
use super::free_rotation::{FreeRotation, SpinFacts, next_start};
use super::path_time::{ONE, PathClock, from_ticks, to_ticks, whole};
use super::pose::{AxisPose, in_counts};
use crate::machine::description::{Axis, MachineDescription, MotionLimits};
use crate::math::hermite::Sample;
use crate::math::units::TURN_RAD;
use crate::motion::cut_motion::{CutMotion, chain, sum};
use crate::motion::plan::{CutSegment, Plan};
use crate::motion::point_to_point::{JerkLaw, solve, whole_ticks};

/// The curves of one cut, looked up in its plan.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Curves<'a> {
    pub(crate) cut: &'a CutSegment,
    motion: CutMotion<'a>,
}

impl<'a> Curves<'a> {
    /// The curves of a cut; `None` if the plan lacks them.
    pub(crate) fn from_segment(plan: &'a Plan, cut: &'a CutSegment) -> Option<Self> {
        Some(Self { cut, motion: plan.motion_of(cut)? })
    }

    pub(crate) fn motion(&self) -> &CutMotion<'a> {
        &self.motion
    }

    /// Angle since the cut begins (rad over s).
    pub(crate) fn angle(&self, time_s: f64) -> Sample {
        self.motion.angle(time_s)
    }

    /// When the last turn ends (s): C that turns on has one more knot.
    fn last_turn_s(&self) -> f64 {
        let knots = self.motion.law.knots();
        let behind = usize::from(self.motion.end_speeds_rad_s().1 > 0.0);
        knots[knots.len() - 1 - behind].at
    }

    /// Angle of the path while C is as given. Whole turns are taken out first: the path then closes to the last bit.
    fn path_angle(&self, c: Sample) -> f64 {
        self.motion.path_start_rad + (c.value - TURN_RAD * libm::floor(c.value / TURN_RAD))
    }

    /// X on the path, without infeed, while C is as given.
    pub(crate) fn path(&self, c: Sample) -> Sample {
        chain(self.motion.path.sample(self.path_angle(c)), c)
    }

    /// Addition of the infeed to X for a motion of C.
    pub(crate) fn infeed(&self, c: Sample) -> Sample {
        self.offset(self.infeed_at(c.value), c)
    }

    /// Addition of an infeed that rests at `level_mm` to X for a motion of C.
    fn standing(&self, level_mm: f64, c: Sample) -> Sample {
        self.offset(Sample { value: level_mm, ..Sample::default() }, c)
    }

    /// The way of X for an infeed over the angle.
    fn offset(&self, infeed: Sample, c: Sample) -> Sample {
        chain(self.motion.path_position(infeed, self.path_angle(c)), c)
    }

    /// X without any hold at a time (mm over s); before the start and after the end as there.
    pub(crate) fn x(&self, time_s: f64) -> Sample {
        let time_s = time_s.clamp(self.motion.start_s(), self.motion.end_s());
        let c = self.angle(time_s);
        sum(sum(self.path(c), self.infeed(c)), self.motion.beside_path(time_s))
    }

    /// Material taken off since the start, where the infeed is the only thing that takes it (mm).
    pub(crate) fn infed_mm(&self, angle_rad: f64) -> f64 {
        self.infeed_at(0.0).value - self.infeed_at(angle_rad).value
    }

    /// Infeed still to come at an angle since the start (mm over rad).
    fn infeed_at(&self, angle_rad: f64) -> Sample {
        self.motion.infeed.sample(angle_rad)
    }
}

/// Offset of X from the path.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Offset {
    Infeed,
    /// Leaves the part, or stands off it.
    Off {
        /// State of the infeed at the interruption.
        left: InterruptedInfeed,
        /// Retraction (mm); 0 if only the infeed stops.
        to_mm: f64,
        /// Offset relative to the infeed there (mm over s of path time), from `begin` on.
        law: JerkLaw,
        begin: i64,
    },
    /// Waits for its phase and returns to the part.
    Back {
        left: InterruptedInfeed,
        to_mm: f64,
        /// The way back, in reverse: relative offset over the time before `until`.
        law: JerkLaw,
        from: i64,
        until: i64,
        turns: i64,
    },
}

/// State of the infeed at the interruption.
#[derive(Debug, Clone, Copy, PartialEq)]
struct InterruptedInfeed {
    at: i64,
    /// The infeed there (mm), and what it was doing to X beyond standing still (mm, s of path time).
    infeed_mm: f64,
    moving: Sample,
}

/// Infeed that ended before its law did: the gauge read the size.
#[derive(Debug, Clone, Copy, PartialEq)]
struct EndedInfeed {
    /// The infeed there (mm), where it stays.
    level_mm: f64,
    /// Way to rest relative to the level (mm over s of path time), from `begin` on.
    law: JerkLaw,
    begin: i64,
}

/// A cut in execution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CutExecution {
    clock: PathClock,
    start_counts: i64,
    /// Turns of C inserted by holds that are over.
    inserted: i64,
    offset: Offset,
    ended: Option<EndedInfeed>,
    plateau: (i64, i64),
    turn: i64,
    /// Angle from which the wheel has been on the path without a break (rad), and the tick from which a whole turn of spark-out lies
    /// behind it, if one does.
    undisturbed_rad: f64,
    sparked_out: Option<u64>,
    /// Start, start and end of the first and the last turn, and end.
    start: i64,
    turns: (i64, i64),
    end: i64,
    /// C turns on at the end.
    turns_on: bool,
    /// X also moves outwards, as in a runout correction. A wheel that left such a path and returned to it would cut deeper than planned,
    /// so a hold waits for the end of the cut.
    goes_outwards: bool,
    retract_mm: f64,
    hold_mm: f64,
    retract_limits: MotionLimits,
    stop_ticks: u64,
    cycle_s: f64,
}

/// A clock for a cut that C comes to turning: path time 0 where the cut begins, and C there (counts).
pub(crate) fn clock_from(
    spin: &FreeRotation,
    tick: u64,
    curves: &Curves<'_>,
    machine: &MachineDescription,
) -> (PathClock, i64) {
    let (motion, cycle_s) = (curves.motion(), machine.cycle_time_s());
    let (w, _) = motion.end_speeds_rad_s();
    let law_start_rad = motion.law.knots()[0].value;
    let (since_rad, c_counts) =
        next_start(spin.place(tick, machine), curves.cut.start_counts, law_start_rad, w * cycle_s, machine);
    let tau = from_ticks((motion.start_s() + since_rad / w) / cycle_s);
    let mut clock = spin.clock();
    clock.rewind(clock.at(tick).tau - tau);
    (clock, c_counts)
}

/// State at the start of a cut in addition to its segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CutStart {
    /// Its path time 0 is where the cut begins.
    pub(crate) clock: PathClock,
    /// C where the cut begins (counts).
    pub(crate) c_counts: i64,
    pub(crate) stop_ticks: u64,
    /// Limits of X that the path leaves to a retract.
    pub(crate) retract_limits: MotionLimits,
    pub(crate) cycle_s: f64,
}

impl CutExecution {
    pub(crate) fn new(curves: &Curves<'_>, start: &CutStart) -> Self {
        let ticks = |seconds: f64| from_ticks(seconds / start.cycle_s);
        let (cut, motion) = (curves.cut, curves.motion());
        let turns_on = motion.end_speeds_rad_s().1 > 0.0;
        // At rest the end is the first tick at which the law is over.
        let end = if turns_on { ticks(motion.end_s()) } else { whole(whole_ticks(motion.end_s(), start.cycle_s)) };
        Self {
            clock: start.clock,
            start_counts: start.c_counts,
            inserted: 0,
            offset: Offset::Infeed,
            ended: None,
            plateau: (ticks(cut.plateau_s.0), ticks(cut.plateau_s.1)),
            turn: ticks(cut.turn_s),
            undisturbed_rad: 0.0,
            sparked_out: None,
            start: ticks(motion.start_s()),
            turns: (0, if turns_on { ticks(curves.last_turn_s()) } else { end }),
            end,
            turns_on,
            goes_outwards: motion.infeed.knots().windows(2).any(|pair| pair[1].value > pair[0].value),
            retract_mm: cut.retract_mm,
            hold_mm: cut.hold_mm,
            retract_limits: start.retract_limits,
            stop_ticks: start.stop_ticks,
            cycle_s: start.cycle_s,
        }
    }

    fn seconds(&self, tau: i64) -> f64 {
        to_ticks(tau) * self.cycle_s
    }

    /// The plateau is long enough for a turn to be inserted.
    fn repeats(&self) -> bool {
        self.turn > 0 && self.plateau.1 - self.plateau.0 >= self.turn
    }

    /// Path time folded back into the plateau, and the turns taken out.
    fn fold(&self, tau: i64, left: &InterruptedInfeed) -> (i64, i64) {
        if !self.repeats() || left.at > self.plateau.1 || tau <= self.plateau.1 {
            return (tau, 0);
        }
        let turns = (tau - self.plateau.1 + self.turn - 1) / self.turn;
        (tau - turns * self.turn, turns)
    }

    /// Infeed at an angle since the start (mm).
    fn level_mm(&self, angle_rad: f64, curves: &Curves<'_>) -> f64 {
        self.ended.map_or_else(|| curves.infeed_at(angle_rad).value, |ended| ended.level_mm)
    }

    /// Addition of the infeed to X at a path time, for the motion of C there.
    fn infeed(&self, tau: i64, c: Sample, curves: &Curves<'_>) -> Sample {
        match &self.ended {
            None => curves.infeed(c),
            Some(EndedInfeed { level_mm, law, begin }) => {
                sum(curves.standing(*level_mm, c), law.sample(self.seconds(tau - begin)))
            }
        }
    }

    /// Infeed since the cut began (mm), at an angle since then.
    pub(crate) fn infed_mm(&self, angle_rad: f64, curves: &Curves<'_>) -> f64 {
        self.ended.map_or_else(|| curves.infed_mm(angle_rad), |ended| curves.infeed_at(0.0).value - ended.level_mm)
    }

    /// C and X without any hold at a path time.
    fn follow(&self, tau: i64, curves: &Curves<'_>) -> (Sample, Sample) {
        if tau >= self.end && !self.turns_on {
            // Exactly: counts close after whole turns.
            let c = Sample { value: f64::from(curves.cut.turns) * TURN_RAD, ..Sample::default() };
            return (c, sum(curves.path(c), self.infeed(tau, c, curves)));
        }
        let time_s = self.seconds(tau);
        let x = match &self.ended {
            None => curves.x(time_s),
            Some(_) => {
                let c = curves.angle(time_s);
                sum(curves.path(c), self.infeed(tau, c, curves))
            }
        };
        let rests = tau < self.start || tau > self.end;
        (curves.angle(time_s), if rests { Sample { value: x.value, ..Sample::default() } } else { x })
    }

    /// C since the cut began at a path time, the turns inserted, and X.
    fn axes_at(&self, tau: i64, curves: &Curves<'_>) -> (Sample, i64, Sample) {
        let follow = |tau: i64, inserted: i64| {
            let (c, x) = self.follow(tau, curves);
            (c, inserted, x)
        };
        match &self.offset {
            Offset::Infeed => follow(tau, self.inserted),
            Offset::Back { until, turns, .. } if tau >= *until => {
                follow(tau - turns * self.turn, self.inserted + turns)
            }
            Offset::Off { left, .. } | Offset::Back { left, .. } => {
                let (folded, turns) = self.fold(tau, left);
                let c = curves.angle(self.seconds(folded));
                let beside = sum(curves.standing(left.infeed_mm, c), self.off_part(tau));
                (c, self.inserted + turns, sum(curves.path(c), beside))
            }
        }
    }

    /// Distance from where the infeed was left.
    fn off_part(&self, tau: i64) -> Sample {
        match &self.offset {
            Offset::Infeed => Sample::default(),
            Offset::Off { law, begin, .. } => law.sample(self.seconds(tau - begin)),
            Offset::Back { law, from, until, .. } => {
                // In reverse: the first derivative changes its sign, the second does not.
                let back = law.sample(if tau <= *from { law.duration() } else { self.seconds(until - tau) });
                Sample { first: -back.first, third: -back.third, ..back }
            }
        }
    }

    /// Axes at a tick.
    pub(crate) fn pose(
        &self,
        tick: u64,
        curves: &Curves<'_>,
        machine: &MachineDescription,
        rest: &AxisPose,
    ) -> AxisPose {
        let time = self.clock.at(tick);
        let (c, inserted, x) = self.axes_at(time.tau, curves);
        let mut pose = AxisPose { base: rest.base, ..AxisPose::default() };
        let turn_counts = machine.axis(Axis::C).scale.counts(TURN_RAD);
        pose.set_axis(Axis::C, self.start_counts + inserted * turn_counts, &c, &time, machine);
        pose.set_axis(Axis::X, 0, &x, &time, machine);
        pose
    }

    /// Turns done, inserted ones not counted, and the angle since the cut began (rad): below 0 before, above its turns after it.
    pub(crate) fn progress(&self, tick: u64, curves: &Curves<'_>) -> (f64, f64) {
        let (c, _, _) = self.axes_at(self.clock.at(tick).tau, curves);
        let angle = match &self.offset {
            Offset::Off { left, .. } | Offset::Back { left, .. } => curves.angle(self.seconds(left.at)).value,
            Offset::Infeed => c.value,
        };
        ((angle / TURN_RAD).clamp(0.0, f64::from(curves.cut.turns)), angle)
    }

    /// Path time done (ticks).
    pub(crate) fn ticks_done(&self, tick: u64) -> f64 {
        to_ticks(match &self.offset {
            Offset::Off { left, .. } | Offset::Back { left, .. } => left.at - self.start,
            Offset::Infeed => (self.clock.at(tick).tau - self.start).max(0),
        })
    }

    /// Path time of the whole cut (ticks).
    pub(crate) fn length_ticks(&self) -> f64 {
        to_ticks(self.end - self.start)
    }

    pub(crate) fn is_done(&self, tick: u64) -> bool {
        self.offset == Offset::Infeed && self.clock.at(tick).tau >= self.end
    }

    /// On the infeed, where a hold can begin.
    pub(crate) fn can_leave(&self, tick: u64) -> bool {
        let tau = self.clock.at(tick).tau;
        !self.goes_outwards && self.repeats() && tau >= self.plateau.0 && tau <= self.plateau.1
    }

    /// Between its first turn and its last, where the wheel may be on the part.
    pub(crate) fn is_turning_the_part(&self, tick: u64) -> bool {
        let tau = self.clock.at(tick).tau;
        tau >= self.turns.0 && tau <= self.turns.1
    }

    /// C has still to come to where it begins.
    fn is_waiting(&self, tick: u64) -> bool {
        self.offset == Offset::Infeed && self.clock.at(tick).tau < self.start
    }

    /// Lets the phase at which it begins go by once more, if it would begin at once.
    pub(crate) fn let_pass(&mut self, tick: u64, curves: &Curves<'_>, machine: &MachineDescription) {
        let (speed_rad_s, _) = curves.motion().end_speeds_rad_s();
        if self.is_waiting(tick) && self.is_next(tick) && speed_rad_s > 0.0 {
            self.start_counts += machine.axis(Axis::C).scale.counts(TURN_RAD);
            self.clock.rewind(from_ticks(TURN_RAD / speed_rad_s / self.cycle_s));
        }
    }

    /// It would begin within the next two ticks.
    fn is_next(&self, tick: u64) -> bool {
        self.start - self.clock.at(tick).tau < 2 * ONE
    }

    /// C turning on from its end.
    pub(crate) fn spin(
        &self,
        curves: &Curves<'_>,
        facts: SpinFacts,
        machine: &MachineDescription,
    ) -> Option<FreeRotation> {
        let scale = machine.axis(Axis::C).scale;
        let turned = in_counts(scale, curves.angle(self.seconds(self.end)).value);
        let base = self.start_counts + self.inserted * scale.counts(TURN_RAD);
        self.turns_on.then(|| FreeRotation::new(self.clock, self.end, (base, turned), facts, self.cycle_s))
    }

    pub(crate) fn is_on_path(&self) -> bool {
        self.offset == Offset::Infeed
    }

    pub(crate) fn is_returning(&self) -> bool {
        matches!(self.offset, Offset::Back { .. })
    }

    /// The wheel stands off the part at a tick.
    pub(crate) fn is_off(&self, tick: u64) -> bool {
        match &self.offset {
            Offset::Off { law, begin, .. } => self.seconds(self.clock.at(tick).tau - begin) >= law.duration(),
            Offset::Back { from, .. } => self.clock.at(tick).tau <= *from,
            Offset::Infeed => false,
        }
    }

    /// A hold: takes the wheel off the part, or stops the infeed only, continuing the state of a tick.
    pub(crate) fn hold(&mut self, tick: u64, curves: &Curves<'_>) {
        self.leave(tick, curves, self.hold_mm);
    }

    /// A cancel: takes the wheel off the part, continuing the state of a tick.
    pub(crate) fn retract(&mut self, tick: u64, curves: &Curves<'_>) {
        self.leave(tick, curves, self.retract_mm.max(self.hold_mm));
    }

    fn leave(&mut self, tick: u64, curves: &Curves<'_>, to_mm: f64) {
        let tau = self.clock.at(tick).tau;
        let left = match self.offset {
            Offset::Off { to_mm: already_mm, .. } if already_mm >= to_mm => return,
            Offset::Off { left, .. } | Offset::Back { left, .. } => left,
            Offset::Infeed => {
                let c = curves.angle(self.seconds(tau.min(self.end)));
                let infeed_mm = self.level_mm(c.value, curves);
                InterruptedInfeed { at: tau, infeed_mm, moving: self.moving(tau, c, infeed_mm, curves) }
            }
        };
        (self.undisturbed_rad, self.sparked_out) = (f64::INFINITY, None);
        let off = if self.offset == Offset::Infeed { left.moving } else { self.off_part(tau) };
        let law = solve(to_mm - off.value, off.first, off.second, 0.0, &self.retract_limits);
        self.offset = Offset::Off { left, to_mm, law: law.shifted(off.value), begin: tau };
    }

    /// Motion of X by the infeed at a path time, beyond an infeed that rests at `infeed_mm` (mm over s of path time).
    fn moving(&self, tau: i64, c: Sample, infeed_mm: f64, curves: &Curves<'_>) -> Sample {
        let (goes, stands) = (self.infeed(tau, c, curves), curves.standing(infeed_mm, c));
        Sample {
            value: 0.0,
            first: goes.first - stands.first,
            second: goes.second - stands.second,
            third: goes.third - stands.third,
        }
    }

    pub(crate) fn is_infeed_ended(&self) -> bool {
        self.ended.is_some()
    }

    /// The law of the infeed is at its end, all whole turns with infeed included.
    pub(crate) fn is_infeed_over(&self, tick: u64, curves: &Curves<'_>) -> bool {
        let angle_rad = curves.angle(self.seconds(self.clock.at(tick).tau)).value;
        let over_rad = curves.motion.infeed.end().max(f64::from(curves.cut.infeed_turns) * TURN_RAD);
        self.is_on_path() && angle_rad >= over_rad
    }

    /// Ends the infeed where it is, continuing the state of a tick: X comes to rest beside the path, and the turns with infeed that would
    /// follow are left out. The turn under way is finished, and every turn of spark-out follows it. `None` while a hold has the wheel off
    /// its way, and where C does not yet turn as it does in every turn.
    pub(crate) fn end_infeed(&mut self, tick: u64, curves: &Curves<'_>) -> Option<InfeedEnd> {
        let tau = self.clock.at(tick).tau;
        if !self.is_on_path() || tau < self.plateau.0 || tau > self.plateau.1 {
            return None;
        }
        let c = curves.angle(self.seconds(tau));
        let level_mm = self.level_mm(c.value, curves);
        let moving = self.moving(tau, c, level_mm, curves);
        let law = solve(0.0, moving.first, moving.second, 0.0, &self.retract_limits);
        let turn = c.value / TURN_RAD;
        let repeating = (self.plateau.1 - tau).div_euclid(self.turn.max(1));
        #[allow(clippy::cast_possible_truncation, reason = "turns of a cut")]
        let left_out = (i64::from(curves.cut.infeed_turns) - libm::ceil(turn) as i64).clamp(0, repeating.max(0));
        let skipped = left_out * self.turn;
        self.ended = Some(EndedInfeed { level_mm, law, begin: tau + skipped });
        self.clock.rewind(-skipped);
        self.inserted -= left_out;
        Some(InfeedEnd {
            lobe: 0,
            turn,
            infed_mm: curves.infeed_at(0.0).value - level_mm,
            left_out: u32::try_from(left_out).unwrap_or(u32::MAX),
        })
    }

    /// Sends the wheel back to the phase at which it left, as soon as C comes by.
    pub(crate) fn come_back(&mut self, tick: u64) {
        let Offset::Off { left, to_mm, .. } = self.offset else { return };
        if !self.is_off(tick) {
            return;
        }
        let tau = self.clock.at(tick).tau;
        let law = solve(to_mm, -left.moving.first, left.moving.second, 0.0, &self.retract_limits);
        let length = from_ticks(law.duration() / self.cycle_s) + 1;
        let turns = ((tau + length - left.at).max(0) + self.turn - 1) / self.turn;
        let until = left.at + turns * self.turn;
        self.offset = Offset::Back { left, to_mm, law, from: until - length, until, turns };
    }

    /// Goes on with the infeed once the wheel is back.
    pub(crate) fn settle(&mut self, tick: u64) {
        if let Offset::Back { until, turns, .. } = self.offset
            && self.clock.at(tick).tau >= until
        {
            self.inserted += turns;
            self.clock.rewind(turns * self.turn);
            self.offset = Offset::Infeed;
        }
    }

    /// Leaves out what turns of spark-out there still are, where the cut says so and the force has been steady: since tick k knows
    /// what was up to k − D, once a whole undisturbed turn of spark-out has been seen. The turn under way is finished. How many turns.
    ///
    /// In spark-out C and X repeat with every turn, so the motion goes on without a step.
    pub(crate) fn leave_out(&mut self, tick: u64, curves: &Curves<'_>, is_steady: bool, delay: u32) -> u32 {
        if curves.cut.until_steady_n.is_none() || !self.is_on_path() {
            return 0;
        }
        let tau = self.clock.at(tick).tau;
        let angle_rad = curves.angle(self.seconds(tau)).value;
        if self.undisturbed_rad.is_infinite() {
            self.undisturbed_rad = angle_rad;
        }
        let from_rad = self.undisturbed_rad.max(f64::from(curves.cut.infeed_turns) * TURN_RAD);
        if angle_rad < from_rad + TURN_RAD {
            return 0;
        }
        let since = *self.sparked_out.get_or_insert(tick);
        let turns = (self.plateau.1 - tau).div_euclid(self.turn.max(1));
        if !is_steady || tick < since + u64::from(delay) || turns < 1 {
            return 0;
        }
        self.clock.rewind(-turns * self.turn);
        self.inserted -= turns;
        u32::try_from(turns).unwrap_or(u32::MAX)
    }

    /// The wanted rate, or a slower one in the slower half of a variation of the work speed. At the end of the plateau the rate is the
    /// wanted one again.
    pub(crate) fn varied_rate(&self, tick: u64, wanted: i64, curves: &Curves<'_>) -> i64 {
        let Some(variation) = &curves.cut.variation else { return wanted };
        let tau = self.clock.at(tick).tau;
        let end = self.plateau.1 - whole(self.stop_ticks);
        if !self.is_on_path() || tau < self.plateau.0 || tau >= end {
            return wanted;
        }
        let (c, inserted, _) = self.axes_at(tau, curves);
        match variation.is_slow(c.value / TURN_RAD + inserted as f64) {
            true => from_ticks(to_ticks(wanted) * variation.slow_rate()),
            false => wanted,
        }
    }

    pub(crate) fn set_rate(&mut self, tick: u64, rate: i64) {
        self.clock.retarget(tick, rate, self.stop_ticks);
    }

    pub(crate) fn is_still(&self, tick: u64) -> bool {
        let at_end = || !self.turns_on && self.clock_past_end(tick);
        self.clock.is_stopped(tick) || (!self.is_on_path() && self.is_off(tick) && at_end())
    }

    /// Off the part, in the run-down, and C has come to the end of its law.
    fn clock_past_end(&self, tick: u64) -> bool {
        let tau = self.clock.at(tick).tau;
        match &self.offset {
            Offset::Off { left, .. } | Offset::Back { left, .. } => self.fold(tau, left).0 >= self.end,
            Offset::Infeed => tau >= self.end,
        }
    }

    /// The same cut, stopping as soon as it can, and the tick of its stop.
    pub(crate) fn stopping(&self, tick: u64) -> (Self, u64) {
        let (clock, end) = self.clock.stopping(tick, self.stop_ticks);
        (Self { clock, ..*self }, end)
    }
}

/// Slowest rate at which a wheel is taken off the part, whatever the override: at 0 it would burn its flat for ever,
/// at 1 an operator who crept along would see C leap.
pub(crate) const LEAVE_RATE: i64 = ONE / 4;
