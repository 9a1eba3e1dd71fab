// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Delivery within a node, and within a process.
//!
//! `RustDDS` does not match a participant's writer with a reader of the same participant (`UPSTREAM.md`, item 8), so messages and requests
//! of a node to itself are delivered here, and the node ignores what DDS brings of them. A node that records its own log or calls its own
//! service needs this.
//!
//! Nodes that share an [`IntraProcess`] deliver topics to each other in the same way. A volatile message that has no reader elsewhere is
//! then not written to DDS at all. A reader that lags behind keeps its reliable writers waiting, as over DDS. Services always use DDS.

use std::{
    collections::{BTreeSet, HashMap, VecDeque},
    fmt,
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
    time::{Duration, Instant},
};

use rustdds::{GUID, bytes::Bytes};

use super::discovery::{Graph, prefix};
use super::network::gate::Prefix;
use super::qos::{Durability, History, Qos, Reliability};
use super::sample_info::SampleInfo;
use camwright_threads::system_time::system_time_ns;

/// Maximum number of messages that a reader of another node of the process has not read yet; reliable writers then wait.
const MAX_UNREAD: usize = 4096;

/// Hands a body to a reader, on its executor thread; the count falls when it is read.
pub(super) type Deliver = Box<dyn Fn(Bytes, SampleInfo, Unread) + Send>;

/// Nodes of one process that deliver topics to each other without the network. Clones are the same.
#[derive(Clone, Default)]
pub(super) struct IntraProcess(Arc<Exchange>);

impl fmt::Debug for IntraProcess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("IntraProcess").finish_non_exhaustive()
    }
}

impl PartialEq for IntraProcess {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

#[derive(Default)]
struct Exchange {
    topics: Mutex<HashMap<String, LocalTopic>>,
    /// Participants of all nodes so far; one that has left may still have a message under way.
    members: Mutex<BTreeSet<Prefix>>,
    /// Signalled when a reader that was full has room.
    has_room: Condvar,
}

impl Exchange {
    fn topics(&self) -> MutexGuard<'_, HashMap<String, LocalTopic>> {
        self.topics.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn members(&self) -> MutexGuard<'_, BTreeSet<Prefix>> {
        self.members.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A message that is under way to a reader of this process.
pub(super) struct Unread {
    count: Arc<AtomicUsize>,
    exchange: Arc<Exchange>,
}

impl Unread {
    fn new(count: &Arc<AtomicUsize>, exchange: &Arc<Exchange>) -> Self {
        count.fetch_add(1, Ordering::AcqRel);
        Self { count: Arc::clone(count), exchange: Arc::clone(exchange) }
    }
}

impl Drop for Unread {
    fn drop(&mut self) {
        if self.count.fetch_sub(1, Ordering::AcqRel) == MAX_UNREAD {
            // Under the lock, so that a writer that has just found no room does not miss it.
            drop(self.exchange.topics());
            self.exchange.has_room.notify_all();
        }
    }
}

struct LocalReader {
    guid: GUID,
    type_name: String,
    qos: Qos,
    deliver: Deliver,
    unread: Arc<AtomicUsize>,
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

    /// Returns true if a reader is full. A node is never full for itself: it would wait for its own thread.
    fn keeps_waiting(&self, reader: &LocalReader) -> bool {
        reader.qos.reliability == Reliability::Reliable
            && reader.unread.load(Ordering::Acquire) >= MAX_UNREAD
            && self.suits(reader)
            && reader.guid.prefix != self.guid.prefix
    }
}

#[derive(Default)]
struct LocalTopic {
    readers: Vec<LocalReader>,
    writers: Vec<LocalWriter>,
}

/// Endpoints of a node, by DDS topic; those of topics together with the other nodes of the process.
pub(super) struct Loopback {
    own: Arc<Exchange>,
    shared: Option<Arc<Exchange>>,
    graph: Arc<Graph>,
}

impl fmt::Debug for Loopback {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Loopback").finish_non_exhaustive()
    }
}

/// One of the node's endpoints; dropping it forgets it.
pub(super) struct LocalEndpoint {
    exchange: Arc<Exchange>,
    graph: Arc<Graph>,
    topic: String,
    guid: GUID,
}

impl fmt::Debug for LocalEndpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LocalEndpoint").field("topic", &self.topic).finish_non_exhaustive()
    }
}

impl Loopback {
    /// Endpoints of the node with the participant of `own`.
    pub(super) fn new(graph: &Arc<Graph>, own: &GUID, process: Option<&IntraProcess>) -> Arc<Self> {
        let exchange = Arc::<Exchange>::default();
        let shared = process.map(|process| Arc::clone(&process.0));
        for exchange in [&exchange].into_iter().chain(&shared) {
            exchange.members().insert(prefix(own));
        }
        Arc::new(Loopback { own: exchange, shared, graph: Arc::clone(graph) })
    }

