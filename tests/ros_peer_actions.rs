//! Actions against real ROS 2 (rclpy with Fast DDS), in both roles, several goals at once.

mod support;

use camwright_msgs::camwright_msgs::action::{Home, HomeFeedback, HomeGoal, HomeResult};
use camwright_nodes::ros::{
    ActionHandler, ActionServer, CancelOutcome, GoalDecision, GoalHandle, GoalId, GoalStatus, Node, NodeOptions,
    RosArgs, SpinThread,
};
use serde_json::{Value, json};
use std::sync::mpsc::{Receiver, Sender, channel};
use support::{Domain, PATIENCE, Peer, peer_env};

const HOME: &str = "camwright_msgs/action/Home";
/// Numbers of `action_msgs/GoalStatus`.
const SUCCEEDED: u8 = 4;
const CANCELED: u8 = 5;
const ABORTED: u8 = 6;

enum Told {
    Accepted(GoalHandle<Home>),
    Cancel(GoalId),
}

/// Accepts what names a joint and leaves the rest to the test.
struct Homing(Sender<Told>);

impl ActionHandler<Home> for Homing {
    fn goal(&mut self, _: GoalId, goal: &HomeGoal) -> GoalDecision {
        match goal.joints.first() {
            Some(_) => GoalDecision::Accept,
            None => GoalDecision::Reject("no joint is named".into()),
        }
    }

    fn accepted(&mut self, goal: GoalHandle<Home>) {
        let _ = self.0.send(Told::Accepted(goal));
    }

    fn cancel(&mut self, id: GoalId) -> bool {
        self.0.send(Told::Cancel(id)).is_ok()
    }
}

fn node(domain: &Domain, name: &str) -> (Node, SpinThread) {
    let node = Node::new(NodeOptions::new(name, &RosArgs::default().with_domain_id(domain.id()))).expect("a node");
    let thread = node.spin_in_thread().expect("a thread");
    (node, thread)
}

fn homing(node: &Node) -> (ActionServer<Home>, Receiver<Told>) {
    let (sender, told) = channel();
    (node.action_server::<Home>("~/home", Homing(sender)).expect("an action server"), told)
}

fn accepted(told: &Receiver<Told>) -> GoalHandle<Home> {
    match told.recv_timeout(PATIENCE).expect("the goal arrives") {
        Told::Accepted(goal) => goal,
        Told::Cancel(id) => panic!("a goal was expected, not the cancelling of {id:?}"),
    }
}

fn cancelled(told: &Receiver<Told>) -> GoalId {
    match told.recv_timeout(PATIENCE).expect("the cancel arrives") {
        Told::Cancel(id) => id,
        Told::Accepted(goal) => panic!("a cancel was expected, not the goal {:?}", goal.id()),
    }
}

fn send(peer: &mut Peer, joint: &str) -> String {
    let answer =
        peer.ask("send_goal", json!({ "action": "/machine/home", "type": HOME, "goal": { "joints": [joint] } }));
    assert_eq!(answer["accepted"], true);
    answer["goal"].as_str().expect("an id").to_owned()
}

fn result(message: &str) -> HomeResult {
    HomeResult { message: message.into(), ..Default::default() }
}

fn outcome(answer: &Value) -> (u64, &str) {
    (answer["status"].as_u64().expect("a number"), answer["result"]["message"].as_str().expect("a text"))
}

#[test]
fn three_goals_at_once_end_each_in_its_own_way() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let (machine, _thread) = node(&domain, "machine");
    let (_server, told) = homing(&machine);
    let mut peer = Peer::start(env, &domain, "operator");
    let refused = peer.ask("send_goal", json!({ "action": "/machine/home", "type": HOME, "goal": {} }));
    assert_eq!(refused["accepted"], false);

    let [a, b, c] = ["a", "b", "c"].map(|joint| (send(&mut peer, joint), accepted(&told)));
    for ((id, goal), joint) in [&a, &b, &c].into_iter().zip(["a", "b", "c"]) {
        assert_eq!(goal.goal().joints, [joint]);
        goal.feedback(&HomeFeedback { joint: joint.into(), step: "search".into() });
        let feedback = peer.event("feedback", |event| event["goal"] == **id);
        assert_eq!((&feedback["data"]["joint"], &feedback["data"]["step"]), (&json!(joint), &json!("search")));
    }
    // All three results are waited for before any goal ends; two are cancelled in between, in another order than they came.
    let [wait_a, wait_b, wait_c] = [&a, &b, &c].map(|(id, _)| peer.order("result", json!({ "goal": id })));
    for (id, goal) in [&c, &a] {
        let order = peer.order("cancel", json!({ "goal": id }));
        assert_eq!(cancelled(&told), goal.id());
        let answer = peer.answer(order).expect("the cancel is answered");
        assert_eq!((&answer["return_code"], &answer["goals"]), (&json!(0), &json!([id])));
        assert!(goal.is_canceling());
    }
    assert!(b.1.succeed(result("b is home")));
    assert!(a.1.canceled(result("a stopped")));
    assert!(c.1.abort(result("c hit its switch")));
    let ends = [wait_a, wait_b, wait_c].map(|order| peer.answer(order).expect("a result"));
    assert_eq!(outcome(&ends[0]), (CANCELED.into(), "a stopped"));
    assert_eq!(outcome(&ends[1]), (SUCCEEDED.into(), "b is home"));
    assert_eq!(outcome(&ends[2]), (ABORTED.into(), "c hit its switch"));
    // Too late to cancel: the goal has ended.
    assert_eq!(peer.ask("cancel", json!({ "goal": b.0 }))["return_code"], 3);
}

