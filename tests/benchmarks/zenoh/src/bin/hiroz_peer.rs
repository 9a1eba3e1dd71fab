// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Peer on the crate `hiroz`, with its own CDR, keys, tokens and attachments: receives chunks and calls the service, for `figures.py`.
//!
//! ```text
//! hiroz_peer CONFIG COUNT
//! ```

use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, SetBoolResponse};
use camwright_msgs::trajectory_msgs::msg::JointTrajectory;
use camwright_msgs::{Message, Service};
use hiroz::context::ZContextBuilder;
use hiroz::entity::{TypeHash, TypeInfo};
use hiroz::msg::{SerdeCdrSerdes, ZMessage, ZService};
use hiroz::{Builder, MessageTypeInfo, ServiceTypeInfo, WithTypeInfo};
use serde::{Deserialize, Serialize};
use std::time::Duration;

const PATIENCE: Duration = Duration::from_secs(30);

macro_rules! message {
    ($($name:ident($inner:ty)),*) => {$(
        #[derive(Serialize, Deserialize)]
        #[serde(transparent)]
        struct $name($inner);
        impl MessageTypeInfo for $name {
            fn type_name() -> &'static str {
                <$inner>::DDS_TYPE_NAME
            }
            fn type_hash() -> TypeHash {
                hash(<$inner>::TYPE_HASH)
            }
        }
        impl WithTypeInfo for $name {}
        impl ZMessage for $name {
            type Serdes = SerdeCdrSerdes<$name>;
        }
    )*};
}
message!(Chunk(JointTrajectory), Request(SetBoolRequest), Response(SetBoolResponse));

fn hash(text: &str) -> TypeHash {
    TypeHash::from_rihs_string(text).unwrap_or_else(TypeHash::zero)
}

struct Estop;

impl ServiceTypeInfo for Estop {
    fn service_type_info() -> TypeInfo {
        TypeInfo::new(SetBool::DDS_REQUEST_TYPE_NAME.trim_end_matches("Request_"), hash(SetBool::TYPE_HASH))
    }
}

impl ZService for Estop {
    type Request = Request;
    type Response = Response;
}

fn run() -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [config, count] = &words[..] else { return Err("usage: hiroz_peer CONFIG COUNT".into()) };
    let (count, domain): (u32, usize) = (count.parse()?, std::env::var("ROS_DOMAIN_ID")?.parse()?);
    let context = ZContextBuilder::default().with_domain_id(domain).with_config_file(config).build()?;
    let node = context.create_node("hiroz_peer").build()?;
    let subscription = node.create_sub::<Chunk>("/machine/setpoints").build()?;
    println!("ready");
    let mut last = String::new();
    for _ in 0..count {
        last = subscription.recv_timeout(PATIENCE)?.0.header.frame_id;
    }
    let client = node.create_client::<Estop>("/machine/estop").build()?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build()?;
    let response = runtime.block_on(client.call_with_timeout(&Request(SetBoolRequest { data: true }), PATIENCE))?;
    let knows = context.graph().get_node_names().iter().any(|(name, _)| name == "axis_interpolator");
    println!("received {count} last {last} service {} node {knows}", response.0.success);
    context.shutdown()?;
    Ok(())
}

fn main() -> std::process::ExitCode {
    match run() {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            std::process::ExitCode::FAILURE
        }
    }
}
