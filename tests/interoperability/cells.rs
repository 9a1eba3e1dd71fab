//! The nodes of a cell as processes of their own.

use crate::ground::{Ground, wait_gone};
use crate::support::processes::{Processes, fresh_bag};
use crate::support::{PATIENCE, Peer};
use serde_json::json;
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
        for node in NODES {
            // The node's own status under its name, and those of its parts under names that begin so.
            let told = peer.message_where("/diagnostics", |told| told["status"][0]["name"] == node);
            for status in told["status"].as_array().expect("a list") {
                let of = status["name"].as_str().map(|name| name.split(": ").next() == Some(node));
                assert_eq!(of, Some(true), "{told}");
                assert!(status["message"].as_str().is_some_and(|text| !text.is_empty()), "{told}");
                assert!(status["level"].as_u64().is_some_and(|level| level <= 2), "{told}");
            }
        }
    });
    ground.check("each node restarted: a peer that stays finds it again", || {
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
    ground.check("each node restarted: a peer that stays finds it again", || {
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
    let some = ["machine_sim", "axis_interpolator"];
    let cells =
        ["/left", "/right"].map(|namespace| (namespace, Processes::start_some(&ground.domain, namespace, &some)));
    ground.check("two cells side by side", || {
        for (namespace, _) in &cells {
            for node in some {
                wait_active(&mut peer, namespace, node);
            }
            let topic = format!("{namespace}/machine/setpoints");
            // Who writes the setpoints of a machine is the interpolator of its own cell, and nobody else.
            peer.ask("wait_publishers", json!({ "topic": topic }));
            let ends = peer.ask("endpoints", json!({ "topic": topic }));
            let nodes: Vec<_> = ["publishers", "subscribers"].map(|kind| ends[kind][0]["node"].clone()).into();
            assert_eq!(nodes, [format!("{namespace}/axis_interpolator"), format!("{namespace}/machine_sim")]);
            assert_eq!(
                (ends["publishers"].as_array().map(Vec::len), ends["subscribers"].as_array().map(Vec::len)),
                (Some(1), Some(1))
            );
        }
        for (_, cell) in cells {
            let _no_bag = cell.end();
        }
    });
}
