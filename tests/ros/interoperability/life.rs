// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Life cycle, simulated time, logs, names.

use super::ground::{Ground, STRING};
use crate::support::{PATIENCE, Peer};
use camwright_msgs::rosgraph_msgs::msg::Clock;
use camwright_msgs::std_msgs::msg::String as Text;
use camwright_msgs::std_srvs::srv::{Trigger, TriggerResponse};
use camwright_ros::{Level, LifecycleCallbacks, LifecycleState, Qos};
use serde_json::{Value, json};
use std::sync::mpsc::channel;
use std::time::Instant;

struct Calm;

impl LifecycleCallbacks for Calm {}

pub fn life_cycle(ground: &mut Ground<'_>) {
    let (node, _spin) = ground.node("machine");
    let life = node.lifecycle(Calm).expect("a life cycle");
    let mut peer = ground.peer("manager");
    let topic = "/machine/transition_event";
    peer.ask("subscribe", json!({ "topic": topic, "type": "lifecycle_msgs/msg/TransitionEvent" }));
    peer.ask("wait_subscribed", json!({ "topic": topic }));
    let state = |peer: &mut Peer| {
        peer.call("/machine/get_state", "lifecycle_msgs/srv/GetState", json!({}))["current_state"]["label"].take()
    };
    let change = |peer: &mut Peer, transition: Value| {
        let request = json!({ "transition": transition });
        peer.call("/machine/change_state", "lifecycle_msgs/srv/ChangeState", request)["success"] == true
    };
    ground.check("illegal transitions refused", || {
        assert_eq!(state(&mut peer), "unconfigured");
        assert!(!change(&mut peer, json!({ "id": 3 })), "not before it is configured");
        assert!(!change(&mut peer, json!({ "id": 99, "label": "sleep" })));
        assert_eq!(state(&mut peer), "unconfigured");
    });
    ground.check("changed by id and by label", || {
        assert!(change(&mut peer, json!({ "id": 1, "label": "configure" })));
        assert!(change(&mut peer, json!({ "label": "activate" })), "by label alone");
        assert_eq!((state(&mut peer), life.state()), (json!("active"), LifecycleState::Active));
        assert!(change(&mut peer, json!({ "id": 4 })), "by id alone");
    });
    ground.check("`~/transition_event` with the states between", || {
        // The first change may have outrun the discovery of who listens; these have not.
        assert!(change(&mut peer, json!({ "id": 3 })) && change(&mut peer, json!({ "id": 4 })));
        let mut seen = Vec::new();
        while !seen
            .ends_with(&[json!("activating"), json!("active"), json!("deactivating"), json!("inactive")].map(Some))
        {
            seen.push(Some(peer.message(topic)["goal_state"]["label"].take()));
            assert!(seen.len() < 20, "{seen:?}");
        }
    });
    ground.check("states, transitions and graph listed", || {
        let mut list = |service: &str, kind: &str, field: &str| {
            let kind = format!("lifecycle_msgs/srv/{kind}");
            peer.call(&format!("/machine/{service}"), &kind, json!({}))[field].as_array().cloned().unwrap_or_default()
        };
        assert_eq!(list("get_available_states", "GetAvailableStates", "available_states").len(), 11);
        let transitions = list("get_available_transitions", "GetAvailableTransitions", "available_transitions");
        assert!(transitions.iter().any(|entry| entry["transition"]["label"] == "activate"), "{transitions:?}");
        let graph = list("get_transition_graph", "GetAvailableTransitions", "available_transitions");
        assert!(graph.len() > transitions.len(), "{} of {}", transitions.len(), graph.len());
        assert!(change(&mut peer, json!({ "label": "shutdown" })));
        assert_eq!(state(&mut peer), "finalized");
    });
}

pub fn clocks(ground: &mut Ground<'_>) {
    let mut peer = Peer::start_with(ground.env, &ground.domain, &["follower", "--sim-time"]);
    let (node, spin) = ground.node_with("follower_too", "--ros-args -p use_sim_time:=true", Vec::new());
    ground.check("`/clock`, theirs to ours", || {
        peer.ask("advertise", json!({ "topic": "/clock", "type": "rosgraph_msgs/msg/Clock" }));
        peer.ask("wait_matched", json!({ "topic": "/clock", "n": 2 }));
        let (sender, ticks) = channel();
        let tick = move |clock: Clock, _: &_| sender.send(clock.clock.sec).unwrap_or_default();
        let _seen = node.subscribe::<Clock>("/clock", &Qos::default_topic(), tick).expect("a subscription");
        peer.ask("wait_matched", json!({ "topic": "/clock", "n": 3 }));
        let (mut sec, deadline) = (100, Instant::now() + PATIENCE);
        while node.now_ns() < 100_000_000_000 {
            assert!(Instant::now() < deadline, "our node does not follow the peer's clock");
            peer.ask("publish", json!({ "topic": "/clock", "data": { "clock": { "sec": sec, "nanosec": 5 } } }));
            ticks.recv_timeout(PATIENCE).expect("the clock ticks");
            sec += 1;
        }
        assert!(node.now_ns() < i64::from(sec) * 1_000_000_000, "simulated time, not the day's: {}", node.now_ns());
    });
    drop(spin);
    node.shutdown();
    let domain = crate::support::Domain::reserve();
    let mut peer = Peer::start_with(ground.env, &domain, &["follower", "--sim-time"]);
    ground.domain = domain;
    let (node, _spin) = ground.node("clock_source");
    ground.check("`/clock`, ours to theirs", || {
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
    });
}

