// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Errors between a node and the graph.

use super::names::NameError;

/// A failure of the ROS layer, worded for the person who started the node.
#[derive(Debug, thiserror::Error)]
pub enum RosError {
    /// A node, topic, service, action or parameter name breaks the ROS 2 naming rules.
    #[error(transparent)]
    Name(#[from] NameError),
    /// The middleware refused to create something.
    #[error("cannot create {what}: {reason}")]
    Create {
        /// Kind and resolved name of the entity.
        what: String,
        /// Message of the middleware.
        reason: String,
    },
    /// A message could not be written.
    #[error("cannot publish on {topic}: {reason}")]
    Publish {
        /// Resolved topic or service name.
        topic: String,
        /// Message of the middleware.
        reason: String,
    },
    /// A full writer rejected a message: a peer does not acknowledge earlier ones, or the network is congested.
    #[error("cannot publish on {topic}: a subscriber does not acknowledge, and no room is left for another message")]
    Congested { topic: String },
    /// A peer did not answer or did not appear in time.
    #[error("{what}: no answer within {waited_s:.3} s")]
    Timeout {
        /// Awaited peer or answer.
        what: String,
        /// Time waited (s).
        waited_s: f64,
    },
    /// A blocking call was made on the thread that would have to deliver its answer.
    #[error("{what}: a blocking call from a callback of the same node would wait for itself")]
    WouldDeadlock { what: String },
    /// The node has left the graph.
    #[error("node {node} is shut down")]
    Closed {
        /// Fully qualified node name.
        node: String,
    },
    /// A parameter declaration, override or change was refused.
    #[error("parameter '{name}': {reason}")]
    Parameter {
        /// Name of the parameter.
        name: String,
        reason: String,
    },
    /// A peer rejected a request.
    #[error("{what} was refused: {reason}")]
    Refused {
        what: String,
        /// Reason given by the peer.
        reason: String,
    },
    /// Two threads tried to run the same node.
    #[error("node {node} is already spinning on another thread")]
    AlreadySpinning {
        /// Fully qualified node name.
        node: String,
    },
    /// The operating system refused a thread, a socket or a signal handler.
    #[error("{what}: {source}")]
    Io { what: String, source: std::io::Error },
}

impl RosError {
    pub(super) fn create(what: impl Into<String>, reason: impl std::fmt::Display) -> Self {
        RosError::Create { what: what.into(), reason: reason.to_string() }
    }

    pub(super) fn publish(topic: &str, reason: impl std::fmt::Display) -> Self {
        RosError::Publish { topic: topic.to_string(), reason: reason.to_string() }
    }

    pub(super) fn timeout(what: impl Into<String>, waited: std::time::Duration) -> Self {
        RosError::Timeout { what: what.into(), waited_s: waited.as_secs_f64() }
    }
}
