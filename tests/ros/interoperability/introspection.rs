// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Service introspection: events of calls on `<service>/_service_event`, read by rclpy with its own types.

use super::ground::{Ground, HOME, text};
use crate::support::{PATIENCE, Peer};
use camwright_msgs::camwright_msgs::action::{Home, HomeGoal, HomeResult};
use camwright_msgs::rcl_interfaces::srv::{GetParameters, GetParametersRequest};
use camwright_msgs::std_srvs::srv::{SetBool, SetBoolRequest, SetBoolResponse};
use camwright_ros::{GoalHandle, Node, ParameterValue};
use serde_json::{Value, json};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

const SET_BOOL: &str = "std_srvs/srv/SetBool";
const GET_PARAMETERS: &str = "rcl_interfaces/srv/GetParameters";

/// Event types of `service_msgs/msg/ServiceEventInfo`.
const REQUEST_SENT: u64 = 0;
const REQUEST_RECEIVED: u64 = 1;
const RESPONSE_SENT: u64 = 2;
const RESPONSE_RECEIVED: u64 = 3;

fn topic_of(service: &str) -> String {
    format!("{service}/_service_event")
}

fn kind_of(event: &Value) -> u64 {
    event["info"]["event_type"].as_u64().expect("a number")
}

fn number_of(event: &Value) -> u64 {
    event["info"]["sequence_number"].as_u64().expect("a positive number")
}

fn watch(peer: &mut Peer, service: &str, kind: &str) {
    let (topic, kind) = (topic_of(service), format!("{kind}_Event"));
    peer.ask("subscribe", json!({ "topic": topic, "type": kind, "qos": "reliable:1000" }));
}

/// Sets a parameter of a node of ours as `ros2 param set` does; returns the reason of a refusal.
fn set(peer: &mut Peer, node: &str, parameter: &str, value: &str) -> String {
    let value = json!({ "type": 4, "string_value": value });
    let request = json!({ "parameters": [{ "name": parameter, "value": value }] });
    let answer = peer.call(&format!("{node}/set_parameters"), "rcl_interfaces/srv/SetParameters", request);
    let result = &answer["results"][0];
    assert_eq!(result["successful"], result["reason"] == "", "{result}");
    result["reason"].as_str().expect("a text").to_owned()
}

/// Calls until each of these events has been seen once. A new publisher and the subscription have then found each other.
fn until_seen(peer: &mut Peer, service: &str, kinds: &[u64], mut call: impl FnMut(&mut Peer)) {
    let (deadline, mut missing) = (Instant::now() + PATIENCE, kinds.to_vec());
    while !missing.is_empty() {
        assert!(Instant::now() < deadline, "no events {missing:?} of {service}");
        call(peer);
        for event in peer.events_so_far("message") {
            missing.retain(|kind| event["topic"] != topic_of(service).as_str() || *kind != kind_of(&event["data"]));
        }
    }
}

/// Time of the clock that stamps events, ns since 1970.
fn now_ns() -> u128 {
    SystemTime::now().duration_since(UNIX_EPOCH).expect("after 1970").as_nanos()
}

/// Events of the only call since a time, in the order of their types.
fn events_since(peer: &mut Peer, service: &str, kinds: &[u64], since_ns: u128) -> Vec<Value> {
    let topic = topic_of(service);
    let mut events: Vec<Value> = Vec::new();
    while events.len() < kinds.len() {
        let event = peer.message(&topic);
        let part = |name: &str| u128::from(event["info"]["stamp"][name].as_u64().expect("a number"));
        // Events of earlier calls may still be on their way.
        if part("sec") * 1_000_000_000 + part("nanosec") >= since_ns {
            events.push(event);
        }
    }
    events.sort_by_key(kind_of);
    assert_eq!(events.iter().map(kind_of).collect::<Vec<_>>(), kinds, "{events:?}");
    events
}

