//! What passes between the engine and the node around it, through rings.

use crate::convert::setpoints::ChunkBuffer;
use camwright::interpolator::trajectory::Start;
use camwright::interpolator::{AppliedInput, Event, Motion, Order, Outcome, Prepared, Request, StartError, Status};
use camwright::machine::description::AXIS_COUNT;
use camwright::setpoint::{Latch, Measured, Setpoint};

/// What the machine told.
#[derive(Debug, Default)]
pub(super) struct News {
    pub(super) tick: u64,
    pub(super) credit_tick: u64,
    pub(super) is_standstill: bool,
    /// Its ticks follow the clock.
    pub(super) is_realtime: bool,
    pub(super) commands_received: u32,
    pub(super) alarms: Vec<u16>,
    pub(super) setpoint_counts: [i64; AXIS_COUNT],
    /// What the encoders read, at the ticks at which every machine tells it.
    pub(super) measured: Option<Measured>,
    pub(super) latches: Vec<Latch>,
}

/// Where the trajectory in execution will be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Foresight {
    /// At this tick, where the engine now waits for what takes its place.
    At(u64, Start),
    /// It is over by then, or about to end.
    Over,
    /// It is held.
    Disturbed,
}

/// How the axes follow what they were told, at one tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tracking {
    pub(super) told: Setpoint,
    pub(super) measured: Measured,
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
            Motion::Trajectory(_)
            | Motion::Home(_)
            | Motion::Move(_)
            | Motion::Probe(_)
            | Motion::Jog(_)
            | Motion::Wheel(_) => Self::default(),
        }
    }
}

/// To the engine.
#[derive(Debug)]
pub(super) enum ToEngine {
    News(Box<News>),
    Start {
        motion: Box<Prepared>,
        job: JobEnds,
    },
    Request(Request),
    /// A trajectory wants to take the place of the one in execution, no sooner than at a tick: where will that be?
    Foresee {
        soonest: u64,
    },
    /// What takes the place, where it was foreseen.
    Splice(Box<Prepared>),
    /// Nothing does.
    StayOn,
    /// What the axes are told at a tick.
    Query {
        tick: u64,
    },
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
#[derive(Debug, Clone, Copy, PartialEq)]
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
    Foreseen(Foresight),
    /// Another trajectory has begun at this tick in the place of the one before.
    Spliced {
        tick: u64,
    },
    NotSpliced(StartError, Box<Prepared>),
    Tracking(Tracking),
    Queried(Option<Setpoint>),
    /// To drop where dropping is allowed.
    Used(Box<News>),
    Done(Box<Prepared>),
}
