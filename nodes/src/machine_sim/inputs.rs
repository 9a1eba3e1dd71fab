//! What the machine was given, told in the order in which its cyclic thread took it: `machine/inputs`.
//!
//! The cyclic thread only hands on what it took; tick and digests are made here, in the pump, which sees ticks and inputs in their order.

use super::commands;
use super::lasting_record::LastingRecord;
use super::output_digest::{OutputDigest, Told, of_chunk};
use super::part::{RawBar, RawLobe};
use super::pump::StreamState;
use super::traffic::{Outbound, Taken};
use crate::convert::setpoints::ChunkBuffer;
use crate::convert::time::TickClock;
use crate::digest;
use crate::record_text::record_text as text;
use crate::ros::{Node, Publisher, Qos, RosError};
use camwright::machine::alarm::AlarmKind;
use camwright::machine::description::MachineDescription;
use camwright::machine::persistent_state::LastingState;
use camwright::simulation::tick_report::TickReport;
use camwright_msgs::camwright_msgs::msg::{MachineInput, MachineKeyframe, PartLobe};
use camwright_msgs::camwright_msgs::srv::{InjectFaultRequest, LoadLobeRequest};
use serde::{Deserialize, Serialize};

/// Inputs that a late reader still gets: a recorder that comes when the machine runs already.
const DEPTH: u32 = 4000;

/// What a run begins with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BeginRecord {
    /// Form of the inputs.
    pub(crate) format: u32,
    /// Version of the program, for people: whether another computes otherwise is seen when it does.
    pub(crate) version: String,
    pub(crate) machine_hash: String,
    pub(crate) lasting: LastingRecord,
}

/// Form of the inputs: it grows when what they say or how they are taken becomes something else, so that they cannot be taken again.
pub(crate) const FORMAT: u32 = 1;

/// This program.
pub(crate) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The topic.
#[derive(Debug)]
pub(super) struct InputOutlet {
    publisher: Publisher<MachineInput>,
    machine: MachineDescription,
    clock: TickClock,
    sequence: u64,
    tick: u64,
    digest: OutputDigest,
}

impl InputOutlet {
    pub(super) fn new(node: &Node, machine: &MachineDescription, clock: TickClock) -> Result<Self, RosError> {
        let publisher = node.publisher("machine/inputs", &Qos::latched(DEPTH))?;
        let (machine, digest) = (machine.clone(), OutputDigest::default());
        Ok(Self { publisher, machine, clock, sequence: 0, tick: 0, digest })
    }

    /// The machine begins.
    pub(super) fn begin(&mut self, lasting: &LastingState) -> Result<(), RosError> {
        let (version, machine_hash) = (VERSION.to_owned(), self.machine.hash.clone());
        let content =
            text(&BeginRecord { format: FORMAT, version, machine_hash, lasting: LastingRecord::from(lasting) });
        self.publish(MachineInput { kind: MachineInput::BEGIN, content, ..MachineInput::default() })
    }

    /// A tick was executed.
    pub(super) fn tick(&mut self, report: &TickReport, state: &StreamState) -> Result<(), RosError> {
        self.tick = report.tick;
        let told = self.digest.take(report, state);
        told.into_iter().flatten().try_for_each(|told| self.publish(digest_message(&told)))
    }

    /// Of which tick a keyframe is that comes now.
    pub(super) fn head(&self) -> MachineKeyframe {
        let (digest, job_tick) = self.digest.parts();
        let (stamp, tick, sequence) = (self.clock.stamp(self.tick), self.tick, self.sequence);
        MachineKeyframe { stamp, tick, sequence, job_tick, digest, ..MachineKeyframe::default() }
    }

    /// Tells what of a report of the cyclic thread was an input.
    pub(super) fn see(&mut self, report: &Outbound) -> Result<(), RosError> {
        let message = match report {
            Outbound::Used(writer, chunk)
            | Outbound::Refused(_, writer, chunk)
            | Outbound::SecondWriter { refused: writer, chunk, .. } => chunk_message(*writer, chunk),
            Outbound::LobeDone(_, lobe) => lobe_message(lobe),
            Outbound::BarDone(_, bar) => bar_message(bar),
            Outbound::Taken(taken) => self.message(taken),
            _ => return Ok(()),
        };
        self.publish(message)
    }

    fn message(&self, taken: &Taken) -> MachineInput {
        let plain = |kind: u8| MachineInput { kind, ..MachineInput::default() };
        match taken {
            Taken::NoChunk(writer) => MachineInput { writer: *writer, ..plain(MachineInput::NO_CHUNK) },
            Taken::Command(writer, command) => {
                let content = text(&commands::message(command, &self.machine));
                MachineInput { writer: *writer, content, ..plain(MachineInput::COMMAND) }
            }
            Taken::Fault(asked) => MachineInput { content: text(&asked.request), ..plain(MachineInput::FAULT) },
            Taken::Reset => plain(MachineInput::RESET),
            Taken::Area(order) => {
                MachineInput { content: order.service().to_owned(), ..plain(MachineInput::WORK_AREA) }
            }
            Taken::Loader { inside, lost } => {
                let number = u64::from(*inside) + 2 * u64::from(*lost);
                MachineInput { number, ..plain(MachineInput::LOADER) }
            }
            Taken::Judge(is_good) => MachineInput { number: u64::from(*is_good), ..plain(MachineInput::JUDGE) },
            Taken::ResetShift => plain(MachineInput::RESET_SHIFT),
            Taken::Close => plain(MachineInput::CLOSE),
            Taken::Open => plain(MachineInput::OPEN),
            Taken::Alarm(kind, value) => {
                let number = u64::from(kind.entry().number);
                MachineInput { number, values: vec![*value], ..plain(MachineInput::ALARM) }
            }
        }
    }

