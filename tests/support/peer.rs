// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A real rclpy node that takes orders (`peer.py`): one JSON object a line each way.

use super::process::{Guarded, PATIENCE};
use super::{Domain, PeerEnv};
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::io::Write;
use std::process::{ChildStdin, Command};
use std::time::Instant;

/// Cyclone's configuration: the loopback interface, which has no multicast everywhere, and the participants there.
pub const LOOPBACK: &str = "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"lo\"/></Interfaces>\
     <AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>\
     <MaxAutoParticipantIndex>31</MaxAutoParticipantIndex><Peers><Peer Address=\"127.0.0.1\"/></Peers></Discovery></Domain></CycloneDDS>";

/// Process of the peer, and its unsolicited messages.
#[derive(Debug)]
pub struct Peer {
    process: Guarded,
    stdin: ChildStdin,
    next_id: u64,
    events: VecDeque<Value>,
    answers: VecDeque<Value>,
}

impl Peer {
    /// Starts a node with this name in the root namespace and waits until it is up.
    pub fn start(env: &PeerEnv, domain: &Domain, name: &str) -> Self {
        Self::start_with(env, domain, &[name])
    }

    /// The same with the arguments of `peer.py`: `NAME [--namespace NS] [--sim-time]`.
    pub fn start_with(env: &PeerEnv, domain: &Domain, arguments: &[&str]) -> Self {
        Self::start_script("peer.py", env.python("peer.py", domain).args(arguments))
    }

    /// Starts a peer on Cyclone DDS (`cyclone_peer.py`) that looks nowhere but on the loopback interface.
    pub fn start_cyclone(env: &PeerEnv, domain: &Domain, name: &str) -> Self {
        Self::start_script(
            "cyclone_peer.py",
            env.python("cyclone_peer.py", domain).arg(name).env("CYCLONEDDS_URI", LOOPBACK),
        )
    }

    /// Starts a script that takes orders as `peer.py` does, and waits until it is ready.
    pub fn start_script(name: &str, command: &mut Command) -> Self {
        let mut process = Guarded::start(name, command);
        let stdin = process.take_stdin();
        let mut peer = Self { process, stdin, next_id: 1, events: VecDeque::new(), answers: VecDeque::new() };
        peer.event("ready", |_| true);
        peer
    }

    /// Gives an order without waiting for its answer; [`Self::answer`] fetches that.
    pub fn order(&mut self, op: &str, arguments: Value) -> u64 {
        let id = self.next_id;
        self.next_id += 1;
        let mut command = arguments;
        command["op"] = json!(op);
        command["id"] = json!(id);
        writeln!(self.stdin, "{command}")
            .unwrap_or_else(|error| panic!("the peer is gone: {error}{}", self.process.complaint()));
        id
    }

    /// The answer to an order: its fields, or what went wrong.
    ///
    /// # Errors
    /// What the peer calls the error.
    pub fn answer(&mut self, id: u64) -> Result<Value, String> {
        let deadline = Instant::now() + PATIENCE;
        loop {
            if let Some(at) = self.answers.iter().position(|answer| answer["id"] == id) {
                let answer = self.answers.remove(at).expect("it was found there");
                return if answer["ok"] == true { Ok(answer) } else { Err(answer["error"].to_string()) };
            }
            self.read(deadline, &format!("the answer to order {id}"));
        }
    }

    /// Returns whether an order has been answered; waits a moment for it.
    pub fn has_answer(&mut self, id: u64) -> bool {
        if !self.answers.iter().any(|answer| answer["id"] == id)
            && let Some(line) = self.process.line_within(std::time::Duration::from_millis(20))
        {
            self.queue_line(&line);
        }
        self.answers.iter().any(|answer| answer["id"] == id)
    }

    /// Gives an order and waits for its answer.
    ///
    /// # Panics
    /// When the peer reports an error.
    pub fn ask(&mut self, op: &str, arguments: Value) -> Value {
        let message = arguments.to_string();
        let id = self.order(op, arguments);
        self.answer(id).unwrap_or_else(|error| panic!("{op} {message}: {error}{}", self.process.complaint()))
    }

    /// The first event of a kind that fits, taken out; waits for it. Other events stay.
    pub fn event(&mut self, kind: &str, fits: impl Fn(&Value) -> bool) -> Value {
        let deadline = Instant::now() + PATIENCE;
        let mut seen = 0;
        loop {
            while seen < self.events.len() {
                if self.events[seen]["event"] == kind && fits(&self.events[seen]) {
                    return self.events.remove(seen).expect("it was found there");
                }
                seen += 1;
            }
            self.read(deadline, &format!("event {kind}"));
        }
    }

    /// The next message on a subscribed topic.
    pub fn message(&mut self, topic: &str) -> Value {
        self.event("message", |event| event["topic"] == topic)["data"].take()
    }

    /// The first message on a subscribed topic that fits; those before it are dropped.
    pub fn message_where(&mut self, topic: &str, fits: impl Fn(&Value) -> bool) -> Value {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let message = self.message(topic);
            if fits(&message) {
                return message;
            }
            assert!(Instant::now() < deadline, "no message on {topic} fits; the last was {message}");
        }
    }

    /// Everything of a kind that has come so far, taken out. Does not wait.
    pub fn events_so_far(&mut self, kind: &str) -> Vec<Value> {
        // An answered question means that everything said before it has been read.
        self.ask("now", json!({}));
        let (wanted, others) = self.events.drain(..).partition(|event| event["event"] == kind);
        self.events = others;
        wanted.into()
    }

    /// Calls a service and gives its response.
    pub fn call(&mut self, service: &str, kind: &str, request: Value) -> Value {
        self.ask("call", json!({ "service": service, "type": kind, "request": request }))["response"].take()
    }

    fn read(&mut self, deadline: Instant, what: &str) {
        let left = deadline.saturating_duration_since(Instant::now());
        assert!(!left.is_zero(), "waited {PATIENCE:?} for {what}{}", self.process.complaint());
        let Some(line) = self.process.line(left) else {
            panic!("the peer ended while {what} was awaited{}", self.process.complaint());
        };
        self.queue_line(&line);
    }

    fn queue_line(&mut self, line: &str) {
        match serde_json::from_str::<Value>(line) {
            Ok(message) if message.get("event").is_some() => self.events.push_back(message),
            Ok(message) => self.answers.push_back(message),
            Err(error) => panic!("the peer said what is not JSON ({error}): {line}"),
        }
    }
}
