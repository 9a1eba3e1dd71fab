// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Graph of the domain: endpoints, matches and node names, as discovery reports them.
//!
//! The participant's status events go to one reader only, so there is one participant per node and this is its only reader: that is
//! what the crate's own Spinner, which would take them away, is not used for.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt,
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use rustdds::{
    DomainParticipantStatusEvent, DomainParticipantStatusListener, EndpointDescription, GUID, StatusEvented,
    qos::QosPolicyId,
};

use super::fastdds_workarounds::FastDdsWorkarounds;
use super::matches::Matches;
use super::names;
use super::network::gate::{self, ParticipantGate, Prefix};
pub use super::participant_entities::Guid;
use super::participant_entities::{NodeEntities, ParticipantEntities};
use super::qos::Qos;

/// An endpoint on a topic.
#[derive(Debug, Clone, PartialEq)]
pub struct EndpointInfo {
    pub guid: Guid,
    /// Fully qualified name of its node, once that is known (it comes up to a second after the endpoint).
    pub node: Option<String>,
    /// Offered or requested profile.
    pub qos: Qos,
    /// The hash of its type (`RIHS01_…`), if it announces it: ROS 2 peers do, our own endpoints cannot.
    pub type_hash: Option<String>,
}

/// A topic with the endpoints that are known of it. Topics that two types are published on appear twice.
#[derive(Debug, Clone, PartialEq)]
pub struct TopicInfo {
    /// ROS name, `/cell/joint_states`.
    pub name: String,
    /// ROS type, `sensor_msgs/msg/JointState`.
    pub type_name: String,
    pub publishers: Vec<EndpointInfo>,
    pub subscriptions: Vec<EndpointInfo>,
}

pub(super) struct Endpoint {
    pub(super) topic: String,
    pub(super) type_name: String,
    qos: Qos,
    type_hash: Option<String>,
}

/// The hash among the data that an endpoint carries for its users: `typehash=RIHS01_…;`, behind their length.
fn type_hash(user_data: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(user_data.get(4..)?).ok()?;
    let hash = text.split(';').find_map(|pair| pair.strip_prefix("typehash="))?;
    hash.starts_with("RIHS01_").then(|| hash.to_owned())
}

impl From<&EndpointDescription> for Endpoint {
    fn from(description: &EndpointDescription) -> Self {
        Endpoint {
            topic: description.topic_name.clone(),
            type_name: description.type_name.clone(),
            qos: Qos::from_policies(&description.qos),
            type_hash: type_hash(&description.user_data),
        }
    }
}

#[derive(Default)]
struct DiscoveryState {
    /// Ours; what discovery says of its endpoints is known better from the loopback.
    own: Option<[u8; 12]>,
    writers: BTreeMap<GUID, Endpoint>,
    readers: BTreeMap<GUID, Endpoint>,
    /// With whom our endpoints are matched, and since when.
    matched: BTreeMap<GUID, BTreeMap<GUID, Instant>>,
    /// Matches announced before both of their ends were known here: ours, theirs.
    undecided: BTreeSet<(GUID, GUID)>,
    incompatible: Vec<String>,
    /// Pairs (ours, theirs) of which it has been said already that they do not fit.
    reported: BTreeSet<(GUID, GUID)>,
    nodes: BTreeMap<Guid, Vec<NodeEntities>>,
    /// Other participants that are present.
    participants: BTreeSet<Prefix>,
    /// Discovery has reported an endpoint of ours. Its reports come in order, and ours follow those of the participants that were met
    /// before our first endpoint.
    has_reported_own: bool,
}

type Listener = Arc<dyn Fn() + Send + Sync>;

/// A node's view of the graph.
#[derive(Default)]
pub(super) struct Graph {
    state: Mutex<DiscoveryState>,
    changed: Condvar,
    listeners: Mutex<Vec<(u64, Listener)>>,
    next_listener: AtomicU64,
}

impl fmt::Debug for Graph {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Graph").finish_non_exhaustive()
    }
}

impl Graph {
    fn state(&self) -> MutexGuard<'_, DiscoveryState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Learns the GUID of our participant.
    pub(super) fn set_own(&self, participant: GUID) {
        self.state().own = Some(prefix(&participant));
    }

