// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Participants, topics and measurements that the checks share.

use rustdds::no_key::{DataReader, DataWriter};
use rustdds::policy::{Durability, History, Reliability};
use rustdds::{DomainParticipant, DomainParticipantBuilder, QosPolicies, QosPolicyBuilder, Topic, TopicKind};
use std::fmt::Display;
use std::net::{IpAddr, Ipv4Addr};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// End of every wait.
pub(crate) const PATIENCE: Duration = Duration::from_secs(8);

/// Result of a check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Verdict {
    Pass,
    /// The defect exists, with the observation that shows it.
    Fail(String),
}

pub(crate) type Checked = Result<Verdict, String>;
pub(crate) type Outcome = Result<(), String>;

impl Verdict {
    pub(crate) fn pass_if(passed: bool, seen: impl FnOnce() -> String) -> Self {
        if passed { Verdict::Pass } else { Verdict::Fail(seen()) }
    }
}

pub(crate) fn text(error: impl Display) -> String {
    error.to_string()
}

/// A participant of the loopback interface in domain `ROS_DOMAIN_ID` (default 0).
pub(crate) fn participant() -> Result<DomainParticipant, String> {
    let domain = std::env::var("ROS_DOMAIN_ID").ok().and_then(|value| value.parse().ok()).unwrap_or(0);
    let builder = DomainParticipantBuilder::new(domain).with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)]);
    builder.build().map_err(text)
}

/// Reliable and volatile, with this depth.
pub(crate) fn qos(depth: i32) -> QosPolicies {
    QosPolicyBuilder::new()
        .reliability(Reliability::Reliable { max_blocking_time: rustdds::Duration::from_secs(1) })
        .durability(Durability::Volatile)
        .history(History::KeepLast { depth })
        .build()
}

pub(crate) fn topic(participant: &DomainParticipant, name: &str, depth: i32) -> Result<Topic, String> {
    participant.create_topic(name.into(), "upstream::Octets".into(), &qos(depth), TopicKind::NoKey).map_err(text)
}

pub(crate) fn writer(participant: &DomainParticipant, name: &str, depth: i32) -> Result<DataWriter<Vec<u8>>, String> {
    let topic = topic(participant, name, depth)?;
    let publisher = participant.create_publisher(&qos(depth)).map_err(text)?;
    publisher.create_datawriter_no_key_cdr(&topic, None).map_err(text)
}

pub(crate) fn reader(participant: &DomainParticipant, name: &str, depth: i32) -> Result<DataReader<Vec<u8>>, String> {
    let topic = topic(participant, name, depth)?;
    let subscriber = participant.create_subscriber(&qos(depth)).map_err(text)?;
    subscriber.create_datareader_no_key_cdr(&topic, None).map_err(text)
}

/// Length of the next sample, waiting at most this time.
pub(crate) fn take(reader: &mut DataReader<Vec<u8>>, patience: Duration) -> Result<Option<usize>, String> {
    wait(patience, || match reader.take_next_sample() {
        Ok(sample) => sample.map(|sample| Ok(sample.value().len())),
        Err(error) => Some(Err(text(error))),
    })
    .transpose()
}

/// Polls until there is a result or the time is over.
pub(crate) fn wait<T>(patience: Duration, mut poll: impl FnMut() -> Option<T>) -> Option<T> {
    let deadline = Instant::now() + patience;
    loop {
        let result = poll();
        if result.is_some() || Instant::now() > deadline {
            return result;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Writes one octet until the reader has received one, then takes the rest.
pub(crate) fn connect(writer: &DataWriter<Vec<u8>>, reader: &mut DataReader<Vec<u8>>) -> Outcome {
    let deadline = Instant::now() + PATIENCE;
    while Instant::now() < deadline {
        writer.write(vec![0], None).map_err(text)?;
        if take(reader, Duration::from_millis(100))?.is_some() {
            writer.wait_for_acknowledgments(PATIENCE).map_err(text)?;
            while take(reader, Duration::from_millis(100))?.is_some() {}
            return Ok(());
        }
    }
    Err(format!("no result: writer and reader did not match within {PATIENCE:?}"))
}

/// A field of /proc/self/status in kB: `VmRSS`, or `VmHWM` for the maximum so far.
pub(crate) fn memory_kb(field: &str) -> Result<u64, String> {
    let status = std::fs::read_to_string("/proc/self/status").map_err(text)?;
    let line = status.lines().find_map(|line| line.strip_prefix(field)?.strip_prefix(':'));
    line.and_then(|line| line.trim().strip_suffix(" kB")?.parse().ok())
        .ok_or(format!("no {field} in /proc/self/status"))
}

/// Growth of the largest memory since a measurement (kB), once it exceeds a bound; an action comes before each look.
pub(crate) fn memory_growth(
    before_kb: u64,
    above_kb: u64,
    patience: Duration,
    mut act: impl FnMut() -> Option<()>,
) -> Option<u64> {
    wait(patience, || {
        act()?;
        memory_kb("VmHWM").ok().map(|now| now - before_kb).filter(|grown| *grown > above_kb)
    })
}

static PANICS: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Records panics of all threads instead of printing them.
pub(crate) fn record_panics() {
    std::panic::set_hook(Box::new(|panic| {
        PANICS.lock().unwrap_or_else(PoisonError::into_inner).push(panic.to_string().replace('\n', " "));
    }));
}

pub(crate) fn first_panic() -> Option<String> {
    PANICS.lock().unwrap_or_else(PoisonError::into_inner).first().cloned()
}
