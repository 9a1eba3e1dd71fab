// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Server: one thread with all connections and all values, so that a subscription misses no change after its first value.

use super::alerts::AlertEvent;
use super::feed::{UaUpdate, UaUpdates};
use super::model;
use super::nodes::NODES;
use super::space::{CellNodeSet, NodeIds};
use camwright_ros::Logger;
use camwright_ros::liveness::LimitedWarning;
use camwright_threads::supervised::{Supervisor, injected};
use opcua::nodes::Event;
use opcua::server::node_manager::memory::{SimpleNodeManager, simple_node_manager_imports};
use opcua::server::{
    ANONYMOUS_USER_TOKEN_ID, Limits, Server, ServerBuilder, ServerEndpoint, ServerHandle, SubscriptionLimits,
};
use opcua::types::{BuildInfo, DataValue, DateTime, NodeId};
use std::fmt::Write as _;
use std::net::{SocketAddr, TcpListener};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::runtime::Runtime;
use tracing::field::{Field, Visit};
use tracing::subscriber::{NoSubscriber, set_default, with_default};
use tracing::{Level, Metadata, span};

/// Name of the thread.
const THREAD: &str = "gateway opcua";
/// Time of an orderly end.
const CLOSING: Duration = Duration::from_secs(1);
/// Changes of a node that wait for the client, if it asks for so many.
const MAX_QUEUE: usize = 1000;
/// Messages that wait for a request of the client: one for each publishing interval with changes.
const MAX_MESSAGES: usize = 600;
/// Folder of certificates. There are none, and the library makes its folders at no other place.
const NO_CERTIFICATES: &str = "/dev/null/pki";

/// 100 ns between 1601, where times of OPC UA begin, and 1970.
const TICKS_TO_1970: i64 = 116_444_736_000_000_000;

/// Time of OPC UA of a time in ns since 1970.
pub(super) fn ua_time(ns_since_1970: i64) -> DateTime {
    DateTime::from(ns_since_1970 / 100 + TICKS_TO_1970)
}

/// Parts of a server before it runs.
#[derive(Debug)]
pub(crate) struct UaSetup {
    pub(super) listener: TcpListener,
    pub(super) set: CellNodeSet,
    pub(super) updates: UaUpdates,
}

/// The running server.
pub(crate) struct UaServer {
    address: SocketAddr,
    handle: ServerHandle,
    thread: Option<JoinHandle<Option<()>>>,
}

impl std::fmt::Debug for UaServer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("UaServer").field("address", &self.address).finish_non_exhaustive()
    }
}

impl UaServer {
    pub(super) fn start(setup: UaSetup, logger: &Logger, supervisor: &Supervisor) -> Result<Self, String> {
        let address = setup.listener.local_addr().map_err(|error| error.to_string())?;
        let (sender, ready) = channel();
        let logger = logger.clone();
        let thread = supervisor.spawn(THREAD, move || run(setup, &logger, &sender)).map_err(|e| e.to_string())?;
        // The thread reports once, or has died and was reported.
        let handle = ready.recv().unwrap_or_else(|_| Err("its thread has ended".to_owned()))?;
        Ok(Self { address, handle, thread: Some(thread) })
    }

    pub(crate) fn address(&self) -> SocketAddr {
        self.address
    }

    /// Closes all connections and ends the thread.
    pub(crate) fn stop(&mut self) {
        self.handle.cancel();
        if let Some(thread) = self.thread.take() {
            // Its death was reported.
            let _reported = thread.join();
        }
    }
}

