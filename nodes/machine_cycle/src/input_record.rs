// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Recorded inputs of the machine, as messages and back.

use super::output_digest::{RangeDigest, chunk_digest};
use super::part::{RawBar, RawLobe};
use super::persistent_record::PersistentRecord;
use camwright::machine::alarm::AlarmKind;
use camwright_files::convert::setpoints::ChunkBuffer;
use camwright_files::digest;
use camwright_files::record_text::record_text as text;
use camwright_msgs::camwright_msgs::msg::{MachineInput, PartLobe};
use camwright_msgs::camwright_msgs::srv::{InjectFaultRequest, LoadLobeRequest};
use serde::{Deserialize, Serialize};

/// Start of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BeginRecord {
    /// Form of the inputs.
    pub format: u32,
    /// Version of the program, for people: whether another computes otherwise is seen when it does.
    pub version: String,
    pub machine_hash: String,
    pub lasting: PersistentRecord,
    /// Bus to real drives; absent: they were simulated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drives: Option<String>,
}

/// Form of the inputs: it grows when what they say or how they are taken becomes something else, so that they cannot be taken again.
pub const FORMAT: u32 = 1;

pub const VERSION: &str = env!("CARGO_PKG_VERSION");

pub fn chunk_message(writer: [u8; 16], chunk: &ChunkBuffer) -> MachineInput {
    let (number, digest) = (chunk.first_tick, chunk_digest(chunk));
    MachineInput { kind: MachineInput::CHUNK, writer, number, digest, ..MachineInput::default() }
}

pub fn lobe_message(lobe: &RawLobe) -> MachineInput {
    let mut without_radii = lobe.request.clone();
    let values = std::mem::take(&mut without_radii.lobe.radius);
    MachineInput { kind: MachineInput::LOBE, content: text(&without_radii), values, ..MachineInput::default() }
}

pub fn bar_message(bar: &RawBar) -> MachineInput {
    MachineInput { kind: MachineInput::BAR, content: text(&bar.request), ..MachineInput::default() }
}

/// A digest as a message.
pub fn digest_message(digest: &RangeDigest) -> MachineInput {
    let (number, digest) = (digest.job_ticks, digest.digest);
    MachineInput { kind: MachineInput::DIGEST, number, digest, ..MachineInput::default() }
}

/// Relevant part of a request for a lobe. Other fields are ignored, so a request may have more or fewer fields than today.
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
    /// Missing in records from before there were crank pins.
    #[serde(default)]
    centre: Vec<f64>,
}

/// Lobe of a message.
pub fn lobe_of(message: &MachineInput) -> Result<RawLobe, String> {
    let LobeRecord { clear, lobe } = record(&message.content)?;
    let RawOutline { name, station, width, key_way, centre } = lobe;
    let radius = message.values.clone();
    let lobe = PartLobe { name, station, width, key_way, radius, centre, ..PartLobe::default() };
    Ok(RawLobe::new(LoadLobeRequest { clear, lobe }))
}

/// Alarm of a message, and its value.
pub fn alarm_of(message: &MachineInput) -> Result<(AlarmKind, f64), String> {
    let kind = u16::try_from(message.number).ok().and_then(AlarmKind::from_number);
    let kind = kind.ok_or_else(|| format!("there is no alarm {}", message.number))?;
    let value = message.values.first().copied().filter(|value| value.is_finite());
    Ok((kind, value.ok_or_else(|| format!("alarm {} has no value", message.number))?))
}

/// The digest by which a message is known to be as it was made.
///
/// # Errors
/// A message that CDR cannot carry.
pub fn check(message: &MachineInput) -> Result<u64, String> {
    digest::message_digest(&MachineInput { check: 0, ..message.clone() })
}

/// The record that a text is.
pub fn record<'a, R: Deserialize<'a>>(text: &'a str) -> Result<R, String> {
    serde_json::from_str(text).map_err(|error| format!("what was recorded cannot be read: {error}"))
}

/// Version of the program that made a BEGIN.
pub fn version_of(begin: &MachineInput) -> Option<String> {
    record::<BeginRecord>(&begin.content).ok().map(|begun| begun.version)
}

/// Bus to the real drives of the machine that made a BEGIN; `None`: they were simulated, or the message is another.
pub fn drives_of(begin: &MachineInput) -> Option<String> {
    record::<BeginRecord>(&begin.content).ok().and_then(|begun| begun.drives)
}

/// Fault request of an emergency stop that is pressed or released.
pub fn estop_request(pressed: bool) -> InjectFaultRequest {
    InjectFaultRequest { fault: "estop".to_owned(), active: pressed, ..InjectFaultRequest::default() }
}

/// Name of a kind of input in messages.
pub fn kind_name(kind: u8) -> &'static str {
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
