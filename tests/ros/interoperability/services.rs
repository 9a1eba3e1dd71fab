// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Services in both roles.

use super::ground::{Ground, text};
use crate::support::{PATIENCE, Peer};
use camwright_msgs::rcl_interfaces::msg::ParameterValue;
use camwright_msgs::rcl_interfaces::srv::{GetParameters, GetParametersRequest, GetParametersResponse};
use camwright_msgs::std_srvs::srv::{
    SetBool, SetBoolRequest, SetBoolResponse, Trigger, TriggerRequest, TriggerResponse,
};
use serde_json::json;

const SET_BOOL: &str = "std_srvs/srv/SetBool";
const TRIGGER: &str = "std_srvs/srv/Trigger";

pub fn both_ways(ground: &mut Ground<'_>) {
    let (node, _spin) = ground.node("node");
    let _hold = node
        .service::<SetBool>("~/hold", |request| SetBoolResponse {
            success: request.data, message: "held ÄÖÜ".into()
        })
        .expect("a service");
    let _stop = node
        .service::<Trigger>("~/stop", |_| TriggerResponse { success: true, message: "at rest".into() })
        .expect("a service");
    let mut peer = ground.peer("peer");
    ground.check("ours, called by theirs", || {
        for data in [true, false, true] {
            let answer = peer.call("/node/hold", SET_BOOL, json!({ "data": data }));
            assert_eq!(answer, json!({ "success": data, "message": "held ÄÖÜ" }));
        }
    });
    let response = json!({ "success": true, "message": "theirs" });
    ground.check("theirs, called by us", || {
        peer.ask("serve", json!({ "service": "/theirs", "type": SET_BOOL, "response": response }));
        let client = node.client::<SetBool>("theirs").expect("a client");
        client.wait_for_service(PATIENCE).expect("the service is there");
        for data in [true, false] {
            let answer = client.call(&SetBoolRequest { data }, PATIENCE).expect("an answer");
            assert!(answer.success && answer.message == "theirs", "{answer:?}");
            assert_eq!(peer.event("request", |_| true)["data"], json!({ "data": data }));
        }
    });
    if !ground.column.is_cyclone() {
        // An empty request is one octet on the wire that nobody's type shows.
        ground.check("without fields, both ways", || {
            assert_eq!(peer.call("/node/stop", TRIGGER, json!({})), json!({ "success": true, "message": "at rest" }));
            peer.ask("serve", json!({ "service": "/empty", "type": TRIGGER, "response": response }));
            let empty = node.client::<Trigger>("empty").expect("a client");
            empty.wait_for_service(PATIENCE).expect("the service is there");
            assert!(empty.call(&TriggerRequest::default(), PATIENCE).expect("an answer").success);
        });
        ground.check("`~/get_type_description`", || describe_type(&mut peer));
    }
}

fn describe_type(peer: &mut Peer) {
    let known = camwright_msgs::by_type_name("trajectory_msgs/msg/JointTrajectory").expect("a type of ours");
    let (service, kind) = ("/node/get_type_description", "type_description_interfaces/srv/GetTypeDescription");
    let asked = |name: &str, hash: &str| json!({ "type_name": name, "type_hash": hash, "include_type_sources": true });
    let answer = peer.call(service, kind, asked("trajectory_msgs/msg/JointTrajectory", known.type_hash));
    assert_eq!(answer["successful"], true, "{}", answer["failure_reason"]);
    let described = &answer["type_description"];
    assert_eq!(described["type_description"]["type_name"], "trajectory_msgs/msg/JointTrajectory");
    assert_eq!(described["referenced_type_descriptions"].as_array().map(Vec::len), Some(4), "{described}");
    let refused = peer.call(service, kind, asked("nobody/msg/Nothing", known.type_hash));
    assert_eq!(refused["successful"], false);
    assert!(refused["failure_reason"].as_str().is_some_and(|reason| !reason.is_empty()), "{refused}");
}

/// Lengths of text on both sides of what a datagram takes, of an Ethernet frame and of UDP.
const LENGTHS: [usize; 8] = [900, 1020, 1100, 1400, 9000, 57_330, 66_000, 300_000];

pub fn long_ones(ground: &mut Ground<'_>) {
    const KIND: &str = "rcl_interfaces/srv/GetParameters";
    let (node, _spin) = ground.node("node");
    let echo = move |request: GetParametersRequest| {
        let answer = |name: &String| ParameterValue { string_value: name.clone(), ..ParameterValue::default() };
        GetParametersResponse { values: request.names.iter().map(answer).collect() }
    };
    let _echo = node.service::<GetParameters>("~/echo", echo).expect("a service");
    let (client_node, _client_spin) = ground.node("client");
    let mut peer = ground.peer("peer");
    ground.check("replies up to 300 kB, ours to theirs", || {
        for length in LENGTHS {
            let response = peer.call("/node/echo", KIND, json!({ "names": [text(length)] }));
            assert!(response["values"][0]["string_value"] == json!(text(length)), "{length} octets to a real client");
        }
    });
    ground.check("requests up to 300 kB, theirs to ours and ours to theirs", || {
        let client = client_node.client::<GetParameters>("/node/echo").expect("a client");
        client.wait_for_service(PATIENCE).expect("the service is there");
        peer.ask("serve", json!({ "service": "/served", "type": KIND, "response": {} }));
        let served = client_node.client::<GetParameters>("/served").expect("a client");
        served.wait_for_service(PATIENCE).expect("the service is there");
        for length in LENGTHS {
            let request = GetParametersRequest { names: vec![text(length)] };
            let response = client.call(&request, PATIENCE).expect("an answer");
            assert!(response.values[0].string_value == text(length), "{length} octets to our client");
            served.call(&request, PATIENCE).expect("an answer");
            let asked = peer.event("request", |_| true);
            assert!(asked["data"]["names"] == json!([text(length)]), "{length} octets to a real server");
        }
    });
}
