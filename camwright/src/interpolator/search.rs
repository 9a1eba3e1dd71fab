// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Searches for an edge of an input: of a job's plan, which return to it, of homing, which stop behind it, and probes, which stand off.

use super::{
    ExecutionMode, Interpolator, InterpolatorAlarm, InterpolatorEvent, Order, OrderKind, Prepared, ProbeOutcome,
    Purpose, StepOutput,
};
use crate::machine::description::{Axis, MotionLimits};
use crate::machine::setpoint::{Input, Latch};
use crate::motion::plan::{AxisTarget, HomeStep, SearchSignal, SegmentKind};

impl Interpolator {
    /// An edge ends the search in execution if it is the first of its input since the search began.
    pub(super) fn catch(&mut self, latch: Latch) {
        let asks = matches!(self.mode, ExecutionMode::Level { .. });
        let searching =
            asks || matches!(self.mode, ExecutionMode::Line(_, Purpose::Seek) | ExecutionMode::LastLook { .. });
        let Some((axis, input, rising)) = self.motion.as_deref().and_then(|motion| self.sought_in(motion)) else {
            return;
        };
        if searching
            && self.caught.is_none()
            && latch.rising == (rising || asks)
            && latch.tick >= self.segment_began
            && (axis, input) == (latch.axis, latch.input)
        {
            self.caught = Some(latch);
        }
    }

    pub(super) fn check_last(&mut self, until: u64, tick: u64, motion: &Prepared, out: &mut StepOutput) {
        if self.leaves_at_rest(tick, motion, out) || self.hold {
            return;
        }
        if self.caught.is_some() {
            self.return_to_edge(tick, motion, out);
        } else if tick >= until
            && let Some((axis, input, _)) = self.sought_in(motion)
        {
            if is_probe(motion, self.segment) {
                self.end_probe(ProbeOutcome::Missed, tick, motion, out);
                return;
            }
            self.fail(InterpolatorAlarm::NoEdge { axis, input }, out);
        }
    }

    /// Searched axis and input of the current segment; true if the input closes.
    fn sought_in(&self, motion: &Prepared) -> Option<(Axis, Input, bool)> {
        let input = motion.facts.get(self.segment)?.input?;
        match motion.plan.segments.get(self.segment)?.kind {
            SegmentKind::Search { axis, .. } => Some((axis, input, true)),
            SegmentKind::Home(HomeStep::Seek { axis, sought, .. } | HomeStep::Probe { axis, sought, .. }) => {
                Some((axis, input, sought == SearchSignal::Closing))
            }
            _ => None,
        }
    }

    pub(super) fn enter_home(
        &mut self,
        step: &HomeStep,
        tick: u64,
        out: &mut StepOutput,
    ) -> Result<bool, InterpolatorAlarm> {
        let delay = u64::from(self.machine.feedback_delay_ticks);
        match *step {
            HomeStep::Forget(axis) => {
                let until = tick + 2 * delay.max(1);
                out.orders.push(Order { tick: until, kind: OrderKind::LoseHome { axis } });
                self.mode = ExecutionMode::Command { until };
                Ok(true)
            }
            HomeStep::Here { axis, counts } => {
                self.references[axis.index()] = self.setpoint.counts[axis.index()] - counts;
                Ok(false)
            }
            HomeStep::Seek { sought: SearchSignal::OpeningIfClosed, .. } => {
                // The machine reports with the tick at which the zero was forgotten: the one before or this one.
                self.mode = ExecutionMode::Level { until: tick + delay + 1 };
                Ok(true)
            }
            HomeStep::Probe { input, .. } => {
                let until = tick + 2 * delay.max(1);
                out.orders.push(Order { tick: until, kind: OrderKind::Ask { input } });
                self.mode = ExecutionMode::Level { until: until + delay + 1 };
                Ok(true)
            }
            HomeStep::Seek { axis, travel_counts, limits, .. } => self.enter_seek(axis, travel_counts, limits, tick),
        }
    }

    pub(super) fn enter_seek(
        &mut self,
        axis: Axis,
        travel_counts: i64,
        limits: MotionLimits,
        tick: u64,
    ) -> Result<bool, InterpolatorAlarm> {
        let target_counts = self.setpoint.counts[axis.index()] + travel_counts;
        self.enter_line(&[AxisTarget { axis, target_counts, limits }], Purpose::Seek, tick)
    }

