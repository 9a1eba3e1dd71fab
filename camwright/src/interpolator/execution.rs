// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! One tick of whatever is being executed, and what follows when it ends.

use super::cut::{Curves, CutExecution, CutStart, LEAVE_RATE, clock_from};
use super::line::{FULL, LineExecution};
use super::path_time::{PathClock, to_ticks, whole};
use super::pose::AxisPose;
use super::{
    ExecutionMode, InfeedEnd, Interpolator, InterpolatorAlarm, InterpolatorEvent, MotionOutcome, Order, OrderKind,
    Prepared, Purpose, StepOutput,
};
use crate::machine::description::{Axis, MachineDescription};
use crate::math::units::TURN_RAD;
use crate::motion::plan::{AxisTarget, CutSegment, HomeStep, PlanCommand, Segment, SegmentKind};
use crate::motion::point_to_point::{MoveLaw, whole_ticks};

/// Time after the end of its travel during which a search still expects its edge (s), in addition to the feedback delay: the axis
/// lags its setpoint by its following error, a few 1/Kv.
const LAST_LOOK_S: f64 = 0.2;

impl Interpolator {
    pub(super) fn advance(&mut self, tick: u64, motion: &Prepared, out: &mut StepOutput) {
        if let Some(spin) = &mut self.spin {
            let rate = if self.alarm.is_some() || self.cancel { 0 } else { self.feed_override };
            spin.set_rate(tick.saturating_sub(1), rate);
        }
        match self.mode {
            ExecutionMode::Idle | ExecutionMode::Fault => {}
            ExecutionMode::Starting => self.begin(0, tick, motion, out),
            ExecutionMode::Ready => {
                if !self.leaves_at_rest(tick, motion, out) && !self.hold {
                    self.begin(self.segment, tick, motion, out);
                }
            }
            ExecutionMode::Dwell { left } => {
                if !self.leaves_at_rest(tick, motion, out) && !self.hold {
                    self.mode = ExecutionMode::Dwell { left: left.saturating_sub(1) };
                    if left <= 1 {
                        self.begin(self.segment + 1, tick, motion, out);
                    }
                }
            }
            ExecutionMode::Wait => {
                if !self.leaves_at_rest(tick, motion, out) && !self.hold && self.decisions > 0 {
                    self.decisions -= 1;
                    self.begin(self.segment + 1, tick, motion, out);
                }
            }
            // An order that is under way takes effect, whatever is wanted meanwhile.
            ExecutionMode::Command { until } => {
                if tick >= until {
                    self.take_effect(motion);
                    self.begin(self.segment + 1, tick, motion, out);
                }
            }
            ExecutionMode::Level { until } => self.check_level(until, tick, motion, out),
            ExecutionMode::LastLook { until } => self.check_last(until, tick, motion, out),
            ExecutionMode::Line(line, purpose) => self.advance_line(line, purpose, tick, motion, out),
            ExecutionMode::Cut(cut) => self.advance_cut(cut, tick, motion, out),
            ExecutionMode::Spiral(spiral) => self.advance_spiral(spiral, tick, motion, out),
            ExecutionMode::Trajectory(clock) => self.advance_trajectory(clock, tick, motion, out),
            ExecutionMode::Settle => self.settle(tick, motion, out),
        }
        self.put_spin(tick);
        self.watch_soft_limits(out);
    }

    /// C of a tick, where it turns on between two cuts.
    fn put_spin(&mut self, tick: u64) {
        if let Some(spin) = &self.spin {
            spin.apply(tick, &self.machine, &mut self.setpoint);
        }
    }

