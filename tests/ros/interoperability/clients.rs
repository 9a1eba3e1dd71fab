// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Actions with the client on our side.

use super::ground::{Ground, HOME};
use crate::support::PATIENCE;
use camwright_msgs::camwright_msgs::action::{Home, HomeGoal};
use camwright_ros::{CancelOutcome, ClientGoal, GoalStatus, Node};
use serde_json::{Value, json};
use std::sync::mpsc::{Receiver, channel};

/// Sends a goal to an action of the peer; its feedback comes through the channel.
fn send(node: &Node, action: &str) -> (ClientGoal<Home>, Receiver<String>) {
    let client = node.action_client::<Home>(action).expect("a client");
    client.wait_for_server(PATIENCE).expect("the server is there");
    let (sender, steps) = channel();
    let goal = HomeGoal { joints: vec!["c_axis".into()] };
    let sent = client.send_goal(goal, move |feedback| drop(sender.send(feedback.step)), PATIENCE);
    (sent.expect("an answer"), steps)
}

pub fn of_actions(ground: &mut Ground<'_>) {
    let mut peer = ground.peer("machine");
    let (node, _spin) = ground.node("operator");
    let feedback = json!([{ "joint": "c_axis", "step": "search" }, { "joint": "c_axis", "step": "latch" }]);
    let mut serve = |action: &str, how: Value| {
        let mut order = json!({ "action": action, "type": HOME, "feedback": feedback,
            "result": { "message": "home" } });
        if let (Some(order), Some(how)) = (order.as_object_mut(), how.as_object()) {
            order.extend(how.clone());
        }
        peer.ask("serve_action", order);
    };
    serve("/quick", json!({}));
    serve("/slow", json!({ "hold": true }));
    serve("/never", json!({ "reject": true }));
    serve("/broken", json!({ "abort": true }));
    ground.check("accepted, feedback, result", || {
        let (sent, steps) = send(&node, "/quick");
        assert!(sent.accepted());
        let (status, result) = sent.result(PATIENCE).expect("a result");
        assert_eq!((status, result.message.as_str()), (GoalStatus::Succeeded, "home"));
        assert_eq!(steps.recv_timeout(PATIENCE).as_deref(), Ok("search"));
        assert_eq!(steps.recv_timeout(PATIENCE).as_deref(), Ok("latch"));
    });
    ground.check("cancelled", || {
        let (sent, steps) = send(&node, "/slow");
        steps.recv_timeout(PATIENCE).expect("it is being executed");
        assert_eq!(sent.cancel(PATIENCE).expect("an answer"), CancelOutcome::Accepted);
        assert_eq!(sent.result(PATIENCE).expect("a result").0, GoalStatus::Canceled);
    });
    ground.check("rejected", || assert!(!send(&node, "/never").0.accepted()));
    ground.check("aborted", || {
        assert_eq!(send(&node, "/broken").0.result(PATIENCE).expect("a result").0, GoalStatus::Aborted);
    });
}
