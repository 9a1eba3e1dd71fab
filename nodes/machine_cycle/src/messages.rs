// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Messages between the cyclic thread and the rest of the node.

use super::area_order::AreaOrder;
use super::keyframes::Room;
use super::outline::PartOutline;
use super::pacing::Slip;
use super::part::{BarRefused, LobeRefused, PartSnapshot, RawBar, RawLobe};
use super::stream_state::StreamState;
use camwright::machine::alarm::AlarmKind;
use camwright::machine::persistent_state::PersistentState;
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
    pub order: MachineOrder,
}

camwright::snapshot!(TimedCommand { sequence, tick, order } on {});

/// Effect of a command.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum MachineOrder {
    Machine(MachineCommand),
    JobBegin,
    #[default]
    JobEnd,
    /// A motion is about to begin.
    Attend,
}

camwright::snapshot_cases!(MachineOrder { 0 Machine(command), 1 JobBegin, 2 JobEnd, 3 Attend });

/// To the cyclic thread.
#[derive(Debug)]
pub enum Inbound {
    /// A chunk, from this writer.
    Chunk([u8; 16], Box<ChunkBuffer>),
    /// A malformed chunk from this writer.
    NoChunk([u8; 16]),
    Command([u8; 16], TimedCommand),
    Fault(Box<AskedFault>),
    Reset,
    Lobe(Box<RawLobe>),
    Bar(Box<RawBar>),
    Snapshot(Box<PartSnapshot>),
    Outline(Box<PartOutline>),
    Area(AreaOrder),
    /// Position of the loader; `lost`: it has fallen silent.
    Loader {
        inside: bool,
        lost: bool,
    },
    /// Judgement of the last part.
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

/// Input applied by the cyclic thread, in addition to the chunks and raw parts that it returns.
#[derive(Debug)]
pub enum CyclicInput {
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
    /// An order of the emergency stop is applied, and a tick has shown it.
    EStopDone,
    LobeDone(Result<(), LobeRefused>, Box<RawLobe>),
    BarDone(Result<(), BarRefused>, Box<RawBar>),
    Snapshot(Box<PartSnapshot>),
    Outline(Box<PartOutline>),
    AreaDone(AreaOrder, Result<(), LoadingRefused>),
    /// A refused chunk; the pump reports and drops it.
    Refused(ChunkError, [u8; 16], Box<ChunkBuffer>),
    /// A second writer sent a chunk; the holder stays.
    SecondWriter {
        holder: [u8; 16],
        refused: [u8; 16],
        chunk: Box<ChunkBuffer>,
    },
    /// A chunk that was taken, or got lost, to drop where dropping is allowed; and who sent it.
    Used([u8; 16], Box<ChunkBuffer>),
    Applied(CyclicInput),
    /// The machine's time slipped against the system clock, or was made up for.
    Slip(Slip),
    /// The bus to real drives does not answer any more, and why.
    DrivesLost(String),
    /// The job that was begun has ended; the part may be looked at.
    JobEnded,
    Lasting(PersistentState),
    /// State after the last reported tick.
    Keyframe(Box<Room>),
}