    /// Begins a segment with its path time 0 at this tick; segments without length are passed over.
    pub(super) fn begin(&mut self, segment: usize, tick: u64, motion: &Prepared, out: &mut StepOutput) {
        self.rest();
        let mut next = segment;
        loop {
            self.segment = next;
            self.segment_began = tick;
            self.caught = None;
            self.mode = ExecutionMode::Ready;
            if self.leaves_at_rest(tick, motion, out) {
                return;
            }
            if motion.trajectory.is_some() && next == 0 {
                self.mode =
                    ExecutionMode::Trajectory(PathClock::starting(tick.max(motion.starts_at), self.feed_override));
                return;
            }
            let Some(planned) = motion.plan.segments.get(next) else {
                self.finish(MotionOutcome::Completed, out);
                return;
            };
            let is_cut = matches!(planned.kind, SegmentKind::Cut(_));
            if self.hold || (is_cut && self.spin.is_some_and(|spin| !spin.is_steady(tick))) {
                return;
            }
            out.events.push(InterpolatorEvent::Segment(next));
            match self.enter(planned, tick, motion, out) {
                Ok(true) => return,
                Ok(false) => next += 1,
                Err(alarm) => {
                    self.fail(alarm, out);
                    return;
                }
            }
        }
    }

    /// Starts a segment; `false` if it is over already.
    fn enter(
        &mut self,
        segment: &Segment,
        tick: u64,
        motion: &Prepared,
        out: &mut StepOutput,
    ) -> Result<bool, InterpolatorAlarm> {
        match &segment.kind {
            SegmentKind::Move(targets) => {
                for target in targets.iter().filter(|target| self.homed[target.axis.index()] || !motion.is_lost) {
                    self.check_target(target)?;
                }
                self.enter_line(targets, Purpose::Move, tick)
            }
            SegmentKind::Search { axis, travel_counts, limits, .. } => {
                let target_counts = self.setpoint.counts[axis.index()] + travel_counts;
                self.enter_line(&[AxisTarget { axis: *axis, target_counts, limits: *limits }], Purpose::Seek, tick)
            }
            SegmentKind::Home(step) => self.enter_home(step, tick, out),
            SegmentKind::Cut(cut) => self.enter_cut(cut, segment, tick, motion).map(|()| true),
            SegmentKind::Spiral(spiral) => self.enter_spiral(spiral, segment, tick, motion).map(|()| true),
            SegmentKind::Dwell => {
                self.mode = ExecutionMode::Dwell { left: segment.ticks };
                Ok(segment.ticks > 0)
            }
            SegmentKind::Wait => {
                self.mode = ExecutionMode::Wait;
                Ok(true)
            }
            SegmentKind::Command(command) => {
                // Long enough for the order to reach the machine while setpoints run D ahead, and to be acknowledged.
                let until = tick + 2 * u64::from(self.machine.feedback_delay_ticks).max(1);
                let kind = match command {
                    PlanCommand::SetHome(axis) => {
                        OrderKind::SetHome { axis: *axis, counts: self.references[axis.index()] }
                    }
                    PlanCommand::WheelStart => OrderKind::WheelStart,
                    PlanCommand::WheelStop => OrderKind::WheelStop,
                    PlanCommand::ExpectWheel { radius_nm } => OrderKind::ExpectWheel { radius_nm: *radius_nm },
                    PlanCommand::ChangeWheel { wheel } => OrderKind::ChangeWheel { wheel: *wheel },
                    PlanCommand::Dress { radius_nm } => OrderKind::Dress { radius_nm: *radius_nm },
                    PlanCommand::Push { max_n } => OrderKind::Push { max_n: *max_n },
                    PlanCommand::WatchForce { max_n } => OrderKind::WatchForce { max_n: *max_n },
                    PlanCommand::WatchSize(size) => {
                        (self.size_watched_from, self.is_size_reached) = (until, false);
                        OrderKind::WatchSize { diameter_nm: size.diameter_nm }
                    }
                };
                out.orders.push(Order { tick: until, kind });
                self.mode = ExecutionMode::Command { until };
                Ok(true)
            }
        }
    }