#[test]
fn a_result_is_kept_for_who_asks_late_and_the_status_is_latched() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let (machine, _thread) = node(&domain, "machine");
    let (_server, told) = homing(&machine);
    let mut peer = Peer::start(env, &domain, "operator");
    let id = send(&mut peer, "x_axis");
    assert!(accepted(&told).succeed(result("home")));
    let topic = "/machine/home/_action/status";
    peer.ask("subscribe", json!({ "topic": topic, "type": "action_msgs/msg/GoalStatusArray", "qos": "latched:1" }));
    // The end is published without anybody having asked for the result.
    let ended = |status: &Value| {
        status["status_list"].as_array().is_some_and(|list| list.iter().any(|s| s["status"] == SUCCEEDED))
    };
    peer.message_where(topic, ended);
    for _ in 0..2 {
        assert_eq!(outcome(&peer.ask("result", json!({ "goal": id }))), (SUCCEEDED.into(), "home"));
    }
}

#[test]
fn a_cancel_without_a_goal_means_all_of_them() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let (machine, _thread) = node(&domain, "machine");
    let (_server, told) = homing(&machine);
    let mut peer = Peer::start(env, &domain, "operator");
    let mut ids = ["a", "b"].map(|joint| send(&mut peer, joint));
    let goals = [accepted(&told), accepted(&told)];
    let order = peer.order("cancel_request", json!({ "action": "/machine/home" }));
    let _both = (cancelled(&told), cancelled(&told));
    let answer = peer.answer(order).expect("the cancel is answered");
    let mut named: Vec<_> = answer["goals"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    named.sort_unstable();
    ids.sort();
    assert_eq!(named, ids);
    assert!(goals.iter().all(GoalHandle::is_canceling));
}

#[test]
fn our_client_sends_goals_to_a_peer_and_cancels_them() {
    let Some(env) = peer_env() else { return };
    let domain = Domain::take();
    let mut peer = Peer::start(env, &domain, "machine");
    let feedback = json!([{ "joint": "c_axis", "step": "latch" }]);
    let offer = |name: &str| json!({ "action": name, "type": HOME, "feedback": feedback, "result": { "success": true, "message": "home" } });
    peer.ask("serve_action", offer("/quick"));
    let mut slow = offer("/slow");
    slow["hold"] = json!(true);
    peer.ask("serve_action", slow);
    let mut never = offer("/never");
    never["reject"] = json!(true);
    peer.ask("serve_action", never);

    let (operator, _thread) = node(&domain, "operator");
    let goal = || HomeGoal { joints: vec!["c_axis".into()] };
    let (sender, steps) = channel();
    let quick = operator.action_client::<Home>("/quick").expect("a client");
    quick.wait_for_server(PATIENCE).expect("the server is there");
    let sent = quick.send_goal(goal(), move |feedback| drop(sender.send(feedback.step)), PATIENCE).expect("an answer");
    assert!(sent.accepted());
    assert_eq!(steps.recv_timeout(PATIENCE).expect("feedback"), "latch");
    let (status, end) = sent.result(PATIENCE).expect("a result");
    assert_eq!((status, end.success, end.message.as_str()), (GoalStatus::Succeeded, true, "home"));

    let slow = operator.action_client::<Home>("/slow").expect("a client");
    slow.wait_for_server(PATIENCE).expect("the server is there");
    let (sender, steps) = channel();
    let sent = slow.send_goal(goal(), move |feedback| drop(sender.send(feedback.step)), PATIENCE).expect("an answer");
    steps.recv_timeout(PATIENCE).expect("it is being executed");
    assert_eq!(sent.cancel(PATIENCE).expect("an answer"), CancelOutcome::Accepted);
    assert_eq!(sent.result(PATIENCE).expect("a result").0, GoalStatus::Canceled);

    let never = operator.action_client::<Home>("/never").expect("a client");
    never.wait_for_server(PATIENCE).expect("the server is there");
    assert!(!never.send_goal(goal(), |_| {}, PATIENCE).expect("an answer").accepted());
}
