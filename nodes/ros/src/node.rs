// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A node: one participant, one executor, and what every ROS 2 node has.

use std::{
    any::Any,
    fmt,
    panic::resume_unwind,
    sync::{Arc, Mutex, OnceLock, PoisonError},
    thread::JoinHandle,
    time::{Duration, Instant},
};

use camwright_msgs::builtin_interfaces;
use rustdds::{DomainParticipant, QosPolicies, RTPSEntity, Topic, TopicKind};

use super::authority::Authority;
use super::clock::{ElapsedTime, RosClock};
use super::delay::{DelayInjection, DelaySource};
use super::discovery::{Graph, Guid};
use super::error::RosError;
use super::executor::{Executor, TimerHandle};
use super::fastdds_workarounds::FastDdsWorkarounds;
use super::introspection::Introspection;
use super::level::Level;
use super::load::Load;
use super::logging::Logger;
use super::loopback::Loopback;
use super::names::{NameKind, NodeNames};
use super::network::watchdog;
use super::parameters::Parameters;
use super::qos::{Qos, WriterWindow};
use super::repeated_warnings::RepeatedWarnings;
use super::shutdown::Shutdown;
use camwright_threads::supervised::Supervisor;

/// Time for a leaving node to send its farewell: 300 ms let real ROS 2 forget its name within 10 ms; without it names
/// stay for the lease of 50 s (measured with Fast DDS).
const FAREWELL: Duration = Duration::from_millis(300);

/// The crate's node and its context, in the order in which they must go: the node says farewell, the context follows.
pub(super) struct CrateSide {
    pub(super) node: ros2_client::Node,
    pub(super) context: ros2_client::Context,
    pub(super) participant: DomainParticipant,
}

pub(super) struct NodeInner {
    pub(super) names: NodeNames,
    pub(super) executor: Arc<Executor>,
    pub(super) graph: Arc<Graph>,
    pub(super) loopback: Arc<Loopback>,
    pub(super) logger: Logger,
    pub(super) parameters: Parameters,
    pub(super) clock: Arc<RosClock>,
    pub(super) beside: Arc<FastDdsWorkarounds>,
    pub(super) delay_injection: Option<DelayInjection>,
    pub(super) writer_window: WriterWindow,
    pub(super) load: Arc<Load>,
    pub(super) introspection: Introspection,
    pub(super) warnings: Arc<RepeatedWarnings>,
    pub(super) authority: OnceLock<Arc<dyn Authority>>,
    pub(super) next_delay: Mutex<u64>,
    pub(super) watch: Mutex<Option<watchdog::ParticipantWatch>>,
    pub(super) crate_side: Mutex<Option<CrateSide>>,
    pub(super) retained: Mutex<Vec<Box<dyn Any + Send>>>,
    pub(super) supervisor: Supervisor,
}

impl Drop for NodeInner {
    fn drop(&mut self) {
        drop(self.leave());
    }
}

/// Farewell of a node that has left; dropping it waits until the farewell is sent (0.3 s).
#[derive(Debug, Default)]
pub struct Farewell(Option<JoinHandle<()>>);

impl Drop for Farewell {
    fn drop(&mut self) {
        if let Some(Err(panic)) = self.0.take().map(JoinHandle::join)
            && !std::thread::panicking()
        {
            resume_unwind(panic);
        }
    }
}

impl NodeInner {
    fn leave(&self) -> Farewell {
        let Some(side) = self.crate_side.lock().unwrap_or_else(PoisonError::into_inner).take() else {
            return Farewell::default();
        };
        self.executor.close();
        self.logger.detach();
        self.retained.lock().unwrap_or_else(PoisonError::into_inner).clear();
        self.watch.lock().unwrap_or_else(PoisonError::into_inner).take();
        let CrateSide { node, context, participant } = side;
        let beside = Arc::clone(&self.beside);
        // Dropping the node publishes the list of nodes without it; the participant must live until that is on its way.
        drop(node);
        Farewell(Some(std::thread::spawn(move || {
            std::thread::sleep(FAREWELL);
            beside.farewell();
            drop(context);
            drop(participant);
        })))
    }
}

/// A ROS 2 node. Clones are the same node.
///
/// Callbacks run on the one thread that calls [`Node::spin`]; everything else may be called from any thread. The node stays in the
/// graph until [`Node::shutdown`] is called or the last clone is dropped.
///
/// RIHS01 type hashes do not reach the graph: `RustDDS` reads the `USER_DATA` of endpoints but never sends any, so `ros2 topic info -v`
/// prints `INVALID` for our topics. Nothing else depends on it; the hashes are in bags and in `~/get_type_description`.
#[derive(Clone)]
pub struct Node {
    pub(super) inner: Arc<NodeInner>,
}

impl fmt::Debug for Node {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Node").field("name", &self.fully_qualified_name()).finish_non_exhaustive()
    }
}

