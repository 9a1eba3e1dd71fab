// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Messages between the engine and its node, through rings.

use camwright::interpolator::trajectory::TrajectoryStart;
use camwright::interpolator::{
    AppliedInput, InterpolatorEvent, InterpolatorStatus, MotionOutcome, MotionRequest, Order, Prepared, RestState,
    StartError,
};
use camwright::machine::description::{AXIS_COUNT, MachineDescription};
use camwright::machine::setpoint::{Latch, Measured, Setpoint};
use camwright::motion::plan::Plan;
use camwright_files::convert::motion_record::MotionRecord;
use camwright_files::convert::setpoints::ChunkBuffer;
use std::sync::Arc;

/// Feedback of the machine.
#[derive(Debug, Default)]
pub(super) struct MachineFeedback {
    pub(super) tick: u64,
    pub(super) credit_tick: u64,
    pub(super) is_standstill: bool,
    /// Its ticks follow the clock.
    pub(super) is_realtime: bool,
    pub(super) commands_received: u32,
    pub(super) alarms: Vec<u16>,
    pub(super) setpoint_counts: [i64; AXIS_COUNT],
    /// Encoder readings, at the ticks at which every machine reports them.
    pub(super) measured: Option<Measured>,
    pub(super) latches: Vec<Latch>,
}

/// Forecast of the trajectory in execution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum MotionForecast {
    /// At this tick, where the engine now waits for what takes its place.
    At(u64, TrajectoryStart),
    /// It is over by then, or about to end.
    Over,
    Disturbed,
}

/// Path following of the axes at one tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tracking {
    pub(super) setpoint: Setpoint,
    pub(super) measured: Measured,
}

/// True if a job begins and ends with a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct JobEnds {
    pub(super) begins: bool,
    pub(super) ends: bool,
}

impl JobEnds {
    /// Only a plan belongs to a job.
    pub(super) fn from_plan(plan: &Plan) -> Self {
        Self { begins: plan.half.begins(), ends: plan.half.ends() }
    }
}

/// A motion ready to be executed, and what it was made from, which is recorded when it begins.
#[derive(Debug)]
pub(super) struct PreparedMotion {
    pub(super) motion: Box<Prepared>,
    pub(super) record: Box<MotionRecord>,
}

impl PreparedMotion {
    /// Makes what is recorded, so that the record is what is executed. A plan is at hand where it is one.
    pub(super) fn new(
        record: MotionRecord,
        plan: Option<Arc<Plan>>,
        machine: &MachineDescription,
    ) -> Result<Self, String> {
        let plan = |hash: &str| plan.ok_or_else(|| format!("plan {hash} is not at hand"));
        let motion = Box::new(record.prepared(machine, plan)?);
        Ok(Self { motion, record: Box::new(record) })
    }
}

#[derive(Debug)]
pub(super) enum ToEngine {
    News(Box<MachineFeedback>),
    Start {
        made: PreparedMotion,
        job: JobEnds,
    },
    Request(MotionRequest),
    /// A trajectory wants to take the place of the one in execution, no sooner than at a tick: where will that be?
    Foresee {
        soonest: u64,
    },
    /// Replacement at the forecast tick.
    Splice(PreparedMotion),
    StayOn,
    /// Setpoints of the axes at a tick.
    Query {
        tick: u64,
    },
    Chunk(Box<ChunkBuffer>),
    /// The machine is silent, or another one answers in its place: what is under way is over.
    MachineLost,
}

/// An order as the machine takes it: with its number in the sequence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum SequencedCommand {
    Interpolator(Order),
    /// A motion is about to begin: at pace fast the machine lets no idle tick pass before its first setpoint.
    Attend {
        tick: u64,
    },
    JobBegin {
        tick: u64,
    },
    JobEnd {
        tick: u64,
    },
    /// An alarm that the interpolator found; the machine keeps it until it is reset.
    Alarm {
        tick: u64,
        number: u16,
    },
}

/// End of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ended {
    pub(super) outcome: MotionOutcome,
    pub(super) first_tick: u64,
    pub(super) last_tick: u64,
    /// Rest position of the axes.
    pub(super) counts: [i64; AXIS_COUNT],
}

#[derive(Debug)]
pub(super) enum FromEngine {
    Started {
        tick: u64,
        rest: RestState,
        record: Box<MotionRecord>,
    },
    NotStarted(StartError, PreparedMotion),
    Chunk(Box<ChunkBuffer>),
    Command {
        sequence: u32,
        command: SequencedCommand,
    },
    Applied {
        tick: u64,
        input: AppliedInput,
    },
    Status {
        tick: u64,
        status: InterpolatorStatus,
    },
    Event {
        tick: u64,
        event: InterpolatorEvent,
    },
    Ended(Ended),
    Foreseen(MotionForecast),
    /// Another trajectory has begun at this tick in the place of the one before.
    Spliced {
        tick: u64,
        record: Box<MotionRecord>,
    },
    NotSpliced(StartError, PreparedMotion),
    Tracking(Tracking),
    Queried(Option<Setpoint>),
    /// To drop where dropping is allowed.
    Used(Box<MachineFeedback>),
    Done(Box<Prepared>),
}