    /// Adds one of our endpoints, with the matches among our own (writer, reader).
    pub(super) fn add_local(
        &self,
        guid: GUID,
        topic: &str,
        type_name: &str,
        qos: &Qos,
        is_writer: bool,
        matches: &[(GUID, GUID)],
    ) {
        let mut state = self.state();
        let endpoint =
            Endpoint { topic: topic.to_string(), type_name: type_name.to_string(), qos: *qos, type_hash: None };
        let endpoints = if is_writer { &mut state.writers } else { &mut state.readers };
        endpoints.insert(guid, endpoint);
        for (writer, reader) in matches {
            state.matched.entry(*writer).or_default().insert(*reader, Instant::now());
            state.matched.entry(*reader).or_default().insert(*writer, Instant::now());
        }
        state.decide(guid);
        drop(state);
        self.changed.notify_all();
    }

    /// Forgets one of our endpoints.
    pub(super) fn remove_local(&self, guid: GUID) {
        let mut state = self.state();
        state.writers.remove(&guid);
        state.readers.remove(&guid);
        state.matched.remove(&guid);
        state.undecided.retain(|(ours, _)| *ours != guid);
        state.forget(|other| *other == guid);
        drop(state);
        self.changed.notify_all();
    }

    /// Processes reports of discovery, the `early` ones first; returns warnings about endpoints that are incompatible with ours, and about a
    /// flood of participants.
    pub(super) fn drain(
        &self,
        early: Vec<DomainParticipantStatusEvent>,
        events: &DomainParticipantStatusListener,
        beside: &FastDdsWorkarounds,
        gate: &mut ParticipantGate,
    ) -> Vec<String> {
        let mut news = false;
        let mut sentences = Vec::new();
        for event in early.into_iter().chain(std::iter::from_fn(|| events.try_recv_status())) {
            sentences.extend(gate.admit(&event, || self.state().partners()));
            if let DomainParticipantStatusEvent::RemoteWriterMatched { local_reader, remote_writer } = &event {
                beside.writer_matched(local_reader, remote_writer);
            }
            news |= self.state().apply(event);
        }
        if news {
            self.notify();
        }
        sentences.append(&mut self.state().incompatible);
        sentences
    }

    /// Processes a participant's list of nodes.
    pub(super) fn participant(&self, participant: ParticipantEntities) {
        let mut state = self.state();
        if participant.nodes.is_empty() {
            state.nodes.remove(&participant.participant);
        } else {
            state.nodes.insert(participant.participant, participant.nodes);
        }
        drop(state);
        self.notify();
    }

    fn notify(&self) {
        self.changed.notify_all();
        let listeners: Vec<Listener> =
            self.listeners.lock().unwrap_or_else(PoisonError::into_inner).iter().map(|(_, l)| Arc::clone(l)).collect();
        for listener in listeners {
            listener();
        }
    }

    /// Calls `listener` on every change, on the executor thread.
    pub(super) fn on_change(self: &Arc<Self>, listener: impl Fn() + Send + Sync + 'static) -> GraphListener {
        let id = self.next_listener.fetch_add(1, Ordering::Relaxed);
        self.listeners.lock().unwrap_or_else(PoisonError::into_inner).push((id, Arc::new(listener)));
        GraphListener { graph: Arc::downgrade(self), id }
    }

