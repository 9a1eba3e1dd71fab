// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Trials to send a type hash (`PID_USER_DATA` of an endpoint) beside `RustDDS`, which omits it.
//!
//! ```text
//! cargo run -p camwright_ros --example upstream_type_hash -- public|replay [MILLISECONDS]
//! ros2 topic info -v --no-daemon /upstream_type_hash
//! ```
//!
//! `public` writes the announcement with a writer of the public API on the topic `DCPSPublication`. `replay` receives the announcement as
//! a peer made by hand, adds the hash, and sends it under the same number to each participant that is discovered. It ends with its
//! standard input.

#[allow(dead_code, unreachable_pub, reason = "shared with the checks")]
#[path = "../upstream_defects/common.rs"]
mod common;
#[allow(dead_code, reason = "shared with the checks")]
#[path = "../upstream_defects/peer.rs"]
mod peer;

use common::{Outcome, text};
use peer::{ACKNACK, DATA, PUBLICATIONS_READER, PUBLICATIONS_WRITER, Peer, sequence_number, submessage};
use rustdds::no_key::{DataWriter, SerializerAdapter};
use rustdds::{
    DomainParticipant, DomainParticipantStatusEvent, RTPSEntity, RepresentationIdentifier, StatusEvented, TopicKind,
    bytes::Bytes,
};
use std::convert::Infallible;
use std::io::Read;
use std::net::{Ipv4Addr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Hash of `std_msgs/msg/String`.
const HASH: &str = "typehash=RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18;";
/// Participants of a host.
const PARTICIPANTS: u16 = 32;

static ENDED: AtomicBool = AtomicBool::new(false);

/// Writes parameter lists that are already serialized.
struct Parameters;

impl SerializerAdapter<Vec<u8>> for Parameters {
    type Error = Infallible;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::PL_CDR_LE
    }

    fn to_bytes(value: &Vec<u8>) -> Result<Bytes, Infallible> {
        Ok(value.clone().into())
    }
}

/// Body of the DATA that announces the only writer, with the hash as its last parameter.
fn announcement(participant: &DomainParticipant) -> Result<Vec<u8>, String> {
    let peer = Peer::meet(participant)?;
    let set = [&sequence_number(1)[..], &32_u32.to_le_bytes(), &[0xff; 4]].concat();
    let request = [&PUBLICATIONS_READER[..], &PUBLICATIONS_WRITER, &set, &[1, 0, 0, 0]].concat();
    peer.send(&[submessage(ACKNACK, 1, &request)])?;
    let mut body = peer.receive_until("the announcement of the writer", |part| {
        let is_writer = part.kind == DATA && part.entity(8)? == PUBLICATIONS_WRITER;
        (is_writer && part.body.windows(18).any(|octets| octets == b"upstream_type_hash")).then(|| part.body.clone())
    })?;
    let length = u32::try_from(HASH.len()).map_err(text)?;
    let mut value = [&length.to_le_bytes()[..], HASH.as_bytes()].concat();
    value.resize(value.len().next_multiple_of(4), 0);
    let padded = u16::try_from(value.len()).map_err(text)?;
    // PID_USER_DATA before the sentinel
    body.truncate(body.len() - 4);
    body.extend([&[0x2c, 0][..], &padded.to_le_bytes(), &value, &[1, 0, 0, 0]].concat());
    body[4..8].copy_from_slice(&PUBLICATIONS_READER);
    Ok(body)
}

/// Writer of the public API on the topic of discovery.
fn public_writer(participant: &DomainParticipant) -> Result<DataWriter<Vec<u8>, Parameters>, String> {
    let (name, kind, qos) = ("DCPSPublication", "PublicationBuiltinTopicData", common::qos(10));
    let topic = participant.create_topic(name.into(), kind.into(), &qos, TopicKind::NoKey).map_err(text)?;
    participant.create_publisher(&qos).map_err(text)?.create_datawriter_no_key(&topic, None).map_err(text)
}

fn main() -> Outcome {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let replays = match arguments.first().map(String::as_str) {
        Some("public") => false,
        Some("replay") => true,
        other => return Err(format!("no trial {other:?}; use one of: public replay")),
    };
    let time = Duration::from_millis(arguments.get(1).map_or(Ok(30), |value| value.parse()).map_err(text)?);
    let participant = common::participant()?;
    let (kind, qos) = ("std_msgs::msg::dds_::String_", common::qos(10));
    let name = "rt/upstream_type_hash";
    let topic = participant.create_topic(name.into(), kind.into(), &qos, TopicKind::NoKey).map_err(text)?;
    let publisher = participant.create_publisher(&qos).map_err(text)?;
    let _writer = publisher.create_datawriter_no_key_cdr::<String>(&topic, None).map_err(text)?;
    let body = announcement(&participant)?;
    let prefix = participant.guid().to_bytes();
    let message = [&b"RTPS\x02\x03\x01\x12"[..], &prefix[..12], &submessage(DATA, 5, &body)].concat();
    let public = if replays { None } else { Some(public_writer(&participant)?) };
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).map_err(text)?;
    let first_port = 7410 + 250 * participant.domain_id();
    std::thread::spawn(|| {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        ENDED.store(true, Ordering::Relaxed);
    });
    let events = participant.status_listener();
    while !ENDED.load(Ordering::Relaxed) {
        let is_new = std::iter::from_fn(|| events.try_recv_status())
            .any(|event| matches!(event, DomainParticipantStatusEvent::ParticipantDiscovered { .. }));
        let end = Instant::now() + time;
        while is_new && Instant::now() < end {
            if let Some(writer) = &public {
                writer.write(body[24..].to_vec(), None).map_err(text)?;
            } else {
                for number in 0..PARTICIPANTS {
                    // An absent participant cannot be informed.
                    let _ = socket.send_to(&message, (Ipv4Addr::LOCALHOST, first_port + 2 * number));
                }
            }
            std::thread::sleep(Duration::from_micros(100));
        }
        std::thread::sleep(Duration::from_micros(200));
    }
    Ok(())
}
