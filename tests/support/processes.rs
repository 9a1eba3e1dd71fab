//! The four nodes as processes, and what a peer does with the cell that they are.

use super::{Domain, Guarded, PATIENCE, Peer, PeerEnv, repository};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Command;

pub const RUN_JOB: &str = "camwright_msgs/action/RunJob";
/// Number of `action_msgs/GoalStatus`.
pub const SUCCEEDED: u64 = 4;

/// Recorder, machine, interpolator and planner, each a process, in a namespace.
pub struct Processes {
    nodes: Vec<(&'static str, Guarded)>,
    bag: PathBuf,
}

impl Processes {
    /// Starts them; `machine` are more parameters of the machine.
    pub fn start(domain: &Domain, namespace: &str, machine: &[&str], bag: &Path) -> Self {
        let directory = format!("bag_dir:={}", bag.display());
        let machine = [&["pace:=fast", "state_file:=none"], machine].concat();
        let binaries: [(&'static str, &str, &[&str]); 4] = [
            ("run_logger", env!("CARGO_BIN_EXE_run_logger"), &[&directory, "use_sim_time:=true"]),
            ("machine_sim", env!("CARGO_BIN_EXE_machine_sim"), &machine),
            ("axis_interpolator", env!("CARGO_BIN_EXE_axis_interpolator"), &[]),
            ("job_planner", env!("CARGO_BIN_EXE_job_planner"), &[]),
        ];
        let start = |(name, binary, parameters): (&'static str, &str, &[&str])| {
            let mut command = in_domain(binary, domain);
            command.args(["--ros-args", "-r", &format!("__ns:={namespace}")]);
            for parameter in parameters {
                command.args(["-p", parameter]);
            }
            (name, Guarded::start(name, &mut command))
        };
        Self { nodes: binaries.map(start).into(), bag: bag.to_owned() }
    }

    /// Ctrl-C to every node, the recorder last: each ends well.
    pub fn end(mut self) -> PathBuf {
        for (name, node) in self.nodes.iter_mut().rev() {
            assert!(node.is_running(), "{name} has ended by itself{}", node.complaint());
            node.interrupt();
            let status = node.wait(PATIENCE);
            assert!(status.success(), "{name} ends with {status} on Ctrl-C{}", node.complaint());
        }
        self.bag
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

/// What the peer does with the cell under a namespace.
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