    fn check_target(&self, target: &AxisTarget) -> Result<(), InterpolatorAlarm> {
        let axis = self.machine.axis(target.axis);
        self.must_be_homed(&[target.axis])?;
        if let Some((low, high)) = axis.soft_limits {
            let (low, high) = (axis.scale.counts(low), axis.scale.counts(high));
            if target.target_counts < low || target.target_counts > high {
                let bound = if target.target_counts < low { low } else { high };
                return Err(InterpolatorAlarm::SoftLimit { axis: target.axis, counts: target.target_counts, bound });
            }
        }
        Ok(())
    }

    pub(super) fn enter_line(
        &mut self,
        targets: &[AxisTarget],
        purpose: Purpose,
        tick: u64,
    ) -> Result<bool, InterpolatorAlarm> {
        let rate = if purpose == Purpose::Retract { FULL } else { self.feed_override };
        let law = MoveLaw::new(self.setpoint.counts, targets, &self.machine)
            .map_err(|_| InterpolatorAlarm::BadSegment { segment: self.segment })?;
        let cycle_s = self.machine.cycle_time_s();
        let moves = law.ticks(cycle_s) > 0;
        self.mode = ExecutionMode::Line(LineExecution::new(law, tick, rate, cycle_s), purpose);
        // A search without travel looks all the same.
        Ok(moves || purpose == Purpose::Seek)
    }

    fn enter_cut(
        &mut self,
        cut: &CutSegment,
        segment: &Segment,
        tick: u64,
        motion: &Prepared,
    ) -> Result<(), InterpolatorAlarm> {
        let bad = InterpolatorAlarm::BadSegment { segment: self.segment };
        let (Some(curves), Some(facts)) = (Curves::from_segment(&motion.plan, cut), motion.facts.get(self.segment))
        else {
            return Err(bad);
        };
        self.must_be_homed(&[Axis::C, Axis::X])?;
        self.must_stand_at(Axis::X, curves.x(curves.motion().start_s()).value)?;
        let (clock, c_counts) = match self.spin.take() {
            Some(spin) => clock_from(&spin, tick, &curves, &self.machine),
            None => (PathClock::starting(tick, self.feed_override), self.c_at_start(cut.start_counts)?),
        };
        let cut = CutExecution::new(
            &curves,
            &CutStart {
                clock,
                c_counts,
                stop_ticks: segment.stop_ticks,
                retract_limits: facts.retract_limits,
                cycle_s: self.machine.cycle_time_s(),
            },
        );
        self.setpoint = cut.pose(tick, &curves, &self.machine, &AxisPose::at_rest(self.setpoint.counts)).setpoint();
        self.mode = ExecutionMode::Cut(cut);
        Ok(())
    }

    /// That these axes know where they are.
    pub(super) fn must_be_homed(&self, axes: &[Axis]) -> Result<(), InterpolatorAlarm> {
        match axes.iter().find(|axis| !self.homed[axis.index()]) {
            Some(axis) => Err(InterpolatorAlarm::NotHomed { axis: *axis }),
            None => Ok(()),
        }
    }

    /// That a slide stands where something begins (mm), to a count: planner and interpolator round the same place by different sums.
    pub(super) fn must_stand_at(&self, axis: Axis, position_mm: f64) -> Result<(), InterpolatorAlarm> {
        let (actual, wanted) = (self.setpoint.counts[axis.index()], self.machine.axis(axis).scale.counts(position_mm));
        if (actual - wanted).abs() > 1 {
            return Err(InterpolatorAlarm::NotAtStart { axis, wanted, actual });
        }
        Ok(())
    }

    /// C at rest where something begins (counts), of which the place within the turn is known.
    pub(super) fn c_at_start(&self, start_counts: i64) -> Result<i64, InterpolatorAlarm> {
        let actual = self.setpoint.counts[Axis::C.index()];
        let turn_counts = self.machine.axis(Axis::C).scale.counts(TURN_RAD).max(1);
        let off = (actual - start_counts).rem_euclid(turn_counts);
        if off.min(turn_counts - off) > 1 {
            return Err(InterpolatorAlarm::NotAtStart { axis: Axis::C, wanted: start_counts, actual });
        }
        Ok(actual)
    }

