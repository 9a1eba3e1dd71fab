// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Start of a node: options, participant, and the endpoints that every ROS 2 node has.

use std::sync::{Arc, Mutex, Once, OnceLock, PoisonError};
use std::time::Duration;

use camwright_threads::supervised::Supervisor;
use rustdds::{DomainParticipant, DomainParticipantStatusEvent, RTPSEntity, StatusEvented};

use super::args::RosArgs;
use super::delay::DelayInjection;
use super::discovery::Graph;
use super::early_events::EarlyEvents;
use super::error::RosError;
use super::executor::Executor;
use super::fastdds_workarounds::FastDdsWorkarounds;
use super::introspection::{self, Introspection};
use super::level::Level;
use super::logging::Logger;
use super::loopback::Loopback;
use super::names::NodeNames;
use super::network::gate::ParticipantGate;
use super::network::{participant, watchdog};
use super::node::{CrateSide, Node, NodeInner};
use super::parameter_value::ParameterValue;
use super::parameters::{Parameter, Parameters};
use super::participant_entities::ParticipantEntities;
use super::qos::{Qos, WriterWindow};
use super::repeated_warnings::RepeatedWarnings;
use super::shutdown::{EXIT_FAILED, Shutdown};
use super::topics::ReaderRequest;
use super::{logger_services, parameter_services, rosout, sim_time, type_description};

/// Lists of nodes that a reader keeps until its node spins: one from each participant, and changes. `RustDDS` has one cache for all writers of
/// a topic, so that of a smaller depth the list of the last participant would remain.
const NODE_LISTS: u32 = 512;
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
    pub fn asked(&self, parameter: &str) -> Option<ParameterValue> {
        let names = NodeNames::new(&self.name, self.args.default_namespace(), self.args.remap_rules()).ok()?;
        let overrides = self.args.overrides_for(names.node(), &names.fully_qualified());
        overrides.into_iter().rev().find(|asked| asked.name == parameter).map(|asked| asked.value)
    }

    /// Name of the node; `args` may remap it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Parameters that the node will have, with the values of the arguments. The node is not started.
    ///
    /// # Errors
    /// A name or a parameter of the arguments is refused.
    pub fn declared(&self) -> Result<Parameters, RosError> {
        let names = NodeNames::new(&self.name, self.args.default_namespace(), self.args.remap_rules())?;
        let overrides = self.args.overrides_for(names.node(), &names.fully_qualified());
        Parameters::declare(self.parameters.clone(), &overrides)
    }

    /// Delays the callbacks of subscriptions at random (default: what `CAMWRIGHT_DELAY_INJECTION=seed:max_ms` says).
    #[must_use]
    pub fn delay_injection(mut self, injection: Option<DelayInjection>) -> Self {
        self.delay_injection = injection;
        self
    }
}

impl Node {
    /// Joins the graph.
    ///
    /// # Errors
    /// A name or a parameter override is refused, or the network is.
    pub fn new(options: NodeOptions) -> Result<Self, RosError> {
        let NodeOptions { name, args, parameters, delay_injection, writer_window } = options;
        let names = NodeNames::new(&name, args.default_namespace(), args.remap_rules())?;
        let fully_qualified = names.fully_qualified();
        let failed = |reason: String| RosError::create(format!("node {fully_qualified}"), reason);

        raise_descriptor_limit();
        args.unsupported().refuse().map_err(&failed)?;
        let overrides = args.overrides_for(names.node(), &fully_qualified);
        let parameters = Parameters::declare(parameters, &overrides)?;
        // One participant per node: status events go to a single reader per participant.
        let participant::WatchedParticipant { participant, vitals, gate } =
            participant::build(args.domain_id(), args.discovery_range()).map_err(failed)?;
        let listener = participant.status_listener();
        let early = EarlyEvents::collect(move || listener.try_recv_status())
            .map_err(|source| RosError::Io { what: format!("node {fully_qualified}"), source })?;
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
        let beside = FastDdsWorkarounds::new(participant.guid(), domain_id, participant_id, args.discovery_range())
            .map_err(io)?;
        let logger = Logger::new(&names, &args);
        let watch = watchdog::watch(vitals, report_death(&logger, &fully_qualified)).map_err(io)?;
        let graph = Arc::<Graph>::default();
        graph.set_own(participant.guid());
        let node = Node {
            inner: Arc::new(NodeInner {
                names,
                loopback: Loopback::new(&graph, &participant.guid(), args.intra_process()),
                graph,
                parameters,
                clock: Arc::default(),
                beside: Arc::new(beside),
                delay_injection,
                writer_window,
                load: Arc::default(),
                introspection: Introspection::default(),
                warnings: RepeatedWarnings::new(&executor, &logger),
                logger,
                executor,
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
        node.watch_graph(&participant, early, gate)?;
        rosout::connect(&node)?;
        node.logger().serve_process();
        if let Some(warning) = args.unsupported().warning() {
            static ONCE: Once = Once::new();
            ONCE.call_once(|| node.logger().warn(&warning));
        }
        for unknown in overrides.iter().filter(|o| o.explicit && node.parameters().get(&o.name).is_none()) {
            node.logger().warn(&format!("parameter '{}' was given but is not known to this node", unknown.name));
        }
        parameter_services::publish_events(&node)?;
        sim_time::follow_parameter(&node)?;
        introspection::follow_parameters(&node);
        parameter_services::offer(&node)?;
        type_description::offer(&node)?;
        logger_services::offer(&node)?;
        Ok(node)
    }

    fn watch_graph(
        &self,
        participant: &DomainParticipant,
        mut early: EarlyEvents<DomainParticipantStatusEvent>,
        gate: ParticipantGate,
    ) -> Result<(), RosError> {
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
                    for sentence in graph.drain(early.finish(), &events, &beside, &mut gate) {
                        logger.warn(&sentence);
                    }
                    false
                })
            })
            .map_err(|error| RosError::create("graph listener", error))?;
        self.retain(events);
        let graph = Arc::clone(self.graph());
        let nodes = self.reader(
            ReaderRequest {
                name: "ros_discovery_info",
                dds_name: "ros_discovery_info".into(),
                dds_type: "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_",
                qos: &Qos::latched(NODE_LISTS),
                delayable: false,
            },
            move |participant: ParticipantEntities, _| graph.participant(participant),
        )?;
        self.retain(nodes);
        Ok(())
    }
}

/// Ends the process when the node's middleware has died: a node that neither hears nor speaks is of no use and seems to be alive.
fn report_death(logger: &Logger, node: &str) -> impl Fn(&str) + Send + use<> {
    let (logger, node) = (logger.clone(), node.to_owned());
    move |reason| {
        let text = format!(
            "{node} has lost its connection to the graph: {reason}. The process ends with exit code {EXIT_FAILED}; start it again. A \
             process that was stopped (Ctrl-Z, a debugger) and continued ends like this. If it happens without, look for a peer that sends \
             malformed datagrams (docs/guides/network_and_security.md)"
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
