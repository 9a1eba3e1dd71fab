// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Real-time priority and locked memory for cyclic threads.
//!
//! It affects only the delay of a tick on a busy computer, not the results. If the system refuses, a warning names the remedy, and the
//! thread runs with ordinary priority.

use crate::running::NodeError;
use crate::{Node, NodeOptions, Parameter, ParameterValue};
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy, set_thread_priority_and_policy,
    thread_native_id,
};

const PRIORITY: &str = "cyclic_priority";
const LOCK_MEMORY: &str = "lock_memory";

/// The parameters that ask for it.
pub fn parameters() -> [Parameter; 2] {
    [
        Parameter::integer(PRIORITY, 0)
            .describe(
                "real-time priority (SCHED_FIFO) of the cyclic thread; other threads of the node have one less; 0: no real-time priority",
            )
            .integer_range(0, 99)
            .read_only(),
        Parameter::bool(LOCK_MEMORY, false)
            .describe("locks the memory of the process (mlockall)")
            .read_only(),
    ]
}

/// Starts a node so that its other threads, those of DDS and the executor, have the priority below the cycle's: a setpoint that waits in
/// one of them is as late as one that was computed late. Threads inherit the scheduling of the one that starts them, so the node is
/// started by a thread of its own. Whether the priority is granted, the cycle's own thread reports.
pub fn start_with_priority<N: Send>(
    options: NodeOptions,
    is_asked: bool,
    start: impl FnOnce(NodeOptions) -> Result<N, NodeError> + Send,
) -> Result<N, NodeError> {
    let wanted = match options.asked(PRIORITY) {
        Some(ParameterValue::Integer(priority)) if is_asked => u8::try_from(priority - 1).unwrap_or(0).min(98),
        _ => 0,
    };
    if wanted == 0 {
        return start(options);
    }
    std::thread::scope(|scope| {
        let starter = std::thread::Builder::new().name("node start".to_owned()).spawn_scoped(scope, move || {
            let _refused_is_reported_by_the_cycle = set_priority(wanted);
            start(options)
        })?;
        starter.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

/// Gives the calling thread a real-time priority.
fn set_priority(priority: u8) -> Result<(), String> {
    let priority = ThreadPriority::try_from(priority).map_err(ToString::to_string)?;
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    set_thread_priority_and_policy(thread_native_id(), priority, policy).map_err(|error| error.to_string())
}

/// Priority that a thread is to have, and the one that it got.
#[derive(Debug, Clone)]
pub struct Realtime {
    node: Node,
    wanted: u8,
    granted: Arc<AtomicU8>,
}

impl Realtime {
    /// Reads the parameters of a node, and locks its memory if it is to.
    ///
    /// # Errors
    /// A priority out of range, which the parameter's own range keeps out.
    pub fn for_node(node: &Node) -> Result<Self, NodeError> {
        let priority = node.parameters().integer(PRIORITY);
        let wanted = u8::try_from(priority).map_err(|_| NodeError::Parameter(format!("{PRIORITY}: {priority}")))?;
        if node.parameters().bool(LOCK_MEMORY) {
            lock_memory(node);
        }
        Ok(Self { node: node.clone(), wanted, granted: Arc::default() })
    }

    /// Asks for the priority, on the thread that is to have it and before its cycle begins.
    pub fn adopt_current_thread(&self) {
        if self.wanted == 0 {
            return;
        }
        let outcome = set_priority(self.wanted);
        match outcome {
            Ok(()) => self.granted.store(self.wanted, Ordering::Relaxed),
            Err(reason) => self.node.logger().warn(&format!(
                "{PRIORITY} {} is refused ({reason}): the cycle runs in an ordinary thread; allow it by `ulimit -r {}` or a line \
                 `rtprio` in /etc/security/limits.d",
                self.wanted, self.wanted
            )),
        }
    }

    /// Scheduling of the node's other threads, as text.
    pub fn text_of_others(&self) -> String {
        match self.granted.load(Ordering::Relaxed) {
            0 | 1 => "ordinary".to_owned(),
            priority => format!("SCHED_FIFO {}", priority - 1),
        }
    }

    /// Scheduling of the thread, as text.
    pub fn text(&self) -> String {
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
