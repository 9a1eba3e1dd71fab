// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Recorded data of a run, topic by topic; missing data stays empty and is never guessed.

use super::error::ReportError;
use camwright_bag::schema_evolution::SchemaChange;
use camwright_bag::{Bag, BagMessage, Topic};
use camwright_files::convert::time::{TickClock, ns_from_time};
use camwright_machine_cycle::bounds::BusTiming;
use camwright_machine_cycle::input_record::drives_of;
use camwright_msgs::camwright_msgs::msg::{
    Alarm, AppliedInput, FormMap, GaugeReading, InterpolatorState, JobFilePage, JobStatus, LobeForm, MachineAlarms,
    MachineDescription, MachineStream, PartLobe, PlanPage, RecorderStatus, TurnedPage,
};
use camwright_msgs::cdr::message_from_sample;
use camwright_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus};
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Topic of the diagnostics of all nodes, without its slash.
const DIAGNOSTICS: &str = "diagnostics";

/// A message with the time at which it was recorded (ns since 1970).
#[derive(Debug, Clone)]
pub(super) struct TimedMessage<T> {
    pub(super) ns: u64,
    pub(super) message: T,
}

#[derive(Debug, Clone)]
pub(super) struct StoredFile {
    pub(super) name: String,
    pub(super) bytes: u64,
    pub(super) sha256: String,
}

/// An alarm from its raising to its reset.
#[derive(Debug, Clone)]
pub(super) struct AlarmRecord {
    pub(super) alarm: Alarm,
    /// Tick of the first list without it.
    pub(super) gone: Option<u64>,
}

/// Messages of a topic that are missing by their numbers.
#[derive(Debug, Clone)]
pub(super) struct MessageGap {
    pub(super) topic: String,
    pub(super) missing: u64,
}

/// Timing of the bus to real drives, over all reports of the recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DriveTiming {
    /// Setpoints that waited: at least, and as a rule.
    pub(super) min_queued: u64,
    pub(super) queue_ticks: u64,
    pub(super) max_jitter_us: f64,
    pub(super) underruns: u64,
}

impl DriveTiming {
    /// `None`: the status has no such figures.
    fn from_status(status: &DiagnosticStatus) -> Option<Self> {
        let value = |key: &str| Some(status.values.iter().find(|pair| pair.key == key)?.value.as_str());
        Some(Self {
            // Empty while the drives did not follow.
            min_queued: value(BusTiming::MIN_QUEUED)?.parse().unwrap_or(u64::MAX),
            queue_ticks: value(BusTiming::QUEUE_TICKS)?.parse().ok()?,
            max_jitter_us: value(BusTiming::MAX_JITTER_US)?.parse().ok().filter(|us: &f64| us.is_finite())?,
            underruns: value(BusTiming::UNDERRUNS)?.parse().ok()?,
        })
    }

    fn and(self, later: Self) -> Self {
        Self {
            min_queued: self.min_queued.min(later.min_queued),
            max_jitter_us: self.max_jitter_us.max(later.max_jitter_us),
            underruns: self.underruns.max(later.underruns),
            ..later
        }
    }
}

/// Everything that was recorded, but for what is there a thousand times a second.
#[derive(Debug, Default)]
pub(super) struct RecordedRun {
    pub(super) name: String,
    pub(super) files: Vec<StoredFile>,
    pub(super) custom: BTreeMap<String, String>,
    pub(super) is_closed: bool,
    pub(super) span_ns: Option<(u64, u64)>,
    pub(super) messages: u64,
    pub(super) topics: usize,
    /// Name of the cell, with which its topics begin.
    pub(super) prefix: String,
    pub(super) clock: Option<TickClock>,
    pub(super) machines: Vec<TimedMessage<MachineDescription>>,
    pub(super) statuses: Vec<TimedMessage<JobStatus>>,
    pub(super) forms: Vec<TimedMessage<LobeForm>>,
    pub(super) parts: Vec<TimedMessage<PartLobe>>,
    pub(super) job_files: Vec<TimedMessage<JobFilePage>>,
    pub(super) pages: Vec<TimedMessage<PlanPage>>,
    pub(super) states: Vec<TimedMessage<InterpolatorState>>,
    pub(super) inputs: Vec<TimedMessage<AppliedInput>>,
    pub(super) alarms: Vec<AlarmRecord>,
    pub(super) gauge: Vec<TimedMessage<GaugeReading>>,
    pub(super) maps: Vec<TimedMessage<FormMap>>,
    pub(super) surface: Vec<TimedMessage<TurnedPage>>,
    /// Bus to real drives; `None`: they were simulated.
    pub(super) drives: Option<String>,
    pub(super) timing: Option<DriveTiming>,
    /// The first input of the machine was read.
    has_begun: bool,
    pub(super) recorder: Option<RecorderStatus>,
    pub(super) gaps: Vec<MessageGap>,
    /// Messages that could not be understood, by topic, with the first reason.
    pub(super) unread: BTreeMap<String, (u64, String)>,
}

