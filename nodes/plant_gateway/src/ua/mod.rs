// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! OPC UA server of the gateway: machine tools (OPC 40501-1) on machinery (OPC 40001-1), read-only.
//!
//! ```text
//! CellMessages ─► nodes ─► UaFeed (changes) ─► thread of the server: address space ─► subscriptions of the clients
//! ```

mod alerts;
mod feed;
mod model;
mod nodes;
mod server;
mod space;

use camwright_ros::Logger;
use camwright_threads::supervised::Supervisor;
use camwright_threads::system_time::system_time_ns;
pub(crate) use feed::{UaFeed, UaUpdates};
pub(crate) use server::UaServer;
use server::UaSetup;
use std::net::{SocketAddr, TcpListener};

/// Options of the OPC UA server.
#[derive(Debug, Clone)]
pub struct UaOptions {
    /// Address to serve at; port 0 selects a free one.
    pub address: SocketAddr,
    /// Identification of the machine.
    pub nameplate: Nameplate,
}

/// Identification of the machine that no message has.
#[derive(Debug, Clone, Default)]
pub struct Nameplate {
    /// Maker of the machine.
    pub manufacturer: Option<String>,
    /// Serial number of the machine.
    pub serial_number: Option<String>,
    /// Globally unique identifier of the machine.
    pub product_instance_uri: Option<String>,
}

/// URI of the namespace of a cell: `urn:camwright:cell:cell_2` for `/cell_2`.
fn cell_uri(namespace: &str) -> String {
    let names = namespace.split('/').filter(|name| !name.is_empty());
    names.fold("urn:camwright:cell".to_owned(), |uri, name| format!("{uri}:{name}"))
}

/// Browse name of the machine in a namespace: that of the namespace, `cell` in `/`.
fn machine_name(namespace: &str) -> String {
    let name = namespace.trim_matches('/').replace('/', "_");
    if name.is_empty() { "cell".to_owned() } else { name }
}

/// Serves the cell of a namespace to OPC UA clients.
///
/// # Errors
/// The system gives no thread, or the server cannot be built.
pub(crate) fn start(
    (listener, nameplate): (TcpListener, Nameplate),
    updates: UaUpdates,
    namespace: &str,
    (logger, supervisor): (&Logger, &Supervisor),
) -> Result<UaServer, String> {
    let set = space::CellNodeSet {
        uri: cell_uri(namespace),
        machine: machine_name(namespace),
        nameplate,
        time: server::ua_time(system_time_ns()),
    };
    UaServer::start(UaSetup { listener, set, updates }, logger, supervisor)
}

/// Rows of the reference: path, model, type, source and rule of each node.
pub(crate) fn table_rows() -> impl Iterator<Item = [String; 5]> {
    nodes::NODES.iter().map(|node| {
        let (topic, rule) = node.origin();
        [node.path.to_owned(), node.namespace.name().to_owned(), node.type_name(), topic, rule]
    })
}

#[cfg(test)]
mod tests {
    use super::{cell_uri, machine_name};

    #[test]
    fn a_namespace_names_the_machine() {
        let named = ["/", "/cell_2", "/hall/cell_2"].map(|namespace| (cell_uri(namespace), machine_name(namespace)));
        let named = named.each_ref().map(|(uri, name)| (uri.as_str(), name.as_str()));
        let expected = [
            ("urn:camwright:cell", "cell"),
            ("urn:camwright:cell:cell_2", "cell_2"),
            ("urn:camwright:cell:hall:cell_2", "hall_cell_2"),
        ];
        assert_eq!(named, expected);
    }
}