    /// The order of the present segment is in force.
    fn take_effect(&mut self, motion: &Prepared) {
        match motion.plan.segments.get(self.segment).map(|segment| &segment.kind) {
            Some(SegmentKind::Command(PlanCommand::SetHome(axis))) => {
                self.setpoint.counts[axis.index()] -= self.references[axis.index()];
                self.references[axis.index()] = 0;
                self.homed[axis.index()] = true;
            }
            Some(SegmentKind::Home(HomeStep::Forget(axis))) => self.homed[axis.index()] = false,
            _ => {}
        }
    }

    fn advance_line(
        &mut self,
        mut line: LineExecution,
        purpose: Purpose,
        tick: u64,
        motion: &Prepared,
        out: &mut StepOutput,
    ) {
        let before = tick.saturating_sub(1);
        let retracting = purpose == Purpose::Retract;
        let found = purpose == Purpose::Seek && self.caught.is_some();
        let rate = if retracting { FULL } else { self.feed_override };
        if self.alarm.is_some() || found || (!retracting && (self.cancel || self.hold)) {
            line.stop_from(before);
        } else if line.is_stopped(before) {
            line.resume(before, rate);
        }
        line.set_rate(before, rate);
        self.setpoint = line.pose(tick, &self.machine).setpoint();
        self.mode = ExecutionMode::Line(line, purpose);
        if line.is_stopped(tick) {
            self.rest();
            if self.alarm.is_some() || (self.cancel && !retracting) {
                self.leaves_at_rest(tick, motion, out);
            } else if found && !self.hold {
                self.return_to_edge(tick, motion, out);
            }
        } else if line.is_done(tick) {
            match purpose {
                Purpose::Move | Purpose::Return => self.begin(self.segment + 1, tick, motion, out),
                Purpose::Retract => {
                    self.rest();
                    self.finish(MotionOutcome::Cancelled, out);
                }
                Purpose::Seek => {
                    self.rest();
                    let look = whole_ticks(LAST_LOOK_S, self.machine.cycle_time_s());
                    let until = tick + look + u64::from(self.machine.feedback_delay_ticks);
                    self.mode = ExecutionMode::LastLook { until };
                }
            }
        }
    }

    fn advance_cut(&mut self, mut cut: CutExecution, tick: u64, motion: &Prepared, out: &mut StepOutput) {
        let Some(curves) = self.curves(motion) else {
            self.fail(InterpolatorAlarm::BadSegment { segment: self.segment }, out);
            return;
        };
        let before = tick.saturating_sub(1);
        cut.settle(before);
        let wanted = cut.varied_rate(before, self.feed_override, &curves);
        let rate = if self.alarm.is_some() {
            0
        } else if self.cancel {
            // At rest on the path there is nothing to leave: the retract that follows takes the wheel off. Nor is there on the
            // way to the part or from it.
            let leaves = cut.is_turning_the_part(before) && !cut.is_still(before);
            if !cut.is_on_path() || leaves {
                cut.retract(before, &curves);
            }
            if cut.is_on_path() || cut.is_off(before) { 0 } else { wanted.max(LEAVE_RATE) }
        } else if self.hold {
            cut.let_pass(before, &curves, &self.machine);
            if cut.is_returning() || (cut.is_on_path() && cut.can_leave(before)) {
                cut.hold(before, &curves);
            }
            if cut.is_on_path() || cut.is_off(before) { wanted } else { wanted.max(LEAVE_RATE) }
        } else {
            cut.come_back(before);
            self.end_infeed(&mut cut, before, &curves, motion, out);
            let turns = cut.leave_out(before, &curves, self.is_steady, self.machine.feedback_delay_ticks);
            if let Some(lobe) = motion.plan.segments.get(self.segment).and_then(|own| own.lobe).filter(|_| turns > 0) {
                out.events.push(InterpolatorEvent::LeftOut { lobe, turns });
            }
            if cut.is_on_path() || cut.is_returning() { wanted } else { wanted.max(LEAVE_RATE) }
        };
        cut.set_rate(before, rate);
        let pose = cut.pose(tick, &curves, &self.machine, &AxisPose::at_rest(self.setpoint.counts));
        self.setpoint = pose.setpoint();
        self.mode = ExecutionMode::Cut(cut);
        if cut.is_done(tick) {
            let facts = motion.facts.get(self.segment).and_then(|facts| facts.spin);
            self.spin = facts.and_then(|facts| cut.spin(&curves, facts, &self.machine));
            self.begin(self.segment + 1, tick, motion, out);
        } else if cut.is_still(tick) && (self.alarm.is_some() || (self.cancel && rate == 0)) {
            self.rest();
            self.leaves_at_rest(tick, motion, out);
        }
    }

