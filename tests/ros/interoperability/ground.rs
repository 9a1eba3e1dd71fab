// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Environment of a scenario: a domain, a peer, nodes of ours, and the table of its checks.

use super::matrix::{Column, Matrix};
use crate::support::{Domain, Peer, PeerEnv};
use camwright_ros::{Node, NodeOptions, Parameter, RosArgs, SpinThread};
use serde_json::{Value, json};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;

pub const STRING: &str = "std_msgs/msg/String";
pub const HOME: &str = "camwright_msgs/action/Home";
/// Numbers of `action_msgs/GoalStatus`.
pub const SUCCEEDED: u64 = 4;
pub const CANCELED: u64 = 5;
pub const ABORTED: u64 = 6;

/// A scenario's own domain, and where it reports to.
pub struct Ground<'a> {
    pub env: &'a PeerEnv,
    pub domain: Domain,
    pub column: Column,
    name: &'static str,
    matrix: &'a Mutex<Matrix>,
}

impl<'a> Ground<'a> {
    pub fn new(env: &'a PeerEnv, column: Column, name: &'static str, matrix: &'a Mutex<Matrix>) -> Self {
        Ground { env, domain: Domain::reserve(), column, name, matrix }
    }

    /// Runs a scenario. What fails outside of its checks fails as a row that nobody knows.
    pub fn walk(mut self, run: fn(&mut Ground<'_>)) {
        let (name, column) = (self.name, self.column);
        let begun = std::time::Instant::now();
        let result = catch_unwind(AssertUnwindSafe(|| run(&mut self)));
        eprintln!("{name} with {column:?}: {:.1} s", begun.elapsed().as_secs_f64());
        if let Err(panic) = result {
            let error = format!("the scenario {name} broke off: {}", panic_message(&*panic));
            self.matrix.lock().expect("entering does not panic here").stray(error, column);
        }
    }

    /// Tries something and enters what came out. The scenario goes on either way.
    pub fn check(&self, row: &'static str, run: impl FnOnce()) {
        let outcome = catch_unwind(AssertUnwindSafe(run)).map_err(|panic| panic_message(&*panic));
        self.matrix.lock().expect("entering panics for a defect of the test alone").enter(row, self.column, outcome);
    }

    /// A peer of the column's kind.
    pub fn peer(&self, name: &str) -> Peer {
        match self.column {
            Column::Jazzy | Column::Kilted => Peer::start(self.env, &self.domain, name),
            Column::Cyclone => Peer::start_cyclone(self.env, &self.domain, name),
        }
    }

    /// A node of ours with the words of a command line, spinning.
    pub fn node_with(&self, name: &str, words: &str, parameters: Vec<Parameter>) -> (Node, SpinThread) {
        let words: Vec<String> = words.split_whitespace().map(str::to_owned).collect();
        let (args, _) = RosArgs::parse_with(&words, |_| None).expect("valid arguments");
        let options = NodeOptions::new(name, &args.with_domain_id(self.domain.id())).parameters(parameters);
        let node = Node::new(options).expect("a node");
        let thread = node.spin_in_thread().expect("a thread");
        (node, thread)
    }

    /// The same without arguments.
    pub fn node(&self, name: &str) -> (Node, SpinThread) {
        self.node_with(name, "", Vec::new())
    }
}

fn panic_message(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().cloned();
    text.or_else(|| panic.downcast_ref::<&str>().map(ToString::to_string)).unwrap_or_else(|| "a panic".into())
}

/// Text of some length.
pub fn text(length: usize) -> String {
    "0123456789".chars().cycle().take(length).collect()
}

/// Waits until a node has left a peer's graph, with everything below a prefix of names.
pub fn wait_gone(peer: &mut Peer, node: (&str, &str), prefix: &str) {
    peer.ask("wait_gone", json!({ "name": node.1, "namespace": node.0, "prefix": prefix, "timeout": 20 }));
}

/// The texts of a JSON list.
pub fn strings(value: &Value) -> Vec<&str> {
    value.as_array().map(|list| list.iter().filter_map(Value::as_str).collect()).unwrap_or_default()
}
