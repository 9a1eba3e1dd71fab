// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Queries about the other nodes of the domain.

use std::time::Duration;

use super::{
    discovery::{EndpointInfo, GraphListener, Guid, TopicInfo},
    error::RosError,
    node::Node,
};

impl Node {
    /// Topics that are known, with their publishers and subscriptions.
    pub fn discovered_topics(&self) -> Vec<TopicInfo> {
        self.graph().topics()
    }

    /// Fully qualified names of the nodes that are known (up to a second after their topics).
    pub fn discovered_nodes(&self) -> Vec<String> {
        self.graph().nodes()
    }

    /// Calls `callback` on the executor thread whenever endpoints, matches or nodes come or go.
    pub fn on_graph_change(&self, callback: impl Fn() + Send + Sync + 'static) -> GraphListener {
        self.graph().on_change(callback)
    }

    /// Waits until a node is known; `false` after the timeout. The node must spin on another thread.
    pub fn wait_for_node(&self, fully_qualified_name: &str, timeout: Duration) -> bool {
        self.graph().wait_until(timeout, |matches| matches.node(fully_qualified_name))
    }

    /// Waits until all participants that ran before this node are known with their nodes; `false` after the timeout, which a participant
    /// without ROS nodes takes up. The node must spin on another thread.
    pub fn wait_acquainted(&self, timeout: Duration) -> bool {
        self.graph().wait_acquainted(timeout)
    }

    /// Publishers of a topic that belong to other nodes.
    ///
    /// # Errors
    /// The name breaks the rules.
    pub fn other_publishers(&self, topic: &str) -> Result<Vec<EndpointInfo>, RosError> {
        Ok(self.graph().other_publishers(&self.resolve_topic(topic)?))
    }

    /// Name of the sender with a GUID: the fully qualified name of its node, those of all nodes of its participant if that does not say
    /// which, or the GUID where nothing is known yet.
    pub fn who(&self, guid: &Guid) -> String {
        self.graph().who(guid)
    }

    /// Returns true where a participant, or that of an endpoint, has said which nodes it has, and has not left.
    pub fn knows_participant(&self, guid: &Guid) -> bool {
        self.graph().knows_participant(guid)
    }

    /// Number of known publishers on a topic.
    ///
    /// # Errors
    /// The name breaks the rules.
    pub fn publisher_count(&self, topic: &str) -> Result<usize, RosError> {
        Ok(self.graph().counts(&self.resolve_topic(topic)?).0)
    }

    /// Number of known subscriptions on a topic.
    ///
    /// # Errors
    /// The name breaks the rules.
    pub fn subscription_count(&self, topic: &str) -> Result<usize, RosError> {
        Ok(self.graph().counts(&self.resolve_topic(topic)?).1)
    }
}
