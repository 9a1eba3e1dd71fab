//! Our ROS layer against real ROS 2 (rclpy with Fast DDS): topics, services, parameters, life cycle, time and logs. Actions are in
//! `ros_peer_actions.rs`.

mod support;

use camwright_msgs::rosgraph_msgs::msg::Clock;
use camwright_msgs::std_msgs::msg::String as Text;
use camwright_msgs::std_srvs::srv::{
    SetBool, SetBoolRequest, SetBoolResponse, Trigger, TriggerRequest, TriggerResponse,
};
use camwright_msgs::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};
use camwright_nodes::ros::{
    Level, LifecycleCallbacks, LifecycleState, Node, NodeOptions, Parameter, ParameterValue, Qos, RosArgs, SpinThread,
};
use serde_json::{Value, json};
use std::sync::mpsc;
use support::{Domain, PATIENCE, Peer, peer_env};

fn start_with(domain: &Domain, name: &str, words: &str, parameters: Vec<Parameter>) -> (Node, SpinThread) {
    let words: Vec<String> = words.split_whitespace().map(str::to_owned).collect();
    let (args, _) = RosArgs::parse_with(&words, |_| None).expect("valid arguments");
    let options = NodeOptions::new(name, &args.with_domain_id(domain.id())).parameters(parameters);
    let node = Node::new(options).expect("a node");
    let thread = node.spin_in_thread().expect("a thread");
    (node, thread)
}

fn start(domain: &Domain, name: &str) -> (Node, SpinThread) {
    start_with(domain, name, "", Vec::new())
}

const STRING: &str = "std_msgs/msg/String";

#[test]
fn topics_go_both_ways_and_the_graph_names_them() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let (node, _thread) = start_with(&domain, "grinder", "--ros-args -r __ns:=/cell", Vec::new());
    let out = node.publisher::<JointTrajectory>("setpoints", &Qos::default_topic()).expect("a publisher");
    let (sender, received) = mpsc::channel();
    let subscription = node
        .subscribe::<Text>("orders", &Qos::default_topic(), move |text, _| drop(sender.send(text.data)))
        .expect("a subscription");

    let mut peer = Peer::start(env, &domain, "observer");
    peer.ask("subscribe", json!({ "topic": "/cell/setpoints", "type": "trajectory_msgs/msg/JointTrajectory" }));
    peer.ask("advertise", json!({ "topic": "/cell/orders", "type": STRING }));
    assert!(out.wait_matched(1, PATIENCE) && subscription.wait_matched(1, PATIENCE));
    peer.ask("wait_matched", json!({ "topic": "/cell/orders" }));

    let point = JointTrajectoryPoint { positions: vec![0.25, -1.5], ..Default::default() };
    let message = JointTrajectory {
        joint_names: vec!["c_axis".into(), "x_axis".into()],
        points: vec![point; 3],
        ..Default::default()
    };
    out.publish(&message).expect("published");
    assert_eq!(peer.message("/cell/setpoints"), serde_json::to_value(&message).expect("plain values"));
    for text in ["one", "", "drei µm", "4"] {
        peer.ask("publish", json!({ "topic": "/cell/orders", "data": { "data": text } }));
        assert_eq!(received.recv_timeout(PATIENCE).expect("it arrives"), text);
    }

    peer.ask("wait_node", json!({ "name": "grinder", "namespace": "/cell" }));
    let graph = peer.ask("graph", json!({}));
    assert_eq!(graph["topics"]["/cell/setpoints"], json!(["trajectory_msgs/msg/JointTrajectory"]));
    assert_eq!(graph["topics"]["/cell/orders"], json!([STRING]));
    let ends = peer.ask("endpoints", json!({ "topic": "/cell/setpoints" }));
    assert_eq!(ends["publishers"][0]["node"], "/cell/grinder");
    assert_eq!(ends["publishers"][0]["reliability"], "RELIABLE");
    assert!(node.wait_for_node("/observer", PATIENCE), "and we see the peer: {:?}", node.discovered_nodes());
}