impl Node {
    /// Keeps an endpoint, a timer or anything else until [`Node::shutdown`].
    ///
    /// A clone of the node in a retained callback keeps the node alive: call [`Node::shutdown`] then, a drop is not enough.
    pub fn retain(&self, endpoint: impl Any + Send) {
        self.inner.retained.lock().unwrap_or_else(PoisonError::into_inner).push(Box::new(endpoint));
    }

    pub(super) fn names(&self) -> &NodeNames {
        &self.inner.names
    }

    pub(super) fn executor(&self) -> &Arc<Executor> {
        &self.inner.executor
    }

    pub(super) fn graph(&self) -> &Arc<Graph> {
        &self.inner.graph
    }

    pub(super) fn beside(&self) -> &Arc<FastDdsWorkarounds> {
        &self.inner.beside
    }

    /// Counts of what was refused or lost under load.
    pub(super) fn load(&self) -> &Arc<Load> {
        &self.inner.load
    }

    /// Events of the node's services and clients.
    pub(super) fn introspection(&self) -> &Introspection {
        &self.inner.introspection
    }

    /// Warns once of what is refused again and again. Repetitions of `kind` within five seconds are counted and reported together.
    #[track_caller]
    pub fn warn_once(&self, kind: &str, text: &str) {
        self.inner.warnings.warn(kind, text);
    }

    /// Lets an authority decide on every request from now on, parameters and life cycle included. The first one stays.
    pub fn set_authority(&self, authority: Arc<dyn Authority>) {
        let _the_first_stays = self.inner.authority.set(authority);
    }

    /// Returns true if an [`Authority`] decides on the requests to this node.
    pub fn has_authority(&self) -> bool {
        self.inner.authority.get().is_some()
    }

    /// Returns why a request is refused, and logs it.
    pub(super) fn refusal(&self, service: &str, request: &dyn Any, sender: &Guid) -> Option<String> {
        let reason = self.inner.authority.get()?.refusal(service, request, sender)?;
        let who = self.graph().who(sender);
        self.warn_once(&format!("{service} refused to {who}"), &format!("{service} refused to {who}: {reason}"));
        Some(reason)
    }

    pub(super) fn clock(&self) -> &Arc<RosClock> {
        &self.inner.clock
    }

    pub(super) fn loopback(&self) -> &Arc<Loopback> {
        &self.inner.loopback
    }

    pub(super) fn downgrade(&self) -> WeakNode {
        WeakNode(Arc::downgrade(&self.inner))
    }

    pub(super) fn writer_policies(&self, qos: &Qos) -> QosPolicies {
        qos.writer_policies(self.inner.writer_window)
    }

    pub(super) fn delay_source(&self) -> Option<DelaySource> {
        let mut next = self.inner.next_delay.lock().unwrap_or_else(PoisonError::into_inner);
        *next += 1;
        self.inner.delay_injection.map(|injection| injection.source(*next))
    }

    /// Runs something with the crate's node.
    pub(super) fn with_crate_node<T>(&self, run: impl FnOnce(&mut ros2_client::Node) -> T) -> Result<T, RosError> {
        let mut side = self.inner.crate_side.lock().unwrap_or_else(PoisonError::into_inner);
        let side = side.as_mut().ok_or_else(|| RosError::Closed { node: self.fully_qualified_name() })?;
        Ok(run(&mut side.node))
    }

    /// Runs something with the participant.
    pub(super) fn with_participant<T>(&self, run: impl FnOnce(&DomainParticipant) -> T) -> Result<T, RosError> {
        let side = self.inner.crate_side.lock().unwrap_or_else(PoisonError::into_inner);
        let side = side.as_ref().ok_or_else(|| RosError::Closed { node: self.fully_qualified_name() })?;
        Ok(run(&side.participant))
    }

    pub(super) fn dds_topic(&self, name: String, type_name: &str, qos: &QosPolicies) -> Result<Topic, RosError> {
        let what = format!("topic {name}");
        self.with_participant(|participant| {
            participant.create_topic(name, type_name.to_string(), qos, TopicKind::NoKey)
        })?
        .map_err(|error| RosError::create(what, error))
    }

    /// Base name, after remapping.
    pub fn name(&self) -> &str {
        self.inner.names.node()
    }

    /// Namespace, `/` or `/a/b`, after remapping.
    pub fn namespace(&self) -> &str {
        self.inner.names.namespace()
    }

    pub fn fully_qualified_name(&self) -> String {
        self.inner.names.fully_qualified()
    }

    /// Absolute name of a topic, after remapping.
    ///
    /// # Errors
    /// The name breaks the rules.
    pub fn resolve_topic(&self, name: &str) -> Result<String, RosError> {
        Ok(self.inner.names.resolve(name, NameKind::Topic)?)
    }

    /// Absolute name of a service, after remapping.
    ///
    /// # Errors
    /// The name breaks the rules.
    pub fn resolve_service(&self, name: &str) -> Result<String, RosError> {
        Ok(self.inner.names.resolve(name, NameKind::Service)?)
    }

