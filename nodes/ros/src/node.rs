//! A node: one participant, one executor, and what every ROS 2 node has.

use std::{
    fmt,
    sync::{Arc, Mutex, Once, OnceLock, PoisonError},
    thread::JoinHandle,
    time::{Duration, Instant},
};

use camwright_msgs::builtin_interfaces;
use rustdds::{DomainParticipant, QosPolicies, RTPSEntity, Topic, TopicKind};

use super::args::RosArgs;
use super::authority_hook::Authority;
use super::clock::TimeSource;
use super::delay::{DelayInjection, DelaySource};
use super::discovery::{Graph, Guid, ParticipantEntities};
use super::error::RosError;
use super::executor::{Executor, TimerHandle};
use super::fastdds_workarounds::Beside;
use super::load::Load;
use super::logging::{Level, Logger};
use super::loopback::Loopback;
use super::names::{NameKind, Names};
use super::network::gate::Gate;
use super::network::{participant, watchdog};
use super::parameters::{Parameter, Parameters};
use super::qos::{Qos, WriterWindow};
use super::repeated_warnings::RepeatedWarnings;
use super::shutdown::{EXIT_FAILED, Shutdown};
use super::{logger_services, type_description};
use camwright_threads::supervised::Supervisor;

/// Time for a leaving node to send its farewell: 300 ms let real ROS 2 forget its name within 10 ms; without it names
/// stay for the lease of 50 s (measured with Fast DDS).
const FAREWELL: Duration = Duration::from_millis(300);

/// Time for discovery between a new participant and running ones, before it announces its first endpoint.
///
/// Discovery's own endpoints have then met, and every announcement arrives in order as it is made. Without the pause the first ones are
/// missing where a peer has just found us, `RustDDS` sends the next ones before it repeats those, and a Fast DDS peer that has such gaps
/// with several participants at once acknowledges the repeated announcements and yet drops some of them for good: of four nodes started
/// together next to a running rclpy node, names, topics or services of one or more were never seen there in ten of sixteen starts (none of 22
/// with the pause). The handshake was seen to take 70 to 100 ms on two busy cores.
const ACQUAINTANCE: Duration = Duration::from_millis(250);

/// Period at which a node that is closed to newcomers checks if it can open.
const GATE_PERIOD: Duration = Duration::from_secs(5);

/// Name, arguments, parameters and limits of a node to be created.
#[derive(Debug, Clone)]
pub struct NodeOptions {
    name: String,
    args: RosArgs,
    parameters: Vec<Parameter>,
    delay_injection: Option<DelayInjection>,
    writer_window: WriterWindow,
}

impl NodeOptions {
    /// Options of a node with a default name, which `args` may remap.
    pub fn new(name: &str, args: &RosArgs) -> Self {
        NodeOptions {
            name: name.to_string(),
            args: args.clone(),
            parameters: Vec::new(),
            delay_injection: DelayInjection::from_env(),
            writer_window: WriterWindow::default(),
        }
    }

    #[must_use]
    pub fn parameter(mut self, parameter: Parameter) -> Self {
        self.parameters.push(parameter);
        self
    }

    #[must_use]
    pub fn parameters(mut self, parameters: impl IntoIterator<Item = Parameter>) -> Self {
        self.parameters.extend(parameters);
        self
    }

    /// Sets how many unacknowledged samples its writers may hold (default: wide).
    #[must_use]
    pub fn writer_window(mut self, window: WriterWindow) -> Self {
        self.writer_window = window;
        self
    }

    /// Value that the arguments ask for a parameter; `None`: its default. Names that cannot be are refused when the node starts.
    pub fn asked(&self, parameter: &str) -> Option<super::parameter_value::ParameterValue> {
        let names = Names::new(&self.name, self.args.default_namespace(), self.args.remap_rules()).ok()?;
        let overrides = self.args.overrides_for(names.node(), &names.fully_qualified());
        overrides.into_iter().rev().find(|asked| asked.name == parameter).map(|asked| asked.value)
    }

    /// Delays the callbacks of subscriptions at random (default: what `CAMWRIGHT_DELAY_INJECTION=seed:max_ms` says).
    #[must_use]
    pub fn delay_injection(mut self, injection: Option<DelayInjection>) -> Self {
        self.delay_injection = injection;
        self
    }
}

/// The crate's node and its context, in the order in which they must go: the node says farewell, the context follows.
struct CrateSide {
    node: ros2_client::Node,
    context: ros2_client::Context,
    participant: DomainParticipant,
}

