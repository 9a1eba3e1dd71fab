//! What passes between the engine and the node around it, through rings.

use crate::convert::setpoints::ChunkBuffer;
use camwright::interpolator::{AppliedInput, Event, Motion, Order, Outcome, Prepared, Request, StartError, Status};
use camwright::machine::description::AXIS_COUNT;
use camwright::setpoint::Latch;

/// What the machine told.
#[derive(Debug, Default)]
pub(super) struct News {
    pub(super) tick: u64,
    pub(super) credit_tick: u64,
    pub(super) is_standstill: bool,
    pub(super) commands_received: u32,
    pub(super) alarms: Vec<u16>,
    pub(super) setpoint_counts: [i64; AXIS_COUNT],
    pub(super) latches: Vec<Latch>,
}

/// Whether a job begins and ends with a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct JobEnds {
    pub(super) begins: bool,
    pub(super) ends: bool,
}

impl JobEnds {
    /// Only a plan belongs to a job.
    pub(super) fn of(motion: &Motion) -> Self {
        match motion {
            Motion::Plan(plan) => Self { begins: plan.half.begins(), ends: plan.half.ends() },
            Motion::Trajectory(_) | Motion::Home(_) | Motion::Move(_) | Motion::Probe(_) => Self::default(),
        }
    }
}

/// To the engine.
#[derive(Debug)]
pub(super) enum ToEngine {
    News(Box<News>),
    Start { motion: Box<Prepared>, job: JobEnds },
    Request(Request),
    Chunk(Box<ChunkBuffer>),
}

/// An order as the machine takes it: with its number in the sequence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Command {
    Interpolator(Order),
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

/// How a motion went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ended {
    pub(super) outcome: Outcome,
    pub(super) first_tick: u64,
    pub(super) last_tick: u64,
    /// Where the axes rest.
    pub(super) counts: [i64; AXIS_COUNT],
}

/// From the engine.
#[derive(Debug)]
pub(super) enum FromEngine {
    Started {
        tick: u64,
    },
    NotStarted(StartError, Box<Prepared>),
    Chunk(Box<ChunkBuffer>),
    Command {
        sequence: u32,
        command: Command,
    },
    Applied {
        tick: u64,
        input: AppliedInput,
    },
    Status {
        tick: u64,
        status: Status,
    },
    Event {
        tick: u64,
        event: Event,
    },
    Ended(Ended),
    /// To drop where dropping is allowed.
    Used(Box<News>),
    Done(Box<Prepared>),
}
