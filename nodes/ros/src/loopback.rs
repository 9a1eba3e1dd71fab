//! A node hears itself.
//!
//! `RustDDS` matches a participant's writer with a reader of the same participant only sometimes (in 3 of 4 trials the writer never
//! learned of the reader), so what stays within a node is delivered here, and what DDS brings of it is ignored. A node that records
//! its own log or calls its own service needs this.

use std::{
    collections::{HashMap, VecDeque},
    fmt,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use rustdds::{GUID, bytes::Bytes};

use super::discovery::Graph;
use super::qos::{Durability, History, Qos, Reliability};
use super::sample_info::SampleInfo;
use camwright_threads::system_time::system_time_ns;

/// Hands a body to a reader, on the executor thread.
pub(super) type Deliver = Box<dyn Fn(Bytes, SampleInfo) + Send>;

struct LocalReader {
    guid: GUID,
    type_name: String,
    qos: Qos,
    deliver: Deliver,
}

struct LocalWriter {
    guid: GUID,
    type_name: String,
    qos: Qos,
    written: i64,
    history: VecDeque<(Bytes, SampleInfo)>,
}

impl LocalWriter {
    fn suits(&self, reader: &LocalReader) -> bool {
        let (offered, asked) = (&self.qos, &reader.qos);
        self.type_name == reader.type_name
            && (offered.reliability == Reliability::Reliable || asked.reliability == Reliability::BestEffort)
            && (offered.durability == Durability::TransientLocal || asked.durability == Durability::Volatile)
    }

    /// Samples kept for readers that come later.
    fn depth(&self) -> usize {
        match (self.qos.durability, self.qos.history) {
            (Durability::Volatile, _) => 0,
            (Durability::TransientLocal, History::KeepLast(depth)) => depth as usize,
            (Durability::TransientLocal, History::KeepAll) => 1000,
        }
    }
}

#[derive(Default)]
struct LocalTopic {
    readers: Vec<LocalReader>,
    writers: Vec<LocalWriter>,
}

/// A node's own endpoints, by DDS topic.
pub(super) struct Loopback {
    topics: Mutex<HashMap<String, LocalTopic>>,
    graph: Arc<Graph>,
}

impl fmt::Debug for Loopback {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Loopback").finish_non_exhaustive()
    }
}

/// One of the node's endpoints; dropping it forgets it.
#[derive(Debug)]
pub(super) struct LocalEndpoint {
    loopback: Arc<Loopback>,
    topic: String,
    guid: GUID,
}

impl Loopback {
    pub(super) fn new(graph: &Arc<Graph>) -> Arc<Self> {
        Arc::new(Loopback { topics: Mutex::default(), graph: Arc::clone(graph) })
    }

    fn topics(&self) -> MutexGuard<'_, HashMap<String, LocalTopic>> {
        self.topics.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn add_reader(
        self: &Arc<Self>,
        topic: &str,
        type_name: &str,
        qos: &Qos,
        guid: GUID,
        deliver: Deliver,
    ) -> LocalEndpoint {
        let reader = LocalReader { guid, type_name: type_name.to_string(), qos: *qos, deliver };
        let mut topics = self.topics();
        let local = topics.entry(topic.to_string()).or_default();
        let mut matches = Vec::new();
        for writer in local.writers.iter().filter(|writer| writer.suits(&reader)) {
            matches.push((writer.guid, guid));
            if qos.durability == Durability::TransientLocal {
                for (body, info) in &writer.history {
                    (reader.deliver)(body.clone(), *info);
                }
            }
        }
        local.readers.push(reader);
        drop(topics);
        self.graph.add_local(guid, topic, type_name, qos, false, &matches);
        LocalEndpoint { loopback: Arc::clone(self), topic: topic.to_string(), guid }
    }

    pub(super) fn add_writer(self: &Arc<Self>, topic: &str, type_name: &str, qos: &Qos, guid: GUID) -> LocalEndpoint {
        let writer =
            LocalWriter { guid, type_name: type_name.to_string(), qos: *qos, written: 0, history: VecDeque::new() };
        let mut topics = self.topics();
        let local = topics.entry(topic.to_string()).or_default();
        let matches: Vec<_> =
            local.readers.iter().filter(|reader| writer.suits(reader)).map(|reader| (guid, reader.guid)).collect();
        local.writers.push(writer);
        drop(topics);
        self.graph.add_local(guid, topic, type_name, qos, true, &matches);
        LocalEndpoint { loopback: Arc::clone(self), topic: topic.to_string(), guid }
    }
}

impl LocalEndpoint {
    /// Returns true if [`LocalEndpoint::write`] would store or deliver a body.
    pub(super) fn wants_bodies(&self) -> bool {
        let topics = self.loopback.topics();
        topics.get(&self.topic).is_some_and(|local| {
            !local.readers.is_empty()
                || local.writers.iter().any(|writer| writer.guid == self.guid && writer.depth() > 0)
        })
    }

    /// Delivers a sample that was just written over DDS to the node's own readers.
    pub(super) fn write(&self, body: Option<Bytes>, related: Option<(GUID, i64)>) {
        let mut topics = self.loopback.topics();
        let Some(local) = topics.get_mut(&self.topic) else { return };
        let Some(writer) = local.writers.iter_mut().find(|writer| writer.guid == self.guid) else { return };
        writer.written += 1;
        let Some(body) = body else { return };
        let now_ns = system_time_ns();
        let info = SampleInfo {
            writer: self.guid,
            number: writer.written,
            source_ns: Some(now_ns),
            received_ns: now_ns,
            related,
        };
        for reader in local.readers.iter().filter(|reader| writer.suits(reader)) {
            (reader.deliver)(body.clone(), info);
        }
        let depth = writer.depth();
        if depth > 0 {
            while writer.history.len() >= depth {
                writer.history.pop_front();
            }
            writer.history.push_back((body, info));
        }
    }
}

impl Drop for LocalEndpoint {
    fn drop(&mut self) {
        let mut topics = self.loopback.topics();
        let mut dropped = None;
        if let Some(local) = topics.get_mut(&self.topic) {
            if let Some(index) = local.readers.iter().position(|reader| reader.guid == self.guid) {
                dropped = Some(local.readers.swap_remove(index));
            }
            local.writers.retain(|writer| writer.guid != self.guid);
            if local.readers.is_empty() && local.writers.is_empty() {
                topics.remove(&self.topic);
            }
        }
        drop(topics);
        // What a callback owns may be an endpoint itself.
        drop(dropped);
        self.loopback.graph.remove_local(self.guid);
    }
}