    /// A switch that was closed when the zero was forgotten is left first.
    pub(super) fn check_level(&mut self, until: u64, tick: u64, motion: &Prepared, out: &mut StepOutput) {
        if self.leaves_at_rest(tick, motion, out) || self.hold || tick < until {
            return;
        }
        let step = motion.plan.segments.get(self.segment).map(|segment| &segment.kind);
        match step {
            Some(SegmentKind::Home(HomeStep::Probe { axis, sought, travel_counts, limits, .. })) => {
                let is_closed = self.caught.take().is_some();
                if is_closed == (*sought == SearchSignal::Closing) {
                    self.end_probe(ProbeOutcome::AlreadyThere, tick, motion, out);
                } else if let Err(alarm) = self.enter_seek(*axis, *travel_counts, *limits, tick) {
                    self.fail(alarm, out);
                }
            }
            Some(SegmentKind::Home(HomeStep::Seek { axis, travel_counts, limits, .. }))
                if self.caught.take().is_some() =>
            {
                if let Err(alarm) = self.enter_seek(*axis, *travel_counts, *limits, tick) {
                    self.fail(alarm, out);
                }
            }
            _ => self.begin(self.segment + 1, tick, motion, out),
        }
    }

    /// A probe came to rest behind its edge.
    #[allow(clippy::too_many_arguments, reason = "what the step says, and what every step is given")]
    fn stand_off(
        &mut self,
        axis: Axis,
        latch: Latch,
        stand_off: Option<(i64, MotionLimits)>,
        reads: Option<(i64, i64)>,
        tick: u64,
        motion: &Prepared,
        out: &mut StepOutput,
    ) {
        let off = reads.map_or(0, |(reads, _)| reads - latch.counts);
        let is_near = reads.is_none_or(|(_, max)| off.abs() <= max);
        let correction = if is_near { off } else { 0 };
        self.references[axis.index()] = -correction;
        let probed =
            if is_near { ProbeOutcome::Found { latch, correction } } else { ProbeOutcome::TooFarOff { latch, off } };
        out.events.push(InterpolatorEvent::Probed(probed));
        let target = stand_off.map(|(away, limits)| AxisTarget { axis, target_counts: latch.counts + away, limits });
        match target.map_or(Ok(false), |target| self.enter_line(&[target], Purpose::Return, tick)) {
            Ok(true) => {}
            Ok(false) => self.begin(self.segment + 1, tick, motion, out),
            Err(alarm) => self.fail(alarm, out),
        }
    }

    /// A probe without an edge: nothing is corrected.
    fn end_probe(&mut self, probed: ProbeOutcome, tick: u64, motion: &Prepared, out: &mut StepOutput) {
        if let Some((axis, ..)) = self.sought_in(motion) {
            self.references[axis.index()] = 0;
        }
        out.events.push(InterpolatorEvent::Probed(probed));
        self.begin(self.segment + 1, tick, motion, out);
    }

    /// From where the search came to rest to the place relative to the edge.
    pub(super) fn return_to_edge(&mut self, tick: u64, motion: &Prepared, out: &mut StepOutput) {
        let (Some(latch), Some(segment)) = (self.caught, motion.plan.segments.get(self.segment)) else { return };
        if let SegmentKind::Home(HomeStep::Seek { axis, zero_counts, .. }) = &segment.kind {
            self.references[axis.index()] = latch.counts - zero_counts;
            self.begin(self.segment + 1, tick, motion, out);
            return;
        }
        if let SegmentKind::Home(HomeStep::Probe { axis, stand_off, reads, .. }) = &segment.kind {
            let (axis, stand_off, reads) = (*axis, *stand_off, *reads);
            self.stand_off(axis, latch, stand_off, reads, tick, motion, out);
            return;
        }
        let SegmentKind::Search { axis, offset_counts, limits, .. } = &segment.kind else { return };
        // The zero of `SetHome` is where the search stands: its edge and its offset.
        self.references[axis.index()] = latch.counts + offset_counts;
        let target = AxisTarget { axis: *axis, target_counts: latch.counts + offset_counts, limits: *limits };
        match self.enter_line(&[target], Purpose::Return, tick) {
            Ok(true) => {}
            Ok(false) => self.begin(self.segment + 1, tick, motion, out),
            Err(alarm) => self.fail(alarm, out),
        }
    }
}

fn is_probe(motion: &Prepared, segment: usize) -> bool {
    let kind = motion.plan.segments.get(segment).map(|segment| &segment.kind);
    matches!(kind, Some(SegmentKind::Home(HomeStep::Probe { .. })))
}
