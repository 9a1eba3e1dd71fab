// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Actions with the server on our side.

use super::ground::{ABORTED, CANCELED, Ground, HOME, SUCCEEDED};
use super::matrix::BURST;
use crate::support::{PATIENCE, Peer};
use camwright_msgs::camwright_msgs::action::{Home, HomeFeedback, HomeGoal, HomeResult};
use camwright_msgs::std_srvs::srv::{Trigger, TriggerResponse};
use camwright_ros::{ActionHandler, ActionServer, GoalDecision, GoalHandle, GoalId, Node};
use serde_json::{Value, json};
use std::sync::mpsc::{Receiver, Sender, channel};

enum Received {
    Accepted(GoalHandle<Home>),
    Cancel(GoalId),
}

/// Accepts what names a joint and leaves the rest to the test.
struct Homing(Sender<Received>);

impl ActionHandler<Home> for Homing {
    fn goal(&mut self, _: GoalId, goal: &HomeGoal) -> GoalDecision {
        match goal.joints.first() {
            Some(_) => GoalDecision::Accept,
            None => GoalDecision::Reject("no joint is named".into()),
        }
    }

    fn accepted(&mut self, goal: GoalHandle<Home>) {
        let _ = self.0.send(Received::Accepted(goal));
    }

    fn cancel(&mut self, id: GoalId) -> bool {
        self.0.send(Received::Cancel(id)).is_ok()
    }
}

fn homing(node: &Node) -> (ActionServer<Home>, Receiver<Received>) {
    let (sender, received) = channel();
    (node.action_server::<Home>("~/home", Homing(sender)).expect("an action server"), received)
}

fn accepted(received: &Receiver<Received>) -> GoalHandle<Home> {
    match received.recv_timeout(PATIENCE).expect("the goal arrives") {
        Received::Accepted(goal) => goal,
        Received::Cancel(id) => panic!("a goal was expected, not the cancelling of {id:?}"),
    }
}

fn cancelled(received: &Receiver<Received>) -> GoalId {
    match received.recv_timeout(PATIENCE).expect("the cancel arrives") {
        Received::Cancel(id) => id,
        Received::Accepted(goal) => panic!("a cancel was expected, not the goal {:?}", goal.id()),
    }
}

fn send(peer: &mut Peer, goal: &Value) -> Value {
    peer.ask("send_goal", json!({ "action": "/machine/home", "type": HOME, "goal": goal }))
}

fn start(peer: &mut Peer, received: &Receiver<Received>, joint: &str) -> (String, GoalHandle<Home>) {
    let answer = send(peer, &json!({ "joints": [joint] }));
    assert_eq!(answer["accepted"], true);
    (answer["goal"].as_str().expect("an id").to_owned(), accepted(received))
}

fn result(message: &str) -> HomeResult {
    HomeResult { message: message.into(), ..Default::default() }
}

fn outcome(answer: &Value) -> (u64, &str) {
    (answer["status"].as_u64().expect("a number"), answer["result"]["message"].as_str().expect("a text"))
}

pub fn several_goals(ground: &mut Ground<'_>) {
    let (machine, _spin) = ground.node("machine");
    let (_server, received) = homing(&machine);
    let mut peer = ground.peer("operator");
    ground.check("goal rejected", || assert_eq!(send(&mut peer, &json!({}))["accepted"], false));
    let [a, b, c] = ["a", "b", "c"].map(|joint| start(&mut peer, &received, joint));
    ground.check("three goals at once, each with its own feedback", || {
        for ((id, goal), joint) in [&a, &b, &c].into_iter().zip(["a", "b", "c"]) {
            assert_eq!(goal.goal().joints, [joint]);
            goal.feedback(&HomeFeedback { joint: joint.into(), step: "search".into() });
            let feedback = peer.event("feedback", |event| event["goal"] == **id);
            assert_eq!((&feedback["data"]["joint"], &feedback["data"]["step"]), (&json!(joint), &json!("search")));
        }
    });
    ground.check("one cancelled, one succeeds, one aborts", || {
        // All three results are waited for before any goal ends; two are cancelled in between, in another order than they came.
        let waiting = [&a, &b, &c].map(|(id, _)| peer.order("result", json!({ "goal": id })));
        for (id, goal) in [&c, &a] {
            let order = peer.order("cancel", json!({ "goal": id }));
            assert_eq!(cancelled(&received), goal.id());
            let answer = peer.answer(order).expect("the cancel is answered");
            assert_eq!((&answer["return_code"], &answer["goals"]), (&json!(0), &json!([id])));
            assert!(goal.is_canceling());
        }
        assert!(b.1.succeed(result("b is home")));
        assert!(a.1.canceled(result("a stopped")));
        assert!(c.1.abort(result("c hit its switch")));
        let ends = waiting.map(|order| peer.answer(order).expect("a result"));
        assert_eq!(outcome(&ends[0]), (CANCELED, "a stopped"));
        assert_eq!(outcome(&ends[1]), (SUCCEEDED, "b is home"));
        assert_eq!(outcome(&ends[2]), (ABORTED, "c hit its switch"));
    });
    ground.check("cancelling an ended goal is answered as such", || {
        assert_eq!(peer.ask("cancel", json!({ "goal": b.0 }))["return_code"], 3);
    });
}

