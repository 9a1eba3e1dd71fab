// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! One sender of a topic that has one source: the recorder's status, the loader's state.

use super::lease::{Participant, participant_of};
use camwright_ros::{Guid, Node};
use std::time::{Duration, Instant};

/// The first sender, until it is silent or has left.
#[derive(Debug)]
pub struct OneSender {
    topic: &'static str,
    limit: Duration,
    sender: Option<(Participant, Instant)>,
}

impl OneSender {
    /// A topic without a sender yet; a sender that is silent for longer than `limit` makes room for another.
    pub fn new(topic: &'static str, limit: Duration) -> Self {
        Self { topic, limit, sender: None }
    }

    /// Returns true where a message counts; that of a second sender is logged.
    pub fn accepts(&mut self, writer: &Guid, node: &Node) -> bool {
        let (by, now) = (participant_of(*writer), Instant::now());
        if let Some((sender, last_message)) = self.sender
            && sender != by
            && now.duration_since(last_message) <= self.limit
            && node.knows_participant(&sender)
        {
            let (topic, who, first) = (self.topic, node.who(writer), node.who(&sender));
            node.warn_once(
                &format!("{topic} of {who} ignored"),
                &format!("{topic} of {who} ignored: {first} sends it; end one of the two"),
            );
            return false;
        }
        self.sender = Some((by, now));
        true
    }
}
