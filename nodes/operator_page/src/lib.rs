// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Operator page and operations of a running cell.
//!
//! The page shows state, alarms and the lobe during grinding, for a browser on this computer. [`Operator`] performs [`operation`]s for the
//! command line and, with control, for the page. [`FleetListener`] shows all cells of one or more domains, one line each.
//!
//! ```text
//! topics of the cell ─► Feed ─► Status, Shape (JSON) ─► /snapshot.json, /events ─► page.html
//! ```
//!
//! Without control the page is read-only: it subscribes to public topics and answers GET. With control it also answers POST with the token.

mod cell_snapshot;
mod control;
mod feed;
mod fleet;
mod holder_socket;
mod http;
pub mod operation;
mod operator;
mod state_line;
mod status;
mod subscriptions;
mod terminal;
mod viewers;

use camwright_ros::running::NodeError;
use camwright_ros::{Node, NodeOptions, RosArgs, SpinThread, Subscription};
use camwright_threads::supervised::Supervisor;
use cell_snapshot::CellSnapshot;
use control::Control;
use feed::Feed;
pub use fleet::{FleetCell, FleetListener};
pub use holder_socket::HolderSocket;
use http::Server;
use operation::END_OF_HISTORY;
pub use operator::Operator;
pub use status::Status;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

/// Default address of the page: this computer only.
pub const DEFAULT_ADDRESS: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 8080);

/// Maximum delay of occasional messages after the first message of the machine.
const OPTIONAL_NODES: Duration = Duration::from_millis(700);

/// Status of a cell that changes.
#[derive(Debug)]
pub struct StatusListener {
    node: Node,
    feed: Arc<Feed>,
    version: u64,
    _subscriptions: Vec<Subscription>,
    _spin: SpinThread,
}

impl StatusListener {
    /// Listens to the cell in the namespace of `args`.
    ///
    /// # Errors
    /// DDS cannot start.
    pub fn start(args: &RosArgs) -> Result<Self, NodeError> {
        let feed = Arc::<Feed>::default();
        let node = Node::new(NodeOptions::new("camwright_status", args))?;
        feed.set_cell(node.namespace());
        let subscriptions = subscriptions::subscribe(&node, &feed)?;
        let spin = node.spin_in_thread()?;
        Ok(Self { node, feed, version: 0, _subscriptions: subscriptions, _spin: spin })
    }

    /// Returns the status once all nodes were received. Without a message within `patience` it has no machine.
    #[must_use]
    pub fn find(&self, patience: Duration) -> Status {
        self.feed.status_when(patience, |snapshot| snapshot.stream.is_some());
        // Planner and recorder are optional.
        self.feed.status_when(OPTIONAL_NODES.min(patience), CellSnapshot::is_complete);
        // A writer of latched messages may repeat older ones first.
        self.feed.wait_for_quiet(END_OF_HISTORY, OPTIONAL_NODES.min(patience));
        self.feed.status_when(patience, CellSnapshot::is_current)
    }

    /// Waits up to `limit` for a message of the cell; returns the status.
    pub fn next(&mut self, limit: Duration) -> Status {
        self.version = self.feed.wait_newer(self.version, limit);
        self.feed.status_when(Duration::ZERO, |_| true)
    }

    /// Ends the node.
    pub fn stop(self) {
        self.node.shutdown();
    }
}

#[derive(Debug)]
pub struct OperatorPage {
    node: Node,
    server: Server,
    feed: Arc<Feed>,
    token: Option<String>,
    _subscriptions: Vec<Subscription>,
    _spin: SpinThread,
}

impl OperatorPage {
    /// Serves the page of the cell in the namespace of `args`; port 0 selects a free one. With `control` viewers with the token operate it.
    ///
    /// # Errors
    /// The address is in use or not of this computer, or DDS cannot start.
    pub fn start(args: &RosArgs, address: SocketAddr, control: bool) -> Result<Self, NodeError> {
        let feed = Arc::<Feed>::default();
        let supervisor = Supervisor::default();
        // Before DDS, so that a wrong port is reported at once.
        let mut server = Server::start(address, Arc::clone(&feed), &supervisor).map_err(|error| {
            NodeError::Parameter(format!("the operator page cannot be served at {address}: {error}"))
        })?;
        let subscribed = Node::new(NodeOptions::new("operator_page", args)).map_err(NodeError::from).and_then(|node| {
            feed.set_cell(node.namespace());
            let logger = node.logger().clone();
            supervisor.on_fault(move |fault| logger.error(fault));
            let subscriptions = subscriptions::subscribe(&node, &feed)?;
            let spin = node.spin_in_thread()?;
            Ok((node, subscriptions, spin))
        });
        match subscribed {
            Ok((node, subscriptions, spin)) => {
                let mut token = None;
                if control {
                    let control = Control::new(Operator::new(node.clone(), args, "operator page"))?;
                    token = Some(control.token().to_owned());
                    server.set_control(control);
                }
                Ok(Self { node, server, feed, token, _subscriptions: subscriptions, _spin: spin })
            }
            Err(error) => {
                server.stop();
                Err(error)
            }
        }
    }

    /// URL of the page; with control it contains the token.
    #[must_use]
    pub fn url(&self) -> String {
        let token = self.token.as_ref().map_or_else(String::new, |token| format!("#{token}"));
        format!("http://{}/{token}", self.address())
    }

    /// Address of the page.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.server.address()
    }

    /// Shows the last state of a cell that was ended on purpose, without an alarm.
    pub fn end_cell(&self) {
        self.feed.end_cell();
    }

    /// Ends the server, then the node.
    pub fn stop(mut self) {
        self.server.stop();
        self.node.shutdown();
    }
}