#[test]
fn latched_messages_reach_late_joiners_both_ways() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let (node, _thread) = start(&domain, "node");
    let latched = node.publisher::<Text>("ours", &Qos::latched(1)).expect("a publisher");
    latched.publish(&Text { data: "before the peer".into() }).expect("published");
    let mut peer = Peer::start(env, &domain, "peer");
    peer.ask("subscribe", json!({ "topic": "/ours", "type": STRING, "qos": "latched:1" }));
    assert_eq!(peer.message("/ours")["data"], "before the peer");

    peer.ask("advertise", json!({ "topic": "/theirs", "type": STRING, "qos": "latched:1" }));
    peer.ask("publish", json!({ "topic": "/theirs", "data": { "data": "before us" } }));
    let (sender, received) = mpsc::channel();
    let _late = node
        .subscribe::<Text>("theirs", &Qos::latched(1), move |text, _| drop(sender.send(text.data)))
        .expect("a subscription");
    assert_eq!(received.recv_timeout(PATIENCE).expect("it arrives"), "before us");
}

#[test]
fn services_go_both_ways() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let (node, _thread) = start(&domain, "node");
    let _trigger = node
        .service::<Trigger>("~/stop", |_| TriggerResponse { success: true, message: "at rest".into() })
        .expect("a service");
    let _hold = node
        .service::<SetBool>("~/hold", |request| SetBoolResponse { success: request.data, message: String::new() })
        .expect("a service");
    let mut peer = Peer::start(env, &domain, "peer");
    let answer = peer.call("/node/stop", "std_srvs/srv/Trigger", json!({}));
    assert_eq!(answer, json!({ "success": true, "message": "at rest" }));
    for data in [true, false, true] {
        assert_eq!(peer.call("/node/hold", "std_srvs/srv/SetBool", json!({ "data": data }))["success"], data);
    }
    assert_eq!(peer.ask("graph", json!({}))["services"]["/node/hold"], json!(["std_srvs/srv/SetBool"]));

    let response = json!({ "success": true, "message": "theirs" });
    peer.ask("serve", json!({ "service": "/theirs", "type": "std_srvs/srv/SetBool", "response": response }));
    let client = node.client::<SetBool>("theirs").expect("a client");
    client.wait_for_service(PATIENCE).expect("the service is there");
    let id = peer.order("now", json!({ "at_least": 0 }));
    let answer = client.call(&SetBoolRequest { data: true }, PATIENCE).expect("an answer");
    assert!(answer.success && answer.message == "theirs");
    peer.answer(id).expect("it still answers");
    assert_eq!(peer.event("request", |_| true)["data"], json!({ "data": true }));

    // An empty request: one byte on the wire that nobody's type shows.
    peer.ask("serve", json!({ "service": "/empty", "type": "std_srvs/srv/Trigger", "response": { "success": true } }));
    let empty = node.client::<Trigger>("empty").expect("a client");
    empty.wait_for_service(PATIENCE).expect("the service is there");
    assert!(empty.call(&TriggerRequest::default(), PATIENCE).expect("an answer").success);
}

fn value(number: f64) -> Value {
    json!({ "type": 3, "double_value": number })
}

