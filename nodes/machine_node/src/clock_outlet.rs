// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! `/clock` at pace fast: published here unless another client does.
//!
//! Two clocks would tear every node that follows simulated time to and fro. So nothing is published as long as another publisher is
//! known that came before this one; of two that came together, the one with the smaller GUID goes on.

use camwright_msgs::builtin_interfaces::msg::Time;
use camwright_msgs::rosgraph_msgs::msg::Clock;
use camwright_ros::{GraphListener, Guid, Node, Publisher, Qos, RosError};
use std::sync::{Arc, Mutex, PoisonError};

const TOPIC: &str = "/clock";

/// The publisher, and who else has one.
#[derive(Debug)]
pub(super) struct ClockOutlet {
    node: Node,
    publisher: Option<Publisher<Clock>>,
    others: Arc<Mutex<OtherPublishers>>,
    is_silent: bool,
    _watch: GraphListener,
}

/// Other publishers of the clock, by GUID, with their nodes as far as they are known.
#[derive(Debug, Default)]
struct OtherPublishers(Vec<(Guid, Option<String>)>);

impl OtherPublishers {
    fn from_discovery(node: &Node) -> Result<Self, RosError> {
        Ok(Self(node.other_publishers(TOPIC)?.into_iter().map(|other| (other.guid, other.node)).collect()))
    }

    /// Another publisher whose clock has priority.
    fn ahead_of(&self, publisher: Option<Guid>) -> Option<String> {
        let ahead = self.0.iter().find(|(guid, _)| publisher.is_none_or(|own| *guid < own));
        ahead.map(|(_, node)| node.clone().unwrap_or_else(|| "another node".to_owned()))
    }
}

impl ClockOutlet {
    pub(super) fn new(node: &Node) -> Result<Self, RosError> {
        let others = Arc::new(Mutex::new(OtherPublishers::from_discovery(node)?));
        let (seen, watched) = (Arc::clone(&others), node.clone());
        let watch = node.on_graph_change(move || {
            if let Ok(now) = OtherPublishers::from_discovery(&watched) {
                *seen.lock().unwrap_or_else(PoisonError::into_inner) = now;
            }
        });
        Ok(Self { node: node.clone(), publisher: None, others, is_silent: false, _watch: watch })
    }

    /// Publishes the time, if this node owns the clock.
    pub(super) fn publish(&mut self, time: Time) -> Result<(), RosError> {
        let own = self.publisher.as_ref().map(Publisher::guid);
        let ahead = self.others.lock().unwrap_or_else(PoisonError::into_inner).ahead_of(own);
        match (&ahead, self.is_silent) {
            (Some(other), false) => self.node.logger().warn(&format!(
                "{other} publishes /clock, so this machine does not: nodes that follow simulated time follow that clock \
                 (remap /clock to have one of the cell's own)"
            )),
            (None, true) => self.node.logger().warn("no other node publishes /clock; this machine publishes it from now on"),
            _ => {}
        }
        self.is_silent = ahead.is_some();
        if self.is_silent {
            return Ok(());
        }
        let publisher = match self.publisher.take() {
            Some(publisher) => publisher,
            None => self.node.publisher(TOPIC, &Qos::default_topic().keep_last(100))?,
        };
        self.publisher.insert(publisher).publish(&Clock { clock: time })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_came_before_or_has_the_smaller_guid_is_ahead() {
        let others = OtherPublishers(vec![([5; 16], None)]);
        assert!(others.ahead_of(None).is_some(), "it was there before this one had a publisher");
        assert!(others.ahead_of(Some([6; 16])).is_some());
        assert!(others.ahead_of(Some([4; 16])).is_none());
        assert!(OtherPublishers::default().ahead_of(None).is_none());
    }
}
