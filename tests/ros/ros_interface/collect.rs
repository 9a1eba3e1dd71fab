// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Topics, services, actions and parameters of the running nodes.

use super::support::{Domain, Folder, PATIENCE};
use camwright_axis_interpolator::AxisInterpolator;
use camwright_job_planner::JobPlanner;
use camwright_machine_sim::MachineSim;
use camwright_msgs::camwright_msgs::msg::InterpolatorState;
use camwright_ros::{EndpointInfo, Node, NodeOptions, Parameter, ParameterValue, Qos, RosArgs};
use camwright_run_logger::RunLogger;
use std::collections::BTreeMap;
use std::sync::mpsc;
use std::time::Instant;

/// Namespace in which the nodes run, so that relative and absolute names differ.
const NAMESPACE: &str = "/cell";

/// Equipment of a machine whose endpoints the default machine lacks, with the parameters that select it.
const EQUIPMENT: [(&str, &[&str]); 4] = [
    ("machine with gauge", &["machine:=journal_grinder"]),
    ("lathe", &["machine:=lathe"]),
    (
        "machine with `loading`",
        &[
            "machine_overrides:=[\"loading={door: {opens_ms: 500, closes_ms: 500}, chuck: {opens_ms: 200, closes_ms: 200}, safe_x_mm: 120}\"]",
        ],
    ),
    ("pace fast", &["pace:=fast"]),
];

/// Endpoint of a topic.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Topic {
    /// Name relative to the namespace, `~/` for that of the node.
    pub(super) name: String,
    pub(super) type_name: String,
    pub(super) qos: Qos,
    /// Equipment that the endpoint needs.
    pub(super) only_with: Option<&'static str>,
}

/// Service or action.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Call {
    pub(super) name: String,
    pub(super) type_name: String,
    pub(super) only_with: Option<&'static str>,
}

/// Interface of a node.
#[derive(Debug, Clone, Default)]
pub(super) struct Interface {
    pub(super) node: String,
    /// True if the lease of command decides on requests to the node.
    pub(super) has_authority: bool,
    pub(super) published: Vec<Topic>,
    pub(super) subscribed: Vec<Topic>,
    pub(super) services: Vec<Call>,
    pub(super) actions: Vec<Call>,
    /// Actions that the node calls.
    pub(super) called_actions: Vec<Call>,
    pub(super) parameters: Vec<Parameter>,
}

impl Interface {
    /// Small interface for tests of the pages.
    pub(super) fn example() -> Self {
        let (name, type_name) = ("~/state".to_owned(), "camwright_msgs/msg/CellState".to_owned());
        let stop = Call { name: "~/stop".into(), type_name: "std_srvs/srv/Trigger".into(), only_with: None };
        Self {
            node: "example".into(),
            published: vec![Topic { name, type_name, qos: Qos::latched(1), only_with: None }],
            services: vec![stop],
            ..Self::default()
        }
    }

    /// Own endpoints of a node, as it sees them itself: a discovered endpoint may lack the depth of its history.
    fn from_node(node: &Node) -> Self {
        let own = node.participant_guid().expect("a running node");
        let is_own = |endpoint: &&EndpointInfo| endpoint.guid[..12] == own[..12];
        let name_of = |absolute: &str| relative(absolute, node.name());
        let mut interface = Self { node: node.name().into(), has_authority: node.has_authority(), ..Self::default() };
        for topic in node.discovered_topics() {
            let name = name_of(&topic.name);
            let action = name.split_once("/_action/").map(|(action, part)| (action.to_owned(), part.to_owned()));
            for (endpoints, publishes) in [(&topic.publishers, true), (&topic.subscriptions, false)] {
                let Some(endpoint) = endpoints.iter().find(is_own) else { continue };
                let (type_name, only_with) = (topic.type_name.clone(), None);
                if let Some((action, part)) = &action {
                    let Some(type_name) = type_name.strip_suffix("_FeedbackMessage").filter(|_| part == "feedback")
                    else {
                        continue;
                    };
                    let call = Call { name: action.clone(), type_name: type_name.into(), only_with };
                    if publishes { interface.actions.push(call) } else { interface.called_actions.push(call) }
                } else {
                    let topic = Topic { name: name.clone(), type_name, qos: endpoint.qos, only_with };
                    if publishes { interface.published.push(topic) } else { interface.subscribed.push(topic) }
                }
            }
        }
        for service in
            node.discovered_services().iter().filter(|service| service.subscriptions.iter().any(|end| is_own(&end)))
        {
            let name = name_of(&service.name);
            if !name.contains("/_action/") {
                let type_name = service.type_name.trim_end_matches("_Request").to_owned();
                interface.services.push(Call { name, type_name, only_with: None });
            }
        }
        let parameters = node.parameters();
        interface.parameters = parameters.names().iter().filter_map(|name| parameters.declaration(name)).collect();
        interface
    }

    /// Adds the endpoints that another start of the node has in addition.
    fn add_missing(&mut self, other: Self, only_with: &'static str) {
        for (mine, theirs) in [(&mut self.published, other.published), (&mut self.subscribed, other.subscribed)] {
            for topic in theirs {
                if !mine.iter().any(|known| known.name == topic.name) {
                    mine.push(Topic { only_with: Some(only_with), ..topic });
                }
            }
            mine.sort_by(|a, b| a.name.cmp(&b.name));
        }
        for (mine, theirs) in [(&mut self.services, other.services), (&mut self.actions, other.actions)] {
            for call in theirs {
                if !mine.iter().any(|known| known.name == call.name) {
                    mine.push(Call { only_with: Some(only_with), ..call });
                }
            }
            mine.sort_by(|a, b| a.name.cmp(&b.name));
        }
    }
}