pub(super) struct NodeInner {
    names: Names,
    executor: Arc<Executor>,
    graph: Arc<Graph>,
    loopback: Arc<Loopback>,
    logger: Logger,
    parameters: OnceLock<Parameters>,
    clock: OnceLock<TimeSource>,
    beside: Arc<Beside>,
    delay_injection: Option<DelayInjection>,
    writer_window: WriterWindow,
    load: Arc<Load>,
    warnings: RepeatedWarnings,
    authority: OnceLock<Arc<dyn Authority>>,
    next_delay: Mutex<u64>,
    watch: Mutex<Option<watchdog::Watch>>,
    crate_side: Mutex<Option<CrateSide>>,
    retained: Mutex<Vec<Box<dyn std::any::Any + Send>>>,
    supervisor: Supervisor,
}

impl Drop for NodeInner {
    fn drop(&mut self) {
        self.leave();
    }
}

impl NodeInner {
    fn leave(&self) {
        let Some(side) = self.crate_side.lock().unwrap_or_else(PoisonError::into_inner).take() else { return };
        self.executor.close();
        self.logger.detach();
        self.retained.lock().unwrap_or_else(PoisonError::into_inner).clear();
        self.watch.lock().unwrap_or_else(PoisonError::into_inner).take();
        let CrateSide { node, context, participant } = side;
        // Dropping the node publishes the list of nodes without it; the participant must live until that is on its way.
        drop(node);
        std::thread::sleep(FAREWELL);
        self.beside.farewell();
        drop(context);
        drop(participant);
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
    inner: Arc<NodeInner>,
}

impl fmt::Debug for Node {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Node").field("name", &self.fully_qualified_name()).finish_non_exhaustive()
    }
}

impl Node {
    /// Joins the graph.
    ///
    /// # Errors
    /// A name or a parameter override is refused, or the network is.
    pub fn new(options: NodeOptions) -> Result<Self, RosError> {
        let NodeOptions { name, args, parameters, delay_injection, writer_window } = options;
        let names = Names::new(&name, args.default_namespace(), args.remap_rules())?;
        let fully_qualified = names.fully_qualified();
        let failed = |reason: String| RosError::create(format!("node {fully_qualified}"), reason);

        raise_descriptor_limit();
        args.unsupported().refuse().map_err(&failed)?;
        // One participant per node: status events go to a single reader per participant.
        let participant::Guarded { participant, vitals, gate } =
            participant::build(args.domain_id(), args.discovery_range()).map_err(failed)?;
        std::thread::sleep(ACQUAINTANCE);
        let context = ros2_client::Context::from_domain_participant(participant.clone())
            .map_err(|error| failed(error.to_string()))?;
        let node_name =
            ros2_client::NodeName::new(names.namespace(), names.node()).map_err(|error| failed(error.to_string()))?;
        // Its own rosout has depth 1, its parameter services live in the Spinner: both are ours instead.
        let crate_options = ros2_client::NodeOptions::new().enable_rosout(false).start_parameter_services(false);
        let node = context.new_node(node_name, crate_options).map_err(|error| failed(error.to_string()))?;

        let io = |source| RosError::Io { what: format!("node {fully_qualified}"), source };
        let executor = Executor::new().map_err(io)?;
        let (domain_id, participant_id) = (participant.domain_id(), participant.participant_id());
        let beside = Beside::new(participant.guid(), domain_id, participant_id, args.discovery_range()).map_err(io)?;
        let logger = Logger::new(&names, &args);
        let watch = watchdog::watch(vitals, report_death(&logger, &fully_qualified)).map_err(io)?;
        let graph = Arc::<Graph>::default();
        graph.set_own(participant.guid());
        let node = Node {
            inner: Arc::new(NodeInner {
                names,
                executor,
                loopback: Loopback::new(&graph),
                graph,
                logger,
                parameters: OnceLock::new(),
                clock: OnceLock::new(),
                beside: Arc::new(beside),
                delay_injection,
                writer_window,
                load: Arc::default(),
                warnings: RepeatedWarnings::default(),
                authority: OnceLock::new(),
                next_delay: Mutex::new(0),
                watch: Mutex::new(Some(watch)),
                crate_side: Mutex::new(Some(CrateSide { node, context, participant: participant.clone() })),
                retained: Mutex::default(),
                supervisor: Supervisor::default(),
            }),
        };
        let logger = node.logger().clone();
        node.supervisor().on_fault(move |fault| logger.error(fault));
        node.watch_graph(&participant, gate)?;
        node.logger().attach(&node)?;
        if let Some(warning) = args.unsupported().warning() {
            static ONCE: Once = Once::new();
            ONCE.call_once(|| node.logger().warn(&warning));
        }
        let parameters = Parameters::declare(&node, parameters, &args)?;
        let _ = node.inner.parameters.set(parameters);
        let _ = node.inner.clock.set(TimeSource::new(&node)?);
        node.parameters().offer_services(&node)?;
        type_description::offer(&node)?;
        logger_services::offer(&node)?;
        Ok(node)
    }

