//! Topics of the cell: `~/cell_state`, and `~/loading` where the machine has a door and a chuck.

use camwright_msgs::Message;
use camwright_msgs::camwright_msgs::msg::{CellState, LoadingState};
use camwright_ros::{Node, Publisher, Qos, RosError};
use std::time::{Duration, Instant};

/// Period of repeated messages without changes.
const PERIOD: Duration = Duration::from_secs(1);

/// A latched topic, and what was said on it last.
#[derive(Debug)]
pub(super) struct LastPublished<M: Message> {
    publisher: Publisher<M>,
    last: Option<(M, Instant)>,
}

impl<M: Message + PartialEq> LastPublished<M> {
    /// Says what is new, or what was said long ago. `plain` is the message without what changes all the time.
    pub(super) fn publish(&mut self, plain: M, whole: impl FnOnce(M) -> M) -> Result<(), RosError> {
        if self.last.as_ref().is_some_and(|(last, at)| *last == plain && at.elapsed() < PERIOD) {
            return Ok(());
        }
        self.last = Some((plain.clone(), Instant::now()));
        self.publisher.publish(&whole(plain))
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