/// Calls once and returns the events of this call, in the order of their types.
fn events_of_call(peer: &mut Peer, service: &str, kinds: &[u64], call: impl FnOnce(&mut Peer)) -> Vec<Value> {
    let since_ns = now_ns();
    call(peer);
    events_since(peer, service, kinds, since_ns)
}

/// Checks that events belong to one call.
fn assert_one_identity(events: &[Value]) {
    for event in events {
        for field in ["client_gid", "sequence_number"] {
            assert_eq!(event["info"][field], events[0]["info"][field], "{field} of {events:?}");
        }
    }
    let gid = events[0]["info"]["client_gid"].as_array().expect("a list");
    assert!(gid.len() == 16 && gid.iter().any(|octet| *octet != 0), "{gid:?}");
}

/// Nodes that publish events of a service.
fn publishers(peer: &mut Peer, service: &str) -> Vec<String> {
    let endpoints = peer.ask("endpoints", json!({ "topic": topic_of(service) }));
    let list = endpoints["publishers"].as_array().expect("a list");
    let mut nodes: Vec<_> = list.iter().filter_map(|endpoint| endpoint["node"].as_str().map(str::to_owned)).collect();
    nodes.sort();
    nodes
}

pub fn of_services(ground: &mut Ground<'_>) {
    const HOLD: &str = "/node/hold";
    const SERVERS: &str = "service_configure_introspection";
    let (node, _spin) = ground.node("node");
    let _hold = node
        .service::<SetBool>("~/hold", |request| SetBoolResponse { success: request.data, message: "held".into() })
        .expect("a service");
    let mut peer = ground.peer("peer");
    let hold = |peer: &mut Peer, data: bool| drop(peer.call(HOLD, SET_BOOL, json!({ "data": data })));
    watch(&mut peer, HOLD, SET_BOOL);
    ground.check("no topic before it is enabled, and other values are refused", || {
        hold(&mut peer, true);
        assert_eq!(publishers(&mut peer, HOLD), Vec::<String>::new());
        let reason = set(&mut peer, "/node", SERVERS, "on");
        assert_eq!(reason, format!("parameter '{SERVERS}' is 'on'; it must be one of disabled, metadata, contents"));
        assert_eq!(publishers(&mut peer, HOLD), Vec::<String>::new());
    });
    let server_side = [REQUEST_RECEIVED, RESPONSE_SENT];
    ground.check("server ours: metadata, contents, then nothing", || {
        assert_eq!(set(&mut peer, "/node", SERVERS, "metadata"), "");
        until_seen(&mut peer, HOLD, &server_side, |peer| hold(peer, true));
        let events = events_of_call(&mut peer, HOLD, &server_side, |peer| hold(peer, true));
        assert_one_identity(&events);
        for event in &events {
            assert_eq!((&event["request"], &event["response"]), (&json!([]), &json!([])), "{event}");
            assert!(event["info"]["stamp"]["sec"].as_u64().is_some_and(|sec| sec > 1_700_000_000), "{event}");
        }
        assert_eq!(set(&mut peer, "/node", SERVERS, "contents"), "");
        let mut last = 0;
        for data in [true, false] {
            let events = events_of_call(&mut peer, HOLD, &server_side, |peer| hold(peer, data));
            let response = json!([{ "success": data, "message": "held" }]);
            assert_eq!((&events[0]["request"], &events[0]["response"]), (&json!([{ "data": data }]), &json!([])));
            assert_eq!((&events[1]["request"], &events[1]["response"]), (&json!([]), &response));
            last = number_of(&events[0]);
        }
        assert_eq!(set(&mut peer, "/node", SERVERS, "disabled"), "");
        hold(&mut peer, true);
        assert_eq!(set(&mut peer, "/node", SERVERS, "metadata"), "");
        hold(&mut peer, true);
        // Events arrive in order, so those of the call in between would come first.
        let next = peer.message(&topic_of(HOLD));
        assert_eq!((kind_of(&next), number_of(&next)), (REQUEST_RECEIVED, last + 2), "{next}");
        assert_eq!(publishers(&mut peer, HOLD), ["/node"], "one publisher, however often it is enabled");
    });
    let all = [REQUEST_SENT, REQUEST_RECEIVED, RESPONSE_SENT, RESPONSE_RECEIVED];
    ground.check("server ours: the four events of a call have one client and one number", || {
        assert_eq!(set(&mut peer, "/node", SERVERS, "contents"), "");
        peer.ask("introspect", json!({ "service": HOLD, "type": SET_BOOL, "state": "contents" }));
        until_seen(&mut peer, HOLD, &all, |peer| hold(peer, true));
        let events = events_of_call(&mut peer, HOLD, &all, |peer| hold(peer, false));
        assert_one_identity(&events);
        assert_eq!((&events[0]["request"], &events[2]["response"]), (&events[1]["request"], &events[3]["response"]));
    });
    ground.check("client ours: the four events of a call have one client and one number", || {
        our_client(&node, &mut peer);
    });
    ground.check("no events of the services of parameters, types and loggers", || {
        assert_eq!(publishers(&mut peer, HOLD), ["/node", "/peer"]);
        let graph = peer.ask("graph", json!({}));
        let topics = graph["topics"].as_object().expect("a map");
        let of_node: Vec<&String> =
            topics.keys().filter(|name| name.starts_with("/node/") && name.ends_with("_service_event")).collect();
        assert_eq!(of_node, [&topic_of(HOLD)]);
    });
}

