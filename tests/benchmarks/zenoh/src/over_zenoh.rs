// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The same topic and a service on Zenoh, with the entities and options that `rmw_zenoh_cpp` gives them.

use super::chunk::{Arrival, DEPTH, PATIENCE, TOPIC, now_ns, print_arrivals, send_bursts};
use super::format::{Attachment, EntityKind, RosEndpoint, SessionNode, gid};
use super::{Outcome, Task};
use camwright_msgs::cdr::{message_from_sample, sample_from_message};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, SetBoolResponse};
use camwright_msgs::trajectory_msgs::msg::JointTrajectory;
use camwright_msgs::{Message, Service};
use std::io::Read as _;
use std::sync::mpsc;
use std::time::{Duration, Instant};
use zenoh::liveliness::LivelinessToken;
use zenoh::query::Query;
use zenoh::sample::Sample;
use zenoh::{Config, Session, Wait};
use zenoh_ext::{
    AdvancedPublisherBuilderExt, AdvancedSubscriberBuilderExt, CacheConfig, HistoryConfig, MissDetectionConfig,
    RecoveryConfig,
};

const SERVICE: &str = "/machine/estop";
const SETPOINTS: RosEndpoint =
    RosEndpoint { name: TOPIC, type_name: JointTrajectory::DDS_TYPE_NAME, type_hash: JointTrajectory::TYPE_HASH };
/// Period of the message from which a subscriber learns that it misses the last sample.
const HEARTBEAT: Duration = Duration::from_millis(500);

fn open(config: &str) -> Result<Session, Box<dyn std::error::Error + Send + Sync>> {
    zenoh::open(Config::from_file(config)?).wait()
}

/// A router, as `rmw_zenohd` is one: a session in the mode that its configuration names.
pub fn route(config: &str) -> Outcome {
    let session = open(config)?;
    println!("ready");
    std::io::stdin().read_to_end(&mut Vec::new())?;
    session.close().wait()
}

fn node(session: &Session, name: &str) -> Result<SessionNode, String> {
    let text = std::env::var("ROS_DOMAIN_ID").unwrap_or_else(|_| "0".into());
    let domain = text.parse().map_err(|_| format!("ROS_DOMAIN_ID `{text}` is not a whole number up to 65535"))?;
    Ok(SessionNode { domain, session: session.zid().to_string(), name: name.into() })
}

fn declare(session: &Session, token: &str) -> Result<LivelinessToken, zenoh::Error> {
    session.liveliness().declare_token(token.to_owned()).wait()
}

fn answer(query: &Query) -> Result<(Vec<u8>, Attachment), String> {
    let attachment = query.attachment().ok_or("the request has no attachment")?;
    let asked = Attachment::from_octets(&attachment.to_bytes())?;
    let payload = query.payload().ok_or("the request has no payload")?;
    let request: SetBoolRequest = message_from_sample(&payload.to_bytes())?;
    let response = SetBoolResponse { success: request.data, message: "nothing is stopped: a benchmark".into() };
    Ok((sample_from_message(&response)?, Attachment { source_ns: now_ns(), ..asked }))
}

pub fn send(task: &Task) -> Outcome {
    let session = open(&task.config)?;
    let node = node(&session, "axis_interpolator")?;
    let request_type = SetBool::DDS_REQUEST_TYPE_NAME;
    let type_name = request_type.strip_suffix("Request_").ok_or_else(|| format!("{request_type} is no request"))?;
    let service = RosEndpoint { name: SERVICE, type_name, type_hash: SetBool::TYPE_HASH };
    let depth = usize::try_from(DEPTH)?;

    let publisher = session.declare_publisher(SETPOINTS.key(node.domain)).advanced();
    // The same options in the same cases as rmw_zenoh_cpp. Its reliable publishers drop where the network is congested.
    let publisher = match task.latched {
        true => publisher
            .publisher_detection()
            .cache(CacheConfig::default().max_samples(depth))
            .sample_miss_detection(MissDetectionConfig::default().sporadic_heartbeat(HEARTBEAT)),
        false => publisher,
    };
    let publisher = publisher.wait()?;
    let token = node.entity_token(1, EntityKind::Publisher, &SETPOINTS, depth, task.latched);
    let key = service.key(node.domain);
    let queryable = session.declare_queryable(key.clone()).complete(true).callback(move |query| {
        let sent = match answer(&query) {
            Ok((payload, attachment)) => {
                query.reply(key.clone(), payload).attachment(attachment.to_octets().to_vec()).wait()
            }
            Err(reason) => query.reply_err(reason).wait(),
        };
        if let Err(error) = sent {
            eprintln!("{key}: {error}");
        }
    });
    let _queryable = queryable.wait()?;
    let _tokens = [
        declare(&session, &node.token())?,
        declare(&session, &token)?,
        declare(&session, &node.entity_token(2, EntityKind::Service, &service, 10, false))?,
    ];

    let identity = gid(&token);
    let mut sequence_number = 0;
    let wait_for_receiver = || {
        let start = Instant::now();
        while !task.latched && !publisher.matching_status().wait()?.matching() {
            if start.elapsed() > PATIENCE {
                return Err(format!("no subscriber of {TOPIC} in {PATIENCE:?}").into());
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        Ok(())
    };
    send_bursts(task.count, wait_for_receiver, |chunk| {
        sequence_number += 1;
        let attachment = Attachment { sequence_number, source_ns: now_ns(), gid: identity };
        publisher.put(sample_from_message(chunk)?).attachment(attachment.to_octets().to_vec()).wait()
    })?;
    session.close().wait()
}

fn arrival(sample: &Sample) -> Result<Arrival, String> {
    let attachment = sample.attachment().ok_or("the sample has no attachment")?;
    Attachment::from_octets(&attachment.to_bytes())?;
    let chunk: JointTrajectory = message_from_sample(&sample.payload().to_bytes())?;
    Ok(Arrival::new(&chunk))
}

pub fn receive(task: &Task) -> Outcome {
    let session = open(&task.config)?;
    let node = node(&session, "machine_sim")?;
    let depth = usize::try_from(DEPTH)?;
    let (sender, arrivals) = mpsc::channel();
    let callback = move |sample: Sample| {
        let _receiver_has_ended = sender.send(arrival(&sample));
    };
    let subscriber = session.declare_subscriber(SETPOINTS.key(node.domain)).callback(callback).advanced();
    let subscriber = match task.latched {
        true => subscriber
            .subscriber_detection()
            .query_timeout(PATIENCE)
            .history(HistoryConfig::default().detect_late_publishers().max_samples(depth))
            .recovery(RecoveryConfig::default().heartbeat()),
        false => subscriber,
    };
    let _subscriber = subscriber.wait()?;
    let _tokens = [
        declare(&session, &node.token())?,
        declare(&session, &node.entity_token(1, EntityKind::Subscription, &SETPOINTS, depth, task.latched))?,
    ];
    print_arrivals(task.count, &arrivals)?;
    session.close().wait()
}