    fn watch_graph(&self, participant: &DomainParticipant, gate: Gate) -> Result<(), RosError> {
        let (graph, logger) = (Arc::clone(self.graph()), self.logger().clone());
        let gate = Arc::new(Mutex::new(gate));
        let (reopened, reporter) = (Arc::clone(&gate), logger.clone());
        self.retain(self.timer(GATE_PERIOD, move || {
            let sentence = reopened.lock().unwrap_or_else(PoisonError::into_inner).reopen();
            sentence.iter().for_each(|sentence| reporter.warn(sentence));
        }));
        let beside = Arc::clone(&self.inner.beside);
        let events = self
            .executor()
            .add_source(participant.status_listener(), |events| {
                Box::new(move |_| {
                    let mut gate = gate.lock().unwrap_or_else(PoisonError::into_inner);
                    for sentence in graph.drain(&events, &beside, &mut gate) {
                        logger.warn(&sentence);
                    }
                    false
                })
            })
            .map_err(|error| RosError::create("graph listener", error))?;
        self.retain(events);
        let graph = Arc::clone(self.graph());
        let nodes = self.reader(
            "ros_discovery_info",
            "ros_discovery_info".into(),
            "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_",
            &Qos::latched(1),
            false,
            move |participant: ParticipantEntities, _| graph.participant(participant),
        )?;
        self.retain(nodes);
        Ok(())
    }

    /// Keeps an endpoint, a timer or anything else until [`Node::shutdown`].
    ///
    /// A clone of the node in a retained callback keeps the node alive: call [`Node::shutdown`] then, a drop is not enough.
    pub fn retain(&self, endpoint: impl std::any::Any + Send) {
        self.inner.retained.lock().unwrap_or_else(PoisonError::into_inner).push(Box::new(endpoint));
    }

    pub(super) fn names(&self) -> &Names {
        &self.inner.names
    }

    pub(super) fn executor(&self) -> &Arc<Executor> {
        &self.inner.executor
    }

    pub(super) fn graph(&self) -> &Arc<Graph> {
        &self.inner.graph
    }

    pub(super) fn beside(&self) -> &Arc<Beside> {
        &self.inner.beside
    }

    /// Counts of what was refused or lost under load.
    pub(super) fn load(&self) -> &Arc<Load> {
        &self.inner.load
    }

    /// Warns once of what is refused again and again. Repetitions of `kind` within five seconds are counted and reported together.
    #[track_caller]
    pub fn warn_once(&self, kind: &str, text: &str) {
        if self.inner.warnings.is_first(self, kind) {
            self.inner.logger.warn(text);
        }
    }

    pub(super) fn warnings(&self) -> &RepeatedWarnings {
        &self.inner.warnings
    }

    /// Decides on the requests of others; empty: all are executed.
    pub(super) fn authority(&self) -> &OnceLock<Arc<dyn Authority>> {
        &self.inner.authority
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
        self.inner.parameters.get().expect("Node::new returns only after declaring them")
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
        self.inner.clock.get().map_or_else(camwright_threads::system_time::system_time_ns, TimeSource::now_ns)
    }

    /// ROS time as a message; see [`Node::now_ns`].
    pub fn now(&self) -> builtin_interfaces::msg::Time {
        super::clock::to_time(self.now_ns())
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
        self.inner.leave();
    }
}

/// Ends the process when the node's middleware has died: a node that neither hears nor speaks is of no use and seems to be alive.
fn report_death(logger: &Logger, node: &str) -> impl Fn(&str) + Send + use<> {
    let (logger, node) = (logger.clone(), node.to_owned());
    move |reason| {
        let text = format!(
            "{node} has lost its connection to the graph: {reason}. The process ends with exit code {EXIT_FAILED}; start it again. If it \
             happens again, look for a peer that sends malformed datagrams (README, Network and security)"
        );
        logger.log(Level::Fatal, &text);
        Shutdown::fail_process(&text);
    }
}

/// An endpoint takes three to seven file descriptors and a managed node with actions some 200 of them, so that a cell in one process
/// exceeds the 1024 that most systems give at first. They give more when asked.
fn raise_descriptor_limit() {
    static ONCE: Once = Once::new();
    // If it is refused, creating an endpoint fails with the system's own words once descriptors run out.
    ONCE.call_once(|| drop(rlimit::increase_nofile_limit(ENOUGH_DESCRIPTORS)));
}

const ENOUGH_DESCRIPTORS: u64 = 20_000;

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