impl RecordedRun {
    pub(super) fn from_bag(bag: &Bag) -> Result<Self, ReportError> {
        let mut recorded = Self {
            name: name_of(bag.path()),
            files: bag.files().iter().map(|file| stored(&file.path)).collect::<Result<_, _>>()?,
            custom: bag.custom_data().clone(),
            is_closed: bag.files().iter().all(|file| file.is_closed),
            span_ns: bag.log_times_ns(),
            messages: bag.message_counts().iter().sum(),
            topics: bag.message_counts().iter().filter(|count| **count > 0).count(),
            prefix: prefix_of(bag),
            ..Self::default()
        };
        let names: Vec<Option<String>> =
            bag.topics().iter().map(|t| recorded.name_in_cell(&t.name).map(str::to_owned)).collect();
        let mut highest: Vec<(u64, u64)> = vec![(0, 0); names.len()];
        let change = |topic: &Topic| {
            let ours = camwright_msgs::by_type_name(&topic.type_name);
            ours.map_or_else(SchemaChange::default, |ours| SchemaChange::since(topic, ours.schema))
        };
        let changes: Vec<SchemaChange> = bag.topics().iter().map(change).collect();
        let mut messages = bag.messages();
        while let Some(mut message) = messages.next_message()? {
            changes[message.topic].apply(&mut message.data);
            let seen = &mut highest[message.topic];
            *seen = (seen.0.max(u64::from(message.sequence)), seen.1 + 1);
            if let Some(name) = &names[message.topic] {
                recorded.add_message(name, &message);
            }
        }
        let gaps = bag.topics().iter().zip(&highest);
        recorded.gaps = gaps
            .filter(|(_, (last, seen))| last > seen)
            .map(|(topic, (last, seen))| MessageGap { topic: topic.name.clone(), missing: last - seen })
            .collect();
        Ok(recorded)
    }