    fn publish(&mut self, message: MachineInput) -> Result<(), RosError> {
        let (stamp, tick, sequence) = (self.clock.stamp(self.tick), self.tick, self.sequence);
        self.sequence += 1;
        let mut message = MachineInput { stamp, tick, sequence, ..message };
        message.check = check(&message).unwrap_or_default();
        self.publisher.publish(&message)
    }
}

fn chunk_message(writer: [u8; 16], chunk: &ChunkBuffer) -> MachineInput {
    let (number, digest) = (chunk.first_tick, of_chunk(chunk));
    MachineInput { kind: MachineInput::CHUNK, writer, number, digest, ..MachineInput::default() }
}

fn lobe_message(lobe: &RawLobe) -> MachineInput {
    let mut without_radii = lobe.request.clone();
    let values = std::mem::take(&mut without_radii.lobe.radius);
    MachineInput { kind: MachineInput::LOBE, content: text(&without_radii), values, ..MachineInput::default() }
}

fn bar_message(bar: &RawBar) -> MachineInput {
    MachineInput { kind: MachineInput::BAR, content: text(&bar.request), ..MachineInput::default() }
}

/// A digest as a message.
fn digest_message(told: &Told) -> MachineInput {
    let (number, digest) = (told.job_ticks, told.digest);
    MachineInput { kind: MachineInput::DIGEST, number, digest, ..MachineInput::default() }
}

/// What counts of a request for a lobe. What else it says of it is not looked at, and so may be more or less than a request says today.
#[derive(Debug, Deserialize)]
struct LobeRecord {
    clear: bool,
    lobe: RawOutline,
}

/// A raw outline without its radii.
#[derive(Debug, Deserialize)]
struct RawOutline {
    name: String,
    station: String,
    width: f64,
    key_way: f64,
}

/// The lobe that a message tells.
pub(super) fn lobe_of(message: &MachineInput) -> Result<RawLobe, String> {
    let LobeRecord { clear, lobe } = record(&message.content)?;
    let RawOutline { name, station, width, key_way } = lobe;
    let radius = message.values.clone();
    let lobe = PartLobe { name, station, width, key_way, radius, ..PartLobe::default() };
    Ok(RawLobe::new(LoadLobeRequest { clear, lobe }))
}

/// The alarm that a message tells, and its value.
pub(super) fn alarm_of(message: &MachineInput) -> Result<(AlarmKind, f64), String> {
    let kind = u16::try_from(message.number).ok().and_then(AlarmKind::from_number);
    let kind = kind.ok_or_else(|| format!("there is no alarm {}", message.number))?;
    let value = message.values.first().copied().filter(|value| value.is_finite());
    Ok((kind, value.ok_or_else(|| format!("alarm {} has no value", message.number))?))
}

/// The digest by which a message is known to be as it was made.
///
/// # Errors
/// A message that CDR cannot carry.
pub(crate) fn check(message: &MachineInput) -> Result<u64, String> {
    digest::of_message(&MachineInput { check: 0, ..message.clone() })
}

/// The record that a text is.
pub(crate) fn record<'a, R: Deserialize<'a>>(text: &'a str) -> Result<R, String> {
    serde_json::from_str(text).map_err(|error| format!("what was recorded cannot be read: {error}"))
}

/// Version of the program that made a BEGIN.
pub(crate) fn version_of(begin: &MachineInput) -> Option<String> {
    record::<BeginRecord>(&begin.content).ok().map(|begun| begun.version)
}

/// What is asked for by an emergency stop that is pressed or released.
pub(super) fn estop_request(pressed: bool) -> InjectFaultRequest {
    InjectFaultRequest { fault: "estop".to_owned(), active: pressed, ..InjectFaultRequest::default() }
}

/// What an input is called in the messages' own words.
pub(crate) fn kind_name(kind: u8) -> &'static str {
    match kind {
        MachineInput::BEGIN => "BEGIN",
        MachineInput::CHUNK => "CHUNK",
        MachineInput::NO_CHUNK => "NO_CHUNK",
        MachineInput::COMMAND => "COMMAND",
        MachineInput::FAULT => "FAULT",
        MachineInput::RESET => "RESET",
        MachineInput::LOBE => "LOBE",
        MachineInput::BAR => "BAR",
        MachineInput::WORK_AREA => "WORK_AREA",
        MachineInput::LOADER => "LOADER",
        MachineInput::JUDGE => "JUDGE",
        MachineInput::RESET_SHIFT => "RESET_SHIFT",
        MachineInput::CLOSE => "CLOSE",
        MachineInput::DIGEST => "DIGEST",
        MachineInput::ALARM => "ALARM",
        MachineInput::OPEN => "OPEN",
        _ => "an unknown input",
    }
}
