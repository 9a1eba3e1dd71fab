// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Matches announced before both of their ends are known.

use super::*;

fn guid(participant: u8, entity: u8) -> GUID {
    let mut octets = [0; 16];
    (octets[0], octets[14], octets[15]) = (participant, entity, 4);
    GUID::from_bytes(octets)
}

fn endpoint(type_name: &str) -> Endpoint {
    Endpoint { topic: "rt/topic".into(), type_name: type_name.into(), qos: Qos::default_topic(), type_hash: None }
}

const TEXT: &str = "std_msgs::msg::dds_::String_";
const NUMBER: &str = "std_msgs::msg::dds_::Float64_";

/// A reader is matched by the event loop before this node has noted it: the match counts when it has, if the types agree.
#[test]
fn a_match_before_its_endpoint_is_noted_is_decided_afterwards() {
    let graph = Graph::default();
    let (reader, right, wrong) = (guid(1, 1), guid(2, 1), guid(2, 2));
    graph.set_own(reader);
    graph.state().writers.insert(right, endpoint(TEXT));
    graph.state().writers.insert(wrong, endpoint(NUMBER));
    for remote_writer in [wrong, right] {
        let event = DomainParticipantStatusEvent::RemoteWriterMatched { local_reader: reader, remote_writer };
        assert!(!graph.state().apply(event));
    }
    graph.add_local(reader, "rt/topic", TEXT, &Qos::default_topic(), false, &[]);
    assert_eq!(graph.ask(|matches| matches.count(&reader)), 1);
    assert!(graph.ask(|matches| matches.with_participant(&reader, &right)));
    assert_eq!(
        graph.state().incompatible,
        [
            "a publisher of an unknown node on /topic has the type std_msgs/msg/Float64, not std_msgs/msg/String; no messages will pass"
        ]
    );
    assert!(graph.state().undecided.is_empty());
}

/// A writer of ours is matched with a reader before discovery has described that reader.
#[test]
fn a_match_with_an_endpoint_not_yet_described_waits_for_its_description() {
    let graph = Graph::default();
    let (writer, reader, gone) = (guid(1, 1), guid(2, 1), guid(3, 1));
    graph.set_own(writer);
    graph.add_local(writer, "rt/topic", TEXT, &Qos::default_topic(), true, &[]);
    for remote_reader in [reader, gone] {
        let event = DomainParticipantStatusEvent::RemoteReaderMatched { local_writer: writer, remote_reader };
        assert!(!graph.state().apply(event));
    }
    assert_eq!(graph.ask(|matches| matches.count(&writer)), 0);
    graph.state().readers.insert(reader, endpoint(TEXT));
    graph.state().decide(reader);
    assert_eq!(graph.ask(|matches| matches.count(&writer)), 1);
    graph.state().forget(|guid| *guid == gone);
    assert!(graph.state().undecided.is_empty());
}

/// A server that was killed stays known and matches first: the service is ready when the server that runs matches too.
#[test]
fn a_service_is_ready_when_every_known_server_matches() {
    let graph = Graph::default();
    let (requests, replies) = (guid(1, 1), guid(1, 2));
    graph.set_own(requests);
    graph.add_local(requests, "rq/ask", TEXT, &Qos::services(), true, &[]);
    graph.add_local(replies, "rr/ask", TEXT, &Qos::services(), false, &[]);
    let server = |topic: &str, type_name: &str| Endpoint { topic: topic.into(), ..endpoint(type_name) };
    for participant in [2, 3] {
        graph.state().readers.insert(guid(participant, 1), server("rq/ask", TEXT));
        graph.state().writers.insert(guid(participant, 2), server("rr/ask", TEXT));
    }
    graph.state().readers.insert(guid(4, 1), server("rq/ask", NUMBER));
    graph.state().readers.insert(guid(5, 1), server("rq/other", TEXT));
    let is_ready = || graph.ask(|matches| matches.is_service_matched(&requests, &replies));
    for (participant, ready) in [(2, false), (3, true)] {
        assert!(!is_ready());
        assert!(graph.state().add_match(requests, guid(participant, 1)));
        assert!(!is_ready());
        assert!(graph.state().add_match(replies, guid(participant, 2)));
        assert_eq!(is_ready(), ready);
    }
}

/// A reply goes to the reader that its client names; a client that names its writer has any reader of its participant.
#[test]
fn a_reply_waits_for_the_reader_that_the_client_names() {
    let graph = Graph::default();
    let (ours, former, reader) = (guid(1, 1), guid(2, 1), guid(2, 3));
    let mut writer = guid(2, 2).to_bytes();
    writer[15] = 3;
    let writer = GUID::from_bytes(writer);
    graph.add_local(ours, "rr/ask", TEXT, &Qos::services(), true, &[]);
    for reader in [former, reader] {
        graph.state().readers.insert(reader, Endpoint { topic: "rr/ask".into(), ..endpoint(TEXT) });
    }
    let is_matched = |client: &GUID| graph.ask(|matches| matches.is_matched_by_client(&ours, client));
    assert!(graph.state().add_match(ours, former));
    assert!(!is_matched(&reader) && is_matched(&former) && is_matched(&writer));
    assert!(graph.state().add_match(ours, reader));
    assert!(is_matched(&reader));
}

#[test]
fn the_hash_of_a_type_is_found_among_the_data_for_users() {
    let data = |text: &str| {
        [&(u32::try_from(text.len()).expect("it is short")).to_le_bytes()[..], text.as_bytes(), &[0; 3]].concat()
    };
    let hash = format!("RIHS01_{}", "a1".repeat(32));
    assert_eq!(type_hash(&data(&format!("enclave=/;typehash={hash};"))).as_deref(), Some(hash.as_str()));
    for none in ["", "typehash=", "typehash=INVALID;", "xtypehash=RIHS01_0;"] {
        assert_eq!(type_hash(&data(none)), None, "{none}");
    }
    assert_eq!(type_hash(&[1, 2]), None);
    assert_eq!(type_hash(&[0, 0, 0, 0, 0xff]), None);
}