    /// Name of a topic without the namespace of the cell; `None`: it is another cell's.
    fn name_in_cell<'a>(&self, topic: &'a str) -> Option<&'a str> {
        // All cells share this one.
        topic.strip_prefix(&self.prefix).or_else(|| topic.strip_prefix('/').filter(|name| *name == DIAGNOSTICS))
    }

    fn add_message(&mut self, name: &str, message: &BagMessage) {
        let outcome = match name {
            "machine/description" => push(&mut self.machines, message),
            "machine/stream" if self.clock.is_none() => self.add_stream(message),
            "machine/part" => push(&mut self.parts, message),
            "machine/gauge" => push(&mut self.gauge, message),
            "machine/turned_part" => push(&mut self.surface, message),
            "job_planner/job_status" => push(&mut self.statuses, message),
            "job_planner/job_files" => push(&mut self.job_files, message),
            "job_planner/lobe_forms" => push(&mut self.forms, message),
            "job_planner/plan" => push(&mut self.pages, message),
            "job_planner/form_map" => push(&mut self.maps, message),
            "axis_interpolator/state" => push(&mut self.states, message),
            "axis_interpolator/inputs" => push(&mut self.inputs, message),
            "machine/inputs" if !self.has_begun => self.begin(message),
            DIAGNOSTICS => message_from_sample(&message.data).map(|array| self.add_diagnostics(array)),
            "run_logger/status" => message_from_sample(&message.data).map(|message| self.recorder = Some(message)),
            "machine/alarms" | "axis_interpolator/alarms" => {
                message_from_sample(&message.data).map(|list| self.add_alarms(list))
            }
            _ => Ok(()),
        };
        if let Err(reason) = outcome {
            let unread = self.unread.entry(format!("{}{name}", self.prefix)).or_insert((0, reason));
            unread.0 += 1;
        }
    }

    /// Reads the first input of the machine, which names its drives.
    fn begin(&mut self, message: &BagMessage) -> Result<(), String> {
        self.has_begun = true;
        self.drives = drives_of(&message_from_sample(&message.data)?);
        Ok(())
    }

    fn add_diagnostics(&mut self, array: DiagnosticArray) {
        let of_drives = array.status.iter().filter(|status| status.name.ends_with(BusTiming::STATUS));
        for timing in of_drives.filter_map(DriveTiming::from_status) {
            self.timing = Some(self.timing.map_or(timing, |before| before.and(timing)));
        }
    }

    fn add_stream(&mut self, message: &BagMessage) -> Result<(), String> {
        let stream: MachineStream = message_from_sample(&message.data)?;
        if let Some(machine) = self.machines.first() {
            self.clock =
                Some(TickClock { epoch_ns: ns_from_time(&stream.epoch), cycle_time_ns: machine.message.cycle_time_ns });
        }
        Ok(())
    }

    /// Records alarms that are new in the list as raised, and missing ones as gone.
    fn add_alarms(&mut self, list: MachineAlarms) {
        let is = |a: &Alarm, b: &Alarm| (a.number, a.tick, &a.source) == (b.number, b.tick, &b.source);
        // Both nodes report the alarm that ended a motion: it is one alarm.
        let of_these = |record: &Alarm, list: &MachineAlarms| list.alarms.iter().any(|alarm| is(alarm, record));
        for record in self.alarms.iter_mut().filter(|record| record.gone.is_none()) {
            if !of_these(&record.alarm, &list) && record.alarm.tick <= list.tick && list.alarms.is_empty() {
                record.gone = Some(list.tick);
            }
        }
        for alarm in list.alarms {
            if !self.alarms.iter().any(|record| is(&record.alarm, &alarm)) {
                self.alarms.push(AlarmRecord { alarm, gone: None });
            }
        }
    }

    /// Length of a tick (s); none where no machine was received.
    pub(super) fn cycle_s(&self) -> Option<f64> {
        self.clock.map(|clock| f64::from(clock.cycle_time_ns) * 1e-9)
    }
}

fn push<T: DeserializeOwned>(into: &mut Vec<TimedMessage<T>>, message: &BagMessage) -> Result<(), String> {
    into.push(TimedMessage { ns: message.log_time_ns, message: message_from_sample(&message.data)? });
    Ok(())
}

/// Namespace of the cell's topics: that of the first machine or planner in the bag.
fn prefix_of(bag: &Bag) -> String {
    let named = ["machine/description", "job_planner/job_status"];
    let of = |ending: &str| {
        bag.topics().iter().find_map(|topic| topic.name.strip_suffix(ending).filter(|start| start.ends_with('/')))
    };
    named.into_iter().find_map(of).unwrap_or("/").to_owned()
}

fn name_of(path: &Path) -> String {
    let whole = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    whole.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

fn stored(path: &Path) -> Result<StoredFile, ReportError> {
    let failed = |source| ReportError::Io { action: "read", path: path.to_owned(), source };
    let mut file = File::open(path).map_err(failed)?;
    let (mut hasher, mut bytes, mut buffer) = (Sha256::new(), 0, vec![0; 1 << 16]);
    loop {
        let read = file.read(&mut buffer).map_err(failed)?;
        if read == 0 {
            break;
        }
        bytes += read as u64;
        hasher.update(&buffer[..read]);
    }
    let sha256 = hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    Ok(StoredFile { name: name_of(path), bytes, sha256 })
}