/// Name relative to the namespace, with `~` for the node.
fn relative(absolute: &str, node: &str) -> String {
    let Some(name) = absolute.strip_prefix(NAMESPACE).and_then(|rest| rest.strip_prefix('/')) else {
        return absolute.to_owned();
    };
    name.strip_prefix(node)
        .and_then(|rest| rest.strip_prefix('/'))
        .map_or_else(|| name.to_owned(), |own| format!("~/{own}"))
}

fn arguments(domain: &Domain, words: &[&str]) -> RosArgs {
    let words = words.iter().flat_map(|word| ["-p", word]);
    let words: Vec<String> = std::iter::once("--ros-args").chain(words).map(str::to_owned).collect();
    let (args, _) = RosArgs::parse_with(&words, |_| None).expect("arguments of a node");
    args.with_domain_id(domain.id()).with_namespace(NAMESPACE)
}

/// Interface of a machine with equipment.
fn machine_with(words: &[&str]) -> Interface {
    let words = [words, &["state_file:=none"]].concat();
    let machine = MachineSim::start(&arguments(&Domain::reserve(), &words)).expect("machine_sim");
    let mut interface = Interface::from_node(machine.node());
    if words.contains(&"pace:=fast") {
        // The clock has its publisher from the first tick on, once no other node publishes it.
        let deadline = Instant::now() + PATIENCE;
        while !interface.published.iter().any(|topic| topic.name == "/clock") {
            assert!(Instant::now() < deadline, "no /clock at pace fast");
            std::thread::yield_now();
            interface = Interface::from_node(machine.node());
        }
    }
    machine.stop();
    interface
}

/// The interfaces of the four nodes, each with the endpoints of all equipment.
pub(super) fn all() -> Vec<Interface> {
    let (folder, domain) = (Folder::new("ros-interface"), Domain::reserve());
    let args = arguments(&domain, &["state_file:=none"]);
    let machine = MachineSim::start(&args).expect("machine_sim");
    let interpolator = AxisInterpolator::start(&args).expect("axis_interpolator");
    wait_for_publishers(&args);
    let learned = ParameterValue::String(folder.path().display().to_string());
    let planner = JobPlanner::start(&args.clone().with_parameter(None, "learned_dir", learned)).expect("job_planner");
    // A recorder that is not active subscribes to nothing: its selection of topics is a parameter.
    let inactive = args.with_parameter(None, "autostart", ParameterValue::Bool(false));
    let recorder = RunLogger::start(&inactive).expect("run_logger");
    let nodes = [machine.node(), interpolator.node(), planner.node(), recorder.node()];
    let mut interfaces: Vec<Interface> = nodes.into_iter().map(Interface::from_node).collect();
    recorder.stop();
    planner.stop();
    interpolator.stop();
    machine.stop();
    for (only_with, words) in EQUIPMENT {
        interfaces[0].add_missing(machine_with(words), only_with);
    }
    interfaces
}

/// Waits for a state of the interpolator: it makes its publishers when it meets the machine, before the first state.
fn wait_for_publishers(args: &RosArgs) {
    let client = Node::new(NodeOptions::new("client", args)).expect("a node");
    let (sender, states) = mpsc::channel();
    let send = move |state: InterpolatorState, _: &_| drop(sender.send(state));
    let _state = client.subscribe("axis_interpolator/state", &Qos::latched(1), send).expect("a subscription");
    let _spin = client.spin_in_thread().expect("a thread");
    states.recv_timeout(PATIENCE).expect("a state of the interpolator");
    client.shutdown();
}

/// Elements that every interface has, and their removal from each.
pub(super) fn split_common(interfaces: &mut [Interface]) -> Interface {
    fn common<T: Clone + PartialEq>(interfaces: &mut [Interface], pick: fn(&mut Interface) -> &mut Vec<T>) -> Vec<T> {
        let Some((first, others)) = interfaces.split_first_mut() else { return Vec::new() };
        let in_all =
            |element: &T, others: &mut [Interface]| others.iter_mut().all(|other| pick(other).contains(element));
        let shared: Vec<T> = pick(first).iter().filter(|element| in_all(element, others)).cloned().collect();
        interfaces.iter_mut().for_each(|interface| pick(interface).retain(|element| !shared.contains(element)));
        shared
    }
    if interfaces.len() < 2 {
        return Interface::default();
    }
    Interface {
        published: common(interfaces, |interface| &mut interface.published),
        subscribed: common(interfaces, |interface| &mut interface.subscribed),
        services: common(interfaces, |interface| &mut interface.services),
        parameters: common(interfaces, |interface| &mut interface.parameters),
        has_authority: true,
        ..Interface::default()
    }
}

/// Names of all topics, services and actions with their types.
pub(super) fn names(interfaces: &[Interface]) -> BTreeMap<String, String> {
    let mut names = BTreeMap::new();
    for interface in interfaces {
        let topics = interface.published.iter().chain(&interface.subscribed);
        names.extend(topics.map(|topic| (topic.name.clone(), topic.type_name.clone())));
        let calls = interface.services.iter().chain(&interface.actions);
        names.extend(calls.map(|call| (call.name.clone(), call.type_name.clone())));
    }
    names
}