impl Drop for UaServer {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Work of the thread.
fn run(setup: UaSetup, logger: &Logger, ready: &Sender<Result<ServerHandle, String>>) {
    // The starter waits for the report.
    let report = |result| drop(ready.send(result));
    let runtime = match tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build() {
        Ok(runtime) => runtime,
        Err(error) => return report(Err(error.to_string())),
    };
    let UaSetup { listener, set, updates } = setup;
    let (uri, address) = (set.uri.clone(), listener.local_addr());
    let built = address.map_err(|error| error.to_string()).and_then(|address| build(&runtime, address, set));
    let (server, handle) = match built {
        Ok(built) => built,
        Err(error) => return report(Err(error)),
    };
    let ids = NodeIds::find(|namespace| handle.get_namespace_index(namespace.uri().unwrap_or(&uri)));
    let manager = handle.node_managers().get_of_type::<SimpleNodeManager>();
    let (Some(ids), Some(manager)) = (ids, manager) else {
        return report(Err("its address space is incomplete".to_owned()));
    };
    let _log = set_default(LibraryWarnings { logger: logger.clone(), warning: Mutex::default() });
    report(Ok(handle.clone()));
    let space = Space { ids, manager, handle: handle.clone(), alerts: 0 };
    let ended = runtime.block_on(async {
        listener.set_nonblocking(true).map_err(|error| error.to_string())?;
        let listener = tokio::net::TcpListener::from_std(listener).map_err(|error| error.to_string())?;
        let overdue = async {
            handle.token().cancelled().await;
            tokio::time::sleep(CLOSING).await;
        };
        tokio::select! {
            ended = server.run_with(listener) => ended,
            () = space.follow(updates, logger) => Ok(()),
            () = overdue => Ok(()),
        }
    });
    if let Err(error) = ended {
        logger.error(&format!("the OPC UA server has ended: {error}; restart the gateway"));
    }
}

fn build(runtime: &Runtime, address: SocketAddr, set: CellNodeSet) -> Result<(Server, ServerHandle), String> {
    // The library reads the working directory for its default folder of certificates, and panics without one.
    std::env::current_dir().map_err(|error| format!("the working directory cannot be read: {error}"))?;
    let _context = runtime.enter();
    let host = match address {
        SocketAddr::V4(address) => address.ip().to_string(),
        SocketAddr::V6(address) => format!("[{}]", address.ip()),
    };
    let version = env!("CARGO_PKG_VERSION");
    let subscriptions = SubscriptionLimits {
        // No interval is too short: a client that asks for 0 gets every change.
        min_sampling_interval_ms: 0.0,
        max_monitored_item_queue_size: MAX_QUEUE,
        max_queued_notifications: MAX_MESSAGES,
        ..SubscriptionLimits::default()
    };
    let builder = ServerBuilder::new()
        .application_name("camwright gateway")
        .application_uri("urn:camwright:gateway")
        .product_uri("urn:camwright:gateway")
        .build_info(BuildInfo {
            product_uri: "urn:camwright:gateway".into(),
            manufacturer_name: "The camwright maintainers".into(),
            product_name: "camwright gateway".into(),
            software_version: version.into(),
            build_number: version.into(),
            build_date: DateTime::null(),
        })
        .host(host)
        .port(address.port())
        .pki_dir(NO_CERTIFICATES)
        .limits(Limits { subscriptions, ..Limits::default() })
        .add_endpoint("none", ServerEndpoint::new_none("/", &[ANONYMOUS_USER_TOKEN_ID.to_owned()]))
        .discovery_urls(vec!["/".to_owned()])
        .with_node_manager(simple_node_manager_imports(vec![Box::new(set)], "camwright"));
    // It warns of missing certificates, which no endpoint needs.
    with_default(NoSubscriber::default(), || builder.build())
}

/// Address space of the running server.
struct Space {
    ids: NodeIds,
    manager: Arc<SimpleNodeManager>,
    handle: ServerHandle,
    /// Alerts so far.
    alerts: u64,
}

impl Space {
    /// Applies updates until the feed ends.
    async fn follow(mut self, mut updates: UaUpdates, logger: &Logger) {
        while let Some(update) = updates.updates.recv().await {
            injected::point(THREAD);
            let lost = updates.take_lost();
            if lost > 0 {
                logger.warn(&format!("{lost} updates of the OPC UA server are lost: it is too slow for the cell"));
            }
            self.apply(update, logger);
        }
    }

    fn apply(&mut self, update: UaUpdate, logger: &Logger) {
        let time = ua_time(update.time_ns);
        let changed =
            update.changes.iter().filter_map(|(index, reading)| NODES.get(*index).map(|node| (node, reading)));
        let values: Vec<(NodeId, DataValue)> =
            changed.flat_map(|(node, reading)| self.ids.values(node, reading, time)).collect();
        let values = values.iter().map(|(id, value)| (id, None, value.clone()));
        if let Err(status) = self.manager.set_values(self.handle.subscriptions(), values) {
            logger.error(&format!("the OPC UA server has no node for a value: {status}"));
        }
        let source = self.ids.path("Notification/Messages");
        for change in update.alarms {
            self.alerts += 1;
            let ids = (self.ids.model(model::ALERT), source.clone());
            let event = AlertEvent::new(change, ids, time, self.alerts);
            self.handle.subscriptions().notify_events(std::iter::once((&event as &dyn Event, &source)));
        }
    }
}

/// Passes warnings and errors of the library to the log of the node, at most one a second.
struct LibraryWarnings {
    logger: Logger,
    warning: Mutex<LimitedWarning>,
}

/// Text of a log line.
#[derive(Default)]
struct LineText(String);

impl Visit for LineText {
    fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
        // A string takes everything.
        let _infallible = match field.name() {
            "message" => write!(self.0, " {value:?}"),
            name => write!(self.0, " {name}={value:?}"),
        };
    }
}

impl tracing::Subscriber for LibraryWarnings {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        // Without certificates there is no endpoint that needs any; the library warns of them at every connection.
        *metadata.level() <= Level::WARN && metadata.target() != "opcua_core::comms::secure_channel"
    }

    fn new_span(&self, _: &span::Attributes<'_>) -> span::Id {
        span::Id::from_u64(1)
    }

    fn record(&self, _: &span::Id, _: &span::Record<'_>) {}

    fn record_follows_from(&self, _: &span::Id, _: &span::Id) {}

    fn event(&self, event: &tracing::Event<'_>) {
        let mut line = LineText::default();
        event.record(&mut line);
        let mut warning = self.warning.lock().unwrap_or_else(PoisonError::into_inner);
        warning.warn(&self.logger, &format!("OPC UA server:{}", line.0));
    }

    fn enter(&self, _: &span::Id) {}

    fn exit(&self, _: &span::Id) {}
}

#[cfg(test)]
mod tests {
    use super::super::model::UaNamespace;
    use super::*;
    use opcua::types::DateTimeUtc;

    #[test]
    fn a_time_is_that_of_the_system_clock() {
        assert_eq!(ua_time(0), DateTime::ymd(1970, 1, 1));
        let time: DateTimeUtc = ua_time(1_795_230_900_123_456_700).into();
        assert_eq!(time.timestamp_nanos_opt(), Some(1_795_230_900_123_456_700));
    }

    #[test]
    fn all_added_namespaces_have_an_index() {
        let ids = NodeIds::find(|namespace| Some(10 + namespace.index())).expect("all are known");
        assert_eq!(ids.index(UaNamespace::Core), 0);
        assert_eq!(ids.model(model::ALERT), NodeId::new(13, 39));
        assert_eq!(ids.path(""), NodeId::new(14, "Machine"));
        assert!(NodeIds::find(|namespace| (namespace != UaNamespace::Di).then_some(2)).is_none());
    }
}
