// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Publishing that does not wait for peers, and publishing that insists.
//!
//! A reliable publisher has room for a bounded number of samples that a peer has not acknowledged. A peer that was killed acknowledges
//! nothing until its lease of 50 s is over. Telemetry is then dropped and counted; what others wait for is tried until it is sent.

use super::{error::RosError, node::Node, qos::Qos, topics::Publisher};
use camwright_msgs::Message;
use camwright_threads::drops::DropCounter;
use std::fmt;
use std::time::{Duration, Instant};

/// Publishes messages of one type on one topic and never waits for room.
pub struct Telemetry<M: Message> {
    publisher: Publisher<M>,
    drops: DropCounter,
}

impl<M: Message> fmt::Debug for Telemetry<M> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Telemetry").field("topic", &self.publisher.topic()).finish_non_exhaustive()
    }
}

impl<M: Message> Telemetry<M> {
    /// Publishes a message, or drops and counts it where there is no room.
    ///
    /// # Errors
    /// See [`Publisher::publish`]; a full writer is no error.
    pub fn publish(&self, message: &M) -> Result<(), RosError> {
        self.publish_within(message, Duration::ZERO)
    }

    /// The same, but tries for some time before it drops the message.
    ///
    /// # Errors
    /// See [`Telemetry::publish`].
    pub fn publish_within(&self, message: &M, patience: Duration) -> Result<(), RosError> {
        let sent = self.offer(message, patience)?;
        if !sent {
            self.drops.add();
        }
        Ok(())
    }

    /// Tries for some time to publish a message; false where there was no room. The caller counts it.
    ///
    /// # Errors
    /// See [`Telemetry::publish`].
    pub fn offer(&self, message: &M, patience: Duration) -> Result<bool, RosError> {
        /// Pause between two attempts: the writer does not signal free space.
        const BETWEEN: Duration = Duration::from_millis(1);
        let end = Instant::now() + patience;
        loop {
            match self.publisher.publish(message) {
                Ok(()) => return Ok(true),
                Err(RosError::Congested { .. }) if patience.is_zero() || Instant::now() >= end => return Ok(false),
                Err(RosError::Congested { .. }) => std::thread::park_timeout(BETWEEN),
                Err(error) => return Err(error),
            }
        }
    }

    /// Number of matched subscriptions.
    pub fn matched(&self) -> usize {
        self.publisher.matched()
    }

    /// Appends zero octets to every message; see [`Publisher::with_trailing_zeros`].
    pub(super) fn with_trailing_zeros(self, octets: usize) -> Self {
        Telemetry { publisher: self.publisher.with_trailing_zeros(octets), ..self }
    }
}

impl<M: Message> Publisher<M> {
    /// Publishes a message that others wait for: where there is no room it is tried again for as long as `limit`.
    ///
    /// # Errors
    /// See [`Publisher::publish`].
    pub fn publish_within(&self, message: &M, limit: Duration) -> Result<(), RosError> {
        let end = Instant::now() + limit;
        loop {
            match self.publish(message) {
                // Each attempt waits for room itself.
                Err(RosError::Congested { .. }) if Instant::now() < end => {}
                outcome => return outcome,
            }
        }
    }
}

impl Node {
    /// Publishes telemetry: messages that may be dropped, which `drops` counts.
    ///
    /// # Errors
    /// See [`Node::publisher`].
    pub fn telemetry<M: Message>(&self, topic: &str, qos: &Qos, drops: &DropCounter) -> Result<Telemetry<M>, RosError> {
        let policies = qos.impatient_writer_policies();
        let publisher = self.publisher_with(topic, M::DDS_TYPE_NAME, qos, &policies)?.typed();
        Ok(Telemetry { publisher, drops: drops.clone() })
    }
}