/// Calls two services of the peer, one with requests that are sent in fragments.
fn our_client(node: &Node, peer: &mut Peer) {
    let all = [REQUEST_SENT, REQUEST_RECEIVED, RESPONSE_SENT, RESPONSE_RECEIVED];
    let contents = ParameterValue::String("contents".into());
    node.parameters().set("client_configure_introspection", contents).expect("it is one of the values");
    let response = json!({ "success": true, "message": "theirs" });
    peer.ask("serve", json!({ "service": "/theirs", "type": SET_BOOL, "response": response }));
    peer.ask("serve", json!({ "service": "/long", "type": GET_PARAMETERS, "response": {} }));
    for (service, kind) in [("/theirs", SET_BOOL), ("/long", GET_PARAMETERS)] {
        peer.ask("introspect", json!({ "service": service, "state": "contents" }));
        watch(peer, service, kind);
    }
    let client = node.client::<SetBool>("/theirs").expect("a client");
    client.wait_for_service(PATIENCE).expect("the service is there");
    let call = |data: bool| drop(client.call(&SetBoolRequest { data }, PATIENCE).expect("an answer"));
    until_seen(peer, "/theirs", &all, |_| call(true));
    let events = events_of_call(peer, "/theirs", &all, |_| call(false));
    assert_one_identity(&events);
    let (request, response) = (json!([{ "data": false }]), json!([response]));
    assert_eq!((&events[0]["request"], &events[0]["response"]), (&request, &json!([])), "{events:?}");
    assert_eq!((&events[3]["request"], &events[3]["response"]), (&json!([]), &response), "{events:?}");

    let long = node.client::<GetParameters>("/long").expect("a client");
    long.wait_for_service(PATIENCE).expect("the service is there");
    let call = |length: usize| {
        let request = GetParametersRequest { names: vec![text(length)] };
        drop(long.call(&request, PATIENCE).expect("an answer"));
    };
    until_seen(peer, "/long", &all, |_| call(10));
    for length in [900, 3000, 90_000] {
        let events = events_of_call(peer, "/long", &all, |_| call(length));
        assert_one_identity(&events);
        assert!(events[0]["request"] == json!([{ "names": [text(length)] }]), "{length} octets in an event");
    }
}

