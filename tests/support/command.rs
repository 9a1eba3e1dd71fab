// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Command of the cell under test, shared with every participant of its domain: tests drive it by many nodes and peers.
#![allow(dead_code, reason = "each test target uses its part")]
#![allow(unreachable_pub, reason = "a module of test binaries has no outside")]

use super::{Domain, PATIENCE};
use camwright_authority::{HeldCommand, TakeOptions};
use camwright_ros::{Node, NodeOptions, RosArgs, SpinThread};
use std::time::Duration;

fn options() -> TakeOptions {
    TakeOptions { patience: PATIENCE, lease_s: 3600.0, ..TakeOptions::new("the test").shared() }
}

/// Shares command of a machine; the node spins on another thread.
pub fn share_command(node: &Node) -> HeldCommand {
    HeldCommand::acquire(node, &options()).expect("command of the machine")
}

/// Shares command of machine and interpolator, once they know each other.
pub fn share_command_of_axes(node: &Node) -> HeldCommand {
    HeldCommand::acquire(node, &TakeOptions { interpolator: true, ..options() }).expect("command of the axes")
}

/// Shares command of a whole cell, once its nodes know each other.
pub fn share_command_of_cell(node: &Node) -> HeldCommand {
    HeldCommand::acquire(node, &options().for_cell()).expect("command of the cell")
}

/// Command that a node of its own shares and renews, also after the machine was started again.
pub struct Shared {
    node: Node,
    spin: Option<SpinThread>,
    command: Option<HeldCommand>,
}

impl Shared {
    /// Shares command of the cell in a namespace; hidden as the name is, lists of nodes stay as they are.
    pub fn for_cell(domain: &Domain, namespace: &str) -> Self {
        Self::acquire(domain, namespace, &options().for_cell())
    }

    /// Shares command of a machine alone.
    pub fn for_machine(domain: &Domain, namespace: &str) -> Self {
        Self::acquire(domain, namespace, &options())
    }

    fn acquire(domain: &Domain, namespace: &str, options: &TakeOptions) -> Self {
        let args = RosArgs::default().with_domain_id(domain.id());
        let args = if namespace.is_empty() { args } else { args.with_namespace(namespace) };
        let node = Node::new(NodeOptions::new("_command", &args)).expect("a node");
        let spin = node.spin_in_thread().expect("a thread");
        let command = HeldCommand::acquire(&node, options).expect("command of the cell");
        Self { node, spin: Some(spin), command: Some(command) }
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        self.command.take();
        self.spin.take();
        self.node.shutdown();
        // Names are forgotten everywhere before a test looks at them.
        std::thread::sleep(Duration::from_millis(10));
    }
}
