// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Topics and what the graph shows of them.

use super::ground::{Ground, STRING, text, wait_gone};
use crate::support::PATIENCE;
use camwright_msgs::rcl_interfaces::msg::Log;
use camwright_msgs::std_msgs::msg::String as Text;
use camwright_msgs::std_srvs::srv::{Trigger, TriggerResponse};
use camwright_msgs::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};
use camwright_ros::{Node, Qos, Subscription};
use serde_json::json;
use std::sync::mpsc::{Receiver, channel};

const TRAJECTORY: &str = "trajectory_msgs/msg/JointTrajectory";

/// Texts that a node of ours receives on a topic.
fn subscribe(node: &Node, topic: &str, qos: &Qos) -> (Subscription, Receiver<String>) {
    let (sender, received) = channel();
    let subscription = node.subscribe::<Text>(topic, qos, move |text, _| drop(sender.send(text.data)));
    (subscription.expect("a subscription"), received)
}

pub fn both_ways(ground: &mut Ground<'_>) {
    let (node, _spin) = ground.node_with("grinder", "--ros-args -r __ns:=/cell", Vec::new());
    let latched = node.publisher::<Text>("ours", &Qos::latched(1)).expect("a publisher");
    latched.publish(&Text { data: "before the peer".into() }).expect("published");
    let out = node.publisher::<JointTrajectory>("setpoints", &Qos::default_topic()).expect("a publisher");
    let (orders, received) = subscribe(&node, "orders", &Qos::default_topic());
    let mut peer = ground.peer("observer");

    ground.check("latched, ours to a late joiner", || {
        peer.ask("subscribe", json!({ "topic": "/cell/ours", "type": STRING, "qos": "latched:1" }));
        assert_eq!(peer.message("/cell/ours")["data"], "before the peer");
    });
    ground.check("nested message, ours to theirs", || {
        peer.ask("subscribe", json!({ "topic": "/cell/setpoints", "type": TRAJECTORY }));
        assert!(out.wait_matched(1, PATIENCE), "our publisher is matched");
        peer.ask("wait_subscribed", json!({ "topic": "/cell/setpoints" }));
        let point = JointTrajectoryPoint { positions: vec![0.25, -1.5], ..Default::default() };
        let joint_names = vec!["c_axis".into(), "x_axis".into()];
        let message = JointTrajectory { joint_names, points: vec![point; 3], ..Default::default() };
        out.publish(&message).expect("published");
        assert_eq!(peer.message("/cell/setpoints"), serde_json::to_value(&message).expect("plain values"));
    });
    ground.check("text, theirs to ours", || {
        peer.ask("advertise", json!({ "topic": "/cell/orders", "type": STRING }));
        assert!(orders.wait_matched(1, PATIENCE), "our subscription is matched");
        peer.ask("wait_matched", json!({ "topic": "/cell/orders" }));
        for text in ["one", "", "drei µm ÄÖÜ", "4"] {
            peer.ask("publish", json!({ "topic": "/cell/orders", "data": { "data": text } }));
            assert_eq!(received.recv_timeout(PATIENCE).expect("it arrives"), text);
        }
    });
    ground.check("latched, theirs to us as late joiner", || {
        peer.ask("advertise", json!({ "topic": "/cell/theirs", "type": STRING, "qos": "latched:1" }));
        peer.ask("publish", json!({ "topic": "/cell/theirs", "data": { "data": "before us" } }));
        let (_late, received) = subscribe(&node, "theirs", &Qos::latched(1));
        assert_eq!(received.recv_timeout(PATIENCE).expect("it arrives"), "before us");
    });
    ground.check("type and quality of service of an endpoint", || {
        let ends = peer.ask("endpoints", json!({ "topic": "/cell/ours" }));
        let publisher = &ends["publishers"][0];
        assert_eq!(publisher["type"], STRING);
        assert_eq!(
            (&publisher["reliability"], &publisher["durability"]),
            (&json!("RELIABLE"), &json!("TRANSIENT_LOCAL"))
        );
        let topics = node.discovered_topics();
        let theirs = topics.iter().find(|topic| topic.name == "/cell/theirs").expect("the peer's topic");
        assert_eq!(
            (theirs.type_name.as_str(), theirs.publishers[0].qos.durability),
            (STRING, Qos::latched(1).durability)
        );
    });
    if !ground.column.is_cyclone() {
        ground.check("node names, both ways", || {
            peer.ask("wait_node", json!({ "name": "grinder", "namespace": "/cell" }));
            let ends = peer.ask("endpoints", json!({ "topic": "/cell/ours" }));
            assert_eq!(ends["publishers"][0]["node"], "/cell/grinder");
            assert!(node.wait_for_node("/observer", PATIENCE), "we see {:?}", node.discovered_nodes());
        });
        ground.check("type hash of an endpoint", || {
            let ends = peer.ask("endpoints", json!({ "topic": "/cell/ours" }));
            let known = camwright_msgs::by_type_name(STRING).expect("a type of ours").type_hash;
            assert_eq!(ends["publishers"][0]["hash"], known);
        });
        ground.check("one publisher of `/parameter_events` a node", || {
            let ends = peer.ask("endpoints", json!({ "topic": "/parameter_events" }));
            let publishers = ends["publishers"].as_array().expect("a list");
            let ours = publishers.iter().filter(|publisher| publisher["node"] == "/cell/grinder").count();
            assert_eq!(ours, 1, "{ends}");
        });
    } else {
        ground.check("node names, both ways", || {
            peer.ask("wait_node", json!({ "name": "grinder", "namespace": "/cell" }));
            peer.ask("call_yourself", json!({ "name": "observer", "namespace": "/" }));
            assert!(node.wait_for_node("/observer", PATIENCE), "we see {:?}", node.discovered_nodes());
        });
    }
}

