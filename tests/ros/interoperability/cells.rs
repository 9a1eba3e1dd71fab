// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! The nodes of a cell as processes of their own.

use super::Column;
use super::ground::{ABORTED, CANCELED, Ground, SUCCEEDED, wait_gone};
use crate::support::processes::{Processes, fresh_bag};
use crate::support::{PATIENCE, Peer};
use serde_json::{Value, json};
use std::time::Instant;

const NODES: [&str; 4] = ["run_logger", "machine_sim", "axis_interpolator", "job_planner"];

/// Something that only this node says, whether or not anybody works: its topic, type and quality of service.
const SAYS: [(&str, &str, &str, &str); 4] = [
    ("run_logger", "run_logger/status", "camwright_msgs/msg/RecorderStatus", "reliable"),
    ("machine_sim", "machine/description", "camwright_msgs/msg/MachineDescription", "latched:1"),
    ("axis_interpolator", "axis_interpolator/state", "camwright_msgs/msg/InterpolatorState", "latched:1"),
    ("job_planner", "job_planner/job_status", "camwright_msgs/msg/JobStatus", "latched:1"),
];

fn wait_active(peer: &mut Peer, namespace: &str, node: &str) {
    let deadline = Instant::now() + PATIENCE;
    loop {
        let service = format!("{namespace}/{node}/get_state");
        let state = peer.call(&service, "lifecycle_msgs/srv/GetState", json!({}))["current_state"]["label"].take();
        if state == "active" {
            return;
        }
        assert!(Instant::now() < deadline, "{namespace}/{node} is {state}");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
}

/// Sends a trajectory of the table; returns its goal and its first feedback.
fn follow(peer: &mut Peer, position: f64, seconds: u32) -> (Value, Value) {
    let action = "/cell/axis_interpolator/follow_joint_trajectory";
    let point = json!({ "positions": [position], "time_from_start": { "sec": seconds } });
    let goal = json!({ "trajectory": { "joint_names": ["z_axis"], "points": [point] } });
    let kind = "control_msgs/action/FollowJointTrajectory";
    let sent = peer.ask("send_goal", json!({ "action": action, "type": kind, "goal": goal }));
    assert_eq!(sent["accepted"], true, "{sent}");
    let goal = sent["goal"].clone();
    let feedback = peer.event("feedback", |event| event["goal"] == goal)["data"].take();
    (goal, feedback)
}

/// Every field of the feedback has its value; Kilted has two more, of which the machine has nothing to report.
fn feedback(peer: &mut Peer, column: Column) {
    let (goal, feedback) = follow(peer, 0.05, 1);
    assert_eq!(feedback["joint_names"], json!(["z_axis"]), "{feedback}");
    for point in ["desired", "actual", "error"] {
        assert_eq!(feedback[point]["positions"].as_array().map(Vec::len), Some(1), "{feedback}");
    }
    for field in ["index", "multi_dof_index"] {
        let expected = if column == Column::Kilted { json!(0) } else { Value::Null };
        assert_eq!(feedback[field], expected, "{feedback}");
    }
    assert_eq!(feedback["multi_dof_joint_names"], json!([]), "{feedback}");
    assert_eq!(feedback["multi_dof_error"]["transforms"], json!([]), "{feedback}");
    let ended = peer.ask("result", json!({ "goal": goal }));
    assert_eq!(ended["status"], SUCCEEDED, "{ended}");
}

/// Sends a trajectory and, once it is on its way, another.
fn preempt(peer: &mut Peer) {
    // The first would take an hour.
    let ((first, _), (second, _)) = (follow(peer, 0.2, 3600), follow(peer, 0.1, 2));
    let ended = peer.ask("result", json!({ "goal": first }));
    assert_eq!((&ended["status"], &ended["result"]["error_code"]), (&json!(ABORTED), &json!(-1)), "{ended}");
    let text = ended["result"]["error_string"].as_str().expect("a text");
    assert!(text.starts_with("a joint trajectory replaced it at tick "), "{text}");
    let ended = peer.ask("result", json!({ "goal": second }));
    assert_eq!((&ended["status"], &ended["result"]["error_code"]), (&json!(SUCCEEDED), &json!(0)), "{ended}");
}

pub fn four_processes(ground: &mut Ground<'_>) {
    let mut peer = ground.peer("operator");
    let bag = fresh_bag("interoperability");
    let mut cell = Processes::start(&ground.domain, "/cell", &[], &bag);
    ground.check("nodes come up active", || {
        for node in NODES {
            peer.ask("wait_node", json!({ "name": node, "namespace": "/cell" }));
            wait_active(&mut peer, "/cell", node);
        }
    });
    ground.check("`/diagnostics` of every node", || {
        let kind = "diagnostic_msgs/msg/DiagnosticArray";
        peer.ask("subscribe", json!({ "topic": "/diagnostics", "type": kind, "qos": "reliable:100", "keep": 60 }));
        for node in NODES.map(|node| format!("/cell/{node}")) {
            // The node's own status under its name, and those of its parts under names that begin so.
            let report = peer.message_where("/diagnostics", |report| report["status"][0]["name"] == node);
            for status in report["status"].as_array().expect("a list") {
                let of = status["name"].as_str().map(|name| name.split(": ").next() == Some(node.as_str()));
                assert_eq!(of, Some(true), "{status}");
                assert!(status["message"].as_str().is_some_and(|text| !text.is_empty()), "{status}");
                assert!(status["level"].as_u64().is_some_and(|level| level <= 2), "{status}");
            }
        }
    });
    ground.check("a joint trajectory replaces another in motion", || preempt(&mut peer));
    ground.check("feedback of a joint trajectory, by the definition of the distribution", || {
        feedback(&mut peer, ground.column);
    });
    ground.check("a goal for a busy axis is rejected with its holder", || {
        let jog = json!({ "joint": "c_axis", "velocity": 0.1, "hold_to_run": -1.0 });
        let action = "/cell/axis_interpolator/jog";
        let sent = peer.ask("send_goal", json!({ "action": action, "type": "camwright_msgs/action/Jog", "goal": jog }));
        let goal = &sent["goal"];
        peer.event("feedback", |event| event["goal"] == *goal);
        let refused = peer.call("/cell/axis_interpolator/wheel", "std_srvs/srv/SetBool", json!({ "data": true }));
        assert_eq!(refused["message"], "a jog of c_axis by /operator has command");
        peer.ask("cancel", json!({ "goal": goal }));
        let ended = peer.ask("result", json!({ "goal": goal }));
        assert_eq!(ended["status"], CANCELED, "{ended}");
    });
    ground.check("each node restarted: a running peer finds it again", || {
        for (_, topic, kind, qos) in SAYS {
            let topic = format!("/cell/{topic}");
            peer.ask("subscribe", json!({ "topic": topic, "type": kind, "qos": qos, "keep": 200 }));
            peer.message(&topic);
        }
        for (node, topic, ..) in SAYS {
            let topic = format!("/cell/{topic}");
            cell.interrupt(node);
            // Of a service that the peer has no client of: its own would stay.
            wait_gone(&mut peer, ("/cell", node), &format!("/cell/{node}/set_parameters"));
            let _before = peer.events_so_far("message");
            cell.restart(node, &ground.domain, "/cell");
            peer.ask("wait_node", json!({ "name": node, "namespace": "/cell" }));
            wait_active(&mut peer, "/cell", node);
            peer.message(&topic);
        }
    });
    ground.check("Ctrl-C: exit 0, gone from the graph", || {
        let _bag = cell.end();
        for node in NODES {
            wait_gone(&mut peer, ("/cell", node), &format!("/cell/{node}/set_parameters"));
        }
    });
    for bag in [bag.with_extension("again"), bag] {
        let _not_there = std::fs::remove_dir_all(bag);
    }
}

/// The same end, as Cyclone sees it; one node is enough.
pub fn one_process(ground: &mut Ground<'_>) {
    let mut peer = ground.peer("operator");
    let mut machine = Processes::start_some(&ground.domain, "/cell", &["machine_sim"]);
    ground.check("each node restarted: a running peer finds it again", || {
        peer.ask("wait_node", json!({ "name": "machine_sim", "namespace": "/cell" }));
        machine.interrupt("machine_sim");
        wait_gone(&mut peer, ("/cell", "machine_sim"), "/cell/");
        machine.restart("machine_sim", &ground.domain, "/cell");
        peer.ask("wait_node", json!({ "name": "machine_sim", "namespace": "/cell" }));
    });
    ground.check("Ctrl-C: exit 0, gone from the graph", || {
        let _no_bag = machine.end();
        wait_gone(&mut peer, ("/cell", "machine_sim"), "/cell/");
    });
}

pub fn two_cells(ground: &mut Ground<'_>) {
    let mut peer = ground.peer("operator");
    let cells = ["/left", "/right"].map(|namespace| {
        let bag = fresh_bag(&format!("interoperability{}", namespace.replace('/', "-")));
        (namespace, Processes::start(&ground.domain, namespace, &[], &bag))
    });
    ground.check("two cells side by side", || {
        for (namespace, _) in &cells {
            for node in NODES {
                peer.ask("wait_node", json!({ "name": node, "namespace": namespace }));
                wait_active(&mut peer, namespace, node);
            }
            let topic = format!("{namespace}/machine/setpoints");
            // Who writes the setpoints of a machine is the interpolator of its own cell, and nobody else.
            peer.ask("wait_publishers", json!({ "topic": topic }));
            let ends = peer.ask("endpoints", json!({ "topic": topic }));
            let nodes = |kind: &str| -> Vec<&str> {
                let ends = ends[kind].as_array().expect("a list");
                ends.iter().filter_map(|end| end["node"].as_str()).collect()
            };
            assert_eq!(nodes("publishers"), [format!("{namespace}/axis_interpolator")]);
            let subscribers = nodes("subscribers");
            assert!(subscribers.contains(&format!("{namespace}/machine_sim").as_str()), "{subscribers:?}");
            assert!(subscribers.iter().all(|node| node.starts_with(&format!("{namespace}/"))), "{subscribers:?}");
        }
        for (_, cell) in cells {
            let bag = cell.end();
            std::fs::remove_dir_all(bag).expect("each has recorded into its own");
        }
    });
}