#[test]
fn parameters_are_listed_described_read_set_and_refused() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let declared = vec![
        Parameter::double("infeed_um_rev", 5.0).describe("infeed per revolution (µm)").range(0.1, 50.0),
        Parameter::string("job", "four_lobes"),
        Parameter::integer("lobes", 4).read_only(),
    ];
    let (node, _thread) = start_with(&domain, "planner", "--ros-args -p job:=other", declared);
    let mut peer = Peer::start(env, &domain, "peer");
    let of = |service: &str| {
        (format!("/planner/{service}"), {
            let camel: String = service.split('_').map(|word| word[..1].to_uppercase() + &word[1..]).collect();
            format!("rcl_interfaces/srv/{camel}")
        })
    };
    let ask = |peer: &mut Peer, service: &str, request: Value| {
        let (name, kind) = of(service);
        peer.call(&name, &kind, request)
    };
    let listed = ask(&mut peer, "list_parameters", json!({}));
    let names: Vec<&str> =
        listed["result"]["names"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    for name in ["infeed_um_rev", "job", "lobes", "use_sim_time"] {
        assert!(names.contains(&name), "{name} in {names:?}");
    }
    let read = ask(&mut peer, "get_parameters", json!({ "names": ["infeed_um_rev", "job"] }));
    assert_eq!(read["values"][0]["double_value"], 5.0);
    assert_eq!(read["values"][1]["string_value"], "other");
    let types = ask(&mut peer, "get_parameter_types", json!({ "names": ["infeed_um_rev", "job", "lobes"] }));
    assert_eq!(types["types"], json!([3, 4, 2]));
    let described = ask(&mut peer, "describe_parameters", json!({ "names": ["infeed_um_rev", "lobes"] }));
    assert_eq!(described["descriptors"][0]["description"], "infeed per revolution (µm)");
    assert_eq!(described["descriptors"][0]["floating_point_range"][0]["to_value"], 50.0);
    assert_eq!(described["descriptors"][1]["read_only"], true);

    peer.ask("subscribe", json!({ "topic": "/parameter_events", "type": "rcl_interfaces/msg/ParameterEvent" }));
    peer.ask("wait_publishers", json!({ "topic": "/parameter_events", "n": 2 }));
    let set = |peer: &mut Peer, name: &str, value: Value| {
        let request = json!({ "parameters": [{ "name": name, "value": value }] });
        peer.call("/planner/set_parameters", "rcl_interfaces/srv/SetParameters", request)["results"][0].take()
    };
    assert_eq!(set(&mut peer, "infeed_um_rev", value(7.5))["successful"], true);
    assert_eq!(node.parameters().get("infeed_um_rev"), Some(ParameterValue::Double(7.5)));
    let refused = set(&mut peer, "infeed_um_rev", value(51.0));
    assert_eq!(refused["successful"], false);
    let reason = refused["reason"].as_str().expect("a text");
    assert!(reason.contains("infeed_um_rev") && reason.contains("50"), "what and how much is allowed: {reason}");
    assert_eq!(set(&mut peer, "lobes", json!({ "type": 2, "integer_value": 5 }))["successful"], false);
    assert_eq!(set(&mut peer, "nobody", value(1.0))["successful"], false);
    assert_eq!(set(&mut peer, "job", value(1.0))["successful"], false, "another type");
    assert_eq!(node.parameters().get("infeed_um_rev"), Some(ParameterValue::Double(7.5)), "refusals change nothing");
    // Nobody promises that the event of a change outruns the discovery of who listens; a second change is seen for certain.
    assert_eq!(set(&mut peer, "infeed_um_rev", value(8.0))["successful"], true);
    let event = peer.message_where("/parameter_events", |event| {
        event["node"] == "/planner" && !event["changed_parameters"].as_array().is_some_and(Vec::is_empty)
    });
    assert_eq!(event["changed_parameters"][0]["name"], "infeed_um_rev");
}

struct Calm;

impl LifecycleCallbacks for Calm {
    fn configure(&mut self) -> Result<(), String> {
        Ok(())
    }
    fn activate(&mut self) -> Result<(), String> {
        Ok(())
    }
    fn deactivate(&mut self) -> Result<(), String> {
        Ok(())
    }
    fn cleanup(&mut self) -> Result<(), String> {
        Ok(())
    }
    fn shutdown(&mut self) -> Result<(), String> {
        Ok(())
    }
}

#[test]
fn a_managed_node_is_walked_through_its_life() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let (node, _thread) = start(&domain, "machine");
    let life = node.lifecycle(Calm).expect("a life cycle");
    let mut peer = Peer::start(env, &domain, "manager");
    peer.ask(
        "subscribe",
        json!({ "topic": "/machine/transition_event", "type": "lifecycle_msgs/msg/TransitionEvent" }),
    );
    peer.ask("wait_publishers", json!({ "topic": "/machine/transition_event" }));
    let state = |peer: &mut Peer| {
        peer.call("/machine/get_state", "lifecycle_msgs/srv/GetState", json!({}))["current_state"]["label"].take()
    };
    let change = |peer: &mut Peer, id: u8, label: &str| {
        let request = json!({ "transition": { "id": id, "label": label } });
        peer.call("/machine/change_state", "lifecycle_msgs/srv/ChangeState", request)["success"] == true
    };
    assert_eq!(state(&mut peer), "unconfigured");
    assert!(!change(&mut peer, 3, "activate"), "not from here");
    assert!(change(&mut peer, 1, "configure"));
    assert_eq!(state(&mut peer), "inactive");
    assert!(change(&mut peer, 0, "activate"), "by label alone");
    assert_eq!((state(&mut peer), life.state()), (json!("active"), LifecycleState::Active));
    let event = peer.message_where("/machine/transition_event", |event| event["goal_state"]["label"] == "active");
    assert_eq!(event["start_state"]["label"], "activating");
    let available =
        peer.call("/machine/get_available_transitions", "lifecycle_msgs/srv/GetAvailableTransitions", json!({}));
    let labels: Vec<_> = available["available_transitions"].as_array().expect("a list").iter().collect();
    assert!(labels.iter().any(|entry| entry["transition"]["label"] == "deactivate"), "{labels:?}");
    let states = peer.call("/machine/get_available_states", "lifecycle_msgs/srv/GetAvailableStates", json!({}));
    assert_eq!(states["available_states"].as_array().map(Vec::len), Some(11));
    assert!(change(&mut peer, 0, "shutdown"));
    assert_eq!(state(&mut peer), "finalized");
}

