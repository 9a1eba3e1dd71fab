//! Queries about matches between our endpoints and those of other nodes.

use std::{collections::BTreeMap, time::Instant};

use rustdds::GUID;

use super::participant_entities::{Guid, NodeEntities};
use super::{cyclone, names};

/// The matches of our endpoints at one moment.
pub(super) struct Matches<'a> {
    /// Matched endpoints of others by our endpoints, with the time of the match.
    pub(super) matched: &'a BTreeMap<GUID, BTreeMap<GUID, Instant>>,
    pub(super) nodes: &'a BTreeMap<Guid, Vec<NodeEntities>>,
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

    /// Returns true if an endpoint of the participant of `theirs` matches one of ours and receives what is sent from now on.
    pub(super) fn is_matched_by_participant(&self, ours: &GUID, theirs: &GUID) -> bool {
        self.for_participant(ours, theirs).any(|(other, since)| cyclone::knows_us(other, *since))
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

    /// Returns true if a node with this fully qualified name is known.
    pub(super) fn node(&self, name: &str) -> bool {
        self.nodes.values().flatten().any(|node| names::join(&node.namespace, &node.name) == name)
    }
}