pub fn results_and_statuses(ground: &mut Ground<'_>) {
    let (machine, _spin) = ground.node("machine");
    let (_server, received) = homing(&machine);
    let mut peer = ground.peer("operator");
    let (id, goal) = start(&mut peer, &received, "x_axis");
    assert!(goal.succeed(result("home")));
    ground.check("status is latched and reports ends without a request", || {
        let topic = "/machine/home/_action/status";
        peer.ask("subscribe", json!({ "topic": topic, "type": "action_msgs/msg/GoalStatusArray", "qos": "latched:1" }));
        let ended = |status: &Value| {
            status["status_list"].as_array().is_some_and(|list| list.iter().any(|s| s["status"] == SUCCEEDED))
        };
        peer.message_where(topic, ended);
    });
    ground.check("result on late and repeated requests", || {
        for _ in 0..2 {
            assert_eq!(outcome(&peer.ask("result", json!({ "goal": id }))), (SUCCEEDED, "home"));
        }
    });
    ground.check("cancelling all goals", || {
        let goals = ["a", "b"].map(|joint| start(&mut peer, &received, joint));
        let order = peer.order("cancel_request", json!({ "action": "/machine/home" }));
        let _both = (cancelled(&received), cancelled(&received));
        let answer = peer.answer(order).expect("the cancel is answered");
        let mut named: Vec<_> = answer["goals"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
        named.sort_unstable();
        let mut ids = goals.each_ref().map(|(id, _)| id.as_str());
        ids.sort_unstable();
        assert_eq!(named, ids);
        assert!(goals.iter().all(|(_, goal)| goal.is_canceling()));
    });
}

/// A client that sends all it has and then reads keeps ten unread answers, as ROS has it by default. It gets every one.
pub fn bursts(ground: &mut Ground<'_>) {
    let (machine, _spin) = ground.node("machine");
    let (_server, received) = homing(&machine);
    let _service = machine.service::<Trigger>("~/reset", |_| TriggerResponse { success: true, ..Default::default() });
    let _ends = std::thread::spawn(move || {
        for received in received {
            if let Received::Accepted(goal) = received {
                goal.abort(result("another goal came"));
            }
        }
    });
    let mut peer = ground.peer("operator");
    ground.check(BURST, || {
        for (n, goal, kind) in [
            (1000, json!({}), "rejected"),
            (300, json!({}), "rejected"),
            (300, json!({ "joints": ["x_axis"] }), "accepted"),
        ] {
            let burst = json!({ "action": "/machine/home", "type": HOME, "goal": goal, "n": n });
            let answer = peer.ask("burst_of_goals", burst);
            eprintln!("{n} goals, {kind}: {answer}");
            assert_eq!(answer["kinds"], json!({ kind: n }), "{answer}");
        }
        let burst = json!({ "service": "/machine/reset", "type": "std_srvs/srv/Trigger", "n": 1000 });
        let answer = peer.ask("burst_of_calls", burst);
        eprintln!("1000 calls: {answer}");
        assert_eq!(answer["kinds"], json!({ "True": 1000 }), "{answer}");
    });
}
