// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! State of the cell in one word, with an explanation; active alarms.

use super::cell_snapshot::{CellSnapshot, SILENCE};
use camwright::motion::plan::Phase;
use camwright_files::convert::plan::{phase_from, phase_name};
use camwright_msgs::camwright_msgs::msg::{Alarm, InterpolatorState, JobStatus, MachineStream};
use serde::Serialize;
use std::time::{Duration, Instant};

/// Time in which the nodes of a cell may still appear.
const STARTING: Duration = Duration::from_secs(10);

/// Emphasis of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Tone {
    Neutral,
    Active,
    /// Success.
    Good,
    /// Waiting for a person or a node.
    Attention,
    Error,
}

/// A word with an explanation.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(super) struct StatusLine {
    pub(super) word: String,
    pub(super) detail: String,
    pub(super) tone: Tone,
}

impl StatusLine {
    pub(super) fn new(tone: Tone, word: &str, detail: impl Into<String>) -> Self {
        Self { word: word.to_uppercase(), detail: detail.into(), tone }
    }
}

/// Alarms that stop motion, the machine's first.
pub(super) fn stopping(snapshot: &CellSnapshot) -> impl Iterator<Item = &Alarm> {
    alarms(snapshot).filter(|alarm| alarm.severity >= Alarm::STOP)
}

/// Every active alarm once: the interpolator repeats those of the machine that ended its motion.
pub(super) fn alarms(snapshot: &CellSnapshot) -> impl Iterator<Item = &Alarm> {
    let machine_alarms = || snapshot.machine_alarms.iter().flatten();
    let of_machine = move |number: u16| machine_alarms().any(|alarm| alarm.active && alarm.number == number);
    let own = snapshot.interpolator_alarms.iter().filter(move |alarm| !of_machine(alarm.number));
    machine_alarms().chain(own).filter(|alarm| alarm.active)
}

/// Line for the state of the cell.
pub(super) fn state(snapshot: &CellSnapshot, now: Instant) -> StatusLine {
    if snapshot.has_ended {
        return job_line(snapshot).unwrap_or_else(|| StatusLine::new(Tone::Neutral, "ended", "the run has ended"));
    }
    let is_silent = |at: Instant| now.saturating_duration_since(at) > SILENCE;
    let is_new = snapshot.since.is_some_and(|since| now.saturating_duration_since(since) < STARTING);
    if is_new && (snapshot.stream.is_none() || snapshot.interpolator.is_none()) {
        return StatusLine::new(Tone::Neutral, "starting", "waiting for the nodes of the cell");
    }
    let Some(stream) = snapshot.stream.as_ref().filter(|stream| !is_silent(stream.at)) else {
        let namespace = if snapshot.namespace.is_empty() { "/" } else { &snapshot.namespace };
        return StatusLine::new(Tone::Error, "no machine", format!("no message from a machine in {namespace}"));
    };
    if snapshot.io.as_ref().is_some_and(|io| io.estop) {
        return StatusLine::new(Tone::Error, "emergency stop", "release it, then reset");
    }
    if let Some(alarm) = stopping(snapshot).next() {
        return StatusLine::new(Tone::Error, &format!("alarm {}", alarm.number), alarm.text.clone());
    }
    let Some(interpolator) = snapshot.interpolator.as_ref().filter(|state| !is_silent(state.at)) else {
        return StatusLine::new(Tone::Error, "no interpolator", "no message from the axis interpolator");
    };
    moving(&interpolator.message).or_else(|| job_line(snapshot)).unwrap_or_else(|| {
        let at_rest = stream.message.motion != MachineStream::MOTION_OFF;
        if at_rest {
            let detail = if interpolator.message.is_homed { "no job" } else { "no job; the axes are not homed" };
            StatusLine::new(Tone::Neutral, "ready", detail)
        } else {
            StatusLine::new(Tone::Attention, "drives off", "the drives have no power; reset")
        }
    })
}

fn moving(state: &InterpolatorState) -> Option<StatusLine> {
    Some(match state.state {
        InterpolatorState::EXECUTING => {
            let (word, detail) = phase_from(state.phase).map_or(("moving", ""), phase_words);
            StatusLine::new(Tone::Active, word, detail)
        }
        InterpolatorState::HOLDING => StatusLine::new(Tone::Attention, "holding", "coming to a hold on the path"),
        InterpolatorState::HELD => StatusLine::new(Tone::Attention, "held", "continues when the hold is released"),
        InterpolatorState::UNHOLDING => StatusLine::new(Tone::Active, "unholding", "returning to the path"),
        InterpolatorState::STOPPING => StatusLine::new(Tone::Attention, "stopping", "cancelled: coming to rest"),
        InterpolatorState::FAULT => StatusLine::new(Tone::Error, "fault", "stopped by an alarm"),
        _ => return None,
    })
}

fn phase_words(phase: Phase) -> (&'static str, &'static str) {
    match phase {
        Phase::Home => ("homing", "looking for the origin"),
        Phase::Index => ("indexing", "the table moves to the lobe's station"),
        Phase::Cut => ("cutting", "generation with infeed"),
        Phase::SparkOut => ("spark-out", "generation without infeed"),
        other => (phase_name(other), ""),
    }
}

fn job_line(snapshot: &CellSnapshot) -> Option<StatusLine> {
    let job = snapshot.job.as_ref()?;
    let word = |tone, word: &str| Some(StatusLine::new(tone, word, job.message.clone()));
    match job.state {
        JobStatus::PLANNING => word(Tone::Active, "planning"),
        JobStatus::EXECUTING => word(Tone::Active, "executing"),
        JobStatus::STOPPING => word(Tone::Attention, "stopping"),
        JobStatus::COMPLETE => word(Tone::Good, "complete"),
        JobStatus::STOPPED => word(Tone::Attention, "stopped"),
        JobStatus::ABORTED => word(Tone::Error, "aborted"),
        _ => None,
    }
}
