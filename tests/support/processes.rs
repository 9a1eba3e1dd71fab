// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The four nodes as processes, and what a peer does with the cell that they are.

use super::command::Shared;
use super::{Domain, Guarded, PATIENCE, Peer, PeerEnv, repository};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Command;

pub const RUN_JOB: &str = "camwright_msgs/action/RunJob";
/// Number of `action_msgs/GoalStatus`.
pub const SUCCEEDED: u64 = 4;

/// Recorder, machine, interpolator and planner, each a process, in a namespace.
pub struct Processes {
    /// Everybody in its domain may command it.
    command: Option<Shared>,
    nodes: Vec<(&'static str, Guarded)>,
    bag: PathBuf,
}

const NAMES: [&str; 4] = ["run_logger", "machine_sim", "axis_interpolator", "job_planner"];

/// Starts one of the nodes; `more` are parameters in addition to those that tests give it.
fn start(name: &'static str, domain: &Domain, namespace: &str, bag: &Path, more: &[&str]) -> (&'static str, Guarded) {
    let directory = format!("bag_dir:={}", bag.display());
    let (binary, parameters): (&str, &[&str]) = match name {
        "run_logger" => (env!("CARGO_BIN_EXE_run_logger"), &[&directory, "use_sim_time:=true"]),
        "machine_sim" => (env!("CARGO_BIN_EXE_machine_sim"), &["pace:=fast", "state_file:=none"]),
        "axis_interpolator" => (env!("CARGO_BIN_EXE_axis_interpolator"), &[]),
        _ => (env!("CARGO_BIN_EXE_job_planner"), &[]),
    };
    let mut command = in_domain(binary, domain);
    command.args(["--ros-args", "-r", &format!("__ns:={namespace}")]);
    for parameter in parameters.iter().chain(more) {
        command.args(["-p", parameter]);
    }
    (name, Guarded::start(name, &mut command))
}

impl Processes {
    /// Starts them; `machine` are more parameters of the machine.
    pub fn start(domain: &Domain, namespace: &str, machine: &[&str], bag: &Path) -> Self {
        let mut processes = Self::start_without_command(domain, namespace, machine, bag);
        processes.command = Some(Shared::for_cell(domain, namespace));
        processes
    }

    /// Starts them; no client has command.
    pub fn start_without_command(domain: &Domain, namespace: &str, machine: &[&str], bag: &Path) -> Self {
        let more = |name| if name == "machine_sim" { machine } else { &[] };
        let nodes = NAMES.map(|name| start(name, domain, namespace, bag, more(name)));
        Self { command: None, nodes: nodes.into(), bag: bag.to_owned() }
    }

    /// Starts only some of them, none of which records.
    pub fn start_some(domain: &Domain, namespace: &str, names: &[&'static str]) -> Self {
        let nodes = names.iter().map(|name| start(name, domain, namespace, Path::new(""), &[])).collect();
        Self { command: None, nodes, bag: PathBuf::new() }
    }

    fn node(&mut self, name: &str) -> &mut (&'static str, Guarded) {
        self.nodes.iter_mut().find(|(other, _)| *other == name).expect("it was started")
    }

    /// Process id of a node.
    ///
    /// # Panics
    /// When it is not one of these.
    pub fn id(&self, name: &str) -> u32 {
        self.nodes.iter().find(|(node, _)| *node == name).expect("a node of the cell").1.id()
    }

    /// Ctrl-C to one node, which ends well.
    pub fn interrupt(&mut self, name: &str) {
        let (name, node) = self.node(name);
        assert!(node.is_running(), "{name} has ended by itself{}", node.complaint());
        node.interrupt();
        let status = node.wait(PATIENCE);
        assert!(status.success(), "{name} ends with {status} on Ctrl-C{}", node.complaint());
    }

    /// Kills one node.
    pub fn kill(&mut self, name: &str) {
        let (_, node) = self.node(name);
        node.signal("KILL");
        let _killed = node.wait(PATIENCE);
    }

    /// Starts a node again that has ended; what it records goes beside what it did before.
    pub fn restart(&mut self, name: &str, domain: &Domain, namespace: &str) {
        let bag = self.bag.with_extension("again");
        let ended = self.node(name);
        *ended = start(ended.0, domain, namespace, &bag, &[]);
    }

    /// Ctrl-C to every node, the recorder last: each ends well.
    pub fn end(mut self) -> PathBuf {
        self.command.take();
        let names: Vec<&str> = self.nodes.iter().rev().map(|(name, _)| *name).collect();
        for name in names {
            self.interrupt(name);
        }
        self.bag.clone()
    }
}

/// A binary of ours in a domain.
pub fn in_domain(binary: &str, domain: &Domain) -> Command {
    let mut command = Command::new(binary);
    command
        .current_dir(repository())
        .env("ROS_DOMAIN_ID", domain.id().to_string())
        .env("XDG_STATE_HOME", env!("CARGO_TARGET_TMPDIR"))
        .env_remove("ROS_NAMESPACE");
    command
}

/// A place for a bag, where nothing is.
pub fn fresh_bag(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("cell-{name}-{}", std::process::id()));
    let _not_there = std::fs::remove_dir_all(&path);
    path
}

/// rosbags, mcap and mcap-ros2-support read every message and agree on every count.
pub fn judge(env: &PeerEnv, domain: &Domain, bag: &Path) -> Value {
    let output = env.python("judge_bag.py", domain).arg(bag).output().expect("the judges can be called");
    assert!(output.status.success(), "the bag is refused: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("a verdict in JSON")
}

/// Actions of the peer with the cell under a namespace.
pub struct Operator<'a> {
    pub peer: &'a mut Peer,
    pub namespace: &'a str,
}

impl Operator<'_> {
    pub fn name(&self, relative: &str) -> String {
        format!("{}/{relative}", self.namespace)
    }

    pub fn subscribe(&mut self, topic: &str, kind: &str, qos: &str, keep: u32) {
        let topic = self.name(topic);
        self.peer.ask("subscribe", json!({ "topic": topic, "type": kind, "qos": qos, "keep": keep }));
    }

    pub fn message(&mut self, topic: &str) -> Value {
        let topic = self.name(topic);
        self.peer.message(&topic)
    }

    pub fn call(&mut self, service: &str, kind: &str, request: Value) -> Value {
        let service = self.name(service);
        self.peer.call(&service, kind, request)
    }

    /// Status and result of a goal that was accepted.
    pub fn result(&mut self, goal: &str) -> (u64, Value) {
        let mut answer = self.peer.ask("result", json!({ "goal": goal, "timeout": PATIENCE.as_secs() }));
        (answer["status"].as_u64().expect("a number"), answer["result"].take())
    }
}
