// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `/rosout`: the log of a node as messages.

use std::sync::Arc;

use camwright_msgs::rcl_interfaces::msg::Log;

use super::clock::RosClock;
use super::error::RosError;
use super::logging::Outlet;
use super::node::Node;
use super::qos::Qos;
use super::topics::Publisher;

struct Rosout {
    publisher: Publisher<Log>,
    clock: Arc<RosClock>,
}

impl Outlet for Rosout {
    fn now_ns(&self) -> i64 {
        self.clock.now_ns()
    }

    fn publish(&self, log: &Log) -> Result<(), RosError> {
        self.publisher.publish(log)
    }
}

/// Connects the node's logger to `/rosout`, unless the arguments disable that.
pub(super) fn connect(node: &Node) -> Result<(), RosError> {
    if node.logger().uses_rosout() {
        let publisher = node.publisher("/rosout", &Qos::rosout())?;
        node.logger().connect(Arc::new(Rosout { publisher, clock: Arc::clone(node.clock()) }));
    }
    Ok(())
}