#[test]
fn log_lines_reach_rosout() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let (node, _thread) = start_with(&domain, "machine", "--ros-args -r __ns:=/cell", Vec::new());
    node.log(Level::Warn, "the wheel is worn");
    let mut peer = Peer::start(env, &domain, "peer");
    peer.ask("subscribe", json!({ "topic": "/rosout", "type": "rcl_interfaces/msg/Log", "qos": "latched:1000" }));
    let line = peer.message_where("/rosout", |line| line["msg"] == "the wheel is worn");
    assert_eq!((&line["name"], &line["level"]), (&json!("cell.machine"), &json!(30)));
}

#[test]
fn simulated_time_goes_both_ways() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let mut peer = Peer::start_with(env, &domain, &["follower", "--sim-time"]);
    let (node, _thread) = start_with(&domain, "follower_too", "--ros-args -p use_sim_time:=true", Vec::new());
    peer.ask("advertise", json!({ "topic": "/clock", "type": "rosgraph_msgs/msg/Clock" }));
    peer.ask("wait_matched", json!({ "topic": "/clock", "n": 2 }));
    let (sender, ticks) = mpsc::channel();
    let _seen = node
        .subscribe::<Clock>("/clock", &Qos::default_topic(), move |clock, _| {
            let _ = sender.send(clock.clock.sec);
        })
        .expect("a subscription");
    peer.ask("wait_matched", json!({ "topic": "/clock", "n": 3 }));
    let mut sec = 100;
    let deadline = std::time::Instant::now() + PATIENCE;
    while node.now_ns() < 100_000_000_000 {
        assert!(std::time::Instant::now() < deadline, "our node does not follow the peer's clock");
        peer.ask("publish", json!({ "topic": "/clock", "data": { "clock": { "sec": sec, "nanosec": 5 } } }));
        ticks.recv_timeout(PATIENCE).expect("the clock ticks");
        sec += 1;
    }
    assert!(node.now_ns() < i64::from(sec) * 1_000_000_000, "simulated time, not the day's: {}", node.now_ns());

    let domain = Domain::take();
    let mut peer = Peer::start_with(env, &domain, &["follower", "--sim-time"]);
    let (node, _thread) = start(&domain, "clock_source");
    let clock = node.publisher::<Clock>("/clock", &Qos::default_topic()).expect("a publisher");
    assert!(clock.wait_matched(1, PATIENCE));
    let mut message = Clock::default();
    message.clock.sec = 42;
    // The subscription of a clock is best effort: what comes before it has found the publisher is lost.
    let id = peer.order("now", json!({ "at_least": 42_000_000_000_u64 }));
    let answer = loop {
        clock.publish(&message).expect("published");
        if peer.has_answer(id) {
            break peer.answer(id).expect("the clock has come");
        }
    };
    assert_eq!(answer["now"], 42_000_000_000_u64);
}

#[test]
fn two_namespaces_in_one_domain_do_not_meet() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let cell = |namespace: &str| {
        let (node, thread) = start_with(&domain, "machine", &format!("--ros-args -r __ns:={namespace}"), Vec::new());
        let publisher = node.publisher::<Text>("name", &Qos::latched(1)).expect("a publisher");
        publisher.publish(&Text { data: namespace.into() }).expect("published");
        let message = namespace.to_owned();
        let service = node
            .service::<Trigger>("~/who", move |_| TriggerResponse { success: true, message: message.clone() })
            .expect("a service");
        (node, thread, publisher, service)
    };
    let _cells = (cell("/one"), cell("/two"));
    let mut peer = Peer::start_with(env, &domain, &["visitor", "--namespace", "/two"]);
    peer.ask("subscribe", json!({ "topic": "/one/name", "type": STRING, "qos": "latched" }));
    peer.ask("subscribe", json!({ "topic": "name", "type": STRING, "qos": "latched" }));
    assert_eq!(peer.message("/one/name")["data"], "/one");
    assert_eq!(peer.message("name")["data"], "/two");
    for namespace in ["/one", "/two"] {
        let answer = peer.call(&format!("{namespace}/machine/who"), "std_srvs/srv/Trigger", json!({}));
        assert_eq!(answer["message"], namespace);
        peer.ask("wait_node", json!({ "name": "machine", "namespace": namespace }));
    }
}