pub fn of_actions(ground: &mut Ground<'_>) {
    let words = "--ros-args -p action_server_configure_introspection:=contents";
    let (machine, _spin) = ground.node_with("machine", words, Vec::new());
    let hold_until_canceled = |goal: GoalHandle<Home>| {
        std::thread::spawn(move || {
            let deadline = Instant::now() + PATIENCE;
            while !goal.is_canceling() && Instant::now() < deadline {
                std::thread::yield_now();
            }
            goal.canceled(HomeResult { message: "stopped".into(), ..HomeResult::default() })
        });
    };
    let _home = machine.action_server::<Home>("~/home", hold_until_canceled).expect("an action server");
    let mut peer = ground.peer("peer");
    let parts = [
        ("send_goal", "camwright_msgs/action/Home_SendGoal"),
        ("cancel_goal", "action_msgs/srv/CancelGoal"),
        ("get_result", "camwright_msgs/action/Home_GetResult"),
    ];
    for (part, kind) in parts {
        watch(&mut peer, &format!("/machine/home/_action/{part}"), kind);
        watch(&mut peer, &format!("/theirs/_action/{part}"), kind);
    }
    let run = |peer: &mut Peer| -> String {
        let sent =
            peer.ask("send_goal", json!({ "action": "/machine/home", "type": HOME, "goal": { "joints": ["a"] } }));
        let goal = sent["goal"].as_str().expect("an id").to_owned();
        peer.ask("cancel", json!({ "goal": goal }));
        peer.ask("result", json!({ "goal": goal }));
        goal
    };
    ground.check("action server ours: events of its three services", || {
        let sides = [REQUEST_RECEIVED, RESPONSE_SENT];
        for (part, _) in parts {
            until_seen(&mut peer, &format!("/machine/home/_action/{part}"), &sides, |peer| drop(run(peer)));
        }
        // One goal makes the events of all three.
        let since_ns = now_ns();
        let goal = run(&mut peer);
        let seen =
            parts.map(|(part, _)| events_since(&mut peer, &format!("/machine/home/_action/{part}"), &sides, since_ns));
        seen.iter().for_each(|events| assert_one_identity(events));
        let id = |value: &Value| {
            let octets = value["goal_id"]["uuid"].as_array().expect("a list").iter();
            octets.map(|octet| format!("{:02x}", octet.as_u64().expect("a number"))).collect::<String>()
        };
        assert_eq!(id(&seen[0][0]["request"][0]), goal);
        assert_eq!(seen[0][0]["request"][0]["goal"], json!({ "joints": ["a"] }));
        assert_eq!(seen[0][1]["response"][0]["accepted"], true);
        assert_eq!(id(&seen[1][0]["request"][0]["goal_info"]), goal);
        assert_eq!(seen[1][1]["response"][0]["return_code"], 0);
        assert_eq!(id(&seen[2][0]["request"][0]), goal);
        assert_eq!(seen[2][1]["response"][0]["result"]["message"], "stopped");
    });
    let words = "--ros-args -p action_client_configure_introspection:=metadata";
    let (operator, _operator_spin) = ground.node_with("operator", words, Vec::new());
    ground.check("action client ours: events of its three clients", || {
        peer.ask("serve_action", json!({ "action": "/theirs", "type": HOME, "hold": true }));
        let client = operator.action_client::<Home>("/theirs").expect("a client");
        client.wait_for_server(PATIENCE).expect("the server is there");
        let run = || {
            let goal = HomeGoal { joints: vec!["c_axis".into()] };
            let sent = client.send_goal(goal, |_| {}, PATIENCE).expect("an answer");
            sent.cancel(PATIENCE).expect("an answer");
            sent.result(PATIENCE).expect("a result");
        };
        for (part, _) in parts {
            let service = format!("/theirs/_action/{part}");
            until_seen(&mut peer, &service, &[REQUEST_SENT, RESPONSE_RECEIVED], |_| run());
            let events = events_of_call(&mut peer, &service, &[REQUEST_SENT, RESPONSE_RECEIVED], |_| run());
            assert_one_identity(&events);
            for event in &events {
                assert_eq!((&event["request"], &event["response"]), (&json!([]), &json!([])), "{event}");
            }
        }
    });
}