    /// Ends the infeed of a cut whose size the gauge has read, or raises an alarm where the whole infeed did not reach it.
    fn end_infeed(
        &mut self,
        cut: &mut CutExecution,
        before: u64,
        curves: &Curves<'_>,
        motion: &Prepared,
        out: &mut StepOutput,
    ) {
        let Some(size) = motion.facts.get(self.segment).and_then(|facts| facts.size) else { return };
        if cut.is_infeed_ended() {
            return;
        }
        if self.is_size_reached {
            let lobe = motion.plan.segments.get(self.segment).and_then(|own| own.lobe);
            let ended = cut.end_infeed(before, curves).zip(lobe);
            if let Some((end, lobe)) = ended {
                out.events.push(InterpolatorEvent::InfeedEnded(InfeedEnd { lobe, ..end }));
            }
        } else if cut.is_infeed_over(before, curves) {
            let (diameter_nm, turns) = (size.diameter_nm, curves.cut.infeed_turns);
            let alarm = InterpolatorAlarm::SizeNotReached { diameter_nm, turns };
            out.events.push(InterpolatorEvent::Alarm(alarm));
            self.alarm = Some(alarm.number());
        }
    }

    fn advance_trajectory(&mut self, mut clock: PathClock, tick: u64, motion: &Prepared, out: &mut StepOutput) {
        let stopping = self.hold || self.cancel || self.alarm.is_some() || self.following.broken.is_some();
        if tick < clock.begins() || (tick == clock.begins() && self.hold) {
            // It waits for its time, at rest.
            if !self.leaves_at_rest(tick, motion, out) {
                if self.hold {
                    clock.postpone(tick + 1);
                }
                self.mode = ExecutionMode::Trajectory(clock);
            }
            return;
        }
        let rate = if stopping { 0 } else { self.feed_override };
        clock.retarget(tick.saturating_sub(1), rate, motion.stop_ticks);
        let rest = AxisPose::at_rest(self.setpoint.counts);
        self.setpoint = trajectory_pose(&clock, tick, motion, &self.machine, &rest).setpoint();
        self.mode = ExecutionMode::Trajectory(clock);
        if clock.at(tick).tau >= whole(motion.ticks) {
            self.rest();
            self.mode = ExecutionMode::Settle;
            self.end_trajectory(tick);
            self.settle(tick, motion, out);
        } else if clock.is_stopped(tick) {
            self.rest();
            self.leaves_at_rest(tick, motion, out);
        }
    }

    /// At the end of a trajectory; the setpoints stay.
    fn settle(&mut self, tick: u64, motion: &Prepared, out: &mut StepOutput) {
        if !self.leaves_at_rest(tick, motion, out) && self.is_at_goal(motion) {
            self.begin(1, tick, motion, out);
        }
    }