    pub fn parameters(&self) -> &Parameters {
        &self.inner.parameters
    }

    pub fn logger(&self) -> &Logger {
        &self.inner.logger
    }

    /// Logs to the console and to `/rosout`.
    #[track_caller]
    pub fn log(&self, level: Level, text: &str) {
        self.inner.logger.log(level, text);
    }

    /// ROS time in ns: the system clock (since 1970), or what `/clock` last said if `use_sim_time` is set (0 before the first).
    pub fn now_ns(&self) -> i64 {
        self.inner.clock.now_ns()
    }

    /// ROS time as a message; see [`Node::now_ns`].
    pub fn now(&self) -> builtin_interfaces::msg::Time {
        super::clock::to_time(self.now_ns())
    }

    /// ROS time that passes from now on, for durations in messages. Waits for a partner use real time, which always passes.
    pub fn elapsed_time(&self) -> ElapsedTime {
        ElapsedTime::new(&self.inner.clock)
    }

    /// Calls `callback` on the executor thread every `period` of real time, until the handle is dropped.
    pub fn timer(&self, period: Duration, callback: impl FnMut() + Send + 'static) -> TimerHandle {
        self.inner.executor.every(period, Box::new(callback))
    }

    /// Runs `job` on the executor thread once, after a time.
    pub fn after(&self, delay: Duration, job: impl FnOnce() + Send + 'static) {
        self.inner.executor.at(Instant::now() + delay, Box::new(job));
    }

    /// Runs `job` on the executor thread as soon as possible.
    pub fn post(&self, job: impl FnOnce() + Send + 'static) {
        self.inner.executor.post(Box::new(job));
    }

    /// Returns true inside a callback of this node, where blocking calls are rejected.
    pub fn on_executor_thread(&self) -> bool {
        self.inner.executor.is_current_thread()
    }

    /// Runs the node's callbacks on this thread until shutdown is requested or the node is shut down.
    ///
    /// # Errors
    /// Another thread runs them already.
    pub fn spin(&self, shutdown: &Shutdown) -> Result<(), RosError> {
        let _current = self.inner.logger.enter();
        if self.inner.executor.spin(shutdown) {
            Ok(())
        } else {
            Err(RosError::AlreadySpinning { node: self.fully_qualified_name() })
        }
    }

    /// Runs the node's callbacks on a thread of its own until the returned value is dropped.
    ///
    /// # Errors
    /// The operating system refuses a thread.
    pub fn spin_in_thread(&self) -> Result<SpinThread, RosError> {
        let shutdown = Shutdown::new();
        let (node, stop) = (self.clone(), shutdown.clone());
        let thread = self
            .supervisor()
            .spawn(&format!("ros {}", self.name()), move || drop(node.spin(&stop)))
            .map_err(|source| RosError::Io { what: format!("thread of node {}", self.name()), source })?;
        Ok(SpinThread { shutdown, thread: Some(thread) })
    }

    /// Supervisor that starts the node's threads and reports their death.
    #[must_use]
    pub fn supervisor(&self) -> &Supervisor {
        &self.inner.supervisor
    }

    /// Leaves the graph: ends `spin`, drops all callbacks, says farewell and waits until that is sent (0.3 s). Publishers and clients
    /// that are still held fail from now on.
    pub fn shutdown(&self) {
        drop(self.leave());
    }

    /// Same as [`Node::shutdown`], but waits only when the result is dropped.
    pub fn leave(&self) -> Farewell {
        self.inner.leave()
    }
}

/// Weak reference to a node.
#[derive(Clone)]
pub(super) struct WeakNode(std::sync::Weak<NodeInner>);

impl WeakNode {
    pub(super) fn upgrade(&self) -> Option<Node> {
        self.0.upgrade().map(|inner| Node { inner })
    }
}

/// A thread that runs a node's callbacks; dropping it ends and joins it.
#[derive(Debug)]
#[must_use = "dropping it ends the thread"]
pub struct SpinThread {
    shutdown: Shutdown,
    thread: Option<JoinHandle<Option<()>>>,
}

impl SpinThread {
    /// Ends the thread and waits for it.
    pub fn stop(self) {}
}

impl Drop for SpinThread {
    fn drop(&mut self) {
        self.shutdown.request();
        if let Some(thread) = self.thread.take() {
            // A callback that panicked has been reported.
            if thread.thread().id() != std::thread::current().id() {
                let _ = thread.join();
            }
        }
    }
}

/// Participant GUID, for tests and logs.
impl Node {
    /// DDS GUID of the node's participant.
    ///
    /// # Errors
    /// The node is shut down.
    pub fn participant_guid(&self) -> Result<Guid, RosError> {
        self.with_participant(|participant| participant.guid().to_bytes())
    }
}

/// Joins a name below the node's private namespace.
pub(super) fn private(name: &str) -> String {
    format!("~/{name}")
}
