//! The operator page: what the cell does, what is wrong, and the cam as it is ground, for a browser on this computer.
//!
//! ```text
//! topics of the cell ─► Feed ─► Status, Shape (JSON) ─► /snapshot.json, /events ─► page.html
//! ```
//!
//! It only looks: it subscribes to public topics, offers nothing and answers GET alone.

mod cell_snapshot;
mod feed;
mod http;
mod listening;
mod seats;
mod status;
mod text;
mod words;

use camwright_ros::running::NodeError;
use camwright_ros::{Node, NodeOptions, RosArgs, SpinThread, Subscription};
use camwright_threads::supervised::Supervisor;
use cell_snapshot::CellSnapshot;
use feed::Feed;
use http::Server;
pub(crate) use status::Status;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

/// Default address of the page: this computer only.
pub const USUAL_ADDRESS: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 8080);

/// Maximum delay of occasional messages after the machine was heard.
const LATECOMERS: Duration = Duration::from_millis(700);

/// The cell in the namespace of `args` as it is now; of one that is not heard within `patience` the status says so.
///
/// # Errors
/// DDS that cannot start.
pub fn look(args: &RosArgs, patience: Duration) -> Result<Status, NodeError> {
    let feed = Arc::<Feed>::default();
    let node = Node::new(NodeOptions::new("camwright_status", args))?;
    feed.set_cell(node.namespace());
    let subscriptions = listening::subscribe(&node, &feed)?;
    let spin = node.spin_in_thread()?;
    feed.look(patience, |known| known.stream.is_some());
    // Planner and recorder may not be there; who is there is heard by then.
    let status = feed.look(LATECOMERS.min(patience), CellSnapshot::is_complete);
    drop((subscriptions, spin));
    node.shutdown();
    Ok(status)
}

#[derive(Debug)]
pub struct OperatorPage {
    node: Node,
    server: Server,
    _subscriptions: Vec<Subscription>,
    _spin: SpinThread,
}

impl OperatorPage {
    /// Serves the page of the cell in the namespace of `args`; port 0 takes a free one.
    ///
    /// # Errors
    /// An address that is taken or is not of this computer, DDS that cannot start.
    pub fn start(args: &RosArgs, address: SocketAddr) -> Result<Self, NodeError> {
        let feed = Arc::<Feed>::default();
        let supervisor = Supervisor::default();
        // Before DDS: whoever mistypes the port shall hear of it at once.
        let mut server = Server::start(address, Arc::clone(&feed), &supervisor).map_err(|error| {
            NodeError::Parameter(format!("the operator page cannot be served at {address}: {error}"))
        })?;
        let listening = Node::new(NodeOptions::new("operator_page", args)).map_err(NodeError::from).and_then(|node| {
            feed.set_cell(node.namespace());
            let logger = node.logger().clone();
            supervisor.on_fault(move |fault| logger.error(fault));
            let subscriptions = listening::subscribe(&node, &feed)?;
            let spin = node.spin_in_thread()?;
            Ok((node, subscriptions, spin))
        });
        match listening {
            Ok((node, subscriptions, spin)) => Ok(Self { node, server, _subscriptions: subscriptions, _spin: spin }),
            Err(error) => {
                server.stop();
                Err(error)
            }
        }
    }

    /// Address of the page.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.server.address()
    }

    /// Ends the server, then the node.
    pub fn stop(mut self) {
        self.server.stop();
        self.node.shutdown();
    }
}