    /// Waits until `condition` holds; needs the node's executor to run on another thread. Returns whether it holds.
    pub(super) fn wait_until(&self, timeout: Duration, condition: impl Fn(&Matches<'_>) -> bool) -> bool {
        let deadline = Instant::now() + timeout;
        let mut state = self.state();
        loop {
            if condition(&state.matches()) {
                return true;
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            // A match becomes reliable after a time.
            let moment = left.min(Duration::from_millis(50));
            state = self.changed.wait_timeout(state, moment).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Waits until every participant that runs already has said which nodes it has; see [`Graph::wait_until`].
    pub(super) fn wait_acquainted(&self, timeout: Duration) -> bool {
        let state = self.state();
        let waited = self.changed.wait_timeout_while(state, timeout, |state| !state.is_acquainted());
        waited.unwrap_or_else(PoisonError::into_inner).0.is_acquainted()
    }

    /// Asks something about matches.
    pub(super) fn ask<T>(&self, question: impl FnOnce(&Matches<'_>) -> T) -> T {
        question(&self.state().matches())
    }

    /// Returns true if a writer has this type; none while discovery has not reported it.
    pub(super) fn has_type(&self, writer: &GUID, dds_type: &str) -> Option<bool> {
        self.state().writers.get(writer).map(|endpoint| endpoint.type_name == dds_type)
    }

    /// Publishers and subscriptions of a topic (absolute ROS name).
    pub(super) fn counts(&self, topic: &str) -> (usize, usize) {
        let dds = names::dds_topic(topic);
        let state = self.state();
        let count = |endpoints: &BTreeMap<GUID, Endpoint>| endpoints.values().filter(|e| e.topic == dds).count();
        (count(&state.writers), count(&state.readers))
    }

    /// Publishers of a topic (absolute ROS name) outside this participant.
    pub(super) fn other_publishers(&self, topic: &str) -> Vec<EndpointInfo> {
        let dds = names::dds_topic(topic);
        let state = self.state();
        let others = state.writers.iter().filter(|(guid, e)| e.topic == dds && state.own != Some(prefix(guid)));
        others.map(|(guid, endpoint)| state.info(guid, endpoint)).collect()
    }

    /// The node of an endpoint, the nodes of its participant, or the GUID itself.
    pub(super) fn who(&self, guid: &Guid) -> String {
        let state = self.state();
        if let Some(node) = state.node_of(&GUID::from_bytes(*guid)) {
            return node;
        }
        let of_participant = state.nodes.iter().filter(|(participant, _)| participant[..12] == guid[..12]);
        let names: Vec<String> =
            of_participant.flat_map(|(_, nodes)| nodes).map(|node| names::join(&node.namespace, &node.name)).collect();
        if names.is_empty() {
            let octets: String = guid.iter().map(|octet| format!("{octet:02x}")).collect();
            return format!("an unknown node ({octets})");
        }
        names.join(" or ")
    }

    /// Returns true where a participant, or that of an endpoint, has said which nodes it has, and has not left.
    pub(super) fn knows_participant(&self, guid: &Guid) -> bool {
        self.state().nodes.keys().any(|participant| participant[..12] == guid[..12])
    }

    /// All topics, sorted by name and type.
    pub(super) fn topics(&self) -> Vec<TopicInfo> {
        let state = self.state();
        let mut topics: BTreeMap<(String, String), TopicInfo> = BTreeMap::new();
        for (endpoints, publishing) in [(&state.writers, true), (&state.readers, false)] {
            for (guid, endpoint) in endpoints {
                let Some(name) = names::ros_topic(&endpoint.topic) else { continue };
                let type_name = names::ros_type(&endpoint.type_name);
                let topic = topics.entry((name.to_string(), type_name.clone())).or_insert_with(|| TopicInfo {
                    name: name.to_string(),
                    type_name,
                    publishers: Vec::new(),
                    subscriptions: Vec::new(),
                });
                let info = state.info(guid, endpoint);
                if publishing { topic.publishers.push(info) } else { topic.subscriptions.push(info) }
            }
        }
        topics.into_values().collect()
    }

    /// All services that have a server, sorted by name, with the types of their requests.
    pub(super) fn services(&self) -> Vec<TopicInfo> {
        let state = self.state();
        let mut services: BTreeMap<String, TopicInfo> = BTreeMap::new();
        for (guid, endpoint) in &state.readers {
            let Some(name) = names::ros_service(&endpoint.topic) else { continue };
            let type_name = names::ros_type(&endpoint.type_name);
            let (publishers, subscriptions) = (Vec::new(), Vec::new());
            let empty = TopicInfo { name: name.to_string(), type_name, publishers, subscriptions };
            let service = services.entry(name.to_string()).or_insert(empty);
            service.subscriptions.push(state.info(guid, endpoint));
        }
        services.into_values().collect()
    }

    /// Fully qualified names of the nodes that are known.
    pub(super) fn nodes(&self) -> Vec<String> {
        let state = self.state();
        let mut nodes: Vec<String> =
            state.nodes.values().flatten().map(|node| names::join(&node.namespace, &node.name)).collect();
        nodes.sort();
        nodes
    }
}

impl DiscoveryState {
    /// Returns true if all participants that were met are known with their nodes.
    fn is_acquainted(&self) -> bool {
        let has_nodes = |met: &Prefix| self.nodes.keys().any(|participant| participant[..12] == *met);
        self.has_reported_own && self.participants.iter().all(has_nodes)
    }

    fn matches(&self) -> Matches<'_> {
        Matches { matched: &self.matched, nodes: &self.nodes, writers: &self.writers, readers: &self.readers }
    }

    /// Processes one event; returns true if it changed the graph.
    fn apply(&mut self, event: DomainParticipantStatusEvent) -> bool {
        let own = self.own;
        let ours = |guid: &GUID| own == Some(prefix(guid));
        match event {
            DomainParticipantStatusEvent::ReaderDetected { reader: EndpointDescription { guid, .. } }
            | DomainParticipantStatusEvent::WriterDetected { writer: EndpointDescription { guid, .. } }
            | DomainParticipantStatusEvent::RemoteReaderMatched { remote_reader: guid, .. }
            | DomainParticipantStatusEvent::RemoteWriterMatched { remote_writer: guid, .. }
            | DomainParticipantStatusEvent::ReaderLost { guid, .. }
            | DomainParticipantStatusEvent::WriterLost { guid, .. }
                if ours(&guid) =>
            {
                return !std::mem::replace(&mut self.has_reported_own, true);
            }
            DomainParticipantStatusEvent::ParticipantDiscovered { dpd } if !ours(&dpd.guid) => {
                self.participants.insert(gate::octets(dpd.guid.prefix));
            }
            DomainParticipantStatusEvent::ReaderDetected { reader } => {
                self.readers.insert(reader.guid, Endpoint::from(&reader));
                self.decide(reader.guid);
            }
            DomainParticipantStatusEvent::WriterDetected { writer } => {
                self.writers.insert(writer.guid, Endpoint::from(&writer));
                self.decide(writer.guid);
            }
            DomainParticipantStatusEvent::RemoteReaderMatched { local_writer, remote_reader } => {
                return self.add_match(local_writer, remote_reader);
            }
            DomainParticipantStatusEvent::RemoteWriterMatched { local_reader, remote_writer } => {
                return self.add_match(local_reader, remote_writer);
            }
            DomainParticipantStatusEvent::ReaderLost { guid, .. } => {
                self.readers.remove(&guid);
                self.forget(|other| *other == guid);
            }
            DomainParticipantStatusEvent::WriterLost { guid, .. } => {
                self.writers.remove(&guid);
                self.forget(|other| *other == guid);
            }
            DomainParticipantStatusEvent::ParticipantLost { id, .. } => {
                self.participants.remove(&gate::octets(id));
                self.readers.retain(|guid, _| guid.prefix != id);
                self.writers.retain(|guid, _| guid.prefix != id);
                self.nodes.retain(|participant, _| participant[..12] != *id.as_ref());
                self.forget(|other| other.prefix == id);
            }
            DomainParticipantStatusEvent::RemoteReaderQosIncompatible {
                local_writer,
                remote_reader,
                requested_qos,
                offered_qos,
            } => {
                let policy = offered_qos.compliance_failure_wrt(&requested_qos);
                self.report_misfit((local_writer, remote_reader), policy, false);
            }
            DomainParticipantStatusEvent::RemoteWriterQosIncompatible {
                local_reader,
                remote_writer,
                requested_qos,
                offered_qos,
            } => {
                let policy = offered_qos.compliance_failure_wrt(&requested_qos);
                self.report_misfit((local_reader, remote_writer), policy, true);
            }
            _ => return false,
        }
        true
    }

    /// Participants with an endpoint that matches one of ours, and our own.
    fn partners(&self) -> BTreeSet<Prefix> {
        let matched = self.matched.values().flat_map(BTreeMap::keys).map(prefix);
        matched.chain(self.own).collect()
    }

    fn forget(&mut self, gone: impl Fn(&GUID) -> bool) {
        for matches in self.matched.values_mut() {
            matches.retain(|other, _| !gone(other));
        }
        self.undecided.retain(|(_, theirs)| !gone(theirs));
        self.reported.retain(|(_, theirs)| !gone(theirs));
    }

    /// Adds a match that `RustDDS` made by topic and quality of service alone: it counts when both ends carry the same type, and waits
    /// until both are known. Returns whether it counts.
    fn add_match(&mut self, ours: GUID, theirs: GUID) -> bool {
        let endpoint = |guid: &GUID| self.writers.get(guid).or_else(|| self.readers.get(guid));
        let (Some(our), Some(their)) = (endpoint(&ours), endpoint(&theirs)) else {
            self.undecided.insert((ours, theirs));
            return false;
        };
        if our.type_name == their.type_name {
            return self.matched.entry(ours).or_default().insert(theirs, Instant::now()).is_none();
        }
        let what = if self.writers.contains_key(&theirs) { "a publisher" } else { "a subscription" };
        let topic = names::ros_topic(&their.topic).unwrap_or(&their.topic);
        let node = self.node_of(&theirs).unwrap_or_else(|| "an unknown node".into());
        let (our_type, their_type) = (names::ros_type(&our.type_name), names::ros_type(&their.type_name));
        self.incompatible.push(format!(
            "{what} of {node} on {topic} has the type {their_type}, not {our_type}; no messages will pass"
        ));
        false
    }

    /// Decides the matches that waited for this endpoint to be known.
    fn decide(&mut self, known: GUID) {
        let waited: Vec<_> =
            self.undecided.extract_if(.., |(ours, theirs)| *ours == known || *theirs == known).collect();
        for (ours, theirs) in waited {
            self.add_match(ours, theirs);
        }
    }

    /// Says, in the words of rclcpp and once, that an endpoint asks for more than it gets.
    fn report_misfit(&mut self, pair: (GUID, GUID), policy: Option<QosPolicyId>, publishes: bool) {
        let known = if publishes { &self.writers } else { &self.readers };
        let Some(topic) = known.get(&pair.1).and_then(|endpoint| names::ros_topic(&endpoint.topic)) else { return };
        let node = self.node_of(&pair.1).map(|node| format!(" ({node})")).unwrap_or_default();
        let policy = policy.map_or_else(|| "UNKNOWN".to_string(), |policy| format!("{policy:?}").to_uppercase());
        let sentence = if publishes {
            format!(
                "New publisher discovered on topic '{topic}'{node}, offering incompatible QoS. No messages will be received from \
                 it. Last incompatible policy: {policy}"
            )
        } else {
            format!(
                "New subscription discovered on topic '{topic}'{node}, requesting incompatible QoS. No messages will be sent to \
                 it. Last incompatible policy: {policy}"
            )
        };
        if self.reported.insert(pair) {
            self.incompatible.push(sentence);
        }
    }

    fn info(&self, guid: &GUID, endpoint: &Endpoint) -> EndpointInfo {
        let (node, type_hash) = (self.node_of(guid), endpoint.type_hash.clone());
        EndpointInfo { guid: guid.to_bytes(), node, qos: endpoint.qos, type_hash }
    }

    fn node_of(&self, guid: &GUID) -> Option<String> {
        let bytes = guid.to_bytes();
        self.nodes
            .iter()
            .filter(|(participant, _)| participant[..12] == bytes[..12])
            .flat_map(|(_, nodes)| nodes)
            .find(|node| node.readers.contains(&bytes) || node.writers.contains(&bytes))
            .map(|node| names::join(&node.namespace, &node.name))
    }
}

pub(super) fn prefix(guid: &GUID) -> Prefix {
    gate::octets(guid.prefix)
}

/// A callback on graph changes; dropping it ends the calls.
#[must_use = "dropping it ends the calls"]
pub struct GraphListener {
    graph: Weak<Graph>,
    id: u64,
}

impl fmt::Debug for GraphListener {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("GraphListener").field("id", &self.id).finish()
    }
}

impl Drop for GraphListener {
    fn drop(&mut self) {
        if let Some(graph) = self.graph.upgrade() {
            graph.listeners.lock().unwrap_or_else(PoisonError::into_inner).retain(|(id, _)| *id != self.id);
        }
    }
}

#[cfg(test)]
#[path = "discovery_tests.rs"]
mod tests;