    fn exchange(&self, topic: &str) -> &Arc<Exchange> {
        self.shared.as_ref().filter(|_| topic.starts_with("rt/")).unwrap_or(&self.own)
    }

    pub(super) fn add_reader(
        &self,
        topic: &str,
        type_name: &str,
        qos: &Qos,
        guid: GUID,
        deliver: Deliver,
    ) -> LocalEndpoint {
        let reader = LocalReader { guid, type_name: type_name.to_string(), qos: *qos, deliver, unread: Arc::default() };
        let exchange = self.exchange(topic);
        let mut topics = exchange.topics();
        let local = topics.entry(topic.to_string()).or_default();
        let mut matches = Vec::new();
        for writer in local.writers.iter().filter(|writer| writer.suits(&reader)) {
            matches.push((writer.guid, guid));
            if qos.durability == Durability::TransientLocal {
                for (body, info) in &writer.history {
                    (reader.deliver)(body.clone(), *info, Unread::new(&reader.unread, exchange));
                }
            }
        }
        local.readers.push(reader);
        drop(topics);
        self.endpoint(topic, type_name, qos, guid, false, matches)
    }

    pub(super) fn add_writer(&self, topic: &str, type_name: &str, qos: &Qos, guid: GUID) -> LocalEndpoint {
        let writer =
            LocalWriter { guid, type_name: type_name.to_string(), qos: *qos, written: 0, history: VecDeque::new() };
        let mut topics = self.exchange(topic).topics();
        let local = topics.entry(topic.to_string()).or_default();
        let matches =
            local.readers.iter().filter(|reader| writer.suits(reader)).map(|reader| (guid, reader.guid)).collect();
        local.writers.push(writer);
        drop(topics);
        self.endpoint(topic, type_name, qos, guid, true, matches)
    }

    /// Adds an endpoint to the graph. Matches with other nodes are found by discovery.
    fn endpoint(
        &self,
        topic: &str,
        type_name: &str,
        qos: &Qos,
        guid: GUID,
        is_writer: bool,
        mut matches: Vec<(GUID, GUID)>,
    ) -> LocalEndpoint {
        matches.retain(|(writer, reader)| writer.prefix == reader.prefix);
        self.graph.add_local(guid, topic, type_name, qos, is_writer, &matches);
        let (exchange, graph) = (Arc::clone(self.exchange(topic)), Arc::clone(&self.graph));
        LocalEndpoint { exchange, graph, topic: topic.to_string(), guid }
    }
}

impl LocalEndpoint {
    /// Returns true if messages of the participant of `writer` on this topic arrive here, so that DDS repeats them.
    pub(super) fn delivers_from(&self, writer: &GUID) -> bool {
        self.exchange.members().contains(&prefix(writer))
    }

    /// Returns true if [`LocalEndpoint::write`] would store or deliver a body.
    pub(super) fn wants_bodies(&self) -> bool {
        let topics = self.exchange.topics();
        topics.get(&self.topic).is_some_and(|local| {
            !local.readers.is_empty()
                || local.writers.iter().any(|writer| writer.guid == self.guid && writer.depth() > 0)
        })
    }

    /// Waits until no reader of another node is full; false after `limit`.
    pub(super) fn wait_room(&self, limit: Duration) -> bool {
        let end = Instant::now() + limit;
        let mut topics = self.exchange.topics();
        loop {
            let is_full = topics.get(&self.topic).is_some_and(|local| {
                let writer = local.writers.iter().find(|writer| writer.guid == self.guid);
                writer.is_some_and(|writer| local.readers.iter().any(|reader| writer.keeps_waiting(reader)))
            });
            if !is_full {
                return true;
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            topics = self.exchange.has_room.wait_timeout(topics, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Returns true if DDS has to carry a message of this writer: it is kept for readers to come, or a reader is in another process.
    pub(super) fn needs_dds(&self, durability: Durability) -> bool {
        if durability != Durability::Volatile {
            return true;
        }
        let members = self.exchange.members();
        self.graph.ask(|matches| {
            let mut readers = matches.endpoints(&self.guid).peekable();
            // Until the first match is known, DDS may know one already.
            readers.peek().is_none() || readers.any(|reader| !members.contains(&prefix(reader)))
        })
    }

    /// Delivers a sample to the readers here.
    pub(super) fn write(&self, body: Option<Bytes>, related: Option<(GUID, i64)>) {
        let mut topics = self.exchange.topics();
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
            (reader.deliver)(body.clone(), info, Unread::new(&reader.unread, &self.exchange));
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
        let mut topics = self.exchange.topics();
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
        // A writer may wait for the reader that is gone.
        self.exchange.has_room.notify_all();
        // What a callback owns may be an endpoint itself.
        drop(dropped);
        self.graph.remove_local(self.guid);
    }
}