/// Endpoints that do not fit together: both sides say so, with the policy, and nothing passes.
pub fn misfits(ground: &mut Ground<'_>) {
    let (node, _spin) = ground.node("node");
    let (sender, logged) = channel();
    let _log = node
        .subscribe::<Log>("/rosout", &Qos::rosout(), move |log, _| drop(sender.send(log.msg)))
        .expect("a subscription");
    let hears = |what: &str, topic: &str| {
        let mut seen = Vec::new();
        loop {
            let line = logged.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("nothing of '{what}' in {seen:?}"));
            if line.contains(what) && line.contains(topic) {
                return line;
            }
            seen.push(line);
        }
    };
    let weak = Qos::default_topic().best_effort();
    let _out = node.publisher::<Text>("/weak_out", &weak).expect("a publisher");
    let _in = subscribe(&node, "/weak_in", &Qos::default_topic());
    let _short_out = node.publisher::<Text>("/short_out", &Qos::default_topic()).expect("a publisher");
    let _short_in = subscribe(&node, "/short_in", &Qos::latched(1));
    let (other, other_received) = subscribe(&node, "/other", &Qos::default_topic());
    let mut peer = ground.peer("peer");
    let mut misfit = |policy: &str, out: &str, into: &str, asks: &str, offers: &str| {
        peer.ask("subscribe", json!({ "topic": out, "type": STRING, "qos": asks }));
        assert_eq!(peer.event("incompatible", |event| event["topic"] == out)["policy"], policy);
        let line = hears("New subscription discovered", out);
        assert!(line.contains("requesting incompatible QoS") && line.ends_with(policy), "{line}");
        peer.ask("advertise", json!({ "topic": into, "type": STRING, "qos": offers }));
        assert_eq!(peer.event("incompatible", |event| event["topic"] == into)["policy"], policy);
        let line = hears("New publisher discovered", into);
        assert!(line.contains("offering incompatible QoS") && line.ends_with(policy), "{line}");
    };
    ground.check("incompatible reliability: both sides report the policy", || {
        misfit("RELIABILITY", "/weak_out", "/weak_in", "reliable", "best_effort");
    });
    ground.check("incompatible durability: both sides report the policy", || {
        misfit("DURABILITY", "/short_out", "/short_in", "latched", "reliable");
    });
    ground.check("different type on a topic: reported, no delivery", || {
        peer.ask("advertise", json!({ "topic": "/other", "type": TRAJECTORY }));
        let line = hears("has the type trajectory_msgs/msg/JointTrajectory, not std_msgs/msg/String", "/other");
        let empty = json!({ "header": { "stamp": { "sec": 0, "nanosec": 0 }, "frame_id": "" }, "joint_names": [], "points": [] });
        peer.ask("publish", json!({ "topic": "/other", "data": empty }));
        peer.ask("advertise", json!({ "topic": "/weak_in", "type": STRING }));
        peer.ask("wait_matched", json!({ "topic": "/weak_in" }));
        assert_eq!(other.matched(), 0, "{line}");
        assert!(other_received.try_recv().is_err());
    });
}

pub fn long_messages(ground: &mut Ground<'_>) {
    let (node, _spin) = ground.node("node");
    let out = node.publisher::<Text>("/ours", &Qos::default_topic()).expect("a publisher");
    let (subscription, received) = subscribe(&node, "/theirs", &Qos::default_topic());
    let mut peer = ground.peer("peer");
    let long = text(1_000_000);
    ground.check("1 MB, ours to theirs", || {
        peer.ask("subscribe", json!({ "topic": "/ours", "type": STRING }));
        assert!(out.wait_matched(1, PATIENCE));
        peer.ask("wait_subscribed", json!({ "topic": "/ours" }));
        for _ in 0..3 {
            out.publish(&Text { data: long.clone() }).expect("published");
            assert!(peer.message("/ours")["data"] == json!(long), "it arrives whole");
        }
    });
    ground.check("1 MB, theirs to ours", || {
        peer.ask("advertise", json!({ "topic": "/theirs", "type": STRING }));
        assert!(subscription.wait_matched(1, PATIENCE));
        peer.ask("wait_matched", json!({ "topic": "/theirs" }));
        for _ in 0..3 {
            peer.ask("publish", json!({ "topic": "/theirs", "data": { "data": long } }));
            assert!(received.recv_timeout(PATIENCE).expect("it arrives") == long, "and whole");
        }
    });
}

/// A node that shuts down is gone, with all that it had.
pub fn leaving(ground: &mut Ground<'_>) {
    let (node, spin) = ground.node_with("guest", "--ros-args -r __ns:=/cell", Vec::new());
    let out = node.publisher::<Text>("~/ours", &Qos::default_topic()).expect("a publisher");
    let _service = node.service::<Trigger>("~/stop", |_| TriggerResponse::default()).expect("a service");
    let mut peer = ground.peer("host");
    ground.check("name, topics and services of a node disappear when it ends", || {
        peer.ask("wait_node", json!({ "name": "guest", "namespace": "/cell" }));
        // Not subscribed to by the peer, whose own end of a topic would stay.
        peer.ask("subscribe", json!({ "topic": "/elsewhere", "type": STRING }));
        drop(spin);
        drop(out);
        node.shutdown();
        wait_gone(&mut peer, ("/cell", "guest"), "/cell/guest/");
    });
}
