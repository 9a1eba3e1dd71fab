//! What passes between the cyclic thread and the rest of the node.

use super::area_order::AreaOrder;
use super::keyframes::Room;
use super::outline::Outline;
use super::pacing::Slip;
use super::part::{BarRefused, LobeRefused, RawBar, RawLobe, Snapshot};
use super::stream_state::StreamState;
use camwright::machine::alarm::AlarmKind;
use camwright::machine::persistent_state::LastingState;
use camwright::simulation::buffer::ChunkError;
use camwright::simulation::fault::Fault;
use camwright::simulation::tick_report::TickReport;
use camwright::simulation::work_area::LoadingRefused;
use camwright::simulation::{MachineCommand, ResetRefused};
use camwright_files::convert::setpoints::ChunkBuffer;
use camwright_msgs::camwright_msgs::srv::InjectFaultRequest;

/// An order with its place in the sender's sequence and the tick at which it takes effect.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TimedCommand {
    pub sequence: u32,
    pub tick: u64,
    pub order: Order,
}

camwright::kept!(TimedCommand { sequence, tick, order } on {});

/// What a command does.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Order {
    Machine(MachineCommand),
    JobBegin,
    #[default]
    JobEnd,
    /// A motion is about to begin.
    Attend,
}

camwright::kept_cases!(Order { 0 Machine(command), 1 JobBegin, 2 JobEnd, 3 Attend });

/// To the cyclic thread.
#[derive(Debug)]
pub enum Inbound {
    /// A chunk, from this writer.
    Chunk([u8; 16], Box<ChunkBuffer>),
    /// What is no chunk, from this writer.
    NoChunk([u8; 16]),
    Command([u8; 16], TimedCommand),
    Fault(Box<AskedFault>),
    Reset,
    Lobe(Box<RawLobe>),
    Bar(Box<RawBar>),
    Snapshot(Box<Snapshot>),
    Outline(Box<Outline>),
    Area(AreaOrder),
    /// Where the loader says it is; `lost`: it has ceased to say anything.
    Loader {
        inside: bool,
        lost: bool,
    },
    /// What the last part was found to be.
    Judge(bool),
    ResetShift,
    Active(bool),
    /// Something was refused for want of authority.
    NoAuthority,
    /// Feedback could not be sent for so long (s).
    Blocked(f64),
    /// The room of a keyframe comes back.
    Room(Box<Room>),
}

/// A fault, and how it was asked for.
#[derive(Debug)]
pub struct AskedFault {
    pub fault: Fault,
    /// When: now (0), or at this tick of the next job, its first being 1.
    pub job_tick: u64,
    pub request: InjectFaultRequest,
}

/// What the cyclic thread has taken, besides what it answers with what it was given: chunks and raw parts.
#[derive(Debug)]
pub enum Taken {
    NoChunk([u8; 16]),
    Command([u8; 16], TimedCommand),
    Fault(Box<AskedFault>),
    Reset,
    Area(AreaOrder),
    Loader {
        inside: bool,
        lost: bool,
    },
    Judge(bool),
    ResetShift,
    /// The node ends or is not active, and no chunk is taken any more.
    Close,
    /// The node is active again.
    Open,
    /// An alarm that does not come from the machine itself, and its value.
    Alarm(AlarmKind, f64),
}

/// From the cyclic thread.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "ticks are nearly all of the traffic; a box would allocate")]
pub enum Outbound {
    Tick(TickReport, StreamState),
    ResetDone(Result<(), ResetRefused>),
    LobeDone(Result<(), LobeRefused>, Box<RawLobe>),
    BarDone(Result<(), BarRefused>, Box<RawBar>),
    Snapshot(Box<Snapshot>),
    Outline(Box<Outline>),
    AreaDone(AreaOrder, Result<(), LoadingRefused>),
    /// A chunk was refused; the pump tells and drops it.
    Refused(ChunkError, [u8; 16], Box<ChunkBuffer>),
    /// A second writer sent a chunk; the holder stays.
    SecondWriter {
        holder: [u8; 16],
        refused: [u8; 16],
        chunk: Box<ChunkBuffer>,
    },
    /// A chunk that was taken, or got lost, to drop where dropping is allowed; and who sent it.
    Used([u8; 16], Box<ChunkBuffer>),
    Taken(Taken),
    /// The machine's time slipped against the system clock, or was made up for.
    Slip(Slip),
    /// The job that was begun has ended; the part may be looked at.
    JobEnded,
    Lasting(LastingState),
    /// The state after the last tick that was told.
    Keyframe(Box<Room>),
}
