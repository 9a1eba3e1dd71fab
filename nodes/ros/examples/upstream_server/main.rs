// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! A node of ros2-client alone, without the workarounds of camwright, for measurements with `fast_dds_peer.py`.
//!
//! ```text
//! cargo run -p camwright_ros --example upstream_server [-- --all-interfaces]
//! ```
//!
//! offers `/upstream/reply_N` (`std_srvs/srv/Trigger` with a message of N octets) and publishes 1 MB on `/upstream/large`
//! (`std_msgs/msg/String`) after each call of `/upstream/publish`. It ends with its standard input.

use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{
    Context, Message, MessageTypeName, Name, Node, NodeName, NodeOptions, QosProfile, Server, ServiceMapping,
    ServiceTypeName,
};
use rustdds::DomainParticipantBuilder;
use serde::{Deserialize, Serialize};
use std::error::Error;
use std::io::Read;
use std::net::{IpAddr, Ipv4Addr};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Octets of the replies, on both sides of an Ethernet frame and of a datagram.
const LENGTHS: [usize; 9] = [100, 1_000, 1_300, 1_500, 4_000, 30_000, 60_000, 70_000, 300_000];
const LARGE: usize = 1_000_000;

static ENDED: AtomicBool = AtomicBool::new(false);

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Request {
    unused: u8,
}
impl Message for Request {}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Response {
    success: bool,
    message: String,
}
impl Message for Response {}

fn qos() -> QosProfile {
    QosProfile::publisher_default()
        .reliability_reliable(WhenFull::DEFAULT)
        .durability(Durability::Volatile)
        .history(History::KeepLast { depth: 10 })
}

fn server(node: &mut Node, name: &str) -> Result<Server<Request, Response>, Box<dyn Error>> {
    let (name, kind) = (Name::new("/upstream", name)?, ServiceTypeName::new("std_srvs", "Trigger"));
    Ok(node.create_server(ServiceMapping::Enhanced, &name, &kind, qos(), qos())?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let domain = std::env::var("ROS_DOMAIN_ID").ok().and_then(|value| value.parse().ok()).unwrap_or(0);
    let mut builder = DomainParticipantBuilder::new(domain);
    if !std::env::args().any(|argument| argument == "--all-interfaces") {
        builder = builder.with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)]);
    }
    let context = Context::from_domain_participant(builder.build()?)?;
    let mut node = context.new_node(NodeName::new("/", "upstream_server")?, NodeOptions::new())?;
    let mut servers = Vec::new();
    for length in LENGTHS {
        servers.push((length, server(&mut node, &format!("reply_{length}"))?));
    }
    let publish = server(&mut node, "publish")?;
    let (name, kind) = (Name::new("/upstream", "large")?, MessageTypeName::new("std_msgs", "String"));
    let topic = node.create_topic(&name, kind, &qos())?;
    let large = node.create_publisher::<String>(&topic, Some(qos()))?;
    std::thread::spawn(|| {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        ENDED.store(true, Ordering::Relaxed);
    });
    while !ENDED.load(Ordering::Relaxed) {
        for (length, server) in &servers {
            if let Some((id, _)) = server.receive_request()? {
                server.send_response(id, Response { success: true, message: "x".repeat(*length) })?;
            }
        }
        if let Some((id, _)) = publish.receive_request()? {
            publish.send_response(id, Response { success: true, message: String::new() })?;
            let seconds = SystemTime::now().duration_since(UNIX_EPOCH)?.as_secs_f64();
            large.publish(format!("{seconds:020.6} {}", "x".repeat(LARGE)))?;
        }
        std::thread::sleep(Duration::from_micros(200));
    }
    Ok(())
}
