// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Performs operations with the authority that they need.

use super::holder_socket::{self, HolderSocket};
use super::operation::{Answer, Operation};
use camwright_authority::{HeldCommand, TakeError, TakeOptions};
use camwright_ros::{Node, RosArgs};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Maximum time to find the machine.
const MEETING: Duration = Duration::from_secs(5);

/// A client of the cell that takes command only for the time of an operation. The node must spin on another thread.
#[derive(Debug, Clone)]
pub struct Operator {
    node: Node,
    name: String,
    socket: PathBuf,
}

impl Operator {
    /// Operator with the name that other clients see while it has command. The node was made with `args`.
    #[must_use]
    pub fn new(node: Node, args: &RosArgs, name: &str) -> Self {
        let socket = holder_socket::path(args.domain_id(), node.namespace());
        Self { node, name: name.to_owned(), socket }
    }

    /// Performs an operation. A motion goes on while `goes_on` returns true.
    ///
    /// Stops are open to everyone. Other operations need command: the operator takes it, or passes the operation to the process of the
    /// same user that has it, such as `camwright run`.
    pub fn perform(&self, operation: &Operation, goes_on: &dyn Fn() -> bool) -> Answer {
        if operation.is_stop() {
            return self.ask_cell(operation, goes_on);
        }
        let options = TakeOptions { patience: MEETING, interpolator: true, ..TakeOptions::new(&self.name) };
        match HeldCommand::acquire(&self.node, &options) {
            Ok(_command) => {
                // Override, resume and others act on a motion while it lasts. Another process that serves the cell keeps its socket.
                let _socket = operation.lasts().then(|| HolderSocket::serve(self, self.node.supervisor()).ok());
                self.ask_cell(operation, goes_on)
            }
            Err(TakeError::Refused(reason)) => {
                let answer = holder_socket::ask(&self.socket, operation, goes_on);
                answer.unwrap_or_else(|| Answer::refused(format!("the machine refuses: {reason}")))
            }
            Err(error) => Answer::refused(error.to_string()),
        }
    }

    /// Performs an operation with the command that this process has already.
    pub(crate) fn ask_cell(&self, operation: &Operation, goes_on: &dyn Fn() -> bool) -> Answer {
        operation.perform(&self.node, goes_on).unwrap_or_else(|error| Answer::refused(error.to_string()))
    }

    /// Socket of the process that has command of this cell.
    pub(crate) fn socket(&self) -> &Path {
        &self.socket
    }
}