    pub(super) fn curves<'a>(&self, motion: &'a Prepared) -> Option<Curves<'a>> {
        match &motion.plan.segments.get(self.segment)?.kind {
            SegmentKind::Cut(cut) => Curves::from_segment(&motion.plan, cut),
            _ => None,
        }
    }

    /// At rest: an alarm ends the motion, a cancel takes the wheel to safety and ends it.
    pub(super) fn leaves_at_rest(&mut self, tick: u64, motion: &Prepared, out: &mut StepOutput) -> bool {
        if let Some(spin) = self.spin.filter(|_| self.alarm.is_some() || self.cancel) {
            if !spin.is_stopped(tick) {
                return true;
            }
            self.put_spin(tick);
            self.rest();
            self.spin = None;
        }
        if let Some(number) = self.alarm {
            out.events.push(InterpolatorEvent::Finished(MotionOutcome::Failed(number)));
            self.mode = ExecutionMode::Fault;
            return true;
        }
        if let Some(broken) = self.following.broken {
            self.finish(MotionOutcome::OutOfTolerance(broken), out);
            return true;
        }
        if !self.cancel {
            return false;
        }
        let x = Axis::X.index();
        let away = motion.safe_x_counts.filter(|safe| *safe > self.setpoint.counts[x] && self.homed[x]);
        if let Some(target_counts) = away {
            let target = AxisTarget { axis: Axis::X, target_counts, limits: self.machine.axis(Axis::X).limits };
            if self.enter_line(&[target], Purpose::Retract, tick) == Ok(true) {
                return true;
            }
        }
        self.finish(MotionOutcome::Cancelled, out);
        true
    }

    fn finish(&mut self, outcome: MotionOutcome, out: &mut StepOutput) {
        self.mode = ExecutionMode::Idle;
        out.events.push(InterpolatorEvent::Finished(outcome));
    }

    /// An alarm of the interpolator's own, at rest; C that turns on comes to rest first.
    pub(super) fn fail(&mut self, alarm: InterpolatorAlarm, out: &mut StepOutput) {
        self.rest();
        out.events.push(InterpolatorEvent::Alarm(alarm));
        if self.spin.is_some() {
            self.alarm = self.alarm.or(Some(alarm.number()));
            self.mode = ExecutionMode::Ready;
            return;
        }
        out.events.push(InterpolatorEvent::Finished(MotionOutcome::Failed(alarm.number())));
        self.mode = ExecutionMode::Fault;
    }

    /// The last guard: no setpoint beyond a soft limit goes unnoticed, wherever it comes from.
    fn watch_soft_limits(&mut self, out: &mut StepOutput) {
        if self.alarm.is_some() || matches!(self.mode, ExecutionMode::Idle | ExecutionMode::Fault) {
            return;
        }
        for axis in Axis::ALL {
            let description = self.machine.axis(axis);
            let (counts, velocity) = (self.setpoint.counts[axis.index()], self.setpoint.velocity[axis.index()]);
            let Some((low, high)) = description.soft_limits else { continue };
            let (low, high) = (description.scale.counts(low), description.scale.counts(high));
            let outward = (counts < low && velocity < 0.0) || (counts > high && velocity > 0.0);
            if outward && self.homed[axis.index()] {
                let alarm = InterpolatorAlarm::SoftLimit { axis, counts, bound: if counts < low { low } else { high } };
                out.events.push(InterpolatorEvent::Alarm(alarm));
                self.alarm = Some(alarm.number());
            }
        }
    }
}

/// Axes of a trajectory at a tick.
pub(super) fn trajectory_pose(
    clock: &PathClock,
    tick: u64,
    motion: &Prepared,
    machine: &MachineDescription,
    rest: &AxisPose,
) -> AxisPose {
    let mut pose = *rest;
    let Some(trajectory) = &motion.trajectory else { return pose };
    let (time, cycle_s) = (clock.at(tick), machine.cycle_time_s());
    // At the end exactly there, though the last tick lies up to a cycle after the last point.
    let over = time.tau >= whole(motion.ticks);
    let at = if over { trajectory.duration_s() + cycle_s } else { to_ticks(time.tau) * cycle_s };
    for axis in Axis::ALL {
        let Some(law) = trajectory.law(axis) else { continue };
        pose.set_axis(axis, 0, &law.sample(at), &time, machine);
    }
    pose
}
