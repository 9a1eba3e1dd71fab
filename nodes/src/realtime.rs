//! What a thread that keeps a cycle may ask of the system: a real-time priority, and memory that stays where it is.
//!
//! Nothing is right or wrong by it; it decides how late a tick comes on a computer that has other things to do. A system that refuses is
//! told of with the remedy, and the thread runs as an ordinary one.

use crate::ros::{Node, Parameter};
use crate::running::NodeError;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy, set_thread_priority_and_policy,
    thread_native_id,
};

const PRIORITY: &str = "cyclic_priority";
const LOCK_MEMORY: &str = "lock_memory";

/// The parameters that ask for it.
pub(crate) fn parameters() -> [Parameter; 2] {
    [
        Parameter::integer(PRIORITY, 0)
            .describe("real-time priority (SCHED_FIFO) of the thread that keeps the cycle; 0: an ordinary thread")
            .integer_range(0, 99)
            .read_only(),
        Parameter::bool(LOCK_MEMORY, false)
            .describe("keep all memory of the process in place (mlockall), so that no tick waits for a page")
            .read_only(),
    ]
}

/// The priority that a thread is to have, and the one that it got.
#[derive(Debug, Clone)]
pub(crate) struct Realtime {
    node: Node,
    wanted: u8,
    granted: Arc<AtomicU8>,
}

impl Realtime {
    /// Reads the parameters of a node, and locks its memory if it is to.
    ///
    /// # Errors
    /// A priority out of range, which the parameter's own range keeps out.
    pub(crate) fn of(node: &Node) -> Result<Self, NodeError> {
        let priority = node.parameters().integer(PRIORITY);
        let wanted = u8::try_from(priority).map_err(|_| NodeError::Parameter(format!("{PRIORITY}: {priority}")))?;
        if node.parameters().bool(LOCK_MEMORY) {
            lock_memory(node);
        }
        Ok(Self { node: node.clone(), wanted, granted: Arc::default() })
    }

    /// Asks for the priority, on the thread that is to have it and before its cycle begins.
    pub(crate) fn adopt_current_thread(&self) {
        if self.wanted == 0 {
            return;
        }
        let outcome = ThreadPriority::try_from(self.wanted).map_err(ToString::to_string).and_then(|priority| {
            let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
            set_thread_priority_and_policy(thread_native_id(), priority, policy).map_err(|error| error.to_string())
        });
        match outcome {
            Ok(()) => self.granted.store(self.wanted, Ordering::Relaxed),
            Err(reason) => self.node.logger().warn(&format!(
                "{PRIORITY} {} is refused ({reason}): the cycle runs in an ordinary thread; allow it by `ulimit -r {}` or a line \
                 `rtprio` in /etc/security/limits.d",
                self.wanted, self.wanted
            )),
        }
    }

    /// How the thread is scheduled, for people.
    pub(crate) fn text(&self) -> String {
        match self.granted.load(Ordering::Relaxed) {
            0 => "ordinary".to_owned(),
            priority => format!("SCHED_FIFO {priority}"),
        }
    }
}

fn lock_memory(node: &Node) {
    use rustix::mm::{MlockAllFlags, mlockall};
    if let Err(error) = mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE) {
        node.logger().warn(&format!(
            "{LOCK_MEMORY} is refused ({error}): a tick may wait for a page; allow it by `ulimit -l unlimited` or a line `memlock` in \
             /etc/security/limits.d"
        ));
    }
}
