// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Topics of the cell: `~/cell_state`, and `~/loading` where the machine has a door and a chuck.

use camwright_msgs::Message;
use camwright_msgs::builtin_interfaces::msg::Time;
use camwright_msgs::camwright_msgs::msg::{CellState, LoadingState};
use camwright_ros::{Node, Publisher, Qos, RosError};
use std::time::{Duration, Instant};

/// Period of repeated messages without changes.
const PERIOD: Duration = Duration::from_secs(1);

/// A latched topic, and what was said on it last.
#[derive(Debug)]
pub(super) struct LastPublished<M: Message> {
    publisher: Publisher<M>,
    /// The message without what changes all the time, when it was published, and the ROS time of its change.
    last: Option<(M, Instant, Time)>,
}

impl<M: Message + PartialEq> LastPublished<M> {
    /// Publishes a changed message with the time `now`, or repeats it after a period with the time of its change. `plain` is the message
    /// without what changes all the time; `whole` adds that and the stamp.
    pub(super) fn publish(&mut self, plain: M, now: &Time, whole: impl FnOnce(M, Time) -> M) -> Result<(), RosError> {
        let same = self.last.as_ref().filter(|(last, ..)| *last == plain);
        if same.is_some_and(|(_, at, _)| at.elapsed() < PERIOD) {
            return Ok(());
        }
        let changed = same.map_or(now, |(.., changed)| changed).clone();
        self.last = Some((plain.clone(), Instant::now(), changed.clone()));
        self.publisher.publish(&whole(plain, changed))
    }
}

/// The topics of the cell.
#[derive(Debug)]
pub(super) struct CellPublisher {
    pub(super) state: LastPublished<CellState>,
    pub(super) loading: LastPublished<LoadingState>,
}

impl CellPublisher {
    pub(super) fn new(node: &Node) -> Result<Self, RosError> {
        // One only: a robot that joins late must not act on a leave of yesterday.
        let latched = Qos::latched(1);
        let state = LastPublished { publisher: node.publisher("~/cell_state", &latched)?, last: None };
        let loading = LastPublished { publisher: node.publisher("~/loading", &latched)?, last: None };
        Ok(Self { state, loading })
    }
}
