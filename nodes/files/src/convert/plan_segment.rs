// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The steps of a plan as messages.

use super::plan_splines::SplineIds;
use super::{m_from_mm, si_from_core};
use camwright::machine::description::{Axis, MotionLimits};
use camwright::motion::plan::{AxisTarget, CutSegment, PlanCommand, Segment, SegmentKind, SpiralSegment};
use camwright_msgs::camwright_msgs::msg::{MachineCommand, PlanSegment};

/// A step as a message.
pub(super) fn segment_to(ids: SplineIds, index: u32, segment: &Segment) -> PlanSegment {
    let base = PlanSegment {
        index,
        phase: segment.phase as u8,
        lobe: segment.lobe.and_then(|lobe| i32::try_from(lobe).ok()).unwrap_or(PlanSegment::NO_LOBE),
        label: segment.label.clone(),
        ticks: segment.ticks,
        stop_ticks: segment.stop_ticks,
        stock_at_start: m_from_mm(segment.stock_mm),
        ..PlanSegment::default()
    };
    match &segment.kind {
        SegmentKind::Move(targets) => move_to(base, targets),
        SegmentKind::Search { axis, input, travel_counts, offset_counts, limits } => PlanSegment {
            kind: PlanSegment::SEARCH,
            target_counts: vec![*travel_counts, *offset_counts],
            input: input.clone(),
            ..with_limits(base, &[(*axis, *limits)])
        },
        // No plan of a job has one; a receiver refuses it.
        SegmentKind::Home(_) => PlanSegment { kind: 0, ..base },
        SegmentKind::Cut(cut) => cut_to(base, ids, cut),
        SegmentKind::Spiral(spiral) => spiral_to(base, ids, spiral),
        SegmentKind::Dwell => PlanSegment { kind: PlanSegment::DWELL, ..base },
        SegmentKind::Wait => PlanSegment { kind: PlanSegment::WAIT, ..base },
        SegmentKind::Command(command) => command_to(base, command),
    }
}

fn move_to(base: PlanSegment, targets: &[AxisTarget]) -> PlanSegment {
    let limits: Vec<_> = targets.iter().map(|target| (target.axis, target.limits)).collect();
    PlanSegment {
        kind: PlanSegment::MOVE,
        target_counts: targets.iter().map(|target| target.target_counts).collect(),
        ..with_limits(base, &limits)
    }
}

/// Adds joints and their limits.
fn with_limits(base: PlanSegment, axes: &[(Axis, MotionLimits)]) -> PlanSegment {
    let si = |limit: fn(&MotionLimits) -> f64| axes.iter().map(|(axis, own)| si_from_core(*axis, limit(own))).collect();
    PlanSegment {
        joints: axes.iter().map(|(axis, _)| axis.joint().to_owned()).collect(),
        velocity: si(|limits| limits.velocity),
        acceleration: si(|limits| limits.acceleration),
        jerk: si(|limits| limits.jerk),
        ..base
    }
}

fn cut_to(base: PlanSegment, ids: SplineIds, cut: &CutSegment) -> PlanSegment {
    PlanSegment {
        kind: PlanSegment::CUT,
        path: ids.path(cut.path),
        speed: ids.time_law(cut.speed),
        infeed: ids.angle_law(cut.infeed),
        ratio: ids.ratio(cut.ratio),
        lead: ids.optional_time_law(cut.lead),
        start_counts: cut.start_counts,
        path_start: cut.path_start_rad,
        turns: f64::from(cut.turns),
        infeed_turns: f64::from(cut.infeed_turns),
        plateau_start: cut.plateau_s.0,
        plateau_end: cut.plateau_s.1,
        turn_time: cut.turn_s,
        retract: m_from_mm(cut.retract_mm),
        hold: m_from_mm(cut.hold_mm),
        until_steady: cut.until_steady_n.map_or(0.0, f64::from),
        velocity: cut.variation.map_or_else(Vec::new, |variation| vec![variation.slower, variation.period_turns]),
        ..base
    }
}

fn spiral_to(base: PlanSegment, ids: SplineIds, spiral: &SpiralSegment) -> PlanSegment {
    PlanSegment {
        kind: PlanSegment::SPIRAL,
        path: ids.angle_law(spiral.path),
        speed: ids.time_law(spiral.speed),
        infeed: ids.angle_law(spiral.advance),
        start_counts: spiral.start_counts,
        ..base
    }
}

fn command_to(base: PlanSegment, command: &PlanCommand) -> PlanSegment {
    let (command, target, target_counts) = match command {
        PlanCommand::SetHome(axis) => (MachineCommand::SET_HOME, axis.joint(), vec![]),
        PlanCommand::WheelStart => (MachineCommand::WHEEL_START, "", vec![]),
        PlanCommand::WheelStop => (MachineCommand::WHEEL_STOP, "", vec![]),
        PlanCommand::ExpectWheel { radius_nm } => (MachineCommand::EXPECT_WHEEL, "", vec![*radius_nm]),
        PlanCommand::ChangeWheel { wheel } => (MachineCommand::CHANGE_WHEEL, "", vec![i64::from(*wheel)]),
        PlanCommand::Dress { radius_nm } => (MachineCommand::DRESS, "", vec![*radius_nm]),
        PlanCommand::Push { max_n } => (MachineCommand::PUSH, "", vec![*max_n]),
        PlanCommand::WatchForce { max_n } => (MachineCommand::WATCH_FORCE, "", vec![*max_n]),
        PlanCommand::WatchSize(size) => (MachineCommand::WATCH_SIZE, "", vec![size.diameter_nm, size.beyond_nm]),
    };
    PlanSegment { kind: PlanSegment::COMMAND, command, target: target.to_owned(), target_counts, ..base }
}
