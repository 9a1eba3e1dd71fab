// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Status of the interpolator, from its state and the motion in execution.

use super::path_time::to_ticks;
use super::spiral::Spiral;
use super::{ExecutionMode, ExecutionState, Interpolator, InterpolatorStatus, Prepared, Purpose, SearchStep};
use crate::machine::description::Axis;
use crate::math::units::TURN_RAD;
use crate::motion::plan::{HomeStep, Phase, SegmentKind};

impl Interpolator {
    fn state(&self) -> ExecutionState {
        let tick = self.tick;
        match self.mode {
            ExecutionMode::Idle => return ExecutionState::Idle,
            ExecutionMode::Fault => return ExecutionState::Fault,
            _ if self.cancel || self.alarm.is_some() => return ExecutionState::Stopping,
            _ => {}
        }
        let (rests, disturbed) = match &self.mode {
            ExecutionMode::Line(line, purpose) => {
                let found = *purpose == Purpose::Seek && self.caught.is_some();
                (line.is_stopped(tick), line.is_stopping() && !found)
            }
            ExecutionMode::Cut(cut) => (cut.is_off(tick), !cut.is_on_path()),
            ExecutionMode::Trajectory(clock) if tick < clock.begins() => (true, false),
            ExecutionMode::Trajectory(clock) | ExecutionMode::Spiral(Spiral { clock, .. }) => {
                (clock.is_stopped(tick), clock.is_stopped(tick) && self.feed_override > 0)
            }
            ExecutionMode::Command { .. } => (false, false),
            _ => (true, false),
        };
        match (self.hold, rests, disturbed) {
            (true, true, _) => ExecutionState::Held,
            (true, false, _) => ExecutionState::Holding,
            (false, _, true) => ExecutionState::Unholding,
            (false, _, false) => ExecutionState::Executing,
        }
    }

    /// Status while nothing is executed: the override of the next motion, and whether the axes are homed.
    #[must_use]
    pub fn idle_status(&self) -> InterpolatorStatus {
        let InterpolatorStatus { feed_override, homed, .. } = self.status(None);
        InterpolatorStatus { feed_override, homed, ..InterpolatorStatus::default() }
    }

    pub(super) fn status(&self, motion: Option<&Prepared>) -> InterpolatorStatus {
        let mut status = InterpolatorStatus {
            state: self.state(),
            segment: self.segment,
            feed_override: to_ticks(self.feed_override),
            homed: self.homed,
            ..InterpolatorStatus::default()
        };
        let Some(motion) = motion else { return status };
        if matches!(self.mode, ExecutionMode::Idle) {
            status.percent = 100.0;
            return status;
        }
        let done = self.ticks_done(motion);
        let all = motion.ticks as f64;
        status.percent = if all > 0.0 { (100.0 * done / all).clamp(0.0, 100.0) } else { 0.0 };
        status.time_left_s = (all - done).max(0.0) * self.machine.cycle_time_s();
        let Some(segment) = motion.plan.segments.get(self.segment) else { return status };
        status.phase = Some(segment.phase);
        status.lobe = segment.lobe;
        status.stock_mm = segment.stock_mm;
        if let (ExecutionMode::Cut(cut), Some(curves)) = (&self.mode, self.curves(motion)) {
            let (turn, angle) = cut.progress(self.tick, &curves);
            status.turn = turn;
            status.turns = f64::from(curves.cut.turns);
            status.stock_mm = (segment.stock_mm - cut.infed_mm(angle.max(0.0), &curves)).max(0.0);
            if angle < 0.0 {
                status.phase = Some(Phase::Approach);
            } else if angle > f64::from(curves.cut.turns) * TURN_RAD {
                status.phase = Some(Phase::Retract);
            } else if segment.phase == Phase::Cut && angle >= f64::from(curves.cut.infeed_turns) * TURN_RAD {
                status.phase = Some(Phase::SparkOut);
            }
        }
        if let (ExecutionMode::Spiral(spiral), Some(curves)) = (&self.mode, self.spiral_motion(motion)) {
            status.turn = spiral.turns_done(self.tick, &curves, self.machine.cycle_time_s());
            status.turns = curves.angle_rad() / TURN_RAD;
        }
        status.search = self.search_step(&segment.kind);
        status
    }

    fn search_step(&self, kind: &SegmentKind) -> Option<(Axis, SearchStep)> {
        match kind {
            SegmentKind::Search { axis, .. } => match self.mode {
                ExecutionMode::Line(_, Purpose::Seek) if self.caught.is_some() => Some((*axis, SearchStep::Stop)),
                ExecutionMode::Line(_, Purpose::Seek) | ExecutionMode::LastLook { .. } => {
                    Some((*axis, SearchStep::Search))
                }
                ExecutionMode::Line(_, Purpose::Return) => Some((*axis, SearchStep::Return)),
                _ => None,
            },
            SegmentKind::Home(HomeStep::Seek { axis, .. } | HomeStep::Probe { axis, .. }) => {
                if matches!(self.mode, ExecutionMode::Line(_, Purpose::Return)) {
                    return Some((*axis, SearchStep::Return));
                }
                let is_found = self.caught.is_some() && !matches!(self.mode, ExecutionMode::Level { .. });
                Some((*axis, if is_found { SearchStep::Stop } else { SearchStep::Search }))
            }
            SegmentKind::Command(crate::motion::plan::PlanCommand::SetHome(axis)) => Some((*axis, SearchStep::Latch)),
            _ => None,
        }
    }

    /// Completed share of the predicted ticks.
    fn ticks_done(&self, motion: &Prepared) -> f64 {
        if let ExecutionMode::Trajectory(clock) = &self.mode {
            return to_ticks(clock.at(self.tick).tau);
        }
        let (Some(facts), Some(segment)) = (motion.facts.get(self.segment), motion.plan.segments.get(self.segment))
        else {
            return motion.ticks as f64;
        };
        let length = segment.ticks as f64;
        let varies = matches!(&segment.kind, SegmentKind::Cut(cut) if cut.variation.is_some());
        let within = match &self.mode {
            ExecutionMode::Line(line, Purpose::Move) => line.share(self.tick) * length,
            ExecutionMode::Cut(cut) if varies => cut.ticks_done(self.tick) / cut.length_ticks() * length,
            ExecutionMode::Cut(cut) => cut.ticks_done(self.tick),
            ExecutionMode::Spiral(spiral) => to_ticks(spiral.clock.at(self.tick).tau),
            ExecutionMode::Dwell { left } => length - *left as f64,
            ExecutionMode::Starting | ExecutionMode::Ready | ExecutionMode::Wait => 0.0,
            _ => self.tick.saturating_sub(self.segment_began) as f64,
        };
        facts.ticks_before as f64 + within.min(length)
    }
}