pub fn logs_and_descriptions(ground: &mut Ground<'_>) {
    let (node, _spin) = ground.node_with("machine", "--ros-args -r __ns:=/cell", Vec::new());
    node.log(Level::Warn, "the wheel is worn");
    let mut peer = ground.peer("peer");
    ground.check("`/rosout`, also to late joiners", || {
        peer.ask("subscribe", json!({ "topic": "/rosout", "type": "rcl_interfaces/msg/Log", "qos": "latched:1000" }));
        let line = peer.message_where("/rosout", |line| line["msg"] == "the wheel is worn");
        assert_eq!((&line["name"], &line["level"]), (&json!("cell.machine"), &json!(30)));
        node.log(Level::Error, "the wheel is gone");
        let line = peer.message_where("/rosout", |line| line["msg"] == "the wheel is gone");
        assert_eq!(line["level"], 40);
        assert!(line["file"].as_str().is_some_and(|file| file.ends_with("life.rs")), "{line}");
    });
    ground.check("levels of loggers, read and set", || {
        let mut levels = |names: &Value| {
            let service = "/cell/machine/get_logger_levels";
            let answer = peer.call(service, "rcl_interfaces/srv/GetLoggerLevels", json!({ "names": names }));
            let levels = answer["levels"].as_array().expect("a list");
            levels.iter().map(|level| level["level"].as_u64().expect("a number")).collect::<Vec<_>>()
        };
        assert_eq!(levels(&json!(["cell.machine", "nobody"])), [20, 0]);
        let mut set = |name: &str, level: u32| {
            let request = json!({ "levels": [{ "name": name, "level": level }] });
            let service = "/cell/machine/set_logger_levels";
            peer.call(service, "rcl_interfaces/srv/SetLoggerLevels", request)["results"][0].take()
        };
        assert_eq!(set("cell.machine", 40)["successful"], true);
        assert!(!node.logger().is_enabled(Level::Warn));
        node.log(Level::Warn, "the wheel is worn again");
        assert_eq!(set("cell.machine", 10)["successful"], true);
        node.log(Level::Debug, "the wheel turns");
        for (name, level, words) in [("nobody", 10, "'cell.machine'"), ("cell.machine", 35, "level 35")] {
            let refused = set(name, level);
            assert_eq!(refused["successful"], false);
            assert!(refused["reason"].as_str().is_some_and(|reason| reason.contains(words)), "{refused}");
        }
        let line = peer.message_where("/rosout", |line| {
            assert_ne!(line["msg"], "the wheel is worn again", "below the level that was set");
            line["msg"] == "the wheel turns"
        });
        assert_eq!(line["level"], 10);
    });
}

pub fn namespaces(ground: &mut Ground<'_>) {
    let make = |words: &str, text: &str| {
        let (node, thread) = ground.node_with("machine", &format!("--ros-args {words}"), Vec::new());
        let publisher = node.publisher::<Text>("name", &Qos::latched(1)).expect("a publisher");
        publisher.publish(&Text { data: text.into() }).expect("published");
        let message = text.to_owned();
        let service = node
            .service::<Trigger>("~/who", move |_| TriggerResponse { success: true, message: message.clone() })
            .expect("a service");
        (node, thread, publisher, service)
    };
    let _two = [make("-r __ns:=/one", "one"), make("-r __ns:=/two", "two")];
    let renamed = "-r __node:=grinder -r name:=/other/title -r grinder:rosservice://~/who:=~/whoever -r __ns:=/three";
    let _renamed = make(renamed, "three");
    let mut peer = Peer::start_with(ground.env, &ground.domain, &["visitor", "--namespace", "/two"]);
    let latched = |peer: &mut Peer, topic: &str| {
        peer.ask("subscribe", json!({ "topic": topic, "type": STRING, "qos": "latched" }));
        peer.message(topic)["data"].take()
    };
    ground.check("two namespaces in one domain stay separate", || {
        assert_eq!((latched(&mut peer, "/one/name"), latched(&mut peer, "name")), (json!("one"), json!("two")));
        for namespace in ["one", "two"] {
            let answer = peer.call(&format!("/{namespace}/machine/who"), "std_srvs/srv/Trigger", json!({}));
            assert_eq!(answer["message"], namespace);
            peer.ask("wait_node", json!({ "name": "machine", "namespace": format!("/{namespace}") }));
        }
    });
    ground.check("remapped names of node, topic and service", || {
        assert_eq!(latched(&mut peer, "/other/title"), "three");
        peer.ask("wait_node", json!({ "name": "grinder", "namespace": "/three" }));
        let answer = peer.call("/three/grinder/whoever", "std_srvs/srv/Trigger", json!({}));
        assert_eq!(answer["message"], "three");
    });
}
