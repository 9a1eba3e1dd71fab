// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Queries about matches between our endpoints and those of other nodes.

use std::{
    collections::BTreeMap,
    time::{Duration, Instant},
};

use rustdds::GUID;

use super::discovery::Endpoint;
use super::participant_entities::{Guid, NodeEntities};
use super::{cyclone, names};

/// Time after the first match in which a new endpoint of ours matches all endpoints that discovery knows already. One that has not matched
/// by then does not fit.
const SETTLED: Duration = Duration::from_secs(1);

/// The matches of our endpoints at one moment.
pub(super) struct Matches<'a> {
    /// Matched endpoints of others by our endpoints, with the time of the match.
    pub(super) matched: &'a BTreeMap<GUID, BTreeMap<GUID, Instant>>,
    pub(super) nodes: &'a BTreeMap<Guid, Vec<NodeEntities>>,
    pub(super) writers: &'a BTreeMap<GUID, Endpoint>,
    pub(super) readers: &'a BTreeMap<GUID, Endpoint>,
}

impl Matches<'_> {
    /// Number of endpoints that match one of ours.
    pub(super) fn count(&self, ours: &GUID) -> usize {
        self.matched.get(ours).map_or(0, BTreeMap::len)
    }

    /// Endpoints that match one of ours.
    pub(super) fn endpoints(&self, ours: &GUID) -> impl Iterator<Item = &GUID> {
        self.matched.get(ours).into_iter().flat_map(BTreeMap::keys)
    }

    /// Returns true if an endpoint of the participant of `theirs` matches one of ours.
    pub(super) fn with_participant(&self, ours: &GUID, theirs: &GUID) -> bool {
        self.for_participant(ours, theirs).next().is_some()
    }

    /// Returns true if the reader `theirs` matches our writer and receives what is sent from now on. A client that names a writer instead
    /// of its reader counts as matched with any reader of its participant.
    pub(super) fn is_matched_by_client(&self, ours: &GUID, theirs: &GUID) -> bool {
        let is_exact = theirs.entity_id.kind().is_reader();
        self.for_participant(ours, theirs)
            .any(|(other, since)| (!is_exact || other == theirs) && cyclone::knows_us(other, *since))
    }

    /// Endpoints of the participant of `theirs` that match one of ours, with the time of the match.
    fn for_participant(&self, ours: &GUID, theirs: &GUID) -> impl Iterator<Item = (&GUID, &Instant)> {
        let prefix = theirs.prefix;
        self.matched.get(ours).into_iter().flatten().filter(move |(other, _)| other.prefix == prefix)
    }

    /// An endpoint of a participant that matches both of ours: a service is there when one reads requests and writes replies.
    pub(super) fn one_peer_for_both(&self, first: &GUID, second: &GUID) -> Option<GUID> {
        let mut candidates = self.matched.get(first)?.iter();
        candidates
            .find(|(other, since)| self.with_participant(second, other) && cyclone::knows_us(other, **since))
            .map(|(other, _)| *other)
    }

    /// Returns true if a server matches a client's writer of requests and reader of replies, and so does every other server that is known.
    ///
    /// The known servers match a new client one after the other. `RustDDS` sends a request only to those that matched before it was
    /// written, and a server that was killed stays known for its lease: without the others, the request could go to that one alone.
    pub(super) fn is_service_matched(&self, requests: &GUID, replies: &GUID) -> bool {
        let Some(server) = self.one_peer_for_both(requests, replies) else { return false };
        let since = self.matched[requests][&server];
        since.elapsed() >= SETTLED
            || (self.has_all(requests, self.writers, self.readers) && self.has_all(replies, self.readers, self.writers))
    }

    /// Returns true if all known endpoints of other participants on the topic of ours match it.
    fn has_all(&self, ours: &GUID, own: &BTreeMap<GUID, Endpoint>, others: &BTreeMap<GUID, Endpoint>) -> bool {
        let Some(endpoint) = own.get(ours) else { return true };
        let is_same = |other: &Endpoint| other.topic == endpoint.topic && other.type_name == endpoint.type_name;
        let mut known = others.iter().filter(|(guid, other)| guid.prefix != ours.prefix && is_same(other));
        known.all(|(guid, _)| self.matched.get(ours).is_some_and(|matched| matched.contains_key(guid)))
    }

    /// Returns true if a node with this fully qualified name is known.
    pub(super) fn node(&self, name: &str) -> bool {
        self.nodes.values().flatten().any(|node| names::join(&node.namespace, &node.name) == name)
    }
}
